"""The PettingZoo environment."""

import numpy as np
import pytest
from pettingzoo.test import api_test, seed_test

import pickline
from pickline.pettingzoo import env, raw_env

# What its tests say of robots that do not decide: they see nothing.
pytestmark = [
    pytest.mark.filterwarnings("ignore:.*zeros.*"),
    pytest.mark.filterwarnings("ignore:.*Observation"),
]


@pytest.mark.parametrize("make", [raw_env, env])
@pytest.mark.parametrize("robots", [2, 4])
def test_the_tests_of_pettingzoo_are_content(make, robots, capsys):
    station = pickline.Station("paper", robots=robots)
    api_test(make(station, "poisson:0.15:5"), num_cycles=1000)
    seed_test(lambda: make(station, "poisson:0.15:5"), num_cycles=500)
    assert "Passed" in capsys.readouterr().out


def test_agents_are_the_robots_of_the_gymnasium_environment():
    patterns = pickline.patterns("poisson:0.15:4", pickline.Station(), items=30)
    many, one = raw_env("paper", patterns), pickline.SortingEnv("paper", patterns)
    many.reset(seed=4)
    want, info = one.reset(seed=4)
    total = dict.fromkeys(many.possible_agents, 0.0)
    rng = np.random.default_rng(2)
    over = False
    for agent in many.agent_iter():
        seen, reward, terminated, truncated, told = many.last()
        total[agent] += reward
        assert not truncated
        if terminated:
            assert over and told["picked"] == info["picked"]
            many.step(None)
            continue
        assert agent == many.possible_agents[one.robot]
        assert np.array_equal(seen["observation"], want)
        assert np.array_equal(seen["action_mask"], info["action_mask"])
        other = next(name for name in many.agents if name != agent)
        assert not many.observe(other)["action_mask"].any()
        action = rng.choice(np.flatnonzero(seen["action_mask"]))
        many.step(action)
        want, _, over, _, info = one.step(action)
    assert not many.agents
    assert many._line.picks.item.tolist() == one.picks.item.tolist()
    returns = info["weight"] + info["weighted_rate"]
    assert list(total.values()) == pytest.approx([returns] * 2)
