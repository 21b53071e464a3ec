"""A story's objective becomes a pattern: parts of it become parameters.

The text of the objective is kept as it was written, with the names of the parameters in the places
of the parts. Lets that hold a part are put in where they are used, since a `let` cannot see a
parameter; what else the objective needs of the story (lets, patterns, imports) is carried along.
That the pattern, called with the parts, says what the story says is proved before it is returned.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from i2pdsl.errors import Diagnostic, Note, Source, Span, StoryError, closest, error, whole_file
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.builtins import FUNCTIONS, RESERVED, STATEMENT_WORDS
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.language.elaborate import Elaborator, LeavesAtZero, Stop
from i2pdsl.language.format import format_source
from i2pdsl.language.imports import build_module, find_library
from i2pdsl.language.kinds import used_names
from i2pdsl.language.parse import parse, parse_expression
from i2pdsl.language.scope import Definition, Env, Module
from i2pdsl.language.statements import (
    room_for_nesting,
    split_statements,
)
from i2pdsl.language.unused import check_unused
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.library.parts import Part, written_in
from i2pdsl.worlds.find import find_vocabulary

_LONGEST = 100_000  # characters of a pattern; lets put into lets can grow without bound
_NOT_OBJECTIVE = (ast.Objective, ast.Let, ast.Pattern, ast.Import)
_LOOSE = (ast.If, ast.Or, ast.And, ast.Not, ast.Compare, ast.Member, ast.Sum, ast.Append)
_ATOMS = (ast.Name, ast.Number, ast.Call, ast.Time, ast.Length, ast.Script, ast.Form)
_LINE = 98  # width of comments


@dataclass(frozen=True)
class Extracted:
    """A pattern made from a story.

    Attributes:
        text: of the file of the pattern.
        call: what the story's objective is now.
        replaced: for each parameter, the number of places where it was put in.
        carried: the names of lets and patterns that came along.
    """

    text: str
    signature: str
    call: str
    replaced: dict[str, int]
    carried: list[str]


def extract(
    source: Source, folder: Path, parts: list[Part], name: str, target: Path, defaults: bool = False
) -> Extracted:
    """Makes a pattern from a story.

    Args:
        folder: where the story's imports and world are looked for.
        name: of the pattern.
        target: the file that the pattern is meant for.
        defaults: whether the parts become defaults of the parameters.

    Raises StoryError for a wrong story, a part that does not occur or overlaps another, a name
    that is taken, and where the pattern would not say the same as the story.
    """
    checked = check_source(source, find_vocabulary, folder)
    if not isinstance(checked, TypedStory) or not checked.objective:
        what = (
            "the story has no objective" if isinstance(checked, TypedStory) else "it is a library"
        )
        message = f"nothing can be extracted: {what}"
        raise error("extract", message, whole_file(source.name), "give a story that maximizes")
    with room_for_nesting():
        extraction = _Extraction(checked, parts, name, defaults)
        text = extraction.library(folder, target)
        formatted = format_source(Source(str(target), text))
        call = extraction.call()
        _prove(checked, Source(str(target), formatted), target.parent, name, call)
    program = parse(Source(str(target), formatted))
    pattern = next(p for p in program.of(ast.Pattern) if p.name.id == name)
    counts = {p.name: extraction.counts[p.name] for p in parts}
    return Extracted(formatted, pattern.signature, call, counts, extraction.carried)


class _Extraction:
    def __init__(self, story: TypedStory, parts: list[Part], name: str, defaults: bool):
        self.story = story
        self.parts = parts
        self.name = name
        self.defaults = defaults
        self.program = parse(story.source)
        self.lets = {let.name.id: let for let in self.program.of(ast.Let)}
        self.counts = dict.fromkeys((p.name for p in parts), 0)
        self.carried: list[str] = []
        self.touched: dict[str, bool] = {}
        self.check_names()
        self.check_parts()

    # What is wrong with the parts.

    def check_names(self) -> None:
        problems: list[Diagnostic] = []
        seen: set[str] = set()
        for part in self.parts:
            problem = self.wrong_name(part.name)
            if part.name in seen:
                problem = "is given twice"
            if part.name == self.name:
                problem = "is the name of the pattern"
            if problem:
                hint = "choose another name for the parameter"
                message = f"`{part.name}` {problem}"
                problems.append(Diagnostic("extract", message, part.place, hint))
            seen.add(part.name)
        problem = self.wrong_name(self.name, is_pattern=True)
        if problem:
            span = Span(Source("--name", self.name), 0, len(self.name))
            hint = "choose another one with --name"
            problems.append(Diagnostic("extract", f"`{self.name}` {problem}", span, hint))
        if problems:
            raise StoryError(problems)

    def wrong_name(self, name: str, is_pattern: bool = False) -> str | None:
        world = self.story.vocabulary
        if not name.isidentifier():
            return "cannot be a name"
        if name in RESERVED or name == "pi" or name in FUNCTIONS:
            return "is a word of the language"
        if name in world.latents:
            return "is a latent of the world"
        if name in _words(world):
            return "is a name of the world"
        found = self.story.module.find(name)
        if found is None or (is_pattern and found.module is not self.story.module):
            return None  # a standard pattern may be replaced
        what = "pattern" if isinstance(found.item, ast.Pattern) else "`let`"
        return f"is the name of a {what} already"

    def check_parts(self) -> None:
        """Every part occurs, and none inside another."""
        found = [(part, node.span) for part, node in self.matches()]
        problems = [self.missing(p) for p in self.parts if not any(q is p for q, _ in found)]
        for part, span in found:
            for other, around in found:
                inside = around.start <= span.start and span.end <= around.end
                if other is part or not inside or (span == around and other.name > part.name):
                    continue
                note = Note(f"it stands here, inside `{other.text}` for `{other.name}`", span)
                message = f"`{part.text}` for `{part.name}` overlaps another part"
                hint = "replace one of them only"
                where = part.value.span
                problems.append(Diagnostic("extract", message, where, hint, (note,)))
        if problems:
            raise StoryError(list({(d.message): d for d in problems}.values()))

    def missing(self, part: Part) -> Diagnostic:
        texts = {
            " ".join(n.span.text.split())
            for v in self.reached()
            for n in written_in(v, self.story.module)
        }
        meant = closest(part.text, texts)
        hint = f"did you mean `{meant}`?" if meant else "a part is a whole expression of it"
        message = f"`{part.text}` does not occur in the objective"
        return Diagnostic("extract", message, part.value.span, hint)

    # Where the parts are.

    def reached(self) -> list[ast.Expr]:
        """The objectives, and the values of the story's lets that they use."""
        values: list[ast.Expr] = [o.value for o in self.program.of(ast.Objective)]
        seen: set[str] = set()
        for value in values:  # which grows
            for node in written_in(value, self.story.module):
                let = self.let(node)
                if let is not None and let.name.id not in seen:
                    seen.add(let.name.id)
                    values.append(let.value)
        return values

    def let(self, node: ast.Node) -> ast.Let | None:
        """The story's `let` that a name stands for."""
        return self.lets.get(node.id) if isinstance(node, ast.Name) else None

    def part(self, node: ast.Node) -> Part | None:
        return next((p for p in self.parts if p.value == node), None)

    def matches(self) -> Iterator[tuple[Part, ast.Node]]:
        for value in self.reached():
            for node in written_in(value, self.story.module):
                yield from ((p, node) for p in self.parts if p.value == node)

    def is_touched(self, let: ast.Let) -> bool:
        """Whether a `let` holds a part, or another that does."""
        name = let.name.id
        if name not in self.touched:
            self.touched[name] = False
            nodes = list(written_in(let.value, self.story.module))
            inner = [i for i in map(self.let, nodes) if i is not None]
            self.touched[name] = any(self.part(n) is not None for n in nodes) or any(
                self.is_touched(i) for i in inner
            )
        return self.touched[name]

    # The text.

    def text(self, value: ast.Expr) -> str:
        """An expression with the parts replaced and the lets that hold one put in."""
        changes: list[tuple[Span, str]] = []
        for node in written_in(value, self.story.module):
            part, let = self.part(node), self.let(node)
            if part is not None:
                self.counts[part.name] += 1
                changes.append((node.span, part.name))
            elif let is not None and self.is_touched(let):
                inner = self.text(let.value)
                is_whole = self.part(let.value) is not None or isinstance(let.value, _ATOMS)
                changes.append((node.span, inner if is_whole else f"({inner})"))
        text, end = "", value.span.start
        whole = value.span.source.text
        for span, new in sorted(changes, key=lambda change: change[0].start):
            text += whole[end : span.start] + new
            end = span.end
        text += whole[end : value.span.end]
        if len(text) > _LONGEST:
            message = f"the pattern would have more than {_LONGEST:,} characters"
            raise error("extract", message, value.span, "replace fewer parts")
        return text

    def body(self) -> str:
        """The objectives as one sum; `minimize` becomes a minus."""
        objectives: list[ast.Objective] = self.program.of(ast.Objective)
        text = ""
        for number, objective in enumerate(objectives):
            term = self.text(objective.value)
            leads = number == 0
            alone = leads and len(objectives) == 1 and objective.sign > 0
            tight = isinstance(objective.value, ast.Product | ast.Power)
            loose = isinstance(objective.value, _LOOSE)
            if not alone and (loose or (tight and leads and objective.sign < 0)):
                term = f"({term})"
            if leads:
                text = term if objective.sign > 0 else f"-{term}"
            else:
                text += f"\n    {'+' if objective.sign > 0 else '-'} {term}"
        return text

    def library(self, folder: Path, target: Path) -> str:
        """The file: imports, what is carried along, and the pattern with its documentation."""
        shown = [f"{p.name} = {p.text}" if self.defaults else p.name for p in self.parts]
        parameters = f"({', '.join(shown)})" if shown else ""
        pattern = f"pattern {self.name}{parameters} =\n    {self.body()}\n"
        carried, imports = self.needed(parse(Source("pattern", pattern)).of(ast.Pattern)[0])
        lines = [self.import_line(s, folder, target) for s in imports]
        for item in carried:
            self.carried.append(item.name.id)
            if isinstance(item, ast.Pattern):
                lines += ["", *_comment(item.documentation)]
            lines.append(item.span.text)
        about = self.documentation()
        return "\n".join([*lines, "", *about, pattern]).lstrip("\n")

    def needed(self, pattern: ast.Pattern) -> tuple[list[ast.Let | ast.Pattern], list[ast.Import]]:
        """What the pattern needs of the story: its definitions in their order, and imports."""
        module = self.story.module
        own = {
            item.name.id: item
            for item in self.program.statements
            if isinstance(item, ast.Let | ast.Pattern)
        }
        names, waiting, imported = set[str](), [pattern], False
        items: list[ast.Let | ast.Pattern] = [*waiting]
        while items:
            for name in used_names(items.pop(), module):
                found = module.find(name)
                if name in names or found is None:
                    continue
                names.add(name)
                if name in own:
                    items.append(own[name])
                elif module.names.get(name) is not None:
                    imported = True
        if self.name in names:
            span = Span(Source("--name", self.name), 0, len(self.name))
            message = f"`{self.name}` is a pattern that the story uses"
            raise error("extract", message, span, "choose another one with --name")
        imports = self.program.of(ast.Import) if imported else []
        return [item for name, item in own.items() if name in names], imports

    def import_line(self, statement: ast.Import, folder: Path, target: Path) -> str:
        """An import as it is written beside the new file."""
        if os.path.realpath(folder) == os.path.realpath(target.parent):
            return statement.span.text
        path = find_library(statement.target, folder)[0]
        whole_folder = isinstance(statement.target, ast.Name) and (folder / statement.target.id)
        if whole_folder and whole_folder.is_dir() and path.parent == whole_folder:
            path = whole_folder
        relative = os.path.relpath(path, target.parent)
        return f'import "{Path(relative).as_posix()}"'

    def documentation(self) -> list[str]:
        """The comment block above the story, and what of the story is no part of the objective."""
        pieces = split_statements(self.story.source, STATEMENT_WORDS).pieces
        settings = [
            " ".join(s.span.text.split())
            for s in self.program.statements
            if not isinstance(s, _NOT_OBJECTIVE)
        ]
        said = f"Taken from {self.story.name}.story: {', '.join(settings)}."
        return [*_comment(pieces[0].documentation), *_comment(textwrap.fill(said, _LINE))]

    def call(self) -> str:
        """What the story's objective is now."""
        given = [] if self.defaults else [p.text for p in self.parts]
        return f"{self.name}({', '.join(given)})" if self.parts else self.name


def _comment(text: str) -> list[str]:
    return [f"# {line}".rstrip() for line in text.splitlines()]


def _words(world: Vocabulary) -> set[str]:
    """All that a world gives a name."""
    values = {str(v) for latent in world.latents.values() for v in latent.values}
    names = {*world.characters, *world.things, *world.places, *world.predicates}
    return values | names | {*world.actions, *world.events}


def _prove(story: TypedStory, library: Source, folder: Path, name: str, call: str) -> None:
    """Raises StoryError unless the call says exactly what the story says."""
    problems: list[Diagnostic] = []
    program = parse(library)
    module = build_module(program, problems.append, folder)
    check_unused(program, module, None, problems.append)
    elaborator = Elaborator(story.vocabulary, story.length, problems.append)
    elaborator.assumption, elaborator.audiences = story.assumption, story.audiences
    elaborator.weight = 1.0 if story.longest else None
    item = next(p for p in program.of(ast.Pattern) if p.name.id == name)
    around = Module(story.source, {**story.module.names, name: Definition(item, module)})
    value: ty.Typed | None = None
    try:
        node = parse_expression(Source("call", call))
        value = elaborator.number(node, Env(around))
        wanted = _as_one(elaborator, story, node)
    except (Stop, LeavesAtZero):
        wanted = None
    errors = [d for d in problems if d.severity == "error"]
    if errors:
        raise StoryError(list(dict.fromkeys(errors)))
    if value is None or value != wanted:
        message = "the pattern would not say the same as the story"
        hint = "nothing was written; please report this story"
        raise error("extract", message, whole_file(story.source.name), hint)


def _as_one(elaborator: Elaborator, story: TypedStory, node: ast.Expr) -> ty.Typed:
    """The objectives of a story as one expression, as a sum of them is checked."""
    env = Env(story.module)
    terms = [
        value if sign > 0 else elaborator.apply("negate", (value,), node, env)
        for sign, value in story.objective
    ]
    return terms[0] if len(terms) == 1 else elaborator.apply("add", tuple(terms), node, env)
