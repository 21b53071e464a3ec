"""Who believes the mime? The tables of docs/hill.md: the mime beside the trivial baseline (the
heavy controller on the light box), and what observers believe whom the optimiser never saw.

    python benchmarks/hill_audience.py [--seeds 0,1,2,3,4] [--quick]
    python benchmarks/hill_audience.py --will [--seeds 0,1,2,3,4]

With --will six further trainings are asked, which do not ship: `i2p train hill --seed 11`, to 16.
An executing seed is the training seed of the controllers that act, and that the optimiser's own
observer imagines; the held-out observers imagine those of the other training seeds, one each, and
are pooled by their mean log-odds. P is the mean over all frames of P(weight = 0.5), with --will of
P(weight = 0.5 and will = eager), for viewers who wonder whether the hopper does its best.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from i2pdsl.errors import Source
from i2pdsl.objective.replay import replay
from i2pdsl.scripts import Script
from i2pdsl.stories import story_from
from i2pdsl.worlds.hill.hopper import MUSCLE_COUNT
from i2pdsl.worlds.hill.spec import HillSpec
from i2pdsl.worlds.hill.world import HillWorld, build_hill
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import Viewer

STORIES = Path(__file__).resolve().parent.parent / "stories" / "hill"
SHIPPED = (0, 1, 2, 3, 4)
FURTHER = (11, 12, 13, 14, 15, 16)  # to whom nothing is told; trained by whoever runs this
LAZY = 0.1  # as in mime.story
HONEST = "world hill(weight = {})\nlength 800\nsearch naive(noise = 0.1)\n"
PLAIN = """world hill(weight = 0.1)
length 800
maximize depict(weight = 0.5)
search descend(window = 50, overlap = 0, lookahead = 0, steps = 40, rate = 0.1)
"""
# The mime as it was before viewers could think of a lazy hopper: it does little.
GENTLE = """world hill(weight = 0.1)
length 800
maximize depict(weight = 0.5)
maximize sum_t (0.3 * [progress(box) @ script[t]] - 0.05 * [effort(hopper) @ script[t]])
search descend(window = 50, overlap = 0, lookahead = 0, steps = 40, rate = 0.1)
"""


def script_of(text: str, executing: int, length: int) -> Script:
    """The best script of a story, told by the controllers of a training seed."""
    text = re.sub(r"^world hill\((.*)\)", rf"world hill(\1, controller = {executing})", text)
    text = re.sub(r"^length \d+", f"length {length}", text, flags=re.M)
    return story_from(Source("story", text)).solve(seed=0).script


def driven(executing: int, length: int, wanted: Callable[[np.ndarray], np.ndarray]) -> Trajectory:
    """A light box pulled by muscles that do what `wanted` says of a state, and some noise."""
    light = build_hill(HillSpec().with_settings({"controller": executing}))
    states, actions = [light.starts()[0]], []
    for chance in 0.1 * np.random.default_rng(0).normal(size=(length, MUSCLE_COUNT)):
        own = light.actuation(states[-1], np.zeros(MUSCLE_COUNT))
        actions.append(wanted(states[-1]) + chance - own)
        states.append(light.transition(light.tables, states[-1], actions[-1]))
    return Trajectory(np.array(actions), np.array(states))


def heavy_controller(executing: int) -> Callable[[np.ndarray], np.ndarray]:
    """The trivial baseline: the hopper pulls as if the box were heavy."""
    heavy = build_hill(HillSpec().with_settings({"controller": executing, "weight": 0.5}))
    return lambda state: heavy.actuation(state, np.zeros(MUSCLE_COUNT))


def log_odds(
    path: Trajectory, weight: float, executing: int, imagined: int, evidence: str
) -> np.ndarray:
    """log P(heavy) / P(light) after each frame, for one observer, [T]."""
    spec = HillSpec().with_settings({"weight": weight, "controller": executing})
    viewer = Viewer(spec.with_settings({"controller": imagined, "evidence": evidence}))
    belief = replay(build_hill(spec, (viewer,)), path.states, path.actions).log_belief[1:, 0]
    return belief[:, 1] - belief[:, 0]


def share(odds: np.ndarray) -> float:
    """The mean probability that goes with log-odds."""
    return float((1 / (1 + np.exp(-odds))).mean())


def climbed(world: HillWorld, path: Trajectory) -> float:
    gone = world.feature(
        world.tables, "progress", ("box",), path.states[1:], path.states[:-1], path.actions
    )
    return float(gone.sum())


def tries(path: Trajectory, settings: dict[str, float | str], imagined: int) -> np.ndarray:
    """P(weight = 0.5 and will = eager) after each frame, for one observer, [T]."""
    spec = HillSpec().with_settings({**settings, "lazy": LAZY})
    viewer = Viewer(spec.with_settings({"controller": imagined}))
    belief = replay(build_hill(spec, (viewer,)), path.states, path.actions).log_belief[1:, 0]
    return np.exp(belief[:, spec.hypotheses.index((0.5, "eager"))])


def pooled(each: list[np.ndarray]) -> float:
    """The mean over all frames of what observers believe together, by their mean log-odds."""
    return share(np.mean([np.log(p / (1 - p)) for p in each], axis=0))


def wills(seeds: tuple[int, ...]) -> None:
    """mime.story beside honest and lazy motion. The story tells its mime to the observers of the
    executing seed, of two other shipped ones, and of six further trainings."""
    lines = (STORIES / "mime.story").read_text(encoding="utf-8").splitlines()
    mime = "\n".join(line for line in lines if not line.startswith("#")).strip()
    length = int(re.findall(r"^length (\d+)", mime, flags=re.M)[0])
    print("| executing | script | box, units | effort | rope taut | own P | two | six | pooled |")
    print("|---|---|---|---|---|---|---|---|---|")
    for executing in seeds:
        first, second, *_ = (seed for seed in SHIPPED if seed != executing)
        text = mime.replace("controller = 0)", f"controller = {first})")
        text = text.replace("controller = 1)", f"controller = {second})")
        lazy = f"0.5, will = lazy, lazy = {LAZY}"
        told: dict[str, tuple[str, dict[str, float | str]]] = {
            "honest light": (HONEST.format(0.1), {"weight": 0.1}),
            "honest heavy": (HONEST.format(0.5), {"weight": 0.5}),
            "lazy, heavy box": (HONEST.format(lazy), {"weight": 0.5, "will": "lazy"}),
            "mime.story": (text, {"weight": 0.1}),
        }
        for name, (story, settings) in told.items():
            script = script_of(story, executing, length)
            print(row(executing, name, script, settings), flush=True)


def row(executing: int, name: str, script: Script, settings: dict[str, float | str]) -> str:
    """A script as a line of the table of wills. Held out are the observers of the shipped trainings
    to whom the mime is not told, and those of further trainings."""
    settings = {**settings, "controller": executing}
    own, *each = (
        tries(script.trajectory, settings, seed)
        for seed in (executing, *[s for s in SHIPPED if s != executing][2:], *FURTHER)
    )
    way, effort, taut = (
        float(script.query(asked))
        for asked in (
            "sum_t [progress(box) @ script[t]]",
            "mean_t [effort(hopper) @ script[t]]",
            "mean_t [taut(hopper) @ script[t]]",
        )
    )
    two, six = (", ".join(f"{p.mean():.2f}" for p in held) for held in (each[:2], each[2:]))
    return (
        f"| {executing} | {name} | {way:.0f} | {effort:.2f} | {taut:.2f} | {own.mean():.2f} "
        f"| {two} | {six} | **{pooled(each):.2f}** |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default=",".join(map(str, SHIPPED)))
    parser.add_argument("--quick", action="store_true", help="200 frames instead of 800")
    parser.add_argument("--will", action="store_true", help="the table of mime.story")
    given = parser.parse_args()
    length = 200 if given.quick else 800
    if given.will:
        wills(tuple(map(int, given.seeds.split(","))))
        return
    told = {
        "honest light": (HONEST.format(0.1), 0.1),
        "honest heavy": (HONEST.format(0.5), 0.5),
        "heavy controller, light box": ("", 0.1),
        "limp hopper, light box": ("", 0.1),
        "mime, belief alone": (PLAIN, 0.1),
        "mime that does little": (GENTLE, 0.1),
        "told to two observers": (
            PLAIN + "audience average(bayesian(), bayesian(controller = {other}))\n",
            0.1,
        ),
    }
    print("| executing | script | box, units | own P | held-out P, each | pooled | masses only |")
    print("|---|---|---|---|---|---|---|")
    for executing in map(int, given.seeds.split(",")):
        others = [seed for seed in SHIPPED if seed != executing]
        for name, (text, weight) in told.items():
            spec = HillSpec().with_settings({"weight": weight, "controller": executing})
            if text:
                path = script_of(
                    text.replace("{other}", str(others[0])).strip(), executing, length
                ).trajectory
            else:
                limp = lambda state: np.zeros(MUSCLE_COUNT)
                wanted = limp if "limp" in name else heavy_controller(executing)
                path = driven(executing, length, wanted)
            # Whom the optimiser saw is not held out.
            held = others[1:] if "two observers" in name else others
            odds = [log_odds(path, weight, executing, seed, "motion") for seed in held]
            own = share(log_odds(path, weight, executing, executing, "motion"))
            known = share(log_odds(path, weight, executing, executing, "mass"))
            each = ", ".join(f"{share(o):.2f}" for o in odds)
            pooled = share(np.mean(odds, axis=0))
            way = climbed(build_hill(spec), path)
            print(
                f"| {executing} | {name} | {way:.0f} | {own:.3f} | {each} | **{pooled:.2f}** "
                f"| {known:.3f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
