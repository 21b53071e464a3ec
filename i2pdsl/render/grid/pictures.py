"""All pictures of a finished script in a grid world: which there are, what they show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from i2pdsl.render.files import KEY_FRAMES, UNSURE, PictureFiles, percent, printable
from i2pdsl.render.grid.stage import Actor, Stage, Tile
from i2pdsl.render.mind import PALETTE, Mark, Panel, Series
from i2pdsl.scripts import Script
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.hypotheses import ATTITUDE, goal_of, rationality_of

# For values and characters that the palette does not name; dashes and labels tell them apart too.
_CAST_COLORS = ("#d98b4a", "#7fae6b", "#b48ad1", "#d9718e", "#c9b04f", "#5fb3b0")
_MORE_COLORS = ("#0068b0", "#c65102", "#00664a", "#8a3ffc", "#8c7a3a", "#d9468f")

CURVES_MAX = 24  # in a panel
OTHERS = " others"


def stage_of(spec: GridSpec) -> Stage:
    """A world as the drawing sees it."""
    tiles = tuple(Tile(t.name, cell, t.color) for t in spec.tiles for cell in t.cells)
    cast = [Actor(c.name, c.sprite, c.color, "character") for c in spec.characters]
    cast += [Actor(t.name, t.sprite, t.color, "object") for t in spec.things]
    return Stage(spec.name, spec.rows, tiles, _told_apart(cast), spec.floor, spec.wall)


def _told_apart(cast: Sequence[Actor]) -> tuple[Actor, ...]:
    """The cast in colours that tell those of one drawing apart, where the world leaves it open."""
    found: list[Actor] = []
    for actor in cast:
        taken = {(other.sprite, other.color) for other in found}
        free = [c for c in (actor.color, *_CAST_COLORS) if (actor.sprite, c) not in taken]
        found.append(replace(actor, color=free[0] if free else actor.color))
    return tuple(found)


class GridPictures(PictureFiles):
    """Draws one script of a grid world; what several pictures share is computed once."""

    def __init__(self, script: Script, title: str | None = None):
        self.told = script.length  # later frames are those that the story appends
        self.script = script = script.shown()
        self.stage = stage_of(script.world.spec)
        self.document: dict[str, Any] = script.record.as_json()
        name = title or (script.record.title or script.world.name)
        self.title = printable(name)

    @cached_property
    def film(self) -> Any:
        """The choreography."""
        from i2pdsl.render.grid.choreography import choreograph

        return choreograph(self.stage, self.document)

    @cached_property
    def panels(self) -> tuple[Panel, ...]:
        """The audience's mind over time: goals, alignment, rationality, values."""
        spec, ask = self.script.world.spec, self.script.query
        found = []
        for c in spec.characters:
            if len(c.goals) > 1:
                goal = goal_of(c.name)
                beliefs = ask(f"P({goal} | script[:t])")
                series = _series(_most(c.goals, beliefs.T))
                found.append(Panel(f"{c.name}'s goal", "probability", series))
        if spec.social:
            kinds = {"hindering": "< 0", "indifferent": "= 0", "helping": "> 0"}
            possible = {
                "hindering": min(spec.social.attitude) < 0,
                "indifferent": 0 in spec.social.attitude,
                "helping": max(spec.social.attitude) > 0,
            }
            curves = [
                (name, ask(f"P({ATTITUDE} {test} | script[:t])"))
                for name, test in kinds.items()
                if possible[name]
            ]
            found.append(Panel(f"{spec.social.name}'s alignment", "probability", _series(curves)))
        names = [c.name for c in spec.characters]
        rational = [
            (n, ask(f"P({rationality_of(n)} | script[:t])", assume="nothing")) for n in names
        ]
        found.append(Panel("rationality", "probability", _series(rational)))
        hypotheses = self.script.world.vocabulary.hypotheses
        assumed = [
            row for row, holds in zip(hypotheses, self.script.assumption, strict=True) if holds
        ]
        # Who is irrational by the story's assumption has no value.
        minded = [n for n in names if any(row[rationality_of(n)] for row in assumed)]
        values = [(n, ask(f"E[V({n}) | script[:t]]")) for n in minded]
        if values:
            found.append(Panel("expected value", "value", _series(values), "value"))
        return tuple(found)

    @property
    def marks(self) -> tuple[Mark, ...]:
        """The frames in which an event happened."""
        found = []
        for t, frame in enumerate(self.document["frames"], 1):
            event = frame.get("event")
            if event:
                thing = next(v for k, v in event.items() if k != "to")
                found.append(Mark(t, f"the {thing} falls"))
        return tuple(found)

    def captions(self, frames: list[int]) -> list[str]:
        """For each frame what viewers believe most, of the alignment or else of the goals."""
        panels = [p for p in self.panels if "alignment" in p.title] or [
            p for p in self.panels if p.kind == "probability" and p.title != "rationality"
        ]
        lines = []
        for t in frames:
            line = ", ".join(_belief(panel, t) for panel in panels[:2])
            lines.append(f"and then: {line}" if t > self.told else line)
        return lines

    def beliefs(self) -> np.ndarray:
        """All probability curves side by side: [T + 1, n]."""
        curves = [s.values for p in self.panels if p.kind == "probability" for s in p.series]
        return np.stack(curves, axis=1)

    def meters(self) -> list[tuple[str, str, Any]]:
        """The curves below the film: the alignment's if there is one, else the first goal's.

        Of a goal it is said whose it is, where there are several.
        """
        chosen = [p for p in self.panels if "alignment" in p.title] or list(self.panels[:1])
        goals = [p for p in self.panels if p.title.endswith("'s goal")]
        is_plain = "alignment" in chosen[0].title or goals == chosen[:1]
        whose = "" if is_plain else f"{chosen[0].title}: "
        return [(whose + s.label, s.color, s.values) for s in chosen[0].series]

    # Files.

    def comic(self) -> str:
        from i2pdsl.render.grid.comic import comic_svg, key_frames

        frames = key_frames(self.document, self.beliefs(), KEY_FRAMES)
        return comic_svg(self.stage, self.document, frames, self.captions(frames), self.title)

    def save_mind(self, path: Path, title: str) -> Path | None:
        from i2pdsl.render.mind import save_mind

        return save_mind(path, self.panels, title, marks=self.marks)

    def save_page(self, path: Path) -> Path:
        from i2pdsl.render.grid.page import save_page

        return save_page(
            path,
            self.stage,
            self.document,
            self.film,
            self.panels,
            self.title,
            self.script.record.text,
            marks=self.marks,
            wishes=self.wishes,
        )

    def save_film(self, path: Path, progress: Callable[[int, int], None] | None) -> None:
        from i2pdsl.render.grid.film import save_gif, save_mp4

        save = save_gif if path.suffix == ".gif" else save_mp4
        meters = self.meters()
        save(path, self.stage, self.film, title=self.title, meters=meters, progress=progress)


def _most(names: Sequence[str], values: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Curves by name; of very many those that are believed most, and the others taken together.

    Args:
        values: [names, T + 1].
    """
    curves = list(zip(names, values, strict=True))
    if len(curves) <= CURVES_MAX:
        return curves
    order = np.argsort(-values.max(axis=1), kind="stable")
    kept, rest = sorted(order[: CURVES_MAX - 1]), order[CURVES_MAX - 1 :]
    others = f"{len(rest)}{OTHERS}"
    return [*(curves[i] for i in kept), (others, values[rest].sum(axis=0))]


def _series(curves: Any) -> tuple[Series, ...]:
    found = []
    for number, (label, values) in enumerate(curves):
        color = PALETTE.get(label, _MORE_COLORS[number % len(_MORE_COLORS)])
        found.append(Series(str(label), np.asarray(values), color))
    return tuple(found)


def _belief(panel: Panel, t: int) -> str:
    """What viewers believe of one thing after frame t, or that they cannot tell."""
    named = [s for s in panel.series if not s.label.endswith(OTHERS)]
    first, *others = sorted(named, key=lambda s: -s.values[t])
    who, _, what = panel.title.partition("'s ")
    if others and first.values[t] - others[0].values[t] < UNSURE:
        return f"{who}: hard to tell"
    verb = "wants" if what == "goal" else "is"
    return f"{who} {verb} {first.label} ({percent(first.values[t])})"
