"""Comic strips: the whole way of a performance and its key frames, or several in rows at the same
moments."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from i2pdsl.render.ink import INK
from i2pdsl.render.key_frames import evenly
from i2pdsl.render.lettering import caption_svg, fitted, heading_svg, text_svg, wrapped
from i2pdsl.render.mind import WINDOW, Window
from i2pdsl.render.panels import GUTTER, TEXT, TITLE
from i2pdsl.render.plane.figures import (
    cast_svg,
    ghosts_svg,
    key_svg,
    scene_svg,
    tint,
    trail_svg,
)
from i2pdsl.render.plane.names import Name, names_svg, place_names
from i2pdsl.render.plane.performance import Performance
from i2pdsl.render.plane.room import View, room_svg, view_within
from i2pdsl.render.raster import text_width

PANEL = (300.0, 250.0)  # pixels that a panel has at most
WIDE, WIDE_PANEL = 2.2, 430.0  # from which shape on a room counts as wide, and its panels' width
SLOT = 190.0  # pixels that a panel's caption has at least
LINES = 4  # of a caption, at most
ASIDE = 270.0  # pixels that the whole way has at least: what is said below it needs them
LABEL = 150.0  # pixels for a performance's name beside its row
DOT = 3.6  # pixels: of the moments on the way
OLD = 1.5  # the span over which the whole way fades, in its own: its beginning is well seen


def comic_svg(performance: Performance, frames: Sequence[int], title: str) -> str:
    """The whole way with numbers where the given frames are, and then these, captions below them,
    as an SVG document in pixels."""
    shape = performance.spec.width / performance.spec.height
    view = view_within(performance.spec, WIDE_PANEL if shape > WIDE else PANEL[0], PANEL[1])
    slot = max(view.width, SLOT)
    tags = ["start" if t == 0 else str(t) for t in frames]
    room = slot - max(text_width(tag, TEXT, True) for tag in tags) - 30
    texts = [wrapped(performance.captions[t], TEXT, room, LINES) for t in frames]
    band = 14 + 1.3 * TEXT * max(len(lines) for lines in texts)
    high = view.height + band + GUTTER
    top = GUTTER + TITLE * 1.6
    # Beside the whole way two rows of panels; below it, where rooms are wide.
    columns = max(2, -(-len(frames) // 2)) if shape <= WIDE else 2
    if shape <= WIDE:
        large = view_within(performance.spec, 2 * slot + GUTTER, 2 * high - GUTTER - band)
        x0, y0 = 2 * GUTTER + max(large.width, ASIDE), top
    else:
        large = view_within(performance.spec, columns * slot + GUTTER, 2 * PANEL[1])
        x0, y0 = GUTTER, top + large.height + 14 + 1.3 * TEXT + GUTTER
    told = f"the whole way, {performance.frames} frames"
    parts = [
        f'<g class="whole" transform="translate({GUTTER:g} {top:g})">'
        f"{_overview(performance, large, frames)}"
        f"{caption_svg('all', [told], large.height, TEXT)}</g>"
    ]
    for number, (frame, tag, lines) in enumerate(zip(frames, tags, texts, strict=True)):
        x, y = x0 + number % columns * (slot + GUTTER), y0 + number // columns * high
        since = frames[number - 1] if number else frame
        parts.append(
            f'<g class="panel" transform="translate({x:g} {y:g})">'
            f"{_panel(performance, view, since, frame)}"
            f"{caption_svg(tag, lines, view.height, TEXT)}</g>"
        )
    rows = -(-len(frames) // columns)
    width = x0 + columns * (slot + GUTTER)
    bottom = y0 + rows * high
    # Who is who stands below the whole way, where the panels beside it leave room for it.
    key_top = top + large.height + 48 if shape <= WIDE else bottom + 4
    bottom = max(bottom, key_top + 22 + GUTTER)
    heading = heading_svg(GUTTER, GUTTER + 0.85 * TITLE, title, TITLE, width - 2 * GUTTER)
    key = key_svg(performance.spec, GUTTER, key_top, max(large.width, ASIDE))
    still = f'<g id="room">{_still(view, [performance])}</g>'
    return _document(width, bottom, still, heading + "".join(parts) + key)


def together_svg(performances: Sequence[Performance], title: str, count: int = 5) -> str:
    """Several performances, one to a row, at the same `count` moments, as an SVG document."""
    lasting = max(performances, key=lambda p: p.frames)
    frames = evenly(lasting.frames, count)
    spec = lasting.spec
    view = view_within(spec, *PANEL)
    slot = max(view.width, SLOT)
    top = GUTTER + TITLE * 1.6
    y, parts = top, []
    for performance in performances:
        own = [min(frame, performance.frames) for frame in frames]
        tags = ["start" if t == 0 else str(t) for t in own]
        room = slot - max(text_width(tag, TEXT, True) for tag in tags) - 30
        texts = [wrapped(performance.captions[t], TEXT, room, LINES) for t in own]
        parts += [
            text_svg(GUTTER, y + 20 + 20 * k, line, 1.1 * TEXT, True)
            for k, line in enumerate(wrapped(performance.title, 1.1 * TEXT, LABEL - 16, LINES))
        ]
        for number, (frame, tag, lines) in enumerate(zip(own, tags, texts, strict=True)):
            x = GUTTER + LABEL + number * (slot + GUTTER)
            parts.append(
                f'<g class="panel" transform="translate({x:g} {y:g})">'
                f"{_panel(performance, view, 0, frame)}"
                f"{caption_svg(tag, lines, view.height, TEXT)}</g>"
            )
        y += view.height + 14 + 1.3 * TEXT * max(map(len, texts)) + GUTTER
    width = GUTTER + LABEL + len(frames) * (slot + GUTTER)
    heading = heading_svg(GUTTER, GUTTER + 0.85 * TITLE, title, TITLE, width - 2 * GUTTER)
    key = key_svg(spec, GUTTER + LABEL, y + 4, width - LABEL - 2 * GUTTER)
    still = f'<g id="room">{_still(view, performances)}</g>'
    return _document(width, y + 34, still, heading + "".join(parts) + key)


def _document(width: float, height: float, defined: str, content: str) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" '
        f'viewBox="0 0 {width:g} {height:g}"><rect width="100%" height="100%" fill="#fff"/>'
        f"<defs>{defined}</defs>{content}</svg>"
    )


def _still(view: View, performances: Sequence[Performance]) -> str:
    return room_svg(view) + names_svg(view, place_names(view), performances)


def _framed(view: View, content: str, window: Window | None) -> str:
    """A picture of a room at (0, 0) with its border; which window it lies in is written on it."""
    edge = f'fill="none" stroke="{INK}" stroke-width="2"'
    return (
        f'<svg width="{view.width:.2f}" height="{view.height:.2f}" viewBox="{view.box}">'
        f"{content}</svg>"
        f'<rect width="{view.width:.2f}" height="{view.height:.2f}" {edge}/>'
        f"{_sign(window, view) if window else ''}"
    )


def _panel(performance: Performance, view: View, since: int, frame: int) -> str:
    """A frame, with the way since an earlier one."""
    ghosts = ghosts_svg(performance, view, since) if since < frame else ""
    moving = scene_svg(performance, view, since, frame, max(frame - since, 1))
    content = f'<use href="#room"/>{ghosts}{moving}'
    return _framed(view, content, performance.window_at(frame))


def _overview(performance: Performance, view: View, frames: Sequence[int]) -> str:
    """The whole way, with the numbers of some frames, and the end."""
    last, characters = performance.frames, performance.spec.characters
    trails, dots, names = "", "", place_names(view)
    small = 0.85 * view.text
    for number, character in enumerate(characters):
        trails += trail_svg(performance, view, number, 0, last, OLD * max(last, 1))
        color = tint(character)
        course = performance.positions[:, number]
        if len(characters) > 1:
            reach = view.radius(number)
            names.append(Name(character.name, course[0], reach, view.text, character.color))
        seen = [course[0], course[-1]]
        for frame in frames:
            # Not where somebody stays: one number there is enough, or none at either end.
            away = min(np.hypot(*(course[frame] - other)) for other in seen)
            if away * view.scale < 1.2 * view.radius(number):
                continue
            seen.append(course[frame])
            x, y = view.pixels(course[frame])
            dots += (
                f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{DOT}" fill="#fff" stroke="{color}" '
                'stroke-width="2"/>'
            )
            names.append(Name(str(frame), course[frame], DOT, small, character.color))
    content = (
        f"{room_svg(view)}{ghosts_svg(performance, view, 0)}{trails}{dots}"
        f"{cast_svg(performance, view, last)}"
        f"{names_svg(view, names, [performance])}"
    )
    return _framed(view, content, None)


def _sign(window: Window, view: View) -> str:
    label = fitted(window.label, 0.9 * TEXT, view.width - 40, bold=True)
    if not label:
        return ""
    wide = text_width(label, 0.9 * TEXT, bold=True) + 16
    return (
        f'<rect x="8" y="8" width="{wide:g}" height="{1.5 * TEXT:g}" rx="5" fill="{WINDOW}" '
        f'stroke="{INK}" stroke-width="1.4"/>'
        f"{text_svg(16, 8 + 1.08 * TEXT, label, 0.9 * TEXT, True)}"
    )
