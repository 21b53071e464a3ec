"""How often answers match, when people differ and films differ: a logistic model with people and
films as crossed random effects, by NUTS (NumPyro).

Answers about one film resemble each other, and so do those of one person: intervals that count them
as independent are too short (Clark 1973, DOI 10.1016/S0022-5371(73)80014-3). The log odds that
person p answers as intended to film f of cell c (a condition by a method) are

    middle[c] + person[p] + taste[p, c] + film[f],

where a person differs from others everywhere and in each cell (Barr et al. 2013, DOI
10.1016/j.jml.2012.11.001), and a film from others of its cell, all normally, with spreads that are
estimated. Answers between 0 and 1 (sliders) have normal noise about the same sum, without the
logistic curve.
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
from numpyro.infer import NUTS

Array = Any

CHAINS, WARMUP, DRAWS = 4, 300, 300
POINTS = 21  # of the quadrature over people and films
_KEPT = ("middle", "spread", "films")


@dataclass(frozen=True)
class Rows:
    """Answers in arrays.

    Attributes:
        match: [R] whether the answer matched, or how far it did, 0 to 1, where `is_choice` is not.
        person, film: [R] whose answer it is, about which film, from 0.
        cell: [films] where each film belongs.
    """

    match: np.ndarray
    person: np.ndarray
    film: np.ndarray
    cell: np.ndarray
    is_choice: bool = True


@dataclass(frozen=True)
class Posterior:
    """What is estimated.

    Attributes:
        share: [D, cells] draws: how often a new person answers as intended about a new film.
        people, tastes: [D] draws of the standard deviations of people, and of their tastes.
        films: [D, cells] of films.
        rhat: the worst R-hat of the shares; `ess` the fewest effective draws.
    """

    share: np.ndarray
    people: np.ndarray
    tastes: np.ndarray
    films: np.ndarray
    rhat: float
    ess: float


def estimate(rows: Rows, seed: int = 0) -> Posterior:
    """The posterior. Call it while JAX may compute (computing.py)."""
    sizes = int(rows.person.max()) + 1, int(rows.cell.max()) + 1, rows.is_choice
    match = np.asarray(rows.match, float)
    sites = sampled(match, (rows.person, rows.film, rows.cell), jax.random.PRNGKey(seed), sizes)
    share = np.asarray(shares(sites, rows.is_choice))
    flat = lambda array: np.asarray(array).reshape(-1, *array.shape[2:])
    return Posterior(
        flat(share),
        flat(sites["spread"][..., 0]),
        flat(sites["spread"][..., 1]),
        flat(sites["films"]),
        float(np.max(split_gelman_rubin(share))),
        float(np.min(effective_sample_size(share))),
    )


Sizes = tuple[int, int, bool]
"""How many people and cells, and whether answers are choices."""


def _program(match: Array, who: tuple[Array, Array, Array], sizes: Sizes) -> None:
    """The model as NumPyro runs it; effects are non-centred."""
    people, cells, is_choice = sizes
    person, film, cell = who
    middle, wide, narrow = (0.0, 2.0, 1.0) if is_choice else (0.5, 0.5, 0.25)
    normal = lambda *shape: dist.Normal().expand(shape).to_event(len(shape))
    base = numpyro.sample("middle", dist.Normal(middle, wide).expand([cells]).to_event(1))
    spread = numpyro.sample("spread", dist.HalfNormal(narrow).expand([2]).to_event(1))
    spreads = numpyro.sample("films", dist.HalfNormal(narrow).expand([cells]).to_event(1))
    own = numpyro.sample("own", normal(people))
    taste = numpyro.sample("taste", normal(cells, people))
    look = numpyro.sample("look", normal(len(cell)))
    of_people = spread[0] * own + spread[1] * taste
    of_films = base[cell] + spreads[cell] * look
    value = of_people[cell[film], person] + of_films[film]
    if is_choice:
        answers = dist.Bernoulli(logits=value)
    else:
        answers = dist.Normal(value, numpyro.sample("noise", dist.HalfNormal(0.5)))
    numpyro.sample("answers", answers.to_event(1), obs=match)


@partial(jax.jit, static_argnames=("sizes", "chains"))
def sampled(
    match: Array,
    who: tuple[Array, Array, Array],
    key: Array,
    sizes: Sizes,
    chains: int = CHAINS,
) -> dict[str, Array]:
    """Draws of what all films and people have in common, [chains, DRAWS, ...], the chains side by
    side."""
    kernel = NUTS(_program, target_accept_prob=0.85, max_tree_depth=7)
    arguments = (match, who, sizes)
    first = kernel.init(jax.random.split(key, chains), WARMUP, None, arguments, {})

    def step(state: Any, _: Any) -> tuple[Any, dict[str, Array]]:
        after = kernel.sample(state, arguments, {})
        return after, {name: after.z[name] for name in _KEPT}

    _, found = jax.lax.scan(step, first, None, WARMUP + DRAWS)
    positive = dist.biject_to(dist.HalfNormal.support)
    kept = {name: jnp.moveaxis(draws[WARMUP:], 0, 1) for name, draws in found.items()}
    return kept | {name: positive(kept[name]) for name in ("spread", "films")}


def shares(sites: dict[str, Array], is_choice: bool) -> Array:
    """How often a new person answers as intended about a new film, [..., cells]."""
    if not is_choice:
        return sites["middle"]
    wide = jnp.sqrt((sites["spread"] ** 2).sum(-1, keepdims=True) + sites["films"] ** 2)
    places, weights = np.polynomial.hermite_e.hermegauss(POINTS)
    each = jax.nn.sigmoid(sites["middle"][..., None] + wide[..., None] * places)
    return each @ (weights / weights.sum())
