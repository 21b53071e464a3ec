"""Compiling a story's search without running it: the next story of its shape starts at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from i2pdsl.search import beam, descent
from i2pdsl.search.programs import Compiling, ReadyError, compiling_only

if TYPE_CHECKING:
    from i2pdsl.pipeline import Story
    from i2pdsl.worlds.ready import Watch


def prepare(story: Story, compiling: Compiling, watch: Watch | None = None) -> str | None:
    """Puts the program of a story's search into the cache of compiled programs.

    Everything is done that `story.solve` does, up to the first run of the compiled search: the
    world is planned, and the program that the cache then holds is the one that will be run.

    Args:
        compiling: what was compiled before, which is not compiled again; it notes what was traced.

    Returns: the shape that the story's search shares with others, or None where nothing is compiled
        (`search naive`).

    Raises StoryError as `story.solve` does.
    """
    if story.typed.search.method == "naive":
        return None
    # What this process has in memory already would be run rather than compiled.
    memories = (beam._programs, descent._programs)
    before = [dict(memory) for memory in memories]
    for memory in memories:
        memory.clear()
    try:
        with compiling_only(compiling):
            story.solve(watch=watch)
    except ReadyError:
        return compiling.shape
    finally:
        for memory, programs in zip(memories, before, strict=True):
            memory.update(programs)
    return None
