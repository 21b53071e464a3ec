"""From a folder of stories to a library: everything is checked, the patterns and lets are packed.

What a file imports from elsewhere is packed too, under `outside/`, or under the name of the
compiled library that it comes from; the standard patterns are not, every reader has them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

from i2pdsl.errors import Diagnostic, Note, Source, StoryError, error, whole_file
from i2pdsl.language import ast
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.language.imports import Unpacked, find_library, import_target, read_library, unpacked
from i2pdsl.language.kinds import used_names
from i2pdsl.language.packed import (
    STANDARD,
    SUFFIX,
    Contents,
    Imports,
    StoredFile,
    is_stored_name,
    too_much,
)
from i2pdsl.language.parse import parse, parse_tolerantly
from i2pdsl.language.scope import LIBRARY_STATEMENTS, Module, standard_library
from i2pdsl.language.statements import read_source, room_for_nesting
from i2pdsl.language.unused import check_circles, check_unused
from i2pdsl.library.description import MADE_WITH, PatternLibrary
from i2pdsl.resources import data_folder
from i2pdsl.untrusted import is_plain_name
from i2pdsl.worlds.find import find_vocabulary, world_path


@dataclass(frozen=True)
class Packed:
    """A library and the checked stories of its folder.

    Attributes:
        stories: path and story, in the order of the library's `stories`.
        warnings: of all files.
    """

    library: PatternLibrary
    stories: list[tuple[Path, TypedStory]]
    warnings: list[Diagnostic]


def pack(folder: Path, paths: list[Path], name: str) -> Packed:
    """Checks the files of a folder and packs its patterns.

    Args:
        paths: the .story and .world files in it.
        name: of the library.

    Raises StoryError with every mistake of all files.
    """
    packer = _Packer(folder, paths)
    packer.read()
    packer.stop_if_wrong()
    if not packer.patterns:
        message = "there are no patterns in this folder"
        hint = "a library of patterns is a file of only `let`, `pattern` and `import`"
        raise error("no-pattern", message, whole_file(str(folder)), hint)
    contents = packer.contents()
    excess = too_much(contents)
    if excess:  # what is written must be readable
        raise error("library", excess, whole_file(str(folder)), "split the folder")
    with room_for_nesting():
        packed = unpacked(contents, packer.report)
        packer.stop_if_wrong()
        packer.check(packed)
    packer.stop_if_wrong()
    packed = replace(packed, contents=replace(contents, standard=_standard_names(packed.exports)))
    stories = sorted(packer.stories, key=lambda story: packer.stored_name(story[0]))
    return Packed(PatternLibrary(name, packed), stories, list(dict.fromkeys(packer.warnings)))


@dataclass
class _Packer:
    """Collects the files of a folder and what they need from outside.

    Attributes:
        programs: of its files of patterns.
        names: of packed files of patterns and of worlds, by resolved path.
    """

    folder: Path
    paths: list[Path]
    problems: list[Diagnostic] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)
    programs: dict[Path, ast.Program] = field(default_factory=dict)
    stories: list[tuple[Path, TypedStory]] = field(default_factory=list)
    patterns: list[StoredFile] = field(default_factory=list)
    outside: list[StoredFile] = field(default_factory=list)
    told: list[StoredFile] = field(default_factory=list)
    worlds: list[StoredFile] = field(default_factory=list)
    names: dict[Path, str] = field(default_factory=dict)

    def report(self, problem: Diagnostic) -> None:
        (self.problems if problem.severity == "error" else self.warnings).append(problem)

    def stop_if_wrong(self) -> None:
        if self.problems:
            raise StoryError(list(dict.fromkeys(self.problems)))

    def contents(self) -> Contents:
        kinds = (self.patterns, self.outside, self.told, self.worlds)
        patterns, outside, stories, worlds = (_by_name(kind) for kind in kinds)
        return Contents(patterns, outside, stories, worlds, MADE_WITH)

    def read(self) -> None:
        """Reads and checks all files of the folder; packs them and what they need."""
        for path in self.paths:
            try:
                name, source = self.stored_name(path), read_source(path)
                if path.suffix == ".world":
                    find_vocabulary(path.name, path.parent)
                    self.world(path)
                    continue
                program = _as_library(source)
                if program is not None:
                    self.names[path.resolve()] = name
                    self.programs[path] = program
                    continue
                checked = check_source(source, find_vocabulary, path.parent)
                self.warnings.extend(checked.warnings)
                if isinstance(checked, TypedStory):
                    self.stories.append((path, checked))
            except StoryError as problem:
                self.problems.extend(problem.diagnostics)
        for path, program in self.programs.items():
            name, imports = self.names[path.resolve()], self.imports(program, path.parent)
            self.patterns.append(StoredFile(name, program.source, imports))
        for path, typed in self.stories:
            name, imports = self.stored_name(path), self.imports(parse(typed.source), path.parent)
            where = world_path(typed.world, path.parent)
            world = typed.world if where is None else self.world(where)
            self.told.append(StoredFile(name, typed.source, imports, world))

    def check(self, packed: Unpacked) -> None:
        """The definitions of all files: names that are not known, circles, and clashes."""
        first: dict[str, ast.Name] = {}
        for program in self.programs.values():
            for name in (
                s.name for s in program.statements if isinstance(s, ast.Let | ast.Pattern)
            ):
                known = first.setdefault(name.id, name)
                if known.span.source is not name.span.source:
                    note = Note("the first one", known.span)
                    message = f"`{name.id}` is defined in two files of the library"
                    hint = "rename one of them"
                    self.report(Diagnostic("duplicate", message, name.span, hint, (note,)))
        items = [d.item for d in packed.exports.names.values()]
        sources = {id(file.source) for file in self.patterns}
        own = [item for item in items if id(item.span.source) in sources]
        whole = ast.Program(whole_file(str(self.folder)).source, tuple(own))
        check_unused(whole, packed.exports, None, self.report)
        check_circles([i for i in items if i not in own], packed.exports, self.report)

    def stored_name(self, path: Path, folder: Path | None = None) -> str:
        name = path.relative_to(folder or self.folder).as_posix()
        if not is_stored_name(name) or not is_plain_name(path.stem):
            message = "a file of this name cannot be stored in a library"
            raise error("library", message, whole_file(str(path)), "rename the file")
        return name

    def imports(self, program: ast.Program, folder: Path) -> Imports:
        """The files that a program's imports mean; those from outside are packed."""
        found: Imports = {}
        for statement in program.of(ast.Import):
            try:
                paths = find_library(statement.target, folder)
                found[import_target(statement)] = self.imported(paths)
            except StoryError as problem:
                self.problems.extend(problem.diagnostics)
        return found

    def imported(self, paths: list[Path]) -> list[str] | str:
        names: list[str] = []
        for path in (p.resolve() for p in paths):
            if path.suffix == SUFFIX:
                names += self.compiled(path)
                continue
            if path not in self.names:
                if path.is_relative_to((data_folder("stories") / "patterns").resolve()):
                    return STANDARD
                self.from_outside(path)
            names.append(self.names[path])
        return names

    def from_outside(self, path: Path) -> None:
        """Packs a file of patterns from outside the folder."""
        self.names[path] = name = self.free_name(f"outside/{path.stem}", ".story")
        program, problems = parse_tolerantly(read_source(path))
        self.problems.extend(problems)
        imports = self.imports(program, path.parent)
        self.outside.append(StoredFile(name, program.source, imports))

    def compiled(self, path: Path) -> list[str]:
        """Packs the files of another compiled library; those that an import of it gives."""
        stored = read_library(path).contents
        if path not in self.names:
            self.names[path] = place = self.free_name(path.name, "")
            for file in (*stored.patterns, *stored.outside):
                imports: Imports = {
                    target: found if isinstance(found, str) else [f"{place}/{n}" for n in found]
                    for target, found in file.imports.items()
                }
                self.outside.append(StoredFile(f"{place}/{file.name}", file.source, imports))
        return [f"{self.names[path]}/{file.name}" for file in stored.patterns]

    def free_name(self, stem: str, suffix: str) -> str:
        taken, number, name = set(self.names.values()), 1, f"{stem}{suffix}"
        taken |= {self.stored_name(path) for path, _ in self.stories}
        while name in taken or not is_stored_name(name):
            number += 1
            name = (
                f"{stem}-{number}{suffix}" if is_stored_name(name) else f"outside/{number}{suffix}"
            )
        return name

    def world(self, path: Path) -> str:
        """The name of a built-in world, or that of the file of another, which is packed."""
        path = path.resolve()
        if path.is_relative_to((data_folder("stories") / "worlds").resolve()):
            return path.stem
        if path not in self.names:
            place = self.folder.resolve()
            inside = path.is_relative_to(place)
            outside = self.free_name(f"outside/{path.stem}", ".world")
            self.names[path] = self.stored_name(path, place) if inside else outside
            self.worlds.append(StoredFile(self.names[path], read_source(path)))
        return self.names[path]


def _standard_names(exports: Module) -> tuple[str, ...]:
    """The standard patterns that a library uses."""
    standard = standard_library().names
    found: set[str] = set()
    for definition in exports.names.values():
        used = used_names(definition.item, definition.module)
        found |= {name for name in used if definition.module.find(name) is standard.get(name, 0)}
    return tuple(sorted(found))


def _by_name(files: list[StoredFile]) -> tuple[StoredFile, ...]:
    return tuple(sorted(files, key=lambda file: file.name))


def _as_library(source: Source) -> ast.Program | None:
    """The program of a file of patterns that can be read; None for everything else."""
    program, problems = parse_tolerantly(source)
    is_library = all(isinstance(s, LIBRARY_STATEMENTS) for s in program.statements)
    return program if is_library and program.statements and not problems else None
