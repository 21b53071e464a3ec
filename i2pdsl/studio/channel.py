"""One connection of a page: messages in and out, the language server and ours side by side.

The language server is the one of `i2p lsp`, unchanged: it gets every message that is not ours, and
writes to the same socket. It keeps the texts, of which everything here is said.
"""

from __future__ import annotations

import asyncio
import json
import sys
import traceback
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from i2pdsl.errors import StoryError
from i2pdsl.studio.folder import Folder, told
from i2pdsl.studio.protocol import OURS, REQUESTS, STALE, STORY, USAGE, Refusal
from i2pdsl.studio.reading import read
from i2pdsl.untrusted import json_excess

if TYPE_CHECKING:
    from pygls.workspace import TextDocument

    from i2pdsl.editor.server import StoryServer

DEEPEST = 100  # lists in lists, of a message
_INVALID, _UNKNOWN, _INTERNAL = -32600, -32601, -32603  # JSON-RPC 2.0, section 5.1

Handler = Callable[[Any], Awaitable[Any]]


class Channel:
    """What comes from a socket, and what goes there."""

    def __init__(self, folder: Folder, send: Callable[[str], None]):
        self.folder = folder
        self.loop = asyncio.get_running_loop()
        self._send = send
        self._tasks: set[asyncio.Task[Any]] = set()
        self._handlers: dict[str, Handler] = {}
        self._server: StoryServer | None = None

    def answers(self, name: str, handler: Handler) -> None:
        """Who answers a request."""
        self._handlers[name] = handler

    # Out.

    def send(self, message: dict[str, Any]) -> None:
        self._send(_encoded(message))

    def notify(self, name: str, params: dict[str, Any]) -> None:
        """A notification; in the loop's thread."""
        self.send({"method": f"{OURS}{name}", "params": finite(params)})

    # In.

    def received(self, text: str) -> None:
        """A message of the page."""
        try:
            if json_excess(text, DEEPEST, 200_000):
                raise ValueError
            message = json.loads(text, parse_constant=_no_number)
            if not isinstance(message, dict) or message.get("jsonrpc") != "2.0":
                raise ValueError
        except (ValueError, RecursionError):
            self.send({"id": None, "error": {"code": _INVALID, "message": "no message"}})
            return
        method = message.get("method")
        if isinstance(method, str) and method.startswith(OURS):
            self.spawn(self._answer(message.get("id"), method, message.get("params")))
        elif method != "exit":  # which would end the process
            self._pass_on(message)

    def spawn(self, work: Coroutine[Any, Any, Any]) -> None:
        """Work that nobody waits for; what becomes of it is of no interest."""
        task = self.loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._done)

    def _done(self, task: asyncio.Task[Any]) -> None:
        self._tasks.discard(task)
        if not task.cancelled():
            task.exception()  # seen

    async def _answer(self, number: Any, method: str, params: Any) -> None:
        name = method.removeprefix(OURS)
        try:
            if name not in self._handlers:
                raise Refusal(USAGE, f"there is no `{method[:60]}`")
            result = await self._handlers[name](read(REQUESTS[name], params))
            # Encoded here: whoever asked is answered, also where the result is no JSON.
            reply = _encoded({"id": number, "result": finite(result)})
        except Refusal as problem:
            reply = _encoded({"id": number, "error": finite(problem.as_json())})
        except StoryError as problem:
            refusal = Refusal(STORY, problem.diagnostics[0].message, **told(problem))
            reply = _encoded({"id": number, "error": finite(refusal.as_json())})
        except Exception as problem:  # a mistake of ours: the studio goes on
            traceback.print_exc(file=sys.stderr)
            error = {"code": _INTERNAL, "message": f"{type(problem).__name__}: {problem}"}
            reply = _encoded({"id": number, "error": error})
        if number is not None:
            self._send(reply)

    # The language server.

    def _pass_on(self, message: dict[str, Any]) -> None:
        uri = _uri_of(message.get("params"))
        if uri is not None:
            try:
                self.folder.path_of(uri)
            except Refusal as problem:
                if message.get("id") is not None:
                    self.send({"id": message["id"], "error": problem.as_json()})
                return
        protocol = self.server.protocol
        try:
            structured = protocol.structure_message(message)
        except Exception as problem:  # whatever the converter raises
            error = {"code": _INVALID, "message": str(problem)}
            self.send({"id": message.get("id"), "error": error})
            return
        protocol.handle_message(structured)

    @property
    def server(self) -> StoryServer:
        if self._server is None:
            from i2pdsl.editor.server import build_server

            self._server = build_server()
            self._server.protocol.set_writer(self, include_headers=False)
        return self._server

    def write(self, data: bytes) -> None:
        """What the language server says (pygls' `Writer`)."""
        self._send(data.decode("utf-8"))

    def close(self) -> None:
        """The page is gone."""
        for task in self._tasks:
            task.cancel()
        if self._server is not None:
            for check in self._server.checks.values():
                check.cancel()
            self._server.worker.shutdown(wait=False, cancel_futures=True)
            self._server.shutdown()

    # Documents.

    def document(self, uri: str, version: int | None) -> tuple[str, str]:
        """The path and text of an open document. Raises Refusal where its version is another."""
        path = self.folder.path_of(uri)
        found = self._open(uri)
        if found is None:
            raise Refusal(USAGE, f"{path} is not open")
        if version is not None and found.version != version:
            raise Refusal(STALE, f"version {version} of {path} is no longer the present one")
        return path, found.source

    def is_present(self, uri: str, version: int) -> bool:
        found = self._open(uri)
        return found is not None and found.version == version

    def _open(self, uri: str) -> TextDocument | None:
        """A document, if it is open; none is before the page has said `initialize`."""
        try:
            return self.server.workspace.text_documents.get(uri)
        except RuntimeError:
            return None


def _encoded(message: dict[str, Any]) -> str:
    return json.dumps({"jsonrpc": "2.0", **message}, allow_nan=False)


def finite(value: Any) -> Any:
    """Plain data with null for numbers that JSON does not have."""
    if isinstance(value, float):
        return value if value - value == 0 else None
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if hasattr(value, "__dataclass_fields__"):
        return finite(asdict(value))
    return value


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is no JSON")


def _uri_of(params: Any) -> str | None:
    """The document that a message of the language server protocol is about."""
    about = params.get("textDocument") if isinstance(params, dict) else None
    uri = about.get("uri") if isinstance(about, dict) else None
    return uri if isinstance(uri, str) else None
