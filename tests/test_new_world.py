"""The kind of world that docs/new-world.md makes, held against its equations and brute force."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from corridor_for_tests import PAGE, STEPS, Watched, corridor
from documents_for_tests import blocks
from i2pdsl.errors import Source, StoryError
from i2pdsl.scripts import Script
from i2pdsl.stories import script_from, story_from

STORY = """\
world "hall.world"
length {length}
start at(walker, (2, 0))
maximize depict(G_walker = {goal})
"""


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with corridor(tmp_path_factory.mktemp("corridor")) as folder:
        yield folder


def walked(hall: Path, goal: str, length: int) -> Script:
    """A script of somebody who does what is best for him."""
    text = STORY.format(length=length, goal=goal)
    return story_from(Source("s.story", text), hall).solve(seed=1, naive=True).script


def test_beliefs_are_bayes_rule(hall: Path) -> None:
    script = walked(hall, "right", 4)
    walk = Watched([tuple(STEPS)[int(a)] for a in script.trajectory.actions])
    assert script.trajectory.states.tolist() == walk.cells
    believed = script.query("P(G_walker = right | script[:t])")
    assert np.allclose(believed, [belief["right"] for belief in walk.beliefs], atol=1e-12)


def test_a_naive_walker_goes_straight_to_his_end(hall: Path) -> None:
    assert walked(hall, "left", 4).trajectory.states.tolist()[:3] == [2, 1, 0]


def test_scripts_are_read_again_or_refused(hall: Path, tmp_path: Path) -> None:
    script = walked(hall, "right", 4)
    again = script_from(script.record, hall)
    assert np.array_equal(again.trajectory.states, script.trajectory.states)
    script.record.frames[1]["state"]["walker"] = [0, 0]
    with pytest.raises(StoryError, match="frame 2: by the world's rules"):
        script_from(script.record, hall)


def test_the_page_counts_its_lines() -> None:
    text = PAGE.read_text(encoding="utf-8")
    python = [b.text for b in blocks(text) if str(b.option("file")).endswith(".py")]
    count = sum(bool(line.strip()) for part in python for line in part.splitlines())
    (said,) = re.findall(r"(\d+) lines\s+of\s+Python", text)
    assert int(said) == count


def test_a_file_of_no_kind_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.world").write_text("# No such kind.\nkind = gird\n", encoding="utf-8")
    with pytest.raises(StoryError, match="no kind of world `gird`") as wrong:
        story_from(Source("s.story", 'world "x.world"\nlength 3\nsearch naive\n'), tmp_path)
    assert "grid" in (wrong.value.diagnostics[0].hint or "")
