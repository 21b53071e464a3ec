"""What a story speaks of, read from its objective: the events that viewers shall believe or not,
the latents that they shall wonder about, the characters whose fortune they shall follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from i2pdsl.language import typed as ty
from i2pdsl.language.story import TypedStory
from i2pdsl.language.vocabulary import Value, Vocabulary

Claims = dict[str, tuple[Value, ...]]
"""An event in words of latents: each has one of these values."""


@dataclass(frozen=True)
class Subject:
    """A belief that an objective speaks of, at whatever time.

    Attributes:
        about: an event, a partition by a latent's values, or a character's value.
        given: the conditions and the assumption that it is taken under.
        viewers: whose belief it is; None where there is only one audience.
    """

    about: ty.Mask | ty.Partition | ty.ValueAt
    given: ty.Mask
    viewers: ty.Viewers | None = None


def subjects_of(story: TypedStory) -> tuple[Subject, ...]:
    """The subjects of a story's objective, each once, in the order of its text."""
    found: dict[Subject, None] = {}
    for _, expression in story.objective:
        for node in ty.walk(expression):
            if not isinstance(node, ty.Belief) or len(node.given) > 1:
                continue  # how far beliefs move is no belief
            if isinstance(node.about, tuple | ty.Partition | ty.ValueAt):
                found[Subject(node.about, node.given[0].mask, node.viewers)] = None
    return tuple(found)


def belief_over(form: str, subject: Subject, length: int) -> ty.Belief:
    """A form about a subject, after each of the frames 0..length."""
    given = (ty.Given(ty.Moment((), range(length + 1), 0), subject.given),)
    return ty.Belief(form, subject.about, given, viewers=subject.viewers)


def claims(words: Vocabulary, event: ty.Mask, within: ty.Mask) -> Claims | None:
    """What an event says of latents, of as few as can be; None if it is no conjunction of that.

    Args:
        within: the hypotheses that are possible at all.
    """
    rows = [row for row, holds in zip(words.hypotheses, within, strict=True) if holds]
    truth = [e for e, holds in zip(event, within, strict=True) if holds]

    def fits(found: Claims) -> bool:
        return truth == [all(row.get(x) in vs for x, vs in found.items()) for row in rows]

    found: Claims = {}
    # Who is rational follows from what one wants, and is left out first.
    order = sorted(words.latents, key=lambda name: name not in words.rational.values())
    for name in order:
        chosen = {row.get(name) for row, holds in zip(rows, truth, strict=True) if holds}
        if None not in chosen and any(row.get(name) not in chosen for row in rows):
            found[name] = tuple(v for v in words.latents[name].values if v in chosen)
    if not fits(found):
        return None
    for name in order:
        fewer = {x: vs for x, vs in found.items() if x != name}
        if name in found and fits(fewer):
            found = fewer
    return found


def event_of(words: Vocabulary, found: Claims) -> ty.Mask:
    """The hypotheses in which each latent has one of its values."""
    return tuple(all(row.get(x) in vs for x, vs in found.items()) for row in words.hypotheses)


def latents_of(words: Vocabulary, subject: Subject) -> Sequence[str]:
    """The latents that a subject is about, as far as can be told."""
    about = subject.about
    if isinstance(about, ty.ValueAt):
        return ()
    if isinstance(about, ty.Partition):
        about = tuple(index == 0 for index in about.index)
    return tuple(claims(words, about, subject.given) or ())
