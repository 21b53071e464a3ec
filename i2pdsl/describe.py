"""Worlds in words, for `i2p worlds`."""

from __future__ import annotations

from typing import Any

from i2pdsl.errors import display_width, padded
from i2pdsl.worlds.kind import Spec
from i2pdsl.worlds.kinds import kind_of


def world_as_json(spec: Spec) -> dict[str, Any]:
    """A world as plain data."""
    kind = kind_of(spec)
    words = kind.vocabulary(spec)
    return {
        "name": spec.name,
        "documentation": spec.documentation,
        **kind.as_json(spec),
        "hypotheses": len(words.hypotheses),
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


def describe_world(spec: Spec) -> str:
    """A world in words: its map, its cast, and everything that a story can name."""
    kind = kind_of(spec)
    words = kind.vocabulary(spec)
    lines = [f"world {spec.name}", "", *(f"  {x}" for x in spec.documentation.splitlines()), ""]
    lines += kind.in_words(spec)
    sections: list[tuple[str, list[tuple[str, str]]]] = [
        (
            "latents",
            [(f"{x.name} in {{{x.domain}}}", x.documentation) for x in words.latents.values()],
        ),
        (
            "tiles",
            [(name, ", ".join(map(str, cells))) for name, cells in words.places.items()]
            if words.columns
            else [],
        ),
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


def shown_value(value: Any) -> str:
    """A setting's value as a story has it."""
    if isinstance(value, tuple):
        return "{" + ", ".join(f"{x:g}" for x in value) + "}"
    return str(value)
