"""Stories with a hole: what is put into it is reported where it stands, and nothing else."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest

from i2pdsl.errors import Diagnostic, Source, StoryError
from i2pdsl.language.check import check_source
from i2pdsl.worlds.find import find_vocabulary

STORY = """\
# A story with a hole.
world kitchen
length 15
start {start}
allow {event}

let shown = script ++ [cheese: {action}, robot: east]
let turn = {number}

# Believes it more and more.
pattern fade(event, over = script) =
    sum_t (t / T * P(event | {script}))

maximize fade({latent} > 0)
maximize fade(G_cheese = {value}, over = shown)
maximize twist(rho > 0,
               rho < 0,
               {turn})
minimize sum_t {term}
search beam(starts = {starts})
"""
RIGHT = {
    "start": "absent(table)",
    "event": "deus(table)",
    "action": "stay",
    "number": "T/2",
    "script": "over[:t]",
    "latent": "rho",
    "value": "pink",
    "turn": "turn",
    "term": "E[V(robot) | script[:t]]",
    "starts": "100",
}
WRONG = [
    # hole, what is put in, where the mistake starts in it, code
    ("start", "absent(robot)", "robot", "no-object"),
    ("start", "moved(robot)", "moved", "predicate"),
    ("start", "at(robot, blue)", "blue", "no-place"),
    ("start", "at(robot, (3, 0))", "(3", "no-place"),
    ("start", "rho > 0", "rho", "hidden"),
    ("event", "deus(robot)", "deus", "no-event"),
    ("event", "table", "table", "no-event"),
    ("action", "fly", "fly", "no-action"),
    ("action", "stay!", "cheese", "turn"),
    ("number", "T/0", "T/0", "arithmetic"),
    ("number", "T/half", "half", "unknown-name"),
    ("number", "2 T", "T", "syntax"),
    ("script", "over[t]", "over", "type"),
    ("script", "over[:t+2]", "t+2", "index"),
    ("script", "ovre[:t]", "ovre", "unknown-name"),
    ("latent", "roh", "roh", "unknown-name"),
    ("latent", "G_cheese", "G_cheese", "compare"),
    ("value", "blue", "blue", "no-value"),
    ("value", "3", "3", "compare"),
    ("turn", "turning", "turning", "unknown-name"),
    ("turn", "rho = 2", "rho", "hidden"),
    ("turn", "turn, 1 = 1, 0, 0, 3", "3", "arguments"),
    ("term", "V(robot)", "V", "value"),
    ("term", "E[V(table) | script[:t]]", "table", "no-character"),
    ("term", "P(rho > 0)", "P", "no-script"),
    ("term", "KL(script[:t])", "KL", "divergence"),
    ("term", "P(G_robot | script[:t])", "G_robot", "distribution"),
    ("term", "P(rho > 0 | script[:t], rho > 3)", "rho > 3", "impossible"),
    ("term", "P(rho > 0 | script[:t]", "(", "bracket"),
    ("term", "sum_t P(rho > 0 | script[:t])", "sum_t", "nested-sum"),
    ("term", "[at(robot) @ script[t]]", "at", "arguments"),
    ("term", "1/(t - 3)", "1/", "arithmetic"),
    ("term", "P(t > 3 | script[:t])", "t >", "time-in-event"),
    ("term", "depcit(rho > 0)", "depcit", "unknown-pattern"),
    ("term", "1e999", "1e999", "number"),
    ("term", "P", "P", "syntax"),
    ("starts", "0", "0", "setting"),
    ("starts", "many", "many", "unknown-name"),
]


def filled(holes: dict[str, str]) -> str:
    text = STORY
    for hole, value in holes.items():
        text = text.replace("{" + hole + "}", value)
    return text


def mistakes(text: str) -> list[Diagnostic]:
    with pytest.raises(StoryError) as caught:
        check_source(Source("hole.story", text), find_vocabulary, Path("nowhere"))
    return list(caught.value.diagnostics)


def test_the_story_without_a_bug_is_right() -> None:
    check_source(Source("hole.story", filled(RIGHT)), find_vocabulary, Path("nowhere"))


@pytest.mark.parametrize(("hole", "bug", "at", "code"), WRONG, ids=[w[1] for w in WRONG])
def test_one_bug_is_one_message_at_its_place(hole: str, bug: str, at: str, code: str) -> None:
    before = filled({k: v for k, v in RIGHT.items() if k != hole})
    start = before.index("{" + hole + "}")
    if at == "cheese":  # the whole move is wrong
        start = before.index("cheese: {action}")
    else:
        start += bug.index(at)
    text = filled({**RIGHT, hole: bug})
    found = mistakes(text)
    assert [(d.code, d.span.start) for d in found] == [(code, start)]
    line = text.count("\n", 0, start) + 1
    column = start - text.rfind("\n", 0, start)
    assert found[0].render().startswith(f"hole.story:{line}:{column}: error[{code}]: ")


def test_all_independent_bugs_are_reported_in_one_go() -> None:
    """The last bug of every hole, all in one file; `turn` is unknown only where it is no name."""
    unread = ("bracket", "syntax", "number")
    chosen = {hole: (bug, code) for hole, bug, _, code in WRONG if code not in unread}
    expected = sorted(code for _, code in chosen.values())
    found = mistakes(filled({**RIGHT, **{hole: bug for hole, (bug, _) in chosen.items()}}))
    assert sorted(d.code for d in found) == expected
    assert [d.span.start for d in found] == sorted(d.span.start for d in found)


def test_a_bug_in_a_pattern_shows_the_line_that_used_it() -> None:
    text = filled({**RIGHT, "script": "over[:t+2]"})
    (first,) = mistakes(text)
    assert first.span.source.position(first.span.start)[0] == 12
    assert [n.span.text for n in first.notes] == ["fade(rho > 0)"]
    assert "used here (hole.story:14:10)" in first.render()


def test_a_bug_in_an_argument_is_reported_at_the_argument() -> None:
    text = filled({**RIGHT, "turn": "rho"})
    (first,) = mistakes(text)
    assert (first.code, first.span.text) == ("hidden", "rho")
    assert "twist.story" in first.notes[0].span.source.name
    assert first.notes[0].span.text == "turn"


@pytest.mark.parametrize("broken", ["worlds kitchen", "world (", "world kitchen length 15"])
def test_a_statement_that_cannot_be_read_is_not_called_missing(broken: str) -> None:
    found = mistakes(f"{broken}\nmaximize depict(rho > 0)\n")
    assert len(found) == 1
    assert found[0].code in ("statement", "bracket", "syntax")


def test_what_is_missing_is_said_beside_other_mistakes() -> None:
    found = mistakes("world kitchen\nlet x = 2 3\n")
    assert [d.code for d in found] == ["no-length", "no-objective", "syntax"]


@pytest.mark.parametrize("cut", range(0, len(STORY), 7))
def test_a_cut_story_has_few_messages(cut: int) -> None:
    """A story that breaks off somewhere is told so, without an avalanche."""
    text = filled(RIGHT)
    if cut >= len(text):
        return
    with suppress(StoryError):
        check_source(Source("cut.story", text[:cut]), find_vocabulary, Path("nowhere"))
        return
    assert 1 <= len(mistakes(text[:cut])) <= 3
