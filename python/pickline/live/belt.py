"""Belts: encoders and drives, which report how the belt moves."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import replace
from typing import Any, ClassVar

from .errors import BadMessage, Closed, Overflow
from .messages import BeltRequest, BeltState, FromNode, Role, Tick, ToNode
from .peer import Peer

__all__ = ["Belt"]

FRESH = 1.0
"""A report that is not older still tells where a moving belt is [s]."""

MOST_WAITING = 1000
"""Reports that wait for a node which takes none, before `report` refuses more."""

MOST_REQUESTS = 64
"""Requests that nobody has read; older ones are dropped, because a new one replaces them."""


class Belt(Peer):
    """The encoder or the drive of a belt.

        async with Belt("127.0.0.1:7400", "encoder") as belt:
            await belt.report(speed=0.35, position=17.204)

    An encoder, which reports a position, has to report at least once a second; a drive may report
    changes only. After a lost connection the last report is told again, unless it is that of an
    encoder and too old to tell where the belt is now.

    Args:
        address: As for `Peer`, as are the options.
        name: The name of the encoder.
    """

    role: ClassVar[Role] = Role.ENCODER

    def __init__(self, address: str, name: str = "encoder", **options: Any) -> None:
        super().__init__(address, name, **options)
        self.last: BeltState | None = None
        """The newest report."""
        self._requests: deque[BeltRequest] = deque(maxlen=MOST_REQUESTS)

    async def report(
        self, speed: float, position: float | None = None, stamp: float | None = None
    ) -> None:
        """Reports how the belt moves.

        Args:
            speed: Its speed [m/s]; 0 is a stop, negative is backwards.
            position: How far it has travelled by the encoder, from any zero [m].
            stamp: When that was measured [s]; by default now.

        Raises:
            BadMessage: The node would refuse a value.
            Overflow: The node takes nothing.
            Refused: The node does not let this encoder in any more.
        """
        self._check_open()
        stamp = self.clock() if stamp is None else stamp
        state = BeltState(stamp, speed, position, self.name)
        self._check_room(1, MOST_WAITING)
        self.last = state
        self._push(state)
        await asyncio.sleep(0)

    async def follow(
        self,
        measure: Callable[[], float | tuple[float, float] | Awaitable[float | tuple[float, float]]],
        every: float = 0.02,
    ) -> None:
        """Reports again and again, until it is cancelled or the node does not let this encoder in
        any more. While the node takes nothing, reports are dropped.

        Args:
            measure: Returns the speed [m/s], or speed and position [m]; may be a coroutine
                function.
            every: Time between two reports [s].
        """
        if not 0 < every <= 60:
            raise BadMessage("`every`", f"{every} is out of range", "give more than 0 s, up to 60 s")
        loop = asyncio.get_running_loop()
        due = loop.time()
        while True:
            found = measure()
            if isinstance(found, Awaitable):
                found = await found
            speed, position = found if isinstance(found, tuple) else (found, None)
            try:
                await self.report(speed, position)
            except Overflow as error:
                # The connection is given up if this goes on. Old reports are worth nothing then.
                self._warn_once("overflow", str(error))
            # Without drift; but what was missed is not made up for.
            due = max(due + every, loop.time())
            await asyncio.sleep(due - loop.time())

    async def tick(self, stamp: float) -> None:
        """Tells a node with `--clock messages` that time has come this far."""
        self._check_open()
        self._push(Tick(stamp))
        await asyncio.sleep(0)

    async def requests(self) -> AsyncIterator[BeltRequest]:
        """What the node asks of the drive, with `--may-stop-belt`. The drive need not follow; what
        it does, it reports."""
        while True:
            try:
                await self._until(lambda: self._requests)
            except Closed:
                return
            yield self._requests.popleft()

    def _greeting(self) -> list[ToNode]:
        last, now = self.last, self.clock()
        if last is None:
            return []
        if 0 <= now - last.stamp <= FRESH:
            return [last]
        if last.position is None or last.speed == 0.0:
            return [replace(last, stamp=now)]
        # The next report tells where the belt is. A guess would misplace every item.
        return []

    def _hear(self, message: FromNode) -> None:
        if isinstance(message, BeltRequest):
            self._requests.append(message)
