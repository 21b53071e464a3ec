"""What a script reaches of each wish of its story (each `maximize` and `minimize`), which frames
hurt it, and what is doubtful about beliefs that were asked for at any price."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from i2pdsl.audience.queries import probability
from i2pdsl.errors import Diagnostic
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.check import TypedStory
from i2pdsl.objective.beats import cut
from i2pdsl.objective.frame import Frame
from i2pdsl.objective.replay import evaluate
from i2pdsl.worlds.world import World

SWAMPED = 0.5  # a mean P(everyone rational) below this is warned about
REFUTED = 0.2  # a P(assumption) below this, in any frame
ALIKE = 1e-3  # a wish that lacks less than this, or this share of what is possible, lacks nothing


@dataclass(frozen=True)
class Wish:
    """A wish of a story, and what became of it.

    Attributes:
        source: the statement, on one line.
        reached: the value of its expression.
        possible: the best value that was found for this wish alone, without the automatic terms:
            the least of a `minimize`; None where nobody looked.
        frames: the fewest frames that make up half of what is missing to that.
    """

    source: str
    reached: float
    possible: float | None
    frames: tuple[int, ...]


def wish(
    source: str,
    sign: int,
    value: ty.Typed,
    world: World,
    frames: Frame,
    best: Frame | None,
) -> Wish:
    """A wish over a finished script; `best` is the script that was found for it alone."""
    reached = float(evaluate(world, frames, value, None))
    if best is None:
        return Wish(source, reached, None, ())
    possible = float(evaluate(world, best, value, None))
    if not sign * (possible - reached) > ALIKE * max(1.0, abs(possible)):
        return Wish(source, reached, reached if sign * reached > sign * possible else possible, ())
    missing = sign * (shares(world, best, value) - shares(world, frames, value))
    return Wish(source, reached, possible, _fewest(missing))


def _fewest(missing: np.ndarray) -> tuple[int, ...]:
    """The fewest frames that make up half of what is missing anywhere, in order."""
    lacks = np.where(missing > 0, missing, 0.0)
    order = np.argsort(-lacks, kind="stable")
    enough = int(np.searchsorted(np.cumsum(lacks[order]), lacks.sum() / 2)) + 1
    return tuple(sorted(int(t) for t in order[:enough] if lacks[t] > 0))


def shares(world: World, frames: Frame, value: ty.Typed) -> np.ndarray:
    """What each frame of a script adds to a number, [T + 1]: they sum to it.

    Terms of sums and means stand at their t, a least or greatest term at the t where it is, and
    anything else at the last frame that it looks at.
    """
    length = len(frames.state) - 1
    found = np.zeros(length + 1)
    for frame, amount in _parts(world, frames, value, 1.0):
        found[min(frame, length)] += amount
    return found


def _parts(
    world: World, frames: Frame, node: ty.Typed, weight: float
) -> Iterator[tuple[int, float]]:
    match node:
        case ty.Reduction(kind=kind):
            times = range(node.first, node.last + 1)
            terms = np.asarray(evaluate(world, frames, node.body, times), float)
            if kind in ("sum", "mean"):
                each = weight / len(times) if kind == "mean" else weight
                yield from zip(times, (each * terms).tolist(), strict=True)
            else:
                at = int(terms.argmin() if kind == "min" else terms.argmax())
                yield times[at], weight * float(terms[at])
        case ty.Beats(parts=parts, least=least, last=last):
            times = range(1, last + 1)
            values = np.stack([evaluate(world, frames, part, times) for part in parts], axis=-1)
            for t, beat in zip(times, cut(values, least), strict=True):
                yield t, weight * float(values[t - 1, beat])
        case ty.Apply(operation="add"):
            for part in node.arguments:
                yield from _parts(world, frames, part, weight)
        case ty.Apply(operation="negate"):
            yield from _parts(world, frames, node.arguments[0], -weight)
        case ty.Apply(operation="multiply" | "divide", arguments=(one, other)) if ty.is_pure(other):
            factor = float(evaluate(world, frames, other, None))
            by = factor if node.operation == "multiply" else 1 / factor
            yield from _parts(world, frames, one, weight * by)
        case ty.Apply(operation="multiply", arguments=(one, other)) if ty.is_pure(one):
            factor = float(evaluate(world, frames, one, None))
            yield from _parts(world, frames, other, weight * factor)
        case _:
            yield _last_frame(node), weight * float(evaluate(world, frames, node, None))


def _last_frame(node: ty.Typed) -> int:
    """The last frame that an expression looks at."""
    found = [0]
    for part in ty.walk(node):
        if isinstance(part, ty.Moment) and part.first is None:
            found.append(part.frames[0])
        elif isinstance(part, ty.Reduction | ty.Beats):
            found.append(part.last)
    return max(found)


def doubts(story: TypedStory, world: World, frames: Frame) -> tuple[Diagnostic, ...]:
    """Warnings: beliefs that are bought with characters who seem to act at random, and those that
    are conditioned on what the script nearly refutes."""
    everything = np.ones(len(story.vocabulary.hypotheses), dtype=bool)
    seen = frames.of(story.viewers).log_belief[1:]
    rational = probability(seen, np.array(story.everyone_rational), everything)
    assumed = probability(seen, np.array(story.assumption), everything)
    found = []
    if rational.mean() < SWAMPED:
        message = (
            f"viewers take it for unlikely that everyone is rational: P is {rational.mean():.2g} "
            f"on average, {rational.min():.2g} in frame {int(rational.argmin()) + 1}"
        )
        hint = "raise `rationality` above 1, or weigh what is wished for less"
        place = story.place(ast.Objective)
        found.append(Diagnostic("swamped", message, place, hint, severity="warning"))
    elif assumed.min() < REFUTED:
        message = (
            f"the script nearly refutes what is assumed: its probability is {assumed.min():.2g} "
            f"in frame {int(assumed.argmin()) + 1}, so beliefs given it say little"
        )
        hint = "ask with `--assume nothing` what viewers really believe"
        place = story.place(ast.Assume, ast.Objective)
        found.append(Diagnostic("refuted", message, place, hint, severity="warning"))
    return tuple(found)
