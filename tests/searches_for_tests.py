"""Searches that tests shorten: a beam mostly looks again at what it found (`polish`), and its
program is compiled for longer than it runs in a world of a few cells."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import pytest

from fuzz_for_tests import FULL
from i2pdsl.search import beam
from i2pdsl.stories import Result, Story


def with_polish(story: Story, most: int) -> Story:
    """A story; in `make test` its beams look again no more than so many times as long."""
    plan = story.typed.search
    if FULL or plan.polish <= most:
        return story
    return replace(story, typed=replace(story.typed, search=replace(plan, polish=most)))


@contextmanager
def searching_once() -> Iterator[None]:
    """In `make test` no beam looks again."""
    solve = Story.solve

    def solved(self: Story, *given: Any, **more: Any) -> Result:
        return solve(with_polish(self, 0), *given, **more)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Story, "solve", solved)
        yield


@contextmanager
def compiling_briefly(places: int | None = None) -> Iterator[None]:
    """No beam's program is compiled to last: it runs once or twice, for a few starts. With
    `places`, it searches from so many at a time; else from 64 or more, which takes as long for one.
    """
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(beam, "BRIEF_SECONDS", math.inf)
        if places is not None:
            patched.setattr(beam, "block_size", lambda *_: places)
        yield
