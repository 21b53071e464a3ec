"""Particle audiences against exact ones, where both are possible."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from beliefs_for_tests import random_turns
from commands_for_tests import Run
from fuzz_for_tests import FULL, examples
from i2pdsl.audience import particles, queries, renewal
from i2pdsl.audience.filter import log_sum
from i2pdsl.audience.particles import Swarm, SwarmTables
from i2pdsl.errors import StoryError
from i2pdsl.language.story import Particles
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.repl.session import Session
from i2pdsl.search.rollout import resume
from i2pdsl.stories import Script, Story
from i2pdsl.worlds.grid.holdings import holdings_of
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.world import Viewer
from searches_for_tests import compiling_briefly
from worlds_for_tests import small_kitchen

ROWS = ("P.", ".G", "..")
FRAMES = 5


@cache
def exact(forgetting: float, known: str = "") -> tuple[GridWorld, Viewer]:
    """A world, and a viewer who holds all of its hypotheses."""
    world = small_kitchen(ROWS).world
    spec = world.spec.with_settings({"forgetting": forgetting})
    rows = world.vocabulary.hypotheses
    holds = tuple(row.get("G_cheese") == known for row in rows) if known else None
    prior = tuple(np.array(holds) / sum(holds)) if holds else None
    viewer = Viewer(spec, prior, holds)
    log_prior = np.log(np.array([prior or [1 / len(rows)] * len(rows)]) + 1e-300)
    share = np.full(1, forgetting)
    forgets = share if holds is None else np.where(np.array([holds]), share[:, None], 0.0)
    if holds is not None:
        log_prior = np.where(np.array([holds]), log_prior, -np.inf)
    return world.with_audience(1.0, forgets, log_prior), viewer


def script(world: GridWorld, seed: int) -> Frame:
    """What who holds all hypotheses believes along a script drawn from his own predictions, with
    one or two actions that surprise him."""
    return replay(world, *random_turns(world, FRAMES, seed))


def swarms(world: GridWorld, viewer: Viewer, plan: Particles, seeds: range) -> SwarmTables:
    """The tables of many seeds, along a first axis."""
    each = [replace(viewer, particles=replace(plan, seed=seed)) for seed in seeds]
    words = world.vocabulary
    tables = [holdings_of(world.spec, words, (one,), world.tables)[0] for one in each]
    stacked: SwarmTables = jax.tree.map(lambda *parts: np.stack(parts), *tables)
    return stacked


@jax.jit
@jax.vmap
def _watch(tables: SwarmTables, rows: jax.Array) -> tuple[jax.Array, jax.Array]:
    """log of the estimated evidence, and the belief after each frame [T, H]."""

    def frame(held: tuple[Swarm, jax.Array], row: jax.Array) -> Any:
        swarm, evidence = held
        for u in range(row.shape[0]):
            before = swarm
            problem = particles.looked_up(tables.problems[u], before.minds)
            likely = row[u][tables.columns[u]][problem]
            evidence = evidence + log_sum(before.log_weight + likely)
            swarm = particles.seen_by(tables, swarm, u, row[u])
        belief = particles.belief(tables, swarm)
        return (renewal.after_frame(tables, swarm), evidence), belief

    start = jax.tree.map(jnp.asarray, particles.begun(tables))
    (_, evidence), beliefs = jax.lax.scan(frame, (start, jnp.zeros(())), rows)
    return evidence, beliefs


def watch(
    world: GridWorld, viewer: Viewer, frames: Frame, plan: Particles, seeds: range
) -> tuple[np.ndarray, np.ndarray]:
    """The estimated evidence as a multiple of the exact one, [S], and P of each hypothesis after
    each frame, [S, T, H]."""
    rows = frames.log_rows[1:, :, 0]
    truth = log_sum(frames.log_expecting[1:] + frames.log_rows[1:]).sum()
    found = []
    for some in (seeds[n : n + AT_ONCE] for n in range(0, len(seeds), AT_ONCE)):
        each = np.broadcast_to(rows, (len(some), *rows.shape))
        found.append(_watch(swarms(world, viewer, plan, some), jnp.asarray(each)))
    evidence, beliefs = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return np.exp(evidence.astype(float) - truth), beliefs.astype(float)


AT_ONCE = 50  # seeds: a program is of so many
PLAN = Particles(count=64, frames=16, moves=1)


@pytest.mark.parametrize(
    ("forgetting", "known"),
    [
        pytest.param(0.0, "", marks=pytest.mark.slow),
        (0.05, ""),
        pytest.param(0.05, "pink", marks=pytest.mark.slow),
    ],
)
def test_the_evidence_is_unbiased_at_the_nominal_rate(forgetting: float, known: str) -> None:
    """Of 8 scripts, each with many seeds, as many means lie beyond two standard errors as should:
    5 or more of 8 at a rate of .05 happen once in 60,000 times."""
    world, viewer = exact(forgetting, known)
    far, count = [], 100 if FULL else 50
    for number in range(8):
        seeds = range(count * number, count * (number + 1))
        ratio, _ = watch(world, viewer, script(world, number), PLAN, seeds)
        far.append((ratio.mean() - 1) / (ratio.std(ddof=1) / np.sqrt(len(ratio))))
    assert (np.abs(far) > 1.96).sum() < 5, far
    assert abs(np.mean(far)) < 4 / np.sqrt(len(far)), far


@pytest.mark.parametrize("forgetting", [pytest.param(0.0, marks=pytest.mark.slow), 0.05])
def test_beliefs_converge_as_the_count_grows(forgetting: float) -> None:
    world, viewer = exact(forgetting)
    frames = script(world, 3)
    helps = np.array([row.get("rho", 0) > 0 for row in world.vocabulary.hypotheses])
    truth = np.exp(frames.log_belief[1:, 0])[:, helps].sum(-1)
    off = {}
    for count in (32, 512):
        plan = replace(PLAN, count=count)
        _, beliefs = watch(world, viewer, frames, plan, range(examples(360)))
        off[count] = np.sqrt(((beliefs[..., helps].sum(-1) - truth) ** 2).mean())
    assert off[512] < off[32] / 2.5  # by the square root of the count it is a quarter
    assert off[512] < 0.05


def test_entropies_are_not_too_low() -> None:
    """Of everything, on average over many seeds: what is added is what is missing."""
    world, viewer = exact(0.05)
    frames = script(world, 3)
    _, beliefs = watch(world, viewer, frames, PLAN, range(100))
    every = np.ones(beliefs.shape[-1], bool)
    truth = -(np.exp(frames.log_belief[1:, 0]) * frames.log_belief[1:, 0]).sum(-1)
    log = np.log(beliefs)[..., None, :]
    off = {
        how: (queries.entropy(log, None, every, counts=counts) - truth).mean()
        for how, counts in (("plain", None), ("corrected", np.array([64.0])))
    }
    assert off["plain"] < -0.03
    assert abs(off["corrected"]) < abs(off["plain"]) / 2
    # Term by term, of one belief.
    p, within = np.array([0.5, 0.25, 0.25, 1e-9]), np.array([True, True, False, True])
    plain = -(2 / 3 * np.log(2 / 3) + 1 / 3 * np.log(1 / 3))
    for count, missing in ((100, 1 / 150), (1, np.log(3) - plain), (np.inf, 0.0)):
        found = queries.entropy(np.log(p)[None], None, within, counts=np.array([count]))
        assert found == pytest.approx(plain + missing, abs=1e-6)


def tables_of(world: GridWorld, viewer: Viewer) -> SwarmTables:
    """Of one seed."""
    each = (replace(viewer, particles=PLAN),)
    (tables,) = holdings_of(world.spec, world.vocabulary, each, world.tables)
    assert tables is not None
    return tables


FINE = 42  # a multiple of how many minds there are in any group: 1, 2, 3, 14; and near any: 1, 6


def chances(tables: SwarmTables, swarm: Swarm, move: Callable, takes: int) -> np.ndarray:
    """The transition matrix of one move between all hypotheses [H, H]: every proposal it can make,
    on a grid of uniform numbers that is fine enough for all of them to be alike, times how often it
    is taken."""
    rows = np.flatnonzero(tables.row.table >= 0)
    sizes = [int((tables.possible[:, c].any(0)).sum()) for c in range(tables.flag.shape[0])]
    every = np.stack(np.unravel_index(rows, sizes), axis=-1)
    number = {tuple(minds): n for n, minds in enumerate(every.tolist())}
    grid = (np.arange(FINE) + 0.5) / FINE
    drawn = np.array(np.meshgrid(*[grid] * (takes - 1))).reshape(takes - 1, -1)
    if takes > 2:  # who changes, and what those think anew
        drawn = drawn[:, np.isin(drawn[0], grid[:: FINE // 2])]
    found = np.zeros((len(every), len(every)))
    for at, minds in enumerate(every):
        here = np.repeat(minds[None], drawn.shape[1], axis=0)
        held = swarm._replace(since=np.zeros(len(here), int))
        proposed, ratio = move(here, list(drawn))
        now, there = (renewal.log_target(tables, held, x) for x in (here, proposed))
        taken = np.minimum(1, np.exp(there - now + ratio)) / len(here)
        for to, chance in zip(proposed.tolist(), taken, strict=True):
            found[at, number.get(tuple(to), at)] += chance
        found[at, at] += 1 - found[at].sum()
    return found


def test_every_move_leaves_the_posterior_as_it_is() -> None:
    tables = tables_of(*exact(0.0))
    sizes = {*tables.sizes.ravel().tolist(), *tables.near_count.ravel().tolist()} - {0}
    assert all(FINE % size == 0 for size in sizes)
    generator = np.random.default_rng(0)
    start = particles.begun(tables)
    swarm = start._replace(sums=tuple(generator.normal(size=s.shape) for s in start.sums))
    rows = np.flatnonzero(tables.row.table >= 0)
    sizes = [int(tables.possible[:, c].any(0).sum()) for c in range(2)]
    every = np.stack(np.unravel_index(rows, sizes), axis=-1)
    held = swarm._replace(since=np.zeros(len(every), int))
    target = np.exp(renewal.log_target(tables, held, every))
    target /= target.sum()
    assert target.max() < 0.5
    moves = [
        (partial(move, tables, c), renewal.OF_VALUE)
        for c in range(2)
        for move in (renewal.another_value, renewal.another_mind)
    ]
    moves.append((partial(renewal.rational_or_not, tables), 4))
    assert sum(takes for _, takes in moves) == renewal.steps_of(2)
    kernel = np.eye(len(every))
    for move, takes in moves:
        chance = chances(tables, swarm, move, takes)
        np.testing.assert_allclose(target @ chance, target, atol=1e-12)
        assert (chance >= -1e-12).all()
        kernel = kernel @ chance
    # A sweep leads from anything to anything in the end.
    np.testing.assert_allclose(np.linalg.matrix_power(kernel, 400)[0], target, atol=1e-6)


def test_a_joint_hypothesis_is_its_characters_minds() -> None:
    world, viewer = exact(0.0)
    tables = tables_of(world, viewer)
    rows = world.vocabulary.hypotheses
    assert sorted(tables.row.table[tables.row.table >= 0]) == list(range(len(rows)))
    # The likelihood of a hypothesis is that of its problems.
    row = world.tables.columns[1][0]
    minds = np.stack(
        np.unravel_index(
            np.flatnonzero(tables.row.table >= 0),
            [int(tables.possible[:, c].any(0).sum()) for c in range(2)],
        ),
        axis=-1,
    )
    number = particles.looked_up(tables.row, minds)
    problem = particles.looked_up(tables.problems[1], minds)
    assert (row[number] == row[tables.columns[1][problem]]).all()


STORY = """
world maze
length 4
audience particles(count = 150, seed = 3)
audience all = bayesian
maximize sum_t P(rho > 0 | script[:t])
maximize 0.1 * P[all](rho > 0 | script[:T])
search beam(starts = 4, width = 2, polish = 0)
"""


def searched(story: Story) -> Script:
    with compiling_briefly(places=8):
        return story.solve(choose="score").script


@cache
def solved() -> Any:
    story = Story.from_text(STORY)
    return story, searched(story)


def test_a_story_before_particles_is_searched_and_asked() -> None:
    story, script = solved()
    again = searched(story)
    assert again.score == script.score
    assert (again.trajectory.actions == script.trajectory.actions).all()
    own, all_ = (script.query(f"P{x}(rho > 0 | script[:t])") for x in ("", "[all]"))
    assert np.abs(own - all_).max() < 0.15
    assert not np.array_equal(own, all_)
    exactly = script.query("P(rho > 0 | script[:t])", audience="bayesian")
    np.testing.assert_allclose(exactly, all_, atol=1e-12)
    # What is appended is seen by particles, too: they are about as right of it.
    later = "P{}(rho > 0 | (script ++ [cat: stay, mouse: stay])[:T+1])"
    assert abs(script.query(later.format("")) - script.query(later.format("[all]"))) < 0.15
    (held,) = script.particles
    assert (held.audience, held.count, held.seed) == ("viewers", 150, 3)
    assert 1 <= held.least <= 150


def test_an_answer_can_be_sent_to_another_process() -> None:
    _, script = solved()
    told = script.ask("P(rho > 0 | script[:t])")
    again = pickle.loads(pickle.dumps(told))
    assert (again.value == told.value).all()
    assert again.trust is None  # the world that could say it is not sent along


def test_what_a_file_says_of_its_error_is_not_said_of_other_viewers(tmp_path: Path) -> None:
    _, script = solved()
    path = script.save(tmp_path / "script.json")
    told = json.loads(path.read_text("utf-8"))
    told["trust"] = {"belief": 0.0, "trusted": True}
    path.write_text(json.dumps(told), encoding="utf-8")
    seen = Script.load(path).seen_by("bayesian(beta = 0.3)")
    assert "trust" not in json.loads(seen.save(tmp_path / "seen.json").read_text("utf-8"))
    for wrong in ({"belief": float("inf")}, {"belief": "9" * 20_000}):
        path.write_text(json.dumps(told | {"trust": wrong}).replace("Infinity", "1e999"), "utf-8")
        assert "trust" not in Script.load(path).record.error


def test_the_search_holds_the_particles_of_the_replay() -> None:
    """One in single precision on the device, one in NumPy and doubles: by common random numbers
    the same, but for a proposal that is as likely as not by a rounding error."""
    story, script = solved()
    objective = story_objective(story.typed, script.world)
    params = jax.tree.map(np.asarray, objective.params)
    node = resume(script.world, objective, 4, script.world.search_tables, params, script.trajectory)
    shown = np.exp(np.asarray(node.belief.log, float))
    np.testing.assert_allclose(shown, np.exp(script.frames.log_belief[-1]), atol=0.02)
    score = evaluate(script.world, script.frames, objective_terms(story), None)
    assert np.isfinite(score)


def objective_terms(story: Story) -> Any:
    (_, first), *_ = story.typed.objective
    return first


def test_a_script_is_held_against_other_particles() -> None:
    """Four times as many, of the next seed; of an audience that holds all hypotheses, nothing."""
    _, script = solved()
    other = script.seen_by("particles(count = 600, seed = 4)")
    far = max(
        float(np.abs(script.query(f"P({event} | script[:t])") - other.query(asked)).max())
        for event in ("rho > 0", "rho < 0", "G_mouse = crumbs", "G_cat = hole", "G_cat = none")
        if (asked := f"P({event} | script[:t])")
    )
    trust = script.trust
    assert trust.method == "150 particles"
    assert trust.closer == "600 particles of another seed"
    assert far - 1e-9 <= trust.belief < 0.3
    story = Story.from_text(STORY.replace("count = 150, seed = 3", "count = 600, seed = 4"))
    world, path = story.world(), script.trajectory
    seen = replay(world, path.states, path.actions)
    assert trust.score == pytest.approx(float(score_script(story.typed, world, seen)), abs=1e-9)
    own, other = (s.query("P(rho > 0 | script[:t])") for s in (script, other))
    told = script.ask("P(rho > 0 | script[:t])").trust
    assert told.answer == pytest.approx(np.abs(own - other).max(), abs=1e-12)
    assert script.ask("P[all](rho > 0 | script[:t])").trust.answer == 0


def test_seeds_differ_and_each_says_the_same_again() -> None:
    _, script = solved()
    ask = lambda seed: script.query(
        "P(rho > 0 | script[:t])", audience=f"particles(count = 40, seed = {seed})"
    )
    np.testing.assert_array_equal(ask(1), ask(1))
    assert not np.array_equal(ask(1), ask(2))


def test_what_particles_cannot_do_is_said() -> None:
    def wrong(audience: str, world: str = "maze") -> str:
        event = "rho > 0" if world == "maze" else "weight > 1"
        text = f"world {world}\nlength 4\naudience {audience}\nmaximize depict({event})\n"
        with pytest.raises(StoryError) as problem:
            Story.from_text(text)
        return str(problem.value)

    assert "`count` must be a whole number from 1 to 100,000" in wrong("particles(count = 0)")
    assert "`audience particles` has no setting `cuont`" in wrong("particles(cuont = 3)")
    assert "all hypotheses are held" in wrong("particles", "hill")


def test_goals_that_change_are_not_for_particles() -> None:
    text = "world maze\nlength 4\naudience particles(switching = 0.2)\nmaximize depict(rho > 0)"
    with pytest.raises(StoryError, match="does not think that goals change"):
        Story.from_text(text).world()


def test_how_many_particles_count_is_said(i2p: Run, tmp_path: Path) -> None:
    _, script = solved()
    path = str(script.save(tmp_path / "script.json"))
    asked = ["query", path, "P(rho > 0 | script[:T])", "--audience", "particles(count = 12)"]
    result = i2p(*asked)
    assert "12 particles, at least " in result.out
    assert "beliefs are rough: 12 particles" in result.err
    told = json.loads(i2p(*asked, "--json").out)
    assert told["particles"][0]["count"] == 12
    assert told["trust"]["closer"] == "48 particles of another seed"
    assert f"this is off by {told['trust']['answer']:.2g}" in result.err
    session = Session()
    session.run(f"load {path}")
    first, second = (session.run("P(rho > 0 | script[:t])") for _ in range(2))
    assert first.said == second.said
    assert "150 particles; by 600 particles of another seed this is off by" in first.said[-1]
    assert len(session.run("P[all](rho > 0 | script[:t]) * 0").said) == 2
    assert session.run("T").said == first.said[:1]
