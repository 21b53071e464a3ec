"""What exact and additive planning cost, from 10^4 to 10^8 states, and how far they are apart.

The kitchen's rules with a second object, `chair`, or more, and on smaller and larger maps. Each
plan is made in a process of its own; those of a world share a cache that is empty at first. Errors
are those of beliefs along 64 scripts of 15 frames whose characters act by exact plans
(docs/approximate.md has the tables).

    python benchmarks/additive.py [WORLD ...]
"""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from i2pdsl.errors import Source
from i2pdsl.worlds.grid import method
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.reduced import reduced

KITCHEN = Path(__file__).parent.parent / "stories" / "worlds" / "kitchen.world"
SCRIPTS, FRAMES = 64, 15
SEARCHED = 10**6  # states above which a search is measured, too
EXACT_SECONDS = 150.0  # estimated, above which exact plans are left out


def hall(columns: int, rows: int) -> list[str]:
    """A map of rooms with doors, of 6 x 5 cells or so."""
    wall = lambda c, r: (c % 7 == 6 and r % 5 != 2) or (r % 5 == 4 and r < rows - 1 and c % 7 != 3)
    return ["".join(".#"[wall(c, r)] for c in range(columns)) for r in range(rows)]


def kitchen(rows: list[str] | None, *more: str):
    """The kitchen on a map of one's own, with P and G in opposite corners, and more objects."""
    text = KITCHEN.read_text(encoding="utf-8")
    if rows is not None:
        rows = [*rows]
        rows[0], rows[-1] = "P" + rows[0][1:], rows[-1][:-1] + "G"
        drawn = "map\n" + "".join(f"    {row}\n" for row in rows)
        text = re.sub(r"map\n(    .*\n)+", drawn, text)
    for name in more:
        text = text.replace("table}", f"table, {name}}}")
        text = text.replace("event deus", f"object {name}\n    may_be_absent = yes\n\nevent deus")
    return parse_world(Source("kitchen.world", text), "kitchen")


def cut(cells: int):
    """The kitchen with a chair, on a map of at most so many cells."""
    return reduced(kitchen(None, "chair"), lambda spec: len(spec.free_cells) <= cells)


def dog():
    """The kitchen with a third character, for the cheese or against it, and the table."""
    text = KITCHEN.read_text(encoding="utf-8").replace("    may_be_absent = yes\n", "")
    text = re.sub(r"event deus\n.*\n|goals = \{pink, green, none\}|order = .*\n", "", text)
    robot = "    goals = {green, none}\n    pushes = {cheese, table}\n"
    text = text.replace("    pushes = {cheese, table}\n", robot).replace(
        "{-3, -1, 0, 1, 3}", "{-3, 3}"
    )
    other = "character dog\n    goals = {pink, none}\n    pushes = {cheese, table}\n"
    other += "    toward = cheese\n    attitude = {-3, 3}\n"
    return parse_world(
        Source("kitchen.world", text.replace("object", f"{other}object", 1)), "kitchen"
    )


CASES = {
    "rooms, 12 cells": lambda: cut(12),
    "rooms, 17 cells": lambda: cut(17),
    "rooms, 20 cells": lambda: cut(20),
    "open, 12 cells": lambda: kitchen(["...."] * 3, "chair"),
    "open, 16 cells": lambda: kitchen(["...."] * 4, "chair"),
    "open, 20 cells": lambda: kitchen(["....."] * 4, "chair"),
    "open, 25 cells": lambda: kitchen(["....."] * 5, "chair"),
    "rooms, 60 cells": lambda: kitchen(None, "chair"),
    "rooms, 60 cells, no chair": lambda: kitchen(None),
    "rooms, 60 cells, and a crate": lambda: kitchen(None, "chair", "crate"),
    "rooms, 298 cells, no chair": lambda: kitchen(hall(23, 17)),
    "rooms, 60 cells, a dog": lambda: dog(),
}


def measured(name: str, how: str, at_once: int) -> dict:
    """What a plan costs, in this process."""
    from i2pdsl.worlds.grid.world import build_world

    spec = CASES[name]().with_settings({"method": how, "at_once": at_once})
    began, cpu = time.perf_counter(), time.process_time()
    world = build_world(spec)
    found = {
        "states": world.dynamics.state_count,
        "seconds": time.perf_counter() - began,
        "processor": time.process_time() - cpu,
    }
    search = searched(world) if world.dynamics.state_count > SEARCHED else None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return found | {"search": search, "gigabytes": peak}


def searched(world) -> float:
    """What the default search of "help" takes, once it is compiled: seconds of processors."""
    from i2pdsl.language.check import check_source
    from i2pdsl.search.searches import search_of
    from i2pdsl.search.task import Task
    from i2pdsl.worlds.kind import Watch

    rho = next(name for name in world.vocabulary.latents if name.startswith("rho"))
    text = f"world kitchen\nlength {FRAMES}\nmaximize depict({rho} > 0)\n"
    story = check_source(Source("help.story", text), lambda *_: world.vocabulary)
    task, search = Task(story, world, Watch()), search_of(story)
    search.prepare(task)
    cpu = time.process_time()
    search.solve(task, 0, 1)
    return time.process_time() - cpu


def errors(name: str, at_once: int) -> dict:
    """How far beliefs by additive plans are from those by exact ones."""
    from i2pdsl.language.story import default_assumption
    from i2pdsl.objective.nearer import rational_scripts
    from i2pdsl.objective.replay import replay_all
    from i2pdsl.objective.trust import apart
    from i2pdsl.worlds.grid.world import build_world

    spec = CASES[name]()
    exact = build_world(spec.with_settings({"method": "exact"}))
    sums = build_world(spec.with_settings({"method": "additive", "at_once": at_once}))
    path = rational_scripts(exact, SCRIPTS, FRAMES, 1)
    seen = [replay_all(world, path.states, path.actions, regret=False) for world in (sums, exact)]
    words = exact.vocabulary
    rational = np.array(default_assumption(words))
    helps = np.array([float(row.get("rho", 0) > 0) for row in words.hypotheses])
    weights = [np.where(rational, np.exp(f.log_belief[:, 1:, 0]), 0) for f in seen]
    first, second = (w @ helps / w.sum(-1) for w in weights)
    wrong = apart(words, tuple(rational), *seen)[:, 1:]
    return {
        "help": float(np.abs(first - second).mean()),
        "mean": float(wrong.mean()),
        "doubtful": float((wrong.max(1) > 0.1).mean()),
    }


def child(folder: str, *arguments: str) -> dict:
    """The same in a process of its own."""
    environment = {**os.environ, "I2PDSL_CACHE": folder}
    command = [sys.executable, __file__, "--child", *arguments]
    found = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return json.loads(found.stdout.splitlines()[-1])


def main(names: list[str]) -> None:
    head = "world", "states", "plan", "seconds", "of processors", "search", "GB"
    head += "P(rho > 0)", "worst latent", "doubtful"
    print(f"| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for name in names or CASES:
        spec = CASES[name]()
        largest = min(3, len(spec.entities) - 1)
        possible = method.estimated_seconds(spec) <= EXACT_SECONDS
        with tempfile.TemporaryDirectory() as folder:
            plans = [("additive", n) for n in range(2, largest + 1)]
            for how, at_once in ([("exact", 12)] if possible else []) + plans:
                cost = child(folder, "cost", name, how, str(at_once))
                row = [name, f"{cost['states']:,}", how if how == "exact" else f"{at_once} at once"]
                row += [f"{cost['seconds']:.1f}", f"{cost['processor']:.1f}"]
                row += ["" if cost["search"] is None else f"{cost['search']:.1f}"]
                row += [f"{cost['gigabytes']:.2f}"]
                if how == "exact" or not possible:
                    row += ["", "", ""]
                else:
                    wrong = child(folder, "errors", name, str(at_once))
                    row += [f"{wrong['help']:.2g}", f"{wrong['mean']:.2g}"]
                    row += [f"{100 * wrong['doubtful']:.0f} %"]
                print(f"| {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        what, name, *rest, number = sys.argv[2:]
        found = measured(name, *rest, int(number)) if what == "cost" else errors(name, int(number))
        print(json.dumps(found))
    else:
        main(sys.argv[1:])
