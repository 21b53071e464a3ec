"""A script of the plane as a performance: what the pictures show of what viewers believe."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from i2pdsl.errors import Source
from i2pdsl.language.scope import Module
from i2pdsl.render.files import UNSURE, percent, printable
from i2pdsl.render.mind import PALETTE, Panel, Series, Window
from i2pdsl.render.plane.performance import Performance
from i2pdsl.scripts import Script
from i2pdsl.worlds.hypotheses import ATTITUDE, goal_of, rationality_of
from i2pdsl.worlds.plane.spec import APPROACH, AVOID, NO_GOAL, PlaneSpec

# For values that the palette does not name; dashes and labels tell them apart too.
_COLORS = ("#0068b0", "#c65102", "#00664a", "#8a3ffc", "#8c7a3a", "#d9468f")
_ATTITUDES = {"hindering": "< 0", "indifferent": "= 0", "helping": "> 0"}


def performance_of(script: Script, title: str | None = None) -> Performance:
    """What a script of the plane looks like, with the curves that belong to it."""
    # The story's own names must not get into the questions that are asked here.
    script = replace(script.shown(), module=Module(Source("pictures", "")))
    world: Any = script.world
    spec: PlaneSpec = world.spec
    count = len(spec.characters)
    states = np.asarray(script.trajectory.states, float)
    goals, attitudes = _goals(script, spec), _attitudes(script, spec)
    told = attitudes or goals
    return Performance(
        title=printable(title or script.record.title or world.name),
        spec=spec,
        positions=states[:, : 2 * count].reshape(-1, count, 2),
        panels=(*goals, *attitudes, *_minds(script, spec)),
        windows=tuple(Window(*window) for window in script.windows),
        captions=[", ".join(_belief(p, spec, t) for p in told[:2]) for t in range(len(states))],
        leading=_leading(goals, attitudes),
        source=script.record.text,
    )


def _goals(script: Script, spec: PlaneSpec) -> list[Panel]:
    """For each character the probability of each of its goals."""
    found = []
    for c in spec.characters:
        if len(c.goals) > 1:
            curves = script.query(f"P({goal_of(c.name)} | script[:t])").T
            found.append(_panel(f"{c.name}'s goal", zip(c.goals, curves, strict=True)))
    return found


def _attitudes(script: Script, spec: PlaneSpec) -> list[Panel]:
    """The probabilities that whoever has an attitude helps, hinders or does not care."""
    if not spec.social:
        return []
    values = script.world.vocabulary.latents[ATTITUDE].values
    numbers = [float(v) for v in values]
    is_possible = {
        "hindering": min(numbers) < 0,
        "indifferent": 0 in numbers,
        "helping": max(numbers) > 0,
    }
    curves = [
        (name, script.query(f"P({ATTITUDE} {test} | script[:t])"))
        for name, test in _ATTITUDES.items()
        if is_possible[name]
    ]
    return [_panel(f"{spec.social.name}'s alignment", curves)]


def _minds(script: Script, spec: PlaneSpec) -> list[Panel]:
    """Who is rational, and what everybody who may be expects."""
    words = script.world.vocabulary
    names = [c.name for c in spec.characters]
    doubted = [n for n in names if rationality_of(n) in words.latents]
    rational = [
        (n, script.query(f"P({rationality_of(n)} | script[:t])", assume="nothing")) for n in doubted
    ]
    assumed = [row for row, holds in zip(words.hypotheses, script.assumption, strict=True) if holds]
    # Who is irrational by the story's assumption has no value.
    minded = [n for n in names if any(row.get(rationality_of(n), True) for row in assumed)]
    values = [(n, script.query(f"E[V({n}) | script[:t]]")) for n in minded]
    found = [_panel("rationality", rational)] if rational else []
    if values:
        found.append(replace(_panel("expected value", values), ylabel="value", kind="value"))
    return found


def _panel(title: str, curves: Iterable[tuple[str, np.ndarray]]) -> Panel:
    series = tuple(
        Series(name, np.asarray(values), PALETTE.get(name, _COLORS[number % len(_COLORS)]))
        for number, (name, values) in enumerate(curves)
    )
    return Panel(title, "probability", series)


def _leading(goals: Sequence[Panel], attitudes: Sequence[Panel]) -> Panel | None:
    """What is shown below a film: the alignment, or else the first goal, named where there are
    several."""
    if attitudes or len(goals) < 2:
        return next(iter((*attitudes, *goals)), None)
    first = goals[0]
    series = tuple(replace(s, label=f"{first.title}: {s.label}") for s in first.series)
    return replace(first, series=series)


def _belief(panel: Panel, spec: PlaneSpec, t: int) -> str:
    """What viewers believe of one thing after frame t, or that they cannot tell."""
    first, *others = sorted(panel.series, key=lambda s: -s.values[t])
    who, _, what = panel.title.rpartition("'s ")
    if others and first.values[t] - others[0].values[t] < UNSURE:
        return f"{who}: hard to tell"
    other = next((c.name for c in spec.characters if c.name != who), "")
    if what != "goal":
        told = f"is {first.label}"
    elif first.label in (APPROACH, AVOID):
        told = f"{'approaches' if first.label == APPROACH else 'avoids'} {other}"
    else:
        told = f"wants {'nothing' if first.label == NO_GOAL else first.label}"
    return f"{who} {told} ({percent(first.values[t])})"
