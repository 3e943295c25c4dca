"""Arguments of calls: errors that name the argument and a cure."""

from __future__ import annotations

import difflib
import functools
import inspect
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

from pickline.conditions import Conditions

P = ParamSpec("P")
R = TypeVar("R")

# What the Rust side adds to an error about an argument of a wrong type.
_NOTE = "while processing '"


def checked(conditions: type[Any] | None = None) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A decorator for a call that takes these conditions besides its own arguments: a misspelled argument,
    and one of a wrong type, is a ``TypeError`` that names it.
    """
    more = list(conditions.__annotations__) if conditions is not None else []

    def decorate(call: Callable[P, R]) -> Callable[P, R]:
        own = [name for name in inspect.signature(call).parameters if name not in ("self", "under")]
        shown = call.__qualname__.removesuffix(".__init__")

        @functools.wraps(call)
        def told(*args: P.args, **given: P.kwargs) -> R:
            for name in given:
                if name not in own and name not in more:
                    raise TypeError(f"{name}: there is no such argument\n  cure: {_cure(name, own + more, shown)}")
            try:
                return call(*args, **given)
            except TypeError as error:
                for note in getattr(error, "__notes__", ()):
                    name = note.removeprefix(_NOTE).removesuffix("'")
                    if note.startswith(_NOTE) and name in own and "\n  cure: " not in str(error):
                        error.args = (f"{name}: {error}\n  cure: see help(pickline.{shown})",)
                raise

        return told

    return decorate


def _cure(name: str, known: list[str], shown: str) -> str:
    if name in Conditions.__annotations__:
        return "leave it out; searches and bounds know neither outages nor what detections truly are"
    near = difflib.get_close_matches(name, known, 1)
    return f"did you mean {near[0]}?" if near else f"see help(pickline.{shown})"
