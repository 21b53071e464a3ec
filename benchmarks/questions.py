"""Many questions about many scripts at once, beside one after the other.

    python benchmarks/questions.py [SCRIPTS]

Scripts of the kitchen (15 frames, 34 hypotheses), five questions. In the same run: `i2pdsl.query`
from their files and once they are loaded, and, as a loop would do it, `Script.load` and
`script.query` for some of them. What is said last are ratios of seconds for each script.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import i2pdsl

LENGTH, ALONE = 15, 20
STORY = f"world kitchen\nlength {LENGTH}\nmaximize sum_t P(rho > 0 | script[:t])\n"
QUESTIONS = (
    "P(rho > 0 | script[:t])",
    "P(G_cheese | script[:t])",
    "E[V(robot) | script[:T]]",
    "mean_t entropy(rho | script[:t])",
    "sum_t surprise(script[t])",
)


def main(count: int) -> None:
    scripts = i2pdsl.Story.from_text(STORY).sample(count).scripts
    with tempfile.TemporaryDirectory() as folder:
        paths = [script.save(Path(folder, f"{n}.json")) for n, script in enumerate(scripts)]
        i2pdsl.query(paths[:1], QUESTIONS)  # everything is imported, the world is in memory
        began = time.perf_counter()
        loaded = [i2pdsl.Script.load(path) for path in paths[:ALONE]]
        read = time.perf_counter()
        for script in loaded:
            for question in QUESTIONS:
                script.query(question)
        asked = time.perf_counter()
        table = i2pdsl.query(paths, QUESTIONS)
        done = time.perf_counter()
        i2pdsl.query(scripts, QUESTIONS)
        known = time.perf_counter() - done
    load, ask, size = (read - began) / ALONE, (asked - read) / ALONE, len(QUESTIONS)
    print(f"{count:,} scripts x {size} questions: {len(table):,} rows")
    print(f"one by one: {1000 * load:.2f} ms to load a script, {1000 * ask:.2f} ms to ask it all")
    print(
        f"at once, from files: {done - asked:.2f} s, {count * size / (done - asked):,.0f} answers/s"
    )
    print(f"at once, once loaded: {known:.2f} s, {count * size / known:,.0f} answers/s")
    print(f"ratio: {(load + ask) * count / (done - asked):.1f} from files,", end=" ")
    print(f"{ask * count / known:.1f} once loaded")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
