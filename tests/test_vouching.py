"""What is said of the error of additive worlds, against the error itself."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from commands_for_tests import Run
from i2pdsl.errors import Source, whole_file
from i2pdsl.objective.nearer import error_in_copy, trust_in
from i2pdsl.objective.panel import judge, panel
from i2pdsl.objective.terms import score_script
from i2pdsl.objective.trust import Copied, Trust, off_by
from i2pdsl.questions import query
from i2pdsl.render.pictures import pictures_of
from i2pdsl.results import Result
from i2pdsl.scripts import Script, script_from
from i2pdsl.search.candidates import TOLERANCE, faults
from i2pdsl.stories import Story
from i2pdsl.vouching import vouched, vouched_alone
from i2pdsl.worlds.grid import around, method
from i2pdsl.worlds.grid.kind import KIND
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.reach import steps_to
from i2pdsl.worlds.grid.reduced import reduced
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.record import parse_record
from worlds_for_tests import CROWD

STORY = "world crowd\nlength 4\nmaximize depict(rho > 0)\nsearch beam(starts = 60, polish = 1)\n"
ROOMS = """
map
    ......#.....
    .A....#.....
    ......#.....
    ##.######.##
    ......#.....
    .k....D...B.
    ......#.....
tile a
    symbol = A
tile b
    symbol = B
object key
    symbol = k
object door
    symbol = D
    opened_by = key
object box
character dog
    carries = key
    pushes = box
    goals = {a, b}
"""


def spec_of(text: str, name: str = "crowd") -> GridSpec:
    return parse_world(Source(f"{name}.world", text), name)


@cache
def solved(folder: Path) -> tuple[Story, Result]:
    (folder / "crowd.world").write_text(CROWD, encoding="utf-8")
    story = Story.from_text(STORY, folder)
    return story, story.solve(seed=0, candidates=6)


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> tuple[Story, Result]:
    return solved(tmp_path_factory.mktemp("crowd"))


def planned_exactly(script: Script) -> Script:
    """The same script, read from a file that asks for exact plans."""
    document = script.record.as_json()
    document["world"] = {**document["world"], "settings": {"method": "exact"}}
    return script_from(parse_record(Source("script.json", json.dumps(document))), None)


def test_the_figure_of_a_script_is_its_error(found: tuple[Story, Result]) -> None:
    """The largest change of a latent's probability, asked for one by one."""
    asked = [f"G_{who} = {goal}" for who, goal in (("cheese", "pink"), ("robot", "none"))]
    for script in found[1].candidates[:3]:
        exact = planned_exactly(script)
        worst = 0.0
        for event in (*asked, "rho > 0", "rho < 0"):
            ours, theirs = (s.query(f"P({event} | script[:t])") for s in (script, exact))
            worst = max(worst, float(np.abs(np.asarray(ours) - np.asarray(theirs)).max()))
        assert script.trust is not None
        assert script.trust.closer == "exact plans"
        assert script.trust.belief == pytest.approx(worst, abs=1e-6)
        assert 1e-3 < worst < 1


def test_candidates_are_put_in_order_by_the_nearer_plans(found: tuple[Story, Result]) -> None:
    story, result = found
    exact = story.with_(method="exact")
    world, order = exact.world(), []
    for script, judgement in zip(result.candidates, result.judgements, strict=True):
        frames = planned_exactly(script).frames
        score = float(score_script(exact.typed, world, frames))
        assert script.trust.score == pytest.approx(score, abs=1e-6)
        assert script.score != pytest.approx(score, abs=1e-4)
        (judged,) = judge(exact.typed, panel(exact.typed, world), [script.trajectory], [frames])
        assert judgement.mean == pytest.approx(judged.mean, abs=1e-6)
        order.append((score, score + judged.mean, faults(world, script.trajectory.states)))
    best = max(score for score, *_ in order)
    # What lacks nothing of a film, and is not much worse than the best, comes first.
    keys = [
        (lacks + (score < best - TOLERANCE * abs(best)), -votes) for score, votes, lacks in order
    ]
    assert len(keys) > 2
    assert keys == sorted(keys)


def test_a_doubtful_script_is_said_to_be_so(found: tuple[Story, Result]) -> None:
    story, result = found
    for script in result.candidates:
        told = [d for d in story.doubts(script) if d.code == "untrusted"]
        assert bool(told) == (script.trust.belief > 0.1) == (script.trust.is_trusted is False)
        for warning in told:
            assert warning.severity == "warning"
            assert warning.span.text == "world crowd"
            assert f"{script.trust.belief:.2g}" in warning.message


def test_where_nothing_else_fits_plans_are_exact_around_the_scripts(
    found: tuple[Story, Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Around all candidates, or around the best one alone; their figures are near to the true."""
    story, result = found
    monkeypatch.setattr(method, "PATIENCE_TO_JUDGE", 0.0)
    task = story.task()
    held = vouched(story.typed, task.world, result.candidates, task.watch)
    assert held.world is not task.world
    for script, ours in zip(result.candidates, held.scripts, strict=True):
        assert ours.trust.closer == "plans that are exact around the script"
        assert ours.trust.belief == pytest.approx(script.trust.belief, abs=0.25)
        assert ours.trust.score == pytest.approx(script.trust.score, abs=0.5)
    monkeypatch.setattr(around, "PATIENCE", 0.0)
    nothing = vouched(story.typed, task.world, result.candidates, task.watch)
    assert nothing.world is task.world
    assert [s.trust.belief for s in nothing.scripts] == [None] * len(result.candidates)
    assert (
        vouched_alone(story.typed, task.world, nothing.scripts[0], task.watch).trust.belief is None
    )
    monkeypatch.setattr(around, "PATIENCE", 60.0)
    alone = vouched_alone(story.typed, task.world, nothing.scripts[0], task.watch)
    assert alone.trust.belief == pytest.approx(result.script.trust.belief, abs=0.25)


def test_an_answer_is_held_against_the_same_by_nearer_plans(
    found: tuple[Story, Result], tmp_path: Path, i2p: Run
) -> None:
    """Of a script from its file, of which nothing was known."""
    script, asked = found[1].script, "P(rho > 0 | script[:t])"
    path = script.save(tmp_path / "script.json")
    again = Script.load(path)
    assert again.trust is None
    assert again.record.error["trust"]["belief"] == script.trust.belief
    worst = np.abs(again.query(asked) - planned_exactly(script).query(asked)).max()
    for each in (script, again):
        trust = each.ask(asked).trust
        assert trust.answer == pytest.approx(worst, abs=1e-6)
        assert trust.belief == pytest.approx(script.trust.belief, abs=1e-9)
    assert script.ask("T + 1").trust is None
    assert planned_exactly(script).ask(asked).trust is None
    told = json.loads(i2p("query", str(path), asked, "--json").out)
    assert told["trust"]["answer"] == pytest.approx(worst, abs=1e-6)
    assert f"this is off by {worst:.2g}" in i2p("query", str(path), asked).err
    assert json.loads(i2p("explain", str(path), "--json").out)["trust"]["closer"] == "exact plans"
    (of_table,) = query([script, again], asked).trust()
    assert of_table.answer == pytest.approx(worst, abs=1e-6)
    assert of_table.belief == pytest.approx(script.trust.belief, abs=1e-9)
    # What a file says of its error is kept, and never believed.
    again.save(path)
    assert Script.load(path).record.error == again.record.error
    assert "trust" not in json.loads(planned_exactly(script).save(path).read_text())


def test_answers_that_are_alike_are_not_off() -> None:
    one = np.array([1.0, np.inf, np.nan, -np.inf])
    assert off_by(one, one.copy()) == 0
    assert off_by(one, np.array([0.75, np.inf, np.nan, -np.inf])) == 0.25
    assert off_by(one, np.array([1.0, 2.0, np.nan, -np.inf])) == np.inf
    assert off_by(np.zeros(0), np.zeros(0)) == 0
    assert Trust("x", "y", 0.0, np.inf, None, answer=np.inf).as_json()["score"] is None


def test_the_page_says_how_right_it_is(found: tuple[Story, Result]) -> None:
    script = found[1].script
    page = pictures_of([script]).page()
    assert f"beliefs within {script.trust.belief:.2g} of those by exact plans" in page
    assert "exact plans" not in pictures_of([planned_exactly(script)]).page()


def test_without_anything_nearer_nothing_is_claimed() -> None:
    trust = Trust("additive", "exact plans would take 43.0 GiB", None, None, None)
    assert trust.is_trusted is None
    assert trust.warnings(whole_file("x")) == ()
    assert "not known: exact plans would take" in trust.in_words()
    copied = Copied("a copy", 64, 0.5, 1.0)
    assert Trust("additive", "exact plans", 0.1, 3.0, copied).is_trusted
    assert Trust("additive", "exact plans", 0.2, 3.0, copied).is_trusted is False
    assert Trust("additive", "exact plans", 0.2, 3.0, copied).as_json()["copy"]["mean"] == 0.5


def test_the_error_in_a_copy_is_that_of_its_plans() -> None:
    """None where both are planned alike; with more at once it is less."""
    crowd = spec_of(CROWD)
    exact = crowd.with_settings({"method": "exact"})
    assert error_in_copy(exact, exact) == (0.0, 0.0)
    two, three = (error_in_copy(crowd.with_settings({"at_once": n}), exact) for n in (2, 3))
    assert 0 < three[0] < two[0] < 1
    assert three[0] < three[1] <= 1


def test_what_is_nearer_to_exact_plans(monkeypatch: pytest.MonkeyPatch) -> None:
    crowd = spec_of(CROWD)
    assert method.approximation(crowd.with_settings({"method": "exact"})) is None
    two = method.approximation(crowd.with_settings({"at_once": 2}))
    assert two.closer.settings.at_once == 3
    assert two.closer_method == "3 at once"
    assert two.told == "a copy with 6 of 6 cells"
    three = method.approximation(crowd)
    assert three.closer.settings.method == "exact"
    assert three.closer_method == "exact plans"
    monkeypatch.setattr(method, "memory_limit", lambda: 0)
    nothing = method.approximation(crowd)
    assert nothing.closer is None
    assert "exact plans would take" in nothing.closer_method


def test_worlds_say_that_they_are_additive() -> None:
    crowd = spec_of(CROWD)
    exact = crowd.with_settings({"method": "exact"})
    assert KIND.in_words(crowd)[-1] == "planned additively, 3 at once: beliefs are approximate"
    assert KIND.in_words(exact) == KIND.in_words(crowd)[:-1]
    told = KIND.as_json(crowd)
    assert (told.pop("method"), told.pop("at_once")) == ("additive", 3)
    assert told == KIND.as_json(exact)
    trust = trust_in(crowd, Watch())
    assert trust.is_trusted is None
    assert trust.in_words() == f"additive, 3 at once; in {trust.copied.in_words()}"
    assert trust.copied.mean == error_in_copy(*method.approximation(crowd).copy)[0] > 0
    assert trust_in(exact, Watch()) is None


def test_copies_keep_goals_doors_and_ways() -> None:
    spec = spec_of(ROOMS)
    small = reduced(spec, lambda each: len(each.free_cells) <= 16)
    assert small is not None
    assert 7 <= len(small.free_cells) <= 16
    assert [len(tile.cells) for tile in small.tiles] == [1, 1]
    assert [len(thing.cells) for thing in small.things] == [1, 1, 0]
    for kept in (*small.tiles, *small.things):
        assert set(kept.cells) <= set(small.free_cells)
    inside = steps_to(small.tiles[0].cells, set(small.free_cells))
    assert set(inside) == set(small.free_cells)  # the two rooms are still joined
    assert small.characters == spec.characters
    assert reduced(spec, lambda each: len(each.free_cells) <= 5) is None
    assert reduced(small, lambda each: True) == small
