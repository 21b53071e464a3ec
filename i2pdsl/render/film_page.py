"""One HTML page around any film: a player, the curves that run along, what happens, the source.

The page is a single file that fetches nothing: drawings, curves, style and player are all inside,
under a Content-Security-Policy that names the script's hash, so that no other script could run even
if a story's text were to smuggle one in. Its parts lie in `render/page`: `page.html` and
`controls.html` (string.Templates), `page.css`, `player.js` with `clock.js`, and for each kind of
film a script that defines `makeStage(film)`, whose `draw(time)` moves the drawing; that lies with
the kind's drawing.
"""

import base64
import hashlib
import json
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from string import Template
from typing import Any

import numpy as np

from i2pdsl.objective.wishes import Wish
from i2pdsl.render.markup import plain
from i2pdsl.render.mind import (
    DASHES,
    Mark,
    Panel,
    Window,
    frame_ticks,
    panel_values,
    value_axis,
)
from i2pdsl.render.reasons import Account
from i2pdsl.render.why import why_section

PLAYER = ("page/clock.js", "page/playback.js", "page/player.js", "page/start.js")
_MODULAR = re.compile(r"^(?:import .*\n|export (?=const))", re.MULTILINE)
PLOT = {"width": 200, "height": 128, "left": 30, "right": 194, "top": 20, "bottom": 98}


@dataclass(frozen=True)
class Film:
    """What a page shows and plays.

    Attributes:
        stage: HTML of the drawing as it is at time 0.
        aspect: the stage's width to its height.
        last: T, the last frame.
        seconds: [T] that each frame lasts at speed 1.
        rests: [T] that its end is held.
        captions: T + 1 texts.
        happenings: the frames whose captions are listed.
        script: the module, below `render`, that exports `makeStage`.
        data: what that script reads, besides what all players do.
        classes: of the stage's section.
    """

    stage: str
    aspect: float
    last: int
    seconds: Sequence[float] | np.ndarray
    rests: Sequence[float] | np.ndarray
    captions: Sequence[str]
    happenings: Sequence[int]
    script: str
    data: dict[str, Any] = field(default_factory=dict)
    classes: str = "theatre"


def film_page(
    film: Film,
    panels: Sequence[Panel],
    title: str,
    about: str,
    source: str,
    marks: Sequence[Mark] = (),
    windows: Sequence[Window] = (),
    language: str = "en",
    wishes: Sequence[Wish] = (),
    account: Account | None = None,
) -> str:
    """The page. `panels` cover the film's frames 0..T; `marks` and `windows` are shown in them.
    `wishes` are what became of those of the story, `account` says why viewers believe it."""
    data = played(film, panels)
    script = one_script(film.script, *PLAYER)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return Template(part("page/page.html")).substitute(
        language=plain(language),
        policy=f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'; "
        "img-src data:; base-uri 'none'; form-action 'none'",
        title=plain(title),
        about=plain(about),
        style=part("page/page.css"),
        classes=film.classes,
        aspect=f"{film.aspect:.3f}",
        stage=film.stage,
        first_caption=plain(film.captions[0]),
        controls=controls(film.last),
        mind=_mind(panels, marks, windows),
        why=why_section(account) if account else "",
        wishes=_wishes(wishes),
        happenings="\n".join(_happenings(film)),
        source=plain(source),
        data=as_json(data),
        player=script,
    )


def controls(last: int) -> str:
    """What a player is held by."""
    return Template(part("page/controls.html")).substitute(last=last)


def to_mount(film: Film, panels: Sequence[Panel], title: str) -> dict[str, Any]:
    """A film for `mount(root, film)` anywhere: what the player reads, and the stage it moves."""
    return {
        **played(film, panels),
        "title": title,
        "stage": film.stage,
        "classes": film.classes,
        "aspect": film.aspect,
        "script": film.script,
    }


def played(film: Film, panels: Sequence[Panel]) -> dict[str, Any]:
    """What the player reads, for JSON; `panels` cover the film's frames 0..T."""
    if len(film.captions) != film.last + 1:
        raise ValueError(
            f"{film.last + 1} captions are needed, for frames 0 to {film.last}, "
            f"not {len(film.captions)}"
        )
    for panel in panels:
        if panel.last != film.last:
            raise ValueError(f"panel {panel.title!r} covers {panel.last} frames, not {film.last}")
    return {
        "last": film.last,
        "seconds": [round(float(each), 4) for each in film.seconds],
        "rests": [round(float(each), 4) for each in film.rests],
        "plot": PLOT,
        "panels": [_panel_data(panel) for panel in panels],
        "captions": list(film.captions),
        **film.data,
    }


def part(name: str) -> str:
    """A file below `render`."""
    return (files("i2pdsl.render") / name).read_text(encoding="utf-8")


def one_script(*names: str) -> str:
    """Modules below `render` as one script that is none: each imports only from those before it."""
    return '"use strict";\n' + "".join(_MODULAR.sub("", part(name)) for name in names)


# ----------------------------------------------------------------------------------- the curves


def _panel_data(panel: Panel) -> dict[str, Any]:
    low, high, _ = value_axis(panel)
    series = []
    for one in panel.series:
        values = [float(f"{v:.6g}") if math.isfinite(v) else None for v in panel_values(panel, one)]
        series.append({"label": one.label, "values": values})
    return {"title": panel.title, "kind": panel.kind, "low": low, "high": high, "series": series}


def _mind(panels: Sequence[Panel], marks: Sequence[Mark], windows: Sequence[Window]) -> str:
    """The section of the belief curves, or nothing where there are none."""
    if not panels:
        return ""
    notes = "; ".join(f"frame {mark.frame:g}, {mark.label}" for mark in marks if mark.label)
    dotted = f" Dotted line: {notes}." if notes else ""
    spans = "; ".join(f"frames {w.first} to {w.last}, {w.label}" for w in windows if w.label)
    dotted += f" Shaded: {spans}." if spans else ""
    figures = "\n".join(_panel(panel, marks, windows, index) for index, panel in enumerate(panels))
    return f"""\
  <section class="mind" aria-labelledby="mind-heading">
    <div class="mind-head">
      <h2 id="mind-heading">The audience’s mind</h2>
      <p class="hint">What somebody who watches comes to believe. \
Press anywhere on a curve to go there.{plain(dotted)}</p>
    </div>
    <div class="panels">
{figures}
    </div>
  </section>"""


def _panel(panel: Panel, marks: Sequence[Mark], windows: Sequence[Window], index: int) -> str:
    clip = f"clip-{index}"
    names, curves, dots = [], [], []
    for rank, series in enumerate(panel.series):
        hue = f'style="--hue: {series.color}"'
        dash = " ".join(f"{2.2 * part:g}" for part in DASHES[rank % len(DASHES)])
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        names.append(
            f'<li><svg class="swatch" viewBox="0 0 26 10" aria-hidden="true" {hue}>'
            f'<path d="M1 5H25"{dashed}/></svg>{plain(series.label)} <b></b></li>'
        )
        curves.append(f'<g class="curve" {hue}><path d="{_path(panel, rank)}"{dashed}/></g>')
        dots.append(f'<g class="curve" {hue}><circle class="dot here" r="4" cx="-99"/></g>')
    left, right, top, bottom = (PLOT[side] for side in ("left", "right", "top", "bottom"))
    spans = "".join(
        f'<rect class="window" x="{_at(panel, w.first):g}" y="{top}" height="{bottom - top}" '
        f'width="{_at(panel, w.last) - _at(panel, w.first):g}"/>'
        for w in windows
    )
    events = "".join(
        f'<path class="event" d="M{_at(panel, mark.frame):g} {top}V{bottom}"/>' for mark in marks
    )
    return f"""\
      <figure class="panel">
        <figcaption><h3 id="panel-{index}">{plain(panel.title)}</h3></figcaption>
        <ul>{"".join(names)}</ul>
        <div class="plot" tabindex="0" role="slider" aria-labelledby="panel-{index}" \
aria-valuemin="0" aria-valuemax="{panel.last}" aria-valuenow="0" aria-valuetext="start">
          <svg viewBox="0 0 {PLOT["width"]} {PLOT["height"]}" aria-hidden="true">
            <clipPath id="{clip}"><rect x="{left - 2}" y="{top - 2}" width="{right - left + 4}" \
height="{bottom - top + 4}"/></clipPath>
            {spans}{_axes(panel)}{events}
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
    drawn = [f'<text x="0" y="10">{plain(panel.ylabel)}</text>']
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


# ------------------------------------------------------------------------------------ the wishes


def _wishes(wishes: Sequence[Wish]) -> str:
    """A bar for each wish: what was reached of what is possible; nothing where nobody looked."""
    if not wishes:
        return ""
    bars = "\n".join(_bar(wish) for wish in wishes)
    return f"""\
  <section class="wishes" aria-labelledby="wishes-heading">
    <h2 id="wishes-heading">What was wished for</h2>
    <ul>
{bars}
    </ul>
  </section>"""


def _bar(wish: Wish) -> str:
    told = f"{wish.reached:.4g}"
    bar = ""
    if wish.possible is not None:
        told += f" ({wish.possible:.4g} alone)"
        missing = abs(wish.possible - wish.reached)
        share = 1 - missing / max(abs(wish.possible), abs(wish.reached), 1e-12)
        bar = f'<span class="bar"><i style="width: {100 * max(share, 0):.0f}%"></i></span>'
    frames = ", ".join(map(str, wish.frames))
    hurt = f"<small>most is missing in frame{'s' * (len(wish.frames) > 1)} {frames}</small>"
    numbers = told.replace("-", "−")
    return (
        f"      <li><code>{plain(wish.source)}</code>{bar}<b>{numbers}</b>"
        f"{hurt if frames else ''}</li>"
    )


# ------------------------------------------------------------------------------------- the words


def _happenings(film: Film) -> Iterable[str]:
    for frame in film.happenings:
        name = "start" if frame == 0 else f"frame {frame}"
        yield (
            f'<li><button type="button" data-frame="{frame}"><span>{name}</span> '
            f"{plain(film.captions[frame])}</button></li>"
        )


def as_json(data: Any) -> str:
    """JSON for a <script> element: nothing in it can end that element or open a comment."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)  # ASCII only
    for letter in "<>&":
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return text
