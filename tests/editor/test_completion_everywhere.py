"""Completion at every place of every story, and of any text at all.

What stands at a place is among what is offered there, and whatever is offered can be written: the
grammar accepts the statement up to it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lark.exceptions import UnexpectedInput
from lark.parsers.lalr_interactive_parser import InteractiveParser
from lark.utils import TextSlice

from fuzz_for_tests import FULL, examples
from i2pdsl.editor.colours import Piece, colour
from i2pdsl.editor.complete import Surroundings, complete, surroundings
from i2pdsl.editor.definition import definition
from i2pdsl.editor.hover import hover
from i2pdsl.editor.outline import headings, signature_at
from i2pdsl.errors import Source
from i2pdsl.language.builtins import STATEMENT_WORDS
from i2pdsl.language.parse import grammar
from i2pdsl.language.statements import split_statements
from i2pdsl.worlds.find import find_vocabulary

ROOT = Path(__file__).parents[2]
EVERY_STATEMENT = ROOT / "tests" / "language" / "every_statement.story"
STORIES = [*sorted((ROOT / "stories").rglob("*.story"))[:: 1 if FULL else 8], EVERY_STATEMENT]


@cache
def known(path: Path) -> tuple[str, Surroundings]:
    text = path.read_text(encoding="utf-8")
    return text, surroundings(Source(str(path), text), path.parent, find_vocabulary)


def is_new(text: str, piece: Piece) -> bool:
    """Whether a name is being given here: by a let, a pattern, or as a parameter."""
    if piece.kind == "definition":
        return True
    head = re.compile(r"^pattern\s+\w+\s*\(", re.MULTILINE)
    for found in head.finditer(text, 0, piece.start):
        depth, inside = 1, text[found.end() : piece.start]
        for sign in inside:
            depth += (sign in "([{") - (sign in ")]}")
        if depth == 1 and inside.rstrip()[-1:] in ("", ","):
            return True
    return False


def told(path: Path) -> Iterator[Piece]:
    """The words and signs of a story that completion can know."""
    text, _ = known(path)
    for piece in colour(text):
        free = piece.kind in ("space", "comment", "number", "string")
        if not free and not is_new(text, piece):
            yield piece


@pytest.mark.parametrize("path", STORIES, ids=lambda p: p.stem)
def test_what_stands_there_is_offered(path: Path) -> None:
    text, around = known(path)
    for piece in told(path):
        word = text[piece.start : piece.end]
        offsets = [piece.start, piece.start + 1] if word[0].isalpha() else [piece.start]
        for offset in offsets:
            # Whatever follows: the whole story, or nothing at all.
            for rest in (text, text[:offset]):
                found = {c.text.removesuffix(" = ") for c in complete(rest, offset, around)}
                line = text.count("\n", 0, offset) + 1
                assert word in found, f"{path.name}:{line}: {text[offset - 20 : offset]!r}"


@pytest.mark.parametrize("path", STORIES, ids=lambda p: p.stem)
def test_what_is_offered_can_be_written(path: Path) -> None:
    text, around = known(path)
    checked = 0
    for piece in colour(text):
        for completion in complete(text, piece.start, around):
            written = text[: completion.start] + completion.text
            assert accepted(written, completion.start), f"{path.name}: {written[-60:]!r}"
            checked += 1
    print(f"{path.name}: {checked} completions are accepted")
    assert checked > 20


def accepted(text: str, completed: int) -> bool:
    """Whether the grammar accepts the statement in which a text was completed, up to its end."""
    first_column = completed == 0 or text[completed - 1] == "\n"
    start = statement_start(text if first_column else text[:completed])
    parser = read(text[: max(start, completed)], start).copy(deepcopy_values=False)
    parser.lexer_thread.state.text = TextSlice(text, start, len(text))  # it goes on from there
    try:
        parser.exhaust_lexer()
    except UnexpectedInput:
        return False
    return True


@lru_cache(maxsize=1)
def read(text: str, start: int) -> InteractiveParser:
    """The parser that has read a text from `start` on, but for its last token: what that is may
    depend on what follows."""
    parser = grammar().parse_interactive(TextSlice(text, start, len(text)), "statement")
    tokens = parser.lexer_thread.lex(parser.parser_state)
    before = now = parser.copy(deepcopy_values=False)
    with suppress(UnexpectedInput):
        for token in tokens:
            before = now
            parser.feed_token(token)
            now = parser.copy(deepcopy_values=False)
    return before


@lru_cache(maxsize=64)
def statement_start(text: str) -> int:
    cut = split_statements(Source("", text), STATEMENT_WORDS)
    return max([*(p.span.start for p in cut.pieces), *(s.start for s in cut.unread)])


# Any text at all.

KITCHEN = surroundings(Source("", "world kitchen\nlength 3\n"), ROOT, find_vocabulary)
FORMS = "P E V KL entropy surprise suspense last script t T if then else and or not in at"
NAMES = "rho G_cheese pink robot cheese table deus depict over west kitchen beam starts"
SIGNS = "( ) [ ] { } , : ; | || @ ! .. + ++ - * / ^ < <= = != >= >"
OTHERS = (
    "sum_t",
    "sum_{",
    "1",
    "0.5",
    '"a',
    "#",
    "\n",
    "\n    ",
    "ρ",
    "\t",
    "\r\n",
    "\x00",
    "\ud800",
)
TOKENS = [*STATEMENT_WORDS, *FORMS.split(), *NAMES.split(), *SIGNS.split(), *OTHERS]
ANY_TEXT = st.lists(st.sampled_from(TOKENS), max_size=40).flatmap(
    lambda tokens: st.sampled_from(["", " "]).map(lambda glue: glue.join(tokens))
)


@given(ANY_TEXT, st.integers(0, 200), st.sampled_from(["file", "expression"]))
@settings(max_examples=examples(500), deadline=None, derandomize=True)
def test_any_text_is_survived(text: str, offset: int, start: str) -> None:
    offset = min(offset, len(text))
    for completion in complete(text, offset, KITCHEN, start):
        assert 0 <= completion.start <= completion.end == offset
        typed = text[completion.start : offset]
        assert completion.text.lower().startswith(typed.lower())
    hover(text, offset, KITCHEN, start)
    definition(text, offset, KITCHEN, start)
    signature_at(text, offset, KITCHEN, start)
    list(headings(Source("any.story", text)))
    surroundings(Source("any.story", text), Path("nowhere"), find_vocabulary)


@pytest.mark.parametrize("part", ["(", "P(rho > 0 | ", "not ", "-", "min(1 1, ", "(if t < 3 then "])
@pytest.mark.parametrize("times", [150, 3000])
def test_nesting_is_survived(part: str, times: int) -> None:
    """What is nested more deeply than a story may be has no completion.

    Where something is wrong before, as `1 1` is, only the brackets next to the place count.
    """
    text = f"world kitchen\nmaximize {part * times}"
    found = complete(text, len(text), KITCHEN)
    assert bool(found) == (times == 150 or part in ("not ", "-", "min(1 1, "))
    hover(text, len(text) - 1, KITCHEN)
    definition(text, len(text) - 1, KITCHEN)
    signature_at(text, len(text), KITCHEN)


STORY_TEXTS = [known(path)[0] for path in STORIES]


@given(st.sampled_from(STORY_TEXTS), st.integers(0, 3000), st.integers(0, 12), ANY_TEXT)
@settings(max_examples=examples(300), deadline=None, derandomize=True)
def test_edited_stories_are_survived(story: str, at: int, removed: int, added: str) -> None:
    at %= len(story)
    text = story[:at] + added + story[at + removed :]
    around = surroundings(Source("any.story", text), Path("nowhere"), find_vocabulary)
    complete(text, at + len(added), around)
    hover(text, at, around)
    definition(text, at, around)
