"""What was held of an earlier frame, and goals that change: against plain sums over every course
that hidden things can take (Baker, Saxe and Tenenbaum 2009, DOI 10.1016/j.cognition.2009.07.005:
P(g_1) = theta, P(g_t+1 = i | g_t = j) = (1 - gamma) [i = j] + gamma theta_i)."""

from __future__ import annotations

import math
from functools import cache
from itertools import product
from random import Random
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import i2pdsl
import reference as R
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import check_query
from i2pdsl.language.scope import Module
from i2pdsl.language.story import TypedStory
from i2pdsl.objective.belief import first_belief
from i2pdsl.objective.frame import observe
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.scripts import Script, script_of
from i2pdsl.worlds.grid.planning import solve
from i2pdsl.worlds.grid.world import GridWorld, assemble
from i2pdsl.worlds.ready import viewers_of
from worlds_for_tests import Pair, planned, small_kitchen

ROOM = """
map
    A.C
    ..B
tile a
    symbol = A
tile b
    symbol = B
tile c
    symbol = C
character dot
    goals = {a, b, c}
planning
    gamma = 0.8
    beta = 1.5
"""
LENGTH = 3
ALONE = R.World(
    ["A.C", "..B"],
    {"a": (0, 0), "b": (2, 1), "c": (2, 0)},
    [R.Character("dot", goals=("a", "b", "c"))],
    gamma=0.8,
    beta=1.5,
)
CHAINS = ((0.0, 0.0), (0.2, 0.0), (0.0, 0.3), (0.1, 0.3), (0.0, 1.0))
PRIOR = "if G_dot = b then 3 else 1"
Courses = dict[tuple[int, ...], float]


@cache
def room() -> Pair:
    return Pair(planned(ROOM), ALONE)


def asked(pair: Pair, text: str, length: int, seed: int) -> Script:
    """A random script as the viewers of a story see it."""
    story = pair.story(f"world small\nlength {length}\n{text}\n")
    path = pair.random_script(Random(seed), length, events=0)
    world = seen_by(pair, story.observers)
    return script_of(story, world, path, replay(world, path.states, path.actions), {}, None)


def seen_by(pair: Pair, observers: tuple) -> GridWorld:
    viewers = viewers_of(pair.spec, observers)
    plan = solve_once(pair)
    return assemble(pair.spec, pair.world.dynamics, viewers, [plan] * len(viewers))


_plans: dict[int, object] = {}


def solve_once(pair: Pair) -> object:
    if id(pair.world) not in _plans:
        _plans[id(pair.world)] = solve(pair.spec, pair.world.dynamics, tolerance=1e-10)
    return _plans[id(pair.world)]


def changed(rows: list[dict], prior: list[float], who: str, e: float, g: float) -> list[list]:
    """P(next hypothesis | hypothesis) once `who` acted: first what is forgotten, then M2."""
    n, goal = len(rows), f"G_{who}"
    rest = [{k: v for k, v in row.items() if k != goal} for row in rows]
    forget = [[1 - e if i == j else e / (n - 1) for j in range(n)] for i in range(n)]
    switch = []
    for i in range(n):
        group = [j for j in range(n) if rest[j] == rest[i] and goal in rows[j] and goal in rows[i]]
        total = sum(prior[j] for j in group)
        drawn = [prior[j] / total if j in group else 0.0 for j in range(n)]
        stays = 1 - g if group else 1.0
        switch.append([stays * (i == j) + g * drawn[j] for j in range(n)])
    return [
        [sum(forget[i][k] * switch[k][j] for k in range(n)) for j in range(n)] for i in range(n)
    ]


def courses(
    world: R.World, rows: list[dict], prior: list[float], shown: dict, e: float, g: float, seen: int
) -> Courses:
    """The weight of every course of hypotheses, one before each action and one after the last,
    where the first `seen` actions are known."""
    acts, state = [], world.state(shown["start"])
    for frame in shown["frames"]:
        acts += world.actions(state, frame)
        state = world.after(state, frame)
    found: Courses = {(i,): p for i, p in enumerate(prior)}
    for number, (who, action, acted_from, _) in enumerate(acts):
        chain = changed(rows, prior, who, e, g)
        told = [
            math.exp(world.log_likelihood(who, h, acted_from, action)) if number < seen else 1.0
            for h in rows
        ]
        found = {
            (*course, j): weight * told[course[-1]] * chain[course[-1]][j]
            for course, weight in found.items()
            for j in range(len(rows))
            if weight * chain[course[-1]][j] > 0
        }
    return found


def believed(found: Courses, at: int, event: list[bool], given: list[bool]) -> float:
    """P(event | given) of the hypothesis before action `at`."""
    of = lambda mask: sum(weight for course, weight in found.items() if mask[course[at]])
    return of([a and b for a, b in zip(event, given, strict=True)]) / of(given)


@pytest.mark.parametrize(("e", "g"), CHAINS)
def test_hindsight_is_a_sum_over_all_courses(e: float, g: float) -> None:
    pair = room()
    told = f"audience bayesian(forgetting = {e}, switching = {g}, prior = {PRIOR})\nmaximize 0"
    script = asked(pair, told, LENGTH, 5)
    rows = [dict(row) for row in pair.vocabulary.hypotheses]
    weights = [3.0 if row.get("G_dot") == "b" else 1.0 for row in rows]
    prior = [w / sum(weights) for w in weights]
    shown = pair.document(script.trajectory)
    everything = [True] * len(rows)
    for known in range(LENGTH + 1):
        every = courses(ALONE, rows, prior, shown, e, g, known)
        for assume, given in ((None, [row["R_dot"] for row in rows]), ("nothing", everything)):
            curve = script.query(f"P(G_dot @ script[t] | script[:{known}])", assume)
            for at in range(LENGTH + 1):
                for number, goal in enumerate("abc"):
                    event = [row.get("G_dot") == goal for row in rows]
                    right = believed(every, at, event, given)
                    assert curve[at, number] == pytest.approx(right, abs=1e-9)
        # The last frame that is known is what viewers believe anyway.
        np.testing.assert_allclose(
            script.query(f"P(G_dot @ script[{known}] | script[:{known}])"),
            script.query(f"P(G_dot | script[:{known}])"),
            rtol=1e-9,
        )
    evidence = math.log(sum(courses(ALONE, rows, prior, shown, e, g, LENGTH).values()))
    assert script.evidence("nothing") == pytest.approx(evidence, abs=1e-9)
    if e == g == 0:  # what does not change is seen at the end as it ever was
        found = script.query("P(G_dot @ script[t] | script[:T])")
        np.testing.assert_allclose(found, np.broadcast_to(found[-1], found.shape), rtol=1e-9)


def test_who_acted_may_want_something_else_and_nothing_else_changes() -> None:
    """Two characters: after the cheese's action its goal is drawn anew, then the robot's."""
    pair, g = small_kitchen(("P.", ".G", "..")), 0.4
    script = asked(pair, f"audience bayesian(forgetting = 0, switching = {g})\nmaximize 0", 2, 4)
    rows = [dict(row) for row in pair.vocabulary.hypotheses]
    prior = [1 / len(rows)] * len(rows)
    shown = pair.document(script.trajectory)
    everything = [True] * len(rows)
    events = {
        "G_cheese = pink": [row.get("G_cheese") == "pink" for row in rows],
        "G_robot = none and rho > 0": [
            row.get("G_robot") == "none" and row.get("rho", 0) > 0 for row in rows
        ],
        "R_robot": [row["R_robot"] for row in rows],
    }
    for known, prefix in ((0, ":0"), (1, ":1, cheese"), (2, ":1"), (3, ":2, cheese"), (4, ":2")):
        every = courses(pair.reference, rows, prior, shown, 0.0, g, known)
        for at, (event, mask) in product((0, 1, 2), events.items()):
            found = script.query(f"P({event} @ script[{at}] | script[{prefix}])", "nothing")
            right = believed(every, 2 * at, mask, everything)
            assert found == pytest.approx(right, abs=1e-9), (prefix, at, event)
    kept = script.query("P(rho, R_cheese | script[:0])", "nothing")
    ever = script.query("P(rho, R_cheese @ script[2] | script[:0])", "nothing")
    np.testing.assert_allclose(kept, ever, atol=1e-12)


FORMS = (
    "sum_t P(G_dot = a @ script[t] | script[:T])",
    "sum_t t * P(G_dot = a @ script[t-1] | script[:t])",
    "E[V(dot) @ script[1] | script[:T]]",
    "sum_t entropy(G_dot @ script[1] | script[:t])",
    "sum_t KL(G_dot @ script[t]; script[:t] || script[:T])",
)


WISHES = "".join(f"maximize {form}\n" for form in FORMS)
VIEWERS = "audience bayesian(forgetting = 0.05, switching = 0.2)\n"
NO_TERMS = "rationality 0\nnaturalness 0\nliveliness 0\n"


def test_searches_and_tables_of_many_scripts_hold_the_same() -> None:
    text = f"{VIEWERS}{NO_TERMS}{WISHES}"
    script = asked(room(), text, LENGTH, 7)
    right = [float(script.query(form)) for form in FORMS]
    table = i2pdsl.query([script, script], FORMS)
    np.testing.assert_allclose(table.value, [*right, *right], rtol=1e-12)
    assert fold(room().story(f"world small\nlength {LENGTH}\n{text}"), script) == pytest.approx(
        sum(right), rel=1e-9
    )


def test_a_film_that_begins_late_has_the_same_hindsight() -> None:
    """Of several lengths all but the longest begin with frames that do not exist."""
    asks = f"{VIEWERS}{NO_TERMS}maximize P(G_dot = a @ script[0] | script[:T]) + {FORMS[1]}\n"
    several = room().story(f"world small\nlength {LENGTH - 1}..{LENGTH}\n{asks}")
    script, first = asked(room(), asks, LENGTH - 1, 7), several.lengths[0]
    late = fold(first, script, before=1)
    assert late == pytest.approx(score_script(first, script.world, script.frames), rel=1e-9)


def fold(story: TypedStory, script: Script, before: int = 0) -> float:
    """The score that a search gives to a script, in doubles."""
    world, objective = script.world, story_objective(story, script.world)

    def score(tables: Any, params: Any, state: Any, actions: Any) -> Any:
        carry, belief = objective.init(tables, params, state), first_belief(world, tables)
        for t in range(len(actions)):
            number = jnp.asarray(before + t + 1)
            frame = observe(world, tables, number, state, actions[t], belief)
            carry = objective.step(tables, params, carry, frame)
            state, belief = frame.state, frame.belief
        return objective.score(tables, params, carry, frame)

    with jax.enable_x64(True):
        path = script.trajectory
        given = (world.tables, objective.params, path.start, path.actions)
        return float(jax.jit(score)(*jax.tree.map(jnp.asarray, given)))


MISTAKES = {
    "P(G_dot = a @ 2 | script[:T])": "write `@ script[2]`",
    "P(G_dot = a @ script[:2] | script[:T])": "expected a frame of a script",
    "P(G_dot = a @ script[9] | script[:T])": "the script has 3 frames, this is 9",
    "suspense(G_dot @ script[1] | script[:T])": "looks one frame ahead from the last one",
    "P(G_dot = a @ script[1])": "a probability without a script",
    "P(G_dot = a @ (script ++ [dot: stay])[4] | (script ++ [dot: east])[:4])": "of another script",
}


@pytest.mark.parametrize("question", MISTAKES)
def test_mistakes_about_frames_are_told(question: str) -> None:
    words = room().vocabulary
    with pytest.raises(StoryError) as told:
        check_query(Source("query", question), words, Module(Source("none", "")), LENGTH)
    (problem,) = told.value.diagnostics
    assert MISTAKES[question] in f"{problem.message} {problem.hint}"
