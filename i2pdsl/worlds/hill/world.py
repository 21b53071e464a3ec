"""A hill, its controllers found and ready: the World protocol over worlds/hill/model.py."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from i2pdsl.language import typed as ty
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.planning.networks import Layers
from i2pdsl.worlds.continuous import ContinuousWorld
from i2pdsl.worlds.hill import model
from i2pdsl.worlds.hill.controllers import Controllers, find_controllers, for_weight, scaling
from i2pdsl.worlds.hill.hopper import MUSCLE_COUNT, build_body, initial_state, masses
from i2pdsl.worlds.hill.spec import HillSpec
from i2pdsl.worlds.hill.vocabulary import BOX, HOPPER, hill_vocabulary
from i2pdsl.worlds.record import Trajectory, empty, extended
from i2pdsl.worlds.world import Part, Viewer, forgetting_of, log_priors

Array = Any


@dataclass(frozen=True)
class HillWorld(ContinuousWorld):
    """A hill as the audience, the objectives and the searches see it.

    Attributes:
        spec: the hill as it is; viewers may imagine other controllers.
        tables: the arrays, in NumPy and doubles (model.Tables).
    """

    spec: HillSpec
    tables: model.Tables

    @cached_property
    def vocabulary(self) -> Vocabulary:
        return hill_vocabulary(self.spec)

    # The protocol (worlds/world.py).

    action_shape = (MUSCLE_COUNT,)
    rows_are_scaled = True  # by 1 / sigma^2

    def guesses(
        self, length: int, seeds: int, noise: float, seed: int, state: np.ndarray
    ) -> np.ndarray:
        """Changes of the controller's actuation, normal of the standard deviation `noise`."""
        shape = (seeds, length, *self.action_shape)
        return noise * np.random.default_rng(seed).normal(size=shape)

    def program_key(self, turns: tuple[ty.Turn, ...]) -> tuple[Any, ...]:
        return ()

    def no_action(self, state: Array) -> Array:
        return state[..., :MUSCLE_COUNT] * 0

    def transition(self, tables: model.Tables, state: Array, action: Array) -> Array:
        return model.transition(tables, state, action)

    def log_rows(
        self, tables: model.Tables, state: Array, action: Array, after: Array
    ) -> tuple[Array, ...]:
        return (model.log_likelihood(tables, state, action, after),)

    def best_rows(
        self, tables: model.Tables, state: Array, action: Array, after: Array
    ) -> tuple[Array, ...]:
        """Those of a frame that is just as one imagines it: all alike."""
        xp = state.__array_namespace__()
        return (xp.zeros((*state.shape[:-1], *tables.log_prior.shape), dtype=state.dtype),)

    def outcome(
        self, tables: model.Tables, state: Array, action: Array
    ) -> tuple[Array, tuple[Array, ...], tuple[Array, ...]]:
        after, seen = model.outcome(tables, state, action)
        return after, (seen,), self.best_rows(tables, state, action, after)

    def value(self, tables: model.Tables, who: int, state: Array) -> Array:
        return model.value(tables, state)

    def feature(
        self,
        tables: model.Tables,
        name: str,
        arguments: tuple[Any, ...],
        state: Array,
        before: Array | None = None,
        action: Array | None = None,
    ) -> Array:
        return model.feature(tables, name, arguments, state, before, action)

    def feature_arguments(self, name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
        """The checker's numbers of characters and things as names of groups of nodes."""
        return tuple((HOPPER, BOX)[a] for a in arguments)

    def is_still(self, tables: model.Tables, state: Array, after: Array) -> Array:
        return model.is_still(state, after)

    def stillness(self, tables: model.Tables, state: Array, after: Array) -> Array:
        return model.stillness(state, after)

    def with_audience(self, sharpness: float, forgetting: Array, log_prior: Array) -> HillWorld:
        """Likelihoods are exp(-error / (2 sigma^2))."""
        sigma = self.tables.sigma / np.sqrt(sharpness)
        told = {"sigma": sigma, "forgetting": forgetting, "log_prior": log_prior}
        return replace(self, tables=self.tables._replace(**told))

    def switching(self, tables: model.Tables) -> tuple[None, ...]:
        return (None,)  # nobody here has a goal

    def starts(self, points: Sequence[ty.Point] = (), parts: Sequence[Part] = ()) -> np.ndarray:
        """The initial states, [1, 76]: there is one."""
        return initial_state(self.spec.settings.slope)[None]

    def actuation(self, state: Array, action: Array) -> Array:
        """What the muscles do in a frame, [..., 6]."""
        return model.actuation(self.tables, state, action)


def build_hill(
    spec: HillSpec,
    viewers: tuple[Viewer, ...] | None = None,
    say: Callable[[str], None] | None = None,
) -> HillWorld:
    """Finds the controllers of a hill and of its viewers.

    Raises StoryError where some are not trained.
    """
    viewers = viewers or (Viewer(spec),)
    found: dict[int, Controllers] = {}
    for each in (spec, *(v.spec for v in viewers)):
        number = each.settings.controller
        if number not in found:
            found[number] = find_controllers(each, number, say)
    rows = spec.hypotheses
    driver = found[spec.settings.controller]
    offset, scale = scaling(spec.settings.slope)
    imagined = [found[v.spec.settings.controller] for v in viewers]
    tables = model.Tables(
        body=build_body(spec),
        mass=masses(spec, spec.settings.weight),
        driver=_scaled(
            for_weight(driver.policy, driver.weights, spec.settings.weight),
            spec.share(spec.settings.will),
        ),
        offset=offset,
        scale=scale,
        masses=np.stack([masses(spec, weight) for weight, _ in rows]),
        policies=_for_viewers(
            [
                [
                    _scaled(for_weight(c.policy, c.weights, weight), spec.share(will))
                    for weight, will in rows
                ]
                for c in imagined
            ]
        ),
        values=_for_viewers(
            [[for_weight(c.value, c.weights, weight) for weight, _ in rows] for c in imagined]
        ),
        sigma=np.array([float(v.spec.settings.sigma) / v.sharpness**0.5 for v in viewers]),
        knows=np.array([v.spec.settings.evidence == "mass" for v in viewers]),
        log_prior=log_priors(viewers, hill_vocabulary(spec)),
        forgetting=forgetting_of(viewers, [float(v.spec.settings.forgetting) for v in viewers]),
    )
    return HillWorld(spec, tables)


def _scaled(layers: Layers, share: float) -> Layers:
    """A network whose outputs are so many times as large."""
    *hidden, (matrix, bias) = layers
    return (*hidden, (share * matrix, share * bias))


def _for_viewers(networks: list[list[Layers]]) -> Layers:
    """The networks of each viewer and hypothesis as one."""
    layers = []
    for number in range(len(networks[0][0])):
        matrix, bias = (
            np.stack([np.stack([network[number][part] for network in each]) for each in networks])
            for part in (0, 1)
        )
        layers.append((_shared(matrix), _shared(bias) if number else bias))
    return tuple(layers)


def _shared(arrays: np.ndarray) -> np.ndarray:
    """Arrays of each viewer and hypothesis, [O, H, ...], or [O, 1, ...] where the hypotheses have
    the same."""
    return arrays[:, :1] if (arrays == arrays[:, :1]).all() else arrays


def hill_rollout(world: HillWorld, length: int, noise: float, seed: int) -> Trajectory:
    """A rollout of the hopper's own controller, its actuation changed by chance.

    Args:
        noise: standard deviation of the changes.
    """
    (changes,) = world.guesses(length, 1, noise, seed, world.starts()[0])
    return extended(world, empty(world, world.starts()[0]), changes)
