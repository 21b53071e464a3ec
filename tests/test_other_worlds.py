"""Grid worlds are data: worlds unlike the kitchen against the reference's transcription."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

import reference
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import check_query, check_source
from i2pdsl.language.scope import Module
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.objective.terms import score_script
from i2pdsl.stories import story_from
from i2pdsl.worlds.grid.dynamics import build_dynamics
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.planning import check_memory, estimated_bytes, solve
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary
from i2pdsl.worlds.grid.world import assemble
from i2pdsl.worlds.world import Viewer
from worlds_for_tests import Pair, planned, small_kitchen

C, Thing = reference.Character, reference.Object
ROWS = ["A..", ".#B"]
TILES = {"red": (0, 0), "blue": (2, 1)}
HEAD = """
map
    A..
    .#B
tile red
    symbol = A
tile blue
    symbol = B
planning
    gamma = 0.9
"""

# name: (text, characters in acting order, things, other settings of the reference)
WORLDS = {
    "both strong, the modeller acts first": (
        "    order = [b, a]\ncharacter a\n    goals = {red, blue}\n    pushes = {b}\n"
        "character b\n    goals = {blue, none}\n    pushes = {a}\n    toward = a\n"
        "    attitude = {-1, 0, 2}\n",
        [
            C("b", goals=("blue", "none"), pushes=("a",), toward="a", attitude=(-1, 0, 2)),
            C("a", goals=("red", "blue"), pushes=("b",)),
        ],
        [],
        {},
    ),
    "both weak, an attitude without 0": (
        "character a\n    success = 0.7\n    goals = {red, blue}\n"
        "character b\n    success = 0.9\n    goals = {red, none}\n    pushes = {a}\n"
        "    toward = a\n    attitude = {-2, 1}\n",
        [
            C("a", success=0.7, goals=("red", "blue")),
            C(
                "b",
                success=0.9,
                goals=("red", "none"),
                pushes=("a",),
                toward="a",
                attitude=(-2, 1),
            ),
        ],
        [],
        {},
    ),
    "no attitude, one models the other": (
        "character a\n    success = 0.5\n    goals = {red, blue}\n"
        "character b\n    goals = {red, blue, none}\n    models = a\n",
        [
            C("a", success=0.5, goals=("red", "blue")),
            C("b", goals=("red", "blue", "none"), models="a"),
        ],
        [],
        {},
    ),
    "nobody models anybody, level 0 by costs": (
        "    level0 = costs\n    beta = 1\ncharacter a\n    goals = {red, blue}\n"
        "character b\n    goals = {red, blue}\n    pushes = {a}\n",
        [C("a", goals=("red", "blue")), C("b", goals=("red", "blue"), pushes=("a",))],
        [],
        {"level0": "costs", "beta": 1.0},
    ),
    "one character alone, weak, with a ball": (
        "    beta = 1.5\ncharacter a\n    success = 0.8\n    goals = {red, blue, none}\n"
        "    pushes = {ball}\nobject ball\n    may_be_absent = yes\nevent deus\n"
        "    drops = {ball}\n",
        [C("a", success=0.8, goals=("red", "blue", "none"), pushes=("ball",))],
        [Thing("ball", may_be_absent=True)],
        {"beta": 1.5},
    ),
    "two things, one of them always there": (
        "character a\n    success = 0.6\n    goals = {red, blue}\n    pushes = {box}\n"
        "object box\nobject jar\n    may_be_absent = yes\nevent deus\n    drops = {jar}\n"
        "rewards\n    goal = 2\n    move = -0.5\n    stay = 0\n",
        [C("a", success=0.6, goals=("red", "blue"), pushes=("box",))],
        [Thing("box", may_be_absent=False), Thing("jar", may_be_absent=True)],
        {"rewards": {"goal": 2.0, "move": -0.5, "stay": 0.0}},
    ),
}


def made(name: str) -> Pair:
    text, characters, things, settings = WORLDS[name]
    rewards = settings.get("rewards")
    others = {k: v for k, v in settings.items() if k != "rewards"}
    ours = reference.World(ROWS, TILES, characters, things, rewards, gamma=0.9, **others)
    return Pair(planned(HEAD + text, "small"), ours)


@pytest.mark.parametrize("name", WORLDS)
def test_beliefs_and_scores_agree(name: str) -> None:
    pair = made(name)
    assert pair.spec.state_count == pair.reference.count_states()
    order, random = pair.order(), Random(name)
    who = pair.vocabulary.characters[0]
    wants = f"G_{who} = blue"
    story = pair.story(f"world w\nlength 5\nmaximize sum_t P({wants} | script[:t])")
    goal = reference.objective(
        lambda world, script, T: sum(
            reference.P(world, script, t, lambda h: h.get(f"G_{who}") == "blue")
            for t in range(1, len(script["frames"]) + 1)
        ),
        5,
    )
    for _ in range(5):
        path = pair.random_script(random, 5, events=0.3)
        frames = replay(pair.world, path.states, path.actions)
        document = pair.document(path)
        expected = pair.reference.beliefs(document)
        for t, belief in enumerate(expected):
            row = [belief[i] for i in order]
            np.testing.assert_allclose(np.exp(frames.log_belief[t, 0]), row, atol=1e-8)
        score = score_script(story, pair.world, frames)
        assert score == pytest.approx(goal(pair.reference, document), abs=1e-6)


def test_averaged_observers_are_the_mean_of_single_ones() -> None:
    pair = small_kitchen()
    spec, dynamics = pair.spec, build_dynamics(pair.spec)
    head = "world w\nlength 4\nmaximize depict(rho > 0)\naudience "
    kinds = ("bayesian(beta = 1, forgetting = 0.01)", "bayesian(prior = if rho > 0 then 3 else 1)")
    path = pair.random_script(Random(3), 4)

    def belief(audience: str) -> np.ndarray:
        story = pair.story(head + audience)
        viewers = tuple(
            Viewer(spec.with_settings(dict(o.settings)), o.prior) for o in story.observers
        )
        plans = [solve(v.spec, dynamics, tolerance=1e-9) for v in viewers]
        world = assemble(spec, dynamics, viewers, plans)
        frames = replay(world, path.states, path.actions)
        source = Source("query", "P(rho > 0 | script[:t])")
        query = check_query(source, pair.vocabulary, Module(Source("m", "")), 4)
        return np.asarray(evaluate(world, frames, query.value, query.times))

    first, second = belief(kinds[0]), belief(kinds[1])
    both = belief(f"average({kinds[0]}, {kinds[1]})")
    assert np.abs(first - second).max() > 0.05
    np.testing.assert_allclose(both, (first + second) / 2, atol=1e-9)
    rational = [h for h in pair.vocabulary.hypotheses if h["R_cheese"] and h["R_robot"]]
    weights = [3 if h["rho"] > 0 else 1 for h in rational]
    helping = sum(w for w, h in zip(weights, rational, strict=True) if h["rho"] > 0)
    assert second[0] == pytest.approx(helping / sum(weights))


def test_mirroring_the_map_changes_no_belief() -> None:
    rows = ("P..", "#.G", "...")
    mirrored = tuple(row[::-1] for row in rows)
    pair, other = small_kitchen(rows), small_kitchen(mirrored)
    path = pair.random_script(Random(9), 6, events=0.0)
    document = pair.document(path)
    flip = {"east": "west", "west": "east"}
    text = {**document, "start": {k: v and [2 - v[0], v[1]] for k, v in document["start"].items()}}
    text["frames"] = [
        {
            "event": None,
            "state": {k: v and [2 - v[0], v[1]] for k, v in frame["state"].items()},
            **{
                c: {**frame[c], "action": flip.get(frame[c]["action"], frame[c]["action"])}
                for c in ("cheese", "robot")
            },
        }
        for frame in document["frames"]
    ]
    from i2pdsl.worlds.grid.kind import KIND
    from i2pdsl.worlds.record import Record

    record = Record({}, {"name": "w"}, None, text["start"], tuple(text["frames"]))
    turned = KIND.read(other.world, record)
    ours = replay(pair.world, path.states, path.actions)
    theirs = replay(other.world, turned.states, turned.actions)
    np.testing.assert_allclose(np.exp(ours.log_belief), np.exp(theirs.log_belief), atol=1e-8)


def test_a_world_that_does_not_fit_is_refused_before_work_starts() -> None:
    row = "    " + "." * 120
    text = "map\n" + "\n".join([row] * 120) + "\ncharacter a\ncharacter b\n    pushes = {a}\n"
    spec = parse_world(Source("big.world", text), "big")
    assert estimated_bytes(spec) > 2**34
    with pytest.raises(StoryError) as caught:
        check_memory(spec)
    (problem,) = caught.value.diagnostics
    assert problem.code == "too-large"
    assert f"{spec.state_count:,} states" in problem.message
    assert "GiB" in problem.message


def test_a_million_states_are_not_refused() -> None:
    row = "    " + "." * 32
    text = "map\n" + "\n".join([row] * 32) + "\ncharacter a\ncharacter b\n    pushes = {a}\n"
    spec = parse_world(Source("big.world", text), "big")
    assert spec.state_count > 1_000_000
    check_memory(spec)


@pytest.mark.parametrize("size", [181, 182, 300])
def test_cells_of_large_maps_are_told_apart(size: int) -> None:
    """32,767 cells are the most that 16 bits can number."""
    row = "." * size
    rows = "\n".join(f"    {r}" for r in ["A" + row[1:], *[row] * (size - 2), row[1:] + "B"])
    text = f"map\n{rows}\ntile here\n    symbol = A\ntile there\n    symbol = B\n"
    text += "character a\n    goals = {here, there}\nplanning\n    gamma = 0.5\n"
    spec = parse_world(Source("big.world", text), "big")
    check_memory(spec)
    dynamics = build_dynamics(spec)
    assert (dynamics.cells[:, 0] == np.arange(size**2)).all()
    assert dynamics.successor[0][3, -1] == size**2 - 2  # west of the last cell
    assert dynamics.successor[0][1, -1] == size**2 - 1  # a wall
    there = solve(spec, dynamics).continuation[0][:, 1]
    assert there[-1] == pytest.approx(0.9 / 0.5, abs=1e-5)
    assert there[0] == pytest.approx(-0.1 / 0.5, abs=1e-5)


def test_more_arrangements_than_can_be_numbered_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from i2pdsl.worlds.grid import planning

    monkeypatch.setattr(planning, "memory_limit", lambda: 2**60)
    row = "    " + "." * 40
    text = "map\n" + "\n".join([row] * 40) + "\ncharacter a\ncharacter b\nobject c\n"
    spec = parse_world(Source("big.world", text), "big")
    with pytest.raises(StoryError, match="4,103,684,801 arrangements") as caught:
        check_memory(spec)
    assert caught.value.diagnostics[0].code == "too-large"


def test_a_single_character_can_be_told_of_from_a_file(tmp_path) -> None:
    text = "map\n    A....B\ntile left\n    symbol = A\ntile right\n    symbol = B\n"
    text += "character robot\n    goals = {left, right}\nplanning\n    gamma = 0.9\n"
    (tmp_path / "hall.world").write_text(text, encoding="utf-8")
    source = Source(
        "s.story", "world hall\nlength 3\nmaximize sum_t P(G_robot = left | script[:t])"
    )
    result = story_from(source, tmp_path).solve(seed=0)
    beliefs = result.script.query("P(G_robot | script[:t])")
    assert beliefs.shape == (4, 2)
    assert beliefs[-1, 0] > 0.9
    words = grid_vocabulary(result.script.world.spec)
    assert set(words.latents) == {"G_robot", "R_robot"}
    with pytest.raises(StoryError):
        check_source(Source("s", "world w\nlength 3\nmaximize depict(rho > 0)"), lambda *_: words)
