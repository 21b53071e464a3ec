"""A simulated panel: viewers who differ, what they believe of films, and what they answer.

What they believe is computed by the audience's own filter in their own world: nothing is
approximated (tests/study/ hold it against `i2pdsl.query`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from i2pdsl.fit.odds import log_odds, logistic
from i2pdsl.language.people import Person, known_settings, read_people, weighed
from i2pdsl.language.vocabulary import Vocabulary, show_value
from i2pdsl.objective.replay import replay_all
from i2pdsl.study.check import Ground
from i2pdsl.study.spec import (
    EVEN,
    MATCHING,
    MAXIMUM,
    WORLD,
    Between,
    Drawn,
    Panel,
    Study,
)
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.ready import ready_world
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import Viewer as Observer

USUAL: dict[str, float | str] = {
    "sharpness": 1.0,
    "doubt": 0.0,
    "rule": MAXIMUM,
    "prior": WORLD,
    "confidence": 0.0,
    "lapse": 0.0,
    "noise": 1.0,
}
FORGETTING = "forgetting"
Weights = Mapping[str, Mapping[str, float]]  # latent -> value -> weight
SUREST = 1e-9  # nobody is surer than that


@dataclass(frozen=True)
class Viewer:
    """One viewer of a panel.

    Attributes:
        sharpness: how much more strongly than in the world's file characters seem to prefer what
            is best for them.
        forgetting: the share of belief reassigned after each observation; None: the world's.
        weights: latent -> value -> weight; they multiply the world's prior.
        even: whether the answers were equally likely to him beforehand.
        settings: of the world as he imagines it.
        matching, confidence, lapse, noise: how he answers (`chances`, `positions`).
    """

    sharpness: float
    forgetting: float | None
    weights: Weights = field(hash=False)
    even: bool
    settings: tuple[tuple[str, float | str], ...]
    matching: bool
    confidence: float
    lapse: float
    noise: float


def viewers_of(panel: Panel, worlds: Sequence[Vocabulary]) -> tuple[Viewer, ...]:
    """The viewers of a panel: each drawn by a generator of his own, so that more viewers leave the
    first as they are."""
    people: tuple[Person, ...] = () if panel.people is None else read_people(panel.people)
    found = []
    for number in range(panel.viewers):
        generator = np.random.default_rng([panel.seed, number])
        # One for each parameter, given or not: what is given does not change the others.
        shares = dict(zip((*USUAL, FORGETTING), generator.random(len(USUAL) + 1), strict=True))
        told = USUAL | {name: _drawn(shares[name], drawn) for name, drawn in panel.drawn.items()}
        weights: Weights = _doubted(generator, float(told["doubt"]), worlds)
        settings = [(n, _drawn(generator.random(), drawn)) for n, drawn in panel.settings.items()]
        if people:
            person = people[number % len(people)]
            told |= {"sharpness": person.sharpness, FORGETTING: person.forgetting}
            weights, settings = person.prior, list(person.settings.items())
        forgetting = told.get(FORGETTING)
        found.append(
            Viewer(
                float(told["sharpness"]),
                None if forgetting is None else float(forgetting),
                weights,
                told["prior"] == EVEN,
                tuple(settings),
                told["rule"] == MATCHING,
                float(told["confidence"]),
                float(told["lapse"]),
                float(told["noise"]),
            )
        )
    return tuple(found)


def _drawn(share: float, drawn: Drawn) -> float | str:
    """What a uniform random number comes to."""
    if isinstance(drawn, Between):
        ends = np.array([drawn.low, drawn.high])
        low, high = np.log(ends) if drawn.in_logs else ends
        value = float(low + share * (high - low))
        return float(np.exp(value)) if drawn.in_logs else value
    return drawn.values[int(share * len(drawn.values))]


def _doubted(generator: np.random.Generator, doubt: float, worlds: Sequence[Vocabulary]) -> Weights:
    """A weight for each value of each latent, normal in logs: `doubt` is the standard deviation."""
    names = {
        (name, show_value(value)): None
        for words in worlds
        for name, latent in words.latents.items()
        for value in latent.values
    }
    found: dict[str, dict[str, float]] = {}
    for (name, value), amount in zip(names, generator.normal(size=len(names)), strict=True):
        found.setdefault(name, {})[value] = float(np.exp(doubt * amount))
    return found


def beliefs(
    study: Study,
    viewers: Sequence[Viewer],
    ground: Ground,
    paths: Sequence[Trajectory],
    watch: Watch,
) -> np.ndarray:
    """P(event) of each viewer at each film and event, [V, N, E]: after the film, or on average
    over its frames (`when = throughout`). All films have the same length.

    Viewers who imagine the world in the same way share its plan. Raises StoryError.
    """
    states, actions = (np.stack([getattr(p, n) for p in paths]) for n in ("states", "actions"))
    events, assumed = np.array(ground.masks, float), np.array(ground.assumed, float)
    found = np.zeros((len(viewers), len(paths), len(events)))
    alike: dict[tuple[tuple[str, float | str], ...], list[int]] = {}
    words = ground.vocabulary
    for number, viewer in enumerate(viewers):
        alike.setdefault(known_settings(words, viewer.settings), []).append(number)
    for settings, numbers in alike.items():
        spec = ground.spec.with_settings(dict(settings))
        world = ready_world(ground.spec, (Observer(spec),), watch)
        rows = None
        if world.rows_are_scaled:  # bodies are simulated once, not once for each viewer
            rows = replay_all(world, states, actions, regret=False).log_rows[:, 1:]
        for number in numbers:
            viewer = viewers[number]
            forgetting = world.forgetting(world.tables)
            if viewer.forgetting is not None:
                forgetting = np.full_like(forgetting, viewer.forgetting)
            prior = np.log(prior_of(viewer, ground))[None]
            his = world.with_audience(viewer.sharpness, forgetting, prior)
            seen = None
            if rows is not None:
                seen = tuple(viewer.sharpness * np.moveaxis(rows, 2, 0))
            belief = replay_all(his, states, actions, seen, regret=False).log_belief[:, :, 0]
            belief = belief[:, 1:] if study.question.throughout else belief[:, -1:]
            held = np.exp(belief) * assumed  # [N, T, H]
            share = held @ events.T / held.sum(-1, keepdims=True)
            found[number] = share.mean(1)
    return found


def prior_of(viewer: Viewer, ground: Ground) -> np.ndarray:
    """P(H) before anything moved, [H]."""
    words = ground.vocabulary
    prior = np.array(words.prior or (1.0,) * len(words.hypotheses))
    if viewer.even:
        prior = _evened(prior, ground)
    weights: np.ndarray = np.maximum(prior * weighed(words, viewer.weights), 1e-300)
    return weights / weights.sum()


def _evened(prior: np.ndarray, ground: Ground) -> np.ndarray:
    """A prior with equally likely answers: the events together stay as likely as they are, or if
    there is one, as likely as not; what is impossible stays so."""
    masks = np.array(ground.masks, bool)
    if len(masks) == 1:
        masks = np.concatenate([masks, ~masks])
    mass = masks @ prior
    evened = prior.copy()
    for mask, own in zip(masks, mass, strict=True):
        evened[mask] *= mass.mean() / own if own > 0 else 1.0
    return evened


# Answers.


def chances(study: Study, viewer: Viewer, believed: np.ndarray) -> np.ndarray:
    """P(answer) of a viewer who believes the answers' events with `believed` [N, E]: [N, A].

    `maximum`: what he believes most, if he believes it with his `confidence`, else the answer that
    has no event. `matching`: each with the probability that he believes it with, as one who draws
    a single sample from his posterior (Vul et al. 2014, DOI 10.1111/cogs.12101), and what is left
    goes to the answer that has no event. With the probability `lapse` any answer.
    """
    sure = np.array([bool(answer.event) for answer in study.answers])
    found = np.zeros((len(believed), len(sure)))
    if viewer.matching:
        found[:, sure] = believed / np.maximum(believed.sum(1, keepdims=True), 1)
        is_sure = np.full(len(believed), True)
    else:
        most = believed.max(1)
        found[:, sure] = np.isclose(believed, most[:, None], rtol=0, atol=1e-12)
        found[:, sure] /= found[:, sure].sum(1, keepdims=True)
        is_sure = most >= viewer.confidence
    if not sure.all():
        found[~is_sure] = 0.0
        found[:, ~sure] = (1 - found.sum(1, keepdims=True)) / (~sure).sum()
    found /= found.sum(1, keepdims=True)
    return (1 - viewer.lapse) * found + viewer.lapse / len(sure)


def first_chosen(viewer: Viewer, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """P(the first film of a pair is chosen), [N]: the difference of the log odds, with logistic
    noise of the scale `noise` (Luce 1959: with 1 it is probability matching)."""
    difference = log_odds(first, SUREST) - log_odds(second, SUREST)
    if viewer.noise > 0:
        chosen: np.ndarray = logistic(difference / viewer.noise)
    else:
        chosen = 0.5 * (1 + np.sign(difference))
    return (1 - viewer.lapse) * chosen + viewer.lapse / 2


def positions(viewer: Viewer, believed: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Where he puts a slider from 0 to 100, [N]: the log odds with logistic noise; with the
    probability `lapse` anywhere. `shares` [N, 2] are uniform random numbers."""
    lapsed = shares[:, 0] < viewer.lapse
    odds = log_odds(believed, SUREST) + viewer.noise * log_odds(shares[:, 1], SUREST)
    placed: np.ndarray = np.round(100 * np.where(lapsed, shares[:, 1], logistic(odds)))
    return placed
