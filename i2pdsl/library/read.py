"""Reading compiled libraries: nothing that they say is believed that their sources do not say."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from i2pdsl.errors import Diagnostic, Source, StoryError
from i2pdsl.language import ast
from i2pdsl.language.scope import Module, standard_library
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.library.description import INFERRED, Record, describe
from i2pdsl.library.document import MADE_WITH, Document, read_document, wrong_library
from i2pdsl.library.modules import STANDARD, Modules, StoredFile, build_modules, import_target
from i2pdsl.worlds.find import builtin_worlds, find_vocabulary, vocabulary_of
from i2pdsl.worlds.grid.parse import parse_world


@dataclass(frozen=True)
class PatternLibrary:
    """A library of patterns that can be used: read from a file, or just packed.

    Attributes:
        document: what its file holds (library/document.py).
        modules: its names; `modules.exports` are those that an import gives.
    """

    document: Document
    modules: Modules

    @property
    def exports(self) -> Module:
        return self.modules.exports

    @property
    def patterns(self) -> list[Record]:
        """The records of its own patterns, by name."""
        own = {file["name"] for file in self.document["files"] if not file["group"]}
        found = [p for p in self.document["patterns"] if p["file"] in own]
        return sorted(found, key=lambda p: p["name"])

    def vocabulary(self, world: str) -> Vocabulary | None:
        """The words of a world of the library, or of a built-in one; None where it is none."""
        for stored in self.document["worlds"]:
            if stored["name"] == world:
                source = Source(stored["file"], stored["source"])
                with suppress(StoryError):
                    return vocabulary_of(parse_world(source, Path(stored["file"]).stem))
                return None
        return find_vocabulary(world) if world in builtin_worlds() else None


def read_library(path: Path) -> PatternLibrary:
    """Reads a compiled library. What was read is kept while the file stays as it is.

    Raises StoryError for a file that is missing, damaged, forged, of a later version, or too large.
    """
    try:
        state = path.stat()
    except (OSError, ValueError):
        read_document(path)  # says why it cannot be read
        raise
    return _read(path, state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=8)
def _read(path: Path, _modified: int, _size: int) -> PatternLibrary:
    document = read_document(path)
    try:
        return _held_against_sources(document, path)
    except RecursionError:
        raise wrong_library(path, "the library is damaged: nested too deep") from None


def _held_against_sources(document: Document, path: Path) -> PatternLibrary:
    """A library, if all that it says follows from its sources."""
    problems: list[Diagnostic] = []
    files = stored_files(document, str(path))
    try:
        modules = build_modules(str(path), files, problems.append)
        for file in files:
            targets = {import_target(s) for s in modules.programs[file.name].of(ast.Import)}
            if targets != set(file.imports):
                raise _forged(path, f"the imports of {file.name} are not those of its source")
        described = describe(modules) if not problems else ([], [])
    except StoryError as problem:
        problems.extend(problem.diagnostics)
        if problem.diagnostics[0].code == "library":
            raise
    if problems:
        line, column = problems[0].span.source.position(problems[0].span.start)
        name = problems[0].span.source.name.removeprefix(f"{path}/")
        reason = f"{name}:{line}:{column}: {problems[0].message}"
        raise wrong_library(path, f"the library is damaged: {reason}")
    same_version = document["made_with"] == MADE_WITH
    if not same_version:
        _check_standard(document, path)
    for kind, found in zip(("pattern", "let"), described, strict=True):
        _compare(kind, document[f"{kind}s"], found, same_version, path)
        records = zip(document[f"{kind}s"], found, strict=True)
        document = {**document, f"{kind}s": [{**said, **truth} for said, truth in records]}
    return PatternLibrary(document, modules)


def stored_files(document: Document, prefix: str) -> list[StoredFile]:
    """The files of a document; `prefix` stands before their names in messages."""
    return [
        StoredFile(
            f["name"], Source(f"{prefix}/{f['name']}", f["source"]), f["group"], f["imports"]
        )
        for f in document["files"]
    ]


def _compare(
    kind: str, stored: list[Record], found: list[Record], same_version: bool, path: Path
) -> None:
    """Raises StoryError where records are not what the sources say.

    What is inferred may be seen otherwise by another version of i2pdsl, and is not compared then.
    """
    names = [(r["file"], r["name"]) for r in stored]
    if names != [(r["file"], r["name"]) for r in found]:
        raise _forged(path, f"its {kind}s are not those of its sources")
    for record, truth in zip(stored, found, strict=True):
        for key, value in truth.items():
            said: Any = record[key]
            if key in INFERRED and not same_version:
                continue
            if said != value:
                raise _forged(path, f"`{key}` of `{record['name']}` is not what its source says")


def _check_standard(document: Document, path: Path) -> None:
    """The standard patterns that the library was made with are there."""
    known = standard_library().names
    for record in (*document["patterns"], *document["lets"]):
        for name, where in record["uses"].items():
            if where == STANDARD and name not in known:
                message = f"it uses the standard pattern `{name}`, which this version has not"
                raise wrong_library(path, f"made with {document['made_with']}: {message}")


def _forged(path: Path, message: str) -> StoryError:
    return wrong_library(path, f"the parts of the library disagree: {message}")
