"""What is known around a place in a text: the world's vocabulary and the names in scope."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from i2pdsl.errors import Diagnostic, Source, StoryError
from i2pdsl.language import ast
from i2pdsl.language.check import FindWorld
from i2pdsl.language.elaborate import Elaborator
from i2pdsl.language.imports import build_module
from i2pdsl.language.kinds import Inference
from i2pdsl.language.parse import parse_tolerantly
from i2pdsl.language.scope import Definition, Env, Module, standard_library
from i2pdsl.language.settings import Settings as SettingsReader
from i2pdsl.language.statements import room_for_nesting
from i2pdsl.language.story import USUAL, Audience
from i2pdsl.language.vocabulary import Vocabulary

_WORLD = re.compile(r'^world[ \t]+(?:"([^"\n]*)"|(\w+))', re.MULTILINE)
_DEEPEST = 12  # names that stand for names


@dataclass(frozen=True)
class Surroundings:
    """What is known around a place.

    Attributes:
        vocabulary: the world's words; None where no world is named, or none can be found.
        module: the names of the file: its lets and patterns, imports, the standard library.
        folder: where imports and .world files are looked for; None is the current folder.
        file: the file itself, which is no library of its own.
        length: T, as far as it is known.
        audiences: whose beliefs can be asked, without what is special about them.
    """

    vocabulary: Vocabulary | None
    module: Module
    folder: Path | None = None
    file: Path | None = None
    length: int = 10
    audiences: tuple[Audience, ...] = (USUAL,)

    @cached_property
    def believing(self) -> dict[int, bool]:
        """Whether definitions have beliefs in them, by their ids, as far as it is known."""
        return {}

    @cached_property
    def _inference(self) -> Inference:
        return Inference()

    def sort(self, definition: Definition) -> str:
        """What a let, or a call of a pattern, comes to.

        event, number, shape (a number over t), script (also its first frames, or one of them),
        predicate, latent, character, object, place, or any.
        """
        return _sort(definition, self._inference, self.vocabulary)

    def definitions(self) -> Iterator[Definition]:
        """All lets and patterns that mean something, the file's own first."""
        yield from self.module.names.values()
        standard = standard_library().names
        yield from (d for name, d in standard.items() if name not in self.module.names)


def at_a_glance(source: Source, folder: Path | None, find_world: FindWorld) -> Surroundings:
    """The world of a text that takes long to be read."""
    module = Module(source)
    vocabulary = _vocabulary(ast.Program(source, ()), module, folder, find_world)
    return Surroundings(vocabulary, module, folder, Path(source.name))


def surroundings(source: Source, folder: Path | None, find_world: FindWorld) -> Surroundings:
    """What can be known from the statements of a text that can be read. Never raises."""
    file = Path(source.name)
    try:
        with room_for_nesting():
            program, _ = parse_tolerantly(source)
            module = build_module(program, _ignore, folder)
    except StoryError:  # not a text, or far too long
        return Surroundings(None, Module(source), folder, file)
    length = 10
    for statement in program.of(ast.LengthIs):
        node = statement.most or statement.frames
        if isinstance(node, ast.Number) and 1 <= node.value <= 100_000:
            length = int(node.value)
    vocabulary = _vocabulary(program, module, folder, find_world)
    named = {
        s.called.id: Audience(s.called.id, USUAL.observers, span=s.span)
        for s in program.of(ast.Audience)
        if s.called is not None
    }
    audiences = (USUAL, *(a for a in named.values() if a.name != USUAL.name))
    placed = tuple(replace(a, first=number) for number, a in enumerate(audiences))
    return Surroundings(vocabulary, module, folder, file, length, placed)


def _ignore(_: Diagnostic) -> None:
    pass


def _vocabulary(
    program: ast.Program, module: Module, folder: Path | None, find_world: FindWorld
) -> Vocabulary | None:
    """The words of the world, also where its statement is not finished."""
    statement: ast.World | None = next(iter(program.of(ast.World)), None)
    if statement is not None:
        target = statement.name
        name = target.id if isinstance(target, ast.Name) else target.value
    else:
        found = _WORLD.search(program.source.text)
        if found is None:
            return None
        name = found.group(1) or found.group(2) or ""
    try:
        vocabulary = find_world(name, folder)
        if vocabulary is None or statement is None or not statement.settings:
            return vocabulary
        elaborator = Elaborator(vocabulary, 10, _ignore)
        with room_for_nesting():
            reader = SettingsReader(elaborator, Env(module))
            settings = reader.read(statement.settings, vocabulary.settings, "world")
        if any(vocabulary.settings[key].reshapes for key, _ in settings):
            vocabulary = find_world(name, folder, settings) or vocabulary
    except (StoryError, OSError, ValueError):  # a world with mistakes, or a name that no file has
        return None
    return vocabulary


# What names stand for.

_SORTS = {
    "frame": "number",
    "first frames": "script",
    "one frame": "script",
}


def _sort(definition: Definition, inference: Inference, world: Vocabulary | None) -> str:
    with room_for_nesting():
        kind = inference.result(definition.item, definition.module, 0)
    if kind != "any":
        return _SORTS.get(kind, kind)
    node = definition.item.value if isinstance(definition.item, ast.Let) else definition.item.body
    for _ in range(_DEEPEST):
        found = definition.module.find(node.id) if isinstance(node, ast.Name) else None
        if found is None or not isinstance(found.item, ast.Let):
            break
        node = found.item.value
    name = node.id if isinstance(node, ast.Name) else ""
    return "number" if name == "pi" else _of_the_world(name, world)


def _of_the_world(name: str, world: Vocabulary | None) -> str:
    if world is None:
        return "any"
    if name in world.latents:
        return "event" if world.latents[name].kind == "truth" else "latent"
    sorts = {"character": world.characters, "object": world.things, "place": world.places}
    return next((sort for sort, words in sorts.items() if name in words), "any")
