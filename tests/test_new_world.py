"""The kind of world that docs/new-world.md makes, held against its equations and brute force."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.stories import Result, script_from, story_from
from i2pdsl.worlds.kinds import KINDS, Place
from test_docs import ROOT, blocks

CELLS, ENDS, STEPS = 5, (0, 4), (-1, 1, 0)
STORY = """\
world "hall.world"
length {length}
start at(walker, (2, 0))
maximize {objective}
search beam(width = 300)
"""


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a corridor, whose kind is in the table meanwhile."""
    folder = tmp_path_factory.mktemp("corridor")
    for block in blocks((ROOT / "docs" / "new-world.md").read_text(encoding="utf-8")):
        name = block.option("file")
        if name is not None:
            (folder / name).write_text(block.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    KINDS["corridor"] = Place("corridor_kind", "corridor_drawing")
    yield folder
    del KINDS["corridor"]
    sys.path.remove(str(folder))
    for name in [n for n in sys.modules if n.startswith("corridor_")]:
        del sys.modules[name]


def beliefs(actions: tuple[int, ...], beta: float = 2.0) -> tuple[list[int], list[float], float]:
    """The cells, P(right) after each frame, by Bayes' rule word for word, and what the frames cost:
    a fifth of a point for each nat of regret and for each frame in which nobody moves."""
    cells, belief = [2], [0.5, 0.5]
    told, cost = [0.5], 0.0
    for action in actions:
        here = cells[-1]
        ways = [min(max(here + step, 0), CELLS - 1) for step in STEPS]
        regrets = []
        for goal, end in enumerate(ENDS):
            weights = [math.exp(-beta * abs(way - end)) for way in ways]
            belief[goal] *= weights[action] / sum(weights)
            regrets.append(math.log(max(weights) / weights[action]))
        total = sum(belief)
        belief = [b / total for b in belief]
        cost += 0.2 * sum(b * r for b, r in zip(belief, regrets, strict=True))
        cost += 0.2 * (ways[action] == here)
        cells.append(ways[action])
        told.append(belief[1])
    return cells, told, cost


def solved(hall: Path, objective: str, length: int) -> Result:
    text = STORY.format(length=length, objective=objective)
    return story_from(Source("s.story", text), hall).solve(seed=0)


def test_beliefs_are_bayes_rule(hall: Path) -> None:
    script = solved(hall, "depict(G_walker = right)", 4).script
    cells, told, _ = beliefs(tuple(int(a) for a in script.trajectory.actions))
    assert script.trajectory.states.tolist() == cells
    assert np.allclose(script.query("P(G_walker = right | script[:t])"), told, atol=1e-12)


def test_the_beam_finds_what_brute_force_finds(hall: Path) -> None:
    found = solved(hall, "P(G_walker = left | script[:2]) + P(G_walker = right | script[:5])", 5)
    best = max(
        1 - told[2] + told[5] - cost
        for _, told, cost in (beliefs(actions) for actions in product(range(3), repeat=5))
    )
    assert found.score == pytest.approx(best, abs=1e-6)


def test_a_naive_walker_goes_straight_to_his_end(hall: Path) -> None:
    text = STORY.format(length=4, objective="depict(G_walker = left)")
    script = story_from(Source("s.story", text), hall).solve(seed=1, naive=True).script
    assert script.trajectory.states.tolist()[:3] == [2, 1, 0]


def test_scripts_are_read_again_or_refused(hall: Path, tmp_path: Path) -> None:
    script = solved(hall, "depict(G_walker = right)", 4).script
    again = script_from(script.record, hall)
    assert np.array_equal(again.trajectory.states, script.trajectory.states)
    script.record.frames[1]["state"]["walker"] = 0
    with pytest.raises(StoryError, match="frame 2: by the world's rules"):
        script_from(script.record, hall)


def test_a_file_of_no_kind_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.world").write_text("# No such kind.\nkind = gird\n", encoding="utf-8")
    with pytest.raises(StoryError, match="no kind of world `gird`") as wrong:
        story_from(Source("s.story", 'world "x.world"\nlength 3\nsearch naive\n'), tmp_path)
    assert "grid" in (wrong.value.diagnostics[0].hint or "")
