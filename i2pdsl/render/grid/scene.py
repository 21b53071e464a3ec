"""One moment of a film as SVG: the kitchen, its rugs, and the cast in their places.

Coordinates are cells times `cell` (pixels), the map's top left at (0, 0); a frame of MARGIN cells
surrounds it. The parts are separate so that the HTML page and the film can draw the background and
the symbols once: `stage_background`, `stage_symbols`, and what moves, `cast_svg`.
"""

from collections.abc import Mapping
from math import ceil
from xml.sax.saxutils import escape

from i2pdsl.render.grid.sprites import (
    UTENSIL_DRAWINGS,
    actor_symbols,
    mark_symbols,
    symbol_id,
    tile_actor,
)
from i2pdsl.render.grid.stage import DIRECTIONS, Actor, Cell, Stage, Tile
from i2pdsl.render.grid.tracks import POSES, Film, Key, sample
from i2pdsl.render.ink import INK, mix
from i2pdsl.render.lettering import FONTS
from i2pdsl.render.raster import text_width

MARGIN = 0.42  # cells of frame around the map; marks and antennas may reach into it
LEAST = 16.0  # pixels: nobody is drawn smaller, however small the cells of a large map
FOOT = 0.94  # where in its cell an actor stands, from the cell's top
LARGEST_SCENE = 2.2e6  # pixels of a picture, of large maps
WHITE, CREAM, BLACK = "#ffffff", "#fff3d9", "#000000"


def life(cell: float) -> float:
    """How much larger than life the cast is drawn where cells are small: 1 where they are not."""
    return max(1.0, LEAST / cell)


def margin(cell: float) -> float:
    """Pixels of frame around the map: as much as the cast needs that stands at its edge."""
    return MARGIN * life(cell) * cell


def scene_size(stage: Stage, cell: float = 64) -> tuple[int, int]:
    """Width and height of a scene in whole pixels, frame included."""
    width, height = (side * cell + 2 * margin(cell) for side in (stage.width, stage.height))
    return ceil(width - 1e-6), ceil(height - 1e-6)


def view_box(stage: Stage, cell: float = 64) -> str:
    """The `viewBox` of a scene: the map starts at (0, 0), the frame lies outside it."""
    width, height = scene_size(stage, cell)
    return f"{-margin(cell):g} {-margin(cell):g} {width:g} {height:g}"


def svg_document(stage: Stage, cell: float, content: str) -> str:
    """A complete SVG document of a scene's size around the content."""
    width, height = scene_size(stage, cell)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" '
        f'viewBox="{view_box(stage, cell)}">{content}</svg>'
    )


def scene_svg(stage: Stage, film: Film, time: float, cell: float = 64) -> str:
    """The whole scene at a time (in turns) as an SVG document; `cell` in pixels."""
    content = f"{stage_background(stage, cell)}{cast_svg(stage, film, time, cell)}"
    content += labels_svg(stage, cell)
    return svg_document(stage, cell, f"<defs>{stage_symbols(stage)}</defs>{content}")


def stage_symbols(stage: Stage, poses: Mapping[str, tuple[str, ...]] | None = None) -> str:
    """All `<symbol>`s that `cast_svg` may use, for a `<defs>`.

    `poses` (actor's name to poses) limits them, for a document that shows one moment.
    """
    chosen = poses or {}
    actors = (actor_symbols(a, chosen.get(a.name, POSES)) for a in stage.cast)
    return "".join(actors) + mark_symbols(stage)


# ---------------------------------------------------------------------------------- what moves


def cast_svg(stage: Stage, film: Film, time: float, cell: float = 64) -> str:
    """Shadows, cast and marks at a time, in drawing order; needs `stage_symbols`."""
    keys = [(actor, sample(film.tracks[actor.name], time)) for actor in stage.cast]
    seen = [(actor, key) for actor, key in keys if key.opacity > 0]
    seen.sort(key=lambda pair: pair[1].y)  # who is nearer hides who is farther
    marks = [
        mark_svg(mark.kind, sample(mark.track, time), cell)
        for mark in film.marks
        if mark.track[0].time < time < mark.track[-1].time
    ]
    shadows = [shadow_svg(key, cell) for _, key in seen]
    return "".join(shadows + [actor_svg(actor, key, cell) for actor, key in seen] + marks)


def actor_svg(actor: Actor, key: Key, cell: float = 64) -> str:
    """An actor as its key has it: lifted, scaled and turned about its foot."""
    x, y = (key.x + 0.5) * cell, (key.y + FOOT - key.lift) * cell
    return (
        f'<use href="#{symbol_id(actor, key.pose)}"{_opacity(key.opacity)} '
        f'transform="{_placed(x, y, key, cell)} translate(-50 -94)"/>'
    )


def mark_svg(kind: str, key: Key, cell: float = 64) -> str:
    """A mark about its cell's centre."""
    x, y = (key.x + 0.5) * cell, (key.y + 0.5 - key.lift) * cell
    return (
        f'<use href="#mark--{kind}"{_opacity(key.opacity)} '
        f'transform="{_placed(x, y, key, cell)} translate(-50 -50)"/>'
    )


def shadow_svg(key: Key, cell: float = 64) -> str:
    """The shadow on the floor: the higher the actor, the smaller and fainter."""
    size = life(cell) * key.scale_x / (1 + 0.22 * key.lift)
    dark = 0.30 * key.opacity / (1 + 0.30 * key.lift)
    x, y = (key.x + 0.5) * cell, (key.y + FOOT - 0.015) * cell
    return "".join(
        f'<ellipse cx="{x:.2f}" cy="{y:.2f}" rx="{rx * size * cell:.2f}" '
        f'ry="{ry * size * cell:.2f}" fill="{INK}" opacity="{dark * part:.3f}"/>'
        for rx, ry, part in ((0.46, 0.135, 0.5), (0.38, 0.10, 0.9))
    )


def _placed(x: float, y: float, key: Key, cell: float) -> str:
    size = life(cell) * cell / 100
    scale = f"scale({key.scale_x * size:.4f} {key.scale_y * size:.4f})"
    turn = f" rotate({key.angle * 360:.2f})" if key.angle else ""
    return f"translate({x:.2f} {y:.2f}){turn} {scale}"


def _opacity(opacity: float) -> str:
    return "" if opacity >= 1 else f' opacity="{opacity:.3f}"'


# ------------------------------------------------------------------------------ what stands still


def stage_background(stage: Stage, cell: float = 64) -> str:
    """Frame, floor, tiles and walls; the tiles' names are in front of the cast (`labels_svg`)."""
    walls = [(c, r) for r in range(stage.height) for c in range(stage.width)]
    walls = [at for at in walls if stage.is_wall(at)]
    shading = [] if stage.wall_sprite else walls
    looks = [tile_actor(tile) for tile in stage.tiles]
    drawn = {look.name: look for look in looks if look is not None}
    if stage.wall_sprite:
        drawn[_WALL] = Actor(_WALL, stage.wall_sprite, stage.wall, "wall", stage.wall_drawing)
    symbols = "".join(actor_symbols(look, ("idle",)) for look in drawn.values())
    return "".join(
        [
            f"<defs>{symbols}</defs>" if symbols else "",
            _floor(stage, cell),
            *(
                _rug(i, tile, cell) if look is None else _still(look, tile.cell, cell)
                for i, (tile, look) in enumerate(zip(stage.tiles, looks, strict=True))
            ),
            *(_ways(tile, cell) for tile in stage.tiles),
            # As one group: where two shadows overlap it is no darker.
            f'<g opacity="0.16">{"".join(_wall_shadow(at, cell) for at in shading)}</g>',
            _frame(stage, cell),
            *(
                _still(drawn[_WALL], at, cell) if stage.wall_sprite else _wall(stage, at, cell)
                for at in walls
            ),
            _fences(stage, cell),
        ]
    )


def labels_svg(stage: Stage, cell: float = 64) -> str:
    """The tiles' names, in front of everybody."""
    return "".join(_label(stage, tile, cell) for tile in stage.tiles)


_WALL = "wall/"  # no actor is called so


def _still(look: Actor, at: Cell, cell: float) -> str:
    """A tile or a wall that is drawn as something."""
    place = f"translate({at[0] * cell:g} {at[1] * cell:g}) scale({cell / 100:g})"
    return f'<use href="#{symbol_id(look, "idle")}" transform="{place}"/>'


def _rect(x: float, y: float, w: float, h: float, fill: str, more: str = "") -> str:
    return f'<rect x="{x:g}" y="{y:g}" width="{w:g}" height="{h:g}" fill="{fill}" {more}/>'


def _frame(stage: Stage, cell: float) -> str:
    """The room's edge, seen from above, and what lies outside it."""
    width, height = scene_size(stage, cell)
    m, w, h = margin(cell), stage.width * cell, stage.height * cell
    # A pixel more on every side, to be cut off, or the picture's edge might be see-through.
    a, across, down = -m - 1, width + 2, height + 2
    outside = f"M{a:g} {a:g} h{across} v{down} h{-across} Z M0 0 v{h:g} h{w:g} v{-h:g} Z"
    parts = [f'<path d="{outside}" fill="{stage.frame or mix(stage.wall, CREAM, 0.78)}"/>']
    for rim, color in ((0.16, mix(stage.wall, BLACK, 0.38)), (0.125, mix(stage.wall, BLACK, 0.10))):
        d = rim * cell / 2
        edge = f'rx="{d:g}" stroke="{color}" stroke-width="{2 * d:g}"'
        parts.append(_rect(-d, -d, w + 2 * d, h + 2 * d, "none", edge))
    return "".join(parts)


def _floor(stage: Stage, cell: float) -> str:
    """The ground as it is laid, darker along the room's top edge."""
    w, h = stage.width * cell, stage.height * cell
    light = mix(stage.floor, WHITE, 0.16)
    # A little under the frame, too, lest a seam shows.
    parts = [_rect(-1, -1, w + 2, h + 2, light)]
    shade = _rect(0, 0, w, 0.10 * cell, INK, 'opacity="0.10"')
    if stage.ground != "checker":
        return "".join((*parts, _LAID[stage.ground](stage, cell), shade))
    other = mix(stage.floor, "#7a4a20", 0.03)
    parts += [
        _rect(c * cell, r * cell, cell, cell, other)
        for r in range(stage.height)
        for c in range(stage.width)
        if (c + r) % 2
    ]
    grout = "".join(f"M{c * cell:g} 0 V{h:g}" for c in range(1, stage.width))
    grout += "".join(f"M0 {r * cell:g} H{w:g}" for r in range(1, stage.height))
    line = mix(light, "#7a4a20", 0.16)
    if grout:
        parts.append(f'<path d="{grout}" stroke="{line}" stroke-width="{0.018 * cell:g}"/>')
    return "".join((*parts, shade))


def _boards(stage: Stage, cell: float) -> str:
    """Long boards, three to a cell, whose ends do not meet."""
    w, rows = stage.width * cell, 3 * stage.height
    lines = "".join(f"M0 {r * cell / 3:g} H{w:g}" for r in range(1, rows))
    for r in range(rows):
        ends = range(1 + 2 * r % 5, 2 * stage.width, 5)
        lines += "".join(f"M{c * cell / 2:g} {r * cell / 3:g} v{cell / 3:g}" for c in ends)
    line = mix(stage.floor, "#5a3414", 0.30)
    return f'<path d="{lines}" stroke="{line}" stroke-width="{0.02 * cell:g}"/>'


def _grass(stage: Stage, cell: float) -> str:
    """Tufts here and there, the same ones in every picture; in the open, no lines between cells."""
    tufts = "".join(
        f"M{(c + x) * cell:g} {(r + y) * cell:g} l{-0.05 * cell:g} {-0.11 * cell:g} "
        f"m{0.05 * cell:g} {0.11 * cell:g} v{-0.14 * cell:g} "
        f"m0 {0.14 * cell:g} l{0.05 * cell:g} {-0.11 * cell:g}"
        for r in range(stage.height)
        for c in range(stage.width)
        for x, y in [((0.37 * c + 0.61 * r + 0.2) % 0.8 + 0.1, (0.53 * c + 0.29 * r) % 0.7 + 0.2)]
    )
    dots = "".join(
        f'<circle cx="{c * cell:g}" cy="{r * cell:g}" r="{0.025 * cell:g}"/>'
        for r in range(1, stage.height)
        for c in range(1, stage.width)
    )
    line = mix(stage.floor, "#2c5a1c", 0.42)
    return (
        f'<path d="{tufts}" fill="none" stroke="{line}" stroke-linecap="round" '
        f'stroke-width="{0.025 * cell:g}"/><g fill="{line}" opacity="0.6">{dots}</g>'
    )


_LAID = {"boards": _boards, "grass": _grass, "plain": lambda stage, cell: ""}


def _rug(i: int, tile: Tile, cell: float) -> str:
    """A soft rug with a stitched border, fringes, and a pattern that tells it apart in grey."""
    (c, r), color = tile.cell, tile.color
    x, y, edge = c * cell, r * cell, mix(tile.color, BLACK, 0.30)
    middle = (c + 0.5) * cell, (r + 0.5) * cell
    fringe = "".join(
        f"M{x + 0.035 * cell:g} {y + f * cell:g} h{0.07 * cell:g} "
        f"M{x + 0.895 * cell:g} {y + f * cell:g} h{0.07 * cell:g} "
        for f in (0.16, 0.27, 0.38, 0.50, 0.62, 0.73, 0.84)
    )

    def inset(by: float, fill: str, more: str) -> str:
        side = (1 - 2 * by) * cell
        return _rect(x + by * cell, y + by * cell, side, side, fill, more)

    thin = f'stroke-width="{0.022 * cell:g}"'
    return (
        f'<path d="{fringe}" stroke="{edge}" stroke-width="{0.03 * cell:g}" '
        'stroke-linecap="round"/>'
        + inset(0.07, mix(color, WHITE, 0.12), f'rx="{0.09 * cell:g}" stroke="{edge}" {thin}')
        + inset(
            0.14,
            "none",
            f'rx="{0.06 * cell:g}" stroke="{mix(color, WHITE, 0.75)}" {thin} '
            f'stroke-dasharray="{0.06 * cell:g} {0.045 * cell:g}"',
        )
        + ("" if tile.ways else _pattern(i, *middle, mix(color, WHITE, 0.36), cell))
    )


_TURNED = {"east": 0, "south": 90, "west": 180, "north": 270}  # degrees


def _ways(tile: Tile, cell: float) -> str:
    """Arrow heads on a tile that is left and entered in some directions only."""
    x, y, a = (tile.cell[0] + 0.5) * cell, (tile.cell[1] + 0.5) * cell, 0.13 * cell
    heads = "".join(f"M{k * a:g} {-a:g} l{a:g} {a:g} l{-a:g} {a:g} " for k in (0.3, 1.5))
    if len(tile.ways) == 1:
        heads = "".join(f"M{k * a:g} {-a:g} l{a:g} {a:g} l{-a:g} {a:g} " for k in (-1.5, -0.3, 0.9))
    look = f'fill="none" stroke="{mix(tile.color, BLACK, 0.45)}" stroke-width="{0.05 * cell:g}"'
    return "".join(
        f'<path d="{heads}" {look} stroke-linecap="round" stroke-linejoin="round" '
        f'transform="translate({x:g} {y:g}) rotate({_TURNED[way]})"/>'
        for way in tile.ways
    )


def _pattern(i: int, x: float, y: float, color: str, cell: float) -> str:
    """The middle of the i-th rug: a square, a disc, a lozenge, or stripes."""
    match i % 4:
        case 0:
            a = 0.23 * cell
            return _rect(x - a, y - a, 2 * a, 2 * a, color, f'rx="{0.05 * cell:g}"')
        case 1:
            return f'<circle cx="{x:g}" cy="{y:g}" r="{0.25 * cell:g}" fill="{color}"/>'
        case 2:
            a = 0.29 * cell
            way = f"M{x:g} {y - a:g} l{a:g} {a:g} l{-a:g} {a:g} l{-a:g} {-a:g} Z"
            return f'<path d="{way}" fill="{color}"/>'
        case _:
            bars = ((x + k * 0.17 * cell, y - 0.24 * cell) for k in (-1, 0, 1))
            return "".join(
                _rect(bx - 0.045 * cell, by, 0.09 * cell, 0.48 * cell, color) for bx, by in bars
            )


def _label(stage: Stage, tile: Tile, cell: float) -> str:
    """The tile's name on a tag over its lower edge, where nobody's face hides it."""
    column, row = tile.cell
    text, size = tile.name, max(0.17 * cell, 8.5)
    # Up to the middle between it and the next tag of about the same height.
    others = (
        abs(t.cell[0] - column)
        for t in stage.tiles
        if abs(t.cell[1] - row) * cell < 1.5 * size and t.cell != tile.cell
    )
    room = min((max(1.66 * cell, 70.0), *((apart - 0.20) * cell for apart in others)))
    if room < size:
        return ""
    # Large names shrink, down to what can be read; what is longer still is cut.
    size = max(min(size, size * room / max(text_width(text, size, bold=True), 1e-6)), 7.0)
    while len(text) > 2 and text_width(text, size, bold=True) > room + 0.1:
        text = text[:-2].rstrip() + "…"
    wide = text_width(text, size, bold=True)
    w, h = wide + 0.8 * size, 1.3 * size
    x, y = (column + 0.5) * cell, (row + 1.055) * cell
    x = min(max(x, w / 2 - 0.3 * cell), (stage.width + 0.3) * cell - w / 2)
    dark = mix(tile.color, BLACK, 0.55)
    tag = f'rx="{h / 2:g}" stroke="{mix(tile.color, BLACK, 0.30)}" stroke-width="{0.018 * cell:g}"'
    return _rect(x - w / 2, y - h / 2, w, h, mix(tile.color, WHITE, 0.86), tag) + (
        f'<text x="{x:g}" y="{y + 0.36 * size:g}" {FONTS} font-size="{size:.2f}" '
        f'font-weight="bold" text-anchor="middle" fill="{dark}">{escape(text)}</text>'
    )


FRONT = 0.30  # how much of a counter's cell shows its front, in cells


def _wall_shadow(at: Cell, cell: float) -> str:
    x, y = at[0] * cell, (at[1] + 0.1) * cell
    return _rect(x, y, 1.10 * cell, 1.02 * cell, INK, f'rx="{0.06 * cell:g}"')


def _wall(stage: Stage, at: Cell, cell: float) -> str:
    """A block, its top in the wall's colour, and its darker front where there is floor below it:
    in a kitchen a counter with doors."""
    (c, r), (x, y) = at, (at[0] * cell, at[1] * cell)
    beside = {
        side: stage.is_wall((c + dx, r + dy))
        and 0 <= c + dx < stage.width
        and 0 <= r + dy < stage.height
        for side, (dx, dy) in DIRECTIONS.items()
    }
    edge = mix(stage.wall, BLACK, 0.42)
    # A little wider than the cell, lest a seam shows between neighbours.
    parts = [_rect(x - 0.2, y - 0.2, cell + 0.4, cell + 0.4, stage.wall)]
    if not beside["south"]:
        front = y + (1 - FRONT) * cell
        parts.append(_rect(x - 0.2, front, cell + 0.4, FRONT * cell, mix(stage.wall, BLACK, 0.18)))
        if stage.has_counters:
            parts.append(_doors(stage, x, front, cell))
    if stage.has_counters:
        # Some counters carry something, the same ones in every picture.
        utensil = UTENSIL_DRAWINGS.get((3 * c + 5 * r) % 11, "")
        place = f"translate({x + 0.5 * cell:g} {y + 0.36 * cell:g}) scale({cell / 100:g})"
        parts.append(f'<g transform="{place}" opacity="0.75">{utensil}</g>' if utensil else "")
    sides = {
        "north": f"M{x:g} {y:g} h{cell:g}",
        "south": f"M{x:g} {y + cell:g} h{cell:g}",
        "west": f"M{x:g} {y:g} v{cell:g}",
        "east": f"M{x + cell:g} {y:g} v{cell:g}",
    }
    # An outline only where the counter ends: neighbours run into each other.
    lines = "".join(line for side, line in sides.items() if not beside[side])
    stroke = f'stroke="{edge}" stroke-width="{0.035 * cell:g}" stroke-linecap="round"'
    return "".join(parts) + f'<path d="{lines}" {stroke}/>'


FENCE = 0.12  # how thick a wall between two cells is, in cells


def _fences(stage: Stage, cell: float) -> str:
    """The walls between two cells: beams on the lines between them, that run into each other."""
    lines = "".join(
        f"M{x * cell:g} {y * cell:g} {'v' if x > before else 'h'}{cell:g}"
        for (before, _), (x, y) in stage.fences
    )
    wide, shade = FENCE * cell, 0.05 * cell
    beam = f'fill="none" stroke-linecap="round" d="{lines}"'
    edge, top = mix(stage.wall, BLACK, 0.42), mix(stage.wall, WHITE, 0.06)
    return (
        ""
        if not lines
        else (
            f'<path {beam} stroke="{INK}" stroke-width="{wide:g}" opacity="0.16" '
            f'transform="translate({shade:g} {shade:g})"/>'
            f'<path {beam} stroke="{edge}" stroke-width="{wide + 0.05 * cell:g}"/>'
            f'<path {beam} stroke="{top}" stroke-width="{wide:g}"/>'
        )
    )


def _doors(stage: Stage, x: float, y: float, cell: float) -> str:
    """A counter's front: the top's overhang and a pair of cupboard doors with knobs."""
    dark = mix(stage.wall, BLACK, 0.38)
    parts = [_rect(x - 0.2, y, cell + 0.4, 0.05 * cell, dark)]
    door = f'rx="{0.02 * cell:g}" stroke="{dark}" stroke-width="{0.018 * cell:g}"'
    for i in (0, 1):
        left, fill = x + (0.07 + 0.44 * i) * cell, mix(stage.wall, BLACK, 0.08)
        parts.append(_rect(left, y + 0.09 * cell, 0.42 * cell, 0.17 * cell, fill, door))
        knob, high = x + (0.44 + 0.12 * i) * cell, y + 0.175 * cell
        parts.append(f'<circle cx="{knob:g}" cy="{high:g}" r="{0.022 * cell:g}" fill="{INK}"/>')
    return "".join(parts)
