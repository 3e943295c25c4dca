"""Robots: they carry out tasks and report the results."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any, ClassVar, Self

from .errors import BadMessage, Closed, LineError, Overflow, Refused, ResultsLost, TaskDropped, Unfinished
from .messages import (
    Ack,
    BeltState,
    Cancel,
    FromNode,
    Report,
    RobotState,
    RobotStatus,
    Role,
    Status,
    Task,
    ToNode,
    Verdict,
)
from .link import News
from .peer import Peer
from .results import Done, Results, is_other_task
from .work import Place, Work

__all__ = ["Robot"]

MOST_UNDELIVERED = 1000
"""Results that may wait for a connection. A node that is away gives no tasks, so they stay few."""

OLDEST = 50.0
"""A report with an older timestamp [s] is sent with the present one: the node refuses those of a
minute ago."""

STARTING = 30.0
"""For this time after its start [s] a controller may be sent tasks of an earlier one."""

NEWER = 1e-3
"""The difference of two timestamps that have an order [s]."""

MOST_WAITING = 1000
"""Tasks that wait for the program. A node gives one at a time."""

SLACK = 1e-3
"""A task may be taken this long after its `latest_start` [s]: clocks have a resolution."""

Handler = Callable[[Work], Awaitable["Verdict | None"]]


class Robot(Peer):
    """The controller of a robot.

        async with Robot("127.0.0.1:7400", "r1") as robot:
            async for work in robot:
                await arm.pick(work.task.meet, work.task.meet_at)
                work.picked()

    The robot is `idle` for the node while the program waits for the next task, and `busy`
    otherwise, until `fault` is called. A task is acknowledged when the program takes it. One that
    comes again is not carried out again: new times are adopted, and a result that the node has
    missed is sent again. A task whose `latest_start` has passed when the program could take it is
    rejected.

    A controller that has just started does not know what has come of the tasks before. So it tells
    the node of a fault first: items that the robot was on its way to return to the line, and those
    that it may have been holding are written off.

    Args:
        address: As for `Peer`, as are the options.
        robot: The robot's name in the node's station file.
        name: The name of the controller; by default the robot's.
        heartbeat: The robot's state is told after this time at the latest [s]. The node regards a
            robot as silent after ten times this, and at least a second.
    """

    role: ClassVar[Role] = Role.ROBOT

    def __init__(
        self,
        address: str,
        robot: str,
        *,
        name: str | None = None,
        heartbeat: float = 0.5,
        **options: Any,
    ) -> None:
        self.robot = robot
        super().__init__(address, robot if name is None else name, **options)
        if not 0 < heartbeat <= 60:
            raise BadMessage("`heartbeat`", f"{heartbeat} is out of range", "give more than 0 s, up to 60 s")
        self._heartbeat = heartbeat
        self._changes = News()
        self._waiting: deque[Work] = deque()
        self._work: Work | None = None
        self._results = Results()
        self._last_task: int | None = None
        self._left: dict[int, str] | None = None
        # Tasks that were decided before this time are those of an earlier controller [s].
        self._born: float | None = None
        self._began = 0.0
        self._available_at: float | None = None
        self.fault_reason: str | None = None
        """Why it is out of service; none if it is in service."""
        self._takes_tasks = False
        self._is_iterated = False
        self._is_leaving = False
        self._before: Status | None = None

    def _robots(self) -> tuple[str, ...]:
        return (self.robot,)

    # What the program sees.

    @property
    def work(self) -> Work | None:
        """The task in hand."""
        return self._work

    @property
    def undelivered(self) -> dict[int, Verdict]:
        """Results that the node has not shown to have, by task."""
        return {report.task: report.result for report in self._results.undelivered()}

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Work:
        """The next task. Ends when the robot is closed.

        Raises:
            Unfinished: The task before has no result yet.
            Refused: The node does not let this controller in any more.
        """
        if self._is_iterated:
            raise LineError(self._place, "its tasks are taken twice", "take them in one place")
        self._is_iterated = True
        try:
            while True:
                self._check_unfinished()
                work = self._next_work()
                if work is not None:
                    return work
                if not self._takes_tasks and self.fault_reason is None:
                    self._takes_tasks = True
                    self._say_state()
                await self._until(self._may_go_on)
        except Closed:
            raise StopAsyncIteration from None
        finally:
            self._is_iterated = False
            was_idle, self._takes_tasks = self._takes_tasks, False
            if was_idle and not self._is_working():
                # The caller was cancelled.
                self._say_state()

    def _may_go_on(self) -> bool:
        """Whether there is something to do for a program that waits for a task."""
        if self.fault_reason is not None or self._is_leaving:
            return False
        # After a fault it has to say again that it takes tasks.
        return bool(self._waiting) or not self._takes_tasks

    def _check_unfinished(self) -> None:
        work = self._work
        if work is not None and work.result is None:
            if self.fault_reason is not None:
                # The node has taken the task back. If the item got into the bin after all, the
                # program can still say so.
                return
            problem = f"task {work.task.id} has no result"
            cure = "call one of its picked, grasp_failed, missed, rejected and dropped first"
            raise Unfinished(self._place, problem, cure)

    def _next_work(self) -> Work | None:
        if self.fault_reason is not None or self._is_leaving:
            return None
        self._check_open()
        while self._waiting:
            work = self._waiting.popleft()
            if not work.is_open:
                continue
            now = self.clock()
            if now > work.task.latest_start + SLACK:
                self._conclude(Report(now, work.task.id, Verdict.REJECTED), work)
                continue
            work._is_taken = True
            self._work, self._last_task = work, work.task.id
            self._available_at = None
            self._push(Ack(now, work.task.id))
            return work
        return None

    async def run(self, handler: Handler) -> None:
        """Carries out tasks with `handler` until the robot is closed.

        Args:
            handler: A coroutine function that is given the `Work`. It returns the result, or calls
                one of the work's methods. If `TaskDropped` leaves it, the task is reported as
                `dropped`. If another exception does, the robot reports `fault`, because nobody
                knows where it and the item are, and the exception is raised.
        """
        async for work in self:
            try:
                verdict = await handler(work)
            except TaskDropped:
                if work.result is None:
                    work.dropped()
                continue
            except BaseException as error:
                if isinstance(error, Exception) or work.result is None:
                    self.fault(repr(error))
                raise
            if verdict is not None and verdict != work.result:
                work.finish(verdict)

    def fault(self, reason: str = "") -> None:
        """The robot is out of service until `ready` is called. Its items return to the others, but
        not one that it may be holding."""
        if self.fault_reason is None:
            self.fault_reason = reason or "fault"
            self._takes_tasks = False
            if self._work is not None and self._work.is_open:
                self._work._fault = self.fault_reason
            self._warn(f"{self._place}: out of service: {self.fault_reason}")
        self._say_state()
        self._changes.tell()

    def ready(self) -> None:
        """The robot is in service again, at its bin."""
        if self.fault_reason is not None:
            self.fault_reason = None
            if self._work is not None and self._work.result is None:
                # The node takes it back when it hears of the fault, which it may not have done.
                now = self.clock()
                self._conclude(Report(now, self._work.task.id, Verdict.CANCELLED), None)
                self._work = None
            self._warn(f"{self._place}: in service again")
        self._say_state()
        self._changes.tell()
        self._news.tell()

    async def report_belt(
        self, speed: float, position: float | None = None, stamp: float | None = None
    ) -> None:
        """Reports how the belt moves, for a controller that has the encoder; see `Belt.report`."""
        self._check_open()
        self._check_room(1, MOST_UNDELIVERED)
        stamp = self.clock() if stamp is None else stamp
        self._push(BeltState(stamp, speed, position, self.name))
        await asyncio.sleep(0)

    async def settle(self, timeout: float = 10.0) -> None:
        """Waits until the node has shown that it has all results. It shows that in its statuses.

        Raises:
            Overflow: It did not within `timeout` [s].
        """
        try:
            async with asyncio.timeout(timeout):
                await self._until(lambda: not self._results)
        except TimeoutError:
            problem = f"{len(self._results)} results are not confirmed after {timeout:g} s"
            raise Overflow(self._place, problem, "see `last_trouble`") from self.last_trouble

    # What the node sees.

    def _state(self) -> RobotStatus:
        now = self.clock()
        state, available_at = RobotState.BUSY, None
        if self.fault_reason is not None:
            state = RobotState.FAULT
        elif self._is_working():
            pass
        elif self._takes_tasks and not self._is_leaving:
            state = RobotState.IDLE
            if self._available_at is not None and self._available_at > now:
                # An `idle` without this would end the wait that the result has announced.
                state, available_at = RobotState.BUSY, self._available_at
        return RobotStatus(now, self.robot, state, available_at, self._last_task)

    def _is_working(self) -> bool:
        has_work = self._work is not None and self._work.result is None
        return has_work or any(work.is_open for work in self._waiting)

    def _say_state(self) -> None:
        self._push(self._state())

    async def _background(self) -> None:
        while True:
            await asyncio.sleep(self._heartbeat)
            self._say_state()

    def _greeting(self) -> list[ToNode]:
        self._results.forget_old()
        messages: list[ToNode] = [self._fresh(report) for report in self._results.undelivered()]
        # After the results: a state that is older than a result says nothing.
        state = self._state()
        if self._born is None:
            # A state ends a fault if it is newer.
            self._born, self._began = max(0.0, state.stamp - NEWER), time.monotonic()
            messages.append(RobotStatus(self._born, self.robot, RobotState.FAULT))
        messages.append(state)
        return messages

    def _fresh(self, report: Report) -> Report:
        now = self.clock()
        if now - report.stamp <= OLDEST:
            return report
        return replace(report, stamp=now, available_at=None)

    def _lost(self) -> None:
        self._results.lost()
        # Nobody has acknowledged these, so the node may give their items to others. If it does not,
        # it sends them again.
        self._waiting.clear()

    def _sent(self, messages: list[ToNode]) -> None:
        self._results.wrote(message for message in messages if isinstance(message, Report))

    def _hear(self, message: FromNode) -> None:
        if isinstance(message, Status):
            self._hear_status(message)
        elif isinstance(message, Task) and message.robot == self.robot:
            self._hear_task(message)
        elif isinstance(message, Cancel) and message.robot == self.robot:
            self._hear_cancel(message)

    def _hear_task(self, task: Task) -> None:
        done = self._results.get(task.id)
        if done is not None:
            if done.is_of(task):
                # The node has not received the result.
                self._send_again(done)
                return
            self._forget_task(task.id)
        work = self._known_work(task.id)
        if work is not None and is_other_task(work.task, task):
            self._forget_task(task.id)
            work = None
        if work is not None:
            # MQTT may deliver an older revision after a newer one.
            if task.revision > work.task.revision:
                work.task = task
                self._changes.tell()
            if work._is_taken:
                self._push(Ack(self.clock(), task.id))
            return
        if self._is_of_an_earlier_controller(task):
            # The fault at the start takes it back; then the node asks to drop it.
            return
        if len(self._waiting) < MOST_WAITING:
            self._waiting.append(Work(self, task))

    def _is_of_an_earlier_controller(self, task: Task) -> bool:
        # Later on its clock may be set back; the node knows of the fault then.
        is_new = time.monotonic() - self._began < STARTING
        return is_new and self._born is not None and task.decided_at < self._born

    def _known_work(self, task: int) -> Work | None:
        for work in (self._work, *self._waiting):
            if work is not None and work.task.id == task and work.is_open:
                return work
        return None

    def _hear_cancel(self, cancel: Cancel) -> None:
        done = self._results.get(cancel.task)
        if done is not None:
            self._send_again(done)
            return
        work = self._known_work(cancel.task)
        if work is None or not work._is_taken:
            # It was not begun, or is not known: perhaps it was given up in a fault.
            if work is not None:
                work.cancel = cancel
            self._conclude(Report(self.clock(), cancel.task, Verdict.CANCELLED), work)
        elif self.fault_reason is not None:
            work.cancel = cancel
            self._changes.tell()
            self._conclude(Report(self.clock(), cancel.task, Verdict.CANCELLED), None)
        elif work.cancel is None:
            work.cancel = cancel
            self._changes.tell()

    def _hear_status(self, status: Status) -> None:
        names = [robot.name for robot in status.robots]
        if names and self.robot not in names:
            # Over TCP the hello was refused; over MQTT nobody has looked.
            known = ", ".join(names)
            problem = f"the node has no robot `{self.robot}`"
            raise Refused(self._place, problem, f"give one of {known}", problem, is_final=True)
        before, self._before = self._before, status
        if before is not None and status.picked < before.picked and status.stamp > before.stamp:
            # What it does not know of, it does not ask for, and the numbers may mean other tasks.
            # If it still knows an earlier task, it sends it again, and is answered.
            self._results.give_up()
            self._tell_started_over()
        for report in self._results.hear(status):
            self._push(self._fresh(report))

    def _send_again(self, done: Done) -> None:
        self._push(self._fresh(self._results.ask_again(done)))

    def _forget_task(self, task: int) -> None:
        """The node has begun anew, without its journal: this number means another task now."""
        self._tell_started_over()
        self._results.forget(task)
        for work in (self._work, *self._waiting):
            if work is not None and work.task.id == task:
                work._is_orphan = True
        if self._last_task == task:
            self._last_task = None

    def _tell_started_over(self) -> None:
        self._warn_once(
            "journal",
            f"{self._place}: the node has started over, so earlier tasks are forgotten; "
            "run it with --journal",
        )

    def _finish(
        self, work: Work, verdict: Verdict, available_at: float | None, found: Place | None
    ) -> None:
        self._check_open()
        now = self.clock()
        report = Report(now, work.task.id, verdict, available_at, found)  # type: ignore[arg-type]
        if work.result is not None and (
            work.result == report.result or report.result != Verdict.PICKED
        ):
            problem = f"it has the result {work.result}, and is given {report.result}"
            raise LineError(f"task {work.task.id}", problem, "report one result of each task")
        if len(self._results) >= MOST_UNDELIVERED:
            problem = f"{len(self._results)} results wait for a connection"
            raise Overflow(self._place, problem, "see `last_trouble`") from self.last_trouble
        self._conclude(report, work)
        if work is self._work:
            self._available_at = available_at

    def _conclude(self, report: Report, work: Work | None) -> None:
        """Keeps a result and sends it."""
        if work is not None:
            work.result = report.result
            if work._is_orphan:
                # Its number means another task now.
                self._news.tell()
                return
            self._last_task = report.task
        self._results.put(report, None if work is None else work.task)
        self._push(report)
        self._news.tell()

    # The end.

    async def _farewell(self) -> None:
        self._is_leaving = True
        if self._is_working():
            # The node need not wait for a result that will not come.
            self.fault("the program ends with a task in hand")
        else:
            self._say_state()
        await super()._farewell()
        self._left = self._results.unwritten()

    def _check_delivered(self) -> None:
        left = self._results.unwritten() if self._left is None else self._left
        if left:
            known = ", ".join(f"{task}: {result}" for task, result in left.items())
            problem = f"closed without a connection; the node may not have these results: {known}"
            raise ResultsLost(self._place, problem, "close the robot while the node is there", left)

    def _ended(self) -> None:
        self._changes.tell()
