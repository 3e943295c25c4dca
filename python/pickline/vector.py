"""Many lines, stepped together in Rust threads."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable, Sequence
from typing import Any, Unpack

import gymnasium
import numpy as np
from gymnasium import error
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from pickline._arguments import checked
from pickline._parts import (
    COUNTS,
    PAPER_REWARD,
    VALUES,
    ObservationName,
    SlotSpace,
    SlotsSpace,
    Uncopied,
    make_batch,
    observation_space,
    rust_seed,
)
from pickline._pickline import Pattern, Station
from pickline.conditions import Conditions

__all__ = ["SortingVectorEnv"]

_INTEGERS = "iu"
# The names of what says which rows of final infos count.
_FLAGS = ("_action_mask", *(f"_{name}" for name in (*COUNTS, *VALUES)))


class SortingVectorEnv(Uncopied, gymnasium.vector.VectorEnv):
    """``num_envs`` environments as :class:`pickline.environment.SortingEnv`, stepped in Rust threads.

    A step releases the GIL and allocates nothing in Rust. Autoreset is ``SAME_STEP``: the observation
    of a step that ends an episode is the first of the next one; ``infos["final_obs"]`` has the last one
    (zero, because nobody decides then) and ``infos["final_info"]`` the figures of the episode. Apart
    from their speed, environments and infos are those of ``gymnasium.vector.SyncVectorEnv`` with the
    same mode.

    ``reset(seed=s)`` gives environment i the seed s + i, as all vector environments of Gymnasium. No
    result depends on the number of threads, which ``RAYON_NUM_THREADS`` sets. A masked action in any
    environment is a ``ValueError`` and changes nothing in any of them.

    Args:
        num_envs: Number of environments, at least 1.
        copy: Whether arrays are new at every step. If not, the next step overwrites observations,
            rewards and masks.

    The other arguments are those of :class:`pickline.environment.SortingEnv`.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.SAME_STEP}

    @checked(Conditions)
    def __init__(
        self,
        num_envs: int = 1,
        station: Station | str | os.PathLike[str] = "paper",
        patterns: Pattern | Iterable[Pattern] | str = "poisson:0.12:100",
        *,
        items: int = 50,
        pattern_seed: int = 1,
        observation: ObservationName = "full",
        slots: int | None = None,
        wait: bool = False,
        reward: tuple[float, float] = PAPER_REWARD,
        copy: bool = True,
        render_mode: str | None = None,
        **under: Unpack[Conditions],
    ) -> None:
        try:
            num_envs = operator.index(num_envs)
        except TypeError:
            raise TypeError(f"num_envs: {num_envs!r} is not an integer\n  cure: give one") from None
        if render_mode is not None:
            raise ValueError(f"render_mode: {render_mode!r} is not available\n  cure: leave it out")
        super().__init__()
        self.num_envs = num_envs
        self.render_mode = None
        self.copy = copy
        self.station, self.patterns, self._batch = make_batch(
            station,
            patterns,
            count=num_envs,
            items=items,
            pattern_seed=pattern_seed,
            observation=observation,
            slots=slots,
            wait=wait,
            reward=reward,
            under=under,
        )
        self._observations = np.zeros((num_envs, self._batch.observation_size), np.float32)
        self._masks = np.zeros((num_envs, self._batch.actions), np.bool_)
        self._rewards = np.zeros(num_envs, np.float64)
        self._ended = np.zeros(num_envs, np.bool_)
        self._counts = np.zeros((num_envs, len(COUNTS)), np.int64)
        self._values = np.zeros((num_envs, len(VALUES)), np.float64)
        self._written = (
            self._observations,
            self._masks,
            self._rewards,
            self._ended,
            self._counts,
            self._values,
        )
        # A copy takes less time than a new array.
        self._never = np.zeros(num_envs, np.bool_)
        self._always = np.ones(num_envs, np.bool_)
        self._begun = False
        self.single_observation_space = observation_space(self._batch)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.single_action_space = SlotSpace(self._masks[0])
        self.action_space = SlotsSpace(self._masks)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode in every environment, or in those of ``options["reset_mask"]``."""
        self._check_open("reset")
        chosen = self._reset_mask(options)
        if isinstance(seed, int | np.integer):
            seeds: list[int | None] = [int(seed) + i for i in range(self.num_envs)]
        elif seed is not None:
            seeds = self._seeds(seed)
        elif not self._begun:
            seeds = [int(s) for s in self.np_random.integers(2**63, size=self.num_envs)]
        else:
            seeds = [None] * self.num_envs
        if len(seeds) != self.num_envs:
            raise ValueError(
                f"seed: {len(seeds)} seeds\n  cure: give {self.num_envs}, or one number"
            )
        least = min((own for own in seeds if own is not None), default=0)
        if least < 0:
            raise ValueError(f"seed: {least} is negative\n  cure: give 0 or more")
        for index, own in enumerate(seeds):
            if own is not None and (chosen is None or chosen[index]):
                self._batch.reseed(index, rust_seed(own))
        self._batch.reset(self._observations, self._masks, chosen)
        self._begun = True
        self._rewards[:] = 0.0
        self._ended[:] = False
        return self._out(self._observations), self._infos(chosen)

    def step(
        self, actions: ArrayLike
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        dict[str, Any],
    ]:
        """Take one decision in every environment."""
        self._check_open("step")
        if not self._begun:
            raise error.ResetNeeded(
                "step: no episode has begun\n  cure: call reset before the first step"
            )
        some_ended = self._batch.step(self._actions(actions), self._written)
        infos = self._infos(None)
        if some_ended:
            self._add_final(infos)
        ended = self._out(self._ended)
        never = self._never.copy()
        return self._out(self._observations), self._out(self._rewards), ended, never, infos

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions are allowed now, bool [environments, actions]."""
        self._check_open("action_masks")
        if not self._begun:
            raise error.ResetNeeded("action_masks: no episode has begun\n  cure: call reset before it")
        return self._masks.copy()

    def _actions(self, actions: ArrayLike) -> NDArray[np.int64]:
        given = np.asarray(actions)
        if given.dtype.kind not in _INTEGERS:
            raise TypeError(
                f"actions: an array of dtype {given.dtype}\n  cure: give an array of integers"
            )
        if given.shape != (self.num_envs,):
            raise ValueError(
                f"actions: an array of shape {given.shape}\n  cure: give one of shape "
                f"({self.num_envs},), an action for every environment"
            )
        return np.ascontiguousarray(given, np.int64)

    @staticmethod
    def _seeds(given: Sequence[int | None]) -> list[int | None]:
        try:
            return [None if own is None else operator.index(own) for own in given]
        except TypeError:
            raise TypeError(
                f"seed: {given!r} is neither a number nor a list of them\n"
                "  cure: give an integer, or one for every environment"
            ) from None

    def _reset_mask(self, options: dict[str, Any] | None) -> NDArray[np.bool_] | None:
        if options is not None and not isinstance(options, dict):
            raise TypeError(
                f"options: {options!r} is not a dict\n  cure: give {{'reset_mask': mask}} or none"
            )
        unknown = sorted(set(options or {}) - {"reset_mask"}, key=str)
        if unknown:
            raise ValueError(
                f"options: unknown option {unknown[0]!r}\n  cure: give 'reset_mask' or none"
            )
        chosen = (options or {}).get("reset_mask")
        if chosen is None:
            return None
        if not isinstance(chosen, np.ndarray) or chosen.dtype != np.bool_:
            raise TypeError("options['reset_mask']: not an array of bool\n  cure: give one")
        if chosen.shape != (self.num_envs,) or not chosen.any():
            raise ValueError(
                f"options['reset_mask']: shape {chosen.shape}, {int(chosen.sum())} chosen\n"
                f"  cure: give shape ({self.num_envs},) with at least one True"
            )
        if not self._begun and not chosen.all():
            raise error.ResetNeeded(
                "options['reset_mask']: no episode has begun\n  cure: reset all of them first"
            )
        return chosen

    def _out(self, array: NDArray[Any]) -> NDArray[Any]:
        return array.copy() if self.copy else array

    def _infos(self, chosen: NDArray[np.bool_] | None) -> dict[str, Any]:
        masks = self._out(self._masks).view(np.int8)
        if chosen is None:
            return {"action_mask": masks, "_action_mask": self._always.copy()}
        masks = np.where(chosen[:, None], masks, np.int8(0))
        return {"action_mask": masks, "_action_mask": chosen.copy()}

    def _add_final(self, infos: dict[str, Any]) -> None:
        """Add the last observations and infos of the episodes that are over."""
        over = self._ended.copy()
        last = np.empty(self.num_envs, object)
        for index in over.nonzero()[0].tolist():
            last[index] = np.zeros(self._batch.observation_size, np.float32)
        # Rows of episodes that go on are zero.
        counts, values = self._counts.copy(), self._values.copy()
        final: dict[str, Any] = {"action_mask": np.zeros(self._masks.shape, np.int8)}
        for column, name in enumerate(COUNTS):
            final[name] = counts[:, column]
        for column, name in enumerate(VALUES):
            final[name] = values[:, column]
        final |= dict.fromkeys(_FLAGS, over)
        infos["final_obs"], infos["_final_obs"] = last, over
        infos["final_info"], infos["_final_info"] = final, over

    def _check_open(self, what: str) -> None:
        if self.closed:
            raise error.ClosedEnvironmentError(
                f"{what}: the environment is closed\n  cure: make a new one"
            )
