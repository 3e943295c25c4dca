"""A robot's side of the protocol, against a node that does what a test says."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
import traceback
from collections.abc import Callable

import pytest

from live_support import FakeNode, eventually, hear, run, say
from test_live_connection import STATUS

from pickline.live import (
    LineError,
    Overflow,
    Refused,
    ResultsLost,
    Robot,
    TaskDropped,
    Unfinished,
    Verdict,
    Work,
)


class Line:
    """A node for one robot: keeps what it hears, and says what a test tells it to."""

    def __init__(self) -> None:
        self.heard: list[dict] = []
        self.hellos: list[dict] = []
        self.writer: asyncio.StreamWriter | None = None
        self.fake = FakeNode(self._serve)
        self.welcome: Callable[[], None] = lambda: None

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.hellos.append(await hear(reader))
        self.writer = writer
        say(writer, kind="hello", accepted=True, robots=["r1"])
        self.welcome()
        while True:
            self.heard.append(await hear(reader))

    def task(self, number: int, revision: int = 0, **changes: object) -> dict:
        now = time.time()
        task = {
            "kind": "task",
            "id": number,
            "revision": revision,
            "robot": "r1",
            "item": f"i{number}",
            "decided_at": now,
            "start": now,
            "earliest_start": now,
            "latest_start": now + 60,
            "meet_at": now,
            "meet": {"x": 1.0, "y": 0.0},
            "bin": {"x": 1.0, "y": 0.7},
            "free_at": now,
            "priority": 1.0,
            "strategy": "test",
        }
        task.update(changes)
        say(self.writer, **task)
        return task

    def cancel(self, number: int) -> None:
        say(self.writer, kind="cancel", stamp=time.time(), task=number, robot="r1", reason="the belt stopped")

    def status(self, **changes: object) -> None:
        say(self.writer, **{**STATUS, "stamp": time.time(), **changes})

    def drop(self) -> None:
        """Ends the connection."""
        self.writer.transport.abort()

    def of(self, kind: str) -> list[dict]:
        return [message for message in self.heard if message["kind"] == kind]

    async def until(self, kind: str, count: int) -> list[dict]:
        await eventually(lambda: len(self.of(kind)) >= count, f"{count} x {kind}")
        return self.of(kind)

    async def idle(self) -> None:
        """Waits until the robot says that it takes tasks, from now on."""
        before = len(self.of("robot"))
        said = lambda: any(one["state"] == "idle" for one in self.of("robot")[before:])
        await eventually(said, "an idle robot")


def play(test: Callable[[Line, Robot], object], **options: object) -> None:
    """Runs a test with a line and an open robot."""

    async def played() -> None:
        line = Line()
        async with line.fake:
            async with Robot(line.fake.address, "r1", heartbeat=0.02, **options) as robot:
                await test(line, robot)  # type: ignore[misc]

    run(played())


async def take(robot: Robot) -> Work:
    return await anext(robot)


def test_a_task_is_acknowledged_when_it_is_taken_and_has_a_result() -> None:
    async def test(line: Line, robot: Robot) -> None:
        await line.until("robot", 3)
        # A controller that has just started does not know what has come of earlier tasks, and takes
        # no tasks before the program asks for one.
        states = line.of("robot")
        assert [one["state"] for one in states[:3]] == ["fault", "busy", "busy"]
        assert states[0]["stamp"] < states[1]["stamp"]
        taking = asyncio.create_task(take(robot))
        await line.idle()
        sent = line.task(7)
        work = await taking
        (ack,) = await line.until("ack", 1)
        assert ack["task"] == 7 and work.task.item == sent["item"]
        await eventually(lambda: line.of("robot")[-1].get("task") == 7, "its task in the state")
        assert line.of("robot")[-1]["state"] == "busy"
        work.picked(available_at=time.time() + 30, found=(1.01, 0.0))
        (result,) = await line.until("result", 1)
        assert result["task"] == 7 and result["result"] == "PICKED" and result["found"] == {"x": 1.01, "y": 0.0}
        # It is not free before the time that it has announced.
        taking = asyncio.create_task(take(robot))
        await eventually(lambda: "available_at" in line.of("robot")[-1], "a time in the state")
        assert line.of("robot")[-1]["state"] == "busy"
        assert line.of("robot")[-1]["available_at"] == result["available_at"]
        taking.cancel()

    play(test)


def test_a_task_that_comes_again_is_not_carried_out_twice() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        first = line.task(7)
        work = await taking
        line.task(7, 1, decided_at=first["decided_at"], meet_at=first["meet_at"] + 5)
        # An older revision after a newer one, as MQTT may deliver it.
        line.task(7, 0, decided_at=first["decided_at"])
        await line.until("ack", 3)
        assert work.task.revision == 1 and work.task.meet_at == first["meet_at"] + 5
        work.picked()
        await line.until("result", 1)
        taking = asyncio.create_task(take(robot))
        line.task(7, 2, decided_at=first["decided_at"])
        results = await line.until("result", 2)
        assert results[0] == results[1]
        assert not taking.done() and len(line.of("ack")) == 3
        taking.cancel()

    play(test)


def test_results_are_sent_over_the_next_connection_until_a_status_shows_them() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.task(7)
        work = await taking
        await line.until("ack", 1)
        line.drop()
        await eventually(lambda: not robot.is_connected, "the lost connection")
        work.picked()
        assert robot.undelivered == {7: Verdict.PICKED}
        await line.until("result", 1)
        line.drop()
        await line.until("result", 2)
        # A status that lists the task does not show the result, nor does a single one without it.
        line.status(open_tasks=[7])
        line.status(open_tasks=[])
        line.status(open_tasks=[7])
        line.status(open_tasks=[])
        seen = robot.status
        await eventually(lambda: robot.status is not seen, "statuses")
        with pytest.raises(Overflow, match="not confirmed"):
            await robot.settle(0.1)
        line.status(open_tasks=[])
        await robot.settle()
        assert not robot.undelivered
        line.drop()
        await eventually(lambda: len(line.hellos) == 4, "another connection")
        await line.until("robot", len(line.of("robot")) + 3)
        assert len(line.of("result")) == 2

    play(test)


def test_a_result_that_was_lost_behind_the_connection_is_sent_again() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.task(7)
        (await taking).missed()
        await line.until("result", 1)
        for _ in range(6):
            line.status(open_tasks=[7])
        await line.until("result", 2)

    play(test)


def test_tasks_that_nobody_has_acknowledged_are_forgotten_with_the_connection() -> None:
    async def test(line: Line, robot: Robot) -> None:
        await eventually(lambda: line.writer, "a connection")
        line.task(7)
        await eventually(lambda: robot._waiting, "the task")
        line.drop()
        await eventually(lambda: len(line.hellos) > 1, "another connection")
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.task(8)
        work = await taking
        assert work.task.id == 8 and [ack["task"] for ack in await line.until("ack", 1)] == [8]
        work.picked()

    play(test)


def test_a_task_in_hand_goes_on_while_there_is_no_connection() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        sent = line.task(7)
        work = await taking
        await line.until("ack", 1)
        # The node sends it again as it stands.
        line.welcome = lambda: line.task(**{"number": 7, "decided_at": sent["decided_at"]})
        line.drop()
        await line.until("ack", 2)
        assert robot.work is work and work.is_open
        assert line.of("robot")[-1]["state"] == "busy"
        work.picked()
        await line.until("result", 1)

    play(test)


def test_a_task_that_comes_too_late_is_rejected() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.task(7, latest_start=time.time() - 1)
        (result,) = await line.until("result", 1)
        assert (result["task"], result["result"]) == (7, "REJECTED") and not line.of("ack")
        line.task(8)
        assert (await taking).task.id == 8
        robot.work.picked()

    play(test)


def test_cancels() -> None:
    async def test(line: Line, robot: Robot) -> None:
        # Of a task that was never received, and that arrives after its cancel.
        await eventually(lambda: line.writer, "a connection")
        line.cancel(6)
        (result,) = await line.until("result", 1)
        assert (result["task"], result["result"]) == (6, "CANCELLED")
        line.task(6)
        await line.until("result", 2)
        # Of one that was not taken yet.
        line.task(7)
        line.cancel(7)
        results = await line.until("result", 3)
        assert (results[2]["task"], results[2]["result"]) == (7, "CANCELLED")
        # Of one in hand: the program decides.
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.task(8, meet_at=time.time() + 1000)
        work = await taking
        waiting = asyncio.create_task(work.until("meet_at"))
        cancelled = asyncio.create_task(work.cancelled())
        line.cancel(8)
        line.cancel(8)
        with pytest.raises(TaskDropped, match="the belt stopped"):
            await waiting
        assert (await cancelled).task == 8 and work.is_cancelled
        with pytest.raises(TaskDropped):
            await work.changed()
        work.dropped(available_at=time.time() + 1)
        results = await line.until("result", 4)
        assert results[3]["result"] == "CANCELLED"
        # Of one that is done.
        line.cancel(8)
        assert (await line.until("result", 5))[4] == results[3]

    play(test)


def test_waits_follow_the_task() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        first = line.task(7, meet_at=time.time() + 1000)
        work = await taking
        waiting = asyncio.create_task(work.until("meet_at"))
        changed = asyncio.create_task(work.changed())
        line.task(7, 1, decided_at=first["decided_at"], meet_at=time.time() - 1)
        await waiting
        assert (await changed).revision == 1
        with pytest.raises(LineError, match="moment"):
            await work.until("lunch")
        work.picked()

    play(test)


def test_a_handler() -> None:
    async def test(line: Line, robot: Robot) -> None:
        async def handle(work: Work) -> Verdict | None:
            if work.task.id == 1:
                return Verdict.PICKED
            if work.task.id == 2:
                work.grasp_failed()
                return None
            if work.task.id == 3:
                await work.until("meet_at")
            raise RuntimeError("arm 7 has lost its drive")

        running = asyncio.create_task(robot.run(handle))
        await line.idle()
        line.task(1)
        await line.until("result", 1)
        line.task(2)
        await line.until("result", 2)
        line.task(3, meet_at=time.time() + 1000)
        await line.until("ack", 3)
        line.cancel(3)
        results = await line.until("result", 3)
        assert [one["result"] for one in results] == ["PICKED", "GRASP_FAIL", "CANCELLED"]
        await line.idle()
        line.task(4)
        with pytest.raises(RuntimeError, match="drive"):
            await running
        await eventually(lambda: line.of("robot")[-1]["state"] == "fault", "a fault")
        # The node takes the task back; then the robot is repaired.
        line.cancel(4)
        results = await line.until("result", 4)
        assert (results[3]["task"], results[3]["result"]) == (4, "CANCELLED")
        running = asyncio.create_task(robot.run(handle))
        states = len(line.of("robot"))
        await line.until("robot", states + 3)
        assert all(one["state"] == "fault" for one in line.of("robot")[states:])
        robot.ready()
        await line.idle()
        line.task(1, 1, item="i1")
        await line.until("result", 6)
        running.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await running

    play(test)


def test_an_item_that_reaches_the_bin_in_a_fault_is_not_lost() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.task(7)
        work = await taking
        robot.fault("safety door")
        line.cancel(7)
        await line.until("result", 1)
        work.picked()
        results = await line.until("result", 2)
        assert [one["result"] for one in results] == ["CANCELLED", "PICKED"]

    play(test)


def test_a_fault_ends_the_waits_of_a_task() -> None:
    async def test(line: Line, robot: Robot) -> None:
        async def handle(work: Work) -> None:
            await work.until("meet_at")

        running = asyncio.create_task(robot.run(handle))
        await line.idle()
        line.task(7, meet_at=time.time() + 1000)
        await line.until("ack", 1)
        # However short it is: the node takes the task back.
        robot.fault("safety door")
        robot.ready()
        results = await line.until("result", 1)
        assert {(one["task"], one["result"]) for one in results} == {(7, "CANCELLED")}
        await line.idle()
        line.task(8, meet_at=time.time() + 1000)
        await line.until("ack", 2)
        # The faults were told once over the first connection, and this one.
        line.drop()
        await eventually(lambda: len(line.hellos) > 1, "another connection")
        count = len(line.of("robot"))
        await line.until("robot", count + 3)
        assert all(one["state"] == "busy" for one in line.of("robot")[count:])
        line.cancel(8)
        await eventually(lambda: any(one["task"] == 8 for one in line.of("result")), "the end of 8")
        running.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await running

    play(test)


def test_tasks_of_an_earlier_controller_are_not_carried_out() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.task(7, decided_at=time.time() - 10)
        line.cancel(7)
        (result,) = await line.until("result", 1)
        assert (result["task"], result["result"]) == (7, "CANCELLED")
        line.task(8)
        assert (await taking).task.id == 8
        robot.work.picked()

    play(test)


def test_tasks_have_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    from pickline.live import robot as module

    monkeypatch.setattr(module, "MOST_WAITING", 3)

    async def test(line: Line, robot: Robot) -> None:
        await eventually(lambda: line.writer, "a connection")
        for number in range(1, 6):
            line.task(number)
        line.status()
        await eventually(lambda: robot.status, "the status after them")
        assert len(robot._waiting) == 3

    play(test)


def test_a_robot_that_the_station_does_not_have() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        other = {"name": "r2", "state": "idle", "picked": 0, "failed": 0}
        line.status(robots=[{**other, "name": "r1"}, other])
        await eventually(lambda: robot.status, "a status")
        line.status(robots=[other])
        with pytest.raises(Refused, match="no robot `r1`"):
            await taking
        with pytest.raises(Refused) as caught:
            await take(robot)
        depth = len(list(traceback.walk_tb(caught.tb)))
        for _ in range(50):
            with pytest.raises(Refused) as caught:
                await take(robot)
        assert len(list(traceback.walk_tb(caught.tb))) == depth
        assert not robot.is_open

    play(test)


def test_one_result_of_each_task() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.task(7)
        work = await taking
        with pytest.raises(Unfinished, match="task 7"):
            await take(robot)
        work.missed()
        with pytest.raises(LineError, match="MISSED"):
            work.missed()
        with pytest.raises(LineError, match="GRASP_FAIL"):
            work.grasp_failed()
        # But a pick that shows late is a correction.
        work.picked()
        results = await line.until("result", 2)
        assert [one["result"] for one in results] == ["MISSED", "PICKED"]
        with pytest.raises(LineError, match="PICKED"):
            work.picked()
        taking = asyncio.create_task(take(robot))
        await line.idle()
        with pytest.raises(LineError, match="twice"):
            await take(robot)
        taking.cancel()

    play(test)


def test_a_cancelled_program_takes_no_task() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        taking.cancel()
        await eventually(lambda: line.of("robot")[-1]["state"] == "busy", "a busy robot")
        line.task(7)
        await eventually(lambda: robot._waiting, "the task")
        # The state must not acknowledge what the program has not taken.
        states = len(line.of("robot"))
        await line.until("robot", states + 3)
        assert all(one.get("task") != 7 for one in line.of("robot"))
        work = await take(robot)
        assert work.task.id == 7
        work.picked()

    play(test)


def test_a_node_that_starts_over_gives_its_numbers_to_other_tasks(caplog: pytest.LogCaptureFixture) -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.task(1)
        (await taking).picked()
        await line.until("result", 1)
        taking = asyncio.create_task(take(robot))
        await line.idle()
        # The same number, but another task: it must not be answered with the old result.
        line.task(1, decided_at=time.time() + 20)
        work = await taking
        await line.until("ack", 2)
        assert len(line.of("result")) == 1
        # And again, while it is in hand: its result belongs to nobody then.
        line.task(1, decided_at=time.time() + 50)
        await eventually(lambda: not work.is_open, "a forgotten task")
        work.picked()
        second = await take(robot)
        assert second.task.id == 1 and second is not work and len(line.of("result")) == 1
        second.missed()
        results = await line.until("result", 2)
        assert results[1]["result"] == "MISSED"

    with caplog.at_level(logging.WARNING, "pickline.live"):
        play(test)
    assert any("--journal" in record.message for record in caplog.records)


def test_a_clock_that_is_set_makes_no_other_task() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        first = line.task(7, meet_at=time.time() + 1000)
        work = await taking
        await line.until("ack", 1)
        moments = ("decided_at", "start", "earliest_start", "latest_start", "meet_at", "free_at")
        # The node sends it as it stands, and then in a new revision.
        line.task(7, **{name: first[name] + 3600 for name in moments})
        line.task(7, 1, **{name: first[name] - 3600 for name in moments})
        await line.until("ack", 3)
        assert work.is_open and work.task.revision == 1 and not robot._waiting
        work.picked()
        line.task(7, 1, **{name: first[name] for name in moments})
        await line.until("result", 2)
        assert not robot._waiting

    play(test)


def test_results_for_a_node_that_has_started_over_are_not_sent() -> None:
    async def test(line: Line, robot: Robot) -> None:
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.status(picked=5)
        line.task(7)
        (await taking).picked()
        await line.until("result", 1)
        line.status(picked=0)
        await eventually(lambda: not robot.undelivered, "nothing to deliver")

    play(test)


def test_a_robot_that_closes_without_a_connection_names_its_results() -> None:
    async def played() -> None:
        line = Line()
        async with line.fake:
            with pytest.raises(ResultsLost) as caught:
                async with Robot(line.fake.address, "r1") as robot:
                    taking = asyncio.create_task(take(robot))
                    await line.idle()
                    line.task(7)
                    work = await taking
                    await line.until("ack", 1)
                    line.fake._server.close()
                    line.drop()
                    await eventually(lambda: not robot.is_connected, "the lost connection")
                    work.picked()
            assert caught.value.results == {7: "PICKED"} and "7: PICKED" in str(caught.value)
            # An exception of the program is not replaced.
        line = Line()
        async with line.fake:
            with pytest.raises(KeyError):
                async with Robot(line.fake.address, "r1") as robot:
                    raise KeyError

    run(played())


def test_a_result_after_the_end_is_an_error() -> None:
    async def played() -> None:
        line = Line()
        async with line.fake:
            async with Robot(line.fake.address, "r1", heartbeat=0.02) as robot:
                taking = asyncio.create_task(take(robot))
                await line.idle()
                line.task(7)
                work = await taking
                changed = asyncio.create_task(work.changed())
            # The node is told that the task will have no result.
            assert line.of("robot")[-1]["state"] == "fault"
            with pytest.raises(LineError, match="closed"):
                work.picked()
            with pytest.raises(TaskDropped, match="ends with a task in hand"):
                await changed
            with pytest.raises(StopAsyncIteration):
                await take(robot)

    run(played())


def test_a_robot_that_closes_takes_no_further_task() -> None:
    async def played() -> None:
        line = Line()
        async with line.fake:
            async with Robot(line.fake.address, "r1", heartbeat=0.02) as robot:
                taking = asyncio.create_task(take(robot))
                await line.idle()
                closing = asyncio.create_task(robot.close())
                await asyncio.sleep(0)
                line.task(7)
                await closing
                with pytest.raises(StopAsyncIteration):
                    await taking
            assert not line.of("ack") and line.of("robot")[-1]["state"] != "idle"

    run(played())


def test_what_a_robot_reports_last_arrives() -> None:
    async def played() -> None:
        line = Line()
        async with line.fake:
            async with Robot(line.fake.address, "r1") as robot:
                taking = asyncio.create_task(take(robot))
                await line.idle()
                line.task(7)
                (await taking).picked()
            assert [one["result"] for one in await line.until("result", 1)] == ["PICKED"]

    run(played())


def test_results_have_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    from pickline.live import results, robot as module

    monkeypatch.setattr(module, "MOST_UNDELIVERED", 3)
    monkeypatch.setattr(results, "MOST_RESULTS", 2)

    async def test(line: Line, robot: Robot) -> None:
        for number in range(1, 4):
            taking = asyncio.create_task(take(robot))
            await line.idle()
            line.task(number)
            (await taking).picked()
            await line.until("result", number)
        taking = asyncio.create_task(take(robot))
        await line.idle()
        line.task(4)
        work = await taking
        with pytest.raises(Overflow, match="3 results"):
            work.picked()
        assert work.is_open and len(robot.undelivered) == 3
        line.status()
        line.status()
        await robot.settle()
        work.picked()
        line.status()
        line.status()
        await robot.settle()

    play(test)


def test_old_results_are_sent_with_a_timestamp_that_is_taken() -> None:
    async def played() -> None:
        now = time.time()
        line = Line()
        async with line.fake, Robot(line.fake.address, "r1", clock=lambda: now) as robot:
            taking = asyncio.create_task(take(robot))
            await line.idle()
            line.task(7)
            work = await taking
            began = now
            work.picked(available_at=now + 1)
            await line.until("result", 1)
            now += 100
            line.drop()
            results = await line.until("result", 2)
            assert results[0]["stamp"] == began and results[1]["stamp"] == now
            assert "available_at" not in results[1]
            line.status()
            line.status()
            await robot.settle()

    run(played())
