"""Worlds in words, for `i2p worlds`."""

from __future__ import annotations

from typing import Any

from i2pdsl.errors import display_width, padded
from i2pdsl.worlds.find import Spec, vocabulary_of
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary
from i2pdsl.worlds.hill.spec import HillSpec
from i2pdsl.worlds.hill.vocabulary import BOX, HOPPER


def world_as_json(spec: Spec) -> dict[str, Any]:
    """A world as plain data."""
    own = _grid_as_json(spec) if isinstance(spec, GridSpec) else _hill_as_json(spec)
    words = vocabulary_of(spec)
    return {
        "name": spec.name,
        "documentation": spec.documentation,
        **own,
        "hypotheses": len(words.hypotheses),
        "latents": [
            {"name": x.name, "values": list(x.values), "documentation": x.documentation}
            for x in words.latents.values()
        ],
        "predicates": [_signature(p) for p in words.predicates.values()],
        "events": [f"{e}({thing})" for e, things in words.events.items() for thing in things],
        "settings": {s.name: s.default for s in words.settings.values()},
    }


def _hill_as_json(spec: HillSpec) -> dict[str, Any]:
    return {"characters": [{"name": HOPPER}], "objects": [{"name": BOX}]}


def _grid_as_json(spec: GridSpec) -> dict[str, Any]:
    return {
        "map": list(spec.rows),
        "states": spec.state_count,
        "characters": [
            {
                "name": c.name,
                "success": c.success,
                "goals": list(c.goals),
                "pushes": list(c.pushes),
                "toward": c.toward,
                "models": c.models,
            }
            for c in spec.characters
        ],
        "objects": [{"name": t.name, "may_be_absent": t.may_be_absent} for t in spec.things],
        "tiles": [{"name": t.name, "cells": [list(c) for c in t.cells]} for t in spec.tiles],
    }


def _signature(predicate: Any) -> str:
    return f"{predicate.name}({', '.join(predicate.parameters)})"


def describe_world(spec: Spec) -> str:
    """A world in words: its map, its cast, and everything that a story can name."""
    words = vocabulary_of(spec)
    lines = [f"world {spec.name}", "", *(f"  {x}" for x in spec.documentation.splitlines()), ""]
    lines += _grid_in_words(spec) if isinstance(spec, GridSpec) else _hill_in_words(spec)
    sections: list[tuple[str, list[tuple[str, str]]]] = [
        (
            "latents",
            [(f"{x.name} in {{{x.domain}}}", x.documentation) for x in words.latents.values()],
        ),
        ("tiles", [(name, ", ".join(map(str, cells))) for name, cells in words.places.items()]),
        ("predicates", [(_signature(p), p.documentation) for p in words.predicates.values()]),
        (
            "events",
            [(f"{e}({t})", "falls onto a free cell") for e, ts in words.events.items() for t in ts],
        ),
        (
            "settings",
            [
                (f"{s.name} = {shown_value(s.default)}", s.documentation)
                for s in words.settings.values()
            ],
        ),
    ]
    for title, rows in sections:
        if rows:
            width = max(display_width(name) for name, _ in rows)
            lines += ["", title, *(f"  {padded(name, width)}  {text}" for name, text in rows)]
    return "\n".join(lines)


def _grid_in_words(spec: GridSpec) -> list[str]:
    lines = [f"    {row}" for row in spec.rows]
    hypotheses = len(grid_vocabulary(spec).hypotheses)
    lines += ["", f"{spec.state_count:,} states, {hypotheses} hypotheses", ""]
    for c in spec.characters:
        strength = "strong" if not c.is_weak else f"weak: a move succeeds with {c.success:g}"
        pushes = f"; pushes {', '.join(c.pushes)}" if c.pushes else ""
        lines.append(f"character {c.name}: {strength}{pushes}")
    for t in spec.things:
        lines.append(f"object {t.name}{': may be absent' if t.may_be_absent else ''}")
    return lines


def _hill_in_words(spec: HillSpec) -> list[str]:
    return [
        f"{spec.settings.slope:g} rad steep; 20 frames a unit of time; continuous actions",
        "",
        f"character {HOPPER}: six muscles; it pulls",
        f"object {BOX}: on a rope",
    ]


def shown_value(value: Any) -> str:
    """A setting's value as a story has it."""
    if isinstance(value, tuple):
        return "{" + ", ".join(f"{x:g}" for x in value) + "}"
    return str(value)
