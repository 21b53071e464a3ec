"""SVG text to pixels, the same on every machine: only matplotlib's bundled DejaVu Sans is used."""

import io
import os
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import resvg_py
from PIL import Image, ImageFont

from i2pdsl.resources import atomic_path

FONT_FAMILY = "DejaVu Sans"


@cache
def font_files() -> tuple[str, str]:
    """Paths of DejaVu Sans, regular and bold, found without importing matplotlib."""
    spec = find_spec("matplotlib")
    if spec is None or not spec.submodule_search_locations:
        raise FileNotFoundError("matplotlib, whose DejaVu Sans the pictures use, is not installed")
    folder = Path(spec.submodule_search_locations[0], "mpl-data", "fonts", "ttf")
    return str(folder / "DejaVuSans.ttf"), str(folder / "DejaVuSans-Bold.ttf")


@cache
def _font(bold: bool) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(font_files()[int(bold)], 100)


def text_width(text: str, size: float, bold: bool = False) -> float:
    """Width of a line of text at a font size, in the size's unit."""
    return _font(bold).getlength(text) * size / 100


def svg_png(svg: str, zoom: float = 1.0) -> bytes:
    """An SVG document as PNG bytes; `zoom` is pixels for each of its units."""
    fonts = list(font_files()) if "<text" in svg else []  # reading them takes longer than a sprite
    return resvg_py.svg_to_bytes(
        svg_string=svg,
        zoom=zoom,
        skip_system_fonts=True,
        font_files=fonts,
        font_family=FONT_FAMILY,
        sans_serif_family=FONT_FAMILY,
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
