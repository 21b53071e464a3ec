"""A script of the hill as a performance: what the pictures show of what viewers believe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from i2pdsl.errors import Source
from i2pdsl.language.scope import Module
from i2pdsl.language.vocabulary import Value, show_value
from i2pdsl.objective.subjects import Claims
from i2pdsl.render.files import printable
from i2pdsl.render.focus import focus_of, in_words, led
from i2pdsl.render.hill.performance import Performance
from i2pdsl.render.key_frames import EDGE, TURN
from i2pdsl.render.mind import PALETTE, Panel, Series, Window
from i2pdsl.scripts import Script
from i2pdsl.worlds.hill.hopper import NODE_COUNT
from i2pdsl.worlds.hill.spec import EAGER
from i2pdsl.worlds.hill.springs import FRAME_SECONDS
from i2pdsl.worlds.hill.vocabulary import HOPPER, WEIGHT, WILL

# From the heaviest to the lightest; dashes and labels tell them apart too.
_COLORS = ("#c65102", "#0068b0", "#00664a", "#8a3ffc", "#8c7a3a", "#d9468f")


def performance_of(script: Script, title: str | None = None) -> Performance:
    """What a script of the hill looks like, with the curves that belong to it."""
    # The story's own names must not get into the questions that are asked here.
    script = replace(script, module=Module(Source("pictures", "")))
    world: Any = script.world  # a HillWorld
    states = script.trajectory.states
    positions = states[:, : 2 * NODE_COUNT].reshape(-1, 2, NODE_COUNT)
    usual = (*_beliefs(script), *_curves(script))
    focus = focus_of(script, usual, sentence)
    moments = {t: TURN * weight for t, weight in focus.turns.items()}
    return Performance(
        title=printable(title or script.record.title or world.name),
        slope=world.spec.settings.slope,
        positions=positions,
        actuation=world.actuation(states[:-1], script.trajectory.actions),
        weight=world.spec.settings.weight,
        panels=led(focus.leading, usual),
        leading=focus.leading,
        moments=moments | dict.fromkeys(_falls(script), EDGE),
        windows=tuple(Window(*window) for window in script.windows),
        captions=[focus.caption(t) for t in range(len(states))],
        source=script.record.text,
        frame_seconds=FRAME_SECONDS,
    )


def _beliefs(script: Script) -> list[Panel]:
    """What viewers think of the box, and of the hopper where they wonder about it."""
    found = [_weights(script)]
    latents = script.world.vocabulary.latents
    if WILL in latents:
        curves = script.query(f"P({WILL} | script[:t])", assume="nothing").T
        series = tuple(
            Series(str(value), np.asarray(curve), color, claim=_one(WILL, [value]))
            for value, curve, color in zip(latents[WILL].values, curves, _COLORS, strict=False)
        )
        question = "whether the hopper does its best"
        found.append(Panel("hopper's will", "probability", series, "probability", WILL, question))
    return found


def _weights(script: Script) -> Panel:
    """The probability of each weight, from the heaviest."""
    weights = script.world.vocabulary.latents[WEIGHT].values
    curves = script.query(f"P({WEIGHT} | script[:t])", assume="nothing").T
    names = [f"weight {show_value(w)}" for w in weights]
    if len(weights) == 2:
        names = [f"light ({show_value(weights[0])})", f"heavy ({show_value(weights[1])})"]
    pairs = list(zip(names, curves, strict=True))[::-1]
    series = tuple(
        Series(
            name,
            np.asarray(curve),
            _COLORS[i % len(_COLORS)],
            claim=f"the box {'is' if len(weights) == 2 else 'has'} {name.partition(' (')[0]}",
        )
        for i, (name, curve) in enumerate(pairs)
    )
    question = "how heavy the box is"
    return Panel("weight of the box", "probability", series, "probability", WEIGHT, question)


def sentence(event: Claims, condition: Claims) -> tuple[str, str]:
    """An event's name, and what those think who believe it."""
    words = in_words(_one, event, condition)
    return words, words


def _one(latent: str, values: Sequence[Value]) -> str:
    """That something has one of some values: the box its weight, the hopper its will."""
    if latent == WILL and len(values) == 1:
        return "the hopper tries" if values[0] == EAGER else "the hopper is lazy"
    named = " or ".join(map(show_value, values))
    return f"the box has weight {named}" if latent == WEIGHT else f"{latent} is {named}"


def _falls(script: Script) -> list[int]:
    """The frames in which the hopper comes to lie."""
    lies = _with_start(script, f"fallen({HOPPER})") > 0.5
    return [int(t) + 1 for t in np.flatnonzero(lies[1:] & ~lies[:-1])]


def _curves(script: Script) -> list[Panel]:
    """Value, effort and distance over t = 0..T; the quantities of frames are 0 at the start."""
    found = [
        ("expected value", "value", "value", script.query(f"E[V({HOPPER}) | script[:t]]")),
        (
            "muscle effort",
            "mean square",
            "effort",
            _smooth(_with_start(script, f"effort({HOPPER})")),
        ),
        ("distance of the box", "units", "box", np.cumsum(_with_start(script, "progress(box)"))),
    ]
    return [
        Panel(title, unit, (Series(name, values, PALETTE.get(name, "#4a4a68")),), "value")
        for title, unit, name, values in found
    ]


def _with_start(script: Script, quantity: str) -> np.ndarray:
    return np.concatenate([[0.0], script.query(f"[{quantity} @ script[t]]")])


def _smooth(values: np.ndarray) -> np.ndarray:
    """The mean over the second around each frame: hops come and go within a few frames."""
    half = round(0.5 / FRAME_SECONDS)
    total = np.cumsum(np.pad(values, (1, 0)))
    last = np.arange(len(values))
    first, end = np.maximum(last - half, 0), np.minimum(last + half + 1, len(values))
    return (total[end] - total[first]) / (end - first)
