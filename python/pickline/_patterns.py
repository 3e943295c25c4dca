"""Patterns as arguments of studies."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping

from pickline._pickline import Pattern

# A source as after ``--patterns`` of the program, or the patterns themselves.
Patterns = str | os.PathLike[str] | Pattern | Iterable[Pattern]

# Names or a file as after ``--cases``, or the patterns of one case or of several, by their names.
Cases = Patterns | Mapping[str, Pattern | Iterable[Pattern]]


def as_given(patterns: Patterns, name: str = "patterns") -> str | list[Pattern]:
    """The source as text, or the patterns as a list; ``name`` is the argument."""
    if isinstance(patterns, Pattern):
        return [patterns]
    if isinstance(patterns, str | os.PathLike):
        return os.fspath(patterns)
    cure = "give a text such as grid:0.15, a Pattern, or a list of them"
    try:
        given = list(patterns)
    except TypeError:
        raise TypeError(
            f"{name}: {type(patterns).__name__} is neither a source of patterns nor patterns\n"
            f"  cure: {cure}"
        ) from None
    for one in given:
        if not isinstance(one, Pattern):
            raise TypeError(f"{name}: {type(one).__name__} is not a pattern\n  cure: {cure}")
    return given


def as_cases(cases: Cases) -> str | list[tuple[str, str | list[Pattern]]]:
    """The name of the cases, or the patterns of each by its name."""
    if isinstance(cases, Mapping):
        return [(name, as_given(patterns, f"cases {name!r}")) for name, patterns in cases.items()]
    given = as_given(cases, "cases")
    return given if isinstance(given, str) else [("given patterns", given)]
