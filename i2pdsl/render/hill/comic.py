"""Comic strips: one performance in key frames, or several in rows at the same moments."""

from __future__ import annotations

from collections.abc import Sequence

from i2pdsl.render.hill.figures import CRATES
from i2pdsl.render.hill.performance import Performance, opening, units
from i2pdsl.render.hill.scene import View, scene_svg, view_of
from i2pdsl.render.ink import INK
from i2pdsl.render.key_frames import evenly
from i2pdsl.render.lettering import caption_svg, fitted, heading_svg, text_svg, wrapped
from i2pdsl.render.mind import WINDOW, Window
from i2pdsl.render.panels import GUTTER, TEXT, TITLE, columns_of
from i2pdsl.render.raster import text_width

PANEL = 360.0  # pixels wide
GHOSTS, GHOST_SECONDS = 3, 0.6  # earlier poses behind each pose, and how far apart in time
LABEL = 150.0  # pixels for a performance's name beside its row
LINES = 4  # of a name or a caption, at most


def comic_svg(performance: Performance, frames: Sequence[int], title: str) -> str:
    """The given frames as a comic strip, captions below them, as an SVG document in pixels.

    Poses of the last moments before each frame are drawn faintly behind it.
    """
    view, columns = view_of([performance]), columns_of(len(frames))
    high = PANEL * view.height / view.width
    tags = [_seconds(performance, frame) for frame in frames]
    room = PANEL - max(text_width(tag, TEXT, True) for tag in tags) - 30
    texts = [wrapped(performance.caption(frame), TEXT, room, LINES) for frame in frames]
    band = 14 + 1.3 * TEXT * max(len(lines) for lines in texts)
    top = GUTTER + TITLE * 1.6
    panels = []
    for number, (frame, tag, lines) in enumerate(zip(frames, tags, texts, strict=True)):
        x = GUTTER + number % columns * (PANEL + GUTTER)
        y = top + number // columns * (high + band + GUTTER)
        panels.append(
            f'<g transform="translate({x:g} {y:g})">'
            f"{_panel(performance, frame, view, CRATES[0])}"
            f"{caption_svg(tag, lines, high, TEXT)}</g>"
        )
    rows = -(-len(frames) // columns)
    width = GUTTER + columns * (PANEL + GUTTER)
    bottom = top + rows * (high + band + GUTTER)
    heading = heading_svg(GUTTER, GUTTER + 0.85 * TITLE, title, TITLE, width - 2 * GUTTER)
    more = f"The box weighs {performance.weight:g}. Numbers on the slope: units from the start."
    note = text_svg(GUTTER, bottom, more, 0.85 * TEXT)
    return _document(width, bottom + 1.2 * TEXT, heading + "".join(panels) + note)


def together_svg(performances: Sequence[Performance], title: str, count: int = 4) -> str:
    """Several performances, one to a row, at the same `count` moments, as an SVG document."""
    view = view_of(performances)
    lasting = max(performances, key=lambda p: p.frames)
    frames = evenly(lasting.frames, count, opening(lasting.frames))
    high = PANEL * view.height / view.width
    top = GUTTER + TITLE * 1.6 + 30
    parts = []
    for number, frame in enumerate(frames):
        x = GUTTER + LABEL + number * (PANEL + GUTTER)
        tag = caption_svg(_seconds(lasting, frame), [], 0, TEXT)
        parts.append(f'<g transform="translate({x:g} {top - 36:g})">{tag}</g>')
    for row, performance in enumerate(performances):
        y = top + row * (high + GUTTER)
        lines = wrapped(performance.title, 1.1 * TEXT, LABEL - 16, LINES)
        notes = [f"box: {performance.weight:g}", f"came {units(performance.distance[-1])}"]
        parts += [
            text_svg(GUTTER, y + 20 + 20 * k, line, 1.1 * TEXT, True)
            for k, line in enumerate(lines)
        ]
        parts += [
            text_svg(GUTTER, y + 24 + 20 * (len(lines) + k), note, 0.9 * TEXT)
            for k, note in enumerate(notes)
        ]
        for number, frame in enumerate(frames):
            x = GUTTER + LABEL + number * (PANEL + GUTTER)
            drawn = _panel(
                performance, min(frame, performance.frames), view, CRATES[row % len(CRATES)]
            )
            parts.append(f'<g transform="translate({x:g} {y:g})">{drawn}</g>')
    width = GUTTER + LABEL + len(frames) * (PANEL + GUTTER)
    height = top + len(performances) * (high + GUTTER)
    heading = heading_svg(GUTTER, GUTTER + 0.85 * TITLE, title, TITLE, width - 2 * GUTTER)
    return _document(width, height, heading + "".join(parts))


def _document(width: float, height: float, content: str) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" '
        f'viewBox="0 0 {width:g} {height:g}"><rect width="100%" height="100%" fill="#fff"/>'
        f"{content}</svg>"
    )


def _panel(performance: Performance, frame: int, view: View, crate: str) -> str:
    """A frame with its ghosts and its border; which window it lies in is written on it."""
    apart = max(1, round(GHOST_SECONDS / performance.frame_seconds))
    ghosts = [frame - apart * k for k in range(GHOSTS, 0, -1) if frame - apart * k >= 0]
    high = PANEL * view.height / view.width
    window = performance.window_at(frame)
    edge = f'fill="none" stroke="{INK}" stroke-width="2"'
    return (
        f'<svg width="{PANEL:g}" height="{high:g}" viewBox="{view.box}">'
        f"{scene_svg(performance, frame, view, crate, ghosts)}</svg>"
        f'<rect width="{PANEL:g}" height="{high:g}" {edge}/>{_sign(window) if window else ""}'
    )


def _sign(window: Window) -> str:
    label = fitted(window.label, 0.9 * TEXT, PANEL - 40, bold=True)
    if not label:
        return ""
    wide = text_width(label, 0.9 * TEXT, bold=True) + 16
    return (
        f'<rect x="8" y="8" width="{wide:g}" height="{1.5 * TEXT:g}" rx="5" fill="{WINDOW}" '
        f'stroke="{INK}" stroke-width="1.4"/>'
        f"{text_svg(16, 8 + 1.08 * TEXT, label, 0.9 * TEXT, True)}"
    )


def _seconds(performance: Performance, frame: int) -> str:
    return f"{frame * performance.frame_seconds:.1f} s"
