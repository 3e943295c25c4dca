"""The example in one file; run.sh installs what it needs."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest


@pytest.fixture(scope="module")
def ppo():
    file = Path(__file__).parents[2] / "examples" / "ppo.py"
    spec = importlib.util.spec_from_file_location("ppo", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_it_learns(ppo):
    _, curve = ppo.train(40_960, seed=2)
    assert np.mean(curve[-3:]) > np.mean(curve[:3]) + 1.0, curve
    _, again = ppo.train(2048, seed=2)
    assert again == curve[:1]


def test_advantages_are_discounted_sums_of_errors(ppo):
    rng = np.random.default_rng(1)
    rewards, values = rng.random((5, 2)), rng.random((5, 2))
    last, ended = rng.random(2), np.zeros((5, 2))
    ended[2, 1] = 1.0
    found = ppo.advantages(rewards, ended, values, last)
    following = np.vstack([values[1:], last])
    for line in range(2):
        for step in range(5):
            expected, weight = 0.0, 1.0
            for later in range(step, 5):
                goes_on = 1.0 - ended[later, line]
                error = rewards[later, line] + ppo.GAMMA * goes_on * following[later, line]
                expected += weight * (error - values[later, line])
                weight *= ppo.GAMMA * ppo.LAMBDA * goes_on
            assert found[step, line] == pytest.approx(expected)
