"""The whole language, tried on the kind of world of docs/new-world.md through the language's own
tables: what there is works, and is what plain Python says; what there is not the checker says."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from commands_for_tests import Run
from corridor_for_tests import FORMS, STEPS, Watched, corridor
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.builtins import FORMS as WORDS
from i2pdsl.language.builtins import FUNCTIONS, STATEMENTS
from i2pdsl.language.forms import BELIEFS, EXPECTED, HIDDEN, Form, Word
from i2pdsl.repl.examples import in_words_of
from i2pdsl.repl.session import Session
from i2pdsl.scripts import Script
from i2pdsl.stories import Result, story_from
from i2pdsl.worlds.find import find_vocabulary

ABOUT = {
    "event": "G_walker = right",
    "quantity": "V(walker)",
    "latent": "G_walker",
    "character": "walker",
    "": "",
}
HEAD = 'world "hall.world"\nlength 4\nstart in_light(walker)\n'
ALL = "search beam(width = 300)\n"  # as wide as there are scripts


def asked(form: Form) -> str:
    """A form as it is asked of the corridor at each t."""
    written = form.shape.written(form.name, ABOUT[form.about])
    if form.shape is HIDDEN:
        (around,) = (each for each in BELIEFS if each.shape is EXPECTED)
        written = EXPECTED.written(around.name, written)
    return written


WISHED = [form for form in BELIEFS if not form.is_table and form.shape is not HIDDEN]
EVERYTHING = f"{HEAD}{ALL}maximize sum_t ({' + '.join(map(asked, WISHED))})\n"
STATED = """\
world "hall.world"(beta = 1.5)
length 4
start in_light(walker)
import twist
let shown = G_walker = right
pattern seen(event) = sum_t P(event | script[:t])
maximize seen(shown)
minimize entropy(G_walker | script[:T])
assume nothing
rationality 2
plausibility 2
luck 2
naturalness 0.5
liveliness 0
audience bayesian(prior(G_walker) = {left: 3, right: 1})
require eventually [at(walker, left)] and never [idle(walker)]
require [moved(walker)] before [at(walker, left)]
pin script[3]: not at(walker, (0, 0))
pin script[1] = [walker: east]
search beam(width = 300)
"""


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with corridor(tmp_path_factory.mktemp("corridor")) as folder:
        (folder / "everything.story").write_text(EVERYTHING, encoding="utf-8")
        yield folder


@pytest.fixture(scope="module")
def found(hall: Path) -> Result:
    """The best script of a story that wishes for every form at once."""
    return story_from(Source("everything.story", EVERYTHING), hall).solve(seed=0)


@pytest.fixture
def saved(found: Result, tmp_path: Path) -> Path:
    return found.script.record.save(tmp_path / "script.json")


def watched(script: Script, **changes: object) -> Watched:
    names = [tuple(STEPS)[int(action)] for action in script.trajectory.actions]
    return Watched(names, int(script.trajectory.states[0]), **changes)  # type: ignore[arg-type]


def walks(**changes: object) -> Iterator[Watched]:
    for actions in product(STEPS, repeat=4):
        yield Watched(actions, **changes)  # type: ignore[arg-type]


# ------------------------------------------------------------------------------------------- forms


@pytest.mark.parametrize("form", BELIEFS, ids=lambda form: form.name)
def test_every_form_is_what_plain_python_says(found: Result, form: Form) -> None:
    """A form that is added to the table is asked here, and lacks its transcription."""
    answer, walk = found.script.ask(asked(form)), watched(found.script)
    assert answer.t is not None
    assert answer.t[-1] == walk.last
    expected = [FORMS[form.name](walk, t) for t in answer.t]
    assert np.allclose(answer.value, expected, rtol=1e-9, atol=1e-12)


def test_a_search_for_all_forms_finds_what_brute_force_finds(found: Result) -> None:
    def worth(walk: Watched) -> float:
        each = (FORMS[form.name](walk, t) for form in WISHED for t in range(1, walk.last + 1))
        return sum(each) - walk.film()  # type: ignore[arg-type]

    assert found.score == pytest.approx(max(map(worth, walks())), abs=1e-6)
    assert found.score == pytest.approx(worth(watched(found.script)), abs=1e-9)


@pytest.mark.parametrize("form", [f for f in BELIEFS if f.tabulates], ids=lambda form: form.name)
def test_tables_are_for_queries(hall: Path, found: Result, form: Form) -> None:
    about = "walker" if form.is_table else "G_walker"
    table = f"{form.name}({about} | script[:t])"
    value = found.script.query(table)
    assert value.shape == (5, 3 if form.is_table else 2)
    assert np.allclose(value.sum(1), 1)
    with pytest.raises(StoryError) as wrong:
        story_from(Source("s.story", f"{HEAD}maximize sum_t {table}\n"), hall)
    assert [d.code for d in wrong.value.diagnostics] == ["distribution"]


EVERY = [*WORDS, *FUNCTIONS.values()]
REFUSED = {
    "script": "type",  # a script is no question
    "T": "type",
    "P": "unknown-name",  # there is no `rho` beside another latent
    "eventually": "unknown-pattern",  # nobody pushes
    "when": "unknown-pattern",
    "++": "turn",  # one walker does not act twice
    "and": "unknown-name",
    "log": "arithmetic",  # at t = 0
    "believes": "no-character",
}
"""Words whose examples say something that the corridor has not, and what is said about it."""


@pytest.mark.parametrize("word", EVERY, ids=lambda word: word.name)
def test_every_word_is_answered_or_refused(hall: Path, found: Result, word: Word) -> None:
    """The table's example of a word, in the corridor's own names as far as it has some."""
    words = find_vocabulary("hall.world", hall)
    assert words is not None
    question = in_words_of(word.example, words) or word.example
    if word.name not in REFUSED:
        assert np.isfinite(found.script.query(question)).all()
        return
    with pytest.raises(StoryError) as wrong:
        found.script.query(question)
    (first, *_) = wrong.value.diagnostics
    assert first.code == REFUSED[word.name]
    assert first.span.text in question


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ("beta = 1", {"beta": 1.0}),
        ("sharpness = 2", {"sharpness": 2.0}),
        ("forgetting = 0.1, switching = 0.2", {"forgetting": 0.1, "switching": 0.2}),
        ("prior(G_walker) = {left: 4, right: 1}", {"prior": (0.8, 0.2)}),
        ("given = G_walker = left, forgetting = 0.1", {"prior": (1.0, 0.0)}),
    ],
)
def test_other_audiences(hall: Path, settings: str, told: dict[str, object]) -> None:
    """Who knows something never forgets it."""
    text = f"{HEAD}audience bayesian({settings})\nmaximize depict(G_walker = left)\n"
    script = story_from(Source("s.story", text), hall).solve(seed=0, naive=True).script
    believed = script.query("P(G_walker = right | script[:t])")
    expected = [belief["right"] for belief in watched(script, **told).beliefs]
    assert np.allclose(believed, expected, atol=1e-12)


# -------------------------------------------------------------------------------------- statements


def test_a_story_of_all_statements_finds_what_brute_force_finds(hall: Path) -> None:
    told = {line.split()[0] for line in STATED.splitlines()}
    assert told | {"allow"} == {word.name for word in STATEMENTS}  # there is nothing to allow
    result = story_from(Source("s.story", STATED), hall).solve(seed=0)
    best = -np.inf
    for walk in walks(beta=1.5, prior=(0.75, 0.25)):
        first = walk.cells[1:].index(0) if 0 in walk.cells[1:] else 0
        if "stay" in walk.actions or walk.actions[0] != "east" or walk.cells[3] == 0 or not first:
            continue
        score = sum(walk.beliefs[t]["right"] for t in range(1, 5)) - walk.entropy(4)
        best = max(best, score - walk.film(0.5, 0))
    assert not result.unmet
    assert result.score == pytest.approx(best, abs=1e-6)


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("allow deus(lamp)", "no-event"),
        ("audience particles(count = 50)", "audience"),
        ("search descend", "search"),
        ("search naive(noise = 0.1)", "setting"),
        ("pin script[1] = [walker: east!]", "turn"),
        ('pin script[1] = "take.json"', "keep"),
        ("pin script[1] = [walker: north]", "no-action"),
        ("require eventually [pushes(walker, walker)]", "unknown-pattern"),
        ("start at(walker, (7, 0))", "no-place"),
        ("assume R_walker", "unknown-name"),
    ],
)
def test_what_there_is_not_is_said_by_the_checker(hall: Path, line: str, code: str) -> None:
    with pytest.raises(StoryError) as wrong:
        story_from(Source("s.story", f"{HEAD}{line}\nmaximize depict(G_walker = left)\n"), hall)
    (first, *_) = wrong.value.diagnostics
    assert first.code == code
    assert first.span.text in line


# ---------------------------------------------------------------------------------------- commands


def test_commands(hall: Path, saved: Path, tmp_path: Path, i2p: Run) -> None:
    story, world = hall / "everything.story", hall / "hall.world"

    def right(*arguments: str | Path) -> str:
        done = i2p(*arguments)
        assert done.status == 0, done.err
        return done.out or done.err

    assert "no mistakes" in right("check", story, world)
    assert right("fmt", "--check", world) == ""
    assert "character walker: west, east, stay" in right("worlds", world)
    assert json.loads(right("worlds", world, "--json"))["states"] == 5
    right("run", story, "--format", "png,svg", "--out", tmp_path / "out")
    names = {path.name for path in (tmp_path / "out" / "everything").iterdir()}
    assert names == {"script.json", "comic.png", "mind.png", "comic.svg", "mind.svg"}
    right("render", saved, "--format", "png", "--out", tmp_path / "drawn")
    right("sheet", story, "--candidates", "2", "--out", tmp_path / "sheet")
    assert (tmp_path / "sheet" / "sheet.png").is_file()
    walk = watched(Script.load(saved))
    told = right("query", saved, "suspense(G_walker | script[:2])")
    assert float(told) == pytest.approx(walk.suspense(2), rel=1e-5)
    document = json.loads(right("query", saved, "next(walker | script[:t])", "--json"))
    for t, row in enumerate(document["value"]):
        assert row == pytest.approx(dict(zip(STEPS, walk.next(t), strict=True)))
    reasons = json.loads(right("explain", saved, "--json"))["reasons"]
    for t, reason in enumerate(reasons, 1):
        before, cell = walk.beliefs[t - 1], walk.cells[t - 1]
        likely = {a: walk.expected(before, cell, a) for a in STEPS if a != reason["action"]}
        assert reason["action"] == walk.actions[t - 1]
        assert reason["expected"] == pytest.approx(walk.expected(before, cell, reason["action"]))
        assert reason["instead_expected"] == pytest.approx(max(likely.values()))
        effect = next(e for e in reason["effects"] if e["event"] == "G_walker = right")
        assert effect["after"] == pytest.approx(walk.beliefs[t]["right"])
        instead = walk.after(before, cell, reason["instead"])["right"]
        assert effect["instead"] == pytest.approx(instead)
    assert "walker" in right("explain", saved)
    for command in ("plan", "train"):
        assert i2p(command, world).status == 1


def test_a_table_of_positions_is_a_script(hall: Path, tmp_path: Path, i2p: Run) -> None:
    table, script = tmp_path / "seen.csv", tmp_path / "seen.json"
    table.write_text("frame,who,x,y\n0,walker,2,0\n1,walker,1,0\n2,walker,1,0\n", encoding="utf-8")
    assert i2p("script", hall / "hall.world", table, "--out", script).status == 0
    walk = Watched(("west", "stay"))
    believed = Script.load(script).query("P(G_walker = right | script[:t])")
    assert np.allclose(believed, [belief["right"] for belief in walk.beliefs])
    table.write_text("frame,who,x,y\n0,walker,2,0\n1,walker,0,0\n", encoding="utf-8")
    done = i2p("script", hall / "hall.world", table, "--out", script)
    assert done.status == 1
    assert "cannot get from [2, 0] to [0, 0]" in done.err


def test_in_the_repl(hall: Path, found: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(hall)
    session = Session()

    def right(line: str) -> object:
        reply = session.run(line)
        assert not reply.diagnostics, reply.diagnostics[0].render()
        return reply.shown

    right('world "hall.world"')
    right("start at(walker, (2, 0))")
    (hint,) = (d.hint for d in session.run("play").diagnostics)
    assert hint == "`play WHO ACTION`"
    (wrong,) = session.run("play walker wset").diagnostics
    assert (wrong.code, wrong.span.text, wrong.hint) == (
        "no-action",
        "wset",
        "did you mean `west`?",
    )
    for line in ("play walker west", "show", "why 1", "suggest 1 P(G_walker = right | script[:T])"):
        right(line)
    assert session.state.suggestions[0].told == "[walker: east]"
    right("accept")
    right("pin 2")
    pinned = [part.text for part in session.state.program.parts if part.text.startswith("pin")]
    assert pinned == ["pin script[2]: at(walker, (2, 0))", "pin script[2] = [walker: east]"]
    right("next(walker | script[:T])")
    right("load everything.story")
    right("solve")
    assert session.state.score == pytest.approx(found.score)


def test_its_files(hall: Path) -> None:
    """What a file says of viewers they think; what is wrong in it is said with its place."""
    name = hall / "long.world"
    good = "kind = corridor\naudience\n    beta = 1\n    prior(G_walker) = {left: 3, right: 1}\n"
    name.write_text(good, encoding="utf-8")
    story = (
        'world "long.world"\nlength 2\nstart in_light(walker)\nmaximize depict(G_walker = left)\n'
    )
    script = story_from(Source("s.story", story), hall).solve(seed=0, naive=True).script
    believed = script.query("P(G_walker = right | script[:t])")
    expected = [b["right"] for b in watched(script, beta=1.0, prior=(0.75, 0.25)).beliefs]
    assert np.allclose(believed, expected)
    name.write_text(good.replace("beta = 1", "bta = 1\n    forgetting = 2"), encoding="utf-8")
    with pytest.raises(StoryError) as wrong:
        story_from(Source("s.story", story), hall)
    assert [(d.code, d.span.text) for d in wrong.value.diagnostics] == [
        ("world-key", "bta"),
        ("world-range", "2"),
    ]


@pytest.mark.parametrize(
    ("was", "becomes", "message"),
    [
        ('"action": "east"', '"action": "up"', "there is no action `up` of `walker`"),
        ('"moved": true', '"moved": false', r"by the world's rules `\w+` of `walker` moves there"),
        ('"walker": [2, 0]', '"walker": [7, 0]', "cannot stand at"),
        ('"walker": [2, 0]', '"walkr": [2, 0]', "there is no `walkr`"),
        ('"walker": [2, 0]', '"walker": 2', "written .column, row."),
    ],
)
def test_scripts_that_break_the_rules(
    hall: Path, saved: Path, was: str, becomes: str, message: str
) -> None:
    text = saved.read_text(encoding="utf-8")
    assert was in text
    saved.write_text(text.replace(was, becomes, 1), encoding="utf-8")
    with pytest.raises(StoryError) as wrong:
        Script.load(saved)
    assert re.search(message, wrong.value.diagnostics[0].message)
