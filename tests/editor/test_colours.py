"""Colours: every terminal has a kind, nothing is lost, and all agree with the real grammar."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pygments.lexers import get_lexer_by_name, get_lexer_for_filename

from fuzz_for_tests import examples
from i2pdsl.editor import textmate
from i2pdsl.editor.colours import (
    TERMINALS,
    WORLD_TERMINALS,
    Piece,
    colour,
    colour_world,
)
from i2pdsl.editor.lexer import TOKENS, StoryLexer, WorldLexer
from i2pdsl.errors import Source
from i2pdsl.language.builtins import FUNCTIONS, RESERVED, STATEMENT_WORDS
from i2pdsl.language.parse import statement_tree, tables
from i2pdsl.language.statements import split_statements
from i2pdsl.worlds.blocks import tables as world_tables
from i2pdsl.worlds.kinds import KINDS as WORLD_KIND_NAMES
from i2pdsl.worlds.kinds import kind_named, syntax_of

ROOT = Path(__file__).parents[2]
EVERY_STATEMENT = ROOT / "tests" / "language" / "every_statement.story"
STORIES = [*sorted((ROOT / "stories").rglob("*.story")), EVERY_STATEMENT]
WORLDS = sorted((ROOT / "stories").rglob("*.world"))
by_name = pytest.mark.parametrize("path", STORIES, ids=lambda p: p.stem)
by_world = pytest.mark.parametrize("path", WORLDS, ids=lambda p: p.stem)

WORDS = sorted(
    {*RESERVED, *FUNCTIONS, "rho", "G_x", "at", "table", "deus", "arc", "pi", "sum_{", "weight"}
)
SIGNS = [*"()[]{},:;|@!.+-*/^<=># \n\t\r\"'§ρ0129e", "\n    ", "..", "++", "||", "# x\n"]
KEYWORDS = kind_named("grid").syntax.keywords
TEXTS = st.lists(st.sampled_from([*WORDS, *SIGNS, *KEYWORDS]), max_size=60).map("".join) | st.text(
    max_size=80
)


def test_every_terminal_has_a_kind() -> None:
    assert set(TERMINALS) == {t.name for t in tables().terminals}
    for kind in WORLD_KIND_NAMES:
        names = {t.name for t in world_tables(kind_named(kind).syntax.grammar).terminals}
        assert {n for n in names if not n.endswith("_KW")} <= set(WORLD_TERMINALS)
    unsaid = {"function", "call", "latent", "definition", "constant", "error"}  # by terminals alone
    kinds = {*TERMINALS.values(), *WORLD_TERMINALS.values(), *unsaid}
    assert set(TOKENS) == kinds
    assert set(textmate.SCOPES) == kinds - {"space"}


def test_reserved_words_are_never_mere_names() -> None:
    for word in RESERVED:
        (piece,) = colour(word)
        assert piece.kind in ("keyword", "form", "story", "reduction"), word


def test_statement_words_are_keywords_in_the_first_column_only() -> None:
    text = "length 3\nlet x = length"
    kinds = [(text[p.start : p.end], p.kind) for p in colour(text)]
    assert kinds[0] == ("length", "keyword")
    assert kinds[-1] == ("length", "name")


def test_at_is_a_keyword_in_an_event_only() -> None:
    text = "let x = script ++ [deus: table at (1, 3)]\nstart at(robot, (1, 3))"
    assert [p.kind for p in colour(text) if text[p.start : p.end] == "at"] == ["keyword", "call"]


def test_names_that_are_known_have_their_kind() -> None:
    kinds = [p.kind for p in colour("weight = x", {"weight": "latent"})]
    assert kinds == ["latent", "space", "operator", "space", "name"]


@given(TEXTS)
@settings(max_examples=examples(400), deadline=None, derandomize=True)
def test_colours_lose_nothing(text: str) -> None:
    for pieces in (list(colour(text)), list(colour_world(text))):
        assert "".join(text[p.start : p.end] for p in pieces) == text
        assert all(p.start < p.end for p in pieces)
    for lexer in (StoryLexer(), WorldLexer()):
        found = list(lexer.get_tokens_unprocessed(text))
        assert "".join(value for _, _, value in found) == text
        assert [start for start, _, _ in found] == sorted({start for start, _, _ in found})


def real_tokens(path: Path) -> Iterator[tuple[str, int, int]]:
    """The tokens of Lark's own contextual lexer, statement by statement."""
    source = Source(str(path), path.read_text(encoding="utf-8"))
    if path.suffix == ".world":
        syntax = syntax_of(source)
        cut, tree_of = syntax.cut(source), syntax.tree
    else:
        cut, tree_of = split_statements(source, STATEMENT_WORDS), statement_tree
    assert not cut.problems
    for piece in cut.pieces:
        tree = tree_of(piece)
        for token in tree.scan_values(lambda _: True):
            if token is not None:
                yield token.type, token.start_pos, token.end_pos


@by_name
def test_stories_are_cut_as_the_parser_cuts_them(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    pieces = {(p.start, p.end): p for p in colour(text) if p.kind not in ("space", "comment")}
    expected = list(real_tokens(path))
    assert sorted(pieces) == sorted((start, end) for _, start, end in expected)
    for terminal, start, end in expected:
        kind, found = TERMINALS[terminal], pieces[start, end].kind
        if kind == "name":
            assert found in ("name", "function", "call", "latent", "definition", "constant")
        else:
            assert found == kind, text[start:end]


@by_world
def test_worlds_are_cut_as_the_parser_cuts_them(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    silent = ("space", "comment")
    pieces = {(p.start, p.end): p for p in colour_world(text) if p.kind not in silent}
    expected = list(real_tokens(path))
    assert sorted(pieces) == sorted((start, end) for _, start, end in expected)
    for terminal, start, end in expected:
        kind, found = WORLD_TERMINALS.get(terminal, "keyword"), pieces[start, end].kind
        assert found == kind or (kind == "name" and found == "definition"), text[start:end]


def test_the_kinds_of_a_story() -> None:
    text = (ROOT / "stories" / "kitchen" / "arc.story").read_text(encoding="utf-8")
    kinds = {text[p.start : p.end]: p.kind for p in colour(text)}
    expected = {
        "world": "keyword",
        "kitchen": "name",
        "absent": "call",
        "tide": "definition",
        "sin": "function",
        "t": "story",
        "3": "number",
        "pi": "constant",
        "E": "form",
        "V": "form",
        "[": "bracket",
        "|": "sign",
        "/": "operator",
        "arc": "call",
    }
    assert {word: kinds[word] for word in expected} == expected


def test_walls_are_no_comments() -> None:
    text = "# note\nmap\n    #.#\n    P.P\ntile p # here\n    symbol = P\n"
    kinds = [(text[p.start : p.end], p.kind) for p in colour_world(text) if p.kind != "space"]
    assert kinds == [
        ("# note", "comment"),
        ("map", "keyword"),
        ("#.#", "map"),
        ("P.P", "map"),
        ("tile", "keyword"),
        ("p", "name"),
        ("# here", "comment"),
        ("symbol", "definition"),
        ("=", "operator"),
        ("P", "name"),
    ]


def test_pygments_finds_the_lexers() -> None:
    assert type(get_lexer_by_name("story")).__name__ == "StoryLexer"
    assert type(get_lexer_by_name("i2p")).__name__ == "StoryLexer"
    assert type(get_lexer_for_filename("help.story")).__name__ == "StoryLexer"
    assert type(get_lexer_for_filename("kitchen.world")).__name__ == "WorldLexer"


# TextMate: what an editor makes of the grammar files, by the rules that they use.


def interpret(name: str, text: str) -> Iterator[tuple[int, int, str]]:
    """The scopes that a TextMate engine gives: line by line, the rule that matches first."""
    rules = json.loads((textmate.FOLDER / name).read_text(encoding="utf-8"))["patterns"]
    compiled = [(re.compile(rule["match"]), rule) for rule in rules]
    for line in re.finditer(r"[^\n]*", text):
        at, end = line.span()
        line_text = line.group()
        position = 0
        while at + position < end:
            found = [(p.search(line_text, position), rule) for p, rule in compiled]
            matches = [(m, rule) for m, rule in found if m is not None and m.end() > m.start()]
            if not matches:
                break
            match, rule = min(matches, key=lambda pair: pair[0].start())
            yield from scopes(match, rule, at)
            position = match.end()


def scopes(match: re.Match[str], rule: dict[str, Any], at: int) -> Iterator[tuple[int, int, str]]:
    if "name" in rule:
        yield at + match.start(), at + match.end(), rule["name"]
        return
    for number, scope in rule["captures"].items():
        start, end = match.span(int(number))
        yield at + start, at + end, scope["name"]


def as_kinds(name: str, text: str, suffix: str) -> list[tuple[int, int, str]]:
    kind_of = {f"{scope}.{suffix}": kind for kind, scope in textmate.SCOPES.items()}
    assert len(kind_of) == len(textmate.SCOPES)
    return [(start, end, kind_of[scope]) for start, end, scope in interpret(name, text)]


def spoken(pieces: Iterator[Piece]) -> list[tuple[int, int, str]]:
    return [(p.start, p.end, p.kind) for p in pieces if p.kind != "space"]


@by_name
def test_textmate_agrees_on_stories(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert as_kinds("story.tmLanguage.json", text, "story") == spoken(colour(text))


@by_world
def test_textmate_agrees_on_worlds(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert as_kinds("world.tmLanguage.json", text, "world") == spoken(colour_world(text))


def test_walls_between_cells_are_no_comment() -> None:
    text = "# A yard.\nmap\n    # . .|. .\n        -   -\n    #|P # . r\n    - - -\ntile pink\n"
    kind = lambda pieces: {at: k for a, b, k in pieces for at in range(a, b) if text[at].strip()}
    assert kind(as_kinds("world.tmLanguage.json", text, "world")) == kind(
        spoken(colour_world(text))
    )
    assert sum(k == "map" for k in kind(spoken(colour_world(text))).values()) == 17


def samples() -> list[str]:
    """A word or sign of every terminal, and of every function."""
    found = [*FUNCTIONS, "pi", "rho", "G_robot", "R_cheese", "anything", '"text"', "12.5e-3"]
    for terminal in tables().terminals:
        value = terminal.value
        if terminal.is_text:
            found.append(value)
        elif value.endswith(r"\b") and "(" not in value:
            found.append(value.removesuffix(r"\b"))
    return [*found, "sum_t", "mean_t", "min_{", "max_{"]


def test_textmate_agrees_on_every_word() -> None:
    assert len(samples()) > 70
    for word in samples():
        for text in (word, f"let x = {word} + 1", f"maximize {word}(a)"):
            found = as_kinds("story.tmLanguage.json", text, "story")
            assert found == spoken(colour(text)), text


def test_the_textmate_files_are_as_generated() -> None:
    for name in textmate.GRAMMARS:
        text = (textmate.FOLDER / name).read_text(encoding="utf-8")
        assert text == textmate.written(name), "run python -m i2pdsl.editor.textmate"
        for rule in json.loads(text)["patterns"]:
            assert set(rule) <= {"match", "name", "captures"}
