"""The results of a robot: kept until the node has them, and longer for a node that asks again.

The protocol does not acknowledge a result. What is lost with a connection is sent again over the
next one; what is lost behind the connection, in a broker or a node that is killed, shows because
the node's statuses go on to list the task as open, or because the node sends the task again.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from .messages import Report, Status, Task, Verdict

__all__ = ["Done", "Results", "is_other_task"]

MOST_RESULTS = 10_000
"""Results that are kept for a node that sends a task again."""

CONFIRMING = 2
"""A result has arrived if so many later statuses do not list its task as open. The first may have
been on its way."""

REPEATING = 5
"""A result is sent again if so many later statuses list its task as open."""

USEFUL = 180.0
"""The node takes no result that is later than this [s], so it need not be kept as undelivered."""

DECIDED_AGAIN = 1.0
"""A known task that was decided so much earlier or later [s] is another one, or a clock was set."""

SAME = 1e-4
"""Two times [s] or positions [m] of one task differ by less."""


FACTS = (Verdict.PICKED, Verdict.GRASP_FAIL, Verdict.MISSED)
"""Results that tell what has become of an item."""


@dataclass
class Done:
    """A task that is over.

    Attributes:
        report: Its result.
        task: The task; none if only its cancel was received.
        written: When the result was handed to the present connection, by the steady clock [s]; none
            if it was not.
        without: Statuses since then that do not list the task as open.
        listed: Statuses since then that do.
    """

    report: Report
    task: Task | None
    written: float | None = None
    without: int = 0
    listed: int = 0

    def is_of(self, task: Task) -> bool:
        """Whether it is the result of `task`, and not of an earlier one with the same number."""
        if self.task is not None:
            return not is_other_task(self.task, task)
        return task.decided_at - self.report.stamp <= DECIDED_AGAIN


def is_other_task(known: Task, task: Task) -> bool:
    """Whether `task` is another one than that known under its number, because the node has started
    over without its journal.

    The times of one task all move by the same when a clock is set. Its item may get another name,
    but in a higher revision only. MQTT may deliver an older revision after a newer one.
    """
    if abs(task.decided_at - known.decided_at) <= DECIDED_AGAIN:
        return False
    if task.revision > known.revision:
        return task.item != known.item
    return task.revision < known.revision or any(
        abs(now - before) > SAME for now, before in zip(_shape(task), _shape(known), strict=True)
    )


def _shape(task: Task) -> tuple[float, ...]:
    """What is the same of a task whatever the clock says."""
    since = task.decided_at
    return (task.meet.x, task.meet.y, task.start - since, task.meet_at - since, task.free_at - since)


class Results:
    """The results of one robot, by task."""

    def __init__(self) -> None:
        self._all: OrderedDict[int, Done] = OrderedDict()
        self._undelivered: dict[int, Done] = {}

    def get(self, task: int) -> Done | None:
        """The result of a task, if it has one that is still known."""
        return self._all.get(task)

    def undelivered(self) -> Iterator[Report]:
        """The results that the node has not shown to have, the oldest first."""
        return (done.report for done in list(self._undelivered.values()))

    def unwritten(self) -> dict[int, str]:
        """Those that were not even handed to the present connection, and that only the robot knows:
        without a `CANCELLED` or a `REJECTED` the node waits for a while and finds the same."""
        return {
            task: str(done.report.result)
            for task, done in self._undelivered.items()
            if done.written is None and done.report.result in FACTS
        }

    def __len__(self) -> int:
        """Number of results that the node has not shown to have."""
        return len(self._undelivered)

    def put(self, report: Report, task: Task | None) -> None:
        """A result, to be delivered from now on."""
        done = self._all[report.task] = Done(report, task)
        self._all.move_to_end(report.task)
        self._undelivered[report.task] = done
        while len(self._all) > MOST_RESULTS:
            self._all.popitem(last=False)

    def ask_again(self, done: Done) -> Report:
        """The node does not have it: it counts as undelivered again. Returns what to send."""
        self._undelivered[done.report.task] = done
        done.written, done.without, done.listed = None, 0, 0
        return done.report

    def forget(self, task: int) -> None:
        """Its number means another task now."""
        self._all.pop(task, None)
        self._undelivered.pop(task, None)

    def give_up(self) -> int:
        """The node has started over and does not wait for results. Returns how many there were."""
        count = len(self._undelivered)
        self._undelivered.clear()
        return count

    def wrote(self, reports: Iterable[Report]) -> None:
        """These were handed to the present connection."""
        for report in reports:
            done = self._undelivered.get(report.task)
            if done is not None and done.report.result == report.result:
                done.written, done.without, done.listed = time.monotonic(), 0, 0

    def lost(self) -> None:
        """The connection is lost, and perhaps what was handed to it."""
        for done in self._undelivered.values():
            done.written, done.without, done.listed = None, 0, 0

    def hear(self, status: Status) -> list[Report]:
        """Takes note of what a status shows. Returns the results that have to be sent again."""
        is_open = set(status.open_tasks)
        again = []
        for task, done in list(self._undelivered.items()):
            if done.written is None:
                continue
            if task in is_open:
                done.without, done.listed = 0, done.listed + 1
                if done.listed >= REPEATING:
                    again.append(self.ask_again(done))
            else:
                done.without += 1
                if done.without >= CONFIRMING:
                    del self._undelivered[task]
        self.forget_old()
        return again

    def forget_old(self) -> None:
        """Takes results as delivered that the node would not take any more. Without statuses nothing
        else shows that it has them."""
        now = time.monotonic()
        for task, done in list(self._undelivered.items()):
            if done.written is not None and now - done.written > USEFUL:
                del self._undelivered[task]
