"""Performances on one HTML page, in a player that draws them as `figures.py` does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import tan
from typing import Any

import numpy as np

from i2pdsl.objective.wishes import Wish
from i2pdsl.render.alone import Alone
from i2pdsl.render.film_page import Film, film_page
from i2pdsl.render.hill.figures import CRATES, IDLE, LAYERS, LONG, SHORT, pose_svg, rig
from i2pdsl.render.hill.performance import Performance, key_frames, units
from i2pdsl.render.hill.rig import GROUNDED, ROPE_LENGTH, SCALE, UNITS, Part
from i2pdsl.render.hill.scene import View, camera_way, moved, range_crest, view_of
from i2pdsl.render.hill.scenery import FAR_SHARE, NEAR_SHARE, ground_svg, range_svg, sky_svg
from i2pdsl.render.markup import plain
from i2pdsl.render.mind import Panel, Window
from i2pdsl.render.performances import HUES
from i2pdsl.render.reasons import Account
from i2pdsl.worlds.hill.hopper import HAND, HIPS, HOOK

SCRIPT = "hill/hill.js"  # what moves films in pages
GRAIN = 100  # steps to a unit of the world (and to a whole pull) in the page's numbers
_UNSEEN = '<ul class="lanes" hidden><li><span class="way"></span><b></b></li></ul>'
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
    return film_page(
        moving(performances, clock), panels, title, _about(performances), source,
        windows=windows, wishes=wishes, account=account,
    )  # fmt: skip


def moving(
    performances: Sequence[Performance], clock: tuple[np.ndarray, np.ndarray] | None = None
) -> Film:
    """The film as pages play it."""
    lasting = max(performances, key=lambda p: p.frames)
    view = view_of(performances)
    several = len(performances) > 1
    captions = _captions(performances)
    usual = np.full(lasting.frames, lasting.frame_seconds), np.zeros(lasting.frames)
    seconds, rests = usual if clock is None else clock
    return Film(
        stage=_stage(performances, view),
        aspect=min(len(performances), 3) * view.width / view.height,
        last=lasting.frames,
        seconds=seconds,
        rests=rests,
        captions=captions,
        happenings=_happenings(captions, lasting),
        script=SCRIPT,
        data=_data(performances),
        classes="theatre wide" if several else "theatre",
    )


def alone(performances: Sequence[Performance], places: int) -> list[Alone]:
    """The films without a word about them, in one view; each place has a crate of its own."""
    view = view_of(performances)
    found = []
    for each in performances:
        bare = replace(each, windows=())
        stages = [_show(place, bare, view, False) + _UNSEEN for place in range(places)]
        seconds = [each.frame_seconds] * each.frames
        aspect = view.width / view.height
        found.append(Alone(stages, aspect, seconds, SCRIPT, _data([bare])))
    return found


def _about(performances: Sequence[Performance]) -> str:
    """One line under the title."""
    lasting = max(performances, key=lambda p: p.frames)
    seconds = lasting.frames * lasting.frame_seconds
    told = ["hill", f"{lasting.frames} frames, {seconds:.0f} seconds"]
    if len(performances) == 1:
        told.append(f"box of weight {lasting.weight:g}")
    return " · ".join(told)


def _captions(performances: Sequence[Performance]) -> list[str]:
    """For each frame what is said of it; of several performances, how far each one has come."""
    if len(performances) == 1:
        return [performances[0].caption(t) for t in range(performances[0].frames + 1)]
    last = max(p.frames for p in performances)
    return [
        ", ".join(f"{p.title}: {units(p.distance[min(t, p.frames)])}" for p in performances)
        for t in range(last + 1)
    ]


def _happenings(captions: Sequence[str], performance: Performance) -> list[int]:
    """The frames whose captions are listed: where they change, or else some over the whole."""
    changes = [t for t in range(len(captions)) if t == 0 or captions[t] != captions[t - 1]]
    if len(changes) <= 2 * TOLD:
        return changes
    return key_frames(performance, TOLD)


# ------------------------------------------------------------------------------------ the stage


def _stage(performances: Sequence[Performance], view: View) -> str:
    """The drawings at the start; the player moves them."""
    several = len(performances) > 1
    shows = "\n".join(_show(number, p, view, several) for number, p in enumerate(performances))
    lanes = "\n".join(
        _lane(number, p.title if several else "way up the slope")
        for number, p in enumerate(performances)
    )
    return f"""\
      <div class="shows">
{shows}
      </div>
      <ul class="lanes" aria-label="How far up the slope">
{lanes}
      </ul>"""


def _show(number: int, performance: Performance, view: View, named: bool) -> str:
    cameras, slope = camera_way(performance), performance.slope
    first, low, high = float(cameras[0]), float(cameras.min()), float(cameras.max())
    sky = sky_svg(SCALE * view.left, -SCALE * view.top, view.width, view.height)
    layers = []
    for which, share in enumerate((FAR_SHARE, NEAR_SHARE)):
        ends = (view.left + share * low, view.right + share * high)
        layers.append((share, range_svg(which, *ends, range_crest(which, view))))
    origin = float(performance.positions[0, 0, HIPS])
    layers.append((1.0, ground_svg(slope, view.left + low, view.right + high, origin)))
    crate = CRATES[number % len(CRATES)]
    pose = pose_svg(performance.positions[0], performance.pull[0], slope, crate)
    layers.append((1.0, f'<g class="cast">{pose}</g>'))
    drawn = "".join(
        f'<g class="layer" data-share="{share:g}">{moved(content, share * first, slope)}</g>'
        for share, content in layers
    )
    name = f'<span class="name">{plain(performance.title)}</span>' if named else ""
    return f"""\
      <div class="show" id="show-{number}">
        <svg role="img" aria-label="{plain(performance.title)}: the film" \
aria-describedby="caption" viewBox="{view.box}">{sky}{drawn}</svg>
        <div class="signs">{name}<span class="window-sign" hidden></span></div>
      </div>"""


def _lane(number: int, name: str) -> str:
    hue = HUES[number % len(HUES)]
    return (
        f'<li style="--hue: {hue}"><span>{plain(name)}</span>'
        f'<span class="lane"><span class="way"></span></span><b>0 units</b></li>'
    )


# ------------------------------------------------------------------------------------- the data


def _data(performances: Sequence[Performance]) -> dict[str, Any]:
    """What `hill.js` reads: how poses are drawn, and the performances in whole numbers."""
    parts = rig()
    return {
        "scale": SCALE,
        "grain": GRAIN,
        "pairs": UNITS,
        "grounded": GROUNDED,
        "rope": {"hand": HAND, "hook": HOOK, "length": ROPE_LENGTH},
        "colors": {"short": SHORT, "idle": IDLE, "long": LONG},
        "parts": [_part(part) for layer in LAYERS for part in parts[layer]],
        "performances": [_recorded(p) for p in performances],
    }


def _part(part: Part) -> dict[str, Any]:
    """Of each point the weights that are not zero: [place in the pose's vector, re, im, ...]."""
    points = []
    for weights in part.points:
        flat: list[float] = []
        for at in np.flatnonzero(weights):
            flat += [int(at), _short(weights[at].real), _short(weights[at].imag)]
        points.append(flat)
    return {"shape": part.shape, "points": points, "muscle": part.muscle}


def _short(value: float) -> float:
    rounded = round(float(value), 4)
    return int(rounded) if rounded == int(rounded) else rounded


def _recorded(performance: Performance) -> dict[str, Any]:
    """Each number's course over the frames, as differences: most of them have two digits."""
    flat = performance.positions.reshape(performance.frames + 1, -1)
    return {
        "slope": performance.slope,
        "rise": tan(performance.slope),
        "positions": _steps(flat),
        "pull": _steps(performance.pull),
        "camera": _steps(camera_way(performance)[:, None])[0],
        "distance": _steps(performance.distance[:, None])[0],
        "windows": [[w.first, w.last, w.label] for w in performance.windows],
    }


def _steps(values: np.ndarray) -> list[list[int]]:
    """[T + 1, n] as n lists of a first value and its changes, in 1 / GRAIN."""
    grains = np.round(GRAIN * values).astype(int)
    return np.diff(grains, axis=0, prepend=0).T.tolist()
