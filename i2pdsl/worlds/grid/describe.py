"""Grid worlds in words, for `i2p worlds`."""

from __future__ import annotations

from typing import Any

from i2pdsl.worlds.grid.hypotheses import grid_hypotheses
from i2pdsl.worlds.grid.spec import GridSpec


def as_json(spec: GridSpec) -> dict[str, Any]:
    return {
        "map": list(spec.rows),
        "states": spec.state_count,
        "characters": [
            {
                "name": c.name,
                "success": c.success,
                "goals": list(c.goals),
                "pushes": list(c.pushes),
                **({"pulls": list(c.pulls)} if c.pulls else {}),
                "toward": c.toward,
                "models": c.models,
            }
            for c in spec.characters
        ],
        "objects": [{"name": t.name, "may_be_absent": t.may_be_absent} for t in spec.things],
        "tiles": [{"name": t.name, "cells": [list(c) for c in t.cells]} for t in spec.tiles],
    }


def in_words(spec: GridSpec) -> list[str]:
    lines = [f"    {row}" for row in spec.rows]
    hypotheses = len(grid_hypotheses(spec))
    most = "at most " if spec.is_limited else ""
    lines += ["", f"{most}{spec.state_count:,} states, {hypotheses} hypotheses", ""]
    for c in spec.characters:
        strength = "strong" if not c.is_weak else f"weak: a move succeeds with {c.success:g}"
        pushes = f"; pushes {', '.join(c.pushes)}" if c.pushes else ""
        pushes += f"; pulls {', '.join(c.pulls)}" if c.pulls else ""
        lines.append(f"character {c.name}: {strength}{pushes}")
    for t in spec.things:
        lines.append(f"object {t.name}{': may be absent' if t.may_be_absent else ''}")
    return lines
