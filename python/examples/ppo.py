"""Masked PPO in one file, to be read and changed: only numpy, torch and the vector environment.

    python ppo.py --steps 200000

The method is proximal policy optimization (Schulman et al., arXiv 1707.06347) with generalized advantage
estimation (Schulman et al., arXiv 1506.02438) and masked actions (Huang and Ontañón, arXiv 2006.14171).
"""

from __future__ import annotations

import argparse
import time

import gymnasium
import numpy as np
import torch
from torch import nn

import pickline  # noqa: F401  (registers the environment)

GAMMA, LAMBDA, CLIP, ENTROPY, VALUE, MOST_GRADIENT = 0.9995, 0.95, 0.2, 0.005, 0.5, 0.5


class Agent(nn.Module):
    """An actor and a critic of two layers each."""

    def __init__(self, inputs: int, actions: int, width: int = 64) -> None:
        super().__init__()

        def network(outputs: int) -> nn.Sequential:
            layers = [nn.Linear(inputs, width), nn.Tanh(), nn.Linear(width, width), nn.Tanh()]
            return nn.Sequential(*layers, nn.Linear(width, outputs))

        self.actor, self.critic = network(actions), network(1)

    def choices(self, observation: torch.Tensor, mask: torch.Tensor) -> torch.distributions.Categorical:
        logits = self.actor(observation).masked_fill(~mask, torch.finfo(torch.float32).min)
        return torch.distributions.Categorical(logits=logits)

    def value(self, observation: torch.Tensor) -> torch.Tensor:
        return self.critic(observation).squeeze(-1)


def advantages(
    rewards: np.ndarray, ended: np.ndarray, values: np.ndarray, last: np.ndarray
) -> np.ndarray:
    """Generalized advantage estimates [steps, environments]; `last` are the values after them."""
    found, running, following = np.zeros_like(rewards), np.zeros_like(last), last
    for step in reversed(range(len(rewards))):
        # The observation after an end is that of another episode.
        goes_on = 1.0 - ended[step]
        error = rewards[step] + GAMMA * goes_on * following - values[step]
        running = error + GAMMA * LAMBDA * goes_on * running
        found[step], following = running, values[step]
    return found


def train(steps: int, envs: int = 32, rollout: int = 64, seed: int = 1) -> tuple[Agent, list[float]]:
    """Trains on the paper's station. Returns the agent and the mean picking rate of the episodes that
    ended in each rollout [1/min]."""
    torch.set_num_threads(1)
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    lines = gymnasium.make_vec(
        "pickline/Sorting-v0",
        num_envs=envs,
        station="paper",
        patterns="poisson:0.12:100",
        # Rates are of the order of 50 per minute.
        reward=(0.05, 0.2),
    )
    (size,), actions = lines.single_observation_space.shape, lines.single_action_space.n
    agent = Agent(size, actions)
    optimizer = torch.optim.Adam(agent.parameters(), lr=1e-3)
    seen = np.zeros((rollout, envs, size), np.float32)
    allowed = np.zeros((rollout, envs, actions), bool)
    taken = np.zeros((rollout, envs), np.int64)
    rewards = np.zeros((rollout, envs), np.float32)
    ended = np.zeros((rollout, envs), np.float32)
    observation, info = lines.reset(seed=seed)
    mask = info["action_mask"].astype(bool)
    curve: list[float] = []
    began = time.monotonic()
    for update in range(max(1, steps // (rollout * envs))):
        rates: list[float] = []
        for step in range(rollout):
            seen[step], allowed[step] = observation, mask
            with torch.no_grad():
                choices = agent.choices(torch.from_numpy(seen[step]), torch.from_numpy(allowed[step]))
            taken[step] = choices.sample().numpy()
            observation, rewards[step], over, _, info = lines.step(taken[step])
            ended[step], mask = over, info["action_mask"].astype(bool)
            if over.any():
                rates += info["final_info"]["picking_rate"][over].tolist()
        batch, masks = torch.from_numpy(seen), torch.from_numpy(allowed)
        actions_taken = torch.from_numpy(taken)
        with torch.no_grad():
            values = agent.value(batch).numpy()
            last = agent.value(torch.from_numpy(np.asarray(observation, np.float32))).numpy()
            before = agent.choices(batch, masks).log_prob(actions_taken)
        gains = advantages(rewards, ended, values, last)
        flat = (batch, masks, actions_taken, before, torch.from_numpy(gains), torch.from_numpy(gains + values))
        flat = tuple(part.flatten(0, 1) for part in flat)
        for _ in range(4):
            for part in np.array_split(rng.permutation(rollout * envs), 4):
                b, m, a, old, gain, target = (each[part] for each in flat)
                choices = agent.choices(b, m)
                ratio = (choices.log_prob(a) - old).exp()
                gain = (gain - gain.mean()) / (gain.std() + 1e-8)
                surrogate = torch.min(ratio * gain, ratio.clamp(1 - CLIP, 1 + CLIP) * gain).mean()
                misfit = (agent.value(b) - target).square().mean()
                loss = VALUE * misfit - surrogate - ENTROPY * choices.entropy().mean()
                optimizer.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(agent.parameters(), MOST_GRADIENT)
                optimizer.step()
        if rates:
            curve.append(float(np.mean(rates)))
        if update % 10 == 0 and curve:
            done = (update + 1) * rollout * envs
            speed = done / (time.monotonic() - began)
            print(f"{done:>9} steps  {curve[-1]:6.2f} picks/min  {speed:7.0f} steps/s", flush=True)
    lines.close()
    return agent, curve


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=200_000, help="decisions to learn from")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    train(chosen.steps, seed=chosen.seed)


if __name__ == "__main__":
    main()
