"""Where a name comes from: the place of its let, pattern, parameter, library or world."""

from __future__ import annotations

import re
from hashlib import sha256
from itertools import permutations
from pathlib import Path

from lark import Token

from i2pdsl.editor.enclosure import enclosures
from i2pdsl.editor.hover import is_named, pattern_around, word_at
from i2pdsl.editor.reading import Reading, read_before
from i2pdsl.editor.surroundings import Surroundings
from i2pdsl.errors import Source, Span, StoryError
from i2pdsl.language import ast
from i2pdsl.language.imports import find_library
from i2pdsl.language.packed import SUFFIX
from i2pdsl.language.statements import read_source
from i2pdsl.resources import cache_folder, write_text
from i2pdsl.worlds.find import world_path
from i2pdsl.worlds.hypotheses import attitude_of, reading_of


def definition(text: str, offset: int, around: Surroundings, start: str = "file") -> Span | None:
    """Where the name at a place is defined; None for the words of the language.

    A place in the text itself has a source without a name.
    """
    piece = word_at(text, offset)
    if piece is None:
        return _quoted(text, offset, around)
    word = text[piece.start : piece.end]
    reading = read_before(text, piece.start, start)
    first = _keyword(reading)
    span = Span(Source("", text), piece.start, piece.end)
    if first == "import":
        return _library(ast.Name(span, word), around)
    if first == "world" and reading is not None and len(reading.tokens) == 1:
        return _world(word, around)
    parameter = _parameter(word, reading, is_named(text, piece.end), around)
    if parameter is not None:
        return parameter
    pattern = pattern_around(text, piece.start)
    for own in pattern.parameters if pattern is not None else ():
        if own.name.id == word:
            return own.name.span
    # The text may have changed since its names were read.
    begins = r"(?:let|pattern)[ \t]+({0})\b|audience[ \t]+({0})[ \t]*="
    own_name = re.compile(rf"^(?:{begins.format(re.escape(word))})", re.M).search(text)
    if own_name is not None:
        here = Source(around.module.source.name, text)
        group = own_name.lastindex or 1
        return Span(here, own_name.start(group), own_name.end(group))
    found = around.module.find(word)
    return found.item.name.span if found is not None else _in_world(word, around)


def _keyword(reading: Reading | None) -> str:
    return str(reading.tokens[0]) if reading is not None and reading.tokens else ""


def _parameter(
    word: str, reading: Reading | None, named: bool, around: Surroundings
) -> Span | None:
    """The parameter that `word = ...` in a call gives a value to."""
    if reading is None or not named:
        return None
    tokens: tuple[Token, ...] = reading.tokens
    inner = enclosures(tokens, False)[-1]
    found = around.module.find(inner.name) if inner.kind == "call" and not inner.part else None
    if found is None or not isinstance(found.item, ast.Pattern):
        return None
    spans = {p.name.id: p.name.span for p in found.item.parameters}
    return spans.get(word)


def _quoted(text: str, offset: int, around: Surroundings) -> Span | None:
    """The file that is named in quotes: `import "path"`, `world "my.world"`."""
    line_start = text.rfind("\n", 0, offset) + 1
    found = re.compile(r'(import|world)[ \t]+("([^"\n]*)")').match(text, line_start)
    if found is None or not found.start(2) <= offset <= found.end(2):
        return None
    if found.group(1) == "world":
        return _world(found.group(3), around)
    span = Span(Source("", text), found.start(2), found.end(2))
    return _library(ast.Text(span, found.group(3)), around)


def _library(target: ast.Name | ast.Text, around: Surroundings) -> Span | None:
    try:
        paths = find_library(target, around.folder)
    except StoryError:
        return None
    if not paths or paths[0].suffix == SUFFIX:
        return None
    return _beginning(paths[0])


def _world(name: str, around: Surroundings) -> Span | None:
    try:
        path = world_path(name, around.folder)
    except (OSError, ValueError):
        return None
    return _beginning(path) if path is not None else None


def _beginning(path: Path) -> Span | None:
    try:
        return Span(read_source(path.resolve()), 0, 0)
    except StoryError:
        return None


def _in_world(word: str, around: Surroundings) -> Span | None:
    """The block of a character, tile or object in the world's file; also for `G_robot` and, of
    whose mind it is, `rho_robot_cheese` or `B_robot_cheese`."""
    world = around.vocabulary
    if world is None:
        return None
    place = _world(world.world, around)
    if place is None:
        return None
    pairs = list(permutations(world.characters, 2))
    owners = {of(*pair): pair[0] for pair in pairs for of in (attitude_of, reading_of)}
    name = word[2:] if word[:2] in ("G_", "R_") and word in world.latents else word
    name = owners[word] if word in owners and word in world.latents else name
    block = re.compile(rf"^(?:tile|object|character|event)[ \t]+({re.escape(name)})\b", re.M)
    found = block.search(place.source.text)
    return Span(place.source, found.start(1), found.end(1)) if found is not None else None


def file_of(span: Span) -> Path | None:
    """A file in which an editor can show a definition.

    A pattern of a compiled library has its source inside the library: it is shown in a file of
    the cache that cannot be written to.
    """
    path = Path(span.source.name)
    try:
        if path.is_file() and path.suffix in (".story", ".world"):
            return path.resolve()
        if not span.source.text:
            return None
        digest = sha256(span.source.text.encode("utf-8", "replace")).hexdigest()[:16]
        folder = cache_folder("sources")
        shown = folder / f"{path.stem or 'library'}-{digest}.story"
        if not shown.exists():
            write_text(shown, span.source.text)
            shown.chmod(0o444)
        return shown
    except (OSError, ValueError):
        return None
