"""The whole flow: text -> typed story -> world -> objective -> search -> scripts.

A stage is a function of what the one before it made. `Story` (stories.py) is the flow as users hold
it, and scripts answer questions (scripts.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from i2pdsl.errors import Source, StoryError, error, whole_file
from i2pdsl.keeping import kept_of
from i2pdsl.language import ast
from i2pdsl.language.check import Library, TypedStory, check_source
from i2pdsl.language.methods import usual_method
from i2pdsl.language.override import override
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.results import Choice, Result, chosen, chosen_of_lengths
from i2pdsl.search.searches import search_of
from i2pdsl.search.task import Task
from i2pdsl.worlds.find import find_spec, find_vocabulary
from i2pdsl.worlds.kind import Spec, Watch
from i2pdsl.worlds.ready import ready_world
from i2pdsl.worlds.record import Kept
from i2pdsl.worlds.world import Viewer, World


def typed(
    source: Source, folder: Path | None, settings: Sequence[tuple[str, str]] = ()
) -> TypedStory:
    """The story that a text tells, all names resolved; what it imports is looked for in `folder`.

    `settings` are (name, value) pairs that replace values of the text (`i2p run --set`).

    Raises StoryError with every mistake of the text.
    """
    if settings:
        source = overridden(source, settings, typed(source, folder).vocabulary)
    checked = check_source(source, find_vocabulary, folder)
    if isinstance(checked, Library):
        message = "this is a library of patterns, not a story"
        hint = "a story needs `world`, `length` and `maximize`"
        raise error("library", message, whole_file(source.name), hint)
    return checked


def overridden(source: Source, settings: Iterable[tuple[str, str]], words: Vocabulary) -> Source:
    """A story's text with some of its values replaced. Raises StoryError."""
    for name, value in settings:
        source = override(source, name, value, tuple(words.settings), usual_method(words))
    return source


def described(story: TypedStory, folder: Path | None, known: Spec | None = None) -> Spec:
    """The description of a story's world with the story's settings: of `known`, or of the one of
    that name that is found."""
    spec = known or find_spec(story.world, folder)
    assert spec is not None  # or the story would not have been checked
    return spec.with_settings(dict(story.settings))


def ready(
    story: TypedStory, spec: Spec, viewers: tuple[Viewer, ...], watch: Watch | None = None
) -> World:
    """The world, planned or trained, as viewers see it.

    Raises StoryError where it is too large, or nobody has trained its controllers.
    """
    try:
        return ready_world(spec, viewers, watch)
    except StoryError as problem:
        raise story.placed(problem, ast.World) from None


def task(
    story: TypedStory,
    spec: Spec,
    viewers: tuple[Viewer, ...],
    folder: Path | None,
    kept: Kept | None,
    watch: Watch,
    effort: int,
) -> Task:
    """The story in its world, to be searched: with its objective and the frames that it keeps."""
    kept = kept_of(story.kept, spec, folder, kept, watch)
    return Task(story, ready(story, spec, viewers, watch), watch, effort, kept=kept)


def solved(task: Task, seed: int, candidates: int, choose: Choice, naive: bool = False) -> Result:
    """The scripts that the story's search finds, best first; see `Story.solve`.

    Raises StoryError where no state fulfils the `start`, and where more effort is asked of a search
    that is no beam.
    """
    story, search = task.story, search_of(task.story, naive)
    if task.effort > 1 and not search.takes_effort:
        message = "more effort is for beam searches"
        hint = None if naive else "a descent takes more `seeds` or `steps` in the story"
        problem = error("search", message, whole_file(story.source.name), hint)
        raise story.placed(problem, ast.Search)
    given = (search, seed, candidates, choose)
    if story.lengths:
        tasks = [replace(task, story=each) for each in story.lengths]
        scripts, judgements, finished = chosen_of_lengths(tasks, *given)
    else:
        scripts, judgements, finished = chosen(task, *given)
    return Result(tuple(scripts), tuple(judgements), finished, dict(task.watch.seconds))
