"""What the search reaches: against all scripts there are in a small world, and against the search
of before (one pass) and a beam of width 10 in the kitchen.

    python benchmarks/search.py nook       a table of 24 objectives (20 minutes on one core)
    python benchmarks/search.py kitchen    a table of 13, with times (10 minutes)
    python benchmarks/search.py nook late swing    of some of them

All scripts are listed by the world's tables in NumPy, all frames but the last are followed one by
one, and the last ones are scored side by side, in single precision; the best is scored again in
doubles.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from typing import Any

import numpy as np
from search_objectives import KITCHEN_OBJECTIVES, NOOK, NOOK_OBJECTIVES

from i2pdsl.computing import computing
from i2pdsl.errors import Source
from i2pdsl.language.check import Library, TypedStory, check_source
from i2pdsl.worlds.grid.dynamics import build_dynamics
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.planning import solve
from i2pdsl.worlds.grid.world import GridWorld, assemble
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.world import Viewer

SEED, BLOCK = 77, 4096


def nook() -> GridWorld:
    spec = parse_world(Source("nook.world", NOOK), "nook")
    dynamics = build_dynamics(spec)
    return assemble(spec, dynamics, (Viewer(spec),), [solve(spec, dynamics, tolerance=1e-10)])


def story_in(world: GridWorld, length: int, objective: str) -> TypedStory:
    source = Source("asked.story", f"world {world.name}\nlength {length}\n{objective}\n")
    checked = check_source(source, lambda *_: world.vocabulary)
    assert not isinstance(checked, Library)
    return checked


def prefixes(world: GridWorld, length: int) -> tuple[np.ndarray, np.ndarray]:
    """All scripts of a length, as starts [n] and actions [n, length]."""
    ahead = world.turns(world.tables, world.starts())
    starts = states = world.starts()
    actions = np.zeros((len(starts), 0), np.int64)
    for _ in range(length):
        i, action = np.nonzero(ahead.valid[states])
        starts, states = starts[i], ahead.state[states[i], action]
        actions = np.concatenate([actions[i], action[:, None]], axis=1)
    return starts, actions


def optimum(world: GridWorld, story: TypedStory) -> float:
    """The score of the best of all scripts, in doubles."""
    import jax
    import jax.numpy as jnp

    from i2pdsl.objective.replay import replay
    from i2pdsl.objective.terms import score_script, story_objective
    from i2pdsl.search.beam import prepared
    from i2pdsl.search.rollout import children, follow, root
    from i2pdsl.worlds.record import empty, extended

    objective = story_objective(story, world)
    tables = world.search_tables
    params = jax.tree.map(jnp.asarray, prepared(world, objective))

    def best(start: Any, actions: Any) -> tuple[Any, Any]:
        node = root(world, objective, tables, params, start)
        for t in range(story.length - 1):
            node, _ = follow(world, objective, tables, params, node, actions[t])
        frames, real = children(world, tables, node, ())
        step = lambda frame: objective.step(tables, params, node.carry, frame)
        worth = jax.vmap(lambda f: objective.score(tables, params, step(f), f))(frames)
        worth = jnp.where(real & jnp.isfinite(worth), worth, -jnp.inf)
        return worth.max(), worth.argmax()

    run = jax.jit(jax.vmap(best))
    starts, actions = prefixes(world, story.length - 1)
    found: list[tuple[float, int, int]] = []
    for i in range(0, len(starts), BLOCK):
        number = np.resize(np.arange(i, min(i + BLOCK, len(starts))), BLOCK)
        given = (starts[number].astype(np.int32), actions[number].astype(np.int32))
        worth, last = (np.asarray(x) for x in run(*given))
        top = int(worth.argmax())
        found.append((float(worth[top]), int(number[top]), int(last[top])))
    worth, number, last = max(found)
    script = np.append(actions[number], last)
    path = extended(world, empty(world, starts[number]), script)
    exact = score_script(story, world, replay(world, path.states, path.actions))
    assert abs(exact - worth) < 1e-3, (exact, worth)
    return exact


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
    from i2pdsl.pipeline import story_from

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
