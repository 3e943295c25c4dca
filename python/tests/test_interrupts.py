"""Ctrl-C."""

import os
import signal
import subprocess
import sys
import time

import pytest

# A shell may have started the tests with Ctrl-C ignored.
LONG = """
import signal
import pickline
signal.signal(signal.SIGINT, signal.default_int_handler)
print("begins", flush=True)
pickline.simulate("paper", pickline.Pattern.grid(1.05, 0.1, 5000), "SPT,FIFO", bound=True)
"""

# Neither ends by itself within the hour: a callable that waits for the next instant, and plans of many runs.
ENDLESS = """
import signal
import math
import pickline
signal.signal(signal.SIGINT, signal.default_int_handler)
pattern = pickline.Pattern.grid(1.05, 0.15, 300)

def waits(snapshot):
    return pickline.Wait(math.nextafter(snapshot.time, math.inf))

def never(snapshot):
    while True:
        pass

def nested(snapshot):
    pickline.compare("paper", [pattern, pattern], strategy=waits, robust="SPT,FIFO", bound=False)

print("begins", flush=True)
{call}
"""


def interrupted(*command):
    """Sends Ctrl-C to this command a second after its first line; returns it with what it said."""
    process = subprocess.Popen(
        [sys.executable, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline()
    time.sleep(1.0)
    assert process.poll() is None, "it was over before it could be interrupted"
    process.send_signal(signal.SIGINT)
    begin = time.monotonic()
    _, errors = process.communicate(timeout=60)
    return process.returncode, errors, time.monotonic() - begin


@pytest.mark.skipif(os.name != "posix", reason="sends signals")
def test_long_work_ends_with_keyboard_interrupt():
    code, errors, seconds = interrupted("-c", LONG)
    assert code in (-signal.SIGINT, 130, 1), (code, errors)
    assert errors.rstrip().endswith("KeyboardInterrupt") and "Panic" not in errors
    assert seconds < 20


@pytest.mark.skipif(os.name != "posix", reason="sends signals")
@pytest.mark.parametrize(
    "call",
    [
        'pickline.simulate("paper", pattern, waits)',
        'pickline.compare("paper", pattern, strategy=waits, robust="SPT,FIFO", policy=False, bound=False)',
        'pickline.optimize("paper", pattern, strategy=waits, max_runs=36)',
        'pickline.simulate("paper", pattern, "lookahead:budget=1000000")',
        'pickline.simulate("paper", pattern, never)',
        'pickline.to_minari("tests/never-v0", waits, "paper", pattern)',
        'pickline.compare("paper", [pattern, pattern], strategy=nested, robust="SPT,FIFO", bound=False)',
    ],
)
def test_a_run_ends_at_its_next_decision(call):
    code, errors, seconds = interrupted("-c", ENDLESS.format(call=call))
    assert code in (-signal.SIGINT, 130, 1), (code, errors)
    assert "Panic" not in errors
    last = errors.rstrip().splitlines()[-1]
    assert last.startswith(("KeyboardInterrupt", "pickline.result.Interrupted")), errors
    assert seconds < 20


@pytest.mark.skipif(os.name != "posix", reason="sends signals")
def test_the_program_stops_with_the_best_so_far():
    process = subprocess.Popen(
        [sys.executable, "-m", "pickline", "optimize", "--robots", "6", "--format", "json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(4.0)
    assert process.poll() is None, "it was over before it could be interrupted"
    process.send_signal(signal.SIGINT)
    printed, errors = process.communicate(timeout=100)
    assert process.returncode == 130, (process.returncode, errors)
    assert printed.startswith("{") or "results so far" in errors
