"""Planning where the plain equations of planning/value_iteration.py do not hold: with a limited
number of frames (backward induction), and for two who act together.

Both solve what model.py:action_values says of the tables, with one function, `implied`: what the
values of the next frame make of those of this one. With a horizon it is applied once for each
frame, from the last to the first; without, until nothing but a common drift changes (value
iteration; the bounds are MacQueen's, see planning/value_iteration.py).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from i2pdsl.sizes import padded_size
from i2pdsl.worlds.grid.arrays import Against, Tables, arrangement, at_goal, namespace
from i2pdsl.worlds.grid.following import in_frame
from i2pdsl.worlds.grid.policy import action_values, expected_of_other, others_reward

Array = Any
Report = Callable[[int, float, float | None], None]
Expected = tuple[tuple[Against, ...], ...]
"""What each character expects of those who answer it (problems.py)."""

CHUNK = 1024  # states that are looked at together: what they need fits into a processor's cache
MOST_SWEEPS = 100_000


class NotSettledError(Exception):
    """Values did not settle."""


def implied(
    tables: Tables,
    against: Expected,
    together: bool,
    who: int,
    state: Array,
    end: float | None = None,
) -> Array:
    """A character's continuation [..., P] in some states, from what comes after them.

    Args:
        tables: of which the continuations after these are read: those of the next frame, and where
            they act one after the other, those of who answers in this frame.
        against: what each expects of those who answer.
        end: in the last frame the reward of standing on one's goal then, else None.
    """
    xp = namespace(tables.cells)
    here = arrangement(tables, state)
    now, count = state - here, len(tables.goals)
    later = now if tables.layer is None else now + tables.layer

    def ahead(place: Array) -> Array:
        if end is not None:
            return end * _standing(tables, against[who], who, place)
        return xp.max(action_values(tables, who, in_frame(later, place)), axis=-2)

    def answered(place: Array, more: int) -> Array:
        """What is expected from an arrangement in which others are still to act."""
        other = (who + more) % count
        ends = end is not None and other < who  # there is no next frame in which it would act
        if more == count or ends or together:
            return ahead(place)
        mine, frame = against[who][more - 1], now if other > who else later
        policy = expected_of_other(tables, mine, other, in_frame(frame, place))
        social = others_reward(tables, mine, policy, other, place)
        moved = answered(xp.moveaxis(tables.successor[other][:, place], 0, -1), more + 1)
        p = tables.success[other]
        after = p * moved + (1 - p) * answered(place, more + 1)[..., None, :]
        return mine.rho * social + (policy * after).sum(-2)

    return answered(here, 1)


def _standing(tables: Tables, against: tuple[Against, ...], who: int, place: Array) -> Array:
    """How many rewards of the end a character has: its own, and others' by rho: [..., P]."""
    reward = at_goal(tables, who, place) * 1.0
    for more, mine in enumerate(against, 1):
        other = (who + more) % len(tables.goals)
        if mine.problem is not None:
            theirs = at_goal(tables, other, place)
            reward = reward + mine.rho * (mine.known * theirs[..., mine.problem])
    return reward


def by_frames(
    tables: Tables,
    against: Expected,
    together: bool,
    frames: int,
    end: float,
    report: Report | None = None,
    say: Callable[[str], None] | None = None,
) -> tuple[np.ndarray, ...]:
    """The continuations of each frame: for each character float32 [frames * S, P].

    Args:
        tables: without continuations, of one frame.
    """
    import jax

    states = len(tables.cells)
    sizes = [goals.shape[0] for goals in tables.goals]
    found = tuple(np.zeros((frames * states, size), np.float32) for size in sizes)
    with jax.enable_x64(True):
        run = _Program(tables, against, together, say)
        window = [np.zeros((2 * run.size, size)) for size in sizes]
        for frame in range(frames - 1, -1, -1):
            for values in window:
                values[run.size :] = values[: run.size]
            for who in reversed(range(len(sizes))):
                is_last = frame == frames - 1
                now = run.plain(window, who, end) if is_last else run(window, who)
                window[who][: run.size] = now
                found[who][frame * states : (frame + 1) * states] = now[:states]
            if report is not None:
                report(frames - frame, 0.0, frames)
    return found


def without_end(
    tables: Tables,
    against: Expected,
    tolerances: list[float],
    report: Report | None = None,
    say: Callable[[str], None] | None = None,
) -> tuple[tuple[np.ndarray, ...], list[float]]:
    """The values of two who act together without an end, float64 [S, P] each, and the residuals.

    Raises NotSettledError where they do not settle to the tolerances.
    """
    import jax

    states, gamma = len(tables.cells), float(tables.gamma)
    sizes = [goals.shape[0] for goals in tables.goals]
    residuals = [np.inf] * len(sizes)
    with jax.enable_x64(True):
        run = _Program(tables, against, True, say)
        values = [np.zeros((run.size, size)) for size in sizes]
        for sweep in range(1, MOST_SWEEPS):
            new = [run(values, who) for who in range(len(sizes))]
            for who, (after, before) in enumerate(zip(new, values, strict=True)):
                change = (after - before)[:states]
                low, high = change.min(0), change.max(0)
                residuals[who] = float((high - low).max() * gamma / 2)
                after += (low + high) / 2 * gamma / (1 - gamma)
            values = new
            if report is not None and sweep % 10 == 0:
                report(sweep, max(residuals), None)
            if all(r <= t for r, t in zip(residuals, tolerances, strict=True)):
                return tuple(v[:states] for v in values), residuals
    raise NotSettledError(f"the residual is {max(residuals):.2g} after {MOST_SWEEPS:,} sweeps")


class _Program:
    """`implied` for all states, compiled, for one character after the other."""

    def __init__(
        self,
        tables: Tables,
        against: Expected,
        together: bool,
        say: Callable[[str], None] | None,
    ):
        import jax

        from i2pdsl.worlds.world import double_precision

        states = len(tables.cells)
        self.size = padded_size(states, CHUNK)
        self.size = -(-self.size // CHUNK) * CHUNK
        self.layered, self.together, self.say = tables.layer is not None, together, say
        self.plain_tables, self.plain_against = tables, against
        wide = lambda array, axis: np.pad(
            array, [(0, self.size - states if i == axis else 0) for i in range(array.ndim)]
        )
        filled = tables._replace(
            cells=wide(tables.cells, 0),
            successor=tuple(wide(table, 1) for table in tables.successor),
            layer=np.array(self.size) if self.layered else None,
        )
        self.tables, self.against = jax.device_put(
            jax.tree.map(double_precision, (filled, against))
        )

    def __call__(self, continuation: list[np.ndarray], who: int) -> np.ndarray:
        """The continuations of a character [size, P] that all [size or 2 size, P] imply."""
        from i2pdsl.programs import compiled_program

        arguments = self.tables._replace(continuation=tuple(continuation)), self.against
        program = compiled_program(
            ("induction", self.together, who),
            partial(_everywhere, self.together, who),
            arguments,
            0,
            self.say,
        )
        return np.array(program.run(*arguments))

    def plain(self, continuation: list[np.ndarray], who: int, end: float) -> np.ndarray:
        """The same of the last frame, whose end is easily looked at."""
        states = len(self.plain_tables.cells)
        layer = np.array(self.size) if self.layered else None
        tables = self.plain_tables._replace(continuation=tuple(continuation), layer=layer)
        found = np.zeros((self.size, continuation[who].shape[1]))
        for first in range(0, states, CHUNK):
            some = np.arange(first, min(first + CHUNK, states))
            found[some] = implied(tables, self.plain_against, self.together, who, some, end)
        return found


def _everywhere(together: bool, who: int, tables: Tables, against: Expected) -> Array:
    """`implied` for each arrangement, in pieces."""
    import jax
    import jax.numpy as jnp

    states = jnp.arange(tables.cells.shape[0]).reshape(-1, CHUNK)
    found = jax.lax.map(lambda some: implied(tables, against, together, who, some), states)
    return found.reshape(-1, found.shape[-1])
