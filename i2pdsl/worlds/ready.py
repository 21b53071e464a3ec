"""Worlds made ready to be searched and asked: planned, or their controllers found."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from i2pdsl.worlds.find import Spec
from i2pdsl.worlds.grid.world import build_world, unplanned_world
from i2pdsl.worlds.hill.controllers import controllers_version
from i2pdsl.worlds.hill.spec import HillSpec
from i2pdsl.worlds.hill.world import build_hill
from i2pdsl.worlds.world import Viewer, World


@dataclass
class Watch:
    """Where long work reports to; the command line fills in progress bars and messages."""

    planning: Callable[[str, int, float, float | None], None] | None = None
    searching: Callable[[int, int], None] | None = None
    training: Callable[[int, int, dict[str, float]], None] | None = None
    say: Callable[[str], None] | None = None
    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, stage: str, began: float) -> None:
        self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - began


def viewers_of(spec: Spec, observers: tuple[Any, ...]) -> tuple[Viewer, ...]:
    """The observers of a story (language/story.py) as viewers of its world."""
    return tuple(Viewer(spec.with_settings(dict(o.settings)), o.prior) for o in observers)


@lru_cache(maxsize=4)
def _world(spec: Spec, viewers: tuple[Viewer, ...], _trained: tuple[Any, ...]) -> World:
    if isinstance(spec, HillSpec):
        return build_hill(spec, viewers, _watch.say)
    return build_world(spec, viewers, _watch.planning, _watch.say)


_watch = Watch()


def ready_world(spec: Spec, viewers: tuple[Viewer, ...], watch: Watch | None = None) -> World:
    """A world ready for its viewers; the last few are kept in memory. Raises StoryError."""
    global _watch  # the cached function must not depend on who watches
    began = time.perf_counter()
    _watch = watch or Watch()
    try:
        return _world(spec, viewers, _versions(spec, viewers))
    finally:
        _watch.add("plan", began)
        _watch = Watch()


def _versions(spec: Spec, viewers: tuple[Viewer, ...]) -> tuple[Any, ...]:
    """What tells controllers from those that another training has put in their place."""
    if not isinstance(spec, HillSpec):
        return ()
    return tuple(controllers_version(each) for each in (spec, *(v.spec for v in viewers)))


def world_of_rules(spec: Spec) -> World:
    """A world that knows what can happen, not what anyone expects: enough to check a script."""
    return build_hill(spec) if isinstance(spec, HillSpec) else unplanned_world(spec)
