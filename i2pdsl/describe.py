"""Worlds and patterns in words, for `i2p worlds` and `i2p patterns`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from i2pdsl.errors import error as story_error
from i2pdsl.errors import whole_file
from i2pdsl.language import ast
from i2pdsl.language.parse import parse_file
from i2pdsl.resources import data_folder
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary


def world_as_json(spec: GridSpec) -> dict[str, Any]:
    """A world as plain data."""
    words = grid_vocabulary(spec)
    return {
        "name": spec.name,
        "documentation": spec.documentation,
        "map": list(spec.rows),
        "states": spec.state_count,
        "hypotheses": len(words.hypotheses),
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
        "latents": [
            {"name": x.name, "values": list(x.values), "documentation": x.documentation}
            for x in words.latents.values()
        ],
        "predicates": [_signature(p) for p in words.predicates.values()],
        "events": [f"{e}({thing})" for e, things in words.events.items() for thing in things],
        "settings": {s.name: s.default for s in words.settings.values()},
    }


def _signature(predicate: Any) -> str:
    return f"{predicate.name}({', '.join(predicate.parameters)})"


def describe_world(spec: GridSpec) -> str:
    """A world in words: its map, its cast, and everything that a story can name."""
    words = grid_vocabulary(spec)
    lines = [f"world {spec.name}", "", *(f"  {x}" for x in spec.documentation.splitlines()), ""]
    lines += [f"    {row}" for row in spec.rows]
    lines += ["", f"{spec.state_count:,} states, {len(words.hypotheses)} hypotheses", ""]
    for c in spec.characters:
        strength = "strong" if not c.is_weak else f"weak: a move succeeds with {c.success:g}"
        pushes = f"; pushes {', '.join(c.pushes)}" if c.pushes else ""
        lines.append(f"character {c.name}: {strength}{pushes}")
    for t in spec.things:
        lines.append(f"object {t.name}{': may be absent' if t.may_be_absent else ''}")
    sections: list[tuple[str, list[tuple[str, str]]]] = [
        (
            "latents",
            [(f"{x.name} in {{{x.domain}}}", x.documentation) for x in words.latents.values()],
        ),
        ("tiles", [(t.name, ", ".join(map(str, t.cells))) for t in spec.tiles]),
        ("predicates", [(_signature(p), p.documentation) for p in words.predicates.values()]),
        (
            "events",
            [(f"{e}({t})", "falls onto a free cell") for e, ts in words.events.items() for t in ts],
        ),
        (
            "settings",
            [(f"{s.name} = {s.default}", s.documentation) for s in words.settings.values()],
        ),
    ]
    for title, rows in sections:
        if rows:
            width = max(len(name) for name, _ in rows)
            lines += ["", title, *(f"  {name:<{width}}  {text}" for name, text in rows)]
    return "\n".join(lines)


def library_patterns(library: str | None) -> list[dict[str, Any]]:
    """The patterns of a library (a file or a folder), or the standard ones."""
    place = Path(library) if library is not None else data_folder("stories") / "patterns"
    files = sorted(place.glob("*.story")) if place.is_dir() else [place]
    found = [
        {
            "name": pattern.name.id,
            "signature": pattern.signature,
            "documentation": pattern.documentation,
            "body": pattern.body.span.text,
            "file": str(file),
        }
        for file in files
        for pattern in parse_file(file).of(ast.Pattern)
    ]
    if not found:
        raise story_error("no-pattern", "there are no patterns here", whole_file(str(place)))
    return sorted(found, key=lambda p: str(p["name"]))
