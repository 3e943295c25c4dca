"""The line as a Gymnasium environment in Python and numpy, to compare the one in Rust with.

It is the plain model of docs/model.md for arms at constant speed with one bin each, with the paper's
observation: what a researcher would write with care. Everything that can be is done for all items at
once; the windows of an episode are found at its beginning. tests/test_benchmark.py holds it to the
environment in Rust.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

import pickline

SLOTS = 10
ROBOTS = 6
"""How many robots the paper's observation shows."""


class NumpySortingEnv(gymnasium.Env):
    """One line of arms at constant speed.

    Args:
        station: The line.
        patterns: One of them is drawn for each episode.
        reward: Weights of a pick's reward and of the weighted rate at the end.
    """

    def __init__(
        self,
        station: pickline.Station,
        patterns: Sequence[pickline.Pattern],
        reward: tuple[float, float] = (1.0, 1.0),
    ) -> None:
        told = tomllib.loads(station.to_toml())
        self.v, self.length = told["belt"]["speed"], told["belt"]["length"]
        robots = told["robot"]
        self.base = np.array([robot["base"] for robot in robots])
        self.bin = np.array([robot["bin"] for robot in robots])
        self.reach = np.array([robot["reach"] for robot in robots])
        self.speed = np.array([robot["speed"] for robot in robots])
        self.dwell = np.array([robot["grasp_time"] + robot["release_time"] for robot in robots])
        self.k = self.speed**2 - self.v**2
        self.patterns = [(pattern.x, pattern.y, pattern.reward) for pattern in patterns]
        self.weights = reward
        self.observation_space = spaces.Box(-np.inf, np.inf, (2 * ROBOTS + 4 * SLOTS,), np.float32)
        self.action_space = spaces.Discrete(SLOTS)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        self.x0, self.y, self.r = self.patterns[self.np_random.integers(len(self.patterns))]
        self.open, self.close = self._windows()
        self.there = np.ones(len(self.x0), bool)
        self.free = np.zeros(len(self.reach))
        self.weight, self.picked, self.last_release = 0.0, 0, 0.0
        self._next_decision()
        return self._observation(), {"action_mask": self._mask()}

    def step(self, action: int) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        if not 0 <= action < len(self.chosen):
            raise ValueError(f"action {action} is masked")
        place = self.chosen[action]
        item, robot = self.candidates[place], self.robot
        self.free[robot] = self.time + self.processing[place]
        self.last_release = max(self.last_release, self.free[robot])
        self.there[item] = False
        self.picked += 1
        self.weight += self.r[item]
        reward = self.weights[0] * self.r[item]
        self._next_decision()
        info: dict[str, Any] = {"action_mask": self._mask()}
        ended = self.robot is None
        if ended:
            end = self.last_release
            if self.there.any():
                end = max(end, (self.length - self.x0[self.there].min()) / self.v)
            rate = 60.0 * self.weight / end
            reward += self.weights[1] * rate
            info |= {"picked": self.picked, "picking_rate": 60.0 * self.picked / end}
        return self._observation(), reward, ended, False, info

    def _windows(self) -> tuple[np.ndarray, np.ndarray]:
        """First and last departure of each robot for each item [s]; the last before the first if there
        is none."""
        dy = self.y - self.base[:, 1:]
        with np.errstate(invalid="ignore"):
            half = np.sqrt(self.reach[:, None] ** 2 - dy**2)
        first = np.maximum(self.base[:, :1] - half, 0.0)
        last = np.minimum(self.base[:, :1] + half, self.length)

        def leaves(x: np.ndarray) -> np.ndarray:
            way = np.hypot(x - self.bin[:, :1], self.y - self.bin[:, 1:])
            return (x - self.x0) / self.v - way / self.speed[:, None]

        close = leaves(last)
        open_ = np.maximum(leaves(first), 0.0)
        can = (first <= last) & (close >= 0.0)
        return np.where(can, np.minimum(open_, close), np.inf), np.where(can, close, -np.inf)

    def _next_decision(self) -> None:
        """Finds the robot that decides next, when, and between which items."""
        self.time, self.robot = math.inf, None
        for robot, free in enumerate(self.free):
            can = self.there & (self.close[robot] >= free)
            if can.any():
                time = max(free, self.open[robot][can].min())
                if time < self.time:
                    self.time, self.robot = time, robot
        if self.robot is None:
            self.candidates = self.chosen = np.zeros(0, np.int64)
            return
        robot, time = self.robot, self.time
        can = self.there & (self.open[robot] <= time) & (self.close[robot] >= time)
        self.candidates = np.flatnonzero(can)
        dx = self.x0[can] + self.v * time - self.bin[robot, 0]
        dy = self.y[can] - self.bin[robot, 1]
        k, vdx = self.k[robot], self.v * dx
        travel = (vdx + np.sqrt(vdx * vdx + k * (dx * dx + dy * dy))) / k
        self.processing = 2.0 * travel + self.dwell[robot]
        self.chosen = np.arange(len(self.candidates))
        if len(self.candidates) > SLOTS:
            # Half of the slots for the shortest picks, half for those that are lost first.
            by_time = np.argsort(self.processing, kind="stable")
            half = -(-SLOTS // 2)
            rest = np.sort(by_time[half:])
            soon = rest[np.argsort(self.close[robot][self.candidates[rest]], kind="stable")]
            self.chosen = np.sort(np.concatenate([by_time[:half], soon[: SLOTS - half]]))

    def _mask(self) -> np.ndarray:
        return (np.arange(SLOTS) < len(self.chosen)).astype(np.int8)

    def _observation(self) -> np.ndarray:
        found = np.zeros(self.observation_space.shape, np.float32)
        if self.robot is None:
            return found
        shown = min(len(self.free), ROBOTS)
        until = np.maximum(self.free - self.time, 0.0)[:shown]
        found[0 : 2 * shown : 2] = until > 0.0
        found[1 : 2 * shown : 2] = until
        items = self.candidates[self.chosen]
        slots = found[2 * ROBOTS :].reshape(SLOTS, 4)[: len(items)]
        slots[:, 0] = self.x0[items] + self.v * self.time - self.base[self.robot, 0]
        slots[:, 1] = self.y[items] - self.base[self.robot, 1]
        slots[:, 2] = self.processing[self.chosen]
        slots[:, 3] = self.r[items]
        return found
