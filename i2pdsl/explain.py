"""Why viewers believe what they believe: which observations moved which belief, by how much,
against which alternative, and what they would believe had something else been done.

What is computed of one observation a, and a question about an event E under a condition C, with the
belief just before it: log P(a | E, C) - log P(a | not E, C), each a mixture of the hypotheses under
that belief. Without forgetting that is what the log-odds of E move by (Bayes' rule); forgetting
comes on top. Of several viewers it is the mean. Everything is in nats, NumPy and doubles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from i2pdsl.audience.filter import log_sum
from i2pdsl.audience.queries import probability
from i2pdsl.language import typed as ty
from i2pdsl.language.story import VIEWERS
from i2pdsl.language.vocabulary import Value, Vocabulary, show_value
from i2pdsl.objective.subjects import Claims, claims, event_of, latents_of
from i2pdsl.scripts import Script

WINDOWS = 12  # that a script of moving bodies is told in, at most
NONE: Claims = {}


@dataclass(frozen=True)
class Rival:
    """What viewers may believe instead of an event: another group of a latent's values."""

    claims: Claims
    mask: ty.Mask


@dataclass(frozen=True)
class Question:
    """A belief that is explained.

    Attributes:
        event, given: masks over hypotheses, the second with the script's assumption.
        claims, condition: the same in words of latents; None where there are none.
        rivals: what the event's latent may be instead; empty where it speaks of several.
        viewers: whose belief it is, and `audience` its name; None where there is only one.
    """

    event: ty.Mask
    given: ty.Mask
    claims: Claims | None
    condition: Claims | None
    rivals: tuple[Rival, ...] = ()
    viewers: ty.Viewers | None = None
    audience: str = VIEWERS

    def of(self, observed: np.ndarray) -> np.ndarray:
        """Of something about each observer, [..., O, H], what is about those who are asked."""
        return observed if self.viewers is None else observed[..., slice(*self.viewers), :]


@dataclass(frozen=True)
class Against:
    """A rival, how much of the belief in `not event` it had before, and by how much likelier the
    event makes what was seen than it does, in nats."""

    claims: Claims
    share: float
    log_ratio: float


@dataclass(frozen=True)
class Effect:
    """What an observation did to the answer of a question.

    Attributes:
        before, after: the probability of the event just before and just after it.
        log_ratio: log P(observation | event) - log P(observation | not event).
        rivals: the same against each alternative that was thinkable, most believed first.
        instead: the probability had the other action been taken; None where none can be listed.
    """

    question: Question
    before: float
    after: float
    log_ratio: float
    rivals: tuple[Against, ...] = ()
    instead: float | None = None


@dataclass(frozen=True)
class Choice:
    """An action, and the probability with which viewers expected it, under the assumption."""

    action: str
    expected: float


@dataclass(frozen=True)
class Reason:
    """One observation: an action, or the motion of some frames.

    Attributes:
        first, last: its frames, from 1 on.
        who, taken: the character and its action; None for motion, and for events.
        second: of the other actions the one that viewers expected most; None as `taken`.
        effects: one for each question; empty for an event, which nobody learns from.
    """

    first: int
    last: int
    who: str | None
    taken: Choice | None
    second: Choice | None
    effects: tuple[Effect, ...]


def questions_of(script: Script) -> tuple[Question, ...]:
    """The events that the script's story asks viewers to believe or not; where there are none, the
    values of the latents that it speaks of, or else of all."""
    words = script.world.vocabulary
    found: dict[tuple[ty.Mask, ty.Mask, ty.Viewers | None], None] = {
        (s.about, s.given, s.viewers): None
        for s in script.subjects
        if isinstance(s.about, tuple)
        and _is_open(s.about, script.audience_of(s.viewers).open_to(s.given))
    }
    if not found:
        usual = script.audiences[0].viewers if len(script.audiences) > 1 else None
        named = [x for s in script.subjects for x in latents_of(words, s)]
        for latent in dict.fromkeys(named or words.apart):
            for values in groups(words, latent):
                event = event_of(words, {latent: values})
                if _is_open(event, script.assumption):
                    found[event, script.assumption, usual] = None
    return tuple(_question(script, *asked) for asked in found)


def explain(
    script: Script, questions: Sequence[Question], frame: int | None = None
) -> tuple[Reason, ...]:
    """The reasons of a script, or those of one of its frames 1..T."""
    if script.world.vocabulary.enumerable:
        frames = range(1, script.length + 1) if frame is None else [frame]
        return tuple(reason for t in frames for reason in _actions(script, questions, t))
    spans = windows(script.length) if frame is None else [(frame, frame)]
    return tuple(_motion(script, questions, first, last) for first, last in spans)


def groups(words: Vocabulary, latent: str) -> list[tuple[Value, ...]]:
    """The values of a latent, those of numbers of both signs by their signs."""
    values = words.latents[latent].values
    signs = [(v > 0) - (v < 0) for v in values if isinstance(v, float)]
    if words.latents[latent].kind != "number" or not {-1, 1} <= set(signs):
        return [(value,) for value in values]
    return [
        tuple(v for v, s in zip(values, signs, strict=True) if s == sign)
        for sign in sorted(set(signs))
    ]


def windows(length: int) -> list[tuple[int, int]]:
    """The frames 1..length in at most WINDOWS stretches of about one length."""
    ends = np.unique(np.linspace(0, length, min(length, WINDOWS) + 1).round().astype(int))
    return [(int(a) + 1, int(b)) for a, b in pairwise(ends)]


def as_story(words: Vocabulary, found: Claims) -> str:
    """Claims as the language has them, such as `rho > 0 and G_cheese = pink`."""
    parts = [_as_story(words, latent, values) for latent, values in found.items()]
    return " and ".join(f"({p})" if " or " in p and len(parts) > 1 else p for p in parts)


def _as_story(words: Vocabulary, latent: str, values: tuple[Value, ...]) -> str:
    if words.latents[latent].kind == "truth":
        return latent if values == (True,) else f"not {latent}"
    by_sign = groups(words, latent)
    if len(by_sign) < len(words.latents[latent].values) and values in by_sign:
        return f"{latent} {'<=>'[1 + int(np.sign(float(values[0])))]} 0"
    return " or ".join(f"{latent} = {show_value(value)}" for value in values)


def _is_open(event: ty.Mask, given: ty.Mask) -> bool:
    """Whether there is anything to find out."""
    return len({e for e, g in zip(event, given, strict=True) if g}) == 2


def _question(
    script: Script, event: ty.Mask, given: ty.Mask, viewers: ty.Viewers | None
) -> Question:
    words = script.world.vocabulary
    told, condition = claims(words, event, given), claims(words, given, script.assumption)
    rivals = []
    if told is not None and len(told) == 1:
        ((latent, values),) = told.items()
        for group in groups(words, latent):
            rest: Claims = {latent: tuple(v for v in group if v not in values)}
            mask = event_of(words, rest)
            if any(m and g for m, g in zip(mask, given, strict=True)):
                rivals.append(Rival(rest, mask))
    audience = script.audience_of(viewers).name
    return Question(event, given, told or None, condition, tuple(rivals), viewers, audience)


# --------------------------------------------------------------------------------------- in numbers


def _actions(script: Script, questions: Sequence[Question], t: int) -> list[Reason]:
    """The reasons of one frame in which everybody's action can be listed."""
    world, frames = script.world, script.frames
    action = int(script.trajectory.actions[t - 1])
    if not world.is_observed(np.asarray(action)):
        return [Reason(t, t, None, None, None, ())]
    words, assumed = world.vocabulary, np.array(script.assumption)
    seen_by = slice(*script.audiences[0].viewers)
    branches = _branches(script, action)
    policies = _policies(script, t, branches)
    place = (frames.before[t], np.asarray(action), frames.state[t])
    done = world.log_rows(world.tables, *place)
    now = frames.at(t - 1).belief.shown(world.holdings(world.tables))
    found = []
    for u, who in enumerate(words.characters):
        belief, row, after = (
            frames.log_expecting[t, u],
            frames.log_rows[t, u],
            frames.log_afterwards[t, u],
        )
        taken = world.branch_actions(u)[branches[u]]
        policy = now.likely(world, world.tables, u, policies[u])
        predicted = log_sum(belief + policy, assumed) - log_sum(belief, assumed)
        expected = np.exp(predicted[..., seen_by]).mean(-1)
        others = [a for a in range(len(policy)) if a != taken]
        second = max(others, key=lambda a: float(expected[a]))
        changed = now.seeing(world, world.tables, u, policies[u][second]).log
        now = now.seeing(world, world.tables, u, done[u])
        effects = [
            _effect(question, belief[None], row[None], after, changed) for question in questions
        ]
        names = words.actions_of(who)
        own, other = (Choice(names[a], float(expected[a])) for a in (taken, second))
        found.append(Reason(t, t, who, own, other, tuple(effects)))
    return found


def _branches(script: Script, action: int) -> tuple[int, ...]:
    """The branch of each character in `World.turns` that a joint turn is made of."""
    world = script.world
    counts = [len(world.branch_actions(u)) for u in range(len(world.vocabulary.characters))]
    return tuple(int(n) for n in np.unravel_index(action, counts))


def _policies(script: Script, t: int, branches: tuple[int, ...]) -> list[np.ndarray]:
    """For each character log P(action | H) where it acts in frame t, [A, O, H], or of problems
    (World.lists_hypotheses)."""
    world, found = script.world, []
    turns = world.turns(world.tables, script.frames.before[t])
    for u, rows in enumerate(turns.log_rows):  # [n_1, ..., O, H], or 1 for what does not matter
        numbers = world.branch_actions(u)
        # Who acts later answers what the others have done, unless all act at the same time.
        chosen = [min(b, size - 1) for b, size in zip(branches, rows.shape, strict=False)]
        own = rows[tuple(slice(None) if i == u else b for i, b in enumerate(chosen))]
        found.append(np.stack([own[numbers.index(a)] for a in range(max(numbers) + 1)]))
    return found


def _motion(script: Script, questions: Sequence[Question], first: int, last: int) -> Reason:
    """What was seen in frames first..last, as one observation."""
    frames, span = script.frames, slice(first, last + 1)
    shape = (-1, *frames.log_belief.shape[1:])
    beliefs, rows = frames.log_expecting[span].reshape(shape), frames.log_rows[span].reshape(shape)
    effects = [_effect(q, beliefs, rows, frames.log_belief[last]) for q in questions]
    return Reason(first, last, None, None, None, tuple(effects))


def _effect(
    question: Question,
    beliefs: np.ndarray,
    rows: np.ndarray,
    after: np.ndarray,
    instead: np.ndarray | None = None,
) -> Effect:
    """What observations that follow each other did to the answer of a question.

    Args:
        beliefs, rows: log P(H) just before each, and its log P(observation | H), [U, O, H].
        after, instead: log P(H) after the last of them, and after another one, [O, H].
    """
    event, given = np.array(question.event), np.array(question.given)
    against = ~event & given
    beliefs, rows, after = map(question.of, (beliefs, np.broadcast_to(rows, beliefs.shape), after))

    def ratio(mask: np.ndarray) -> float:
        with np.errstate(invalid="ignore"):
            each = _likelihood(beliefs, rows, event & given) - _likelihood(beliefs, rows, mask)
        return float(each.sum(0).mean())

    rivals = []
    for rival in question.rivals:
        mask = np.array(rival.mask) & given
        share = float(probability(beliefs[0], mask, against))
        if share > 0:
            rivals.append(Against(rival.claims, share, ratio(mask)))
    return Effect(
        question,
        float(probability(beliefs[0], event, given)),
        float(probability(after, event, given)),
        ratio(against),
        tuple(sorted(rivals, key=lambda r: -r.share)),
        None if instead is None else float(probability(question.of(instead), event, given)),
    )


def _likelihood(beliefs: np.ndarray, rows: np.ndarray, mask: np.ndarray) -> Any:
    """log P(observation | mask) under the belief just before it, [U, O]."""
    return log_sum(beliefs + rows, mask) - log_sum(beliefs, mask)


# ------------------------------------------------------------------------------------------ as data


def document(script: Script, frame: int | None = None) -> dict[str, Any]:
    """Plain data: the questions with their courses 0..T, and the observations in order."""
    words, questions = script.world.vocabulary, questions_of(script)
    return {
        "questions": [
            {
                "event": _told(words, question.claims),
                "given": _told(words, question.condition),
                "audience": question.audience,
                "course": course(script, question).tolist(),
            }
            for question in questions
        ],
        "reasons": [_as_json(words, reason) for reason in explain(script, questions, frame)],
        **({"trust": script.trust.as_json()} if script.trust is not None else {}),
    }


def course(script: Script, question: Question) -> np.ndarray:
    """The probability of a question's event after each of the frames 0..T."""
    event, given = np.array(question.event), np.array(question.given)
    return np.asarray(probability(question.of(script.frames.log_belief), event, given))


def _as_json(words: Vocabulary, reason: Reason) -> dict[str, Any]:
    return {
        "first": reason.first,
        "last": reason.last,
        "who": reason.who,
        "action": reason.taken and reason.taken.action,
        "expected": reason.taken and reason.taken.expected,
        "instead": reason.second and reason.second.action,
        "instead_expected": reason.second and reason.second.expected,
        "effects": [_effect_as_json(words, effect) for effect in reason.effects],
    }


def _effect_as_json(words: Vocabulary, effect: Effect) -> dict[str, Any]:
    return {
        "event": _told(words, effect.question.claims),
        "given": _told(words, effect.question.condition),
        "audience": effect.question.audience,
        "before": effect.before,
        "after": effect.after,
        "log_ratio": effect.log_ratio,
        "ratio": times(effect.log_ratio),
        "against": [
            {
                "event": as_story(words, rival.claims),
                "share": rival.share,
                "log_ratio": rival.log_ratio,
                "ratio": times(rival.log_ratio),
            }
            for rival in effect.rivals
        ],
        "instead": effect.instead,
    }


def _told(words: Vocabulary, found: Claims | None) -> str | None:
    return as_story(words, found) if found else None


def times(log_ratio: float) -> float:
    """A ratio from its logarithm; infinite where it is too large for a number."""
    return math.exp(log_ratio) if log_ratio < 700 else math.inf
