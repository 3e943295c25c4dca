"""What can go wrong with a line. Every message names the place, the problem and the cure."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = [
    "BadAddress",
    "BadMessage",
    "BadReply",
    "Closed",
    "LineError",
    "Lost",
    "MissingPackage",
    "Overflow",
    "Refused",
    "ResultsLost",
    "TaskDropped",
    "Unfinished",
    "Unreachable",
]


class LineError(Exception):
    """Something is wrong with a line, or with how it is used.

    Attributes:
        place: What it is about: an address, a field, a task.
        problem: What is wrong with it.
        cure: What to do about it.
    """

    def __init__(self, place: str, problem: str, cure: str) -> None:
        super().__init__(place, problem, cure)
        self.place = place
        self.problem = problem
        self.cure = cure

    def __str__(self) -> str:
        return f"{self.place}: {self.problem}; {self.cure}"


class BadAddress(LineError, ValueError):
    """An address, or an option of the connection, that cannot be used."""


class BadMessage(LineError, ValueError):
    """A value that the node would refuse. Nothing of the call was sent."""


class BadReply(LineError):
    """What comes from the other side is not the live protocol."""


class Unreachable(LineError, ConnectionError):
    """The first connection was not made within `patience`."""


class Refused(LineError, PermissionError):
    """The node does not let this peer in, or has disconnected it for good.

    Attributes:
        reason: The node's own words.
        may_pass: Whether another attempt may succeed although nothing changes at this peer.
        is_final: Whether a peer that was let in before does not try again.
    """

    def __init__(
        self,
        place: str,
        problem: str,
        cure: str,
        reason: str = "",
        *,
        may_pass: bool = False,
        is_final: bool = False,
    ) -> None:
        super().__init__(place, problem, cure)
        self.reason = reason
        self.may_pass = may_pass
        self.is_final = is_final


class Lost(LineError, ConnectionError):
    """A connection has ended. Peers connect again by themselves, so callers see this only as the
    `last_trouble` of a peer."""


class Overflow(LineError):
    """More messages wait to be sent than a peer keeps. Nothing of the call was accepted."""


class Closed(LineError):
    """The peer is not open."""


class Unfinished(LineError):
    """The next task was asked for before the present one had a result."""


class MissingPackage(LineError, ImportError):
    """An optional package is not installed."""


class ResultsLost(LineError):
    """A robot was closed while results had not been delivered.

    Attributes:
        results: The results by task id.
    """

    def __init__(
        self, place: str, problem: str, cure: str, results: Mapping[int, str] | None = None
    ) -> None:
        super().__init__(place, problem, cure)
        self.results = dict(results or {})


class TaskDropped(LineError):
    """The node wants a task dropped. Raised where a program waits for a moment of the task."""
