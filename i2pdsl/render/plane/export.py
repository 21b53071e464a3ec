"""What other programs animate a story in a plane with: the discs as a sprite sheet, and the story
as a timeline (docs/export.md). Lengths are the plane's units; places are counted from the room's
upper left corner, y down."""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np

from i2pdsl.render import export
from i2pdsl.render.plane.figures import figure_svg
from i2pdsl.render.plane.names import names_svg, place_names
from i2pdsl.render.plane.performance import Performance
from i2pdsl.render.plane.room import View, room_svg, view_within
from i2pdsl.render.raster import svg_rgba
from i2pdsl.worlds.plane.spec import PlaneSpec

RADIUS = 64  # pixels of the largest disc in the sheet
ROOM = 8  # pixels about it
BACKGROUND = 1920.0, 1440.0  # pixels that the room's picture has at most
LOOKING = 0.3  # how long a gaze is that has a direction, of 1
WAYS = ("east", "northeast", "north", "northwest", "west", "southwest", "south", "southeast")
POSES = ("idle", *(f"look-{way}" for way in WAYS))


def pose_of(gaze: np.ndarray) -> str:
    """The drawing whose eyes look most like a gaze [2], x to the east and y to the north."""
    if np.hypot(*gaze) < LOOKING:
        return "idle"
    return f"look-{WAYS[round(float(np.arctan2(gaze[1], gaze[0])) / (np.pi / 4)) % 8]}"


def gaze_of(pose: str) -> np.ndarray:
    """[2] Where the eyes of a drawing look."""
    if pose == "idle":
        return np.zeros(2)
    angle = WAYS.index(pose.removeprefix("look-")) * np.pi / 4
    return np.array([np.cos(angle), np.sin(angle)])


def sheet(spec: PlaneSpec) -> tuple[np.ndarray, dict[str, Any]]:
    """All poses of the cast, a row for each: RGBA [height, width, 4], and where each stands."""
    cell = RADIUS / max(c.radius for c in spec.characters)
    side = 2 * (RADIUS + ROOM)
    drawn, corners = [], {}
    for row, character in enumerate(spec.characters):
        corners[character.name] = {
            pose: [column * side, row * side] for column, pose in enumerate(POSES)
        }
        for pose, corner in corners[character.name].items():
            middle = np.array(corner) + side / 2
            drawn.append(figure_svg(character, row, middle, character.radius * cell, gaze_of(pose)))
    width, height = len(POSES) * side, len(spec.characters) * side
    picture = svg_rgba(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">'
        f"{''.join(drawn)}</svg>"
    )
    document = {
        "format": "i2p-sprites",
        "version": export.VERSION,
        "image": "sprites.png",
        "size": [side, side],
        "cell": cell,
        "foot": [side / 2, side / 2],
        "middle": [side / 2, side / 2],
        "stands": [0.0, 0.0],
        "entities": corners,
        "marks": {},
    }
    return picture, document


def background(performance: Performance) -> tuple[np.ndarray, dict[str, Any]]:
    """The room without its cast, RGBA, and where in it the plane begins."""
    spec = performance.spec
    largest = view_within(spec, *BACKGROUND).scale
    view = View(spec, min(largest, RADIUS / max(c.radius for c in spec.characters)))
    content = room_svg(view) + names_svg(view, place_names(view), [performance])
    picture = svg_rgba(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{ceil(view.width)}" '
        f'height="{ceil(view.height)}" viewBox="{-view.margin:g} {-view.margin:g} '
        f'{ceil(view.width)} {ceil(view.height)}">{content}</svg>'
    )
    about = {
        "image": "background.png",
        "cell": view.scale,
        "origin": [view.margin, view.margin],
    }
    return picture, about


def timeline(performance: Performance, clock: tuple[np.ndarray, np.ndarray]) -> dict[str, Any]:
    """The story as data; `clock` is how long each frame lasts, and its end is held, [T] each."""
    spec = performance.spec
    view = View(spec, 1.0)
    place = lambda at: np.round(view.pixels(np.array(at)), 5).tolist()
    world = {
        "kind": "plane",
        "name": spec.name,
        "columns": spec.width,
        "rows": spec.height,
        "walls": [
            {"points": [place(at) for at in w.points], "closed": w.closed, "color": w.color}
            for w in spec.walls
        ],
        "tiles": [
            {"name": p.name, "at": place(p.at), "radius": p.radius, "color": p.color}
            for p in spec.places
        ],
    }
    cast = [
        {"name": c.name, "kind": "character", "radius": c.radius, "color": c.color}
        for c in spec.characters
    ]
    names = [c.name for c in spec.characters]
    ways = [[place(at) for at in frame] for frame in performance.positions]
    tracks = {
        name: [
            [t, *ways[t][k], 0, 1, 1, 1, 0, "linear", pose_of(performance.gaze[t, k])]
            for t in range(performance.frames + 1)
        ]
        for k, name in enumerate(names)
    }
    return export.timeline(
        performance.title,
        world,
        cast,
        [{name: {"at": at} for name, at in zip(names, frame, strict=True)} for frame in ways],
        [None] * (performance.frames + 1),
        performance.panels,
        clock,
        tracks=tracks,
    )
