"""Beam search over scripts, from many initial states at once (paper, section 3).

Starts are independent: each has its own beam. They are searched in blocks that bound the memory,
some of them at once; between blocks the search can be interrupted, and keeps what it has. After a
first pass over all starts, the best are searched again (rounds.py).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import numpy as np

from i2pdsl.audience.holding import HoldingTables, way_of
from i2pdsl.computing import computing
from i2pdsl.errors import error, whole_file
from i2pdsl.objective.appended import tabulate_turns, worth_a_table
from i2pdsl.objective.compile import Params
from i2pdsl.objective.fold import Objective
from i2pdsl.programs import Program, Say, compiled_program, on_devices
from i2pdsl.search.pool import Rule, grown
from i2pdsl.search.rollout import root
from i2pdsl.search.rounds import Block, rounds
from i2pdsl.search.workers import Workers
from i2pdsl.sizes import memory_limit, padded_size, processors
from i2pdsl.worlds.world import World, single_precision

Array = Any

BLOCK_BYTES = 96 * 2**20  # of working memory for one block
PLACES = 256  # of a block: scripts side by side
WORKERS = 8  # blocks that are searched at once, if there are so many processors

# What a search takes for each child and hypothesis (measured: the kitchen, one core). Another
# machine is not ten times as fast.
CHILD_SECONDS = 1e-8
BRIEF_SECONDS = 0.05  # below, it takes longer to compile well than it saves
LONG, TOO_LONG = 600.0, 24 * 3600.0  # seconds that are said, and that are refused


@dataclass(frozen=True)
class Found:
    """The best script from each start, best first.

    Attributes:
        starts: [N] initial states.
        actions: [N, T].
        scores: [N], in single precision.
        finished: whether all starts were searched.
        compile_seconds: time spent on tracing and compiling.
    """

    starts: np.ndarray
    actions: np.ndarray
    scores: np.ndarray
    finished: bool
    compile_seconds: float


@dataclass(frozen=True)
class More:
    """What a search spends after its first pass.

    Attributes:
        asked: initial states that the story asks for; there may be fewer.
        budget: scripts that may be searched beside those of the first pass.
        fresh: further initial states, for when there is time.
    """

    asked: int
    budget: int
    fresh: np.ndarray


def beam_search(
    world: World,
    objective: Objective,
    length: int,
    starts: np.ndarray,
    width: int,
    events: tuple[int, ...],
    report: Callable[[int, int], None] | None = None,
    say: Callable[[str], None] | None = None,
    more: More | None = None,
) -> Found:
    """Searches from every start, and then again from the best. Ctrl-C ends it early with what was
    found.

    Args:
        starts: [N] initial states.
        width: scripts kept for each start in the first pass.
        events: the allowed events, as numbers of `world.events`.
        report: called with (scripts searched, all scripts).
        say: is told of damaged caches.
        more: what is spent on looking again; nothing by default.

    Raises KeyboardInterrupt if it is interrupted before anything was found, StoryError where it
    would need too much memory, or more than a day.
    """
    more = more or More(len(starts), 0, starts[:0])
    check_size(world, objective, length, len(starts), width, events, say, more.budget)
    ready = prepare_beam(world, objective, length, more.asked, width, more.budget, events, say)
    every = np.concatenate([starts, more.fresh]).astype(np.int32)
    best = np.full(len(every), -np.inf, np.float32)
    found = np.zeros((len(every), length), np.int32)
    searched = np.zeros(len(every), bool)
    total, done, finished = len(starts) * width + more.budget, 0, True
    try:
        with Workers(min(WORKERS, processors())) as workers:
            for blocks in rounds(len(starts), width, ready.places, more.budget, best):
                size = ready.devices
                shares = [blocks[i : i + size] for i in range(0, len(blocks), size)]
                calls = [partial(ready.search, every, share, length) for share in shares]
                each = (one for share in workers.in_turn(calls) for one in share)
                for block, (scores, actions) in zip(blocks, each, strict=True):
                    better = ~searched[block.starts] | (scores > best[block.starts])
                    better_starts = block.starts[better]
                    best[better_starts], found[better_starts] = scores[better], actions[better]
                    searched[block.starts] = True
                    done = min(total, done + len(block.starts) * block.width)
                    if report is not None:
                        report(done, total)
        if report is not None and done < total:
            report(total, total)
    except KeyboardInterrupt:
        if not searched.any():
            raise
        finished = False
    order = np.flatnonzero(searched)
    order = order[np.argsort(-best[order], kind="stable")]
    return Found(every[order], found[order], best[order], finished, ready.seconds)


@dataclass(frozen=True)
class Beam:
    """A beam search that is ready to run: `program` of the tables, parameters, and on each device
    `places` starts and a rule (pool.py).

    `seconds` is the time spent on tracing and compiling.
    """

    program: Program
    tables: Any
    params: Params
    places: int
    devices: int
    seconds: float

    def search(
        self, every: np.ndarray, blocks: list[Block], length: int
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """The best score [G] and actions [G, T] of each start of some blocks, one for each device,
        or fewer; in any thread."""
        given = [blocks[n % len(blocks)] for n in range(self.devices)]
        starts = [np.resize(np.repeat(every[b.starts], b.width), self.places) for b in given]
        rules = [Rule(np.int32(b.width), np.int32(b.alike), np.bool_(b.ahead)) for b in given]
        with computing():
            found = self.program.run(self.tables, self.params, *_stacked(starts, rules))
            every_score, every_action = map(np.asarray, found)
        best = []
        for block, scores, actions in zip(blocks, every_score, every_action, strict=False):
            count, width = len(block.starts), block.width
            own = scores[: count * width].reshape(count, width)
            at = own.argmax(1)
            best.append((own[np.arange(count), at], actions[np.arange(count) * width + at]))
        return best


def _stacked(starts: list[np.ndarray], rules: list[Rule]) -> tuple[np.ndarray, Rule]:
    """What devices are given, [D, ...]."""
    rule = Rule(*(np.stack(parts) for parts in zip(*rules, strict=True)))
    return np.stack(starts).astype(np.int32), rule


def prepare_beam(
    world: World,
    objective: Objective,
    length: int,
    count: int,
    width: int,
    budget: int,
    events: tuple[int, ...],
    say: Callable[[str], None] | None = None,
) -> Beam:
    """Compiles a beam search from `count` starts, and of `budget` scripts more, or finds it in the
    cache."""
    wanted = padded_size(count * width, 64)
    places = max(width, min(wanted, PLACES, block_size(world, objective, length, events)))
    tables = world.search_tables
    began = time.perf_counter()
    params = prepared(world, objective, say)
    layout = world.program_key(objective.suffix_turns)
    key = ("pool", objective.shape, layout, length, events)
    search = partial(_search, world, objective, length, events)
    devices = len(jax.devices())
    rule = Rule(np.int32(1), np.int32(1), np.bool_(False))
    given = _stacked([np.zeros(places)] * devices, [rule] * devices)
    arguments = (tables, params, *given)
    scripts = max(places, count * width + budget)
    brief = expected_seconds(world, objective, length, scripts, events) < BRIEF_SECONDS
    program = compiled_program(key, search, arguments, (0, 0), say, brief, apart=(2, 3))
    tables, params = on_devices((tables, params), devices)
    return Beam(program, tables, params, places, devices, time.perf_counter() - began)


def _search(
    world: World,
    objective: Objective,
    length: int,
    events: tuple[int, ...],
    tables: Any,
    params: Params,
    starts: Array,
    rule: Rule,
) -> tuple[Array, Array]:
    """The score [M] and actions [M, T] of the script that has each place in the end."""
    pool = jax.vmap(partial(root, world, objective, tables, params))(starts)
    return grown(world, objective, length, events, tables, params, pool, rule, params.before)


def branching(world: World, events: tuple[int, ...]) -> int:
    """How many children a script has, those that are not possible included."""
    return world.turn_count + len(events) * world.event_slots


def place_bytes(world: World, objective: Objective, length: int, events: tuple[int, ...]) -> int:
    """Working memory for one place of a block."""
    belief, held = world.tables.log_prior.size, [s for s in world.holdings(world.tables) if s]
    per_child = 4 * belief * 8 + sum(4 * way_of(h).numbers(h) * 8 for h in held)
    if objective.keeps_history:
        per_child += 4 * belief * 8 * (length + 1)
    if not world.lists_hypotheses:
        per_child += _of_holdings(world, objective, length, held)
    kept = sum(4 * way_of(h).carried(h) for h in held)
    return per_child * branching(world, events) + 8 * length + 2 * kept


def _of_holdings(
    world: World, objective: Objective, length: int, held: Sequence[HoldingTables]
) -> int:
    """Working memory for the particles or factors that an objective asks about one child."""
    own = sum(4 * way_of(h).kept(h) for h in held) * (length + 1) * objective.keeps_history
    asked = sum(way_of(h).numbers(h) for h in held)
    return own + world.turn_count * 8 * 2 * asked * objective.looks_around


def block_size(world: World, objective: Objective, length: int, events: tuple[int, ...]) -> int:
    """How many scripts side by side fit into BLOCK_BYTES."""
    return max(1, BLOCK_BYTES // place_bytes(world, objective, length, events))


def check_size(
    world: World,
    objective: Objective,
    length: int,
    starts: int,
    width: int,
    events: tuple[int, ...],
    say: Say | None = None,
    more: int = 0,
) -> None:
    """Refuses a search that does not fit or takes more than a day, and says when it takes long.

    Raises StoryError.
    """
    hint = "fewer `starts`, a smaller `width` or a shorter story"
    size = f"{starts:,} starts x {width:,} scripts x {length:,} frames"
    if more:
        size += f", and {more / (starts * width):,.0f} times as much for improving"
        hint += ", less `polish`, less effort"
    needed = width * place_bytes(world, objective, length, events)
    there = memory_limit() // 2
    if needed > there:
        message = (
            f"the search ({size}) needs {needed / 2**30:.1f} GiB of memory for one start, "
            f"{there / 2**30:.1f} GiB are there"
        )
        raise error("too-large", message, whole_file("search"), hint)
    seconds = expected_seconds(world, objective, length, starts * width + more, events)
    if seconds > TOO_LONG:
        message = f"the search ({size}) would take about {_duration(seconds)}"
        raise error("too-large", message, whole_file("search"), hint)
    if seconds > LONG and say is not None:
        say(f"the search ({size}) takes about {_duration(seconds)}; Ctrl-C keeps what was found")


def expected_seconds(
    world: World, objective: Objective, length: int, scripts: int, events: tuple[int, ...]
) -> float:
    """How long it takes to search so many scripts side by side, roughly."""
    work = processor_seconds(world, objective, length, scripts, events)
    return work / min(WORKERS, processors())


def processor_seconds(
    world: World, objective: Objective, length: int, scripts: int, events: tuple[int, ...]
) -> float:
    """The same of one processor."""
    children = branching(world, events)
    looks = 1 + len(objective.suffix_turns) + (children if objective.looks_around else 0)
    looks *= 1 + length if objective.keeps_history else 1
    believed = world.tables.log_prior.size
    believed += sum(2 * way_of(h).numbers(h) for h in world.holdings(world.tables) if h)
    child = children * believed * looks * CHILD_SECONDS
    return scripts * length * child


def _duration(seconds: float) -> str:
    """A length of time in the largest unit of which there are two."""
    for unit, size in (("days", 86_400), ("hours", 3600)):
        if seconds >= 2 * size:
            return f"{seconds / size:,.0f} {unit}"
    return f"{seconds / 60:.0f} minutes"


def prepared(world: World, objective: Objective, say: Say | None = None) -> Params:
    """An objective's parameters in single precision, with the tables that are worth their time."""
    params = jax.tree.map(single_precision, objective.params)
    turns, tables = objective.suffix_turns, world.search_tables
    if not worth_a_table(world, tables, turns):
        return params
    key = ("turns", turns, world.program_key(turns))
    tabulate = lambda tables: tabulate_turns(world, tables, turns)
    program = compiled_program(key, tabulate, (tables,), (0,) * len(turns), say)
    return params._replace(suffix_rows=program.run(tables))
