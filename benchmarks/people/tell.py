"""Stories told to the audience that was fitted to people, beside the same told to the usual one.

    python benchmarks/people/fit.py DATA --out FOLDER
    python benchmarks/people/tell.py FOLDER [--out FILMS]

FOLDER has the trials' worlds and `people.toml`. Each of three stories is told in the kitchen and in
the world of trial 12; both films are then shown to both audiences. Prints a table in Markdown, and
leaves the scripts in FILMS, for `i2p render`.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from i2pdsl.stories import Story

WISH = "wish = (G_cheese = pink), contact = [adjacent(robot, cheese) @ script[t]]"
BOTH = "mean_t (if t <= T/2 then P(rho > 0 | script[:t]) else P(rho < 0 | script[:t]))"
WORLDS = {"kitchen": ("kitchen", 15, f", {WISH}"), "trial 12": ("trial_12", 8, "")}
STORIES = {
    "help": ("depict(rho > 0)", "mean_t P(rho > 0 | script[:t])"),
    "hinder": ("depict(rho < 0)", "mean_t P(rho < 0 | script[:t])"),
    "betrayal": ("twist(rho > 0, rho < 0{more})", BOTH),
}
AUDIENCES = {"usual": None, "people": '"people.toml"'}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="trials' worlds and people.toml")
    parser.add_argument("--out", type=Path, help="where the scripts go")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    file = given.folder / "people.toml"
    films = given.out or Path(tempfile.mkdtemp())
    films.mkdir(parents=True, exist_ok=True)
    print("| world | story | told to | usual viewers believe | people believe | still frames |")
    print("|---|---|---|---|---|---|")
    for world, (place, length, more) in WORLDS.items():
        for name, (pattern, asked) in STORIES.items():
            for told_to, audience in AUDIENCES.items():
                lines = [f"world {place}", f"length {length}"]
                lines += [] if audience is None else [f"audience {audience}"]
                lines.append(f"maximize {pattern.format(more=more)}")
                story = Story.from_text("\n".join(lines) + "\n", folder=given.folder)
                script = story.solve(seed=given.seed).script
                script.save(films / f"{world.replace(' ', '-')}-{name}-{told_to}.json")
                usual = script if audience is None else script.seen_by("bayesian()")
                people = script.seen_by(f'"{file}"') if audience is None else script
                seen = " | ".join(f"{float(each.query(asked)):.2f}" for each in (usual, people))
                print(f"| {world} | {name} | {told_to} | {seen} | {script.still:.0%} |", flush=True)


if __name__ == "__main__":
    main()
