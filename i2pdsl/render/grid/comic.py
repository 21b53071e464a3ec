"""A finished script as a comic strip: the frames that matter, and what led from one to the next."""

from collections.abc import Mapping, Sequence
from typing import Any

from i2pdsl.render.grid.choreography import choreograph, facing
from i2pdsl.render.grid.scene import (
    MARGIN,
    actor_svg,
    labels_svg,
    life,
    margin,
    mark_svg,
    scene_size,
    shadow_svg,
    stage_background,
    stage_symbols,
)
from i2pdsl.render.grid.sprites import actor_tint
from i2pdsl.render.grid.stage import STEPS, Actor, Beat, Cell, Stage
from i2pdsl.render.grid.tracks import Film, Key, sample
from i2pdsl.render.ink import INK, mix
from i2pdsl.render.lettering import caption_svg, fitted, heading_svg, text_svg, wrapped
from i2pdsl.render.panels import GUTTER, TEXT, TITLE, columns_of
from i2pdsl.render.raster import text_width

# -------------------------------------------------------------------------------- the strip

LINES = 8  # of a caption, at most, and as many as long names are cut into
SMALL = 12.0  # pixels for a cell below which a map is better drawn larger, if it can be
WIDEST, TALLEST = 2600.0, 1400.0  # pixels of all panels in a row, and of one
AREA = 8e6  # pixels of all panels together


def comic_svg(
    stage: Stage,
    script: Mapping[str, Any],
    frames: Sequence[int],
    captions: Sequence[str] | None = None,
    title: str = "",
    columns: int | None = None,
    explained: bool = True,
) -> str:
    """A comic strip of the given frames (0 is the start) as an SVG document, in pixels.

    `captions` has a line for each of `frames`, written below its panel. How to read it, and who is
    who, stands below them if it is `explained`.
    """
    if captions is not None and len(captions) != len(frames):
        raise ValueError(f"{len(frames)} frames, but {len(captions)} captions")
    film = choreograph(stage, script)
    columns, cell = _fitted(stage, len(frames), columns)
    panel_width, panel_height = scene_size(stage, cell)
    slot = max(panel_width, 180.0)
    tags = ["start" if t == 0 else str(t) for t in frames]
    room = slot - max((text_width(tag, TEXT, True) for tag in tags), default=0) - 30
    texts = [wrapped(text, TEXT, room, LINES) for text in captions or [""] * len(frames)]
    band = 14 + 1.3 * TEXT * max((len(lines) for lines in texts), default=1)
    top = GUTTER + (TITLE * 1.6 if title else 0.0)

    panels = []
    for i, (t, tag, lines) in enumerate(zip(frames, tags, texts, strict=True)):
        x = GUTTER + (i % columns) * (slot + GUTTER)
        y = top + (i // columns) * (panel_height + band + GUTTER)
        since = frames[i - 1] if i else t
        panels.append(
            f'<g transform="translate({x:g} {y:g})">'
            f'<g transform="translate({(slot - panel_width) / 2 + margin(cell):g} '
            f'{margin(cell):g})">'
            f'<use href="#room"/>{_panel(stage, film, since, t, cell)}</g>'
            f'<rect x="{(slot - panel_width) / 2:g}" width="{panel_width:g}" '
            f'height="{panel_height:g}" fill="none" stroke="{INK}" stroke-width="2"/>'
            f"{caption_svg(tag, lines, panel_height, TEXT)}</g>"
        )
    rows = -(-len(frames) // columns)
    width = GUTTER + columns * (slot + GUTTER)
    bottom = top + rows * (panel_height + band + GUTTER)
    height = bottom + 1.2 * TEXT
    heading = ""
    if title:
        heading = heading_svg(GUTTER, GUTTER + 0.85 * TITLE, title, TITLE, width - 2 * GUTTER)
    legend, cast = "", ""
    if explained:
        legend = _legend(width, bottom)
        cast, room = _cast_legend(stage, width, bottom + TEXT)
        height += room
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" '
        f'viewBox="0 0 {width:g} {height:g}"><rect width="100%" height="100%" fill="#fff"/>'
        f'<defs>{stage_symbols(stage)}<g id="room">{stage_background(stage, cell)}</g></defs>'
        f"{heading}{''.join(panels)}{legend}{cast}</svg>"
    )


def _fitted(stage: Stage, count: int, columns: int | None) -> tuple[int, float]:
    """Panels in a row, and pixels for a cell: of large maps fewer panels stand side by side."""
    across, down = stage.width + 2 * MARGIN, stage.height + 2 * MARGIN
    usual = columns or columns_of(count)
    wish = min(max(27.0 * across, 250.0), 600.0)
    most = min((AREA / (count * across * down)) ** 0.5, TALLEST / down)
    cell = min(wish / across, 62.0, most)
    choices = [columns] if columns else range(usual, 0, -1)

    def size(number: int) -> float:
        return max(cell, min(SMALL, WIDEST / number / across, most))

    best = max(choices, key=lambda number: (round(size(number), 1), number))
    return best, size(best)


# ------------------------------------------------------------------------------ inside a panel

_HERE = Key(0, 0, 0)

SIZE = 1.12  # panels are small: the cast is drawn a little larger than life


def _panel(stage: Stage, film: Film, since: int, t: int, cell: float) -> str:
    """The state after frame t, with the ways gone since frame `since`."""
    beats = [beat for beat in film.beats if since < beat.frame <= t]
    ways: list[str] = []
    shoves: list[str] = []
    for i, actor in enumerate(stage.cast):
        # Each keeps to its own lane, so that ways over the same cells stay apart.
        lane = 0.13 * (i - (len(stage.cast) - 1) / 2)
        own, pushed = _trail(actor, _steps(actor.name, beats), lane, cell)
        ways += own
        shoves += pushed
    keys = [(actor, sample(film.tracks[actor.name], t)) for actor in stage.cast]
    standing = [
        (actor, Key(t, key.x, key.y, 0, *_size(key), pose=_mood(actor.name, beats, t)))
        for actor, key in keys
        if key.opacity > 0
    ]
    standing.sort(key=lambda pair: pair[1].y)
    ghosts = [_ghost(actor, beats, cell) for actor in stage.cast]
    cast = [shadow_svg(key, cell) for _, key in standing]
    cast += [actor_svg(actor, key, cell) for actor, key in standing]
    # Not beside those who failed and were then pushed elsewhere: the pusher stands there now.
    at = {actor.name: (key.x, key.y) for actor, key in standing}
    signs = [_sign(b, cell) for b in beats if b.frame == t and at.get(b.actor) == b.target]
    return "".join([*ghosts, *ways, *cast, labels_svg(stage, cell), *shoves, *signs])


def _size(key: Key) -> tuple[float, float]:
    return SIZE * key.scale_x, SIZE * key.scale_y


def _steps(name: str, beats: Sequence[Beat]) -> list[tuple[bool, Cell, Cell]]:
    """The moves of an actor in order: (by itself?, from, to)."""
    steps = []
    for beat in beats:
        if beat.actor == name and beat.origin and beat.target and beat.origin != beat.target:
            steps.append((True, beat.origin, beat.target))
        steps += [(False, s.origin, s.target) for s in beat.pushed if s.name == name]
    return steps


def _ghost(actor: Actor, beats: Sequence[Beat], cell: float) -> str:
    """A faint actor where its way since the last panel began."""
    steps = _steps(actor.name, beats)
    if not steps or steps[0][1] == steps[-1][2]:
        return ""
    x, y = steps[0][1]
    return f'<g opacity="0.30">{actor_svg(actor, Key(0, x, y, 0, SIZE, SIZE), cell)}</g>'


def _trail(
    actor: Actor, steps: Sequence[tuple[bool, Cell, Cell]], lane: float, cell: float
) -> tuple[list[str], list[str]]:
    """Own steps as solid arrows, pushed ones as dotted arrows with an open head.

    Whoever pushes stands on the way of whom it pushed: such arrows run along the lower and the
    right edges of the cells and are drawn over the cast, the others through the middle, below it.
    """
    color = mix(actor_tint(actor), "#2a1a10", 0.35)
    own: list[str] = []
    pushed: list[str] = []
    i = 0
    while i < len(steps):
        j = i
        while j + 1 < len(steps) and steps[j + 1][0] == steps[i][0]:
            j += 1
        run = [steps[i][1], *(step[2] for step in steps[i : j + 1])]
        if steps[i][0]:
            short = 0.50 if j + 1 == len(steps) else 0.12  # at the actor's edge, to be seen
            own.append(_arrow(run, True, color, (0.5 + lane, 0.62 + lane), short, cell))
        else:
            across, along = len({x for x, _ in run}) > 1, len({y for _, y in run}) > 1
            edges = (0.93 if along else 0.5, 0.97 if across else 0.6)
            pushed.append(_arrow(run, False, color, edges, 0.0, cell))
        i = j + 1
    return own, pushed


def _arrow(
    run: Sequence[Cell],
    own: bool,
    color: str,
    offset: tuple[float, float],
    short: float,
    cell: float,
) -> str:
    """An arrow through cells, `offset` within each, ending `short` (cells) before the last."""
    points = [((x + offset[0]) * cell, (y + offset[1]) * cell) for x, y in run]
    (ax, ay), (bx, by) = points[-2], points[-1]
    dx, dy = (bx > ax) - (bx < ax), (by > ay) - (by < ay)
    tip = (bx - dx * short * cell, by - dy * short * cell)
    large = life(cell) * cell
    head, thick = 0.24 * large, 0.09 * large
    base = (tip[0] - dx * head, tip[1] - dy * head)
    points[-1] = base
    way = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in points)
    side = 0.62 * head
    triangle = (
        f"M{tip[0]:.1f} {tip[1]:.1f} L{base[0] - dy * side:.1f} {base[1] + dx * side:.1f} "
        f"L{base[0] + dy * side:.1f} {base[1] - dx * side:.1f} Z"
    )
    line = 'fill="none" stroke-linecap="round" stroke-linejoin="round"'
    dash = "" if own else f' stroke-dasharray="{0.01 * cell:.1f} {1.8 * thick:.1f}"'
    fill = color if own else "#fff"
    return (
        f'<path d="{way}" {line} stroke="#fff" stroke-width="{1.9 * thick:.1f}" opacity="0.85"/>'
        f'<path d="{way}" {line} stroke="{color}" stroke-width="{thick:.1f}"{dash}/>'
        f'<path d="{triangle}" fill="{fill}" stroke="{color}" stroke-width="{0.6 * thick:.1f}" '
        'stroke-linejoin="round"/>'
    )


def _mood(name: str, beats: Sequence[Beat], t: int) -> str:
    """The pose that shows what happened to an actor in frame t."""
    mood = "idle"
    for beat in beats:
        if beat.frame != t:
            continue
        if beat.actor == name:
            verbs = {"step": "walk", "bump": "bump"}
            verbs |= dict.fromkeys(("push", "pull", "put"), "push")
            mood = "sad" if beat.verb == "fail" else mood
            mood = f"{verbs[beat.verb]}-{facing(beat)}" if beat.verb in verbs else mood
        elif beat.verb in ("fall", "vanish", "handed") or any(s.name == name for s in beat.pushed):
            mood = "surprised"
    return mood


def _sign(beat: Beat, cell: float) -> str:
    """A mark beside who failed, bumped or fell in the panel's own frame."""
    if beat.target is None:
        return ""
    (x, y), (dx, dy) = beat.target, STEPS.get(beat.direction, (0, 0))
    match beat.verb:
        case "fail":
            puff = Key(0, x + 0.60 * dx, y + 0.18 + 0.62 * dy, scale_x=0.42, scale_y=0.42)
            drop = Key(0, x - 0.40 if dx >= 0 else x + 0.40, y - 0.36, scale_x=0.34, scale_y=0.34)
            return mark_svg("puff", puff, cell) + mark_svg("sweat", drop, cell)
        case "pull":
            angle = 0.25 if dy else 0.0
            return mark_svg("grip", Key(0, x - 0.5 * dx, y - 0.5 * dy + 0.08, angle), cell)
        case "bump":
            star = Key(0, x + 0.54 * dx, y + 0.54 * dy, scale_x=0.5, scale_y=0.5)
            return mark_svg("bump", star, cell)
        case "fall":
            return "".join(
                mark_svg("dust", Key(0, x + 0.55 * s, y + 0.30, scale_x=0.5, scale_y=0.5), cell)
                for s in (-1, 1)
            ) + mark_svg("lines", Key(0, x, y - 0.5, 0.25, 0.6, 0.6), cell)
        case _:
            return ""


def _cast_legend(stage: Stage, width: float, y: float) -> tuple[str, float]:
    """Who is who, where the drawings do not say it, in rows below `y`; and how high that is."""
    if len(stage.cast) < 2 or all(actor.name == actor.sprite for actor in stage.cast):
        return "", 0.0
    side, size, x, row = 2.0 * TEXT, 0.85 * TEXT, GUTTER, 0
    parts = []
    for actor in stage.cast:
        name = fitted(actor.name, size, width - 2 * GUTTER - side - 6)
        wide = side + 6 + text_width(name, size) + 24
        if x > GUTTER and x + wide - 24 > width - GUTTER:
            x, row = GUTTER, row + 1
        top = y + row * 1.2 * side
        parts.append(f'<g transform="translate({x:g} {top:g})">{actor_svg(actor, _HERE, side)}</g>')
        parts.append(text_svg(x + side + 6, top + 0.65 * side, name, size))
        x += wide
    return "".join(parts), (row + 1) * 1.2 * side


def _legend(width: float, y: float) -> str:
    """How to read arrows and marks, at the lower right."""
    size = 0.85 * TEXT
    icons = {
        "own steps": (_arrow([(0, 0), (1, 0)], True, INK, (0, -0.14), 0, 34), 34),
        "pushed": (_arrow([(0, 0), (1, 0)], False, INK, (0, -0.14), 0, 34), 34),
        "failed": (mark_svg("puff", Key(0, -0.05, -0.62, 0, 0.8, 0.8), 22), 20),
        "blocked": (mark_svg("bump", Key(0, -0.05, -0.72, 0, 0.8, 0.8), 22), 20),
    }
    wide = sum(icon[1] + text_width(words, size) + 28 for words, icon in icons.items()) - 20
    if wide > width - 2 * GUTTER:  # a single narrow panel has no room for it
        return ""
    x, parts = width - GUTTER - wide, []
    for words, (icon, room) in icons.items():
        parts.append(f'<g transform="translate({x:g} {y:g})">{icon}</g>')
        parts.append(text_svg(x + room + 8, y, words, size))
        x += room + text_width(words, size) + 28
    return "".join(parts)
