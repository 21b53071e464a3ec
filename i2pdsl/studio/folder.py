"""The folder that a studio is of: its files by paths like `kitchen/help.story`, and no others.

A path is plain names with `/` between them (untrusted.py), none of them hidden, and no link in it
leads out of the folder. Files are written whole, under a temporary name, and only where they still
are what they were when they were read: who comes too late is shown what is there.
"""

from __future__ import annotations

import hashlib
import os
import threading
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import count, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlsplit

from i2pdsl.errors import StoryError
from i2pdsl.language.statements import LARGEST_TEXT
from i2pdsl.resources import write_text
from i2pdsl.studio.protocol import CONFLICT, FILE, REFUSED, Refusal
from i2pdsl.untrusted import WrongData, below, is_plain_name, read_bytes

if TYPE_CHECKING:
    from i2pdsl.scripts import Script

TEXTS = {".story": "story", ".world": "world"}
FILES = {**TEXTS, ".json": "script", ".svg": "sprite", ".png": "sprite"}
MOST_FILES, MOST_ENTRIES, DEEPEST = 2000, 20_000, 8  # of a folder that is somebody's home
_HEAD = 2000  # bytes that tell what a file is


@dataclass(frozen=True)
class Seen:
    """A file of the folder.

    Attributes:
        kind: story, world, script or sprite.
        mark: what changes when the file does: its time, size and number on the disk.
    """

    path: str
    kind: str
    mark: tuple[int, int, int]


class Folder:
    """A folder; its methods may be called in any thread. They raise Refusal."""

    def __init__(self, root: Path):
        self.root = root.resolve()
        self._saving = threading.Lock()

    def place(self, path: str) -> Path:
        """Where a file of that path is, or would be."""
        names = path.split("/")
        hidden = next((name for name in names if name.startswith(".")), None)
        if hidden is not None or len(names) > DEEPEST or not all(map(is_plain_name, names)):
            raise Refusal(REFUSED, f"`{path[:80]}` is no path of a file in this folder")
        try:
            found = below(self.root, *names)
        except OSError as problem:
            raise Refusal(REFUSED, problem.strerror or str(problem)) from None
        if not found.resolve().is_relative_to(self.root):
            raise Refusal(REFUSED, f"a link leads out of the folder: {path}")
        return found

    def uri(self, path: str) -> str:
        return self.place(path).as_uri()

    def path_of(self, uri: str) -> str:
        """The path of a file: URI, which is that of a file of the folder."""
        parts = urlsplit(uri)
        found = Path(unquote(parts.path))
        if parts.scheme != "file" or parts.netloc or not found.is_relative_to(self.root):
            raise Refusal(REFUSED, f"no file of this folder: {uri[:200]}")
        path = found.relative_to(self.root).as_posix()
        self.place(path)
        return path

    # Reading.

    def files(self) -> list[Seen]:
        """What there is to show, without hidden files and folders, in order."""
        found = islice(self._seen(self.root, "", count()), MOST_FILES)
        return sorted(found, key=lambda each: each.path)

    def _seen(
        self, folder: Path, before: str, numbers: Iterator[int], depth: int = 1
    ) -> Iterator[Seen]:
        with suppress(OSError), os.scandir(folder) as entries:
            for entry in entries:
                if next(numbers) > MOST_ENTRIES:
                    return
                if entry.name.startswith(".") or not is_plain_name(entry.name):
                    continue
                with suppress(OSError):
                    if entry.is_dir(follow_symlinks=False):
                        if depth < DEEPEST:
                            inside = f"{before}{entry.name}/"
                            yield from self._seen(Path(entry.path), inside, numbers, depth + 1)
                        continue
                    kind = FILES.get(Path(entry.name).suffix.lower())
                    if kind is None or (entry.is_symlink() and not self._is_inside(entry.path)):
                        continue
                    if entry.is_file():
                        found = entry.stat()
                        mark = found.st_mtime_ns, found.st_size, found.st_ino
                        yield Seen(f"{before}{entry.name}", kind, mark)

    def _is_inside(self, path: str) -> bool:
        return Path(path).resolve().is_relative_to(self.root)

    def bytes_of(self, path: str, largest: int = LARGEST_TEXT) -> bytes:
        try:
            return read_bytes(self.place(path), largest)
        except OSError as problem:
            raise Refusal(FILE, f"{path}: {problem.strerror or problem}") from None

    def read(self, path: str) -> tuple[str, str]:
        """A text, and its digest."""
        data = self.bytes_of(path)
        try:
            return data.decode("utf-8-sig").replace("\r\n", "\n"), digest_of(data)
        except UnicodeDecodeError as problem:
            message = f"{path}: byte {problem.start:,} is not UTF-8"
            raise Refusal(FILE, message) from None

    def digest(self, path: str) -> str | None:
        """None where there is no such file."""
        try:
            return digest_of(read_bytes(self.place(path), LARGEST_TEXT))
        except OSError:
            return None

    def about(self, seen: Seen) -> str:
        """What the comment at the top of a text says, on one line."""
        if seen.kind not in TEXTS.values():
            return ""
        with suppress(OSError), open(self.root / seen.path, "rb") as file:
            lines = file.read(_HEAD).decode("utf-8", "replace").splitlines()
            told = []
            for line in lines:
                if not line.startswith("#"):
                    break
                told.append(line.lstrip("# ").rstrip())
            return " ".join(told)
        return ""

    # Writing.

    def save(self, path: str, text: str, digest: str | None) -> str:
        """Writes a text where the file still has a digest, or is not there (None); returns the
        new digest. A conflict has the other text and its digest."""
        if Path(path).suffix not in (*TEXTS, ".json"):
            raise Refusal(REFUSED, "only stories, worlds and scripts are written")
        data = text.encode("utf-8")
        if len(data) > LARGEST_TEXT:
            raise Refusal(REFUSED, f"it has {len(data):,} bytes; at most {LARGEST_TEXT:,} are kept")
        place = self.place(path)
        with self._saving:
            there = self.digest(path)
            if there == digest_of(data):
                return there
            if there != digest:
                raise self._conflict(path, there)
            try:
                write_text(place, text, new=digest is None)
            except FileExistsError:
                raise self._conflict(path, self.digest(path)) from None
            except OSError as problem:
                raise Refusal(FILE, f"{path}: {problem.strerror or problem}") from None
        return digest_of(data)

    def keep_script(self, path: str, script: Script) -> dict[str, Any]:
        """Writes a script under a name, or a free one like it; returns which, and its digest."""
        stem, suffix = path.removesuffix(".json"), ".json"
        if stem == path:
            raise Refusal(REFUSED, "a script is called NAME.json")
        with self._saving:
            names = (f"{stem}{'' if n == 1 else f'-{n}'}{suffix}" for n in range(1, 1000))
            free = next(name for name in names if not self.place(name).exists())
            try:
                script.save(self.place(free))
            except OSError as problem:
                raise Refusal(FILE, f"{free}: {problem.strerror or problem}") from None
        return {"path": free, "digest": self.digest(free)}

    def _conflict(self, path: str, digest: str | None) -> Refusal:
        text = None
        if digest is not None:
            with suppress(Refusal):
                text, digest = self.read(path)
        said = "is another by now" if digest is not None else "is no longer there"
        return Refusal(CONFLICT, f"{path} {said}", text=text, digest=digest)

    def put_picture(self, path: str, data: bytes) -> str:
        """Writes what is kept of a drawing (worlds/drawings.py); returns its digest. A new name is
        taken: a drawing that is there already is not replaced by another."""
        import base64

        from i2pdsl.resources import atomic_path
        from i2pdsl.worlds.drawings import LARGEST, OWN, kept_drawing

        place = self.place(path)
        suffix = place.suffix
        if suffix not in OWN:
            raise Refusal(REFUSED, "a picture is an .svg or a .png")
        if len(data) > LARGEST[suffix]:
            message = f"it has {len(data):,} bytes; at most {LARGEST[suffix]:,} are read"
            raise Refusal(REFUSED, message)
        try:
            kept = kept_drawing(place.name, data)
        except WrongData as problem:
            raise Refusal(REFUSED, str(problem)) from None
        clean = base64.b64decode(kept) if suffix == ".png" else kept.encode("utf-8")
        with self._saving:
            if self.digest(path) == digest_of(clean):
                return digest_of(clean)
            try:
                with atomic_path(place, new=True) as temporary:
                    temporary.write_bytes(clean)
            except FileExistsError:
                raise Refusal(CONFLICT, f"{path} is there already: take another name") from None
            except OSError as problem:
                raise Refusal(FILE, f"{path}: {problem.strerror or problem}") from None
        return digest_of(clean)


def digest_of(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:32]


def told(problem: StoryError) -> dict[str, object]:
    """The mistakes of a text as data of a Refusal."""
    return {"diagnostics": [each.as_json() for each in problem.diagnostics]}
