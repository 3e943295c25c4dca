"""Where a line is: addresses and what goes with them."""

from __future__ import annotations

import os
import ssl
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote, urlsplit

from .errors import BadAddress

__all__ = ["Address"]

PORTS = {"tcp": None, "tls": None, "mqtt": 1883, "mqtts": 8883}
"""The schemes, and the ports where none is given."""

TOKEN_LENGTHS = range(16, 1025)
"""The node takes tokens of these lengths [characters]."""


@dataclass(frozen=True)
class Address:
    """The place of a node or a broker, read from `HOST:PORT`, `tcp://HOST:PORT`, `tls://HOST:PORT`,
    `mqtt://HOST[:PORT]` or `mqtts://HOST[:PORT]`.

    Attributes:
        scheme: `tcp`, `tls`, `mqtt` or `mqtts`.
        host: Name or IP address.
        port: Port.
        user: User name at a broker.
        password: Password at a broker.
    """

    scheme: str
    host: str
    port: int
    user: str | None = None
    password: str | None = field(default=None, repr=False)

    @classmethod
    def read(cls, text: str) -> Address:
        """Reads an address.

        Raises:
            BadAddress: It is not one.
        """
        cure = "give HOST:PORT, for example 127.0.0.1:7400, or tls://, mqtt:// or mqtts://HOST:PORT"
        if not isinstance(text, str):
            raise BadAddress("the address", f"{text!r} is not a text", cure)
        # A URL may hold a password, which must not get into an error.
        place = "the address" if "@" in text else f"the address `{text}`"
        with_scheme = text if "://" in text else f"tcp://{text}"
        try:
            parts = urlsplit(with_scheme)
            port = parts.port
        except ValueError as error:
            raise BadAddress(place, str(error), cure) from None
        if parts.scheme not in PORTS:
            raise BadAddress(place, f"there is no scheme `{parts.scheme}`", cure)
        if port is None:
            port = PORTS[parts.scheme]
        if not parts.hostname or not port:
            raise BadAddress(place, "it has no host or no port", cure)
        if parts.path not in ("", "/") or parts.query or parts.fragment:
            raise BadAddress(place, "there is something after the port", cure)
        is_mqtt = parts.scheme in ("mqtt", "mqtts")
        if parts.username is not None and not is_mqtt:
            raise BadAddress(place, "only a broker has users", "give the node's token as `token`")
        return cls(
            parts.scheme,
            parts.hostname,
            port,
            None if parts.username is None else unquote(parts.username),
            None if parts.password is None else unquote(parts.password),
        )

    @property
    def is_mqtt(self) -> bool:
        """Whether it is that of a broker."""
        return self.scheme in ("mqtt", "mqtts")

    @property
    def is_tls(self) -> bool:
        """Whether the connection is encrypted."""
        return self.scheme in ("tls", "mqtts")

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        scheme = "" if self.scheme == "tcp" else f"{self.scheme}://"
        return f"{scheme}{host}:{self.port}"


def read_token(token: str | os.PathLike[str] | None) -> str | None:
    """A token: the text itself, or the content of a file that is given as a `pathlib.Path`.

    Raises:
        BadAddress: The file cannot be read, or the token is too short or too long.
    """
    if token is None:
        return None
    place = "`token`"
    if isinstance(token, os.PathLike):
        place = f"`token` in {Path(token)}"
        try:
            token = Path(token).read_text(encoding="utf-8")
        except (OSError, ValueError) as error:
            cure = "name a file that this user can read"
            raise BadAddress(place, str(error), cure) from None
    if not isinstance(token, str):
        raise BadAddress(place, "it is not a text", "give the token, or its file as a pathlib.Path")
    token = token.strip()
    if len(token) not in TOKEN_LENGTHS:
        cure = "give the text in the node's `--token` file, or the file as a pathlib.Path"
        raise BadAddress(place, f"it has {len(token)} characters, not 16 to 1024", cure)
    return token


def tls_context(
    address: Address,
    ca: str | os.PathLike[str] | None,
    cert: str | os.PathLike[str] | None,
    key: str | os.PathLike[str] | None,
) -> ssl.SSLContext | None:
    """What TLS needs, if the address asks for it.

    Raises:
        BadAddress: A file cannot be used, or is given for a connection without TLS.
    """
    if not address.is_tls:
        if ca or cert or key:
            encrypted = "mqtts" if address.is_mqtt else "tls"
            raise BadAddress(
                "`ca`, `cert` and `key`",
                f"the connection to {address} is not encrypted",
                f"give {encrypted}://{address.host}:{address.port}, or leave them out",
            )
        return None
    if bool(cert) != bool(key):
        raise BadAddress("`cert` and `key`", "one of the two is missing", "give both or neither")
    try:
        context = ssl.create_default_context(cafile=None if ca is None else os.fspath(ca))
    except (OSError, ssl.SSLError) as error:
        raise BadAddress(f"`ca` {ca}", str(error), "give a file of certificates (PEM)") from None
    # The node does not insist on extensions that a small authority of one's own leaves out, and from
    # Python 3.13 on this side would. Signatures, names and dates are checked all the same.
    context.verify_flags &= ~ssl.VERIFY_X509_STRICT
    if cert and key:
        try:
            context.load_cert_chain(os.fspath(cert), os.fspath(key), password=_no_password)
        except (OSError, ssl.SSLError) as error:
            cure = "give a certificate and its private key (PEM), which is not encrypted"
            raise BadAddress(f"`cert` {cert} and `key` {key}", str(error), cure) from None
    return context


def _no_password() -> str:
    # Otherwise OpenSSL asks on the terminal, and a service waits for ever.
    return ""
