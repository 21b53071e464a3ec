"""From what a kind says of its states to the tables of a listed world."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.language.vocabulary import STAY, Vocabulary
from i2pdsl.worlds.listed.words import ListedSpec
from i2pdsl.worlds.listed.world import ListedTables, ListedWorld, log_softmax
from i2pdsl.worlds.world import Viewer, forgetting_of, log_priors, switching_of

if TYPE_CHECKING:
    from i2pdsl.worlds.listed.kind import ListedKind, Picture


MOST = 10_000_000  # numbers that a kind is asked for, one by one: half a minute


def build_listed(kind: ListedKind[Any], spec: ListedSpec, viewers: Sequence[Viewer]) -> ListedWorld:
    """A world ready for its viewers. Raises StoryError where it has too many states."""
    words = kind.vocabulary(spec)
    pictures = _listed(kind, spec, words)
    after = tuple(_after(kind, spec, words, who, pictures) for who in words.characters)
    cells = sorted(words.free, key=lambda cell: cell[::-1])
    numbers = {cell: number for number, cell in enumerate(cells)}
    minds = {viewer.spec: _minds(kind, viewer.spec, pictures) for viewer in viewers}
    log_policy, value = [], []
    for who in range(len(after)):
        likes, worth = zip(*(minds[viewer.spec][who] for viewer in viewers), strict=True)
        sharp = [viewer.sharpness * viewer.spec.settings.beta for viewer in viewers]
        rows = [log_softmax(beta * each) for beta, each in zip(sharp, likes, strict=True)]
        log_policy.append(np.stack(rows, axis=2))
        value.append(np.stack(worth, axis=1))
    log_prior = log_priors(viewers, words)
    tables = ListedTables(
        coordinates=np.array(cells),
        cells=np.array([[numbers[cell] for cell in picture] for picture in pictures]),
        after=after,
        log_policy=tuple(log_policy),
        value=tuple(value),
        log_prior=log_prior,
        forgetting=forgetting_of(viewers, [v.spec.settings.forgetting for v in viewers]),
        switching=switching_of(viewers, words, log_prior),
    )
    begins = np.array([kind.begins(spec, picture) for picture in pictures])
    return kind.world()(spec, words, tables, begins)


def _listed(kind: ListedKind[Any], spec: ListedSpec, words: Vocabulary) -> list[Picture]:
    """All states, if they are few enough."""
    actions = sum(len(words.actions_of(who)) + 1 for who in words.characters)
    most = MOST // (actions * len(words.hypotheses))
    pictures = list(islice(kind.states(spec), most + 1))
    if len(pictures) > most:
        message = (
            f"world {spec.name} has more than {most:,} states; with {actions:,} actions and values "
            f"and {len(words.hypotheses):,} hypotheses no more are listed"
        )
        hint = "fewer cells, characters or hypotheses"
        raise error("too-large", message, whole_file(spec.name), hint)
    return pictures


def _after(
    kind: ListedKind[Any],
    spec: ListedSpec,
    words: Vocabulary,
    who: str,
    pictures: Sequence[Picture],
) -> np.ndarray:
    """The states that the actions of a character lead to, [S, A]."""
    numbers = {picture: number for number, picture in enumerate(pictures)}
    if len(numbers) < len(pictures):
        raise ValueError("two states look alike")
    actions = words.actions_of(who)
    ends = [[kind.step(spec, picture, who, a) for a in actions] for picture in pictures]
    unknown = {end for row in ends for end in row} - set(numbers)
    if unknown:
        raise ValueError(f"{who} can come to {unknown.pop()}, which is no state")
    after = np.array([[numbers[end] for end in row] for row in ends])
    # Searches rely on it: what can be had in n frames can be had in more.
    if STAY not in actions or (after[:, actions.index(STAY)] != np.arange(len(after))).any():
        raise ValueError(f"{who} must have the action `{STAY}`, which changes nothing")
    return after


def _minds(
    kind: ListedKind[Any], spec: ListedSpec, pictures: Sequence[Picture]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Of each character how much it likes its actions, [S, A, H], and states, [S, H]."""
    words = kind.vocabulary(spec)
    rows, found = words.hypotheses, []
    for who in words.characters:
        actions = words.actions_of(who)
        likes = [
            [[kind.likes(spec, row, picture, who, a) for row in rows] for a in actions]
            for picture in pictures
        ]
        worth = [[kind.worth(spec, row, picture, who) for row in rows] for picture in pictures]
        found.append((np.array(likes, dtype=float), np.array(worth, dtype=float)))
    return found
