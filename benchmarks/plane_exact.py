"""How far the viewers' idea of a helper is from exact planning of the same situation, on a grid.

No walls, one place. The other walks straight to the place. By symmetry a state is its distance to
the place and where the helper stands relative to it: three numbers, so that value iteration is
cheap. Says how far the two are apart, and draws where the helper would go (docs/plane.md).

    python benchmarks/plane_exact.py [figure.svg]
"""

from __future__ import annotations

import sys

import numpy as np

from i2pdsl.worlds.plane import costs, dynamics, ways
from i2pdsl.worlds.plane.geometry import disc
from i2pdsl.worlds.plane.spec import Place, PlaneCharacter, PlaneSettings, PlaneSpec
from i2pdsl.worlds.plane.world import build_plane

FAR, REACH, CELLS, STEPS = 4.0, 2.5, 25, 17  # units from the place; beside the other; nodes
RHOS = (2.0, 4.0, 8.0, 16.0)
MOVES = 0.01  # units a frame: below, somebody stays where it is


def situation(rho):
    """A place in the middle of an endless plane, and the two."""
    cast = (
        PlaneCharacter("little", (40.0, 40.0), goals=("home",)),
        PlaneCharacter("big", (30.0, 30.0), mass=3.0, toward="little", attitude=(0.0, rho)),
    )
    return build_plane(
        PlaneSpec("exact", 80.0, 80.0, (), (Place("home", (40.0, 40.0)),), cast, PlaneSettings())
    )


def states(distance, beside):
    """The world's states: the other is so far east of the place, the helper `beside` it."""
    x = 40.0 + distance
    zero = np.zeros_like(x)
    return np.stack(
        [x, 40.0 + zero, x + beside[..., 0], 40.0 + beside[..., 1], zero, zero, zero, zero], axis=-1
    )


def reduced(state):
    """Distance and relative place [..., 3] of a state, turned so that the place is due west."""
    away = state[..., :2] - 40.0
    distance = np.hypot(*np.moveaxis(away, -1, 0))
    unit = away / np.maximum(distance, 1e-9)[..., None]
    beside = state[..., 2:4] - state[..., :2]
    along = (beside * unit).sum(-1)
    across = unit[..., 0] * beside[..., 1] - unit[..., 1] * beside[..., 0]
    return np.stack([distance, along, across], axis=-1)


def interpolation(numbers):
    """Nodes and shares [..., 8] of a trilinear interpolation over distance, along, across."""
    low = np.array([0.0, -REACH, -REACH])
    step = np.array([FAR / (STEPS - 1), *(2 * (2 * REACH / (CELLS - 1),))])
    shape = (STEPS, CELLS, CELLS)
    at = np.clip((numbers - low) / step, 0, np.array(shape) - 1.001)
    cell = np.floor(at).astype(int)
    part = at - cell
    corners = np.array(list(np.ndindex(2, 2, 2)))
    shares = np.where(corners, part[..., None, :], 1 - part[..., None, :]).prod(-1)
    nodes = np.ravel_multi_index(np.moveaxis(cell[..., None, :] + corners, -1, 0), shape)
    return nodes, shares


def main() -> None:
    for rho in RHOS:
        compared = compare(rho)
    if len(sys.argv) > 1:
        draw(sys.argv[1], *compared)


def compare(rho):
    """Velocities of the exact helper and of the one that viewers expect, and where."""
    world = situation(rho)
    tables, cast = world.tables, world.cast
    line = np.linspace(-REACH, REACH, CELLS)
    distance, along, across = np.meshgrid(np.linspace(0, FAR, STEPS), line, line, indexing="ij")
    beside = np.stack([along, across], axis=-1)
    apart = np.hypot(along, across)
    touch = tables.radius.sum()
    beside = beside * np.maximum(1.0, touch / np.maximum(apart, 1e-6))[..., None]
    state = states(distance, beside)
    nodes, _ = disc(16, 3)
    tried = np.concatenate([[[0.0, 0.0]], tables.fastest[1] * nodes])  # [K, 2]
    other = np.zeros((*distance.shape, 2))
    other[..., 0] = -np.minimum(tables.speed[0], distance)
    action = np.concatenate(
        [
            np.broadcast_to(other[..., None, :], (*distance.shape, len(tried), 2)),
            np.broadcast_to(tried, (*distance.shape, len(tried), 2)),
        ],
        axis=-1,
    )
    after = reduced(dynamics.transition(tables, cast, state[..., None, :], action))
    # A frame costs the helper its own motion, and rho times the other's time and motion.
    own = (tried**2).sum(-1) / (2 * tables.speed[1])
    theirs = rho * costs.step_cost(tables, 0, other)
    value = rho * distance
    cells, shares = interpolation(after)
    for sweep in range(1, 1000):  # noqa: B007
        total = own + theirs[..., None] + (value.reshape(-1)[cells] * shares).sum(-1)
        new = np.where(distance < 0.05, 0.0, total.min(-1))
        change = np.abs(new - value).max()
        value = new
        if change < 1e-3:
            break
    exact = tried[total.argmin(-1)]
    known = ways.outlook(tables, cast, state)
    moving = [other, np.zeros_like(other)]
    plans = tables.plans[1]
    helping = int(np.flatnonzero(plans.theirs.max(0) > 0)[0])
    guess = costs.lookahead(
        tables, cast, 1, known, moving, np.broadcast_to(tried, (*distance.shape, len(tried), 2))
    )
    ours = tried[guess[..., helping].argmin(-1)]
    exactly, expected = (field[..., 0] + 1j * field[..., 1] for field in (exact, ours))
    there = distance >= 1
    both = there & (abs(exactly) > MOVES) & (abs(expected) > MOVES)
    turn = np.degrees(abs(np.angle(exactly[both] * np.conj(expected[both]))))
    share = lambda field: 100 * (abs(field[there]) > MOVES).mean()
    print(
        f"rho {rho:g} ({sweep} sweeps, residual {change:.1g}): it moves in {share(exactly):.0f} % "
        f"of the states, expected {share(expected):.0f} %; where both do, directions differ by "
        f"{np.median(turn):.0f} degrees (median), {np.quantile(turn, 0.9):.0f} (90 %)",
        flush=True,
    )
    return beside, exact, ours, distance, tables.radius.sum()


def draw(path, beside, exact, ours, distance, touch) -> None:
    import matplotlib.pyplot as plt

    layer = int(np.abs(distance[:, 0, 0] - 3.0).argmin())
    figure, axes = plt.subplots(1, 2, figsize=(9, 4.5), sharey=True)
    for axis, field, title in zip(
        axes, (exact, ours), ("exact planning", "what viewers expect"), strict=True
    ):
        x, y = beside[layer, ::2, ::2, 0], beside[layer, ::2, ::2, 1]
        axis.quiver(x, y, field[layer, ::2, ::2, 0], field[layer, ::2, ::2, 1], angles="xy")
        axis.add_patch(plt.Circle((0, 0), touch, color="#f2c14e", alpha=0.5))
        axis.annotate("", (-2.8, 0), (-1.0, 0), arrowprops={"arrowstyle": "->", "color": "#c98d5e"})
        axis.set_title(title)
        axis.set_aspect("equal")
    figure.tight_layout()
    figure.savefig(path)


if __name__ == "__main__":
    main()
