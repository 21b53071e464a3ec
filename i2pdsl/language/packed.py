"""The file of a compiled library, NAME.i2plib: a zip of sources, and a manifest of what they mean.

    manifest.json  {"format": "i2p-library", "version": 2, "made_with", "standard": [names],
                    "patterns": [FILE], "outside": [FILE], "stories": [FILE], "worlds": [FILE]}
    NAME ...       each file as it was written

with FILE = {"file": NAME, "sha256", "imports": {target: [names] or "standard"}, "world"}. Nothing
is compressed: the same sources give the same bytes on every machine, and no file is larger than it
says. Whatever is told of a pattern is computed from the sources. Anyone may have written such a
file: nothing in it is believed, and no name in it is ever a path.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import struct
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from i2pdsl.errors import Source, StoryError, error, shorten, whole_file
from i2pdsl.language.statements import read_data
from i2pdsl.resources import atomic_path
from i2pdsl.untrusted import WrongData, decode_json, is_plain_name, mismatch

FORMAT, VERSION = "i2p-library", 2
SUFFIX = ".i2plib"
MANIFEST = "manifest.json"
LARGEST = 4 * 2**20  # bytes of a library; the standard one has 50 kB
MOST_CHARACTERS = 200_000  # of patterns, which take seconds to parse; the standard ones have 20,000
MOST_STATEMENTS = 2000  # of patterns
MOST_FILES = 500  # of patterns, and that their imports mean in all
STANDARD = "standard"  # what an import of standard patterns means
MOST_IMPORTED = 20_000  # files that all imports of stories mean
_STATEMENT = re.compile(r"^[^\W\d]", re.MULTILINE)
_DEEPEST = 8  # brackets in brackets of a manifest, which has 5
_KINDS = ("patterns", "outside", "stories", "worlds")
# What zipfile raises for bytes that are no zip.
_NO_ZIP = (
    zipfile.BadZipFile, RuntimeError, ValueError, OSError, EOFError, OverflowError, struct.error,
)  # fmt: skip


Imports = dict[str, list[str] | str]
"""For each import of a file, as it is written: the files that it means, or STANDARD."""


@dataclass(frozen=True)
class StoredFile:
    """A file of a library.

    Attributes:
        name: its path inside the library.
        world: of a story: the name of a built-in world, or of a stored one's file.
    """

    name: str
    source: Source
    imports: Imports = field(default_factory=dict)
    world: str = ""


@dataclass(frozen=True)
class Contents:
    """What a library holds, each kind by name.

    Attributes:
        patterns: its own, which know each other's names.
        outside: files of patterns that were packed because others import them.
        made_with: the program that wrote it, for messages.
        standard: the names of the standard patterns that its patterns use.
    """

    patterns: tuple[StoredFile, ...]
    outside: tuple[StoredFile, ...]
    stories: tuple[StoredFile, ...]
    worlds: tuple[StoredFile, ...]
    made_with: str
    standard: tuple[str, ...] = ()


def encode(contents: Contents) -> bytes:
    """The bytes of the file: the same contents give the same."""
    manifest: dict[str, Any] = {"format": FORMAT, "version": VERSION}
    manifest |= {"made_with": contents.made_with, "standard": list(contents.standard)}
    members: dict[str, bytes] = {}
    for kind in _KINDS:
        manifest[kind] = []
        for file in getattr(contents, kind):
            data = members[file.name] = file.source.text.encode("utf-8")
            said = {"file": file.name, "sha256": hashlib.sha256(data).hexdigest()}
            manifest[kind].append({**said, "imports": file.imports, "world": file.world})
    text = json.dumps(manifest, ensure_ascii=False, indent=1) + "\n"
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, data in {MANIFEST: text.encode("utf-8"), **members}.items():
            info = zipfile.ZipInfo(name)  # of the first day of 1980
            info.create_system, info.external_attr = 3, 0o644 << 16  # else those of this system
            archive.writestr(info, data)
    return buffer.getvalue()


def write_contents(path: Path, contents: Contents) -> bytes:
    """Writes a library, whole or not at all; returns its bytes.

    Raises StoryError where it is larger than what is read, OSError where it cannot be written.
    """
    data = encode(contents)
    if len(data) > LARGEST:
        message = f"the library has {len(data):,} bytes; at most {LARGEST:,} are read"
        raise error("library", message, whole_file(str(path)), "split the folder")
    with atomic_path(path) as temporary:
        temporary.write_bytes(data)
    return data


def read_contents(path: Path) -> Contents:
    """Reads a library. Raises StoryError for a file that is missing, of another version, too large,
    damaged, or forged where that can be seen."""
    try:
        return _decode(read_data(path, LARGEST), path)
    except WrongData as problem:
        raise wrong_library(path, str(problem)) from None
    except StoryError as problem:
        if problem.diagnostics[0].code != "too-long":
            raise
        message = f"the library is too large: at most {LARGEST:,} bytes are read"
        raise wrong_library(path, message) from None


def wrong_library(path: Path, message: str) -> StoryError:
    """The error for a library that cannot be used."""
    later = "made by a later version" in message
    hint = "update i2pdsl" if later else f"compile it again: `i2p compile FOLDER -o {path.name}`"
    return error("library", message, whole_file(str(path)), hint)


def _decode(data: bytes, path: Path) -> Contents:
    """Raises WrongData."""
    if not data.strip():
        raise WrongData("the library is empty")
    if data.lstrip().startswith(b"{") and f'"{FORMAT}"'.encode() in data[:200]:
        made = "made by an earlier version of i2pdsl (format 1)"
        raise WrongData(f"{made}; this one reads format {VERSION}")
    if not data.startswith(b"PK"):
        raise WrongData("this is not a compiled library")
    members = _members(data)
    manifest = _manifest(members)
    names = [MANIFEST, *(record["file"] for kind in _KINDS for record in manifest[kind])]
    if len(set(names)) < len(names):
        raise _damaged("two of its files have one name")
    for name in sorted(members.keys() ^ names):
        raise _damaged(f"{shorten(name)} is either not in it or not in its manifest")
    kinds = (tuple(_file(r, members, path) for r in manifest[kind]) for kind in _KINDS)
    patterns, outside, stories, worlds = kinds
    said = manifest["made_with"], tuple(manifest["standard"])
    contents = Contents(patterns, outside, stories, worlds, *said)
    known = {file.name for file in (*patterns, *outside)}
    for file in (*patterns, *outside, *stories):
        for target, found in file.imports.items():
            if found != STANDARD and (isinstance(found, str) or not known.issuperset(found)):
                raise _damaged(f"the import `{shorten(target)}` leads to no file of it")
    excess = too_much(contents)
    if excess:
        raise WrongData(f"the library is too large: {excess}")
    return contents


def _members(data: bytes) -> dict[str, bytes]:
    """The files in a zip. All that a library has no need of is refused before it is read."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(data))
    except _NO_ZIP:
        raise _damaged("it is no whole zip (is its end missing?)") from None
    infos = {info.orig_filename: info for info in archive.infolist()}
    if len(infos) < len(archive.infolist()):
        raise _damaged("two of its files have one name")
    for name, info in infos.items():
        if info.compress_type != zipfile.ZIP_STORED or info.compress_size != info.file_size:
            raise _damaged(f"{shorten(name)} is compressed")
    if sum(info.file_size for info in infos.values()) > len(data):
        raise _damaged("its files overlap")
    found: dict[str, bytes] = {}
    for name, info in infos.items():
        try:
            found[name] = archive.read(info)
        except _NO_ZIP:  # also of what is encrypted
            raise _damaged(f"{shorten(name)} cannot be read") from None
    return found


def _manifest(members: dict[str, bytes]) -> dict[str, Any]:
    if MANIFEST not in members:
        raise WrongData(f"this is not a compiled library: it has no {MANIFEST}")
    manifest = decode_json(members[MANIFEST], "its manifest", _DEEPEST)
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise WrongData("this is not a compiled library")
    version = manifest.get("version")
    if type(version) is not int or version < VERSION:
        raise _damaged(f"its version is no number from {VERSION} on")
    if version > VERSION:
        made = f"made by a later version of i2pdsl (format {version})"
        raise WrongData(f"{made}; this one reads format {VERSION}")
    problem = mismatch(manifest, _SHAPE, "the manifest")
    if problem is not None:
        raise _damaged(problem)
    return manifest


def _file(record: dict[str, Any], members: dict[str, bytes], path: Path) -> StoredFile:
    name, data = record["file"], members[record["file"]]
    if hashlib.sha256(data).hexdigest() != record["sha256"]:
        raise _damaged(f"{name} does not have the hash that is stated")
    try:
        source = Source(f"{path}/{name}", data.decode("utf-8"))
    except UnicodeDecodeError:
        raise _damaged(f"{name} is not UTF-8") from None
    return StoredFile(name, source, record["imports"], record["world"])


def _damaged(message: str) -> WrongData:
    return WrongData(f"the library is damaged: {message}")


def too_much(contents: Contents) -> str | None:
    """What there is more of than is read, or None: what is read must be read soon."""
    files = (*contents.patterns, *contents.outside)
    counts = {
        "characters of patterns": (sum(len(f.source.text) for f in files), MOST_CHARACTERS),
        "patterns, lets and imports": (
            sum(len(_STATEMENT.findall(f.source.text)) for f in files), MOST_STATEMENTS,
        ),
        "files of patterns": (max(len(files), _meant(files)), MOST_FILES),
        "files that stories import": (_meant(contents.stories), MOST_IMPORTED),
    }  # fmt: skip
    for what, (count, most) in counts.items():
        if count > most:
            return f"{count:,} {what}, at most {most:,} are read"
    return None


def _meant(files: tuple[StoredFile, ...]) -> int:
    """How many files all imports mean."""
    return sum(len(f) for file in files for f in file.imports.values() if isinstance(f, list))


# The shape of the manifest (untrusted.mismatch).


def _path(value: Any) -> str | None:
    """Names of files inside the library: never one that leads out of it."""
    if not isinstance(value, str) or not 0 < len(value) <= 500:
        return "is no file's name"
    if not all(map(is_plain_name, value.split("/"))):
        return "leads out of the library or is no file's name"
    return None


def is_stored_name(name: str) -> bool:
    """Whether a file can have this name in a library."""
    return _path(name) is None


def _world(value: Any) -> str | None:
    return None if value == "" else _path(value)


def _name(value: Any) -> str | None:
    return None if isinstance(value, str) and value.isidentifier() else "is no name"


_FILE = {"file": _path, "sha256": str, "imports": {str: ([_path], str)}, "world": _world}
_SHAPE = {"format": str, "version": int, "made_with": str, "standard": [_name],
          **{kind: [_FILE] for kind in _KINDS}}  # fmt: skip
