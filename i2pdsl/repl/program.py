"""The story that grows line by line: its statements as they were written."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

from i2pdsl.errors import Diagnostic, Source, Span, StoryError
from i2pdsl.language.builtins import ONCE, STATEMENT_WORDS
from i2pdsl.language.check import Library, TypedStory, check_source
from i2pdsl.language.methods import LONGEST_STORY, has_audience
from i2pdsl.language.statements import split_statements
from i2pdsl.language.vocabulary import Settings, Vocabulary
from i2pdsl.repl.mistakes import put_into
from i2pdsl.worlds.find import Spec, find_vocabulary, vocabulary_of

NO_OBJECTIVE = "maximize 0"  # of a story that does not say it yet
USUAL_LENGTH = 15  # of a story that does not say it yet
_HEAD = ("world", "length", "start", "allow")
_NAMED_AUDIENCE = re.compile(r"audience\s+\w+\s*=")
_ORDER = (*_HEAD, "import", "let", "pattern", "assume", "audience")


@dataclass(frozen=True)
class Part:
    """A statement: the blank lines and comments `before` it, and its own text."""

    before: str
    text: str

    @property
    def keyword(self) -> str:
        return self.text.split(None, 1)[0]

    @property
    def name(self) -> str:
        """What it defines, or the keyword."""
        words = self.text.replace("(", " ").replace("=", " ").split()
        named = self.keyword in ("let", "pattern") or _NAMED_AUDIENCE.match(self.text)
        return words[1] if named and len(words) > 1 else self.keyword


@dataclass(frozen=True)
class Program:
    """The statements of a session.

    Attributes:
        name: of the file that it came from.
        folder: where imports and worlds are looked for.
        rest: what stands after the last statement.
        known: the world of a script that carries it, and that is looked for nowhere else.
    """

    parts: tuple[Part, ...]
    name: str = "session"
    folder: Path = Path()
    rest: str = "\n"
    known: Spec | None = None

    @property
    def text(self) -> str:
        """The story."""
        return "".join(part.before + part.text for part in self.parts) + self.rest

    def has(self, *keywords: str) -> bool:
        return any(part.keyword in keywords for part in self.parts)

    def forgettable(self) -> set[str]:
        """The names and keywords of what can be taken out again."""
        return {part.name for part in self.parts if part.keyword != "world"}

    def carries(self, world: str) -> bool:
        """Whether a world, by its name or the path of its file, is the one that it brings along."""
        if self.known is None:
            return False
        of_file = Path(world).stem if world.endswith(".world") else world
        return self.known.name in (world, of_file)

    def find_world(
        self, name: str, folder: Path | None, settings: Settings = ()
    ) -> Vocabulary | None:
        if self.known is not None and self.carries(name):
            return vocabulary_of(self.known.with_settings(dict(settings)))
        return find_vocabulary(name, folder, settings)

    @property
    def has_audience(self) -> bool:
        """Whether its search asks viewers."""
        searches = (re.match(r"search\s+(\w+)", part.text) for part in self.parts)
        return all(has_audience(found[1]) for found in searches if found)

    def check(self) -> TypedStory:
        """The finished story. Raises StoryError."""
        return self._checked(self.text)

    def understood(self) -> TypedStory:
        """The story so far: what is missing yet is filled in. Raises StoryError."""
        if self.has("length"):
            return self._of_length("")
        try:
            return self._of_length(f"\nlength {USUAL_LENGTH}\n")
        except StoryError as problem:
            if all(found.code != "length" for found in problem.diagnostics):
                raise
        # There is less time in its world.
        most = self._of_length("\nlength 1\n").vocabulary.longest
        return self._of_length(f"\nlength {most}\n")

    def _of_length(self, length: str) -> TypedStory:
        """The story so far, with a statement that says its length."""
        text = self.text + length
        if not self.has("maximize", "minimize") and self.has_audience:
            text += f"\n{NO_OBJECTIVE}\n"
        return self._checked(text)

    def _checked(self, text: str) -> TypedStory:
        found = check_source(Source(self.name, text), self.find_world, self.folder)
        assert not isinstance(found, Library)  # a session has a world
        return found

    def with_part(self, part: Part) -> Program:
        """The story with one more statement; it replaces one that can stand only once."""
        parts = list(self.parts)
        once = part.keyword in (*ONCE, "let", "pattern", "audience")
        same = [i for i, p in enumerate(parts) if once and p.name == part.name]
        if same:
            before = part.before if part.before.strip() else parts[same[0]].before
            parts[same[0]] = replace(part, before=before)
        else:
            place = max((i + 1 for i, p in enumerate(parts) if _rank(p) <= _rank(part)), default=0)
            if not place:
                part = replace(part, before=part.before.lstrip("\n"))
            elif not _belong_together(parts[place - 1], part):
                part = replace(part, before="\n" + part.before)
            parts.insert(place, part)
        return replace(self, parts=tuple(parts))

    def without(self, name: str) -> Program:
        """The story without a definition, or without the statements of a keyword."""
        kept = tuple(p for p in self.parts if p.name != name)
        return replace(self, parts=kept)

    def with_length(self, length: int) -> Program:
        return self.with_part(Part("\n", f"length {min(length, LONGEST_STORY)}"))

    def in_words(self, problem: StoryError, part: Part) -> tuple[Diagnostic, ...]:
        """The mistakes with those of a new statement placed in what was typed."""
        offset = 0
        for other in self.parts:
            offset += len(other.before)
            if other.text == part.text:
                break
            offset += len(other.text)

        def move(span: Span) -> tuple[int, int] | None:
            inside = offset <= span.start and span.end <= offset + len(part.text)
            if span.source.name != self.name or not inside:
                return None
            return span.start - offset, span.end - offset

        return put_into(problem.diagnostics, part.text, move)


def _belong_together(one: Part, other: Part) -> bool:
    """Whether no blank line is between two statements."""
    return one.keyword == other.keyword or {one.keyword, other.keyword} <= set(_HEAD)


def _rank(part: Part) -> int:
    return _ORDER.index(part.keyword) if part.keyword in _ORDER else len(_ORDER)


def read_program(source: Source, folder: Path) -> Program:
    """A story's text as statements that can be replaced one by one."""
    parts, done = [], 0
    for piece in split_statements(source, STATEMENT_WORDS).pieces:
        before = source.text[done : piece.span.start]
        parts.append(Part(before, piece.span.text))
        done = piece.span.end
    return Program(tuple(parts), source.name, folder, source.text[done:] or "\n")
