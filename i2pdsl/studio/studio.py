"""A studio: a folder, the pages that show it, and the worker that they share.

Nothing here needs arrays before the first story is solved: the page is served at once.
"""

from __future__ import annotations

import asyncio
import secrets
import shutil
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from i2pdsl.render.files import FORMATS
from i2pdsl.studio.channel import Channel
from i2pdsl.studio.folder import Folder, Seen
from i2pdsl.studio.page import Page
from i2pdsl.studio.protocol import LARGEST_MESSAGE, PROTOCOL, Refusal
from i2pdsl.studio.solver import Solver

LOOK_AGAIN, SELDOM = 0.4, 20.0  # seconds between two looks at the folder, or times what one takes
MOST_MADE = 32  # folders of exported files that are kept until the studio is closed


class Studio:
    """What all pages share.

    Args:
        start: the file that is opened first.
    """

    def __init__(self, root: Path, start: str | None):
        self.folder, self.start = Folder(root), start
        self.solver = Solver()
        self.asker = ThreadPoolExecutor(1, "i2p-asker")
        self.drawer = ThreadPoolExecutor(1, "i2p-drawer")
        self.pages: set[Page] = set()
        self._made: dict[str, Path] = {}
        self._known: dict[str, Seen] = {}

    # Pages.

    def joined(self, send: Callable[[str], None]) -> Page:
        page = Page(self, Channel(self.folder, send))
        self.pages.add(page)
        return page

    def left(self, page: Page) -> None:
        self.pages.discard(page)
        self.solver.stop(lambda owner: owner[0] == id(page))
        page.close()

    def about(self) -> dict[str, Any]:
        try:
            program = version("i2pdsl")
        except PackageNotFoundError:
            program = "0"
        return {
            "protocol": PROTOCOL,
            "program": program,
            "folder": self.folder.root.name,
            "start": self.start,
            "formats": list(FORMATS),
            "largest": LARGEST_MESSAGE,
        }

    # The folder.

    def files(self) -> list[dict[str, Any]]:
        return [
            {
                "path": seen.path,
                "uri": self.folder.uri(seen.path),
                "kind": seen.kind,
                "size": seen.mark[1],
                "about": self.folder.about(seen),
            }
            for seen in self.folder.files()
        ]

    async def watch(self) -> None:
        """Tells pages what changes in the folder, whoever changed it."""
        self._known = {seen.path: seen for seen in await asyncio.to_thread(self.folder.files)}
        took = 0.0
        while True:
            await asyncio.sleep(max(LOOK_AGAIN, SELDOM * took))
            if not self.pages:
                continue
            began = time.monotonic()
            changes = await asyncio.to_thread(self._changes)
            took = time.monotonic() - began
            for change in changes:
                for page in self.pages:
                    page.channel.notify("changed", change)

    def _changes(self) -> list[dict[str, Any]]:
        """What is otherwise than at the last look."""
        now = {seen.path: seen for seen in self.folder.files()}
        changed = [seen for path, seen in now.items() if self._known.get(path) != seen]
        gone = [seen for path, seen in self._known.items() if path not in now]
        self._known = now
        told = []
        for seen in (*changed, *gone):
            with suppress(Refusal):  # by now it may be a link that leads out of the folder
                told.append(
                    {
                        "path": seen.path,
                        "uri": self.folder.uri(seen.path),
                        "kind": seen.kind,
                        "digest": None if seen in gone else self.folder.digest(seen.path),
                    }
                )
        return told

    # Files that were made to be fetched.

    def room_for_files(self) -> tuple[str, Path]:
        """A secret, and a folder whose files are served under it."""
        secret = secrets.token_urlsafe(18)
        self._made[secret] = Path(tempfile.mkdtemp(prefix="i2p-studio-"))
        while len(self._made) > MOST_MADE:
            oldest = next(iter(self._made))
            shutil.rmtree(self._made.pop(oldest), ignore_errors=True)
        return secret, self._made[secret]

    def made(self, secret: str, name: str) -> Path | None:
        folder = self._made.get(secret)
        if folder is None:
            return None
        return next((path for path in folder.iterdir() if path.name == name), None)

    def close(self) -> None:
        for folder in self._made.values():
            shutil.rmtree(folder, ignore_errors=True)
        self._made.clear()
