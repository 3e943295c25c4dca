"""A task in the hands of a robot's program."""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING

from .errors import BadMessage, TaskDropped
from .messages import Cancel, Point, Task, Verdict

if TYPE_CHECKING:
    from .robot import Robot

__all__ = ["Place", "Work"]

CLOCK_CHECK = 0.5
"""A wait for a moment by the clock looks at the clock at least this often [s]: it may be set."""

MOMENTS = ("earliest_start", "start", "latest_start", "meet_at", "free_at")

Place = Point | tuple[float, float]
"""A place in the belt frame: a `Point`, or `(x, y)` [m]."""


class Work:
    """A task in the hands of the program. Each ends with exactly one result: `picked`,
    `grasp_failed`, `missed`, `rejected` or `dropped`.

    Attributes:
        task: The task with its present times. The node may change them until the robot meets the
            item.
        cancel: The node's wish that the task is dropped; none so far.
        result: The result; none so far.
    """

    def __init__(self, robot: Robot, task: Task) -> None:
        self._robot = robot
        self.task = task
        self.cancel: Cancel | None = None
        self.result: Verdict | None = None
        self._is_taken = False
        # The fault in which the robot gave it up, even if that is over.
        self._fault: str | None = None
        # Whether the node that gave it has forgotten it.
        self._is_orphan = False

    @property
    def is_open(self) -> bool:
        """Whether the node waits for its result."""
        return self.result is None and not self._is_orphan

    @property
    def is_cancelled(self) -> bool:
        """Whether the node wants the task dropped. Then answer with `dropped`, or with the actual
        result if it was too late."""
        return self.cancel is not None

    async def until(self, moment: str) -> None:
        """Waits for a moment of the task: `start`, `meet_at` or `free_at`. If the node changes the
        times meanwhile, it waits for the new one.

        Raises:
            TaskDropped: The node wants the task dropped, or the robot was out of service.
        """
        if moment not in MOMENTS:
            raise BadMessage("`moment`", f"there is no `{moment}`", "give start, meet_at or free_at")
        while True:
            self.check()
            left = getattr(self.task, moment) - self._robot.clock()
            if left <= 0:
                return
            await self._change(min(left, CLOCK_CHECK))

    async def changed(self) -> Task:
        """Waits until the node changes the task, and returns it.

        Raises:
            TaskDropped: The node wants it dropped.
        """
        before = self.task
        while self.task is before:
            self.check()
            self._robot._check_open()
            await self._change(None)
        return self.task

    async def cancelled(self) -> Cancel:
        """Waits until the node wants the task dropped."""
        while self.cancel is None:
            self._robot._check_open()
            await self._change(None)
        return self.cancel

    async def _change(self, timeout: float | None) -> None:
        """Waits until the task changes, is cancelled, or some time [s] has passed."""
        task, cancel = self.task, self.cancel
        robot = self._robot
        was_open, fault = robot.is_open, self._fault
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                await robot._changes.until(
                    lambda: self.task is not task
                    or self.cancel is not cancel
                    or robot.is_open is not was_open
                    or self._fault is not fault
                )

    def check(self) -> None:
        """Raises `TaskDropped` if the node wants the task dropped, or the robot was out of service."""
        cure = "go back and report `dropped`, or the actual result if it was too late"
        if self.cancel is not None:
            raise TaskDropped(f"task {self.task.id}", f"cancelled: {self.cancel.reason}", cure)
        if self._fault is not None:
            problem = f"the robot was out of service: {self._fault}"
            raise TaskDropped(f"task {self.task.id}", problem, cure)

    def picked(self, *, available_at: float | None = None, found: Place | None = None) -> None:
        """The item is in the bin."""
        self.finish(Verdict.PICKED, available_at=available_at, found=found)

    def grasp_failed(self, *, available_at: float | None = None, found: Place | None = None) -> None:
        """The grasp failed; the item is still on the belt."""
        self.finish(Verdict.GRASP_FAIL, available_at=available_at, found=found)

    def missed(self, *, available_at: float | None = None, found: Place | None = None) -> None:
        """The robot came too late, or did not find the item."""
        self.finish(Verdict.MISSED, available_at=available_at, found=found)

    def rejected(self, *, available_at: float | None = None) -> None:
        """The robot refuses the task; the item is not offered to it again."""
        self.finish(Verdict.REJECTED, available_at=available_at)

    def dropped(self, *, available_at: float | None = None) -> None:
        """The robot has dropped the task: because the node wants it, or for its own reasons."""
        self.finish(Verdict.CANCELLED, available_at=available_at)

    def finish(
        self, verdict: Verdict, *, available_at: float | None = None, found: Place | None = None
    ) -> None:
        """Reports the result. It is kept, and sent again over the next connection if this one is
        lost, until the node shows that it has it.

        Args:
            verdict: The result. `PICKED` may follow another one, as its correction.
            available_at: When the robot can set out next [s]; by default now.
            found: Where the item would have been at `meet_at` if it had stayed on the belt,
                according to the robot [m].

        Raises:
            LineError: The task has another result.
            Overflow: Too many results wait for a connection.
        """
        self._robot._finish(self, verdict, available_at, found)

    def __repr__(self) -> str:
        state = self.result or ("cancelled" if self.cancel else "open")
        return f"<Work on task {self.task.id}, item {self.task.item!r}, {state}>"
