"""From a folder of stories to a library: everything is checked, the patterns and lets are packed.

What a file imports from elsewhere is packed too, under `outside/`, or under the name of the
compiled library that it comes from; the standard patterns are not, every reader has them.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from i2pdsl.errors import Diagnostic, Source, StoryError, error, whole_file
from i2pdsl.language import ast
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.language.parse import parse, parse_tolerantly
from i2pdsl.language.scope import LIBRARY_STATEMENTS, find_library
from i2pdsl.language.statements import read_source, room_for_nesting
from i2pdsl.language.unused import check_unused
from i2pdsl.library.description import Record, describe
from i2pdsl.library.document import (
    MADE_WITH,
    SUFFIX,
    is_stored_name,
    too_much,
    with_hash,
)
from i2pdsl.library.fits import fit_all
from i2pdsl.library.modules import (
    STANDARD,
    Imports,
    Modules,
    StoredFile,
    build_modules,
    import_target,
)
from i2pdsl.library.read import PatternLibrary, read_library, stored_files
from i2pdsl.resources import data_folder
from i2pdsl.worlds.find import builtin_worlds, find_vocabulary, world_path
from i2pdsl.worlds.grid.parse import parse_world


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
    if not packer.files:
        message = "there are no patterns in this folder"
        hint = "a library of patterns is a file of only `let`, `pattern` and `import`"
        raise error("no-pattern", message, whole_file(str(folder)), hint)
    modules = build_modules(name, packer.files, packer.report)
    with room_for_nesting():
        for file in packer.files:
            if file.is_own:
                program = modules.programs[file.name]
                check_unused(program, modules.modules[file.name], None, packer.report)
    packer.stop_if_wrong()
    patterns, lets = describe(modules)
    packer.refuse_too_much(len(patterns) + len(lets))
    stories = [packer.story(path, typed, modules) for path, typed in packer.stories]
    for record in patterns:
        record["worlds"] = fit_all(record, modules.exports, packer.vocabularies())
        record["examples"] = [
            {"file": story["file"], "world": story["world"], "call": story["calls"][record["name"]]}
            for story in stories
            if record["name"] in story["calls"]
        ]
    document = with_hash(
        {
            "name": name,
            "made_with": MADE_WITH,
            "files": [
                {"name": f.name, "source": f.source.text, "group": f.group, "imports": f.imports}
                for f in packer.files
            ],
            "patterns": patterns,
            "lets": lets,
            "worlds": list(packer.worlds.values()),
            "stories": stories,
            "shapes": [],
        }
    )
    library = PatternLibrary(document, modules)
    return Packed(library, packer.stories, list(dict.fromkeys(packer.warnings)))


@dataclass
class _Packer:
    """Collects the files of a folder and what they need from outside."""

    folder: Path
    paths: list[Path]
    problems: list[Diagnostic] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)
    files: list[StoredFile] = field(default_factory=list)
    stories: list[tuple[Path, TypedStory]] = field(default_factory=list)
    worlds: dict[Path, Record] = field(default_factory=dict)
    names: dict[Path, str] = field(default_factory=dict)  # of packed files, by resolved path

    def report(self, problem: Diagnostic) -> None:
        (self.problems if problem.severity == "error" else self.warnings).append(problem)

    def stop_if_wrong(self) -> None:
        if self.problems:
            raise StoryError(list(dict.fromkeys(self.problems)))

    def read(self) -> None:
        """Reads and checks the stories and worlds; finds the files of patterns."""
        libraries: list[tuple[Path, ast.Program]] = []
        for path in self.paths:
            try:
                source = read_source(path)
                if path.suffix == ".world":
                    parse_world(source, path.stem)
                    self.world(path)
                    continue
                program = _as_library(source)
                if program is not None:
                    self.names[path.resolve()] = self.stored_name(path)
                    libraries.append((path, program))
                    continue
                checked = check_source(source, find_vocabulary, path.parent)
                self.warnings.extend(checked.warnings)
                if isinstance(checked, TypedStory):
                    self.stories.append((path, checked))
            except StoryError as problem:
                self.problems.extend(problem.diagnostics)
        for path, program in libraries:
            imports = self.imports(program, path.parent)
            self.files.append(StoredFile(self.names[path.resolve()], program.source, "", imports))
        self.files.sort(key=lambda file: (file.group, file.name))

    def stored_name(self, path: Path) -> str:
        name = path.relative_to(self.folder).as_posix()
        if not is_stored_name(name):
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
            elif path in self.names:
                names.append(self.names[path])
            elif path.is_relative_to((data_folder("stories") / "patterns").resolve()):
                return STANDARD
            else:
                # The files of one import know each other: a file, or those of a folder.
                group = f"outside/{paths[0].parent.name if len(paths) > 1 else path.stem}"
                names.append(self.outside(path, group))
        return names

    def outside(self, path: Path, group: str) -> str:
        """Packs a file from outside the folder."""
        self.names[path] = name = self.free_name(f"outside/{path.stem}", ".story")
        program, problems = parse_tolerantly(read_source(path))
        self.problems.extend(problems)
        imports = self.imports(program, path.parent)
        self.files.append(StoredFile(name, program.source, group, imports))
        return name

    def compiled(self, path: Path) -> list[str]:
        """Packs the files of another compiled library; those that an import of it gives."""
        stored = stored_files(read_library(path).document, str(path))
        if path not in self.names:
            self.names[path] = self.free_name(path.name, "")
            for file in stored:
                imports: Imports = {
                    target: found if isinstance(found, str) else self.within(path, found)
                    for target, found in file.imports.items()
                }
                place = self.names[path]
                group = f"{place}/{file.group}" if file.group else place
                source = Source(f"{path}/{file.name}", file.source.text)
                self.files.append(StoredFile(f"{place}/{file.name}", source, group, imports))
        return self.within(path, [f.name for f in stored if f.is_own])

    def within(self, library: Path, names: list[str]) -> list[str]:
        return [f"{self.names[library]}/{name}" for name in names]

    def free_name(self, stem: str, suffix: str) -> str:
        taken, number, name = set(self.names.values()), 1, f"{stem}{suffix}"
        while name in taken or not is_stored_name(name):
            number += 1
            name = (
                f"{stem}-{number}{suffix}" if is_stored_name(name) else f"outside/{number}{suffix}"
            )
        return name

    def refuse_too_much(self, definitions: int) -> None:
        """What would be written must be readable."""
        excess = too_much([file.source.text for file in self.files], definitions)
        if excess:
            raise error("library", excess, whole_file(str(self.folder)), "split the folder")

    # Worlds and stories.

    def world(self, path: Path) -> str:
        """The name of a world in the library; its text is kept unless every reader has it."""
        path = path.resolve()
        if path.is_relative_to((data_folder("stories") / "worlds").resolve()):
            return path.stem
        if path not in self.worlds:
            taken = {*builtin_worlds(), *(world["name"] for world in self.worlds.values())}
            place = self.folder.resolve()
            inside = path.is_relative_to(place)
            file = path.relative_to(place).as_posix() if inside else f"outside/{path.name}"
            name = path.stem if path.stem not in taken else file
            if not is_stored_name(file) or not is_stored_name(name):
                message = "a file of this name cannot be stored in a library"
                raise error("library", message, whole_file(str(path)), "rename the file")
            source = read_source(path).text
            self.worlds[path] = {"name": name, "file": file, "source": source}
        return str(self.worlds[path]["name"])

    def vocabularies(self) -> list[tuple[str, Any]]:
        """The built-in worlds and those of the folder, by name."""
        found = [(name, find_vocabulary(name)) for name in builtin_worlds()]
        for path, world in self.worlds.items():
            found.append((world["name"], find_vocabulary(path.name, path.parent)))
        return [(name, words) for name, words in found if words is not None]

    def story(self, path: Path, typed: TypedStory, modules: Modules) -> Record:
        """The record of a story."""
        where = world_path(typed.world, path.parent)
        own = {p for p, name in self.names.items() if name in modules.programs}
        return {
            "file": self.stored_name(path),
            "world": typed.world if where is None else self.world(where),
            "length": typed.length,
            "search": typed.search.method,
            "source": typed.source.text,
            "calls": calls_of(typed, own),
        }


def _as_library(source: Source) -> ast.Program | None:
    """The program of a file of patterns that can be read; None for everything else."""
    program, problems = parse_tolerantly(source)
    is_library = all(isinstance(s, LIBRARY_STATEMENTS) for s in program.statements)
    return program if is_library and program.statements and not problems else None


def calls_of(typed: TypedStory, files: set[Path]) -> dict[str, str]:
    """The first call of each pattern of these files in a story's objective, as it is written."""
    found: dict[str, str] = {}
    waiting: list[ast.Expr] = [o.value for o in reversed(parse(typed.source).of(ast.Objective))]
    seen: set[str] = set()
    while waiting:
        for node in _in_order(waiting.pop()):
            if not isinstance(node, ast.Name | ast.Call):
                continue
            name = node.id if isinstance(node, ast.Name) else node.callee.id
            definition = typed.module.find(name)
            if definition is None:
                continue
            if isinstance(definition.item, ast.Let):
                if name not in seen and definition.module is typed.module:
                    seen.add(name)
                    waiting.append(definition.item.value)
                continue
            place = Path(os.path.realpath(definition.item.span.source.name))
            if place in files:
                found.setdefault(name, " ".join(node.span.text.split()))
    return dict(sorted(found.items()))


def _in_order(node: ast.Node) -> list[ast.Node]:
    return sorted(ast.walk(node), key=lambda part: part.span.start)
