"""Decisions per second: the vector environment in Rust beside one in Python and numpy.

    python python/benchmarks/throughput.py

Both play the same patterns of 50 items with random allowed actions in 64 environments. Runs of the two
take turns, so that the ratio holds on a busy machine.
"""

from __future__ import annotations

import argparse
import itertools
import os
import statistics
import time

import gymnasium
import numpy as np
from numpy_environment import NumpySortingEnv

import pickline

ENVS = 64


class RandomActions:
    """Draws allowed actions for all environments at once."""

    def __init__(self) -> None:
        # Drawn beforehand, so that the time of a step is that of the environments.
        self.draws = itertools.cycle(np.random.default_rng(1).random((1009, ENVS)))

    def __call__(self, masks: np.ndarray) -> np.ndarray:
        # Slots are filled from the first.
        filled = masks.sum(axis=1, dtype=np.int32)
        return (next(self.draws) * filled).astype(np.int64)


def rust(observation: str, steps: int) -> float:
    """Decisions per second of the vector environment."""
    lines = gymnasium.make_vec(
        "pickline/Sorting-v0",
        num_envs=ENVS,
        patterns="poisson:0.12:100",
        items=50,
        observation=observation,
        copy=False,
    )
    draw = RandomActions()
    lines.reset(seed=1)
    masks = lines.unwrapped.action_masks()
    began = time.perf_counter()
    for _ in range(steps):
        lines.step(draw(masks))
        masks = lines.unwrapped.action_masks()
    return ENVS * steps / (time.perf_counter() - began)


def numpy_only(steps: int) -> float:
    """Decisions per second of the environment in Python, stepped by Gymnasium's vector environment."""
    station = pickline.Station("paper")
    patterns = pickline.patterns("poisson:0.12:100", station, items=50)
    lines = gymnasium.vector.SyncVectorEnv(
        [lambda: NumpySortingEnv(station, patterns)] * ENVS,
        autoreset_mode=gymnasium.vector.AutoresetMode.SAME_STEP,
    )
    draw = RandomActions()
    _, infos = lines.reset(seed=1)
    began = time.perf_counter()
    for _ in range(steps):
        _, _, _, _, infos = lines.step(draw(infos["action_mask"]))
    return ENVS * steps / (time.perf_counter() - began)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=5, help="rounds, of which the medians are told")
    parser.add_argument("--steps", type=int, default=4000, help="steps of the environment in Rust")
    chosen = parser.parse_args()
    found: dict[str, list[float]] = {"numpy": [], "paper": [], "full": []}
    for _ in range(chosen.rounds):
        found["numpy"].append(numpy_only(max(1, chosen.steps // 100)))
        for observation in ("paper", "full"):
            found[observation].append(rust(observation, chosen.steps))
    print(f"{ENVS} environments, patterns of 50 items, {os.cpu_count()} cores, decisions per second:")
    middle = {name: statistics.median(rates) for name, rates in found.items()}
    print(f"Python and numpy, the paper's observation  {middle['numpy']:12,.0f}")
    for observation in ("paper", "full"):
        ratios = [a / b for a, b in zip(found[observation], found["numpy"], strict=True)]
        times = statistics.median(ratios)
        print(f"pickline, observation {observation!r:<20} {middle[observation]:12,.0f}  {times:5,.0f} times")


if __name__ == "__main__":
    main()
