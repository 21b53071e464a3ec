"""From a map of another tool to the text of a world. No JAX."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from dataclasses import dataclass

from i2pdsl.errors import Source, Span, error
from i2pdsl.untrusted import is_plain_name
from i2pdsl.worlds.grid.foreign import gems, minigrid, restaurants, sokoban
from i2pdsl.worlds.grid.foreign.level import Level, Part
from i2pdsl.worlds.grid.map import SYNTAX
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.spec import NO_GOAL, Cell, GridSpec
from i2pdsl.worlds.kind import Imported

MANY_STATES = 2_000_000  # from which on only those are planned for that can be reached in time
USUAL_HORIZON = 20
USUAL_LENGTH = 10
_WIDTH = 96  # characters of a line of a comment
_SIGNS = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"


@dataclass(frozen=True)
class Format:
    """What is read of another tool: a name for people, whether a text is one, and its reader."""

    what: str
    recognises: Callable[[Source], bool]
    read: Callable[[Source, int], Level]


# The first that recognises a text reads it.
FORMATS = tuple(
    Format(each.WHAT, each.recognises, each.read) for each in (restaurants, minigrid, gems, sokoban)
)


def read_level(source: Source, number: int) -> Level:
    """The map in a text, whatever tool it is of. Raises StoryError."""
    if not source.text.strip():
        raise error("empty", "the file is empty", Span(source, 0, 0))
    found = next((each for each in FORMATS if each.recognises(source)), None)
    if found is None:
        first = len(source.text) - len(source.text.lstrip())
        hint = f"known: {', '.join(each.what for each in FORMATS)}"
        message = "this is a map of no tool that is known here"
        raise error("world-map", message, Span(source, first, first + 1), hint)
    if number > 1 and found.read is not sokoban.read:
        message = f"there is one level in this file, no level {number}"
        raise error("range", message, Span(source, 0, 1))
    return found.read(source, number)


def imported(source: Source, file: str, name: str, number: int) -> Imported:
    """What a map of another tool comes to. Raises StoryError."""
    level = read_level(source, number)
    text = _world_text(level, file, name)
    spec = _spec(text, name)
    actor = spec.characters[0]
    goals, length = [goal for goal in actor.goals if goal != NO_GOAL], USUAL_LENGTH
    if actor.cell is not None:
        ways = _ways(level, spec, actor.cell)
        goals = sorted((goal for goal in goals if goal in ways), key=lambda goal: ways[goal])
        length = ways[goals[0]] + 4 if goals else length
    length = max(6, min(length, 30, spec.settings.horizon or 30))
    return Imported(level.what, text, level.notes, actor.name, tuple(goals), length)


def _ways(level: Level, spec: GridSpec, start: Cell) -> dict[str, int]:
    """About how many steps each tile is away that can be reached at all."""
    doors = {cell for thing in spec.things if thing.opened_by for cell in thing.cells}
    near, far = level.steps_from(start, doors), level.steps_from(start)
    # A way through a locked door leads past its key first.
    steps = {cell: near.get(cell, 2 * far[cell]) for cell in far}
    return {
        tile.name: min(steps[cell] for cell in tile.cells)
        for tile in spec.tiles
        if steps.keys() >= {*tile.cells}
    }


def _world_text(level: Level, file: str, name: str) -> str:
    """The text of the world, in the usual layout, with what is otherwise at its head."""
    text = _text(level, file)
    spec = _spec(text, name)
    if spec.state_count > MANY_STATES and None not in spec.placed:
        text += f"# So that of {spec.state_count:,} states only those are planned for that can be\n"
        text += f"# reached in time.\nplanning\n    horizon = {USUAL_HORIZON}\n"
    return SYNTAX.formatted(Source(f"{name}.world", text))


def _spec(text: str, name: str) -> GridSpec:
    return parse_world(Source(f"{name}.world", text), name)


def _text(level: Level, file: str) -> str:
    about = level.what[0].upper() + level.what[1:]
    about += f", from {file}." if is_plain_name(file) else "."
    head = [_comment(about), "#", *map(_comment, level.notes)]
    signs: dict[str, str] = {}
    drawn: dict[Cell, str] = {}
    # Who stands somewhere is drawn there; a tile below it says its cell.
    order = sorted(level.parts, key=lambda part: (len(part.cells) < 2, part.keyword == "tile"))
    for part in order:
        if part.cells and not any(cell in drawn for cell in part.cells):
            signs[part.name] = _sign(part, set(signs.values()))
            drawn.update(dict.fromkeys(part.cells, signs[part.name]))
    rows = [
        "".join(drawn.get((c, r), sign) for c, sign in enumerate(row))
        for r, row in enumerate(level.rows)
    ]
    blocks = [
        "\n    ".join([f"{part.keyword} {part.name}", *_place(part, signs), *_keys(part)])
        for part in level.parts
    ]
    return "\n".join([*head, "\n    ".join(["map", *rows]), *blocks]) + "\n"


def _comment(text: str) -> str:
    lines = textwrap.wrap(text, _WIDTH, break_long_words=False, break_on_hyphens=False)
    return "\n".join(f"# {line}" for line in lines)


def _sign(part: Part, others: set[str]) -> str:
    """A letter for a part: its name's, small for who acts, else the first that is free. Beyond
    those no part is drawn; it says its cell."""
    first = part.name[0] if part.keyword != "tile" else part.name[0].upper()
    wanted = (first, first.swapcase(), *(sign for sign in part.name if sign.isalnum()), *_SIGNS)
    return next(sign for sign in wanted if sign not in others)


def _place(part: Part, signs: dict[str, str]) -> tuple[str, ...]:
    if part.name in signs:
        return (f"symbol = {signs[part.name]}",)
    return tuple(f"cell = ({column}, {row})" for column, row in part.cells)


def _keys(part: Part) -> list[str]:
    named = [f"{key} = {{{', '.join(names)}}}" for key, names in part.names if names]
    return [*named, *part.lines]
