"""Robots that are down, and the shapes of feeds: every figure is that of the program."""

import json

import numpy as np
import pytest

import pickline
from test_studies import assert_same, files, program

OUTAGES = dict(outage=["r2:60..75", "1:20..30"], outages=(120, 8))
WORDS = ["--outage", "r2:60..75", "--outage", "1:20..30", "--outages", "120,8"]


def test_a_run_with_outages_is_that_of_the_program():
    pattern = pickline.Pattern.grid(1.05, 0.15, 50)
    run = pickline.simulate("paper", pattern, "SPT,FIFO", seed=4, **OUTAGES)
    words = ["--strategy", "SPT,FIFO", "--seed", "4", "--no-bound", "--check", *WORDS]
    theirs = json.loads(program("simulate", *words, "--format", "json"))
    ours = json.loads(run.to_json())
    assert ours["picks"] == theirs["picks"] and ours["missed"] == theirs["missed"]
    assert ours["downtimes"] == theirs["downtimes"] and len(ours["downtimes"]) >= 2
    # No decision while a robot is down.
    for robot, begin, end in [(1, 60.0, 75.0), (0, 20.0, 30.0)]:
        decided = run.picks.decide[run.picks.robot == robot]
        assert len(decided) and not ((decided >= begin) & (decided < end)).any()
    plain = pickline.simulate("paper", pattern, "SPT,FIFO", seed=4)
    assert run.picks.decide.tobytes() != plain.picks.decide.tobytes()
    again = pickline.simulate("paper", pattern, "SPT,FIFO", seed=4, **OUTAGES | {"outages": "120,8"})
    assert again.picks.decide.tobytes() == run.picks.decide.tobytes()


def test_a_comparison_with_outages_is_that_of_the_program(tmp_path):
    settings = dict(replicates=3, robust="SPT,FIFO", greedy=False, policy=False, bound=False)
    result = pickline.compare("paper", "dense", **settings, outages=(60, 10))
    words = "--cases dense --replicates 3 --robust SPT,FIFO --no-greedy --no-policy --no-bound".split()
    written = files("compare", *words, "--outages", "60,10", folder=tmp_path)
    assert_same(result.picking_rate, written["picking_rate.csv"])
    assert_same(result.runs, written["runs.csv"])
    command = json.loads(result.to_json())["made"]["command"]
    assert "outages=[60, 10]" in command and "outage=" not in command


def test_a_sweep_with_outages_is_that_of_the_program(tmp_path):
    settings = dict(robust="SPT,FIFO", from_=0.03, to=0.05, step=0.01, bound=False)
    result = pickline.sweep(**settings, outage="r1:5..20")
    words = "--robust SPT,FIFO --from 0.03 --to 0.05 --step 0.01 --no-bound --outage r1:5..20"
    assert_same(result.points, files("sweep", *words.split(), folder=tmp_path)["sweep.csv"])


def test_halted_robots_are_those_of_the_program(tmp_path):
    station = pickline.Station("paper", robots=3)
    result = pickline.robots_down(
        station, "random:4", flow=80, items=60, robust="SPT,SPT,FIFO", strategy="FIFO,FIFO,FIFO"
    )
    words = (
        "--sweep robots-down --robots 3 --patterns random:4 --flow 80 --items 60 --robust SPT,SPT,FIFO "
        "--strategy FIFO,FIFO,FIFO"
    )
    written = files("sweep", *words.split(), folder=tmp_path)
    assert_same(result.points, written["sweep.csv"])
    theirs, ours = json.loads(written["sweep.json"]), json.loads(result.to_json())
    assert ours["points"] == theirs["points"] and result.patterns == theirs["patterns"] == 4
    # Settings are spelled as arguments.
    assert [note.replace("`robust`", "--robust") for note in result.notes] == theirs["notes"]
    assert result.partial is None and "3 robots" in repr(result)
    assert list(dict.fromkeys(result.points.robot_down)) == ["", "r1", "r2", "r3"]
    whole = result.points.robot_down == ""
    assert np.isnan(result.points.loss_percent[whole]).all()
    assert result.points.loss_percent[~whole].max() > 0.0
    assert "robot" in str(result) and "&lt;svg" in result._repr_html_()


FEEDS = [
    ("clustered:60/min:3", dict(cluster_size=8, cluster_spread=0.05)),
    ("gaps:60/min:3", dict(gap_length=2.0, gap_share=0.5)),
]


@pytest.mark.parametrize(("feed", "shape"), FEEDS)
def test_shapes_of_feeds_are_those_of_the_program(feed, shape, tmp_path):
    flags = [word for name, value in shape.items() for word in (f"--{name.replace('_', '-')}", str(value))]
    settings = dict(items=40, robust="SPT,FIFO", from_=0.03, to=0.04, step=0.01, bound=False)
    swept = pickline.sweep(patterns=feed, **settings, **shape)
    words = "--items 40 --robust SPT,FIFO --from 0.03 --to 0.04 --step 0.01 --no-bound".split()
    written = files("sweep", "--patterns", feed, *words, *flags, folder=tmp_path / "sweep")
    assert_same(swept.points, written["sweep.csv"])
    usual = pickline.sweep(patterns=feed, **settings)
    assert usual.points.picking_rate_per_min.tolist() != swept.points.picking_rate_per_min.tolist()
    found = pickline.optimize(patterns=feed, items=40, validate=2, bound=False, **shape)
    words = ["--patterns", feed, "--items", "40", "--validate", "2", "--no-bound", *flags]
    written = files("optimize", *words, folder=tmp_path / "optimize")
    assert_same(found.ranking, written["ranking.csv"])
    # The patterns themselves: `pattern generate` draws the first of them.
    kind = feed.partition(":")[0]
    words = ["--flow", "60", "--count", "40", "--seed", "3", *flags]
    printed = program("pattern", "generate", kind, *words)
    drawn = pickline.patterns(feed, pickline.Station("paper"), items=40, seed=3, **shape)
    assert len(drawn) == 3 and drawn[0] == pickline.Pattern.from_csv_text(printed)


GRID = pickline.Pattern.grid(1.05, 0.15, 20)


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: pickline.simulate("paper", GRID, outage="r2"), ValueError, "`outage`: `r2` is not an outage"),
        (lambda: pickline.simulate("paper", GRID, outage=["r9:1..2"]), ValueError, "the line has no robot"),
        (lambda: pickline.simulate("paper", GRID, outage=[3]), TypeError, "outage: 3 is not a text"),
        (lambda: pickline.simulate("paper", GRID, outages=(0, 20)), ValueError, "`outages`: 0 s is not"),
        (lambda: pickline.simulate("paper", GRID, outages=(1, 2, 3)), TypeError, "is not a pair of times"),
        (lambda: pickline.simulate("paper", GRID, outages="300"), ValueError, "`outages`: `300` is not"),
        (lambda: pickline.optimize(outages=(300, 20)), TypeError, "outages"),
        (lambda: pickline.optimize(misdetections=True), TypeError, "misdetections"),
        (lambda: pickline.bound("paper", GRID, outage="r1:0..5"), TypeError, "outage"),
        (lambda: pickline.sweep(sweep="robots-down"), ValueError, "call pickline.robots_down"),
        (lambda: pickline.robots_down(misdetections=True), ValueError, "misdetections"),
        (lambda: pickline.robots_down(robust="SPT"), ValueError, "1 rule for 2 robots"),
        (lambda: pickline.robots_down(step=1), TypeError, "step"),
        (
            lambda: pickline.sweep(patterns="random:60/min:3", cluster_size=3),
            ValueError,
            "`cluster_size`: applies only to the feed clustered",
        ),
        (
            lambda: pickline.optimize(patterns="gaps:60/min:3", gap_share=1.5),
            ValueError,
            "`gap_share`: 1.5 is not a valid share of the belt",
        ),
        (lambda: pickline.optimize(gap_length="1 m"), TypeError, "feed: "),
        (
            lambda: pickline.patterns("grid:0.2", pickline.Station("paper"), gap_share=0.2),
            ValueError,
            "`gap_share`: applies only to the feed gaps",
        ),
    ],
)
def test_what_is_wrong_is_an_exception_of_its_class(call, kind, words):
    with pytest.raises(kind) as raised:
        call()
    assert words in str(raised.value)
