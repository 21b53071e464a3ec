"""What happens on a hill, and what viewers make of it: pure functions of NumPy or JAX arrays.

States are [..., 76] (x of 19 nodes, y, then the velocities), actions [..., 6]: what is added to
the controller's own actuation of the muscles (paper, section 3.3). O observers, H hypotheses.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from i2pdsl.planning.networks import Layers, apply_network
from i2pdsl.worlds.hill import springs
from i2pdsl.worlds.hill.controllers import VALUE_SCALE
from i2pdsl.worlds.hill.hopper import GROUPS, MUSCLE_COUNT, Body, rest_ascents
from i2pdsl.worlds.hill.springs import Motion

Array = Any

MOVED = 0.02  # units in a frame that are seen as a motion of a node (about a tenth of a hop's)
SLOWLY = 0.05  # units in a frame, of the node that moves most: half as still as no motion at all
SOFTNESS = 1.0  # units of height over which the smooth step of `fallen` rises
REST_ASCENTS = rest_ascents()
SLACKNESS = 0.3  # units of stretch over which that of `taut` does


class Tables(NamedTuple):
    """The numbers of a hill.

    Attributes:
        body: springs and nodes.
        mass [N]: of each node, as it is.
        driver: the policy that acts.
        offset, scale [76]: networks see (observation - offset) / scale.
        masses [H, N]: of each node under each hypothesis.
        policies, values: of each observer and hypothesis; matrices [O, 1, out, in] and biases
            [O, H, out], or [O, 1, out] where the hypotheses share them.
        sigma [O]: standard deviation of the comparison.
        knows [O]: whether an observer knows what the muscles do (`evidence = mass`).
        log_prior [O, H]; forgetting [O].
    """

    body: Body
    mass: Array
    driver: Layers
    offset: Array
    scale: Array
    masses: Array
    policies: Layers
    values: Layers
    sigma: Array
    knows: Array
    log_prior: Array
    forgetting: Array


def seen_by_networks(tables: Tables, motion: Motion) -> Array:
    """The networks' inputs but the weight, [76, B]."""
    seen = springs.observation(tables.body, motion)
    return (seen - tables.offset[:, None]) / tables.scale[:, None]


def actuation(tables: Tables, state: Array, action: Array) -> Array:
    """Of the muscles, [..., 6]: the controller's own and what is added to it."""
    inputs = seen_by_networks(tables, springs.motion_of(state))
    return _used(tables, inputs, action).T.reshape(*state.shape[:-1], MUSCLE_COUNT)


def _used(tables: Tables, inputs: Array, action: Array) -> Array:
    """The same, [6, B]."""
    return apply_network(tables.driver, inputs) + action.reshape(-1, MUSCLE_COUNT).T


def transition(tables: Tables, state: Array, action: Array) -> Array:
    """The state after a frame, [..., 76]."""
    motion = springs.motion_of(state)
    used = _used(tables, seen_by_networks(tables, motion), action)
    after, _ = springs.step(tables.body, tables.mass, motion, used)
    return springs.state_of(after, state.shape[:-1])


def log_likelihood(tables: Tables, state: Array, action: Array, after: Array) -> Array:
    """log P(what is seen | H), [..., O, H], up to what is the same for all hypotheses.

    An observer imagines one frame under each hypothesis, with its own mass and controller, from
    the state before it (Battaglia et al. 2013, DOI 10.1073/pnas.1306572110), and compares:
    -mean((seen - imagined)^2) / (2 sigma^2) over the 76 numbers of an observation.
    """
    motion = springs.motion_of(state)  # [2, N, B]
    inputs = seen_by_networks(tables, motion)
    imagined = _imagined(tables, motion, inputs, _used(tables, inputs, action))
    expected, _ = springs.step(tables.body, *imagined)
    missed = _missed(tables, springs.motion_of(after), expected)
    return missed.reshape(*state.shape[:-1], *tables.log_prior.shape)


def outcome(tables: Tables, state: Array, action: Array) -> tuple[Array, Array]:
    """`transition`, and `log_likelihood` of what it leads to: what happens and what is imagined
    as one batch, which takes half the time."""
    xp = state.__array_namespace__()
    motion = springs.motion_of(state)
    inputs = seen_by_networks(tables, motion)
    used = _used(tables, inputs, action)
    mass = xp.broadcast_to(tables.mass[:, None], (tables.mass.shape[0], used.shape[-1]))
    imagined = _imagined(tables, motion, inputs, used)
    joined = lambda real, others: xp.concatenate([real, others], axis=-1)
    moving = Motion(*map(joined, motion, imagined[1]))
    moved, _ = springs.step(
        tables.body, joined(mass, imagined[0]), moving, joined(used, imagined[2])
    )
    count = used.shape[-1]
    after, expected = (
        Motion(*(part[..., which] for part in moved))
        for which in (slice(count), slice(count, None))
    )
    missed = _missed(tables, after, expected).reshape(*state.shape[:-1], *tables.log_prior.shape)
    return springs.state_of(after, state.shape[:-1]), missed


def _imagined(
    tables: Tables, motion: Motion, inputs: Array, used: Array
) -> tuple[Array, Motion, Array]:
    """What every observer imagines under every hypothesis, as one long batch of O * H * B: masses
    [N, ...], motions, actuations [6, ...]."""
    xp = used.__array_namespace__()
    shape = (*tables.log_prior.shape, used.shape[-1])
    own = apply_network(tables.policies, inputs)  # [O, H, 6, B]
    all_used = xp.where(tables.knows[:, None, None, None], used, own)
    mass = xp.broadcast_to(tables.masses.T[:, None, :, None], (tables.masses.shape[1], *shape))
    everyone = Motion(*(_repeated(xp, part, shape) for part in motion))
    return (
        mass.reshape(mass.shape[0], -1),
        everyone,
        all_used.transpose(2, 0, 1, 3).reshape(MUSCLE_COUNT, -1),
    )


def _missed(tables: Tables, after: Motion, expected: Motion) -> Array:
    """The log-likelihoods [B, O, H] of a motion where others were expected."""
    seen = springs.observation(tables.body, after)
    imagined = springs.observation(tables.body, expected)
    imagined = imagined.reshape(imagined.shape[0], *tables.log_prior.shape, -1)
    missed = ((seen[:, None, None, :] - imagined) ** 2).mean(0)  # [O, H, B]
    return (-missed / (2 * tables.sigma[:, None, None] ** 2)).transpose(2, 0, 1)


def _repeated(xp: Any, part: Array, shape: tuple[int, int, int]) -> Array:
    full = (*part.shape[:2], *shape)
    return xp.broadcast_to(part[:, :, None, None, :], full).reshape(*part.shape[:2], -1)


def value(tables: Tables, state: Array) -> Array:
    """The hopper's value of a state under each hypothesis, [..., O, H]."""
    inputs = seen_by_networks(tables, springs.motion_of(state))
    found = VALUE_SCALE * apply_network(tables.values, inputs)[:, :, 0]  # [O, H, B]
    return found.transpose(2, 0, 1).reshape(*state.shape[:-1], *found.shape[:2])


def feature(
    tables: Tables,
    name: str,
    arguments: tuple[Any, ...],
    state: Array,
    before: Array | None,
    action: Array | None,
) -> Array:
    """A predicate or quantity of a frame, [...]."""
    motion = springs.motion_of(state)
    shape = state.shape[:-1]
    if name == "fallen":
        height = springs.head_height(tables.body, motion.position).reshape(shape)
        return _below(height, springs.HEAD_FALLEN, SOFTNESS)
    if name == "taut":
        return _below(-springs.stretch(tables.body, motion.position).reshape(shape), 0.0, SLACKNESS)
    if name == "climbed":
        (group,) = arguments
        nowhere = motion.position * 0
        up = springs.ascent(tables.body.slope, nowhere, motion.position, GROUPS[group])
        return (up - REST_ASCENTS[group]).reshape(shape)
    assert before is not None
    if name == "effort":
        return (actuation(tables, before, action) ** 2).mean(-1)
    (group,) = arguments
    first = springs.motion_of(before).position
    gone = springs.ascent(tables.body.slope, first, motion.position, GROUPS[group])
    return gone.reshape(shape)


def is_still(state: Array, after: Array) -> Array:
    """Whether no node has moved so far that it is seen, [...]."""
    return _most(state, after) < MOVED**2


def stillness(state: Array, after: Array) -> Array:
    """1 where no node moves, 1/2 where the one that moves most goes SLOWLY, [...]."""
    return 1 / (1 + _most(state, after) / SLOWLY**2)


def _most(state: Array, after: Array) -> Array:
    """The square of how far the node moved that moved most, [...]."""
    moved = springs.motion_of(after).position - springs.motion_of(state).position  # [2, N, B]
    most: Array = (moved**2).sum(0).max(0).reshape(state.shape[:-1])
    return most


def _below(length: Array, limit: float, softness: float) -> Array:
    """1 where a length is below a limit, else 0.

    Exact; but JAX differentiates a smooth step in its place, so that a descent which is asked to
    avoid it feels in which direction to go.
    """
    xp = length.__array_namespace__()
    below = xp.where(length < limit, 1.0, 0.0)
    if xp.__name__ == "numpy":
        return below
    from jax.lax import stop_gradient

    smooth = 1 / (1 + xp.exp(xp.clip((length - limit) / softness, -30.0, 30.0)))
    return smooth + stop_gradient(below - smooth)
