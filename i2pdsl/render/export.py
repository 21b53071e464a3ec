"""What other programs animate with: what the timelines of all kinds of world have in common, and
the files. They are documented in docs/export.md; the script for Godot 4 beside this module plays
them."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from i2pdsl.render.mind import Panel
from i2pdsl.resources import atomic_path, write_text

VERSION = 1
PLAYER = "i2p_player.gd"
KEYS = ("time", "x", "y", "angle", "scale_x", "scale_y", "opacity", "lift", "ease", "pose")


def timeline(
    title: str,
    world: Mapping[str, Any],
    cast: Sequence[Mapping[str, Any]],
    entities: Sequence[Mapping[str, Any]],
    events: Sequence[Any],
    panels: Sequence[Panel],
    clock: tuple[np.ndarray, np.ndarray],
    **more: Any,
) -> dict[str, Any]:
    """A story of T frames as data.

    Args:
        world: what stands still.
        cast: who there is.
        entities: for each of the frames 0..T where everybody is and what it does.
        events: for each of them what happens that is nobody's deed.
        panels: what viewers believe, over the frames 0..T.
        clock: [T] how long each frame lasts, and [T] how long its end is held, in seconds.
        more: further keys.
    """
    seconds, rests = (np.concatenate([[0.0], each]) for each in clock)
    ends = np.cumsum(seconds + rests)
    frames = [
        {
            "frame": t,
            "start": round(float(ends[max(t - 1, 0)]), 4),
            "seconds": round(float(seconds[t]), 4),
            "rests": round(float(rests[t]), 4),
            "entities": each,
            "event": event,
            "beliefs": {
                p.title: {s.label: number(float(s.values[t])) for s in p.series} for p in panels
            },
        }
        for t, (each, event) in enumerate(zip(entities, events, strict=True))
    ]
    told = {
        "format": "i2p-timeline",
        "version": VERSION,
        "title": title,
        "world": world,
        "entities": list(cast),
        "frames": frames,
    }
    return told | {"beats": [], "keys": KEYS, "tracks": {}, "marks": []} | more


def number(value: float, digits: int = 6) -> float | None:
    """JSON has neither infinity nor what is no number."""
    return round(value, digits) if np.isfinite(value) else None


def save_sheet(
    folder: Path,
    sheet: tuple[np.ndarray, dict[str, Any]],
    background: tuple[np.ndarray, dict[str, Any]],
) -> list[Path]:
    """Writes `sprites.png`, `sprites.json` and `background.png`, each whole or not at all.

    Args:
        sheet: the cast, RGBA, and where in it each pose is.
        background: the room without its cast, RGBA, and where in it the map begins.
    """
    (picture, document), (room, about) = sheet, background
    paths = [folder / "sprites.png", folder / "background.png"]
    for path, pixels in zip(paths, (picture, room), strict=True):
        _save_png(path, pixels)
    return [*paths, _save_json(folder / "sprites.json", document | {"background": about})]


def save_timeline(folder: Path, document: Mapping[str, Any]) -> Path:
    """Writes `timeline.json`."""
    return _save_json(folder / "timeline.json", document)


def save_player(folder: Path) -> Path:
    """Writes the script for Godot 4."""
    path = folder / PLAYER
    write_text(path, (Path(__file__).parent / PLAYER).read_text(encoding="utf-8"))
    return path


def _save_json(path: Path, document: Mapping[str, Any]) -> Path:
    write_text(path, json.dumps(document, ensure_ascii=False, allow_nan=False) + "\n")
    return path


def _save_png(path: Path, pixels: np.ndarray) -> None:
    from PIL import Image

    made = io.BytesIO()
    Image.fromarray(pixels).save(made, "PNG", optimize=True)
    with atomic_path(path) as temporary:
        temporary.write_bytes(made.getvalue())
