"""The whole story on one HTML page: the film, the audience's mind, what happens, the source.

The page is a single file that fetches nothing: drawings, keyframes, curves, style and player are
all inside, under a Content-Security-Policy that names the player's hash, so that no other script
could run even if a story's text were to smuggle one in. Its parts lie in `render/page`:
`page.html` (a string.Template), `page.css` and `player.js`.
"""

import base64
import hashlib
import json
import math
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from i2pdsl.render.choreography import Film, Key, Track
from i2pdsl.render.mind import (
    DASHES,
    Mark,
    Panel,
    frame_ticks,
    panel_values,
    value_axis,
)
from i2pdsl.render.scene import (
    FOOT,
    actor_svg,
    scene_size,
    shadow_svg,
    stage_background,
    stage_symbols,
    view_box,
)
from i2pdsl.render.sprites import symbol_id
from i2pdsl.render.stage import Stage, describe
from i2pdsl.resources import write_text

CELL = 100.0  # units of the stage's viewBox to a cell
SECONDS = 1.1  # a turn lasts at speed 1
PLOT = {"width": 200, "height": 128, "left": 30, "right": 194, "top": 20, "bottom": 98}


def page_html(
    stage: Stage,
    script: Mapping[str, Any],
    film: Film,
    panels: Sequence[Panel],
    title: str,
    source: str,
    captions: Sequence[str] | None = None,
    marks: Sequence[Mark] | None = None,
    language: str = "en",
) -> str:
    """A self-contained page for a finished script (the dict of script.json, T frames).

    `panels` cover the frames 0..T. `captions` has T + 1 texts, for the start and each frame;
    without it they are told from the film. `marks` are the moments to line out in the curves;
    without it, those when something falls or vanishes.
    """
    last = len(script["frames"])
    told = tuple(captions) if captions is not None else frame_captions(stage, script, film)
    if len(told) != last + 1:
        raise ValueError(f"{last + 1} captions are needed, for frames 0 to {last}, not {len(told)}")
    for panel in panels:
        if panel.last != last:
            raise ValueError(f"panel {panel.title!r} covers {panel.last} frames, not {last}")
    events = tuple(marks) if marks is not None else _events(film)
    folder = files("i2pdsl.render") / "page"
    parts = {name: (folder / name).read_text(encoding="utf-8") for name in PARTS}
    digest = base64.b64encode(hashlib.sha256(parts["player.js"].encode()).digest()).decode()
    width, height = scene_size(stage, CELL)
    heading = title.strip() or stage.name
    return Template(parts["page.html"]).substitute(
        language=_text(language),
        policy=f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; "
        "img-src data:; base-uri 'none'; form-action 'none'",
        title=_text(heading),
        about=_text(_about(stage, script)),
        style=parts["page.css"],
        aspect=f"{width / height:.3f}",
        view=view_box(stage, CELL),
        stage_label=_text(f"{heading}: the film"),
        scenery=f"<defs>{stage_symbols(stage, _poses(film))}</defs>{stage_background(stage, CELL)}",
        actors="\n".join(_cast(stage, film)),
        first_caption=_text(told[0]),
        last=last,
        mind=_mind(panels, events),
        happenings="\n".join(_happenings(told)),
        source=_text(source),
        data=_json(_film_data(stage, film, panels, told, last)),
        player=parts["player.js"],
    )


PARTS = ("page.html", "page.css", "player.js")


def save_page(
    path: str | Path,
    stage: Stage,
    script: Mapping[str, Any],
    film: Film,
    panels: Sequence[Panel],
    title: str,
    source: str,
    captions: Sequence[str] | None = None,
    marks: Sequence[Mark] | None = None,
    language: str = "en",
) -> Path:
    """Writes `page_html`, whole or not at all."""
    path = Path(path)
    page = page_html(stage, script, film, panels, title, source, captions, marks, language)
    write_text(path, page)
    return path


def frame_captions(stage: Stage, script: Mapping[str, Any], film: Film) -> tuple[str, ...]:
    """T + 1 sentences: where everybody is at the start, then what happens in each frame."""
    places = []
    for actor in stage.cast:
        at = script["start"].get(actor.name)
        where = "absent" if at is None else f"at ({at[0]}, {at[1]})"
        places.append(f"{actor.name} {where}")
    told = [", ".join(places)]
    for frame in range(1, len(script["frames"]) + 1):
        beats = [describe(beat) for beat in film.beats if beat.frame == frame]
        told.append("; ".join(beats) or "nothing moves")
    return tuple(told)


def _events(film: Film) -> tuple[Mark, ...]:
    unusual = (beat for beat in film.beats if beat.verb in ("fall", "vanish"))
    return tuple(Mark(beat.frame, describe(beat)) for beat in unusual)


def _about(stage: Stage, script: Mapping[str, Any]) -> str:
    """One line under the title; `story` and `score` inform only, and may be missing."""
    count = len(script["frames"])
    told = [f"{stage.name}", f"{count} frame{'' if count == 1 else 's'}"]
    story = script.get("story")
    if isinstance(story, Mapping) and isinstance(story.get("seed"), int):
        told.append(f"seed {story['seed']}")
    score = script.get("score")
    if isinstance(score, (int, float)) and math.isfinite(score):
        told.append(f"score {score:.4g}")
    return " · ".join(told)


# ------------------------------------------------------------------------------------ the stage


def _poses(film: Film) -> dict[str, tuple[str, ...]]:
    """The poses that each actor takes: only these are drawn into the page."""
    return {name: tuple(sorted({key.pose for key in track})) for name, track in film.tracks.items()}


def _cast(stage: Stage, film: Film) -> Iterable[str]:
    """The cast at time 0; the player moves it. First all shadows: they lie under everybody."""
    ground = Key(0, -0.5, 0.015 - FOOT)  # a shadow about (0, 0), for the player to move
    for index, actor in enumerate(stage.cast):
        key = film.tracks[actor.name][0]
        x, y = (key.x + 0.5) * CELL, (key.y + FOOT - 0.015) * CELL
        yield (
            f'<g data-index="{index}" data-part="shadow" opacity="{key.opacity:g}" '
            f'transform="translate({x:g} {y:g})">{shadow_svg(ground, CELL)}</g>'
        )
    for index, actor in enumerate(stage.cast):
        drawn = actor_svg(actor, film.tracks[actor.name][0], CELL)
        more = f'data-index="{index}" data-part="actor" data-actor="{_text(actor.name)}"'
        yield drawn.replace("<use ", f"<use {more} ", 1)


def _film_data(
    stage: Stage, film: Film, panels: Sequence[Panel], told: Sequence[str], last: int
) -> dict[str, Any]:
    """What the player reads; keys in the order of `choreography.Key`."""
    actors = []
    for actor in stage.cast:
        symbols = {pose: symbol_id(actor, pose) for pose in _poses(film)[actor.name]}
        keys = _keys(film.tracks[actor.name])
        actors.append({"name": actor.name, "symbols": symbols, "keys": keys})
    return {
        "last": last,
        "seconds": SECONDS,
        "cell": CELL,
        "foot": 100 * FOOT,
        "actors": actors,
        "marks": [
            {"symbol": f"mark--{mark.kind}", "keys": _keys(mark.track)} for mark in film.marks
        ],
        "plot": PLOT,
        "panels": [_panel_data(panel) for panel in panels],
        "captions": list(told),
    }


def _keys(track: Track) -> list[list[Any]]:
    return [[round(v, 5) if isinstance(v, float) else v for v in key] for key in track]


# ----------------------------------------------------------------------------------- the curves


def _panel_data(panel: Panel) -> dict[str, Any]:
    low, high, _ = value_axis(panel)
    series = []
    for one in panel.series:
        values = [float(f"{v:.6g}") if math.isfinite(v) else None for v in panel_values(panel, one)]
        series.append({"label": one.label, "values": values})
    return {"title": panel.title, "kind": panel.kind, "low": low, "high": high, "series": series}


def _mind(panels: Sequence[Panel], marks: Sequence[Mark]) -> str:
    """The section of the belief curves, or nothing where there are none."""
    if not panels:
        return ""
    notes = "; ".join(f"frame {mark.frame:g}, {mark.label}" for mark in marks if mark.label)
    dotted = f" Dotted line: {notes}." if notes else ""
    figures = "\n".join(_panel(panel, marks, index) for index, panel in enumerate(panels))
    return f"""\
  <section class="mind" aria-labelledby="mind-heading">
    <div class="mind-head">
      <h2 id="mind-heading">The audience’s mind</h2>
      <p class="hint">What somebody who watches comes to believe. \
Press anywhere on a curve to go there.{_text(dotted)}</p>
    </div>
    <div class="panels">
{figures}
    </div>
  </section>"""


def _panel(panel: Panel, marks: Sequence[Mark], index: int) -> str:
    clip = f"clip-{index}"
    names, curves, dots = [], [], []
    for rank, series in enumerate(panel.series):
        hue = f'style="--hue: {series.color}"'
        dash = " ".join(f"{2.2 * part:g}" for part in DASHES[rank % len(DASHES)])
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        names.append(
            f'<li><svg class="swatch" viewBox="0 0 26 10" aria-hidden="true" {hue}>'
            f'<path d="M1 5H25"{dashed}/></svg>{_text(series.label)} <b></b></li>'
        )
        curves.append(f'<g class="curve" {hue}><path d="{_path(panel, rank)}"{dashed}/></g>')
        dots.append(f'<g class="curve" {hue}><circle class="dot here" r="4" cx="-99"/></g>')
    left, right, top, bottom = (PLOT[side] for side in ("left", "right", "top", "bottom"))
    events = "".join(
        f'<path class="event" d="M{_at(panel, mark.frame):g} {top}V{bottom}"/>' for mark in marks
    )
    return f"""\
      <figure class="panel">
        <figcaption><h3 id="panel-{index}">{_text(panel.title)}</h3></figcaption>
        <ul>{"".join(names)}</ul>
        <div class="plot" tabindex="0" role="slider" aria-labelledby="panel-{index}" \
aria-valuemin="0" aria-valuemax="{panel.last}" aria-valuenow="0" aria-valuetext="start">
          <svg viewBox="0 0 {PLOT["width"]} {PLOT["height"]}" aria-hidden="true">
            <clipPath id="{clip}"><rect x="{left - 2}" y="{top - 2}" width="{right - left + 4}" \
height="{bottom - top + 4}"/></clipPath>
            {_axes(panel)}{events}
            <g class="now" transform="translate({left} 0)"><line y1="{top}" y2="{bottom}"/></g>
            <g clip-path="url(#{clip})">{"".join(curves)}</g>
            <g class="probe" style="display:none"><line y1="{top}" y2="{bottom}"/></g>
            {"".join(dots)}
          </svg>
        </div>
      </figure>"""


def _at(panel: Panel, frame: float) -> float:
    return PLOT["left"] + (PLOT["right"] - PLOT["left"]) * frame / max(panel.last, 1)


def _height(panel: Panel, value: float) -> float:
    low, high, _ = value_axis(panel)
    return PLOT["bottom"] - (PLOT["bottom"] - PLOT["top"]) * (value - low) / (high - low)


def _path(panel: Panel, rank: int) -> str:
    """A curve's path data; a gap where a value is missing."""
    path, pen = [], "M"
    for frame, value in enumerate(panel_values(panel, panel.series[rank])):
        if math.isfinite(value):
            path.append(f"{pen}{_at(panel, frame):.2f} {_height(panel, value):.2f}")
            pen = "L"
        else:
            pen = "M"
    return "".join(path)


def _axes(panel: Panel) -> str:
    """Grid lines and numbers; the x axis counts frames."""
    left, right, top, bottom = (PLOT[side] for side in ("left", "right", "top", "bottom"))
    drawn = [f'<text x="0" y="10">{_text(panel.ylabel)}</text>']
    for value in value_axis(panel)[2]:
        y = _height(panel, value)
        number = f"{value:g}".replace("-", "−")
        drawn.append(f'<path class="grid" d="M{left} {y:.2f}H{right}"/>')
        drawn.append(f'<text x="{left - 6}" y="{y + 4:.2f}" text-anchor="end">{number}</text>')
    for frame in frame_ticks(panel.last):
        x = _at(panel, frame)
        drawn.append(f'<path class="grid" d="M{x:.2f} {top}V{bottom}"/>')
        drawn.append(f'<text x="{x:.2f}" y="{bottom + 14}" text-anchor="middle">{frame}</text>')
    middle = (left + right) / 2
    drawn.append(f'<text x="{middle:g}" y="{bottom + 27}" text-anchor="middle">frame</text>')
    return "".join(drawn)


# ------------------------------------------------------------------------------------- the words


def _happenings(told: Sequence[str]) -> Iterable[str]:
    for frame, caption in enumerate(told):
        name = "start" if frame == 0 else f"frame {frame}"
        yield (
            f'<li><button type="button" data-frame="{frame}"><span>{name}</span> '
            f"{_text(caption)}</button></li>"
        )


def _text(text: str) -> str:
    """Escaped for HTML, in elements and in quoted attributes; what HTML cannot hold becomes �."""
    known = "".join(
        "\ufffd" if unicodedata.category(c) in ("Cc", "Cs") and c not in "\n\t" else c
        for c in text.replace("\r\n", "\n").replace("\r", "\n")
    )
    return escape(known, quote=True)


def _json(data: Any) -> str:
    """JSON for a <script> element: nothing in it can end that element or open a comment."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)  # ASCII only
    for letter in "<>&":
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return text
