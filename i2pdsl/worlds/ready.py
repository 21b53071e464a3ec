"""Worlds made ready to be searched and asked: planned, or their controllers found."""

from __future__ import annotations

import time
from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from i2pdsl.worlds.kind import Spec, Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.world import Viewer, World


def viewers_of(spec: Spec, observers: tuple[Any, ...]) -> tuple[Viewer, ...]:
    """The observers of a story (language/story.py) as viewers of its world."""
    return tuple(
        Viewer(spec.with_settings(dict(o.settings)), o.prior, o.known, o.sharpness, o.particles)
        for o in observers
    )


@lru_cache(maxsize=4)
def _world(spec: Spec, viewers: tuple[Viewer, ...], _versions: tuple[Hashable, ...]) -> World:
    return kind_of(spec).build(spec, viewers, _watch)


_watch = _usual = Watch()


@contextmanager
def watched(watch: Watch) -> Iterator[None]:
    """Within it `watch` is told of worlds that are made ready without another."""
    global _usual
    before, _usual = _usual, watch
    try:
        yield
    finally:
        _usual = before


def ready_world(spec: Spec, viewers: tuple[Viewer, ...], watch: Watch | None = None) -> World:
    """A world ready for its viewers; the last few are kept in memory. Raises StoryError."""
    global _watch  # the cached function must not depend on who watches
    began = time.perf_counter()
    _watch = watch or _usual
    version = kind_of(spec).version
    try:
        versions = tuple(version(each) for each in (spec, *(v.spec for v in viewers)))
        return _world(spec, viewers, versions)
    finally:
        _watch.add("plan", began)
        _watch = Watch()
