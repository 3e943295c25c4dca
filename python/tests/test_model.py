"""Stations, patterns and simulation."""

import copy
import json
import pickle
import subprocess
import sys

import numpy as np
import pytest

import pickline


def run(*words):
    """The program of the package with these arguments."""
    command = [sys.executable, "-m", "pickline", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def station():
    return pickline.Station("paper", robots=2)


@pytest.fixture(scope="module")
def grid(station):
    return pickline.Pattern.grid(station, spacing=0.15, items=50)


def test_stations_have_what_their_files_say(station, tmp_path):
    assert station.robots == ["r1", "r2"]
    assert (station.belt_speed, station.belt_width) == (0.05, 1.05)
    assert "paper" in pickline.Station.built_in()
    faster = pickline.Station("paper", robots=3, belt_speed=0.06)
    assert len(faster.robots) == 3 and faster.belt_speed == 0.06
    assert faster != station
    file = tmp_path / "line.toml"
    file.write_text(faster.to_toml())
    again = pickline.Station(file)
    assert again == faster and again.hash == faster.hash and hash(again) == hash(faster)
    assert pickline.Station.from_toml(file.read_text()) == faster


def test_stations_and_patterns_are_copied_and_pickled(station, grid):
    for value in (station, grid, pickline.Station("sorting")):
        assert copy.deepcopy(value) == value
        assert pickle.loads(pickle.dumps(value)) == value


def test_patterns_from_arrays_are_sorted_downstream_first():
    x = np.array([-1.0, 0.0, -2.0], np.float32)
    wide = np.array([[0.1, 9.0], [0.2, 9.0], [0.3, 9.0]])
    pattern = pickline.Pattern(x, wide[:, 0], weight=[None, 2.0, None], item_class=["a", None, "b"])
    assert pattern.x.tolist() == [0.0, -1.0, -2.0]
    assert pattern.y.tolist() == [0.2, 0.1, 0.3]
    assert pattern.reward.tolist() == [2.0, 0.5, 0.5]
    assert pattern.id == ["2", "1", "3"]
    assert pattern.item_class == [None, "a", "b"]
    assert len(pattern) == 3
    assert pickline.Pattern([0, -1], [0, 0]).x.tolist() == [0.0, -1.0]


def test_patterns_are_read_and_generated(station, grid, tmp_path):
    file = tmp_path / "items.csv"
    file.write_text(grid.to_csv())
    assert pickline.Pattern.from_csv(file) == grid
    assert pickline.Pattern.from_csv_text(grid.to_csv()) == grid
    disk = pickline.Pattern.poisson(1.05, 0.2, 29, seed=3)
    assert disk == pickline.Pattern.poisson(station, 0.2, 29, seed=3)
    assert disk != pickline.Pattern.poisson(station, 0.2, 29, seed=4)
    far = (disk.x[:, None] - disk.x) ** 2 + (disk.y[:, None] - disk.y) ** 2
    assert np.sqrt(far[~np.eye(29, dtype=bool)]).min() >= 0.2
    assert len(pickline.Pattern.random(station, flow=60, items=40)) == 40
    sorted_ones = pickline.patterns(
        "random:60/min:2", pickline.Station("sorting"), classes="pet:0.5,wood:0.5"
    )
    assert set(sorted_ones[0].item_class) == {"pet", "wood"}
    two = pickline.patterns("poisson:0.2:2", station, items=30, seed=5)
    assert [len(pattern) for pattern in two] == [30, 30] and two[0] != two[1]
    trials = pickline.trials(station)
    assert [len(patterns) for patterns in trials.values()] == [1, 1, 10, 10, 1, 10, 10, 10]
    # Under the seeds of the curves of `pickline train`.
    third = pickline.Pattern.poisson(station, 0.2, 29, seed=990_002)
    assert trials["poisson 0.2, 29 items"][2] == third
    assert list(pickline.trials(station, "paper")) == list(trials)[:4]


def test_a_run_is_that_of_the_program(station, grid):
    result = pickline.simulate(station, grid, "SPT,FIFO", bound=True)
    assert (result.items, result.picked, len(result.picks)) == (50, 44, 44)
    assert result.missed.tolist() == [36, 37, 38, 44, 45, 46]
    assert len(result.miss_reasons) == 6 and len(result.failures) == 0
    assert result.robot_picked.sum() == 44
    assert result.picks.release.max() <= result.end
    assert result.picks.item.dtype == np.int64 and result.picks.decide.dtype == np.float64
    assert result.bound_picked >= 44 and result.bound_rate >= result.picking_rate
    # The command with the same line and pattern.
    words = "simulate --robots 2 --pattern - --strategy SPT,FIFO --format json --quiet".split()
    printed = subprocess.run(
        [sys.executable, "-m", "pickline", *words],
        input=grid.to_csv(),
        capture_output=True,
        text=True,
        check=True,
    )
    document = json.loads(printed.stdout)
    assert document["picked"] == 44
    assert document["picking_rate_per_min"] == result.picking_rate
    ids = [grid.id[item] for item in result.picks.item]
    columns = (result.picks.robot, ids, result.picks.decide, result.picks.release)
    keys = ("robot", "item", "decide_s", "release_s")
    picks = [tuple(pick[key] for key in keys) for pick in document["picks"]]
    assert picks == list(zip(*columns, strict=True))


def test_grasps_may_fail(station, grid):
    sure = pickline.simulate(station, grid, "SPT,FIFO")
    risky = pickline.simulate(station, grid, "SPT,FIFO", grasp_success=0.5, seed=2)
    assert risky.picked < sure.picked
    assert len(risky.failures) == len(risky.failure_causes) == risky.robot_failed.sum() > 0
    assert set(risky.failure_causes) == {"grasp"}
    again = pickline.simulate(station, grid, "SPT,FIFO", grasp_success=0.5, seed=2)
    assert np.array_equal(again.picks.item, risky.picks.item)


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda s, p: pickline.Station("papr"), ValueError, "did you mean `paper`"),
        (lambda s, p: pickline.Station("none/a.toml"), FileNotFoundError, "check the path"),
        (lambda s, p: pickline.Station("paper", robots=-1), ValueError, "-1 is out of range"),
        (lambda s, p: pickline.Station("paper", robots=1.5), TypeError, "whole number"),
        (lambda s, p: pickline.Station("paper", belt_speed=np.nan), ValueError, "belt"),
        (lambda s, p: pickline.Station.from_toml("a = ["), ValueError, "line"),
        (lambda s, p: pickline.Pattern([], []), ValueError, "no items"),
        (lambda s, p: pickline.Pattern([0.0, np.nan], [0, 0]), ValueError, "NaN"),
        (lambda s, p: pickline.Pattern([1.0], [0]), ValueError, "beyond the start"),
        (lambda s, p: pickline.Pattern(["a"], [0]), TypeError, "dtype"),
        (lambda s, p: pickline.Pattern([1j], [0]), TypeError, "complex128"),
        (lambda s, p: pickline.Pattern([True], [0]), TypeError, "bool"),
        (lambda s, p: pickline.Pattern([[0.0]], [0]), ValueError, "shape [1, 1]"),
        (lambda s, p: pickline.Pattern([[0.0], [1.0, 2.0]], [0]), ValueError, "x: "),
        (lambda s, p: pickline.Pattern([0.0, -1], [0]), ValueError, "1 values for 2 items"),
        (lambda s, p: pickline.Pattern([0], [0], weight=["a"]), TypeError, "weight: "),
        (lambda s, p: pickline.Pattern([0], [0], weight=[-1]), ValueError, "not a valid weight"),
        (lambda s, p: pickline.Pattern([0], [0], id="ab"), TypeError, "a single text"),
        (lambda s, p: pickline.Pattern([0, 0], [0, 0], id=["a", "a"]), ValueError, "already"),
        (lambda s, p: pickline.Pattern.grid(s, 0.15, -1), ValueError, "out of range"),
        (lambda s, p: pickline.Pattern.grid(s, 0.0, 5), ValueError, "`spacing`"),
        (lambda s, p: pickline.Pattern.poisson(s, 0.2, 5, seed=-1), ValueError, "out of range"),
        (lambda s, p: pickline.Pattern.from_csv("none.csv"), FileNotFoundError, "cure: "),
        (lambda s, p: pickline.Pattern.from_csv_text("x,z\n0,0\n"), ValueError, "cure: "),
        (lambda s, p: pickline.patterns("grdi:0.1", s), ValueError, "cure: "),
        (lambda s, p: pickline.trials(s, "papre"), ValueError, "did you mean `paper`"),
        (lambda s, p: pickline.learning_curves([]), ValueError, "there are none"),
        (lambda s, p: pickline.learning_curves([("a", [0, 1], [0.5])]), ValueError, "as many"),
        (lambda s, p: pickline.learning_curves([("a", [0], [np.nan])]), ValueError, "NaN"),
        (lambda s, p: pickline.simulate(s, p, "SPT"), ValueError, "1 rule for 2 robots"),
        (lambda s, p: pickline.simulate(s, p, "SPT,FOFI"), ValueError, "did you mean `FIFO`"),
        (lambda s, p: pickline.simulate(s, p, update_hz=-1.0), ValueError, "`update_hz`"),
        (lambda s, p: pickline.simulate(s, p, grasp_success=2.0), ValueError, "probability"),
        (lambda s, p: pickline.simulate(s, p, grasp_sucess=0.5), TypeError, "grasp_sucess"),
        (lambda s, p: pickline.simulate(s, pickline.Pattern([0], [9.0])), ValueError, "beside"),
    ],
)
def test_what_is_wrong_is_an_exception_of_its_class(station, grid, call, kind, words):
    with pytest.raises(kind) as raised:
        call(station, grid)
    assert words in str(raised.value)


def test_the_program_is_installed():
    version = run("--version")
    assert (version.returncode, version.stdout) == (0, f"pickline {pickline.__version__}\n")
    wrong = run("simulte")
    assert wrong.returncode == 2 and "simulate" in wrong.stderr
    hosted = run("service", "install", "--root", "/nowhere")
    assert hosted.returncode == 2 and "inside another program" in hosted.stderr
