"""What is said of a library's patterns and lets: all of it follows from their sources."""

from __future__ import annotations

from typing import Any

from i2pdsl.errors import StoryError, error
from i2pdsl.language import ast
from i2pdsl.language.builtins import FUNCTIONS
from i2pdsl.language.kinds import Inference, parameter_kinds, result_kind, used_names
from i2pdsl.language.scope import Definition
from i2pdsl.library.modules import Modules

Record = dict[str, Any]
INFERRED = ("parameters", "result", "uses", "names_of_worlds")
"""What another version of i2pdsl may see otherwise; the rest is the text itself."""


def describe(modules: Modules) -> tuple[list[Record], list[Record]]:
    """The records of all patterns and of all lets (library/document.py), each in the order of the
    files and of what stands in them; without the worlds and examples.

    Raises StoryError where definitions go in a circle.
    """
    needs = _Needs(modules)
    inference = Inference()
    patterns: list[Record] = []
    lets: list[Record] = []
    for file, program in modules.programs.items():
        module = modules.modules[file]
        for item in program.statements:
            if not isinstance(item, ast.Let | ast.Pattern):
                continue
            body = item.body if isinstance(item, ast.Pattern) else item.value
            record: Record = {
                "name": item.name.id,
                "file": file,
                "line": item.span.source.position(item.span.start)[0],
            }
            if isinstance(item, ast.Pattern):
                kinds = parameter_kinds(item, module, inference)
                record["signature"] = item.signature
                record["parameters"] = [
                    {
                        "name": p.name.id,
                        "kind": kinds[p.name.id],
                        "default": None if p.default is None else _one_line(p.default.span.text),
                    }
                    for p in item.parameters
                ]
            record["result"] = result_kind(item, module, inference)
            if isinstance(item, ast.Pattern):
                record["documentation"] = item.documentation
            record["body"] = body.span.text
            record["uses"] = needs.uses(Definition(item, module))
            record["names_of_worlds"] = sorted(needs.of(Definition(item, module)))
            (patterns if isinstance(item, ast.Pattern) else lets).append(record)
    return patterns, lets


class _Needs:
    """Which names of a world each definition needs, by way of others too; each is read once."""

    def __init__(self, modules: Modules):
        self.modules = modules
        self.names: dict[int, dict[str, Definition | None]] = {}
        self.found: dict[int, frozenset[str]] = {}

    def direct(self, definition: Definition) -> dict[str, Definition | None]:
        """The names in a definition and what they stand for; None for those of a world."""
        key = id(definition.item)
        if key not in self.names:
            used = sorted(used_names(definition.item, definition.module))
            found = {name: definition.module.find(name) for name in used}
            self.names[key] = {
                name: inner
                for name, inner in found.items()
                if inner is not None or (name not in FUNCTIONS and name != "pi")
            }
        return self.names[key]

    def uses(self, definition: Definition) -> dict[str, str]:
        named = self.direct(definition).items()
        return {name: self.modules.file_of(d) for name, d in named if d is not None}

    def of(self, definition: Definition) -> frozenset[str]:
        """Without recursion: chains of definitions are as long as a library."""
        waiting, open_ = [definition], set[int]()
        while waiting:
            current = waiting[-1]
            key = id(current.item)
            inner = [d for d in self.direct(current).values() if d is not None]
            missing = [d for d in inner if id(d.item) not in self.found]
            if key in self.found or not missing:
                if key not in self.found:
                    own = {name for name, d in self.direct(current).items() if d is None}
                    parts = (self.found[id(d.item)] for d in inner)
                    self.found[key] = frozenset(own).union(*parts)
                waiting.pop()
                continue
            if any(id(d.item) in open_ or d.item is current.item for d in missing):
                raise _circle(current)
            open_.add(key)
            waiting.append(missing[0])
        return self.found[id(definition.item)]


def _circle(definition: Definition) -> StoryError:
    name = definition.item.name
    return error("recursion", f"`{name.id}` is defined by itself", name.span)


def _one_line(text: str) -> str:
    return " ".join(text.split())
