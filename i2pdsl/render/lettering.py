"""Lettering in SVG: lines of text, captions that fit, numbered tags."""

import re
from bisect import bisect_left
from collections.abc import Callable, Sequence
from xml.sax.saxutils import escape

from i2pdsl.render.fonts import FAMILY
from i2pdsl.render.ink import INK
from i2pdsl.render.raster import text_width

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


_UNIT = re.compile(
    r"(?<=[<>=≤≥≈])[ ]|[ ](?=[<>=≤≥≈][ ])|(?<=[\d.])[ ](?=(?:%|s|kg|units?)(?!\w))"
    r"|(?<=\bframe)[ ](?=\d)|(?<=\bframes)[ ](?=\d)|(?<=\bturn)[ ](?=\d)|(?<=\bseed)[ ](?=\d)"
)


def units(text: str, fits: Callable[[str], bool]) -> list[str]:
    """The pieces between which a line may end: `> 99 %`, `t = 3` and `frame 12` are one each,
    unless such a piece is too long for a line by itself."""
    found = []
    for word in _UNIT.sub("\0", " ".join(text.split())).split(" "):
        whole = word.replace("\0", " ")
        found += [whole] if fits(whole) else word.split("\0")
    return found


def wrapped(text: str, size: float, room: float, most: int = 2) -> list[str]:
    """A caption broken into at most so many lines that fit; the rest becomes an ellipsis.

    The pieces of a name that is too long for a line do not count.
    """
    lines = [""]
    for word in units(text, lambda word: text_width(word, size) <= room):
        longer = f"{lines[-1]} {word}".strip()
        if text_width(longer, size) <= room:
            lines[-1] = longer
        else:
            pieces = _cut(word, size, room)
            most += len(pieces) if len(pieces) > 1 else 0
            lines = [*lines, *pieces] if lines[-1] else pieces
    if len(lines) > most:
        lines = [*lines[: most - 1], f"{lines[most - 1]} …"]
    return [fitted(line, size, room) for line in lines]


def _cut(word: str, size: float, room: float) -> list[str]:
    """A word in pieces that fit; a long name is cut behind an underscore where there is one."""
    pieces = []
    while text_width(word, size) > room and len(word) > 1:
        fits = range(1, len(word))
        end = max(1, bisect_left(fits, True, key=lambda n: text_width(word[:n], size) > room))
        end = word.rfind("_", end // 2, end) + 1 or end
        pieces.append(word[:end])
        word = word[end:]
    return [*pieces, word]


def heading_svg(x: float, y: float, text: str, size: float, room: float) -> str:
    """A title, smaller where it would be wider than `room`."""
    size = min(size, size * room / max(text_width(text, size, bold=True), 1e-6))
    return text_svg(x, y, text, size, True)
