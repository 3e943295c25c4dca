"""Checks of the values of messages to the node, by the ranges of the protocol.

Each check returns the value in the type that the message has, or raises `BadMessage`. The node tells
nobody but its log which message it has refused, so that values are checked here first.
"""

from __future__ import annotations

import json
import math
import operator
import re
import unicodedata
from collections.abc import Mapping
from enum import StrEnum
from typing import Any

from .errors import BadMessage

LONGEST_NAME = 200
"""Maximum length of a name [characters]."""

LONGEST_DATA = 4096
"""Maximum size of a detection's `data` as JSON [bytes]."""


def shown(value: object) -> str:
    """A value in an error: in one line, not too long, without control characters."""
    text = value if isinstance(value, str) else repr(value)
    text = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text[:80])
    return text


def wrong(kind: str, name: str, problem: str, expected: str) -> BadMessage:
    return BadMessage(f"`{name}` of a {kind}", problem, f"give {expected}")


def check_number(kind: str, name: str, value: object, low: float, high: float, what: str) -> float:
    """A number in the range, as a float. Takes numpy's numbers too."""
    number = None
    if not isinstance(value, (bool, str, bytes)):
        try:
            number = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError, OverflowError):
            number = None
    if number is None:
        raise wrong(kind, name, f"`{shown(value)}` is not a number", what.rstrip(","))
    if not low <= number <= high:
        hint = ""
        if name == "stamp" and 1e12 <= number <= 1e20:
            hint = "; are these milli-, micro- or nanoseconds?"
        raise wrong(kind, name, f"{number!r} is out of range", f"{what} from {low:g} to {high:g}{hint}")
    return number


def check_whole(kind: str, name: str, value: object, most: int = 2**64 - 1) -> int:
    try:
        number = None if isinstance(value, bool) else operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = None
    if number is None or not 0 <= number <= most:
        raise wrong(kind, name, f"`{shown(value)}` is not a whole number", f"a number from 0 to {most}")
    return number


# Direction marks and separators make a text look like another one.
HIDDEN = re.compile("[\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff]")


def check_name(kind: str, name: str, value: object) -> str:
    if not isinstance(value, str):
        raise wrong(kind, name, f"{shown(value)} is not a text", "a text, for example str(value)")
    value = str(value)
    if not value or value.strip() != value:
        problem = f"`{shown(value)}` is empty, or starts or ends with a space"
        raise wrong(kind, name, problem, "a name without leading or trailing spaces")
    if len(value) > LONGEST_NAME:
        problem = f"it has {len(value)} characters"
        raise wrong(kind, name, problem, f"at most {LONGEST_NAME} characters")
    # Surrogates cannot be written as UTF-8.
    if HIDDEN.search(value) or any(unicodedata.category(c) in ("Cc", "Cs") for c in value):
        problem = f"`{shown(value)}` contains line breaks or control characters"
        raise wrong(kind, name, problem, "printable characters only")
    return value


def check_word(kind: str, name: str, value: Any, words: type[StrEnum]) -> Any:
    try:
        return words(value)
    except ValueError:
        known = ", ".join(word.value for word in words)
        raise wrong(kind, name, f"there is no `{shown(value)}`", f"one of {known}") from None


def check_numbers(
    kind: str, name: str, value: object, count: int, low: float, high: float, what: str
) -> tuple[float, ...]:
    try:
        several = tuple(value)  # type: ignore[arg-type, var-annotated]
    except TypeError:
        several = ()
    if len(several) != count or isinstance(value, (str, bytes)):
        raise wrong(kind, name, f"`{shown(value)}` are not {count} numbers", f"{count} numbers, {what.rstrip(',')}")
    return tuple(check_number(kind, name, one, low, high, what) for one in several)


def check_stamp(kind: str, value: object, name: str = "stamp") -> float:
    return check_number(kind, name, value, 0.0, 1e11, "seconds, with the system clock since 1970,")


ANY = (-math.inf, math.inf)


def check_finite(kind: str, name: str, value: object, what: str) -> float:
    number = check_number(kind, name, value, *ANY, what)
    if math.isinf(number):
        raise wrong(kind, name, f"{number!r} is not finite", what)
    return number


def check_data(kind: str, data: object) -> Mapping[str, Any]:
    """A copy of `data` that later changes of the original do not reach."""
    if not isinstance(data, Mapping):
        raise wrong(kind, "data", f"`{shown(data)}` is not a dict", "a dict of what JSON can hold")
    try:
        text = json.dumps(dict(data), allow_nan=False, ensure_ascii=False, separators=(",", ":"))
        length = len(text.encode())
    except (TypeError, ValueError, RecursionError) as error:
        problem = f"cannot be written as JSON: {shown(str(error))}"
        raise wrong(kind, "data", problem, "text, finite numbers, lists and dicts") from None
    if length > LONGEST_DATA:
        problem = f"it has {length} bytes as JSON"
        raise wrong(kind, "data", problem, f"at most {LONGEST_DATA}: it goes into every task")
    copy: dict[str, Any] = json.loads(text)
    return copy
