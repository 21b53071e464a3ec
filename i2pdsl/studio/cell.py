"""The studio's stage, time line and curves in a cell of a notebook: `story.studio()`.

A widget of anywidget whose messages are those of the studio (docs/studio-protocol.md), answered in
this process: there is no server, no file and no language server.
"""

from __future__ import annotations

import asyncio
import json
import threading
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anywidget
import traitlets

from i2pdsl.render.film_page import part
from i2pdsl.render.modules import one_module
from i2pdsl.render.pictures import page_scripts
from i2pdsl.stories import Script, Story
from i2pdsl.studio.channel import Channel
from i2pdsl.studio.page import Page
from i2pdsl.studio.protocol import STALE, USAGE, Refusal
from i2pdsl.studio.studio import Studio

if TYPE_CHECKING:
    from collections.abc import Callable

CHANGED = "textDocument/didChange"


@cache
def module_of_widget(scripts: tuple[str, ...]) -> str:
    """The widget's module, with everything inside; `scripts` move its films (page_scripts)."""
    client = files("i2pdsl.studio") / "client"

    def read(path: str) -> str:
        render = path.startswith("/render/")
        name = path.removeprefix("/render/" if render else "/")
        found = part(name) if render else (client / name).read_text(encoding="utf-8")
        return found if found.endswith("\n") else f"{found}\n"

    # What draws each kind of film comes in as an import like all others.
    imports = "".join(
        f'import {{ makeStage as kind{number} }} from "/render/{script}";\n'
        for number, script in enumerate(scripts)
    )
    makers = ", ".join(f'"{script}": kind{number}' for number, script in enumerate(scripts))
    sheets = {
        name: "\n".join(read(path) for path in paths)
        for name, paths in {
            "page": ("/render/page/page.css",),
            "film": ("/film.css",),
            "desk": ("/studio.css", "/widget.css"),
        }.items()
    }
    given = f"{{ makers: {{ {makers} }}, ...{json.dumps(sheets)} }}"
    first = (
        f'import {{ makeWidget }} from "/widget.js";\n{imports}'
        f"export const widget = makeWidget({given});\n"
    )
    whole = one_module("/first.js", lambda path: first if path == "/first.js" else read(path))
    return f"{whole}export default widget;\n"


class _Talk(Channel):
    """A channel whose one document is the widget's text."""

    def __init__(self, studio: Studio, uri: str, send: Callable[[str], None]):
        super().__init__(studio.folder, send)
        self.uri = uri
        self.version, self.text = 0, ""

    def _pass_on(self, message: dict[str, Any]) -> None:
        """Of the language server's messages there is one: a newer text."""
        if message.get("method") == CHANGED:
            about = message["params"]
            self.version = about["textDocument"]["version"]
            self.text = about["contentChanges"][-1]["text"]

    def document(self, uri: str, version: int | None) -> tuple[str, str]:
        path = self.folder.path_of(uri)
        if uri != self.uri:
            raise Refusal(USAGE, f"{path} is not open")
        if version is not None and version != self.version:
            raise Refusal(STALE, f"version {version} is no longer the present one")
        return path, self.text

    def is_present(self, uri: str, version: int) -> bool:
        return (uri, version) == (self.uri, self.version)

    def close(self) -> None:
        for task in self._tasks:
            task.cancel()


@cache
def _loop() -> asyncio.AbstractEventLoop:
    """The loop in which messages of all widgets are heard, in a thread of its own: a kernel hears
    them now in one thread and now in another, whose loop may wait for something else."""
    loop = asyncio.new_event_loop()
    threading.Thread(target=loop.run_forever, name="i2p-cell", daemon=True).start()
    return loop


class StudioWidget(anywidget.AnyWidget):
    """A story on its stage, to be played, dragged, drawn and written.

    Attributes:
        text: the story's text, which is what hands make of it; another one may be put in its place.
    """

    _esm = traitlets.Unicode().tag(sync=True)
    text = traitlets.Unicode().tag(sync=True)
    uri = traitlets.Unicode().tag(sync=True)

    def __init__(self, story: Story):
        folder = Path.cwd() if story.folder is None else story.folder
        self._studio, self._folder = Studio(folder, None), folder
        self._page: Page | None = None
        text = story.typed.source.text
        uri = self._studio.folder.uri(f"{story.typed.name}.story")
        super().__init__(_esm=module_of_widget(page_scripts()), text=text, uri=uri)
        self.on_msg(self._received)

    def _received(self, _: Any, content: Any, buffers: Any) -> None:
        """A message of a view; in any thread."""
        if isinstance(content, dict) and isinstance(content.get("text"), str):
            _loop().call_soon_threadsafe(self._hear, content["text"])

    def _hear(self, text: str) -> None:
        if self._page is None:
            talk = _Talk(self._studio, self.uri, lambda text: self.send({"text": text}))
            self._page = Page(self._studio, talk)
        self._page.channel.received(text)

    @property
    def story(self) -> Story:
        """The story as it is written now. Raises StoryError."""
        return Story.from_text(self.text, self._folder)

    @property
    def script(self) -> Script | None:
        """The best script of the present text that was found so far."""
        return None if self._page is None else self._page.best(self.uri)

    def close(self) -> None:
        _loop().call_soon_threadsafe(self._leave)
        super().close()

    def _leave(self) -> None:
        if self._page is not None:
            self._studio.left(self._page)
            self._page = None
