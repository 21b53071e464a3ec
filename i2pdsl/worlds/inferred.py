"""What characters did, from where everybody was: scripts of worlds whose actions have names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, pairwise
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from i2pdsl.errors import Diagnostic, StoryError, shorten
from i2pdsl.language.vocabulary import STAY, Vocabulary
from i2pdsl.worlds.positions import OPTIONAL, Inferred, Positions
from i2pdsl.worlds.record import Record, Trajectory

if TYPE_CHECKING:
    from i2pdsl.worlds.kind import Kind
    from i2pdsl.worlds.world import World


def inferred_turns(kind: Kind, world: World, table: Positions) -> Inferred:
    """The turns that lead from picture to picture.

    Of the turns that do, those in which the fewest act are taken: who need not have done anything
    stayed, was not blocked and did not fail; who can have been pushed was pushed. An `action` in
    the table decides. Of turns that are alike in that, the first in the order of the world's
    actions is taken. Where it cannot be seen whether somebody was pushed or moved by itself, a
    warning says so.

    Args:
        world: knows what can happen (Kind.rules).

    Raises StoryError that names the frame and who.
    """
    pictures = _pictures(world.vocabulary, table)
    state = _first(kind, world, table, pictures[0])
    frames, unsure = [], []
    for number, (then, now) in enumerate(pairwise(pictures), 1):
        ways, after = _ways(kind, world, state, now)
        if not ways:
            _impossible(kind, world, table, pictures, number, state)
        rows = table.seen[number]
        known = {who: row.action for who, row in rows.items() if row.action is not None}
        left = [way for way in ways if all(_action(way, who) == a for who, a in known.items())]
        if not left:
            _unlike(table, number, ways, known)
        efforts = [_efforts(world.vocabulary, way) for way in left]
        chosen = left[efforts.index(min(efforts))]
        frames.append(chosen)
        unsure += [
            (number, who)
            for who in world.vocabulary.characters
            if now[who] != then[who] and not _moved(chosen, who)
            if any(_moved(way, who) for way in left)
        ]
        state = after
    return Inferred(pictures[0], tuple(frames), _doubts(table, unsure))


def _pictures(words: Vocabulary, table: Positions) -> list[dict[str, Any]]:
    """Where everybody and everything is in each frame. Things need a row only where they move."""
    found: list[dict[str, Any]] = []
    for number, rows in enumerate(table.seen):
        picture: dict[str, Any] = {}
        for name in (*words.characters, *words.things):
            if name in rows:
                row = rows[name]
                whole = row.x is not None and row.y is not None
                if whole and (row.x != int(row.x or 0) or row.y != int(row.y or 0)):
                    table.wrong(number, "places on a map are whole numbers", name)
                picture[name] = [int(row.x or 0), int(row.y or 0)] if whole else None
            elif name in words.characters:
                table.wrong(number, f"where is `{name}`?", name)
            else:
                picture[name] = found[-1][name] if found else None
        found.append(picture)
    return found


def _first(kind: Kind, world: World, table: Positions, picture: dict[str, Any]) -> Any:
    """The first picture in the world's numbers."""
    try:
        return kind.read(world, Record({}, {}, None, picture, (), "table")).start
    except StoryError as problem:
        message = problem.diagnostics[0].message.removeprefix("start: ")
        who = next((name for name in picture if f"`{name}`" in message), "")
        table.wrong(0, message, who, problem.diagnostics[0].hint)


def _ways(
    kind: Kind, world: World, before: Any, picture: dict[str, Any]
) -> tuple[list[dict[str, Any]], Any]:
    """The frames of a script's file that lead from a state to a picture, and the state there."""
    ends = np.asarray(world.endings(world.tables, before))
    codes = np.arange(len(ends))
    if world.vocabulary.events:
        fallen, possible = world.drops(world.tables, before)
        some = np.flatnonzero(possible)
        ends, codes = np.append(ends, fallen[some]), np.append(codes, world.turn_count + some)
    kinds, which = np.unique(ends, return_inverse=True)
    leads = np.array([_on_map(kind.start_as_json(world, end)) == picture for end in kinds])
    found: list[dict[str, Any]] = []
    for code in codes[leads[which]]:
        path = Trajectory(np.array([code]), np.array([before, kinds[leads][0]]))
        (frame,) = kind.frames_as_json(world, path)
        if frame not in found:  # a blocked move that also fails
            found.append(frame)
    return found, kinds[leads][0] if found else None


def _on_map(state: Mapping[str, Any]) -> dict[str, Any]:
    """A state as a table of positions has it: what is carried has none."""
    return {name: None if isinstance(place, str) else place for name, place in state.items()}


def _action(way: Mapping[str, Any], who: str) -> str | None:
    return way[who]["action"] if who in way else None


def _efforts(words: Vocabulary, way: Mapping[str, Any]) -> int:
    """How many act in a frame."""
    return sum(_action(way, who) not in (STAY, None) for who in words.characters)


def _moved(way: Mapping[str, Any], who: str) -> bool:
    """Whether somebody moved by itself in a frame."""
    return who in way and way[who]["moved"]


def _impossible(
    kind: Kind,
    world: World,
    table: Positions,
    pictures: Sequence[dict[str, Any]],
    number: int,
    before: Any,
) -> NoReturn:
    """Says who cannot have come where it is said to be."""
    then, now = pictures[number - 1], pictures[number]
    for name, place in now.items():
        if place is not None and tuple(place) not in world.vocabulary.free:
            table.wrong(number, f"`{name}` cannot stand at {place}: there is no free cell", name)
    for one, other in combinations([name for name in now if now[name] is not None], 2):
        if now[one] == now[other]:
            table.wrong(number, f"`{one}` and `{other}` stand on one cell, {now[one]}", other)
    ends = np.unique(world.endings(world.tables, before))
    reached = [_on_map(kind.start_as_json(world, end)) for end in ends]
    for name, place in now.items():
        if place == then[name] or any(end[name] == place for end in reached):
            continue
        if place is None:
            table.wrong(number, f"`{name}` cannot vanish", name)
        if then[name] is None:
            table.wrong(number, f"`{name}` cannot fall there while others move", name)
        hint = f"from {then[name]} it can get to {_listed(end[name] for end in reached)}"
        table.wrong(number, f"`{name}` cannot get from {then[name]} to {place}", name, hint)
    moved = [name for name in now if now[name] != then[name]]
    still = [name for name in now if now[name] == then[name]]
    stuck = [name for name in still if all(end[name] != now[name] for end in reached)]
    names = " and ".join(f"`{name}`" for name in moved)
    why = f"`{stuck[0]}` would have been moved" if stuck else None
    table.wrong(
        number, f"{names or 'nobody'} cannot have moved so at once", next(iter(moved), ""), why
    )


def _listed(places: Iterable[Any]) -> str:
    return ", ".join(dict.fromkeys(str(place) for place in places))


def _unlike(
    table: Positions, number: int, ways: Sequence[Mapping[str, Any]], known: Mapping[str, str]
) -> NoReturn:
    """Says whose action does not lead where the table says."""
    for who, action in known.items():
        possible = dict.fromkeys(_action(way, who) for way in ways)
        if action not in possible:
            others = ", ".join(act for act in possible if act is not None)
            hint = f"it can have been {others}" if others else "something fell, nobody acts"
            table.wrong(number, f"`{who}` ends elsewhere by `{action}`", who, hint)
    table.wrong(number, "these actions together lead elsewhere", next(iter(known)))


def _doubts(table: Positions, unsure: Sequence[tuple[int, str]]) -> tuple[Diagnostic, ...]:
    found = []
    for who in dict.fromkeys(name for _, name in unsure):
        frames = [str(number) for number, name in unsure if name == who]
        told = f"frame{'s' * (len(frames) > 1)} {shorten(', '.join(frames))}"
        message = (
            f"`{who}` may have moved by itself or been pushed in {told}; it is taken as pushed"
        )
        hint = f"a column `{OPTIONAL}` says otherwise"
        found.append(Diagnostic("positions", message, table.place, hint, severity="warning"))
    return tuple(found)
