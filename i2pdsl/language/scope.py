"""Names and what they stand for: lets, patterns, imports, and the arguments of a call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from i2pdsl.errors import Diagnostic, Note, Source, Span, StoryError, did_you_mean, error
from i2pdsl.language import ast
from i2pdsl.language.parse import RESERVED, parse_file
from i2pdsl.resources import data_folder


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

    def find(self, name: str) -> Definition | None:
        found = self.names.get(name)
        if found is None:
            standard = standard_library()
            found = standard.names.get(name) if standard is not self else None
        return found

    def known(self) -> set[str]:
        return set(self.names) | set(standard_library().names)


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
        in_sum: inside a reduction over t.
        inside: 'event', 'quantity', 'condition', 'frame', 'start' or '' elsewhere.
        guarded: in the branch of an `if` that depends on t, where indices may leave the script.
        uses: the calls that led here, outermost first.
    """

    module: Module
    names: Mapping[str, Bound] = field(default_factory=dict)
    times: range | None = None
    in_sum: bool = False
    inside: str = ""
    guarded: bool = False
    uses: tuple[tuple[str, Span], ...] = ()

    def notes(self) -> tuple[Note, ...]:
        """Where the pattern was used, for a mistake inside it."""
        return tuple(Note(f"in `{name}`, used here", span) for name, span in reversed(self.uses))


@cache
def standard_library() -> Module:
    """The standard patterns: every file of stories/patterns/."""
    folder = data_folder("stories") / "patterns"
    module = Module(Source(str(folder), ""))
    for path in sorted(folder.glob("*.story")):
        define(module, parse_file(path), reporter=_raise)
    return module


def _raise(problem: Diagnostic) -> None:
    raise StoryError([problem])


def build_module(
    program: ast.Program, report: Callable[[Diagnostic], None], folder: Path | None
) -> Module:
    """The names of a program, its imports included."""
    return _build(program, report, folder, ())


def _build(
    program: ast.Program,
    report: Callable[[Diagnostic], None],
    folder: Path | None,
    importing: tuple[Path, ...],
) -> Module:
    module = Module(program.source)
    for statement in program.of(ast.Import):
        try:
            for path in find_library(statement.target, folder):
                if path.resolve() in importing:
                    raise error("import", "the imports go in a circle", statement.target.span)
                library = _build(
                    parse_file(path), report, path.parent, (*importing, path.resolve())
                )
                for name, definition in library.names.items():
                    module.names.setdefault(name, definition)
        except StoryError as problem:
            for diagnostic in problem.diagnostics:
                report(diagnostic)
    define(module, program, report)
    return module


def define(module: Module, program: ast.Program, reporter: Callable[[Diagnostic], None]) -> None:
    """Adds a program's own lets and patterns to a module."""
    own: dict[str, Span] = {}
    for item in program.statements:
        if not isinstance(item, ast.Let | ast.Pattern):
            continue
        name = item.name
        if name.id in RESERVED or name.id == "pi":
            message = f"`{name.id}` is a word of the language and cannot be a name"
            reporter(Diagnostic("reserved", message, name.span, "choose another name"))
            continue
        if name.id in own:
            note = Note("the first one", own[name.id])
            message = f"`{name.id}` is defined twice"
            reporter(Diagnostic("duplicate", message, name.span, None, (note,)))
            continue
        own[name.id] = name.span
        if isinstance(item, ast.Pattern):
            _check_parameters(item, reporter)
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


def find_library(target: ast.Name | ast.Text, folder: Path | None) -> list[Path]:
    """The files of `import NAME` or `import "path"`: beside the importing file, else standard."""
    here = folder or Path()
    if isinstance(target, ast.Text):
        candidates = [here / target.value]
        shown = target.value
    else:
        shown = target.id
        places = (here, data_folder("stories") / "patterns")
        candidates = [
            place / name
            for place in places
            for name in (f"{shown}.story", shown, f"{shown}.i2plib")
        ]
    for path in candidates:
        if path.is_dir():
            files = sorted(path.glob("*.story"))
            if files:
                return files
        elif path.is_file():
            if path.suffix == ".i2plib":
                message = "compiled libraries cannot be read by this version"
                raise error("import", message, target.span, "import the folder of its stories")
            return [path]
    beside = {p.stem for p in here.glob("*.story")} if here.is_dir() else set()
    standard = {p.stem for p in (data_folder("stories") / "patterns").glob("*.story")}
    hint = did_you_mean(shown, beside | standard)
    raise error("import", f"there is no library `{shown}`", target.span, hint)
