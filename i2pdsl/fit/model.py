"""How people answer: the audience's exact posterior inside a hierarchical model, in NumPyro.

Everybody has the same kinds of parameters. With several people each parameter has a mean and a
spread in the group, and everybody's own values are drawn from a normal distribution around it (in
the parameter's unbounded scale; non-centred, as Papaspiliopoulos, Roberts and Skoeld 2007 advise,
DOI 10.1214/088342307000000014).

A viewer: how sharply choices are expected, forgetting, the prior over every latent's values. What
becomes of a belief as it is told: answering.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np
import numpyro
import numpyro.distributions as dist
from jax.nn import logsumexp, sigmoid

from i2pdsl.fit.answering import log_choice, log_pair, log_slider, slider_mean
from i2pdsl.fit.odds import normal_points
from i2pdsl.fit.viewers import Answers, Seen, Viewer

Array = Any

PAIR = -1  # in the place of a number of options: one of two films


class Scale(NamedTuple):
    """A parameter: where its values lie, and what is thought of it before any answer: the mean and
    the standard deviation of the group's mean, and the scale of the spread, in unbounded terms."""

    bounded: Callable[[Array], Array]
    mean: float
    sd: float
    spread: float


def _share(x: Array) -> Array:
    return sigmoid(x)


def _same(x: Array) -> Array:
    return x


RESPONSE = {
    "lapse": Scale(_share, -3.0, 1.0, 0.5),
    "noise": Scale(jnp.exp, 0.0, 0.7, 0.3),
    "bias": Scale(_same, 0.0, 0.5, 0.3),
    "slope": Scale(jnp.exp, 0.0, 0.5, 0.3),
}
"""How people answer, whatever they believe."""

VIEWER = {
    "sharpness": Scale(jnp.exp, 0.0, 1.0, 0.5),
    "forgetting": Scale(_share, -5.0, 2.0, 0.5),
}
POSSIBLE = {
    "sharpness": (1e-3, 1e3),
    "forgetting": (0.0, 0.5),
    "lapse": (0.0, 0.99),
    "noise": (1e-3, 1e3),
    "bias": (-100.0, 100.0),
    "slope": (1e-3, 1e3),
}
"""What they can be where they are not fitted."""
WEIGHT = Scale(_same, 0.0, 1.0, 0.5)

MISFIT = 0.5
"""The scale of how far questions lie apart from what any viewer would answer, in log odds, before
any answer is seen."""

USUALLY_VARY = ("plan", "prior", "lapse", "noise", "bias")
"""In what people differ unless somebody says otherwise: to let all differ in sharpness as well
takes as many times as long as there are people. `plan` is how they think that characters plan."""


class Predictor(Protocol):
    """What is believed of each cell, from parameters with names."""

    @property
    def scales(self) -> dict[str, Scale]: ...

    def __call__(self, seen: Any, values: dict[str, Array]) -> Array:
        """[C], probabilities, from unbounded parameters."""


@dataclass(frozen=True)
class Latent:
    """A latent whose prior is asked for.

    Attributes:
        values: their names.
        one_hot: which hypothesis has which, [H, V]; of those in which it plays no part all 0.
    """

    name: str
    values: tuple[str, ...]
    one_hot: np.ndarray

    @property
    def parameters(self) -> tuple[str, ...]:
        return tuple(f"prior[{self.name} = {value}]" for value in self.values)


@dataclass(frozen=True)
class Watching:
    """Viewers: the audience of the product with parameters of its own.

    Attributes:
        answers: what a viewer answers to each of the cells.
        latents: whose priors are fitted.
        base: log P(H) that the weights change, [H].
        fixed: parameters that are not fitted, with their (bounded) values.
    """

    answers: Answers
    latents: tuple[Latent, ...]
    base: np.ndarray
    fixed: Mapping[str, float]

    @property
    def scales(self) -> dict[str, Scale]:
        own = {name: scale for name, scale in VIEWER.items() if name not in self.fixed}
        return own | {name: WEIGHT for latent in self.latents for name in latent.parameters}

    def viewer(self, values: dict[str, Array]) -> Viewer:
        """A viewer from unbounded parameters."""
        found = {name: jnp.asarray(value, float) for name, value in self.fixed.items()}
        found |= {name: VIEWER[name].bounded(values[name]) for name in VIEWER if name in values}
        log_prior = jnp.asarray(self.base, float)
        for latent in self.latents:
            weights = jnp.stack([values[name] for name in latent.parameters])
            log_prior = log_prior + jnp.asarray(latent.one_hot) @ (weights - weights.mean())
        return Viewer(found["sharpness"], found["forgetting"], log_prior - logsumexp(log_prior))

    def __call__(self, seen: Seen, values: dict[str, Array]) -> Array:
        return self.answers(seen, self.viewer(values))


@dataclass(frozen=True)
class Cues:
    """A baseline without any planning: the log odds of an answer are a weighted sum of what can be
    counted in a film, [C, F] in units of its standard deviation."""

    names: tuple[str, ...]

    @property
    def scales(self) -> dict[str, Scale]:
        return {"cue[always]": WEIGHT} | {f"cue[{name}]": WEIGHT for name in self.names}

    def __call__(self, seen: Array, values: dict[str, Array]) -> Array:
        weights = jnp.stack([values[f"cue[{name}]"] for name in self.names])
        return sigmoid(values["cue[always]"] + jnp.asarray(seen) @ weights)


class Asked(NamedTuple):
    """The rows of a table in arrays: R answers, C cells (a question about a script each).

    Attributes:
        person: [R], from 0.
        cell: of a slider its cell, [R, 1]; with choices those of their options, with pairs those of
            the two films, [R, K].
        options: how many options a choice has, [R]; 0 on a slider, PAIR of two films.
        answer: [R], between 0 and 1; of a choice which option, of two films whether the first.
    """

    person: Array
    cell: Array
    options: Array
    answer: Array


@dataclass(frozen=True)
class Model:
    """How people answer.

    Attributes:
        predictor: what is believed.
        people: how many there are.
        fixed: parameters of answers that are not fitted, with their values.
        varies: the parameters in which people differ; `prior` stands for all weights of latents'
            values, `cue` for those of cues, and `plan` for the way of planning.
        plans: how many ways of planning there are.
        cells: how many questions about scripts there are. Each has a deviation of its own from what
            viewers would answer, for the same few are put to all people, and no model is right
            (Clark 1973, DOI 10.1016/S0022-5371(73)80014-3).
    """

    predictor: Predictor
    people: int
    fixed: Mapping[str, float]
    varies: tuple[str, ...] = USUALLY_VARY
    plans: int = 1
    cells: int = 0

    @property
    def scales(self) -> dict[str, Scale]:
        """The parameters in their order, [D]."""
        own = {name: scale for name, scale in RESPONSE.items() if name not in self.fixed}
        return own | self.predictor.scales | dict.fromkeys(self.share_names, WEIGHT)

    @property
    def share_names(self) -> tuple[str, ...]:
        """The parameters that say how many people think that characters plan in which way; none
        where all think the same."""
        differ = self.plans > 1 and self.people > 1 and "plan" in self.varies
        return tuple(f"share[{number}]" for number in range(self.plans if differ else 0))

    @property
    def differing(self) -> tuple[str, ...]:
        """In which of the parameters people differ."""
        if self.people == 1:
            return ()
        return tuple(name for name in self.scales if name.partition("[")[0] in self.varies)

    def told(
        self, values: dict[str, Array], seen: Any, asked: Asked
    ) -> tuple[Array, dict[str, Array]]:
        """What people believe of each row's cells, [R, K], and how they answer, [R] each; `apart`
        is by how much two films differ besides.

        Args:
            values: unbounded; of what differs among people [P], else a number.
        """
        inner = {name: values[name] for name in self.predictor.scales}
        # What is the same for all is computed once.
        axes = {name: 0 if name in self.differing else None for name in inner}
        believed = lambda own: self.predictor(seen, own)
        if any(axis == 0 for axis in axes.values()):
            p = jax.vmap(believed, (axes,))(inner)[asked.person[:, None], asked.cell]
        else:
            p = believed(inner)[asked.cell]
        own = {name: jnp.asarray(value, float) for name, value in self.fixed.items()}
        for name in RESPONSE:
            if name in values:
                bounded = RESPONSE[name].bounded(values[name])
                own[name] = bounded[asked.person] if jnp.ndim(bounded) else bounded
        apart = jnp.zeros(())
        if "deviation" in values:
            each = values["deviation"][asked.cell]
            own["bias"] = own["bias"] + each[:, 0]
            apart = each[:, 0] - each[:, -1]
        own["apart"] = apart
        rows = len(asked.person)
        return p, {name: jnp.broadcast_to(value, (rows,)) for name, value in own.items()}

    def log_likelihoods(self, values: dict[str, Array], seen: Any, asked: Asked) -> Array:
        """log P(answer) of each row, [R]."""
        p, own = self.told(values, seen, asked)
        slider = log_slider(asked.answer, p[:, 0], own)
        if p.shape[1] == 1:
            return slider
        pair = log_pair(asked.answer, p, own)
        choice = log_choice(asked.answer.astype(int), p, asked.options, own)
        there = [asked.options > 0, asked.options == PAIR]
        return jnp.select(there, [choice, pair], slider)

    def expected(self, values: dict[str, Array], seen: Any, asked: Asked) -> Array:
        """What is expected of answers to questions like those of the rows, [R, K]: first the mean
        of a slider, or how often the first of two films is chosen; of a choice how often each of
        its options is."""
        usual = {name: value for name, value in values.items() if name != "deviation"}
        p, own = self.told(usual, seen, asked)
        several = p.shape[1] > 1

        def mean(away: Array) -> Array:
            slider = slider_mean(p[:, 0], own | {"bias": own["bias"] + away})
            if not several:
                return slider
            # Two films lie apart by the difference of two such deviations.
            pair = jnp.exp(log_pair(1.0, p, own | {"apart": own["apart"] + np.sqrt(2) * away}))
            return jnp.where(asked.options == PAIR, pair, slider)

        if "misfit" in values:
            places, weights = normal_points(9)
            means = jax.vmap(mean)(values["misfit"] * jnp.asarray(places))
            first = weights @ means
        else:
            first = mean(jnp.zeros(()))
        if not several:
            return first[:, None]
        option = jnp.broadcast_to(jnp.arange(p.shape[1])[:, None], p.shape[::-1])
        chosen = jax.vmap(lambda which: log_choice(which, p, asked.options, own))(option)
        return jnp.where((asked.options > 0)[:, None], jnp.exp(chosen.T), first[:, None])

    def groups(self, asked: Asked) -> tuple[Array, int]:
        """Whose answers are given under one way of planning, [R], and how many groups there are:
        each person's own, or everybody's."""
        if self.share_names:
            return asked.person, self.people
        return np.zeros(len(asked.answer), int), 1

    def log_shares(self, values: dict[str, Array]) -> Array:
        """log of the share of each way of planning, [N]; all the same where nobody differs."""
        if not self.share_names:
            return jnp.full(self.plans, -np.log(self.plans))
        return jax.nn.log_softmax(jnp.stack([values[name] for name in self.share_names]))

    def by_plan(
        self, values: dict[str, Array], nodes: Any, asked: Asked, counted: Array | float = 1.0
    ) -> tuple[Array, Array]:
        """log P(answer) of each row under each way of planning, [N, R], and log P(a group's
        answers and that it thinks of this way), [N, G].

        Args:
            nodes: what is seen under each way.
            counted: the weight of each row, [R]; all are alike without it.
        """
        group, count = self.groups(asked)
        rows = jax.lax.map(lambda seen: self.log_likelihoods(values, seen, asked), nodes)
        together = jax.vmap(lambda row: jax.ops.segment_sum(row * counted, group, count))(rows)
        return rows, together + self.log_shares(values)[:, None]

    def log_answers(
        self, values: dict[str, Array], nodes: Any, asked: Asked, counted: Array | float = 1.0
    ) -> Array:
        """log P(all answers), with the ways of planning summed out."""
        return logsumexp(self.by_plan(values, nodes, asked, counted)[1], axis=0).sum()

    def program(self, nodes: Any, asked: Asked) -> None:
        """The model as NumPyro runs it."""
        numpyro.factor("answers", self.log_answers(self.drawn(), nodes, asked))

    def drawn(self) -> dict[str, Array]:
        scales = self.scales
        mean, sd = (np.array([scale[k] for scale in scales.values()]) for k in (1, 2))
        sites = {"mean": numpyro.sample("mean", dist.Normal(mean, sd).to_event(1))}
        if self.differing:
            wide = np.array([scales[name].spread for name in self.differing])
            sites["spread"] = numpyro.sample("spread", dist.HalfNormal(wide).to_event(1))
            shape = (self.people, len(wide))
            sites["own"] = numpyro.sample("own", dist.Normal(0.0, 1.0).expand(shape).to_event(2))
        if self.cells:
            each = dist.Normal(0.0, 1.0).expand((self.cells,)).to_event(1)
            sites["misfit"] = numpyro.sample("misfit", dist.HalfNormal(MISFIT))
            sites["deviation"] = numpyro.sample("deviation", each)
        return self.values(sites)

    def values(self, sites: Mapping[str, Array]) -> dict[str, Array]:
        """Unbounded parameters from a draw of the model's sites: [P] of what differs, else a
        number."""
        found = {name: sites["mean"][number] for number, name in enumerate(self.scales)}
        for number, name in enumerate(self.differing):
            found[name] = found[name] + sites["spread"][number] * sites["own"][:, number]
        if self.cells:
            found["misfit"] = sites["misfit"]
            found["deviation"] = sites["misfit"] * sites["deviation"]
        return found
