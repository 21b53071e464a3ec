"""What every story that ships comes to: what it expects of itself, what is seen in its film, what a
panel of other viewers makes of it, and how long it takes.

    PYTHONPATH=tests python benchmarks/stories.py [--seeds 0-2] [--scripts FOLDER] [STORY ...]

Prints a table in Markdown, with the median and, of several seeds, the least and the greatest. What
stories expect of themselves is read by the tests. With
`--scripts`, FOLDER/FAMILY-NAME/script.json are judged in place of new ones, so that what another
version of i2pdsl found is seen with the eyes of this one.
"""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

import numpy as np

from i2pdsl.objective.film import film_of
from i2pdsl.objective.panel import judge, panel
from i2pdsl.objective.terms import score_script
from i2pdsl.scripts import Script
from i2pdsl.stories import load
from stories_for_tests import PATHS, expectations, name

HEAD = ("story", "expects", "still", "contact", "regret", "luck", "panel, worst / score", "CPU s")


def contact(script: Script) -> float:
    """The share of frames in which one pushes another, or touches it where nobody pushes."""
    vocabulary = script.world.vocabulary
    word = "pushes" if "pushes" in vocabulary.predicates else "touching"
    names = vocabulary.characters
    if len(names) < 2:
        return math.nan
    either = " or ".join(f"{word}({a}, {b})" for a in names for b in names if a != b)
    return float(script.query(f"mean_t [{either} @ script[t]]"))


def figures(path: Path, script: Script, seconds: float) -> list[list[float]]:
    """Of one script, a list for each column."""
    typed, world = load(path).typed, script.world
    asked = [e for e in expectations(path) if e.expression not in ("still", "luck")]
    regret = luck = math.nan
    if "naturalness" in world.vocabulary.automatic:
        film = film_of(world, script.frames, typed.viewers)
        regret, luck = float(film.regret), float(film.luck.max(initial=0.0))
    (verdict,) = judge(typed, panel(typed, world), [script.trajectory], [script.frames])
    score = score_script(typed, world, script.frames)
    return [
        [float(script.query(e.expression, e.assume)) for e in asked],
        [script.still],
        [contact(script)],
        [regret],
        [luck],
        [verdict.mean, verdict.worst, score],
        [seconds],
    ]


def made(path: Path, seed: int) -> tuple[Script, float]:
    """A story's script, and the CPU seconds that it took."""
    began = time.process_time()
    script = load(path).solve(seed).script
    return script, time.process_time() - began


def cell(values: np.ndarray) -> str:
    """Of [seeds, numbers]: medians, with the least and the greatest."""
    shown = []
    for middle, least, most in zip(np.median(values, 0), values.min(0), values.max(0), strict=True):
        spread = f" [{least:.3g}, {most:.3g}]" if len(values) > 1 else ""
        shown.append("" if math.isnan(middle) else f"{middle:.3g}{spread}")
    return "; ".join(shown)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stories", nargs="*", type=Path)
    parser.add_argument("--seeds", default="0")
    parser.add_argument("--scripts", type=Path)
    given = parser.parse_args()
    first, _, last = given.seeds.partition("-")
    print("| " + " | ".join(HEAD) + " |")
    print("|---" * len(HEAD) + "|")
    for path in [p.resolve() for p in given.stories] or PATHS:
        found = []
        if given.scripts:
            kept = given.scripts / name(path).replace("/", "-") / "script.json"
            if kept.exists():
                found.append(figures(path, Script.load(kept), math.nan))
        else:
            found = [
                figures(path, *made(path, n)) for n in range(int(first), int(last or first) + 1)
            ]
        if found:
            columns = [cell(np.array(each)) for each in zip(*found, strict=True)]
            print(f"| {name(path)} | " + " | ".join(columns) + " |", flush=True)


if __name__ == "__main__":
    main()
