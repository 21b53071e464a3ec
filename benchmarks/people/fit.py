"""The audience against people's judgements of helping and hindering: docs/people.md's figures.

    python benchmarks/people/fit.py DATA [--out FOLDER]

DATA is the folder of Wu, Sridhar and Gerstenberg 2023 (see convert.py). Every trial is predicted by
an audience that was fitted to the others: how many of the viewers think that characters plan in
which of the ways in NODES, how sharply they expect them to choose, what they forget and thought
before, and how they answer, where the posterior is highest if people are alike in all but the way
of planning. The baseline of cues is fitted in the same way, and what both predict is pooled.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import jax
import numpy as np
from convert import convert

from i2pdsl.computing import computing
from i2pdsl.fit.audience import person
from i2pdsl.fit.cues import cues
from i2pdsl.fit.fit import seen_under
from i2pdsl.fit.judgements import read_judgements
from i2pdsl.fit.model import Asked, Cues, Model, Watching
from i2pdsl.fit.odds import log_odds, logistic
from i2pdsl.fit.questions import Study, study
from i2pdsl.fit.report import agreement, plan_in_words
from i2pdsl.fit.sampling import alike, modes
from i2pdsl.fit.viewers import Answers
from i2pdsl.language.people import Person, written

NOBODY = "nobody"
QUESTION = "P(rho > 0 | script[:T])"
NODES = [
    {"move": move, "stay": move / 5, "end": end, "gamma": 0.99, "beta": beta}
    for move, end, beta in product((-0.25, -0.5, -1.0), (5.0, 10.0), (2.0, 4.0))
]
VIEWERS = 10  # of the file, about
CUES = (
    "mean_t [idle(blue) @ script[t]]",
    "[distance(red, star) @ script[T]]",
    "[distance(blue, red) @ script[T]]",
    "T",
)


def predicted(
    model: Model, nodes: Any, asked: Asked, rated: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Each trial's mean by the model that was fitted to the others, and by the one that was fitted
    to all, [trials] each; and the parameters of that, [D].

    Args:
        nodes: what is seen under each way of planning.
        rated: the trials of which there are ratings, [trials]; the others have an answer that
            stands for none.
    """
    trials = len(rated)
    known = rated[asked.cell[:, 0]]
    # The last fold has all.
    folds = [known & (asked.cell[:, 0] != trial) for trial in (*np.flatnonzero(rated), -1)]
    every = jax.tree.map(lambda part: np.broadcast_to(part, (len(folds), *part.shape)), nodes)
    points = modes(model, every, asked, np.stack(folds).astype(float))

    @jax.jit
    def mean(point: np.ndarray) -> Any:
        values = alike(model, point)
        each = jax.lax.map(lambda node: model.expected(values, node, asked)[:, 0], nodes)
        return jax.numpy.exp(model.log_shares(values)) @ each

    told = [np.asarray(mean(point)) for point in points]
    of = lambda fold, trial: told[fold][asked.cell[:, 0] == trial].mean()
    without = {trial: fold for fold, trial in enumerate(np.flatnonzero(rated))}
    outside = np.array([of(without.get(trial, -1), trial) for trial in range(trials)])
    inside = np.array([of(-1, trial) for trial in range(trials)])
    return outside, inside, points[-1]


def pooled(one: np.ndarray, other: np.ndarray, weight: Any = 0.5) -> np.ndarray:
    """The logarithmic pool of two predictions between 0 and 1: a weighted mean of log odds, [...]
    (Satopää et al. 2014, International Journal of Forecasting 30, 344-356)."""
    found: np.ndarray = logistic(weight * log_odds(one) + (1 - weight) * log_odds(other))
    return found


def pooled_apart(means: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """`pooled`, with the weight for each trial that is best for the others, [trials]."""
    weights = np.linspace(0, 1, 101)
    every = pooled(one, other, weights[:, None])
    squares = (every - means) ** 2  # [weights, trials]
    best = (squares.sum(1, keepdims=True) - squares).argmin(0)
    return every[best, np.arange(len(means))]


def counted_cues(people: Study) -> np.ndarray:
    """CUES, and how often a box was moved, at the end of each trial."""
    moves = []
    for script in people.scripts.values():
        frames = [frame["state"] for frame in script.record.frames]
        places = [[f[n] for n in f if n.startswith("box")] for f in (script.record.start, *frames)]
        moves.append(sum(a != b for a, b in pairwise(places)))
    column = np.array([float(moves[question.script]) for question in people.questions])
    column = (column - column.mean()) / column.std()
    return np.column_stack([cues(people.scripts, people.questions, CUES), column])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    folder = given.out or Path(tempfile.mkdtemp())
    convert(given.data, folder)
    table = write_table(given.data, folder)
    with computing():
        people = study(read_judgements(table, 100.0), folder, 100.0)
        viewers = report(people)
    told = "Viewers fitted to the judgements of Wu, Sridhar and Gerstenberg 2023."
    (folder / "people.toml").write_text(written(viewers, {}, told))
    print(f"the audience fitted to all: {folder / 'people.toml'}")


def write_table(data: Path, folder: Path) -> Path:
    """The ratings as `i2p fit` reads them; NOBODY has an answer to each trial without any."""
    path = folder / "judgements.csv"
    left = {int(file.stem.removeprefix("trial_")) for file in folder.glob("trial_*.json")}
    with (data / "intention.csv").open(newline="") as file, path.open("w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(("participant", "script", "frame", "question", "answer"))
        for row in csv.DictReader(file):
            script = f"trial_{int(row['trial']):02d}.json"
            writer.writerow((row["participant"], script, "T", QUESTION, row["rating"]))
            left.discard(int(row["trial"]))
        for number in sorted(left):
            writer.writerow((NOBODY, f"trial_{number:02d}.json", "T", QUESTION, 50))
    return path


def report(people: Study) -> tuple[Person, ...]:
    """Prints the tables; the audience that was fitted to all trials."""
    trials = len(people.labels)
    nobody = people.people.index(NOBODY) if NOBODY in people.people else -1
    answered = people.asked.cell[people.asked.person != nobody, 0]
    rated = np.isin(np.arange(trials), answered)
    means = np.array(
        [people.asked.answer[people.asked.cell[:, 0] == trial].mean() for trial in range(trials)]
    )
    ways = [seen_under(people, tuple(node.items())) for node in NODES]
    watched = ways[0][0]
    nodes = jax.tree.map(lambda *parts: np.stack(parts), *[seen for _, seen in ways])
    world = watched[0].world
    log_prior = world.log_prior(world.tables)[0]
    watching = Watching(Answers(watched, people.questions), people.latents, log_prior, {})
    model = Model(watching, len(people.people), {}, ("plan",), len(NODES), trials)
    answering = {"slope": 1.0, "bias": 0.0}  # weights do the same
    baseline = Model(Cues((*CUES, "boxes moved")), len(people.people), answering, (), cells=trials)
    outside, inside, point = predicted(model, nodes, people.asked, rated)
    cues_outside, cues_inside, _ = predicted(
        baseline, counted_cues(people)[None], people.asked, rated
    )
    both = pooled(outside, cues_outside)
    columns = (means, outside, cues_outside, both, inside)
    print("| trial | people | audience | cues | both | audience in sample |")
    print("|---|---|---|---|---|---|")
    for trial in sorted(range(trials), key=lambda t: people.labels[t][0]):
        number = int(people.labels[trial][0].removesuffix(".json")[-2:])
        told = [f"{100 * x[trial]:.1f}" for x in columns]
        told[0] = told[0] if rated[trial] else ""
        print(f"| {number} | " + " | ".join(told) + " |")
    for name, found in (
        ("audience, out of sample", outside),
        ("audience, in sample", inside),
        ("cues, out of sample", cues_outside),
        ("both, out of sample", both),
        ("cues, in sample", cues_inside),
    ):
        r, rmse = agreement(means[rated], found[rated])
        print(f"{name}: r = {r:.3f}, RMSE = {100 * rmse:.1f}")
    weighed = pooled_apart(means[rated], outside[rated], cues_outside[rated])
    r, rmse = agreement(means[rated], weighed)
    print(f"both, weight fitted to the others: r = {r:.3f}, RMSE = {100 * rmse:.1f}")
    values = alike(model, point)
    scales = {name: scale for name, scale in model.scales.items() if "[" not in name}
    bounded = {name: float(scale.bounded(values[name])) for name, scale in scales.items()}
    print({name: round(value, 3) for name, value in bounded.items()})
    shares = np.asarray(jax.numpy.exp(model.log_shares(values)))
    for node, share in zip(NODES, shares, strict=True):
        print(f"{100 * share:5.1f} % {plan_in_words(node)}")
    # Each viewer of a file stands for as many people.
    counts = np.round(VIEWERS * shares).astype(int)
    return tuple(
        person(watching, values, node)
        for node, count in zip(NODES, counts, strict=True)
        for _ in range(count)
    )


if __name__ == "__main__":
    main()
