"""Lettering in SVG: lines of text, captions that fit, numbered tags."""

from collections.abc import Sequence
from xml.sax.saxutils import escape

from i2pdsl.render.fonts import FAMILY
from i2pdsl.render.raster import text_width
from i2pdsl.render.sprites import INK

FONTS = f"font-family=\"'{FAMILY}', Verdana, sans-serif\""
TAG = "#ffe9b0"


def text_svg(x: float, y: float, text: str, size: float, bold: bool = False, more: str = "") -> str:
    """A line of text; `more` are further attributes."""
    weight = ' font-weight="bold"' if bold else ""
    return (
        f'<text x="{x:g}" y="{y:g}" {FONTS} font-size="{size:g}"{weight} fill="{INK}"{more}>'
        f"{escape(text)}</text>"
    )


def caption_svg(tag: str, lines: Sequence[str], y: float, size: float) -> str:
    """A frame's number in a tag, and its caption beside it."""
    wide, high = text_width(tag, size, bold=True) + 12, 1.45 * size
    number = text_svg(wide / 2, y + 8 + 1.08 * size, tag, size, True, ' text-anchor="middle"')
    return (
        f'<rect y="{y + 8:g}" width="{wide:g}" height="{high:g}" rx="4" fill="{TAG}" '
        f'stroke="{INK}" stroke-width="1.4"/>{number}'
        + "".join(
            text_svg(wide + 9, y + 8 + (1.08 + 1.25 * i) * size, line, size)
            for i, line in enumerate(lines)
        )
    )


def fitted(text: str, size: float, room: float, bold: bool = False) -> str:
    """The text, cut and ended by an ellipsis where it is wider than `room`."""
    while len(text) > 2 and text_width(text, size, bold) > room:
        text = text[:-2].rstrip(" …") + "…"
    return text


def wrapped(text: str, size: float, room: float) -> list[str]:
    """A caption broken into at most two lines that fit; what does not fit ends in an ellipsis."""
    lines, words = [""], text.split()
    for word in words:
        longer = f"{lines[-1]} {word}".strip()
        if text_width(longer, size) <= room or not lines[-1]:
            lines[-1] = longer
        else:
            lines.append(word)
    if len(lines) > 2:
        lines = [lines[0], f"{lines[1]} …"]
    return [fitted(line, size, room) for line in lines]


def heading_svg(x: float, y: float, text: str, size: float, room: float) -> str:
    """A title, smaller where it would be wider than `room`."""
    size = min(size, size * room / max(text_width(text, size, bold=True), 1e-6))
    return text_svg(x, y, text, size, True)
