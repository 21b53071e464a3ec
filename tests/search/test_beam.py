"""Beam search against brute force, and its promises: determinism, blocks, events, interruption."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from random import Random

import numpy as np
import pytest

import reference
from fuzz_for_tests import FULL
from i2pdsl import programs
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import TypedStory
from i2pdsl.objective.replay import replay
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.search import beam
from i2pdsl.search.beam import Found, beam_search, check_size
from i2pdsl.search.task import draw_starts
from i2pdsl.stories import story_from
from i2pdsl.worlds.grid.world import unplanned_world
from searches_for_tests import compiling_briefly
from worlds_for_tests import CORRIDOR, Pair, planned, small_kitchen, trajectory

# A search takes seconds to compile, once for each length, width and shape of the objective (events
# and numbers are no part of it): tests that need just any search take this objective.
HELPS = "world w\nlength {}\nmaximize sum_t P({} | script[:t])"
HELP = HELPS.format(4, "rho > 0")
WIDE = 40


@pytest.fixture(autouse=True)
def brief() -> Iterator[None]:
    """One program serves narrow beams and wide ones."""
    with compiling_briefly(places=WIDE):
        yield


def search(pair: Pair, text: str, starts: list[int] | np.ndarray, width: int = 1) -> Found:
    story = pair.story(text)
    world = pair.world
    entities = world.spec.entities
    events = tuple(world.moves.events.index(entities.index(t)) for _, t in story.allow)
    objective = story_objective(story, world)
    return beam_search(world, objective, story.length, np.array(starts), width, events)


def score(pair: Pair, text: str, start: int, actions: np.ndarray) -> float:
    return scored(pair, pair.story(text), start, actions)


def scored(pair: Pair, story: TypedStory, start: int, actions: np.ndarray) -> float:
    path = trajectory(pair.world, start, actions)
    return score_script(story, pair.world, replay(pair.world, path.states, path.actions))


@pytest.fixture(scope="module")
def pair() -> Pair:
    return small_kitchen()


ON_THE_CORRIDOR = (
    "sum_t P(G_one = left | script[:t])",
    "sum_t P(G_one = left | script[:t]) - 0.5 * (sum_t KL(script[:t-1] || script[:t]))",
    "(max_t P(G_one = left | script[:t])) * (min_t P(G_one = right | script[:t]))",
    "P(G_one = left | script[:2]) - P(G_one = left | script[:T])",
)


@pytest.mark.parametrize(
    "objective",
    ON_THE_CORRIDOR
    if FULL
    else (
        ON_THE_CORRIDOR[0],
        " + ".join(f"{n} * ({each})" for n, each in enumerate(ON_THE_CORRIDOR[1:], 1)),
    ),
)
def test_full_width_is_brute_force_on_the_corridor(objective: str) -> None:
    world = planned(CORRIDOR, "corridor")
    ours = reference.World(
        ["A...B"],
        {"left": (0, 0), "right": (4, 0)},
        [reference.Character("one", goals=("left", "right"))],
        [],
        gamma=0.9,
        beta=1,
    )
    pair = Pair(world, ours)
    frames = 4 if FULL else 3
    text = f"world corridor\nlength {frames}\nmaximize {objective}"
    story = pair.story(text)
    every = np.arange(5)
    found = search(pair, text, every, width=5**frames)
    for start, actions, best in zip(found.starts, found.actions, found.scores, strict=True):
        turns = itertools.product(range(5), repeat=frames)
        brute = max(scored(pair, story, int(start), np.array(t)) for t in turns)
        assert best == pytest.approx(brute, abs=1e-4)
        assert scored(pair, story, int(start), actions) == pytest.approx(brute, abs=1e-4)


def test_full_width_is_brute_force_with_events_and_chance() -> None:
    pair = small_kitchen(("P.", ".G"))
    text = "world w\nlength 2\nallow deus(table)\nmaximize sum_t P(rho > 0 | script[:t])"
    absent = np.flatnonzero(pair.world.dynamics.cells[:, 2] == pair.world.dynamics.absent)
    starts = absent[: 6 if FULL else 1].tolist()
    found = search(pair, text, starts, width=3000)
    goal = reference.objective("help", 2)
    for start, best in zip(found.starts, found.scores, strict=True):
        document = pair.document(trajectory(pair.world, int(start), np.array([0])))
        state = tuple(None if v is None else tuple(v) for v in document["start"].values())
        brute, _ = reference.exhaustive(pair.reference, state, 2, goal, ("table",))
        assert best == pytest.approx(brute, abs=1e-4)


def test_greedy_search_agrees_with_the_reference(pair: Pair) -> None:
    starts = draw_starts(np.arange(pair.spec.state_count), 4 if FULL else 2, seed=5)
    found = search(pair, HELPS.format(3, "rho > 0"), starts)
    goal = reference.objective("help", 3)
    for start, best in zip(found.starts, found.scores, strict=True):
        document = pair.document(trajectory(pair.world, int(start), np.array([0])))
        state = tuple(None if v is None else tuple(v) for v in document["start"].values())
        expected, _ = reference.beam(pair.reference, [state], 3, goal)
        assert best == pytest.approx(expected, abs=1e-4)


def test_wider_beams_are_no_worse_and_blocks_change_nothing(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = HELPS.format(4, "rho < 0")
    starts = draw_starts(np.arange(pair.spec.state_count), 10, seed=0)
    narrow, wide = search(pair, text, starts), search(pair, text, starts, WIDE)
    assert wide.scores.max() >= narrow.scores.max() - 1e-5
    monkeypatch.setattr(beam, "block_size", lambda *_: 3)
    blocks = search(pair, text, starts)
    np.testing.assert_allclose(blocks.scores, narrow.scores, atol=1e-4)
    assert blocks.starts.tolist() == narrow.starts.tolist()


SUMS = (
    "maximize arc(robot)",
    "maximize sum_t surprise(script[t])",
    "maximize sum_t (E[V(robot) | script[:t]] - E[V(robot) | script[:0]])",
    "maximize -(mean_t entropy(rho | script[:t]))",
    "maximize sum_t [pushes(robot, cheese) @ script[t]]",
)
HISTORIES = (
    "let more = script ++ [cheese: stay, robot: east] ++ [cheese: north!, robot: stay]\n"
    "maximize depict(rho > 0, over = more)",
    "maximize sum_t suspense(rho | script[:t])",
    "maximize sum_{t in 2..3} P(rho > 0 | script[:t+1]) * P(rho > 0 | script[:1])",
    "minimize max_t P(G_cheese = pink | script[:t])\nrationality 0.5\nplausibility 3",
)
# Several objectives of a story are added up: one program serves them all where time is short.
TERMS = (*SUMS, *HISTORIES) if FULL else ("\n".join(SUMS), HISTORIES[0], "\n".join(HISTORIES[1:]))


@pytest.mark.parametrize("text", TERMS)
def test_scores_in_single_precision_are_those_in_double(pair: Pair, text: str) -> None:
    starts = draw_starts(np.arange(pair.spec.state_count), 5, seed=1)
    story = f"world w\nlength 4\n{text}"
    for width in (1, 5) if "more" in text or (FULL and "surprise" in text) else (1,):
        with compiling_briefly(places=5):
            found = search(pair, story, starts, width=width)
        for start, actions, value in zip(found.starts, found.actions, found.scores, strict=True):
            assert value == pytest.approx(
                score(pair, story, int(start), actions), abs=2e-3, rel=1e-4
            ), text


def test_same_seed_same_scripts(pair: Pair) -> None:
    allowed = np.arange(pair.spec.state_count)
    first = search(pair, HELP, draw_starts(allowed, 6, seed=3), WIDE)
    again = search(pair, HELP, draw_starts(allowed, 6, seed=3), WIDE)
    assert (first.actions == again.actions).all()
    assert (first.starts == again.starts).all()
    other = draw_starts(allowed, 6, seed=4)
    assert set(other.tolist()) != set(first.starts.tolist())


def test_starts_are_drawn_without_repetition() -> None:
    drawn = draw_starts(np.arange(50), 40, seed=0)
    assert len(set(drawn.tolist())) == 40
    assert sorted(draw_starts(np.arange(7), 500, seed=0).tolist()) == list(range(7))


def test_interruption_keeps_what_was_found(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    objective = story_objective(pair.story(HELP), pair.world)
    monkeypatch.setattr(beam, "block_size", lambda *_: 3)

    def interrupt(done: int, total: int) -> None:
        if done >= 6:
            raise KeyboardInterrupt

    starts = draw_starts(np.arange(pair.spec.state_count), 10, seed=1)
    found = beam_search(pair.world, objective, 4, starts, 1, (), interrupt)
    assert not found.finished
    assert len(found.starts) == 6
    assert set(found.starts.tolist()) == set(starts[:6].tolist())


def test_scripts_of_a_search_are_valid_and_use_only_allowed_events(pair: Pair) -> None:
    text = f"{HELP}\nstart absent(table)\nallow deus(table)\n"
    story = pair.story(text)
    allowed = allowed_starts(pair.world, story.start)
    assert (pair.world.dynamics.cells[allowed, 2] == pair.world.dynamics.absent).all()
    found = search(pair, text, draw_starts(allowed, 10, seed=0))
    for start, actions in zip(found.starts, found.actions, strict=True):
        frames = pair.document(trajectory(pair.world, int(start), actions))["frames"]
        assert sum(f["event"] is not None for f in frames) <= 1
    plain = text.replace("allow deus(table)\n", "")
    found = search(pair, plain, draw_starts(allowed, 10, seed=0))
    assert (found.actions < pair.world.moves.turn_count).all()


def test_one_program_serves_stories_of_one_shape(pair: Pair) -> None:
    programs._memory.clear()
    starts = draw_starts(np.arange(pair.spec.state_count), 5, seed=1)
    for event in ("rho > 0", "rho < 0", "G_cheese = pink"):
        search(pair, HELPS.format(4, event), starts)
    assert len(programs._memory) == 1
    search(pair, HELPS.format(3, "rho > 0"), starts)
    assert len(programs._memory) == 2


def test_random_scripts_never_beat_the_search(pair: Pair) -> None:
    text = HELPS.format(5, "rho > 0")
    found = search(pair, text, np.arange(pair.spec.state_count))
    random = Random(0)
    for _ in range(30):
        path = pair.random_script(random, 5, events=0.0)
        assert score(pair, text, path.start, path.actions) <= found.scores[0] + 1e-3


@pytest.mark.parametrize("settings", ["length 15\nsearch beam(width = 10000)", "length 100000"])
def test_a_search_that_takes_days_is_refused_with_numbers(settings: str) -> None:
    text = f"world kitchen\n{settings}\nmaximize sum_t entropy(script[:t])\n"
    story = story_from(Source("big.story", text))
    world = unplanned_world(story.spec)
    objective, plan = story_objective(story.typed, world), story.typed.search
    size = (world, objective, story.typed.length, 10**6, plan.width, ())
    with pytest.raises(StoryError, match=r"1,000,000 starts x .* would take about [\d,]+ days"):
        check_size(*size)
    said: list[str] = []
    check_size(world, objective, 15, 10**7, 1, (), said.append)
    assert "Ctrl-C keeps what was found" in said[0]


def test_a_search_that_does_not_fit_is_refused_at_its_statement() -> None:
    text = (
        "world fork\nlength 20000\nmaximize sum_t P(G_robot = left | script[:t])\n"
        "maximize sum_t P(G_robot = left | script[:5])\nsearch beam(width = 10000)\n"
    )
    with pytest.raises(StoryError) as caught:
        story_from(Source("big.story", text)).solve()
    (problem,) = caught.value.diagnostics
    assert "GiB of memory for one start" in problem.message
    assert problem.span.text == "search beam(width = 10000)"
