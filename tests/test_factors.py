"""Beliefs held by factors, against those over all hypotheses, and a plain transcription."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from beliefs_for_tests import random_turns, told
from i2pdsl import questions
from i2pdsl.audience import factors
from i2pdsl.audience.factors import Factors, FactorTables
from i2pdsl.audience.filter import update
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.priors import factorises
from i2pdsl.language.query import check_audience
from i2pdsl.language.scope import Module
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.replay import replay
from i2pdsl.programs import BRIEF
from i2pdsl.stories import Story
from i2pdsl.worlds.grid import hypotheses
from i2pdsl.worlds.grid.describe import in_words
from i2pdsl.worlds.grid.dynamics import build_dynamics
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.planning import solve
from i2pdsl.worlds.grid.problems import problem_keys, problem_of
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.world import GridWorld, assemble
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import Viewer
from searches_for_tests import compiling_briefly

FRAMES = 5
THREE = """
map
    R.
    .L
tile roses
    symbol = R
tile lake
    symbol = L
character princess
    success = 0.6
    goals = {roses, lake}
""" + "".join(
    f"character {name}\n    goals = {{roses, lake, none}}\n    pushes = princess\n"
    "    toward = {princess: {-2, 0, 2}}\n"
    for name in ("knight", "ghost")
)
PLANNING = "planning\n    gamma = 0.8\n"
ASKED = "rho_knight_princess G_ghost"


def spec_of(**settings: float | str) -> GridSpec:
    text = THREE + PLANNING
    return parse_world(Source("three.world", text), "three").with_settings(settings)


def built(spec: GridSpec, viewer: Viewer | None = None) -> GridWorld:
    dynamics = build_dynamics(spec)
    return assemble(spec, dynamics, (viewer or Viewer(spec),), [solve(spec, dynamics)])


@cache
def listed(forgetting: float = 0.0) -> GridWorld:
    return built(spec_of(forgetting=forgetting))


@cache
def path() -> tuple[np.ndarray, np.ndarray]:
    """States and actions of a script."""
    return random_turns(listed(), FRAMES)


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Nobody can list more than 150 hypotheses, from now on."""
    assert len(listed().vocabulary.hypotheses) == 178
    for module in ("spec", "hypotheses"):
        monkeypatch.setattr(f"i2pdsl.worlds.grid.{module}.MOST_HYPOTHESES", 150)
    monkeypatch.setattr("i2pdsl.worlds.grid.hypotheses.ROOM", 1)
    for known in (hypotheses.factors, hypotheses.apart):
        known.cache_clear()
    yield
    for known in (hypotheses.factors, hypotheses.apart):
        known.cache_clear()


@pytest.mark.parametrize(
    "asked",
    [
        "P(rho_knight_princess > 0 | script[:t])",
        "P(G_ghost | script[:t], rho_knight_princess < 0 or G_ghost = lake)",
        "P(rho_knight_princess < 0 | script[:t, knight])",
        "entropy(rho_knight_princess | script[:t])",
        "entropy(script[:t])",
        "entropy(script[:t], rho_knight_princess != 0 or G_ghost = lake)",
        "KL(script[:t] || script[:t-1])",
        "surprise(script[t])",
        "next(princess | script[:t], rho_knight_princess < 0)",
        "next(ghost | script[:t])",
        "suspense(G_ghost | script[:t])",
        "E[V(knight) | script[:t]]",
        "E[V(princess) * V(ghost) - rho_knight_princess | script[:t], rho_knight_princess > 0]",
        "E[2 * (V(knight) - V(ghost) / 4) + V(knight) * V(ghost) + 1 | script[:t], G_ghost = lake]",
    ],
)
def test_without_forgetting_factors_are_the_belief_over_all_hypotheses(
    few: None, asked: str
) -> None:
    world = built(spec_of(asked=ASKED, forgetting=0.0))
    (tables,) = world.tables.holdings
    assert isinstance(tables, FactorTables)
    assert tables.size == 63
    ours, theirs = (told(each, asked, *path()) for each in (world, listed()))
    np.testing.assert_allclose(ours, theirs, rtol=1e-8, atol=1e-9)
    assert np.ptp(theirs) > 1e-3


@pytest.mark.parametrize(
    "asked",
    [
        "E[V(knight) @ script[1] | script[:t]]",
        "E[V(knight) - V(ghost) @ script[t-1] | script[:t]]",
        "E[V(princess) @ script[2] | script[:T]] + t",
        "E[V(ghost) @ script[t] | script[:2], rho_knight_princess > 0]",
    ],
)
def test_what_might_be_hoped_for_in_an_earlier_frame(few: None, asked: str) -> None:
    """What was hidden then is hidden now; where everybody stood is that frame's."""
    world = built(spec_of(asked=ASKED, forgetting=0.0))
    audience = check_audience(
        Source("audience", "bayesian(forgetting = 0)"),
        world.vocabulary,
        Module(Source("m", "")),
        (),
    )
    ours, theirs = (told(each, asked, *path(), audience) for each in (world, listed()))
    np.testing.assert_allclose(ours, theirs, rtol=1e-8, atol=1e-9)
    assert np.ptp(theirs) > 1e-3


def test_how_odd_an_action_is_and_what_each_row_expects(few: None) -> None:
    world = built(spec_of(asked=ASKED, forgetting=0.0))
    ours, theirs = (replay(each, *path()) for each in (world, listed()))
    np.testing.assert_allclose(ours.regret, theirs.regret, rtol=1e-9, atol=1e-9)
    every = [row.items() for row in listed().vocabulary.hypotheses]
    rows = [
        [h for h, row in enumerate(every) if told.items() <= row]
        for told in world.vocabulary.hypotheses
    ]
    for t, u in itertools.product(range(1, FRAMES + 1), range(3)):
        before, action = theirs.log_expecting[t, u, 0], theirs.log_rows[t, u, 0]
        for number, members in enumerate(rows):
            weights = np.exp(before[members] - before[members].max())
            mean = (weights @ np.exp(action[members])) / weights.sum()
            assert np.exp(ours.log_rows[t, u, 0, number]) == pytest.approx(mean, rel=1e-9)


def test_who_forgets_mixes_each_factor_with_an_even_one(few: None) -> None:
    """The equations of audience/factors.py, in dictionaries."""
    e = 0.03
    world = built(spec_of(asked=ASKED, forgetting=e))
    states, actions = path()
    rows = listed().vocabulary.hypotheses
    names = ("princess", "knight", "ghost")
    latents = {who: (f"G_{who}", f"R_{who}", f"rho_{who}_princess") for who in names}
    mine = lambda row, who: tuple(sorted((x, v) for x, v in row.items() if x in latents[who]))
    joint = [tuple(mine(row, who) for who in names) for row in rows]
    wants = {cell[0] for cell in joint}
    beside = [{m: {cell[i] for cell in joint if cell[0] == m} for m in wants} for i in (0, 1, 2)]
    count = {m: len(beside[1][m]) * len(beside[2][m]) for m in wants}
    assert sum(count.values()) == len(rows) == 178
    even = {m: count[m] / 178 for m in wants}
    common = dict(even)
    own = [
        {m: {h: 1 / len(there) for h in there} for m, there in beside[i].items()} for i in (1, 2)
    ]
    anew = e * 178 / 177

    keys = problem_keys(world.spec)
    seen = world.log_rows(world.tables, states[:-1], actions, states[1:])

    def likelihood(t: int, who: int, cell: tuple[tuple[tuple[str, object], ...], ...]) -> float:
        row = {x: v for part in cell for x, v in part}
        if not row[f"R_{names[who]}"]:
            return 1 / 5
        key = problem_of(listed().spec, listed().spec.characters[who], row)
        return math.exp(seen[who][t, 0, list(keys[who]).index(key)])

    frames = replay(world, states, actions)
    kept = [
        {x: v for x, v in row.items() if x in world.vocabulary.kept}
        for row in ({x: v for part in cell for x, v in part} for cell in joint)
    ]
    for t in range(FRAMES):
        for who in range(3):
            if who == 0:
                common = {m: p * likelihood(t, 0, (m,)) for m, p in common.items()}
            else:
                table = own[who - 1]
                for m, each in table.items():
                    scaled = {h: q * likelihood(t, who, (m, h)) for h, q in each.items()}
                    total = sum(scaled.values())
                    common[m] *= total
                    table[m] = {h: q / total for h, q in scaled.items()}
            total = sum(common.values())
            common = {m: (1 - anew) * p / total + anew * even[m] for m, p in common.items()}
            own = [
                {
                    m: {h: (1 - anew) * q + anew / len(each) for h, q in each.items()}
                    for m, each in table.items()
                }
                for table in own
            ]
        belief = np.exp(frames.log_belief[t + 1, 0])
        for row, ours in zip(world.vocabulary.hypotheses, belief, strict=True):
            theirs = sum(
                common[m] * own[0][m][one] * own[1][m][other]
                for (m, one, other), shown in zip(joint, kept, strict=True)
                if shown == row
            )
            assert ours == pytest.approx(theirs, rel=1e-9)
    assert belief.max() < 0.9


def one_factor(size: int, forgetting: float) -> FactorTables:
    """Of one who is seen, whom nobody models, beside nobody; or who is all that is modelled."""
    even = np.full(size, 1 / size)
    every = np.arange(size)
    return FactorTables(
        even, (), Factors(even, ()), np.array(forgetting * size / (size - 1)), (every,), (every,),
        (), (), np.eye(size), every[:, None], every, every,
    )  # fmt: skip


def test_one_factor_is_forgotten_as_a_list_is() -> None:
    generator = np.random.default_rng(0)
    tables, e = one_factor(7, 0.1), np.array([0.1])
    held, belief = factors.begun(tables), np.log(np.full((1, 7), 1 / 7))
    for _ in range(5):
        row = generator.normal(size=7)
        held = factors.seen_by(tables, held, 0, row)
        belief = update(belief, row, e)
        np.testing.assert_allclose(factors.belief(tables, held), np.exp(belief[0]), rtol=1e-12)


def star(count: int, size: int) -> FactorTables:
    """Of one who is modelled, and of `count` others beside him, of `size` minds each, of whom two
    of those who are modelled look alike."""
    classes = np.maximum(np.arange(size) - 1, 0)
    groups = np.array([[0, 1], *([n, size] for n in range(2, size))])
    even = np.full(size, 1 / size), np.full((size, size), 1 / size)
    every, pairs = np.arange(size), np.arange(size * size)
    begun = Factors(even[0], (even[1],) * count)
    rows = np.arange((size - 1) * size**count)
    row_of = rows.reshape(*(size,) * count, size - 1)[..., classes]
    return FactorTables(
        *begun, begun, np.array(0.0), (every, *(pairs.reshape(size, size),) * count),
        (every, *(pairs,) * count), (every,) * count, (np.eye(size),) * count,
        np.eye(size - 1)[classes], groups, rows, row_of,
    )  # fmt: skip


@pytest.mark.parametrize("count", [0, 3])
@pytest.mark.parametrize("kind", ["float32", "float64"])
def test_nothing_gets_too_improbable(count: int, kind: str) -> None:
    """What all have seen to be all but impossible can still be a condition."""
    xp = jnp if kind == "float32" else np
    change = lambda part: xp.asarray(part, kind if part.dtype == float else None)
    tables = jax.tree.map(change, star(count, 3))
    within = np.zeros((*(3,) * count, 2), bool)
    within[(0,) * (count + 1)] = within[(*(1,) * count, 0)] = True
    mask = xp.asarray(within.reshape(-1))

    def rows_of(likes: np.ndarray) -> list[np.ndarray]:
        return [likes, *[xp.tile(likes, 3)] * count]

    def once_more(tables: FactorTables, mask: np.ndarray, held: Factors, likes: np.ndarray) -> Any:
        """What is held after all have acted, what shall be finite of it, and what shall be 1."""
        finite, ones = [], []
        for u, row in enumerate(rows_of(likes)):
            finite.append(factors.likely(tables, held, u, row))
            every = xp.ones(len(tables.columns[u]), kind)
            ones.append(factors.mean(tables, held, u, every, mask))
            held = factors.seen_by(tables, held, u, row)
        return held, finite, ones

    def asked(tables: FactorTables, mask: np.ndarray, held: Factors, likes: np.ndarray) -> Any:
        """The belief, and what else shall be finite."""
        belief = factors.log_belief(tables, held)
        shape = [(1,) * u + (1,) + (1,) * (count - u) for u in range(count + 1)]
        rows = tuple(row.reshape(*shape[u], -1) for u, row in enumerate(rows_of(likes)))
        quantity = partial(factors.Points.of_rows, values=belief)
        return belief, (
            factors.expectation(tables, held, mask, quantity, ()),
            *factors.ahead(tables, held, rows, mask),
            factors.entropy(tables, held, mask),
            factors.divergence(tables, factors.begun(tables), held, mask),
        )

    if xp is jnp:
        once_more, asked = (jax.jit(f, compiler_options=BRIEF) for f in (once_more, asked))
    for each in ([-900.0, -905.0, 0.0], [-80.0, -85.0, 0.0], [-2.0, 0.0, -300.0]):
        held, likes = factors.begun(tables), np.array(each, kind)
        for _ in range(3):
            held, finite, ones = once_more(tables, mask, held, likes)
            assert all(np.isfinite(found).all() for found in finite)
            np.testing.assert_allclose(ones, 1, atol=1e-4)
        belief, found = asked(tables, mask, held, likes)
        assert np.isfinite(belief).all()
        assert np.exp(belief).sum() == pytest.approx(1, abs=1e-4)
        assert all(np.isfinite(each).all() for each in found)


def test_what_is_all_but_impossible_is_known_exactly_in_single_precision() -> None:
    """Each of five is thought to be of a sort that he cannot be: what of it he is, is known."""
    double = star(4, 3)
    single = jax.tree.map(
        lambda part: jnp.asarray(part, jnp.float32 if part.dtype == float else None), double
    )
    helds = [factors.begun(double), factors.begun(single)]
    for _ in range(6):
        for u in range(5):
            row = np.array([-9.0, -8.8, 0.0] * (1 if u == 0 else 3))
            helds = [
                factors.seen_by(double, helds[0], u, row),
                factors.seen_by(single, helds[1], u, jnp.asarray(row, jnp.float32)),
            ]
    one, other = (
        factors.log_belief(tables, held)
        for tables, held in zip((double, single), helds, strict=True)
    )
    assert one.min() < -220  # beyond the numbers of single precision
    np.testing.assert_allclose(other, one, rtol=1e-4, atol=1e-3)


def test_products_and_logs_say_the_same() -> None:
    generator, tables = np.random.default_rng(3), star(2, 4)
    held, mask = factors.begun(tables), np.arange(48) % 5 < 2
    for u in (0, 1, 2, 0, 1, 2):
        row, values = generator.normal(size=(2, len(tables.columns[u]))) * 2
        for doubted, logs in (
            (np.log(factors.belief(tables, held)), factors.log_belief(tables, held)),
            tuple(factors.likely(tables, held, u, row, doubts) for doubts in (True, False)),
            tuple(factors.mean(tables, held, u, values, mask, doubts) for doubts in (True, False)),
        ):
            np.testing.assert_allclose(doubted, logs, rtol=1e-9, atol=1e-12)
        held = factors.seen_by(tables, held, u, row)


def test_a_search_holds_logs_where_products_may_be_too_small(few: None) -> None:
    for forgetting, doubts in ((0.0, False), (1e-12, False), (0.001, True)):
        assert built(spec_of(asked=ASKED, forgetting=forgetting)).keeps_doubt == doubts


def test_products_are_told_from_other_weights() -> None:
    generator = np.random.default_rng(1)
    parts = (frozenset("a"), frozenset("bc"), frozenset("d"))
    rows = [
        dict(zip("abcd", values, strict=True))
        for values in itertools.product((1, 2), (1, 2), (1, 2, 3), (1, 2, 3))
        if values[0] == 1 or values[3] != 2
    ]
    for trial in range(20):
        one, two = generator.uniform(0.1, 3, (2, 4, 4)), generator.uniform(0.1, 3, (2, 4))
        if trial % 2:
            one[1, 2], two[0, 1] = 0.0, 0.0
        weights = [one[r["a"] - 1, r["b"], r["c"]] * two[r["a"] - 1, r["d"]] for r in rows]
        assert factorises(rows, parts, weights)
        place = int(generator.integers(len(rows)))
        while not weights[place]:
            place = int(generator.integers(len(rows)))
        weights[place] *= 1.1
        assert not factorises(rows, parts, weights)


def test_a_search_by_factors_finds_what_one_over_all_hypotheses_does(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    told = THREE.replace("R.", "R..").replace(".L", ".L.") + "audience\n    forgetting = 0.000001\n"
    text = """world three
length 4
maximize depict(rho_knight_princess > 0) - entropy(script[:T])
maximize 0.1 * E[V(princess) | script[:T], G_ghost = lake]
search beam(starts = 8, width = 1, polish = 1)
"""
    found = []
    for by_factors in (False, True):
        if by_factors:
            request.getfixturevalue("few")
        folder = tmp_path / str(by_factors)  # what is known of a file is remembered
        folder.mkdir()
        (folder / "three.world").write_text(told)
        story = Story.from_text(text, folder)
        assert bool(story.typed.vocabulary.factors) == by_factors
        with compiling_briefly(places=8):
            found.append(story.solve(choose="score").script.score)
    assert found[0] is not None
    assert found[1] == pytest.approx(found[0], abs=1e-3)


FOUR = (
    THREE.replace("roses, lake", "roses, lake, well")
    .replace("    R.\n    .L", "    R..\n    .L.")
    .replace("tile lake", "tile well\n    cell = (2, 0)\ntile lake")
)


def four(folder: Path, text: str) -> Story:
    more = FOUR[FOUR.index("character ghost") :].replace("ghost", "dragon")
    (folder / "four.world").write_text(
        (FOUR + more).replace("    pushes = princess\n", "") + PLANNING
    )
    return Story.from_text(f"world four\nlength 3\n{text}\n", folder)


WISH = "maximize depict(rho_knight_princess > 0)\n"


@pytest.mark.parametrize(
    ("audience", "by_factors"),
    [
        ("", True),
        ("audience bayesian(given = G_knight = lake and rho_ghost_princess > 0)", True),
        ("audience bayesian(prior(rho_knight_princess) = {0: 0.8, others: 0.2})", True),
        ("audience bayesian(prior(R_princess) = {true: 0.9, false: 0.1})", True),
        ("audience bayesian(prior = if G_knight = lake then 3 else 1)", True),
        ("audience bayesian(given = G_knight = G_ghost)", False),
        ("audience bayesian(prior = if G_knight = lake or G_ghost = lake then 3 else 1)", False),
        ("audience particles", False),
    ],
)  # fmt: skip
def test_who_holds_factors(tmp_path: Path, audience: str, by_factors: bool) -> None:
    story = four(tmp_path, f"{audience}\n{WISH}")
    words = story.typed.vocabulary
    assert sum(words.counts) == 5309
    assert len(words.factors) == 4
    (observer,) = story.typed.observers
    assert (observer.particles is None) == by_factors
    told = [d.message for d in story.typed.warnings]
    alone = "who know of several characters together cannot hold all 5,309"
    assert any(alone in message for message in told) == (not by_factors and "bayes" in audience)


def test_a_world_says_how_its_hypotheses_are_held(tmp_path: Path) -> None:
    spec = four(tmp_path, WISH).spec
    assert isinstance(spec, GridSpec)
    assert any(line.endswith("5309 hypotheses, held by factors") for line in in_words(spec))
    chain = THREE.replace("toward = {princess: {-2, 0, 2}}", "toward = {princess: {-9, 0, 9}}")
    more = "character bear\n    goals = {roses, lake, none}\n    toward = {princess: {-1, 1}, "
    more += "knight: {-3, -2, -1, 1, 2, 3}, ghost: {-1, 1}}\n"
    long = parse_world(Source("long.world", chain + more), "long")
    assert any(line.endswith("hypotheses, held as particles") for line in in_words(long))


def test_to_who_forgets_nothing_what_is_so_was_so(tmp_path: Path) -> None:
    told = f"audience bayesian(forgetting = 0)\n{WISH}maximize depict(G_princess = lake)"
    (script,) = four(tmp_path, told).sample(1).scripts
    for asked in ("P(G_princess = lakeAT | script[:t])", "P(G_princessAT | script[:t])"):
        now, back = (script.query(asked.replace("AT", at)) for at in ("", " @ script[1]"))
        np.testing.assert_array_equal(now, back)
        assert np.ptp(now) > 1e-3
    with pytest.raises(StoryError, match="`V` needs the end of a frame"):
        script.query("E[V(knight) @ script[0] | script[:t, knight]]")
    with pytest.raises(StoryError, match="to viewers who forget nothing what is so was so"):
        script.query("P(G_princess @ script[1] | script[:t])", audience="bayesian")


def test_of_a_sum_of_values_one_is_told_apart_at_a_time(
    few: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = built(spec_of(asked=ASKED, forgetting=0.0))
    sizes = world.vocabulary.factor_sizes
    assert sizes is not None
    (tables,) = world.tables.holdings
    assert isinstance(tables, FactorTables)
    assert sizes.probabilities == tables.size
    assert sizes.points() == tables.row_of.size
    assert sizes.points({0}) == tables.points({0}) < sizes.points({0, 1})
    points = sizes.points({0, 1})
    looked: list[int] = []
    asked_of = factors.Points.of_problems

    def noted(self: factors.Points, who: int, values: np.ndarray) -> np.ndarray:
        found = asked_of(self, who, values)
        looked.append(found.shape[-1])
        return found

    monkeypatch.setattr(factors.Points, "of_problems", noted)
    told(
        world,
        "E[V(knight) - 2 * (V(ghost) + V(princess)) | script[:t]]",
        *path(),
    )
    assert max(looked) == max(sizes.points({0}), sizes.points({1})) < points
    told(world, "E[V(knight) * V(ghost) | script[:t]]", *path())
    assert max(looked) == points
    monkeypatch.setattr("i2pdsl.language.beliefs.MOST_POINTS", points - 1)
    told(world, "E[V(knight) + V(ghost) | script[:t]]", *path())
    with pytest.raises(StoryError, match=f"{points} ways .* the most is {points - 1}"):
        told(world, "E[V(knight) * V(ghost) | script[:t]]", *path())


@pytest.mark.parametrize("audience", [None, "particles(count = 50, seed = 1)"])
def test_many_scripts_are_asked_about_in_pieces_that_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, audience: str | None
) -> None:
    scripts = list(four(tmp_path, WISH).sample(3).scripts)
    asked = "E[V(knight) * V(ghost) | script[:t]]"
    whole = questions.query(scripts, asked, audience)["value"]
    seen = []
    replayed = questions._replayed

    def noted(world: GridWorld, paths: list[Trajectory], *more: bool) -> Frame:
        seen.append(len(paths))
        return replayed(world, paths, *more)

    monkeypatch.setattr(questions, "_replayed", noted)
    questions.query(scripts, asked, audience)
    assert seen[0] == 3
    seen.clear()
    monkeypatch.setattr(questions, "NUMBERS_AT_ONCE", 1)
    pieces = questions.query(scripts, asked, audience)["value"]
    assert set(seen) == {1}
    np.testing.assert_allclose(whole, pieces)


@pytest.mark.slow
def test_four_characters_are_watched_exactly(tmp_path: Path) -> None:
    """Searched, asked, sampled and explained; what is held against an exact belief by hand is in
    tests/test_particles_unlisted.py."""
    story = four(tmp_path, f"{WISH}search beam(starts = 4, width = 1, polish = 0)")
    script = story.solve(choose="score").script
    assert script.trust is None
    assert not script.particles
    asked = "P(rho_knight_princess > 0 | script[:T])"
    particles = script.query(asked, audience="particles(count = 4000, seed = 3)")
    assert float(script.query(asked)) == pytest.approx(float(particles), abs=0.05)
    everything = script.query("entropy(script[:t])")
    assert everything[0] == pytest.approx(math.log(3 * 11**3))
    assert everything[-1] < everything[0]
