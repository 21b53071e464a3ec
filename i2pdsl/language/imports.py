"""What `import` brings into a file: names from other files, from folders, from compiled libraries.

What an import means is found on disk, or read off the manifest of the library that the importing
file lies in; all else is the same for both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from i2pdsl.errors import (
    MOST_SHOWN,
    Diagnostic,
    Note,
    Source,
    Span,
    StoryError,
    closest,
    error,
    shorten,
)
from i2pdsl.language import ast
from i2pdsl.language.packed import SUFFIX, Contents, StoredFile, read_contents, wrong_library
from i2pdsl.language.parse import parse, parse_tolerantly
from i2pdsl.language.scope import LIBRARY_STATEMENTS, Module, define, standard_library
from i2pdsl.language.statements import read_source, room_for_nesting
from i2pdsl.resources import data_folder

Report = Callable[[Diagnostic], None]
Place = Path | str
"""A file of patterns: on disk, or by its name in a compiled library."""
Finder = Callable[[ast.Import, bool], Sequence[Place]]
"""From an import to the files that it means. Raises StoryError, with what may have been meant if
that is asked for."""


def build_module(program: ast.Program, report: Report, folder: Path | None) -> Module:
    """The names of a program, its imports included."""
    return Importer(report, _open).module(program, _beside(folder))


def _open(place: Place) -> tuple[Source, Finder]:
    return read_source(place), _beside(Path(place).parent)


def _beside(folder: Path | None) -> Finder:
    def find(statement: ast.Import, guess: bool) -> list[Place]:
        return [path.resolve() for path in find_library(statement.target, folder, guess)]

    return find


class Importer:
    """Reads files of patterns, each once. A folder is one library: its files know each other's
    names.

    Attributes:
        open: gives the text of a file, and what its imports mean.
        loaded: what was read so far.
        trail: the files that are being read and the imports that led to them.
    """

    def __init__(self, report: Report, open_: Callable[[Place], tuple[Source, Finder]]):
        self.report = report
        self.open = open_
        self.loaded: dict[Place, Module] = {}
        self.trail: list[tuple[Place, Span | None]] = []
        self.guesses = MOST_SHOWN  # what missing libraries may have been

    def tell(self, problem: Diagnostic) -> None:
        """Reports a mistake in a library together with the imports that led there."""
        spans = (span for _, span in reversed(self.trail) if span is not None)
        notes = tuple(Note("imported here", span) for span in spans)
        self.report(replace(problem, notes=(*problem.notes, *notes)))

    def module(self, program: ast.Program, find: Finder) -> Module:
        """The names of a program that is no library."""
        module = Module(program.source)
        self.add_imports(module, program, find)
        define(module, program, self.report)
        return module

    def add_imports(self, module: Module, program: ast.Program, find: Finder) -> None:
        seen: set[ast.Name | ast.Text] = set()
        for statement in program.of(ast.Import):
            if statement.target in seen:
                continue
            seen.add(statement.target)
            try:
                libraries = self.library(statement, find)
            except StoryError as problem:
                for diagnostic in problem.diagnostics:
                    self.tell(diagnostic)
                module.incomplete = True
                continue
            for library in libraries:
                module.names = {**library.names, **module.names}
                module.unread |= library.unread
                module.incomplete |= library.incomplete

    def library(self, statement: ast.Import, find: Finder) -> list[Module]:
        """The modules of an import."""
        here = statement.target.span
        self.guesses -= 1
        places = find(statement, self.guesses >= 0)
        if len(places) == 1 and isinstance(places[0], Path) and places[0].suffix == SUFFIX:
            return [compiled_library(places[0], here)]
        if any(place in places for place, _ in self.trail):
            raise error("import", "the imports go in a circle", here, "remove this import")
        return self.files(places, here)

    def files(self, places: Sequence[Place], here: Span | None) -> list[Module]:
        """Files that know each other's names."""
        modules: list[Module] = []
        for place in places:
            self.trail.append((place, here))
            try:
                modules.append(self.file(place))
            finally:
                self.trail.pop()
        shared = joined(modules)
        for module in modules:
            module.names = {**shared.names, **module.names}
            module.unread |= shared.unread
        return modules

    def file(self, place: Place) -> Module:
        """A library's names, as far as it can be read."""
        if place in self.loaded:
            return self.loaded[place]
        source, find = self.open(place)
        program, problems = parse_tolerantly(source)
        for problem in problems:
            self.tell(problem)
        for statement in program.statements:
            if not isinstance(statement, LIBRARY_STATEMENTS):
                word = statement.span.text.split(None, 1)[0]
                message = f"a library has no `{word}`"
                hint = "a library holds only `let`, `pattern` and `import`"
                self.tell(Diagnostic("import", message, statement.span, hint))
        module = self.loaded[place] = Module(program.source)
        self.add_imports(module, program, find)
        define(module, program, self.tell)
        return module


def joined(modules: Sequence[Module]) -> Module:
    """All names of modules, those of the first ones first."""
    shared = Module(Source("", ""))
    for module in modules:
        shared.names = {**module.names, **shared.names}
        shared.unread |= module.unread
    return shared


# Compiled libraries.


@dataclass(frozen=True)
class Unpacked:
    """A compiled library whose patterns were read; `exports` are the names that an import gives."""

    contents: Contents
    exports: Module


def unpacked(contents: Contents, report: Report) -> Unpacked:
    """The patterns of a library; mistakes in them go to `report`."""
    own = _importer(contents, report).files([file.name for file in contents.patterns], None)
    return Unpacked(contents, joined(own))


def modules_of_stories(contents: Contents) -> Iterator[tuple[StoredFile, ast.Program, Module]]:
    """The stories of a library and the names in them; without those that cannot be read."""
    importer = _importer(contents, lambda _: None)
    for file in contents.stories:
        with suppress(StoryError), room_for_nesting():
            program = parse(file.source)
            yield file, program, importer.module(program, _stored(file))


def _importer(contents: Contents, report: Report) -> Importer:
    files = {file.name: file for file in (*contents.patterns, *contents.outside)}
    return Importer(report, lambda name: (files[str(name)].source, _stored(files[str(name)])))


def _stored(file: StoredFile) -> Finder:
    def find(statement: ast.Import, guess: bool) -> Sequence[Place]:
        found = file.imports.get(import_target(statement))
        if found is None:
            raise error("import", "it is not said what this import means", statement.target.span)
        return () if isinstance(found, str) else found

    return find


def import_target(statement: ast.Import) -> str:
    """An import as it is written."""
    target = statement.target
    return target.id if isinstance(target, ast.Name) else target.value


def compiled_library(path: Path, here: Span) -> Module:
    """The names of a compiled library; `here` is the import. Raises StoryError."""
    try:
        exports = read_library(path).exports
    except StoryError as problem:
        found = problem.diagnostics[0]
        message = f"`{path.name}` cannot be used: {found.message}"
        raise error("import", message, here, found.hint) from None
    return Module(exports.source, exports.names)


def read_library(path: Path) -> Unpacked:
    """Reads a compiled library. What was read is kept while the file stays as it is.

    Raises StoryError for a file that is missing, damaged, forged, of another version, or too large.
    """
    try:
        state = path.stat()
    except (OSError, ValueError):
        read_contents(path)  # says why it cannot be read
        raise
    return _read(path, state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=8)
def _read(path: Path, _modified: int, _size: int) -> Unpacked:
    contents = read_contents(path)
    for name in contents.standard:
        if name not in standard_library().names:
            message = f"it uses the standard pattern `{name}`, which this version has not"
            raise wrong_library(path, f"made with {contents.made_with}: {message}")
    problems: list[Diagnostic] = []
    with room_for_nesting():
        packed = unpacked(contents, problems.append)
    if problems:
        span = problems[0].span
        line, column = span.source.position(span.start)
        name = span.source.name.removeprefix(f"{path}/")
        reason = f"{name}:{line}:{column}: {problems[0].message}"
        raise wrong_library(path, f"the library is damaged: {reason}")
    return packed


# Files.


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
        names = (f"{shown}.story", shown, f"{shown}{SUFFIX}")
        candidates = [place / name for place in (here, patterns) for name in names]
    for path in candidates:
        files = _library_files(path)
        if files:
            return files
    stems: set[str] = set()
    if guess:
        stems = {p.stem for place in (here, patterns) for p in _library_files(place)}
        stems |= {p.stem for p in here.glob(f"*{SUFFIX}")}
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
