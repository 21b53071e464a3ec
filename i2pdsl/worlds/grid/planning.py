"""The plans of a grid world: its problems solved, looked at, and kept (problems.py says which)."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from i2pdsl.computing import computing
from i2pdsl.errors import StoryError, error, whole_file
from i2pdsl.planning import store
from i2pdsl.planning.problem import Problem, Response, boltzmann, expected_reward
from i2pdsl.sizes import memory_limit
from i2pdsl.worlds.grid.arrays import Terms
from i2pdsl.worlds.grid.cost import listed_arrangements, planning_bytes
from i2pdsl.worlds.grid.dynamics import Dynamics
from i2pdsl.worlds.grid.problems import (
    Key,
    answering,
    choices,
    costs,
    expectations,
    ground,
    imagined,
    on_goal,
    plain,
    problem_keys,
    rules_of,
)
from i2pdsl.worlds.grid.spec import GridSpec

Report = Callable[[str, int, float, float | None], None]
"""Progress: (stage, sweep, residual, expected number of sweeps or None)."""

MODELLED = 1e-3  # what a modeller expects of the other is so much nearer to the truth
FORGIVEN = 1e-4  # the residual that will do where rounding keeps values from settling further
LARGEST_INDEX = 2**31 - 1  # of states and arrangements: searches count in 32 bits
SAMPLE = 1024  # states at which a plan from the cache is looked at
SMALLER = "make the map smaller, or take an object away"
Keys = tuple[tuple[Key, ...], ...]
"""The problems of each character."""


@dataclass(frozen=True)
class Plan:
    """The solved problems of a world.

    Attributes:
        keys: for each character, its problems.
        continuation: for each character float64 [S, P], the value after an action; with a horizon
            float32 [F * S, P], for each frame (arrays.py). Additive: [R, P], of all sub-worlds.
        residual: the largest Bellman residual that was reached; of a sample of the states where
            the plan came from the cache.
        bound: no value is further from the truth; not a number where that is not known.
        seconds: the time that solving took, 0 where the plan came from the cache.
        terms: of what values are the sum, where they are additive (additive.py).
    """

    keys: Keys
    continuation: tuple[np.ndarray, ...]
    residual: float
    bound: float
    seconds: float = 0.0
    terms: tuple[Terms, ...] | None = None


def estimated_bytes(spec: GridSpec, keys: Keys | None = None) -> int:
    """Memory that planning takes at its peak."""
    return planning_bytes(spec, sum(map(len, keys or problem_keys(spec))))


def check_memory(spec: GridSpec, what_fits: str | None = None) -> None:
    """Refuses a world whose tables would not fit, before any work. Raises StoryError.

    Args:
        what_fits: a hint at what would.
    """
    needed, available = estimated_bytes(spec), memory_limit()
    whole = whole_file(f"{spec.name}.world")
    if needed > available and not spec.is_limited:
        message = (
            f"the world has {spec.state_count:,} states; planning would take "
            f"{needed / 2**30:.1f} GiB of memory, {available / 2**30:.1f} GiB are there"
        )
        raise error("too-large", message, whole, what_fits or SMALLER)
    check_numbers(spec)


def check_numbers(spec: GridSpec) -> None:
    """Refuses a world whose states cannot be numbered. Raises StoryError."""
    whole, hint = whole_file(f"{spec.name}.world"), SMALLER
    listed = listed_arrangements(spec)
    if listed > LARGEST_INDEX:
        message = (
            f"the world has {listed:,} arrangements of its characters and objects, more "
            f"than can be numbered ({LARGEST_INDEX:,})"
        )
        raise error("too-large", message, whole, hint)
    if spec.state_count * spec.frame_count > LARGEST_INDEX and not spec.is_limited:
        message = (
            f"{spec.state_count:,} states in each of {spec.frame_count:,} frames are more than can "
            f"be numbered ({LARGEST_INDEX:,})"
        )
        raise error("too-large", message, whole, f"a shorter `horizon`; or {hint}")


def load_or_plan(
    spec: GridSpec,
    dynamics: Callable[[], Dynamics],
    report: Report | None = None,
    say: Callable[[str], None] | None = None,
    keys: Keys | None = None,
) -> Plan:
    """The plan from the cache, or solved now and stored there.

    An entry that is damaged, or holds anything but this plan, is said and made again.

    Args:
        keys: the problems that are wanted of each character, and of those whom it models; all of
            them by default.
    """
    keys = keys or problem_keys(spec)
    name = f"{spec.planning_key}-{_digest(keys)}"
    built = dynamics() if spec.is_limited else None
    count = spec.state_count if built is None else built.state_count
    states = count * spec.frame_count
    shapes = {f"continuation_{i}": (states, len(k)) for i, k in enumerate(keys)}
    size = sum(8 * states * problems for states, problems in shapes.values())
    found = store.load(name, say, size + 2**16)
    if found is not None:
        plan = _plan_of(spec, dynamics, keys, shapes, found)
        if plan is not None:
            return plan
        store.refuse(name, "does not fit the world", say)
    check_memory(spec)
    with computing(say):
        plan = solve(spec, dynamics(), report=report, say=say, keys=keys)
    store.save(name, dict(zip(shapes, plan.continuation, strict=True)), say)
    return plan


def _plan_of(
    spec: GridSpec,
    dynamics: Callable[[], Dynamics],
    keys: Keys,
    shapes: dict[str, tuple[int, int]],
    found: dict[str, np.ndarray],
) -> Plan | None:
    """The plan that a cache holds, if it is one: everywhere finite, and right in some states."""
    right = {key: (shape, _precision(spec)) for key, shape in shapes.items()}
    if {key: (array.shape, array.dtype) for key, array in found.items()} != right:
        return None
    values = tuple(np.ascontiguousarray(found[key]) for key in shapes)
    if not all(np.isfinite(array).all() for array in values):
        return None
    count = next(iter(shapes.values()))[0]
    # Nobody who writes the file can know the sample.
    some = np.arange(count) if count <= SAMPLE else np.random.default_rng().choice(count, SAMPLE)
    residuals = _residuals(spec, dynamics(), keys, values, some)
    for who, residual in enumerate(residuals):
        rounding = 16 * float(np.finfo(values[who].dtype).eps * np.abs(values[who]).max(initial=0))
        if not residual <= 2 * _tolerance(spec, who) + rounding:
            return None
    return Plan(keys, values, max(residuals), _bound(spec, residuals, values))


def _digest(keys: Keys) -> str:
    import hashlib

    text = json.dumps([[plain(key) for key in each] for each in keys])
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def solve(
    spec: GridSpec,
    dynamics: Dynamics,
    tolerance: float | None = None,
    report: Report | None = None,
    say: Callable[[str], None] | None = None,
    keys: Keys | None = None,
) -> Plan:
    """Solves all problems of a world exactly: to a Bellman residual of `tolerance`, or one for
    which beliefs are right to 1e-4 and values to 1e-2.

    Raises StoryError if the values do not settle.
    """
    import time

    from i2pdsl.planning.value_iteration import NotConverged
    from i2pdsl.planning.value_iteration import solve as solve_problems

    started = time.perf_counter()
    keys = keys or problem_keys(spec)
    if not is_plain(spec):
        return _solve_by_induction(spec, dynamics, keys, tolerance, report, say)
    found: dict[int, np.ndarray] = {}
    residuals = [0.0] * len(keys)
    for who in map(spec.characters.index, spec.by_depth):
        if not keys[who]:
            found[who] = np.zeros((dynamics.state_count, 0))
            continue
        problem = family_of(spec, dynamics, who, keys, found)
        try:
            solution = solve_problems(
                problem,
                tolerance=tolerance or _tolerance(spec, who),
                forgiven=FORGIVEN,
                progress=None if report is None else partial(report, spec.characters[who].name),
                say=say,
            )
        except NotConverged as problem_:
            raise _not_settled(spec, str(problem_)) from None
        found[who], residuals[who] = solution.continuation, solution.residual
    arrays = tuple(found[i] for i in range(len(keys)))
    bound, seconds = _bound(spec, residuals, arrays), time.perf_counter() - started
    return Plan(keys, arrays, max(residuals), bound, seconds)


def family_of(
    spec: GridSpec,
    dynamics: Dynamics,
    who: int,
    keys: Keys,
    found: dict[int, np.ndarray],
) -> Problem:
    """All problems of a character; they need the continuations of those whom it models."""
    problem = _alone(spec, dynamics, who, keys[who])
    answers = []
    for other in answering(spec, who):
        seen = choices(spec, keys, who, other)
        if seen is None:
            policy, social = imagined(spec, other)[None, :, None], None
            choice, rho = np.zeros(len(keys[who]), dtype=int), np.zeros(len(keys[who]))
        else:
            choice, rho = seen
            theirs = _alone(spec, dynamics, other, keys[other])
            policy = boltzmann(theirs, found[other], spec.settings.beta)
            social = expected_reward(policy, theirs.reward[:, theirs.goal], costs(spec, other))
            at_random = np.full((1, *policy.shape[1:]), 1 / policy.shape[1])
            policy = np.concatenate([policy, at_random])
            social = np.concatenate([social, np.zeros((len(social), 1))], axis=1)
        success = spec.characters[other].success
        answers.append(Response(dynamics.successor[other], success, policy, choice, social, rho))
    return replace(problem, answers=tuple(answers))


def _tolerance(spec: GridSpec, who: int) -> float:
    """The Bellman residual to which a character's problems are solved.

    A residual r bounds the error of values by r / (1 - gamma). What viewers believe depends on
    beta times the differences of values, and what they expect on beliefs times values, which grow
    with 1 / (1 - gamma): measured against tight solutions (tests/test_accuracy.py). Rounding sets
    a limit of its own.
    """
    numbers = spec.settings
    far = 1 - numbers.gamma
    wanted = min(1e-6, 1e-4 * far) * min(1.0, 2 / max(numbers.beta, 1e-9))
    wanted *= (MODELLED * min(1.0, 100 * far) ** 2) ** _modelled(spec, spec.characters[who].name)
    return max(wanted, 2 * float(np.finfo(float).eps) * _largest_reward(spec, who) / far)


def _modelled(spec: GridSpec, name: str) -> int:
    """How many model it one behind the other."""
    above = (c.name for c in spec.characters if name in c.models)
    return max((1 + _modelled(spec, each) for each in above), default=0)


def _largest_reward(spec: GridSpec, who: int) -> float:
    """The largest reward of a character for a turn, whatever its sign."""
    numbers, c = spec.settings, spec.characters[who]
    own = abs(numbers.goal) + max(abs(numbers.move), abs(numbers.stay))
    own += max((abs(tile.cost) for tile in spec.tiles), default=0.0)
    return own * (1 + sum(max(map(abs, values)) for _, values in c.attitudes))


def largest_value(spec: GridSpec, who: int) -> float:
    """What no value of a character can exceed, whatever its sign."""
    return _far(spec) * _largest_reward(spec, who)


def _bound(spec: GridSpec, residuals: list[float], found: tuple[np.ndarray, ...]) -> float:
    """How far the values may be from the truth: each from the solution of its own equation, and
    a modeller's also because others' policies are those of values not quite right.

    An error e of another's values changes the odds of its actions by at most exp(2 beta e), and
    a policy that differs by d in sum gives values that differ by at most d / (1 - gamma) times
    half the range of what comes after it.
    """
    if not is_plain(spec):
        return _far(spec) * max(residuals)
    bounds: dict[str, float] = {}
    for c in spec.by_depth:
        who = spec.characters.index(c)
        changed = sum(float(np.expm1(2 * spec.settings.beta * bounds[name])) for name in c.models)
        after = float(np.ptp(found[who], axis=0).max(initial=0.0)) / 2 + 2 * _largest_reward(
            spec, who
        )
        bounds[c.name] = _far(spec) * (residuals[who] + changed * after)
    return max(bounds.values())


def _not_settled(spec: GridSpec, reason: str) -> StoryError:
    hint = "a gamma nearer to 0 settles faster"
    return error("planning", f"planning did not settle: {reason}", whole_file(spec.name), hint)


def _alone(spec: GridSpec, dynamics: Dynamics, who: int, keys: tuple[Key, ...]) -> Problem:
    """The problems of a character whom nobody answers."""
    own = [key._replace(others=()) for key in keys]
    goals = list(dict.fromkeys(own))
    standing = on_goal(spec, dynamics, who, goals) * spec.settings.goal
    here, spot = dynamics.cells[:, who], dynamics.cells[:, dynamics.spots[who]]
    reward = standing[:, spot].T - ground(spec, dynamics)[here, None]
    return Problem(
        successor=dynamics.successor[who],
        success=spec.characters[who].success,
        reward=np.ascontiguousarray(reward),
        cost=costs(spec, who),
        goal=np.array([goals.index(goal) for goal in own]),
        gamma=spec.settings.gamma,
    )


# With a horizon, or together (induction.py).


def is_plain(spec: GridSpec) -> bool:
    """Whether planning has no end, and one acts after the other."""
    return not (spec.settings.horizon or spec.together)


def _precision(spec: GridSpec) -> np.dtype:
    """Of the values that are kept: with a horizon those of all frames, in single precision."""
    return np.dtype(np.float32 if spec.settings.horizon else np.float64)


def _far(spec: GridSpec) -> float:
    """By how much a residual can add up to an error: that of later frames is discounted."""
    gamma, frames = spec.settings.gamma, spec.settings.horizon
    return (1 - gamma**frames) / (1 - gamma) if frames else 1 / (1 - gamma)


def _solve_by_induction(
    spec: GridSpec,
    dynamics: Dynamics,
    keys: Keys,
    tolerance: float | None,
    report: Report | None,
    say: Callable[[str], None] | None,
) -> Plan:
    """`solve`, with a horizon or together."""
    import time

    from i2pdsl.worlds.grid.induction import NotSettledError, by_frames, without_end

    started = time.perf_counter()
    numbers, against = spec.settings, expectations(spec, keys)
    told = None if report is None else partial(report, spec.name)
    if numbers.horizon:
        tables = rules_of(spec, dynamics, keys, frames=True)
        values = by_frames(tables, against, spec.together, numbers.horizon, numbers.end, told, say)
        count = dynamics.state_count * spec.frame_count
        some = np.arange(0, count, max(1, count // SAMPLE))
        residuals = _residuals(spec, dynamics, keys, values, some)
    else:
        tables = rules_of(spec, dynamics, keys, frames=False)
        wanted = [tolerance or _tolerance(spec, who) for who in range(len(keys))]
        try:
            values, residuals = without_end(tables, against, wanted, told, say)
        except NotSettledError as problem:
            raise _not_settled(spec, str(problem)) from None
    seconds = time.perf_counter() - started
    return Plan(keys, values, max(residuals), _bound(spec, residuals, values), seconds)


def _residuals(
    spec: GridSpec,
    dynamics: Dynamics,
    keys: Keys,
    values: tuple[np.ndarray, ...],
    some: np.ndarray,
) -> list[float]:
    """How far each character's values are from what those that come after imply, in some states."""
    from i2pdsl.worlds.grid.induction import implied

    numbers, against = spec.settings, expectations(spec, keys)
    tables = rules_of(spec, dynamics, keys, frames=bool(numbers.horizon))
    tables = tables._replace(continuation=values)
    last = (numbers.horizon - 1) * dynamics.state_count
    is_last = some >= last if numbers.horizon else some < 0
    worst = [0.0] * len(keys)
    for states, end in ((some[~is_last], None), (some[is_last], numbers.end)):
        for who in (w for w, each in enumerate(keys) if each and len(states)):
            with np.errstate(all="ignore"):  # numbers of any size may stand in a file
                found = implied(tables, against, spec.together, who, states, end)
                worst[who] = max(worst[who], float(np.abs(found - values[who][states]).max()))
    return worst
