"""Gradient descent on the hill: the same compiled objective, window by window."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from i2pdsl import StoryError, programs
from i2pdsl.errors import Source
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.pipeline import Result, Story, story_from
from i2pdsl.programs import Program
from i2pdsl.search import descent
from i2pdsl.search.beam import prepared
from i2pdsl.search.minimise import minimise
from i2pdsl.search.rollout import follow, root
from i2pdsl.worlds.kind import Watch

SHORT = "search descend(seeds = 3, window = 20, steps = 6)"
TERMS = (
    "depict(weight = 0.5)",
    "sum_t (if 3 <= t <= 6 then -1 else 1) * E[V(hopper) | script[:t], weight = 0.5]",
    "arc(hopper)",
    "twist(weight = 0.1, weight = 0.5)",
    "sum_t ([progress(box) @ script[t]] - 0.1 * [effort(hopper) @ script[t]])",
    "sum_t [not fallen(hopper) @ script[t]] + surprise(script[T]) + entropy(weight | script[:T])",
    "sum_t KL(script[:5] || script[:t]) + mean_t P(weight = 0.5 | script[:T])",
    "min_t P(weight = 0.5 | script[:t]) - max_t [progress(hopper) @ script[t]]",
)


SUMS = (TERMS[0], TERMS[4], TERMS[7])


def story(objective: str, length: int = 20, *lines: str, weight: float = 0.1) -> Story:
    text = "\n".join(
        (f"world hill(weight = {weight})", f"length {length}", f"maximize {objective}", *lines)
    )
    return story_from(Source("test.story", text + "\n"))


def solved(objective: str, length: int = 20, *lines: str, **more: Any) -> Result:
    return story(objective, length, *(lines or (SHORT,)), **more).solve(seed=0)


@pytest.mark.parametrize("objective", TERMS)
def test_the_fold_scores_as_the_whole_script_does(objective: str) -> None:
    """What a descent differentiates is what a query of the finished script gives."""
    made = story(objective, 8, "search naive(noise = 1)")
    script = made.solve(seed=2).script
    world, path = script.world, script.trajectory
    compiled = story_objective(made.typed, world)
    with jax.enable_x64(True):
        tables, params = jax.tree.map(jnp.asarray, (world.tables, compiled.params))
        node = root(world, compiled, tables, params, jnp.asarray(path.states[0]))
        for t, action in enumerate(path.actions, 1):
            node, frame = follow(world, compiled, tables, params, node, jnp.asarray(action))
            np.testing.assert_allclose(node.state, path.states[t], atol=1e-8)
            found = float(compiled.score(tables, params, node.carry, frame))
            prefix = replay(world, path.states[: t + 1], path.actions[:t])
            if objective in SUMS:  # of the frames so far, whatever T is
                shorter = re.sub(r"length \d+", f"length {t}", made.typed.source.text)
                typed = story_from(Source("prefix.story", shorter)).typed
                assert found == pytest.approx(score_script(typed, world, prefix), abs=1e-6)
    assert found == pytest.approx(score_script(made.typed, world, prefix), abs=1e-6)
    assert script.score == pytest.approx(found, abs=1e-6)


@pytest.mark.parametrize("objective", TERMS[:5])
def test_gradients_of_objectives_are_finite_differences(objective: str) -> None:
    made = story(objective, 5, "search naive(noise = 0.5)")
    script = made.solve(seed=1).script
    world, path = script.world, script.trajectory
    compiled = story_objective(made.typed, world)
    with jax.enable_x64(True):
        tables, params = jax.tree.map(jnp.asarray, (world.tables, compiled.params))

        @jax.jit
        def score(actions: jax.Array) -> jax.Array:
            node = root(world, compiled, tables, params, jnp.asarray(path.states[0]))
            for t in range(5):
                node, frame = follow(world, compiled, tables, params, node, actions[t])
            return compiled.score(tables, params, node.carry, frame)

        point = jnp.asarray(path.actions)
        gradient = np.asarray(jax.grad(score)(point))
        for place in ((0, 0), (1, 4), (3, 2)):
            step = jnp.zeros_like(point).at[place].set(1e-6)
            expected = float(score(point + step) - score(point - step)) / 2e-6
            assert gradient[place] == pytest.approx(expected, rel=1e-3, abs=1e-6)
        assert np.isfinite(gradient).all()


def test_a_descent_improves_on_what_it_begins_with() -> None:
    honest = solved("depict(weight = 0.5)", 40, "search naive").score
    found = solved("depict(weight = 0.5)", 40)
    assert found.score > honest + 3
    assert found.finished
    scores = [c.score for c in found.candidates]
    assert len(scores) == 3
    assert scores == sorted(scores, reverse=True)  # type: ignore[type-var]
    states = [c.trajectory.states for c in found.candidates]
    assert np.abs(states[0] - states[1]).max() > 0.01


def test_the_same_seed_gives_the_same_script_and_others_others() -> None:
    made = story("depict(weight = 0.5)", 20, SHORT)
    first, again, other = made.solve(0).script, made.solve(0).script, made.solve(1).script
    np.testing.assert_array_equal(first.trajectory.states, again.trajectory.states)
    assert np.abs(first.trajectory.states - other.trajectory.states).max() > 1e-3


@pytest.mark.parametrize(("overlap", "lookahead"), [(0, 0), (0.5, 0), (0.5, 10), (0, 100)])
@pytest.mark.parametrize("length", [1, 20, 33])
def test_windows_need_not_fit_the_story(length: int, overlap: float, lookahead: int) -> None:
    """Each stored state follows from the one before it and the residual, at every seam."""
    line = f"""search descend(
        seeds = 2, window = 20, steps = 2, overlap = {overlap}, lookahead = {lookahead})"""
    script = solved("depict(weight = 0.5)", length, line).script
    path = script.trajectory
    assert path.actions.shape == (length, 6)
    assert path.states.shape == (length + 1, 76)
    follows = script.world.transition(script.world.tables, path.states[:-1], path.actions)
    np.testing.assert_allclose(follows, path.states[1:], atol=1e-3)


def test_a_bound_is_kept() -> None:
    line = "search descend(seeds = 2, window = 20, steps = 4, bound = 0.25)"
    found = solved("depict(weight = 0.5)", 20, line)
    honest = solved("depict(weight = 0.5)", 20, "search naive(noise = 0)").score
    for candidate in found.candidates:
        assert np.abs(candidate.trajectory.actions).max() <= 0.25 + 1e-6
    assert found.score > honest
    free = solved("depict(weight = 0.5)", 20)
    assert np.abs(free.script.trajectory.actions).max() > 0.25


@pytest.mark.parametrize("optimiser", ["adam", "lbfgs", "ncg"])
def test_every_optimiser_descends(optimiser: str) -> None:
    line = f"search descend(seeds = 2, window = 20, steps = 4, optimiser = {optimiser})"
    honest = solved("depict(weight = 0.5)", 20, "search naive(noise = 0)").score
    assert solved("depict(weight = 0.5)", 20, line).score > honest


@pytest.mark.parametrize("damping", [0, 0.9])
def test_damped_gradients_descend_too(damping: float) -> None:
    line = f"search descend(seeds = 2, window = 20, steps = 6, damping = {damping})"
    honest = solved("depict(weight = 0.5)", 20, "search naive(noise = 0)").score
    assert solved("depict(weight = 0.5)", 20, line).score > honest


def test_not_fallen_keeps_a_hopper_up() -> None:
    """Asked to lose its value as fast as it can, it lies down; not if that is forbidden."""
    low = "minimize sum_t E[V(hopper) | script[:t]]"
    how = "search descend(seeds = 4, window = 60, lookahead = 0, steps = 30, rate = 0.2)"
    text = f"world hill(weight = 0.5)\nlength 120\n{low}\n{how}\n"
    fell = "sum_t [fallen(hopper) @ script[t]]"
    free = story_from(Source("free.story", text)).solve(0).candidates
    kept = story_from(Source("kept.story", f"{text}minimize 20000 * {fell}\n")).solve(0).script
    # Rollouts are chaotic: another machine has other falls.
    assert any(script.query(fell) > 0 for script in free)
    assert kept.query(fell) == 0


@pytest.mark.parametrize(("lookahead", "felt"), [(5, False), (6, True)])
def test_a_window_feels_as_far_as_it_looks_ahead(lookahead: int, felt: bool) -> None:
    """Only frames 16 to 20 count: who does not see them has nothing to do in frames 1 to 10."""
    how = f"search descend(seeds = 1, window = 10, overlap = 0, steps = 3, lookahead = {lookahead})"
    aims = [f"({k} - 2) * sum_{{t in 16..20}} [progress(box) @ script[t]]" for k in (1, 3)]
    forth, back = (solved(aim, 20, how).script.trajectory.actions for aim in aims)
    assert np.abs(forth[10:] - back[10:]).max() > 0.01
    assert (np.abs(forth[:10] - back[:10]).max() > 0.01) == felt


def test_looking_ahead_prevents_falls_that_are_beyond_the_window() -> None:
    """A hopper falls for longer than a window lasts; its value is least just before."""
    low = "-(sum_t (E[V(hopper) | script[:t]] + 20000 * [fallen(hopper) @ script[t]]))"
    how = "search descend(seeds = 6, window = 60, overlap = 0, steps = 30, rate = 0.2{})"

    def fallen(more: str) -> int:
        found = solved(low, 180, how.format(more), weight=0.5).candidates
        return sum(float(c.query("max_t [fallen(hopper) @ script[t]]")) > 0 for c in found)

    assert fallen("") < fallen(", lookahead = 0")


def test_an_average_of_observers_is_descended_on() -> None:
    how = "audience average(bayesian(controller = 1), bayesian(controller = 3, sigma = 2))"
    script = solved("depict(weight = 0.5)", 20, SHORT, how).script
    assert script.frames.belief.shape == (21, 2, 2)
    both = np.exp(script.frames.belief[:, :, 1]).mean(1)
    np.testing.assert_allclose(script.query("P(weight = 0.5 | script[:t])"), both, atol=1e-9)


def test_interrupted_it_keeps_what_it_has(monkeypatch: pytest.MonkeyPatch) -> None:
    """The windows that are done, and then the controller's own motion."""
    made = story("depict(weight = 0.5)", 60, "search descend(seeds = 2, window = 20, overlap = 0)")

    def report(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    found = made.solve(0, watch=Watch(searching=report))
    assert not found.finished
    actions = found.script.trajectory.actions
    assert len(actions) == 60
    assert np.abs(actions[:40]).max() > 0
    np.testing.assert_array_equal(actions[40:], 0)

    text = "search descend(seeds = 2, window = 20, overlap = 0.5)"
    found = story("depict(weight = 0.5)", 60, text).solve(0, watch=Watch(searching=report))
    actions = found.script.trajectory.actions
    assert np.abs(actions[20:30]).max() > 0, "the second half of the last window is kept too"
    np.testing.assert_array_equal(actions[30:], 0)

    def at_once(*_: Any, **__: Any) -> Any:
        raise KeyboardInterrupt

    program = Program(at_once, "interrupted", False)
    monkeypatch.setattr(descent, "compiled_program", lambda *_: program)
    with pytest.raises(KeyboardInterrupt):
        made.solve(0)


def test_an_objective_without_a_value_is_an_error() -> None:
    with pytest.raises(StoryError, match="no finite value"):
        solved("sum_t log(P(weight = 0.5 | script[:t]) - 2)", 5)


def test_gradients_that_are_not_finite_are_left_out_and_said() -> None:
    """sqrt has no derivative at 0, where all seeds begin."""
    said: list[str] = []
    made = story(
        "sum_t sqrt(max(0, P(weight = 0.5 | script[:t]) - 0.999)) + depict(weight = 0.5)",
        20,
        "search descend(seeds = 2, window = 20, steps = 3)",
    )
    found = made.solve(0, watch=Watch(say=said.append))
    assert np.isfinite(found.score)
    assert any("were not finite" in message for message in said)


# The minimisers alone.


@pytest.mark.parametrize("optimiser", ["adam", "lbfgs", "ncg"])
def test_minimisers_find_a_minimum(optimiser: str) -> None:
    aim = jnp.asarray([1.0, -2.0, 0.5])
    found, spoilt = minimise(
        lambda x: ((x - aim) ** 2 * jnp.asarray([1.0, 3.0, 0.5])).sum(),
        jnp.zeros(3),
        optimiser,
        200,
        0.1,
        None,
    )
    np.testing.assert_allclose(found, aim, atol=0.05)
    assert spoilt == 0


def test_the_box_holds_the_minimum() -> None:
    aim = jnp.asarray([1.0, -2.0, 0.1])
    found, _ = minimise(lambda x: ((x - aim) ** 2).sum(), jnp.zeros(3), "adam", 50, 0.1, 0.5)
    np.testing.assert_allclose(found, [0.5, -0.5, 0.1], atol=1e-3)


def test_the_best_point_is_kept() -> None:
    """A step that is far too long jumps over the minimum; the start was better."""
    found, _ = minimise(lambda x: (x**4).sum(), jnp.asarray([0.01]), "adam", 3, 50.0, None)
    assert abs(float(found[0])) <= 0.01


def test_the_best_point_in_the_box_is_kept() -> None:
    """Accelerated steps lead uphill on a rugged loss; never the result."""
    for phase in range(8):

        def loss(x: jax.Array) -> jax.Array:
            return (x**2).sum() + 2 * jnp.sin(9 * x + phase).sum()  # noqa: B023

        start = jnp.linspace(-1.5, 1.5, 5)
        values = [float(loss(minimise(loss, start, "adam", n, 0.1, 2.0)[0])) for n in (1, 3, 9)]
        assert values[0] <= float(loss(start))
        assert values == sorted(values, reverse=True)


def test_where_the_loss_in_the_box_means_nothing_it_is_not_taken() -> None:
    def loss(x: jax.Array) -> jax.Array:
        return jnp.where(x[0] > 0.25, jnp.nan, -x[0])

    found, _ = minimise(loss, jnp.asarray([0.0]), "adam", 30, 0.1, 1.0)
    assert 0.0 <= float(found[0]) <= 0.25


def test_one_step_is_a_step() -> None:
    found, _ = minimise(lambda x: (x**2).sum(), jnp.asarray([1.0]), "adam", 1, 0.1, None)
    assert float(found[0]) == pytest.approx(0.9, abs=1e-3)


def test_what_is_too_much_at_once_is_refused() -> None:
    with pytest.raises(StoryError, match="too many to improve at once"):
        solved("depict(weight = 0.5)", 60_000, "search descend(seeds = 10, window = 60000)")


def test_long_windows_are_computed_again_to_the_same_end(monkeypatch: pytest.MonkeyPatch) -> None:
    how = "search descend(seeds = 2, window = 10, steps = 3)"
    usual = solved("depict(weight = 0.5)", 10, how).script.trajectory.states
    monkeypatch.setattr(descent, "REMEMBERED_FRAMES", 1)
    monkeypatch.setattr(
        descent, "compiled_program", lambda key, f, *_: Program(jax.jit(f), "again", True)
    )
    again = solved("depict(weight = 0.5)", 10, how).script.trajectory.states
    np.testing.assert_allclose(usual, again, atol=1e-3)


def test_where_the_loss_means_nothing_it_is_not_taken() -> None:
    def loss(x: jax.Array) -> jax.Array:
        return jnp.where(x[0] > 0.25, jnp.nan, -x[0])

    found, _ = minimise(loss, jnp.asarray([0.0]), "adam", 30, 0.1, None)
    assert 0.0 < float(found[0]) <= 0.25


def test_tables_in_single_precision_are_the_same_world() -> None:
    made = story("depict(weight = 0.5)")
    world = made.world()
    compiled = story_objective(made.typed, world)
    tables = world.search_tables
    assert {a.dtype for a in jax.tree.leaves(tables)} == {np.dtype("float32"), np.dtype(bool)}
    assert all(np.isfinite(a).all() for a in jax.tree.leaves(prepared(world, compiled)))


def test_stories_of_one_shape_share_a_program(tmp_path: Path) -> None:
    before = len(programs._memory)
    for weight in ("0.1", "0.5"):
        solved(f"depict(weight = {weight})", 7, "search descend(seeds = 2, window = 7, steps = 2)")
    assert len(programs._memory) == before + 1
