"""The connection of a peer: made, kept up, made again.

`Link` knows nothing of what a peer is for. What it sends waits in a queue that belongs to one
connection: when that is lost, the queue is emptied, and the peer's greeting tells the next
connection everything that the node may not know.
"""

from __future__ import annotations

import asyncio
import itertools
import logging
import random
import statistics
import time
from collections import deque
from collections.abc import Callable

from .errors import BadReply, Closed, LineError, Lost, Overflow, Refused
from .messages import FromNode, Hello, Status, ToNode
from .session import Session, Transport

__all__ = ["Link", "News", "log"]

log = logging.getLogger("pickline.live")

OPEN_TIMEOUT = 10.0
"""A connection is given up if it is not established after this time [s]."""

WRITE_TIMEOUT = 10.0
"""A connection is given up if the other side takes nothing for this time [s]."""

FIRST_PAUSE, SHORT_PAUSE, LONGEST_PAUSE = 0.05, 0.4, 2.0
"""Pauses between two attempts to connect [s]: each is twice the one before, up to the longest; after
a connection, up to the short one. An arm that waits for its line should not wait much longer than
the node's restart takes."""

STEADY = 1.0
"""A connection that has lasted this long was a success: pauses begin anew [s]."""

SILENCE = 5.0
"""A node that sends statuses regularly is gone after this time at least [s]."""

SILENT_PERIODS = 10
"""... and after this many of its intervals."""

READ_TIME = 0.1
"""In this time what the system has received is read [s]."""

AT_ONCE = 256
"""Maximum number of messages in one write."""

MOST_BAD_REPLIES = 100
"""A connection that brings so much that cannot be read, and nothing else, is given up."""

MOST_REMARKS, REMARK_TIME = 20, 60.0
"""At most so many troubles are logged in so much time [s]."""


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


class Link:
    """Keeps up the connection of a peer. The methods without a body are the peer's."""

    def __init__(self, transport: Transport, hello: Hello, title: str) -> None:
        self.hello = hello
        self.status: Status | None = None
        """The newest status of the line; none before the first."""
        self.station_robots: tuple[str, ...] = ()
        """The robots of the node's station, upstream first. Not known over MQTT."""
        self.last_trouble: LineError | None = None
        """Why the connection was lost last, or could not be made."""
        self.connections = 0
        """How often it has connected."""
        self._transport = transport
        self._place = title
        self._outbox: deque[ToNode] = deque()
        self._runner: asyncio.Task[None] | None = None
        self._failure: LineError | None = None
        self._is_up = False
        self._is_closing = False
        self._news = News()
        self._writes = asyncio.Event()
        self._heard_at = 0.0
        self._status_times: deque[float] = deque(maxlen=8)
        self._trouble: str | None = None
        self._told_once: set[str] = set()
        self._remarks: deque[float] = deque()
        self._unlogged = 0

    # What kinds of peers do differently.

    def _greeting(self) -> list[ToNode]:
        """What the node has to be told over a new connection."""
        return []

    def _take(self, message: FromNode) -> None:
        """Takes a message from the node. Must not wait."""

    def _sent(self, messages: list[ToNode]) -> None:
        """Takes note of messages that were handed to the connection."""

    def _lost(self) -> None:
        """Takes note that the connection is lost."""

    async def _background(self) -> None:
        """Runs as long as the peer is open."""
        await asyncio.Event().wait()

    def _ended(self) -> None:
        """Wakes whoever waits for something else than `_until` does."""

    # Waiting and sending.

    def _check_open(self) -> None:
        if self._failure is not None:
            # The same error may be raised often, and must not collect where.
            raise self._failure.with_traceback(None)
        if self._runner is None or self._is_closing:
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

    # The log.

    def _warn(self, text: str) -> None:
        """Logs a warning, if there are not too many of them."""
        now = time.monotonic()
        while self._remarks and now - self._remarks[0] > REMARK_TIME:
            self._remarks.popleft()
        if len(self._remarks) >= MOST_REMARKS:
            self._unlogged += 1
            return
        self._remarks.append(now)
        if self._unlogged:
            text = f"{text} (and {self._unlogged} remarks that were not logged)"
            self._unlogged = 0
        log.warning("%s", text)

    def _warn_once(self, about: str, text: str) -> None:
        """Logs a warning, the first time that it is about this."""
        if about not in self._told_once:
            self._told_once.add(about)
            self._warn(text)

    def _troubled(self, error: LineError) -> None:
        """Notes why there is no connection, and logs it unless it is the same as before."""
        self.last_trouble = error
        if self._trouble != error.problem:
            self._trouble = error.problem
            self._warn(f"{error}; retrying")
        self._news.tell()

    # The connection.

    async def _run(self) -> None:
        tasks = [asyncio.create_task(self._stay_connected()), asyncio.create_task(self._background())]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        except LineError as error:
            self._failure = error
            if self.connections:
                log.error("%s", error)
        except Exception as error:
            # An error of this package. Callers must not wait for ever.
            self._failure = LineError(self._place, f"internal error: {error!r}", "report it")
            self._failure.__cause__ = error
            log.exception("%s: internal error", self._place)
        finally:
            await stop(tasks)
            self._news.tell()
            self._ended()

    async def _stay_connected(self) -> None:
        pause, taken_over = FIRST_PAUSE, 0
        while True:
            began = None
            try:
                try:
                    async with asyncio.timeout(OPEN_TIMEOUT):
                        session = await self._transport.open(self.hello)
                except TimeoutError:
                    cure = "check that a node is at this address"
                    problem = f"{self._transport.reached} within {OPEN_TIMEOUT:g} s"
                    raise Lost(self._place, problem, cure) from None
                began = time.monotonic()
                await self._serve(session)
            except (Refused, BadReply) as error:
                is_lasting = not getattr(error, "may_pass", False)
                if (is_lasting and not self.connections) or getattr(error, "is_final", False):
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
        if self._trouble is not None:
            self._trouble = None
            self._warn(f"{self._place}: connected")
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
            await stop(tasks)
            self._outbox.clear()
            self._writes.clear()
            self._lost()
            self._news.tell()
            await session.close(flush=is_whole)

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
                    raise Lost(self._place, problem, "see what holds it up") from None
                self._sent(batch)
                self._news.tell()
            self._writes.clear()
            self._news.tell()

    async def _read(self, session: Session) -> None:
        bad = told = 0
        while True:
            try:
                message = await session.receive()
            except BadReply as error:
                bad += 1
                if bad >= MOST_BAD_REPLIES:
                    raise Lost(error.place, error.problem, error.cure) from None
                if not told:
                    self._warn(f"{error}; ignored, as is what follows it of this kind")
                told += 1
                # What comes without a pause must not keep others from their work.
                await asyncio.sleep(0)
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
        was_silent = False
        while True:
            times = list(self._status_times)
            if len(times) < 3:
                await asyncio.sleep(SILENCE / 5)
                continue
            period = statistics.median(b - a for a, b in itertools.pairwise(times))
            allowed = max(SILENCE, SILENT_PERIODS * period)
            left = self._heard_at + allowed - time.monotonic()
            if left <= 0 and not was_silent:
                # If this program was held up, what has come meanwhile is read now.
                was_silent = True
                await asyncio.sleep(READ_TIME)
                continue
            if left <= 0:
                problem = f"the node has sent nothing for {allowed:.1f} s"
                raise Lost(self._place, problem, "check the network and the node")
            was_silent = False
            await asyncio.sleep(left)


async def stop(tasks: list[asyncio.Task[None]]) -> None:
    """Cancels tasks and waits for their end, however they end."""
    for task in tasks:
        task.cancel()
    await asyncio.wait(tasks)
    for task in tasks:
        # Otherwise asyncio complains that nobody has looked.
        if not task.cancelled():
            task.exception()
