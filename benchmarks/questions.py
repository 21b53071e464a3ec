"""Many questions about many scripts at once, beside one after the other.

    python benchmarks/questions.py [SCRIPTS]

Random scripts of the kitchen (15 frames, 34 hypotheses), five questions. In the same run: reading
their files, all questions with `i2pdsl.query`, and `Script.load` and `script.query` for some of
them, as a loop would do it. What is said last are ratios of seconds for each script.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import i2pdsl
from i2pdsl.scripts import make_record
from i2pdsl.worlds.record import empty, extended

LENGTH, ALONE = 15, 20
STORY = f"world kitchen\nlength {LENGTH}\nmaximize sum_t P(rho > 0 | script[:t])\n"
QUESTIONS = (
    "P(rho > 0 | script[:t])",
    "P(G_cheese | script[:t])",
    "E[V(robot) | script[:T]]",
    "mean_t entropy(rho | script[:t])",
    "sum_t surprise(script[t])",
)


def write(folder: Path, count: int) -> list[Path]:
    """Scripts of random turns."""
    world = i2pdsl.Story.from_text(STORY).world()
    generator = np.random.default_rng(0)
    about = {"name": "random", "file": "random.story", "source": STORY, "seed": 0}
    paths = []
    for number in range(count):
        path = empty(world, generator.choice(world.starts()))
        for _ in range(LENGTH):
            valid = np.flatnonzero(world.turns(world.tables, path.states[-1]).valid)
            path = extended(world, path, [int(generator.choice(valid))])
        paths.append(folder / f"{number}.json")
        make_record(world, path, about, {}, None).save(paths[-1])
    return paths


def main(count: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        paths = write(Path(folder), count)
        i2pdsl.query(paths[:1], QUESTIONS)  # everything is imported, the world is in memory
        began = time.perf_counter()
        scripts = [i2pdsl.Script.load(path) for path in paths[:ALONE]]
        loaded = time.perf_counter()
        for script in scripts:
            for question in QUESTIONS:
                script.query(question)
        asked = time.perf_counter()
        table = i2pdsl.query(paths, QUESTIONS)
        done = time.perf_counter()
        records = [i2pdsl.Script.load(path) for path in paths[:ALONE]]
        several = records * (count // ALONE)
        again = time.perf_counter()
        i2pdsl.query(several, QUESTIONS)
        known = time.perf_counter() - again
    load, ask = (loaded - began) / ALONE, (asked - loaded) / ALONE
    together, at_once = (done - asked) / count, known / len(several)
    print(f"{count:,} scripts x {len(QUESTIONS)} questions: {len(table):,} rows")
    print(
        f"one by one: {1000 * load:.2f} ms to load a script, {1000 * ask:.2f} ms for its questions"
    )
    print(f"at once, from files: {done - asked:.2f} s, {len(QUESTIONS) / together:,.0f} answers/s")
    print(f"at once, once loaded: {known:.2f} s, {len(QUESTIONS) / at_once:,.0f} answers/s")
    print(f"ratio: {(load + ask) / together:.1f} from files, {ask / at_once:.1f} once loaded")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
