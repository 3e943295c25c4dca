"""Lines over an MQTT 5 broker; needs the extra `pickline[mqtt]` (paho-mqtt 2.1 or later).

There is no hello: the broker's permissions decide who may write to which topic. Messages that must
not be lost wait until the node is there, which it shows on the topic PREFIX/node.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import secrets
import socket
import ssl
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from .address import Address
from .checks import shown
from .errors import BadAddress, BadReply, LineError, Lost, MissingPackage, Refused
from .messages import LONGEST_LINE, Answer, FromNode, Hello, Role, ToNode, decode, encode
from .session import Session, Transport

__all__ = ["MqttTransport", "check_prefix", "level"]

log = logging.getLogger("pickline.live")

KEEPALIVE = 10
"""The broker and this client notice within about this time that the other is gone [s]."""

SESSION_EXPIRY = 60
"""How long the broker keeps messages for a client that is away [s]."""

MESSAGE_EXPIRY = 60
"""The node refuses older messages, so the broker need not keep them [s]."""

RECEIVE_MAXIMUM = 512
"""Messages that the broker may send before the first is acknowledged."""

IN_FLIGHT = 64
"""Messages that the broker has not acknowledged before `send` waits."""

MOST_UNREAD = 10_000
"""A connection that brings more than can be read is given up."""

NODE_TIMEOUT = 5.0
"""How long the node may take to show that it is there [s]."""

CLOSE_TIMEOUT = 2.0
"""How long the end of a connection may take [s]."""

HEARD: dict[Role, tuple[str, ...]] = {
    Role.CAMERA: ("status", "due"),
    Role.ENCODER: ("status", "due", "belt_request"),
    Role.ROBOT: ("status", "due", "task", "cancel"),
    Role.OPERATOR: ("status", "due"),
    Role.OBSERVER: ("status", "due", "belt_request", "task", "cancel"),
}
"""What a role is sent over TCP, it subscribes to here."""

# Codes of MQTT 5, section 2.4.
NOT_AUTHORIZED = 0x87
BAD_PASSWORD = 0x86
UNSUPPORTED = 0x84
TAKEN_OVER = 0x8E


def check_prefix(prefix: str) -> str:
    """Checks the first levels of the topics.

    Raises:
        BadAddress: They are not valid.
    """
    is_good = (
        isinstance(prefix, str)
        and all(prefix.split("/"))
        and prefix.isprintable()
        and not any(c in prefix for c in "+#")
        and not prefix.startswith("$")
        and len(prefix.encode()) <= 200
    )
    if not is_good:
        cure = "give words separated by /, without + and #, for example plant/line1"
        raise BadAddress("`prefix`", f"`{shown(prefix)}` is not a valid topic prefix", cure)
    return prefix


def level(name: str) -> str:
    """A name as one level of a topic: special characters are written as %XX."""
    return "".join(f"%{ord(c):02X}" if c in "/+#%" else c for c in name)


class MqttTransport(Transport):
    """The way to `pickline run --mqtt`."""

    def __init__(
        self,
        address: Address,
        tls: ssl.SSLContext | None,
        prefix: str,
        user: str | None,
        password: str | None,
    ) -> None:
        try:
            import paho.mqtt.client
            import paho.mqtt.properties
            import paho.mqtt.subscribeoptions  # noqa: F401
        except ImportError as error:
            cure = "install it with `pip install paho-mqtt`, or use the node's TCP address"
            raise MissingPackage(f"{address}", f"MQTT needs the package paho-mqtt: {error}", cure) from None
        self.address = address
        self.prefix = check_prefix(prefix)
        self._tls = tls
        self._user = address.user if user is None else user
        self._password = address.password if password is None else password
        # The broker keeps messages under this name while the connection is away.
        self._client_id: str | None = None
        self._was_connected = False

    async def open(self, hello: Hello) -> Session:
        if self._client_id is None:
            self._client_id = f"pickline-{level(hello.name)}-{secrets.token_hex(4)}"
        session = MqttSession(self, hello)
        self.reached = "no connection to the broker"
        try:
            await session.connect(self._client_id, not self._was_connected)
            self.reached = "connected to the broker, but no node there"
            self._was_connected = True
            await session.subscribe()
            await session.await_node()
        except BaseException:
            await session.close(flush=False)
            raise
        return session

    def make_client(self, client_id: str) -> Any:
        """A client of paho, not yet connected."""
        import paho.mqtt.client as paho
        from paho.mqtt.enums import CallbackAPIVersion

        client = paho.Client(
            CallbackAPIVersion.VERSION2,
            client_id=client_id,
            protocol=paho.MQTTv5,
            reconnect_on_failure=False,
        )
        client.connect_timeout = NODE_TIMEOUT
        client.on_socket_open = _send_at_once
        # `send` has its own bound.
        client.max_inflight_messages_set(IN_FLIGHT)
        client.max_queued_messages_set(0)
        if self._user is not None:
            client.username_pw_set(self._user, self._password)
        if self._tls is not None:
            client.tls_set_context(self._tls)
        return client


def properties(packet: str, **values: Any) -> Any:
    """The properties of an MQTT 5 packet."""
    from paho.mqtt.packettypes import PacketTypes
    from paho.mqtt.properties import Properties

    found: Any = Properties(getattr(PacketTypes, packet))  # type: ignore[no-untyped-call]
    for name, value in values.items():
        setattr(found, name, value)
    return found


class MqttSession(Session):
    """One connection to a broker, over which a node is there."""

    def __init__(self, way: MqttTransport, hello: Hello) -> None:
        self._way = way
        self._hello = hello
        self._place = str(way.address)
        self._loop = asyncio.get_running_loop()
        self._inbox: asyncio.Queue[tuple[str, bytes] | LineError] = asyncio.Queue()
        self._connected: asyncio.Future[int] = self._loop.create_future()
        self._subscribed: asyncio.Future[list[int]] = self._loop.create_future()
        # Topics and futures of what the broker has not acknowledged.
        self._published: dict[int, tuple[str, asyncio.Future[int]]] = {}
        self._node: str | None = None
        self._client: Any = None
        self._connecting: asyncio.Future[Any] | None = None
        self._ended: LineError | None = None
        # What came before the node was there.
        self._first: deque[tuple[str, bytes]] = deque()
        self.answer = Answer(accepted=True)

    # From the thread of the client to this loop.

    def _call(self, what: Callable[..., None], *arguments: Any) -> None:
        # The loop may have ended.
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(what, *arguments)

    def _on_connect(self, _client: Any, _data: Any, _flags: Any, reason: Any, _properties: Any) -> None:
        self._call(self._settle, self._connected, _code(reason))

    def _on_subscribe(self, _client: Any, _data: Any, _mid: int, reasons: Any, _properties: Any) -> None:
        self._call(self._settle, self._subscribed, [_code(reason) for reason in reasons])

    def _on_publish(self, _client: Any, _data: Any, mid: int, reason: Any, _properties: Any) -> None:
        self._call(self._acknowledged, mid, _code(reason))

    def _on_message(self, _client: Any, _data: Any, message: Any) -> None:
        try:
            topic = message.topic
        except UnicodeDecodeError:
            return
        self._call(self._take, topic, message.payload, message.retain)

    def _on_disconnect(self, _client: Any, _data: Any, _flags: Any, reason: Any, _properties: Any) -> None:
        self._call(self._lose, f"{reason}", _code(reason))

    # In this loop.

    @staticmethod
    def _settle(future: asyncio.Future[Any], value: Any) -> None:
        if not future.done():
            future.set_result(value)

    def _acknowledged(self, mid: int, code: int) -> None:
        # `publish` has returned: this runs in the same loop.
        topic, future = self._published.pop(mid, ("", None))
        if future is None:
            return
        if code >= 0x80:
            # Mosquitto closes the connection then. This has to be known first.
            problem = f"the broker refuses messages on {topic} (code {code:#x})"
            cure = "allow this user to publish on the topics in docs/mqtt.md"
            self._end(Refused(self._place, problem, cure, is_final=code == NOT_AUTHORIZED))
        self._settle(future, code)

    def _end(self, error: LineError) -> LineError:
        """The session is over, for the first reason that there is."""
        if self._ended is None:
            self._ended = error
            self._inbox.put_nowait(error)
        return self._ended

    def _lose(self, why: str, code: int = 0) -> None:
        cure = "check the broker and the network"
        if code == TAKEN_OVER:
            cure = "another client has the same client id"
        ended = self._end(Lost(self._place, f"the connection to the broker has ended: {why}", cure))
        waited: list[asyncio.Future[Any]] = [self._connected, self._subscribed]
        for future in (*waited, *(future for _, future in self._published.values())):
            if not future.done():
                future.set_exception(ended)
                # Nobody may be waiting for it.
                future.exception()
        self._published.clear()

    def _take(self, topic: str, payload: bytes, retained: bool) -> None:
        rest = topic.removeprefix(f"{self._way.prefix}/")
        if rest == "node":
            self._hear_presence(payload)
        elif not retained:
            # What a broker retains may be of yesterday.
            if self._inbox.qsize() >= MOST_UNREAD:
                self._leave(f"{MOST_UNREAD} messages are unread, and more come")
            else:
                self._inbox.put_nowait((rest, payload))

    def _hear_presence(self, payload: bytes) -> None:
        try:
            presence = json.loads(payload)
            is_online, client = presence["state"] == "online", str(presence["client"])
        except (ValueError, KeyError, TypeError, RecursionError):
            return
        if is_online and self._node is None:
            self._node = client
            self._inbox.put_nowait(("node", b""))
        elif is_online and client != self._node:
            self._leave("the node has been started again")
        elif not is_online and self._node is not None:
            self._leave("the node has left the broker")

    def _leave(self, why: str) -> None:
        self._end(Lost(self._place, why, "see that `pickline run --mqtt` runs with this broker"))

    # The connection.

    async def connect(self, client_id: str, clean: bool) -> None:
        """Connects to the broker.

        Raises:
            Lost: There is no connection now.
            Refused: The broker does not let this user in.
        """
        client = self._client = self._way.make_client(client_id)
        client.on_connect = self._on_connect
        client.on_subscribe = self._on_subscribe
        client.on_publish = self._on_publish
        client.on_message = self._on_message
        client.on_disconnect = self._on_disconnect
        wishes = properties(
            "CONNECT", SessionExpiryInterval=SESSION_EXPIRY, ReceiveMaximum=RECEIVE_MAXIMUM
        )
        address = self._way.address

        def connect() -> None:
            client.connect(
                address.host, address.port, KEEPALIVE, clean_start=clean, properties=wishes
            )

        self._connecting = self._loop.run_in_executor(None, connect)
        # If it fails after this was cancelled, nobody looks.
        self._connecting.add_done_callback(lambda done: done.cancelled() or done.exception())
        try:
            # A thread cannot be cancelled: `close` waits for it.
            await asyncio.shield(self._connecting)
        except ssl.SSLCertVerificationError as error:
            problem = f"its certificate is not trusted: {error.verify_message}"
            cure = "give the authority that issued the broker's certificate as `ca`"
            raise Refused(self._place, problem, cure) from None
        except (OSError, ValueError) as error:
            cure = "start the broker, or check the address; with TLS it is mqtts://"
            raise Lost(self._place, f"no connection to the broker: {error}", cure) from None
        client.loop_start()
        code = await self._connected
        if code in (BAD_PASSWORD, NOT_AUTHORIZED):
            raise Refused(self._place, "the broker refuses the user", "check `user` and `password`")
        if code in (UNSUPPORTED, 1):
            raise Refused(self._place, "it is an MQTT 3 broker", "use one with MQTT 5")
        if code >= 0x80:
            raise Lost(self._place, f"the broker refuses the connection (code {code:#x})", "see its log")

    async def subscribe(self) -> None:
        """Subscribes to what its role is sent.

        Raises:
            Refused: The broker does not allow it.
        """
        from paho.mqtt.subscribeoptions import SubscribeOptions

        fresh = SubscribeOptions(qos=1, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)
        kept = SubscribeOptions(qos=1, retainHandling=SubscribeOptions.RETAIN_SEND_ON_SUBSCRIBE)
        topics = [(self._topic("node"), kept)]
        robots = [level(robot) for robot in self._hello.robots] or ["#"]
        for kind in HEARD[self._hello.role]:
            if kind in ("task", "cancel"):
                topics += [(self._topic(f"{kind}/{robot}"), fresh) for robot in robots]
            else:
                topics.append((self._topic(kind), fresh))
        self._client.subscribe(topics)
        codes = await self._subscribed
        for (topic, _), code in zip(topics, codes, strict=False):
            if code >= 0x80:
                cure = "allow this user to subscribe to the topics in docs/mqtt.md"
                problem = f"the broker refuses the subscription of {topic} (code {code:#x})"
                raise Refused(self._place, problem, cure)

    async def await_node(self) -> None:
        """Waits until the node is there: a broker that has restarted drops what nobody subscribes
        to.

        Raises:
            Lost: It is not.
        """
        try:
            async with asyncio.timeout(NODE_TIMEOUT):
                while True:
                    what = await self._inbox.get()
                    if isinstance(what, LineError):
                        raise what
                    if what[0] == "node":
                        return
                    # The broker has kept it while there was no connection.
                    self._first.append(what)
        except TimeoutError:
            problem = f"no node is connected to the broker under {self._way.prefix}/"
            cure = "start `pickline run --mqtt` with this broker, and the same --mqtt-prefix"
            raise Lost(self._place, problem, cure) from None

    def _topic(self, rest: str) -> str:
        return f"{self._way.prefix}/{rest}"

    async def send(self, messages: Sequence[ToNode]) -> None:
        for start in range(0, len(messages), IN_FLIGHT):
            window = [self._publish(message) for message in messages[start : start + IN_FLIGHT]]
            codes = await asyncio.gather(*window)
            if self._ended is not None and any(code >= 0x80 for code in codes):
                raise self._ended

    def _publish(self, message: ToNode) -> asyncio.Future[int]:
        """Hands a message to the client, which keeps the order."""
        if self._ended is not None:
            raise self._ended
        # Each sender has topics of its own, so that a broker can tell senders apart.
        topic = self._topic(f"{message.kind}/{level(self._hello.name)}")
        options = properties("PUBLISH", MessageExpiryInterval=MESSAGE_EXPIRY, ContentType="application/json")
        info = self._client.publish(topic, encode(message), qos=1, properties=options)
        if info.rc != 0:
            cure = "check the broker"
            raise self._end(Lost(self._place, f"the broker is not connected (code {info.rc})", cure))
        future: asyncio.Future[int] = self._loop.create_future()
        self._published[info.mid] = topic, future
        return future

    async def receive(self) -> FromNode | None:
        what = self._first.popleft() if self._first else await self._inbox.get()
        if isinstance(what, LineError):
            raise what
        topic, payload = what
        if topic == "node":
            return None
        place = f"{self._place} {self._topic(topic)}"
        if len(payload) > LONGEST_LINE:
            raise BadReply(place, f"it sends {len(payload)} bytes", "let only the node publish there")
        message = decode(payload, place)
        # Topics may have permissions, so a message must be of its topic's kind.
        if message is not None and message.kind != topic.split("/")[0]:
            problem = f"a `{message.kind}` comes on this topic"
            raise BadReply(place, problem, "let only the node publish there")
        return message

    async def close(self, *, flush: bool) -> None:
        # Everything that was sent is with the broker: `send` has waited for it.
        try:
            if self._connecting is not None and not self._connecting.done():
                await asyncio.wait([self._connecting], timeout=NODE_TIMEOUT)
        finally:
            if self._client is not None:
                client, self._client = self._client, None
                end = self._loop.run_in_executor(None, _end, client, flush)
                await asyncio.wait([end], timeout=CLOSE_TIMEOUT)


def _send_at_once(_client: Any, _data: Any, connected: Any) -> None:
    """Small packets must not wait for the acknowledgement of those before: an `ack` would be 40 ms
    late."""
    with contextlib.suppress(OSError):
        connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _end(client: Any, forget: bool) -> None:
    """Disconnects; `forget` lets the broker forget the client too. In a thread, because it waits for
    that of the client."""
    with contextlib.suppress(OSError, ValueError):
        expiry = 0 if forget else SESSION_EXPIRY
        client.disconnect(properties=properties("DISCONNECT", SessionExpiryInterval=expiry))
    client.loop_stop()


def _code(reason: Any) -> int:
    """The number of a reason code."""
    return int(getattr(reason, "value", reason))
