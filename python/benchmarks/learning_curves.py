"""Learning curves of both trainers side by side: a picture, and where they end.

    python python/benchmarks/learning_curves.py results/sb3

reads the curves of ``pickline train`` (``native-SEED.csv``, with the rates of greedy GT in
``native-SEED.json``) and of ``python -m pickline.train_sb3`` (``sb3-SEED.csv``), writes ``curves.svg`` beside
them, and prints for every training the mean picking rate on the paper's cases at its end, as a share of
greedy GT's.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections import defaultdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import pickline

TRAINERS = {"native": "pickline train", "sb3": "Stable-Baselines3"}
"""The trainers by how the names of their files begin."""

Curve = tuple[NDArray[np.int64], NDArray[np.float64]]
"""Decisions learned from, and the shares of greedy GT's rate then, [evaluations] each."""


def rates_of(file: Path, cases: list[str]) -> dict[int, dict[str, float]]:
    """The weighted rates [1/min] in the curve of either trainer, by decisions and case."""
    rates: dict[int, dict[str, float]] = defaultdict(dict)
    with file.open(newline="") as lines:
        for row in csv.DictReader(lines):
            steps = int(row["steps"])
            if "case" in row:
                rates[steps][row["case"]] = float(row["weighted_rate_per_min"])
            else:
                # A column of the native trainer is named "station: case".
                own = {name.partition(": ")[2]: rate for name, rate in row.items()}
                rates[steps].update({case: float(own[case]) for case in cases})
    return rates


def curve_of(file: Path, greedy: dict[str, float]) -> Curve:
    """The mean over the cases of ``greedy`` of a training's rate as a share of greedy GT's."""
    rates = rates_of(file, list(greedy))
    steps = sorted(rates)
    shares = [np.mean([rates[step][case] / rate for case, rate in greedy.items()]) for step in steps]
    return np.array(steps), np.array(shares)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, help="the picture; FOLDER/curves.svg if not given")
    chosen = parser.parse_args()
    cases = list(pickline.trials(pickline.Station("paper"), "paper"))
    record = json.loads(next(iter(sorted(chosen.folder.glob("native-*.json")))).read_text())
    by_name = {trial["name"].partition(": ")[2]: trial["greedy"] for trial in record["trials"]}
    greedy = {case: by_name[case] for case in cases}
    curves = []
    for prefix, trainer in TRAINERS.items():
        for file in sorted(chosen.folder.glob(f"{prefix}-*.csv")):
            steps, shares = curve_of(file, greedy)
            curves.append((trainer, steps, shares))
            seed = file.stem.partition("-")[2]
            print(f"{trainer}, seed {seed}: {100 * shares[-1]:.1f} % after {steps[-1]} decisions")
    picture = chosen.out or chosen.folder / "curves.svg"
    picture.write_text(pickline.learning_curves(curves))


if __name__ == "__main__":
    main()
