"""What viewers of a plane believe: the equation of the paper, normalisation, invariances."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from i2pdsl.errors import Source
from i2pdsl.language.vocabulary import Weights
from i2pdsl.objective.film import seen
from i2pdsl.objective.replay import replay
from i2pdsl.stories import story_from
from i2pdsl.worlds.plane import costs, dynamics
from i2pdsl.worlds.plane.geometry import disc
from i2pdsl.worlds.plane.spec import Place
from i2pdsl.worlds.plane.world import DIRECTIONS, SPEEDS
from plane_for_tests import DESK, PAIR, WALLED, believed, build_plane, wandered


def paper_posterior(spec, path, speed, beta):
    """P(G | xi_{S->Q}) of Dragan, Lee and Srinivasa 2013 (DOI 10.1109/HRI.2013.6483603), in plain
    Python: proportional to exp(-C[xi_{S->Q}] - V_G(Q)) / exp(-V_G(S)) P(G).

    C integrates a quadratic of the velocity, (|v|^2 + s^2) / (2 s), over time. V_G is the least C
    of any motion to G, of any duration: by brute force over durations at constant velocity, which
    is optimal by Jensen's inequality.
    """

    def least(point, goal):
        length = math.dist(point, goal)
        durations = [length / speed * (0.98 + 0.0001 * k) for k in range(401)]
        return min((length**2 / d + speed**2 * d) / (2 * speed) for d in durations)

    spent = 0.0
    for (x0, y0), (x1, y1) in pairwise(path):
        spent += ((x1 - x0) ** 2 + (y1 - y0) ** 2 + speed**2) / (2 * speed)
    goals = [p.at for p in spec.places]
    weights = [
        math.exp(-beta * (spent + least(path[-1], g) - least(path[0], g))) / len(goals)
        for g in goals
    ]
    return [w / sum(weights) for w in weights]


@pytest.mark.parametrize(("beta", "seed"), [(0.5, 0), (3.0, 1), (8.0, 2)])
def test_path_observer_is_that_of_the_paper(beta, seed):
    spec = DESK.with_settings({"observer": "path", "beta": beta})
    world = build_plane(spec)
    states, actions = wandered(world, 25, seed, 0.5)
    beliefs = np.exp(believed(world, states, actions))[:, 0]
    for t in range(1, 26):
        ours = beliefs[t, :3] / beliefs[t, :3].sum()  # given that the hand is rational
        path = [tuple(s[:2]) for s in states[: t + 1]]
        theirs = paper_posterior(spec, path, spec.characters[0].speed, beta)
        assert np.allclose(ours, theirs, rtol=0, atol=1e-9)


@pytest.mark.parametrize("spec", [PAIR, WALLED])
def test_path_rows_telescope(spec):
    """Of two characters and with walls too, only the first and the last place count."""
    world = build_plane(spec.with_settings({"observer": "path", "beta": 2.0}))
    states, actions = wandered(world, 12)
    tables, cast = world.tables, world.cast
    rows = [
        world.log_rows(tables, *step) for step in zip(states, actions, states[1:], strict=False)
    ]
    for who, plans in enumerate(tables.plans):
        total = sum(r[who] for r in rows)[0]
        v = [costs.value(tables, cast, who, s)[0] for s in (states[0], states[-1])]
        moves = dynamics.velocities(tables, cast, actions)[who]
        spent = sum(costs.step_cost(tables, who, u) for u in moves)
        constant = len(moves) * np.log(2 * np.pi * tables.speed[who] / 2.0)
        expected = -2.0 * (spent - v[1] + v[0]) - constant
        rational = plans.rows[-1] == 0
        assert np.allclose(total[rational], expected[rational])


@pytest.mark.parametrize(("spec", "beta"), [(DESK, 2.0), (DESK, 20.0), (PAIR, 8.0), (WALLED, 8.0)])
def test_step_observer_is_a_density_of_velocities(spec, beta):
    """Over all velocities of one character, the densities of each hypothesis integrate to 1."""
    world = build_plane(spec.with_settings({"beta": beta}))
    tables, count = world.tables, world.cast.count
    states, actions = wandered(world, 6)
    nodes, weights = disc(90, 30)
    for who in range(count):
        velocities = tables.fastest[who] * nodes
        every = np.repeat(actions[-1][None], len(nodes), axis=0)
        every[:, 2 * who : 2 * who + 2] = velocities
        before = np.repeat(states[-2][None], len(nodes), axis=0)
        after = world.transition(tables, before, every)
        density = np.exp(world.log_rows(tables, before, every, after)[who][:, 0])
        total = (weights[:, None] * tables.fastest[who] ** 2 * density).sum(0)
        assert np.allclose(total, 1.0, atol=0.02)


@pytest.mark.parametrize(
    ("spec", "observer"), [(DESK, "step"), (DESK, "path"), (PAIR, "step"), (WALLED, "step")]
)
def test_the_best_velocity_is_the_likeliest(spec, observer):
    """Of those that viewers weigh and the one taken, to viewers who know what the other does."""
    world = build_plane(spec.with_settings({"observer": observer, "beta": 3.0}))
    tables = world.tables
    states, actions = wandered(world, 5)
    nodes, _ = disc(DIRECTIONS, SPEEDS)
    for before, action, after in zip(states, actions, states[1:], strict=False):
        taken = world.log_rows(tables, before, action, after)
        best = world.best_rows(tables, before, action, after)
        here = np.repeat(before[None], len(nodes), axis=0)
        for who in range(world.cast.count):
            others = np.repeat(action[None], len(nodes), axis=0)
            others[:, 2 * who : 2 * who + 2] = tables.fastest[who] * nodes
            there = world.transition(tables, here, others)
            rows = world.log_rows(tables, here, others, there)[who]
            likeliest = np.maximum(taken[who], rows.max(0))
            assert np.allclose(best[who], likeliest, rtol=0, atol=1e-9)
            assert (best[who] > taken[who]).any()


def test_regret_is_what_the_best_step_would_have_saved():
    """In plain Python, of one hand: beta times what the step costs more than the best one."""
    world = build_plane(DESK.with_settings({"beta": 3.0}))
    states, actions = wandered(world, 4, spread=0.4)
    speed, nodes = DESK.characters[0].speed, disc(DIRECTIONS, SPEEDS)[0]

    def cost(place, velocity, goal):
        ahead = [x + v for x, v in zip(place, velocity, strict=True)]
        spent = (velocity[0] ** 2 + velocity[1] ** 2 + speed**2) / (2 * speed)
        return spent + math.dist(ahead, goal)

    frames = replay(world, states, actions)
    for t, (state, action) in enumerate(zip(states, actions, strict=False), 1):
        place, taken = state[:2].tolist(), action.tolist()
        tried = [taken, *(2 * speed * nodes).tolist()]
        expected = total = 0.0
        for number, goal in enumerate(p.at for p in DESK.places):
            costs = [cost(place, velocity, goal) for velocity in tried]
            belief = math.exp(frames.log_belief[t, 0, number])
            expected += belief * 3.0 * (costs[0] - min(costs))
            total += belief
        assert seen(world, world.tables, frames.at(t), None).regret == pytest.approx(
            expected / total
        )


def test_who_trembles_is_as_still_as_who_rests():
    """In plain Python: how each gets on in two frames, in quarters of the speed that he likes."""
    world = build_plane(PAIR)
    tremble, walk = [0.06, 0.0], [0.0, 0.09]
    for then, now, mouse, cat in (
        (tremble, [-0.06, 0.0], 0.0, 0.0),
        (tremble, tremble, 0.06, 0.0),
        (walk, tremble, math.hypot(0.03, 0.045), 0.02),
    ):
        places = world.starts()[0][:4].tolist()
        before, after = [*places, *then, 0.0, 0.0], [*places, *now, 0.0, 2 * cat]
        both = zip((mouse, cat), PAIR.characters, strict=True)
        quarters = math.hypot(*(4 * gone / character.speed for gone, character in both))
        found = world.stillness(world.tables, np.array(before), np.array(after))
        assert found == pytest.approx(1 / (1 + quarters**2))


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ("pasture", Weights(1, 0, 0.3, 0, 0.5)),
        ("desk", Weights(1, 0, 0.3, 0, 0)),
        ("hill", Weights(0, 0, 0.3, 0, 0)),
    ],
)
def test_what_the_automatic_terms_weigh(place, expected):
    text = f"world {place}\nlength 9\nmaximize [moved(X) @ script[T]]\nnaturalness 0.3\n"
    asked = {"pasture": "moved(big)", "desk": "moved(hand)", "hill": "progress(box)"}[place]
    told = story_from(Source("t.story", text.replace("moved(X)", asked)))
    assert told.typed.weights == expected


def test_step_observer_in_free_space_is_nearly_the_path_observer():
    """Far from goals and below the greatest speed the normaliser is that of a normal law."""
    actions = np.repeat([[0.05, 0.08]], 15, axis=0)
    found = []
    for observer in ("step", "path"):
        world = build_plane(DESK.with_settings({"observer": observer, "beta": 20.0}))
        states = np.cumsum(np.concatenate([[[6.0, 1.0]], actions]), axis=0)
        states = np.concatenate([states, np.concatenate([[[0, 0]], actions])], axis=1)
        found.append(np.exp(believed(world, states, actions))[-1, 0])
    assert np.allclose(*found, atol=0.05)


@pytest.mark.parametrize("observer", ["step", "path"])
@pytest.mark.parametrize("spec", [DESK, PAIR, WALLED])
def test_beliefs_sum_to_one(spec, observer):
    world = build_plane(spec.with_settings({"observer": observer, "forgetting": 0.01}))
    beliefs = np.exp(believed(world, *wandered(world, 30)))
    assert np.isfinite(beliefs).all()
    assert np.allclose(beliefs.sum(-1), 1.0)


def mirrored(spec):
    flip = lambda point: (spec.width - point[0], point[1])
    return replace(
        spec,
        walls=tuple(replace(w, points=tuple(map(flip, w.points))) for w in spec.walls),
        places=tuple(replace(p, at=flip(p.at)) for p in spec.places),
        characters=tuple(replace(c, at=flip(c.at)) for c in spec.characters),
    )


@pytest.mark.parametrize("spec", [DESK, PAIR, WALLED])
def test_a_mirror_changes_nothing(spec):
    world, other = build_plane(spec), build_plane(mirrored(spec))
    states, actions = wandered(world, 20)
    flipped = actions * np.tile([-1.0, 1.0], world.cast.count)
    start = other.starts()[0]
    there = [start]
    for action in flipped:
        there.append(other.transition(other.tables, there[-1], action))
    assert np.allclose(np.array(there)[:, 0], spec.width - states[:, 0])
    here = np.exp(believed(world, states, actions))
    # Nodes of a table that lie on a wall belong to one of its sides.
    close = 0.01 if spec.walls else 1e-9
    assert np.allclose(here, np.exp(believed(other, np.array(there), flipped)), atol=close)


@pytest.mark.parametrize("spec", [DESK, WALLED])
def test_names_of_goals_do_not_matter(spec):
    """Places in another order are the same hypotheses in another order."""
    shuffled = replace(spec, places=tuple(reversed(spec.places)))
    world, other = build_plane(spec), build_plane(shuffled)
    path = wandered(world, 15)
    assert np.allclose(believed(world, *path), believed(other, *path))


def test_nobody_near_wants_what_is_far():
    """Going straight to a place is soon believed; resting there is no sign of another goal."""
    world = build_plane(replace(DESK, places=(*DESK.places[:2], Place("low", (6.0, 2.0)))))
    states = np.zeros((31, 4))
    states[:11, 1] = np.linspace(1, 2, 11)
    states[11:, 1], states[:, 0] = 2.0, 6.0
    states[1:11, 3] = 0.1
    actions = states[1:, 2:]
    beliefs = np.exp(believed(world, states, actions))[:, 0]
    assert beliefs[-1, 2] > 0.99
    assert (np.diff(beliefs[10:, 2]) >= -1e-9).all()
