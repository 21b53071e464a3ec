"""Who may speak to a studio: pages of its own address only, and those that know its token.

The studio listens on the loopback, but every page that a browser shows can send requests there. So
the `Host` must be the studio's own (a name that somebody makes point to 127.0.0.1 is none of them),
the `Origin` of a socket too, the token must be in its handshake, and nothing but that socket
changes anything: HTTP has GET and HEAD alone. What is served allows no scripts but its own files
(Content-Security-Policy, https://www.w3.org/TR/CSP3/).
"""

from __future__ import annotations

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

SUBPROTOCOL, TOKEN = "i2p", "i2p.token."
POLICY = (
    "default-src 'none'; script-src 'self'; font-src 'self'; "
    "style-src 'self'; style-src-attr 'unsafe-inline'; "
    "img-src 'self' data: blob:; media-src 'self' blob:; connect-src 'self' {sockets}; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class Guard:
    """An ASGI application in front of another one.

    Args:
        hosts: the values of `Host` that are the studio's own.
    """

    def __init__(self, app: App, hosts: tuple[str, ...], token: str):
        self.app, self.hosts = app, hosts
        self.token = f"{TOKEN}{token}".encode()
        policy = POLICY.format(sockets=" ".join(f"ws://{host}" for host in hosts))
        self.headers = [
            (name.encode(), value.encode())
            for name, value in (
                ("content-security-policy", policy),
                ("cross-origin-opener-policy", "same-origin"),
                ("cross-origin-resource-policy", "same-origin"),
                ("permissions-policy", "camera=(), microphone=(), geolocation=()"),
                ("referrer-policy", "no-referrer"),
                ("x-content-type-options", "nosniff"),
                ("x-frame-options", "DENY"),
            )
        ]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
        elif scope["type"] == "websocket":
            if self.may_connect(scope):
                await self.app(scope, receive, send)
            else:
                await receive()
                await send({"type": "websocket.close", "code": 1008})  # answered by 403
        elif not self.is_own(scope):
            await self.refuse(send, 403)
        elif scope["method"] not in ("GET", "HEAD"):
            await self.refuse(send, 405)
        else:
            await self.app(scope, receive, self.guarded(send))

    def is_own(self, scope: Scope) -> bool:
        """Whether a request is to this address and, as far as it says so, from this address."""
        hosts, origins = _values(scope, b"host"), _values(scope, b"origin")
        if len(hosts) != 1 or hosts[0] not in self.hosts:
            return False
        return not origins or origins == [f"http://{hosts[0]}"]

    def may_connect(self, scope: Scope) -> bool:
        if not self.is_own(scope) or len(_values(scope, b"origin")) != 1:
            return False
        # The length is no secret.
        offered = [each.encode() for each in scope.get("subprotocols", ())]
        knows = [hmac.compare_digest(each, self.token) for each in offered]
        return SUBPROTOCOL.encode() in offered and any(knows)

    def guarded(self, send: Send) -> Send:
        async def with_headers(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", ()), *self.headers]
            await send(message)

        return with_headers

    async def refuse(self, send: Send, status: int) -> None:
        kind = (b"content-type", b"text/plain; charset=utf-8")
        start = {"type": "http.response.start", "status": status}
        await send({**start, "headers": [kind, *self.headers]})
        await send({"type": "http.response.body", "body": b"refused\n"})


def _values(scope: Scope, name: bytes) -> list[str]:
    return [value.decode("latin-1") for key, value in scope["headers"] if key == name]
