"""What a story is about: the curves that its pictures lead with, and its captions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.story import VIEWERS
from i2pdsl.language.vocabulary import Value
from i2pdsl.objective.replay import evaluate
from i2pdsl.objective.subjects import Claims, Subject, belief_over, claims, event_of, latents_of
from i2pdsl.render.files import UNSURE, percent
from i2pdsl.render.mind import PALETTE, Panel, Series
from i2pdsl.scripts import Script
from i2pdsl.worlds.hypotheses import is_attitude

Sentence = Callable[[Claims, Claims], tuple[str, str]]
"""An event, and the condition that it is taken under: its name, and what those think who believe
it."""

ASKED, FORTUNE = "what the story asks", "'s fortune"
SERIES_MAX = 4  # of several things that are asked
TOLD_MAX = 3  # statements of a caption
HUES = ("#0068b0", "#c65102", "#00664a", "#8a3ffc")
SURE, LIKELY = 0.95, 0.7  # from which probability on viewers are sure, and think so
EARLY = 0.2  # of a story, in which viewers are expected to get to know everybody
TURNED = (0.4, 0.6)  # a belief that goes from one side of this to the other is turned


@dataclass(frozen=True)
class Focus:
    """What a story is about.

    Attributes:
        leading: the curves that are shown with its film, None where viewers wonder about nothing.
        told: the panels that captions speak of.
    """

    leading: Panel | None
    told: tuple[Panel, ...]

    def caption(self, t: int, since: int | None = None) -> str:
        """What viewers think after frame t, of the first of what is told; where that is several
        things, only what they did not think `since`."""
        found = self._said(t)
        if since is not None and len(found) > 1:
            known = {said[:3] for said in self._said(since)}
            new = [said for said in found if said[:3] not in known]
            who = dict.fromkeys(_those(said.audience) for said in found)
            if not new:
                verb = "think" if list(who) == [VIEWERS] else "all think"
                return f"{' and '.join(who)} {verb} as before"
            found = new
        claims = [said.claim for said in found]
        text = ""
        before = _Said("", "", "")
        for said in found:
            verb, same = _agreeing(said.audience, said.verb), said.audience == before.audience
            # What several audiences are told to think of needs room: their curves tell how much.
            shared = bool(said.claim) and claims.count(said.claim) > 1
            clause = said.clause if shared else said.clause + said.share
            again = bool(said.claim) and said.claim == before.claim and not same
            told = verb + _AGAIN[said.verb] if again else f"{verb} {clause}"
            if same and said.verb == before.verb:
                told = clause
            told = told if same else f"{_those(said.audience)} {told}"
            text += f"{', ' if again else ', and ' if text else ''}{told}"
            before = said
        return text

    def _said(self, t: int) -> list[_Said]:
        """What viewers think after frame t. What somebody does not think need not be said where he
        thinks something that excludes it."""
        found = [said for panel in self.told for said in _statements(panel, t)]
        believed = [said for said in found if said.verb in _CONVINCED]
        told = [
            said
            for said in found
            if said.verb not in _DOUBTING or not any(_excludes(one, said) for one in believed)
        ]
        return told[:TOLD_MAX]

    @property
    def turns(self) -> dict[int, float]:
        """The frames in which what is asked turns, and how much that matters: 1 for a belief that
        is given up or a fortune at its height or depth, less for one that is won late."""
        found: dict[int, float] = {}
        if self.leading is None:
            return found
        for series in self.leading.series:
            if self.leading.kind == "value":
                found |= dict.fromkeys(_extremes(series.values), 1.0)
                continue
            for t, is_won in _changes(series.values):
                if not is_won or t > EARLY * self.leading.last:
                    found[t] = max(found.get(t, 0.0), 0.5 if is_won else 1.0)
        return found


def focus_of(script: Script, panels: Sequence[Panel], sentence: Sentence) -> Focus:
    """What a script's story asks of its viewers, in the order of its text; where it asks nothing
    that has a curve, whether one helps the other, or else what everybody wants."""
    fortunes, asked = _fortunes(script), _asked(script, panels, sentence)
    if asked is None:
        usual = [p for p in panels if p.latent]
        told = tuple([p for p in usual if is_attitude(p.latent)] or usual[:2])
        asked = Focus(told[0] if told else None, told)
        first = fortunes
    else:
        is_fortune = [isinstance(s.about, ty.ValueAt) for s in script.subjects]
        first = fortunes if is_fortune[0] else ()
    return Focus(first[0], first[:1]) if first else asked


def in_words(one: Callable[[str, Sequence[Value]], str], event: Claims, condition: Claims) -> str:
    """An event and its condition, from what says one latent and some of its values."""
    told = _joined([one(latent, values) for latent, values in event.items()])
    if not condition:
        return told
    return f"{told}, if {_joined([one(latent, values) for latent, values in condition.items()])}"


def _joined(claims: Sequence[str]) -> str:
    """Claims with `and` between them; who was just spoken of is not named again."""
    told = list(claims[:1])
    for before, claim in pairwise(claims):
        who, _, does = claim.partition(" ")
        told.append(does if does and before.startswith(f"{who} ") else claim)
    return " and ".join(told)


def is_of_story(panel: Panel) -> bool:
    """Whether a panel is there for the sake of what a story asks, and not of its world."""
    return panel.title == ASKED or panel.title.endswith(FORTUNE)


def led(leading: Panel | None, panels: tuple[Panel, ...]) -> tuple[Panel, ...]:
    """The panels, and the leading one first where it is none of them."""
    known = leading is None or any(p.latent and p.latent == leading.latent for p in panels)
    return panels if known or leading is None else (leading, *panels)


def whose(leading: Panel | None, panels: Sequence[Panel]) -> Panel | None:
    """The leading curves as a film has them: those of a goal say whose it is, where there are
    several."""
    goals = [p for p in panels if p.title.endswith("'s goal")]
    if leading is None or leading not in goals or len(goals) == 1:
        return leading
    series = tuple(replace(s, label=f"{leading.title}: {s.label}") for s in leading.series)
    return replace(leading, series=series)


def _fortunes(script: Script) -> tuple[Panel, ...]:
    """What viewers expect for the characters whose values an objective speaks of."""
    length, found = script.length, []
    for subject in script.subjects:
        if isinstance(subject.about, ty.ValueAt):
            who = script.world.vocabulary.characters[subject.about.who]
            belief = belief_over("E", subject, length)
            values = evaluate(script.world, script.frames, belief, range(length + 1))
            series = Series(who, np.asarray(values, float), PALETTE.get(who, HUES[0]))
            audience = script.audience_of(subject.viewers).name
            if audience != VIEWERS:
                series = replace(series, label=f"{audience}: {who}", audience=audience)
            found.append(Panel(f"{who}{FORTUNE}", "value", (series,), "value"))
    return tuple(found)


def _asked(script: Script, panels: Sequence[Panel], sentence: Sentence) -> Focus | None:
    """The beliefs that an objective speaks of."""
    words = script.world.vocabulary
    subjects = [s for s in script.subjects if not isinstance(s.about, ty.ValueAt)]
    latents = list(dict.fromkeys(x for s in subjects for x in latents_of(words, s)))
    told = [p for p in panels if p.latent in latents]
    told.sort(key=lambda p: not is_attitude(p.latent))  # what one means to another is told first
    events = [s for s in subjects if isinstance(s.about, tuple)]
    conditions = {s.given for s in events}
    if any(script.audience_of(s.viewers).name != VIEWERS for s in events):
        series = _series(script, events, sentence)
        if series:
            panel = Panel(ASKED, "probability", series)
            return Focus(panel, (panel,))
    if len(conditions) == 1 and script.assumption not in conditions and told:
        one = len(told) == 1
        asked = _with_rest(events) if one else events
        series = _series(script, asked, lambda event, _: sentence(event, {}))
        if series:  # what everybody knows all along need not be said
            question = told[0].question if one else ""
            panel = Panel(ASKED, "probability", series, question=question)
            return Focus(panel, (panel,))
    if conditions - {script.assumption}:
        series = _series(script, events, sentence)
        if series:
            panel = Panel(ASKED, "probability", series)
            return Focus(panel, (panel,))
    if len(told) > 1:
        named = [_claims(script, s.about, s.given) or {} for s in events]  # type: ignore[arg-type]
        wanted = [
            Subject(event_of(words, {x: vs}), script.assumption, events[0].viewers)
            for found in named
            for x, vs in found.items()
        ]
        series = _series(script, list(dict.fromkeys(wanted)), sentence)
        if series:
            return Focus(Panel(ASKED, "probability", series), tuple(told))
    return Focus(told[0], tuple(told)) if told else None


def _with_rest(events: list[Subject]) -> list[Subject]:
    """Events under one condition, and that none of them holds, where that can be."""
    given = events[0].given
    columns = zip(*(s.about for s in events), strict=True)
    rest = tuple(not any(column) for column in columns)
    possible = any(r and g for r, g in zip(rest, given, strict=True))
    return [*events, Subject(rest, given, events[0].viewers)] if possible else events


def _claims(script: Script, event: ty.Mask, within: ty.Mask) -> Claims | None:
    return claims(script.world.vocabulary, event, within)


def _series(script: Script, subjects: Sequence[Subject], sentence: Sentence) -> tuple[Series, ...]:
    """A curve for each event, named in words, those without a condition first; none where one of
    them has no words."""
    length, found = script.length, list[Series]()
    plain = [_claims(script, s.about, s.given) for s in subjects if s.given == script.assumption]  # type: ignore[arg-type]
    named = any(script.audience_of(s.viewers).name != VIEWERS for s in subjects)
    for subject in sorted(subjects, key=lambda s: s.given != script.assumption)[:SERIES_MAX]:
        assert isinstance(subject.about, tuple)
        event = _claims(script, subject.about, subject.given)
        condition = _claims(script, subject.given, script.assumption)
        if not event or condition is None:
            return ()
        belief = belief_over("P", subject, length)
        values = evaluate(script.world, script.frames, belief, range(length + 1))
        label, claim = sentence(event, condition)
        if condition and condition in plain:
            claim = ""  # viewers are asked to believe the condition, and then it goes without it
        hue, audience = HUES[len(found)], script.audience_of(subject.viewers).name
        label = f"{audience}: {label}" if named else label
        told = np.asarray(values, float)
        same = len({s.given for s in subjects}) == 1  # else to exclude each other means nothing
        both = zip(subject.about, subject.given, strict=True)
        asked = tuple(a and g for a, g in both) if same else ()
        found.append(Series(label, told, hue, claim=claim, audience=audience, event=asked))
    return tuple(found)


# --------------------------------------------------------------------------------------- in words


class _Said(NamedTuple):
    """What an audience thinks: how sure it is, and of what; where that is one claim among others,
    the claim, how much it is believed, in brackets, and the hypotheses of which it is true."""

    audience: str
    verb: str
    clause: str
    claim: str = ""
    share: str = ""
    event: ty.Mask = ()


def _excludes(one: _Said, other: _Said) -> bool:
    """Whether of two claims of an audience not both can be true."""
    both = [a and b for a, b in zip(one.event, other.event, strict=False)]
    return one.audience == other.audience and bool(both) and not any(both)


def _statements(panel: Panel, t: int) -> list[_Said]:
    """What viewers think of what a panel shows."""
    if panel.kind == "value":
        return [_fortune(series, t) for series in panel.series]
    named = [s for s in panel.series if s.claim]
    if not panel.question:
        return [_degree(s, float(s.values[t])) for s in named]
    first, *others = sorted(named, key=lambda s: -s.values[t])
    p = float(first.values[t])
    if others and p - others[0].values[t] < UNSURE:
        return [_Said(first.audience, "cannot tell", panel.question)]
    share = f" ({percent(p)})"
    return [_Said(first.audience, _verb(p), f"that {first.claim}", share=share)]


def _those(audience: str) -> str:
    """Whose belief a caption speaks of: `viewers`, `the friend`."""
    return audience if audience == VIEWERS else f"the {audience}"


def _agreeing(audience: str, verb: str) -> str:
    """A verb as the name of an audience wants it: one that ends in `s` is taken for several."""
    if audience.endswith("s"):
        return verb
    return _OF_ONE.get(verb, verb)


_OF_ONE = {
    "are sure": "is sure",
    "think": "thinks",
    "rather think": "rather thinks",
    "do not think": "does not think",
    "rather doubt": "rather doubts",
}
_CONVINCED, _DOUBTING = ("are sure", "think", "rather think"), ("do not think", "rather doubt")
_AGAIN = {
    "are sure": " of it",
    "think": " so",
    "rather think": " so",
    "do not think": " so",
    "rather doubt": " it",
    "cannot tell": "",
}
"""How a claim is said that another audience was just said to think of."""


def _verb(p: float) -> str:
    return "are sure" if p >= SURE else "think" if p >= LIKELY else "rather think"


def _degree(series: Series, p: float) -> _Said:
    """How much viewers believe something for itself."""
    claim, share = series.claim, f" ({percent(p)})"
    if abs(p - 0.5) < UNSURE:
        return _Said(series.audience, "cannot tell", f"whether {claim}", claim, "", series.event)
    verb = _verb(p) if p > 0.5 else "do not think" if p < 1 - LIKELY else "rather doubt"
    return _Said(series.audience, verb, f"that {claim}", claim, share, series.event)


def _fortune(series: Series, t: int) -> _Said:
    """How things look for somebody, measured by the best and the worst of the story."""
    low, high = float(np.nanmin(series.values)), float(np.nanmax(series.values))
    here = float(series.values[t])
    share = (here - low) / (high - low) if high > low else 0.5
    how = "bad" if share < 1 / 3 else "good" if share > 2 / 3 else "fair"
    number = (f"{here:.0f}" if abs(here) >= 100 else f"{here:.3g}").replace("-", "−")
    who = series.label.removeprefix(f"{series.audience}: ")
    clause = f"that things look {how} for {who} (value {number})"
    return _Said(series.audience, "think", clause)


# ------------------------------------------------------------------------------------------ turns


def _changes(values: np.ndarray) -> list[tuple[int, bool]]:
    """The frames in which a belief is won (True) or given up."""
    low, high = TURNED
    sides = [(t, bool(v > high)) for t, v in enumerate(values) if v > high or v < low]
    changes = [(t, now) for (_, before), (t, now) in pairwise(sides) if now != before]
    if sides and sides[0][0] > 0 and sides[0][1]:  # it began undecided
        changes.insert(0, sides[0])
    return changes


def _extremes(values: np.ndarray) -> list[int]:
    """The frames between which a curve goes up or down by a third of all that it ever does."""
    least = (np.nanmax(values) - np.nanmin(values)) / 3
    found: list[int] = []
    turning, way = 0, 0  # the last candidate, and where the curve has gone since: up or down
    for t in range(1, len(values)):
        change = values[t] - values[turning]
        if way * change >= 0 and abs(change) > 0 and (way or abs(change) >= least):
            if not way:
                found.append(turning)
            way, turning = (1 if change > 0 else -1), t
        elif way and abs(change) >= least > 0:
            found.append(turning)
            way, turning = -way, t
    return [*found, turning] if way else found
