"""What there is to say about a library: computed from its sources when it is asked for."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from i2pdsl import __version__
from i2pdsl.errors import StoryError
from i2pdsl.language import ast
from i2pdsl.language.imports import Unpacked, modules_of_stories
from i2pdsl.language.kinds import Inference, parameter_kinds, result_kind
from i2pdsl.language.packed import Contents, StoredFile
from i2pdsl.language.scope import Definition, Module
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.library.fits import fit_all
from i2pdsl.worlds.find import builtin_worlds, find_vocabulary, vocabulary_of
from i2pdsl.worlds.kinds import parse_world

MADE_WITH = f"i2pdsl {__version__}"
Record = dict[str, Any]


@dataclass(frozen=True)
class PatternLibrary:
    """A library of patterns: read from a file, or just packed.

    Attributes:
        name: of its file, without the suffix.
    """

    name: str
    packed: Unpacked

    @property
    def contents(self) -> Contents:
        return self.packed.contents

    @property
    def exports(self) -> Module:
        """The names that an import gives."""
        return self.packed.exports

    @cached_property
    def definitions(self) -> dict[str, Definition]:
        """Its own patterns, by name in order."""
        own = {id(file.source) for file in self.contents.patterns}
        return {
            name: definition
            for name, definition in sorted(self.exports.names.items())
            if isinstance(definition.item, ast.Pattern) and id(definition.item.span.source) in own
        }

    @property
    def lets(self) -> list[str]:
        """The names of the lets that an import gives."""
        return [name for name, d in self.exports.names.items() if isinstance(d.item, ast.Let)]

    @cached_property
    def records(self) -> list[Record]:
        """Of each of its own patterns: `name`, `file`, `signature`, `parameters` (each with `name`,
        `kind`, `default`), `result`, `documentation`, `body` and `examples` (each with `file`,
        `world`, `call`)."""
        inference = Inference()
        return [self._record(d, inference) for d in self.definitions.values()]

    @cached_property
    def patterns(self) -> list[Record]:
        """The records with `worlds` (library/fits.py), which takes longest to find."""
        found = [dict(record) for record in self.records]
        fit_all(found, self.exports, self.vocabularies)
        return found

    def _record(self, definition: Definition, inference: Inference) -> Record:
        item, module = definition.item, definition.module
        assert isinstance(item, ast.Pattern)
        kinds = parameter_kinds(item, module, inference)
        name = item.name.id
        return {
            "name": name,
            "file": next(f.name for f in self.contents.patterns if f.source is item.span.source),
            "signature": item.signature,
            "parameters": [
                {
                    "name": p.name.id,
                    "kind": kinds[p.name.id],
                    "default": None if p.default is None else _one_line(p.default),
                }
                for p in item.parameters
            ],
            "result": result_kind(item, module, inference),
            "documentation": item.documentation,
            "body": item.body.span.text,
            "examples": [
                {"file": story["file"], "world": story["world"], "call": story["calls"][name]}
                for story in self.stories
                if name in story["calls"]
            ],
        }

    @cached_property
    def stories(self) -> list[Record]:
        """Of each story: `file`, `world` (its name), `source`, and `calls`, the first call of each
        of the library's own patterns in its objective, as it is written."""
        names = {file.name: name for name, file in self.worlds.items()}
        return [
            {
                "file": file.name,
                "world": names.get(file.world, file.world),
                "source": file.source.text,
                "calls": _calls(program, module, self.definitions),
            }
            for file, program, module in modules_of_stories(self.contents)
        ]

    @cached_property
    def worlds(self) -> dict[str, StoredFile]:
        """Its worlds by the names that stories can call them: those of their files, or the whole
        path where there is another world of the name."""
        found: dict[str, StoredFile] = {}
        for file in self.contents.worlds:
            stem = Path(file.name).stem
            taken = stem in builtin_worlds() or stem in found
            found[file.name if taken else stem] = file
        return found

    @cached_property
    def vocabularies(self) -> dict[str, Vocabulary]:
        """The words of the built-in worlds and of its own, by name; without those that cannot be
        read."""
        found = {name: find_vocabulary(name) for name in builtin_worlds()}
        for name, file in self.worlds.items():
            with suppress(StoryError):
                spec = parse_world(file.source, Path(file.name).stem)
                found[name] = vocabulary_of(spec)
        return {name: words for name, words in found.items() if words is not None}


def _calls(program: ast.Program, module: Module, own: dict[str, Definition]) -> dict[str, str]:
    """The first call of each of these patterns in a story's objective.

    A pattern is known by its text: stories of the standard library do not import it.
    """
    found: dict[str, str] = {}
    waiting: list[ast.Expr] = [o.value for o in reversed(program.of(ast.Objective))]
    seen: set[str] = set()
    while waiting:
        for node in sorted(ast.walk(waiting.pop()), key=lambda part: part.span.start):
            if not isinstance(node, ast.Name | ast.Call):
                continue
            name = node.id if isinstance(node, ast.Name) else node.callee.id
            definition = module.find(name)
            if definition is None:
                continue
            if isinstance(definition.item, ast.Let):
                if name not in seen and definition.module is module:
                    seen.add(name)
                    waiting.append(definition.item.value)
            elif name in own and own[name].item.span.text == definition.item.span.text:
                found.setdefault(name, _one_line(node))
    return dict(sorted(found.items()))


def _one_line(node: ast.Node) -> str:
    return " ".join(node.span.text.split())
