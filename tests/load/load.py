#!/usr/bin/env python3
"""Load on a live line: `pickline emulate` plays a dense belt to `pickline run`.

    cargo build --release --features mqtt
    python3 tests/load/load.py                           # 1,000 detections/s for 60 s
    python3 tests/load/load.py --mqtt                    # over a broker instead of pipes
    python3 tests/load/load.py --watchers 8              # with so many at the dashboard
    python3 tests/load/load.py --strategy onnx:FILE      # any strategy of `run`
    python3 tests/load/load.py --clock messages --items 1000000
    python3 tests/load/load.py --station delta --robots 6 --rate 15 --items 900

Prints what the node says at its end, what the thread that decides had of a core, and how
its memory went. Ends with 1 where anything was lost: an item that was not seen, or is in no
figure; a message that was refused; memory that grew by more than a tenth after two fifths
of the time, when the belt is long full.
"""

import argparse
import contextlib
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
import urllib.request
from pathlib import Path

from broker import broker, free_port
from line import Brokered, Pipes

# The belt of the station `paper` [m/s], just slower than its arms of 0.5 m/s.
FAST_BELT = 0.45
# Detections within this distance of an item show that item, where items are far apart [m].
TOLERANCE = 0.015


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--pickline", default="target/release/pickline", help="the program")
    parser.add_argument("--strategy", default="SPT,FIFO", help="of the node")
    parser.add_argument("--budget-ms", help="of each decision")
    parser.add_argument("--station", default="paper", help="a built-in one or a file")
    parser.add_argument("--robots", default="2")
    parser.add_argument("--rate", type=float, default=1000, help="detections a second")
    parser.add_argument("--items", type=int, default=60_000)
    parser.add_argument("--clock", default="system", help="with `messages`, as fast as it goes")
    parser.add_argument("--mqtt", action="store_true", help="over a mosquitto of its own")
    parser.add_argument("--watchers", type=int, default=0, help="who watch the dashboard")
    return parser.parse_args()


class Watcher(threading.Thread):
    """Reads the dashboard's events as they come, until they end."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.address = f"http://127.0.0.1:{port}/events"
        self.bytes = 0
        self.start()

    def run(self):
        while True:
            try:
                with urllib.request.urlopen(self.address) as events:
                    while part := events.read1(1 << 16):
                        self.bytes += len(part)
                    return
            except OSError as error:
                # What urllib says of a connection wraps the cause.
                if not isinstance(getattr(error, "reason", error), ConnectionRefusedError):
                    return  # Gone, or there are too many.
                time.sleep(0.1)  # Not there yet.


def memory(process):
    """Resident memory and its peak [MB], or none when the process has ended."""
    try:
        lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
    except OSError:
        return None
    kilobytes = {line.split(":")[0]: line.split()[1] for line in lines if "kB" in line}
    if "VmRSS" not in kilobytes:
        return None
    return int(kilobytes["VmRSS"]) / 1024, int(kilobytes["VmHWM"]) / 1024


def cores(process):
    """Time [s] that the node's deciding thread has had a core, and waited for one."""
    try:
        spent = Path(f"/proc/{process.pid}/schedstat").read_text().split()
    except OSError:
        return None
    return int(spent[0]) / 1e9, int(spent[1]) / 1e9


def belt_of(options):
    """Width [m] and speed [m/s] of the belt."""
    show = [options.pickline, "station", "show", "--station", options.station]
    shown = subprocess.run(show, check=True, capture_output=True).stdout
    belt = tomllib.loads(shown.decode())["belt"]
    return belt["width"], FAST_BELT if options.station == "paper" else belt["speed"]


def main():
    options = parse_arguments()
    width, speed = belt_of(options)
    step = (width * speed / options.rate) ** 0.5
    line = ["--station", options.station, "--robots", options.robots, "--belt-speed", str(speed)]
    line += ["--clock", options.clock]
    # On a dense belt items are nearer to each other than elsewhere.
    tolerance = str(min(step / 2, TOLERANCE))
    run = ["run", *line, "--strategy", options.strategy, "--tolerance", tolerance]
    if options.budget_ms:
        run += ["--budget-ms", options.budget_ms]
    if options.watchers:
        port = free_port()
        run += ["--dashboard", f"127.0.0.1:{port}"]
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        pattern = f"{folder}/pattern.csv"
        grid = ["pattern", "generate", "grid", "--spacing", str(step), "--count"]
        grid += [str(options.items), "--station", options.station, "--output", pattern]
        subprocess.run([options.pickline, *grid], check=True)
        emulate = ["emulate", *line, "--pattern", pattern]
        began = time.monotonic()
        if options.mqtt:
            place = stack.enter_context(broker(folder))
            line = Brokered(place, options.pickline, run, emulate)
        else:
            line = Pipes(options.pickline, run, emulate)
        watchers = [Watcher(port) for _ in range(options.watchers)]
        sizes, spent = [], (0, 0)
        while line.node.poll() is None:
            if now := memory(line.node):
                sizes.append((time.monotonic() - began, *now))
            spent = cores(line.node) or spent
            line.look_after()
            time.sleep(0.25)
        seconds = time.monotonic() - began
        line.finish()
    print(*line.remarks, sep="", end="")
    codes = line.node.returncode, line.station.returncode
    if any(codes) or not line.statuses:
        print(f"the node ended with {codes[0]}, the station with {codes[1]}")
        return 1
    print(f"what decides had a core for {spent[0]:.1f} s, {spent[0] / seconds:.1%} of the time,", end="")
    print(f" and waited {spent[1]:.1f} s for one")
    if watchers:
        sent = [watcher.bytes / 1e6 for watcher in watchers]
        print(f"{len(sent)} watchers were sent {sum(sent):.0f} MB, each {min(sent):.0f} at least")
    wrong = report(options, seconds, line.statuses[-1], sizes)
    if any(not watcher.bytes for watcher in watchers):
        wrong.append("somebody saw nothing of the dashboard")
    for what in wrong:
        print(what)
    return 1 if wrong else 0


def report(options, seconds, status, sizes):
    """Prints how it went; what went wrong."""
    missed = sum(status["missed"].values())
    print(f"{status['seen']} items in {seconds:.0f} s, {status['seen'] / seconds:.0f} a second;", end=" ")
    print(f"{status['picked']} picked, {missed} missed; refused {status['rejected'] or 'nothing'}")
    print("memory [MB]:", end="")
    for share in (0.1, 0.2, 0.4, 0.6, 0.8, 1):
        at, size, _ = sizes[min(int(share * len(sizes)), len(sizes) - 1)]
        print(f" {size:.1f} after {at:.0f} s", end=",")
    print(f" peak {sizes[-1][2]:.1f}")
    # By the last two fifths buffers have their size, also on a machine that is busy otherwise.
    later = sizes[3 * len(sizes) // 5 :]
    # At the very beginning a library may need more for a moment.
    highest = max(size for _, size, _ in later)
    if later[-1][2] > later[0][2]:
        highest = later[-1][2]
    wrong = []
    if status["seen"] != options.items or status["seen"] != status["picked"] + missed:
        wrong.append("items were lost")
    if status["rejected"]:
        wrong.append("messages were refused")
    if highest > 1.1 * later[0][1] + 1:
        wrong.append("memory grew")
    return wrong


if __name__ == "__main__":
    sys.exit(main())
