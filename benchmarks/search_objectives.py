"""The objectives that the search is measured by: what a story may want, in two small worlds.

Each is said for a story of T frames, of a weak character and a strong one who may help it.
"""

from __future__ import annotations

NOOK = """
map
    A..
    .#.
    ..B
tile left
    symbol = A
tile right
    symbol = B
character small
    success = 0.6
    goals = {left, right}
character tall
    goals = {left, right, none}
    pushes = {small}
    toward = small
    attitude = {-2, 0, 2}
"""
"""A ring of eight cells: 56 first pictures, and 2,136,840 scripts of three frames."""

NOOK_OBJECTIVES = {
    "help": "maximize sum_t P(rho > 0 | script[:t])",
    "hinder": "maximize sum_t P(rho < 0 | script[:t])",
    "late": "maximize 4 * P(rho > 0 | script[:T])",
    "min": "maximize 4 * (min_t P(rho > 0 | script[:t]))",
    "max": "maximize 4 * (max_t P(G_tall = none | script[:t]))",
    "max times min": "maximize 9 * (max_t P(G_small = left | script[:t])) * "
    "(min_t P(rho = 0 | script[:t]))",
    "entropy at the end": "maximize entropy(rho | script[:T])",
    "entropy": "maximize sum_t entropy(script[:t])",
    "certain": "minimize sum_t entropy(script[:t])",
    "KL": "maximize sum_t KL(script[:t-1] || script[:t])",
    "KL from the prior": "maximize KL(rho; script[:0] || script[:T])",
    "surprise": "maximize sum_t surprise(script[t])",
    "surprise at the end": "maximize 3 * surprise(script[T])",
    "suspense": "maximize sum_t suspense(rho | script[:t])",
    "swing": "maximize 4 * (P(rho > 0 | script[:T]) - P(rho > 0 | script[:1]))^2",
    "turn": "maximize twist(G_small = left, G_small = right, turn = 2)",
    "irony": "maximize irony(G_small = left, G_small = right, rho > 0, rho < 0)",
    "conditional": "maximize sum_t P(rho > 0 | script[:t], G_small = left)\n"
    "maximize 2 * P(rho < 0 | script[:T], G_small = right)",
    "must end on the tile": "maximize sum_t P(rho > 0 | script[:t])\n"
    "maximize 50 * [at(small, left) @ script[T]]",
    "must swap tiles": "maximize 50 * (if P(rho > 0 | script[:T]) > 0.9 then 1 else 0)\n"
    "maximize 10 * [at(tall, left) @ script[T]] * [at(small, right) @ script[T]]",
    "never adjacent, then pushed": "maximize 4 * [pushes(tall, small) @ script[T]]\n"
    "minimize sum_{t in 1..T-1} [adjacent(tall, small) @ script[t]]",
    "fortune falls and rises": "maximize E[V(small) | script[:T]] / 4\n"
    "minimize E[V(small) | script[:T-1]] / 4",
    "a fixed frame in a sum": "maximize sum_t P(rho > 0 | script[:t]) * P(rho < 0 | script[:1])",
    "points": "minimize sum_t 4 * (P(rho > 0 | script[:t]) - points((0, 0), (0.5, 0.2), (1, 1)))^2",
}

KITCHEN_OBJECTIVES = {
    "help": "maximize depict(rho > 0)",
    "KL": "maximize sum_t KL(script[:t-1] || script[:t])",
    "if/else over time": "maximize sum_t (if t < 6 then P(rho < 0 | script[:t]) "
    "else P(rho > 0 and G_cheese = pink | script[:t]))",
    "pushes": "maximize sum_t [pushes(robot, cheese) @ script[t]]\n"
    "maximize sum_t P(rho < 0 | script[:t])",
    "a fixed frame in a sum": "maximize sum_t P(rho > 0 | script[:t]) * P(rho < 0 | script[:3])",
    "points": "minimize sum_t 4 * (P(rho > 0 | script[:t]) - points((0, 0), (0.5, 0.2), (1, 1)))^2",
    "late": "maximize 10 * P(rho = 3 | script[:T])",
    "swing": "maximize 10 * (P(rho > 0 | script[:T]) - P(rho > 0 | script[:5]))^2",
    "min": "maximize 10 * (min_t P(G_robot = green | script[:t]))",
    "entropy at the end": "maximize 5 * entropy(script[:T])",
    "conditional": "maximize sum_t P(rho > 0 | script[:t], G_cheese = pink) "
    "* P(rho < 0 | script[:t], G_cheese = green)",
    "a meeting and swapped tiles": "maximize 10 * [adjacent(robot, cheese) @ script[8]]\n"
    "maximize 10 * [at(robot, pink) @ script[T]] * [at(cheese, green) @ script[T]]",
    "reveal": "maximize reveal(G_robot = pink)",
}
