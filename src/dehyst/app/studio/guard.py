"""Who may ask: pages of the studio itself, with its token, of the user who started it."""

from __future__ import annotations

import os
import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from pathlib import Path
from typing import Any

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
    """

    def __init__(self, app: App, *, port: int, token: str) -> None:
        self.app, self.port = app, port
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        self.token = f"Bearer {token}".encode()

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
        sent = {name.decode("latin-1"): value for name, value in scope["headers"]}  # the last one, if there are two
        host = sent.get("host", b"").decode("latin-1")
        if host not in self.hosts:
            return f"This server is 127.0.0.1:{self.port}, and was asked for by another name."
        origin = sent.get("origin")
        if origin is not None and origin.decode("latin-1") != f"http://{host}":
            return "Pages from elsewhere may not call the studio."
        if sent.get("sec-fetch-site", b"none") not in (b"none", b"same-origin"):
            return "Pages from elsewhere may not call the studio."
        client = scope.get("client")
        owner = owner_of(client[1], self.port) if client else None
        if owner not in (None, 0, os.getuid() if hasattr(os, "getuid") else None):
            return "The studio belongs to another user of this machine."
        if scope["path"].startswith("/api/") and not secrets.compare_digest(sent.get("authorization", b""), self.token):
            return "The token is missing or wrong: open the address that `dehyst studio` printed."
        return ""


def owner_of(port: int, server: int, table: Path = Path("/proc/net/tcp")) -> int | None:
    """User id of the process at the other end of a connection of this machine; None where nothing tells.

    Linux lists connections as ``sl local remote st tx:rx tr:when retrnsmt uid ...``, ports in hexadecimal.

    Examples
    --------
    >>> owner_of(1, 2, Path("nowhere")) is None
    True
    """
    try:
        lines = table.read_text(encoding="ascii").splitlines()[1:]
    except (OSError, UnicodeDecodeError):
        return None
    ends = f":{port:04X}", f":{server:04X}"
    for words in map(str.split, lines):
        if len(words) > 7 and words[1].endswith(ends[0]) and words[2].endswith(ends[1]):
            return int(words[7])
    return None
