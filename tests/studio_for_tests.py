"""A studio in a process of its own for tests, on a small world, and a page of it without a browser
that asks, listens and edits."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

from worlds_for_tests import with_small_world

SEARCH = "search beam(starts = 30, polish = 0)\n"  # what is solved in no time
HELP = f"# The robot helps.\nworld small\nlength 6\n{SEARCH}\nmaximize depict(rho > 0)\n"
BRIEF = f"# The robot helps.\nworld small\nlength 6\n\nmaximize depict(rho > 0)\n{SEARCH}"
LONG = 60.0  # seconds that nothing here takes


@dataclass
class Served:
    """`i2p studio` at work on a folder."""

    folder: Path
    port: str = ""
    address: str = ""
    process: Any = field(default=None, repr=False)

    def start(self) -> None:
        """Starts it, at the port that it had."""
        ports = ["--port", self.port] if self.port else []
        command = [sys.executable, "-m", "i2pdsl", "studio", str(self.folder), "--no-browser"]
        self.process = subprocess.Popen(
            [*command, *ports], stdout=subprocess.PIPE, text=True, env=dict(os.environ)
        )
        self.address = self.process.stdout.readline().strip()
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/#\S+", self.address)
        assert found is not None, self.address
        self.port = found[1]

    def kill(self) -> None:
        """Ends it at once, in the middle of whatever it does."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process.stdout.close()
        self.process = None


def fill(folder: Path) -> Path:
    with_small_world(folder)
    (folder / "help.story").write_text(HELP, encoding="utf-8")
    return folder


class Refused(Exception):
    """The studio's answer is an error."""

    def __init__(self, error: dict[str, Any]):
        super().__init__(error["message"])
        self.kind = error.get("data", {}).get("kind", error["code"])
        self.data = error.get("data", {})


class Talk:
    """A connection. `told` are the notifications so far."""

    def __init__(self, address: str):
        from websockets.sync.client import connect

        self.base, token = address.split("/#")
        self._open = ExitStack()
        opening = connect(
            f"{self.base.replace('http', 'ws')}/socket",
            subprotocols=["i2p", f"i2p.token.{token}"],
            origin=self.base,
            max_size=None,
        )
        self.socket = self._open.enter_context(opening)
        self.told: list[dict[str, Any]] = []
        self.replies: dict[int, dict[str, Any]] = {}
        self._numbers = count(1)
        self.uri, self.version, self.text, self.digest = "", 0, "", None
        about = {"processId": None, "rootUri": None, "capabilities": {}}
        self.capabilities = self.ask("initialize", about)["capabilities"]
        self.tell("initialized", {})

    def __enter__(self) -> Talk:
        return self

    def __exit__(self, *error: object) -> None:
        self._open.close()

    # Messages.

    def tell(self, method: str, params: dict[str, Any]) -> None:
        self.socket.send(json.dumps({"jsonrpc": "2.0", "method": method, "params": params}))

    def begin(self, method: str, params: dict[str, Any] | None = None) -> int:
        """Asks, and does not wait."""
        number = next(self._numbers)
        message = {"jsonrpc": "2.0", "id": number, "method": method, "params": params or {}}
        self.socket.send(json.dumps(message))
        return number

    def listen(self) -> dict[str, Any]:
        message: dict[str, Any] = json.loads(self.socket.recv(LONG))
        if "id" in message and "method" not in message:
            self.replies[message["id"]] = message
        else:
            self.told.append(message)
        return message

    def reply(self, number: int) -> Any:
        """Raises Refused."""
        while number not in self.replies:
            self.listen()
        message = self.replies.pop(number)
        if "error" in message:
            raise Refused(message["error"])
        return message["result"]

    def ask(self, method: str, params: dict[str, Any] | None = None) -> Any:
        return self.reply(self.begin(method, params))

    def until(self, method: str, **wanted: Any) -> dict[str, Any]:
        """The next notification of a method, those that came already included; all before it are
        forgotten."""
        while True:
            while self.told:
                message = self.told.pop(0)
                params = message.get("params", {})
                if message["method"] == method and all(
                    params.get(k) == v for k, v in wanted.items()
                ):
                    return params
            self.listen()

    # A document.

    @property
    def here(self) -> dict[str, Any]:
        return {"uri": self.uri, "version": self.version}

    def open(self, path: str) -> None:
        found = self.ask("i2p/open", {"path": path})
        self.uri, self.text, self.digest = found["uri"], found["text"], found["digest"]
        self.version += 1
        about = {**self.here, "languageId": found["language"], "text": self.text}
        self.tell("textDocument/didOpen", {"textDocument": about})

    def write(self, text: str) -> None:
        self.version, self.text = self.version + 1, text
        changes = [{"text": text}]
        self.tell("textDocument/didChange", {"textDocument": self.here, "contentChanges": changes})

    def by_hand(self, method: str, **params: Any) -> str:
        """Has the text edited; returns it."""
        reply = self.ask(f"i2p/{method}", {**self.here, **params})
        assert reply["version"] == self.version
        self.write(edited(self.text, reply["edits"]))
        return self.text

    def film(self, **params: Any) -> dict[str, Any]:
        """The first film of the text as it is."""
        self.told.clear()
        self.begin("i2p/solve", {**self.here, **params})
        film: dict[str, Any] = self.until("i2p/film", version=self.version)["film"]
        self.ask("i2p/cancel", {"uri": self.uri})
        return film

    def solve(self, **params: Any) -> dict[str, Any]:
        """The best film of the text as it is."""
        number = self.begin("i2p/solve", {**self.here, **params})
        reply = self.reply(number)
        assert reply == {"version": self.version, "finished": True}
        films = [m["params"] for m in self.told if m["method"] == "i2p/film"]
        film: dict[str, Any] = [f for f in films if f["version"] == self.version][-1]["film"]
        return film


def edited(text: str, edits: list[dict[str, Any]]) -> str:
    """A text with edits of the language server protocol, of ASCII."""
    starts = [0, *(found.end() for found in re.finditer("\n", text))]
    place = lambda at: starts[at["line"]] + at["character"]
    for edit in reversed(edits):
        start, end = place(edit["range"]["start"]), place(edit["range"]["end"])
        text = text[:start] + edit["newText"] + text[end:]
    return text
