"""Drawings that worlds name: those that come with i2pdsl, and a user's own files beside a world.

An own drawing is a picture that anyone may have drawn, also one that came within a script. Only
what it needs to be seen is kept of it, by a list of what is allowed: no scripts, no styles, no
fonts, no reference to anything outside, of bounded size. JAX-free, and Pillow only where a PNG is.
"""

from __future__ import annotations

import base64
import binascii
import errno
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

from i2pdsl.untrusted import WrongData, is_plain_name, read_bytes

Files = Callable[[str], "bytes | None"]
"""The content of the file of a plain name, None where nothing is said of it. Raises OSError."""

OWN = (".svg", ".png")  # the suffixes of own drawings
LARGEST = {".svg": 200_000, ".png": 2_000_000}  # bytes
MOST_PARTS, DEEPEST = 3000, 40  # elements of an SVG, and elements in elements
WIDEST, KEPT = 2048, 256  # pixels of a PNG's side that are read, and that are kept
# Rasterisers fail at coordinates near 1e10 pixels: so far from its picture may a shape reach, in
# the picture's sides, all its numbers taken together, and so much may transforms magnify it.
FARTHEST, MOST_GROWTH = 2e4, 20.0
SVG, XLINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"
ET.register_namespace("", SVG)

_FOLDER = Path(__file__).parent / "sprites"
_SHAPES = {"g", "path", "rect", "circle", "ellipse", "line", "polyline", "polygon"}
_SHARED = {"linearGradient", "radialGradient", "clipPath"}  # what others refer to by an id
_UNSEEN = {"title", "desc", "metadata"}  # left out without a word
_GEOMETRY = {
    *("d", "x", "y", "x1", "y1", "x2", "y2", "width", "height", "rx", "ry", "r", "cx", "cy"),
    *("fx", "fy", "points", "transform", "offset", "gradientUnits", "gradientTransform"),
    *("spreadMethod", "clipPathUnits"),
}
# No dashes: a long line of short ones is slow to draw.
_LOOKS = {
    *("fill", "fill-opacity", "fill-rule", "stroke", "stroke-width", "stroke-opacity"),
    *("stroke-linecap", "stroke-linejoin", "stroke-miterlimit", "opacity", "stop-color"),
    *("stop-opacity", "clip-path", "clip-rule", "color", "display", "visibility", "paint-order"),
}
_OURS = {"data-part", "data-pose", "data-look"}  # what sprites are posed by (docs/worlds.md)
_REFERENCE = re.compile(r"url\(\s*['\"]?#([\w.-]+)['\"]?\s*\)", re.ASCII)
_TINT = re.compile(r"#[0-9a-fA-F]{6}")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", re.ASCII)
_TRANSFORM = re.compile(r"\s*,?\s*(matrix|translate|scale|rotate)\s*\(([^()]*)\)", re.ASCII)
_LENGTHS = _GEOMETRY - {"transform", "gradientTransform"} | {"stroke-width", "stroke-miterlimit"}


# Those that come with i2pdsl.


@cache
def builtin_sprites() -> tuple[str, ...]:
    """Names of the drawings that there are."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.svg")))


@cache
def builtin_sprite(name: str) -> str:
    """The SVG of a name in `builtin_sprites`."""
    return (_FOLDER / f"{name}.svg").read_text(encoding="utf-8")


# What tiles are drawn as whose names, or parts of them, say it.
_TILE_LOOKS = {
    word: sprite
    for sprite, words in {
        "pond": "pond lake water pool well",
        "nest": "nest hay straw",
        "door": "door gate exit house home",
        "hole": "hole burrow den cave pit",
        "crumbs": "crumbs crumb seed seeds food grain",
        "dock": "dock quay pier jetty bridge",
    }.items()
    for word in words.split()
}


def tile_look(name: str) -> str:
    """The sprite that a tile's name, or a part of it, calls for; empty where there is none."""
    words = (word for word in name.lower().split("_") if word in _TILE_LOOKS)
    return next((_TILE_LOOKS[word] for word in words), "")


def sprite_color(name: str) -> str:
    """A built-in sprite's own colour, or the empty text of one that is not built in."""
    if name not in builtin_sprites():
        return ""
    return str(ET.fromstring(builtin_sprite(name)).get("data-tint", ""))


# Where own ones come from.


def is_own(sprite: str) -> bool:
    """Whether a sprite is a file's name."""
    return sprite.lower().endswith(OWN)


def beside(folder: Path) -> Files:
    """The files of a folder: by plain names only, and through no link that leads out of it."""

    def read(name: str) -> bytes:
        path = folder / name
        if not is_plain_name(name):
            raise OSError(errno.EINVAL, "this is no name for a file", name)
        if not path.resolve().is_relative_to(folder.resolve()):
            raise OSError(errno.EPERM, "a link leads out of the world's folder", name)
        return read_bytes(path, LARGEST[name[-4:].lower()])

    return read


def within(drawings: Mapping[str, str]) -> Files:
    """The files that a script holds: the text of an SVG, base64 of a PNG."""

    def read(name: str) -> bytes | None:
        text = drawings.get(name)
        if text is None:
            return None
        try:
            data = base64.b64decode(text, validate=True) if _is_png(name) else text.encode()
        except (binascii.Error, ValueError):
            raise OSError(errno.EINVAL, "this is no base64", name) from None
        if len(data) > LARGEST[name[-4:].lower()]:
            raise OSError(errno.EFBIG, f"it has {len(data):,} bytes", name)
        return data

    return read


def kept_drawing(name: str, data: bytes) -> str:
    """What is kept of an own drawing, as text: an SVG, or base64 of a PNG. Raises WrongData."""
    if _is_png(name):
        return base64.b64encode(_kept_png(data)).decode()
    return _kept_svg(data)


def _is_png(name: str) -> bool:
    return name.lower().endswith(".png")


def as_svg(name: str, kept: str) -> str:
    """A kept drawing as an SVG document."""
    if not _is_png(name):
        return kept
    # Width and height stand at a fixed place: signature, length, IHDR, then both (RFC 2083, 4.1.1).
    head = base64.b64decode(kept[:32])
    width, height = (int.from_bytes(head[at : at + 4], "big") for at in (16, 20))
    return (
        f'<svg xmlns="{SVG}" viewBox="0 0 {width} {height}"><image width="{width}" '
        f'height="{height}" href="data:image/png;base64,{kept}"/></svg>'
    )


# What is kept.


def _kept_png(data: bytes) -> bytes:
    """The pixels alone, RGBA, at most KEPT on a side."""
    import io

    from PIL import Image

    try:
        with Image.open(io.BytesIO(data), formats=("PNG",)) as image:
            if max(image.size) > WIDEST:
                size = " x ".join(map(str, image.size))
                raise WrongData(f"it has {size} pixels; at most {WIDEST} x {WIDEST} are read")
            pixels = image.convert("RGBA")
    except (OSError, ValueError, SyntaxError, EOFError):
        raise WrongData("this is no PNG, or it is damaged") from None
    pixels.thumbnail((KEPT, KEPT))
    made = io.BytesIO()
    pixels.save(made, "PNG", optimize=True)
    return made.getvalue()


def _kept_svg(data: bytes) -> str:
    """The shapes of an SVG, their looks, and the gradients and clips that they use."""
    try:
        text = data.decode("utf-8-sig")
        if "<!ENTITY" in text.upper():  # they could make a small file endless
            raise WrongData("it declares entities: save it as plain SVG")
        root = ET.fromstring(text)
    except (ET.ParseError, ValueError) as problem:
        raise WrongData(f"this is no SVG: {problem}") from None
    if root.tag not in (f"{{{SVG}}}svg", "svg"):
        raise WrongData("this is no SVG: its root is not `svg`")
    if sum(1 for _ in root.iter()) > MOST_PARTS:
        raise WrongData(f"it has more than {MOST_PARTS:,} elements")
    shared = ET.Element(f"{{{SVG}}}defs")
    made = ET.Element(f"{{{SVG}}}svg", {"viewBox": _view_box(root)})
    for key, valid in (("data-tint", _TINT), ("data-faces", re.compile("east|west"))):
        value = root.get(key)
        if value is not None:
            if not valid.fullmatch(value):
                raise WrongData(f"`{key}` cannot be `{value[:40]}`")
            made.set(key, value)
    for key, value in _attributes(root, "svg").items():
        if key in _LOOKS:
            made.set(key, value)
    numbers = [float(number) for number in made.attrib["viewBox"].split()]
    side = max(numbers[2:])
    if max(map(abs, numbers[:2])) > FARTHEST * side:
        raise WrongData("its `viewBox` is too far from where it begins")
    for child in root:
        _keep(child, made, shared, 1)
    _check_reach(made, side, 1.0)
    _check_reach(shared, side, 1.0)
    if len(shared):
        made.insert(0, shared)
    known = {element.get("id") for element in shared}
    for element in made.iter():
        for value in element.attrib.values():
            missing = set(_REFERENCE.findall(value)) - known
            if missing:
                raise WrongData(f"it refers to `#{min(missing)}`, which is no gradient or clip")
    if not any(element.tag.rpartition("}")[2] in _SHAPES - {"g"} for element in made.iter()):
        raise WrongData("it has no shapes")
    return ET.tostring(made, encoding="unicode")


def _keep(element: ET.Element, into: ET.Element, shared: ET.Element, depth: int) -> None:
    """Copies what is kept of an element; what is shared moves to the front of the document."""
    if not isinstance(element.tag, str):  # a comment
        return
    space, _, name = element.tag.rpartition("}")
    if space.strip("{") not in ("", SVG) or name in _UNSEEN:
        return  # what drawing programs note down for themselves
    if depth > DEEPEST:
        raise WrongData(f"it is nested deeper than {DEEPEST}")
    if name == "defs":
        for child in element:
            if isinstance(child.tag, str) and child.tag.rpartition("}")[2] in _SHARED:
                _keep(child, into, shared, depth + 1)
        return
    inside = into.tag.rpartition("}")[2]
    if name not in _SHAPES | _SHARED and not (name == "stop" and inside in _SHARED):
        hint = _INSTEAD.get(name, "save it as plain SVG, of paths and shapes")
        raise WrongData(f"`{name[:40]}` is not read: {hint}")
    place = shared if name in _SHARED else into
    made = ET.SubElement(place, f"{{{SVG}}}{name}", _attributes(element, name))
    for child in element:
        _keep(child, made, shared, depth + 1)


def _check_reach(element: ET.Element, side: float, growth: float) -> None:
    """Raises WrongData where numbers lead too far out of a picture of that side."""
    for key, value in element.attrib.items():
        if key in _LENGTHS:
            numbers = [float(number) for number in _NUMBER.findall(value)]
            if not sum(map(abs, numbers)) <= FARTHEST * max(side, 1.0):
                raise WrongData(f"`{key}` leads too far out of the picture")
        elif key in ("transform", "gradientTransform"):
            growth *= _growth(value, side)
    if growth > MOST_GROWTH:
        raise WrongData(f"its transforms magnify more than {MOST_GROWTH:g} times")
    for child in element:
        _check_reach(child, side, growth)


def _growth(transform: str, side: float) -> float:
    """How much a transform magnifies, at least 1. Raises WrongData for what is none."""
    growth, at = 1.0, 0
    while transform[at:].strip():
        found = _TRANSFORM.match(transform, at)
        if found is None:
            raise WrongData(f"the transform `{transform[:40]}` is not read")
        at = found.end()
        numbers = [abs(float(number)) for number in _NUMBER.findall(found[2])]
        scales = {"matrix": numbers[:4], "scale": numbers}.get(found[1], [])
        moves = numbers[4:] if found[1] == "matrix" else numbers
        growth *= max([1.0, *scales])
        if not sum(moves) <= FARTHEST * max(side, 1.0):
            raise WrongData("a transform leads too far out of the picture")
    return growth


_INSTEAD = {
    "script": "drawings have no scripts",
    "style": "save it with presentation attributes, as `fill` is one",
    "image": "give the picture itself, as .png",
    "text": "turn it into paths",
    "use": "unlink the clones",
    "foreignObject": "nothing else can stand in a drawing",
    "filter": "flatten the effect, or give a .png",
    "mask": "use a clip, or give a .png",
    "pattern": "use a gradient, or give a .png",
}


def _attributes(element: ET.Element, name: str) -> dict[str, str]:
    """The attributes that are kept, with those that stood in a `style`."""
    found = dict(element.attrib)
    for part in found.pop("style", "").split(";"):
        key, colon, value = part.partition(":")
        if colon:
            found[key.strip()] = value.strip()
    kept: dict[str, str] = {}
    for key, value in found.items():
        if key.lower().startswith("on"):
            raise WrongData(f"`{key[:40]}` is not read: drawings have no scripts")
        if key in ("href", f"{{{XLINK}}}href"):
            if not re.fullmatch(r"#[\w.-]+", value, re.ASCII):
                raise WrongData("it refers to something outside: only itself can be shown")
            if name in _SHARED:
                kept["href"] = value
            continue
        if "url(" in value.lower() and not _REFERENCE.fullmatch(value.strip()):
            raise WrongData("it refers to something outside: only itself can be shown")
        if key == "id" and name in _SHARED:
            if not re.fullmatch(r"[\w.-]+", value, re.ASCII):
                raise WrongData(f"`{value[:40]}` is no id")
            kept[key] = value
        elif key == "data-look":
            if not re.fullmatch(r"\d{1,2}(\.\d{1,4})?", value, re.ASCII):
                raise WrongData("`data-look` is a number of units below 100")
            kept[key] = value
        elif key in _GEOMETRY | _LOOKS | _OURS:
            kept[key] = value
    return kept


def _view_box(root: ET.Element) -> str:
    """The `viewBox`, or what `width` and `height` make of it: four plain numbers."""
    words = re.split(r"[\s,]+", root.get("viewBox", "").strip())
    if words == [""]:
        sides = (re.sub(r"(px|pt|mm)$", "", root.get(side, "")) for side in ("width", "height"))
        words = ["0", "0", *sides]
    try:
        numbers = [float(word) for word in words]
        _, _, width, height = numbers
    except ValueError:
        raise WrongData("it has no size: give `viewBox`") from None
    if not all(map(math.isfinite, numbers)) or not (1e-3 < width < 1e6 and 1e-3 < height < 1e6):
        raise WrongData("its `viewBox` has no usual size")
    return " ".join(f"{number:g}" for number in numbers)
