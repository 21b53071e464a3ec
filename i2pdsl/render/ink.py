"""The colour of lines, and colours mixed."""

from PIL import ImageColor

INK = "#3b2a20"


def mix(color: str, other: str, share: float) -> str:
    """`color` with a `share` (0 to 1) of `other` in it, as '#rrggbb'. Both are CSS colours."""
    a, b = ImageColor.getrgb(color), ImageColor.getrgb(other)
    r, g, b_ = (round(p + (q - p) * share) for p, q in zip(a[:3], b[:3], strict=True))
    return f"#{r:02x}{g:02x}{b_:02x}"
