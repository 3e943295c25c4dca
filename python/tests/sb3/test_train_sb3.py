"""Training as a program, and what it writes, read by the Rust side; run.sh installs what it needs."""

import csv
import subprocess
import sys

import pytest
import torch

import pickline
from pickline import train_sb3
from pickline.environment import SortingEnv

SMALL = {"patterns": "poisson:0.15:5", "items": 30}


@pytest.fixture(scope="module")
def model():
    return train_sb3.train(steps=2048, evaluate_on="poisson:0.15:2", seed=3, **SMALL)


def exporters():
    new = tuple(map(int, torch.__version__.split(".")[:2])) >= (2, 5)
    return ["torchscript", "dynamo"] if new else ["torchscript"]


@pytest.mark.parametrize("exporter", exporters())
def test_the_rust_side_decides_as_the_policy(model, tmp_path, exporter):
    file = tmp_path / "policy.onnx"
    train_sb3.export(model, file, exporter)
    station = pickline.Station("paper")
    for pattern in pickline.patterns("poisson:0.12:4", station, items=40, seed=9):
        ours = train_sb3.evaluate(model, [SortingEnv(station, [pattern], observation="paper")])
        theirs = pickline.simulate(station, pattern, f"onnx:{file}")
        assert ours["picking_rate"] == theirs.picking_rate
        assert ours["picked_share"] == theirs.picked / theirs.items


def test_the_program_writes_a_policy_and_its_curve(tmp_path):
    file = tmp_path / "mine.onnx"
    command = [sys.executable, "-m", "pickline.train_sb3", "--out", str(file), "--steps", "4096"]
    command += ["--patterns", "poisson:0.15:5", "--items", "30", "--evaluate-on", "poisson:0.15:2"]
    command += ["--evaluate-every", "2048", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with file.with_suffix(".csv").open(newline="") as curve:
        rows = list(csv.DictReader(curve))
    assert [int(row["steps"]) for row in rows] == [0, 2048, 4096]
    assert all(0 < float(row["picked_share"]) <= 1 for row in rows)
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
