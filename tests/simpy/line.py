"""The line of docs/model.md as a SimPy program: one process for each robot, one event for each pick.

For robots with one bin and arms at constant speed, without camera, disturbances and update frequency. The
windows are computed once for a station and a pattern, and shared by all runs, as in pickline.
"""

import csv
import math
import tomllib
from collections.abc import Callable, Generator
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

import simpy


@dataclass(slots=True)
class Arm:
    """A robot: lengths [m], speeds [m/s], times [s]."""

    belt_speed: float
    belt_length: float
    base_x: float
    base_y: float
    bin_x: float
    bin_y: float
    reach: float
    speed: float
    grasp_time: float
    release_time: float

    def travel_time(self, x: float, y: float) -> float:
        """Time [s] from the bin to an item that is now at (x, y)."""
        dx, dy = x - self.bin_x, y - self.bin_y
        k = self.speed * self.speed - self.belt_speed * self.belt_speed
        vdx = self.belt_speed * dx
        return (vdx + math.sqrt(vdx * vdx + k * (dx * dx + dy * dy))) / k

    def departure(self, x: float, x0: float, y: float) -> float:
        """When the robot leaves [s] to meet the item at x."""
        dx, dy = x - self.bin_x, y - self.bin_y
        return (x - x0) / self.belt_speed - math.sqrt(dx * dx + dy * dy) / self.speed

    def window(self, x0: float, y: float) -> tuple[float, float] | None:
        """The departure window [s] of an item; None if there is none."""
        dy = y - self.base_y
        square = self.reach * self.reach - dy * dy
        if square < 0.0:
            return None
        x_in = max(self.base_x - math.sqrt(square), 0.0)
        x_out = min(self.base_x + math.sqrt(square), self.belt_length)
        closes = self.departure(x_out, x0, y)
        if x_in > x_out or closes < 0.0:
            return None
        return min(max(self.departure(x_in, x0, y), 0.0), closes), closes


@dataclass(slots=True)
class Candidate:
    """An item with its departure window for one robot."""

    item: int
    x0: float
    y: float
    weight: float
    opens: float
    closes: float


class Pick(NamedTuple):
    """Which robot takes which item; when it leaves for it, grasps it and is free again [s]."""

    robot: int
    item: int
    decide: float
    grasp: float
    release: float


Key = Callable[[Candidate], float]


# A rule gives the key of an item at a decision, when the belt has moved by `shift` [m] since time 0.
def fifo(arm: Arm, shift: float) -> Key:
    return lambda item: -(item.x0 + shift)


def spt(arm: Arm, shift: float) -> Key:
    # As in `Arm.travel_time`, but the call of a method would double the time of a key.
    sqrt, v, bin_x, bin_y = math.sqrt, arm.belt_speed, arm.bin_x, arm.bin_y
    grasp_time, release_time = arm.grasp_time, arm.release_time
    k = arm.speed * arm.speed - v * v

    def key(item: Candidate) -> float:
        dx, dy = item.x0 + shift - bin_x, item.y - bin_y
        vdx = v * dx
        return 2.0 * ((vdx + sqrt(vdx * vdx + k * (dx * dx + dy * dy))) / k) + grasp_time + release_time

    return key


def sd(arm: Arm, shift: float) -> Key:
    sqrt, base_x, base_y = math.sqrt, arm.base_x, arm.base_y

    def key(item: Candidate) -> float:
        dx, dy = item.x0 + shift - base_x, item.y - base_y
        return sqrt(dx * dx + dy * dy)

    return key


def pp(arm: Arm, shift: float) -> Key:
    return lambda item: -item.weight


# The rules: what is best first, and how. Both take the first of equal keys.
RULES = {"FIFO": (min, fifo), "SPT": (min, spt), "LPT": (max, spt), "SD": (min, sd), "LD": (max, sd), "PP": (min, pp)}


def robot(
    env: simpy.Environment,
    index: int,
    arm: Arm,
    rule: str,
    offered: list[Candidate],
    claimed: set[int],
    picks: list[Pick],
) -> Generator[simpy.Event]:
    """The process of one robot: waits until the window of an item is open, picks, and begins again.

    `offered` are the items that it has windows for, by opening time. SimPy's clock adds delays, so it may be
    off the sum of the model's times in the last bit; the process therefore keeps the model's time itself.
    """
    best, key = RULES[rule]
    downstream_first = attrgetter("item")
    now = 0.0
    coming = 0
    candidates: list[Candidate] = []
    while True:
        candidates = [c for c in candidates if c.closes >= now and c.item not in claimed]
        known = len(candidates)
        while coming < len(offered) and (item := offered[coming]).opens <= now:
            if item.closes >= now and item.item not in claimed:
                candidates.append(item)
            coming += 1
        if not candidates:
            while coming < len(offered) and offered[coming].item in claimed:
                coming += 1
            if coming == len(offered):
                return
            now = offered[coming].opens
            yield env.timeout(max(now - env.now, 0.0))
            continue
        if len(candidates) > known:
            candidates.sort(key=downstream_first)
        item = best(candidates, key=key(arm, arm.belt_speed * now))
        claimed.add(item.item)
        travel = arm.travel_time(item.x0 + arm.belt_speed * now, item.y)
        release = now + (2.0 * travel + arm.grasp_time + arm.release_time)
        picks.append(Pick(index, item.item, now, now + travel, release))
        now = release
        yield env.timeout(release - env.now)


class Line:
    """A pattern on a station, with every departure window computed once."""

    def __init__(self, station: dict, pattern: list[tuple[float, float, float]]):
        belt = station["belt"]
        self.arms = [
            Arm(belt["speed"], belt["length"], *r["base"], *r["bin"], r["reach"], r["speed"], r["grasp_time"], r["release_time"])
            for r in station["robot"]
        ]
        self.offered = [self._windows(arm, pattern) for arm in self.arms]

    @staticmethod
    def _windows(arm: Arm, pattern: list[tuple[float, float, float]]) -> list[Candidate]:
        windows = [
            Candidate(item, x0, y, weight, *window)
            for item, (x0, y, weight) in enumerate(pattern)
            if (window := arm.window(x0, y))
        ]
        windows.sort(key=attrgetter("opens"))
        return windows

    def run(self, rules: list[str]) -> list[Pick]:
        """The picks of one run, in order of decision, ties in the order of the robots."""
        env = simpy.Environment()
        claimed: set[int] = set()
        picks: list[Pick] = []
        for index, (arm, rule, offered) in enumerate(zip(self.arms, rules, self.offered, strict=True)):
            env.process(robot(env, index, arm, rule, offered, claimed, picks))
        env.run()
        return picks


def read_station(text: str) -> dict:
    """A station as `pickline station show` prints it."""
    return tomllib.loads(text)


def read_pattern(text: str) -> list[tuple[float, float, float]]:
    """A pattern as `pickline pattern generate` prints it, with or without weights: x and y at time 0 [m],
    weight. An item without one has the reward of the paper's detection that is certain and has no area, 1/2."""
    rows = list(csv.DictReader(text.splitlines()))
    return [(float(row["x"]), float(row["y"]), float(row.get("weight") or 0.5)) for row in rows]
