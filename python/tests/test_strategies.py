"""Strategies that are Python callables."""

import doctest
import threading

import numpy as np
import pytest

import pickline
from pickline import Snapshot, Wait

STATION = pickline.Station("paper")
PATTERN = pickline.Pattern.grid(STATION, 0.15, 50)


def shortest(snapshot):
    """The rule SPT: the item that is in its bin first, on a tie the one further downstream."""
    return snapshot.processing_time.argmin()


def downstream(snapshot):
    """The rule that takes the first item."""
    return 0


def test_a_callable_decides_as_the_rule_that_it_is():
    mine = pickline.simulate(STATION, PATTERN, shortest, bound=True)
    rules = pickline.simulate(STATION, PATTERN, "SPT,SPT")
    assert mine.strategy == "shortest"
    for name, values in rules.picks.to_dict().items():
        assert np.array_equal(getattr(mine.picks, name), values), name
    assert mine.bound_picked >= mine.picked
    assert "strategy=shortest, bound=True)" in mine.to_json()


def test_a_snapshot_is_the_line_at_the_decision():
    seen = []

    def look(snapshot):
        seen.append(snapshot)
        return downstream(snapshot)

    run = pickline.simulate(STATION, PATTERN, look)
    assert len(seen) == run.picked
    for snapshot, robot, item, decide, release, x, y in zip(
        seen,
        run.picks.robot,
        run.picks.item,
        run.picks.decide,
        run.picks.release,
        PATTERN.x[run.picks.item],
        PATTERN.y[run.picks.item],
        strict=True,
    ):
        assert isinstance(snapshot, Snapshot)
        assert (snapshot.robot, snapshot.item[0], snapshot.time) == (robot, item, decide)
        assert snapshot.x[0] == pytest.approx(x + STATION.belt_speed * decide)
        assert snapshot.y[0] == y and snapshot.reward[0] == PATTERN.reward[item]
        assert decide + snapshot.processing_time[0] == pytest.approx(release)
        assert snapshot.open[0] <= decide <= snapshot.close[0]
        assert len(snapshot.free_at) == 2 and snapshot.free_at[robot] <= decide
        assert item in snapshot.view_item and set(snapshot.item) <= set(snapshot.view_item)
        assert len(snapshot.view_x) == len(snapshot.view_item) == len(snapshot.view_reward)


def test_waiting_is_an_answer():
    class Patient:
        """Lets every second candidate pass for a second."""

        def __init__(self):
            self.calls = 0

        def __call__(self, snapshot):
            self.calls += 1
            return Wait(snapshot.time + 1.0) if self.calls % 2 else np.int64(0)

    patient = Patient()
    run = pickline.simulate(STATION, PATTERN, patient)
    assert run.strategy == "Patient" and 0 < run.picked < patient.calls
    idle = pickline.simulate(STATION, PATTERN, lambda snapshot: Wait())
    assert idle.picked == 0 and idle.strategy == "<lambda>"


def test_a_callable_is_compared_with_rules():
    threads = set()

    def noted(snapshot):
        threads.add(threading.get_ident())
        return shortest(snapshot)

    settings = dict(replicates=10, robust="SPT,FIFO", greedy=False, policy=False, bound=False)
    compared = pickline.compare(strategy=["rules:SPT,SPT", noted], **settings)
    rates = compared.picking_rate
    mine = rates.picking_rate_per_min[rates.method == "noted"]
    assert np.array_equal(mine, rates.picking_rate_per_min[rates.method == "rules:SPT,SPT"])
    assert threads and pickline.compare(strategy=shortest, **settings).methods[-1] == "shortest"
    swept = pickline.sweep(
        strategy=shortest, robust="SPT,SPT", from_=0.04, to=0.06, step=0.01, bound=False
    )
    points = swept.points
    is_mine = points.method == "shortest"
    assert np.array_equal(points.picked_share[is_mine], points.picked_share[~is_mine])
    found = pickline.optimize(
        patterns="poisson:0.2:3", items=30, validate=3, strategy=shortest, bound=False
    )
    assert "shortest" in found.strategies.strategy.tolist()


def test_a_callable_may_simulate_too():
    """A planner of one's own tries rules; all threads may be in such callables at once."""
    line = pickline.Station("paper")
    patterns = [pickline.Pattern.poisson(line, 0.15, 12, seed=seed) for seed in range(6)]

    def planner(snapshot):
        tried = pickline.compare(
            line, patterns[:3], robust="SPT,FIFO", greedy=False, policy=False, bound=False, strategy=lambda _: 0
        )
        assert len(tried.runs) == 6
        return 0 if pickline.simulate(line, patterns[0], "SPT,FIFO", bound=True).picked else Wait()

    settings = dict(robust="FIFO,FIFO", greedy=False, policy=False, bound=False)
    compared = pickline.compare(line, patterns, strategy=planner, **settings)
    rates = compared.picking_rate.picking_rate_per_min
    assert rates[0] == rates[1] > 0


def test_names_of_other_methods_are_refused():
    def rival(snapshot):
        return 0

    settings = dict(cases=PATTERN, robust="SPT,FIFO", greedy=False, policy=False, bound=False)
    with pytest.raises(ValueError, match="`rival` is the name of another method\n  cure: "):
        pickline.compare(strategy=rival, **settings)
    with pytest.raises(ValueError, match="`rules:SPT,SPT` is given twice\n  cure: "):
        pickline.compare(strategy=["SPT,SPT", "rules:SPT,SPT"], **settings)


def test_functions_of_one_name_are_numbered_and_texts_are_given_once():
    settings = dict(cases=PATTERN, robust="SPT,FIFO", greedy=False, policy=False, bound=False)
    compared = pickline.compare(strategy=[lambda _: 0, shortest, lambda _: Wait()], **settings)
    assert compared.methods == ["robust_gt", "<lambda>", "shortest", "<lambda> 2"]
    assert compared.picking_rate.picking_rate_per_min[3] == 0 < compared.picking_rate.picking_rate_per_min[1]
    with pytest.raises(ValueError, match="`strategy`: `SPT,SPT` is given twice\n  cure: "):
        pickline.compare(strategy=["SPT,SPT", "SPT,SPT"], **settings)


class Trouble(Exception):
    """Something that only this test raises."""


def troubled(snapshot):
    """Fails in the middle of the run."""
    if snapshot.time > 20:
        raise Trouble(f"at {snapshot.robot}")
    return 0


def test_what_a_callable_raises_comes_out_as_itself():
    with pytest.raises(Trouble, match="at "):
        pickline.simulate(STATION, PATTERN, troubled)
    with pytest.raises(Trouble, match="at "):
        pickline.compare(strategy=troubled, replicates=20, robust="SPT,SPT", bound=False)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (lambda s: len(s.item), "it picks candidate"),
        (lambda s: -1, "it answers -1, which is neither"),
        (lambda s: None, "it answers None, which is neither"),
        (lambda s: True, "it answers True, which is neither"),
        (lambda s: 0.0, "it answers 0.0, which is neither"),
        (lambda s: "0", "it answers '0', which is neither"),
        (lambda s: Wait(s.time), "it waits until"),
        (lambda s: Wait(float("nan")), "it waits until NaN s, which is not later"),
    ],
)
def test_a_wrong_action_is_a_value_error_that_names_it(answer, words):
    with pytest.raises(ValueError) as raised:
        pickline.simulate(STATION, PATTERN, answer)
    assert words in str(raised.value) and "robot `r" in str(raised.value)


def test_other_things_are_no_strategies():
    with pytest.raises(TypeError, match="strategy: 3 is neither a text nor callable"):
        pickline.simulate(STATION, PATTERN, 3)
    with pytest.raises(TypeError, match="neither a text nor callable"):
        pickline.compare(strategy=["SPT,SPT", 3])
    with pytest.raises(TypeError):
        pickline.simulate(STATION, PATTERN, lambda snapshot: Wait("now"))


def test_the_example_of_the_module_runs():
    result = doctest.testmod(pickline.strategy)
    assert result.attempted >= 4 and result.failed == 0
