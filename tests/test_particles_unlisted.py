"""Worlds with more hypotheses than anybody can hold: the same as where they are listed."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from beliefs_for_tests import random_turns, told
from i2pdsl.errors import Source, StoryError
from i2pdsl.explain import explain, questions_of
from i2pdsl.language.check import check_query
from i2pdsl.language.scope import Module
from i2pdsl.language.story import Particles, default_assumption
from i2pdsl.objective.replay import replay
from i2pdsl.objective.subjects import Subject
from i2pdsl.stories import Script, Story
from i2pdsl.worlds.find import find_spec
from i2pdsl.worlds.grid import hypotheses as grid_hypotheses_module
from i2pdsl.worlds.grid.dynamics import build_dynamics
from i2pdsl.worlds.grid.hypotheses import grid_hypotheses, minds_of_all
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.planning import solve
from i2pdsl.worlds.grid.problems import problem_keys
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary
from i2pdsl.worlds.grid.world import GridWorld, assemble
from i2pdsl.worlds.hypotheses import told_apart
from i2pdsl.worlds.record import Record, Trajectory
from i2pdsl.worlds.world import Viewer
from worlds_for_tests import kitchen_text

ROWS = ("P.", ".G", "..")
FRAMES = 5
FOUR = (
    """
map
    R.L
    W..
tile roses
    symbol = R
tile lake
    symbol = L
tile well
    symbol = W
character princess
    goals = {roses, lake, well}
"""
    + "".join(
        f"character {name}\n    goals = {{roses, lake, well, none}}\n"
        "    toward = {princess: {-2, 0, 2}}\n"
        for name in ("knight", "ghost", "dragon")
    )
    + "planning\n    gamma = 0.8\n"
)


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody can hold more than 20 hypotheses, from now on."""
    assert len(listed().vocabulary.hypotheses) == len(listed(0.0).vocabulary.hypotheses) == 34
    for module in ("spec", "hypotheses"):
        monkeypatch.setattr(f"i2pdsl.worlds.grid.{module}.MOST_HYPOTHESES", 20)
    monkeypatch.setattr("i2pdsl.worlds.grid.hypotheses.ROOM", 1)


def spec_of(**settings: float | str) -> GridSpec:
    text = kitchen_text(ROWS, gamma="0.8")
    return parse_world(Source("small.world", text), "small").with_settings(settings)


@cache
def listed(forgetting: float = 0.02) -> GridWorld:
    spec = spec_of(forgetting=forgetting)
    assert not spec.is_sampled
    dynamics = build_dynamics(spec)
    return assemble(spec, dynamics, (Viewer(spec),), [solve(spec, dynamics)])


@pytest.mark.parametrize("name", ["kitchen", "maze", "court", "porters", "nursery", "cellar"])
def test_minds_combine_to_the_hypotheses(name: str) -> None:
    spec = find_spec(name)
    assert isinstance(spec, GridSpec)
    rows = {frozenset(row.items()) for row in grid_hypotheses(spec)}
    every = frozenset(latent for row in rows for latent, _ in row)
    found, counts = told_apart(minds_of_all(spec), every)
    assert {frozenset(row.items()) for row in found} == rows
    assert set(counts) == {1.0}


def test_rows_stand_for_all_that_is_not_told_apart(few: None) -> None:
    words = grid_vocabulary(spec_of(asked="rho"))
    rows = listed().vocabulary.hypotheses
    assert sum(words.counts) == len(rows) == 34
    for row, count in zip(words.hypotheses, words.counts, strict=True):
        alike = [h for h in rows if all(h.get(x) == row.get(x) for x in words.kept)]
        assert len(alike) == count


def test_problems_are_those_of_the_listed_hypotheses(few: None) -> None:
    spec = spec_of(asked="rho")
    assert spec.is_sampled
    ours, theirs = problem_keys(spec), problem_keys(listed().spec)
    assert [set(keys) for keys in ours] == [set(keys) for keys in theirs]


def test_particles_believe_what_all_hypotheses_do(few: None) -> None:
    exact = listed()
    spec = spec_of(asked="rho", forgetting=0.02)
    dynamics = build_dynamics(spec)
    plan = solve(spec, dynamics)
    given = random_turns(exact, FRAMES)
    truth = replay(exact, *given)
    share = lambda frames, words: np.array(
        [
            np.exp(frames.log_belief[:, 0])[
                :, [row.get("rho") == rho for row in words.hypotheses]
            ].sum(-1)
            for rho in words.latents["rho"].values
        ]
    )
    off, odd = [], []
    for seed in range(8):
        viewer = Viewer(spec, particles=Particles(count=600, seed=seed, frames=16))
        world = assemble(spec, dynamics, (viewer,), [plan])
        frames = replay(world, *given)
        off.append(share(frames, world.vocabulary) - share(truth, exact.vocabulary))
        odd.append(frames.regret[1:, 0] - truth.regret[1:, 0])
        assert frames.log_rows.shape[-1] == len(world.vocabulary.hypotheses)
    assert np.sqrt(np.mean(np.square(off))) < 0.04
    assert np.abs(np.mean(off, axis=0)).max() < 0.05
    assert np.abs(np.mean(odd, axis=0)).max() < 0.2
    # What is observed is as probable in each row as in the hypotheses that it stands for.
    wide = np.exp(truth.log_rows[1, 0, 0])
    for row, log in zip(world.vocabulary.hypotheses, frames.log_rows[1, 0, 0], strict=True):
        alike = [
            all(h.get(x) == row.get(x) for x in world.vocabulary.kept)
            for h in exact.vocabulary.hypotheses
        ]
        assert np.exp(log) == pytest.approx(wide[alike].mean(), abs=0.1)


def holding_all(**settings: float | str) -> GridWorld:
    """A world in which hypotheses are not listed, before one whose particles are all of them."""
    spec = spec_of(asked="rho", **settings)
    dynamics = build_dynamics(spec)
    viewer = Viewer(spec, particles=Particles(count=34, least=0, frames=16))
    world = assemble(spec, dynamics, (viewer,), [solve(spec, dynamics)])
    (tables,) = world.tables.holdings
    flags, possible = tables.flag, tables.possible
    every = np.array(list(np.ndindex(*(possible.shape[-1],) * 2)))
    group = flags[0, every[:, 0]] + flags[1, every[:, 1]]
    first = every[(possible[group[:, None], np.arange(2), every]).all(1)]
    assert len(first) == 34
    return replace(world, tables=world.tables._replace(holdings=(tables._replace(first=first),)))


@pytest.mark.parametrize(
    "asked",
    [
        "next(robot | script[:t])",
        "next(cheese | script[:t], rho > 0)",
        "suspense(rho | script[:t])",
        "E[V(cheese) | script[:t]]",
        "E[V(robot) * V(robot) | script[:t], rho < 0]",
        "E[V(robot) * rho + 1 | script[:3]]",
        "E[V(robot) | script[:t]] - E[V(robot) | script[:t-1]]",
    ],
)
def test_who_holds_all_particles_expects_what_he_would_of_a_list(few: None, asked: str) -> None:
    """Where each hypothesis is one particle nothing is left to chance."""
    exact = listed(0.0)
    given = random_turns(exact, FRAMES)
    ours, theirs = (told(world, asked, *given) for world in (holding_all(), exact))
    np.testing.assert_allclose(ours, theirs, rtol=1e-4, atol=1e-4)
    assert np.ptp(theirs) > 1e-3 or theirs.ndim == 0


def test_beliefs_are_explained_as_those_of_a_list(few: None) -> None:
    reasons = []
    for world in (holding_all(), listed(0.0)):
        states, actions = random_turns(listed(0.0), FRAMES)
        words = world.vocabulary
        rational, path = default_assumption(words), Trajectory(actions, states)
        helps = tuple(row.get("rho", 0) > 0 for row in words.hypotheses)
        seen, module = replay(world, states, actions), Module(Source("m", ""))
        about = Record({}, {"name": "small"}, None, {}, ())
        script = Script(about, world, path, module, rational, seen)
        script = replace(script, subjects=(Subject(helps, rational),))
        reasons.append(explain(script, questions_of(script)))
    told = [0.0]
    for ours, theirs in zip(*reasons, strict=True):
        assert (ours.who, ours.taken.action) == (theirs.who, theirs.taken.action)
        assert ours.taken.expected == pytest.approx(theirs.taken.expected, abs=1e-4)
        assert ours.second.expected == pytest.approx(theirs.second.expected, abs=1e-4)
        (own,), (other,) = ours.effects, theirs.effects
        assert own.log_ratio == pytest.approx(other.log_ratio, abs=1e-4)
        assert own.instead == pytest.approx(other.instead, abs=1e-4)
        told.append(abs(other.log_ratio))
    assert max(told) > 0.1


def test_who_acts_under_a_row_has_one_of_its_hypotheses(few: None) -> None:
    """Each of them, and no other: by what the cheese and the robot would do in some states."""
    exact, world = listed(0.0), holding_all()
    words, generator = world.vocabulary, np.random.default_rng(0)
    states = np.arange(0, exact.dynamics.state_count, 7)
    own, every = (w.turns(w.tables, states).log_rows for w in (world, exact))
    for number, row in enumerate(words.hypotheses):
        drawn = world.acting(np.full(200, number), generator)
        alike = [
            all(h.get(x) == row.get(x) for x in words.kept) for h in listed().vocabulary.hypotheses
        ]
        for u in range(2):
            ours = {own[u][..., 0, k].tobytes() for k in drawn[:, u]}
            assert ours == {every[u][..., 0, h].tobytes() for h in np.flatnonzero(alike)}


def four(folder: Path, text: str, **settings: str) -> Story:
    (folder / "four.world").write_text(FOUR)
    return Story.from_text(f"world four\nlength 3\n{text}\n", folder, **settings)


def test_viewers_hold_particles_where_nobody_can_hold_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("i2pdsl.worlds.grid.hypotheses.MOST_HYPOTHESES", 100)  # neither by factors
    grid_hypotheses_module.factors.cache_clear()
    try:
        story = four(tmp_path, "maximize depict(rho_knight_princess > 0 and G_princess = lake)")
    finally:
        grid_hypotheses_module.factors.cache_clear()
    (warning,) = story.typed.warnings
    assert "viewers cannot hold all 5,309 hypotheses: they hold 200 particles" in warning.message
    assert all(observer.particles for observer in story.typed.observers)
    words = story.typed.vocabulary
    assert {"rho_knight_princess", "G_princess"} <= words.kept
    assert sum(words.counts) == 5309
    named = four(
        tmp_path, "audience particles(count = 50)\nmaximize depict(rho_ghost_princess > 0)"
    )
    assert not named.typed.warnings


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (
            "audience particles\nminimize entropy(script[:T])",
            "`entropy` of everything is about every hypothesis",
        ),
        ("maximize P(rho_ghost_princess > 0 @ script[1] | script[:T])", "hindsight looks back"),
    ],
)
def test_what_needs_every_hypothesis_is_refused(tmp_path: Path, asked: str, said: str) -> None:
    with pytest.raises(StoryError) as problem:
        four(tmp_path, asked)
    assert said in str(problem.value)


def test_conditions_that_no_particle_fulfils_have_an_answer(tmp_path: Path) -> None:
    rare = "rho_knight_princess > 0 and rho_ghost_princess > 0 and G_princess = lake"
    told = f"audience particles(count = 20)\nmaximize depict({rare})"
    (script,) = four(tmp_path, told).sample(1).scripts
    for asked in (f"E[V(princess) | script[:t], {rare}]", f"next(knight | script[:T], {rare})"):
        assert np.isfinite(script.query(asked)).all()


def test_latents_that_are_not_kept_apart_are_named(tmp_path: Path) -> None:
    told = four(tmp_path, "maximize depict(rho_knight_princess > 0)").typed
    given = told.vocabulary, told.module, told.length, told.assumption, None, told.audiences
    assert "G_ghost" not in told.vocabulary.kept
    with pytest.raises(StoryError, match="do not keep `G_ghost` apart") as problem:
        check_query(Source("query", "P(G_ghost | script[:T])"), *given)
    assert 'asked = "G_ghost' in str(problem.value)
    wider = four(tmp_path, "maximize depict(rho_knight_princess > 0)", asked='"G_ghost"')
    assert "G_ghost" in wider.typed.vocabulary.kept
    every = [x for x in told.vocabulary.latents if x[0] != "R"]
    with pytest.raises(StoryError, match="ways how"):
        four(tmp_path, f"maximize depict({' or '.join(f'{x} = {x}' for x in every)})")


@pytest.mark.slow
def test_four_characters_are_watched_from_end_to_end(tmp_path: Path) -> None:
    """Planned, searched, asked; its beliefs against all hypotheses, one by one."""
    story = four(
        tmp_path,
        "audience particles(count = 1000)\nmaximize depict(rho_knight_princess > 0)\n"
        "search beam(starts = 4, width = 1, polish = 0)",
    )
    script = story.solve(choose="score").script
    world, tables = script.world, script.world.tables
    # The exact belief, of all hypotheses that the minds combine to.
    groups = minds_of_all(world.spec)
    rows, _ = told_apart(groups, frozenset(x for x in world.vocabulary.latents))
    assert len(rows) == 5309
    keys = problem_keys(world.spec)
    from i2pdsl.worlds.grid.problems import problem_of

    path = script.trajectory
    seen = world.log_rows(tables, path.states[:-1], path.actions, path.states[1:])
    log = np.zeros(len(rows))
    for who, c in enumerate(world.spec.characters):
        number = {key: n for n, key in enumerate(keys[who])}
        problem = [
            number[problem_of(world.spec, c, row)] if row[f"R_{c.name}"] else len(number)
            for row in rows
        ]
        log += seen[who][:, 0, problem].sum(0)
    share = np.exp(log - log.max())
    share /= share.sum()
    sane = np.array([all(row[f"R_{c.name}"] for c in world.spec.characters) for row in rows])
    helps = np.array([row.get("rho_knight_princess", 0) > 0 for row in rows])
    truth = share[sane & helps].sum() / share[sane].sum()
    told = float(script.query("P(rho_knight_princess > 0 | script[:T])"))
    assert told == pytest.approx(truth, abs=0.1)
    assert script.particles[0].count == 1000
    read = Script.load(script.save(tmp_path / "script.json"))
    np.testing.assert_array_equal(read.frames.log_belief, script.frames.log_belief)
