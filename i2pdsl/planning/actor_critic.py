"""Short-horizon actor-critic (Xu et al. 2022, arXiv:2204.07137) for differentiable worlds.

The policy is improved by the gradient of the reward over a short horizon, through the simulator,
plus what a learnt value function expects after it; the value function learns from TD(lambda)
targets. Arrays in, arrays out: nothing here knows of hills or stories.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax

from i2pdsl.planning.networks import Layers, apply_network, random_network
from i2pdsl.programs import FOR_HOURS

Array = Any


class Environment(NamedTuple):
    """A batch of B differentiable environments; the batch is the last axis everywhere.

    Attributes:
        reset: (count) -> initial states of all environments, a tree of [..., B].
        observe: state -> the networks' inputs [n, B].
        step: (state, action [m, B]) -> (state, reward [B], done [B]).
        actions: m.
    """

    reset: Callable[[int], Any]
    observe: Callable[[Any], Array]
    step: Callable[[Any, Array], tuple[Any, Array, Array]]
    actions: int


class Recipe(NamedTuple):
    """The numbers of the algorithm; measured ones (model.md, "Hill")."""

    environments: int = 64
    horizon: int = 32
    iterations: int = 2400
    hidden: tuple[int, ...] = (128, 64)
    gamma: float = 0.99
    trace: float = 0.95  # lambda
    policy_rate: float = 2e-3
    value_rate: float = 1e-3
    value_steps: int = 8
    value_batch: int = 256
    value_scale: float = 100.0
    target_share: float = 0.2
    noise: tuple[float, float] = (0.3, 0.2)  # at the start and at the end
    reset_chance: float = 0.1
    average: float = 0.99


class Training(NamedTuple):
    """All that goes on from one iteration to the next."""

    iteration: Array
    key: Array
    state: Any
    policy: Layers
    value: Layers
    target: Layers
    averaged: Layers  # exponential moving average of the policy
    policy_moments: Any
    value_moments: Any


def policy_optimiser(recipe: Recipe) -> optax.GradientTransformation:
    """Adam, its rate falling to a tenth, on gradients of norm 1 at most."""
    rate = optax.linear_schedule(recipe.policy_rate, 0.1 * recipe.policy_rate, recipe.iterations)
    return optax.chain(optax.clip_by_global_norm(1.0), optax.adam(rate, b1=0.7, b2=0.95))


def begin(environment: Environment, recipe: Recipe, seed: int) -> Training:
    """The state before the first iteration."""
    generator = np.random.default_rng(seed)
    state = environment.reset(recipe.environments)
    inputs = environment.observe(state).shape[0]
    policy = random_network(generator, (inputs, *recipe.hidden, environment.actions), 0.1)
    value = random_network(generator, (inputs, *recipe.hidden, 1))
    policy, value = jax.tree.map(jnp.asarray, (policy, value))
    return Training(
        jnp.zeros((), jnp.int32),
        jax.random.PRNGKey(seed),
        state,
        policy,
        value,
        value,
        policy,
        policy_optimiser(recipe).init(policy),
        optax.adam(recipe.value_rate).init(value),
    )


def estimate(recipe: Recipe, value: Layers, inputs: Array) -> Array:
    """V of a state: [B]."""
    return recipe.value_scale * apply_network(value, inputs)[0]


class Segment(NamedTuple):
    """What happened in one short rollout, [horizon, ...]."""

    inputs: Array  # [horizon, n, B]
    reward: Array
    done: Array
    next_value: Array  # of the state after each frame, by the target network; 0 where done


def improve(environment: Environment, recipe: Recipe, training: Training) -> tuple[Training, Array]:
    """One iteration; also returns its mean reward and the share of frames that ended a rollout."""
    key, noise_key, reset_key, batch_key = jax.random.split(training.key, 4)
    share = training.iteration / recipe.iterations
    spread = recipe.noise[0] + (recipe.noise[1] - recipe.noise[0]) * share
    shape = (recipe.horizon, environment.actions, recipe.environments)
    noise = spread * jax.random.normal(noise_key, shape)
    fresh = environment.reset(recipe.environments)
    again = jax.random.uniform(reset_key, (recipe.environments,)) < recipe.reset_chance
    start = _choose(again, fresh, training.state)

    def loss(policy: Layers) -> tuple[Array, tuple[Any, Segment]]:
        @jax.checkpoint
        def frame(carry: Any, noise: Array) -> tuple[Any, Segment]:
            state, discount, total = carry
            inputs = environment.observe(state)
            action = apply_network(policy, inputs) + noise
            state, reward, done = environment.step(state, action)
            after = estimate(recipe, training.target, environment.observe(state))
            after = jnp.where(done, 0.0, after)
            total = total + discount * reward
            # A rollout that ended begins anew, with a new discount.
            discount = jnp.where(done, 1.0, discount * recipe.gamma)
            state = _choose(done, fresh, state)
            return (state, discount, total), Segment(inputs, reward, done, after)

        ones = jnp.ones((recipe.environments,))
        (state, discount, total), segment = jax.lax.scan(frame, (start, ones, 0 * ones), noise)
        total = total + discount * segment.next_value[-1]
        return -total.mean() / recipe.horizon, (state, segment)

    (_, (state, segment)), gradient = jax.value_and_grad(loss, has_aux=True)(training.policy)
    finite = _all_finite(gradient)
    gradient = jax.tree.map(lambda g: jnp.where(finite, g, 0.0), gradient)
    optimiser = policy_optimiser(recipe)
    change, policy_moments = optimiser.update(gradient, training.policy_moments)
    policy = optax.apply_updates(training.policy, change)
    learnt = _learn_value(recipe, training, segment, batch_key)
    value, value_moments = jax.tree.map(
        lambda new, old: jnp.where(_all_finite(learnt), new, old),
        learnt,
        (training.value, training.value_moments),
    )
    keep = recipe.target_share
    training = Training(
        training.iteration + 1,
        key,
        state,
        policy,
        value,
        jax.tree.map(lambda old, new: keep * old + (1 - keep) * new, training.target, value),
        jax.tree.map(
            lambda old, new: recipe.average * old + (1 - recipe.average) * new,
            training.averaged,
            policy,
        ),
        policy_moments,
        value_moments,
    )
    return training, jnp.stack([segment.reward.mean(), segment.done.mean()])


def _all_finite(tree: Any) -> Array:
    return jnp.stack([jnp.isfinite(leaf).all() for leaf in jax.tree.leaves(tree)]).all()


def _choose(condition: Array, first: Any, second: Any) -> Any:
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), first, second)


def td_lambda(recipe: Recipe, segment: Segment) -> Array:
    """G_t = r_t + gamma ((1 - lambda) V_{t+1} + lambda G_{t+1}), [horizon, B]; V alone at the end
    and nothing after a frame that ended a rollout."""

    def back(later: Array, frame: tuple[Array, Array, Array]) -> tuple[Array, Array]:
        reward, done, value = frame
        mixed = (1 - recipe.trace) * value + recipe.trace * later
        target = reward + recipe.gamma * jnp.where(done, 0.0, mixed)
        return target, target

    frames = (segment.reward, segment.done, segment.next_value)
    return jax.lax.scan(back, segment.next_value[-1], frames, reverse=True)[1]


def _learn_value(
    recipe: Recipe, training: Training, segment: Segment, key: Array
) -> tuple[Layers, Any]:
    targets = td_lambda(recipe, segment).reshape(-1)
    inputs = segment.inputs.transpose(1, 0, 2).reshape(segment.inputs.shape[1], -1)
    optimiser = optax.adam(recipe.value_rate)
    order = jax.random.permutation(key, targets.shape[0])
    batches = order[: recipe.value_steps * recipe.value_batch].reshape(recipe.value_steps, -1)

    def loss(value: Layers, batch: Array) -> Array:
        missed = estimate(recipe, value, inputs[:, batch]) - targets[batch]
        return ((missed / recipe.value_scale) ** 2).mean()

    def learn(carry: tuple[Layers, Any], batch: Array) -> tuple[tuple[Layers, Any], None]:
        value, moments = carry
        gradient = jax.grad(loss)(value, batch)
        change, moments = optimiser.update(gradient, moments)
        return (optax.apply_updates(value, change), moments), None

    return jax.lax.scan(learn, (training.value, training.value_moments), batches)[0]


@partial(jax.jit, static_argnums=(0, 1, 2), compiler_options=FOR_HOURS)
def improve_often(
    environment: Environment, recipe: Recipe, count: int, training: Training
) -> tuple[Training, Array]:
    """`count` iterations, and their mean reward and rate of endings, [2]."""

    def once(training: Training, _: None) -> tuple[Training, Array]:
        return improve(environment, recipe, training)

    training, figures = jax.lax.scan(once, training, None, length=count)
    return training, figures.mean(0)
