"""Gradient descent on the hill: the same compiled objective, window by window."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from hill_for_tests import DESCENT
from i2pdsl import Script, StoryError, programs
from i2pdsl.errors import Source
from i2pdsl.language.check import Library, check_source
from i2pdsl.language.story import SearchPlan
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.programs import Program, once
from i2pdsl.search import descent
from i2pdsl.search.beam import prepared
from i2pdsl.search.minimise import minimise
from i2pdsl.search.rollout import Node, follow, root
from i2pdsl.stories import Result, Story, story_from
from i2pdsl.worlds.kind import Watch
from plane_for_tests import DESK, build_plane

# A descent takes ten seconds to compile: tests share what they can, by one length, one window
# and one objective (its numbers are no part of a program).
SHORT = "search descend(seeds = 3, window = 20, steps = 6{})"
LENGTH = 40
WINDOWS = "search descend(seeds = 2, window = 20, overlap = {}, lookahead = {}, steps = 2)"
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
WIDE = (TERMS[0], TERMS[1], TERMS[4], TERMS[6])  # have all kinds of terms


def story(objective: str, length: int = LENGTH, *lines: str, weight: float = 0.1) -> Story:
    text = "\n".join(
        (f"world hill(weight = {weight})", f"length {length}", f"maximize {objective}", *lines)
    )
    return story_from(Source("test.story", text + "\n"))


@cache
def solved(objective: str, length: int = LENGTH, *lines: str, **more: Any) -> Result:
    made = story(objective, length, *(lines or (SHORT.format(""),)), **more)
    return made.solve(seed=0, choose="score")


def honest(length: int = LENGTH, noise: float = 0) -> float:
    """What the controller's own motion is worth."""
    return solved("depict(weight = 0.5)", length, f"search naive(noise = {noise})").score


@pytest.mark.parametrize(
    "objective", [t if t in WIDE else pytest.param(t, marks=pytest.mark.slow) for t in TERMS]
)
def test_the_fold_scores_as_the_whole_script_does(objective: str) -> None:
    """What a descent differentiates is what a query of the finished script gives."""
    made = story(objective, 8, "search naive(noise = 1)")
    script = made.solve(seed=2).script
    world, path = script.world, script.trajectory
    compiled = story_objective(made.typed, world)
    with jax.enable_x64(True):
        tables, params = jax.tree.map(jnp.asarray, (world.tables, compiled.params))

        @partial(jax.jit, compiler_options=programs.BRIEF)
        def further(node: Node, action: jax.Array) -> tuple[Node, jax.Array]:
            after, frame = follow(world, compiled, tables, params, node, action)
            return after, compiled.score(tables, params, after.carry, frame)

        begin = jax.jit(partial(root, world, compiled, tables, params))
        node = begin(jnp.asarray(path.states[0]))
        for t, action in enumerate(path.actions, 1):
            node, score = further(node, jnp.asarray(action))
            found = float(score)
            np.testing.assert_allclose(node.state, path.states[t], atol=1e-8)
            prefix = replay(world, path.states[: t + 1], path.actions[:t])
            if objective in SUMS:  # of the frames so far, whatever T is
                shorter = re.sub(r"length \d+", f"length {t}", made.typed.source.text)
                typed = story_from(Source("prefix.story", shorter)).typed
                assert found == pytest.approx(score_script(typed, world, prefix), abs=1e-6)
    assert found == pytest.approx(score_script(made.typed, world, prefix), abs=1e-6)
    assert script.score == pytest.approx(found, abs=1e-6)


@pytest.mark.parametrize(
    "objective",
    [
        " + ".join(f"{number} * ({term})" for number, term in enumerate(TERMS[:5], 1)),
        *(pytest.param(term, marks=pytest.mark.slow) for term in TERMS[:5]),
    ],
)
def test_gradients_of_objectives_are_finite_differences(objective: str) -> None:
    made = story(objective, 5, "search naive(noise = 0.5)")
    script = made.solve(seed=1).script
    world, path = script.world, script.trajectory
    compiled = story_objective(made.typed, world)
    with jax.enable_x64(True):
        tables, params = jax.tree.map(jnp.asarray, (world.tables, compiled.params))

        def score(actions: jax.Array) -> jax.Array:
            """The first frame gives the loop over the others what it carries."""
            one = lambda node, action: follow(world, compiled, tables, params, node, action)
            node = root(world, compiled, tables, params, jnp.asarray(path.states[0]))
            shapes = jax.eval_shape(one, node, actions[0])[1]
            none = jax.tree.map(lambda a: jnp.zeros(a.shape, a.dtype), shapes)
            step = lambda carry, action: (one(carry[0], action), None)
            (node, frame), _ = jax.lax.scan(step, (node, none), actions)
            return compiled.score(tables, params, node.carry, frame)

        both = jax.jit(jax.value_and_grad(score), compiler_options=programs.BRIEF)
        score = lambda actions: both(actions)[0]
        point = jnp.asarray(path.actions)
        gradient = np.asarray(both(point)[1])
        for place in ((0, 0), (1, 4), (3, 2)):
            step = jnp.zeros_like(point).at[place].set(1e-6)
            expected = float(score(point + step) - score(point - step)) / 2e-6
            assert gradient[place] == pytest.approx(expected, rel=1e-3, abs=1e-6)
        assert np.isfinite(gradient).all()


def test_a_descent_improves_on_what_it_begins_with() -> None:
    found = solved("depict(weight = 0.5)")
    assert found.score > honest(noise=SearchPlan().noise) + 3
    assert found.finished
    scores = [c.score for c in found.candidates]
    assert len(scores) == 3
    assert scores == sorted(scores, reverse=True)  # type: ignore[type-var]
    states = [c.trajectory.states for c in found.candidates]
    assert np.abs(states[0] - states[1]).max() > 0.01


def test_the_same_seed_gives_the_same_script_and_others_others() -> None:
    made = story("depict(weight = 0.5)", LENGTH, SHORT.format(""))
    first = solved("depict(weight = 0.5)").script
    again, other = (made.solve(seed, choose="score").script for seed in (0, 1))
    np.testing.assert_array_equal(first.trajectory.states, again.trajectory.states)
    assert np.abs(first.trajectory.states - other.trajectory.states).max() > 1e-3


@pytest.mark.parametrize(
    ("length", "overlap", "lookahead"),
    [
        *((20, 0, 0), (20, 0, 100)),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (
                *((1, 0, 0), (1, 0.5, 0), (1, 0.5, 10), (1, 0, 100), (50, 0.5, 10)),
                *((20, 0.5, 0), (20, 0.5, 10), (50, 0, 0), (50, 0.5, 0), (50, 0, 100)),
            )
        ),
    ],
)
def test_windows_need_not_fit_the_story(length: int, overlap: float, lookahead: int) -> None:
    line = WINDOWS.format(overlap, lookahead)
    check_seams(solved("depict(weight = 0.5)", length, line).script, length)


def test_windows_overlap() -> None:
    check_seams(solved("depict(weight = 0.5)").script, LENGTH)


def check_seams(script: Script, length: int) -> None:
    """Each stored state follows from the one before it and the residual, at every seam."""
    path = script.trajectory
    assert path.actions.shape == (length, 6)
    assert path.states.shape == (length + 1, 76)
    follows = script.world.transition(script.world.tables, path.states[:-1], path.actions)
    np.testing.assert_allclose(follows, path.states[1:], atol=1e-3)


def test_a_bound_is_kept() -> None:
    """In a plane, where this is compiled in half the time."""
    desk = build_plane(DESK)

    def found(search: str) -> Result:
        text = f"world desk\nlength 12\nmaximize depict(G_hand = left)\nsearch {search}\n"
        typed = check_source(Source("desk.story", text), lambda *_: desk.vocabulary)
        assert not isinstance(typed, Library)
        return Story(typed, known=DESK).solve(seed=0, choose="score")

    descend = "descend(seeds = 2, window = 12, lookahead = 0, steps = 8{})".format
    bound, free, naive = map(found, (descend(", bound = 0.05"), descend(""), "naive(noise = 0)"))
    widest = [
        [np.abs(each.trajectory.actions).max() for each in result.candidates]
        for result in (bound, free)
    ]
    assert max(widest[0]) <= 0.05 + 1e-6 < 0.06 < max(widest[1])
    assert bound.score > naive.score


@pytest.mark.parametrize(
    "optimiser", ["adam", *(pytest.param(o, marks=pytest.mark.slow) for o in ("lbfgs", "ncg"))]
)
def test_every_optimiser_descends(optimiser: str) -> None:
    line = SHORT.format(f", optimiser = {optimiser}")
    assert solved("depict(weight = 0.5)", LENGTH, line).score > honest()


@pytest.mark.parametrize("damping", [0, 0.9])
def test_damped_gradients_descend_too(damping: float) -> None:
    line = SHORT.format(f", damping = {damping}")
    assert solved("depict(weight = 0.5)", LENGTH, line).score > honest()


def lying(price: float, length: int, how: str) -> tuple[Script, ...]:
    """Scripts of a hopper that loses its value as fast as it can, where a fall costs so much."""
    low = f"-(sum_t (E[V(hopper) | script[:t]] + {price} * [fallen(hopper) @ script[t]]))"
    line = f"search descend(window = 60, steps = 30, rate = 0.2, {how})"
    return solved(low, length, line, weight=0.5).candidates


def falls(script: Script) -> bool:
    return float(script.query("max_t [fallen(hopper) @ script[t]]")) > 0


@pytest.mark.slow
def test_not_fallen_keeps_a_hopper_up() -> None:
    """Asked to lose its value as fast as it can, it lies down; not if that is forbidden."""
    how = "seeds = 4, lookahead = 0"
    # Rollouts are chaotic: another machine has other falls.
    assert any(map(falls, lying(1e-6, 120, how)))
    assert not falls(lying(20000, 120, how)[0])


AHEAD = "search descend(seeds = 1, window = 10, overlap = 0, lookahead = {}, steps = 3)"
LATE = "({} - 2) * sum_t (if {} <= t and t <= 20 then 1 else 0) * [progress(box) @ script[t]]"


@pytest.mark.parametrize(
    ("lookahead", "first", "felt"),
    [(6, 16, True), (6, 17, False), pytest.param(5, 16, False, marks=pytest.mark.slow)],
)
def test_a_window_feels_as_far_as_it_looks_ahead(lookahead: int, first: int, felt: bool) -> None:
    """Only frames from the first on to 20 count: who does not see them has nothing to do in frames
    1 to 10."""
    forth, back = (
        solved(LATE.format(k, first), 25, AHEAD.format(lookahead)).script.trajectory.actions
        for k in (1, 3)
    )
    assert np.abs(forth[10:] - back[10:]).max() > 0.01
    assert (np.abs(forth[:10] - back[:10]).max() > 0.01) == felt


@pytest.mark.slow
def test_looking_ahead_prevents_falls_that_are_beyond_the_window() -> None:
    """A hopper falls for longer than a window lasts; its value is least just before."""
    how = "seeds = 6, overlap = 0"
    fallen = lambda more: sum(map(falls, lying(20000, 180, how + more)))
    assert fallen("") < fallen(", lookahead = 0")


@pytest.mark.parametrize(
    "search", ["search naive", pytest.param(SHORT.format(""), marks=pytest.mark.slow)]
)
def test_an_average_of_observers_is_descended_on(search: str) -> None:
    how = "audience average(bayesian(controller = 1), bayesian(controller = 3, sigma = 2))"
    script = solved("depict(weight = 0.5)", 20, search, how).script
    assert script.frames.log_belief.shape == (21, 2, 2)
    both = np.exp(script.frames.log_belief[:, :, 1]).mean(1)
    np.testing.assert_allclose(script.query("P(weight = 0.5 | script[:t])"), both, atol=1e-9)


def test_interrupted_it_keeps_what_it_has(monkeypatch: pytest.MonkeyPatch) -> None:
    """The windows that are done, and then the controller's own motion."""
    made = story(LATE.format(1, 16), 25, AHEAD.format(6))

    def report(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    found = made.solve(0, watch=Watch(searching=report))
    assert not found.finished
    actions = found.script.trajectory.actions
    assert len(actions) == 25
    assert np.abs(actions[:20]).max() > 0
    np.testing.assert_array_equal(actions[20:], 0)

    overlapping = story("depict(weight = 0.5)", LENGTH, SHORT.format(""))
    found = overlapping.solve(0, watch=Watch(searching=report))
    actions = found.script.trajectory.actions
    assert np.abs(actions[20:30]).max() > 0, "the second half of the last window is kept too"
    np.testing.assert_array_equal(actions[30:], 0)

    def at_once(*_: Any, **__: Any) -> Any:
        raise KeyboardInterrupt

    program = Program(at_once, "interrupted", False)
    monkeypatch.setattr(descent, "compiled_program", lambda *_, **__: program)
    with pytest.raises(KeyboardInterrupt):
        made.solve(0)


ROOT = "sum_t max(0, P(weight = 0.5 | script[:t]) - 0.999) ^ {} + depict(weight = 0.5)"


def test_an_objective_without_a_value_is_an_error() -> None:
    with pytest.raises(StoryError, match="no finite value"):
        solved(ROOT.format(-1), 20, DESCENT)


def test_gradients_that_are_not_finite_are_left_out_and_said() -> None:
    """A root has no derivative at 0, where all seeds begin."""
    said: list[str] = []
    made = story(ROOT.format(0.5), 20, DESCENT)
    found = made.solve(0, watch=Watch(say=said.append))
    assert np.isfinite(found.score)
    assert any("were not finite" in message for message in said)


# The minimisers alone.


def least(
    loss: Callable[[jax.Array], jax.Array], start: jax.Array, *how: Any
) -> tuple[jax.Array, int]:
    """The best point, and the gradients that were not finite; what the loss says of a point comes
    along."""
    found, along, spoilt = once(
        lambda start: minimise(lambda x: (loss(x), {"twice": 2 * x}), start, *how), start
    )
    np.testing.assert_allclose(along["twice"], 2 * found, rtol=1e-6)
    return found, int(spoilt)


@pytest.mark.parametrize("optimiser", ["adam", "lbfgs", "ncg"])
def test_minimisers_find_a_minimum(optimiser: str) -> None:
    aim = jnp.asarray([1.0, -2.0, 0.5])
    found, spoilt = least(
        lambda x: ((x - aim) ** 2 * jnp.asarray([1.0, 3.0, 0.5])).sum(),
        jnp.zeros(3),
        optimiser,
        200,
        0.1,
        None,
    )
    np.testing.assert_allclose(found, aim, atol=0.05)
    assert spoilt == 0


@pytest.mark.parametrize(
    ("optimiser", "bound"), [("adam", None), ("lbfgs", None), ("ncg", None), ("adam", 2.0)]
)
@pytest.mark.parametrize("start", [[-1.0, 1.0], [1.0, 0.0]])
def test_where_no_gradient_is_finite_the_start_is_returned(
    optimiser: str, bound: float | None, start: list[float]
) -> None:
    """Of a root below 0 there is no value, of one at 0 no gradient."""
    loss = lambda x: jnp.sqrt(x).sum()
    found, spoilt = least(loss, jnp.asarray(start), optimiser, 4, 0.1, bound)
    np.testing.assert_array_equal(found, start)
    assert spoilt > 0


def test_the_box_holds_the_minimum() -> None:
    aim = jnp.asarray([1.0, -2.0, 0.1])
    found, _ = least(lambda x: ((x - aim) ** 2).sum(), jnp.zeros(3), "adam", 50, 0.1, 0.5)
    np.testing.assert_allclose(found, [0.5, -0.5, 0.1], atol=1e-3)


def test_the_best_point_is_kept() -> None:
    """A step that is far too long jumps over the minimum; the start was better."""
    found, _ = least(lambda x: (x**4).sum(), jnp.asarray([0.01]), "adam", 3, 50.0, None)
    assert abs(float(found[0])) <= 0.01


def test_the_best_point_in_the_box_is_kept() -> None:
    """Accelerated steps lead uphill on a rugged loss; never the result."""
    start = np.linspace(-1.5, 1.5, 5, dtype=np.float32)

    def values(phase: jax.Array) -> list[jax.Array]:
        def loss(x: jax.Array) -> tuple[jax.Array, None]:
            return (x**2).sum() + 2 * jnp.sin(9 * x + phase).sum(), None

        found = [minimise(loss, start, "adam", n, 0.1, 2.0)[0] for n in (1, 3, 9)]
        return [loss(x)[0] for x in (start, *found)]

    each = np.array(once(jax.vmap(values), np.arange(16.0, dtype=np.float32)))
    assert each.shape == (4, 16)
    assert (np.diff(each, axis=0) <= 0).all()


def test_where_the_loss_in_the_box_means_nothing_it_is_not_taken() -> None:
    def loss(x: jax.Array) -> jax.Array:
        return jnp.where(x[0] > 0.25, jnp.nan, -x[0])

    found, _ = least(loss, jnp.asarray([0.0]), "adam", 30, 0.1, 1.0)
    assert 0.0 <= float(found[0]) <= 0.25


def test_one_step_is_a_step() -> None:
    found, _ = least(lambda x: (x**2).sum(), jnp.asarray([1.0]), "adam", 1, 0.1, None)
    assert float(found[0]) == pytest.approx(0.9, abs=1e-3)


def test_what_is_too_much_at_once_is_refused() -> None:
    with pytest.raises(StoryError, match="too many to improve at once"):
        solved("depict(weight = 0.5)", 60_000, "search descend(seeds = 10, window = 60000)")


@pytest.mark.slow
def test_long_windows_are_computed_again_to_the_same_end(monkeypatch: pytest.MonkeyPatch) -> None:
    how = DESCENT
    usual = solved("depict(weight = 0.5)", 20, how).script.trajectory.states
    monkeypatch.setattr(descent, "REMEMBERED_FRAMES", 1)
    compiled = descent.compiled_program
    monkeypatch.setattr(
        descent,
        "compiled_program",
        lambda key, *rest, **more: compiled((*key, "again"), *rest, **more),
    )
    again = solved.__wrapped__("depict(weight = 0.5)", 20, how).script.trajectory.states
    np.testing.assert_allclose(usual, again, atol=1e-3)


def test_where_the_loss_means_nothing_it_is_not_taken() -> None:
    def loss(x: jax.Array) -> jax.Array:
        return jnp.where(x[0] > 0.25, jnp.nan, -x[0])

    found, _ = least(loss, jnp.asarray([0.0]), "adam", 30, 0.1, None)
    assert 0.0 < float(found[0]) <= 0.25


def test_tables_in_single_precision_are_the_same_world() -> None:
    made = story("depict(weight = 0.5)")
    world = made.world()
    compiled = story_objective(made.typed, world)
    tables = world.search_tables
    assert {a.dtype for a in jax.tree.leaves(tables)} == {np.dtype("float32"), np.dtype(bool)}
    assert all(np.isfinite(a).all() for a in jax.tree.leaves(prepared(world, compiled)))


def test_stories_of_one_shape_share_a_program() -> None:
    programs._memory.clear()
    for weight in ("0.1", "0.5"):
        solved.__wrapped__(f"depict(weight = {weight})", 20, DESCENT)
    assert len(programs._memory) == 1
