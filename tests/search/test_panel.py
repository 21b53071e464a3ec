"""The panel: other viewers than the story's, and what they make of candidates."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from i2pdsl.errors import Source
from i2pdsl.objective.panel import DOUBT, MEMBERS, SHARPER, judge, panel
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script
from i2pdsl.search.candidates import TOLERANCE, faults
from i2pdsl.stories import Story, story_from
from i2pdsl.worlds.plane.kind import PlaneKind
from i2pdsl.worlds.plane.world import build_plane
from i2pdsl.worlds.ready import ready_world
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import Viewer
from plane_for_tests import DESK, wandered
from worlds_for_tests import with_small_world

TEXT = (
    "world small\nlength 5\nmaximize sum_t P(rho > 0 | script[:t])\n"
    "search beam(starts = 60, polish = 1)\n"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return with_small_world(tmp_path_factory.mktemp("panel"))


@pytest.fixture(scope="module")
def told(folder: Path) -> Story:
    return story_from(Source("help.story", TEXT), folder)


def test_members_differ_from_the_story_and_from_each_other(told: Story) -> None:
    world = told.world()
    members = panel(told.typed, world)
    sharp = sorted(m.sharpness for m in members)
    assert len(members) == MEMBERS
    assert sharp[0] == pytest.approx(1 / SHARPER)
    assert sharp[-1] == pytest.approx(SHARPER)
    assert np.prod(sharp) == pytest.approx(1)
    forgetting = sorted(float(m.world.forgetting(m.world.tables)[0]) for m in members)
    own = float(world.forgetting(world.tables)[0])
    assert forgetting[0] == own
    assert forgetting[-1] == pytest.approx(own + (1 - own) / told.typed.length)
    priors = np.array([m.world.log_prior(m.world.tables)[0] for m in members])
    assert np.allclose(np.exp(priors).sum(-1), 1)
    spread = np.std(priors - priors.mean(-1, keepdims=True))
    assert spread == pytest.approx(DOUBT, rel=0.25)


def test_what_a_viewer_holds_for_impossible_stays_so(folder: Path) -> None:
    text = TEXT + "audience bayesian(prior = if rho > 1 then 0 else 1)\n"
    sure = story_from(Source("sure.story", text), folder)
    world = sure.world()
    never = np.isneginf(world.log_prior(world.tables))
    for member in panel(sure.typed, world):
        prior = member.world.log_prior(member.world.tables)
        assert np.array_equal(np.isneginf(prior), never)
        assert np.exp(prior).sum() == pytest.approx(1)


def test_one_who_does_not_differ_judges_as_the_story_does(told: Story) -> None:
    """And sharpness is what a viewer with another beta has, where nobody is modelled."""
    world = told.world()
    tables = world.tables
    same = world.with_audience(1.0, world.forgetting(tables), world.log_prior(tables))
    script = told.solve(choose="score").script
    path = script.trajectory
    frames = replay(same, path.states, path.actions)
    assert score_script(told.typed, same, frames) == script.score


def test_a_sharper_viewer_is_one_of_another_beta() -> None:
    story = story_from(Source("f.story", "world fork\nlength 3\nmaximize depict(G_robot = left)\n"))
    world, path = story.world(), story.solve(choose="score").script.trajectory
    spec = story.spec
    sharp = ready_world(spec, (Viewer(spec.with_settings({"beta": 2 * spec.settings.beta})),))
    other = world.with_audience(2.0, world.forgetting(world.tables), world.log_prior(world.tables))
    expected = replay(sharp, path.states, path.actions).log_belief
    assert np.allclose(replay(other, path.states, path.actions).log_belief, expected, atol=1e-9)


def test_judgements_are_the_objective_before_each_member(told: Story) -> None:
    found = told.solve(seed=0, candidates=2)
    script, judgement = found.script, found.judgements[0]
    path = script.trajectory
    scores = []
    for member in panel(told.typed, told.world()):
        frames = replay(member.world, path.states, path.actions)
        scores.append(score_script(told.typed, member.world, frames))
    assert judgement.mean == pytest.approx(np.mean(scores))
    assert judgement.worst == pytest.approx(min(scores))
    assert np.ptp(scores) > 0.01


def test_scaled_rows_are_rows_of_other_viewers() -> None:
    text = "world hill(weight = 0.5)\nlength 6\nmaximize depict(weight = 0.5)\nsearch naive\n"
    hill = story_from(Source("h.story", text))
    script = hill.solve().script
    world, path = hill.world(), script.trajectory
    for member in panel(hill.typed, world)[:2]:
        assert member.world.rows_are_scaled
        anew = replay(member.world, path.states, path.actions)
        assert np.allclose(
            member.watch([path], [script.frames])[0].log_belief, anew.log_belief, atol=1e-12
        )


def test_a_wide_panel_also_imagines_another_level_0(told: Story, folder: Path) -> None:
    """Each member twice, the second time as one of a world that was planned so."""
    found = told.solve(seed=0, candidates=2, choose="wide")
    script, world = found.script, told.world()
    path, text = script.trajectory, TEXT.replace("world small", "world small(level0 = costs)")
    other = story_from(Source("o.story", text), folder).world()
    scores = []
    for member in panel(told.typed, world):
        tables = member.world.tables
        told_so = member.sharpness, tables.forgetting, tables.log_prior
        for each in (member.world, other.with_audience(*told_so)):
            frames = replay(each, path.states, path.actions)
            scores.append(score_script(told.typed, each, frames))
    assert found.judgements[0].mean == pytest.approx(np.mean(scores))
    assert found.judgements[0].worst == pytest.approx(min(scores))
    assert np.abs(np.subtract(scores[::2], scores[1::2])).max() > 1e-3


def test_in_a_plane_a_wide_panel_also_looks_at_whole_ways() -> None:
    spec = replace(DESK, settings=replace(DESK.settings, observer="step"))
    world, other = (
        build_plane(each, None) for each in (spec, PlaneKind().imagined_otherwise(spec))
    )
    assert other.spec.settings.observer == "path"
    states, actions = wandered(world, 12, spread=0.1)
    path, known = Trajectory(actions, states), replay(world, states, actions)
    text = "world desk\nlength 12\nmaximize depict(G_hand = left)\nsearch descend(steps = 1)\n"
    members = panel(story_from(Source("d.story", text)).typed, world, other)
    assert [m.imagines_otherwise for m in members] == [False, True] * MEMBERS
    for member in members[:4]:
        anew = replay(member.world, states, actions)
        np.testing.assert_allclose(
            member.watch([path], [known])[0].log_belief, anew.log_belief, atol=1e-9
        )
    usual, wide = (m.watch([path], [known])[0].log_belief for m in members[:2])
    assert np.abs(usual - wide).max() > 1e-3


def test_where_nothing_can_be_imagined_otherwise_the_panel_is_the_usual_one() -> None:
    text = "world fork\nlength 3\nmaximize depict(G_robot = left)\n"
    fork = story_from(Source("f.story", text))
    wide, usual = (fork.solve(choose=choice).judgements for choice in ("wide", "panel"))
    assert wide == usual


def test_the_panel_puts_candidates_in_its_order(told: Story) -> None:
    found = told.solve(seed=0, candidates=3)
    best = told.solve(seed=0, choose="score").score
    order = []
    for script, judgement in zip(found.candidates, found.judgements, strict=True):
        score = script.score or 0
        far = score < best - TOLERANCE * abs(best)
        order.append(
            (faults(script.world, script.trajectory.states) + far, -score - judgement.mean)
        )
    assert order == sorted(order)
    again = told.solve(seed=0, candidates=3)
    assert [s.record for s in again.candidates] == [s.record for s in found.candidates]
    by_score = told.solve(seed=0, candidates=3, choose="score")
    scores = [s.score or 0 for s in by_score.candidates]
    assert scores == sorted(scores, reverse=True)
    assert scores[0] >= max(s.score or 0 for s in found.candidates)
    members = panel(told.typed, told.world())
    for script, judgement in zip(by_score.candidates, by_score.judgements, strict=True):
        assert judge(told.typed, members, [script.trajectory], [script.frames]) == [judgement]
    with pytest.raises(ValueError, match="panel, wide or score"):
        told.solve(choose="luck")  # type: ignore[arg-type]


def test_standing_still_and_never_meeting_are_faults(told: Story) -> None:
    world: Any = told.world()
    cells = world.dynamics.coordinates[world.dynamics.cells[:, :2]]  # [S, 2, (column, row)]
    apart = np.abs(cells[:, 0] - cells[:, 1]).sum(-1)
    steps = world.dynamics.successor[1]  # [A, S] of the robot
    leads = lambda among: next(s for s in among if s != here and apart[s] > 1)
    near = int(np.flatnonzero(apart == 1)[0])
    here = int(
        np.flatnonzero(
            (apart > 1) & ((steps != np.arange(len(apart))) & (apart[steps] > 1)).any(0)
        )[0]
    )
    aside = int(leads(steps[:, here]))
    assert faults(world, np.array([here, here, here])) == 2
    assert faults(world, np.array([near, near, near])) == 1
    assert faults(world, np.array([here, aside, here])) == 1
    assert faults(world, np.array([here, aside, near])) == 0
    assert world.is_still(
        world.tables, np.array([here, here]), np.array([here, aside])
    ).tolist() == [True, False]


@pytest.mark.parametrize("kind", ["hill", "plane"])
def test_bodies_that_hardly_move_are_still(kind: str) -> None:
    name = {"hill": "hill", "plane": "pasture"}[kind]
    world: Any = story_from(Source("s.story", f"world {name}\nlength 2\nsearch naive\n")).world()
    state = world.starts()[0]
    for far, still in ((1e-4, True), (0.1, False)):
        after = state.copy()
        after[0] += far
        if kind == "plane":
            after[len(after) // 2] = far
        both = np.stack([after, after])
        assert world.is_still(world.tables, np.stack([state, state]), both).tolist() == [still] * 2
