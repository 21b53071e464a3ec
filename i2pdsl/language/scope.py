"""Names and what they stand for: lets, patterns, imports, and the arguments of a call."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

from i2pdsl.errors import (
    MOST_SHOWN,
    Diagnostic,
    Note,
    Source,
    Span,
    StoryError,
    closest,
    did_you_mean,
)
from i2pdsl.language import ast
from i2pdsl.language.builtins import RESERVED
from i2pdsl.language.naming import same_name, with_marks
from i2pdsl.language.parse import parse_file
from i2pdsl.resources import data_folder

_UNREAD_NAME = re.compile(with_marks(r"^(?:let|pattern)\s+(\w+)"), re.MULTILINE)
MOST_NOTES = 4  # uses of patterns within patterns that a message shows
LIBRARY_STATEMENTS = (ast.Let, ast.Pattern, ast.Import)


@dataclass(frozen=True)
class Definition:
    """A `let` or a `pattern` and the module whose names its body uses."""

    item: ast.Let | ast.Pattern
    module: Module


@dataclass
class Module:
    """The names that a file defines and imports. Its own hide the standard library's."""

    source: Source
    names: dict[str, Definition] = field(default_factory=dict)
    unread: set[str] = field(default_factory=set)  # defined by statements that could not be read
    incomplete: bool = False  # an import failed: other names may be missing
    guesses: int = MOST_SHOWN  # misspelt names that may still be looked up: that takes time

    def find(self, name: str) -> Definition | None:
        found = self.names.get(name)
        if found is None:
            standard = standard_library()
            found = standard.names.get(name) if standard is not self else None
        return found

    def known(self) -> set[str]:
        """All names that mean something here."""
        return set(self.names) | set(standard_library().names)

    def is_lost(self, name: str, known: Callable[[], Iterable[str]]) -> bool:
        """Whether an unknown name follows from a mistake that was reported already."""
        if name in self.unread or not self.incomplete:
            return name in self.unread
        self.guesses -= 1
        return self.guesses < 0 or closest(name, known()) is None

    def meant(self, name: str, known: Callable[[], Iterable[str]]) -> str | None:
        """A hint what an unknown name may have meant, for as many as are shown."""
        self.guesses -= 1
        return did_you_mean(name, known()) if self.guesses >= 0 else None

    def known_patterns(self) -> set[str]:
        """The names that can be called."""
        return {
            name
            for names in (standard_library().names, self.names)
            for name, definition in names.items()
            if isinstance(definition.item, ast.Pattern)
        }


@dataclass(frozen=True)
class Bound:
    """An argument: put in as an expression, together with the names that it was written among."""

    expression: ast.Expr
    env: Env


@dataclass(frozen=True)
class Env:
    """What the names in an expression mean, and where the expression stands.

    Attributes:
        times: the values of t, or None where t means nothing.
        reached: those of them that reach this branch of an `if`; None for all.
        sum_span: the sum over t around the expression.
        after_sum: in a term that follows a sum: `sum_t a + b`.
        inside: 'event', 'quantity', 'condition', 'frame', 'start' or '' elsewhere.
        uses: the calls that led here, outermost first.
    """

    module: Module
    names: Mapping[str, Bound] = field(default_factory=dict)
    times: range | None = None
    reached: Sequence[int] | None = None
    sum_span: Span | None = None
    after_sum: bool = False
    inside: str = ""
    uses: tuple[tuple[str, Span], ...] = ()

    @property
    def ts(self) -> Sequence[int]:
        """The values of t at which the expression counts."""
        if self.reached is not None:
            return self.reached
        return self.times if self.times is not None else ()

    @property
    def is_dead(self) -> bool:
        """In a branch of an `if` that nothing reaches."""
        return self.reached is not None and not self.reached

    def notes(self) -> tuple[Note, ...]:
        """Where the pattern was used, for a mistake inside it."""
        notes = [Note(f"in `{name}`, used here", span) for name, span in reversed(self.uses)]
        if len(notes) > MOST_NOTES:
            skipped = len(notes) - MOST_NOTES
            last = Note(f"and after {skipped} more, {notes[-1].message}", notes[-1].span)
            notes = [*notes[: MOST_NOTES - 1], last]
        return tuple(notes)


@cache
def standard_library() -> Module:
    """The standard patterns: every file of stories/patterns/."""
    folder = data_folder("stories") / "patterns"
    module = Module(Source(str(folder), ""))
    for path in sorted(folder.glob("*.story")):
        define(module, parse_file(path), report=_raise)
    return module


def _raise(problem: Diagnostic) -> None:
    raise StoryError([problem])


def define(module: Module, program: ast.Program, report: Callable[[Diagnostic], None]) -> None:
    """Adds a program's own lets and patterns to a module."""
    unread = "\n".join(span.text for span in program.unread)
    module.unread.update(map(same_name, _UNREAD_NAME.findall(unread)))
    own: dict[str, Span] = {}
    for item in program.statements:
        if not isinstance(item, ast.Let | ast.Pattern):
            continue
        name = item.name
        if name.id in RESERVED or name.id == "pi":
            message = f"`{name.id}` is a word of the language and cannot be a name"
            report(Diagnostic("reserved", message, name.span, "choose another name"))
            continue
        if name.id in own:
            note = Note("the first one", own[name.id])
            message = f"`{name.id}` is defined twice"
            report(Diagnostic("duplicate", message, name.span, None, (note,)))
            continue
        own[name.id] = name.span
        if isinstance(item, ast.Pattern):
            _check_parameters(item, report)
        module.names[name.id] = Definition(item, module)


def _check_parameters(pattern: ast.Pattern, report: Callable[[Diagnostic], None]) -> None:
    seen: set[str] = set()
    default_seen = False
    for parameter in pattern.parameters:
        name = parameter.name
        if name.id in RESERVED or name.id == "pi":
            message = f"`{name.id}` is a word of the language and cannot be a name"
            report(Diagnostic("reserved", message, name.span, "choose another name"))
        elif name.id in seen:
            message = f"two parameters have the name `{name.id}`"
            report(Diagnostic("duplicate", message, name.span))
        elif default_seen and parameter.default is None:
            message = f"`{name.id}` needs a default, since the parameter before it has one"
            report(Diagnostic("arguments", message, name.span))
        default_seen = default_seen or parameter.default is not None
        seen.add(name.id)
