"""A connection to a line, whatever carries it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from .messages import Answer, FromNode, Hello, ToNode

__all__ = ["Session", "Transport"]


class Session(ABC):
    """One connection, from which a node can be spoken to until it is lost."""

    answer: Answer
    """What the node has answered to the hello. Over MQTT nobody answers: it is made up."""

    @abstractmethod
    async def send(self, messages: Sequence[ToNode]) -> None:
        """Sends messages in this order, and waits while the other side does not take them.

        Raises:
            Lost: The connection has ended.
        """

    @abstractmethod
    async def receive(self) -> FromNode | None:
        """The next message; none for one that is of no use to this version.

        Raises:
            Lost: The connection has ended.
            BadReply: It is not a message. The next one may be.
        """

    @abstractmethod
    async def close(self, *, flush: bool) -> None:
        """Ends the connection. With `flush`, what was sent arrives if the other side is there.
        Never raises."""


class Transport(ABC):
    """A way to a line."""

    reached = "no connection"
    """How far `open` has got, as the problem if it gets no further."""

    @abstractmethod
    async def open(self, hello: Hello) -> Session:
        """Opens a connection over which the node listens.

        Raises:
            Lost: There is none now.
            Refused: The node does not want this peer.
            BadReply: Something else answers at this address.
        """
