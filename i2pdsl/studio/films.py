"""Films as the page gets them: what its player mounts, what is known of them, who is where."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from i2pdsl.render.drawing import Drawing
from i2pdsl.render.film_page import to_mount
from i2pdsl.render.mind import DASHES, Panel, panel_values, value_axis
from i2pdsl.render.pictures import drawing_for, pictures_of
from i2pdsl.stories import Script
from i2pdsl.studio.made import Made
from i2pdsl.studio.protocol import REFUSED, Refusal

TOGETHER = "touching"  # the predicate of all worlds with two characters


def film_as_json(made: Made) -> dict[str, Any]:
    """All that the page is told of a film."""
    script, judgement = made.script, made.judgement
    pictures = pictures_of([script])
    if "html" not in pictures.offered:
        raise Refusal(REFUSED, f"films in worlds like {script.world.name} cannot be played")
    drawing: Drawing = drawing_for(script.world.spec)
    moving = pictures.moving()
    words = script.world.vocabulary
    about = f"{script.world.name} · {script.length} frame{'s' * (script.length != 1)}"
    play = {
        **to_mount(moving, pictures.panels, pictures.title),
        "about": about,
        "happenings": list(moving.happenings),
        "panels": [panel_as_json(panel) for panel in pictures.panels],
        "events": [asdict(mark) for mark in pictures.marks],
        "windows": [asdict(window) for window in pictures.windows],
    }
    return {
        "id": made.name,
        "quality": made.quality,
        "score": script.score,
        "panel": judgement and {"mean": judgement.mean, "worst": judgement.worst},
        "still": script.still,
        "lively": 1 - script.still,
        "contact": contact(script),
        "unmet": [each.text for each in script.unmet],
        "length": script.length,
        "script": script.record.as_json(),
        "cast": [
            {
                "name": seen.name,
                "what": "character" if seen.name in words.characters else "object",
                "at": list(seen.at),
            }
            for seen in drawing.seen(script.shown())  # with the turns that a flashback appends
        ],
        "play": play,
    }


def panel_as_json(panel: Panel) -> dict[str, Any]:
    """A panel of curves, with all that is needed to draw it."""
    low, high, ticks = value_axis(panel)
    return {
        "title": panel.title,
        "kind": panel.kind,
        "ylabel": panel.ylabel,
        "low": low,
        "high": high,
        "ticks": [float(tick) for tick in ticks],
        "series": [
            {
                "label": one.label,
                "claim": one.claim,
                "color": one.color,
                "dash": list(DASHES[rank % len(DASHES)]),
                "values": numbers(panel_values(panel, one)),
            }
            for rank, one in enumerate(panel.series)
        ],
    }


def numbers(values: np.ndarray) -> list[float | None]:
    """Numbers as JSON has them, to six digits."""
    return [float(f"{v:.6g}") if math.isfinite(v) else None for v in values.tolist()]


def contact(script: Script) -> float | None:
    """The share of frames in which the characters are side by side; None of one who is alone."""
    words = script.world.vocabulary
    if TOGETHER not in words.predicates or len(words.characters) < 2:
        return None
    first, second = words.characters[:2]
    plain = replace(script, module=replace(script.module, names={}))
    return float(plain.query(f"mean_t [{TOGETHER}({first}, {second}) @ script[t]]"))
