"""The adapter for Stable-Baselines3; run.sh installs what it needs."""

import gymnasium
import numpy as np
import pytest
import torch
from sb3_contrib import MaskablePPO
from sb3_contrib.common.maskable.evaluation import evaluate_policy
from sb3_contrib.common.maskable.utils import get_action_masks, is_masking_supported
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.vec_env import DummyVecEnv

import pickline
from pickline.sb3 import SortingVecEnv

torch.set_num_threads(1)

SMALL = {"patterns": "poisson:0.2:5", "items": 12}


def test_the_checker_of_sb3_is_content():
    check_env(gymnasium.make("pickline/Sorting-v0", **SMALL).unwrapped)
    check_env(gymnasium.make("pickline/Sorting-v0", observation="paper", wait=True).unwrapped)


def test_it_is_the_vec_env_of_sb3_over_the_gymnasium_environment():
    ours = SortingVecEnv(3, **SMALL)
    theirs = DummyVecEnv([lambda: pickline.SortingEnv(**SMALL)] * 3)
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    ours.seed(5)
    theirs.seed(5)
    assert np.array_equal(ours.reset(), theirs.reset())
    rng = np.random.default_rng(1)
    ends = 0
    for _ in range(80):
        masks = get_action_masks(ours)
        assert np.array_equal(masks, np.stack(theirs.env_method("action_masks")))
        actions = np.where(masks, rng.random(masks.shape), -1.0).argmax(axis=1)
        got, want = ours.step(actions), theirs.step(actions)
        for a, b in zip(got[:3], want[:3], strict=True):
            assert np.array_equal(a, b) and a.dtype == b.dtype
        for a, b, over in zip(got[3], want[3], got[2], strict=True):
            b.pop("action_mask")
            episode = a.pop("episode", None)
            assert (episode is not None) == over
            if over:
                ends += 1
                assert np.array_equal(a.pop("terminal_observation"), b.pop("terminal_observation"))
                assert episode["r"] == pytest.approx(a["weight"] + a["weighted_rate"])
                assert episode["l"] == a["picked"]
            assert a == b
    assert ends > 3
    assert is_masking_supported(ours)


def test_maskable_ppo_learns_on_it():
    # One pattern, on which the order of the picks decides the rate at the end.
    env = SortingVecEnv(4, "paper", "grid:0.15", items=30, observation="paper", reward=(0.0, 1.0))
    model = MaskablePPO("MlpPolicy", env, n_steps=128, batch_size=128, seed=1, verbose=0)
    before, _ = evaluate_policy(model, env, n_eval_episodes=4)
    model.learn(12_000)
    after, _ = evaluate_policy(model, env, n_eval_episodes=4)
    assert after > before * 1.02, (before, after)
    lengths = [episode["l"] for episode in model.ep_info_buffer]
    assert lengths and max(lengths) <= 30


def test_wrong_use_is_an_exception():
    env = SortingVecEnv(2, **SMALL)
    env.reset()
    with pytest.raises(RuntimeError, match="call step_async"):
        env.step_wait()
    with pytest.raises(AttributeError, match="cannot be changed"):
        env.set_attr("station", 1)
    with pytest.raises(AttributeError, match="call action_masks"):
        env.env_method("reset")
    with pytest.raises(ValueError, match="shape"):
        env.step(np.zeros(3, int))
    env.close()
