"""Whether some initial state fulfils the conditions of `start`, without listing all states."""

from __future__ import annotations

from typing import Any

from i2pdsl.language import typed as ty
from i2pdsl.language.evaluate import OPEN, evaluate
from i2pdsl.language.vocabulary import Vocabulary

Cell = tuple[int, int]
MOST_TRIALS = 20_000  # partial states; beyond them the search for a start decides
_USUAL = 20  # parts of a condition; of longer ones fewer states are tried


def can_start(condition: ty.Typed, world: Vocabulary) -> bool | None:
    """Whether some state fulfils a condition of `at`, `absent` and `adjacent`.

    None where that cannot be told quickly, or not from a map alone. Places one entity after
    another, first those that the condition speaks of, and goes back as soon as it must be false.
    """
    entities = (*world.characters, *world.things)
    named = {a for n in ty.walk(condition) if isinstance(n, ty.Feature) for a in n.arguments}
    order = sorted(range(len(entities)), key=lambda e: (e not in named, e))
    cells = sorted(world.free)
    if not cells:
        return None
    cost = sum(1 for _ in ty.walk(condition))  # of one trial
    trials = 0

    def place(placed: dict[int, Cell | None]) -> bool | None:
        nonlocal trials
        trials += 1
        if trials * max(cost, _USUAL) > MOST_TRIALS * _USUAL:
            return None
        try:
            holds = evaluate(condition, placed, _feature)
        except (ArithmeticError, ValueError):  # 1/(if at(robot, pink) then 0 else 1) > 0
            return None
        if holds is False:
            return False
        if len(placed) == len(order):
            return None if holds is OPEN else True
        entity = order[len(placed)]
        taken = set(placed.values())
        options: list[Cell | None] = [c for c in cells if c not in taken]
        if entities[entity] in world.may_be_absent:
            options.append(None)
        for cell in options:
            found = place({**placed, entity: cell})
            if found is not False:
                return found
        return False

    return place({})


def _feature(node: ty.Feature, placed: dict[int, Cell | None]) -> Any:
    """A predicate's truth where only some entities are placed; OPEN where it is not known."""
    entities = [a for a in node.arguments if isinstance(a, int)]
    if any(e not in placed for e in entities):
        return OPEN
    cells = [placed[e] for e in entities]
    if node.predicate == "absent":
        return cells[0] is None
    first, *others = cells
    if node.predicate == "at":
        return first is not None and first in node.arguments[1]  # type: ignore[operator]
    if node.predicate == "adjacent":
        other = others[0]
        if first is None or other is None:
            return False
        return abs(first[0] - other[0]) + abs(first[1] - other[1]) == 1
    return OPEN
