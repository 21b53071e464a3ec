"""An expression has one value, by whatever way it is computed.

Random expressions of numbers, of t and of predicates are worked out in Python as they are made,
and compared with the plain evaluator (language/evaluate.py), constant folding, a query (in
NumPy), a fold over frames (in JAX), and the choice of first pictures by `start`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from random import Random
from typing import Any

import jax
import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.language import typed as ty
from i2pdsl.language.check import check_query
from i2pdsl.language.elaborate import Elaborator
from i2pdsl.language.evaluate import OPEN, evaluate
from i2pdsl.language.parse import parse_expression
from i2pdsl.language.scope import Env, Module
from i2pdsl.language.start import can_start
from i2pdsl.language.vocabulary import Weights
from i2pdsl.objective.belief import first_belief
from i2pdsl.objective.fold import compile_objective
from i2pdsl.objective.frame import Frame, observe
from i2pdsl.objective.replay import evaluate as evaluate_query
from i2pdsl.objective.replay import replay
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.programs import BRIEF
from worlds_for_tests import Pair, small_kitchen

FRAMES = 5
PREDICATES = ("at(robot, pink)", "adjacent(robot, cheese)", "absent(table)", "at(cheese, (2, 2))")
Seen = dict[str, bool]  # predicate -> whether it holds
PAIR: Pair = small_kitchen()
MODULE = Module(Source("none", ""))


@dataclass(frozen=True)
class Made:
    """An expression in which `#` is a frame's number and `«...»` a predicate, and its value."""

    text: str
    value: Callable[[int, Seen], Any]

    def asked(self) -> str:
        """As a query about frame t."""
        return self.text.replace("#", "t").replace("«", "[").replace("»", " @ script[t]]")

    def pictured(self, t: int) -> str:
        """As a condition of a first picture."""
        return self.text.replace("#", str(t)).replace("«", "").replace("»", "")

    def constant(self, t: int, seen: Seen) -> str:
        """As an expression of numbers alone."""
        text = self.text.replace("#", str(t))
        for name, holds in seen.items():
            text = text.replace(f"«{name}»", f"{int(holds)} = 1")
        return text


def number(random: Random, depth: int) -> Made:
    if depth == 0:
        x = random.choice((0, 1, 2, 0.5, 3.25))
        return random.choice((Made("#", lambda t, s: t), Made(str(x), lambda t, s: x)))
    a, b = number(random, depth - 1), number(random, depth - 1)
    c = condition(random, depth - 1)
    forms: tuple[tuple[str, Callable[[float, float], float]], ...] = (
        ("(A + B)", lambda x, y: x + y),
        ("(A - B)", lambda x, y: x - y),
        ("sin(A * B)", lambda x, y: math.sin(x * y)),
        ("(A / (1 + abs(B)))", lambda x, y: x / (1 + abs(y))),
        ("exp(-abs(A))", lambda x, y: math.exp(-abs(x))),
        ("log(1 + abs(A))", lambda x, y: math.log(1 + abs(x))),
        ("sqrt(abs(cos(B)))", lambda x, y: math.sqrt(abs(math.cos(y)))),
        ("(1 + abs(A))^0.5", lambda x, y: (1 + abs(x)) ** 0.5),
        ("max(A, B, 1)", lambda x, y: max(x, y, 1)),
        ("min(A, B)", min),
    )
    pattern, function = random.choice(forms)
    text = pattern.replace("A", a.text).replace("B", b.text)
    chosen = Made(
        f"(if {c.text} then {a.text} else {b.text})",
        lambda t, s: a.value(t, s) if c.value(t, s) else b.value(t, s),
    )
    # What is not reached needs no value.
    reached = Made("(if # != 3 then 1/(# - 3) else 0)", lambda t, s: 1 / (t - 3) if t != 3 else 0)
    computed = Made(text, lambda t, s: function(a.value(t, s), b.value(t, s)))
    return random.choice((computed, computed, computed, chosen, reached))


def condition(random: Random, depth: int) -> Made:
    if depth == 0:
        name = random.choice(PREDICATES)
        return Made(f"«{name}»", lambda t, s: s[name])
    a, b = number(random, depth - 1), number(random, depth - 1)
    c, d = condition(random, depth - 1), condition(random, depth - 1)
    compared = Made(  # never equal but for rounding
        f"{a.text} > {b.text} + 0.0123", lambda t, s: a.value(t, s) > b.value(t, s) + 0.0123
    )
    both = Made(f"({c.text} and {d.text})", lambda t, s: c.value(t, s) and d.value(t, s))
    either = Made(f"({c.text} or {d.text})", lambda t, s: c.value(t, s) or d.value(t, s))
    return random.choice((compared, both, either, Made(f"(not {c.text})", _not(c))))


def _not(c: Made) -> Callable[[int, Seen], bool]:
    return lambda t, s: not c.value(t, s)


def elaborated(text: str, inside: str = "", times: range | None = None) -> Any:
    """The checked form of an expression, before functions of t are put into tables."""

    def report(problem: object) -> None:
        raise AssertionError(problem)

    elaborator = Elaborator(PAIR.vocabulary, FRAMES, report, query=True)
    env = Env(MODULE, times=times, inside=inside)
    return elaborator.item(parse_expression(Source("made", text)), env).value


def seen_in(state: int) -> Seen:
    """Which predicates hold in a state, read off the cells on which everything stands."""
    dynamics, entities = PAIR.world.dynamics, PAIR.spec.entities
    robot, cheese, table = (
        None if c == dynamics.absent else tuple(map(int, dynamics.coordinates[c]))
        for c in (dynamics.cells[state][entities.index(x)] for x in ("robot", "cheese", "table"))
    )
    assert robot is not None
    assert cheese is not None
    apart = sum(abs(x - y) for x, y in zip(robot, cheese, strict=True))
    pink = PAIR.vocabulary.places["pink"]
    truths = (robot in pink, apart == 1, table is None, cheese == (2, 2))
    return dict(zip(PREDICATES, truths, strict=True))


OBSERVE = jax.jit(partial(observe, PAIR.world), compiler_options=BRIEF)


def folded(frames: Frame, expression: ty.Typed) -> list[float]:
    """What each frame adds to the objective `sum_t expression`, by init, step and score."""
    world, xp = PAIR.world, jax.numpy
    tables = jax.tree.map(xp.asarray, world.tables)
    total = ty.Reduction("sum", 1, FRAMES, expression)
    objective = compile_objective(world, FRAMES, [(1.0, total)], Weights(0, 0, 0, 0, 0))
    params = jax.tree.map(xp.asarray, objective.params)
    carry = objective.init(tables, params, xp.asarray(frames.state[0]))
    belief, scores = first_belief(world, tables), [0.0]
    for t in range(1, FRAMES + 1):
        state, action = xp.asarray(frames.before[t]), xp.asarray(frames.action[t])
        frame = OBSERVE(tables, xp.asarray(t), state, action, belief)
        belief, carry = frame.belief, objective.step(tables, params, carry, frame)
        scores.append(float(objective.score(tables, params, carry, frame)))
    return np.diff(scores).tolist()


@pytest.mark.parametrize("seed", range(8))
def test_a_number_has_one_value(seed: int) -> None:
    random = Random(seed)
    made = number(random, 3)
    path = PAIR.random_script(random, FRAMES)
    frames = replay(PAIR.world, path.states, path.actions)
    seen = [seen_in(state) for state in path.states]
    times = range(1, FRAMES + 1)
    expected = [float(made.value(t, seen[t])) for t in times]

    plain = elaborated(made.asked(), times=times)
    features = {name: elaborated(f"[{name} @ script[1]]") for name in PREDICATES}
    names = {(node.predicate, node.arguments): name for name, node in features.items()}

    def leaf(node: ty.Feature, t: int) -> bool:
        return seen[t][names[node.predicate, node.arguments]]

    assert [evaluate(plain, t, leaf) for t in times] == pytest.approx(expected)
    constants = [evaluate(elaborated(made.constant(t, seen[t]))) for t in times]
    assert constants == pytest.approx(expected)

    query = check_query(Source("made", f"0*t + {made.asked()}"), PAIR.vocabulary, MODULE, FRAMES)
    asked = evaluate_query(PAIR.world, frames, query.value, range(FRAMES + 1))
    assert asked[1:].tolist() == pytest.approx(expected)

    story = PAIR.story(f"world w\nlength {FRAMES}\nmaximize sum_t ({made.asked()})")
    ((_, reduction),) = story.objective
    assert isinstance(reduction, ty.Reduction)
    with jax.enable_x64(True):
        assert folded(frames, reduction.body) == pytest.approx(expected)


@pytest.mark.parametrize("seed", range(60))
def test_a_condition_chooses_the_pictures_in_which_it_holds(seed: int) -> None:
    random = Random(seed)
    made = condition(random, 3)
    states = PAIR.world.starts()
    expected = [state for state in states if made.value(2, seen_in(state))]
    typed = elaborated(made.pictured(2), "start")
    assert allowed_starts(PAIR.world, typed).tolist() == expected
    assert can_start(typed, PAIR.vocabulary) in (bool(expected), None)
    # What is known of a picture is never contradicted by the rest of it.
    some = evaluate(typed, None, lambda node, _: OPEN if node.predicate == "at" else True)
    assert some is OPEN or isinstance(some, bool)


def test_a_let_in_a_start_is_a_number_like_any() -> None:
    """It was checked, and then ended in a TypeError."""
    text = (
        "world w\nlength 2\nlet near = {}\nstart adjacent(robot, cheese) and near > 0\nmaximize 1"
    )
    states = PAIR.world.starts()
    near = [state for state in states if seen_in(state)["adjacent(robot, cheese)"]]
    story = PAIR.story(text.format(1))
    assert allowed_starts(PAIR.world, story.start).tolist() == near
    with pytest.raises(StoryError, match="no state fulfils this condition"):
        PAIR.story(text.format(0))


def test_a_start_without_a_value_somewhere_is_no_mistake_of_ours() -> None:
    typed = elaborated("1 / (if at(robot, pink) then 0 else 1) < 2", "start")
    assert can_start(typed, PAIR.vocabulary) is None
    found = set(allowed_starts(PAIR.world, typed).tolist())
    assert found == {s for s in PAIR.world.starts() if not seen_in(s)["at(robot, pink)"]}


def test_without_a_map_the_world_decides_what_can_be_a_start() -> None:
    """A world of another kind has no cells on which things could be tried."""
    typed = elaborated("adjacent(robot, cheese)", "start")
    assert can_start(typed, replace(PAIR.vocabulary, free=frozenset())) is None
