"""The cast's drawings, tinted and posed into reusable symbols; tiles and walls that are drawn so.

A sprite file (worlds/sprites) is drawn in a 100 x 100 box, its feet at (50, 94). Each group
directly below the root is a layer, from back to front, and is shown in the poses that it names:

    <g data-part="...">          in every pose
    <g data-pose="idle walk">    in these poses, or verbs of poses ('walk' is walk-east and so on)
    <g data-pose="push-east">    in this pose, and mirrored in push-west unless that has its own
    <g data-look="4">            anywhere inside: shifted by 4 units in the pose's direction (eyes)

Fills named TINT, TINT_LIGHT, TINT_DARK and TINT_DEEP follow the actor's colour; `data-tint` on the
root is the colour of an actor that has none.

An own drawing whose `viewBox` is not 0 0 100 100, or that has no such layers, is one layer for
every pose, fitted into the box. If its root has `data-faces="east"` it is mirrored where the actor
heads west; with "west" the other way round.
"""

import re
import xml.etree.ElementTree as ET
from functools import cache
from xml.sax.saxutils import quoteattr

from i2pdsl.render.grid.stage import LOOKS, Actor, Stage, Tile
from i2pdsl.render.grid.tracks import POSES
from i2pdsl.render.ink import INK, mix
from i2pdsl.worlds.drawings import SVG, as_svg, builtin_sprite, builtin_sprites, tile_look

FALLBACK = "blob"
# An own drawing fits between these edges, its lower edge where the feet are.
LEFT, TOP, RIGHT, FEET = 6.0, 4.0, 94.0, 94.0


@cache
def _root(actor: Actor) -> ET.Element:
    """A drawing, own or built-in; its layers are the children."""
    if actor.drawing:
        return _layered(ET.fromstring(as_svg(actor.sprite, actor.drawing)))
    # Looked up among the names, never as a path: the sprite's name comes out of a .world file.
    name = actor.sprite if actor.sprite in builtin_sprites() else FALLBACK
    return ET.fromstring(builtin_sprite(name))


def _layered(root: ET.Element) -> ET.Element:
    """An own drawing as built-in ones are: what is no layer becomes one."""
    box = root.get("viewBox", "")
    shared = [child for child in root if child.tag == f"{{{SVG}}}defs"]
    drawn = [child for child in root if child.tag != f"{{{SVG}}}defs"]
    if box == "0 0 100 100" and all({*c.keys()} & {"data-pose", "data-part"} for c in drawn):
        return root
    left, top, width, height = map(float, box.split())
    scale = min((RIGHT - LEFT) / width, (FEET - TOP) / height)
    x, y = 50 - scale * (left + width / 2), FEET - scale * (top + height)
    looks = {key: value for key, value in root.attrib.items() if not key.startswith("data-")}
    looks.pop("viewBox")
    place = f"translate({x:.4f} {y:.4f}) scale({scale:.6f})"
    if root.get("data-faces") == "west":
        place = f"translate(100 0) scale(-1 1) {place}"
    made = ET.Element(root.tag, {key: v for key, v in root.attrib.items() if key == "data-tint"})
    made.extend(shared)
    poses = [pose for pose in POSES if not pose.endswith("west")]
    layer = {"data-pose": " ".join(poses)} if root.get("data-faces") else {"data-part": "all"}
    inside = ET.SubElement(ET.SubElement(made, f"{{{SVG}}}g", layer), f"{{{SVG}}}g", looks)
    inside.set("transform", place)
    inside.extend(drawn)
    return made


@cache
def actor_tint(actor: Actor) -> str:
    """The colour that stands for an actor: its own, or else its drawing's, as '#rrggbb'."""
    tint = actor.color or _root(actor).get("data-tint", "#999999")
    return mix(tint, tint, 0)


@cache
def _layers(actor: Actor) -> tuple[ET.Element, ...]:
    """A drawing's layers from back to front, tinted; first of all what they refer to, if any."""
    source, tint = ET.tostring(_root(actor), encoding="unicode"), actor_tint(actor)
    shades = {
        "TINT_LIGHT": mix(tint, "#ffffff", 0.45),
        "TINT_DARK": mix(tint, "#4a2a14", 0.28),
        "TINT_DEEP": mix(tint, "#3a1f10", 0.48),
        "TINT": tint,
    }
    for name, shade in shades.items():
        source = re.sub(rf'"{name}"', f'"{shade}"', source)
    # Two drawings on one page may call different things the same.
    own = _slug(actor.name)
    source = re.sub(r'\bid="', f'id="{own}--', source)
    source = re.sub(r"""url\(\s*['"]?#""", f"url(#{own}--", source).replace(
        'href="#', f'href="#{own}--'
    )
    return tuple(ET.fromstring(source))


def symbol_id(actor: Actor, pose: str) -> str:
    """The id of an actor's symbol in a pose; `stage_symbols` defines one for each of POSES."""
    return f"{_slug(actor.name)}--{pose}"


def _slug(name: str) -> str:
    return "".join(c if c.isascii() and (c.isalnum() or c == "-") else f"_{ord(c):x}" for c in name)


def actor_symbols(actor: Actor, poses: tuple[str, ...] = POSES) -> str:
    """`<symbol>`s of an actor, one for each pose, in the sprite's 100 x 100 units."""
    shared, symbols = [], []
    layers = _layers(actor)
    if layers and layers[0].tag == f"{{{SVG}}}defs":
        shared.append(_inner(layers[0]))
        layers = layers[1:]
    for i, layer in enumerate(layers):
        if layer.get("data-pose") is None:
            shared.append(f'<g id="{_slug(actor.name)}--part{i}">{_inner(layer)}</g>')
    known = {word for layer in layers for word in layer.get("data-pose", "").split()}
    verbs = known | {word.split("-")[0] for word in known}
    for pose in poses:
        parts = []
        shown = pose if pose.split("-")[0] in verbs else "idle"
        for i, layer in enumerate(layers):
            if layer.get("data-pose") is None:
                parts.append(f'<use href="#{_slug(actor.name)}--part{i}"/>')
            else:
                parts.append(_posed(layer, shown, pose, known))
        label = quoteattr(symbol_id(actor, pose))
        symbols.append(f'<symbol id={label} overflow="visible">{"".join(parts)}</symbol>')
    return "".join(shared) + "\n" + "\n".join(symbols) + "\n"


def _posed(layer: ET.Element, shown: str, pose: str, known: set[str]) -> str:
    """A layer's markup in a pose, or '' where it is not part of that pose."""
    names = layer.get("data-pose", "").split()
    verb, _, direction = shown.partition("-")
    if shown in names or verb in names:
        return _inner(layer, pose.partition("-")[2])
    east = f"{verb}-{direction.replace('west', 'east')}"
    if direction.endswith("west") and east in names and shown not in known:
        return f'<g transform="translate(100 0) scale(-1 1)">{_inner(layer)}</g>'
    return ""


def _inner(layer: ET.Element, direction: str = "") -> str:
    """The markup inside a layer, with what looks about turned toward the direction."""
    markup = "".join(ET.tostring(child, encoding="unicode").strip() for child in layer)
    markup = markup.replace(f' xmlns="{SVG}"', "")
    dx, dy = LOOKS.get(direction, (0, 0))

    def shift(match: re.Match[str]) -> str:
        reach = float(match.group(1))
        # Eyes are wider apart than high: a full shift down would run into the mouth.
        return f'transform="translate({dx * reach:g} {0.7 * dy * reach:g})"'

    return re.sub(r'data-look="([\d.]+)"', shift, markup)


def tile_actor(tile: Tile) -> Actor | None:
    """A tile as something to be drawn; None where it is a rug."""
    sprite = tile.sprite or tile_look(tile.name)
    name = f"tile/{tile.name}"  # no actor is called so
    return Actor(name, sprite, tile.color, "tile", tile.drawing) if sprite else None


_LINE = f'stroke="{INK}" stroke-linecap="round" stroke-linejoin="round"'
_CLOUD = "M22 66 a15 15 0 0 1 8 -27 a22 22 0 0 1 41 -3 a16 16 0 0 1 8 30 Z"
_BURST = (
    "M50 6 L59 31 L82 17 L72 41 L97 50 L72 59 L82 83 L59 69 "
    "L50 94 L41 69 L18 83 L28 59 L3 50 L28 41 L18 17 L41 31 Z"
)
MARK_DRAWINGS = {
    "puff": f'<path d="{_CLOUD}" fill="#fffdf7" {_LINE} stroke-width="4.5"/>'
    f'<path d="M38 50 q6 -8 13 -2" fill="none" {_LINE} stroke-width="3.5" opacity=".5"/>',
    "dust": '<path d="M22 66 a15 15 0 0 1 8 -27 a22 22 0 0 1 41 -3 a16 16 0 0 1 8 30 Z"'
    ' fill="#dcc7a4" stroke="#8f7651" stroke-width="4" opacity=".92"/>',
    "sweat": f'<path d="M50 8 Q78 50 78 66 A28 27 0 0 1 22 66 Q22 50 50 8 Z" fill="#7fc8f0" {_LINE}'
    ' stroke-width="6"/><path d="M36 66 Q37 77 47 80" fill="none" stroke="#fff" stroke-width="7"'
    ' stroke-linecap="round"/>',
    "bang": '<path d="M38 6 H62 L57 62 H43 Z M50 74 A9.5 9.5 0 1 1 49.9 74 Z" fill="#d9372b"'
    ' stroke="#fffdf7" stroke-width="15" stroke-linejoin="round" paint-order="stroke"/>'
    '<path d="M38 6 H62 L57 62 H43 Z M50 74 A9.5 9.5 0 1 1 49.9 74 Z" fill="#d9372b"/>',
    "bump": f'<path d="{_BURST}" fill="#ffd84d" {_LINE} stroke-width="5"/>'
    '<circle cx="50" cy="50" r="13" fill="#fffdf7"/>',
    "lines": f'<path d="M4 28 H58 M-8 50 H50 M4 72 H58" fill="none" {_LINE} stroke-width="6"'
    ' opacity=".75"/>',
}


_HANDLE = "M14 50 H86 M14 34 V66 M86 34 V66"
GRIP_DRAWING = (
    f'<path d="{_HANDLE}" fill="none" {_LINE} stroke-width="17"/>'
    f'<path d="{_HANDLE}" fill="none" stroke="#f2c14e" stroke-linecap="round" stroke-width="9"/>'
)


def mark_symbols(stage: Stage) -> str:
    """`<symbol>`s of all marks, with ids 'mark--puff' and so on, in 100 x 100 units."""
    drawings = MARK_DRAWINGS | ({"grip": GRIP_DRAWING} if stage.pulls else {})
    return "".join(
        f'<symbol id="mark--{kind}" overflow="visible">{drawing}</symbol>\n'
        for kind, drawing in drawings.items()
    )


_RINGS = "".join(f'<circle cx="{x}" cy="{y}" r="7.5"/>' for x in (-14, 14) for y in (-11, 11))
_SLICE = "a6 6 0 0 1 6 -6 h3 a6 6 0 0 1 6 6 v16 h-15 Z"
# Flat on a kitchen's counters and pale, so that nobody takes them for cast. In hundredths of a
# cell about (0, 0); the keys are drawn by lot (see `scene`).
UTENSIL_DRAWINGS = {
    9: '<rect x="-28" y="-24" width="56" height="48" rx="5" fill="#5d5650"/>'
    f'<g fill="none" stroke="#b9b2aa" stroke-width="2.2">{_RINGS}</g>',  # a hob
    4: '<rect x="-29" y="-22" width="58" height="46" rx="8" fill="#e9e6df" stroke="#8d857b" '
    'stroke-width="2.2"/><rect x="-23" y="-10" width="46" height="28" rx="7" fill="#c4cdd0"/>'
    '<path d="M0 -17 V-4" stroke="#7e8a8e" stroke-width="5" stroke-linecap="round"/>',  # a sink
    3: '<rect x="-27" y="-19" width="54" height="38" rx="6" fill="#c79a62" stroke="#8b6437" '
    f'stroke-width="2.2"/><path d="M-18 -5 {_SLICE} M2 -5 {_SLICE}" fill="#f0dcb4" '
    'stroke="#a8763d" stroke-width="2"/>',  # bread on a board
}
