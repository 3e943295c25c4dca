"""A client for the live protocol: connects cameras, encoders, robots, monitors and operators to
`pickline run`.

    from pickline.live import Camera

    async with Camera("127.0.0.1:7400", "north") as camera:
        await camera.report([{"x": 0.12, "y": -0.05, "id": "17"}])

Needs the standard library only; for MQTT also the extra `pickline[mqtt]`.
"""

from .belt import Belt
from .camera import Camera
from .errors import (
    BadAddress,
    BadMessage,
    BadReply,
    Closed,
    LineError,
    Lost,
    MissingPackage,
    Overflow,
    Refused,
    ResultsLost,
    TaskDropped,
    Unfinished,
    Unreachable,
)
from .messages import (
    Ack,
    Answer,
    BeltRequest,
    BeltState,
    Cancel,
    Detection,
    Due,
    Hello,
    Latency,
    MissedCounts,
    Order,
    Point,
    Report,
    RobotReport,
    RobotState,
    RobotStatus,
    Role,
    SourceKind,
    SourceReport,
    Status,
    Task,
    Tick,
    Verdict,
)
from .monitor import Monitor, Operator
from .peer import Peer
from .robot import Robot
from .work import Work

__all__ = [
    "Ack",
    "Answer",
    "BadAddress",
    "BadMessage",
    "BadReply",
    "Belt",
    "BeltRequest",
    "BeltState",
    "Camera",
    "Cancel",
    "Closed",
    "Detection",
    "Due",
    "Hello",
    "Latency",
    "LineError",
    "Lost",
    "MissedCounts",
    "MissingPackage",
    "Monitor",
    "Operator",
    "Order",
    "Overflow",
    "Peer",
    "Point",
    "Refused",
    "Report",
    "ResultsLost",
    "Robot",
    "RobotReport",
    "RobotState",
    "RobotStatus",
    "Role",
    "SourceKind",
    "SourceReport",
    "Status",
    "Task",
    "TaskDropped",
    "Tick",
    "Unfinished",
    "Unreachable",
    "Verdict",
    "Work",
]
