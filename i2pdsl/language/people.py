"""Audiences in files: viewers as they were fitted to people's judgements, `audience "people.toml"`.

Anybody may have written such a file. It names latents and their values; those that a story's world
does not have count for nothing there, so that viewers fitted in one world can watch another.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, error
from i2pdsl.language.statements import read_source
from i2pdsl.language.story import Observer
from i2pdsl.language.vocabulary import Vocabulary, show_value
from i2pdsl.untrusted import mismatch

FORMAT, VERSION = "i2p-audience", 1
_HEAD = re.compile(r"\s*\[\[\s*viewer\s*\]\]")
MOST_VIEWERS = 64  # of a file: a story's search thinks for each of them


@dataclass(frozen=True)
class Person:
    """One viewer of a file.

    Attributes:
        sharpness: how much more strongly than characters do he expects them to prefer what is best
            for them.
        forgetting: the share of belief that is reassigned after each observed action.
        prior: latent -> value -> weight.
        settings: of the world as he believes it works.
    """

    sharpness: float
    forgetting: float
    prior: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    settings: Mapping[str, float | str] = field(default_factory=dict)

    def observer(self, words: Vocabulary) -> Observer:
        """The viewer in a world; what that does not have is left out."""
        settings = {"forgetting": self.forgetting, **self.settings}
        known = known_settings(words, settings.items())
        weights = list(words.prior or (1.0,) * len(words.hypotheses))
        weights = [w * own for w, own in zip(weights, weighed(words, self.prior), strict=True)]
        total = sum(weights)
        prior = tuple(weight / total for weight in weights) if total > 0 else None
        return Observer(tuple(sorted(known)), prior, sharpness=self.sharpness)


def known_settings(
    words: Vocabulary, settings: Iterable[tuple[str, float | str]]
) -> tuple[tuple[str, float | str], ...]:
    """Of a viewer's settings those in which viewers of a world can differ."""
    return tuple(
        (name, value if isinstance(value, str) else float(value))
        for name, value in settings
        if name in words.observer_settings and words.settings[name].holds(value)
    )


def weighed(words: Vocabulary, prior: Mapping[str, Mapping[str, float]]) -> list[float]:
    """The weight of each hypothesis, from those of latents' values."""
    return [
        math.prod(
            values.get(show_value(row[name]), 1.0) for name, values in prior.items() if name in row
        )
        for row in words.hypotheses
    ]


def read_people(path: Path, here: Span | None = None) -> tuple[Person, ...]:
    """The viewers of a file. Raises StoryError, at `here` where there is no such file."""
    try:
        source = read_source(path)
    except StoryError:
        if here is None:
            raise
        message = f"there is no audience file `{path.name}`"
        hint = "`i2p fit` makes one; its path is relative to this file"
        raise error("audience", message, here, hint) from None
    try:
        document = tomllib.loads(source.text)
    except tomllib.TOMLDecodeError as problem:
        raise error("audience", f"it is not TOML: {problem}", _line(source, 1)) from None
    document = {"fitted": {}, **document}
    wrong = mismatch(document, _SHAPE, "the file")
    if wrong is None and not 1 <= len(document["viewer"]) <= MOST_VIEWERS:
        wrong = f"the file has {len(document['viewer'])} viewers, not 1 to {MOST_VIEWERS}"
    if wrong:
        raise error("audience", wrong, _line(source, 1), "`i2p fit` writes such files")
    lines = [n for n, line in enumerate(source.text.splitlines(), 1) if _HEAD.match(line)]
    problems = [
        Diagnostic("audience", told, _line(source, lines[n] if n < len(lines) else 1))
        for n, viewer in enumerate(document["viewer"])
        if (told := _viewer(viewer, f"viewer {n + 1}"))
    ]
    if problems:
        raise StoryError(problems)
    return tuple(
        Person(
            float(each["sharpness"]),
            float(each["forgetting"]),
            each.get("prior", {}),
            each.get("settings", {}),
        )
        for each in document["viewer"]
    )


def _line(source: Source, number: int) -> Span:
    return Span(source, *source.line_range(number))


def _between(low: float, high: float) -> Any:
    def wrong(value: Any) -> str | None:
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not math.isfinite(value) or not low <= value <= high:
            return f"is no number from {low:g} to {high:g}"
        return None

    return wrong


def _number_or_word(value: Any) -> str | None:
    is_word = isinstance(value, str) and value.isidentifier() and len(value) < 100
    return None if is_word else _between(-1e6, 1e6)(value)


def _viewer(value: Any, name: str) -> str | None:
    """What is wrong with a viewer."""
    if not isinstance(value, dict):
        return f"{name} is no table"
    whole = {"prior": {}, "settings": {}, **value}
    shape = {
        "sharpness": _between(1e-3, 1e3),
        "forgetting": _between(0.0, 1.0),
        "prior": {str: {str: _between(0.0, 1e6)}},
        "settings": {str: _number_or_word},
    }
    return mismatch(whole, shape, name)


def _is(wanted: Any) -> Any:
    return lambda value: None if value == wanted else f"is not {wanted!r}"


def _anything(value: Any) -> None:
    return None


_SHAPE = {
    "format": _is(FORMAT),
    "version": _is(VERSION),
    "fitted": _anything,
    "viewer": [_anything],
}


def written(people: tuple[Person, ...], fitted: Mapping[str, Any], about: str) -> str:
    """The text of a file: viewers, and how they were fitted."""
    lines = [f"# {line}" for line in about.splitlines()]
    lines += [f'format = "{FORMAT}"', f"version = {VERSION}", "", "[fitted]"]
    lines += [f"{_key(name)} = {_number(value)}" for name, value in fitted.items()]
    for person in people:
        lines += ["", "[[viewer]]", f"sharpness = {_number(person.sharpness)}"]
        lines.append(f"forgetting = {_number(person.forgetting)}")
        if person.settings:
            pairs = ", ".join(f"{_key(k)} = {_number(v)}" for k, v in person.settings.items())
            lines.append(f"settings = {{ {pairs} }}")
        for latent, values in person.prior.items():
            pairs = ", ".join(f"{_key(value)} = {_number(w)}" for value, w in values.items())
            lines.append(f"prior.{_key(latent)} = {{ {pairs} }}")
    return "\n".join(lines) + "\n"


def _key(name: str) -> str:
    escaped = name.replace("\\", "\\\\").replace('"', '\\"')
    return name if name.isascii() and name.replace("_", "").isalnum() else f'"{escaped}"'


def _number(value: float | str) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    return repr(float(f"{value:.6g}"))
