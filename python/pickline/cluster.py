"""``python -m pickline.cluster`` runs long calls of the program on a cluster of Dask.

The call is split into shards (``docs/scale.md``), each of which is a task of Dask distributed, and put
together in this process: the output has the bytes of the same call of ``pickline``, on any number of
workers. A worker that dies costs the time of its shards.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pickline._pickline import make_shard, program

VERBS = ("optimize", "compare", "sweep", "benchmark")
# Shards for each thread of a worker, so that all end at about the same time, and at least: in a call of ten
# minutes each then takes seconds, and a worker that dies costs no more.
SHARDS_PER_THREAD = 16
LEAST_SHARDS = 128
# How often a shard may lose its worker before it is taken to be what kills them.
MOST_LOSSES = 50

EPILOG = """\
All other arguments are those of the verb, such as --cases or --out; see `pickline compare --help`. Workers
need this package and the files that the call reads, at the same paths.

Examples:
  python -m pickline.cluster compare --cases dense --strategy lookahead
  python -m pickline.cluster sweep --sweep robots --scheduler tcp://10.0.0.5:8786
  python -m pickline.cluster benchmark --strategy lookahead --checkpoint parts/
"""


class _Failure(Exception):
    """What the user has to change; the message names it with a cure."""


def shard(words: list[str], index: int, count: int, known: str | None) -> str:
    """Make shard `index` of `count` of the call with `words`; returns the content of its file.

    `known` is the file of shard 0.
    """
    with tempfile.TemporaryDirectory(prefix="pickline-shard-") as folder:
        if known is not None:
            Path(folder, f"0-of-{count}.json").write_text(known, encoding="utf-8")
        _make(words, index, count, Path(folder))
        return Path(folder, f"{index}-of-{count}.json").read_text(encoding="utf-8")


def _make(words: list[str], index: int, count: int, folder: Path) -> None:
    # One thread, unless the call says otherwise: the cluster starts as many tasks as there are cores.
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    make_shard(["pickline", *words, "--shard", f"{index}/{count}", "--shard-dir", str(folder)])


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m pickline.cluster",
        description="Run a long call of pickline on a cluster of Dask, with the same result.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("verb", choices=VERBS, help="what to run")
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="the scheduler of a running cluster, such as tcp://10.0.0.5:8786 [default: a cluster on this machine]",
    )
    parser.add_argument(
        "--workers",
        type=_positive,
        metavar="N",
        help="number of workers on this machine, of one thread each [default: one for each core]",
    )
    parser.add_argument(
        "--shards",
        type=_positive,
        metavar="N",
        help="number of tasks; does not affect the result "
        f"[default: {SHARDS_PER_THREAD} for each thread of the workers, at least {LEAST_SHARDS}]",
    )
    parser.add_argument(
        "--checkpoint",
        metavar="DIR",
        type=Path,
        help="keep finished shards in this folder; the same call goes on with them after it was stopped",
    )
    return parser


def _positive(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 1_000_000:
        raise ValueError(text)
    return value


def main(arguments: list[str] | None = None) -> int:
    """Run the call; returns the exit code, which is that of ``pickline``."""
    options, rest = _parser().parse_known_args(arguments)
    words = [options.verb, *rest]
    quiet = "-q" in rest or "--quiet" in rest
    try:
        _check(options, rest)
        with _folder(options.checkpoint) as folder:
            return _run(options, words, folder, quiet)
    except _Failure as failure:
        print(f"pickline.cluster: {failure}", file=sys.stderr)
        return 2


def _check(options: argparse.Namespace, rest: list[str]) -> None:
    for flag in ("--shard", "--shard-dir"):
        if any(word == flag or word.startswith(f"{flag}=") for word in rest):
            raise _Failure(f"{flag}: the cluster splits the call itself\n  cure: leave it out, or give --shards N")
    if options.scheduler and options.workers:
        raise _Failure(
            "--workers: a running cluster has its own workers\n  cure: leave out --workers or --scheduler"
        )


@contextmanager
def _folder(checkpoint: Path | None) -> Iterator[Path]:
    """Where finished shards are kept."""
    if checkpoint is None:
        with tempfile.TemporaryDirectory(prefix="pickline-") as folder:
            yield Path(folder)
        return
    try:
        checkpoint.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _Failure(f"--checkpoint: {error}\n  cure: name a folder that can be written") from None
    yield checkpoint


def _finished(folder: Path, words: list[str]) -> tuple[int | None, set[int]]:
    """How many shards the call in `folder` was split into, if any are there, and which are."""
    count: int | None = None
    found = set()
    for path in folder.glob("*-of-*.json"):
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            same = content["arguments"] == words
            index, own = content["shard"], content["shards"]
        except (OSError, ValueError, KeyError, TypeError):
            raise _Failure(
                f"--checkpoint: {path} is not the file of a shard\n  cure: delete it, or name another folder"
            ) from None
        if not same:
            other = " ".join(content["arguments"])
            raise _Failure(
                f"--checkpoint: {path} is a shard of another call: {other}\n  cure: name another folder"
            )
        if count not in (None, own):
            raise _Failure(
                f"--checkpoint: {folder} has shards of two numbers, {count} and {own}\n  cure: delete one kind"
            )
        count = own
        found.add(index)
    return count, found


def _run(options: argparse.Namespace, words: list[str], folder: Path, quiet: bool) -> int:
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise _Failure(
            "Dask distributed is not installed\n  cure: pip install './python[cluster]'"
        ) from None

    def tell(text: str) -> None:
        if not quiet:
            print(text, file=sys.stderr)

    count, found = _finished(folder, words)
    if options.shards and count not in (None, options.shards):
        raise _Failure(
            f"--shards: {folder} has {count} shards of this call, not {options.shards}\n"
            "  cure: leave out --shards, or name another folder"
        )
    cluster: Any = None
    try:
        if options.scheduler:
            try:
                client = Client(options.scheduler, timeout=10)
            except (OSError, ValueError, TypeError) as error:
                raise _Failure(
                    f"--scheduler: {options.scheduler} cannot be reached: {error}\n"
                    "  cure: start it with `dask scheduler`, or give the address that it prints"
                ) from None
        else:
            # A port of its own: several may run on one machine.
            cluster = LocalCluster(
                n_workers=options.workers or os.cpu_count() or 1,
                threads_per_worker=1,
                dashboard_address="127.0.0.1:0",
                silence_logs=50,
            )
            client = Client(cluster)
        threads = sum(client.nthreads().values())
        if options.scheduler and threads == 0:
            tell("waiting for a worker")
            client.wait_for_workers(1)
            threads = sum(client.nthreads().values())
        count = count or options.shards or max(LEAST_SHARDS, SHARDS_PER_THREAD * threads)
        tell(f"dashboard {client.dashboard_link}")
        left = [index for index in range(1, count + 1) if index not in found]
        if len(left) < count:
            tell(f"{count - len(left)} of {count} shards are in {folder}")
        whole = _shards(client, words, (count, left, 0 not in found), folder, quiet)
        client.close()
    finally:
        if cluster is not None:
            cluster.close()
    merge = ["pickline", "merge", str(folder)]
    if whole:
        return program(merge)
    if not any(folder.glob("[1-9]*-of-*.json")):
        print("pickline.cluster: stopped before the first shard was finished", file=sys.stderr)
        return 130
    program([*merge, "--partial"])
    return 130


def _shards(
    client: Any, words: list[str], work: tuple[int, list[int], bool], folder: Path, quiet: bool
) -> bool:
    """Make the shards that are left; whether all of them are there, and not stopped by Ctrl-C."""
    from distributed import as_completed
    from distributed.client import FutureCancelledError
    from distributed.scheduler import KilledWorker

    count, left, first = work
    losses = dict.fromkeys([0, *left], 0)
    known: str | None = None

    def submit(index: int) -> Any:
        return client.submit(shard, words, index, count, known, key=f"shard-{index}-{losses[index]}", pure=False)

    def finish(future: Any, index: int) -> Any:
        """The content of a shard, or the task that makes it again."""
        try:
            return future.result()
        except KilledWorker:
            losses[index] += 1
            if losses[index] > MOST_LOSSES:
                raise _Failure(
                    f"shard {index}/{count} lost its worker {losses[index]} times\n"
                    "  cure: give workers more memory, or make smaller shards (--shards)"
                ) from None
            return submit(index)
        except (FutureCancelledError, OSError) as error:
            raise _Failure(
                f"the scheduler was lost: {error}\n"
                "  cure: start it again and repeat the call; with --checkpoint it goes on where it was"
            ) from None
        except ValueError as error:
            # What pickline itself says.
            raise _Failure(f"shard {index}/{count}: {error}") from None

    def keep(index: int, content: str) -> None:
        path = folder / f"{index}-of-{count}.json"
        partial = path.with_suffix(".partial")
        partial.write_text(content, encoding="utf-8")
        partial.replace(path)

    try:
        if first:
            content = submit(0)
            while not isinstance(content, str):
                content = finish(content, 0)
            keep(0, content)
        known = (folder / f"0-of-{count}.json").read_text(encoding="utf-8")
        with _bar(count, count - len(left), quiet) as advance:
            numbers = {}
            tasks = as_completed()
            for index in left:
                task = submit(index)
                numbers[task.key] = index
                tasks.add(task)
            for task in tasks:
                index = numbers[task.key]
                content = finish(task, index)
                if isinstance(content, str):
                    keep(index, content)
                    advance()
                else:
                    numbers[content.key] = index
                    tasks.add(content)
        return True
    except KeyboardInterrupt:
        # A second one ends the program.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        if not quiet:
            print("stopping with the shards that are finished", file=sys.stderr)
        return False


@contextmanager
def _bar(total: int, done: int, quiet: bool) -> Iterator[Any]:
    """Shows how many shards are finished."""
    try:
        from tqdm import tqdm
    except ImportError:
        yield lambda: None
        return
    bar = tqdm(total=total, initial=done, desc="shards", disable=quiet)
    try:
        yield bar.update
    finally:
        bar.close()


if __name__ == "__main__":
    sys.exit(main())
