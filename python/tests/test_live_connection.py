"""Connections: who is let in, what is told after one is lost, and what comes from strangers."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import signal
import stat
import time
from pathlib import Path

import pytest

from live_support import (
    FakeNode,
    certificates,
    eventually,
    free_port,
    hear,
    hear_kind,
    needs_program,
    node,
    run,
    say,
)

from pickline.live import (
    BadAddress,
    BadMessage,
    BadReply,
    Belt,
    Camera,
    Closed,
    LineError,
    Monitor,
    Operator,
    Overflow,
    Refused,
    Robot,
    Unreachable,
    link,
    messages,

)
from pickline.live.address import Address

TOKEN = "0123456789abcdef0123456789abcdef"
STATUS = {
    "kind": "status",
    "stamp": 1.0,
    "last": False,
    "seen": 0,
    "picked": 0,
    "picked_share": 0.0,
    "picks_per_min": 0.0,
    "missed": {"unreachable": 0, "grasp_failed": 0, "no_result": 0, "passed_over": 0, "busy": 0},
    "on_belt": 0,
    "claimed": 0,
    "open_tasks": [],
    "queued": 0,
    "rejected": {},
    "noted": {},
    "robots": [],
}


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("127.0.0.1:7400", ("tcp", "127.0.0.1", 7400)),
        ("[::1]:7400", ("tcp", "::1", 7400)),
        ("tls://line.example:7400", ("tls", "line.example", 7400)),
        ("mqtt://broker", ("mqtt", "broker", 1883)),
        ("mqtts://u:p%40@broker:8884", ("mqtts", "broker", 8884)),
    ],
)
def test_addresses(text: str, read: tuple[str, str, int]) -> None:
    address = Address.read(text)
    assert (address.scheme, address.host, address.port) == read
    if "@" in text:
        assert (address.user, address.password) == ("u", "p@") and "p@" not in repr(address)
    else:
        assert Address.read(str(address)) == address


@pytest.mark.parametrize(
    "text", ["", "127.0.0.1", "127.0.0.1:", ":7400", "h:99999", "h:x", "http://h:1", "h:1/x", "tcp://u@h:1"]
)
def test_what_is_no_address(text: str) -> None:
    with pytest.raises(BadAddress) as caught:
        Camera(text)
    assert "address" in str(caught.value)


def test_what_is_no_option(tmp_path: Path) -> None:
    for options, word in [
        ({"token": "short"}, "16"),
        ({"token": tmp_path / "none"}, "none"),
        ({"ca": "ca.pem"}, "tls://"),
        ({"keep": 100}, "keep"),
    ]:
        with pytest.raises(LineError) as caught:
            Camera("127.0.0.1:1", **options)
        assert word in str(caught.value)
    with pytest.raises(BadAddress, match="cert"):
        Camera("tls://127.0.0.1:1", cert="x.pem")
    with pytest.raises(BadAddress, match="ca"):
        Camera("tls://127.0.0.1:1", ca=str(tmp_path / "none"))
    with pytest.raises(BadMessage, match="heartbeat"):
        Robot("127.0.0.1:1", "r1", heartbeat=0)
    with pytest.raises(BadMessage, match="name"):
        Camera("127.0.0.1:1", "")


def test_nobody_there() -> None:
    async def play() -> None:
        address = f"127.0.0.1:{free_port()}"
        with pytest.raises(Unreachable) as caught:
            async with Camera(address, patience=0.3):
                pass
        text = str(caught.value)
        assert address in text and "pickline run --listen" in text
        assert isinstance(caught.value, ConnectionError)

    run(play())


def test_a_peer_that_is_not_open() -> None:
    async def play() -> None:
        camera = Camera("127.0.0.1:1")
        with pytest.raises(Closed, match="async with"):
            await camera.report([(0, 0)])
        await camera.close()

    run(play())


@needs_program
def test_tokens(tmp_path: Path) -> None:
    file = tmp_path / "line.token"
    file.write_text(TOKEN + "\n")
    file.chmod(stat.S_IRUSR | stat.S_IWUSR)

    async def play() -> None:
        async with node("--token", str(file)) as line:
            for token, word in [(None, "no token"), ("f" * 32, "wrong")]:
                with pytest.raises(Refused) as caught:
                    async with Camera(line.address, token=token):
                        pass
                assert word in caught.value.reason and "token" in caught.value.cure
                assert "f" * 32 not in str(caught.value)
            for token in (TOKEN, file):
                async with Camera(line.address, token=token) as camera:
                    await camera.report([(0.1, 0.0)])

    run(play())


@needs_program
def test_a_robot_that_the_station_does_not_have_and_one_that_is_taken() -> None:
    async def play() -> None:
        async with node() as line:
            with pytest.raises(Refused, match="no robot `r9`"):
                async with Robot(line.address, "r9"):
                    pass
            async with Robot(line.address, "r1"):
                with pytest.raises(Refused, match="already speaks for"):
                    async with Robot(line.address, "r1", name="other", patience=0.3):
                        pass
            # The other has gone: no attempt is needed twice.
            async with Robot(line.address, "r1", name="other"):
                pass

    run(play())


@needs_program
def test_two_programs_with_one_name_do_not_disconnect_each_other_for_ever() -> None:
    async def play() -> None:
        async with node() as line:
            first, second = Robot(line.address, "r1"), Robot(line.address, "r1")
            await first.open()
            await second.open()
            await eventually(lambda: not (first.is_open and second.is_open), "one that gives up")
            loser, winner = (first, second) if not first.is_open else (second, first)
            with pytest.raises(Refused) as caught:
                await loser.wait_connected()
            assert "another connection" in caught.value.reason
            await winner.wait_connected()
            await loser.close()
            await winner.close()

    run(play())


@needs_program
def test_tls(tmp_path: Path) -> None:
    certificates(tmp_path)
    flags = ["--tls-cert", "node.pem", "--tls-key", "node.key", "--tls-ca", "ca.pem"]
    flags = [str(tmp_path / flag) if "." in flag else flag for flag in flags]

    async def play() -> None:
        async with node(*flags, "--status-every", "0.1") as line:
            address = f"tls://{line.address}"
            ca, cert, key = (tmp_path / name for name in ("ca.pem", "client.pem", "client.key"))
            async with Camera(address, ca=ca, cert=cert, key=key) as camera:
                await camera.report([(0.1, 0.0)])
                await eventually(lambda: camera.status and camera.status.seen == 1, "the item")
            with pytest.raises(Refused, match="not trusted"):
                async with Camera(address, cert=cert, key=key):
                    pass
            # Without a certificate, and without TLS: the node hangs up, and may be asked again.
            with pytest.raises(Unreachable, match="--tls-c"):
                async with Camera(address, ca=ca, patience=0.5):
                    pass
            with pytest.raises(Unreachable, match="tls://"):
                async with Camera(line.address, patience=0.5):
                    pass

    run(play())


async def serve_status(reader, writer) -> None:
    await hear(reader)
    say(writer, kind="hello", accepted=True, robots=["r1"])
    while True:
        say(writer, **STATUS)
        await writer.drain()
        await asyncio.sleep(0.02)


@pytest.mark.parametrize(
    "begin",
    [
        b"SSH-2.0-OpenSSH_9.2p1\r\n",
        b"HTTP/1.1 400 Bad Request\r\n\r\n",
        b"\xff\x00\xfe\n",
        b"[]\n",
        b'{"kind":"status"}\n',
        b'{"v":2,"kind":"hello","accepted":true}\n',
        json.dumps(STATUS).encode() + b"\n",
    ],
)
def test_something_else_answers(begin: bytes) -> None:
    async def serve(reader, writer) -> None:
        await hear(reader)
        writer.write(begin)
        await reader.read()

    async def play() -> None:
        async with FakeNode(serve) as fake:
            with pytest.raises(BadReply) as caught:
                async with Camera(fake.address, patience=5):
                    pass
            assert fake.address in str(caught.value)

    run(play())


def test_a_line_without_end_is_not_collected_for_ever() -> None:
    async def serve(reader, writer) -> None:
        await hear(reader)
        while True:
            writer.write(b"x" * 100_000)
            await writer.drain()

    async def play() -> None:
        async with FakeNode(serve) as fake:
            with pytest.raises(Unreachable, match="more than"):
                async with Camera(fake.address, patience=1):
                    pass

    run(play())


def test_garbage_between_messages_is_skipped_and_told_once(caplog: pytest.LogCaptureFixture) -> None:
    async def serve(reader, writer) -> None:
        await hear(reader)
        say(writer, kind="hello", accepted=True)
        for _ in range(5):
            writer.write(b'\n{"kind":"status","stamp":"x"}\n{"kind":"new","x":1}\n')
            say(writer, **STATUS)
        await writer.drain()
        await reader.read()

    async def play() -> None:
        async with FakeNode(serve) as fake, Monitor(fake.address) as monitor:
            await eventually(lambda: monitor.status, "a status")
            assert monitor.is_connected and monitor.connections == 1

    with caplog.at_level(logging.WARNING, "pickline.live"):
        run(play())
    assert sum("wrong field" in record.message for record in caplog.records) == 1


def test_nothing_but_garbage_ends_the_connection() -> None:
    async def serve(reader, writer) -> None:
        await hear(reader)
        say(writer, kind="hello", accepted=True)
        while True:
            writer.write(b"}{\n" * 10)
            await writer.drain()
            await asyncio.sleep(0.001)

    async def play() -> None:
        async with FakeNode(serve) as fake, Monitor(fake.address) as monitor:
            await eventually(lambda: monitor.connections > 1, "another attempt")
            assert "not JSON" in monitor.last_trouble.problem

    run(play())


def test_a_node_that_falls_silent_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link, "SILENCE", 0.2)
    monkeypatch.setattr(link, "SILENT_PERIODS", 3)

    async def serve(reader, writer) -> None:
        await hear(reader)
        say(writer, kind="hello", accepted=True)
        for _ in range(4):
            say(writer, **STATUS)
            await asyncio.sleep(0.02)
        await asyncio.Event().wait()

    async def play() -> None:
        async with FakeNode(serve) as fake, Camera(fake.address) as camera:
            await eventually(lambda: camera.connections > 1, "another connection")
            assert "has sent nothing" in camera.last_trouble.problem

    run(play())


@needs_program
def test_a_program_that_is_held_up_does_not_blame_the_node(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link, "SILENCE", 0.3)
    monkeypatch.setattr(link, "SILENT_PERIODS", 1)

    # The node is another program, which goes on while this one does nothing.
    async def play() -> None:
        async with node("--status-every", "0.05") as line, Camera(line.address) as camera:
            for _ in range(5):
                await camera.next_status()
            for _ in range(3):
                time.sleep(0.5)
                for _ in range(5):
                    await camera.next_status()
            assert camera.connections == 1 and camera.is_connected

    run(play())


def test_a_node_that_never_answers_the_hello(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link, "OPEN_TIMEOUT", 0.1)

    async def serve(reader, writer) -> None:
        await asyncio.Event().wait()

    async def play() -> None:
        async with FakeNode(serve) as fake:
            with pytest.raises(Unreachable, match="connected, but no answer"):
                async with Camera(fake.address, patience=0.5):
                    pass
            assert fake.connections > 1

    run(play())


def test_pictures_that_may_be_lost_are_sent_again_in_order() -> None:
    heard: list[list[dict]] = []

    async def serve(reader, writer) -> None:
        heard.append([])
        await hear(reader)
        say(writer, kind="hello", accepted=True)
        while True:
            message = await hear(reader)
            heard[-1].append(message)
            if message.get("id") == "break":
                return

    async def play() -> None:
        async with FakeNode(serve) as fake, Camera(fake.address, "north", keep=20) as camera:
            now = time.time()
            await camera.report([(0.1, 0)], now - 30)
            await camera.report([{"x": 0.2, "y": 0, "id": "a"}, {"x": 0.3, "y": 0, "id": "b"}], now - 1)
            await camera.report([])
            await camera.report([{"x": 0.4, "y": 0, "id": "break"}], now)
            await eventually(lambda: camera.last_trouble, "the lost connection")
            # Without a connection, or over the next one.
            await camera.report([{"x": 0.5, "y": 0, "id": "c"}], now)
            await eventually(lambda: len(heard) > 1 and len(heard[1]) >= 3, "the pictures again")
        first, second = heard[0], heard[1]
        assert [message.get("id") for message in first] == [None, "a", "b", "break"]
        assert {message["source"] for message in first} == {"north"}
        # What is older than `keep` is not.
        assert [message.get("id") for message in second][:3] == ["a", "b", "break"]
        assert second[:2] == first[1:3]

    run(play())


def test_pictures_of_a_long_outage_are_lost_but_not_in_silence(caplog: pytest.LogCaptureFixture) -> None:
    async def serve(reader, writer) -> None:
        await hear(reader)
        say(writer, kind="hello", accepted=True)

    async def play() -> None:
        now = 1000.0
        async with FakeNode(serve) as fake, Camera(fake.address, keep=5, clock=lambda: now) as camera:
            await eventually(lambda: camera.last_trouble, "the lost connection")
            fake._server.close()
            await eventually(lambda: not camera.is_connected, "no connection")
            for _ in range(20):
                now += 1
                await camera.report([(0.1, 0), (0.2, 0)])
            assert camera.dropped == 2 * 14
            await camera.close()

    with caplog.at_level(logging.WARNING, "pickline.live"):
        run(play())
    assert sum("are lost" in record.message for record in caplog.records) == 1


@needs_program
def test_a_node_that_reads_nothing_does_not_fill_the_memory() -> None:
    async def play() -> None:
        async with node() as line, Camera(line.address) as camera:
            line.send_signal(signal.SIGSTOP)
            picture = [{"x": 0.3, "y": 0.0, "data": {"pad": "x" * 3000}}] * 50
            with pytest.raises(Overflow) as caught:
                while True:
                    await camera.report(picture)
            assert "the node takes none" in str(caught.value)
            line.send_signal(signal.SIGCONT)
            await camera.flush(60)
            await camera.report(picture)

    run(play())


def test_a_node_that_reads_nothing_for_long_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link, "WRITE_TIMEOUT", 0.1)

    async def serve(reader, writer) -> None:
        await hear(reader)
        say(writer, kind="hello", accepted=True)
        await asyncio.Event().wait()

    async def play() -> None:
        async with FakeNode(serve) as fake, Camera(fake.address, keep=0.0) as camera:
            picture = [{"x": 0.3, "y": 0.0, "data": {"pad": "x" * 3000}}] * 50
            while camera.connections < 2:
                with contextlib.suppress(Overflow):
                    await camera.report(picture)
            assert "taken nothing" in camera.last_trouble.problem

    run(play())


@needs_program
def test_a_program_that_does_not_read_holds_up_nobody() -> None:
    async def play() -> None:
        async with (
            node("--status-every", "0.01") as line,
            Monitor(line.address, keep=3) as monitor,
            Camera(line.address) as camera,
        ):
            # It begins to read and stops.
            stream = monitor.messages()
            await anext(stream)
            await eventually(lambda: monitor.skipped > 20, "skipped messages")
            with pytest.raises(LineError, match="twice"):
                await anext(monitor.messages())
            await stream.aclose()
            assert monitor.is_connected and monitor.connections == 1
            assert camera.is_connected and camera.connections == 1

    run(play())


@needs_program
def test_what_the_node_refuses_is_told(caplog: pytest.LogCaptureFixture) -> None:
    async def play() -> None:
        async with node("--status-every", "0.1") as line, Camera(line.address) as camera:
            await camera.next_status()
            # The station's belt is 1 m wide: only the node can know.
            await camera.report([(0.1, 5.0)])
            await eventually(lambda: camera.rejected, "a refusal")
            assert dict(camera.rejected) == {"off_belt": 1}

    with caplog.at_level(logging.WARNING, "pickline.live"):
        run(play())
    assert any("1 x off_belt" in record.message for record in caplog.records)


@needs_program
def test_nothing_of_a_bad_picture_is_sent() -> None:
    async def play() -> None:
        async with node("--status-every", "0.1") as line, Camera(line.address) as camera:
            for bad in (
                {"x": 0.1},
                {"x": 0.1, "y": 0.1, "colour": "red"},
                {"x": 0.1, "y": 0.1, "stamp": 1},
                (1, 2, 3),
                7,
                "ab",
            ):
                with pytest.raises(BadMessage):
                    await camera.report([(0.2, 0.0), bad])
            with pytest.raises(BadMessage, match="not a list of items"):
                await camera.report(None)
            await camera.report([(0.3, 0.1)])
            await eventually(lambda: camera.status and camera.status.seen, "the item")
            assert (await camera.next_status()).seen == 1

    run(play())


@needs_program
def test_an_operator() -> None:
    async def play() -> None:
        async with node("--status-every", "0.05") as line, Operator(line.address) as operator:
            assert (await operator.pause()).mode == "paused"
            assert (await operator.drain()).mode in ("draining", "drained")
            assert (await operator.stop()).mode == "stopped"
            assert (await operator.resume()).mode == "running"
            await operator.pause("r1")
            with pytest.raises(BadMessage, match="r1, r2"):
                await operator.pause("r9")

    run(play())


@needs_program
def test_an_order_is_given_over_the_next_connection_too() -> None:
    async def play() -> None:
        async with node("--status-every", "0.05") as line, Operator(line.address) as operator:
            await operator.next_status()
            line.kill()
            await eventually(lambda: not operator.is_connected, "the lost connection")
            pausing = asyncio.create_task(operator.pause(timeout=60))
            line.start()
            assert (await pausing).mode == "paused"

    run(play())


def test_an_order_that_no_status_shows() -> None:
    async def play() -> None:
        async with FakeNode(serve_status) as fake, Operator(fake.address) as operator:
            with pytest.raises(LineError, match="no status shows"):
                await operator.pause(timeout=0.3)

    run(play())


@needs_program
def test_a_belt_is_asked_to_stop() -> None:
    async def play() -> None:
        async with (
            node("--may-stop-belt") as line,
            Belt(line.address) as belt,
            Robot(line.address, "r1") as robot,
        ):
            await belt.report(0.8)
            robot.fault("test")

            async def first() -> messages.BeltRequest:
                async for request in belt.requests():
                    return request
                raise AssertionError

            asking = asyncio.create_task(first())
            while not asking.done():
                await belt.report(0.8)
                await asyncio.sleep(0.05)
            assert asking.result().speed == 0.0

    run(play())


@pytest.mark.parametrize(
    ("report", "age", "told"),
    [
        ((0.3, 7.0), 0.5, (0.3, 7.0, 0.5)),
        ((0.3, None), 0.5, (0.3, None, 0.5)),
        ((0.3, None), 60.0, (0.3, None, 0.0)),
        ((0.0, 7.0), 60.0, (0.0, 7.0, 0.0)),
        ((0.3, 7.0), 60.0, None),
    ],
)
def test_a_new_connection_is_told_how_the_belt_moves(report, age: float, told) -> None:
    heard: list[list[dict]] = []
    may_break = asyncio.Event()

    async def serve(reader, writer) -> None:
        heard.append([])
        await hear(reader)
        say(writer, kind="hello", accepted=True)
        heard[-1].append(await hear_kind(reader, "belt"))
        await may_break.wait()

    async def play() -> None:
        now = 1000.0
        async with FakeNode(serve) as fake, Belt(fake.address, clock=lambda: now) as belt:
            await belt.report(*report)
            await eventually(lambda: heard[0], "the report")
            now += age
            may_break.set()
            await eventually(lambda: belt.connections > 1, "another connection")
            if told is None:
                await belt.report(0.4, 30.0)
            await eventually(lambda: len(heard) > 1 and heard[1], "the report over it")
            first = heard[1][0]
            speed, position, back = told or (0.4, 30.0, 0.0)
            assert first["speed"] == speed and first.get("position") == position
            assert first["stamp"] == now - back

    run(play())


@needs_program
def test_the_end_of_a_node_and_of_a_client() -> None:
    async def play() -> None:
        async with node("--status-every", "60") as line:
            async with Camera(line.address) as camera, Monitor(line.address) as monitor:
                for n in range(100):
                    await camera.report([(0.3, 0.001 * n)], time.time())
                # What was reported arrives although the camera ends at once.
                await camera.close()
                await camera.close()
                with pytest.raises(Closed):
                    await camera.report([(0.1, 0)])
                ended = asyncio.create_task(line.stop())
                await eventually(lambda: monitor.status and monitor.status.last, "the last status")
                assert monitor.status.seen >= 1
                noted = monitor.status.noted.get("repeated_detection", 0)
                assert monitor.status.seen + noted + monitor.status.noted.get("doubled", 0) >= 90
                await ended

    run(play())


@needs_program
def test_a_cancelled_program_leaves_nothing_behind() -> None:
    async def play() -> None:
        async with node() as line:

            async def work() -> None:
                async with Camera(line.address) as camera, Robot(line.address, "r1") as robot:
                    ready.set()
                    await asyncio.gather(robot.run(None), camera.next_status(), asyncio.Event().wait())

            for _ in range(3):
                ready = asyncio.Event()
                task = asyncio.create_task(work())
                await ready.wait()
                task.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await task
            # While it opens.
            task = asyncio.create_task(Camera("127.0.0.1:1", patience=None).open())
            await asyncio.sleep(0)
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task

    run(play())
