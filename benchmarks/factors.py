"""What it costs to hold beliefs as a list, by factors, or as particles: a cheese and two or three
robots, on 12 cells (docs/particles.md has the table).

    python benchmarks/factors.py
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

WORLD = """map
    P...
    ....
    ...G
tile pink
    symbol = P
tile green
    symbol = G
character cheese
    success = 0.6
    goals = {pink, green}
"""
ROBOT = """character NAME
    goals = {pink, green, none}
    pushes = {cheese}
    toward = {cheese: {-3, -1, 0, 1, 3}}
"""
STORY = """world many
length 10
maximize depict(rho_robot_cheese > 0)
search beam(starts = 20, width = 1, polish = 0)
"""
WAYS = {"list": 10**6, "factors": 300, "particles": 300}  # from how many hypotheses none is listed


def measured(robots: int, way: str) -> dict:
    """Of one way to hold beliefs, in this process."""
    from i2pdsl.worlds.grid import hypotheses, spec

    spec.MOST_HYPOTHESES = WAYS[way]
    hypotheses.MOST_HYPOTHESES = max(WAYS[way], 4096)
    from i2pdsl.objective.replay import replay
    from i2pdsl.search.searches import search_of
    from i2pdsl.stories import Story

    with tempfile.TemporaryDirectory() as folder:
        names = ("robot", "dog", "cat")[:robots]
        told = WORLD + "".join(ROBOT.replace("NAME", name) for name in names)
        (Path(folder) / "many.world").write_text(told)
        audience = "audience particles(count = 200)\n" if way == "particles" else ""
        story = Story.from_text(STORY + audience, folder)
        words, task = story.typed.vocabulary, story.task()
    search = search_of(task.story)
    search.prepare(task)
    cpu = time.process_time()
    (path, *_) = search.solve(task, 0, 1).paths
    searched = time.process_time() - cpu
    replay(task.world, path.states, path.actions)
    cpu = time.process_time()
    replay(task.world, path.states, path.actions)
    held = [h for h in task.world.tables.holdings if h is not None]
    return {
        "hypotheses": int(sum(words.counts) or len(words.hypotheses)),
        "numbers": getattr(held[0], "size", 200) if held else len(words.hypotheses),
        "search": searched,
        "replay": time.process_time() - cpu,
        "gigabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20,
    }


def main() -> None:
    head = "robots", "hypotheses", "held as", "numbers", "search", "beliefs", "GB"
    print(f"| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for robots in (2, 3):
        for way in WAYS:
            command = [sys.executable, __file__, "--child", str(robots), way]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            found = json.loads(done.stdout.splitlines()[-1])
            row = [str(robots), f"{found['hypotheses']:,}", way, f"{found['numbers']:,}"]
            row += [f"{found['search']:.2f} s", f"{1000 * found['replay']:.0f} ms"]
            row += [f"{found['gigabytes']:.2f}"]
            print(f"| {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        print(json.dumps(measured(int(sys.argv[2]), sys.argv[3])))
    else:
        main()
