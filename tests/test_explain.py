"""Why viewers believe it: numbers against the reference's transcription and against each other,
words against numbers, on maps and in a plane."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from html import escape
from itertools import pairwise
from pathlib import Path
from random import Random

import numpy as np
import pytest

import reference
from commands_for_tests import Run
from i2pdsl.errors import Source
from i2pdsl.explain import Reason, as_story, course, explain, questions_of, windows
from i2pdsl.language.check import default_assumption
from i2pdsl.language.scope import Module
from i2pdsl.objective.replay import replay
from i2pdsl.objective.subjects import subjects_of
from i2pdsl.render.pictures import pictures_of
from i2pdsl.render.reasons import account_of, reasons_in_words
from i2pdsl.scripts import Script, make_record
from i2pdsl.worlds.plane.world import build_plane
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import World
from plane_for_tests import DESK, PAIR, wandered
from worlds_for_tests import Pair, small_kitchen

T = 6
ASKED = "maximize P(rho > 0 | script[:T], G_cheese = pink) + P(G_cheese = green | script[:T])\n"


def script_in(world: World, path: Trajectory) -> Script:
    frames = replay(world, path.states, path.actions)
    record = make_record(world, path, {}, {}, None)
    module, assumption = Module(Source("test", "")), default_assumption(world.vocabulary)
    return Script(record, world, path, module, assumption, frames)


@pytest.fixture(scope="module")
def pair() -> Pair:
    return small_kitchen(("P.", ".G", ".."))


@pytest.fixture(scope="module")
def asked(pair: Pair) -> Script:
    """A random script, with what a story would ask of it."""
    script = script_in(pair.world, pair.random_script(Random(4), T, events=0.2))
    story = pair.story(f"world kitchen\nlength {T}\n{ASKED}")
    return replace(script, subjects=subjects_of(story))


def test_questions_are_what_the_story_asks_in_its_own_language(asked: Script) -> None:
    words, found = asked.world.vocabulary, questions_of(asked)
    told = [(as_story(words, q.claims or {}), as_story(words, q.condition or {})) for q in found]
    assert told == [("rho > 0", "G_cheese = pink"), ("G_cheese = green", "")]
    for question, (event, given) in zip(found, told, strict=True):
        behind = f", {given}" if given else ""
        expected = asked.query(f"P({event} | script[:t]{behind})")
        np.testing.assert_allclose(course(asked, question), expected, atol=1e-12)


def test_ratios_and_other_actions_are_those_of_the_reference(pair: Pair, asked: Script) -> None:
    """In plain Python: a mixture of policies for each side, and Bayes' rule for another action."""
    world, document = pair.reference, pair.document(asked.trajectory)
    sides = (
        (lambda h: h.get("rho", 0) > 0, [lambda h: h.get("G_cheese") == "pink"]),
        (lambda h: h.get("G_cheese") == "green", []),
    )
    reasons = explain(asked, questions_of(asked))
    seen = [
        (t, *each) for t in range(1, T + 1) for each in world.beliefs_before(document, t)
    ]  # an event has none
    acts = [reason for reason in reasons if reason.who]
    assert [(r.first, r.who, r.taken and r.taken.action) for r in acts] == [s[:3] for s in seen]
    for reason, (_, who, action, state, belief) in zip(acts, seen, strict=True):
        assert reason.taken is not None
        assert reason.second is not None

        def likelihood(condition, act, who=who, state=state, belief=belief):
            within = reference.given(world, belief, condition)
            policies = {i: world.policy(who, world.hypotheses[i], state) for i in within}
            return sum(p * policies[i][act] for i, p in within.items())

        expected = {act: likelihood([], act) for act in ("north", "south", "east", "west", "stay")}
        assert reason.taken.expected == pytest.approx(expected.pop(action), rel=1e-6)
        assert reason.second.expected == pytest.approx(max(expected.values()), rel=1e-6)
        other = world.update(belief, who, state, reason.second.action)
        for effect, (event, condition) in zip(reason.effects, sides, strict=True):
            apart = likelihood([event, *condition], action) / likelihood(
                [lambda h, event=event: not event(h), *condition], action
            )
            assert math.exp(effect.log_ratio) == pytest.approx(apart, rel=1e-5)
            changed = reference.given(world, other, condition)
            answer = sum(p for i, p in changed.items() if event(world.hypotheses[i]))
            assert effect.instead == pytest.approx(answer, abs=1e-7)


def test_without_forgetting_ratios_are_the_steps_of_the_log_odds(asked: Script) -> None:
    tables = asked.world.tables
    world = asked.world.with_audience(1.0, np.zeros(1), tables.log_prior)
    script = replace(
        asked,
        world=world,
        frames=replay(world, asked.trajectory.states, asked.trajectory.actions),
    )
    reasons = [r for r in explain(script, questions_of(script)) if r.who]
    assert reasons
    for reason in reasons:
        for effect in reason.effects:
            moved = _log_odds(effect.after) - _log_odds(effect.before)
            assert effect.log_ratio == pytest.approx(moved, abs=1e-6)
            mixed = sum(r.share * math.exp(-r.log_ratio) for r in effect.rivals)
            assert mixed == pytest.approx(math.exp(-effect.log_ratio), rel=1e-9)


def _log_odds(p: float) -> float:
    return math.log(p / (1 - p))


@pytest.mark.parametrize("spec", [DESK, PAIR], ids=lambda spec: spec.name)
def test_motion_is_told_by_windows_that_add_up(spec: object) -> None:
    world = build_plane(replace(spec, settings=DESK.settings), None)  # type: ignore[type-var]
    states, actions = wandered(world, 30, spread=0.1)
    script = script_in(world, Trajectory(actions, states))
    questions = questions_of(script)  # of no story: the values of all latents
    reasons = explain(script, questions)
    assert [t for r in reasons for t in range(r.first, r.last + 1)] == list(range(1, 31))
    assert all(r.who is r.taken is r.second is None for r in reasons)
    for number, question in enumerate(questions):
        believed = course(script, question)
        total = sum(r.effects[number].log_ratio for r in reasons)
        moved = _log_odds(believed[-1]) - _log_odds(believed[0])
        assert total == pytest.approx(moved, abs=1e-6)
    told = reasons_in_words(script)
    assert "no second-best action is told" in told
    assert "had it been" not in told


@pytest.mark.parametrize("length", [1, 5, 12, 13, 800])
def test_windows_cover_a_script_once(length: int) -> None:
    found = windows(length)
    assert [t for a, b in found for t in range(a, b + 1)] == list(range(1, length + 1))
    sizes = {b - a for a, b in found}
    assert max(sizes) - min(sizes) <= 1


def test_words_go_the_way_that_beliefs_go(asked: Script) -> None:
    """What is likelier if one believes it is believed more afterwards."""
    rises = []
    for frame in range(1, T + 1):
        lines = reasons_in_words(asked, frame).splitlines()
        for line, change in pairwise(lines):
            if "times likelier " in line:
                claim, _, numbers = change.strip().partition(": ")
                before, after = map(float, numbers.split(";")[0].split(" -> "))
                rises.append(after > before)
                assert (
                    f"likelier if {claim} than" in line if rises[-1] else f"than if {claim}" in line
                )
    assert len(rises) > T
    assert len(set(rises)) == 2


def test_the_page_tells_every_change(asked: Script) -> None:
    page, account = pictures_of([asked]).page(), account_of(asked)
    assert account is not None
    told = [(seen.first, change) for seen in account.observations for change in seen.changes]
    assert len({frame for frame, _ in told}) > 2
    for frame, change in told:
        item = page.partition(f'<li data-first="{frame}" ')[2].partition('<li data-first="')[0]
        assert escape(change.claim) in item
        assert escape(change.ratio) in item


def test_an_event_is_nobodys_deed(pair: Pair) -> None:
    """Viewers learn nothing from what falls."""
    scripts = (pair.random_script(Random(seed), 3, events=1.0) for seed in range(20))
    path = next(p for p in scripts if (p.actions >= pair.world.turn_count).any())
    script = script_in(pair.world, path)
    frame = int(np.flatnonzero(path.actions >= pair.world.turn_count)[0]) + 1
    (reason,) = explain(script, questions_of(script), frame)
    assert reason == Reason(frame, frame, None, None, None, ())
    assert "table falls from the sky: nobody's deed" in reasons_in_words(script, frame)


def test_the_command(asked: Script, tmp_path: Path, i2p: Run) -> None:
    path = asked.save(tmp_path / "script.json")
    said = i2p("explain", path, "--frame", "2")
    assert said.status == 0
    assert "frame 2\n" in said.out
    assert "frame 1\n" not in said.out
    document = json.loads(i2p("explain", path, "--json").out)
    assert document["script"] == str(path)
    assert {q["event"] for q in document["questions"]} > {"rho > 0", "G_cheese = pink"}
    assert {r["first"] for r in document["reasons"]} == set(range(1, T + 1))
    refused = i2p("explain", path, "--frame", "7")
    assert refused.status == 2
    assert "the script has 6 frames, not 7" in refused.err
