"""The messages of the live protocol, version 1.

Units are SI. Positions are in the belt frame: x along the travel, y across, origin on the centre
line at the belt's start. Timestamps are in seconds on the clock that all peers share, with the
system clock seconds since 1970.

Messages to the node are checked when they are made, by the rules of the node, because the node tells
nobody but its log which message it has refused. Of messages from the node, fields that this version
does not know are kept in `extra`, because a newer node may send more.
"""

from __future__ import annotations

import json
import math
import types
import typing
from collections.abc import Mapping
from dataclasses import MISSING, fields
from enum import StrEnum
from functools import cache
from typing import Any, Union

from .checks import shown
from .errors import BadReply
from .incoming import Ack, BeltState, Detection, Hello, Order, Report, RobotStatus, Tick, ToNode
from .outgoing import (
    Answer,
    BeltRequest,
    Cancel,
    Due,
    FromNode,
    Latency,
    MissedCounts,
    RobotReport,
    SourceReport,
    Status,
    Task,
)
from .words import Point, RobotState, Role, SourceKind, Verdict

__all__ = [
    "FROM_NODE",
    "TO_NODE",
    "VERSION",
    "Ack",
    "Answer",
    "BeltRequest",
    "BeltState",
    "Cancel",
    "Detection",
    "Due",
    "FromNode",
    "Hello",
    "Latency",
    "MissedCounts",
    "Order",
    "Point",
    "Report",
    "RobotReport",
    "RobotState",
    "RobotStatus",
    "Role",
    "SourceKind",
    "SourceReport",
    "Status",
    "Task",
    "Tick",
    "ToNode",
    "Verdict",
    "decode",
    "encode",
]

VERSION = 1
"""Version of the protocol."""

LONGEST_LINE = 64 * 1024
"""The node refuses longer lines [bytes]."""

TO_NODE: Mapping[str, type] = {
    "detection": Detection,
    "belt": BeltState,
    "robot": RobotStatus,
    "ack": Ack,
    "result": Report,
    **dict.fromkeys(Order.KINDS, Order),
    "tick": Tick,
    "hello": Hello,
}
"""The class of each kind of message to the node."""

FROM_NODE: Mapping[str, type] = {
    cls.kind: cls for cls in (Task, Cancel, BeltRequest, Status, Due, Answer)
}
"""The class of each kind of message from the node."""


def wire_name(attribute: str) -> str:
    """The field of an attribute: `class` is a keyword of Python."""
    return "class" if attribute == "class_" else attribute


def encode(message: ToNode) -> bytes:
    """A message as one line, without its line ending. Numbers keep every bit."""
    values: dict[str, Any] = {"v": VERSION, "kind": message.kind}
    for one in fields(message):
        value = getattr(message, one.name)
        if value is None or value == () or one.name == "kind":
            continue
        if isinstance(value, Point):
            value = {"x": value.x, "y": value.y}
        elif isinstance(value, StrEnum):
            value = value.value
        values[wire_name(one.name)] = value
    text = json.dumps(values, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    return text.encode()


def decode(line: bytes | str, place: str = "the node") -> FromNode | None:
    """The message from the node in a line, or none if its kind is of a newer node.

    Unknown fields are kept in `extra`.

    Raises:
        BadReply: The line is not a message of this version of the protocol.
    """

    def bad(problem: str) -> BadReply:
        return BadReply(place, problem, "check that what sends there is `pickline run`")

    try:
        values = json.loads(line if isinstance(line, str) else line.decode())
    except (ValueError, RecursionError) as error:
        begin = line[:40] if isinstance(line, str) else line[:40].decode(errors="replace")
        problem = f"what it sends is not JSON ({shown(str(error))}); it begins with `{shown(begin)}`"
        raise bad(problem) from None
    if not isinstance(values, dict):
        raise bad(f"it sends `{shown(values)}` instead of an object")
    version = values.pop("v", VERSION)
    if version != VERSION or isinstance(version, bool):
        raise BadReply(
            place,
            f"it speaks version {shown(version)} of the protocol, not {VERSION}",
            "install the version of this package that belongs to the node",
        )
    kind = values.pop("kind", None)
    if not isinstance(kind, str):
        raise bad("it sends an object without `kind`")
    cls = FROM_NODE.get(kind)
    if cls is None:
        return None
    try:
        message: FromNode = _make(cls, values)
        return message
    except _Bad as error:
        raise bad(f"its `{kind}` has a wrong field: {error}") from None


class _Bad(Exception):
    pass


@cache
def _plan(cls: type) -> tuple[tuple[str, str, bool, Any], ...]:
    """Of each field its attribute, its name in JSON, whether it is required, and its type."""
    hints = typing.get_type_hints(cls)
    return tuple(
        (
            one.name,
            wire_name(one.name),
            one.default is MISSING and one.default_factory is MISSING,
            hints[one.name],
        )
        for one in fields(cls)
        if one.name != "extra"
    )


def _make(cls: type, values: dict[str, Any]) -> Any:
    found: dict[str, Any] = {}
    for attribute, name, required, wanted in _plan(cls):
        if name in values:
            value = values.pop(name)
            if value is None and not required:
                continue
            found[attribute] = _convert(value, wanted, name)
        elif required:
            raise _Bad(f"`{name}` is missing")
    if "extra" in cls.__dataclass_fields__:  # type: ignore[attr-defined]
        found["extra"] = values
    return cls(**found)


def _convert(value: Any, wanted: Any, name: str) -> Any:
    """A value of JSON as the type that a field has."""
    origin, arguments = typing.get_origin(wanted), typing.get_args(wanted)
    if origin in (Union, types.UnionType):
        (wanted,) = (one for one in arguments if one is not type(None))
        return _convert(value, wanted, name)
    if wanted is float and isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if math.isfinite(number):
            return number
    elif wanted is int and isinstance(value, int) and not isinstance(value, bool) and value >= 0:
        return value
    elif wanted in (str, bool) and isinstance(value, wanted):
        return value
    elif origin is tuple and isinstance(value, list):
        if arguments[1:] == (...,):
            return tuple(_convert(one, arguments[0], name) for one in value)
        if len(value) == len(arguments):
            return tuple(_convert(*pair, name) for pair in zip(value, arguments, strict=True))
    elif origin is Mapping and isinstance(value, dict):
        if arguments[1] is Any:
            return value
        return {key: _convert(one, arguments[1], name) for key, one in value.items()}
    elif isinstance(wanted, type) and hasattr(wanted, "__dataclass_fields__") and isinstance(value, dict):
        return _make(wanted, dict(value))
    raise _Bad(f"`{name}` is `{shown(value)}`")
