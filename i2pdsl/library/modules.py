"""From the stored files of a library to modules: names as if the files lay in a folder.

The files of one group know each other's names, as those of a folder do. The library's own files are
the group without a name; files that were packed because one of these imports them are others, and
are known where they are imported.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from i2pdsl.errors import Diagnostic, Note, Source, StoryError
from i2pdsl.language import ast
from i2pdsl.language.parse import parse_tolerantly
from i2pdsl.language.scope import LIBRARY_STATEMENTS, Definition, Module, define

Imports = dict[str, list[str] | str]
"""For each import of a file, as it is written: the files that it means, or `standard`."""
STANDARD = "standard"

Report = Callable[[Diagnostic], None]


@dataclass(frozen=True)
class StoredFile:
    """A file of a library. `name` is its path inside the library."""

    name: str
    source: Source
    group: str = ""
    imports: Imports = field(default_factory=dict)

    @property
    def is_own(self) -> bool:
        return not self.group


@dataclass(frozen=True)
class Modules:
    """What the files of a library define.

    Attributes:
        programs, modules: of each file, by its name.
        exports: the names that an import of the library gives.
    """

    programs: dict[str, ast.Program]
    modules: dict[str, Module]
    exports: Module

    def file_of(self, definition: Definition) -> str:
        """The file that a name is defined in; `standard` for the standard patterns."""
        for name, module in self.modules.items():
            if definition.module is module:
                return name
        return STANDARD


def import_target(statement: ast.Import) -> str:
    """An import as it is written."""
    target = statement.target
    return target.id if isinstance(target, ast.Name) else target.value


def build_modules(name: str, files: list[StoredFile], report: Report) -> Modules:
    """Reads the sources and finds their names; mistakes go to `report`.

    Raises StoryError where the imports go in a circle.
    """
    programs: dict[str, ast.Program] = {}
    for file in files:
        try:
            programs[file.name], problems = parse_tolerantly(file.source)
        except StoryError as problem:
            programs[file.name], problems = ast.Program(file.source, ()), [*problem.diagnostics]
        for diagnostic in problems:
            report(diagnostic)
        for statement in programs[file.name].statements:
            if not isinstance(statement, LIBRARY_STATEMENTS):
                word = statement.span.text.split(None, 1)[0]
                hint = "a library holds only `let`, `pattern` and `import`"
                report(Diagnostic("import", f"a library has no `{word}`", statement.span, hint))
    builder = _Builder(files, programs, report)
    for file in files:
        builder.module(file.name)
    _check_clashes([builder.modules[file.name] for file in files if file.is_own], report)
    exports = Module(Source(name, ""))
    groups: dict[str, list[Module]] = {}
    for file in files:
        groups.setdefault(file.group, []).append(builder.modules[file.name])
    for group, members in groups.items():
        shared = Module(Source(name, ""))
        for module in members:
            shared.names = {**module.names, **shared.names}
        if not group:
            exports = shared
        for module in members:
            module.names = {**shared.names, **module.names}
    return Modules(programs, builder.modules, exports)


class _Builder:
    """Builds the module of each file after those that it imports. No recursion: chains of imports
    are as long as a library."""

    def __init__(self, files: list[StoredFile], programs: dict[str, ast.Program], report: Report):
        self.files = {file.name: file for file in files}
        self.programs = programs
        self.report = report
        self.modules: dict[str, Module] = {}

    def module(self, name: str) -> None:
        waiting, open_ = [name], set[str]()
        while waiting:
            current = waiting[-1]
            if current in self.modules:
                waiting.pop()
                continue
            missing = [n for n in self.imported(current) if n not in self.modules]
            if not missing:
                self.modules[current] = self.build(current)
                continue
            if open_ & {*missing} or current in missing:
                raise StoryError([self.circle(current)])
            open_.add(current)
            waiting.append(missing[0])

    def imported(self, name: str) -> list[str]:
        lists = self.files[name].imports.values()
        return [n for found in lists if not isinstance(found, str) for n in found]

    def build(self, name: str) -> Module:
        module = Module(self.programs[name].source)
        for statement in self.programs[name].of(ast.Import):
            found = self.files[name].imports.get(import_target(statement), STANDARD)
            for other in () if isinstance(found, str) else found:
                module.names = {**self.modules[other].names, **module.names}
        define(module, self.programs[name], self.report)
        return module

    def circle(self, name: str) -> Diagnostic:
        statements = self.programs[name].of(ast.Import)
        span = statements[0].target.span
        return Diagnostic("import", "the imports go in a circle", span, "remove this import")


def _check_clashes(own: list[Module], report: Report) -> None:
    """Two files of a library cannot define one name."""
    first: dict[str, Definition] = {}
    for module in own:
        for name, definition in module.names.items():
            if definition.module is not module:
                continue
            if name in first:
                note = Note("the first one", first[name].item.name.span)
                message = f"`{name}` is defined in two files of the library"
                span, hint = definition.item.name.span, "rename one of them"
                report(Diagnostic("duplicate", message, span, hint, (note,)))
            first.setdefault(name, definition)
