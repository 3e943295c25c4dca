"""The environment that the benchmark compares with is the same model."""

import sys
from pathlib import Path

import numpy as np
import pytest

import pickline

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

import throughput  # noqa: E402
from numpy_environment import NumpySortingEnv  # noqa: E402


@pytest.mark.parametrize("robots", [1, 2, 4])
@pytest.mark.parametrize("source", ["poisson:0.1:3", "random:60/min:2"])
def test_both_environments_are_the_same_model(robots, source):
    station = pickline.Station("paper", robots=robots)
    rng = np.random.default_rng(robots)
    for pattern in pickline.patterns(source, station, items=80, seed=4):
        ours = pickline.SortingEnv(station, [pattern], observation="paper")
        theirs = NumpySortingEnv(station, [pattern])
        (seen, told), (expected, known) = ours.reset(seed=1), theirs.reset(seed=1)
        ended, steps = False, 0
        while not ended:
            assert np.array_equal(told["action_mask"], known["action_mask"])
            np.testing.assert_allclose(seen, expected, rtol=1e-5, atol=1e-5)
            action = int(rng.integers(told["action_mask"].sum()))
            seen, reward, ended, _, told = ours.step(action)
            expected, wanted, over, _, known = theirs.step(action)
            assert over == ended and reward == pytest.approx(wanted)
            steps += 1
        assert told["picked"] == known["picked"] == steps > 10
        assert told["picking_rate"] == pytest.approx(known["picking_rate"])


def test_the_benchmark_runs():
    assert min(throughput.rust("paper", 20), throughput.rust("full", 20), throughput.numpy_only(5)) > 0
