"""Training the controllers of a hill (`i2p train hill`): progress, checkpoints, the best kept."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.errors import StoryError, error, whole_file
from i2pdsl.planning import store
from i2pdsl.planning.actor_critic import Environment, Recipe, Training, begin, improve_often
from i2pdsl.planning.networks import Layers, apply_network
from i2pdsl.programs import FOR_HOURS
from i2pdsl.resources import cache_folder
from i2pdsl.worlds.hill import springs
from i2pdsl.worlds.hill.controllers import (
    VALUE_SCALE,
    Controllers,
    file_name,
    find_controllers,
    save_controllers,
    scaling,
    training_command,
    weight_input,
)
from i2pdsl.worlds.hill.hopper import BOX, MUSCLE_COUNT, build_body, initial_state, masses
from i2pdsl.worlds.hill.spec import HillSpec

Array = Any

POWER_CHARGE = 9 / 100  # without it light and heavy boxes go up equally fast (model.md)
CHUNK = 100  # iterations between two looks at how well the policy does
ROLLOUTS, FRAMES = 64, 800  # of a look, as many for each weight as it divides into
LOOK_NOISE = 0.2
FALL_PENALTY = 3.0
Report = Callable[[int, int, dict[str, float]], None]


class Look(NamedTuple):
    """How well a policy does over noisy rollouts.

    Attributes:
        reward: mean per frame.
        falls: share of the rollouts in which the hopper falls.
        climbs: mean ascent of the box for each weight, [W].
    """

    reward: float
    falls: float
    climbs: tuple[float, ...]

    @property
    def merit(self) -> float:
        """What checkpoints are compared by."""
        return self.reward - FALL_PENALTY * self.falls * abs(self.reward)


@dataclass(frozen=True)
class Trained:
    """What a training came to, and where it is stored (None where better ones are kept).

    `finished` is false where it was interrupted: the best so far is kept.
    """

    controllers: Controllers
    path: Path | None
    finished: bool
    seconds: float
    look: Look


def hill_environment(
    spec: HillSpec, weights: tuple[float, ...], count: int
) -> tuple[Environment, np.ndarray]:
    """The hill as the actor-critic sees it; rollout i has the weight of index [i], returned too."""
    body = jax.tree.map(_single, build_body(spec))
    index = np.arange(count) * len(weights) // count
    mass = _single(np.stack([masses(spec, weights[i]) for i in index], axis=1))
    known = _single(np.array([weight_input(weights, weights[i]) for i in index]))
    offset, scale = (_single(a)[:, None] for a in scaling(spec.settings.slope))

    def observe(motion: springs.Motion) -> Array:
        seen = (springs.observation(body, motion) - offset) / scale
        return jnp.concatenate([seen, known[None]])

    def reset(rollouts: int) -> springs.Motion:
        start = _single(initial_state(spec.settings.slope))
        return springs.motion_of(jnp.broadcast_to(start, (rollouts, len(start))))

    def step(motion: springs.Motion, action: Array) -> tuple[springs.Motion, Array, Array]:
        motion, power = springs.step(body, mass, motion, action)
        paid = springs.reward(body, mass, motion, action, power, POWER_CHARGE)
        # A motion that is not finite is over too: no comparison with NaN is true.
        up = springs.head_height(body, motion.position) >= springs.HEAD_FALLEN
        return motion, paid, ~up

    return Environment(reset, observe, step, MUSCLE_COUNT), index


def _single(array: np.ndarray) -> Array:
    return jnp.asarray(array, jnp.float32)


def looker(spec: HillSpec, weights: tuple[float, ...]) -> Callable[[Layers, int, float], Look]:
    """A function (policy, seed, noise) -> Look."""
    environment, index = hill_environment(spec, weights, ROLLOUTS)
    start = environment.reset(ROLLOUTS)

    @partial(jax.jit, compiler_options=FOR_HOURS)
    def look(policy: Layers, key: Array, spread: Array) -> tuple[Array, Array, Array]:
        def frame(carry: Any, key: Array) -> tuple[Any, None]:
            motion, total, fallen = carry
            noise = spread * jax.random.normal(key, (MUSCLE_COUNT, ROLLOUTS))
            action = apply_network(policy, environment.observe(motion)) + noise
            motion, reward, done = environment.step(motion, action)
            return (motion, total + reward, fallen | done), None

        zeros = jnp.zeros(ROLLOUTS)
        carry = (start, zeros, zeros > 0)
        (motion, total, fallen), _ = jax.lax.scan(frame, carry, jax.random.split(key, FRAMES))
        return (
            total / FRAMES,
            fallen,
            springs.ascent(spec.settings.slope, start.position, motion.position, BOX),
        )

    def run(policy: Layers, seed: int, noise: float) -> Look:
        reward, fallen, climb = map(
            np.asarray, look(policy, jax.random.PRNGKey(seed), jnp.asarray(noise, jnp.float32))
        )
        climbs = tuple(float(climb[index == i].mean()) for i in range(len(weights)))
        return Look(float(reward.mean()), float(fallen.mean()), climbs)

    return run


def train_hill(
    spec: HillSpec,
    seed: int,
    folder: Path | None = None,
    recipe: Recipe | None = None,
    resume: bool = True,
    report: Report | None = None,
    say: Callable[[str], None] | None = None,
) -> Trained:
    """Trains the controllers of a hill for all weights that it needs, and stores them.

    The result depends on the seed, the recipe and the machine's arithmetic only, not on
    interruptions: Ctrl-C keeps the best policy so far (`finished` is false then) and the state of
    the training, from which the next call goes on.

    Args:
        folder: where the file goes; the user's cache by default.
        resume: whether to go on from a training that was interrupted, and to keep controllers
            that were trained for longer.
        report: called with (iterations done, all, figures).
        say: is told of damaged caches.

    Raises KeyboardInterrupt if it is interrupted before there was anything to keep, OSError where
    nothing can be stored, StoryError where no motion is finite.
    """
    if folder is None:
        cache_folder("controllers")  # before the work, if nothing can be stored there
    recipe = recipe or Recipe()
    assert recipe.value_scale == VALUE_SCALE
    began = time.perf_counter()
    weights = spec.trained_weights
    environment, _ = hill_environment(spec, weights, recipe.environments)
    look = looker(spec, weights)
    training = begin(environment, recipe, seed)
    best: tuple[Look, Layers, Layers] | None = None
    name = f"training-{spec.training_key}-{recipe.iterations}-seed{seed}"
    stored = store.load(name, say) if resume else None
    if stored is not None:
        try:
            training, best = _unpacked(stored, training)
        except (KeyError, ValueError):
            if say is not None:
                say("the state of an interrupted training is damaged; it begins anew")
    finished = True
    try:
        while int(training.iteration) < recipe.iterations:
            count = min(CHUNK, recipe.iterations - int(training.iteration))
            training, figures = improve_often(environment, recipe, count, training)
            for policy in (training.policy, training.averaged):
                # Other noise than that of the final figures (seed + 1).
                seen = look(policy, seed, LOOK_NOISE)
                if np.isfinite(seen.merit) and (best is None or seen.merit > best[0].merit):
                    best = (seen, policy, training.value)
            store.save(name, _packed(training, best), say)
            if report is not None:
                shown = best[0] if best else seen
                report(
                    int(training.iteration),
                    recipe.iterations,
                    {"reward": float(figures[0]), "best": shown.reward, "falls": shown.falls},
                )
    except KeyboardInterrupt:
        if best is None:
            raise
        finished = False
    if best is None:
        message = "no controllers were found whose motion is finite"
        raise error("training", message, whole_file(f"world {spec.name}"))
    _, policy, value = jax.device_get(best)
    final = look(policy, seed + 1, LOOK_NOISE)
    usual = recipe.iterations == Recipe().iterations
    about = {
        "command": training_command(spec, seed, None if usual else recipe.iterations),
        "seed": seed,
        "physics": spec.physics,
        "iterations": int(training.iteration),
        "finished": finished,
        "reward": round(final.reward, 3),
        "falls": final.falls,
        "climbs": [round(c, 2) for c in final.climbs],
    }
    found = Controllers(policy, value, weights, about)
    place = (folder or cache_folder("controllers")) / file_name(spec, seed)
    path: Path | None = place
    if folder is None and resume and _are_better(spec, seed, int(training.iteration)):
        path = None
        if say is not None:
            say("the controllers that are there were trained for longer, and are kept")
    else:
        save_controllers(place, found)
    if finished:
        with suppress(OSError):
            store.remove(name)
    return Trained(found, path, finished, time.perf_counter() - began, final)


def _are_better(spec: HillSpec, seed: int, iterations: int) -> bool:
    """Whether controllers are stored, or ship, that were trained for more iterations."""
    try:
        found = find_controllers(spec, seed)
    except StoryError:
        return False
    return int(found.about.get("iterations", 0)) > iterations


def _packed(training: Training, best: tuple[Look, Layers, Layers] | None) -> dict[str, np.ndarray]:
    """The state of a training as arrays by name."""
    leaves = jax.tree.leaves((training, best[1:] if best else (training.policy, training.value)))
    arrays = {f"leaf{i}": np.asarray(leaf) for i, leaf in enumerate(leaves)}
    figures = (best[0].reward, best[0].falls, *best[0].climbs) if best else ()
    return {**arrays, "best": np.array(figures)}


def _unpacked(
    arrays: dict[str, np.ndarray], like: Training
) -> tuple[Training, tuple[Look, Layers, Layers] | None]:
    leaves, structure = jax.tree.flatten((like, (like.policy, like.value)))
    found = [jnp.asarray(arrays[f"leaf{i}"]) for i in range(len(leaves))]
    if any(a.shape != b.shape for a, b in zip(leaves, found, strict=True)):
        raise ValueError("it is of other networks")
    training, networks = jax.tree.unflatten(structure, found)
    figures = [float(x) for x in arrays["best"]]
    if not figures:
        return training, None
    return training, (Look(figures[0], figures[1], tuple(figures[2:])), *networks)
