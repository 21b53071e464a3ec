"""`i2p lsp`, spoken to as an editor does: JSON over the standard streams of a process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from commands_for_tests import PATIENCE
from fuzz_for_tests import examples

pytest.importorskip("pygls")

ROOT = Path(__file__).parents[2]
STORY = """# A ρobot 🤖 that helps.
world kitchen
length 15

let kind = rho > 0
maximize depict(kind)
"""


COMMAND = (
    "import sys; from i2pdsl.commands.lsp import lsp; "
    "sys.exit(lsp(['--stdio'], standalone_mode=False))"
)


class Editor:
    """A language client with one server."""

    def __init__(self, encodings: list[str] | None = None):
        self.process = subprocess.Popen(
            [sys.executable, "-W", "error", "-c", COMMAND],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**os.environ, "PYTHONFAULTHANDLER": "1"},
        )
        self.messages: Queue[dict[str, Any]] = Queue()
        self.published: dict[str, list[dict[str, Any]]] = {}
        self.shown: list[str] = []
        self.count = 0
        self.listener = Thread(target=self.listen, daemon=True)
        self.listener.start()
        capabilities = {"general": {"positionEncodings": encodings}} if encodings else {}
        self.answer = self.ask(
            "initialize", {"processId": None, "rootUri": None, "capabilities": capabilities}
        )
        self.tell("initialized", {})

    def listen(self) -> None:
        stream = self.process.stdout
        assert stream is not None
        while True:
            length = 0
            while line := stream.readline().strip():
                name, _, value = line.partition(b":")
                if name.lower() == b"content-length":
                    length = int(value)
            if not length:
                return
            self.messages.put(json.loads(stream.read(length)))

    def send(self, message: dict[str, Any]) -> None:
        data = json.dumps({"jsonrpc": "2.0", **message}).encode()
        stream = self.process.stdin
        assert stream is not None
        stream.write(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))
        stream.flush()

    def tell(self, method: str, params: Any) -> None:
        self.send({"method": method, "params": params})

    def ask(self, method: str, params: Any) -> Any:
        self.count += 1
        self.send({"id": self.count, "method": method, "params": params})
        while True:
            message = self.receive()
            if message.get("id") == self.count:
                assert "error" not in message, message
                return message.get("result")

    def receive(self) -> dict[str, Any]:
        try:
            message = self.messages.get(timeout=PATIENCE)
        except Empty:
            raise AssertionError(self.close()) from None
        if message.get("method") == "textDocument/publishDiagnostics":
            params = message["params"]
            self.published[params["uri"]] = params["diagnostics"]
        elif "method" in message:
            self.shown.append(str(message))
        return message

    def open(self, uri: str, text: str) -> None:
        document = {"uri": uri, "languageId": "story", "version": 1, "text": text}
        self.tell("textDocument/didOpen", {"textDocument": document})

    def change(self, uri: str, text: str, version: int = 2) -> None:
        change = {"textDocument": {"uri": uri, "version": version}}
        self.tell("textDocument/didChange", {**change, "contentChanges": [{"text": text}]})

    def diagnostics(self, uri: str) -> list[dict[str, Any]]:
        """The next diagnostics of a document."""
        self.published.pop(uri, None)
        while uri not in self.published:
            self.receive()
        return self.published[uri]

    def at(self, method: str, uri: str, line: int, character: int) -> Any:
        place = {"line": line, "character": character}
        return self.ask(f"textDocument/{method}", {"textDocument": {"uri": uri}, "position": place})

    def labels(self, uri: str, line: int, character: int) -> list[str]:
        return [i["label"] for i in self.at("completion", uri, line, character)["items"]]

    def stop(self) -> int:
        self.ask("shutdown", None)
        self.tell("exit", None)
        try:
            status = self.process.wait(PATIENCE)
        finally:
            errors = self.close()
        assert "Traceback" not in errors, errors
        assert not self.shown, self.shown
        return status

    def close(self) -> str:
        """Ends the server, if it has not ended; what it said on standard error."""
        if self.process.poll() is None:
            self.process.kill()
        self.listener.join(5)
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        assert self.process.stderr is not None
        with suppress(OSError):
            self.process.stdin.close()
        errors = self.process.stderr.read().decode()
        self.process.stdout.close()
        self.process.stderr.close()
        return errors


@pytest.fixture(scope="module")
def editor() -> Iterator[Editor]:
    client = Editor()
    yield client
    assert client.stop() == 0


@pytest.fixture
def uri(tmp_path: Path) -> str:
    return (tmp_path / "tale.story").as_uri()


def test_it_says_what_it_can_do(editor: Editor) -> None:
    can = editor.answer["capabilities"]
    assert can["textDocumentSync"]["change"] == 1
    assert can["positionEncoding"] == "utf-16"
    for what in ("hover", "definition", "documentFormatting", "documentSymbol"):
        assert can[f"{what}Provider"]
    assert "=" in can["completionProvider"]["triggerCharacters"]


def test_a_mistake_is_shown_and_gone_when_repaired(editor: Editor, uri: str) -> None:
    editor.open(uri, STORY.replace("rho > 0", "rhoo > 0  # 🤖"))
    (found,) = editor.diagnostics(uri)
    assert found["code"] == "unknown-name"
    assert found["severity"] == 1
    assert found["source"] == "i2p"
    assert found["message"] == "unknown name `rhoo`\nhint: did you mean `rho`?"
    assert found["range"] == {
        "start": {"line": 4, "character": 11},
        "end": {"line": 4, "character": 15},
    }
    editor.change(uri, STORY)
    assert editor.diagnostics(uri) == []


def test_columns_count_units_of_utf_16(editor: Editor, uri: str) -> None:
    text = 'world kitchen\nlength 3\nmaximize P("🤖ρ" | script[:3]) + P(rhoo > 0 | script[:3])\n'
    editor.open(uri, text)
    places = [d["range"]["start"]["character"] for d in editor.diagnostics(uri)]
    line = text.splitlines()[2]
    units = len(line[: line.index("rhoo")].encode("utf-16-le")) // 2
    assert units == line.index("rhoo") + 1
    assert units in places
    hover = editor.at("hover", uri, 2, len(line[: line.rindex("script")].encode("utf-16-le")) // 2)
    assert hover["range"]["start"]["character"] == line.rindex("script") + 1


@pytest.mark.parametrize("encoding", ["utf-8", "utf-32"])
def test_an_editor_may_count_otherwise(encoding: str, uri: str) -> None:
    client = Editor([encoding])
    assert client.answer["capabilities"]["positionEncoding"] == encoding
    client.open(uri, "world kitchen\nlength 3\nmaximize depict(🤖)\n")
    (found,) = client.diagnostics(uri)
    start = found["range"]["start"]["character"]
    assert found["range"]["end"]["character"] - start == {"utf-8": 4, "utf-32": 1}[encoding]
    assert client.stop() == 0


def test_completion_knows_the_world(editor: Editor, uri: str) -> None:
    text = STORY + "maximize P(G_cheese = "
    editor.open(uri, text)
    assert editor.labels(uri, 6, 22) == ["pink", "green"]
    editor.change(uri, STORY + "maximize P(G_ch")
    (item,) = editor.at("completion", uri, 6, 15)["items"]
    assert item["label"] == "G_cheese"
    assert item["detail"] == "G_cheese in {pink, green}"
    assert item["textEdit"] == {
        "newText": "G_cheese",
        "range": {"start": {"line": 6, "character": 11}, "end": {"line": 6, "character": 15}},
    }


def test_completion_sorts_as_the_language_does(editor: Editor, uri: str) -> None:
    editor.open(uri, STORY + "maximize P(")
    items = editor.at("completion", uri, 6, 11)["items"]
    keys = [item["sortText"] for item in items]
    assert keys == sorted(keys)
    assert items[0]["label"] == "rho"
    assert not {"(", ")"} & {item["label"] for item in items}


def test_hover_tells_type_and_documentation(editor: Editor, uri: str) -> None:
    editor.open(uri, STORY)
    rho = editor.at("hover", uri, 4, 12)["contents"]["value"]
    assert "rho in {-3, -1, 0, 1, 3}" in rho
    assert "attitude toward cheese" in rho
    kind = editor.at("hover", uri, 5, 17)["contents"]["value"]
    assert "kind = rho > 0" in kind
    assert "*event*" in kind
    depict = editor.at("hover", uri, 5, 10)["contents"]["value"]
    assert "depict(event, over = script)" in depict
    assert "*number*" in depict
    assert editor.at("hover", uri, 0, 5) is None


def test_definitions_are_found_here_and_in_the_library(editor: Editor, uri: str) -> None:
    editor.open(uri, STORY)
    here = editor.at("definition", uri, 5, 17)
    assert here["uri"] == uri
    assert here["range"]["start"] == {"line": 4, "character": 4}
    library = editor.at("definition", uri, 5, 10)
    path = ROOT / "stories" / "patterns" / "depict.story"
    assert library["uri"] == path.resolve().as_uri()
    line = path.read_text(encoding="utf-8").splitlines()[library["range"]["start"]["line"]]
    assert line.startswith("pattern depict(")


def test_formatting(editor: Editor, uri: str) -> None:
    editor.open(uri, "world   kitchen\nlength 3\nmaximize depict( rho>0 )")
    (edit,) = editor.ask(
        "textDocument/formatting",
        {"textDocument": {"uri": uri}, "options": {"tabSize": 4, "insertSpaces": True}},
    )
    assert edit["newText"] == "world kitchen\nlength 3\nmaximize depict(rho > 0)\n"
    assert edit["range"]["start"] == {"line": 0, "character": 0}
    assert edit["range"]["end"] == {"line": 2, "character": 24}
    editor.change(uri, "world kitchen\nlength (\n")
    options = {"textDocument": {"uri": uri}, "options": {"tabSize": 4, "insertSpaces": True}}
    assert editor.ask("textDocument/formatting", options) is None


def test_signatures_and_symbols(editor: Editor, uri: str) -> None:
    editor.open(uri, STORY + "maximize arc(robot, ")
    found = editor.at("signatureHelp", uri, 6, 20)
    (signature,) = found["signatures"]
    assert signature["label"].startswith("arc(who, shape")
    assert found["activeParameter"] == 1
    names = editor.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri}})
    assert [s["name"] for s in names] == ["world kitchen", "kind", "maximize depict(kind)"]


def test_worlds_are_checked_too(editor: Editor, tmp_path: Path) -> None:
    uri = (tmp_path / "larder.world").as_uri()
    text = (ROOT / "stories" / "worlds" / "kitchen.world").read_text(encoding="utf-8")
    editor.open(uri, text)
    assert editor.diagnostics(uri) == []
    editor.change(uri, text.replace("success = 0.6", "sucess = 0.6"))
    (found,) = editor.diagnostics(uri)
    assert found["code"] == "world-key"
    assert "did you mean `success`" in found["message"]
    names = editor.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri}})
    assert "character robot" in [s["name"] for s in names]
    assert editor.at("completion", uri, 0, 0)["items"] == []
    assert editor.at("hover", uri, 0, 3) is None


def test_a_mistake_in_a_library_is_shown_at_its_import(editor: Editor, tmp_path: Path) -> None:
    library = tmp_path / "mine.story"
    library.write_text("pattern a(x) = sum_t P(x | script[:t)\n", encoding="utf-8")
    uri = (tmp_path / "tale.story").as_uri()
    text = "world kitchen\nlength 3\nimport mine\nmaximize a(rho > 0)\n"
    editor.open(uri, text)
    (found,) = editor.diagnostics(uri)
    assert found["range"]["start"] == {"line": 2, "character": 7}
    places = [r["location"]["uri"] for r in found["relatedInformation"]]
    assert library.resolve().as_uri() in places
    # The library is repaired and saved: the story that imports it is checked again.
    library.write_text("pattern a(x) = sum_t P(x | script[:t])\n", encoding="utf-8")
    editor.tell("textDocument/didSave", {"textDocument": {"uri": library.as_uri()}})
    assert editor.diagnostics(uri) == []
    where = editor.at("definition", uri, 3, 9)
    assert where["uri"] == library.resolve().as_uri()
    assert editor.at("definition", uri, 2, 8)["uri"] == library.resolve().as_uri()


def test_notes_become_related_information(editor: Editor, uri: str) -> None:
    editor.open(uri, "world kitchen\nworld maze\nlength 3\nmaximize depict(rho > 0)\n")
    (found,) = editor.diagnostics(uri)
    (note,) = found["relatedInformation"]
    assert note["message"] == "the first one"
    assert note["location"]["uri"] == uri
    assert note["location"]["range"]["start"] == {"line": 0, "character": 0}


def test_a_buffer_that_was_never_saved(editor: Editor) -> None:
    uri = "untitled:Untitled-1"
    editor.open(uri, STORY)
    assert editor.diagnostics(uri) == []
    assert editor.at("definition", uri, 5, 17)["uri"] == uri
    editor.tell("textDocument/didClose", {"textDocument": {"uri": uri}})
    assert editor.diagnostics(uri) == []


def test_only_the_last_of_many_changes_is_checked(editor: Editor, uri: str) -> None:
    editor.open(uri, STORY)
    assert editor.diagnostics(uri) == []
    for version in range(2, 30):
        editor.change(uri, STORY + "maximize rubbish" * (version < 29), version)
    assert editor.diagnostics(uri) == []


LONG = "".join(f"let a{i} = P(rho > 0 | script[:T]) + arc(robot)\n" for i in range(2000))


def test_a_long_text_is_read_beside_the_answers(editor: Editor, uri: str) -> None:
    """Its mistakes take a while; meanwhile the world is known, and then its names are too."""
    text = f"world kitchen\nlength 15\n{LONG}maximize depict(G_ch"
    line, end = text.count("\n"), 20
    editor.published.pop(uri, None)
    editor.open(uri, text)
    assert "G_cheese" in editor.labels(uri, line, end)
    assert "attitude" in str(editor.at("hover", uri, 100, 15))
    there = editor.at("definition", uri, 1600, 5)
    assert there["range"]["start"]["line"] == 1600
    names = editor.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri}})
    assert uri not in editor.published
    assert len(names) == 500
    assert names[-1]["name"] == "... 1,502 more"
    assert editor.diagnostics(uri)
    editor.change(uri, text.replace("depict(G_ch", "a1711     "))
    assert "a1711" in editor.labels(uri, line, 14)
    editor.tell("textDocument/didClose", {"textDocument": {"uri": uri}})
    editor.diagnostics(uri)


TOKENS = [*'()[]{}|,:;@!.=<>+-*/^"#\n\t ', "rho", "P(", "script[:t]", "🤖", "ρ", "sum_t ", "\r\n"]
EDITS = st.lists(
    st.tuples(
        st.integers(0, 400),
        st.integers(0, 30),
        st.lists(st.sampled_from(TOKENS), max_size=6).map("".join),
    ),
    min_size=1,
    max_size=4,
)


@given(EDITS, st.integers(0, 8), st.integers(0, 40))
@settings(
    max_examples=examples(40),
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_random_edits_do_no_harm(
    editor: Editor, edits: list[tuple[int, int, str]], line: int, character: int
) -> None:
    uri = "untitled:random.story"
    text = STORY
    editor.open(uri, text)
    for version, (at, removed, added) in enumerate(edits, 2):
        at = min(at, len(text))
        text = text[:at] + added + text[at + removed :]
        editor.change(uri, text, version)
        for method in ("completion", "hover", "definition", "signatureHelp"):
            editor.at(method, uri, line, character)
    editor.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri}})
    editor.tell("textDocument/didClose", {"textDocument": {"uri": uri}})
    assert editor.process.poll() is None
