"""Rollouts of characters who act as viewers think that they do, under hypotheses that are drawn.

A hypothesis is drawn from a viewer's prior. Everybody acts by the policy that this viewer expects
of it, softmax(beta Q), and chance decides by the world's probabilities what succeeds. So these are
draws from the audience's own model of films, and its beliefs about them are calibrated: of films
for which viewers say p, a share of p is so. Where viewers think that goals change (`switching`),
they do.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from i2pdsl.audience.queries import marginal
from i2pdsl.errors import Source, error, whole_file
from i2pdsl.language.query import check_assumption
from i2pdsl.language.story import TypedStory
from i2pdsl.language.vocabulary import UNKNOWN, show_value
from i2pdsl.objective.replay import replay_all
from i2pdsl.objective.rollouts import drawn_from, rollouts
from i2pdsl.objective.starts import allowed_starts
from i2pdsl.scripts import Script, script_of
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import World

AT_ONCE = 1024  # rollouts that go on side by side


@dataclass(frozen=True)
class Confusion:
    """How a latent that was drawn is believed at the end: `counts` [drawn, most believed]."""

    drawn: tuple[str, ...]
    believed: tuple[str, ...]
    counts: np.ndarray

    @property
    def right(self) -> float:
        """The share of scripts after which the true value is the most believed one."""
        hits = sum(
            self.counts[i, self.believed.index(name)]
            for i, name in enumerate(self.drawn)
            if name in self.believed
        )
        return float(hits / self.counts.sum())


@dataclass(frozen=True)
class Samples:
    """Scripts of characters who act under hypotheses, and what was drawn.

    Attributes:
        courses: the number of each script's hypothesis before anything moves and after each frame,
            [N, T + 1].
        observers: the number of the viewer whose expectations it follows, [N].
        assumption: what beliefs are conditioned on, a mask [H].
    """

    scripts: tuple[Script, ...]
    courses: np.ndarray
    observers: np.ndarray
    assumption: np.ndarray

    @property
    def hypotheses(self) -> np.ndarray:
        """The number of each script's hypothesis at the end, [N]."""
        last: np.ndarray = self.courses[:, -1]
        return last

    @property
    def latents(self) -> tuple[str, ...]:
        """Those of which the assumption leaves open what they are."""
        words = self.scripts[0].world.vocabulary
        rows = [row for row, m in zip(words.hypotheses, self.assumption, strict=True) if m]
        return tuple(name for name in words.latents if len({row.get(name) for row in rows}) > 1)

    def drawn(self, latent: str) -> list[str]:
        """The latent's value at the end of each script, `unknown` where it plays no part."""
        rows = self.scripts[0].world.vocabulary.hypotheses
        return [_named(rows[h].get(latent)) for h in self.hypotheses]

    def believed(self, latent: str) -> tuple[tuple[str, ...], np.ndarray]:
        """The latent's values, and the probability of each at the end of each script, [N, V]."""
        rows = self.scripts[0].world.vocabulary.hypotheses
        names = [_named(row.get(latent)) for row in rows]
        kept = [name for name, m in zip(names, self.assumption, strict=True) if m]
        values = self.scripts[0].world.vocabulary.latents[latent].values
        order = tuple(n for n in (*map(show_value, values), UNKNOWN) if n in kept)
        groups = np.array([[name == value for value in order] for name in names], dtype=float)
        viewers = slice(*self.scripts[0].audiences[0].viewers)
        last = np.stack([script.frames.log_belief[-1, viewers] for script in self.scripts])
        return order, marginal(last, groups, self.assumption).mean(1)

    def confusion(self, latent: str) -> Confusion:
        """Its true values against those most believed at the end."""
        believed, probabilities = self.believed(latent)
        drawn = self.drawn(latent)
        names = (*believed, *sorted(set(drawn) - set(believed)))
        counts = np.zeros((len(names), len(believed)), dtype=int)
        np.add.at(counts, ([names.index(d) for d in drawn], probabilities.argmax(-1)), 1)
        kept = [n in drawn for n in names]
        return Confusion(tuple(n for n in names if n in drawn), believed, counts[kept])

    def columns(self) -> dict[str, list[Any]]:
        """A row for each script: its number, the viewer's, and of each latent what was drawn, what
        is most believed at the end, and how probable the truth is then (0 where it is excluded)."""
        found: dict[str, list[Any]] = {
            "script": list(range(len(self.scripts))),
            "observer": self.observers.tolist(),
        }
        for latent in self.latents:
            names, probabilities = self.believed(latent)
            drawn = self.drawn(latent)
            found[latent] = drawn
            found[f"{latent}_believed"] = [names[i] for i in probabilities.argmax(-1)]
            found[f"{latent}_p"] = [
                float(row[names.index(name)]) if name in names else 0.0
                for row, name in zip(probabilities, drawn, strict=True)
            ]
        return found


def sample(
    story: TypedStory,
    world: World,
    count: int,
    seed: int,
    given: str | None = None,
    assume: str | None = None,
) -> Samples:
    """So many rollouts of the story's length, from initial states that it allows.

    Args:
        given: a condition on the hypotheses that are drawn, besides the story's assumption.
        assume: another assumption; 'nothing' drops it.

    Raises StoryError.
    """
    words, where = world.vocabulary, whole_file(story.source.name)
    if not words.enumerable:
        message = f"whoever acts {words.where} does not choose among actions that can be listed"
        raise error("sample", message, where, "`search naive` makes rollouts there")
    usual = story.audiences[:1]
    read = lambda name, text: check_assumption(Source(name, text), words, story.module, usual)
    assumption = story.assumption if assume is None else read("assume", assume)
    mask = np.array(assumption)
    if given is not None:
        mask &= np.array(read("given", given))
    starts = allowed_starts(world, story.start)
    if not len(starts):
        raise error("impossible", "no state fulfils the `start` of the story", where)
    generator = np.random.default_rng(seed)
    viewers = usual[0].viewers
    observers = generator.integers(*viewers, size=count)
    priors = np.where(mask, np.exp(world.log_prior(world.tables)), 0.0)
    if not priors[slice(*viewers)].any(-1).all():
        place = where if given is None else whole_file("given")
        raise error("impossible", "no hypothesis that is thought possible fulfils this", place)
    hypotheses = drawn_from(priors[observers], generator.random(count))
    states = starts[generator.integers(len(starts), size=count)]
    luck = generator.random((count, story.length))
    courses = _courses(world, story.length, observers, hypotheses, generator)
    acting = courses
    if not world.lists_hypotheses:  # where nobody can think that goals change
        acting = world.acting(hypotheses, generator)[:, None].repeat(story.length, axis=1)
    scripts: list[Script] = []
    for first in range(0, count, AT_ONCE):
        some = slice(first, first + AT_ONCE)
        path = rollouts(world, states[some], observers[some], acting[some], luck[some])
        frames = replay_all(world, path.states, path.actions)
        for i, course in enumerate(courses[some, :, 0]):
            about = _about(story, seed, [words.hypotheses[number] for number in course])
            own = Trajectory(path.actions[i], path.states[i])
            seen = frames.at(i)
            scripts.append(script_of(story, world, own, seen, about, None))
    whole = courses[:, :, 0]
    return Samples(tuple(scripts), whole, observers - viewers[0], np.array(assumption))


def _courses(
    world: World,
    length: int,
    observers: np.ndarray,
    hypotheses: np.ndarray,
    generator: np.random.Generator,
) -> np.ndarray:
    """The row of the hypothesis by which each action is chosen, [N, T + 1, U]: [:, t, u] of action
    u in frame t + 1, and [:, T, 0] what holds at the end."""
    switching = world.switching(world.tables)
    found = np.empty((len(hypotheses), length + 1, len(switching)), dtype=int)
    now = hypotheses
    for t in range(length + 1):
        for u, changes in enumerate(switching):
            found[:, t, u] = now
            if changes is None:
                continue
            goes, which = generator.random((2, len(now)))
            group = changes.group == changes.group[now][:, None]
            weights = np.where(group, np.exp(changes.log_prior[observers]), 0.0)
            now = np.where(goes < changes.share[observers], drawn_from(weights, which), now)
    return found


def _about(story: TypedStory, seed: int, course: list[dict[str, Any]]) -> dict[str, Any]:
    """What a script's file says of where it came from; `course` is what holds after each frame."""
    source = story.source
    about = {"name": story.name, "file": source.name, "source": source.text, "seed": seed}
    changes = [
        {"frame": t, "drawn": after}
        for t, (before, after) in enumerate(pairwise(course), 1)
        if after != before
    ]
    return {**about, "drawn": course[0], **({"changes": changes} if changes else {})}


def _named(value: Any) -> str:
    return UNKNOWN if value is None else show_value(value)
