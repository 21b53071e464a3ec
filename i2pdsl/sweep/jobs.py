"""The jobs of a sweep: stories x settings x seeds, each with a place for its result."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any

from i2pdsl import __version__
from i2pdsl.errors import Diagnostic, Source, StoryError, error, whole_file
from i2pdsl.language.statements import LARGEST_TEXT, read_source, split_outside
from i2pdsl.results import Choice
from i2pdsl.stories import Story, story_from
from i2pdsl.untrusted import plain_name, read_bytes

Setting = tuple[str, str]


@dataclass(frozen=True)
class Manner:
    """How each story is solved (stories.Story.solve)."""

    candidates: int = 1
    naive: bool = False
    choose: Choice = "panel"
    effort: int = 1


@dataclass(frozen=True)
class Job:
    """One story with one choice of settings and one seed.

    Attributes:
        story: its name, and `path` its file, for messages and imports.
        text: what is solved, with the settings in it.
        place: the folder of its result, below that of the sweep.
        key: of all that the result depends on: a result of another key is none of this job.
        planning: of what is planned for it; jobs may share it.
    """

    story: str
    path: str
    text: str
    settings: tuple[Setting, ...]
    seed: int
    manner: Manner
    place: str
    key: str
    planning: str

    def load(self) -> Story:
        """The story. Raises StoryError."""
        return story_from(Source(self.path, self.text), Path(self.path).parent)


def choices_of(settings: Sequence[Setting]) -> list[tuple[Setting, ...]]:
    """All combinations of `NAME=V1,V2` (commas in brackets separate nothing)."""
    each: dict[str, list[Setting]] = {}
    for name, values in settings:
        given = each.setdefault(name, [])
        given += [(name, value.strip()) for value in split_outside(values, ",") if value.strip()]
    return list(product(*(dict.fromkeys(values) for values in each.values())))


def list_jobs(
    paths: Sequence[str], settings: Sequence[Setting], seeds: Sequence[int], manner: Manner
) -> list[Job]:
    """All jobs, in the order of stories, settings, seeds. Raises StoryError with the mistakes of
    all stories."""
    jobs: list[Job] = []
    problems: list[Diagnostic] = []
    for path in dict.fromkeys(paths):
        for chosen in choices_of(settings):
            try:
                story = story_from(read_source(path), Path(path).parent, chosen)
                jobs += jobs_of_story(story, chosen, seeds, manner)
            except StoryError as problem:
                problems += problem.diagnostics
    if problems:
        raise StoryError(list(dict.fromkeys(problems)))
    taken: dict[str, str] = {}
    for job in jobs:
        if taken.setdefault(job.place, job.path) != job.path:
            message = f"its results would go where those of {taken[job.place]} go"
            raise error("sweep", message, whole_file(job.path), "give one of them another name")
    return jobs


def jobs_of_story(
    story: Story, settings: tuple[Setting, ...], seeds: Sequence[int], manner: Manner
) -> list[Job]:
    """The jobs of one story, with `settings` in it already."""
    told = story.typed
    name = plain_name(told.name)
    chosen = ",".join(f"{key}={''.join(value.split())}" for key, value in settings)
    folder = f"{name}/{plain_name(chosen)}" if chosen else name
    # What imports, patterns and the world's file come to is in the checked story.
    meaning = [(each.objective, each.requirements, each.pins) for each in (told, *told.lengths)]
    kept = [_content(each.path(story.folder)) for each in told.kept]
    told_by = (told.source.text, story.spec, meaning, told.audiences)
    content = (*told_by, *([kept] if kept else []), asdict(manner), __version__)
    planning = digest(story.spec, [viewer.spec for viewer in story.viewers])
    return [
        Job(
            told.name,
            told.source.name,
            told.source.text,
            settings,
            seed,
            manner,
            f"{folder}/seed-{seed}",
            digest(content, seed),
            planning,
        )
        for seed in seeds
    ]


def _content(path: Path) -> bytes | None:
    """What is in a script whose frames a story keeps; None where it cannot be read."""
    try:
        return read_bytes(path, LARGEST_TEXT)
    except OSError:
        return None


def digest(*content: Any) -> str:
    """A name for plain data; the same in every process."""
    return hashlib.sha256(repr(content).encode("utf-8", "surrogatepass")).hexdigest()[:24]


def shard(jobs: Sequence[Job], number: int, count: int) -> list[Job]:
    """Part `number` of `count`, from 1 on: every count-th job, so that parts take about as long."""
    return list(jobs[number - 1 :: count])
