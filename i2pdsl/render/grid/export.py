"""What other programs animate a story on a map with: the cast as a sprite sheet, and the story as
a timeline (docs/export.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from i2pdsl.render import export
from i2pdsl.render.grid.scene import (
    FOOT,
    LARGEST_SCENE,
    labels_svg,
    margin,
    scene_size,
    stage_background,
    svg_document,
)
from i2pdsl.render.grid.sprites import actor_symbols, actor_tint, mark_symbols, symbol_id
from i2pdsl.render.grid.stage import Stage
from i2pdsl.render.grid.tracks import GRIP, MARKS, POSES, Film, Track
from i2pdsl.render.mind import Panel
from i2pdsl.render.raster import svg_rgba

CELL = 128  # pixels of a cell in the sheet
ROOM = 24  # pixels about a cell that drawings may reach into
SIDE = CELL + 2 * ROOM
COLUMNS = 8


def sheet(stage: Stage) -> tuple[np.ndarray, dict[str, Any]]:
    """All poses of the cast, and the marks: RGBA [height, width, 4], and where each stands."""
    drawn: list[str] = []
    frames: dict[str, dict[str, list[int]]] = {}
    row = 0
    groups = [(a.name, {pose: symbol_id(a, pose) for pose in POSES}) for a in stage.cast]
    kinds = (*MARKS, GRIP) if stage.pulls else MARKS
    groups.append(("", {mark: f"mark--{mark}" for mark in kinds}))  # nobody is called so
    for name, symbols in groups:
        frames[name] = {}
        for number, (pose, symbol) in enumerate(symbols.items()):
            x, y = number % COLUMNS * SIDE, (row + number // COLUMNS) * SIDE
            frames[name][pose] = [x, y]
            place = f"translate({x + ROOM} {y + ROOM}) scale({CELL / 100})"
            drawn.append(f'<use href="#{symbol}" transform="{place}"/>')
        row += -(-len(symbols) // COLUMNS)
    symbols_svg = "".join(actor_symbols(actor) for actor in stage.cast) + mark_symbols(stage)
    picture = svg_rgba(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{COLUMNS * SIDE}" height="{row * SIDE}">'
        f"<defs>{symbols_svg}</defs>{''.join(drawn)}</svg>"
    )
    marks = frames.pop("")
    document = {
        "format": "i2p-sprites",
        "version": export.VERSION,
        "image": "sprites.png",
        "size": [SIDE, SIDE],
        "cell": CELL,
        "foot": [SIDE / 2, ROOM + FOOT * CELL],
        "middle": [SIDE / 2, SIDE / 2],
        "stands": [0.5, FOOT],
        "entities": frames,
        "marks": marks,
    }
    return picture, document


def background(stage: Stage) -> tuple[np.ndarray, dict[str, Any]]:
    """The room without its cast, RGBA, and where in it the map begins; smaller of large maps."""
    area = np.prod(scene_size(stage, CELL))
    cell = CELL if area <= LARGEST_SCENE else max(1, int(CELL * (LARGEST_SCENE / area) ** 0.5))
    content = stage_background(stage, cell) + labels_svg(stage, cell)
    about = {"image": "background.png", "cell": cell, "origin": [margin(cell), margin(cell)]}
    return svg_rgba(svg_document(stage, cell, content)), about


def timeline(
    stage: Stage,
    script: Mapping[str, Any],
    film: Film,
    panels: Sequence[Panel],
    title: str,
    seconds: np.ndarray,
    rests: np.ndarray,
) -> dict[str, Any]:
    """The story as data, T frames.

    Args:
        script: the dict of script.json.
        panels: what viewers believe, over the frames 0..T.
        seconds: [T] how long each frame lasts.
        rests: [T] how long its end is held.
    """
    cells = [(c, r) for r in range(stage.height) for c in range(stage.width)]
    world = {
        "kind": "grid",
        "name": stage.name,
        "columns": stage.width,
        "rows": stage.height,
        "walls": [list(at) for at in cells if stage.is_wall(at)],
        **({"fences": [[list(a), list(b)] for a, b in stage.fences]} if stage.fences else {}),
        "tiles": [
            {"name": tile.name, "cell": list(tile.cell), "color": tile.color}
            for tile in stage.tiles
        ],
    }
    cast = [
        {"name": a.name, "kind": a.kind, "sprite": a.sprite, "color": actor_tint(a)}
        for a in stage.cast
    ]
    frames = [{"state": script["start"]}, *script["frames"]]
    return export.timeline(
        title,
        world,
        cast,
        [_entities(stage, frame) for frame in frames],
        [frame.get("event") for frame in frames],
        panels,
        (seconds, rests),
        beats=[
            {
                "frame": beat.frame,
                "entity": beat.actor,
                "does": beat.verb,
                "direction": beat.direction or None,
                "from": beat.origin and list(beat.origin),
                "to": beat.target and list(beat.target),
                "pushes": [shove.name for shove in beat.pushed],
            }
            for beat in film.beats
        ],
        tracks={name: _keys(track) for name, track in film.tracks.items()},
        marks=[{"mark": mark.kind, "keys": _keys(mark.track)} for mark in film.marks],
    )


def _entities(stage: Stage, frame: Mapping[str, Any]) -> dict[str, Any]:
    found = {}
    for actor in stage.cast:
        acted = frame.get(actor.name) or {}
        action = acted.get("action")
        place = frame["state"].get(actor.name)
        found[actor.name] = {
            "cell": None if isinstance(place, str) else place,
            "action": action,
            "success": acted["moved"] if action not in (None, "stay") else None,
        } | ({"carried_by": place} if isinstance(place, str) else {})
    return found


def _keys(track: Track) -> list[list[Any]]:
    return [[round(v, 5) if isinstance(v, float) else v for v in key] for key in track]
