"""Records one minibatch update of Stable-Baselines3's MaskablePPO for tests/learning/sb3.rs.

Runs the real `MaskablePPO.train()` on a rollout buffer filled with random numbers and
writes what went in and came out to update.json. Needed only to record again:

    apt-get install python3-torch            # Debian 12: torch 1.13.1
    python3 -m venv --system-site-packages venv
    venv/bin/pip install --no-deps stable-baselines3==2.4.1 sb3-contrib==2.4.0 \
        gymnasium==0.29.1 cloudpickle==3.0.0 farama-notifications==0.0.4
    venv/bin/pip install 'numpy<1.25' 'pandas<2.1' 'matplotlib<3.8'
    venv/bin/python tests/sb3/record.py
"""

import json
import pathlib

import gymnasium
import numpy as np
import torch
from sb3_contrib import MaskablePPO

OBSERVATION, ACTIONS, SAMPLES, HIDDEN = 6, 4, 32, [5, 5]


class Nothing(gymnasium.Env):
    """An environment of the right shape; the samples do not come from it."""

    observation_space = gymnasium.spaces.Box(-10, 10, (OBSERVATION,))
    action_space = gymnasium.spaces.Discrete(ACTIONS)

    def reset(self, seed=None, options=None):
        return np.zeros(OBSERVATION, np.float32), {}

    def step(self, action):
        return np.zeros(OBSERVATION, np.float32), 0.0, True, False, {}

    def action_masks(self):
        return np.ones(ACTIONS, bool)


def weights(policy):
    """Both towers, layer by layer: torch's weight [outputs, inputs] and bias."""
    extractor = policy.mlp_extractor
    towers = {
        "policy": [*extractor.policy_net, policy.action_net],
        "value": [*extractor.value_net, policy.value_net],
    }
    return {
        name: [
            {"weight": layer.weight.tolist(), "bias": layer.bias.tolist()}
            for layer in tower
            if isinstance(layer, torch.nn.Linear)
        ]
        for name, tower in towers.items()
    }


def main():
    torch.set_num_threads(1)
    settings = dict(
        learning_rate=3e-4, n_steps=SAMPLES, batch_size=SAMPLES, n_epochs=1,
        gamma=0.9995, gae_lambda=0.95, clip_range=0.2, ent_coef=0.01, vf_coef=0.5,
        max_grad_norm=0.5,
    )
    model = MaskablePPO(
        "MlpPolicy", Nothing(), seed=1, policy_kwargs={"net_arch": HIDDEN}, **settings
    )
    model._setup_learn(SAMPLES)
    rng = np.random.default_rng(1)
    # Fresh weights give nearly equal probabilities; these do not.
    with torch.no_grad():
        for parameter in model.policy.parameters():
            parameter += torch.tensor(rng.normal(0, 0.3, parameter.shape), dtype=torch.float32)
    buffer = model.rollout_buffer
    buffer.reset()
    observations = rng.normal(size=(SAMPLES, 1, OBSERVATION)).astype(np.float32)
    masks = rng.random((SAMPLES, 1, ACTIONS)) < 0.6
    for row in range(SAMPLES):
        masks[row, 0, row % ACTIONS] = True
    starts = rng.random((SAMPLES, 1)) < 0.2
    last_done = np.array([False])
    for row in range(SAMPLES):
        observation = torch.tensor(observations[row])
        with torch.no_grad():
            action, value, log_probability = model.policy(observation, action_masks=masks[row])
        # Off the policy, so that some ratios are clipped.
        log_probability = log_probability + float(rng.normal(0, 0.3))
        buffer.add(
            observations[row], action.numpy(), rng.normal(size=1), starts[row],
            value, log_probability, action_masks=masks[row],
        )
    after = torch.tensor([0.7])
    buffer.compute_returns_and_advantage(last_values=after, dones=last_done)
    record = {
        "made_by": "tests/sb3/record.py: stable-baselines3 2.4.1, sb3-contrib 2.4.0, "
        f"torch {torch.__version__}",
        "settings": settings,
        "hidden": HIDDEN,
        "observations": observations[:, 0].tolist(),
        "masks": masks[:, 0].tolist(),
        "actions": buffer.actions[:, 0, 0].astype(int).tolist(),
        "log_probabilities": buffer.log_probs[:, 0].tolist(),
        "values": buffer.values[:, 0].tolist(),
        "rewards": buffer.rewards[:, 0].tolist(),
        "episode_starts": buffer.episode_starts[:, 0].astype(bool).tolist(),
        "last_value": 0.7,
        "advantages": buffer.advantages[:, 0].tolist(),
        "returns": buffer.returns[:, 0].tolist(),
        "before": weights(model.policy),
    }
    model.train()
    logged = model.logger.name_to_value
    record["terms"] = {
        "policy": logged["train/policy_gradient_loss"],
        "value": logged["train/value_loss"],
        "entropy": -logged["train/entropy_loss"],
        "divergence": logged["train/approx_kl"],
        "clipped": logged["train/clip_fraction"],
        "loss": logged["train/loss"],
    }
    record["after"] = weights(model.policy)
    path = pathlib.Path(__file__).with_name("update.json")
    path.write_text(json.dumps(record, default=float) + "\n")
    print(record["terms"])


if __name__ == "__main__":
    main()
