"""Messages from the node. Fields that this version does not know are kept in `extra`, because a newer
node may send more."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar

from .words import Point

__all__ = [
    "Answer",
    "BeltRequest",
    "Cancel",
    "Due",
    "FromNode",
    "Latency",
    "MissedCounts",
    "RobotReport",
    "SourceReport",
    "Status",
    "Task",
]


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


FromNode = Task | Cancel | BeltRequest | Status | Due | Answer
"""A message from the node."""
