"""How often answers match, when people differ and films differ: a logistic model with people and
films as crossed random effects, by Hamiltonian Monte Carlo (NumPyro).

Answers about one film resemble each other, and so do those of one person: intervals that count them
as independent are too short (Clark 1973, DOI 10.1016/S0022-5371(73)80014-3). The log odds that
person p answers as intended to film f of cell c (a condition by a method) are

    middle[c] + person[p] + taste[p, c] + film[f],

where a person differs from others everywhere and in each cell (Barr et al. 2013, DOI
10.1016/j.jml.2012.11.001), and a film from others of its cell, all normally, with spreads that are
estimated, those of films for each cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpyro
import numpyro.distributions as dist
from numpyro.diagnostics import effective_sample_size, split_gelman_rubin
from numpyro.infer import HMC, init_to_value

from i2pdsl.fit.odds import normal_points
from i2pdsl.programs import compiled

Array = Any

CHAINS, WARMUP, DRAWS = 4, 300, 400
# Between a quarter and half of the period of a standard normal, which most effects are by
# themselves: NUTS finds the same and takes three times as long to compile.
TRAJECTORY = 2.2
POINTS = 21  # of the quadrature over people and films
WIDE, SPREAD = 2.5, 1.5  # thought of beforehand: of the middles, and of all spreads
_KEPT = ("middle", "spread", "films")


@dataclass(frozen=True)
class Posterior:
    """What is estimated.

    Attributes:
        share: [D, C] draws: how often a new person answers as intended about a new film.
        people, tastes: [D] draws of the standard deviations of people, and of their tastes.
        films: [D, C] of films.
        rhat: the worst R-hat of the shares; `ess` the fewest effective draws.
    """

    share: np.ndarray
    people: np.ndarray
    tastes: np.ndarray
    films: np.ndarray
    rhat: float
    ess: float


def estimate(matches: np.ndarray, cell: np.ndarray, seed: int = 0) -> Posterior:
    """The posterior. Call it while JAX may compute (computing.py).

    Args:
        matches: [P, F] whether a person's answer about a film matches; NaN where there is none.
        cell: [F] where each film belongs, from 0; none is left out.
    """
    person, film = np.nonzero(~np.isnan(matches))
    rows = jnp.asarray(matches[person, film], float), person, film, cell
    sizes = len(matches), int(cell.max()) + 1
    run = jax.jit(partial(sampled, sizes=sizes))
    key = jax.random.PRNGKey(seed)
    sites = compiled(run.lower(rows, key))(rows, key)
    share = np.asarray(shares(sites))
    flat = lambda array: np.asarray(array).reshape(-1, *array.shape[2:])
    return Posterior(
        flat(share),
        flat(sites["spread"][..., 0]),
        flat(sites["spread"][..., 1]),
        flat(sites["films"]),
        float(np.max(split_gelman_rubin(share))),
        float(np.min(effective_sample_size(share))),
    )


Rows = tuple[Array, Array, Array, Array]
"""Of each answer whether it matches, whose it is, about which film, [R]; and the films' cells."""


def _program(rows: Rows, sizes: tuple[int, int]) -> None:
    """The model as NumPyro runs it; effects are non-centred."""
    (match, person, film, cell), (people, cells) = rows, sizes
    normal = lambda *shape: dist.Normal().expand(shape).to_event(len(shape))
    half = lambda size: dist.HalfNormal(SPREAD).expand([size]).to_event(1)
    middle = numpyro.sample("middle", dist.Normal(0.0, WIDE).expand([cells]).to_event(1))
    spread = numpyro.sample("spread", half(2))
    spreads = numpyro.sample("films", half(cells))
    own = numpyro.sample("own", normal(people))
    taste = numpyro.sample("taste", normal(cells, people))
    look = numpyro.sample("look", normal(len(cell)))
    of_people = spread[0] * own + spread[1] * taste
    of_films = middle[cell] + spreads[cell] * look
    odds = of_people[cell[film], person] + of_films[film]
    numpyro.sample("answers", dist.Bernoulli(logits=odds).to_event(1), obs=match)


def sampled(
    rows: Rows, key: Array, sizes: tuple[int, int], chains: int = CHAINS
) -> dict[str, Array]:
    """Draws of what all films and people have in common, [chains, DRAWS, ...], the chains side by
    side. `sizes` are the numbers of people and of cells."""
    people, cells = sizes
    begin = {
        "middle": jnp.zeros(cells), "spread": jnp.full(2, 0.3), "films": jnp.full(cells, 0.3),
        "own": jnp.zeros(people), "taste": jnp.zeros((cells, people)),
        "look": jnp.zeros(len(rows[3])),
    }  # fmt: skip
    kernel = HMC(
        _program,
        trajectory_length=TRAJECTORY,
        target_accept_prob=0.85,
        init_strategy=init_to_value(values=begin),
    )
    arguments = (rows, sizes)
    first = kernel.init(jax.random.split(key, chains), WARMUP, None, arguments, {})

    def step(state: Any, _: Any) -> tuple[Any, dict[str, Array]]:
        after = kernel.sample(state, arguments, {})
        return after, {name: after.z[name] for name in _KEPT}

    _, found = jax.lax.scan(step, first, None, WARMUP + DRAWS)
    positive = dist.biject_to(dist.HalfNormal.support)
    kept = {name: jnp.moveaxis(draws[WARMUP:], 0, 1) for name, draws in found.items()}
    return kept | {name: positive(kept[name]) for name in ("spread", "films")}


def shares(sites: dict[str, Array]) -> Array:
    """How often a new person answers as intended about a new film, [..., C]."""
    wide = jnp.sqrt((sites["spread"] ** 2).sum(-1, keepdims=True) + sites["films"] ** 2)
    places, weights = normal_points(POINTS)
    each = jax.nn.sigmoid(sites["middle"][..., None] + wide[..., None] * places)
    return each @ weights
