"""Many lines as a Stable-Baselines3 ``VecEnv``, stepped together in Rust threads.

Needs the package stable-baselines3: ``pip install stable-baselines3``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickline._parts import COUNTS, VALUES, Uncopied, missing
from pickline.vector import SortingVectorEnv

try:
    from stable_baselines3.common.vec_env import VecEnv
except ModuleNotFoundError as error:
    raise missing("stable-baselines3 sb3-contrib", error) from error

__all__ = ["SortingVecEnv"]


class SortingVecEnv(Uncopied, VecEnv):
    """``num_envs`` lines for the algorithms of Stable-Baselines3 and sb3-contrib.

    MaskablePPO finds the masks by ``env_method("action_masks")``:

    >>> from sb3_contrib import MaskablePPO
    >>> env = SortingVecEnv(8, "paper", "poisson:0.12:100", observation="paper")
    >>> MaskablePPO("MlpPolicy", env).learn(3_000_000)  # doctest: +SKIP

    After the last step of an episode the observation is the first of the next one. The info of that
    step has ``terminal_observation``, the figures of the episode, and ``episode`` with its return ``r``
    and length ``l``, which the loggers read; it needs no ``VecMonitor``. ``TimeLimit.truncated`` is
    always false.

    The arguments are those of :class:`pickline.vector.SortingVectorEnv`.
    """

    def __init__(self, num_envs: int = 1, *args: Any, **options: Any) -> None:
        self.lines = SortingVectorEnv(num_envs, *args, **options)
        self._returns = np.zeros(num_envs)
        self._lengths = np.zeros(num_envs, np.int64)
        self._actions: NDArray[np.int64] | None = None
        super().__init__(
            num_envs, self.lines.single_observation_space, self.lines.single_action_space
        )

    def reset(self) -> NDArray[np.float32]:
        """Begin an episode in every environment, with the seeds of ``seed`` if it was called."""
        seeds = list(self._seeds)
        given = None if all(seed is None for seed in seeds) else seeds
        observations, _ = self.lines.reset(seed=given)
        self._returns[:] = 0.0
        self._lengths[:] = 0
        self.reset_infos = [{} for _ in range(self.num_envs)]
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: NDArray[np.int64]) -> None:
        """Take these actions at the next ``step_wait``."""
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Step every environment."""
        if self._actions is None:
            raise RuntimeError("step_wait: no actions\n  cure: call step_async before it")
        actions, self._actions = self._actions, None
        observations, rewards, ended, _, told = self.lines.step(actions)
        self._returns += rewards
        self._lengths += 1
        infos: list[dict[str, Any]] = [{"TimeLimit.truncated": False} for _ in range(self.num_envs)]
        for index in np.flatnonzero(ended):
            final, info = told["final_info"], infos[index]
            info.update({name: final[name][index].item() for name in (*COUNTS, *VALUES)})
            info["terminal_observation"] = told["final_obs"][index]
            info["episode"] = {
                "r": float(self._returns[index]),
                "l": int(self._lengths[index]),
            }
        self._returns[ended] = 0.0
        self._lengths[ended] = 0
        return observations, rewards.astype(np.float32), ended, infos

    def close(self) -> None:
        """End the environments."""
        self.lines.close()

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions are allowed now, bool [environments, actions]."""
        return self.lines.action_masks()

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """An attribute of the environments, the same for all of them but for ``action_masks``."""
        chosen = self._chosen(indices)
        if attr_name == "action_masks":
            return [lambda index=index: self.lines.action_masks()[index] for index in chosen]
        return [getattr(self.lines, attr_name) for _ in chosen]

    def set_attr(
        self, attr_name: str, value: Any, indices: int | Iterable[int] | None = None
    ) -> None:
        """Refused: the environments cannot be changed one by one."""
        raise AttributeError(
            f"{attr_name}: environments in Rust cannot be changed\n  cure: make new ones"
        )

    def env_method(
        self,
        method_name: str,
        *args: Any,
        indices: int | Iterable[int] | None = None,
        **options: Any,
    ) -> list[Any]:
        """Call ``action_masks``, the one method that single environments have here."""
        if method_name != "action_masks" or args or options:
            raise AttributeError(
                f"{method_name}: not a method of an environment in Rust\n"
                "  cure: call action_masks without arguments"
            )
        masks = self.lines.action_masks()
        return [masks[index] for index in self._chosen(indices)]

    def env_is_wrapped(
        self, wrapper_class: type[Any], indices: int | Iterable[int] | None = None
    ) -> list[bool]:
        """Whether environments are wrapped: they are not, but they report episodes as Monitor does."""
        monitors = wrapper_class.__name__ == "Monitor"
        return [monitors for _ in self._chosen(indices)]

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """No images; the environments cannot be rendered yet."""
        return [None] * self.num_envs

    def _chosen(self, indices: int | Iterable[int] | None) -> list[int]:
        return list(self._get_indices(indices))
