"""The example with RLlib; run.sh installs what it needs."""

import importlib.util
from pathlib import Path

import gymnasium
import numpy as np
import pytest
import ray
import torch
from ray.rllib.core.columns import Columns
from ray.rllib.core.rl_module import RLModuleSpec

import pickline

torch.set_num_threads(1)

# Two robots, of which each can often choose among several items.
SMALL = dict(station="paper", patterns="poisson:0.15:4", items=15, observation="paper", slots=6)


@pytest.fixture(scope="module")
def example():
    file = Path(__file__).parents[2] / "examples" / "rllib_ppo.py"
    spec = importlib.util.spec_from_file_location("rllib_ppo", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    ray.init(num_cpus=1, include_dashboard=False)
    yield module
    ray.shutdown()


def test_ppo_trains_with_masked_actions(example):
    # A masked action is an exception of the environment, which would end the training.
    algorithm, curve = example.train(example.settings(steps=256, **SMALL), 3)
    assert len(curve) == 3 and np.isfinite(curve).all() and min(curve) > 0.0, curve
    module = algorithm.get_module()
    untrained = example.settings(steps=256, **SMALL).build_algo().get_module()
    changed = [
        not torch.equal(ours, theirs)
        for ours, theirs in zip(module.parameters(), untrained.parameters(), strict=True)
    ]
    assert all(changed), changed
    # The trained network plays whole episodes as it explores.
    env = example.WithMask(gymnasium.make("pickline/Sorting-v0", **SMALL))
    torch.manual_seed(1)
    for seed in range(5):
        observation, _ = env.reset(seed=seed)
        terminated = False
        while not terminated:
            assert env.observation_space.contains(observation)
            batch = {
                name: torch.as_tensor(values)[None] for name, values in observation.items()
            }
            outputs = module.forward_exploration({Columns.OBS: batch})
            choices = module.get_exploration_action_dist_cls().from_logits(
                outputs[Columns.ACTION_DIST_INPUTS]
            )
            action = int(choices.sample())
            observation, _, terminated, _, info = env.step(action)
        assert 0 < info["picked"] <= info["items"] == 15
    algorithm.stop()


def test_no_masked_action_has_a_probability(example):
    env = example.WithMask(pickline.SortingEnv(**SMALL))
    module = RLModuleSpec(
        module_class=example.MaskedModule,
        observation_space=env.observation_space,
        action_space=env.action_space,
    ).build()
    rng = np.random.default_rng(2)
    size = env.observation_space["observation"].shape[0]
    masks = rng.random((200, 6)) < 0.4
    masks[np.arange(200), rng.integers(6, size=200)] = True
    seen = {
        "observation": torch.as_tensor(rng.normal(size=(200, size)), dtype=torch.float32),
        "action_mask": torch.as_tensor(masks.astype(np.int8)),
    }
    for forward in (module.forward_exploration, module.forward_inference, module.forward_train):
        logits = forward({Columns.OBS: dict(seen)})[Columns.ACTION_DIST_INPUTS]
        shares = torch.softmax(logits.detach(), dim=1).numpy()
        assert (shares[~masks] == 0.0).all() and (shares[masks] > 0.0).all()
