"""What the search reaches: against all scripts there are in a small world, and against the search
of before (one pass) and a beam of width 10 in the kitchen.

    python benchmarks/search.py nook       a table of 24 objectives (20 minutes on one core)
    python benchmarks/search.py kitchen    a table of 13, with times (10 minutes)
    python benchmarks/search.py nook late swing    of some of them
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from typing import Any

from brute_force import nook, optimum, story_in
from search_objectives import KITCHEN_OBJECTIVES, NOOK_OBJECTIVES

from i2pdsl.computing import computing
from i2pdsl.errors import Source
from i2pdsl.language.story import TypedStory
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.kind import Watch

SEED = 77


def searched(world: GridWorld, story: TypedStory, effort: int = 1) -> tuple[float, float]:
    """The best score of a search, and its seconds without compiling."""
    from i2pdsl.search.searches import SEARCHES
    from i2pdsl.search.task import Task

    watch = Watch()
    task = Task(story, world, watch, effort)
    found = SEARCHES["beam"].solve(task, SEED, 1)
    return best_of(task, found), watch.seconds["search"]


def best_of(task: Any, found: Any) -> float:
    from i2pdsl.objective.replay import replay
    from i2pdsl.objective.terms import score_script

    frames = (replay(task.world, p.states, p.actions) for p in found.paths)
    return max(score_script(task.story, task.world, each) for each in frames)


def planned_as(story: TypedStory, **settings: int) -> TypedStory:
    return replace(story, search=replace(story.search, **settings))


def nook_table(names: list[str]) -> None:
    world = nook()
    print("| objective | optimum | one pass | default | seconds |\n|---|---|---|---|---|")
    for name in names or NOOK_OBJECTIVES:
        story = story_in(world, 3, NOOK_OBJECTIVES[name])
        best = optimum(world, story)
        before, _ = searched(world, planned_as(story, polish=0))
        now, seconds = searched(world, story)
        print(f"| {name} | {best:.3f} | {gap(best, before)} | {gap(best, now)} | {seconds:.2f} |")
        sys.stdout.flush()


def gap(best: float, reached: float) -> str:
    return "0" if best - reached < 1e-3 else f"-{best - reached:.3f}"


def kitchen_table(names: list[str]) -> None:
    from i2pdsl.stories import story_from

    heads = "| objective | one pass | s | width 10, one pass | s | default | s | effort 10 | s |"
    print(heads + "\n" + "|---" * 9 + "|")
    for name in names or KITCHEN_OBJECTIVES:
        text = f"world kitchen\nlength 15\n{KITCHEN_OBJECTIVES[name]}\n"
        whole = story_from(Source("asked.story", text))
        world, story = whole.world(), whole.typed
        cells = []
        for asked, effort in (
            (planned_as(story, polish=0), 1),
            (planned_as(story, polish=0, width=10), 1),
            (story, 1),
            (story, 10),
        ):
            began = time.perf_counter()
            score, seconds = searched(world, asked, effort)
            cells += [f"{score:.4f}", f"{min(seconds, time.perf_counter() - began):.1f}"]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def main() -> None:
    """Prints a table."""
    which, *names = sys.argv[1:] or ["nook"]
    with computing():
        {"nook": nook_table, "kitchen": kitchen_table}[which](names)


if __name__ == "__main__":
    main()
