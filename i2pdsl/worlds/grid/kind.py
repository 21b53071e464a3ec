"""Grid worlds as a kind (worlds/kind.py): planned ahead, searched by beams."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

from i2pdsl.errors import Diagnostic, Source, error, whole_file
from i2pdsl.language.story import TypedStory
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.worlds.beginnings import roles_among
from i2pdsl.worlds.drawings import Files
from i2pdsl.worlds.grid import describe
from i2pdsl.worlds.grid.cost import is_plainly_brief
from i2pdsl.worlds.grid.map import SYNTAX
from i2pdsl.worlds.grid.painting import read_map, with_map
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.reach import goal_warnings
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary
from i2pdsl.worlds.kind import Approximation, DrawnMap, Imported, Prepared, Watch
from i2pdsl.worlds.kind_of_turns import KindOfTurns

if TYPE_CHECKING:
    import numpy as np

    from i2pdsl.worlds.grid.world import GridWorld
    from i2pdsl.worlds.record import Record, Trajectory
    from i2pdsl.worlds.world import Viewer


class GridKind(KindOfTurns):
    syntax = SYNTAX
    suggested = (1, 20)
    catalogued = ("kitchen",)

    def parse(self, source: Source, name: str, files: Files | None = None) -> GridSpec:
        return parse_world(source, name, files)

    def map_of(self, source: Source) -> DrawnMap | None:
        return read_map(source)

    def with_map(self, source: Source, drawn: DrawnMap) -> str:
        return with_map(source, drawn)

    def imported(self, source: Source, file: str, name: str, number: int) -> Imported:
        from i2pdsl.worlds.grid.foreign.write import imported

        return imported(source, file, name, number)

    def drawings(self, spec: GridSpec) -> Mapping[str, str]:
        return dict(spec.look.drawings)

    def imagined_otherwise(self, spec: GridSpec) -> GridSpec | None:
        """With the other level 0, where anybody is modelled."""
        if not any(c.models for c in spec.characters):
            return None
        other = {"uniform": "costs", "costs": "uniform"}[spec.settings.level0]
        return spec.with_settings({"level0": other})

    def approximation(self, spec: GridSpec) -> Approximation | None:
        from i2pdsl.worlds.grid.method import approximation

        return approximation(spec)

    def around(
        self,
        world: GridWorld,
        viewers: tuple[Viewer, ...],
        paths: Sequence[Trajectory],
        watch: Watch,
    ) -> tuple[GridWorld, list[Trajectory]] | None:
        from i2pdsl.worlds.grid.around import around

        return around(world, viewers, paths, watch)

    def vocabulary(self, spec: GridSpec) -> Vocabulary:
        return grid_vocabulary(spec)

    def as_json(self, spec: GridSpec) -> dict[str, Any]:
        most = _at_once(spec)
        told = {} if most is None else {"method": "additive", "at_once": most}
        return describe.as_json(spec) | told

    def in_words(self, spec: GridSpec) -> list[str]:
        most = _at_once(spec)
        told = (
            [] if most is None else [f"planned additively, {most} at once: beliefs are approximate"]
        )
        return describe.in_words(spec) + told

    def warnings(
        self, spec: GridSpec, where: str, story: TypedStory | None = None
    ) -> tuple[Diagnostic, ...]:
        told = _method_warnings(spec, where)
        if story is None:
            return goal_warnings(spec, where) + told
        return goal_warnings(spec, where, story.start, story.length) + told

    def roles(self, spec: GridSpec, words: Vocabulary) -> dict[str, str]:
        return roles_among(spec.characters, words)

    def has_same_rules(self, one: GridSpec, other: GridSpec) -> bool:
        return replace(one, settings=other.settings) == other

    # Ready to be searched and asked.

    def build(self, spec: GridSpec, viewers: tuple[Viewer, ...], watch: Watch) -> GridWorld:
        from i2pdsl.worlds.grid.world import build_world

        return build_world(spec, viewers, watch.planning, watch.say)

    def rules(self, spec: GridSpec) -> GridWorld:
        from i2pdsl.worlds.grid.world import unplanned_world

        return unplanned_world(spec)

    def plan(self, spec: GridSpec, watch: Watch) -> Prepared:
        from i2pdsl.worlds.grid.world import build_world

        began = time.perf_counter()
        built = build_world(spec, None, watch.planning, watch.say)
        problems = sum(table.shape[1] for table in built.tables.continuation)
        is_cached = built.planning_seconds == 0
        document = {
            "world": spec.name,
            "states": built.dynamics.state_count,
            "problems": problems,
            "residual": built.residual,
            "bound": None if math.isnan(built.bound) else built.bound,
            "cached": is_cached,
            "seconds": round(time.perf_counter() - began, 3),
        }
        where = "read from the cache" if is_cached else "solved and stored"
        right = "additive" if math.isnan(built.bound) else f"values right to {built.bound:.2g}"
        words = (
            f"{spec.name}: {built.dynamics.state_count:,} states, {problems} problems, residual "
            f"{built.residual:.2g}, {right}, {where} in {document['seconds']:.1f} s"
        )
        return Prepared(document, words)

    def training_settings(self, spec: GridSpec) -> tuple[str, ...]:
        message = f"world {spec.name} is not trained but planned"
        raise error("no-training", message, whole_file(spec.name), f"`i2p plan {spec.name}`")

    # Scripts.

    def start_as_json(self, world: GridWorld, state: Any) -> dict[str, Any]:
        from i2pdsl.worlds.grid.script import state_as_json

        return state_as_json(world.spec, world.dynamics, int(state))

    def begun(self, record: Record) -> str:
        from i2pdsl.worlds.grid.script import placed_in_words

        return " and ".join(placed_in_words(name, at) for name, at in record.start.items())

    def kept(self, world: GridWorld, path: Trajectory, first: int, last: int) -> list[str]:
        from i2pdsl.worlds.grid.script import kept_in_words

        return kept_in_words(world, path, first, last)

    def frames_as_json(self, world: GridWorld, path: Trajectory) -> tuple[dict[str, Any], ...]:
        from i2pdsl.worlds.grid.script import frames_as_json

        return frames_as_json(world, path)

    def read(self, world: GridWorld, record: Record) -> Trajectory:
        from i2pdsl.worlds.grid.script import GridReader

        return GridReader(world, record).read()

    def columns(self, words: Vocabulary, record: Record) -> Mapping[str, tuple[list[Any], str]]:
        """Those of what is done, and the event."""
        events = [None, *(_event(frame.get("event")) for frame in record.frames)]
        return {**super().columns(words, record), "event": (events, "string")}

    def naive(
        self,
        world: GridWorld,
        story: TypedStory,
        allowed: np.ndarray,
        rational: np.ndarray,
        seed: int,
    ) -> Trajectory:
        from i2pdsl.worlds.grid.naive import naive_rollout
        from i2pdsl.worlds.record import empty, extended

        start, actions, _ = naive_rollout(world, story.length, allowed, rational, seed)
        return extended(world, empty(world, start), actions)

    def distance(self, world: GridWorld, first: np.ndarray, second: np.ndarray) -> float:
        from i2pdsl.worlds.grid.script import APART, distance

        return distance(world, first, second) / APART

    def meet(self, world: GridWorld, states: np.ndarray) -> bool:
        pairs = list(combinations(range(len(world.spec.characters)), 2))
        touch = (world.feature(world.tables, "adjacent", pair, states).any() for pair in pairs)
        return not pairs or any(map(bool, touch))

    # By hand.

    def frame_in_words(self, world: GridWorld, path: Trajectory, frame: int) -> str:
        from i2pdsl.worlds.grid.script import turn_in_words

        return turn_in_words(world, int(path.actions[frame - 1]))[1:-1]

    def continuation_in_words(self, world: GridWorld, path: Trajectory, first: int) -> str:
        from i2pdsl.worlds.grid.script import turn_in_words

        return " ".join(turn_in_words(world, int(a)) for a in path.actions[first - 1 :])


def _at_once(spec: GridSpec) -> int | None:
    """How many entities are planned for together; None where all are, exactly. Most worlds need no
    arrays to tell."""
    if spec.settings.method != "additive" and is_plainly_brief(spec):
        return None
    from i2pdsl.worlds.grid.method import at_once

    return at_once(spec)


def _method_warnings(spec: GridSpec, where: str) -> tuple[Diagnostic, ...]:
    if spec.settings.method != "auto" or is_plainly_brief(spec):
        return ()
    from i2pdsl.worlds.grid.method import method_warnings

    return method_warnings(spec, where)


def _event(event: Mapping[str, Any] | None) -> str | None:
    """An event as a story has it: `deus(table)`."""
    told = [f"{kind}({thing})" for kind, thing in (event or {}).items() if kind != "to"]
    return told[0] if told else None


KIND = GridKind()
