"""Why viewers believe it, in words: explain.py's numbers as sentences."""

from __future__ import annotations

from collections.abc import Sequence

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
from i2pdsl.render.pictures import drawing_for
from i2pdsl.scripts import Script

MOVED = 0.001  # of a probability: less is not told
EVEN = 1.05  # ratios closer to 1 are told as such
OTHERWISE = "otherwise"


def reasons_in_words(script: Script, frame: int | None = None) -> str:
    """What moved viewers' beliefs in a script: of a whole script the greatest change that each
    observation made, of one frame (1..T) all of them."""
    questions = questions_of(script)
    if not questions:
        return "viewers have nothing to find out"
    drawing, words = drawing_for(script.world.spec), script.world.vocabulary
    sentence, deeds = drawing.sentence(script.world.spec), drawing.deeds(script)
    lines = ["what viewers are asked, and believe at the start and at the end:"]
    lines += [_asked(script, question, sentence) for question in questions]
    told = 0
    for reason in explain(script, questions, frame):
        span = f"frame {reason.first}"
        if reason.first != reason.last:
            span = f"frames {reason.first} to {reason.last}"
        if reason.first != told:
            lines += ["", span]
        told, deed = reason.first, deeds[reason.first - 1]
        if reason.who is None and words.enumerable:
            seen = ", ".join(deed.values()) or "an event"
            lines.append(f"  {seen}: nobody's deed, from which viewers learn nothing")
            continue
        effects = _effects(reason, sentence, frame is not None)
        said = "what is seen"
        if reason.who is not None and reason.taken is not None:
            said = deed.get(reason.who, f"{reason.who} {reason.taken.action}")
            said += f" (expected with {short(reason.taken.expected)})"
        lines.append(f"  {said}{':' if effects else ' changes next to nothing of this'}")
        lines += effects
    return "\n".join((*lines, "", *_legend(words.enumerable)))


def short(p: float) -> str:
    """A probability that need not be read to the last digit."""
    return f"{p:.4g}"


def _asked(script: Script, question: Question, sentence: Sentence) -> str:
    believed = course(script, question)
    words = script.world.vocabulary
    parts = [as_story(words, found) for found in (question.claims, question.condition) if found]
    formal = f" [{' | '.join(parts)}]" if question.claims else ""
    ends = f"{number(believed[0])} -> {number(believed[-1])}"
    return f"  {_whose(question)}{_claim(question, sentence)}{formal}: {ends}"


def _whose(question: Question) -> str:
    """The name of the audience that is asked, where it has one of its own."""
    return "" if question.audience == VIEWERS else f"{question.audience}: "


def _claim(question: Question, sentence: Sentence) -> str:
    """A question's event in words."""
    if question.claims is None or question.condition is None:
        return "what the story asks about holds"
    return sentence(question.claims, question.condition)[1]


def _effects(reason: Reason, sentence: Sentence, all_of_them: bool) -> list[str]:
    """The changes worth telling, greatest first; of two that mirror each other the rise."""
    effects = [e for e in reason.effects if abs(e.after - e.before) >= MOVED]
    effects.sort(key=lambda e: (-round(abs(e.after - e.before), 9), e.after < e.before))
    told: list[Effect] = []
    for effect in effects:
        if not any(_mirrors(effect, other) for other in told):
            told.append(effect)
    if not all_of_them:  # the greatest of each audience
        told = list({e.question.audience: e for e in reversed(told)}.values())[::-1]
    lines = []
    for effect in told:
        whose = _whose(effect.question)
        lines.append(f"    {whose}{_ratio(effect, sentence)}")
        change = f"{number(effect.before)} -> {number(effect.after)}"
        instead = ""
        if (effect.after - effect.before) * effect.log_ratio < 0:
            instead = ", since they forget faster than that tells them"
        if effect.instead is not None and reason.second is not None:
            expected = f"expected with {short(reason.second.expected)}"
            instead = (
                f"; had it been `{reason.second.action}` ({expected}): {number(effect.instead)}"
            )
        lines.append(f"    {whose}{_claim(effect.question, sentence)}: {change}{instead}")
    return lines


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


def _legend(enumerable: bool) -> list[str]:
    """How to read it."""
    likelier = "likelier: under what viewers believed just before"
    if enumerable:
        return [f"{likelier}; `had it been`: of the other actions the one that they expected most"]
    return [
        likelier,
        "no second-best action is told: what moving bodies might have done cannot be listed",
    ]
