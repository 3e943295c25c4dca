"""Runs every assignment of a few lines by tree enumeration, by the event loop and in SimPy, compares all
picks, and prints how long one assignment takes (docs/speed.md).

usage: benchmark.py [--rounds N]

One core: the engines do not share out an enumeration among threads, and SimPy has only one. Times are those
for which a program had the processor. The engines take turns; what is printed is the fastest round of each,
and the median of the ratios of the rounds.
"""

import argparse
import csv
import itertools
import json
import statistics
import subprocess
import tempfile
import time
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

from line import RULES, Line, Pick, read_pattern, read_station

LINES = ["grid-2", "poisson-2", "grid-4", "poisson-4"]
ENGINES = ["tree", "event loop", "event loop and windows", "SimPy", "SimPy and windows"]


def build() -> str:
    """The part in Rust, with the optimisations of a release."""
    command = ["cargo", "bench", "--locked", "--package", "pickline", "--no-default-features"]
    command += ["--bench", "passes", "--no-run", "--message-format=json"]
    printed = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    messages = [json.loads(text) for text in printed.splitlines()]
    built = [m["executable"] for m in messages if m.get("target", {}).get("name") == "passes" and m.get("executable")]
    return built[-1]


class Cost(NamedTuple):
    """What one assignment costs: time [s], passes of a robot, time of their square roots alone [s]."""

    seconds: float
    passes: float
    roots: float


class Case:
    """A line with everything that the part in Rust found on it."""

    def __init__(self, folder: Path, name: str):
        self.name = name
        self.station = read_station((folder / f"{name}.toml").read_text())
        self.pattern = read_pattern((folder / f"{name}.csv").read_text())
        self.line = Line(self.station, self.pattern)
        robots = len(self.line.arms)
        self.assignments = [list(rules) for rules in itertools.product(RULES, repeat=robots)]
        self.picks: dict[str, list[Pick]] = defaultdict(list)
        with (folder / f"{name}-picks.csv").open() as file:
            for row in csv.reader(itertools.islice(file, 1, None)):
                self.picks[row[0]].append(Pick(int(row[1]), int(row[2]), *map(float, row[3:])))

    def compare(self) -> None:
        """Holds every pick of every assignment to SimPy's, to the bit."""
        for rules in self.assignments:
            assert self.line.run(rules) == self.picks[" ".join(rules)], f"{self.name}, {rules}"

    def costs(self, program: str) -> dict[str, Cost]:
        """One round: what one assignment costs, by each engine."""
        command = [program, "--bench", "--time", self.name]
        printed = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
        costs = {engine: Cost(*map(float, row)) for engine, *row in csv.reader(printed.stdout.splitlines())}
        began = time.process_time()
        for rules in self.assignments:
            self.line.run(rules)
        loop = costs["event loop"]
        costs["SimPy"] = loop._replace(seconds=(time.process_time() - began) / len(self.assignments))
        # The windows of a pattern do not depend on the rules, so a part of them is enough here.
        few = self.assignments[:: max(1, len(self.assignments) // 36)]
        began = time.process_time()
        for rules in few:
            Line(self.station, self.pattern).run(rules)
        costs["SimPy and windows"] = loop._replace(seconds=(time.process_time() - began) / len(few))
        return costs


def report(case: Case, rounds: list[dict[str, Cost]]) -> None:
    """Prints the rows of one line."""
    for engine in ENGINES:
        seconds = min(costs[engine].seconds for costs in rounds)
        beside = "SimPy and windows" if engine.endswith("windows") else "SimPy"
        ratio = statistics.median(costs[beside].seconds / costs[engine].seconds for costs in rounds)
        limit = statistics.median(costs[engine].seconds / costs[engine].roots for costs in rounds)
        passes = rounds[0][engine].passes
        print(
            f"| {case.name} | {engine} | {1e6 * seconds:,.2f} | {passes / seconds:,.0f} "
            f"| {1e6 * seconds / passes:,.2f} | {limit:,.1f} | {ratio:,.0f} |"
        )


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    program = build()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        subprocess.run([program, "--bench", "--write", str(folder)], check=True)
        cases = [Case(folder, line) for line in LINES]
    for case in cases:
        case.compare()
    compared = sum(len(picks) for case in cases for picks in case.picks.values())
    print(f"{compared} picks of {sum(len(c.assignments) for c in cases)} runs: equal to the bit\n")
    head = ["line", "engine", "one assignment [us]", "passes per second", "one pass [us]", "over its roots", "SimPy over it"]
    print(f"| {' | '.join(head)} |")
    print("|---|---|---|---|---|---|---|")
    for case in cases:
        report(case, [case.costs(program) for _ in range(rounds)])


if __name__ == "__main__":
    main()
