#!/usr/bin/env python3
"""Latency of a live line from outside: from a message's first byte to a task's last.

    cargo build --release
    python3 tests/load/latency.py                        # rules
    python3 tests/load/latency.py --strategy lookahead --budget-ms 10

A camera sends 20 pictures a second of a full belt, 2,000 detections a second in all, and an
encoder 50 messages a second. Robots report PICKED one after another, each 5 ms to 25 ms after
the last task came; measured is the time from just before that line is written to its socket
until the next task for that robot is read from it. Nothing here is code of `pickline`.

Prints a row of the table in docs/live.md. Ends with 1 where detections were refused, the
line stood still, or memory grew by more than a tenth in the second half.
"""

import argparse
import json
import multiprocessing
import random
import select
import socket
import subprocess
import sys
import time
from pathlib import Path

STATION = Path(__file__).parent.parent / "live" / "support" / "three.toml"
ROBOTS = ["delta-1", "scara-2", "arm-3"]
SPEED = 0.3
PICTURES = 20
# Pictures in which an item is.
SEEN = 10
# Time until the belt is full [s].
FILLS = 12
# Half of the width in which items lie [m].
HALF_WIDTH = 0.25


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--pickline", default="target/release/pickline", help="the program")
    parser.add_argument("--strategy", default="SPT,SPT,FIFO", help="of the node")
    parser.add_argument("--budget-ms", help="of each decision")
    parser.add_argument("--rate", type=int, default=2000, help="detections a second")
    parser.add_argument("--seconds", type=int, default=60, help="that are measured")
    return parser.parse_args()


def connect(port, **hello):
    peer = socket.create_connection(("127.0.0.1", port))
    peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    peer.sendall(line(kind="hello", **hello))
    return peer


def line(**fields):
    return json.dumps(fields).encode() + b"\n"


def discard(peer):
    """Reads what is there."""
    while select.select([peer], [], [], 0)[0] and peer.recv(1 << 16):
        pass


def see(port, rate, until):
    """The camera and the encoder, in a process of their own."""
    camera = connect(port, name="camera", role="camera")
    encoder = connect(port, name="encoder", role="encoder")
    rows = rate // PICTURES // SEEN
    # Items that enter with each picture, a row of them across the belt.
    apart = 2 * HALF_WIDTH / rows
    began = time.time()
    for number in range(int((until - began) * 100)):
        wait = began + number / 100 - time.time()
        if wait > 0:
            time.sleep(wait)
        now = time.time()
        gone = SPEED * (now - began)
        if number % 2 == 0:
            encoder.sendall(line(kind="belt", stamp=now, speed=SPEED, position=gone))
            discard(encoder)
        if number % (100 // PICTURES):
            continue
        discard(camera)
        picture = number // (100 // PICTURES)
        lines = []
        for row in range(picture, max(picture - SEEN, -1), -1):
            x = gone - SPEED * row / PICTURES - 0.2
            for place in range(rows):
                y = (place + 0.5) * apart - HALF_WIDTH
                lines.append(line(kind="detection", stamp=now, id=f"{row}:{place}", x=x, y=y))
        camera.sendall(b"".join(lines))


class Robots:
    """All robots, on one connection; one of them is asked about at a time."""

    def __init__(self, port):
        self.peer = connect(port, name="robots", role="robot", robots=ROBOTS)
        self.rest = b""
        self.open = {}
        self.status = None
        for name in ROBOTS:
            self.peer.sendall(line(kind="robot", stamp=time.time(), name=name, state="idle"))

    def hear(self, patience):
        """Robots for which a task has come by now, with the time when it was read [s]."""
        if not select.select([self.peer], [], [], max(patience, 0))[0]:
            return []
        part = self.peer.recv(1 << 16)
        read = time.perf_counter()
        if not part:
            sys.exit("the node has hung up")
        lines = (self.rest + part).split(b"\n")
        self.rest = lines.pop()
        come = []
        for text in lines:
            message = json.loads(text)
            if message["kind"] == "task":
                known = message["robot"] in self.open
                self.open[message["robot"]] = message["id"]
                self.peer.sendall(line(kind="ack", stamp=time.time(), task=message["id"]))
                if not known:
                    come.append((message["robot"], read))
            elif message["kind"] == "status":
                self.status = message
        return come

    def report(self, name):
        """Says that a robot is done; when that was [s]."""
        text = line(kind="result", stamp=time.time(), task=self.open.pop(name), result="PICKED")
        wrote = time.perf_counter()
        self.peer.sendall(text)
        return wrote

    def measure(self, until, process):
        """Latencies [ms] and sizes of the process [MB] until then."""
        latencies, sizes, sampled = [], [], 0
        last = None
        while time.time() < until:
            pause = time.time() + random.uniform(0.005, 0.025)
            while (left := pause - time.time()) > 0:
                self.hear(left)
            names = [name for name in ROBOTS if name in self.open]
            if not names:
                self.hear(0.1)
                continue
            # In turn.
            later = [name for name in names if last and ROBOTS.index(name) > ROBOTS.index(last)]
            last = (later or names)[0]
            wrote, patience = self.report(last), time.time() + 5
            while time.time() < patience:
                come = dict(self.hear(0.1))
                if last in come:
                    latencies.append(1e3 * (come[last] - wrote))
                    break
            if time.time() - sampled > 0.5:
                sampled = time.time()
                sizes.append(memory(process))
        return latencies, sizes


def memory(process):
    """Resident memory [MB]."""
    lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
    return next(int(text.split()[1]) / 1024 for text in lines if text.startswith("VmRSS"))


def quantile(sorted_values, share):
    return sorted_values[min(int(share * len(sorted_values)), len(sorted_values) - 1)]


def main():
    options = parse_arguments()
    random.seed(1)
    command = [options.pickline, "run", "--station", str(STATION), "--listen", "127.0.0.1:0"]
    command += ["--strategy", options.strategy]
    if options.budget_ms:
        command += ["--budget-ms", options.budget_ms]
    node = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        for remark in node.stderr:
            if "listening at" in remark:
                port = int(remark.rsplit(":", 1)[1])
                break
        else:
            return f"it has ended with {node.wait()}"
        until = time.time() + FILLS + options.seconds
        camera = multiprocessing.Process(target=see, args=(port, options.rate, until), daemon=True)
        camera.start()
        robots = Robots(port)
        robots.measure(until - options.seconds, node)
        latencies, sizes = robots.measure(until - 0.5, node)
        status = robots.status
    finally:
        node.terminate()
        node.stderr.read()
        node.wait()
    latencies.sort()
    if len(latencies) < options.seconds:
        return f"{len(latencies)} tasks in {options.seconds} s: the line stood still"
    half = sizes[len(sizes) // 2]
    strategy = options.strategy + (f", {options.budget_ms} ms" if options.budget_ms else "")
    inside = status["latency"]
    times = " | ".join(f"{quantile(latencies, share):.2f}" for share in (0.5, 0.9, 0.99, 1))
    print(f"| {strategy} | {options.rate:,} | {len(latencies):,} | {times} | ", end="")
    print(f"{inside['p50_ms']:.2f}, {inside['p99_ms']:.2f} | {half:.1f}, {max(sizes):.1f} |")
    if status["rejected"]:
        return f"refused: {status['rejected']}"
    if max(sizes[len(sizes) // 2 :]) > 1.1 * half + 1:
        return "memory grew"
    return 0


if __name__ == "__main__":
    sys.exit(main())
