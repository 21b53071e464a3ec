"""From the text of a story to films, better and better ones: in a thread of the worker.

A preview looks from few first pictures, once. What is looked for next begins at all of them, and
in the end as `i2p run` does, so that a film that is left alone is the one that it would make.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from i2pdsl.errors import Source, StoryError
from i2pdsl.objective.panel import Judgement
from i2pdsl.render.pictures import drawing_for
from i2pdsl.results import ranked
from i2pdsl.search.searches import search_of
from i2pdsl.search.task import Found
from i2pdsl.stories import Result, Script, Story, story_from
from i2pdsl.studio.hands import PINS, where
from i2pdsl.studio.outline import abilities
from i2pdsl.studio.text import StoryText
from i2pdsl.worlds.kind import Spec, Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.world import World

FEW_STARTS, FEW_SEEDS, FEW_STEPS = 60, 2, 5  # of a preview
RESCORED = 2  # scripts of a preview that are scored again in doubles

_planning = threading.Lock()  # two threads shall not plan one world


@dataclass(frozen=True)
class Better:
    """A script that was found, and what the panel makes of it, if it was asked."""

    script: Script
    judgement: Judgement | None = None
    finished: bool = True


def read(text: str, path: str, folder: Path) -> Story:
    """The checked story. Raises StoryError."""
    return story_from(Source(path, text), folder)


def world_of(story: Story, watch: Watch) -> World:
    """Its world, planned if it was not. Raises StoryError."""
    with _planning:
        return story.world(watch)


def preview(story: Story, seed: int, watch: Watch) -> Better:
    """What a short look finds. Raises StoryError."""
    plan = story.typed.search
    few = replace(
        plan,
        starts=min(plan.starts, FEW_STARTS),
        polish=0,
        seeds=min(plan.seeds, FEW_SEEDS),
        steps=min(plan.steps, FEW_STEPS),
    )
    brief = replace(story, typed=replace(story.typed, search=few))
    task, search = brief.task(watch), search_of(story.typed)
    found = search.solve(task, seed, 1)
    best, *_ = ranked(task, Found(found.paths[:RESCORED], found.finished), seed)
    return Better(best)


def looks_again(story: Story) -> bool:
    """Whether `refined` looks for another film than `preview`: where bodies move it does not."""
    return search_of(story.typed).takes_effort


def refined(story: Story, seed: int, watch: Watch) -> Better:
    """What one look at all first pictures finds, of a story that is searched by a beam."""
    typed = story.typed
    once = [
        replace(each, search=replace(each.search, polish=0)) for each in (*typed.lengths, typed)
    ]
    brief = replace(story, typed=replace(once[-1], lengths=tuple(once[:-1])))
    return _better(brief.solve(seed, 1, watch=watch, choose="score"), None)


def best(story: Story, seed: int, effort: int, watch: Watch) -> Better:
    """What `i2p run` finds."""
    found = story.solve(seed, 1, watch=watch, effort=effort)
    return _better(found, found.judgements[0])


def ready_for_pins(story: Story, watch: Watch) -> None:
    """Compiles what the first pin needs, so that whoever drags somebody need not wait for it.

    Not where bodies move: there each frame that is pinned has a program of its own.
    """
    can = abilities(story)["drag"]
    if story.typed.pins or not can or not story.typed.vocabulary.enumerable:
        return
    said = where(can[0], drawing_for(story.spec).spots(story.spec)[0].place)
    pinned = StoryText(story.typed.source.text).with_statements([f"pin script[1]: {said}"], PINS)
    preview(read(pinned.text, story.typed.source.name, story.folder or Path()), 0, watch)


def planned(spec: Spec, watch: Watch) -> dict[str, Any] | None:
    """Plans a world, if it is planned; what there is to say of it."""
    try:
        with _planning:
            return kind_of(spec).plan(spec, watch).document
    except StoryError as problem:
        if problem.diagnostics[0].code == "no-plan":
            return None
        raise


def _better(found: Result, judgement: Judgement | None) -> Better:
    return Better(found.script, judgement, found.finished)
