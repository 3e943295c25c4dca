"""Under load: the node is killed and starts again from its journal, connections are cut."""

from __future__ import annotations

import asyncio
import os
import random
import time

import pytest

from live_support import World, eventually, needs_program, node, peers_at_work, run

from pickline.live import Camera, Monitor, Robot

pytestmark = needs_program

ITEMS = int(os.environ.get("PICKLINE_TEST_ITEMS", 60))


@pytest.mark.parametrize("seed", [1, 2])
def test_a_node_that_is_killed_again_and_again(seed: int) -> None:
    async def play() -> None:
        rng = random.Random(seed)
        world = World(time.time)
        async with (
            node("--journal", "line.journal", "--status-every", "0.1") as line,
            peers_at_work(world, line.address) as peers,
        ):
            world.begin(ITEMS)
            showing = asyncio.create_task(world.show(peers.camera))
            kills = 0
            while not showing.done():
                # At any moment, and down for a while in which the belt goes on.
                works, pause = world.works, rng.uniform(0.3, 1.2)
                begun = time.monotonic()
                await eventually(
                    lambda: showing.done()
                    or (world.works > works and time.monotonic() - begun > pause),
                    "work",
                )
                await peers.keep_up()
                if world.works == works or showing.done():
                    break
                line.kill()
                kills += 1
                await asyncio.sleep(rng.uniform(0.0, 0.3))
                line.start()
            await showing
            status = await peers.settle()
            assert kills >= 3
            assert status.seen == ITEMS
            # What the node calls lost was lost by nobody else.
            assert status.missed.no_result == 0
            for item, verdicts in world.reported.items():
                assert verdicts.count("PICKED") == (1 if item in world.bins else 0)
            assert min(peers.r1.connections, peers.r2.connections, peers.camera.connections) > 1

    run(play())


async def crash() -> None:
    """The farewell of a program that has none."""


class Proxy:
    """A way to the node that can be cut at any moment."""

    def __init__(self, port: int) -> None:
        self._target = port
        self._ways: set[asyncio.Task[None]] = set()
        self.cuts = 0

    async def __aenter__(self) -> Proxy:
        self._server = await asyncio.start_server(self._accept, "127.0.0.1", 0)
        self.port = self._server.sockets[0].getsockname()[1]
        return self

    async def __aexit__(self, *_: object) -> None:
        self._server.close()
        self.cut()
        await asyncio.gather(*self._ways, return_exceptions=True)

    async def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._ways.add(task)
        writers = [writer]

        async def copy(source: asyncio.StreamReader, target: asyncio.StreamWriter) -> None:
            while block := await source.read(4096):
                target.write(block)
                await target.drain()
            if target.can_write_eof():
                target.write_eof()

        try:
            reads, writes = await asyncio.open_connection("127.0.0.1", self._target)
            writers.append(writes)
            async with asyncio.TaskGroup() as group:
                group.create_task(copy(reader, writes))
                group.create_task(copy(reads, writer))
        except* (OSError, asyncio.CancelledError):
            pass
        finally:
            self._ways.discard(task)
            for one in writers:
                one.transport.abort()

    def cut(self) -> None:
        """Ends all connections on the spot: what is on its way is lost."""
        for way in list(self._ways):
            way.cancel()
        self.cuts += 1


def test_a_controller_that_crashes_with_a_task_in_hand() -> None:
    """It is started again, and knows nothing of the task. The line goes on."""

    async def play() -> None:
        world = World(time.time)
        async with (
            node("--status-every", "0.1") as line,
            Monitor(line.address) as monitor,
            Camera(line.address, "north") as camera,
        ):
            world.begin(12)
            showing = asyncio.create_task(world.show(camera))
            crashes = 0
            while not showing.done():
                robot = Robot(line.address, "r1", heartbeat=0.1)
                await robot.open()
                taking = asyncio.ensure_future(anext(robot))
                await asyncio.wait([showing, taking], return_when=asyncio.FIRST_COMPLETED)
                if taking.done():
                    work = taking.result()
                    await asyncio.wait([showing], timeout=0.1 * (crashes % 4))
                    if crashes % 2:
                        await world.pick(work)
                        await robot.settle()
                    else:
                        # Nothing of an end is done that a crash would not do.
                        robot._farewell = crash  # type: ignore[method-assign]
                crashes += 1
                taking.cancel()
                await robot.close()
            await showing

            def is_settled() -> bool:
                status = monitor.status
                return status.seen == 12 and not status.on_belt + status.claimed + len(status.open_tasks)

            await eventually(is_settled, "a settled line")
            status = monitor.status
            assert status.seen == 12 and status.picked == len(world.bins) and not world.twice
            assert crashes > 3

    run(play())


def test_connections_that_are_cut_again_and_again() -> None:
    async def play() -> None:
        rng = random.Random(3)
        world = World(time.time)
        async with (
            node("--status-every", "0.1") as line,
            Proxy(line.port) as proxy,
            peers_at_work(world, f"127.0.0.1:{proxy.port}", watched_at=line.address) as peers,
        ):
            world.begin(ITEMS)
            showing = asyncio.create_task(world.show(peers.camera))
            while not showing.done():
                await asyncio.wait([showing], timeout=rng.uniform(0.1, 0.8))
                await peers.keep_up()
                proxy.cut()
            await showing
            status = await peers.settle()
            assert status.seen == ITEMS and status.missed.no_result == 0
            assert proxy.cuts > 10 and peers.r1.connections > 5

    run(play())
