"""Who may ask: pages of the studio itself, with its token, of the user who started it."""

from __future__ import annotations

import os
import platform
import secrets
import socket
import sys
from collections.abc import Awaitable, Callable, Iterator, MutableMapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Send = Callable[[Message], Awaitable[None]]
Receive = Callable[[], Awaitable[Message]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

HEADERS = (
    (b"cache-control", b"no-store"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"referrer-policy", b"no-referrer"),
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
)


class Guard:
    """ASGI layer that answers 403 before anything else is looked at.

    Asked of every request: `Host` names this server (a name that was made to point here, DNS rebinding, does not),
    `Origin` and `Sec-Fetch-Site`, where a browser sends them, are those of its own pages, and the connection belongs to
    the user who runs the studio, or to root, where the system tells (Linux). Below /api/ the token is asked for too. It
    travels in a header, never in a cookie, which other servers of this machine would be sent as well; so no other
    page can have it sent along. No answer allows another origin (CORS).

    `key` stands in the command line of the browser that is opened, where other users see it: it gives the token once.
    """

    def __init__(self, app: App, *, port: int, token: str, key: str = "") -> None:
        self.app, self.port, self.server = app, port, (HOST, port)
        self.is_listed = is_listed(self.server)
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        self.token = _bearer(token)
        self.key = _bearer(key) if key else b""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or pass on."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", ()), *HEADERS]
            await send(message)

        why = self.refusal(scope)
        if not why:
            await self.app(scope, receive, guarded)
        elif scope["type"] == "http":
            kind = [(b"content-type", b"text/plain; charset=utf-8")]
            await guarded({"type": "http.response.start", "status": 403, "headers": kind})
            await guarded({"type": "http.response.body", "body": why.encode()})
        else:
            await send({"type": "websocket.close", "code": 1008})

    def refusal(self, scope: Scope) -> str:
        """Why a request is refused, "" if it is not."""
        sent = {
            name.decode("latin-1"): value for name, value in scope["headers"]
        }  # the last one, if there are two
        host = sent.get("host", b"").decode("latin-1")
        if host not in self.hosts:
            return f"This server is 127.0.0.1:{self.port}, and was asked for by another name."
        origin = sent.get("origin")
        if origin is not None and origin.decode("latin-1") != f"http://{host}":
            return "Pages from elsewhere may not call the studio."
        if sent.get("sec-fetch-site", b"none") not in (b"none", b"same-origin"):
            return "Pages from elsewhere may not call the studio."
        if not self._is_mine(scope.get("client")):
            return "The studio belongs to another user of this machine."
        if scope["path"] == ENTER:
            return "" if self._enters(sent.get("authorization", b"")) else USED
        # Compared in constant time: how long a refusal takes says nothing about the token.
        if scope["path"].startswith("/api/") and not secrets.compare_digest(
            sent.get("authorization", b""), self.token
        ):
            return "The token is missing or wrong: open the address that `dehyst studio` printed."
        return ""

    def _is_mine(self, client: Sequence[Any] | None) -> bool:
        """Whether this user or root asks; the token alone decides where the system does not tell."""
        owner = owner_of((client[0], client[1]), self.server) if client else None
        if owner is None:
            return not self.is_listed
        return owner == 0 or (hasattr(os, "getuid") and owner == os.getuid())

    def _enters(self, offered: bytes) -> bool:
        """Whether this is the key, which dies by it."""
        right = bool(self.key) and secrets.compare_digest(offered, self.key)
        if right:
            self.key = b""
        return right


HOST = "127.0.0.1"
ENTER = "/api/enter"
USED = (
    "This address opened the studio once, as others can see it. Open the one that `dehyst studio` printed in its "
    "terminal; if this is the first page that you see of it, somebody else was quicker: end the studio by Ctrl-C."
)
TABLES = Path("/proc/net")
ESTABLISHED, LISTENING = "01", "0A"

Address = tuple[str, int]


def _bearer(secret: str) -> bytes:
    return f"Bearer {secret}".encode()


def is_listed(server: Address, tables: Path = TABLES) -> bool:
    """Whether the system tells of every connection of this machine whose it is: it lists our own server.

    Under Windows' Linux a browser of Windows has no line in the table of Linux.
    """
    if "microsoft" in platform.release().lower():
        return False
    return any(
        line.local == server and line.state == LISTENING for line in _lines(server[1], tables)
    )


def owner_of(client: Address, server: Address, tables: Path = TABLES) -> int | None:
    """User id of the process at the other end of a connection of this machine; None where no line tells.

    Linux lists connections as ``sl local remote st tx:rx tr:when retrnsmt uid ...``: in tcp those of IPv4 sockets, in
    tcp6 those of IPv6 sockets, which reach an IPv4 server too. A socket that was closed is listed as root's: only an
    established connection has an owner.

    Examples
    --------
    >>> owner_of(("127.0.0.1", 1), ("127.0.0.1", 2), Path("nowhere")) is None
    True
    """
    for _ in range(2):  # a table that changes while it is read may lack a line
        for line in _lines(server[1], tables):
            if (line.local, line.remote, line.state) == (client, server, ESTABLISHED):
                return line.user
    return None


class _Line(NamedTuple):
    local: Address
    remote: Address
    state: str
    user: int


def _lines(port: int, tables: Path) -> Iterator[_Line]:
    """Lines of the tables that name a port."""
    for name in ("tcp", "tcp6"):
        try:
            rows = (tables / name).read_text(encoding="ascii").splitlines()
        except (OSError, UnicodeDecodeError):
            continue
        for row in rows:
            words = row.split()
            if f":{port:04X}" in row and len(words) > 7:
                yield _Line(_end(words[1]), _end(words[2]), words[3], int(words[7]))


def _end(text: str) -> Address:
    """Address and port of an end; an IPv4 address within IPv6 is that IPv4 address.

    Examples
    --------
    >>> _end("0100007F:1F90") == _end("0000000000000000FFFF00000100007F:1F90")
    True
    """
    address, _, port = text.partition(":")
    # The kernel prints an address as words of 32 bits in the byte order of the machine.
    words = [
        int(address[k : k + 8], 16).to_bytes(4, sys.byteorder) for k in range(0, len(address), 8)
    ]
    packed = b"".join(words).removeprefix(MAPPED)
    return socket.inet_ntop(socket.AF_INET if len(packed) == 4 else socket.AF_INET6, packed), int(
        port, 16
    )


MAPPED = bytes(10) + b"\xff\xff"
