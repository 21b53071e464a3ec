"""From a table of people's judgements to an audience: `i2p fit`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

import jax
import numpy as np

from i2pdsl.fit.cues import cues
from i2pdsl.fit.model import USUALLY_VARY, VIEWER, Asked, Cues, Model, Watching
from i2pdsl.fit.questions import Study, Value
from i2pdsl.fit.sampling import Draws, Report, alike, draw, modes
from i2pdsl.fit.viewers import Answers, Watched, what_is_seen
from i2pdsl.language.story import check_listed
from i2pdsl.programs import once
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.ready import ready_world
from i2pdsl.worlds.world import Viewer as SpecViewer

Array = Any
Plan = tuple[tuple[str, Value], ...]
"""How characters plan in a node of the grid: settings of the world with their values."""

MOST_WORSE = 20.0  # nats by which a way of planning may be worse than the best, and still count


@dataclass(frozen=True)
class Fitted:
    """What people's judgements say of them.

    Attributes:
        plans: the ways of planning that were considered.
        nodes: what is seen under each of them (viewers.Seen, stacked).
    """

    study: Study
    model: Model
    plans: tuple[Plan, ...]
    nodes: Any = field(repr=False)
    draws: Draws = field(repr=False)


def seen_under(study: Study, plan: Plan, watch: Watch | None = None) -> tuple[list[Watched], Any]:
    """The scripts as viewers see them who think that characters plan in this way."""
    watched = []
    check_listed(study.words, "a fit")
    for script in study.scripts.values():
        spec = script.world.spec.with_settings(dict(plan))
        watched.append(Watched(ready_world(spec, (SpecViewer(spec),), watch), script.trajectory))
    return watched, what_is_seen(watched)


def fit(
    study: Study,
    grid: Mapping[str, Sequence[float]] | None = None,
    fixed: Mapping[str, float] | None = None,
    settings: Mapping[str, Value] | None = None,
    varies: tuple[str, ...] | None = None,
    chains: int = 4,
    warmup: int = 400,
    draws: int = 400,
    seed: int = 0,
    watch: Watch | None = None,
    report: Report | None = None,
) -> Fitted:
    """Fits an audience to judgements. Call it while JAX may compute (computing.py).

    Args:
        grid: settings of how characters plan, each with the values that are tried; all
            combinations are planned, and which of them holds is summed out.
        fixed: parameters that are not fitted, by their names in model.py.
        settings: of the world as viewers believe it works.
        varies: the parameters in which people differ, if not in those of model.USUALLY_VARY.

    Raises KeyboardInterrupt before there is anything to tell.
    """
    base = tuple((settings or {}).items())
    plans = [
        (*base, *zip(grid or (), each, strict=True)) for each in product(*(grid or {}).values())
    ]
    watched, seen = [], []
    for plan in plans:
        those, what = seen_under(study, plan, watch)
        watched.append(those)
        seen.append(what)
    seen = _with_one_chain(seen)
    first = watched[0]
    answers = Answers(first, study.questions)
    log_prior = first[0].world.log_prior(first[0].world.tables)[0]
    given = study.unused | dict(fixed or {})
    own = {name: given.pop(name) for name in list(given) if name in VIEWER}
    watching = Watching(answers, study.latents, np.asarray(log_prior), own)
    own_ones = USUALLY_VARY if varies is None else varies
    model = Model(watching, len(study.people), given, own_ones, cells=study.deviating)
    nodes = jax.tree.map(lambda *parts: np.stack(parts), *seen)
    if len(plans) > 1:
        kept = _plausible(model, nodes, study.asked)
        plans, nodes = [plans[i] for i in kept], jax.tree.map(lambda part: part[kept], nodes)
        model = replace(model, plans=len(plans))
    found = draw(model, nodes, study.asked, chains, warmup, draws, seed, report)
    return Fitted(study, model, tuple(plans), nodes, found)


def _with_one_chain(seen: list[Any]) -> list[Any]:
    """What is seen under several plans, if some of them have goals that change: under the others
    they never do."""
    some = next((each.switching for each in seen if each.switching), ())
    never = tuple(each._replace(share=0 * each.share) for each in some)
    return [each._replace(switching=each.switching or never) for each in seen]


def fit_cues(
    study: Study,
    expressions: Sequence[str],
    chains: int = 4,
    warmup: int = 400,
    draws: int = 400,
    seed: int = 0,
    report: Report | None = None,
) -> Fitted:
    """Fits what can be counted in a film (cues.py) to the same judgements, as a baseline."""
    answering = {"slope": 1.0, "bias": 0.0}  # weights do the same
    own = Cues(tuple(expressions))
    model = Model(own, len(study.people), study.unused | answering, cells=study.deviating)
    nodes = cues(study.scripts, study.questions, expressions)[None]
    found = draw(model, nodes, study.asked, chains, warmup, draws, seed, report)
    return Fitted(study, model, ((),), nodes, found)


def _plausible(model: Model, nodes: Any, asked: Asked) -> list[int]:
    """The ways of planning that explain the answers about as well as the best does, or, where
    people differ in them, the answers of somebody: to sum over the others costs time for nothing.
    """
    count = len(jax.tree.leaves(nodes)[0])
    each = jax.tree.map(lambda part: part[:, None], nodes)
    every = np.ones(len(asked.answer))
    points = modes(model, each, asked, np.tile(every, (count, 1)))
    group, groups = replace(model, plans=count).groups(asked)
    row = lambda fit: model.log_likelihoods(alike(model, fit[0]), fit[1], asked)
    rows = np.asarray(once(lambda fits: jax.lax.map(row, fits), (points, nodes)))
    totals = np.array([np.bincount(group, row, groups) for row in rows])  # [N, G]
    if groups == 1:
        return list(np.flatnonzero(totals[:, 0] > totals.max() - MOST_WORSE))
    explained = np.exp(totals - totals.max(0))
    explained /= explained.sum(0)
    return list(np.flatnonzero(explained.sum(1) > 0.5))
