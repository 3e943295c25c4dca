"""Lines over TCP, with and without TLS."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import ssl
from collections.abc import Sequence

from .address import Address
from .errors import BadReply, Lost, Refused
from .messages import LONGEST_LINE, Answer, FromNode, Hello, ToNode, decode, encode
from .session import Session, Transport

__all__ = ["TcpTransport"]

LONGEST_REPLY = 16 * LONGEST_LINE
"""Maximum length of a line from the node [bytes]: a bound for what something else may send."""

CLOSE_TIMEOUT = 1.0
"""How long the node may take to notice that a connection ends [s]."""

MOST_UNSENT = 64 * 1024
"""Bytes that wait in this process for the other side before `send` waits."""

SILENT = "connected, but no answer to the hello"
"""What is wrong with something that only listens."""


class TcpTransport(Transport):
    """The way to `pickline run --listen`."""

    def __init__(self, address: Address, tls: ssl.SSLContext | None) -> None:
        self.address = address
        self._tls = tls

    async def open(self, hello: Hello) -> Session:
        place = str(self.address)
        self.reached = "no connection"
        try:
            reader, writer = await asyncio.open_connection(
                self.address.host, self.address.port, ssl=self._tls, limit=LONGEST_REPLY
            )
        except ssl.SSLCertVerificationError as error:
            cure = "give the authority that issued the node's certificate as `ca`"
            problem = f"its certificate is not trusted: {error.verify_message}"
            raise Refused(place, problem, cure) from None
        except ssl.SSLError as error:
            cure = "check that the node has --tls-cert, and that it trusts `cert` if it has --tls-ca"
            raise Lost(place, f"no TLS connection: {error.reason or error}", cure) from None
        except (OSError, UnicodeError) as error:
            cure = "start `pickline run --listen` there"
            problem = f"no connection: {getattr(error, 'strerror', None) or error}"
            raise Lost(place, problem, cure) from None
        self.reached = SILENT
        session = TcpSession(place, reader, writer, hello.name)
        try:
            prepare(writer.get_extra_info("socket"))
            writer.transport.set_write_buffer_limits(high=MOST_UNSENT)
            await session.send([hello])
            session.answer = await session.hear_answer()
        except BaseException:
            await session.close(flush=False)
            raise
        return session


def prepare(its: socket.socket | None) -> None:
    """Lets short messages leave at once, and the system notice a peer that is gone."""
    if its is None:
        return
    options = [(socket.IPPROTO_TCP, "TCP_NODELAY", 1), (socket.SOL_SOCKET, "SO_KEEPALIVE", 1)]
    # Gone is who answers nothing for about ten seconds. Not every system has these options.
    options += [
        (socket.IPPROTO_TCP, "TCP_KEEPIDLE", 4),
        (socket.IPPROTO_TCP, "TCP_KEEPINTVL", 2),
        (socket.IPPROTO_TCP, "TCP_KEEPCNT", 3),
        (socket.IPPROTO_TCP, "TCP_USER_TIMEOUT", 10_000),
    ]
    for level, name, value in options:
        option = getattr(socket, name, None)
        if option is not None:
            with contextlib.suppress(OSError):
                its.setsockopt(level, option, value)


class TcpSession(Session):
    """One TCP connection."""

    def __init__(
        self, place: str, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, name: str
    ) -> None:
        self._place = place
        self._reader = reader
        self._writer = writer
        self._name = name
        self.answer = Answer(accepted=False)

    def _lost(self, error: object = "") -> Lost:
        problem = "the node has closed the connection"
        if error:
            problem = f"the connection broke: {error}"
        return Lost(self._place, problem, "the log of the node says why")

    async def send(self, messages: Sequence[ToNode]) -> None:
        try:
            self._writer.write(b"".join(encode(message) + b"\n" for message in messages))
            await self._writer.drain()
        except (OSError, ssl.SSLError, RuntimeError) as error:
            raise self._lost(error) from None

    async def receive(self) -> FromNode | None:
        try:
            line = await self._reader.readuntil(b"\n")
        except asyncio.IncompleteReadError:
            raise self._lost() from None
        except asyncio.LimitOverrunError:
            # Where the next line begins is not known.
            problem = f"it sends a line of more than {LONGEST_REPLY} bytes"
            raise Lost(self._place, problem, "check that a node is at this address") from None
        except (OSError, ssl.SSLError) as error:
            raise self._lost(error) from None
        if not line.strip():
            return None
        message = decode(line, self._place)
        if isinstance(message, Answer) and not message.accepted:
            raise refused(self._place, self._name, message)
        return message

    async def hear_answer(self) -> Answer:
        """The answer to the hello, which the node sends before anything else."""
        try:
            while (message := await self.receive()) is None:
                pass
        except Lost as error:
            cure = "check that it is a node; for one with --tls-cert, give tls://HOST:PORT and `ca`"
            raise Lost(self._place, f"{error.problem}, without an answer to the hello", cure) from None
        if not isinstance(message, Answer):
            problem = f"it answers the hello with `{message.kind}`"
            raise BadReply(self._place, problem, "check that this is a node that listens")
        return message

    async def close(self, *, flush: bool) -> None:
        quiet = contextlib.suppress(OSError, RuntimeError, TimeoutError, ssl.SSLError)
        try:
            # A socket that is closed with unread input is reset, and what was sent may be lost. So
            # the node first reads the end of this side, and closes its own.
            with quiet:
                if flush:
                    async with asyncio.timeout(CLOSE_TIMEOUT):
                        await self._writer.drain()
                        if self._writer.can_write_eof():
                            self._writer.write_eof()
                            while await self._reader.read(LONGEST_LINE):
                                pass
            with quiet:
                self._writer.close()
                async with asyncio.timeout(CLOSE_TIMEOUT):
                    await self._writer.wait_closed()
        finally:
            self._writer.transport.abort()


def refused(place: str, name: str, answer: Answer) -> Refused:
    """The node's refusal as an error."""
    reason = answer.reason or "it gives no reason"
    cure, may_pass = "see the reason", True
    if "token" in reason:
        may_pass = False
        cure = "give the text in the node's `--token` file as `token`"
    elif "already speaks for" in reason:
        cure = "stop the other program that speaks for this robot"
    elif "another connection" in reason:
        cure = f"stop the other program that calls itself `{name}`, or give each a `name` of its own"
    elif "connected, and no more" in reason:
        cure = "give the node a larger --max-peers"
    elif "no robot" in reason:
        may_pass = False
        cure = "give the robot's name in the node's station file"
    return Refused(place, f"the node refuses `{name}`: {reason}", cure, reason, may_pass=may_pass)
