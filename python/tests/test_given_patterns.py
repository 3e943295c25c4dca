"""Studies on patterns that are given: every figure is that of the program on files of them."""

import json

import numpy as np
import pytest

import pickline
from test_studies import assert_same, files

PAPER = pickline.Station("paper")
PATTERNS = pickline.patterns("poisson:0.16:4", PAPER, items=35, seed=3)


@pytest.fixture
def folder(tmp_path):
    """The patterns as files, in their order."""
    place = tmp_path / "patterns"
    place.mkdir()
    for number, pattern in enumerate(PATTERNS, 1):
        (place / f"p{number}.csv").write_text(pattern.to_csv())
    return place


def test_a_search_on_patterns_is_that_of_the_program_on_their_files(folder, tmp_path):
    result = pickline.optimize(PAPER, PATTERNS, strategy="SPT,LPT", seed=3)
    words = ["--patterns", str(folder), "--strategy", "SPT,LPT", "--seed", "3"]
    written = files("optimize", *words, folder=tmp_path / "out")
    ours, theirs = result.ranking.to_dict(), written["ranking.csv"]
    # Labels of patterns are numbers here and names of files there.
    for number in range(1, 5):
        theirs = theirs.replace(f"p{number}.csv", f"pattern {number}")
    assert_same(result.ranking, theirs)
    assert set(ours["worst_pattern"]) <= {f"pattern {number}" for number in range(1, 5)}
    assert_same(result.strategies, written["strategies.csv"])
    assert result.validation is None and json.loads(written["optimize.json"])["validation"] is None
    made = json.loads(result.to_json())["made"]
    assert made["patterns"].startswith("4 given patterns (hash ")
    assert "patterns=<4 patterns>" in made["command"]


def test_a_sweep_on_patterns_is_that_of_the_program_on_their_files(folder, tmp_path):
    settings = dict(robust="SPT,FIFO", from_=0.03, to=0.05, step=0.01, bound=False)
    words = "--robust SPT,FIFO --from 0.03 --to 0.05 --step 0.01 --no-bound".split()
    written = files("sweep", "--patterns", str(folder), *words, folder=tmp_path / "out")
    assert_same(pickline.sweep(PAPER, patterns=PATTERNS, **settings).points, written["sweep.csv"])


def test_cases_of_patterns_are_those_of_the_program_on_their_files(folder, tmp_path):
    result = pickline.compare(
        PAPER, {"first": PATTERNS[0], "third": [PATTERNS[2]]}, robust="SPT,FIFO", strategy="LPT,SD"
    )
    cases = tmp_path / "cases.toml"
    case = '[[case]]\nname = "{}"\npattern = "patterns/p{}.csv"\n'
    cases.write_text(case.format("first", 1) + case.format("third", 3))
    words = ["--cases", str(cases), "--robust", "SPT,FIFO", "--strategy", "LPT,SD"]
    written = files("compare", *words, folder=tmp_path / "out")
    assert result.cases == ["first", "third"]
    assert_same(result.picking_rate, written["picking_rate.csv"])
    assert_same(result.throughput, written["throughput.csv"])
    assert_same(result.runs, written["runs.csv"])


def test_a_list_of_patterns_is_one_case():
    compared = pickline.compare(PAPER, PATTERNS, robust="SPT,FIFO", greedy=False, policy=False)
    assert compared.cases == ["given patterns"]
    runs, rates = compared.runs, compared.picking_rate
    assert rates.patterns.tolist() == [4] and len(runs) == 4
    single = [pickline.simulate(PAPER, pattern, "SPT,FIFO") for pattern in PATTERNS]
    assert runs.picked.tolist() == [run.picked for run in single]
    assert runs.picking_rate_per_min.tolist() == [run.picking_rate for run in single]
    mean = np.mean([run.picking_rate for run in single])
    assert rates.picking_rate_per_min[0] == pytest.approx(mean, rel=1e-12)
    assert rates.picking_rate_low_per_min[0] < mean < rates.picking_rate_high_per_min[0]
    assert "4 given patterns (hash " in json.loads(compared.to_json())["made"]["patterns"]
    one = pickline.compare(PAPER, PATTERNS[1], robust="SPT,FIFO", greedy=False, policy=False)
    assert one.runs.picked.tolist() == [single[1].picked]


def test_every_given_pattern_is_run_when_something_can_go_wrong():
    under = dict(robust="SPT,FIFO", greedy=False, policy=False, bound=False, grasp_success=0.8)
    few = pickline.compare(PAPER, PATTERNS, replicates=2, **under)
    assert len(few.runs) == 4 and len(set(few.runs.pattern_seed)) == 4
    many = pickline.compare(PAPER, PATTERNS, replicates=10, **under)
    assert len(many.runs) == 10
    assert many.runs.picked[:4].tolist() == few.runs.picked.tolist()


def test_greedy_is_found_on_each_given_pattern():
    compared = pickline.compare(PAPER, PATTERNS, robust="SPT,FIFO", policy=False, bound=False)
    assert compared.methods == ["robust_gt", "greedy_gt"]
    rates = {
        name: compared.runs.picking_rate_per_min[compared.runs.method == name] for name in compared.methods
    }
    assert (rates["greedy_gt"] >= rates["robust_gt"]).all()


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: pickline.optimize(PAPER, []), ValueError, "`patterns`: there is no pattern"),
        (lambda: pickline.optimize(PAPER, [3]), TypeError, "patterns: "),
        (lambda: pickline.optimize(PAPER, 3), TypeError, "patterns: "),
        (lambda: pickline.optimize(PAPER, PATTERNS, items=5), ValueError, "`items`: does not apply"),
        (lambda: pickline.optimize(PAPER, PATTERNS, flow=5), ValueError, "`flow`: does not apply"),
        (lambda: pickline.optimize(PAPER, PATTERNS, classes="pet:1"), ValueError, "`classes`: does not apply"),
        (lambda: pickline.compare(PAPER, []), ValueError, "the case `given patterns` has no pattern"),
        (lambda: pickline.compare(PAPER, {}), ValueError, "`cases`: there is no case"),
        (lambda: pickline.compare(PAPER, {"": PATTERNS}), ValueError, "give every case a name"),
        (lambda: pickline.compare(PAPER, {"mine": "dense"}), TypeError, "cases: "),
        (lambda: pickline.compare(PAPER, 3), TypeError, "cases: int is neither"),
        (lambda: pickline.compare(PAPER, PATTERNS, area="const:80"), ValueError, "do not apply to recorded"),
        (
            lambda: pickline.compare(PAPER, pickline.Pattern([-0.1], [9.0]), robust="SPT,FIFO"),
            ValueError,
            "beside the belt",
        ),
    ],
)
def test_what_is_wrong_is_an_exception_of_its_class(call, kind, words):
    with pytest.raises(kind) as raised:
        call()
    assert words in str(raised.value)
