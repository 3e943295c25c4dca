"""Monitors, which watch a line, and operators, who give it orders."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Callable
from dataclasses import replace
from typing import Any, ClassVar

from .errors import BadMessage, Closed, LineError
from .messages import Answer, FromNode, Order, Role, Status, ToNode
from .peer import Peer

__all__ = ["Monitor", "Operator"]

MOST_KEPT = 1024
"""Messages that are kept for a program that does not read them."""


class Monitor(Peer):
    """Watches a line: it is sent everything and sends nothing.

        async with Monitor("127.0.0.1:7400") as monitor:
            async for status in monitor.statuses():
                print(status.picked, "of", status.seen)

    Args:
        address: As for `Peer`, as are the options.
        name: The monitor's name.
        keep: Messages kept for a program that is slower than the line.
    """

    role: ClassVar[Role] = Role.OBSERVER

    def __init__(
        self, address: str, name: str = "monitor", *, keep: int = MOST_KEPT, **options: Any
    ) -> None:
        super().__init__(address, name, **options)
        if keep < 1:
            raise BadMessage("`keep`", f"{keep} is out of range", "give at least 1")
        self._events: deque[FromNode] = deque(maxlen=keep)
        self.skipped = 0
        """Messages that were dropped because `messages` was not read in time."""
        self._is_read = False

    async def messages(self) -> AsyncIterator[FromNode]:
        """Every message from the node from now on: tasks, cancels, requests to the belt, statuses.
        If the caller is too slow, the oldest are dropped and counted in `skipped`."""
        if self._is_read:
            raise LineError(self._place, "its messages are read twice", "read them in one place")
        self._is_read = True
        try:
            while True:
                try:
                    await self._until(lambda: self._events)
                except Closed:
                    return
                yield self._events.popleft()
        finally:
            self._is_read = False
            self._events.clear()

    def _hear(self, message: FromNode) -> None:
        if self._is_read and not isinstance(message, Answer):
            if len(self._events) == self._events.maxlen:
                self.skipped += 1
            self._events.append(message)


DONE: dict[str, tuple[str, ...]] = {
    "pause": ("paused",),
    "resume": ("running",),
    "drain": ("draining", "drained"),
    "stop": ("stopped",),
}
"""The modes that an order leads to."""


class Operator(Peer):
    """Gives the operator's orders.

        async with Operator("127.0.0.1:7400") as operator:
            await operator.pause()

    Args:
        address: As for `Peer`, as are the options.
        name: The operator's name.
    """

    role: ClassVar[Role] = Role.OPERATOR

    def __init__(self, address: str, name: str = "operator", **options: Any) -> None:
        super().__init__(address, name, **options)
        self._orders: dict[str | None, Order] = {}

    async def pause(self, robot: str | None = None, timeout: float = 10.0) -> Status:
        """No new task is given; open ones are carried out."""
        return await self._order("pause", robot, timeout)

    async def resume(self, robot: str | None = None, timeout: float = 10.0) -> Status:
        """The line continues."""
        return await self._order("resume", robot, timeout)

    async def drain(self, robot: str | None = None, timeout: float = 10.0) -> Status:
        """Known items are picked, later ones pass; of a robot, the same as `pause`."""
        return await self._order("drain", robot, timeout)

    async def stop(self, robot: str | None = None, timeout: float = 10.0) -> Status:
        """No new task is given; open ones that have not reached their meeting point are
        cancelled."""
        return await self._order("stop", robot, timeout)

    async def _order(self, kind: str, robot: str | None, timeout: float) -> Status:
        """Gives an order, over the next connection too if this one is lost, and waits until a status
        shows it: the mode of the line; for a robot, whose order shows only while it is idle, the
        second status after it.

        Raises:
            LineError: No status shows it within `timeout` [s].
        """
        self._check_open()
        order = Order(kind, self.clock(), robot)
        if robot is not None and self.station_robots and robot not in self.station_robots:
            known = ", ".join(self.station_robots)
            raise BadMessage(f"`{kind}`", f"there is no robot `{robot}`", f"give one of {known}")
        self._orders[robot] = order
        shows = self._shows(order)
        self._push(order)
        try:
            async with asyncio.timeout(timeout):
                await self._until(lambda: self._orders.get(robot) is not order or shows())
            if self._orders.get(robot) is not order:
                problem = f"another order came before `{kind}` was confirmed"
                raise LineError(self._place, problem, "await one order before the next")
        except TimeoutError:
            problem = f"no status shows the order `{kind}` within {timeout:g} s"
            cure = "see the log of the node; it needs --status-every above 0"
            raise LineError(self._place, problem, cure) from self.last_trouble
        finally:
            if self._orders.get(robot) is order:
                del self._orders[robot]
        assert self.status is not None
        return self.status

    def _shows(self, order: Order) -> Callable[[], bool]:
        """Whether a status that came after an order shows it."""
        last, count, connection = self.status, 0, self.connections

        def shows() -> bool:
            nonlocal last, count, connection
            if connection != self.connections:
                # The order was given again.
                count, connection = 0, self.connections
            if self.status is last or not self._is_up:
                return False
            last, count = self.status, count + 1
            assert last is not None
            if order.robot is not None:
                return count >= 2
            return last.mode in DONE[order.kind]

        return shows

    def _greeting(self) -> list[ToNode]:
        return [replace(order, stamp=self.clock()) for order in self._orders.values()]
