"""Strategies as arguments."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from pickline.strategy import Snapshot, Wait

# A text as after ``--strategy`` of the program, or a callable; ``Any`` stands for numpy's integers.
Strategy = str | Callable[[Snapshot], int | Wait | Any]

# One strategy, or several.
Strategies = Strategy | Iterable[Strategy]


def as_strategies(given: Strategies) -> list[Strategy]:
    """The strategies as a list."""
    return [given] if isinstance(given, str) or callable(given) else list(given)
