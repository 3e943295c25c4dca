"""A whole line: a camera, an encoder and robots as clients of `pickline run`."""

from __future__ import annotations

import asyncio
import time

from live_support import World, eventually, needs_program, node, peers_at_work, run

from pickline.live import Camera, Due, Monitor, Robot, Task

pytestmark = needs_program


def test_camera_belt_and_robots_pick_a_whole_pattern() -> None:
    async def play() -> None:
        world = World(time.time)
        async with (
            node("--status-every", "0.2") as line,
            peers_at_work(world, line.address) as peers,
        ):
            assert peers.camera.station_robots == ("r1", "r2")
            world.begin(30)
            await world.show(peers.camera)
            status = await peers.settle()
            assert status.seen == 30
            assert status.picked >= 20, status
            assert not status.rejected
            assert not peers.camera.rejected and not peers.r1.rejected
            names = {(source.name, str(source.kind)) for source in status.sources}
            assert {("north", "camera"), ("encoder", "belt"), ("r1", "robot")} <= names

    run(play())


def test_a_line_with_message_time() -> None:
    """The clock of the peers is that of the test. The node says when it has decided all that is due,
    and gives the same tasks each time."""

    async def play() -> list[tuple]:
        now = 100.0
        found: list[tuple] = []
        async with (
            node("--clock", "messages", "--status-every", "0") as line,
            Monitor(line.address) as monitor,
            Camera(line.address, "north", clock=lambda: now) as camera,
            Robot(line.address, "r1", clock=lambda: now, heartbeat=60) as r1,
        ):
            stream = monitor.messages()

            async def tick() -> None:
                await camera.tick(now)
                while True:
                    message = await anext(stream)
                    if isinstance(message, Task):
                        found.append((message.id, message.item, message.start, message.meet))
                    elif isinstance(message, Due) and message.stamp == now:
                        return

            await r1.flush()
            taking = asyncio.ensure_future(anext(r1))
            await eventually(lambda: r1._takes_tasks, "a robot that takes tasks")
            await r1.flush()
            await camera.report([{"x": 0.1, "y": 0.1, "id": "a"}, {"x": 0.1, "y": -0.2, "id": "b"}])
            await camera.flush()
            while not taking.done():
                now += 0.1
                await tick()
            work = await taking
            # Waits follow the same clock.
            waiting = asyncio.ensure_future(work.until("meet_at"))
            while not waiting.done():
                now += 0.5
                await asyncio.sleep(0.05)
            work.picked()
            await r1.flush()
            await tick()
            await stream.aclose()
        return found

    async def twice() -> None:
        first, second = await play(), await play()
        assert first and first[0] == second[0]

    run(twice())
