"""The studio's server: one page, its files, one socket (Starlette, uvicorn, websockets)."""

from __future__ import annotations

import asyncio
import ctypes
import errno
import hashlib
import mimetypes
import os
import secrets
import socket
import stat
import tempfile
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from importlib.resources import files
from ipaddress import ip_address
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from i2pdsl.resources import data_folder
from i2pdsl.studio.guard import SUBPROTOCOL, Guard
from i2pdsl.studio.protocol import LARGEST_MESSAGE
from i2pdsl.studio.studio import Studio
from i2pdsl.untrusted import read_bytes

PORT, TRIED = 8760, 40  # the first port that is tried, and how many
TOKEN_BYTES = 24
MOST_PAGES = 24  # connections at once
_ARENAS = -8  # M_ARENA_MAX of malloc.h
_TYPES = {".js": "text/javascript", ".svg": "image/svg+xml", ".woff2": "font/woff2"}


def shelf() -> dict[str, Path]:
    """What is served, by its path: files of ours, looked up once, and nothing else."""
    found: dict[str, Path] = {}
    package = Path(str(files("i2pdsl")))
    render, client = package / "render", package / "studio" / "client"
    grammars = package / "editor" / "vscode" / "syntaxes"
    pictures = data_folder("stories") / "patterns" / "pictures"
    for before, folder, suffixes in (
        ("/render", render, (".js", ".css")),
        ("/language", grammars, (".json",)),
        ("/patterns", pictures, (".png",)),
        ("", client, (".html", ".js", ".css", ".svg", ".png", ".woff2", ".txt")),
    ):
        for path in folder.rglob("*"):
            if path.suffix in suffixes:
                found[f"{before}/{path.relative_to(folder).as_posix()}"] = path
    found["/"] = client / "index.html"
    return found


def application(studio: Studio, hosts: tuple[str, ...], token: str) -> Guard:
    """The ASGI application."""
    served = shelf()

    async def file(request: Request) -> Response:
        path = served.get(request.url.path)
        if path is None or not path.is_file():
            return PlainTextResponse("not found\n", 404)
        kind = _TYPES.get(path.suffix) or mimetypes.guess_type(path.name)[0]
        return FileResponse(path, media_type=kind, headers={"cache-control": "no-cache"})

    async def made(request: Request) -> Response:
        found = studio.made(request.path_params["secret"], request.path_params["name"])
        if found is None:
            return PlainTextResponse("not found\n", 404)
        return FileResponse(found, filename=found.name, headers={"cache-control": "no-store"})

    async def talk(socket: WebSocket) -> None:
        if len(studio.pages) >= MOST_PAGES:
            await socket.close(1013)
            return
        await socket.accept(SUBPROTOCOL)
        waiting: asyncio.Queue[str] = asyncio.Queue()
        page = studio.joined(waiting.put_nowait)

        async def write() -> None:
            with suppress(WebSocketDisconnect, RuntimeError):
                while True:
                    await socket.send_text(await waiting.get())

        writing = asyncio.create_task(write())
        try:
            while True:
                page.channel.received(await socket.receive_text())
        # KeyError: bytes, which nobody sends. Cancelled: the studio is closed, and this page did
        # not answer in time.
        except (WebSocketDisconnect, KeyError, asyncio.CancelledError):
            pass
        finally:
            writing.cancel()
            studio.left(page)

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        watching = asyncio.create_task(studio.watch())
        yield
        watching.cancel()
        studio.close()

    routes = [
        WebSocketRoute("/socket", talk),
        Route("/made/{secret}/{name}", made, methods=["GET"]),
        Route("/{path:path}", file, methods=["GET"]),
    ]
    return Guard(Starlette(routes=routes, lifespan=lifespan), hosts, token)


def listening(host: str, port: int | None) -> socket.socket:
    """A socket at a port, or at the first free one after the usual. Raises OSError."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    wanted = [port] if port is not None else [*range(PORT, PORT + TRIED), 0]
    for number in wanted:
        found = socket.socket(family, socket.SOCK_STREAM)
        if os.name == "posix":  # a port that was left a moment ago is free
            found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((host, number))
            found.listen(128)
            return found
        except OSError as problem:
            found.close()
            if problem.errno != errno.EADDRINUSE or number == wanted[-1]:
                raise
    raise AssertionError


def kept_token(folder: Path) -> str:
    """A folder's token, which only its user can read: the same when the studio is started again,
    so that pages that are open go on."""
    from platformdirs import user_state_path

    name = hashlib.sha256(str(folder.resolve()).encode()).hexdigest()[:32]
    token = secrets.token_urlsafe(TOKEN_BYTES)
    with suppress(OSError):  # where nothing can be kept it is another one each time
        path = user_state_path("i2pdsl") / "studio" / name
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        with suppress(FileNotFoundError):
            known = read_bytes(path, 2 * len(token)).decode("ascii", "replace")
            if len(known) == len(token) and _is_private(path):
                return known
            path.unlink()
        handle, temporary = tempfile.mkstemp(dir=path.parent)  # only the user may read it
        with open(handle, "w", encoding="ascii") as file:
            file.write(token)
        os.replace(temporary, path)
    return token


def _is_private(path: Path) -> bool:
    """Whether nobody else could have read a file, or written it."""
    if os.name != "posix":
        return True
    found = path.lstat()
    return found.st_uid == os.getuid() and stat.S_ISREG(found.st_mode) and not found.st_mode & 0o077


def is_loopback(host: str) -> bool:
    with suppress(ValueError):
        return ip_address(host).is_loopback
    return host == "localhost"


def own_hosts(host: str, port: int) -> tuple[str, ...]:
    """What the browser may say that it speaks to."""
    names = ["127.0.0.1", "localhost"] if is_loopback(host) else [host]
    if ":" in host:
        names = [f"[{host}]"]
    return tuple(f"{name}:{port}" for name in names)


def serve(
    folder: Path, start: str | None, host: str, port: int | None, ready: Callable[[str], None]
) -> None:
    """Serves a folder until somebody interrupts; `ready` is told the address, once it is served.

    Raises OSError where the port cannot be had, KeyboardInterrupt in the end.
    """
    _share_memory()
    listener = listening(host, port)
    number = listener.getsockname()[1]
    token = kept_token(folder)
    shown = f"[{host}]" if ":" in host else host
    app: Any = application(Studio(folder, start), own_hosts(host, number), token)
    config = uvicorn.Config(
        app,
        log_level="warning",
        access_log=False,
        server_header=False,
        date_header=False,
        proxy_headers=False,
        lifespan="on",
        loop="asyncio",
        http="h11",
        ws="websockets-sansio",
        ws_max_size=LARGEST_MESSAGE,
        ws_per_message_deflate=False,  # from a machine to itself it only takes time
        timeout_graceful_shutdown=2,
    )
    server = _Server(config, lambda: ready(f"http://{shown}:{number}/#{token}"))
    server.run([listener])


def _share_memory() -> None:
    """Has all threads take memory from one place: otherwise what one of them gives back is not
    for the others, and after a hundred solves the process holds a hundred MB for nothing."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):  # not the C library of Linux
        return
    mallopt(_ARENAS, 1)


class _Server(uvicorn.Server):
    """A server that says when it is there."""

    def __init__(self, config: uvicorn.Config, ready: Callable[[], None]):
        super().__init__(config)
        self._ready = ready

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self.started:
            self._ready()
