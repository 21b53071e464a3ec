"""The best of all scripts that there are, found by scoring them all, in a small world.

All scripts are listed by the world's tables in NumPy, all frames but the last are followed one by
one, and the last ones are scored side by side, in single precision; the best is scored again in
doubles.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from search_objectives import NOOK

from i2pdsl.errors import Source
from i2pdsl.language.check import Library, TypedStory, check_source
from i2pdsl.worlds.grid.dynamics import build_dynamics
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.planning import solve
from i2pdsl.worlds.grid.world import GridWorld, assemble
from i2pdsl.worlds.world import Viewer

BLOCK = 4096  # scripts that are followed side by side


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
        worth = children(world, objective, (), tables, params, jnp.bool_(False), node).worth
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
