"""How long everything takes on the hill, stage by stage, and what it is measured against: plain
NumPy doing the same work, and one optimiser against another.

    python benchmarks/hill.py [--quick]

All times are seconds of wall clock in this run; run it on a quiet machine.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.errors import Source
from i2pdsl.planning.actor_critic import Recipe, begin, improve_often
from i2pdsl.stories import Result, story_from
from i2pdsl.worlds.hill import springs
from i2pdsl.worlds.hill.hopper import MUSCLE_COUNT, build_body, initial_state, masses
from i2pdsl.worlds.hill.spec import HillSpec
from i2pdsl.worlds.hill.training import hill_environment

STORIES = Path(__file__).resolve().parent.parent / "stories" / "hill"
SPEC = HillSpec()
BATCH = 64


def clock(work: Callable[[], Any], repeats: int = 3) -> float:
    """The shortest of several runs."""
    best = float("inf")
    for _ in range(repeats):
        began = time.perf_counter()
        jax.block_until_ready(work())
        best = min(best, time.perf_counter() - began)
    return best


def row(name: str, figure: str, more: str = "") -> None:
    print(f"  {name:<46}{figure:>16}  {more}", flush=True)


def roll(body: Any, mass: Any, start: springs.Motion, actuations: Any) -> springs.Motion:
    """The motion after all frames."""

    @jax.checkpoint
    def frame(motion: springs.Motion, actuation: Any) -> tuple[springs.Motion, None]:
        return springs.step(body, mass, motion, actuation)[0], None

    return jax.lax.scan(frame, start, actuations)[0]


def simulator(frames: int) -> None:
    """Frames a second at batch 64, forward and with the gradient, against NumPy one by one."""
    print(f"simulator, {BATCH} rollouts side by side")
    single = partial(jnp.asarray, dtype=jnp.float32)
    body = jax.tree.map(single, build_body(SPEC))
    mass = single(masses(SPEC, 0.1))
    start = springs.motion_of(jnp.broadcast_to(single(initial_state()), (BATCH, 76)))
    noise = np.random.default_rng(0).normal(size=(frames, MUSCLE_COUNT, BATCH))
    actuations = single(0.3 * noise)
    forward = jax.jit(roll)
    done = jax.block_until_ready(forward(body, mass, start, actuations))
    rate = BATCH * frames / clock(lambda: forward(body, mass, start, actuations))

    def reached(actuations: Any) -> Any:
        return roll(body, mass, start, actuations).position[0].mean()

    gradient = jax.jit(jax.grad(reached))
    some = actuations[:100]
    jax.block_until_ready(gradient(some))
    backward = BATCH * len(some) / clock(lambda: gradient(some))

    def one_by_one() -> springs.Motion:
        motion = springs.motion_of(initial_state()[None])
        for t in range(50):
            motion, _ = springs.step(
                build_body(SPEC), masses(SPEC, 0.1), motion, 0.3 * noise[t, :, :1]
            )
        return motion

    plain = 50 / clock(one_by_one)
    row("forward", f"{rate:,.0f} frames/s", f"{rate / plain:,.0f} x plain NumPy, one by one")
    row("with gradient", f"{backward:,.0f} frames/s")
    assert np.isfinite(np.asarray(done.position)).all()


def training(iterations: int) -> None:
    """The time that `i2p train hill` needs, from some of its iterations."""
    print("training")
    recipe = Recipe()
    environment, _ = hill_environment(SPEC, SPEC.trained_weights, recipe.environments)
    state = begin(environment, recipe, 0)
    began = time.perf_counter()
    jax.block_until_ready(improve_often(environment, recipe, iterations, state))
    compiled = time.perf_counter() - began
    seconds = clock(lambda: improve_often(environment, recipe, iterations, state), 1)
    whole = seconds * recipe.iterations / iterations
    row("compile", f"{compiled - seconds:.1f} s")
    row("both weights, 2400 iterations", f"{whole:.0f} s", f"from {iterations} iterations")


def solve(name: str, *lines: str, length: int = 800, seed: int = 0) -> tuple[Result, float]:
    """A story of stories/hill, its `search` replaced by lines that are given."""
    text = (STORIES / f"{name}.story").read_text(encoding="utf-8").splitlines()
    kept = [x for x in text if not (lines and x.startswith("search"))]
    kept = [f"length {length}" if x.startswith("length") else x for x in kept]
    story = story_from(Source(f"{name}.story", "\n".join((*kept, *lines)) + "\n"))
    began = time.perf_counter()
    result = story.solve(seed)
    return result, time.perf_counter() - began


def stories(length: int) -> None:
    """Each story: compiling, searching, and what comes out of the best of its 8 seeds."""
    print(f"stories, {length} frames, 8 seeds in one batch")
    for name in ("mime", "stumble", "arc", "honest-light"):
        result, _ = solve(name, length=length)
        stages = result.seconds
        row(
            name,
            f"{stages['search']:.1f} s",
            f"compile {stages.get('compile', 0):.1f} s, score {result.score:.6g}",
        )


OPTIMISERS = (
    ("adam, 15 steps of 0.1 (default)", "steps = 15"),
    ("adam, no lookahead", "lookahead = 0"),
    ("adam, 15 steps of 0.05", "rate = 0.05"),
    ("adam, 40 steps of 0.1", "steps = 40"),
    ("lbfgs, 8 steps", "steps = 8, optimiser = lbfgs"),
    ("lbfgs, 15 steps", "steps = 15, optimiser = lbfgs"),
    ("ncg, 15 steps", "steps = 15, optimiser = ncg"),
    ("ncg, 30 steps", "steps = 30, optimiser = ncg"),
    ("box of 1 (projected gradient), 10 steps", "steps = 10, bound = 1"),
)


def optimisers(length: int) -> None:
    """One optimiser against another: seconds, and the mean belief or the score."""
    print(f"optimisers, {length} frames, 8 seeds; seconds, then best and median of the seeds")
    for name, what in (("mime", "objective"), ("stumble", "objective")):
        for label, how in OPTIMISERS:
            solve(name, f"search descend({how})", length=length)
            result, seconds = solve(name, f"search descend({how})", length=length, seed=1)
            scores = np.array([c.score for c in result.candidates], dtype=float)
            row(
                f"{name}: {label}",
                f"{seconds:.1f} s",
                f"{what} {scores.max():.5g}, {np.median(scores):.5g}",
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a tenth of the work")
    quick = parser.parse_args().quick
    simulator(100 if quick else 400)
    training(20 if quick else 200)
    stories(100 if quick else 800)
    optimisers(100 if quick else 500)


if __name__ == "__main__":
    main()
