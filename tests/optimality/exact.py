"""Solves small lines to proven optimality with two foreign solvers, from the model's formulas written anew,
and says how much of the gap between look-ahead and the certified bound is the plans' and how much the bound's.
Then it confirms the best known solutions and the bounds of the benchmark's instances of 20 items
(patterns/benchmark/) whose arms have one bin.

usage: exact.py PICKLINE [--slot S] [--seconds S] [--all]

Time is cut into slots. With every pick rounded to take a little less than it does, CP-SAT and HiGHS (a
mixed-integer program over arcs) give what no schedule exceeds; with every pick rounded to take a little more,
CP-SAT gives a schedule. Where both agree, the optimum is proven. Neither uses anything of pickline but the
station file and the pattern.
"""

import argparse
import csv
import io
import json
import math
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

import highspy
import numpy as np
from ortools.sat.python import cp_model

# Lines on which not everything can be picked: station, robots, belt speed [m/s], radius [m], items, seed.
FEW = [
    ("paper", 2, 0.2, 0.12, 20, 1),
    ("paper", 3, 0.25, 0.12, 20, 2),
    ("paper-narrow", 2, 0.25, 0.1, 20, 3),
    ("delta", 2, 0.8, 0.06, 20, 4),
]
# More of them, larger ones, for the table in the documentation.
MANY = FEW + [
    ("paper", 2, 0.1, 0.12, 40, 5),
    ("paper", 2, 0.05, 0.1, 60, 6),
    ("paper-narrow", 2, 0.1, 0.1, 40, 7),
    ("delta", 3, 0.8, 0.06, 40, 8),
]


BENCHMARK = Path(__file__).parents[2] / "patterns" / "benchmark"
# Instances of the benchmark that are confirmed without --all.
FEW_OF_BENCHMARK = 3


@dataclass
class Way:
    """How one robot may take one item."""

    opens: float
    closes: float
    x0: float
    y: float


class Arm:
    """A robot with one bin, at which it rests: its travel times and departure windows."""

    def __init__(self, belt: dict, robot: dict):
        self.v, self.length, self.width = belt["speed"], belt["length"], belt["width"]
        self.base, self.bin, self.reach = robot["base"], robot["bin"], robot["reach"]
        self.speed, self.lift = robot["speed"], robot.get("lift", 0.0)
        up = robot.get("acceleration")
        self.ramps = 1 / up + 1 / robot.get("deceleration", up) if up else 0.0
        self.grasp, self.release = robot["grasp_time"], robot["release_time"]

    def time(self, way: float) -> float:
        """Time [s] for a move of `way` [m] in the plane: a trapezoidal profile, up and down included."""
        path = way + 2 * self.lift
        if path <= self.speed**2 * self.ramps / 2:
            return math.sqrt(2 * path * self.ramps)
        return path / self.speed + self.speed * self.ramps / 2

    def travel(self, x: float, y: float) -> float:
        """Time [s] until the arm that leaves its bin now meets an item at (x, y), by bisection."""
        low, high = 0.0, 1.0
        late = lambda tau: self.time(math.hypot(x + self.v * tau - self.bin[0], y - self.bin[1])) > tau
        while late(high):
            high *= 2
        for _ in range(80):
            middle = (low + high) / 2
            low, high = (middle, high) if late(middle) else (low, middle)
        return high

    def free(self, way: Way, leaves: float) -> float:
        """When the arm is free again [s] that leaves for an item at `leaves` [s]."""
        x = way.x0 + self.v * leaves
        tau = self.travel(x, way.y)
        back = math.hypot(x + self.v * tau - self.bin[0], way.y - self.bin[1])
        return leaves + tau + self.grasp + self.time(back) + self.release

    def way(self, x0: float, y: float) -> Way | None:
        """The departure window for an item that is at (x0, y) at time 0; None if it is out of reach."""
        across = y - self.base[1]
        if abs(across) > self.reach:
            return None
        half = math.sqrt(self.reach**2 - across**2)
        first, last = max(self.base[0] - half, 0.0), min(self.base[0] + half, self.length)
        if first > last:
            return None
        leave = lambda x: (x - x0) / self.v - self.time(math.hypot(x - self.bin[0], y - self.bin[1]))
        opens, closes = max(leave(first), 0.0), leave(last)
        return Way(min(opens, closes), closes, x0, y) if closes >= 0 else None


def steps(arm: Arm, way: Way, slot: float, optimistic: bool) -> list[tuple[int, int]]:
    """The slots in which the arm may leave for an item, each with the slot in which it is free again, of those
    with the same end the last. What is rounded makes every schedule a way through the slots if `optimistic`, and
    every way through the slots a schedule if not."""
    found: dict[int, int] = {}
    if optimistic:
        # A little early, so that no rounding error can take away a schedule.
        for start in range(int(way.opens / slot), int(way.closes / slot) + 1):
            ends = arm.free(way, max(way.opens, start * slot)) - 1e-9
            found[int(ends / slot)] = start
    else:
        for start in range(math.ceil(way.opens / slot + 1e-9), math.floor(way.closes / slot - 1e-9) + 1):
            found[math.ceil((arm.free(way, start * slot) + 1e-9) / slot)] = start
    return sorted((start, end) for end, start in found.items())


Choices = dict[tuple[int, int], list[tuple[int, int]]]
"""For each robot and item, the first and the last slot of every pick."""


def by_cp_sat(choices: Choices, seconds: float) -> tuple[int, int]:
    """The most items that can be picked and a bound on it: the same if it is proven."""
    model = cp_model.CpModel()
    intervals: dict[int, list] = {}
    takes: dict[int, list] = {}
    for (robot, item), pairs in choices.items():
        if not pairs:
            continue
        place = model.new_int_var(0, len(pairs) - 1, "")
        start = model.new_int_var(pairs[0][0], pairs[-1][0], "")
        end = model.new_int_var(pairs[0][1], pairs[-1][1], "")
        model.add_element(place, [pair[0] for pair in pairs], start)
        model.add_element(place, [pair[1] for pair in pairs], end)
        length = model.new_int_var(0, max(b - a for a, b in pairs), "")
        taken = model.new_bool_var("")
        intervals.setdefault(robot, []).append(model.new_optional_interval_var(start, length, end, taken, ""))
        takes.setdefault(item, []).append(taken)
    for own in intervals.values():
        model.add_no_overlap(own)
    for own in takes.values():
        model.add_at_most_one(own)
    model.maximize(sum(taken for own in takes.values() for taken in own))
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = seconds
    solver.parameters.num_workers = 2
    status = solver.solve(model)
    if status == cp_model.UNKNOWN:
        # Nothing in time, not even a bound.
        return 0, len(takes)
    if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        sys.exit(f"CP-SAT found nothing: {solver.status_name(status)}")
    return round(solver.objective_value), math.floor(solver.best_objective_bound + 1e-6)


def by_highs(choices: Choices, seconds: float) -> int:
    """A bound on the most items that can be picked, from flows through the slots of each robot."""
    highs = highspy.Highs()
    highs.silent()
    highs.setOptionValue("time_limit", float(seconds))
    columns: list[tuple[float, float, int]] = []  # cost, upper bound, whether whole
    entries: list[tuple[int, int, float]] = []  # row, column, value
    rows: list[tuple[float, float]] = []
    item_rows: dict[int, int] = {}
    for robot in {robot for robot, _ in choices}:
        own = [(item, pair) for (other, item), pairs in choices.items() if other == robot for pair in pairs]
        nodes = sorted({slot for _, pair in own for slot in pair})
        row_of = {slot: len(rows) + place for place, slot in enumerate(nodes)}
        # One unit of flow enters at the first node and leaves at the last.
        for place in range(len(nodes)):
            flow = float(place == 0) - float(place == len(nodes) - 1)
            rows.append((flow, flow))
        for before, after in zip(nodes, nodes[1:]):
            entries += [(row_of[before], len(columns), 1.0), (row_of[after], len(columns), -1.0)]
            columns.append((0.0, 1.0, 0))
        for item, (start, end) in own:
            if item not in item_rows:
                item_rows[item] = -1
            if start != end:
                entries += [(row_of[start], len(columns), 1.0), (row_of[end], len(columns), -1.0)]
            entries.append((-1 - item, len(columns), 1.0))
            columns.append((1.0, 1.0, 1))
    for item in item_rows:
        item_rows[item] = len(rows)
        rows.append((0.0, 1.0))
    entries = [(row if row >= 0 else item_rows[-1 - row], column, value) for row, column, value in entries]
    entries.sort()
    lp = highspy.HighsLp()
    lp.num_col_, lp.num_row_ = len(columns), len(rows)
    lp.col_cost_ = np.array([-cost for cost, _, _ in columns])
    lp.col_lower_, lp.col_upper_ = np.zeros(len(columns)), np.array([upper for _, upper, _ in columns])
    lp.integrality_ = [
        highspy.HighsVarType.kInteger if whole else highspy.HighsVarType.kContinuous for _, _, whole in columns
    ]
    lp.row_lower_, lp.row_upper_ = np.array([low for low, _ in rows]), np.array([high for _, high in rows])
    lp.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    counts = np.bincount([row for row, _, _ in entries], minlength=len(rows))
    lp.a_matrix_.start_ = np.concatenate([[0], np.cumsum(counts)])
    lp.a_matrix_.index_ = np.array([column for _, column, _ in entries])
    lp.a_matrix_.value_ = np.array([value for _, _, value in entries])
    highs.passModel(lp)
    highs.run()
    bound = -highs.getInfo().mip_dual_bound
    # Without a bound in time, every item may be picked.
    return math.floor(bound + 1e-6) if math.isfinite(bound) else len(item_rows)


def rows(text: str) -> list[dict[str, str]]:
    """The rows of a CSV text, without comments."""
    shown = io.StringIO("".join(row for row in text.splitlines(True) if not row.startswith("#")))
    return list(csv.DictReader(shown))


def optimum(station: str, pattern: str, slot: float, seconds: float) -> tuple[int, int, int]:
    """The most picks of a schedule that was found, what no schedule exceeds, and what it is by HiGHS alone, of
    the texts of a station and of a pattern."""
    known = tomllib.loads(station)
    arms = [Arm(known["belt"], robot) for robot in known["robot"]]
    places = [(float(row["x"]), float(row["y"])) for row in rows(pattern)]

    def choices(optimistic: bool) -> Choices:
        ways = {(r, i): arm.way(*at) for r, arm in enumerate(arms) for i, at in enumerate(places)}
        return {
            key: steps(arms[key[0]], way, slot, optimistic) for key, way in ways.items() if way is not None
        }

    relaxed = choices(optimistic=True)
    _, at_most = by_cp_sat(relaxed, seconds)
    whole = by_highs(relaxed, seconds)
    at_least, _ = by_cp_sat(choices(optimistic=False), seconds)
    return at_least, min(at_most, whole), whole


def check(name: str, certified: int, at_least: int, at_most: int) -> None:
    """Ends the program if a bound is below a schedule."""
    for what, broken in [
        ("the bound is below a schedule", certified < at_least),
        ("a schedule is above what the solvers allow", at_least > at_most),
    ]:
        if broken:
            sys.exit(f"{name}: {what}")


def confirm_benchmark(seconds: float, slots: dict[str, float], few: bool) -> None:
    """Confirms what is known of the benchmark's small instances."""
    small = [row for row in rows((BENCHMARK / "instances.csv").read_text()) if row["items"] == "20"]
    small = [row for row in small if not row["name"].startswith("sorting")]
    if few:
        # One of each station.
        small = small[:: len(small) // FEW_OF_BENCHMARK][:FEW_OF_BENCHMARK]
    print(f"\n{'instance of the benchmark':40} best known  optimum  HiGHS  bound")
    proven = 0
    for row in small:
        name, picked, certified = row["name"], int(row["picked"]), int(row["picks_bound"])
        station = (BENCHMARK / "stations" / f"{name}.toml").read_text()
        pattern = (BENCHMARK / "patterns" / f"{name}.csv").read_text()
        slot = slots["delta" if name.startswith("delta") else "paper"]
        at_least, at_most, whole = optimum(station, pattern, slot, seconds)
        check(name, certified, max(at_least, picked), at_most)
        best = max(at_least, picked)
        shown = f"{best}" if best == at_most else f"{best}..{at_most}"
        print(f"{name:40} {picked:10} {shown:>8} {whole:6} {certified:6}", flush=True)
        proven += picked == at_most
    print(f"best known solutions that are proven optimal: {proven} of {len(small)}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("pickline")
    parser.add_argument("--slot", type=float, default=0.05, help="length of the slots of the paper's stations [s]")
    parser.add_argument("--seconds", type=float, default=60, help="longest time for one solution [s]")
    parser.add_argument("--all", action="store_true", help="the larger lines as well")
    options = parser.parse_args()
    slots = {"paper": options.slot, "delta": options.slot / 10}

    def call(*arguments: str) -> str:
        line = [options.pickline, *arguments]
        return subprocess.run(line, check=True, capture_output=True, text=True).stdout

    print(f"{'line':58} look-ahead schedule  optimum  HiGHS  bound")
    totals = [0, 0, 0]
    with tempfile.TemporaryDirectory() as folder:
        for station, robots, speed, radius, items, seed in MANY if options.all else FEW:
            line = ["--station", station, "--robots", str(robots), "--belt-speed", str(speed)]
            text = call("station", "show", *line)
            station_file, pattern_file = Path(folder, "station.toml"), Path(folder, "pattern.csv")
            station_file.write_text(text)
            made = ["--radius", str(radius), "--count", str(items), "--seed", str(seed)]
            pattern = call("pattern", "generate", "poisson", "--quiet", *line, *made)
            pattern_file.write_text(pattern)
            run = ["--station", str(station_file), "--pattern", str(pattern_file), "--quiet", "--format", "json"]
            bound = json.loads(call("bound", *run))
            ahead = json.loads(call("simulate", "--strategy", "lookahead", "--no-bound", *run))["picked"]
            slot = slots["delta" if station == "delta" else "paper"]
            at_least, at_most, whole = optimum(text, pattern, slot, options.seconds)
            certified = bound["picks_upper_bound"]
            # Rounded picks lose some schedules that the others have.
            own = bound["schedule"]["picked"] if bound["schedule"] else 0
            at_least = max(at_least, ahead, own)
            proven = f"{at_least}" if at_least == at_most else f"{at_least}..{at_most}"
            name = f"{station} {robots} robots {speed} m/s poisson {radius} {items} items #{seed}"
            print(f"{name:58} {ahead:10} {own:8} {proven:>8} {whole:6} {certified:6}", flush=True)
            check(name, certified, at_least, at_most)
            if at_least == at_most:
                for place, value in enumerate((ahead, at_least, certified)):
                    totals[place] += value
    ahead, best, certified = totals
    print(
        f"where the optimum is proven: look-ahead {ahead}, optimum {best}, bound {certified}; the plans lack "
        f"{100 * (1 - ahead / best):.1f} %, the bound has {100 * (certified / best - 1):.1f} % too much"
    )
    confirm_benchmark(options.seconds, slots, few=not options.all)


main()
