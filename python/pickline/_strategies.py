"""Strategies as arguments."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pickline.strategy import Snapshot, Wait

# A text as after ``--strategy`` of the program, or a callable; ``Any`` stands for numpy's integers.
Strategy = str | Callable[[Snapshot], int | Wait | Any]

# One strategy, or several.
Strategies = Strategy | Iterable[Strategy]


def as_strategies(given: Strategies) -> list[Strategy]:
    """The strategies as a list."""
    if isinstance(given, str) or callable(given):
        return [given]
    try:
        if isinstance(given, bytes | Mapping):
            raise TypeError
        return list(given)
    except TypeError:
        raise TypeError(
            f"strategy: {given!r} is not a strategy\n  cure: give a text such as 'SPT,FIFO', a function, or a "
            "list of them"
        ) from None
