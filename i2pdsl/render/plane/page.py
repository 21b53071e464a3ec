"""Performances on one HTML page, in a player that draws them as `figures.py` does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil
from typing import Any

import numpy as np

from i2pdsl.objective.wishes import Wish
from i2pdsl.render.alone import Alone
from i2pdsl.render.film_page import Film, film_page
from i2pdsl.render.markup import plain
from i2pdsl.render.mind import Panel, Window
from i2pdsl.render.plane.figures import (
    DASH,
    DASHED,
    FACE,
    FAINT,
    LINE,
    PUPIL,
    STRONG,
    THIN,
    TRAIL,
    cast_svg,
    tint,
    way_style,
)
from i2pdsl.render.plane.performance import Performance, frame_seconds, key_frames
from i2pdsl.render.plane.room import View
from i2pdsl.render.plane.stage import Stage, stage_within
from i2pdsl.render.reasons import Account
from i2pdsl.worlds.plane.spec import PlaneSpec

SCRIPT = "plane/plane.js"  # what moves films in pages
SHOWN = 560.0, 400.0  # pixels that a stage usually has on a screen, about
ROW = 1120.0  # pixels that a row of several has
TOLD = 16  # captions that are listed where they change too often to list all


def page_html(
    performances: Sequence[Performance],
    panels: Sequence[Panel],
    title: str,
    windows: Sequence[Window] = (),
    wishes: Sequence[Wish] = (),
    account: Account | None = None,
    clock: tuple[np.ndarray, np.ndarray] | None = None,
) -> str:
    """A self-contained page. `panels` cover the frames of the performance that lasts longest;
    `clock` is how long frames last and how long their ends are held; without it, as usual."""
    source = "\n\n".join(dict.fromkeys(p.source for p in performances if p.source))
    count = max(p.frames for p in performances)
    about = f"{performances[0].spec.name} · {count} frame{'' if count == 1 else 's'}"
    return film_page(
        moving(performances, clock), panels, title, about, source,
        windows=windows, wishes=wishes, account=account,
    )  # fmt: skip


def moving(
    performances: Sequence[Performance], clock: tuple[np.ndarray, np.ndarray] | None = None
) -> Film:
    """The film as pages play it."""
    several = len(performances) > 1
    lasting = max(performances, key=lambda p: p.frames)
    across = min(len(performances), 3)
    stage = page_stage(lasting.spec, across)
    shows = "\n".join(_show(k, p, performances, stage) for k, p in enumerate(performances))
    captions = _captions(performances)
    usual = np.full(lasting.frames, frame_seconds(performances)), np.zeros(lasting.frames)
    seconds, rests = usual if clock is None else clock
    return Film(
        stage=f'      <div class="shows">\n{shows}\n      </div>' if several else shows,
        aspect=across * stage.width / stage.height,
        last=lasting.frames,
        seconds=seconds,
        rests=rests,
        captions=captions,
        happenings=_happenings(captions, lasting),
        script=SCRIPT,
        data=_data(performances, stage),
        classes="theatre wide" if several else "theatre",
    )


def page_stage(spec: PlaneSpec, across: int) -> Stage:
    """The stage of a page that shows so many side by side."""
    return stage_within(spec, min(SHOWN[0], ROW / across), SHOWN[1])


def page_view(spec: PlaneSpec) -> View:
    """How a page that shows one film lays out the plane."""
    return page_stage(spec, 1).view


def alone(performances: Sequence[Performance], places: int) -> list[Alone]:
    """The films without a word about them."""
    found = []
    for each in performances:
        bare = replace(each, windows=())
        stage = stage_within(bare.spec, *SHOWN)
        stages = [_show(place, bare, [bare], stage) for place in range(places)]
        seconds = [frame_seconds([bare])] * bare.frames
        aspect, data = stage.width / stage.height, _data([bare], stage)
        found.append(Alone(stages, aspect, seconds, SCRIPT, data))
    return found


def _captions(performances: Sequence[Performance]) -> list[str]:
    """For each frame what is believed; of several performances, of each one."""
    if len(performances) == 1:
        return list(performances[0].captions)
    last = max(p.frames for p in performances)
    return [
        "; ".join(f"{p.title}: {p.captions[min(t, p.frames)]}" for p in performances)
        for t in range(last + 1)
    ]


def _happenings(captions: Sequence[str], performance: Performance) -> list[int]:
    """The frames whose captions are listed: where they change, or else those that tell most."""
    changes = [t for t in range(len(captions)) if t == 0 or captions[t] != captions[t - 1]]
    return changes if len(changes) <= TOLD else key_frames(performance, TOLD)


# ------------------------------------------------------------------------------------ the stage


def _show(
    number: int, performance: Performance, together: Sequence[Performance], stage: Stage
) -> str:
    """The drawing at the start; the player moves it."""
    view, spec = stage.view, performance.spec
    trails = "".join(
        f'<g class="trail" data-who="{k}"><path class="way" {way_style(performance, view, k)}/>'
        + f'<path class="piece" {LINE} stroke="{tint(character)}"/>' * _pieces(view.step(k))
        + "</g>"
        for k, character in enumerate(spec.characters)
    )
    several = len(together) > 1
    name = f'<span class="name">{plain(performance.title)}</span>' if several else ""
    svg = (
        f'<svg role="img" aria-label="{plain(performance.title)}: the film" '
        f'aria-describedby="caption" viewBox="{stage.box}">{stage.still(together)}{trails}'
        f"{cast_svg(performance, view, 0)}</svg>"
    )
    return f"""\
      <div class="show" id="show-{number}">
        {svg}
        <div class="signs">{name}<span class="window-sign" hidden></span></div>
      </div>"""


def _pieces(step: int) -> int:
    """How many pieces a trail has at most."""
    return ceil(TRAIL / step) + 1


# ------------------------------------------------------------------------------------- the data


def _data(performances: Sequence[Performance], stage: Stage) -> dict[str, Any]:
    """What `plane.js` reads: courses in pixels, and how trails fade."""
    view = stage.view
    return {
        "trail": {
            "span": TRAIL, "dash": DASH, "width": view.trail, "thin": THIN, "faint": FAINT,
            "strong": STRONG,
        },
        "eyes": {"face": FACE, "pupils": PUPIL},
        "performances": [
            {
                "cast": [
                    {
                        "name": p.spec.characters[k].name,
                        "x": _course(view.pixels(p.positions)[:, k, 0]),
                        "y": _course(view.pixels(p.positions)[:, k, 1]),
                        "gazeX": _course(p.gaze[:, k, 0]),
                        "gazeY": _course(p.gaze[:, k, 1]),
                        "size": view.radius(k) / 100,
                        "step": view.step(k),
                        "dashed": k >= DASHED,
                    }
                    for k in range(len(p.spec.characters))
                ],
                "windows": [[w.first, w.last, w.label] for w in p.windows],
            }
            for p in performances
        ],
    }  # fmt: skip


def _course(values: np.ndarray) -> list[float]:
    return np.round(values, 2).tolist()
