"""The curves that show what an example does to its viewers: of what its pattern speaks of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from i2pdsl.errors import Source
from i2pdsl.language import ast
from i2pdsl.language.parse import parse_expression

if TYPE_CHECKING:
    from i2pdsl.render.mind import Panel

_MOST = 2  # panels
_MOST_POINTS = 160  # of a curve


@dataclass(frozen=True)
class Curves:
    """A panel of curves over the frames 0..last, between the values low and high.

    A series has label, color, dash, and values at frames evenly apart (None where there is none).
    """

    title: str
    low: float
    high: float
    last: int
    series: list[dict[str, Any]]


def decisive_curves(panels: tuple[Panel, ...], call: str) -> list[Curves]:
    """The two panels that tell most of a pattern, the most telling first.

    These are the curves that stand in its pictures for its sake alone, then the beliefs about the
    latents that the call names, then those in which most happens.
    """
    from i2pdsl.render.focus import is_of_story

    told = [p for p in panels if p.title != "rationality"]
    named: set[str] = set()
    for part in ast.walk(parse_expression(Source("call", call))):
        if isinstance(part, ast.Name):
            named.add(part.id)
        elif isinstance(part, ast.Call):
            named |= {a.name.id for a in part.arguments if a.name is not None}

    def rank(panel: Panel) -> tuple[Any, ...]:
        return (not is_of_story(panel), panel.latent not in named, -_movement(panel))

    chosen = sorted(told, key=rank)[:_MOST]
    return [_thinned(panel) for panel in chosen]


def _movement(panel: Panel) -> float:
    """How much of the panel's height its curves cover."""
    import numpy as np

    from i2pdsl.render.mind import value_axis

    low, high, _ = value_axis(panel)
    spans = [np.nanmax(s.values) - np.nanmin(s.values) for s in panel.series]
    return float(max(spans)) / (high - low) - (panel.kind != "probability")


def _thinned(panel: Panel) -> Curves:
    """A panel as plain data, with no more points than can be seen."""
    import numpy as np

    from i2pdsl.render.mind import DASHES, value_axis

    low, high, _ = value_axis(panel)
    places = np.linspace(0, panel.last, min(panel.last + 1, _MOST_POINTS)).round().astype(int)
    series = [
        {
            "label": one.label,
            "color": one.color,
            "dash": list(DASHES[rank % len(DASHES)]),
            "values": [
                round(float(v), 4) if np.isfinite(v) else None
                for v in np.asarray(one.values, float)[places]
            ],
        }
        for rank, one in enumerate(panel.series)
    ]
    return Curves(panel.title, float(low), float(high), int(panel.last), series)
