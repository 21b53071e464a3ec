"""The audience of a fit as viewers whom stories can be told to."""

from __future__ import annotations

from collections.abc import Mapping

import jax.numpy as jnp
import numpy as np

from i2pdsl.fit.model import Watching
from i2pdsl.fit.report import Report
from i2pdsl.language.people import Person


def people(report: Report, viewers: int) -> tuple[Person, ...]:
    """One viewer where people do not differ in what they believe, else `viewers` of them, each for
    as many people: those who think that characters plan alike stand together, and among them those
    who are alike along the line in which people differ most."""
    fitted = report.fitted
    watching = fitted.model.predictor
    assert isinstance(watching, Watching), "cues believe nothing"
    model, sites = fitted.model, fitted.draws.sites
    mean = {name: s.mean((0, 1)) for name, s in sites.items()}
    values = {n: np.asarray(v) for n, v in model.values(mean).items()}
    everybody = np.arange(model.people)
    plan = np.broadcast_to(report.plan_weights.argmax(0), model.people)
    differ = [name for name in watching.scales if name in model.differing]
    place = np.zeros(model.people)
    if differ:
        table = np.stack([values[name] for name in differ], axis=1)
        centred = table - table.mean(0)
        place = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
    groups = [everybody]
    if differ or len(set(plan)) > 1:
        groups = np.array_split(np.lexsort((place, plan)), viewers)
    found = []
    for group in groups:
        if not len(group):
            continue
        own = {n: values[n][group].mean() if n in differ else values[n] for n in watching.scales}
        settings = fitted.plans[int(np.bincount(plan[group]).argmax())]
        found.append(person(watching, own, dict(settings)))
    return tuple(found)


def person(
    watching: Watching, own: Mapping[str, np.ndarray], settings: Mapping[str, float]
) -> Person:
    """The viewer with (unbounded) parameters, who thinks that characters plan in a certain way."""
    viewer = watching.viewer({name: jnp.asarray(value, float) for name, value in own.items()})
    prior = {
        latent.name: {
            value: float(np.exp(own[name] - np.mean([own[n] for n in latent.parameters])))
            for value, name in zip(latent.values, latent.parameters, strict=True)
        }
        for latent in watching.latents
    }
    return Person(float(viewer.sharpness), float(viewer.forgetting), prior, settings)
