"""Goals that nobody can reach, or that are not worth the way: warnings, from the map alone."""

from __future__ import annotations

import math
import re
from collections import deque
from functools import lru_cache

from i2pdsl.errors import Diagnostic, Source, Span
from i2pdsl.worlds.grid.spec import NO_GOAL, OFFSETS, Character, GridSpec, Settings

Cell = tuple[int, int]


@lru_cache(maxsize=64)
def goal_warnings(spec: GridSpec, file: str) -> tuple[Diagnostic, ...]:
    """Warnings of goals that cannot be reached, or not be worth reaching, from some cells.

    What is worth it is what a character alone would do; things in the way are left aside.

    Args:
        spec: the world, with the story's settings.
        file: the name of its file.
    """
    source = Source(file, spec.source)
    tiles = {tile.name: tile.cells for tile in spec.tiles}
    found = []
    for c in spec.characters:
        for goal in c.goals:
            if goal != NO_GOAL:
                steps = _steps(spec, tiles[goal])
                for message, hint in (
                    _walled_off(spec, c, goal, steps),
                    _far(spec, c, goal, steps),
                ):
                    if message:
                        span = _place(source, c.name, goal)
                        warning = Diagnostic("world-goal", message, span, hint, severity="warning")
                        found.append(warning)
    return tuple(found)


def _steps(spec: GridSpec, cells: tuple[Cell, ...]) -> dict[Cell, int]:
    """The length of the shortest way to a goal from each cell from which there is one."""
    free = set(spec.free_cells)
    steps = dict.fromkeys(cells, 0)
    queue = deque(cells)
    while queue:
        column, row = queue.popleft()
        for dx, dy in OFFSETS:
            near = (column + dx, row + dy)
            if near in free and near not in steps:
                steps[near] = steps[column, row] + 1
                queue.append(near)
    return steps


def _walled_off(
    spec: GridSpec, c: Character, goal: str, steps: dict[Cell, int]
) -> tuple[str, str | None]:
    cells = len(spec.free_cells)
    missed = cells - len(steps)
    if not missed:
        return "", None
    hint = "open a way on the map; where there is none, viewers cannot tell that someone wants it"
    if not any(steps.values()):
        return f"{c.name} can never get to `{goal}`: no way leads there", hint
    return f"{c.name} cannot get to `{goal}` from {missed:,} of the {cells:,} cells", hint


def _far(spec: GridSpec, c: Character, goal: str, steps: dict[Cell, int]) -> tuple[str, str | None]:
    numbers = spec.settings
    farthest = max(steps.values())
    limit = worthwhile_steps(numbers, c.success, farthest)
    if limit >= farthest:
        return "", None
    costs = f"a move pays {numbers.move:g}, staying {numbers.stay:g}"
    costs += f", and the goal {numbers.goal:g} a turn more"
    wanted = _goal_for(numbers, c.success, farthest)
    hint = f"{costs} (gamma = {numbers.gamma:g})"
    if wanted is not None:
        hint += f"; with `goal = {wanted:g}` it would pay from everywhere"
    if limit == 0:
        return f"it never pays for {c.name} to go to `{goal}`: staying is better", hint
    beyond = sum(n > limit for n in steps.values())
    message = (
        f"from {limit + 1} steps on it does not pay for {c.name} to walk to `{goal}`: staying is "
        f"better on {beyond:,} of the {len(spec.free_cells):,} cells"
    )
    return message, hint


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
