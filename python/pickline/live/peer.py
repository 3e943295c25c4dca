"""What every peer of a line does: connect, stay connected, listen, and end in order."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import logging
import os
import random
import statistics
import time
from collections import Counter, deque
from collections.abc import AsyncIterator, Callable
from types import TracebackType
from typing import Any, ClassVar, Self

from .address import Address, read_token, tls_context
from .errors import BadReply, Closed, LineError, Lost, Overflow, Refused, Unreachable
from .messages import FromNode, Hello, Role, Status, ToNode
from .session import Session, Transport
from .tcp import TcpTransport

__all__ = ["Peer"]

log = logging.getLogger("pickline.live")

OPEN_TIMEOUT = 10.0
"""A connection is given up if it is not established after this time [s]."""

WRITE_TIMEOUT = 10.0
"""A connection is given up if the other side takes nothing for this time [s]."""

FIRST_PAUSE, SHORT_PAUSE, LONGEST_PAUSE = 0.05, 0.4, 2.0
"""Pauses between two attempts to connect [s]: each is twice the one before, up to the longest; after
a connection, up to the short one. An arm that waits for its line should not wait much longer than
the node's restart takes."""

FAREWELL_TIMEOUT = 2.0
"""How long a peer that closes tries to send what is left [s]."""

STEADY = 1.0
"""A connection that has lasted this long was a success: pauses begin anew [s]."""

SILENCE = 5.0
"""A node that sends statuses regularly is gone after this time at least [s]."""

SILENT_PERIODS = 10
"""... and after this many of its intervals."""

AT_ONCE = 256
"""Maximum number of messages in one write."""

MOST_BAD_REPLIES = 100
"""A connection that brings so much that cannot be read, and nothing else, is given up."""


class News:
    """Wakes everybody who waits for something to happen."""

    def __init__(self) -> None:
        self._next = asyncio.Event()

    def tell(self) -> None:
        """Something has happened."""
        self._next.set()
        self._next = asyncio.Event()

    async def until(self, happened: Callable[[], object]) -> None:
        """Waits until `happened` returns something true."""
        while not happened():
            await self._next.wait()


class Peer:
    """A peer of a line. `async with` opens and closes it.

    The connection is kept up in the background: when it is lost, the peer connects again, with
    growing pauses and without a limit, and tells the node what it has to know. Troubles are logged
    as warnings of the logger `pickline.live`, each once.

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
        self.address = Address.read(address)
        self.clock = clock
        self.hello = Hello(name, self.role, self._robots(), read_token(token))
        self.name = self.hello.name
        self.status: Status | None = None
        """The newest status of the line; none before the first."""
        self.station_robots: tuple[str, ...] = ()
        """The robots of the node's station, upstream first. Not known over MQTT."""
        self.last_trouble: LineError | None = None
        """Why the connection was lost last, or could not be made."""
        self.connections = 0
        """How often it has connected."""
        self.rejected: Counter[str] = Counter()
        """Messages that the node has refused since this peer was opened, by reason. The node tells
        only how many of all its peers they are."""
        self._patience = patience
        self._transport = self._make_transport(ca, cert, key, prefix, user, password)
        self._outbox: deque[ToNode] = deque()
        self._runner: asyncio.Task[None] | None = None
        self._failure: LineError | None = None
        self._is_up = False
        self._is_closing = False
        self._news = News()
        self._writes = asyncio.Event()
        self._noted: str | None = None
        self._heard_at = 0.0
        self._status_times: deque[float] = deque(maxlen=8)

    def _make_transport(
        self, ca: Any, cert: Any, key: Any, prefix: str, user: str | None, password: str | None
    ) -> Transport:
        tls = tls_context(self.address, ca, cert, key)
        if self.address.is_mqtt:
            # A package that only this needs.
            from .mqtt import MqttTransport

            return MqttTransport(self.address, tls, prefix, user, password)
        return TcpTransport(self.address, tls)

    # What kinds of peers do differently.

    def _robots(self) -> tuple[str, ...]:
        return ()

    def _greeting(self) -> list[ToNode]:
        """What the node has to be told over a new connection."""
        return []

    def _hear(self, message: FromNode) -> None:
        """Takes a message from the node. Must not wait."""

    def _sent(self, messages: list[ToNode]) -> None:
        """Takes note of messages that were handed to the connection."""

    def _lost(self) -> None:
        """Takes note that the connection is lost."""

    async def _background(self) -> None:
        """Runs as long as the peer is open."""

    async def _farewell(self) -> None:
        """What is done before the connection ends."""
        if self._is_up:
            with contextlib.suppress(LineError):
                await self.flush(FAREWELL_TIMEOUT)

    def _ended(self) -> None:
        """Wakes whoever waits for something else than `_until` does."""

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
            problem = trouble.problem if trouble else "no connection"
            cure = trouble.cure if trouble else "check the address"
            problem = f"{problem} (tried for {self._patience:g} s)"
            raise Unreachable(str(self.address), problem, cure) from trouble
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

    @property
    def _place(self) -> str:
        return f"{self.role} `{self.name}` at {self.address}"

    def _check_open(self) -> None:
        if self._failure is not None:
            raise self._failure
        if not self.is_open:
            problem = "it is not open" if self._runner is None else "it is closed"
            cure = f"use it within `async with {type(self).__name__}(...)`"
            raise Closed(self._place, problem, cure)

    async def _until(self, happened: Callable[[], object]) -> None:
        """Waits until something has happened, or the peer can be used no more."""

        def ended() -> bool:
            if happened():
                return True
            self._check_open()
            return False

        await self._news.until(ended)

    # Sending.

    def _push(self, *messages: ToNode) -> None:
        """Sends messages, if there is a connection: without one, the greeting of the next has to
        make up for it."""
        if self._is_up:
            self._outbox.extend(messages)
            self._writes.set()

    def _check_room(self, count: int, most: int) -> None:
        if len(self._outbox) + count > most:
            problem = f"{len(self._outbox)} messages wait, and the node takes none"
            cure = "send less, or find out what holds up the node"
            raise Overflow(self._place, problem, cure)

    async def flush(self, timeout: float = 5.0) -> None:
        """Waits until everything so far was handed to the connection.

        Raises:
            Overflow: It was not within `timeout` [s].
        """
        try:
            async with asyncio.timeout(timeout):
                await self._until(lambda: self._is_up and not self._outbox and not self._writes.is_set())
        except TimeoutError:
            problem = f"{len(self._outbox)} messages could not be sent within {timeout:g} s"
            raise Overflow(self._place, problem, "see `last_trouble`") from self.last_trouble

    # Listening.

    async def statuses(self) -> AsyncIterator[Status]:
        """The statuses of the line as they come, without those that came while the caller was busy
        with another."""
        last = self.status
        while True:
            try:
                await self._until(lambda seen=last: self.status is not seen)  # type: ignore[misc]
            except Closed:
                return
            last = self.status
            if last is not None:
                yield last

    async def next_status(self) -> Status:
        """The next status of the line."""
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
        if grown:
            self.rejected += grown
            known = ", ".join(f"{count} x {reason}" for reason, count in sorted(grown.items()))
            log.warning(
                "%s: the node has refused messages of its peers: %s; its log says which", self._place, known
            )

    def _tell_clock(self, status: Status) -> None:
        """Warns once if the node has to correct the clock of this peer."""
        for source in status.sources:
            if source.name == self.name and source.mapped:
                self._note(
                    "clock",
                    f"{self._place}: the node adds {source.mapped:+.3f} s to its timestamps; "
                    "set the clocks of both machines with NTP",
                )

    def _note(self, about: str, text: str) -> None:
        """Logs a warning, unless it is about the same as the last one."""
        if self._noted != about:
            self._noted = about
            log.warning("%s", text)

    # The connection.

    async def _run(self) -> None:
        background = asyncio.create_task(self._background())
        background.add_done_callback(self._background_ended)
        try:
            await self._stay_connected()
        except LineError as error:
            self._failure = error
            if self.connections:
                log.error("%s", error)
        except asyncio.CancelledError:
            raise
        except Exception as error:
            # An error of this module. Callers must not wait for ever.
            self._failure = LineError(self._place, f"internal error: {error!r}", "report it")
            self._failure.__cause__ = error
            log.exception("%s: internal error", self._place)
        finally:
            background.cancel()
            await asyncio.wait([background])
            self._news.tell()
            self._ended()

    def _background_ended(self, task: asyncio.Task[None]) -> None:
        if not task.cancelled() and task.exception() is not None:
            log.error("%s: internal error", self._place, exc_info=task.exception())

    async def _stay_connected(self) -> None:
        pause, taken_over = FIRST_PAUSE, 0
        while True:
            began = None
            try:
                async with asyncio.timeout(OPEN_TIMEOUT):
                    session = await self._transport.open(self.hello)
                began = time.monotonic()
                await self._serve(session)
            except TimeoutError:
                cure = "check that a node is at this address"
                self._troubled(Lost(str(self.address), f"no answer within {OPEN_TIMEOUT:g} s", cure))
            except (Refused, BadReply) as error:
                if not self.connections and not getattr(error, "may_pass", False):
                    raise
                if getattr(error, "is_final", False):
                    raise
                # Another program with the same name is connected. Two that connect again each time
                # would disconnect each other for ever, and both drive the robot.
                is_taken = "another connection" in getattr(error, "reason", "")
                taken_over = taken_over + 1 if is_taken else 0
                if taken_over == 2:
                    raise
                self._troubled(error)
            except Lost as error:
                self._troubled(error)
            if began is not None:
                # The node is there, and at most in trouble.
                pause = min(pause, SHORT_PAUSE)
                if time.monotonic() - began > STEADY:
                    pause, taken_over = FIRST_PAUSE, 0
            # Not all peers at the same moment.
            await asyncio.sleep(pause * random.uniform(0.5, 1.0))
            pause = min(2 * pause, LONGEST_PAUSE)

    def _troubled(self, error: LineError) -> None:
        self.last_trouble = error
        self._note(error.problem, f"{error}; retrying")

    async def _serve(self, session: Session) -> None:
        """Speaks and listens until the connection is lost."""
        self.station_robots = session.answer.robots
        self._outbox.clear()
        self._outbox.extend(self._greeting())
        self._writes.set()
        self._heard_at = time.monotonic()
        self._status_times.clear()
        self._is_up = True
        self.connections += 1
        if self._noted is not None and self._noted != "clock":
            log.warning("%s: connected", self._place)
            self._noted = None
        self._news.tell()
        parts = [self._write(session), self._read(session), self._watch()]
        tasks = [asyncio.create_task(part) for part in parts]
        is_whole = True
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            is_whole = False
            for task in done:
                task.result()
        finally:
            self._is_up = False
            for task in tasks:
                task.cancel()
            await asyncio.wait(tasks)
            for task in tasks:
                # Otherwise asyncio complains that nobody has looked.
                if not task.cancelled():
                    task.exception()
            self._outbox.clear()
            self._writes.clear()
            self._lost()
            await session.close(flush=is_whole)
            self._news.tell()

    async def _write(self, session: Session) -> None:
        while True:
            await self._writes.wait()
            while self._outbox:
                batch = [self._outbox.popleft() for _ in range(min(AT_ONCE, len(self._outbox)))]
                try:
                    async with asyncio.timeout(WRITE_TIMEOUT):
                        await session.send(batch)
                except TimeoutError:
                    problem = f"the node has taken nothing for {WRITE_TIMEOUT:g} s"
                    raise Lost(str(self.address), problem, "see what holds it up") from None
                self._sent(batch)
                self._news.tell()
            self._writes.clear()
            self._news.tell()

    async def _read(self, session: Session) -> None:
        bad = 0
        while True:
            try:
                message = await session.receive()
            except BadReply as error:
                bad += 1
                if bad >= MOST_BAD_REPLIES:
                    raise Lost(error.place, error.problem, error.cure) from None
                self._note(error.problem, f"{error}; ignored")
                continue
            bad = 0
            self._heard_at = time.monotonic()
            if message is not None:
                if isinstance(message, Status):
                    self._status_times.append(self._heard_at)
                self._take(message)

    async def _watch(self) -> None:
        """Ends a connection over which nothing comes any more, although statuses did. A cable that
        was pulled shows in no other way."""
        while True:
            times = list(self._status_times)
            if len(times) < 3:
                await asyncio.sleep(SILENCE / 5)
                continue
            period = statistics.median(b - a for a, b in itertools.pairwise(times))
            allowed = max(SILENCE, SILENT_PERIODS * period)
            left = self._heard_at + allowed - time.monotonic()
            if left <= 0:
                problem = f"the node has sent nothing for {allowed:.1f} s"
                raise Lost(str(self.address), problem, "check the network and the node")
            await asyncio.sleep(left)

    def __repr__(self) -> str:
        state = "connected" if self._is_up else "open" if self.is_open else "closed"
        return f"<{type(self).__name__} {self.name!r} at {self.address}, {state}>"

