"""SVG text to pixels, the same on every machine as long as DejaVu Sans has all characters."""

import io
import os
import re
from functools import cache
from pathlib import Path
from xml.sax.saxutils import unescape

import numpy as np
import resvg_py
from PIL import Image, ImageFont

from i2pdsl.render.fonts import FAMILY, font_files, further_fonts, lacked
from i2pdsl.resources import atomic_path

_TEXT = re.compile(r"<text[^>]*>([^<]*)")
_WIDE = 1.0  # of a character that no font of ours has, in the font's size: a box, or a Han sign


@cache
def _font(bold: bool) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(font_files()[int(bold)], 100)


def text_width(text: str, size: float, bold: bool = False) -> float:
    """Width of a line of text at a font size, in the size's unit."""
    lacking = lacked(text)
    known = "".join(c for c in text if c not in lacking) if lacking else text
    return _font(bold).getlength(known) * size / 100 + _WIDE * size * (len(text) - len(known))


def svg_png(svg: str, zoom: float = 1.0) -> bytes:
    """An SVG document as PNG bytes; `zoom` is pixels for each of its units."""
    fonts: list[str] = []  # reading them takes longer than a sprite
    if "<text" in svg:
        words = unescape("".join(_TEXT.findall(svg)))
        fonts = [*font_files(), *further_fonts(words)]
    return resvg_py.svg_to_bytes(
        svg_string=svg,
        zoom=zoom,
        skip_system_fonts=True,
        font_files=fonts,
        font_family=FAMILY,
        sans_serif_family=FAMILY,
    )


def svg_rgba(svg: str, zoom: float = 1.0) -> np.ndarray:
    """An SVG document as an array [height, width, 4] of uint8, not premultiplied."""
    with Image.open(io.BytesIO(svg_png(svg, zoom))) as image:
        return np.asarray(image.convert("RGBA"))


def composite(below: np.ndarray, above: np.ndarray) -> np.ndarray:
    """RGBA `above` laid over RGB `below`, both uint8 of one size: RGB uint8."""
    alpha = above[..., 3:].astype(np.uint16)
    mixed = above[..., :3] * alpha + below * (255 - alpha) + 127
    return (mixed // 255).astype(np.uint8)


def save_svg(path: str | os.PathLike[str], svg: str) -> None:
    """Writes an SVG document, atomically."""
    with atomic_path(Path(path)) as temporary:
        temporary.write_text(svg, encoding="utf-8")


def save_png(path: str | os.PathLike[str], svg: str, zoom: float = 1.0) -> None:
    """Writes an SVG document as PNG, atomically; `zoom` is pixels for each of its units."""
    png = svg_png(svg, zoom)
    with atomic_path(Path(path)) as temporary:
        temporary.write_bytes(png)
