"""What viewers believe of characters that want something and care about each other, as curves and
in words: the same for all worlds that have such."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np

from i2pdsl.language.vocabulary import Value, show_value
from i2pdsl.objective.subjects import Claims
from i2pdsl.render.focus import in_words
from i2pdsl.render.mind import PALETTE, Panel, Series
from i2pdsl.scripts import Script
from i2pdsl.worlds.hypotheses import (
    NOWHERE,
    Attitude,
    Minded,
    attitudes_of,
    goal_of,
    rationality_of,
    reading_of,
    via_of,
)

# For values that the palette does not name; dashes and labels tell them apart too.
COLORS = ("#0068b0", "#c65102", "#00664a", "#8a3ffc", "#8c7a3a", "#d9468f")
CURVES_MAX = 24  # in a panel
OTHERS = " others"
T = TypeVar("T")

_ATTITUDES = {"hindering": "< 0", "indifferent": "= 0", "helping": "> 0"}
_SIGNS = {"hindering": -1, "indifferent": 0, "helping": 1}


class Cast(Protocol):
    """The characters of a world."""

    @property
    def characters(self) -> Sequence[Minded]: ...


@dataclass(frozen=True)
class Beliefs:
    """Curves and words of what viewers believe of a cast.

    Attributes:
        wants: how goals are said that are no places, with `{other}` for the other character.
    """

    cast: Cast
    wants: dict[str, str]

    def goal(self, who: str, values: Sequence[str]) -> str:
        """That a character wants one of some things."""
        other = next((c.name for c in self.cast.characters if c.name != who), "")
        usual = [v for v in values if v not in self.wants]
        told = [f"wants {' or '.join(usual)}"] if usual else []
        told += [self.wants[v].format(other=other) for v in values if v in self.wants]
        return f"{who} {' or '.join(told)}"

    def attitude(self, about: Attitude, values: Iterable[float]) -> str:
        """What whoever has an attitude means to do: nobody may be seen to do it."""
        who, found = about.toward, {int(np.sign(v)) for v in values}
        told = {
            (1,): f"means to help {who}",
            (-1,): f"means to hinder {who}",
            (0,): f"does not care about {who}",
            (0, 1): f"does not mean to hinder {who}",
            (-1, 0): f"does not mean to help {who}",
            (-1, 1): f"cares about {who}",
        }
        return f"{about.who} {told.get(tuple(sorted(found)), f'may mean anything to {who}')}"

    @property
    def attitudes(self) -> dict[str, Attitude]:
        """The attitudes of the cast, by latent."""
        return {each.latent: each for each in attitudes_of(self.cast.characters)}

    @property
    def _readings(self) -> dict[str, tuple[str, str]]:
        """Who takes whom to want something, by latent."""
        return {
            reading_of(c.name, other): (c.name, other)
            for c in self.cast.characters
            for other in c.misreads
        }

    @property
    def _ways(self) -> dict[str, str]:
        """Who may want to have been somewhere first, by latent."""
        return {via_of(c.name): c.name for c in self.cast.characters if c.via}

    @property
    def _places(self) -> dict[str, tuple[str, str]]:
        """Who takes which thing to be somewhere, by latent."""
        return {
            reading_of(c.name, thing): (c.name, thing)
            for c in self.cast.characters
            for thing, _ in c.supposes
        }

    def sentence(self, event: Claims, condition: Claims) -> tuple[str, str]:
        """An event's name, and what those think who believe it.

        What somebody means to another who wants something is said as what the deed looks like,
        whatever the other wants in truth.
        """
        about = self.attitudes.get(next(iter(event), "")) if len(event) == 1 else None
        if about is not None and len(condition) == 1:
            signs = {int(np.sign(float(v))) for v in event[about.latent]}
            goals = [str(g) for g in condition.get(goal_of(about.toward), ())]
            if signs in ({1}, {-1}) and goals and not set(goals) & set(self.wants):
                verb, to = ("helping", "to") if signs == {1} else ("keeping", "from")
                place = " or ".join(goals)
                claim = f"{about.who} acts as if {verb} {about.toward} {to} {place}"
                return f"{verb} {to} {place}", claim
        return in_words(self._name, event, condition), in_words(self._one, event, condition)

    def _name(self, latent: str, values: Sequence[Value]) -> str:
        """As `_one`, as short as can be."""
        about = self.attitudes.get(latent)
        if about is not None:
            signs = {int(np.sign(float(v))) for v in values}
            told = " or ".join(name for name, sign in _SIGNS.items() if sign in signs)
            return told if len(self.attitudes) == 1 else f"{about.who} {told} {about.toward}"
        who, named = latent.partition("_")[2], " or ".join(map(show_value, values))
        if latent in self._readings:
            reader, other = self._readings[latent]
            return f"{reader} takes {other}: {named}"
        if latent in self._ways:
            return f"{self._ways[latent]} by: {named}"
        if latent in self._places:
            return f"{' supposes '.join(self._places[latent])}: {named}"
        return f"{who}: {named}" if latent.startswith("G_") else f"{who} rational: {named}"

    def _one(self, latent: str, values: Sequence[Value]) -> str:
        """That a latent has one of some values."""
        about = self.attitudes.get(latent)
        if about is not None:
            return self.attitude(about, [float(v) for v in values])
        if latent in self._readings:
            who, other = self._readings[latent]
            return f"{who} takes it that {self.goal(other, [str(v) for v in values])}"
        if latent in self._ways:
            who, named = self._ways[latent], " or ".join(map(show_value, values))
            told = "straight to what it wants" if named == NOWHERE else f"by {named} first"
            return f"{who} wants to go {told}"
        if latent in self._places:
            who, thing = self._places[latent]
            return f"{who} takes {thing} to be at {' or '.join(map(show_value, values))}"
        for c in self.cast.characters:
            if latent == goal_of(c.name):
                return self.goal(c.name, [str(v) for v in values])
            if latent == rationality_of(c.name):
                return f"{c.name} acts {'sensibly' if values == (True,) else 'at random'}"
        raise ValueError(f"no words for {latent!r}")

    def panels(self, script: Script) -> tuple[Panel, ...]:
        """The audience's mind over time: goals, alignment, rationality, values."""
        return (*self._goals(script), *self._attitudes(script), *self._minds(script))

    def _goals(self, script: Script) -> Iterable[Panel]:
        """For each character the probability of each of its goals, and of what others take it to
        want."""
        goals = {c.name: c.goals for c in self.cast.characters}
        for c in self.cast.characters:
            latent = goal_of(c.name)
            if len(c.goals) > 1 and latent in script.world.vocabulary.apart:
                curves = most_believed(c.goals, script.query(f"P({latent} | script[:t])").T)
                series = tuple(
                    replace(s, claim=self.goal(c.name, [s.label])) if s.label in c.goals else s
                    for s in series_of(curves)
                )
                question = f"what {c.name} wants"
                yield Panel(
                    f"{c.name}'s goal", "probability", series, "probability", latent, question
                )

        for latent, (who, other) in _kept(script, self._readings):
            curves = most_believed(goals[other], script.query(f"P({latent} | script[:t])").T)
            series = tuple(
                replace(s, claim=self._one(latent, [s.label])) if s.label in goals[other] else s
                for s in series_of(curves)
            )
            title = f"what {who} takes {other} to want"
            yield Panel(title, "probability", series, "probability", latent, title)
        asked = {
            latent: f"where {who} takes {it} to be" for latent, (who, it) in self._places.items()
        }
        asked |= {latent: f"which way {who} wants to go" for latent, who in self._ways.items()}
        for latent, title in _kept(script, asked):
            places = [str(v) for v in script.world.vocabulary.latents[latent].values]
            curves = most_believed(places, script.query(f"P({latent} | script[:t])").T)
            series = tuple(
                replace(s, claim=self._one(latent, [s.label])) if s.label in places else s
                for s in series_of(curves)
            )
            yield Panel(title, "probability", series, "probability", latent, title)

    def _attitudes(self, script: Script) -> Iterable[Panel]:
        """The probabilities that whoever has an attitude helps, hinders or does not care."""
        for _, about in _kept(script, self.attitudes):
            numbers = script.world.vocabulary.latents[about.latent].values
            possible = {int(np.sign(float(v))) for v in numbers}
            series = series_of(
                (name, script.query(f"P({about.latent} {test} | script[:t])"))
                for name, test in _ATTITUDES.items()
                if _SIGNS[name] in possible
            )
            series = tuple(
                replace(s, claim=self.attitude(about, [_SIGNS[s.label]])) for s in series
            )
            whom = f" toward {about.toward}" if len(self.attitudes) > 1 else ""
            title = f"{about.who}'s alignment{whom}"
            question = f"what {about.who} means to {about.toward}"
            yield Panel(title, "probability", series, "probability", about.latent, question)

    def _minds(self, script: Script) -> Iterable[Panel]:
        """Who is rational, and what everybody who may be expects."""
        words, names = script.world.vocabulary, [c.name for c in self.cast.characters]
        rational = series_of(
            (n, script.query(f"P({rationality_of(n)} | script[:t])", assume="nothing"))
            for n in names
            if rationality_of(n) in words.latents
        )
        if rational:
            yield Panel("rationality", "probability", rational)
        pairs = list(zip(words.hypotheses, script.assumption, strict=True))

        def may_be_rational(name: str) -> bool:
            """By the story's assumption, and to its viewers; who may not has no value."""
            latent = rationality_of(name)
            mask = tuple(holds and bool(row.get(latent, True)) for row, holds in pairs)
            return script.audience_of(None).can_hold(mask)

        minded = [name for name in names if may_be_rational(name)]
        values = series_of((n, script.query(f"E[V({n}) | script[:t]]")) for n in minded)
        if values:
            yield Panel("expected value", "value", values, "value")


def most_believed(names: Sequence[str], values: np.ndarray) -> list[tuple[str, np.ndarray]]:
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


def _kept(script: Script, latents: dict[str, T]) -> Iterable[tuple[str, T]]:
    """Those of some latents whose values viewers keep apart."""
    apart = script.world.vocabulary.apart
    return ((latent, about) for latent, about in latents.items() if latent in apart)


def series_of(curves: Iterable[tuple[str, np.ndarray]]) -> tuple[Series, ...]:
    return tuple(
        Series(label, np.asarray(values), PALETTE.get(label, COLORS[number % len(COLORS)]))
        for number, (label, values) in enumerate(curves)
    )
