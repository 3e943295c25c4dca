"""What both environments are made of."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import Any, Literal

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from pickline import _pickline
from pickline._patterns import as_given
from pickline._pickline import Pattern, Station
from pickline._pickline import patterns as patterns_of
from pickline.conditions import Conditions, conditions
from pickline.simulation import as_station

# The paper's reward: (weight of r at its pick, weight of the weighted rate at the end).
PAPER_REWARD = (1.0, 1.0)

ObservationName = Literal["full", "paper", "real"]

# Names of the figures of an episode, as in the buffers of the vector environment.
COUNTS = ("items", "picked")
VALUES = ("weight", "end", "picking_rate", "weighted_rate")


class SlotSpace(spaces.Discrete):
    """The slots, of which only those that hold an item can be sampled.

    Without a mask, ``sample`` draws among the actions that the environment allows now.
    """

    def __init__(self, mask: NDArray[np.bool_]) -> None:
        super().__init__(len(mask))
        self._mask = mask

    def sample(self, mask: Any = None, probability: Any = None) -> Any:
        """Draw an allowed action."""
        if mask is None and probability is None and self._mask.any():
            mask = self._mask.astype(np.int8)
        return super().sample(mask, probability)


class SlotsSpace(spaces.MultiDiscrete):
    """The slots of many environments; see :class:`SlotSpace`."""

    def __init__(self, masks: NDArray[np.bool_]) -> None:
        super().__init__(np.full(len(masks), masks.shape[1]))
        self._masks = masks

    def sample(self, mask: Any = None, probability: Any = None) -> Any:
        """Draw an allowed action in every environment."""
        if mask is None and probability is None and self._masks.any(axis=1).all():
            mask = tuple(self._masks.astype(np.int8))
        return super().sample(mask, probability)


def as_patterns(
    patterns: Pattern | Iterable[Pattern] | str, station: Station, items: int, seed: int
) -> list[Pattern]:
    """The patterns themselves, or those of a source."""
    given = as_given(patterns)
    if isinstance(given, str):
        return patterns_of(given, station, items=items, seed=seed)
    return given


def as_slots(slots: int | None, observation: str) -> int:
    """The number of slots, or the usual one of an observation."""
    if slots is None:
        return 10 if observation == "paper" else 16
    return slots


def as_reward(reward: Any) -> tuple[float, float]:
    """The two weights of a reward; lists are those of datasets, which keep arguments as JSON."""
    try:
        pick, rate = (float(weight) for weight in reward)
    except (TypeError, ValueError):
        raise TypeError(
            f"reward: {reward!r} is not two numbers\n"
            "  cure: give the weights of a pick and of the rate at the end, such as (1.0, 1.0)"
        ) from None
    return pick, rate


def missing(packages: str, error: ModuleNotFoundError) -> ModuleNotFoundError:
    """The error for one of ``packages`` that is missing."""
    return ModuleNotFoundError(f"{error}\n  cure: pip install {packages}", name=error.name)


class Uncopied:
    """An environment: a copy would share its state, and steps of one would be those of the other."""

    def __copy__(self) -> Any:
        raise TypeError(
            "an environment cannot be pickled or copied\n  cure: make one where it is stepped, from the same "
            "arguments; stations, patterns and results can be pickled"
        )


def make_batch(
    station: Station | str | os.PathLike[str],
    patterns: Pattern | Iterable[Pattern] | str,
    *,
    count: int,
    items: int,
    pattern_seed: int,
    observation: str,
    slots: int | None,
    wait: bool,
    reward: tuple[float, float] | list[float],
    under: Conditions,
) -> tuple[Station, Sequence[Pattern], _pickline.Batch]:
    """The environments in Rust."""
    station = as_station(station)
    patterns = as_patterns(patterns, station, items, pattern_seed)
    if not isinstance(observation, str):
        raise TypeError(
            f"observation: {observation!r} is not a text\n  cure: give 'full', 'paper' or 'real'"
        )
    slots = as_slots(slots, observation)
    if not isinstance(wait, bool | np.bool_):
        raise TypeError(f"wait: {wait!r} is not a bool\n  cure: give True or False")
    reward = as_reward(reward)
    batch = _pickline.Batch(
        station, patterns, conditions(**under), observation, slots, bool(wait), reward, count
    )
    return station, patterns, batch


def observation_space(batch: _pickline.Batch) -> Any:
    """The space of one observation."""
    low, high = batch.bounds()
    return spaces.Box(low, high, dtype=np.float32)


def rust_seed(seed: int) -> int:
    """The seed of the episodes: Rust has 64 bits."""
    return seed % 2**64
