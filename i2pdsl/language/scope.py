"""Names and what they stand for: lets, patterns, imports, and the arguments of a call."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

from i2pdsl.errors import (
    MOST_SHOWN,
    Diagnostic,
    Note,
    Source,
    Span,
    StoryError,
    closest,
    did_you_mean,
    error,
    shorten,
)
from i2pdsl.language import ast
from i2pdsl.language.builtins import RESERVED
from i2pdsl.language.naming import same_name, with_marks
from i2pdsl.language.parse import parse_file, parse_tolerantly
from i2pdsl.language.statements import read_source
from i2pdsl.resources import data_folder

_UNREAD_NAME = re.compile(with_marks(r"^(?:let|pattern)\s+(\w+)"), re.MULTILINE)
MOST_NOTES = 4  # uses of patterns within patterns that a message shows
LIBRARY_STATEMENTS = (ast.Let, ast.Pattern, ast.Import)
COMPILED = ".i2plib"


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


def build_module(
    program: ast.Program, report: Callable[[Diagnostic], None], folder: Path | None
) -> Module:
    """The names of a program, its imports included."""
    module = Module(program.source)
    _Importer(report).add_imports(module, program, folder)
    define(module, program, report)
    return module


class _Importer:
    """Reads libraries, each once. A folder is one library: its files know each other's names.

    `trail` holds the files that are being read and the imports that led to them.
    """

    def __init__(self, report: Callable[[Diagnostic], None]):
        self.report = report
        self.loaded: dict[Path, Module] = {}
        self.trail: list[tuple[Path, Span]] = []
        self.guesses = MOST_SHOWN  # what missing libraries may have been

    def tell(self, problem: Diagnostic) -> None:
        """Reports a mistake in a library together with the imports that led there."""
        notes = tuple(Note("imported here", span) for _, span in reversed(self.trail))
        self.report(replace(problem, notes=(*problem.notes, *notes)))

    def add_imports(self, module: Module, program: ast.Program, folder: Path | None) -> None:
        seen: set[ast.Name | ast.Text] = set()
        for statement in program.of(ast.Import):
            if statement.target in seen:
                continue
            seen.add(statement.target)
            try:
                libraries = self.library(statement, folder)
            except StoryError as problem:
                for diagnostic in problem.diagnostics:
                    self.tell(diagnostic)
                module.incomplete = True
                continue
            for library in libraries:
                module.names = {**library.names, **module.names}
                module.unread |= library.unread
                module.incomplete |= library.incomplete

    def library(self, statement: ast.Import, folder: Path | None) -> list[Module]:
        """The modules of an import: one, or those of a folder, which know each other's names."""
        here = statement.target.span
        self.guesses -= 1
        paths = [p.resolve() for p in find_library(statement.target, folder, self.guesses >= 0)]
        if len(paths) == 1 and paths[0].suffix == COMPILED:
            return [compiled_library(paths[0], here)]
        if any(path in paths for path, _ in self.trail):
            raise error("import", "the imports go in a circle", here, "remove this import")
        modules = []
        for path in paths:
            self.trail.append((path, here))
            try:
                modules.append(self.file(path))
            finally:
                self.trail.pop()
        for module in modules:
            for other in modules:
                module.names = {**other.names, **module.names}
                module.unread |= other.unread
        return modules

    def file(self, path: Path) -> Module:
        """A library's names, as far as it can be read."""
        if path in self.loaded:
            return self.loaded[path]
        program, problems = parse_tolerantly(read_source(path))
        for problem in problems:
            self.tell(problem)
        for statement in program.statements:
            if not isinstance(statement, LIBRARY_STATEMENTS):
                word = statement.span.text.split(None, 1)[0]
                message = f"a library has no `{word}`"
                hint = "a library holds only `let`, `pattern` and `import`"
                self.tell(Diagnostic("import", message, statement.span, hint))
        module = self.loaded[path] = Module(program.source)
        self.add_imports(module, program, path.parent)
        define(module, program, self.tell)
        return module


def compiled_library(path: Path, here: Span) -> Module:
    """The names of a compiled library; `here` is the import. Raises StoryError."""
    from i2pdsl.library.read import read_library  # which needs this module

    try:
        exports = read_library(path).exports
    except StoryError as problem:
        found = problem.diagnostics[0]
        message = f"`{path.name}` cannot be used: {found.message}"
        raise error("import", message, here, found.hint) from None
    return Module(exports.source, exports.names)


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


def find_library(
    target: ast.Name | ast.Text, folder: Path | None, guess: bool = True
) -> list[Path]:
    """The files of `import NAME` or `import "path"`: beside the importing file, else standard.

    Raises StoryError, with a `guess` what may have been meant.
    """
    here = folder or Path()
    patterns = data_folder("stories") / "patterns"
    if isinstance(target, ast.Text):
        shown = target.value
        candidates = [here / shown]
    else:
        shown = target.id
        names = (f"{shown}.story", shown, f"{shown}{COMPILED}")
        candidates = [place / name for place in (here, patterns) for name in names]
    for path in candidates:
        files = _library_files(path)
        if files:
            return files
    stems: set[str] = set()
    if guess:
        stems = {p.stem for place in (here, patterns) for p in _library_files(place)}
        stems |= {p.stem for p in here.glob(f"*{COMPILED}")}
    message = f"there is no library `{shorten(shown)}`"
    close = closest(shown, stems)
    hint = "a library is NAME.story, NAME.i2plib or a folder of stories, beside this file"
    if close:
        hint = f"did you mean `{close}`?"
    raise error("import", message, target.span, hint)


def _library_files(path: Path) -> list[Path]:
    """The file itself, or the stories in a folder; nothing where there is neither."""
    try:
        if path.is_dir():
            return sorted(path.glob("*.story"))
        return [path] if path.is_file() else []
    except (OSError, ValueError):  # a name that no file can have
        return []
