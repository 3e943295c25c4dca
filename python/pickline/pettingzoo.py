"""The line as a PettingZoo AEC environment, in which every robot is an agent.

Needs the package pettingzoo: ``pip install pettingzoo``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces

from pickline._parts import SlotSpace, Uncopied, missing
from pickline.environment import SortingEnv

try:
    from pettingzoo import AECEnv
    from pettingzoo.utils import wrappers
except ModuleNotFoundError as error:
    raise missing("pettingzoo", error) from error

__all__ = ["SortingAECEnv", "env", "raw_env"]


class SortingAECEnv(Uncopied, AECEnv):
    """Robots along a moving belt pick items; the robot whose decision is due is the agent that acts.

    The process is that of :class:`pickline.environment.SortingEnv`, and so are its arguments, actions,
    seeds and the end of an episode: the same seed and actions give the same picks.

    Agents: the robots by name, upstream first. They act in the order in which they become free, so one
    may act several times in a row, and one that nothing comes within reach of never does.

    Observations: ``{"observation": float32 [n], "action_mask": int8 [actions]}``. Only the robot that
    decides sees something; those of the others are zero and allow nothing.

    Rewards: every robot gets the whole reward of every step, so that what an agent earns is what the
    line earns.

    ``infos`` of every robot has the figures of the episode when it is over.
    """

    metadata = {"name": "sorting_v0", "render_modes": [], "is_parallelizable": False}

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__()
        self._line = SortingEnv(*args, **options)
        self.render_mode = None
        self.possible_agents = self._line.station.robots
        self.agents: list[str] = []
        actions = len(self._line._mask)
        space = spaces.Dict(
            {
                "observation": self._line.observation_space,
                "action_mask": spaces.Box(0, 1, (actions,), np.int8),
            }
        )
        self.observation_spaces = {agent: space for agent in self.possible_agents}
        self.action_spaces = {agent: SlotSpace(self._line._mask) for agent in self.possible_agents}
        # The robot that decides; none when the episode is over.
        self._deciding: str | None = None

    def observation_space(self, agent: str) -> spaces.Dict:
        """The space of the observations of an agent."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> SlotSpace:
        """The space of the actions of an agent."""
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode on a pattern drawn at random. There are no options; others are ignored."""
        observation, info = self._line.reset(seed=seed)
        self.agents = list(self.possible_agents)
        self.rewards = dict.fromkeys(self.agents, 0.0)
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self.terminations = dict.fromkeys(self.agents, False)
        self.truncations = dict.fromkeys(self.agents, False)
        self.infos: dict[str, dict[str, Any]] = {agent: {} for agent in self.agents}
        self._skip_agent_selection = None
        self._see(observation, info["action_mask"])

    def observe(self, agent: str) -> dict[str, Any]:
        """What an agent sees."""
        if agent == self._deciding:
            return {"observation": self._observation.copy(), "action_mask": self._mask.copy()}
        return {
            "observation": np.zeros_like(self._observation),
            "action_mask": np.zeros_like(self._mask),
        }

    def step(self, action: int | np.integer[Any] | None) -> None:
        """Take the decision of the selected agent; None once its episode is over."""
        agent: str = self.agent_selection
        if self.terminations[agent]:
            self._was_dead_step(action)
            return
        if action is None:
            raise TypeError(
                f"action: None, but {agent} has to decide\n  cure: give the index of a slot"
            )
        observation, reward, terminated, _, info = self._line.step(action)
        self._cumulative_rewards[agent] = 0.0
        self.rewards = dict.fromkeys(self.agents, reward)
        mask = info.pop("action_mask")
        if terminated:
            self.terminations = dict.fromkeys(self.agents, True)
            self.infos = {name: dict(info) for name in self.agents}
            self._deciding, self._observation, self._mask = None, observation, mask
        else:
            self._see(observation, mask)
        self._accumulate_rewards()

    def close(self) -> None:
        """End the environment."""
        self._line.close()

    def _see(self, observation: Any, mask: Any) -> None:
        robot = self._line.robot
        assert robot is not None, "an episode that goes on has a robot that decides"
        self._deciding = self.agent_selection = self.possible_agents[robot]
        self._observation, self._mask = observation, mask


def raw_env(*args: Any, **options: Any) -> SortingAECEnv:
    """The environment as it is."""
    return SortingAECEnv(*args, **options)


def env(*args: Any, **options: Any) -> Any:
    """The environment with PettingZoo's check of the order of calls."""
    return wrappers.OrderEnforcingWrapper(raw_env(*args, **options))
