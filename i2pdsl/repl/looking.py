"""A frame of a script in characters: the map of a grid world, the figures on the hill."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from i2pdsl.errors import display_width, padded
from i2pdsl.repl.curves import Canvas, Ink
from i2pdsl.repl.texts import laid_out
from i2pdsl.scripts import Script
from i2pdsl.search.grid_script import state_as_json, turn_in_words
from i2pdsl.worlds.grid.spec import WALL, GridSpec
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.hill.hopper import BONES, CRATE, HOPPER, MUSCLES, NODE_COUNT, ROPE
from i2pdsl.worlds.hill.world import HillWorld


def frame_in_words(script: Script, frame: int) -> str:
    """What the characters do in a frame; the start has nothing."""
    if frame == 0:
        return "the start"
    if isinstance(script.world, GridWorld):
        return turn_in_words(script.world, int(script.trajectory.actions[frame - 1]))[1:-1]
    residual = np.asarray(script.trajectory.actions[frame - 1])
    if not residual.any():
        return "the hopper's own motion"
    return f"muscles changed by {', '.join(f'{x:+.2f}' for x in residual)}"


def frame_picture(script: Script, frame: int, ink: Ink) -> str:
    """Where everybody is after a frame."""
    state = script.trajectory.states[frame]
    if isinstance(script.world, GridWorld):
        return _map(script.world, int(state), ink)
    assert isinstance(script.world, HillWorld)
    return _hill(script.world, np.asarray(state, float), ink)


def _map(world: GridWorld, state: int, ink: Ink) -> str:
    spec = world.spec
    places = state_as_json(spec, world.dynamics, state)
    letters = _letters(spec.entities)
    floor, wall = ("·", "█") if ink.unicode else (".", "#")
    signs = (*letters.values(), *(tile.name[0].lower() for tile in spec.tiles))
    wide = max(map(display_width, signs), default=1)
    wall, floor = wall * wide, padded(floor, wide)
    rows = [[wall if symbol == WALL else floor for symbol in row] for row in spec.rows]
    for tile in spec.tiles:
        for column, row in tile.cells:
            sign = padded(tile.name[0].lower(), wide)
            rows[row][column] = ink.paint(sign, _colour(tile.color))
    for name, place in places.items():
        if place is not None:
            sign = padded(letters[name], wide)
            rows[place[1]][place[0]] = ink.paint(sign, f"1;{_colour(_look(spec, name))}")
    told = [
        (letters[name], f"1;{_colour(_look(spec, name))}", name + ("" if place else " (absent)"))
        for name, place in places.items()
    ]
    told += [(tile.name[0].lower(), _colour(tile.color), tile.name) for tile in spec.tiles]
    legend = [(f"{sign} {name}", f"{ink.paint(sign, code)} {name}") for sign, code, name in told]
    lines = ["    " + " ".join(row) for row in rows]
    return "\n".join((*lines, *laid_out(legend, 2, 4, ink.columns)))


def _letters(names: Iterable[str]) -> dict[str, str]:
    """A capital letter for each, as near to the front of its name as others leave it."""
    found: dict[str, str] = {}
    for name in names:
        free = [c.upper() for c in name if c.isalpha() and c.upper() not in found.values()]
        found[name] = free[0] if free else "?"
    return found


def _look(spec: GridSpec, name: str) -> str:
    colours = {c.name: c.color for c in spec.characters}
    return (colours | {t.name: t.color for t in spec.things})[name]


def _colour(value: str) -> str:
    """A colour of the world as a code of ANSI terminals."""
    red, green, blue = (int(value[i : i + 2], 16) for i in (1, 3, 5))
    return f"38;2;{red};{green};{blue}"


def _hill(world: HillWorld, state: np.ndarray, ink: Ink) -> str:
    """The hopper, the rope and the box on the slope, as lines of dots."""
    x, y = state[: 2 * NODE_COUNT].reshape(2, NODE_COUNT)
    canvas = Canvas(min(72, ink.columns - 6), 14, ink)
    across, down = canvas.size
    left, right = float(x.min()) - 2, float(x.max()) + 2
    slope = np.tan(world.spec.settings.slope)
    low = min(float(y.min()), left * slope) - 0.5
    # A character is about twice as high as it is wide.
    shape = 1.0 if canvas.fine else 2.0
    scale = min((across - 1) / (right - left), (down - 1) * shape / (float(y.max()) - low + 0.5))

    def place(px: float, py: float) -> tuple[float, float]:
        return (px - left) * scale, down - 1 - (py - low) * scale / shape

    end = left + (across - 1) / scale
    canvas.line(*place(left, left * slope), *place(end, end * slope), 5)
    for number, springs in ((3, ROPE), (0, CRATE), (1, BONES), (1, MUSCLES)):
        for first, second in springs:
            ends = (x[first], y[first]), (x[second], y[second])
            canvas.line(*place(*ends[0]), *place(*ends[1]), number)
    told = f"hopper at x = {x[list(HOPPER)].mean():.1f}, box at x = {x[11:].mean():.1f}"
    return "\n".join((*("    " + line for line in canvas.lines()), f"    {told}"))
