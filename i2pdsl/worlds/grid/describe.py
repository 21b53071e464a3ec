"""Grid worlds in words, for `i2p worlds`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from i2pdsl.worlds.grid.hypotheses import factors, hypothesis_count
from i2pdsl.worlds.grid.spec import GridSpec


def as_json(spec: GridSpec) -> dict[str, Any]:
    return {
        "map": list(spec.rows),
        **({"walls": [[list(a), list(b)] for a, b in spec.walls]} if spec.walls else {}),
        "states": spec.state_count,
        "characters": [
            {
                "name": c.name,
                "success": c.success,
                "goals": list(c.goals),
                "pushes": list(c.pushes),
                **({"pulls": list(c.pulls)} if c.pulls else {}),
                **({"carries": list(c.carries)} if c.carries else {}),
                **({"puts_down": list(c.puts_down)} if c.puts_down else {}),
                **({"diagonals": True} if c.diagonals else {}),
                "toward": _one([name for name, _ in c.attitudes]),
                "models": _one(c.models),
                **({"misreads": list(c.misreads)} if c.misreads else {}),
                **({"via": list(c.via)} if c.via else {}),
                **({"supposes": {k: list(v) for k, v in c.supposes}} if c.supposes else {}),
            }
            for c in spec.characters
        ],
        "objects": [
            {"name": t.name, "may_be_absent": t.may_be_absent}
            | ({"count": t.count} if t.count > 1 else {})
            | ({"opened_by": list(t.opened_by)} if t.opened_by else {})
            for t in spec.things
        ],
        **({"order": "together"} if spec.together else {}),
        "tiles": [{"name": t.name, "cells": [list(c) for c in t.cells]} for t in spec.tiles],
    }


def _one(names: Sequence[str]) -> str | list[str] | None:
    """None, the only one, or all of several."""
    return (names[0] if names else None) if len(names) < 2 else [*names]


def map_in_words(spec: GridSpec) -> list[str]:
    """The lines of the map as a file has it, with the walls between its cells."""
    if not spec.walls:
        return list(spec.rows)
    walls, lines = set(spec.walls), []
    for r, row in enumerate(spec.rows):
        gaps = ["|" if ((c, r), (c + 1, r)) in walls else " " for c in range(len(row) - 1)]
        lines.append("".join(a + b for a, b in zip(row, [*gaps, ""], strict=True)))
        below = " ".join("-" if ((c, r), (c, r + 1)) in walls else " " for c in range(len(row)))
        if below.strip():
            lines.append(below.rstrip())
    return lines


def in_words(spec: GridSpec) -> list[str]:
    lines = [f"    {row}" for row in map_in_words(spec)]
    hypotheses = hypothesis_count(spec)
    most = "at most " if spec.is_limited else ""
    held = ""
    if spec.is_sampled:
        held = ", held by factors" if factors(spec) else ", held as particles"
    lines += ["", f"{most}{spec.state_count:,} states, {hypotheses} hypotheses{held}", ""]
    for c in spec.characters:
        strength = "strong" if not c.is_weak else f"weak: a move succeeds with {c.success:g}"
        pushes = f"; pushes {', '.join(c.pushes)}" if c.pushes else ""
        pushes += f"; pulls {', '.join(c.pulls)}" if c.pulls else ""
        pushes += f"; carries {', '.join(c.carries)}" if c.carries else ""
        pushes += f"; puts down {', '.join(c.puts_down)}" if c.puts_down else ""
        pushes += "; moves aslant" if c.diagonals else ""
        lines.append(f"character {c.name}: {strength}{pushes}")
    for t in spec.things:
        told = f": {t.count} that are alike" if t.count > 1 else ""
        told = f": opened by {' or '.join(t.opened_by)}" if t.opened_by else told
        lines.append(f"object {t.name}{': may be absent' if t.may_be_absent else told}")
    if spec.together:
        lines.append("both act at the same time")
    if spec.settings.horizon:
        lines.append(f"the time is up after {spec.settings.horizon} frames")
    return lines
