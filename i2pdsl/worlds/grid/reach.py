"""Goals that nobody can reach, or that are not worth the way: warnings, from the map alone."""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Collection, Iterable
from collections.abc import Set as AbstractSet
from functools import lru_cache

from i2pdsl.errors import Diagnostic, Source, Span
from i2pdsl.language import typed as ty
from i2pdsl.worlds.grid.spec import NO_GOAL, OFFSETS, Character, GridSpec, Settings

Cell = tuple[int, int]

POCKET = 0.1  # of the cells, from which a goal may be out of reach without a warning


@lru_cache(maxsize=64)
def goal_warnings(
    spec: GridSpec, file: str, start: ty.Typed | None = None, length: int = 0
) -> tuple[Diagnostic, ...]:
    """Warnings of goals that cannot be reached, or are not worth reaching, from some cells.

    What is worth it is what a character alone would do; things in the way are left aside.

    Args:
        spec: the world, with the story's settings.
        file: the name of its file.
        start, length: of the story, if there is one; with a `start` that says where a character
            stands, only the cells to which it can get are looked at.
    """
    source = Source(file, spec.source)
    tiles = {tile.name: tile.cells for tile in spec.tiles}
    found = []
    for number, c in enumerate(spec.characters):
        free, walls = set(spec.free_cells), set(spec.walls)
        # Nobody is told of from a single cell between walls.
        cells = {cell for cell in free if any(near in free for near in _near(cell))} or free
        placed = {c.cell} if c.cell else _cells_at(start, number)
        if placed is not None:
            frames = length or spec.settings.horizon or len(free)
            turns = frames * len(spec.characters)  # one's own steps and those of being pushed
            cells = {cell for cell, n in steps_to(placed & free, free, walls).items() if n <= turns}
        places = dict(c.supposes)
        for goal in dict.fromkeys(tile for g in c.goals for tile in places.get(g, (g,))):
            if goal == NO_GOAL or not cells:
                continue
            steps = steps_to(tiles[goal], free, walls)
            if c.diagonals:  # a way takes at least half as many steps
                steps = {cell: (n + 1) // 2 for cell, n in steps.items()}
            ways = [steps.get(cell) for cell in cells]
            for told in (_walled_off(spec, c, goal, ways), _far(spec, c, goal, ways)):
                if told is not None:
                    place = _place(source, c.name, goal)
                    found.append(Diagnostic("world-goal", told[0], place, told[1], (), "warning"))
    return tuple(found)


def _cells_at(start: ty.Typed | None, number: int) -> set[Cell] | None:
    """The cells where a `start` puts a character, if it says so plainly."""
    if isinstance(start, ty.Feature) and start.predicate == "at":
        who, places = start.arguments
        return set(places) if who == number and isinstance(places, tuple) else None
    if isinstance(start, ty.Apply) and start.operation == "and":
        sets = [s for s in (_cells_at(a, number) for a in start.arguments) if s is not None]
        return set.intersection(*sets) if sets else None
    return None


def steps_to(
    cells: Iterable[Cell], free: AbstractSet[Cell], walls: Collection[tuple[Cell, Cell]] = ()
) -> dict[Cell, int]:
    """The length of the shortest way over free cells to some from each from which there is one.

    Args:
        walls: pairs of cells with a wall between them.
    """
    steps = dict.fromkeys(cells, 0)
    queue = deque(steps)
    while queue:
        cell = queue.popleft()
        for near in _near(cell):
            closed = (cell, near) in walls or (near, cell) in walls
            if near in free and near not in steps and not closed:
                steps[near] = steps[cell] + 1
                queue.append(near)
    return steps


def _near(cell: Cell) -> list[Cell]:
    return [(cell[0] + dx, cell[1] + dy) for dx, dy in OFFSETS if (dx, dy) != (0, 0)]


def _walled_off(
    spec: GridSpec, c: Character, goal: str, ways: list[int | None]
) -> tuple[str, str] | None:
    missed = ways.count(None)
    # A small part that is closed off is not what stories are about.
    if missed < POCKET * len(ways):
        return None
    hint = "open a way on the map: viewers cannot tell who wants what is out of reach"
    if not any(ways):
        return f"{c.name} can never get to `{goal}`: no way leads there", hint
    where = f"from {missed:,} of {len(ways):,} cells"
    return f"{c.name} can get to `{goal}` from some places only: no way leads there {where}", hint


def _far(spec: GridSpec, c: Character, goal: str, ways: list[int | None]) -> tuple[str, str] | None:
    numbers = spec.settings
    if numbers.horizon:  # what pays depends on how many frames are left
        return None
    known = [n for n in ways if n is not None]
    farthest = max(known, default=0)
    limit = worthwhile_steps(numbers, c.success, farthest)
    if limit >= farthest:
        return None
    hint = f"a move pays {numbers.move:g}, staying {numbers.stay:g}, and the goal "
    hint += f"{numbers.goal:g} a turn more (gamma = {numbers.gamma:g})"
    wanted = _goal_for(numbers, c.success, farthest)
    if wanted is not None:
        hint += f"; with `goal = {wanted:g}` it would pay from everywhere"
    if limit == 0:
        return f"it never pays for {c.name} to go to `{goal}`: staying is better", hint
    beyond = sum(n > limit for n in known)
    message = f"from {limit + 1} steps on it does not pay for {c.name} to walk to `{goal}`: "
    return f"{message}staying is better on {beyond:,} of {len(ways):,} cells", hint


def worthwhile_steps(numbers: Settings, success: float, farthest: int) -> int:
    """The longest way, up to `farthest`, that is better than staying where one is for ever."""
    if numbers.move >= numbers.stay and numbers.goal >= 0:
        return farthest  # walking costs nothing
    gamma = numbers.gamma
    forever = numbers.stay / (1 - gamma)
    value = (numbers.goal + numbers.stay) / (1 - gamma)
    for steps in range(farthest):
        value = (numbers.move + gamma * success * value) / (1 - gamma * (1 - success))
        if value <= forever:
            return steps
    return farthest


def _goal_for(numbers: Settings, success: float, farthest: int) -> float | None:
    """A reward of the goal for which a way of `farthest` steps pays, if a sensible one does."""
    gamma = numbers.gamma
    value = numbers.stay / (1 - gamma)
    for _ in range(farthest):
        if gamma == 0 or abs(value) > 1e9:
            return None
        value = (value * (1 - gamma * (1 - success)) - numbers.move) / (gamma * success)
    goal = value * (1 - gamma) - numbers.stay
    step = 10.0 ** (math.floor(math.log10(max(abs(goal), 1e-6))) - 1)
    rounded = (math.floor(goal / step) + 1) * step
    return rounded if rounded <= 1e6 else None


def _place(source: Source, character: str, goal: str) -> Span:
    """Where a character's block names a goal, or the block, or the file."""
    block = re.search(
        rf"^character[ \t]+{re.escape(character)}\b(.*\n?)([ \t].*\n?|\s*\n|#.*\n)*",
        source.text,
        re.MULTILINE,
    )
    if block is None:
        return Span(source, 0, 0)
    named = re.compile(rf"^\s*goals\s*=[^#}}]*?\b({re.escape(goal)})\b", re.MULTILINE)
    found = named.search(source.text, block.start(), block.end())
    if found is None:
        return Span(source, block.start(), block.start() + len("character"))
    return Span(source, *found.span(1))
