"""Messages to the node. Their values are checked and converted when they are made."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from .checks import (
    ANY,
    check_data,
    check_finite,
    check_name,
    check_number,
    check_numbers,
    check_stamp,
    check_whole,
    check_word,
    shown,
    wrong,
)
from .words import Point, RobotState, Role, Verdict

__all__ = [
    "Ack",
    "BeltState",
    "Detection",
    "Hello",
    "Order",
    "Report",
    "RobotStatus",
    "Tick",
    "ToNode",
]


class _Checked:
    """Messages to the node: their values are checked and converted when they are made."""

    if TYPE_CHECKING:

        @property
        def kind(self) -> str: ...

    def _check(self) -> None:
        raise NotImplementedError

    def __post_init__(self) -> None:
        self._check()

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _convert(self, name: str, convert: Any, *arguments: Any) -> None:
        value = getattr(self, name)
        if value is not None:
            self._set(name, convert(self.kind, name, value, *arguments))


@dataclass(frozen=True)
class Detection(_Checked):
    """The camera has seen an item.

    Attributes:
        stamp: When the picture was taken [s].
        x: Position along the travel at the timestamp [m], -250 to 1e6; negative is upstream of the
            belt's start.
        y: Position across the belt [m].
        id: The tracker's id; a detection without one is associated by distance.
        area_cm2: Area seen from above [cm^2].
        p_detection: Probability that this is a real item, 0 to 1.
        p_grasp: Probability that a grasp succeeds, 0 to 1.
        weight: Explicit weight; overrides the weight that follows from the three fields above.
        class_: Class of the item; `class` in the message.
        angle: Angle of its long side, from x towards y [rad], -7 to 7.
        height: Height of its top above the belt [m], 0 to 10.
        size: Length and width [m], 0 to 10.
        data: Any other data for the robot, at most 4,096 bytes as JSON. The node passes it on
            unread.
        covariance: Covariance of the position, `(xx, xy, yy)` [m^2], 0 <= xx, yy <= 0.04; widens
            the gate for matching.
        source: Name of the camera.
    """

    kind: ClassVar[str] = "detection"

    stamp: float
    x: float
    y: float
    id: str | None = None
    area_cm2: float | None = None
    p_detection: float | None = None
    p_grasp: float | None = None
    weight: float | None = None
    class_: str | None = None
    angle: float | None = None
    height: float | None = None
    size: tuple[float, float] | None = None
    data: Mapping[str, Any] | None = None
    covariance: tuple[float, float, float] | None = None
    source: str | None = None

    def _check(self) -> None:
        kind = self.kind
        self._set("stamp", check_stamp(kind, self.stamp))
        self._convert("x", check_number, -250.0, 1e6, "a position [m]")
        self._convert("y", check_number, -1e6, 1e6, "a position [m]")
        if self.x is None or self.y is None:
            raise wrong(kind, "x` and `y", "one is missing", "both [m]")
        for name in ("id", "class_", "source"):
            self._convert(name, check_name)
        self._convert("area_cm2", check_number, 0.0, 1e6, "an area [cm^2]")
        self._convert("weight", check_number, 0.0, 1e12, "a weight")
        for name in ("p_detection", "p_grasp"):
            self._convert(name, check_number, 0.0, 1.0, "a probability")
        self._convert("angle", check_number, -7.0, 7.0, "an angle [rad]")
        self._convert("height", check_number, 0.0, 10.0, "a height [m]")
        self._convert("size", check_numbers, 2, 0.0, 10.0, "lengths [m]")
        self._convert("covariance", check_numbers, 3, *ANY, "[xx, xy, yy] [m^2],")
        if self.covariance is not None:
            xx, xy, yy = self.covariance
            if not (0.0 <= xx <= 0.04 and 0.0 <= yy <= 0.04 and xy * xy <= xx * yy):
                expected = "(xx, xy, yy) [m^2] with 0 <= xx, yy <= 0.04 and xy^2 <= xx yy"
                raise wrong(kind, "covariance", f"{self.covariance} is not a covariance", expected)
        if self.data is not None:
            self._set("data", check_data(kind, self.data))


@dataclass(frozen=True)
class BeltState(_Checked):
    """How the belt moves.

    Attributes:
        stamp: Timestamp [s].
        speed: Speed along +x [m/s], -10 to 10; 0 is a stop, negative is backwards.
        position: Travel of the belt by the encoder, from any zero [m].
        source: Name of the encoder.
    """

    kind: ClassVar[str] = "belt"

    stamp: float
    speed: float
    position: float | None = None
    source: str | None = None

    def _check(self) -> None:
        self._set("stamp", check_stamp(self.kind, self.stamp))
        self._set("speed", check_number(self.kind, "speed", self.speed, -10.0, 10.0, "a belt speed [m/s]"))
        self._convert("position", check_number, -1e12, 1e12, "a belt position [m]")
        self._convert("source", check_name)


@dataclass(frozen=True)
class RobotStatus(_Checked):
    """What a robot is doing.

    Attributes:
        stamp: Timestamp [s].
        name: Its name in the station file.
        state: Its state.
        available_at: When it can set out next [s]; if omitted, with `idle` the timestamp, with
            `busy` unknown.
        task: Id of the last task that it has received. It shows whether an `idle` was sent before
            or after that task.
    """

    kind: ClassVar[str] = "robot"

    stamp: float
    name: str
    state: RobotState
    available_at: float | None = None
    task: int | None = None

    def _check(self) -> None:
        self._set("stamp", check_stamp(self.kind, self.stamp))
        self._set("name", check_name(self.kind, "name", self.name))
        self._set("state", check_word(self.kind, "state", self.state, RobotState))
        self._convert("available_at", check_finite, "a timestamp [s]")
        self._convert("task", check_whole)


@dataclass(frozen=True)
class Ack(_Checked):
    """The robot has understood a task and sets out.

    Attributes:
        stamp: Timestamp [s].
        task: Id of the task.
    """

    kind: ClassVar[str] = "ack"

    stamp: float
    task: int

    def _check(self) -> None:
        self._set("stamp", check_stamp(self.kind, self.stamp))
        self._set("task", check_whole(self.kind, "task", self.task))


@dataclass(frozen=True)
class Report(_Checked):
    """The result of a task; `kind` is `result`.

    Attributes:
        stamp: Timestamp of the result [s].
        task: Id of the task.
        result: The result.
        available_at: When the robot can set out next [s]; the timestamp if omitted.
        found: Where the item would have been at the task's `meet_at` if it had stayed on the belt,
            according to the robot [m].
    """

    kind: ClassVar[str] = "result"

    stamp: float
    task: int
    result: Verdict
    available_at: float | None = None
    found: Point | None = None

    def _check(self) -> None:
        self._set("stamp", check_stamp(self.kind, self.stamp))
        self._set("task", check_whole(self.kind, "task", self.task))
        self._set("result", check_word(self.kind, "result", self.result, Verdict))
        self._convert("available_at", check_finite, "a timestamp [s]")
        if self.found is not None:
            found = self.found
            place = (found.x, found.y) if isinstance(found, Point) else found
            x, y = check_numbers(self.kind, "found", place, 2, *ANY, "(x, y) [m],")
            if math.isinf(x) or math.isinf(y):
                raise wrong(self.kind, "found", f"({x}, {y}) is not finite", "(x, y) [m]")
            self._set("found", Point(x, y))


@dataclass(frozen=True)
class Order(_Checked):
    """An order of the operator. `kind` is `pause` (no new task is given), `resume`, `drain` (known
    items are picked, later ones pass) or `stop` (open tasks are cancelled too).

    Attributes:
        kind: The order.
        stamp: Timestamp [s].
        robot: Name of the robot; the whole line if omitted.
    """

    KINDS: ClassVar[tuple[str, ...]] = ("pause", "resume", "drain", "stop")

    kind: str
    stamp: float
    robot: str | None = None

    def _check(self) -> None:
        if self.kind not in self.KINDS:
            known = ", ".join(self.KINDS)
            raise wrong("order", "kind", f"there is no `{shown(self.kind)}`", f"one of {known}")
        self._set("stamp", check_stamp(self.kind, self.stamp))
        self._convert("robot", check_name)


@dataclass(frozen=True)
class Tick(_Checked):
    """Time has come this far. With `--clock messages` the node decides what is due up to this time
    and answers with `due`.

    Attributes:
        stamp: Timestamp [s].
    """

    kind: ClassVar[str] = "tick"

    stamp: float

    def _check(self) -> None:
        self._set("stamp", check_stamp(self.kind, self.stamp))


@dataclass(frozen=True)
class Hello(_Checked):
    """The identity of a peer: the first line that it sends over TCP.

    Attributes:
        name: Its name, for remarks and as a source.
        role: Its role.
        robots: The robots that it speaks for, by their names in the station file; with the role
            `robot` only.
        token: The shared token, if the node requires one.
        stamp: Timestamp [s]; ignored by the node.
    """

    kind: ClassVar[str] = "hello"

    name: str
    role: Role
    robots: tuple[str, ...] = ()
    token: str | None = field(default=None, repr=False)
    stamp: float | None = None

    def _check(self) -> None:
        kind = self.kind
        self._set("name", check_name(kind, "name", self.name))
        self._set("role", check_word(kind, "role", self.role, Role))
        if isinstance(self.robots, str):
            raise wrong(kind, "robots", "is one text", "a list of names")
        self._set("robots", tuple(check_name(kind, "robots", robot) for robot in self.robots))
        if (self.role is Role.ROBOT) != bool(self.robots):
            expected = "the robots that a peer with the role `robot` speaks for, and none otherwise"
            raise wrong(kind, "robots", f"{list(self.robots)} with the role `{self.role}`", expected)
        if self.token is not None and not isinstance(self.token, str):
            raise wrong(kind, "token", "it is not a text", "the text in the node's token file")
        if self.stamp is not None:
            self._set("stamp", check_stamp(kind, self.stamp))


ToNode = Detection | BeltState | RobotStatus | Ack | Report | Order | Tick | Hello
"""A message to the node."""
