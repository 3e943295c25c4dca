"""Measures calls on a cluster of Dask against the plain program, for docs/scale.md.

    python results/scaling/cluster.py PICKLINE

PICKLINE is the program, built with the same profile as the package in this Python. A start is a call with hardly
any work. What one more shard costs is the slope between calls with few and with many shards of hardly any work;
throughput is that of a call with work for about a minute on one core.
"""

import os
import subprocess
import sys
import tempfile
import time

RUNS = 3
FEW, MANY = 4, 84
# Hardly any work: rules without a bound.
LITTLE = "compare --robust FIFO,FIFO --no-policy --no-bound --replicates 20 -q --format json"
WORK = "compare --cases dense --robust SPT,FIFO --no-policy --strategy lookahead --replicates 16 -q --format json"


def timed(command: list[str]) -> tuple[float, bytes]:
    """Time [s] and output of a call."""
    began = time.perf_counter()
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE)
    return time.perf_counter() - began, done.stdout


def fastest(command: list[str]) -> float:
    """The shortest time [s] of a few calls."""
    return min(timed(command)[0] for _ in range(RUNS))


def cluster(call: str, workers: int, shards: int) -> list[str]:
    return [
        sys.executable,
        "-m",
        "pickline.cluster",
        *call.split(),
        f"--workers={workers}",
        f"--shards={shards}",
    ]


def main() -> None:
    program = sys.argv[1]
    print(f"{os.cpu_count()} cores")
    alone = fastest([program, *LITTLE.split(), "--threads", "1"])
    few, many = (fastest(cluster(LITTLE, 1, shards)) for shards in (FEW, MANY))
    each = (many - few) / (MANY - FEW)
    print(f"little work: {alone:.3f} s alone; {few:.2f} s in {FEW} shards, {many:.2f} s in {MANY} on one worker")
    print(f"start of the cluster and merge: {few - FEW * each - alone:.2f} s")
    print(f"one shard: {1e3 * each:.1f} ms; below 5 % from {20 * each:.2f} s of work on")
    print("| call | time [s] | of one thread alone |")
    print("|---|---|---|")
    expected = None
    base = 0.0
    for threads in (1, 2):
        seconds, printed = timed([program, *WORK.split(), "--threads", str(threads)])
        base = base or seconds
        expected = expected or printed
        assert printed == expected
        print(f"| alone, threads {threads} | {seconds:.1f} | {base / seconds:.2f} |")
    for workers in (1, 2):
        for shards in (8 * workers, 32 * workers):
            seconds, printed = timed(cluster(WORK, workers, shards))
            assert printed == expected
            print(f"| cluster, workers {workers}, shards {shards} | {seconds:.1f} | {base / seconds:.2f} |")
    # What goes through the scheduler.
    with tempfile.TemporaryDirectory() as folder:
        for index in (0, 1):
            subprocess.run(
                [program, *WORK.split(), f"--shard={index}/16", f"--shard-dir={folder}"], check=True
            )
        sizes = [os.path.getsize(f"{folder}/{index}-of-16.json") for index in (0, 1)]
    print(f"shared work {sizes[0] / 1e3:.1f} kB, one of 16 shards {sizes[1] / 1e3:.1f} kB")


if __name__ == "__main__":
    main()
