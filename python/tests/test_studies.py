"""Comparisons, sweeps, searches, bounds and checks: every figure is that of the program."""

import csv
import io
import json
import subprocess
import sys

import numpy as np
import pytest

import pickline
from pickline import Columns


def program(*words, text=None):
    """What the program of the package prints."""
    command = [sys.executable, "-m", "pickline", *words, "--quiet"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def rows_of(text):
    """The rows of a CSV text by name, as texts."""
    return list(csv.DictReader(line for line in io.StringIO(text) if not line.startswith("#")))


def assert_same(columns: Columns, text):
    """Asserts that a table has the columns of the CSV text, and every figure to the bit."""
    rows = rows_of(text)
    found = columns.to_dict()
    assert rows and list(found) == list(rows[0]), text
    assert len(columns) == len(rows)
    for name, values in found.items():
        given = [row[name] for row in rows]
        if values.dtype == np.float64:
            assert np.array_equal(values, [float(text or "nan") for text in given], equal_nan=True), name
        elif values.dtype == np.bool_:
            assert [str(value).lower() for value in values] == given, name
        else:
            assert values.dtype in (np.int64, np.object_), (name, values.dtype)
            assert [str(value) for value in values] == given, name


def files(verb, *words, folder):
    """Runs a verb that writes its result files to this folder; returns their texts by name."""
    program(verb, *words, "--out", str(folder))
    return {file.name: file.read_text() for file in folder.iterdir()}


@pytest.fixture(scope="module")
def compared():
    return pickline.compare(
        "paper", strategy=["SPT,SPT", "lookahead:depth=2"], replicates=3, robust="SPT,FIFO", seed=5
    )


COMPARE = (
    "--replicates 3 --robust SPT,FIFO --seed 5 --strategy SPT,SPT --strategy lookahead:depth=2".split()
)


def test_a_comparison_is_that_of_the_program(compared, tmp_path):
    written = files("compare", *COMPARE, folder=tmp_path)
    assert_same(compared.picking_rate, written["picking_rate.csv"])
    assert_same(compared.throughput, written["throughput.csv"])
    assert_same(compared.picked_time, written["picked_time.csv"])
    assert_same(compared.runs, written["runs.csv"])
    assert compared.purity is None and compared.classes is None and compared.partial is None
    assert compared.methods[0] == "robust_gt" and len(compared.cases) == 4
    theirs, ours = json.loads(written["compare.json"]), json.loads(compared.to_json())
    assert ours["cases"] == theirs["cases"] and ours["notes"] == compared.notes
    assert "4 cases" in repr(compared) and "picking rate" in str(compared)
    rates = compared.picking_rate
    assert rates.picking_rate_per_min[rates.method == "rules:SPT,SPT"].shape == (4,)
    # Results say which call makes them again.
    call = ours["made"]["command"]
    assert call.startswith("pickline.compare(") and "seed=5" in call and "greedy" not in call
    again = eval(call)
    assert again.to_json() == compared.to_json()


def test_a_comparison_with_what_can_go_wrong_is_that_of_the_program(tmp_path):
    result = pickline.compare(
        "sorting",
        replicates=4,
        robust="SPT,SPT,SPT,SPT",
        greedy=False,
        bound=False,
        classes="pet:0.6,wood:0.4",
        p_detection="beta:8,2",
        misdetections=True,
        grasp_success=0.9,
    )
    words = (
        "--station sorting --replicates 4 --robust SPT,SPT,SPT,SPT --no-greedy --no-bound --misdetections "
        "--classes pet:0.6,wood:0.4 --p-detection beta:8,2 --grasp-success 0.9"
    )
    written = files("compare", *words.split(), folder=tmp_path)
    assert_same(result.purity, written["purity.csv"])
    assert_same(result.classes, written["classes.csv"])
    assert_same(result.runs, written["runs.csv"])
    assert result.runs.rightly_binned.dtype == np.int64
    assert set(result.classes.item_class) >= {"pet", "wood"}
    assert result.classes.names == {"item_class": "class"}


def test_the_tuned_rival_is_that_of_the_program(tmp_path):
    plain = dict(replicates=2, robust="SPT,FIFO", greedy=False, policy=False, bound=False)
    result = pickline.compare(**plain, tune=True, reference="rival")
    words = "--replicates 2 --robust SPT,FIFO --no-greedy --no-policy --no-bound --tune --reference rival"
    written = files("compare", *words.split(), folder=tmp_path)
    assert_same(result.runs, written["runs.csv"])
    assert result.methods == ["rival", "robust_gt"]
    # Other notes spell settings as each of the two calls them.
    assert result.notes[1].startswith("rival is ")
    assert result.notes[1] == json.loads(written["compare.json"])["notes"][1]


def test_a_sweep_is_that_of_the_program(tmp_path):
    result = pickline.sweep(robust="SPT,FIFO", from_=0.03, to=0.06, step=0.01, greedy=True)
    words = "--robust SPT,FIFO --from 0.03 --to 0.06 --step 0.01 --greedy"
    written = files("sweep", *words.split(), folder=tmp_path)
    assert_same(result.points, written["sweep.csv"])
    assert (result.sweep, result.unit, result.patterns) == ("speed", "m/s", 1)
    assert "belt_speed_m_per_s" in result.points.to_dict()
    limits = json.loads(written["sweep.json"])["limits"]
    assert result.limits.method.tolist() == [limit["method"] for limit in limits]
    assert result.limits.highest.tolist() == [limit["highest"] for limit in limits]
    assert "speed over 4 values from 0.03 to 0.06 m/s" in repr(result)


def test_other_quantities_are_swept(tmp_path):
    words = "--sweep robots --from 1 --to 3 --robust SPT --patterns poisson:0.15:3 --no-bound"
    with pytest.raises(ValueError, match="1 rule for 2 robots"):
        pickline.sweep(sweep="robots", from_=1, to=3, robust="SPT", patterns="poisson:0.15:3")
    words = words.replace("--robust SPT ", "--train-patterns grid:0.2 --train-items 30 ")
    station = pickline.Station("paper")
    settings = dict(
        from_=1,
        to=3,
        patterns="poisson:0.15:3",
        bound=False,
        train_patterns="grid:0.2",
        train_items=30,
    )
    result = pickline.sweep(station, "robots", **settings)
    assert_same(result.points, files("sweep", *words.split(), folder=tmp_path)["sweep.csv"])
    assert result.points.value.tolist() == [1.0, 2.0, 3.0]
    assert np.isnan(result.points.added_per_robot_per_min[0])
    chosen = pickline.sweep(
        sweep="min-detection",
        patterns="poisson:0.15:3",
        robust="SPT,SPT",
        step=0.25,
        p_detection="beta:8,2",
        purity=0.8,
        bound=False,
    )
    assert set(chosen.thresholds.patterns) == {"training", "fresh"}
    assert chosen.purity.binned.sum() > 0


OPTIMIZE = "--patterns poisson:0.2:6 --items 40 --validate 5 --strategy SPT,LPT --seed 3"


def test_a_search_is_that_of_the_program(tmp_path):
    result = pickline.optimize(
        patterns="poisson:0.2:6", items=40, validate=5, strategy="SPT,LPT", seed=3
    )
    written = files("optimize", *OPTIMIZE.split(), folder=tmp_path)
    assert_same(result.ranking, written["ranking.csv"])
    assert_same(result.strategies, written["strategies.csv"])
    theirs = json.loads(written["optimize.json"])
    assert result.best == theirs["best"] and result.validation == theirs["validation"]
    assert result.runs == theirs["runs"] and result.unit == "1/min" and result.partial is None
    assert result.ranking.assignment[0] == " ".join(result.best)
    assert result.strategy in repr(result)
    exact = pickline.optimize(
        patterns="poisson:0.2:6", items=40, validate=0, search="exact", seed=3
    )
    assert (result.proof, exact.stop_reason, exact.proof["gap"]) == (None, "proven", 0.0)
    assert exact.proof["most"] == pytest.approx(max(exact.ranking.value))
    pattern = pickline.Pattern.poisson(1.05, 0.2, 29)
    assert pickline.simulate("paper", pattern, result.strategy).picked > 0


def test_a_bound_is_that_of_the_program(tmp_path):
    pattern = pickline.Pattern.poisson(1.05, 0.2, 29, seed=2)
    result = pickline.bound("paper", pattern, objective="weight", iterations=50)
    file = tmp_path / "items.csv"
    file.write_text(pattern.to_csv())
    words = ["--pattern", str(file), "--objective", "weight", "--iterations", "50"]
    written = files("bound", *words, folder=tmp_path / "out")
    assert_same(result.prices, written["prices.csv"])
    theirs = json.loads(written["bound.json"])
    for name in ("picks_upper_bound", "picks_relaxed", "weight_upper_bound", "schedule", "slot_s"):
        assert getattr(result, name) == theirs[name], name
    rates = {row["figure"]: row["value"] for row in rows_of(result.to_csv())}
    rate = result.picking_rate_upper_bound_per_min
    assert float(rates["picking_rate_upper_bound_per_min"]) == rate
    assert result.all_picked in ("yes", "no", "open") and "at most" in repr(result)


def test_picks_are_checked(tmp_path):
    station = pickline.Station("paper")
    pattern = pickline.Pattern.grid(station, 0.15, 50)
    run = pickline.simulate(station, pattern, "SPT,FIFO")
    file = tmp_path / "picks.csv"
    file.write_text(run.to_csv())
    good = pickline.check(file, station, pattern)
    assert good and good.confirmed and good.picks == run.picked and len(good.violations) == 0
    assert good.violations.decide_s.dtype == np.float64
    # One second too early, so that the robot has not come back.
    header, *lines = [line for line in run.to_csv().splitlines() if not line.startswith("#")]
    fields = lines[4].split(",")
    fields[2] = str(float(fields[2]) - 1.0)
    lines[4] = ",".join(fields)
    file.write_text("\n".join([header, *lines]) + "\n")
    bad = pickline.check(file, station, pattern)
    assert not bad and len(bad.violations) >= 1 and "violation" in repr(bad)
    assert bad.violations.line.tolist()[0] == 6
    items = tmp_path / "items.csv"
    items.write_text(pattern.to_csv())
    command = [sys.executable, "-m", "pickline", "check", str(file), "--pattern", str(items)]
    printed = subprocess.run([*command, "--format", "csv"], capture_output=True, text=True)
    assert printed.returncode == 1
    assert_same(bad.violations, printed.stdout)
    assert pickline.check(file, station, pattern, tolerance=2.0)


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: pickline.compare(replicates=0), ValueError, "`replicates`"),
        (lambda: pickline.compare(replicates=-1), ValueError, "out of range"),
        (lambda: pickline.compare(replicates="3"), TypeError, "not a whole number"),
        (lambda: pickline.compare(cases="papr"), ValueError, "did you mean `paper`"),
        (lambda: pickline.compare(cases="none.toml"), FileNotFoundError, "none.toml"),
        (lambda: pickline.compare(reference="best"), ValueError, "`reference`"),
        (lambda: pickline.compare(robust="SPT,SPX"), ValueError, "`robust`"),
        (lambda: pickline.compare(robust="SPT"), ValueError, "1 rule for 2 robots"),
        (lambda: pickline.compare(strategy="SPX,SPT"), ValueError, "SPX"),
        (lambda: pickline.compare(strategy=[3]), TypeError, "strategy: 3 is neither"),
        (lambda: pickline.compare(train_patterns="random:20"), ValueError, "`train_patterns`"),
        (
            lambda: pickline.compare(robust="SPT,SPT", train_patterns="grid:0.2"),
            ValueError,
            "`train_patterns`: there is nothing to train, as `robust` gives the assignment",
        ),
        (lambda: pickline.compare(area="lognormal"), ValueError, "`area` lognormal"),
        (lambda: pickline.compare(progress=3), TypeError, "progress"),
        (lambda: pickline.compare(update_hs=3), TypeError, "update_hs"),
        (lambda: pickline.sweep(sweep="speeed"), ValueError, "did you mean `speed`"),
        (lambda: pickline.sweep(from_=0.05, to=0.04), ValueError, "`"),
        (lambda: pickline.sweep(purity=0.9), ValueError, "`sweep` min-detection"),
        (lambda: pickline.sweep(patterns="gird:0.1"), ValueError, "gird"),
        (lambda: pickline.optimize(objective="rate"), ValueError, "`objective`"),
        (lambda: pickline.optimize(search="grsp"), ValueError, "did you mean `grasp`"),
        (lambda: pickline.optimize(risk="cvar"), ValueError, "risk"),
        (lambda: pickline.optimize(time_limit=0.0), ValueError, "`time_limit`"),
        (lambda: pickline.optimize(alpha=float("nan")), ValueError, "alpha"),
        (lambda: pickline.optimize(starts=1.5), TypeError, "not a whole number"),
        (
            lambda: pickline.bound("paper", pickline.Pattern([0], [0]), objective="time"),
            ValueError,
            "'picks' or 'weight'",
        ),
        (
            lambda: pickline.bound("paper", pickline.Pattern([0], [0]), iterations=0),
            ValueError,
            "`iterations`",
        ),
        (
            lambda: pickline.check("none.csv", "paper", pickline.Pattern([0], [0])),
            FileNotFoundError,
            "none.csv",
        ),
    ],
)
def test_what_is_wrong_is_an_exception_of_its_class(call, kind, words):
    with pytest.raises(kind) as raised:
        call()
    assert words in str(raised.value)


def film(speed=0.1, objects=8, frames=120):
    """Boxes of items that ride on a belt of this speed [m/s], as a tracker writes them."""
    lines = []
    for frame in range(1, frames + 1):
        for track in range(1, objects + 1):
            centre = (frame - 1) / 30 * speed / 0.001 - 90 * track
            if 0 < centre < 1280:
                left, top = centre - 20, 100 + 40 * track
                lines.append(f"{frame},{track},{left},{top},40,40,0.9,{1 + track % 2},1")
    return "\n".join(lines) + "\n"


def test_an_imported_recording_is_that_of_the_program(tmp_path):
    file = tmp_path / "film.txt"
    file.write_text(film())
    settings = dict(fps=30, scale=0.001, axis="x", belt_speed=0.1)
    found = pickline.import_mot(file, class_names={1: "pet", 2: "hdpe"}, **settings)
    words = "--fps 30 --scale 0.001 --axis x --belt-speed 0.1 --class-names 1:pet,2:hdpe"
    printed = program("pattern", "import", "tracks", str(file), *words.split())
    assert found.pattern == pickline.Pattern.from_csv_text(printed)
    assert set(found.pattern.item_class) == {"pet", "hdpe"}
    assert found.report["items"] == len(found.pattern) > 0
    assert found.report["measured_speed"] == pytest.approx(0.1)
    assert str(len(found.pattern)) in str(found) and not found.warnings
    for wrong, words in [
        (dict(belt_speed=0.3), "`belt_speed`"),
        (dict(axis="z"), "`axis`"),
        (dict(boxes="corner"), "did you mean `corners`"),
        (dict(class_names="pet"), "`class_names`"),
        (dict(fps=0), "`fps`"),
    ]:
        with pytest.raises(ValueError, match=words):
            pickline.import_mot(file, **settings | wrong)
