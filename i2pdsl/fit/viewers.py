"""What viewers answer about scripts, as a differentiable function of what kind of viewers they are.

The audience is the product's own: its likelihoods, its filter, its evaluation of expressions. Only
what a viewer's parameters change is computed again: how sharply choices are expected, what is
forgotten, and the prior.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from i2pdsl.audience.filter import Switching, update
from i2pdsl.language import typed as ty
from i2pdsl.objective.compile import Compiler, Params, evaluate_all, reduce_over_history
from i2pdsl.objective.frame import Frame, View
from i2pdsl.objective.hindsight import Chain
from i2pdsl.objective.replay import histories
from i2pdsl.worlds.record import Trajectory
from i2pdsl.worlds.world import World

Array = Any

_NONE = -1e9  # log of the probability of what does not exist


class Viewer(NamedTuple):
    """What kind of viewer somebody is.

    Attributes:
        sharpness: how much more strongly than in the world's file characters seem to prefer what
            is best for them (World.with_audience).
        forgetting: the share of belief that is reassigned after each observed action.
        log_prior: log P(H) before anything moved, [H].
    """

    sharpness: Array
    forgetting: Array
    log_prior: Array


@dataclass(frozen=True)
class Watched:
    """A script that people were asked about, in a world made ready for a single viewer."""

    world: World
    path: Trajectory


@dataclass(frozen=True)
class Question:
    """An expression about a script, after `frame` of its frames."""

    script: int
    value: ty.Typed
    times: range | None
    frame: int


class Seen(NamedTuple):
    """What is observed in S scripts, padded to T frames and A alternatives.

    Attributes:
        choices: log P(a | H) of all that could have been observed, [S, T, U, A, H]; where it is
            not one of so many [S, T, U, 1, H], log P of it.
        taken: which of them it was, [S, T, U].
        observed: whether viewers learn anything from it, [S, T].
        switching: how the goal of who is observed changes; empty if none does.
    """

    choices: Array
    taken: Array
    observed: Array
    switching: tuple[Switching, ...] = ()

    def chain(self, viewer: Viewer) -> Chain:
        """What becomes of a hypothesis after each observation, in a viewer's mind."""
        prior, count = viewer.log_prior[None], self.taken.shape[2]
        changes = tuple(each.given(prior) for each in self.switching) or (None,) * count
        return Chain(jnp.reshape(viewer.forgetting, (1,)), changes)


def what_is_seen(watched: Sequence[Watched]) -> Seen:
    """The evidence of scripts that have the same observations and hypotheses, in doubles."""
    longest, first = max(1, *(len(each.path.actions) for each in watched)), watched[0].world
    found = []
    for each in watched:
        world, path = each.world, each.path
        if len(path.actions):
            seen = (path.states[:-1], path.actions, path.states[1:])
        else:  # nothing has happened yet, but what is observed has its shape
            seen = (path.states, world.no_action(path.states), path.states)
        pairs = world.alternatives(world.tables, *seen)
        if not pairs:
            rows = world.log_rows(world.tables, *seen)
            pairs = tuple((row[:, None], np.zeros(len(row), int)) for row in rows)
        observed = world.is_observed(seen[1]) & (len(path.actions) > 0)
        logs = [np.asarray(log[:, :, 0]) for log, _ in pairs]  # [T, A, H] each
        found.append((logs, np.stack([which for _, which in pairs], axis=1), observed))
    most = max(log.shape[1] for logs, _, _ in found for log in logs)
    choices = [np.stack([_padded(x, 1, most, _NONE) for x in logs], 1) for logs, _, _ in found]
    return Seen(
        np.stack([_padded(each, 0, longest, _NONE) for each in choices]),
        np.stack([_padded(taken, 0, longest, 0) for _, taken, _ in found]),
        np.stack([_padded(observed, 0, longest, False) for _, _, observed in found]),
        tuple(each for each in first.switching(first.tables) if each is not None),
    )


def _padded(array: np.ndarray, axis: int, size: int, value: float) -> np.ndarray:
    widths = [(0, size - n if i == axis else 0) for i, n in enumerate(array.shape)]
    return np.pad(array, widths, constant_values=value)


def log_likelihoods(seen: Seen, sharpness: Array) -> Array:
    """log P(observation | H) for a viewer who expects choices to be so sharp, [S, T, U, H].

    Of alternatives that is softmax(sharpness * log P); what is alone in its place is a density
    whose logarithm grows with it (World.rows_are_scaled).
    """
    # What does not exist keeps its place: the product of such a number is off by hundreds in single
    # precision, and a compiler that fuses it into the difference below makes exp of that.
    powers = jnp.where(seen.choices > _NONE, sharpness * seen.choices, _NONE)
    if seen.choices.shape[3] > 1:
        powers = powers - jax.nn.logsumexp(powers, axis=3, keepdims=True)
    index = seen.taken[..., None, None]
    return jnp.take_along_axis(powers, index, axis=3)[:, :, :, 0]


class History(NamedTuple):
    """What a viewer makes of S scripts: log P(H | script[:t]) for all t, [S, T + 1, H]; then of
    each observation, [S, T, U, H], the belief before it and its log-likelihood."""

    log_belief: Array
    before: Array
    rows: Array


def watch(seen: Seen, viewer: Viewer) -> History:
    """What a viewer believes, frame by frame (audience/filter.py)."""
    rows = log_likelihoods(seen, viewer.sharpness)
    chain = seen.chain(viewer)
    count, observations = rows.shape[0], rows.shape[2]
    prior = jnp.broadcast_to(viewer.log_prior, (count, 1, rows.shape[-1]))

    def frame(belief: Array, step: tuple[Array, Array]) -> tuple[Array, tuple[Array, Array]]:
        row, observed = step  # [S, U, H], [S]
        before = []
        for u in range(observations):
            before.append(belief[:, 0])
            after = update(belief, row[:, u, None], chain.forgetting, chain.switching[u])
            belief = jnp.where(observed[:, None, None], after, belief)
        return belief, (belief[:, 0], jnp.stack(before, axis=1))

    steps = (jnp.moveaxis(rows, 1, 0), jnp.moveaxis(jnp.asarray(seen.observed), 1, 0))
    _, (after, before) = jax.lax.scan(frame, prior, steps)
    whole = jnp.concatenate([prior[:, None, 0], jnp.moveaxis(after, 0, 1)], axis=1)
    return History(whole, jnp.moveaxis(before, 0, 1), rows)


class Answers:
    """The answers of a viewer to questions about scripts, as JAX computes them.

    Questions that look at one frame alone, as `P(rho > 0 | script[:t])` does, are evaluated for all
    scripts together; others (sums over frames, differences, appended turns) script by script.
    """

    def __init__(self, watched: Sequence[Watched], questions: Sequence[Question]):
        self.watched, self.questions = watched, questions
        self.tables = [jax.tree.map(jnp.asarray, each.world.tables) for each in watched]
        self.together: dict[Hashable, list[int]] = {}
        self.alone: list[int] = []
        self.frames = [_only_frame(question) for question in questions]
        for number, question in enumerate(questions):
            if self.frames[number] is None:
                self.alone.append(number)
            else:
                self.together.setdefault(self._alike(question), []).append(number)

    def _alike(self, question: Question) -> Hashable:
        """What questions share that are evaluated together: all but the script and the frame."""
        world = self.watched[question.script].world
        compiler = Compiler(world, 1)
        compiler.build(question.value)
        params = jax.tree.map(lambda a: (a.shape, a.tobytes()), compiler.params())
        needs_state = any(isinstance(n, ty.ValueAt | ty.Feature) for n in ty.walk(question.value))
        return tuple(compiler.shape), repr(params), id(world) if needs_state else None

    def __call__(self, seen: Seen, viewer: Viewer) -> Array:
        """[C], an answer to each question."""
        frames = self._frames(watch(seen, viewer))
        found = jnp.zeros(len(self.questions))
        for numbers in self.together.values():
            found = found.at[np.array(numbers)].set(self._answered_together(frames, numbers))
        answered: dict[Hashable, Array] = {}  # at all frames: a program for each would be slow
        for number in self.alone:
            question = self.questions[number]
            key = (question.script, question.value, question.times)
            if key not in answered:
                length = len(self.watched[question.script].path.actions)
                own = frames.at(np.s_[question.script, : length + 1])
                answered[key] = self._answered(question, own, seen.chain(viewer))
            place = 0 if question.times is None else question.frame - question.times.start
            found = found.at[number].set(answered[key][place])
        return found

    def _frames(self, history: History) -> Frame:
        """All frames of all scripts as a viewer sees them, with one observer, [S, T + 1, ...]; of a
        shorter script the last ones stand for nothing."""
        count, total = history.log_belief.shape[:2]
        belief = history.log_belief[:, :, None]
        # Nothing is observed in frame 0; what would be has its shape.
        none = jnp.zeros((count, 1, *history.rows.shape[2:]))
        seen = lambda part: jnp.concatenate([none, part], axis=1)[:, :, :, None]
        state, action = (
            jnp.asarray(np.stack([part(each) for each in self.watched]))
            for part in (lambda w: _held(w.path.states, total), lambda w: _done(w, total))
        )
        earlier = lambda part: jnp.concatenate([part[:, :1], part[:, :-1]], axis=1)
        return Frame(
            number=jnp.broadcast_to(jnp.arange(total), (count, total)),
            before=earlier(state),
            action=action,
            state=state,
            log_previous=earlier(belief),
            log_belief=belief,
            log_expecting=seen(history.before)[:, :total],
            log_rows=seen(history.rows)[:, :total],
            regret=jnp.zeros((count, total, 1)),
        )

    def _answered_together(self, frames: Frame, numbers: list[int]) -> Array:
        scripts = np.array([self.questions[n].script for n in numbers])
        at = np.array([self.frames[n] for n in numbers])
        first = self.questions[numbers[0]]
        world = self.watched[first.script].world
        compiler = Compiler(world, 1)
        closure = compiler.build(first.value)
        tables = self.tables[first.script]
        scope = _FrameScope(world, tables, compiler.params(), frames.at((scripts, at)))
        return jnp.broadcast_to(jnp.asarray(closure(scope), float), (len(at),))

    def _answered(self, question: Question, frames: Frame, chain: Chain) -> Array:
        """The answer at all frames that the question covers, or one if it has no free t."""
        world = self.watched[question.script].world
        compiler = Compiler(world, len(frames.state) - 1)
        compiler.on_reduction = reduce_over_history(compiler)
        closure = compiler.build(question.value)
        tables = self.tables[question.script]
        turns = histories(world, tables, frames, question.value)
        found = evaluate_all(compiler, closure, tables, turns, question.times, chain=chain)
        shape = (1 if question.times is None else len(question.times),)
        return jnp.broadcast_to(jnp.asarray(found, float), shape)


def _held(states: np.ndarray, total: int) -> np.ndarray:
    """The states of a script, the last one again and again until there are so many."""
    found: np.ndarray = states[np.minimum(np.arange(total), len(states) - 1)]
    return found


def _done(watched: Watched, total: int) -> np.ndarray:
    """What happened in each frame of a script; nothing in frame 0."""
    path = watched.path
    nothing = np.asarray(watched.world.no_action(path.states[:1]))
    return _held(np.concatenate([nothing, path.actions]), total)


_OF_A_FRAME = (
    *(ty.Constant, ty.LatentValue, ty.Symbol, ty.PerHypothesis, ty.ValueAt),
    *(ty.Apply, ty.Belief, ty.Given, ty.Moment),
)


def _only_frame(question: Question) -> int | None:
    """The one frame that a question looks at; None where there are several, or it needs more."""
    nodes = list(ty.walk(question.value))
    moments = [node for node in nodes if isinstance(node, ty.Moment)]
    if not moments or not all(isinstance(node, _OF_A_FRAME) for node in nodes):
        return None
    if any(moment.turns or moment.seen is not None for moment in moments):
        return None
    if any(isinstance(node, ty.Belief) and node.moment is not None for node in nodes):
        return None  # hindsight needs the frames between the two
    if all(moment.offset == 0 for moment in moments):
        return question.frame
    fixed = {moment.frames[0] for moment in moments if moment.first is None}
    is_one = len(fixed) == 1 and all(moment.first is None for moment in moments)
    return fixed.pop() if is_one else None


class _FrameScope:
    """Frames of several scripts side by side, each of which is all that is looked at."""

    held = False
    xp = jnp

    def __init__(self, world: World, tables: Any, params: Params, frame: Frame):
        self.world, self.tables, self.params, self.frame = world, tables, params, frame
        self.t = self.count = frame.number

    def view(self, moment: ty.Moment) -> View:
        return View(self.frame.log_belief, self.frame.state, self.frame)
