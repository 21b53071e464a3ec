"""The audience against people's judgements of helping and hindering: docs/people.md's figures.

    python benchmarks/people/fit.py DATA [--out FOLDER]

DATA is the folder of Wu, Sridhar and Gerstenberg 2023 (see convert.py). Every trial is predicted by
an audience that was fitted to the others: how characters plan (one of NODES), how sharply viewers
expect them to choose, what they forget and thought before, and how they answer are chosen where
the posterior is highest if all people are alike. The baseline of cues is fitted in the same way.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
from itertools import pairwise, product
from pathlib import Path

import jax
import numpy as np
from convert import convert

from i2pdsl.computing import computing
from i2pdsl.fit.cues import cues
from i2pdsl.fit.fit import Study, seen_under, study
from i2pdsl.fit.judgements import read_judgements
from i2pdsl.fit.model import Asked, Cues, Model, Watching
from i2pdsl.fit.report import agreement
from i2pdsl.fit.sampling import alike, modes
from i2pdsl.fit.viewers import Answers

QUESTION = "P(rho > 0 | script[:T])"
NODES = [
    {"move": move, "stay": move / 5, "end": end, "gamma": 0.99, "beta": beta}
    for move, end, beta in product((-0.25, -0.5, -1.0), (5.0, 10.0), (2.0, 4.0))
]
CUES = (
    "mean_t [idle(blue) @ script[t]]",
    "[distance(red, star) @ script[T]]",
    "[distance(blue, red) @ script[T]]",
    "T",
)


def predicted(model: Model, nodes: list, asked: Asked, trials: int) -> tuple[np.ndarray, list]:
    """Each trial's mean by the model that was fitted to the others, [trials], and which node that
    was; at the end the means in sample."""
    folds = [asked.cell[:, 0] != trial for trial in range(trials + 1)]  # the last has all
    pairs = list(product(range(len(folds)), range(len(nodes))))
    seen = jax.tree.map(lambda *parts: np.stack(parts)[:, None], *[nodes[n] for _, n in pairs])
    weights = np.stack([folds[f] for f, _ in pairs]).astype(float)
    points = modes(model, seen, asked, weights)
    rows = jax.jit(lambda point, node: model.log_likelihoods(alike(model, point), node, asked))
    mean = jax.jit(lambda point, node: model.expected(alike(model, point), node, asked))
    prior = lambda point: sum(
        -0.5 * ((x - s.mean) / s.sd) ** 2 for x, s in zip(point, model.scales.values(), strict=True)
    )
    found, chosen = np.empty(trials), []
    for fold, kept in enumerate(folds):
        of_fold = [i for i, (f, _) in enumerate(pairs) if f == fold]
        scores = [
            float(rows(points[i], nodes[pairs[i][1]])[kept].sum() + prior(points[i]))
            for i in of_fold
        ]
        best = of_fold[int(np.argmax(scores))]
        told = np.asarray(mean(points[best], nodes[pairs[best][1]]))
        if fold < trials:
            found[fold] = told[asked.cell[:, 0] == fold].mean()
        else:
            inside = np.array([told[asked.cell[:, 0] == t].mean() for t in range(trials)])
        chosen.append((pairs[best][1], points[best]))
    return np.concatenate([found, inside]), chosen


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
        report(people)


def write_table(data: Path, folder: Path) -> Path:
    """The ratings as `i2p fit` reads them."""
    path = folder / "judgements.csv"
    with (data / "intention.csv").open(newline="") as file, path.open("w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(("participant", "script", "frame", "question", "answer"))
        for row in csv.DictReader(file):
            script = f"trial_{int(row['trial']):02d}.json"
            writer.writerow((row["participant"], script, "T", QUESTION, row["rating"]))
    return path


def report(people: Study) -> None:
    trials = len(people.labels)
    means = np.array(
        [people.asked.answer[people.asked.cell[:, 0] == trial].mean() for trial in range(trials)]
    )
    nodes = []
    watched = []
    for node in NODES:
        watched, seen = seen_under(people, tuple(node.items()))
        nodes.append(seen)
    world = watched[0].world
    log_prior = world.log_prior(world.tables)[0]
    watching = Watching(Answers(watched, people.questions), people.latents, log_prior, {})
    model = Model(watching, len(people.people), {}, ())
    audience, chosen = predicted(model, nodes, people.asked, trials)
    baseline = Model(
        Cues((*CUES, "boxes moved")), len(people.people), {"slope": 1.0, "bias": 0.0}, ()
    )
    counted, _ = predicted(baseline, [counted_cues(people)], people.asked, trials)
    print("| trial | people | audience | cues | audience in sample |")
    print("|---|---|---|---|---|")
    for trial in sorted(range(trials), key=lambda t: people.labels[t][0]):
        number = int(people.labels[trial][0].removesuffix(".json")[-2:])
        row = (means[trial], audience[trial], counted[trial], audience[trials + trial])
        print(f"| {number} | " + " | ".join(f"{100 * x:.1f}" for x in row) + " |")
    for name, found in (("audience", audience), ("cues", counted)):
        for what, part in (("out of sample", found[:trials]), ("in sample", found[trials:])):
            r, rmse = agreement(means, part)
            print(f"{name}, {what}: r = {r:.3f}, RMSE = {100 * rmse:.1f}")
    for number, point in chosen[-1:]:
        values = {
            n: float(s.bounded(x)) for (n, s), x in zip(model.scales.items(), point, strict=True)
        }
        print("the best plan:", NODES[number], {name: round(v, 3) for name, v in values.items()})
    print("plans chosen:", [number for number, _ in chosen])


if __name__ == "__main__":
    main()
