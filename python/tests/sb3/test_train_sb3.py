"""Training as a program, and what it writes, read by the Rust side; run.sh installs what it needs."""

import csv
import itertools
import subprocess
import sys

import numpy as np
import pytest
import torch

import pickline
from pickline import sb3, train_sb3
from pickline.environment import SortingEnv

SMALL = {"patterns": "poisson:0.15:5", "items": 30}
CASES = """
[[case]]
name = "sparse"
poisson = 0.2
items = 12

[[case]]
name = "a grid"
grid = 0.15
items = 30
"""


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    file = tmp_path_factory.mktemp("cases") / "cases.toml"
    file.write_text(CASES)
    return str(file)


@pytest.fixture(scope="module")
def model(cases):
    return train_sb3.train(steps=2048, evaluate_on=cases, seed=3, **SMALL)


def exporters():
    new = tuple(map(int, torch.__version__.split(".")[:2])) >= (2, 5)
    return ["torchscript", "dynamo"] if new else ["torchscript"]


@pytest.mark.parametrize("exporter", exporters())
def test_the_rust_side_decides_as_the_policy(model, tmp_path, exporter):
    file = tmp_path / "policy.onnx"
    train_sb3.export(model, file, exporter)
    station = pickline.Station("paper")
    sets = {
        "dense": pickline.patterns("poisson:0.12:4", station, items=40, seed=9),
        "sparse": pickline.patterns("poisson:0.2:2", station, items=20, seed=9),
    }
    lines = {
        name: [SortingEnv(station, [pattern], observation="paper") for pattern in own]
        for name, own in sets.items()
    }
    ours = train_sb3.evaluate(model, lines)
    for name, own in sets.items():
        theirs = [pickline.simulate(station, pattern, f"onnx:{file}") for pattern in own]
        rates = np.mean([run.picking_rate for run in theirs])
        shares = np.mean([run.picked / run.items for run in theirs])
        assert ours[name]["picking_rate_per_min"] == pytest.approx(rates, rel=1e-12)
        assert ours[name]["picked_share"] == pytest.approx(shares, rel=1e-12)


def test_no_pattern_of_the_evaluations_is_trained_on(cases, monkeypatch):
    trained_on = []

    class Watched(sb3.SortingVecEnv):
        def __init__(self, count, line, patterns, **options):
            trained_on.extend(patterns)
            super().__init__(count, line, patterns, **options)

    monkeypatch.setattr(sb3, "SortingVecEnv", Watched)
    train_sb3.train(steps=2048, patterns="balanced:3", items=30, evaluate_on=cases, seed=3)
    station = pickline.Station("paper")
    whole = pickline.patterns("balanced:3", station, items=30, seed=3)
    assert pickline.trials(station, cases)["a grid"] == [whole[0]]
    assert trained_on == whole[1:]
    with pytest.raises(ValueError, match="evaluated on all of them"):
        train_sb3.train(patterns="grid:0.15", items=30, evaluate_on=cases)


def test_the_program_writes_a_policy_and_its_curve(cases, tmp_path):
    file = tmp_path / "mine.onnx"
    command = [sys.executable, "-m", "pickline.train_sb3", "--out", str(file), "--steps", "4096"]
    command += ["--patterns", "poisson:0.15:5", "--items", "30", "--evaluate-on", cases]
    command += ["--evaluate-every", "2048", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with file.with_suffix(".csv").open(newline="") as curve:
        rows = list(csv.DictReader(curve))
    steps, names = (0, 2048, 4096), ("sparse", "a grid")
    assert [(int(row["steps"]), row["case"]) for row in rows] == [*itertools.product(steps, names)]
    assert all(0 < float(row["picked_share"]) <= 1 for row in rows)
    # Nothing is known of the items, so that each weighs a half.
    for row in rows:
        half = float(row["picking_rate_per_min"]) / 2
        assert float(row["weighted_rate_per_min"]) == pytest.approx(half)
    shown = pickline.simulate("paper", pickline.patterns("grid:0.15", pickline.Station("paper"))[0], f"onnx:{file}")
    assert shown.picked > 0
    # Nothing is overwritten.
    again = subprocess.run(command, capture_output=True, text=True)
    assert again.returncode == 2 and "the file exists" in again.stderr


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--station", "nowhere"], "nowhere"),
        (["--patterns", "poisson:x"], "poisson:x"),
        (["--envs", "7"], "7 does not divide the 2048 steps"),
        (["--evaluate-on", "papre"], "did you mean `paper`"),
        (["--patterns", "grid:0.15"], "evaluated on all of them"),
        (["--out", "policy.pt"], "does not end in .onnx"),
    ],
)
def test_wrong_settings_are_told_and_leave_nothing(tmp_path, flags, says):
    command = [sys.executable, "-m", "pickline.train_sb3", "--out", "p.onnx", "--quiet", *flags]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 2, done.stderr
    assert says in done.stderr and "cure: " in done.stderr and "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_exporter_is_a_value_error(model, tmp_path):
    with pytest.raises(ValueError, match="torchscript or dynamo"):
        train_sb3.export(model, tmp_path / "p.onnx", "onnx")
