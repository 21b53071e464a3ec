"""What is said of words and where they are defined; positions as editors count them."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from i2pdsl.editor.complete import surroundings
from i2pdsl.editor.definition import definition, file_of
from i2pdsl.editor.hover import Hover, hover
from i2pdsl.editor.outline import signature_at
from i2pdsl.editor.positions import Lines
from i2pdsl.errors import Source, Span
from i2pdsl.worlds.find import find_vocabulary

ROOT = Path(__file__).parents[2]
STORY = """world kitchen(beta = 1.5)
length 15
start at(robot, pink)
allow deus(table)
let shown = script ++ [cheese: stay, robot: east]
let kind = rho > 0
let curve = P(kind | script[:t])
let whole = G_robot
# How much it is believed.
# By everybody.
pattern show(event, over = script) = sum_t P(event | over[:t])
maximize show(kind, over = shown) + mean_t E[V(robot) | script[:t]]
maximize [pushes(robot, cheese) @ script[T]] + arc(who = cheese, scale = 1)
search beam(starts = 3)
let table = P(G_cheese, rho | script[:t, cheese])
let moves = next(robot | script[:t])
audience friend = bayesian(given = G_cheese = pink)
let secret = P[friend](kind | script[:t])
"""
AROUND = surroundings(Source("tale.story", STORY), ROOT / "nowhere", find_vocabulary)


def place(word: str, number: int = 1) -> int:
    """The offset of the n-th occurrence of a text."""
    at = -1
    for _ in range(number):
        at = STORY.index(word, at + 1)
    return at


def told(word: str, number: int = 1) -> Hover:
    found = hover(STORY, place(word, number), AROUND)
    assert found is not None
    return found


TYPES = {  # the word in the story: its kind, its signature, its type
    ("shown", 1): ("let", "shown = script ++ [cheese: stay, robot: east]", "script"),
    ("kind", 1): ("let", "kind = rho > 0", "event"),
    ("curve", 1): ("let", "curve = P(kind | script[:t])", "number over t"),
    ("rho", 1): ("latent", "rho in {-3, -1, 0, 1, 3}", "number over hypotheses"),
    ("G_robot", 1): ("latent", "G_robot in {pink, green, none}", "name over hypotheses"),
    ("P(kind", 1): ("form", "P(event | script[:k], condition, ...)", "number over t"),
    ("P(G_cheese, rho", 1): (
        "form",
        "P(event | script[:k], condition, ...)",
        "distribution over G_cheese and rho over t",
    ),
    ("next(", 1): (
        "form",
        "next(who | script[:k], condition, ...)",
        "distribution over robot over t",
    ),
    ("V(robot", 1): ("form", "V(who)", "number over hypotheses"),
    ("E[", 1): ("form", "E[quantity | script[:k], condition, ...]", "number over t"),
    ("mean_t", 1): ("reduction", "mean_t e", "number"),
    ("script[:t]", 1): ("story", "script", "the first frames of a script"),
    ("script[T]", 1): ("story", "script", "a frame of a script"),
    ("script ++", 1): ("story", "script", "script"),
    ("show(", 2): ("pattern", "show(event, over = script)", "number"),
    ("arc(", 1): ("pattern", None, "number"),
    ("pushes", 1): ("predicate", "pushes(character, thing)", "condition of a frame"),
    ("kitchen", 1): ("world", "world kitchen", ""),
    ("beta", 1): ("setting", "beta = 2", ""),
    ("starts", 1): ("setting", "starts = 500", ""),
    ("deus", 1): ("event", "deus(table)", ""),
    ("east", 1): ("action", "robot: east", ""),
    ("pink", 1): ("place", "(1, 1)", ""),
    ("event", 1): ("parameter", "event", ""),
    ("over = shown", 1): ("argument", "over = script", ""),
    ("friend]", 1): ("audience", "audience friend = bayesian(given = G_cheese = pink)", ""),
    ("P[friend]", 1): ("form", "P(event | script[:k], condition, ...)", "number over t"),
    ("given", 1): ("setting", "given = EVENT", ""),
    ("maximize", 1): ("keyword", "maximize EXPRESSION", ""),
    ("++", 1): ("operator", "script ++ [who: action, ...]", ""),
}


@pytest.mark.parametrize(("word", "number"), TYPES)
def test_what_is_said_of_a_word(word: str, number: int) -> None:
    what, signature, type_ = TYPES[word, number]
    found = told(word, number)
    assert found.type == type_
    assert found.what == what
    assert signature is None or found.signature == signature


def test_documentation_comes_with_it() -> None:
    assert told("show(", 2).documentation == "How much it is believed.\nBy everybody."
    assert "attitude toward cheese" in told("rho").documentation
    assert "something hidden that may hold" in told("event").documentation
    assert "inverse temperature" in told("beta").documentation
    text = told("P(kind").markdown()
    assert text.startswith("```story\nP(event | script[:k], condition, ...)\n```")
    assert "number over t" in text
    assert "For instance `P(rho > 0 | script[:T], G_cheese = pink)`" in text


def test_a_query_for_a_latent_is_a_distribution() -> None:
    text = "P(G_robot | script[:t])"
    found = hover(text, 0, AROUND, "expression")
    assert found is not None
    assert found.type == "distribution over G_robot over t"
    found = hover("P(rho | script[:2])", 0, AROUND, "expression")
    assert found is not None
    assert found.type == "distribution over rho"


def test_nothing_is_said_of_comments_and_numbers() -> None:
    for word in ("How much", "15", "= 1.5"):
        assert hover(STORY, place(word), AROUND) is None


def test_definitions() -> None:
    def where(word: str, number: int = 1) -> tuple[str, int] | None:
        span = definition(STORY, place(word, number), AROUND)
        if span is None:
            return None
        return Path(span.source.name).name, span.source.position(span.start)[0]

    assert where("kind", 2) == ("tale.story", 6)
    assert where("shown", 2) == ("tale.story", 5)
    assert where("friend]") == ("tale.story", 17)
    assert where("show(", 2) == ("tale.story", 11)
    assert where("event", 2) == ("", 11)
    assert where("over[") == ("", 11)
    assert where("over = shown") == ("tale.story", 11)
    name, line = where("who = ") or ("", 0)
    assert name == "arc.story"
    assert "who" in (ROOT / "stories/patterns/arc.story").read_text().splitlines()[line - 1]
    assert where("kitchen") == ("kitchen.world", 1)
    world = (ROOT / "stories/worlds/kitchen.world").read_text().splitlines()
    for word, block in (("robot", "character robot"), ("G_robot", "character robot")):
        name, line = where(word) or ("", 0)
        assert (name, world[line - 1]) == ("kitchen.world", block)
    name, line = where("pink") or ("", 0)
    assert world[line - 1] == "tile pink"
    for word in ("rho", "sum_t", "maximize", "15", "How much"):
        assert where(word) is None


def test_an_attitude_is_defined_by_whose_it_is() -> None:
    text = "world court\nmaximize depict(rho_ghost_knight > 0)\n"
    around, at = surroundings(Source("", text), ROOT, find_vocabulary), text.index("rho")
    span, found = definition(text, at, around), hover(text, at, around)
    assert span is not None
    assert found is not None
    assert span.source.text[: span.end].endswith("character ghost")
    assert found.documentation.startswith("ghost's attitude toward knight")


def test_imports_lead_to_their_file(tmp_path: Path) -> None:
    (tmp_path / "mine.story").write_text("let y = 3\n", encoding="utf-8")
    for text in ("import mine\n", 'import "mine.story"\n', "import depict\n"):
        around = surroundings(Source("x.story", text), tmp_path, find_vocabulary)
        span = definition(text, 9, around)
        assert span is not None
        assert Path(span.source.name).stem in ("mine", "depict")
    around = surroundings(Source("x.story", "import no\n"), tmp_path, find_vocabulary)
    assert definition("import no\n", 8, around) is None


def test_a_source_without_a_file_is_shown_read_only(tmp_path: Path) -> None:
    source = Source(str(tmp_path / "packed.i2plib" / "a.story"), "pattern a(x) = x\n")
    path = file_of(Span(source, 8, 9))
    assert path is not None
    assert path.read_text(encoding="utf-8") == source.text
    assert stat.S_IMODE(path.stat().st_mode) == 0o444
    assert file_of(Span(source, 0, 1)) == path
    assert file_of(Span(Source("nothing", ""), 0, 0)) is None


def test_signatures() -> None:
    def active(text: str) -> tuple[str, int | None] | None:
        found = signature_at(text, len(text), AROUND)
        return (found.signature.partition("(")[0], found.active) if found else None

    assert active("maximize show(") == ("show", 0)
    assert active("maximize show(rho > 0, ") == ("show", 1)
    assert active("maximize show(over = script, ") == ("show", 0)
    assert active("maximize [pushes(robot, ") == ("pushes", 1)
    assert active("maximize P(rho > 0 | ") == ("P", None)
    assert active("maximize show(rho > (") == ("show", 0)
    assert active("maximize ") is None


# Positions.


@given(st.text("ab\r\n🤖ρ\u2028\x0b"), st.sampled_from(["utf-8", "utf-16", "utf-32"]))
@settings(derandomize=True, deadline=None)
def test_positions_and_offsets_agree(text: str, encoding: str) -> None:
    lines = Lines(text, encoding)
    for offset in range(len(text) + 1):
        if text[offset - 1 : offset + 1] == "\r\n":
            continue  # between the two is no place of its own
        line, character = lines.position(offset)
        assert lines.offset(line, character) == offset
        assert line == text[:offset].replace("\r\n", "\n").replace("\r", "\n").count("\n")


def test_positions_in_units_of_utf_16() -> None:
    lines = Lines("a🤖b\nρ🤖c")
    assert lines.position(2) == (0, 3)
    assert lines.position(6) == (1, 3)
    assert lines.offset(0, 3) == 2
    assert lines.offset(0, 2) == 1  # inside the robot
    assert lines.offset(0, 99) == 3
    assert lines.offset(9, 0) == 7
    assert Lines("a🤖b", "utf-8").position(2) == (0, 5)
    assert Lines("a🤖b", "utf-32").position(2) == (0, 2)
