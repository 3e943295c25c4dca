"""What every peer of a line has: its address and name, its beginning and end, the line's status."""

from __future__ import annotations

import asyncio
import contextlib
import os
import ssl
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable
from types import TracebackType
from typing import ClassVar, Self

from .address import Address, read_token, tls_context
from .errors import BadMessage, Closed, LineError, Overflow, Refused, Unreachable
from .link import Link, log
from .messages import FromNode, Hello, Role, Status
from .session import Transport
from .tcp import TcpTransport

__all__ = ["Peer"]

FAREWELL_TIMEOUT = 2.0
"""How long a peer that closes tries to send what is left [s]."""


OF_OTHERS: dict[Role, frozenset[str]] = {
    Role.CAMERA: frozenset({"unknown_task", "unknown_robot"}),
    Role.ENCODER: frozenset({"unknown_task", "unknown_robot", "off_belt", "too_many_items"}),
    Role.ROBOT: frozenset({"off_belt", "too_many_items"}),
    Role.OPERATOR: frozenset({"unknown_task", "off_belt", "too_many_items"}),
    Role.OBSERVER: frozenset(),
}
"""Reasons for which the node cannot have refused a message of a role. An observer watches all."""


class Peer(Link):
    """A peer of a line. `async with` opens and closes it.

    The connection is kept up in the background: when it is lost, the peer connects again, with
    growing pauses and without a limit, and tells the node what it has to know. Troubles are logged
    as warnings of the logger `pickline.live`, each once.

    A peer belongs to the event loop in which it was opened, and is not for several threads.

    Args:
        address: `HOST:PORT` or `tls://HOST:PORT` of a node that listens, or `mqtt://HOST:PORT` or
            `mqtts://HOST:PORT` of a broker.
        name: Its name: for the node's remarks, and as the `source` of a camera or encoder.
        token: The node's token, or the file that holds it as a `pathlib.Path`.
        ca: File of the authorities to trust (PEM) instead of the machine's; for TLS.
        cert: File of a certificate to show (PEM); with `key`.
        key: File of its private key (PEM).
        patience: How long the first connection may take [s]; `None` waits for ever.
        clock: The clock of all timestamps [s]; by default the machine's.
        prefix: First levels of the topics, over MQTT.
        user: User name at a broker; may also be in the address.
        password: Password at a broker.

    Raises:
        BadAddress: The address, or an option of the connection, cannot be used.
        BadMessage: The name cannot be used.
        MissingPackage: The package that MQTT needs is not installed.
    """

    role: ClassVar[Role]

    def __init__(
        self,
        address: str,
        name: str,
        *,
        token: str | os.PathLike[str] | None = None,
        ca: str | os.PathLike[str] | None = None,
        cert: str | os.PathLike[str] | None = None,
        key: str | os.PathLike[str] | None = None,
        patience: float | None = 30.0,
        clock: Callable[[], float] = time.time,
        prefix: str = "pickline",
        user: str | None = None,
        password: str | None = None,
    ) -> None:
        if patience is not None and not (isinstance(patience, int | float) and patience > 0):
            raise BadMessage("`patience`", f"{patience!r} is out of range", "give more than 0 s, or None")
        self.address = Address.read(address)
        self.clock = clock
        hello = Hello(name, self.role, self._robots(), read_token(token))
        self.name = hello.name
        self.rejected: Counter[str] = Counter()
        """Messages that the node has refused since this peer was opened, by reason, without reasons
        that only others can have caused. The node tells only how many of all its peers they are."""
        self._patience = patience
        tls = tls_context(self.address, ca, cert, key)
        transport = self._transport_for(tls, prefix, user, password)
        super().__init__(transport, hello, f"{self.role} `{self.name}` at {self.address}")

    def _transport_for(
        self, tls: ssl.SSLContext | None, prefix: str, user: str | None, password: str | None
    ) -> Transport:
        if self.address.is_mqtt:
            # A package that only this needs.
            from .mqtt import MqttTransport

            return MqttTransport(self.address, tls, prefix, user, password)
        return TcpTransport(self.address, tls)

    # What kinds of peers do differently.

    def _robots(self) -> tuple[str, ...]:
        return ()

    def _hear(self, message: FromNode) -> None:
        """Takes a message from the node. Must not wait."""

    async def _farewell(self) -> None:
        """What is done before the connection ends."""
        if self._is_up:
            with contextlib.suppress(LineError):
                await self.flush(FAREWELL_TIMEOUT)

    def _check_delivered(self) -> None:
        """Raises what remains undone after the end."""

    # Its life.

    @property
    def is_connected(self) -> bool:
        """Whether the node can be spoken to now."""
        return self._is_up

    @property
    def is_open(self) -> bool:
        """Whether it was opened, and neither closed nor refused since."""
        return self._runner is not None and not self._is_closing and self._failure is None

    async def __aenter__(self) -> Self:
        await self.open()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            await self.close()
        except LineError as undone:
            if error is None:
                raise
            # What has happened first matters more.
            log.error("%s", undone)

    async def open(self) -> None:
        """Connects.

        Raises:
            Refused: The node does not let it in.
            BadReply: What answers there is not a node.
            Unreachable: There was no connection within `patience`.
        """
        if self._runner is not None:
            raise Closed(self._place, "it was opened before", "make a new one for each use")
        self._runner = asyncio.create_task(self._run(), name=f"pickline.live {self.name}")
        try:
            async with asyncio.timeout(self._patience):
                await self._until(lambda: self.connections > 0)
        except TimeoutError:
            trouble = self.last_trouble
            await self._abandon()
            if isinstance(trouble, Refused):
                raise trouble from None
            problem = trouble.problem if trouble else self._transport.reached
            cure = trouble.cure if trouble else "check that a node is at this address"
            problem = f"{problem} (tried for {self._patience:g} s)"
            raise Unreachable(self._place, problem, cure) from trouble
        except BaseException:
            await self._abandon()
            raise

    async def close(self) -> None:
        """Sends what is left, and ends the connection. Closing twice is closing once.

        Raises:
            ResultsLost: Results of a robot could not be delivered.
        """
        if self._runner is None or self._is_closing:
            return
        try:
            if self._failure is None:
                await self._farewell()
        finally:
            await self._abandon()
        self._check_delivered()

    async def _abandon(self) -> None:
        self._is_closing = True
        self._news.tell()
        self._ended()
        if self._runner is not None:
            self._runner.cancel()
            await asyncio.wait([self._runner])

    async def wait_connected(self) -> None:
        """Waits until the node can be spoken to.

        Raises:
            Refused: The node does not let it in any more.
            Closed: The peer is closed.
        """
        await self._until(lambda: self._is_up)

    async def flush(self, timeout: float = 5.0) -> None:
        """Waits until everything so far was handed to the connection.

        Raises:
            Overflow: It was not within `timeout` [s].
        """
        try:
            async with asyncio.timeout(timeout):
                await self._until(
                    lambda: self._is_up and not self._outbox and not self._writes.is_set()
                )
        except TimeoutError:
            problem = f"{len(self._outbox)} messages could not be sent within {timeout:g} s"
            raise Overflow(self._place, problem, "see `last_trouble`") from self.last_trouble

    # Listening.

    async def statuses(self) -> AsyncIterator[Status]:
        """The statuses of the line as they come, without those that came while the caller was busy
        with another. Ends when the peer is closed."""
        while True:
            try:
                status = await self.next_status()
            except Closed:
                return
            yield status

    async def next_status(self) -> Status:
        """The next status of the line.

        Raises:
            Refused: The node does not let it in any more.
            Closed: The peer is closed.
        """
        last = self.status
        await self._until(lambda: self.status is not last)
        assert self.status is not None
        return self.status

    def _take(self, message: FromNode) -> None:
        if isinstance(message, Status):
            before, self.status = self.status, message
            self._tell_rejected(before, message)
            self._tell_clock(message)
        self._hear(message)
        self._news.tell()

    def _tell_rejected(self, before: Status | None, now: Status) -> None:
        """Notes what the node has refused since the last status."""
        if before is None:
            return
        grown = Counter(now.rejected) - Counter(before.rejected)
        if Counter(before.rejected) - Counter(now.rejected):
            # A node that has started over. What it has refused since then is new.
            grown = Counter(now.rejected)
        for reason in OF_OTHERS[self.role]:
            del grown[reason]
        if grown:
            self.rejected += grown
            known = ", ".join(f"{count} x {reason}" for reason, count in sorted(grown.items()))
            self._warn(
                f"{self._place}: the node has refused messages of its peers: {known}; its log says which"
            )

    def _tell_clock(self, status: Status) -> None:
        """Warns once if the node has to correct the clock of this peer."""
        own = {self.name, *self.hello.robots}
        for source in status.sources:
            if source.name in own and source.mapped:
                self._warn_once(
                    "clock",
                    f"{self._place}: the node adds {source.mapped:+.3f} s to its timestamps; "
                    "set the clocks of both machines with NTP",
                )

    def __repr__(self) -> str:
        state = "connected" if self._is_up else "open" if self.is_open else "closed"
        return f"<{type(self).__name__} {self.name!r} at {self.address}, {state}>"
