"""PPO of RLlib with masked actions, to be read and changed.

    python rllib_ppo.py --iterations 50

RLlib knows no masks by itself, so the environment puts them into its observations, and the network gives
actions that are not allowed a probability of 0. Needs ``pip install 'ray[rllib]' torch``.
"""

from __future__ import annotations

import argparse
from typing import Any

import gymnasium
import numpy as np
import ray
import torch
from gymnasium import spaces
from ray.rllib.algorithms.ppo import PPO, PPOConfig
from ray.rllib.algorithms.ppo.torch.default_ppo_torch_rl_module import DefaultPPOTorchRLModule
from ray.rllib.core.columns import Columns
from ray.rllib.core.rl_module import RLModuleSpec
from ray.tune.registry import register_env

import pickline  # noqa: F401  (registers the environment)

LOWEST = torch.finfo(torch.float32).min


class WithMask(gymnasium.Wrapper):
    """The environment with its mask in every observation."""

    def __init__(self, env: gymnasium.Env) -> None:
        super().__init__(env)
        mask = spaces.Box(0, 1, (int(env.action_space.n),), np.int8)
        self.observation_space = spaces.Dict(observation=env.observation_space, action_mask=mask)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        observation, info = self.env.reset(seed=seed, options=options)
        return self._masked(observation, info), info

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        observation, reward, terminated, truncated, info = self.env.step(action)
        return self._masked(observation, info), float(reward), terminated, truncated, info

    def _masked(self, observation: Any, info: dict[str, Any]) -> dict[str, Any]:
        return {"observation": observation, "action_mask": info["action_mask"]}


class MaskedModule(DefaultPPOTorchRLModule):
    """The usual network of PPO on the observation, with logits of masked actions that are never drawn."""

    def __init__(self, *args: Any, observation_space: Any = None, **options: Any) -> None:
        super().__init__(*args, observation_space=observation_space["observation"], **options)

    def _forward(self, batch: dict[str, Any], **options: Any) -> dict[str, Any]:
        return self._masked(super()._forward(self._seen(batch), **options), batch)

    def _forward_train(self, batch: dict[str, Any], **options: Any) -> dict[str, Any]:
        return self._masked(super()._forward_train(self._seen(batch), **options), batch)

    def compute_values(self, batch: dict[str, Any], embeddings: Any = None) -> torch.Tensor:
        return super().compute_values(self._seen(batch), embeddings)

    def _seen(self, batch: dict[str, Any]) -> dict[str, Any]:
        """The batch as the network takes it."""
        return {**batch, Columns.OBS: batch[Columns.OBS]["observation"]}

    def _masked(self, outputs: dict[str, Any], batch: dict[str, Any]) -> dict[str, Any]:
        allowed = batch[Columns.OBS]["action_mask"] > 0
        logits = outputs[Columns.ACTION_DIST_INPUTS]
        return {**outputs, Columns.ACTION_DIST_INPUTS: logits.masked_fill(~allowed, LOWEST)}


def settings(seed: int = 1, steps: int = 2048, **line: Any) -> PPOConfig:
    """PPO on a line with these arguments of the environment, `steps` decisions an iteration."""
    register_env("masked-sorting", lambda given: WithMask(gymnasium.make("pickline/Sorting-v0", **given)))
    return (
        PPOConfig()
        .environment("masked-sorting", env_config=line)
        # In this process, because a process of its own costs more than these small networks.
        .env_runners(num_env_runners=0, num_envs_per_env_runner=8)
        .learners(num_learners=0)
        .rl_module(rl_module_spec=RLModuleSpec(module_class=MaskedModule))
        .training(
            gamma=0.9995,
            lambda_=0.95,
            lr=3e-4,
            entropy_coeff=0.005,
            train_batch_size_per_learner=steps,
            minibatch_size=256,
            num_epochs=4,
        )
        .debugging(seed=seed)
    )


def train(config: PPOConfig, iterations: int) -> tuple[PPO, list[float]]:
    """Trains; returns the algorithm and the mean return of the episodes of each iteration."""
    algorithm = config.build_algo()
    curve = []
    for iteration in range(iterations):
        found = algorithm.train()["env_runners"]
        curve.append(float(found["episode_return_mean"]))
        print(f"{iteration + 1}: mean return {curve[-1]:.2f}")
    return algorithm, curve


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--iterations", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    torch.set_num_threads(1)
    ray.init(num_cpus=1, include_dashboard=False)
    algorithm, _ = train(settings(given.seed, observation="paper"), given.iterations)
    algorithm.stop()


if __name__ == "__main__":
    main()
