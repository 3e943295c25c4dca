"""Calls on a cluster of Dask: the bytes of the program, also after a scheduler was lost."""

import os
import signal
import subprocess
import sys
import time

import pytest
from distributed import LocalCluster

PROGRAM = os.environ["PICKLINE"]
COMPARE = "compare --robots 2 --robust SPT,FIFO --no-policy --replicates 8 --format json -q".split()
PATIENCE = 300.0


@pytest.fixture
def cluster():
    """Starts clusters of this test."""
    started = []

    def start(workers):
        made = LocalCluster(
            n_workers=workers, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50
        )
        started.append(made)
        return made

    yield start
    for made in started:
        made.close()


def command(*words):
    return [sys.executable, "-m", "pickline.cluster", *map(str, words)]


def run(*words, folder=None):
    return subprocess.run(command(*words), capture_output=True, text=True, cwd=folder, timeout=PATIENCE)


def plain(*words, folder=None):
    return subprocess.run(
        [PROGRAM, *words], check=True, capture_output=True, text=True, cwd=folder, timeout=PATIENCE
    ).stdout


def wait_for(what, happened):
    until = time.monotonic() + PATIENCE
    while not happened():
        assert time.monotonic() < until, what
        time.sleep(0.02)


def finished(folder):
    return {int(path.name.split("-")[0]): path for path in folder.glob("*-of-*.json")}


@pytest.mark.parametrize(
    ("workers", "shards", "calls"),
    [
        (1, 3, [COMPARE]),
        (
            2,
            7,
            [
                COMPARE,
                "optimize --patterns balanced:4 --validate 10 --no-bound --format csv -q".split(),
                "sweep --sweep reach --robust FIFO,SPT --no-bound --format json -q".split(),
            ],
        ),
    ],
)
def test_the_bytes_are_those_of_the_program(tmp_path, workers, shards, calls):
    for words in calls:
        out, alone = tmp_path / words[0], tmp_path / f"{words[0]}-alone"
        done = run(*words, "--out", out, "--workers", workers, "--shards", shards)
        assert (done.returncode, done.stderr) == (0, ""), done.stderr
        assert done.stdout == plain(*words, "--out", str(alone))
        names = sorted(path.name for path in out.iterdir())
        assert names == sorted(path.name for path in alone.iterdir())
        for name in names:
            assert (out / name).read_bytes() == (alone / name).read_bytes()


def test_a_remark_names_the_dashboard():
    done = run("sweep", "--robust", "SPT,FIFO", "--no-bound", "--workers", 1, "--shards", 2)
    assert done.returncode == 0, done.stderr
    assert "dashboard http://127.0.0.1:" in done.stderr


def test_a_checkpoint_goes_on_where_it_was(tmp_path):
    folder = tmp_path / "parts"
    words = [*COMPARE, "--workers", 1, "--checkpoint", folder]
    running = subprocess.Popen(
        command(*words, "--shards", 40), stdout=subprocess.PIPE, start_new_session=True
    )
    wait_for("some shards", lambda: len(finished(folder)) > 4 if folder.exists() else False)
    # The scheduler and everything else with it.
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    running.stdout.close()
    before = {index: path.stat().st_mtime_ns for index, path in finished(folder).items()}
    assert 4 < len(before) < 41
    done = run(*words)
    assert done.returncode == 0, done.stderr
    assert done.stdout == plain(*COMPARE)
    after = finished(folder)
    assert sorted(after) == list(range(41))
    assert all(after[index].stat().st_mtime_ns == time for index, time in before.items())
    # Another call, or another number of shards, does not get into it.
    for more, told in [
        (["--replicates", "9"], "is a shard of another call: compare --robots 2"),
        (["--shards", 4], "has 40 shards of this call, not 4"),
    ]:
        words_of_other = [word for word in words if more[0] != "--replicates" or word not in ("--replicates", "8")]
        refused = run(*words_of_other, *more)
        assert refused.returncode == 2 and told in refused.stderr, refused.stderr
        assert "  cure: " in refused.stderr


def test_a_scheduler_that_is_lost_is_named(tmp_path, cluster):
    machines = cluster(1)
    folder = tmp_path / "parts"
    words = [*COMPARE, "--scheduler", machines.scheduler_address, "--checkpoint", folder]
    running = subprocess.Popen(
        command(*words, "--shards", 40), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    wait_for("some shards", lambda: len(finished(folder)) > 2 if folder.exists() else False)
    machines.close()
    _, stderr = running.communicate(timeout=PATIENCE)
    assert running.returncode == 2, stderr
    assert "the scheduler was lost" in stderr and "--checkpoint" in stderr


def test_ctrl_c_returns_what_is_complete(tmp_path):
    folder = tmp_path / "parts"
    words = [*COMPARE, "--workers", 1, "--shards", 40, "--checkpoint", folder]
    running = subprocess.Popen(command(*words), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    # The case with a single pattern is complete.
    wait_for("some shards", lambda: len(finished(folder)) > 12 if folder.exists() else False)
    running.send_signal(signal.SIGINT)
    stdout, stderr = running.communicate(timeout=PATIENCE)
    assert running.returncode == 130, stderr
    assert '"partial": "of 40 shards, ' in stdout, (stdout, stderr)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["compare", "--shard", "1/2"], "--shard: the cluster splits the call itself"),
        (["compare", "--scheduler", "x", "--workers", "2"], "a running cluster has its own workers"),
        (["compare", "--scheduler", "tcp://127.0.0.1:9"], "--scheduler: tcp://127.0.0.1:9 cannot be reached"),
        (["compare", "--replicates", "0", "--workers", "1"], "--replicates: 0 patterns per case"),
        (["compare", "--no-such", "--workers", "1"], "unexpected argument '--no-such'"),
        (["sweep", "--sweep", "robots-down", "--workers", "1"], "--shard: does not apply to --sweep robots-down"),
        (["compare", "--checkpoint", "/dev/null/x"], "--checkpoint: "),
    ],
)
def test_what_is_wrong_is_said(words, told):
    done = run(*words)
    assert done.returncode == 2, done.stderr
    assert told in done.stderr
    assert "cure: " in done.stderr
    assert "Traceback" not in done.stderr


def test_help_has_examples():
    done = run("--help")
    assert done.returncode == 0
    assert "python -m pickline.cluster compare" in done.stdout
