"""The stimuli of Wu, Sridhar and Gerstenberg (CogSci 2023) as `.world` and script files.

    python benchmarks/people/convert.py DATA FOLDER      writes 24 of each, and reads them back
    python benchmarks/people/convert.py DATA FOLDER --ask      and says P(help) of each, beside
                                                               people's mean where that is known

DATA is a folder with `experiment1.json`, `grids/N.txt` and `intention.csv` (a public repository,
cicl-stanford/counterfactual_agents, under the MIT licence; nothing of it is in ours).

How the data are read, so that in all 24 trials nobody passes a wall and no two are on one cell:

- A cell of a map takes two characters, its content and what is to its right: `|` is a wall. `_`,
  `G` and `X` have a wall below. Anything else behind a cell (`,` or a space) is nothing.
- `box_changes` are not moves: at the end of that time step the box there is taken hold of, or let
  go if it was held. A held box goes wherever blue goes.
- So blue's path needs no steps for taking hold. It is always a box in front of it or behind it, in
  the direction in which it then moves: a push or a pull.
- A trial ends as red is on the star, or after ten steps. Who has no steps left stays.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

Cell = tuple[int, int]
STEPS = 10
NAMES = {(0, -1): "north", (0, 1): "south", (1, 0): "east", (-1, 0): "west", (0, 0): "stay"}

WORLD = """\
# Trial {number} of Wu, Sridhar and Gerstenberg 2023: does blue help red to get to the star in time?

map
{map}

tile star
    symbol = S
    color = "#e8c547"
object box
    symbol = x
    color = "#8a6a4a"
character blue
    symbol = b
    pushes = box
    pulls = box
    toward = red
    attitude = {{-1, 1}}
    color = "#4a7fc0"
character red
    symbol = r
    goals = star
    color = "#d0564a"
rewards
    goal = {goal:g}
    end = {end:g}
    move = {move:g}
    stay = {stay:g}
planning
    order = together
    horizon = {horizon:g}
    gamma = {gamma:g}
    beta = {beta:g}
"""
NUMBERS = {
    "goal": 1.0,
    "end": 5.0,
    "move": -0.5,
    "stay": -0.1,
    "gamma": 0.99,
    "beta": 2.0,
    "horizon": STEPS,
}


@dataclass(frozen=True)
class Map:
    """A map: its size, its walls between cells, and where everything is at first."""

    columns: int
    rows: int
    walls: frozenset[frozenset[Cell]]
    star: Cell
    boxes: tuple[Cell, ...]

    def drawn(self, red: Cell, blue: Cell) -> str:
        """The map as a `.world` file has it."""
        symbols = {self.star: "S", red: "r", blue: "b", **dict.fromkeys(self.boxes, "x")}
        lines = []
        for row in range(self.rows):
            signs = ""
            for column in range(self.columns):
                here = column, row
                signs += symbols.get(here, ".")
                if column + 1 < self.columns:
                    signs += "|" if frozenset((here, (column + 1, row))) in self.walls else " "
            lines.append(signs)
            below = [frozenset(((c, row), (c, row + 1))) in self.walls for c in range(self.columns)]
            if any(below):
                lines.append(" ".join("-" if wall else " " for wall in below).rstrip())
        return "\n".join(f"    {line}" for line in lines)


def read_map(text: str) -> Map:
    lines = [line for line in text.splitlines() if line.strip()]
    walls, boxes, star = set(), [], None
    for row, line in enumerate(lines):
        for at, sign in enumerate(line):
            here = at // 2, row
            if at % 2:
                if sign == "|":
                    walls.add(frozenset((here, (here[0] + 1, row))))
                continue
            if sign in "gG":
                star = here
            if sign in "xX":
                boxes.append(here)
            if sign in "_GX" and row + 1 < len(lines):
                walls.add(frozenset((here, (here[0], row + 1))))
    assert star is not None
    columns = max(len(line) + 1 for line in lines) // 2
    columns = min(columns, max((len(line.rstrip()) + 1) // 2 for line in lines))
    return Map(columns, len(lines), frozenset(walls), star, tuple(boxes))


def frames_of(trial: dict[str, Any], drawn: Map) -> list[dict[str, Any]]:
    """The frames of a trial as a script has them. Raises ValueError if the reading is wrong."""
    red, blue, boxes = tuple(trial["red_start"]), tuple(trial["blue_start"]), list(drawn.boxes)
    changes = {int(k): {tuple(cell) for cell in v} for k, v in trial["box_changes"].items()}
    held: set[int] = set()
    frames: list[dict[str, Any]] = []
    for step in range(STEPS):
        if red == drawn.star:
            break
        moves = [
            tuple(path[step]) if step < len(path) else (0, 0)
            for path in (trial["blue_path"], trial["red_path"])
        ]
        pulled = False
        for number in held if moves[0] != (0, 0) else ():
            if boxes[number] == _plus(blue, (-moves[0][0], -moves[0][1])):
                pulled = True
            elif boxes[number] != _plus(blue, moves[0]):
                raise ValueError(f"trial {trial['num']}: a box is dragged aside in step {step + 1}")
            boxes[number] = _plus(boxes[number], moves[0])
        red, blue = _plus(red, moves[1]), _plus(blue, moves[0])
        names = [NAMES[move] for move in moves]
        if pulled:
            names[0] = f"pull_{names[0]}"
        acts = {
            who: {"action": name, "moved": name != "stay"}
            for who, name in zip(("blue", "red"), names, strict=True)
        }
        frames.append({**acts, "event": None, "state": _state(red, blue, boxes)})
        held ^= {number for number, box in enumerate(boxes) if box in changes.get(step + 1, ())}
    return frames


def _plus(cell: Cell, move: Cell) -> Cell:
    return cell[0] + move[0], cell[1] + move[1]


def _state(red: Cell, blue: Cell, boxes: list[Cell]) -> dict[str, list[int]]:
    """Who stands where; boxes are numbered in reading order."""
    rows = sorted(boxes, key=lambda cell: (cell[1], cell[0]))
    names = ["box"] if len(rows) == 1 else [f"box_{i + 1}" for i in range(len(rows))]
    found = {"blue": list(blue), "red": list(red)}
    return found | {name: list(cell) for name, cell in zip(names, rows, strict=True)}


def world_text(trial: dict[str, Any], drawn: Map, **numbers: float) -> str:
    """The file of a trial's world.

    Args:
        numbers: some of NUMBERS to be replaced.
    """
    shown = drawn.drawn(tuple(trial["red_start"]), tuple(trial["blue_start"]))
    return WORLD.format(number=trial["num"], map=shown, **(NUMBERS | numbers))


def convert(data: Path, folder: Path, **numbers: float) -> list[Path]:
    """Writes `trial_NN.world` and `trial_NN.json` of each trial; returns the latter."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for trial in json.loads((data / "experiment1.json").read_text()):
        number = trial["num"]
        drawn = read_map((data / "grids" / f"{number}.txt").read_text())
        name = f"trial_{number:02}"
        text = world_text(trial, drawn, **numbers)
        start = _state(tuple(trial["red_start"]), tuple(trial["blue_start"]), list(drawn.boxes))
        script = {
            "format": "i2p-script",
            "version": 1,
            "story": {"name": name},
            "world": {"name": name, "source": text, "settings": {}},
            "score": None,
            "start": start,
            "frames": frames_of(trial, drawn),
        }
        (folder / f"{name}.world").write_text(text)
        written.append(folder / f"{name}.json")
        written[-1].write_text(json.dumps(script, indent=1) + "\n")
    return written


def people(data: Path) -> dict[int, float]:
    """The mean rating of each trial that has some, as a probability."""
    ratings = defaultdict(list)
    with (data / "intention.csv").open() as file:
        for row in csv.DictReader(file):
            ratings[int(row["trial"])].append(float(row["rating"]))
    return {trial: float(np.mean(found)) / 100 for trial, found in ratings.items()}


def ask(data: Path, scripts: list[Path]) -> None:
    """Prints P(help) at the end of each script beside people's judgement."""
    from i2pdsl.scripts import Script

    known, pairs = people(data), []
    print("trial  states  frames  P(rho > 0)  people")
    for number, path in enumerate(scripts, 1):
        script = Script.load(path)
        belief = float(script.query("P(rho > 0 | script[:t])")[-1])
        said = known.get(number)
        if said is not None:
            pairs.append((belief, said))
        shown = "-" if said is None else f"{said:.2f}"
        count = script.world.dynamics.state_count
        print(f"{number:5} {count:9,} {script.length:4} {belief:10.3f} {shown:>8}", flush=True)
    ours, theirs = np.array(pairs).T
    error = np.sqrt(((ours - theirs) ** 2).mean())
    print(
        f"{len(pairs)} trials: r = {np.corrcoef(ours, theirs)[0, 1]:.3f}, RMSE = {100 * error:.1f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--ask", action="store_true", help="plan each world and ask")
    for name, value in NUMBERS.items():
        parser.add_argument(f"--{name}", type=float, default=value)
    options = parser.parse_args()
    numbers = {name: getattr(options, name) for name in NUMBERS}
    scripts = convert(options.data, options.folder, **numbers)
    print(f"{len(scripts)} worlds and scripts in {options.folder}")
    if options.ask:
        ask(options.data, scripts)


if __name__ == "__main__":
    main()
