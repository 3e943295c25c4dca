"""What goes to another process, as multiprocessing sends it: stations, patterns and results."""

import copy
import dataclasses
import multiprocessing
import pickle

import numpy as np
import pytest

import pickline
from pickline import Columns
from test_studies import film

GRID = pickline.Pattern.grid(1.05, 0.15, 20)


def checked(folder):
    picks = folder / "picks.csv"
    picks.write_text(pickline.simulate("paper", GRID).to_csv())
    return pickline.check(picks, "paper", GRID)


def imported(folder):
    file = folder / "film.txt"
    file.write_text(film())
    return pickline.import_mot(file, fps=30, scale=0.001, axis="x", belt_speed=0.1)


RESULTS = {
    "simulate": lambda _: pickline.simulate("paper", GRID, bound=True, grasp_success=0.7),
    "compare": lambda _: pickline.compare(replicates=2, robust="SPT,FIFO", bound=False),
    "sweep": lambda _: pickline.sweep(robust="SPT,FIFO", from_=0.03, to=0.05, step=0.01),
    "robots_down": lambda _: pickline.robots_down(items=30, robust="SPT,FIFO"),
    "optimize": lambda _: pickline.optimize(patterns="grid:0.2", items=20, validate=2, bound=False),
    "bound": lambda _: pickline.bound("paper", GRID, objective="weight"),
    "check": checked,
    "import_mot": imported,
}


def assert_same(found, due, place):
    """Asserts that two results hold the same, to the bit."""
    assert type(found) is type(due), place
    if isinstance(due, np.ndarray):
        assert found.dtype == due.dtype, place
        assert np.array_equal(found, due, equal_nan=due.dtype == np.float64), place
    elif isinstance(due, Columns) or dataclasses.is_dataclass(due):
        for field in dataclasses.fields(due):
            if field.name != "report":
                before, after = getattr(due, field.name), getattr(found, field.name)
                assert_same(after, before, f"{place}.{field.name}")
    elif isinstance(due, dict):
        assert found.keys() == due.keys(), place
        for key in due:
            assert_same(found[key], due[key], f"{place}[{key!r}]")
    elif isinstance(due, float) and np.isnan(due):
        assert np.isnan(found), place
    else:
        assert found == due, place


@pytest.mark.parametrize("name", RESULTS)
def test_results_are_the_same_in_another_process(name, tmp_path):
    result = RESULTS[name](tmp_path)
    copies = [pickle.loads(pickle.dumps(result, protocol)) for protocol in (2, pickle.HIGHEST_PROTOCOL)]
    # Copies of copies, too.
    copies += [pickle.loads(pickle.dumps(copies[0])), copy.copy(result), copy.deepcopy(result)]
    copies.append(copy.deepcopy(copies[0]))
    for other in copies:
        assert_same(other, result, name)
        assert (str(other), repr(other)) == (str(result), repr(result))
        if name == "import_mot":
            assert other.report == result.report
            continue
        assert (other.to_csv(), other.to_json()) == (result.to_csv(), result.to_json())
        assert other._repr_html_() == result._repr_html_()
        for field in dataclasses.fields(result):
            table = getattr(result, field.name)
            if isinstance(table, Columns):
                names = [*table.to_dict()]
                assert [*getattr(other, field.name).to_dict()] == names


@pytest.mark.parametrize("name", ["compare", "bound"])
def test_kept_reports_have_every_form(name, tmp_path):
    report = RESULTS[name](tmp_path).report
    kept = pickle.loads(pickle.dumps(report))
    assert not kept.interrupted
    for form in ("text", "csv", "json", "page"):
        assert getattr(kept, form)() == getattr(report, form)(), form
    ours, theirs = kept.tables(), report.tables()
    assert ours.keys() == theirs.keys()
    for table, columns in theirs.items():
        assert ours[table].keys() == columns.keys()
        for field, (label, values) in columns.items():
            assert ours[table][field][0] == label
            assert_same(ours[table][field][1], values, f"{table}.{field}")


def test_what_an_interrupted_call_has_found_is_kept():
    """Pools hand over exceptions as pickles."""
    partial = pickline.bound("paper", GRID)
    stopped = pickline.Interrupted(partial)
    for again in (pickle.loads(pickle.dumps(stopped)), copy.deepcopy(stopped)):
        assert type(again) is pickline.Interrupted and isinstance(again, KeyboardInterrupt)
        assert again.partial.to_json() == partial.to_json()
        assert str(again) == str(stopped)


def simulated(task):
    station, pattern, strategy = task
    return pickline.simulate(station, pattern, strategy)


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_a_pool_of_processes_works_on_stations_and_patterns(method):
    station = pickline.Station("paper", robots=3, belt_speed=0.06)
    strategies = ["SPT,SPT,FIFO", "FIFO,FIFO,FIFO"]
    with multiprocessing.get_context(method).Pool(2) as pool:
        found = pool.map(simulated, [(station, GRID, strategy) for strategy in strategies])
    for result, strategy in zip(found, strategies, strict=True):
        assert_same(result, pickline.simulate(station, GRID, strategy), strategy)


def test_stations_keep_their_names(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(pickline.Station("delta").to_toml())
    for station in (pickline.Station("paper"), pickline.Station(file)):
        again = pickle.loads(pickle.dumps(station))
        rules = ",".join(["SPT"] * len(station.robots))
        result = pickline.compare(again, replicates=2, robust=rules, bound=False)
        due = pickline.compare(station, replicates=2, robust=rules, bound=False)
        assert result.report.page() == due.report.page() and str(result) == str(due)


LINE = """
[belt]
speed = 0.05
width = 1.0
[line]
robots = 2
first_base_x = 1.2
spacing = 1.4
base_offset = 0.1
bin_offset = 0.0
tail = 0.8
reach = 0.8
speed = 0.5
grasp_time = 0.1
release_time = 0.1
"""


def swept(station):
    """A sweep of robots, which makes the station again with other numbers of them."""
    settings = dict(from_=1, to=3, patterns="poisson:0.2:2", items=30, train_items=20, bound=False)
    return pickline.sweep(station, "robots", **settings).points


@pytest.mark.parametrize("given", ["built-in", "file", "text"])
def test_stations_can_have_other_numbers_of_robots_in_another_process(given, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "mine.toml"
    file.write_text(LINE)
    station = {
        "built-in": lambda: pickline.Station("paper", belt_speed=0.06),
        "file": lambda: pickline.Station("mine.toml", belt_speed=0.06),
        "text": lambda: pickline.Station.from_toml(LINE, belt_speed=0.06),
    }[given]()
    due = swept(station)
    assert set(due.value) == {1.0, 2.0, 3.0}
    sent = pickle.dumps(station)
    # There, the file may not be there, or another one may have the name.
    file.unlink()
    (tmp_path / "paper").write_text(LINE.replace("reach = 0.8", "reach = 0.7"))
    for again in (pickle.loads(sent), pickle.loads(pickle.dumps(pickle.loads(sent))), copy.copy(station)):
        assert again == station and hash(again) == hash(station)
        assert_same(swept(again), due, given)


def test_a_line_of_robots_that_are_listed_has_no_other_numbers_of_them():
    station = pickline.Station.from_toml(pickline.Station("paper").to_toml())
    for line in (station, pickle.loads(pickle.dumps(station))):
        with pytest.raises(ValueError, match=r"\[line\]"):
            swept(line)


def test_environments_say_that_they_are_not_pickled():
    env = pickline.SortingEnv("paper", GRID)
    vector = pickline.SortingVectorEnv(2, "paper", GRID)
    for call in (pickle.dumps, copy.copy, copy.deepcopy):
        for environment in (env, vector):
            with pytest.raises(TypeError, match="cannot be pickled or copied\n  cure: make one"):
                call(environment)
