"""Why viewers believe it, in words: explain.py's numbers as sentences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from i2pdsl.answers import number
from i2pdsl.explain import (
    Against,
    Effect,
    Question,
    Reason,
    as_story,
    course,
    explain,
    questions_of,
    times,
)
from i2pdsl.language.story import VIEWERS
from i2pdsl.render.focus import Sentence
from i2pdsl.scripts import Script
from i2pdsl.worlds.kinds import drawing_of

MOVED = 0.001  # of a probability: less is not told
EVEN = 1.05  # ratios closer to 1 are told as such
OTHERWISE = "otherwise"


@dataclass(frozen=True)
class Asked:
    """What viewers are asked: in words, as the language writes it ('' where it cannot), and its
    probability at the start and at the end."""

    claim: str
    formal: str
    before: float
    after: float


@dataclass(frozen=True)
class Change:
    """A belief that an observation moved.

    Attributes:
        claim: what is believed.
        before, after: its probability.
        ratio: against which alternative, and by how much, what was seen speaks.
        instead: of the other actions the one that viewers expected most, with which probability
            they did, and what this one had been then; None where actions cannot be listed.
        is_forgotten: whether it went against what was seen.
        audience: who believes it.
    """

    claim: str
    before: float
    after: float
    ratio: str
    instead: tuple[str, float, float] | None = None
    is_forgotten: bool = False
    audience: str = VIEWERS


@dataclass(frozen=True)
class Observation:
    """What was seen in the frames first..last, and the changes worth telling, greatest first.

    Attributes:
        expected: the probability with which viewers expected an action; None for motion.
        is_event: it was nobody's deed, and nobody learns from it.
    """

    first: int
    last: int
    seen: str
    expected: float | None
    changes: tuple[Change, ...]
    is_event: bool = False

    @property
    def greatest(self) -> tuple[Change, ...]:
        """The greatest change of each audience."""
        first = {change.audience: change for change in reversed(self.changes)}
        return tuple(change for change in self.changes if first[change.audience] is change)


@dataclass(frozen=True)
class Account:
    """Why viewers believe what they believe; `legend` says how to read it."""

    asked: tuple[Asked, ...]
    observations: tuple[Observation, ...]
    legend: tuple[str, ...]


def account_of(script: Script, frame: int | None = None) -> Account | None:
    """What moved viewers' beliefs in a script, or in one of its frames 1..T; None where they have
    nothing to find out."""
    questions = questions_of(script)
    if not questions:
        return None
    drawing, words = drawing_of(script.world.spec), script.world.vocabulary
    sentence, deeds = drawing.sentence(script.world.spec), drawing.deeds(script)
    observations = []
    for reason in explain(script, questions, frame):
        deed, expected = deeds[reason.first - 1], None
        is_event = reason.who is None and words.enumerable
        seen = (", ".join(deed.values()) or "an event") if is_event else "what is seen"
        if reason.who is not None and reason.taken is not None:
            seen = deed.get(reason.who, f"{reason.who} {reason.taken.action}")
            expected = reason.taken.expected
        changes = tuple(_change(reason, effect, sentence) for effect in _told(reason))
        span = reason.first, reason.last
        observations.append(Observation(*span, seen, expected, changes, is_event))
    asked = tuple(_asked(script, question, sentence) for question in questions)
    return Account(asked, tuple(observations), _legend(words.enumerable))


def reasons_in_words(script: Script, frame: int | None = None) -> str:
    """What moved viewers' beliefs in a script: of a whole script the greatest change that each
    observation made, of one frame (1..T) all of them."""
    account = account_of(script, frame)
    if account is None:
        return "viewers have nothing to find out"
    lines = ["what viewers are asked, and believe at the start and at the end:"]
    for asked in account.asked:
        formal = f" [{asked.formal}]" if asked.formal else ""
        lines.append(f"  {asked.claim}{formal}: {number(asked.before)} -> {number(asked.after)}")
    told = 0
    for each in account.observations:
        if each.first != told:
            lines += ["", frames_in_words(each)]
        told = each.first
        if each.is_event:
            lines.append(f"  {each.seen}: nobody's deed, from which viewers learn nothing")
            continue
        said = each.seen
        if each.expected is not None:
            said += f" (expected with {short(each.expected)})"
        lines.append(f"  {said}{':' if each.changes else ' changes next to nothing of this'}")
        for change in each.changes if frame is not None else each.greatest:
            lines += [f"    {change.ratio}", f"    {_change_in_words(change)}"]
    return "\n".join((*lines, "", *account.legend))


def frames_in_words(seen: Observation) -> str:
    """The frames of an observation."""
    if seen.first == seen.last:
        return f"frame {seen.first}"
    return f"frames {seen.first} to {seen.last}"


def short(p: float) -> str:
    """A probability that need not be read to the last digit."""
    return f"{p:.4g}"


def _change_in_words(change: Change) -> str:
    told = f"{change.claim}: {number(change.before)} -> {number(change.after)}"
    if change.instead is not None:
        action, expected, otherwise = change.instead
        expecting = f"expected with {short(expected)}"
        return f"{told}; had it been `{action}` ({expecting}): {number(otherwise)}"
    return f"{told}, since they forget faster than that tells them" if change.is_forgotten else told


def _asked(script: Script, question: Question, sentence: Sentence) -> Asked:
    believed, words = course(script, question), script.world.vocabulary
    parts = [as_story(words, found) for found in (question.claims, question.condition) if found]
    formal = " | ".join(parts) if question.claims else ""
    claim = f"{_whose(question)}{_claim(question, sentence)}"
    formal = formal if formal != claim else ""  # there are no other words for it
    return Asked(claim, formal, float(believed[0]), float(believed[-1]))


def _whose(question: Question) -> str:
    """The name of the audience that is asked, where it has one of its own."""
    return "" if question.audience == VIEWERS else f"{question.audience}: "


def _claim(question: Question, sentence: Sentence) -> str:
    """A question's event in words."""
    if question.claims is None or question.condition is None:
        return "what the story asks about holds"
    return sentence(question.claims, question.condition)[1]


def _told(reason: Reason) -> list[Effect]:
    """The changes worth telling, greatest first; of two that mirror each other the rise."""
    effects = [e for e in reason.effects if abs(e.after - e.before) >= MOVED]
    effects.sort(key=lambda e: (-round(abs(e.after - e.before), 9), e.after < e.before))
    told: list[Effect] = []
    for effect in effects:
        if not any(_mirrors(effect, other) for other in told):
            told.append(effect)
    return told


def _change(reason: Reason, effect: Effect, sentence: Sentence) -> Change:
    second, instead, whose = reason.second, effect.instead, _whose(effect.question)
    return Change(
        f"{whose}{_claim(effect.question, sentence)}",
        effect.before,
        effect.after,
        f"{whose}{_ratio(effect, sentence)}",
        (second.action, second.expected, instead) if second and instead is not None else None,
        (effect.after - effect.before) * effect.log_ratio < 0,
        effect.question.audience,
    )


def _mirrors(one: Effect, other: Effect) -> bool:
    """Whether the event of one is that the other's does not hold."""
    first, second = one.question, other.question
    pairs = zip(first.event, second.event, first.given, strict=True)
    alike = first.given == second.given and first.viewers == second.viewers
    return alike and all(a != b for a, b, holds in pairs if holds)


def _ratio(effect: Effect, sentence: Sentence) -> str:
    """By how much likelier one hypothesis makes what was seen than the other does."""
    claim, rival = _claim(effect.question, sentence), _rival(effect)
    log_ratio, other = effect.log_ratio, OTHERWISE
    if rival is not None:
        log_ratio = rival.log_ratio
        other = f"if {sentence(rival.claims, {})[1]}"
    factor = times(abs(log_ratio))
    if factor < EVEN:
        return f"about as likely if {claim} as {other}"
    likelier = f"{factor:.4g}" if factor < 1000 else f"{factor:,.0f}"
    likelier = f"{likelier} times likelier" if factor < 1e6 else "over a million times likelier"
    if log_ratio > 0:
        return f"{likelier} if {claim} than {other}"
    return f"{likelier} {other} than if {claim}"


def _rival(effect: Effect) -> Against | None:
    """The alternative that is told: the one that viewers believed most, where it stands for all of
    them: it had at least half of their belief, and speaks the same way."""
    first: Sequence[Against] = effect.rivals[:1]
    return next((r for r in first if r.share >= 0.5 and r.log_ratio * effect.log_ratio > 0), None)


def _legend(enumerable: bool) -> tuple[str, ...]:
    """How to read it."""
    likelier = "likelier: under what viewers believed just before"
    if enumerable:
        return (f"{likelier}; `had it been`: of the other actions the one that they expected most",)
    return (
        likelier,
        "no second-best action is told: what moving bodies might have done cannot be listed",
    )
