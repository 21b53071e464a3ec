"""The language server: pygls on the outside, the other modules of this package inside.

Texts are sent whole at every change; they are checked a moment after the last one, and formatted,
by a thread of their own: requests about a large text are answered meanwhile. Needs the extra `lsp`.
"""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TypeVar

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer
from pygls.uris import to_fs_path

from i2pdsl.editor import answers
from i2pdsl.editor.documents import Document

T = TypeVar("T")
PAUSE = 0.08  # seconds after the last change before a text is checked
_TRIGGERS = [" ", "=", "(", "[", "{", "|", ",", ":", ";", "@"]


class StoryServer(LanguageServer):
    """The server and the documents that are open."""

    def __init__(self) -> None:
        super().__init__("i2p", _version(), lsp.TextDocumentSyncKind.Full)
        self.open: dict[str, Document] = {}
        self.checks: dict[str, asyncio.Task[None]] = {}
        self.worker = ThreadPoolExecutor(1, "i2p-check")

    def document(self, uri: str) -> Document:
        """The present version of a document."""
        buffer = self.workspace.get_text_document(uri)
        text, language = buffer.source, buffer.language_id or ""
        known = self.open.get(uri)
        if known is None or known.text != text:
            encoding = self.workspace.position_encoding or "utf-16"
            encoding = str(getattr(encoding, "value", encoding))
            path = to_fs_path(uri) if uri.startswith("file:") else None
            before = known.around if known is not None else None
            file = Path(path) if path else None
            known = self.open[uri] = Document(uri, text, file, encoding, language, before)
        return known

    def place(self, uri: str, position: lsp.Position) -> tuple[Document, int]:
        document = self.document(uri)
        return document, document.lines.offset(position.line, position.character)

    def check_soon(self, uri: str, pause: float = PAUSE) -> None:
        """Checks a document after a pause, unless it changes again before."""
        waiting = self.checks.pop(uri, None)
        if waiting is not None:
            waiting.cancel()
        self.checks[uri] = asyncio.ensure_future(self._check(uri, pause))

    async def _check(self, uri: str, pause: float) -> None:
        await asyncio.sleep(pause)
        document = self.document(uri)
        found = await self.aside(answers.diagnostics, document)
        if self.open.get(uri) is document:
            self.publish(uri, found)

    def aside(self, work: Callable[[Document], T], document: Document) -> asyncio.Future[T]:
        """Work that takes long for a large text, done one after the other in a thread."""
        return asyncio.get_running_loop().run_in_executor(self.worker, work, document)

    def publish(self, uri: str, found: Sequence[lsp.Diagnostic]) -> None:
        number = self.workspace.get_text_document(uri).version
        shown = lsp.PublishDiagnosticsParams(uri, list(found), number)
        self.text_document_publish_diagnostics(shown)

    def forget(self, uri: str) -> None:
        """A document was closed."""
        self.open.pop(uri, None)
        waiting = self.checks.pop(uri, None)
        if waiting is not None:
            waiting.cancel()
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))


def _version() -> str:
    try:
        return version("i2pdsl")
    except PackageNotFoundError:
        return "0"


def build_server() -> StoryServer:
    """A server with all that it can do."""
    server = StoryServer()

    @server.feature(lsp.INITIALIZED)
    def initialized(ls: StoryServer, _: lsp.InitializedParams) -> None:
        answers.warm_up()

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    async def opened(ls: StoryServer, params: lsp.DidOpenTextDocumentParams) -> None:
        ls.check_soon(params.text_document.uri, 0)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    async def changed(ls: StoryServer, params: lsp.DidChangeTextDocumentParams) -> None:
        ls.check_soon(params.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
    async def saved(ls: StoryServer, params: lsp.DidSaveTextDocumentParams) -> None:
        """Other files may import this one, or name this world."""
        for uri in list(ls.open):
            ls.open.pop(uri)
            ls.check_soon(uri, 0)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    async def closed(ls: StoryServer, params: lsp.DidCloseTextDocumentParams) -> None:
        ls.forget(params.text_document.uri)

    @server.feature(
        lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=_TRIGGERS)
    )
    def complete(ls: StoryServer, params: lsp.CompletionParams) -> lsp.CompletionList:
        return answers.completions(*ls.place(params.text_document.uri, params.position))

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    def hover(ls: StoryServer, params: lsp.HoverParams) -> lsp.Hover | None:
        return answers.hover_of(*ls.place(params.text_document.uri, params.position))

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    def definition(ls: StoryServer, params: lsp.DefinitionParams) -> lsp.Location | None:
        return answers.location_of(*ls.place(params.text_document.uri, params.position))

    @server.feature(
        lsp.TEXT_DOCUMENT_SIGNATURE_HELP, lsp.SignatureHelpOptions(trigger_characters=["(", ","])
    )
    def signature(ls: StoryServer, params: lsp.SignatureHelpParams) -> lsp.SignatureHelp | None:
        return answers.signature_of(*ls.place(params.text_document.uri, params.position))

    @server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    async def formatting(
        ls: StoryServer, params: lsp.DocumentFormattingParams
    ) -> list[lsp.TextEdit] | None:
        return await ls.aside(answers.edits, ls.document(params.text_document.uri))

    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def symbols(ls: StoryServer, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        return answers.symbols(ls.document(params.text_document.uri))

    return server


def serve() -> None:
    """Serves an editor over standard input and output until it says `exit`."""
    output = sys.stdout.buffer
    sys.stdout = sys.stderr  # nothing but the protocol goes to standard output
    build_server().start_io(sys.stdin.buffer, output)


if __name__ == "__main__":
    serve()
