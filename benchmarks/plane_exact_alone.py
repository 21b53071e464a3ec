"""How far viewers' idea of one character is from exact planning of the same plane, on a fine grid.

Two rooms, a door between them and a place in one. Value iteration over a grid of points with the
velocities of the viewers' quadrature and the dynamics of the world; bilinear between points.
Viewers have the cost to go from shortest ways instead. Says how far apart costs, best directions
and probabilities of velocities are, and draws both costs (docs/plane.md).

    python benchmarks/plane_exact_alone.py [figure.svg]
"""

from __future__ import annotations

import sys

import numpy as np

from i2pdsl.worlds.plane import costs, dynamics, ways
from i2pdsl.worlds.plane.geometry import clearance
from i2pdsl.worlds.plane.spec import Place, PlaneCharacter, PlaneSettings, PlaneSpec, Wall
from i2pdsl.worlds.plane.world import build_plane

WIDTH, HEIGHT, GOAL, RADIUS = 12.0, 8.0, (10.0, 3.0), 0.4
DOOR = Wall(((7.0, 0.0), (7.0, 4.4))), Wall(((7.0, 6.0), (7.0, 8.0)))
SPACING = 0.1  # units between points
KNOWN = 0.5  # units about the place in which the grid is too coarse: the straight way is exact


def situation():
    """Somebody alone, who wants to be in the other room."""
    cast = (PlaneCharacter("mover", (2.0, 2.0), RADIUS, 0.13, goals=("inside",)),)
    places = (Place("inside", GOAL),)
    return build_plane(PlaneSpec("alone", WIDTH, HEIGHT, DOOR, places, cast, PlaneSettings()))


def interpolation(points, shape, free):
    """Nodes [..., 4] and shares of a bilinear interpolation between free nodes."""
    at = np.clip(points / SPACING, 0, np.array(shape) - 1.001)
    cell = np.floor(at).astype(int)
    part = at - cell
    corners = np.array(list(np.ndindex(2, 2)))
    shares = np.where(corners, part[..., None, :], 1 - part[..., None, :]).prod(-1)
    nodes = np.ravel_multi_index(np.moveaxis(cell[..., None, :] + corners, -1, 0), shape)
    shares = shares * free[nodes]
    total = shares.sum(-1, keepdims=True)
    return nodes, np.where(total > 1e-6, shares / np.maximum(total, 1e-6), 1.0)


def main() -> None:
    world = situation()
    tables, cast = world.tables, world.cast
    x, y = np.meshgrid(
        np.arange(0, WIDTH + 1e-9, SPACING), np.arange(0, HEIGHT + 1e-9, SPACING), indexing="ij"
    )
    points = np.stack([x, y], axis=-1)
    room = np.array([WIDTH, HEIGHT]) / 2
    inside = (abs(points - room) <= room - RADIUS + 1e-9).all(-1)
    free = inside & (clearance(tables.walls, points) >= RADIUS)
    here = points[free]  # [N, 2]
    state = np.concatenate([here, np.zeros_like(here)], axis=-1)
    tried = tables.fastest[0] * tables.nodes
    action = np.broadcast_to(tried, (len(here), *tried.shape))
    after = dynamics.transition(tables, cast, state[:, None, :], action)[..., :2]
    nodes, shares = interpolation(after, free.shape, free.reshape(-1))
    own = costs.step_cost(tables, 0, tried)
    straight = np.hypot(*(here - GOAL).T)
    exact = np.full(free.size, 100.0)  # also of points that nobody can be at
    for sweep in range(1, 2000):  # noqa: B007
        total = own + (exact[nodes] * shares).sum(-1)
        new = np.where(straight < KNOWN, straight, total.min(-1))
        change = np.abs(new - exact[free.reshape(-1)]).max()
        exact[free.reshape(-1)] = new
        if change < 1e-6:
            break
    known = ways.outlook(tables, cast, state)
    ours = costs.costs_here(tables, cast, 0, known)[:, 0]
    guess = costs.lookahead(tables, cast, 0, known, [np.zeros_like(here)], action)[..., 0]
    there = straight > 2 * KNOWN
    error = np.abs(ours - new)[there]
    best = [tried[q[there].argmin(-1)] @ np.array([1, 1j]) for q in (total, guess)]
    turn = np.degrees(abs(np.angle(best[0] * np.conj(best[1]))))

    def likely(q):
        weighed = tables.log_weights - tables.beta[0] * q[there]
        weighed = np.exp(weighed - weighed.max(-1, keepdims=True))
        return weighed / weighed.sum(-1, keepdims=True)

    apart = 0.5 * np.abs(likely(total) - likely(guess)).sum(-1)
    figures = lambda found: (
        f"{np.median(found):.3g} (median), {np.quantile(found, 0.9):.3g} (90 %), {found.max():.3g}"
    )
    print(
        f"{there.sum()} points, {sweep} sweeps, residual {change:.1g}; ways up to {ours.max():.1f}"
    )
    print(f"cost to go, units apart: {figures(error)}")
    print(f"best direction, degrees apart: {figures(turn)}")
    print(f"probabilities of velocities, total variation: {figures(apart)}")
    if len(sys.argv) > 1:
        draw(sys.argv[1], points, free, exact, ours)


def draw(path, points, free, exact, ours) -> None:
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True)
    fields = np.full((2, *free.shape), np.nan)
    fields[0][free] = exact[free.reshape(-1)]
    fields[1][free] = ours
    titles = "exact planning on a grid", "what viewers expect: shortest ways"
    for axis, field, title in zip(axes, fields, titles, strict=True):
        axis.contour(*np.moveaxis(points, -1, 0), field, levels=np.arange(0, 20), cmap="viridis")
        for wall in DOOR:
            axis.plot(*np.array(wall.points).T, color="black", linewidth=2)
        axis.plot(*GOAL, "o", color="#c98d5e")
        axis.set_title(title)
        axis.set_aspect("equal")
    figure.tight_layout()
    figure.savefig(path)


if __name__ == "__main__":
    main()
