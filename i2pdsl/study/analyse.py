"""What people's answers come to: the shares of matching answers as for a panel (study/analysis.py),
the same by the mixed-effects model (study/mixed.py), and by participant."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from i2pdsl.fit.judgements import OTHER
from i2pdsl.study.analysis import LEVEL, Share, flipped
from i2pdsl.study.answers import Answers
from i2pdsl.study.people import FAILED, PARTIAL, Collected
from i2pdsl.study.report import aligned, ends, given_in_words, in_words, percent
from i2pdsl.study.spec import PAIR, SLIDER, Study

RHAT, ENOUGH = 1.05, 100.0  # what chains must reach


@dataclass(frozen=True)
class Effect:
    """A share by the mixed-effects model: of a new person about a new film.

    Attributes:
        difference: to the baseline, or to chance, with its interval; None where there is none.
        more: the probability that the share is above that of the baseline.
        films: the standard deviation of films, in log odds.
    """

    group: str
    method: str
    share: float
    low: float
    high: float
    difference: tuple[float, float, float] | None
    more: float | None
    films: float


@dataclass(frozen=True)
class Mixed:
    """What the model says of all groups.

    Attributes:
        people, tastes: standard deviations in log odds: of people everywhere, and in each group.
    """

    effects: tuple[Effect, ...]
    people: float
    tastes: float
    rhat: float
    ess: float

    @property
    def has_converged(self) -> bool:
        return self.rhat <= RHAT and self.ess >= ENOUGH


def columns_of(answers: Answers, share: Share) -> np.ndarray:
    """The films of a group by a method, by their numbers among the items."""
    own = [(i.group, i.method) == (share.group, share.method) for i in answers.items]
    return np.flatnonzero(own)


def mixed_matters(answers: Answers) -> bool:
    """Whether there are people and films enough to tell them apart."""
    cells = {(item.group, item.method) for item in answers.items}
    return len(answers.participants) > 2 and len(answers.items) > len(cells)


def mixed(answers: Answers, shares: Sequence[Share], seed: int = 0) -> Mixed:
    """The model's shares. Call it while JAX may compute (computing.py)."""
    from i2pdsl.study.mixed import estimate

    cell = np.zeros(len(answers.items), int)
    for number, share in enumerate(shares):
        cell[columns_of(answers, share)] = number
    found = estimate(answers.matches, cell, seed)
    place = {(share.group, share.method): n for n, share in enumerate(shares)}
    effects = []
    for number, share in enumerate(shares):
        own, versus = found.share[:, number], share.comparison
        difference, more = None, None
        if versus is not None:
            known = place.get((share.group, versus.against))
            apart = own - (0.5 if known is None else found.share[:, known])
            difference, more = _interval(apart), float((apart > 0).mean())
        effects.append(
            Effect(
                share.group,
                share.method,
                *_interval(own),
                difference,
                more,
                float(found.films[:, number].mean()),
            )
        )
    spreads = float(found.people.mean()), float(found.tastes.mean())
    return Mixed(tuple(effects), *spreads, found.rhat, found.ess)


def _interval(draws: np.ndarray) -> tuple[float, float, float]:
    """Mean, and the ends of the central interval."""
    low, high = np.quantile(draws, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return float(draws.mean()), float(low), float(high)


def by_participant(answers: Answers) -> dict[str, dict[str, float]]:
    """How many answers each gave, and the share of them that match."""
    matches = answers.matches
    return {
        name: {
            "answers": int((~np.isnan(own)).sum()),
            "share": float(np.nanmean(own)),
        }
        for name, own in zip(answers.participants, matches, strict=True)
    }


def p_by_people(answers: Answers, shares: Sequence[Share], seed: int = 0) -> list[float | None]:
    """For each share p of its difference to the baseline by a test over participants: each one's
    own difference may as well have the other sign."""
    generator, matches = np.random.default_rng(seed), answers.matches
    means = {}
    for share in shares:
        own = matches[:, columns_of(answers, share)]
        count = (~np.isnan(own)).sum(1)
        right = np.nansum(own, axis=1)
        means[share.group, share.method] = np.where(count, right / np.maximum(count, 1), np.nan)
    found: list[float | None] = []
    for share in shares:
        if share.comparison is None:
            found.append(None)
            continue
        own = means[share.group, share.method]
        other = means.get((share.group, share.comparison.against), np.full(len(own), 0.5))
        apart = (own - other)[~np.isnan(own - other)]
        found.append(flipped(generator, apart) if len(apart) else None)
    return found


def joined(collected: Collected, folder: Path) -> dict[str, list[Any]]:
    """All answers that count as one table for a folder, which `i2p fit` reads, too: with what each
    film is, and what the tables have in further columns."""
    study, pairs = collected.answers.study, collected.answers.study.question.kind == PAIR
    more = list(dict.fromkeys(name for row in collected.rows for name in row.more))
    told = ("participant", "script", OTHER, "frame", "question", "answer", "condition", "method")
    names = [name for name in told if pairs or name != OTHER]
    names += ["seed", "right", *(name for name in more if name not in (*names, "seed", "right"))]
    found: dict[str, list[Any]] = {name: [] for name in names}
    rows = zip(collected.rows, collected.items, collected.folders, strict=True)
    for row, item, place in rows:
        path = lambda name, place=place: Path(os.path.relpath(place / name, folder)).as_posix()
        answer = row.answer
        if study.question.kind == SLIDER:
            answer = round(100 * float(row.answer), 6)
        cells = dict(row.more) | {
            "participant": row.participant,
            **{column: path(name) for column, name in row.scripts},
            "frame": "T" if row.frame is None else row.frame,
            "question": row.question,
            "answer": answer,
            "condition": item.group,
            "method": item.method,
            "seed": item.films[0].seed,
            "right": item.right,
        }
        for name in names:
            found[name].append(cells.get(name, ""))
    return found


# ------------------------------------------------------------------------------------ in words


def told(
    collected: Collected,
    shares: Sequence[Share],
    people: Sequence[float | None],
    model: Mixed | None,
) -> str:
    """The whole report."""
    answers = collected.answers
    study = answers.study
    count = int((~np.isnan(answers.given)).sum())
    parts = [
        f"{study.title}: {count:,} answers of {len(answers.participants):,} people "
        f"to {len(answers.items):,} {'pairs' if study.pairs else 'films'}",
        _excluded(collected),
        in_words(study, shares),
        given_in_words(study, shares),
    ]
    if model is not None:
        parts.append(_mixed(study, model, people))
    each = np.array([each["share"] for each in by_participant(answers).values()])
    parts.append(
        f"by participant: from {percent(each.min())} to {percent(each.max())} match, "
        f"half of them {percent(float(np.median(each)))} or more"
    )
    return "\n\n".join(part for part in parts if part)


def _excluded(collected: Collected) -> str:
    why = {
        FAILED: "failed an attention check and",
        PARTIAL: "stopped early and",
    }
    lines = [
        f"{len(names)} {why[reason]} {'does' if len(names) == 1 else 'do'} not count: "
        + ", ".join(names[:8])
        + (", ..." if len(names) > 8 else "")
        for reason, names in collected.excluded.items()
    ]
    if collected.twice:
        lines.append(f"of {collected.twice} answers to what was answered already the first counts")
    return "\n".join(lines)


def _mixed(study: Study, model: Mixed, people: Sequence[float | None]) -> str:
    groups = {group.name: group.label for group in study.groups}
    methods = {method.name: method.label for method in study.methods}
    heads = ("match", "95 %", "films differ", "difference", "95 %", "P(more)", "p by people")
    rows = [("new people, new films", *heads)]
    for effect, p in zip(model.effects, people, strict=True):
        name = groups[effect.group]
        if len(study.methods) > 1:
            name = f"{name}, {methods[effect.method]}"
        interval, spread = ends(effect.low, effect.high), f"{effect.films:.2g}"
        row = (name, percent(effect.share), interval, spread)
        if effect.difference is None or effect.more is None:
            rows.append((*row, "", "", "", ""))
        else:
            apart, low, high = effect.difference
            test = "" if p is None else f"{p:.2g}"
            rows.append((*row, f"{100 * apart:+.0f}", ends(low, high), f"{effect.more:.3f}", test))
    return (
        f"{aligned(rows)}\n\nin log odds people differ by {model.people:.2g}, and by "
        f"{model.tastes:.2g} more in each row (standard deviations, as those of films)"
    )


def as_json(
    collected: Collected,
    shares: Sequence[Share],
    people: Sequence[float | None],
    model: Mixed | None,
) -> dict[str, Any]:
    """The document of `i2p study --analyse --json`."""
    answers = collected.answers
    return {
        "study": answers.study.name,
        "participants": len(answers.participants),
        "answers": int((~np.isnan(answers.given)).sum()),
        "excluded": {why: list(names) for why, names in collected.excluded.items()},
        "twice": collected.twice,
        "shares": [
            share.as_json() | {"p_people": p} for share, p in zip(shares, people, strict=True)
        ],
        "mixed": None if model is None else asdict(model) | {"converged": model.has_converged},
        "by_participant": by_participant(answers),
    }
