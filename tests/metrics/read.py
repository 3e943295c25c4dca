"""A line with names that need escapes, whose metrics are scraped while it runs: every scrape
is parsed by prometheus_client, counters never fall, and the figures add up to what the status
messages say at the end."""

import json
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

from prometheus_client.parser import text_string_to_metric_families

PROGRAM = sys.argv[1]
ROBOTS = ['r "1"', "r\\2"]
STATION = "[belt]\nspeed = 0.3\nlength = 4.0\nwidth = 1.0\n" + "".join(
    f"[[robot]]\nname = {json.dumps(name)}\nbase = [{x}, -0.6]\nbin = [{x}, -0.5]\nreach = 0.8\n"
    "speed = 2.0\ngrasp_time = 0.05\nrelease_time = 0.05\n"
    for name, x in zip(ROBOTS, (1.3, 2.9))
)


class Remarks(threading.Thread):
    """What a program says on stderr."""

    def __init__(self, process):
        super().__init__(daemon=True)
        self.process, self.lines = process, []
        self.start()

    def run(self):
        for line in self.process.stderr:
            self.lines.append(line)

    def wait_for(self, pattern):
        until = time.monotonic() + 60
        while time.monotonic() < until:
            for line in self.lines:
                if found := re.search(pattern, line):
                    return found.group(1)
            time.sleep(0.02)
        sys.exit(f"waited in vain for {pattern} in {self.lines}")


def scrape(address):
    with urllib.request.urlopen(f"http://{address}/metrics", timeout=10) as answer:
        assert answer.headers["Content-Type"] == "text/plain; version=0.0.4; charset=utf-8"
        text = answer.read().decode()
    families = list(text_string_to_metric_families(text))
    names = [family.name for family in families]
    assert len(names) == len(set(names)), names
    for family in families:
        assert family.documentation and family.type != "unknown", family
    return {family.name: family for family in families}


def value(families, name):
    (sample,) = families[name].samples
    return sample.value


def by(families, name, label):
    found = {sample.labels[label]: sample.value for sample in families[name].samples}
    assert len(found) == len(families[name].samples)
    return found


def check(families, before):
    missed = by(families, "pickline_items_missed", "reason")
    assert {"unreachable", "grasp_failed", "no_result", "passed_over", "busy"} <= set(missed)
    seen, picked = (value(families, f"pickline_items_{what}") for what in ("seen", "picked"))
    rest = sum(value(families, f"pickline_items_{what}") for what in ("on_belt", "claimed"))
    assert seen == picked + sum(missed.values()) + rest
    for robot in ROBOTS:
        states = [
            sample
            for sample in families["pickline_robot_state"].samples
            if sample.labels["robot"] == robot
        ]
        assert sum(sample.value for sample in states) == 1, states
    for name in ("age", "overdue"):
        family = families[f"pickline_source_{name}" + ("_seconds" if name == "age" else "")]
        for sample in family.samples:
            assert sample.labels["kind"] and sample.labels["source"], sample
            assert sample.value >= 0, sample
    times = families["pickline_decision_duration_seconds"].samples
    buckets = [(float(s.labels["le"]), s.value) for s in times if s.name.endswith("_bucket")]
    assert buckets == sorted(buckets) and buckets[-1][0] == float("inf")
    assert [count for _, count in buckets] == sorted(count for _, count in buckets)
    (count,) = (s.value for s in times if s.name.endswith("_count"))
    assert count == buckets[-1][1]
    for name, family in families.items():
        if family.type == "counter":
            for sample in family.samples:
                key = (name, *sorted(sample.labels.items()))
                assert sample.value >= before.get(key, 0), f"{key} has fallen"
                before[key] = sample.value
    return seen, picked


folder = pathlib.Path(tempfile.mkdtemp())
station = folder / "line.toml"
station.write_text(STATION)
node = subprocess.Popen(
    [PROGRAM, "run", "--station", station, "--listen", "127.0.0.1:0", "--dashboard",
     "127.0.0.1:0", "--status-every", "0.2"],
    stderr=subprocess.PIPE, text=True)
remarks = Remarks(node)
address = remarks.wait_for(r"listening at (\S+)")
dashboard = remarks.wait_for(r"dashboard at http://(\S+)/")
host, port = address.rsplit(":", 1)
watcher = socket.create_connection((host, int(port)))
# The second line is refused, and counted by reason.
watcher.sendall(b'{"kind":"hello","name":"watcher","role":"observer"}\n{\n')
before, scrapes = {}, 0
emulate = subprocess.Popen(
    [PROGRAM, "emulate", "--station", station, "--connect", address, "--failing-grasps", "0.2"],
    stderr=subprocess.DEVNULL)
while emulate.poll() is None:
    check(scrape(dashboard), before)
    scrapes += 1
    time.sleep(0.2)
assert emulate.returncode == 0 and scrapes > 2, scrapes
families = scrape(dashboard)
seen, picked = check(families, before)
assert by(families, "pickline_messages_rejected", "reason") == {"syntax": 1}
assert by(families, "pickline_robot_picks", "robot").keys() == set(ROBOTS)
ages = families["pickline_source_age_seconds"].samples
# A camera and a belt may have one name, but not one name and kind.
assert len({(age.labels["source"], age.labels["kind"]) for age in ages}) == len(ages), ages
assert set(ROBOTS) <= {age.labels["source"] for age in ages}, ages
(info,) = families["pickline_info"].samples
assert info.labels["strategy"].endswith("SPT,FIFO"), info
node.terminate()
assert node.wait(10) == 0
statuses = [json.loads(line) for line in watcher.makefile() if '"kind":"status"' in line]
last = statuses[-1]
assert last["last"] and (last["seen"], last["picked"]) == (seen, picked), last
times = families["pickline_decision_duration_seconds"].samples
(decisions,) = (sample.value for sample in times if sample.name.endswith("_count"))
assert last["latency"]["decisions"] == decisions, last
robots = by(families, "pickline_robot_picks", "robot")
assert {robot["name"]: robot["picked"] for robot in last["robots"]} == robots
print(f"metrics: {scrapes} scrapes, {seen:.0f} items seen, {picked:.0f} picked: all add up")
