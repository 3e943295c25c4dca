"""The messages of the live protocol, version 1.

Units are SI. Positions are in the belt frame: x along the travel, y across, origin on the centre
line at the belt's start. Timestamps are in seconds on the clock that all peers share, with the
system clock seconds since 1970.

Messages to the node are checked before they are sent (`check`), by the rules of the node, because
the node tells nobody but its log which message it has refused. Of messages from the node, fields
that this version does not know are kept in `extra`, because a newer node may send more.
"""

from __future__ import annotations

import json
import math
import operator
import re
import types
import typing
import unicodedata
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from enum import StrEnum
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, Union

from .errors import BadMessage, BadReply

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

LONGEST_NAME = 200
"""Maximum length of a name [characters]."""

LONGEST_DATA = 4096
"""Maximum size of a detection's `data` as JSON [bytes]."""


class Role(StrEnum):
    """The role of a peer."""

    CAMERA = "camera"
    ENCODER = "encoder"
    ROBOT = "robot"
    OPERATOR = "operator"
    OBSERVER = "observer"


class RobotState(StrEnum):
    """The state of a robot: it waits at its bin and takes tasks; it is busy; it is out of service
    until it reports another state."""

    IDLE = "idle"
    BUSY = "busy"
    FAULT = "fault"


class Verdict(StrEnum):
    """The result of a task.

    `PICKED`: the item is in the bin. `GRASP_FAIL`: the grasp failed, the item is still on the belt.
    `MISSED`: the robot came too late or did not find the item. `REJECTED`: the robot refuses the
    task, and the item is not offered to it again. `CANCELLED`: the robot has dropped the task,
    because of a `cancel` or for its own reasons.
    """

    PICKED = "PICKED"
    GRASP_FAIL = "GRASP_FAIL"
    MISSED = "MISSED"
    REJECTED = "REJECTED"
    CANCELLED = "CANCELLED"


class SourceKind(StrEnum):
    """The kind of a source of messages."""

    CAMERA = "camera"
    BELT = "belt"
    ROBOT = "robot"


# Checks of values, by the ranges of the protocol.


def shown(value: object) -> str:
    """A value in an error: in one line, not too long, without control characters."""
    text = value if isinstance(value, str) else repr(value)
    text = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text[:80])
    return text


def _wrong(kind: str, name: str, problem: str, expected: str) -> BadMessage:
    return BadMessage(f"`{name}` of a {kind}", problem, f"give {expected}")


def _number(kind: str, name: str, value: object, low: float, high: float, what: str) -> float:
    """A number in the range, as a float. Takes numpy's numbers too."""
    number = None
    if not isinstance(value, (bool, str, bytes)):
        try:
            number = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError, OverflowError):
            number = None
    if number is None:
        raise _wrong(kind, name, f"`{shown(value)}` is not a number", what)
    if not low <= number <= high:
        hint = ""
        if name == "stamp" and 1e12 <= number <= 1e20:
            hint = "; are these milli-, micro- or nanoseconds?"
        raise _wrong(kind, name, f"{number!r} is out of range", f"{what} from {low:g} to {high:g}{hint}")
    return number


def _whole(kind: str, name: str, value: object, most: int = 2**64 - 1) -> int:
    try:
        number = None if isinstance(value, bool) else operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = None
    if number is None or not 0 <= number <= most:
        raise _wrong(kind, name, f"`{shown(value)}` is not a whole number", f"a number from 0 to {most}")
    return number


# Direction marks and separators make a text look like another one.
_HIDDEN = re.compile("[\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff]")


def _name(kind: str, name: str, value: object) -> str:
    if not isinstance(value, str):
        raise _wrong(kind, name, f"{shown(value)} is not a text", "a text, for example str(value)")
    value = str(value)
    if not value or value.strip() != value:
        problem = f"`{shown(value)}` is empty, or starts or ends with a space"
        raise _wrong(kind, name, problem, "a name without leading or trailing spaces")
    if len(value) > LONGEST_NAME:
        problem = f"it has {len(value)} characters"
        raise _wrong(kind, name, problem, f"at most {LONGEST_NAME} characters")
    # Surrogates cannot be written as UTF-8.
    if _HIDDEN.search(value) or any(unicodedata.category(c) in ("Cc", "Cs") for c in value):
        problem = f"`{shown(value)}` contains line breaks or control characters"
        raise _wrong(kind, name, problem, "printable characters only")
    return value


def _word(kind: str, name: str, value: Any, words: type[StrEnum]) -> Any:
    try:
        return words(value)
    except ValueError:
        known = ", ".join(word.value for word in words)
        raise _wrong(kind, name, f"there is no `{shown(value)}`", f"one of {known}") from None


def _numbers(
    kind: str, name: str, value: object, count: int, low: float, high: float, what: str
) -> tuple[float, ...]:
    try:
        several = tuple(value)  # type: ignore[arg-type, var-annotated]
    except TypeError:
        several = ()
    if len(several) != count or isinstance(value, (str, bytes)):
        raise _wrong(kind, name, f"`{shown(value)}` are not {count} numbers", f"{count} numbers, {what}")
    return tuple(_number(kind, name, one, low, high, what) for one in several)


def _stamp(kind: str, value: object, name: str = "stamp") -> float:
    return _number(kind, name, value, 0.0, 1e11, "seconds, with the system clock since 1970,")


_ANY = (-math.inf, math.inf)


def _finite(kind: str, name: str, value: object, what: str) -> float:
    number = _number(kind, name, value, *_ANY, what)
    if math.isinf(number):
        raise _wrong(kind, name, f"{number!r} is not finite", what)
    return number


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


@dataclass(frozen=True, slots=True)
class Point:
    """A place in the belt frame.

    Attributes:
        x: Along the travel [m].
        y: Across the belt [m].
    """

    x: float
    y: float


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
        self._set("stamp", _stamp(kind, self.stamp))
        self._convert("x", _number, -250.0, 1e6, "a position [m]")
        self._convert("y", _number, -1e6, 1e6, "a position [m]")
        if self.x is None or self.y is None:
            raise _wrong(kind, "x` and `y", "one is missing", "both [m]")
        for name in ("id", "class_", "source"):
            self._convert(name, _name)
        self._convert("area_cm2", _number, 0.0, 1e6, "an area [cm^2]")
        self._convert("weight", _number, 0.0, 1e12, "a weight")
        for name in ("p_detection", "p_grasp"):
            self._convert(name, _number, 0.0, 1.0, "a probability")
        self._convert("angle", _number, -7.0, 7.0, "an angle [rad]")
        self._convert("height", _number, 0.0, 10.0, "a height [m]")
        self._convert("size", _numbers, 2, 0.0, 10.0, "lengths [m]")
        self._convert("covariance", _numbers, 3, *_ANY, "[xx, xy, yy] [m^2],")
        if self.covariance is not None:
            xx, xy, yy = self.covariance
            if not (0.0 <= xx <= 0.04 and 0.0 <= yy <= 0.04 and xy * xy <= xx * yy):
                expected = "(xx, xy, yy) [m^2] with 0 <= xx, yy <= 0.04 and xy^2 <= xx yy"
                raise _wrong(kind, "covariance", f"{self.covariance} is not a covariance", expected)
        if self.data is not None:
            self._set("data", _data(kind, self.data))


def _data(kind: str, data: object) -> Mapping[str, Any]:
    """A copy of `data` that later changes of the original do not reach."""
    if not isinstance(data, Mapping):
        raise _wrong(kind, "data", f"`{shown(data)}` is not a dict", "a dict of what JSON can hold")
    try:
        text = json.dumps(dict(data), allow_nan=False, ensure_ascii=False, separators=(",", ":"))
        length = len(text.encode())
    except (TypeError, ValueError, RecursionError) as error:
        problem = f"cannot be written as JSON: {shown(str(error))}"
        raise _wrong(kind, "data", problem, "text, finite numbers, lists and dicts") from None
    if length > LONGEST_DATA:
        problem = f"it has {length} bytes as JSON"
        raise _wrong(kind, "data", problem, f"at most {LONGEST_DATA}: it goes into every task")
    copy: dict[str, Any] = json.loads(text)
    return copy


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
        self._set("stamp", _stamp(self.kind, self.stamp))
        self._set("speed", _number(self.kind, "speed", self.speed, -10.0, 10.0, "a belt speed [m/s]"))
        self._convert("position", _number, -1e12, 1e12, "a belt position [m]")
        self._convert("source", _name)


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
        self._set("stamp", _stamp(self.kind, self.stamp))
        self._set("name", _name(self.kind, "name", self.name))
        self._set("state", _word(self.kind, "state", self.state, RobotState))
        self._convert("available_at", _finite, "a timestamp [s]")
        self._convert("task", _whole)


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
        self._set("stamp", _stamp(self.kind, self.stamp))
        self._set("task", _whole(self.kind, "task", self.task))


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
        self._set("stamp", _stamp(self.kind, self.stamp))
        self._set("task", _whole(self.kind, "task", self.task))
        self._set("result", _word(self.kind, "result", self.result, Verdict))
        self._convert("available_at", _finite, "a timestamp [s]")
        if self.found is not None:
            found = self.found
            place = (found.x, found.y) if isinstance(found, Point) else found
            x, y = _numbers(self.kind, "found", place, 2, *_ANY, "(x, y) [m],")
            if math.isinf(x) or math.isinf(y):
                raise _wrong(self.kind, "found", f"({x}, {y}) is not finite", "(x, y) [m]")
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
            raise _wrong("order", "kind", f"there is no `{shown(self.kind)}`", f"one of {known}")
        self._set("stamp", _stamp(self.kind, self.stamp))
        self._convert("robot", _name)


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
        self._set("stamp", _stamp(self.kind, self.stamp))


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
        self._set("name", _name(kind, "name", self.name))
        self._set("role", _word(kind, "role", self.role, Role))
        if isinstance(self.robots, str):
            raise _wrong(kind, "robots", "is one text", "a list of names")
        self._set("robots", tuple(_name(kind, "robots", robot) for robot in self.robots))
        if (self.role is Role.ROBOT) != bool(self.robots):
            expected = "the robots that a peer with the role `robot` speaks for, and none otherwise"
            raise _wrong(kind, "robots", f"{list(self.robots)} with the role `{self.role}`", expected)
        if self.token is not None and not isinstance(self.token, str):
            raise _wrong(kind, "token", "it is not a text", "the text in the node's token file")
        if self.stamp is not None:
            self._set("stamp", _stamp(kind, self.stamp))


# Messages from the node.


@dataclass(frozen=True)
class Task:
    """Pick one item and bring it to the bin.

    Attributes:
        id: Number of the task; never reused.
        revision: Increases each time that the task is sent again, with its present times and
            meeting point.
        robot: Name of the robot.
        item: Id of the item.
        decided_at: When this was decided [s].
        start: When the robot must leave its bin [s].
        earliest_start: First start with which the robot meets the item in its workspace [s].
        latest_start: Last such start [s]: after this the robot must not set out.
        meet_at: When the robot meets the item [s].
        meet: Where the robot meets the item [m].
        bin: The bin for the item [m].
        free_at: When the robot is expected to be free again [s].
        priority: Object-specific reward of the item.
        strategy: Strategy that chose it.
        bin_name: The bin's name, if the robot has several bins or this one has a name.
        class_: Class of the item, by the camera's last report, as are the fields below; `class` in
            the message.
        angle: Angle of its long side, from x towards y [rad].
        height: Height of its top above the belt [m].
        size: Length and width [m].
        data: Any other data from the camera.
        extra: Fields that this version does not know.
    """

    kind: ClassVar[str] = "task"

    id: int
    revision: int
    robot: str
    item: str
    decided_at: float
    start: float
    earliest_start: float
    latest_start: float
    meet_at: float
    meet: Point
    bin: Point
    free_at: float
    priority: float
    strategy: str
    bin_name: str | None = None
    class_: str | None = None
    angle: float | None = None
    height: float | None = None
    size: tuple[float, float] | None = None
    data: Mapping[str, Any] | None = None
    extra: Mapping[str, Any] = field(default_factory=dict, repr=False)


@dataclass(frozen=True)
class Cancel:
    """Drop a task; answer with `CANCELLED`, or with the actual result if it was too late.

    Attributes:
        stamp: Timestamp [s].
        task: Id of the task.
        robot: Name of the robot.
        reason: The reason.
        extra: Fields that this version does not know.
    """

    kind: ClassVar[str] = "cancel"

    stamp: float
    task: int
    robot: str
    reason: str
    extra: Mapping[str, Any] = field(default_factory=dict, repr=False)


@dataclass(frozen=True)
class BeltRequest:
    """A request for a belt speed. The drive need not follow it; the belt's own messages report what
    it does.

    Attributes:
        stamp: Timestamp [s].
        speed: Speed along +x [m/s]; 0 is a stop.
        reason: The reason.
        extra: Fields that this version does not know.
    """

    kind: ClassVar[str] = "belt_request"

    stamp: float
    speed: float
    reason: str
    extra: Mapping[str, Any] = field(default_factory=dict, repr=False)


@dataclass(frozen=True)
class MissedCounts:
    """Items that were not picked, by the first reason that applies.

    Attributes:
        unreachable: No robot had a departure window for it.
        grasp_failed: It was attempted, and no grasp succeeded.
        no_result: A robot was sent but never reported a result.
        passed_over: A robot could have picked it at a decision, but another action was chosen.
        busy: Whenever it was in a robot's window, the robot was busy or out of service.
        not_found: Each robot that was sent came too late or did not find it.
    """

    unreachable: int
    grasp_failed: int
    no_result: int
    passed_over: int
    busy: int
    not_found: int = 0

    @property
    def total(self) -> int:
        """All of them."""
        return sum(getattr(self, one.name) for one in fields(self))


@dataclass(frozen=True)
class RobotReport:
    """One robot in a status.

    Attributes:
        name: Its name.
        state: `idle`, `busy`, `fault`, `silent` (its result is overdue), or `unknown` before its
            first message; `paused` or `stopped` if it is idle by order of the operator.
        picked: Its picks.
        failed: Its failed grasps.
        missed: Its tasks for which it came too late or did not find the item.
    """

    name: str
    state: str
    picked: int
    failed: int
    missed: int = 0


@dataclass(frozen=True)
class SourceReport:
    """One source in a status.

    Attributes:
        name: Its `source`, or its kind if it gives none; for a robot its name.
        kind: Its kind.
        age: Time since its last message [s].
        overdue: Whether it has been silent for longer than expected.
        period: Typical interval of its messages [s]; absent if it reports only changes.
        offset: Smallest time from the timestamp of a message to its arrival over the last half
            minute, by the machine's clock [s]: the sum of transmission delay and clock offset.
            Absent with message time.
        mapped: What is added to its timestamps [s], if its clock certainly differs from the
            machine's.
    """

    name: str
    kind: str
    age: float
    overdue: bool
    period: float | None = None
    offset: float | None = None
    mapped: float | None = None


@dataclass(frozen=True)
class Latency:
    """Durations of decisions [ms]. Quantiles come from a histogram with classes 1 % wide.

    Attributes:
        decisions: Number of decisions.
        p50_ms: Median [ms].
        p99_ms: 99th percentile [ms].
        max_ms: Maximum [ms].
    """

    decisions: int
    p50_ms: float
    p99_ms: float
    max_ms: float


@dataclass(frozen=True)
class Status:
    """The figures of the line. `seen` is always `picked` + all of `missed` + `on_belt` + `claimed` +
    `unwanted`.

    Attributes:
        stamp: Timestamp [s].
        last: Whether this is the last one.
        seen: Items seen.
        picked: Items picked.
        picked_share: `picked` / (`seen` - `unwanted`); 0 if nothing that is wanted was seen.
        picks_per_min: Picks per minute since the first message [1/min].
        missed: Items that were not picked, by reason.
        on_belt: Items that may still be picked.
        claimed: Items that are assigned to a robot.
        open_tasks: Ids of the tasks without a result yet.
        queued: Messages waiting to be sent.
        rejected: Messages that were refused, by reason.
        noted: Unusual events by kind, such as repeated detections and late results.
        robots: Each robot, upstream first.
        mode: `running`, `paused`, `draining`, `drained` or `stopped`, by the operator's orders.
        unwanted: Items that are left on the belt on purpose. Absent on a line that takes every
            item.
        latency: Durations of decisions; absent with message time.
        layout: Hash of the node's station, independent of the belt's speed.
        sources: The sources that were heard, by kind and name.
        extra: Fields that this version does not know.
    """

    kind: ClassVar[str] = "status"

    stamp: float
    last: bool
    seen: int
    picked: int
    picked_share: float
    picks_per_min: float
    missed: MissedCounts
    on_belt: int
    claimed: int
    open_tasks: tuple[int, ...]
    queued: int
    rejected: Mapping[str, int]
    noted: Mapping[str, int]
    robots: tuple[RobotReport, ...]
    mode: str = ""
    unwanted: int | None = None
    latency: Latency | None = None
    layout: str | None = None
    sources: tuple[SourceReport, ...] = ()
    extra: Mapping[str, Any] = field(default_factory=dict, repr=False)


@dataclass(frozen=True)
class Due:
    """Everything up to a tick is decided; answers `tick` with message time.

    Attributes:
        stamp: Timestamp of the tick [s].
        next: When the next decision is due if no further message comes [s].
        extra: Fields that this version does not know.
    """

    kind: ClassVar[str] = "due"

    stamp: float
    next: float | None = None
    extra: Mapping[str, Any] = field(default_factory=dict, repr=False)


@dataclass(frozen=True)
class Answer:
    """The node's answer to a hello, and its last message to a peer that it disconnects; `kind` is
    `hello`.

    Attributes:
        accepted: Whether the peer may stay.
        reason: The reason if it may not.
        robots: The robots of the node's station, upstream first, if the peer may stay.
        extra: Fields that this version does not know.
    """

    kind: ClassVar[str] = "hello"

    accepted: bool
    reason: str | None = None
    robots: tuple[str, ...] = ()
    extra: Mapping[str, Any] = field(default_factory=dict, repr=False)


ToNode = Detection | BeltState | RobotStatus | Ack | Report | Order | Tick | Hello
"""A message to the node."""

FromNode = Task | Cancel | BeltRequest | Status | Due | Answer
"""A message from the node."""

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
        values = json.loads(line)
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
