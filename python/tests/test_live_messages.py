"""The messages: held to the schema of the program, checked, and read back."""

from __future__ import annotations

import asyncio
import dataclasses
import inspect
import json
import math
import random
import re
import subprocess
import time
import types
import typing
from collections.abc import Mapping
from enum import StrEnum

import pytest

from live_support import PROGRAM, eventually, needs_program, node, run

from pickline.live import (
    Ack,
    BadMessage,
    BadReply,
    BeltState,
    Camera,
    Detection,
    Hello,
    Monitor,
    Order,
    Point,
    Report,
    RobotState,
    RobotStatus,
    Role,
    SourceKind,
    SourceReport,
    Task,
    Tick,
    Verdict,
    messages,
)
from pickline.live.messages import FROM_NODE, TO_NODE, decode, encode

TASK = {
    "v": 1,
    "kind": "task",
    "id": 7,
    "revision": 0,
    "robot": "r1",
    "item": "i3",
    "decided_at": 1.0,
    "start": 2,
    "earliest_start": 1.5,
    "latest_start": 2.5,
    "meet_at": 3.0,
    "meet": {"x": 1.25, "y": -0.1},
    "bin": {"x": 1.2, "y": 0.7},
    "free_at": 4.0,
    "priority": 1.0,
    "strategy": "rules:SPT,FIFO",
}


@pytest.fixture(scope="module")
def schema() -> dict:
    made = subprocess.run([PROGRAM, "run", "--schema"], capture_output=True, check=True)
    return json.loads(made.stdout)


def resolve(schema: dict, node: dict) -> dict:
    """A node of the schema with what it refers to, and without `null`."""
    node = dict(node)
    if "anyOf" in node:
        (node_of,) = (one for one in node.pop("anyOf") if one != {"type": "null"})
        node.update(node_of)
    if "$ref" in node:
        referred = resolve(schema, schema["$defs"][node["$ref"].rsplit("/", 1)[1]])
        own = {key: value for key, value in node.items() if key != "$ref"}
        properties = {**referred.get("properties", {}), **own.get("properties", {})}
        required = [*referred.get("required", []), *own.get("required", [])]
        node = {**referred, **own, "properties": properties, "required": required}
    return node


def accepts_null(node: dict) -> bool:
    return "null" in node.get("type", []) or {"type": "null"} in node.get("anyOf", [])


def check_type(schema: dict, node: dict, wanted: object, place: str) -> None:
    """A type of Python is that of the schema."""
    origin, arguments = typing.get_origin(wanted), typing.get_args(wanted)
    if origin in (typing.Union, types.UnionType):
        (wanted,) = (one for one in arguments if one is not type(None))
        return check_type(schema, node, wanted, place)
    node = resolve(schema, node)
    kind = node.get("type")
    if isinstance(kind, list):
        (kind,) = (one for one in kind if one != "null")
    if kind is None or "oneOf" in node:
        assert isinstance(wanted, type) and issubclass(wanted, (StrEnum, str)), place
        words = {one["const"] for one in node["oneOf"]}
        enum = SourceKind if wanted is str else wanted
        assert words == {word.value for word in enum}, place
    elif kind == "array":
        assert origin is tuple, place
        if "maxItems" in node:
            assert len(arguments) == node["maxItems"] == node["minItems"], place
        else:
            assert arguments[1] is ..., place
        check_type(schema, node["items"], arguments[0], place)
    elif kind == "object" and origin is Mapping:
        values = node["additionalProperties"]
        if values is True:
            assert arguments[1] is typing.Any, place
        else:
            check_type(schema, values, arguments[1], place)
    elif kind == "object":
        check_class(schema, node, wanted, place)
    else:
        names = {"number": float, "integer": int, "string": str, "boolean": bool}
        assert wanted is names[kind], f"{place}: {wanted} for {kind}"


def check_class(schema: dict, node: dict, cls: type, place: str) -> None:
    """A class has the fields of the schema, no others, and requires the same."""
    hints = typing.get_type_hints(cls)
    fields = {
        "class" if one.name == "class_" else one.name: one
        for one in dataclasses.fields(cls)
        if one.name not in ("extra", "kind") or (one.name == "kind" and cls is SourceReport)
    }
    properties = dict(node["properties"])
    if cls is not SourceReport:
        properties.pop("kind", None)
    properties.pop("v", None)
    assert set(fields) == set(properties), place
    for name, one in fields.items():
        where = f"{place}.{name}"
        is_required = one.default is dataclasses.MISSING and one.default_factory is dataclasses.MISSING
        assert is_required == (name in node["required"]), where
        may_be_none = type(None) in typing.get_args(hints[one.name])
        assert may_be_none == accepts_null(properties[name]), where
        check_type(schema, properties[name], hints[one.name], where)
        doc = inspect.cleandoc(cls.__doc__ or "")
        assert f"\n    {one.name}: " in doc, f"{where} is not described"
        unit = [word for word in ("[s]", "[m]", "[m/s]", "[rad]", "[ms]", "[cm^2]", "[m^2]")
                if word in properties[name].get("description", "")]
        described = re.split(r"\n    (?=\w+: )", doc.split(f"\n    {one.name}: ", 1)[1], maxsplit=1)[0]
        assert all(word in described for word in unit), f"{where} has no unit: {unit}"


@needs_program
@pytest.mark.parametrize(("side", "known"), [("Incoming", TO_NODE), ("Outgoing", FROM_NODE)])
def test_every_kind_field_and_type_is_that_of_the_schema(schema: dict, side: str, known: dict) -> None:
    kinds = set()
    for one in schema["$defs"][side]["oneOf"]:
        node = resolve(schema, one)
        kind = node["properties"]["kind"]["const"]
        kinds.add(kind)
        assert node["properties"]["v"]["const"] == messages.VERSION
        check_class(schema, node, known[kind], kind)
    assert kinds == set(known)


def test_numbers_keep_every_bit() -> None:
    for x in (0.1 + 0.2, -1 / 3, 5e-324, 123_456.789_012_345_67):
        message = Detection(1_795_000_000.123_456_7, x, -x / 7, id='a\u00e9"b', class_="PET", size=(0.1, 0.2))
        values = json.loads(encode(message))
        assert values["kind"] == "detection" and values["v"] == 1 and values["class"] == "PET"
        assert (values["x"], values["y"], values["stamp"]) == (x, -x / 7, message.stamp)
        assert "source" not in values and values["size"] == [0.1, 0.2]


def test_what_the_node_accepts_it_accepts() -> None:
    encode(Hello("p", Role.ROBOT, ("r1", "r2"), token="x" * 16))
    encode(RobotStatus(1.0, "r1", "idle", available_at=2, task=3))
    encode(Report(1, 2, "PICKED", found=(0.1, 0.2)))
    assert json.loads(encode(Report(1, 2, Verdict.MISSED, found=Point(1, 2))))["found"] == {"x": 1.0, "y": 2.0}
    assert json.loads(encode(Order("pause", 1.0))) == {"v": 1, "kind": "pause", "stamp": 1.0}
    assert json.loads(encode(Ack(1.0, 2**64 - 1)))["task"] == 2**64 - 1
    assert json.loads(encode(BeltState(1.0, 0.0, -5)))["position"] == -5.0
    assert json.loads(encode(Tick(0)))["stamp"] == 0.0


def test_numbers_of_numpy_are_numbers() -> None:
    numpy = pytest.importorskip("numpy")
    message = Detection(numpy.float64(1), numpy.float32(0.5), numpy.int64(0), size=numpy.array([0.1, 0.2]))
    assert json.loads(encode(message))["x"] == 0.5
    assert Ack(1.0, numpy.uint32(5)).task == 5


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Detection(math.nan, 0, 0), ["`stamp`", "nan"]),
        (lambda: Detection(1795656426000, 0, 0), ["`stamp`", "milli"]),
        (lambda: Detection(-1, 0, 0), ["`stamp`"]),
        (lambda: Detection(1, -350, 0), ["`x`", "-250"]),
        (lambda: Detection(1, math.inf, 0), ["`x`"]),
        (lambda: Detection(1, None, 0), ["`x`"]),
        (lambda: Detection(1, "1", 0), ["`x`", "not a number"]),
        (lambda: Detection(1, True, 0), ["`x`", "not a number"]),
        (lambda: Detection(1, 0, 0, id=7), ["`id`", "str("]),
        (lambda: Detection(1, 0, 0, id=""), ["`id`", "empty"]),
        (lambda: Detection(1, 0, 0, id=" a"), ["`id`", "space"]),
        (lambda: Detection(1, 0, 0, id="a\nb"), ["`id`", "control"]),
        (lambda: Detection(1, 0, 0, id="a\u202eb"), ["`id`", "control"]),
        (lambda: Detection(1, 0, 0, id="\ud800"), ["`id`", "control"]),
        (lambda: Detection(1, 0, 0, id="x" * 201), ["`id`", "201"]),
        (lambda: Detection(1, 0, 0, p_grasp=2), ["`p_grasp`", "probability"]),
        (lambda: Detection(1, 0, 0, size=(1, 2, 3)), ["`size`", "2 numbers"]),
        (lambda: Detection(1, 0, 0, size=0.1), ["`size`"]),
        (lambda: Detection(1, 0, 0, covariance=(1e-6, 1e-3, 1e-6)), ["`covariance`"]),
        (lambda: Detection(1, 0, 0, data={"a": math.nan}), ["`data`", "JSON"]),
        (lambda: Detection(1, 0, 0, data={"a": object()}), ["`data`", "JSON"]),
        (lambda: Detection(1, 0, 0, data=[1]), ["`data`", "dict"]),
        (lambda: Detection(1, 0, 0, data={"a": "x" * 5000}), ["`data`", "4096"]),
        (lambda: BeltState(1, 11), ["`speed`", "10"]),
        (lambda: BeltState(1, None), ["`speed`"]),
        (lambda: RobotStatus(1, "r1", "asleep"), ["`state`", "idle, busy, fault"]),
        (lambda: RobotStatus(1, "r1", "idle", available_at=math.inf), ["`available_at`"]),
        (lambda: Ack(1, -1), ["`task`"]),
        (lambda: Ack(1, 1.5), ["`task`"]),
        (lambda: Report(1, 1, "OK"), ["`result`", "GRASP_FAIL"]),
        (lambda: Report(1, 1, "PICKED", found=(1, math.inf)), ["`found`"]),
        (lambda: Order("start", 1), ["`kind`", "pause"]),
        (lambda: Hello("p", "robot"), ["`robots`"]),
        (lambda: Hello("p", "camera", ("r1",)), ["`robots`"]),
        (lambda: Hello("p", "robot", "r1"), ["`robots`", "list"]),
    ],
)
def test_what_the_node_would_refuse_is_refused_here(make, words: list[str]) -> None:
    with pytest.raises(BadMessage) as caught:
        make()
    text = str(caught.value)
    assert all(word in text for word in words), text
    assert "\n" not in text and len(text) < 400
    assert isinstance(caught.value, ValueError)


def test_a_token_is_in_no_text() -> None:
    assert "secret" not in repr(Hello("p", "camera", token="secret" * 4))


def test_a_task_is_read_and_unknown_fields_are_kept() -> None:
    task = decode(json.dumps({**TASK, "class": "PET", "size": [0.1, 0.2], "tool": "cup", "angle": None}))
    assert isinstance(task, Task)
    assert (task.start, task.meet, task.class_, task.size) == (2.0, Point(1.25, -0.1), "PET", (0.1, 0.2))
    assert task.angle is None and task.extra == {"tool": "cup"}
    with pytest.raises(dataclasses.FrozenInstanceError):
        task.id = 8  # type: ignore[misc]


def test_a_kind_of_a_newer_node_is_skipped() -> None:
    assert decode(b'{"v":1,"kind":"weather","stamp":1}') is None


def without(name: str) -> str:
    return json.dumps({key: value for key, value in TASK.items() if key != name})


@pytest.mark.parametrize(
    ("line", "word"),
    [
        (b"", "not JSON"),
        (b"\xff\xfe", "not JSON ('utf-8'"),
        (b"[" * 100_000, "not JSON"),
        (b"SSH-2.0-OpenSSH_9.2", "SSH-2.0"),
        (b"[1]", "instead of an object"),
        (b'{"kind":7}', "without `kind`"),
        (b'{"v":2,"kind":"due","stamp":1}', "version 2"),
        (b'{"v":true,"kind":"due","stamp":1}', "version"),
        (b'{"kind":"due"}', "`stamp` is missing"),
        (b'{"kind":"due","stamp":null}', "`stamp`"),
        (b'{"kind":"due","stamp":NaN}', "`stamp`"),
        (b'{"kind":"due","stamp":1e999}', "`stamp`"),
        (b'{"kind":"due","stamp":true}', "`stamp`"),
        (b'{"kind":"hello","accepted":1}', "`accepted`"),
        (b'{"kind":"hello","accepted":true,"robots":"r1"}', "`robots`"),
        (without("meet").encode(), "`meet` is missing"),
        (json.dumps({**TASK, "meet": {"x": 1}}).encode(), "`y` is missing"),
        (json.dumps({**TASK, "size": [1]}).encode(), "`size`"),
        (json.dumps({**TASK, "id": -1}).encode(), "`id`"),
        (json.dumps({**TASK, "start": 10**400}).encode(), "`start`"),
    ],
)
def test_what_is_no_message_is_named(line: bytes, word: str) -> None:
    with pytest.raises(BadReply) as caught:
        decode(line)
    assert word in str(caught.value)
    assert len(str(caught.value)) < 500 and "\n" not in str(caught.value)


def test_whatever_comes_is_a_message_or_named() -> None:
    rng = random.Random(1)
    whole = json.dumps({**TASK, "class": "PET", "size": [0.1, 0.2], "data": {"a": [1, None]}}).encode()
    read = 0
    for _ in range(5000):
        line = bytearray(whole)
        for _ in range(rng.randint(1, 4)):
            at = rng.randrange(len(line))
            match rng.randrange(4):
                case 0:
                    line[at] = rng.randrange(256)
                case 1:
                    del line[at : at + rng.randint(1, 8)]
                case 2:
                    line[at:at] = rng.choice([b"null", b"1e999", b"[", b'"', b"-1", b"{}", b",", b"\xff"])
                case _:
                    line[at:at] = line[rng.randrange(len(line)) :][:6]
        try:
            message = decode(bytes(line))
        except BadReply as error:
            assert "\n" not in str(error) and len(str(error)) < 600
        else:
            read += 1
            assert message is None or isinstance(message.extra, dict)
    assert read > 100


# Each is refused here; so it must be by the node, or this side is too strict.
REFUSED = [
    '"stamp":-1,"x":0.3,"y":0',
    '"stamp":1795656426000000,"x":0.3,"y":0',
    '"stamp":NOW,"x":-250.1,"y":0',
    '"stamp":NOW,"x":1000001,"y":0',
    '"stamp":NOW,"x":0.3,"y":1000001',
    '"stamp":NOW,"x":"0.3","y":0',
    '"stamp":NOW,"x":true,"y":0',
    '"stamp":NOW,"x":0.3',
    '"stamp":NOW,"x":0.3,"y":0,"id":7',
    '"stamp":NOW,"x":0.3,"y":0,"id":""',
    '"stamp":NOW,"x":0.3,"y":0,"id":" a"',
    '"stamp":NOW,"x":0.3,"y":0,"id":"a\\nb"',
    '"stamp":NOW,"x":0.3,"y":0,"id":"a\\u202eb"',
    '"stamp":NOW,"x":0.3,"y":0,"id":"a\\u0085b"',
    '"stamp":NOW,"x":0.3,"y":0,"id":"\\u3000a"',
    '"stamp":NOW,"x":0.3,"y":0,"area_cm2":1000001',
    '"stamp":NOW,"x":0.3,"y":0,"weight":-1',
    '"stamp":NOW,"x":0.3,"y":0,"p_grasp":1.01',
    '"stamp":NOW,"x":0.3,"y":0,"angle":7.1',
    '"stamp":NOW,"x":0.3,"y":0,"height":10.1',
    '"stamp":NOW,"x":0.3,"y":0,"size":[1]',
    '"stamp":NOW,"x":0.3,"y":0,"covariance":[0.05,0,0.01]',
    '"stamp":NOW,"x":0.3,"y":0,"covariance":[1e-6,1e-3,1e-6]',
    '"stamp":NOW,"x":0.3,"y":0,"data":[1]',
    '"stamp":NOW,"x":0.3,"y":0,"colour":"red"',
]


def made_here(text: str, now: float) -> None:
    values = json.loads("{" + text.replace("NOW", repr(now)) + "}")
    values = {"class_" if name == "class" else name: value for name, value in values.items()}
    Detection(**values)


@needs_program
def test_the_node_refuses_what_is_refused_here_and_takes_what_is_taken() -> None:
    async def play() -> None:
        async with node("--status-every", "0.05", "--max-peers", "200") as line, Monitor(line.address) as monitor:
            for number, text in enumerate(REFUSED):
                now = time.time()
                with pytest.raises((BadMessage, TypeError)):
                    made_here(text, now)
                reader, writer = await asyncio.open_connection("127.0.0.1", line.port)
                writer.write(b'{"kind":"hello","name":"raw","role":"camera"}\n')
                writer.write(('{"kind":"detection",' + text.replace("NOW", repr(now)) + "}\n").encode())
                await eventually(
                    lambda: monitor.status and sum(monitor.status.rejected.values()) == number + 1,
                    f"the refusal of {text}",
                )
                assert set(monitor.status.rejected) <= {"value", "field", "stamp", "syntax"}
                writer.close()
                await writer.wait_closed()
            refused = dict(monitor.status.rejected)
            async with Camera(line.address) as camera:
                x = 0.0
                for extra in [
                    {"id": "x" * 200},
                    {"id": "\u00e9 \U0001f4a1 a,b", "class": "PET", "source": "s"},
                    {"area_cm2": 1e6, "weight": 1e12, "p_detection": 1, "p_grasp": 0.0},
                    {"angle": -7, "height": 10, "size": (10, 0)},
                    {"covariance": (0.04, 0.04, 0.04)},
                    {"data": {"a": "x" * (4096 - 8)}},
                    {"data": {"\u00e9": ["\u00e9" * 2000, None, True, 1.5, {"b": {}}]}},
                    {"data": {}},
                ]:
                    x += 0.1
                    await camera.report([{"x": x, "y": 0.4, **extra}])
                await eventually(lambda: monitor.status.seen == 8, "the items")
                assert dict(monitor.status.rejected) == refused

    run(play())


def test_words_equal_their_texts() -> None:
    assert Verdict.PICKED == "PICKED" and f"{RobotState.IDLE}" == "idle"
