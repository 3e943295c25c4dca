#!/usr/bin/env python3
"""Load on a live line: `pickline emulate` plays a dense belt to `pickline run` through pipes.

    cargo build --release
    python3 tests/load/load.py                           # 1,000 detections/s for 60 s
    python3 tests/load/load.py --watchers 8              # with so many at the dashboard
    python3 tests/load/load.py --clock messages --items 1000000

Prints what the node says at its end and how its memory went. Ends with 1 where anything
was lost: an item that was not seen, or is in no figure; a message that was refused; memory
that grew by more than a tenth after two fifths of the time, when the belt is long full.
"""

import argparse
import json
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from pathlib import Path

# Just slower than the arms of 0.5 m/s.
BELT_SPEED = 0.45
# Width of the built-in station's belt [m].
WIDTH = 1.05


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--pickline", default="target/release/pickline", help="the program")
    parser.add_argument("--strategy", default="SPT,FIFO", help="of the node")
    parser.add_argument("--budget-ms", help="of each decision")
    parser.add_argument("--robots", default="2")
    parser.add_argument("--rate", type=float, default=1000, help="detections a second")
    parser.add_argument("--items", type=int, default=60_000)
    parser.add_argument("--clock", default="system", help="with `messages`, as fast as it goes")
    parser.add_argument("--watchers", type=int, default=0, help="who watch the dashboard")
    return parser.parse_args()


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def watch(port, taken):
    """Reads the dashboard's events as they come, until they end."""
    while True:
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/events") as events:
                while part := events.read1(1 << 16):
                    taken.append(len(part))
                return
        except ConnectionRefusedError:
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


def start(program, stdin, arguments):
    return subprocess.Popen(
        [program, *arguments],
        stdin=stdin,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        bufsize=0,
    )


def hand_on(source, sink, keep):
    """Hands on whole lines, and keeps the statuses."""
    rest = b""
    while part := source.read(1 << 16):
        try:
            sink.write(part)
        except OSError:
            pass  # One that has ended hears no more.
        lines = (rest + part).split(b"\n")
        rest = lines.pop()
        keep.extend(line for line in lines if b'"kind":"status"' in line)
    sink.close()


def collect(stream, into):
    into.append(stream.read().decode())


def main():
    options = parse_arguments()
    step = (WIDTH * BELT_SPEED / options.rate) ** 0.5
    line = ["--robots", options.robots, "--belt-speed", str(BELT_SPEED), "--clock", options.clock]
    node_line = [*line, "--strategy", options.strategy]
    if options.budget_ms:
        node_line += ["--budget-ms", options.budget_ms]
    if options.watchers:
        port = free_port()
        node_line += ["--dashboard", f"127.0.0.1:{port}"]
    with tempfile.TemporaryDirectory() as folder:
        pattern = f"{folder}/pattern.csv"
        grid = ["pattern", "generate", "grid", "--spacing", str(step), "--count"]
        subprocess.run([options.pickline, *grid, str(options.items), "--output", pattern], check=True)
        began = time.monotonic()
        node = start(options.pickline, subprocess.PIPE, ["run", *node_line])
        emulate = ["emulate", *line, "--pattern", pattern]
        # What it sends goes straight to the node, as through a shell's pipe.
        station = subprocess.Popen(
            [options.pickline, *emulate],
            stdin=subprocess.PIPE,
            stdout=node.stdin,
            stderr=subprocess.PIPE,
            bufsize=0,
        )
        node.stdin.close()
        statuses, remarks, station_remarks, taken = [], [], [], []
        threads = [
            threading.Thread(target=hand_on, args=(node.stdout, station.stdin, statuses)),
            threading.Thread(target=collect, args=(node.stderr, remarks)),
            threading.Thread(target=collect, args=(station.stderr, station_remarks)),
        ]
        for _ in range(options.watchers):
            threads.append(threading.Thread(target=watch, args=(port, taken)))
        for thread in threads:
            thread.start()
        sizes, spent = [], (0, 0)
        while node.poll() is None:
            if now := memory(node):
                sizes.append((time.monotonic() - began, *now))
            spent = cores(node) or spent
            time.sleep(0.25)
        for thread in threads:
            thread.join()
        station.wait()
        seconds = time.monotonic() - began
    print(f"its decisions had a core for {spent[0]:.1f} s and waited {spent[1]:.1f} s for one")
    if options.watchers:
        print(f"{options.watchers} watchers were sent {sum(taken) / 1e6:.0f} MB")
    return report(options, seconds, json.loads(statuses[-1]), sizes, remarks[0] + station_remarks[0])


def report(options, seconds, status, sizes, remarks):
    print(remarks, end="")
    missed = sum(status["missed"].values())
    print(f"{status['seen']} items in {seconds:.0f} s, {status['seen'] / seconds:.0f} a second;", end=" ")
    print(f"{status['picked']} picked, {missed} missed; refused {status['rejected'] or 'nothing'}")
    print("memory [MB]:", end="")
    for share in (0.1, 0.2, 0.4, 0.6, 0.8, 1):
        at, size, _ = sizes[min(int(share * len(sizes)), len(sizes) - 1)]
        print(f" {size:.1f} after {at:.0f} s", end=",")
    peak = sizes[-1][2]
    print(f" peak {peak:.1f}")
    settled = sizes[2 * len(sizes) // 5][1]
    wrong = []
    if status["seen"] != options.items or status["seen"] != status["picked"] + missed:
        wrong.append("items were lost")
    if status["rejected"]:
        wrong.append("messages were refused")
    if peak > 1.1 * settled + 1:
        wrong.append("memory grew")
    for what in wrong:
        print(what)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
