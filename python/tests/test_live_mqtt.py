"""Lines over MQTT, with a mosquitto on a free port. Needs a program with the feature `mqtt`, named by
PICKLINE_MQTT or PICKLINE, the package paho-mqtt and Debian's package mosquitto."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import os
import random
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

import live_support
from live_support import (
    PROGRAM,
    Node,
    Peers,
    World,
    certificates,
    eventually,
    free_port,
    peers_at_work,
    run,
)

from pickline.live import (
    BadAddress,
    Belt,
    Camera,
    MissingPackage,
    Monitor,
    Operator,
    Refused,
    Robot,
    Unreachable,
)
from pickline.live.mqtt import MqttTransport

MOSQUITTO = shutil.which("mosquitto") or shutil.which("/usr/sbin/mosquitto")
MQTT_PROGRAM = os.environ.get("PICKLINE_MQTT") or PROGRAM


def has_mqtt() -> bool:
    """Whether the program has the feature `mqtt`."""
    if MQTT_PROGRAM is None:
        return False
    shown = subprocess.run([MQTT_PROGRAM, "run", "--help"], capture_output=True, text=True)
    return "--mqtt" in shown.stdout


needs_broker = pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed (apt install mosquitto)")
needs_mqtt = pytest.mark.skipif(not has_mqtt(), reason="the program has no feature `mqtt`")
pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")


class Broker:
    """A mosquitto that can be killed and started again at the same port."""

    def __init__(self, folder: Path, settings: str, user: str) -> None:
        self.folder = folder
        self.port = free_port()
        self.user = user
        (folder / "conf").write_text(
            f"listener {self.port} 127.0.0.1\nset_tcp_nodelay true\npersistence false\n"
            f"max_queued_messages 0\n{settings.replace('FOLDER', str(folder))}"
        )
        self.process: subprocess.Popen[bytes] | None = None

    @property
    def address(self) -> str:
        return f"mqtt://{self.user}127.0.0.1:{self.port}"

    async def start(self) -> None:
        log = (self.folder / "broker.log").open("ab")
        command = [MOSQUITTO, "-c", str(self.folder / "conf"), "-v"]
        self.process = subprocess.Popen(command, stdout=log, stderr=log)
        log.close()

        def is_ready() -> bool:
            assert self.process.poll() is None, (self.folder / "broker.log").read_text()
            with contextlib.suppress(OSError):
                socket.create_connection(("127.0.0.1", self.port), timeout=1).close()
                return True
            return False

        await eventually(is_ready, "the broker")

    def kill(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()


@contextlib.asynccontextmanager
async def broker(settings: str = "allow_anonymous true\n", user: str = "") -> AsyncIterator[Broker]:
    with tempfile.TemporaryDirectory() as folder:
        # Its user, which is not that of the test, reads and writes there.
        os.chmod(folder, 0o755)
        place = Broker(Path(folder), f"user {os.environ.get('USER') or 'root'}\n{settings}", user)
        await place.start()
        try:
            yield place
        finally:
            place.kill()


@contextlib.asynccontextmanager
async def node_at(place: Broker, *flags: str) -> AsyncIterator[Node]:
    """A node that is connected to a broker."""
    with tempfile.TemporaryDirectory() as folder:
        url = f"mqtt://127.0.0.1:{place.port}"
        line = Node(Path(folder), "--mqtt", url, *flags, listen=False)
        before, live_support.PROGRAM = live_support.PROGRAM, MQTT_PROGRAM
        line.start()
        try:
            yield line
        finally:
            live_support.PROGRAM = before
            if line.process.poll() is None:
                line.kill()


@needs_broker
@needs_mqtt
def test_a_whole_line_over_mqtt() -> None:
    async def play() -> None:
        world = World(time.time)
        async with (
            broker() as place,
            node_at(place, "--status-every", "0.2"),
            peers_at_work(world, place.address) as peers,
        ):
            events: list[str] = []

            async def watch() -> None:
                async for message in peers.monitor.messages():
                    events.append(message.kind)

            watching = asyncio.create_task(watch())
            world.begin(30)
            await world.show(peers.camera)
            status = await peers.settle()
            watching.cancel()
            assert status.seen == 30 and not status.rejected
            assert len(world.bins) >= 15
            assert events.count("task") >= len(world.bins)

    run(play())


@needs_broker
@needs_mqtt
def test_an_operator_over_mqtt() -> None:
    async def play() -> None:
        async with (
            broker() as place,
            node_at(place, "--status-every", "0.1", "--mqtt-prefix", "plant/line1"),
            Operator(place.address, "shift leader/+#%", prefix="plant/line1") as operator,
        ):
            assert (await operator.pause()).mode == "paused"
            assert (await operator.resume()).mode == "running"

    run(play())


# When something is killed: at any time, when a robot has just been given a task, which it
# acknowledges, and when it has just finished one, whose result is on its way.
PHASES = ("any", "task", "result")


async def reach(phase: str, peers: Peers, rng: random.Random, showing: asyncio.Task[None]) -> None:
    """Waits for a phase of the work, or for the end of the showing."""
    world = peers.world
    works, ended = world.works, sum(map(len, world.reported.values()))
    reached = {
        "any": lambda: world.works > works + 1,
        "task": lambda: world.works > works,
        "result": lambda: sum(map(len, world.reported.values())) > ended,
    }[phase]
    await eventually(lambda: showing.done() or reached(), f"a kill in the phase `{phase}`")
    # What has begun is at another point of its way each time.
    longest = 0.7 if phase == "any" else 0.01
    await asyncio.wait([showing], timeout=rng.uniform(0.0, longest))


@needs_broker
@needs_mqtt
@pytest.mark.parametrize("what", ["node", "broker"])
def test_kills_over_mqtt(what: str) -> None:
    async def play() -> None:
        rng = random.Random(5)
        world = World(time.time)
        flags = ["--journal", "line.journal", "--status-every", "0.1"]
        async with (
            broker() as place,
            node_at(place, *flags) as line,
            peers_at_work(world, place.address) as peers,
        ):
            world.begin(40)
            showing = asyncio.create_task(world.show(peers.camera))
            kills = on_their_way = in_hand = 0
            for phase in itertools.cycle(PHASES):
                await peers.keep_up()
                await reach(phase, peers, rng, showing)
                if showing.done():
                    break
                robots = (peers.r1, peers.r2)
                kills += 1
                on_their_way += any(robot.undelivered for robot in robots)
                in_hand += any(robot.work is not None and robot.work.is_open for robot in robots)
                if what == "node":
                    line.kill()
                    line.start()
                else:
                    place.kill()
                    await place.start()
            await showing
            status = await peers.settle()
            assert kills >= 3 and on_their_way >= 1 and in_hand >= 1
            assert status.seen == 40 and status.missed.no_result == 0
            # Nobody's clock was set: pictures that come again are late.
            assert "source_step" not in status.noted
            assert peers.r1.connections > 1

    run(play())


@needs_broker
def test_no_node_at_the_broker() -> None:
    async def play() -> None:
        async with broker() as place:
            with pytest.raises(Unreachable, match="no node is connected"):
                async with Camera(place.address, patience=6):
                    pass
        with pytest.raises(Unreachable, match="no connection to the broker"):
            async with Camera(place.address, patience=0.3):
                pass

    run(play())


@needs_broker
def test_users_and_permissions() -> None:
    async def play() -> None:
        settings = "allow_anonymous false\npassword_file FOLDER/users\nacl_file FOLDER/acl\n"
        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder) / "users"
            tool = shutil.which("mosquitto_passwd")
            subprocess.run([tool, "-b", "-c", str(made), "cam", "secret pass"], check=True)
            users = made.read_text()
        place = None
        async with contextlib.AsyncExitStack() as stack:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            os.chmod(folder, 0o755)
            (Path(folder) / "users").write_text(users)
            (Path(folder) / "acl").write_text(
                "user cam\ntopic read pickline/#\ntopic write pickline/node\ntopic write pickline/belt/#\n"
            )
            place = Broker(Path(folder), f"user {os.environ.get('USER') or 'root'}\n{settings}", "")
            await place.start()
            stack.callback(place.kill)
            publish(place, "pickline/node", '{"state":"online","client":"x"}', "cam", "secret pass")
            for options in ({}, {"user": "cam", "password": "wrong"}):
                with pytest.raises(Refused, match="refuses the user"):
                    async with Camera(place.address, **options):
                        pass
            async with Belt(place.address, user="cam", password="secret pass") as belt:
                await belt.report(0.3)
                await belt.flush()
            # A camera that may not report says so to its program, and does not try for ever.
            address = f"mqtt://cam:secret%20pass@127.0.0.1:{place.port}"
            async with Camera(address, "north") as camera:
                with pytest.raises(Refused, match="pickline/detection/north"):
                    while True:
                        await camera.report([(0.1, 0.0)])
                        await asyncio.sleep(0.01)

    run(play())


def publish(place: Broker, topic: str, payload: str, user: str, password: str) -> None:
    """Leaves a retained message at a broker."""
    import paho.mqtt.publish

    paho.mqtt.publish.single(
        topic,
        payload,
        qos=1,
        retain=True,
        hostname="127.0.0.1",
        port=place.port,
        auth={"username": user, "password": password},
    )


@needs_broker
def test_what_strangers_publish() -> None:
    """Old, wrong and foreign messages on the topics of the node."""
    import paho.mqtt.publish

    async def play() -> None:
        async with broker() as place:

            def say(topic: str, payload: bytes | str, retain: bool = False) -> None:
                paho.mqtt.publish.single(
                    f"pickline/{topic}", payload, 1, retain, "127.0.0.1", place.port
                )

            say("status", '{"kind":"status"}', retain=True)
            say("node", '{"state":"online","client":"first"}', retain=True)
            async with Monitor(place.address) as monitor:
                stream = monitor.messages()
                first = asyncio.ensure_future(anext(stream))
                await asyncio.sleep(0)
                for payload in (b"\xff", b"", b"[]", b"x" * 70_000, '{"kind":"due","stamp":1}'):
                    await asyncio.to_thread(say, "status", payload)
                await asyncio.to_thread(say, "node", "nonsense")
                await asyncio.to_thread(say, "due", '{"kind":"due","stamp":2}')
                assert (await first).stamp == 2.0
                assert monitor.connections == 1
                # Another node, or the same once more.
                await asyncio.to_thread(say, "node", '{"state":"online","client":"second"}', True)
                await eventually(lambda: monitor.connections == 2, "another connection")
                await asyncio.to_thread(say, "node", '{"state":"offline","client":"second"}', True)
                await eventually(lambda: "has left" in monitor.last_trouble.problem, "the node's end")
                assert not monitor.is_connected
                await stream.aclose()

    run(play())


@needs_broker
def test_tls_over_mqtt(tmp_path: Path) -> None:
    certificates(tmp_path)
    import paho.mqtt.publish

    async def play() -> None:
        port = free_port()
        settings = (
            f"allow_anonymous true\nlistener {port} 127.0.0.1\n"
            f"certfile {tmp_path}/node.pem\nkeyfile {tmp_path}/node.key\nallow_anonymous true\n"
        )
        async with broker(settings) as place:
            online = '{"state":"online","client":"x"}'
            paho.mqtt.publish.single("pickline/node", online, 1, True, "127.0.0.1", place.port)
            async with Camera(f"mqtts://127.0.0.1:{port}", ca=tmp_path / "ca.pem") as camera:
                await camera.report([(0.1, 0.0)])
                await camera.flush()
            with pytest.raises(Refused, match="not trusted"):
                async with Camera(f"mqtts://127.0.0.1:{port}"):
                    pass

    run(play())


@needs_broker
def test_an_ack_does_not_wait_for_the_packets_before_it(monkeypatch: pytest.MonkeyPatch) -> None:
    import paho.mqtt.publish

    clients = []
    make = MqttTransport.make_client

    def kept(self: MqttTransport, client_id: str) -> object:
        clients.append(make(self, client_id))
        return clients[-1]

    monkeypatch.setattr(MqttTransport, "make_client", kept)

    async def play() -> None:
        async with broker() as place:
            online = '{"state":"online","client":"x"}'
            paho.mqtt.publish.single("pickline/node", online, 1, True, "127.0.0.1", place.port)
            async with Robot(place.address, "r1"):
                connected = clients[0].socket()
                assert connected.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)

    run(play())


def test_prefixes() -> None:
    for prefix in ("", "/a", "a/", "a//b", "a+", "#", "$SYS", "a\nb"):
        with pytest.raises(BadAddress, match="prefix"):
            Camera("mqtt://127.0.0.1", prefix=prefix)


def test_names_become_topics() -> None:
    from pickline.live.mqtt import level

    assert level("a/+#%\u00e9") == "a%2F%2B%23%25\u00e9"


def test_the_package_that_mqtt_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "paho.mqtt.client", None)
    with pytest.raises(MissingPackage, match="pip install paho-mqtt"):
        Camera("mqtt://127.0.0.1")
