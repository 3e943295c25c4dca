"""What the tests of `pickline.live` share: the package, a node at work, a small world.

The program is named by the environment variable PICKLINE, or is `pickline` on the path. Nothing
here sleeps for a fixed time: `eventually` waits for what happens.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import types
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parent.parent / "pickline"


def import_package() -> None:
    """Makes `pickline.live` importable where the package is not installed: it needs no compiled
    module, but the package around it does."""
    try:
        importlib.import_module("pickline.live")
        return
    except ImportError:
        pass
    package = types.ModuleType("pickline")
    package.__path__ = [str(SOURCE)]
    for name in [name for name in sys.modules if name.split(".")[0] == "pickline"]:
        del sys.modules[name]
    sys.modules["pickline"] = package
    importlib.import_module("pickline.live")


import_package()

from pickline.live import Belt, Camera, Monitor, Robot, Status, Verdict, Work  # noqa: E402

PROGRAM = os.environ.get("PICKLINE") or shutil.which("pickline")

needs_program = pytest.mark.skipif(
    PROGRAM is None, reason="PICKLINE does not name the program, and it is not on the path"
)

DEADLINE = float(os.environ.get("PICKLINE_TEST_DEADLINE", 120.0))
"""More than any step takes on a slow machine [s]."""


async def eventually(happened: Callable[[], object], what: str) -> None:
    """Waits until something has happened."""
    try:
        async with asyncio.timeout(DEADLINE):
            while not happened():
                await asyncio.sleep(0.005)
    except TimeoutError:
        raise AssertionError(f"waited in vain for {what}") from None


def run(coroutine: object) -> None:
    """Runs a test, which fails if it hangs."""

    async def limited() -> None:
        async with asyncio.timeout(2 * DEADLINE):
            await coroutine  # type: ignore[misc]
        left = [task for task in asyncio.all_tasks() if task is not asyncio.current_task()]
        assert not left, f"tasks are left: {left}"

    asyncio.run(limited())


def free_port() -> int:
    """A port that nobody listens at now."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


BELT_SPEED = 0.8
BELT_LENGTH = 4.0

STATION = f"""
[belt]
speed = {BELT_SPEED}
length = {BELT_LENGTH}
width = 1.0
""" + "".join(
    f"""
[[robot]]
name = "{name}"
base = [{x}, 0.6]
bin = [{x}, 0.7]
reach = 1.0
speed = 4.0
grasp_time = 0.1
release_time = 0.1
"""
    for name, x in (("r1", 1.2), ("r2", 2.8))
)


class Node:
    """`pickline run`, which can be killed and started again at the same port."""

    def __init__(self, folder: Path, *flags: str, listen: bool = True) -> None:
        self.folder = folder
        self.flags = flags
        self.port = free_port()
        self.listens = listen
        (folder / "station.toml").write_text(STATION)
        self.log = folder / "node.log"
        self.log.touch()
        self.process: subprocess.Popen[bytes] | None = None

    @property
    def address(self) -> str:
        return f"127.0.0.1:{self.port}"

    def start(self) -> None:
        where = ["--listen", self.address] if self.listens else []
        command = [PROGRAM, "run", "--station", "station.toml", *where, *self.flags]
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log
            )

    def said(self) -> str:
        return self.log.read_text(errors="replace")

    async def ready(self) -> None:
        """Waits until it accepts messages."""

        def is_ready() -> bool:
            assert self.process is not None
            assert self.process.poll() is None, self.said()
            # No connection tries it: with message time, a node ends when its peers have gone.
            return ("listening at" if self.listens else "running") in self.said()

        await eventually(is_ready, "the node")

    def send_signal(self, number: int) -> None:
        assert self.process is not None
        self.process.send_signal(number)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)
        assert self.process is not None
        self.process.wait()

    async def stop(self) -> int:
        """Ends it in order, and returns its exit code."""
        self.send_signal(signal.SIGTERM)
        assert self.process is not None
        await eventually(lambda: self.process.poll() is not None, "the end of the node")
        return self.process.returncode


@contextlib.asynccontextmanager
async def node(*flags: str, listen: bool = True) -> AsyncIterator[Node]:
    """A node at work, in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        line = Node(Path(folder), *flags, listen=listen)
        line.start()
        try:
            await line.ready()
            yield line
        finally:
            if line.process is not None and line.process.poll() is None:
                line.process.send_signal(signal.SIGCONT)
                line.kill()


@dataclass
class World:
    """What is really on the belt and in the bins. It owes nothing to the code under test."""

    clock: Callable[[], float]
    began: float = 0.0
    items: dict[str, tuple[float, float]] = field(default_factory=dict)
    bins: dict[str, str] = field(default_factory=dict)
    twice: list[str] = field(default_factory=list)
    reported: dict[str, list[Verdict]] = field(default_factory=dict)
    works: int = 0

    def begin(self, count: int, apart: float = 0.2) -> None:
        """Puts items in a row, the first at the belt's start now."""
        self.began = self.clock()
        self.items = {f"i{n}": (-apart * n, 0.1 * (n % 5) - 0.2) for n in range(count)}

    def x(self, item: str, now: float) -> float:
        return self.items[item][0] + BELT_SPEED * (now - self.began)

    def seen(self, now: float) -> list[dict[str, object]]:
        """What a camera over the belt's first 0.4 m sees."""
        found = []
        for item, (_, y) in self.items.items():
            x = self.x(item, now)
            if 0.0 <= x <= 0.4 and item not in self.bins:
                found.append({"x": x, "y": y, "id": item})
        return found

    def is_past(self, now: float) -> bool:
        return all(self.x(item, now) > BELT_LENGTH + 0.6 for item in self.items)

    async def pick(self, work: Work) -> None:
        """What a robot does with a task."""
        self.works += 1
        await work.until("start")
        await work.until("meet_at")
        item = work.task.item
        if item in self.bins:
            self.twice.append(item)
            verdict = Verdict.MISSED
        elif abs(self.x(item, work.task.meet_at) - work.task.meet.x) > 0.02:
            verdict = Verdict.MISSED
        else:
            self.bins[item] = work.task.robot
            verdict = Verdict.PICKED
        await asyncio.sleep(max(0.0, work.task.free_at - self.clock()))
        self.reported.setdefault(item, []).append(verdict)
        work.finish(verdict)

    async def show(self, camera: object, every: float = 0.1) -> None:
        """Takes pictures until all items have passed. A camera takes them in time, also when this
        program gets to evaluating them late: no item passes unseen."""
        taken = self.began
        while not self.is_past(taken):
            await asyncio.sleep(max(0.0, taken - self.clock()))
            await camera.report(self.seen(taken), taken)  # type: ignore[attr-defined]
            taken += every


@contextlib.asynccontextmanager
async def at_work(world: World, *robots: Robot) -> AsyncIterator[None]:
    """Lets robots carry out what they are given."""
    tasks = [asyncio.create_task(robot.run(world.pick)) for robot in robots]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    for task in tasks:
        if not task.cancelled() and task.exception() is not None:
            raise task.exception()  # type: ignore[misc]


@dataclass
class Peers:
    """The programs of a whole line: a camera, an encoder, two robots and a monitor."""

    world: World
    monitor: Monitor
    camera: Camera
    r1: Robot
    r2: Robot

    def _has_settled(self) -> bool:
        status = self.monitor.status
        return (
            self.monitor.is_connected
            and status is not None
            and status.on_belt + status.claimed == 0
            and status.seen >= len(self.world.items)
            and not status.open_tasks
        )

    async def keep_up(self) -> None:
        """Waits until the node knows the items that came onto the belt two seconds ago: an item whose
        first report comes after it has left the belt is lost, and that by right. For tests that take
        the connection away again and again, also on a slow machine."""

        def has_kept_up() -> bool:
            status, then = self.monitor.status, self.world.clock() - 2.0
            entered = sum(self.world.x(item, then) >= 0.0 for item in self.world.items)
            return entered == 0 or (status is not None and status.seen >= entered)

        await eventually(has_kept_up, "a node that knows the items")

    async def settle(self) -> Status:
        """Waits until the node has heard of everything that has happened, whose figures are then
        those of the world."""
        await self.monitor.wait_connected()
        await self.r1.settle(60)
        await self.r2.settle(60)
        try:
            await eventually(self._has_settled, "a settled line")
        except AssertionError as error:
            raise AssertionError(f"{error}: {self.monitor.status}, {self.world}") from None
        status = self.monitor.status
        assert status is not None
        check(self.world, status)
        return status


@contextlib.asynccontextmanager
async def peers_at_work(
    world: World, address: str, watched_at: str | None = None
) -> AsyncIterator[Peers]:
    """The programs of a whole line, which work for the node at an address until the block ends.

    Args:
        watched_at: Where the monitor finds the node, if it is elsewhere.
    """

    def position() -> tuple[float, float]:
        return BELT_SPEED, BELT_SPEED * (world.clock() - world.began)

    async with (
        Monitor(watched_at or address) as monitor,
        Belt(address) as belt,
        Camera(address, "north") as camera,
        Robot(address, "r1", heartbeat=0.1) as r1,
        Robot(address, "r2", heartbeat=0.1) as r2,
        at_work(world, r1, r2),
    ):
        driving = asyncio.create_task(belt.follow(position))
        try:
            yield Peers(world, monitor, camera, r1, r2)
        finally:
            driving.cancel()


def check(world: World, status: Status) -> None:
    """The node's figures are those of the world."""
    total = status.picked + status.missed.total + status.on_belt + status.claimed
    assert status.seen == total + (status.unwanted or 0)
    assert not world.twice, "items were picked twice"
    assert status.picked == len(world.bins)
    by_robot = Counter(world.bins.values())
    assert {robot.name: robot.picked for robot in status.robots} == {
        name: by_robot[name] for name in ("r1", "r2")
    }
    assert not status.open_tasks


def certificates(folder: Path) -> None:
    """An authority, and certificates of it for a node and a client: `ca.pem`, `NAME.pem` and
    `NAME.key`."""

    def openssl(*arguments: str) -> None:
        made = subprocess.run(["openssl", *arguments], cwd=folder, capture_output=True, text=True)
        assert made.returncode == 0, made.stderr

    new = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    openssl("req", "-x509", *new, "-keyout", "ca.key", "-out", "ca.pem", "-days", "2", "-subj", "/CN=test")
    (folder / "names").write_text("subjectAltName=IP:127.0.0.1,DNS:localhost\n")
    for name in ("node", "client"):
        openssl("req", *new, "-keyout", f"{name}.key", "-out", f"{name}.csr", "-subj", f"/CN={name}")
        openssl(
            *("x509", "-req", "-in", f"{name}.csr", "-CA", "ca.pem", "-CAkey", "ca.key"),
            *("-CAcreateserial", "-out", f"{name}.pem", "-days", "2", "-extfile", "names"),
        )


class FakeNode:
    """A server that does what a test says: `serve` is given each connection."""

    def __init__(self, serve: Callable[[asyncio.StreamReader, asyncio.StreamWriter], object]) -> None:
        self._serve = serve
        self.port = 0
        self.connections = 0
        self._tasks: set[asyncio.Task[None]] = set()

    @property
    def address(self) -> str:
        return f"127.0.0.1:{self.port}"

    async def __aenter__(self) -> FakeNode:
        async def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            task = asyncio.current_task()
            assert task is not None
            self._tasks.add(task)
            self.connections += 1
            try:
                await self._serve(reader, writer)  # type: ignore[misc]
            except (ConnectionError, asyncio.IncompleteReadError, asyncio.CancelledError):
                pass
            finally:
                self._tasks.discard(task)
                writer.transport.abort()

        self._server = await asyncio.start_server(accept, "127.0.0.1", 0)
        self.port = self._server.sockets[0].getsockname()[1]
        return self

    async def __aexit__(self, *_: object) -> None:
        self._server.close()
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await self._server.wait_closed()


async def hear(reader: asyncio.StreamReader) -> dict[str, object]:
    """The next message of a client."""
    return json.loads(await reader.readuntil(b"\n"))


async def hear_kind(reader: asyncio.StreamReader, kind: str) -> dict[str, object]:
    """The next message of a client of this kind."""
    while True:
        message = await hear(reader)
        if message["kind"] == kind:
            return message


def say(writer: asyncio.StreamWriter, **message: object) -> None:
    """Sends a message of a node."""
    writer.write(json.dumps({"v": 1, **message}).encode() + b"\n")


def lines(text: str) -> Iterator[str]:
    return iter(text.splitlines())
