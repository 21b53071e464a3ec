"""What a fit says: estimates with intervals, whether the chains agree, how well people's answers
are predicted, and the audience as a file."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.answers import optional
from i2pdsl.fit.answering import SD, placed
from i2pdsl.fit.fit import Fitted
from i2pdsl.fit.model import RESPONSE, VIEWER, Watching
from i2pdsl.language.vocabulary import show_value
from i2pdsl.programs import once
from i2pdsl.resources import atomic_path

Array = Any

AGREE = 1.05  # the largest R-hat of chains that agree
ENOUGH = 50.0  # effective draws, at least, of each estimate
INTERVAL = (5.0, 95.0)  # percent
MOST = 200  # draws that predictions are made from


@dataclass(frozen=True)
class Estimate:
    """A parameter of the group: posterior mean and 90 % interval, R-hat, effective draws."""

    mean: float
    low: float
    high: float
    rhat: float
    ess: float


@dataclass(frozen=True)
class Cell:
    """A question about a script, or about two: how many were asked, the mean of their answers with
    a 90 % interval by the bootstrap, and that of the model with the posterior's interval. Of two
    scripts it is the share of those who chose the first, of a choice that of a `label`."""

    script: str
    other: str | None
    question: str
    frame: int
    label: str | None
    count: int
    people: float
    people_low: float
    people_high: float
    model: float
    model_low: float
    model_high: float


class Report:
    """A fit, looked at. Computed at its first use; call it while JAX may compute."""

    def __init__(self, fitted: Fitted):
        self.fitted = fitted

    # Estimates.

    @cached_property
    def group(self) -> dict[str, np.ndarray]:
        """The group's parameters as they are read, [chains, draws] each: bounded, and for each
        latent the prior probability of its values."""
        model, sites = self.fitted.model, self.fitted.draws.sites
        found = {}
        unbounded = {name: sites["mean"][..., i] for i, name in enumerate(model.scales)}
        for name, values in unbounded.items():
            if name in RESPONSE or name in VIEWER or name.startswith("cue["):
                found[name] = np.asarray(model.scales[name].bounded(values))
        watching = model.predictor
        if isinstance(watching, Watching):
            viewer = lambda values: watching.viewer(values).log_prior
            log_prior = once(jax.vmap(jax.vmap(viewer)), unbounded)
            if model.share_names:
                log_shares = once(jax.vmap(jax.vmap(model.log_shares)), unbounded)
                shares = np.exp(np.asarray(log_shares))
                for number, plan in enumerate(self.fitted.plans):
                    found[f"share[{plan_in_words(dict(plan))}]"] = shares[..., number]
            for latent in watching.latents:
                share = np.exp(np.asarray(log_prior)) @ latent.one_hot
                share /= share.sum(-1, keepdims=True)
                found |= {
                    f"P({latent.name} = {v})": share[..., i] for i, v in enumerate(latent.values)
                }
        if model.cells:
            found["misfit"] = sites["misfit"]
        for number, name in enumerate(model.differing):
            found[f"spread[{name}]"] = sites["spread"][..., number]
        return found

    @cached_property
    def estimates(self) -> dict[str, Estimate]:
        arviz = _arviz()
        found = {}
        for name, draws in self.group.items():
            low, high = np.percentile(draws, INTERVAL)
            rhat, ess = arviz.rhat(draws), arviz.ess(draws)
            figures = (draws.mean(), low, high, rhat, ess)
            found[name] = Estimate(*map(float, figures))
        return found | self._planning()

    def _planning(self) -> dict[str, Estimate]:
        """The settings of planning that were summed out: their posterior is that of the nodes;
        where people differ in them, their distribution among people."""
        plans, weights = self.fitted.plans, self.plan_weights.mean(1)
        found = {}
        for name in dict(plans[0]):
            values = np.array([dict(plan)[name] for plan in plans])
            if len(set(values)) == 1:
                continue
            order = np.argsort(values)
            share = np.cumsum(weights[order])
            low, high = (float(values[order][np.searchsorted(share, q / 100)]) for q in INTERVAL)
            count = float(self.fitted.draws.diverging.size)
            found[name] = Estimate(float(weights @ values), low, high, 1.0, count)
        return found

    @property
    def disagreements(self) -> list[str]:
        """What shows that the chains did not converge; nothing if they did."""
        if len(self.fitted.draws.diverging) < 2:
            return ["one chain alone does not show it: `--chains 2`, or more"]
        told = []
        for name, estimate in self.estimates.items():
            if not estimate.rhat <= AGREE:
                told.append(f"R-hat of {name} is {estimate.rhat:.4f}, above {AGREE:g}")
            elif not estimate.ess >= ENOUGH:
                told.append(f"{name} has {estimate.ess:.0f} effective draws, fewer than {ENOUGH:g}")
        return told

    @property
    def is_thin(self) -> str | None:
        """What is to be said where there are too few answers to learn from."""
        count, own = len(self.fitted.study.asked.answer), len(self.fitted.model.scales)
        if count > 3 * own:
            return None
        return f"{count} answers for {own} parameters: most of what is estimated was thought before"

    # Predictions.

    @cached_property
    def some(self) -> dict[str, np.ndarray]:
        """M draws that are spread over all chains, [M, ...] of each site."""
        sites = self.fitted.draws.sites
        flat = {name: s.reshape(-1, *s.shape[2:]) for name, s in sites.items()}
        total = len(flat["mean"])
        chosen = np.unique(np.linspace(0, total - 1, min(total, MOST)).astype(int))
        return {name: s[chosen] for name, s in flat.items()}

    @cached_property
    def _predicted(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For some draws what is expected of each row, [M, R, K], log P(answer | all the others),
        [M, R], and how likely each way of planning is for whom, [M, N, G]."""
        fitted = self.fitted
        model, asked, nodes = fitted.model, fitted.study.asked, fitted.nodes
        group, _ = model.groups(asked)

        def one(sites: dict[str, Array]) -> tuple[Array, Array, Array]:
            values = model.values(sites)
            means = jax.lax.map(lambda node: model.expected(values, node, asked), nodes)
            logs, together = model.by_plan(values, nodes, asked)
            weights = jax.nn.softmax(together, axis=0)
            own = together[:, group]
            without = jax.nn.logsumexp(own, axis=0) - jax.nn.logsumexp(own - logs, axis=0)
            return (weights[:, group, None] * means).sum(0), without, weights

        found = once(lambda draws: jax.lax.map(one, draws), self.some)
        means, logs, weights = map(np.asarray, found)
        return means, logs, weights

    @property
    def plan_weights(self) -> np.ndarray:
        """The posterior probability of each way of planning, [N, G]: of each person, or of all."""
        weights: np.ndarray = self._predicted[2].mean(0)
        return weights

    @cached_property
    def cells(self) -> tuple[Cell, ...]:
        """What was asked, beside what was answered."""
        study = self.fitted.study
        means, asked, scale = self._predicted[0], study.asked, study.scale
        generator = np.random.default_rng(0)
        found = []
        for rows in study.alike:
            first = study.judgements[rows[0]]
            labels: list[str | None] = [None]
            shares = asked.answer[rows][:, None]
            if asked.options[rows[0]] > 0:
                labels = list(study.labels_of(first))
                shares = asked.answer[rows][:, None] == np.arange(len(labels))
            where = [study.labels[cell] for cell in asked.cell[rows[0]]]
            other = where[1][0] if first.other is not None else None
            again = generator.integers(len(rows), size=(2000, len(rows)))
            for number, label in enumerate(labels):
                answers = scale * shares[:, number]
                model = scale * means[:, rows, number].mean(1)
                figures = (
                    answers.mean(),
                    *np.percentile(answers[again].mean(1), INTERVAL),
                    model.mean(),
                    *np.percentile(model, INTERVAL),
                )
                told = (where[0][0], other, first.question, where[0][2], label, len(rows))
                found.append(Cell(*told, *map(float, figures)))
        return tuple(found)

    @property
    def agreement(self) -> tuple[float, float]:
        """r and RMSE of the model's means and people's, over the cells."""
        people = np.array([cell.people for cell in self.cells])
        model = np.array([cell.model for cell in self.cells])
        return agreement(people, model)

    @cached_property
    def predictive(self) -> dict[str, float]:
        """Posterior predictive checks: the share of answers within the model's 90 % intervals, and
        the share of answers at an end of the slider, of people and of the model."""
        study = self.fitted.study
        generator = np.random.default_rng(0)
        rows = np.flatnonzero(study.asked.options == 0)
        if not len(rows):
            return {}
        drawn = np.stack([_again(*draw, generator)[rows] for draw in self._placed])
        low, high = np.percentile(drawn, INTERVAL, axis=0)
        answers = study.asked.answer[rows]
        inside = (answers >= low - 1e-9) & (answers <= high + 1e-9)
        ends = lambda array: float(((array < 0.005) | (array > 0.995)).mean())
        return {
            "within_90": float(inside.mean()),
            "at_ends_people": ends(answers),
            "at_ends_model": ends(drawn),
        }

    @property
    def _placed(self) -> list[tuple[np.ndarray, dict[str, np.ndarray]]]:
        """For some draws, where each row's belief is placed, and how its person answers, [R] each;
        under the way of planning that is likeliest for him."""
        model, asked, nodes = self.fitted.model, self.fitted.study.asked, self.fitted.nodes
        group, _ = model.groups(asked)
        plan = self.plan_weights.argmax(0)[group]

        def one(sites: dict[str, Array]) -> tuple[Array, dict[str, Array]]:
            values = model.values(sites)
            told, own = jax.lax.map(lambda node: model.told(values, node, asked), nodes)
            own = {name: each[0] for name, each in own.items()}
            return placed(told[plan, jnp.arange(len(plan)), 0], own), own

        found = once(lambda draws: jax.lax.map(one, draws), self.some)
        middle, own = jax.tree.map(np.asarray, found)
        return [(m, {name: each[i] for name, each in own.items()}) for i, m in enumerate(middle)]

    # Comparison.

    @cached_property
    def data(self) -> Any:
        """Everything as an arviz.InferenceData: the group's parameters, people's own, and the
        log-likelihood of each row."""
        arviz = _arviz()
        study, draws = self.fitted.study, self.fitted.draws
        chains = draws.sites["mean"].shape[0]
        own = {}
        if "own" in draws.sites:
            own["own"] = draws.sites["own"]
        logs = self._predicted[1]
        each = len(logs) // chains
        logs = logs[: chains * each].reshape(chains, each, -1)
        rows, of_rows = study.judgements, ("participant", "script", "frame", "question")
        data = arviz.from_dict(
            posterior={**self.group, **own},
            observed_data={"answer": study.asked.answer},
            sample_stats={"diverging": draws.diverging},
            constant_data={n: [str(getattr(row, n)) for row in rows] for n in of_rows},
            coords={
                "person": list(study.people),
                "parameter": list(self.fitted.model.differing),
                "row": np.arange(1, len(rows) + 1),
            },
            dims={"own": ["person", "parameter"], **{n: ["row"] for n in ("answer", *of_rows)}},
        )
        of_answers = arviz.dict_to_dataset(
            {"answer": logs}, coords={"row": data.observed_data["row"]}, dims={"answer": ["row"]}
        )
        data.add_groups(log_likelihood=of_answers)
        return data

    @cached_property
    def loo(self) -> dict[str, float]:
        """Leave-one-out cross-validation by Pareto smoothing (Vehtari, Gelman and Gabry 2017, DOI
        10.1007/s11222-016-9696-4) and WAIC, in nats: `loo`, its standard error, `p_loo`, `bad`,
        the share of rows whose Pareto k is above .7, and `waic`."""
        loo, waic = self._left_out
        return {
            "loo": float(loo.elpd_loo),
            "se": float(loo.se),
            "p_loo": float(loo.p_loo),
            "bad": float((loo.pareto_k > 0.7).mean()),
            "waic": float(waic.elpd_waic),
        }

    @cached_property
    def _left_out(self) -> tuple[Any, Any]:
        arviz = _arviz()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return arviz.loo(self.data, pointwise=True), arviz.waic(self.data)

    @property
    def left_out(self) -> np.ndarray:
        """log of the probability of each answer by a model that was fitted to the others, [R]."""
        found: np.ndarray = np.asarray(self._left_out[0].loo_i.values)
        return found

    def as_json(self) -> dict[str, Any]:
        """The document of `i2p fit --json`."""
        r, rmse = self.agreement
        return {
            "estimates": {name: vars(each) for name, each in self.estimates.items()},
            "r": r,
            "rmse": rmse,
            "loo": self.loo,
            "predictive": self.predictive,
            "divergences": int(self.fitted.draws.diverging.sum()),
            "converged": not self.disagreements,
            "finished": self.fitted.draws.finished,
            "people": len(self.fitted.study.people),
            "answers": len(self.fitted.study.asked.answer),
            "cells": [vars(cell) for cell in self.cells],
        }

    def save(self, path: Path) -> None:
        """Writes what ArviZ reads, atomically."""
        with atomic_path(path) as temporary:
            self.data.to_netcdf(str(temporary), engine="h5netcdf")


def _arviz() -> Any:
    """The library, without what it says once a day of its own future."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return optional("arviz", "fit")


def agreement(people: np.ndarray, model: np.ndarray) -> tuple[float, float]:
    """Pearson's r and the root of the mean squared difference."""
    rmse = float(np.sqrt(np.mean((people - model) ** 2))) if len(people) else float("nan")
    if len(people) < 2 or not people.std() or not model.std():
        return float("nan"), rmse
    return float(np.corrcoef(people, model)[0, 1]), rmse


def plan_in_words(plan: Mapping[str, float | str]) -> str:
    """A way of planning: `beta = 2, gamma = 0.9`."""
    return ", ".join(f"{name} = {show_value(value)}" for name, value in plan.items())


def _again(
    middle: np.ndarray, own: dict[str, np.ndarray], generator: np.random.Generator
) -> np.ndarray:
    """Answers as the model would give them where beliefs are placed so, [R]."""
    odds = middle + generator.logistic(size=len(middle)) * own["noise"] / SD
    lapses = generator.random(len(middle)) < own["lapse"]
    anywhere = generator.random(len(middle))
    answers = 1 / (1 + np.exp(-np.clip(odds, -30, 30)))
    found: np.ndarray = np.where(lapses, anywhere, answers).round(2)
    return found
