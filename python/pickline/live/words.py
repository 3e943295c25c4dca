"""The words of the protocol, and places."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

__all__ = ["Point", "RobotState", "Role", "SourceKind", "Verdict"]


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


@dataclass(frozen=True, slots=True)
class Point:
    """A place in the belt frame.

    Attributes:
        x: Along the travel [m].
        y: Across the belt [m].
    """

    x: float
    y: float
