"""What a script's file says of its world and its story, understood."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from i2pdsl.errors import (
    Diagnostic,
    Source,
    StoryError,
    did_you_mean,
    error,
    shorten,
    whole_file,
)
from i2pdsl.language import typed as ty
from i2pdsl.language.check import TypedStory, check_source, default_assumption
from i2pdsl.language.scope import Module
from i2pdsl.language.story import Audience, usual_audience
from i2pdsl.untrusted import is_plain_name, plain_name
from i2pdsl.worlds.drawings import within
from i2pdsl.worlds.find import find_spec, vocabulary_of
from i2pdsl.worlds.kind import Spec
from i2pdsl.worlds.kinds import kind_of, parse_world
from i2pdsl.worlds.ready import viewers_of
from i2pdsl.worlds.record import Record, Trajectory
from i2pdsl.worlds.world import Viewer, World


@dataclass(frozen=True)
class Stored:
    """The world and the story of a script, which many scripts may share.

    Attributes:
        spec: the world with the script's settings.
        story: None where there is none, or where it is not understood.
        warnings: of a story that is not understood.
    """

    spec: Spec
    story: TypedStory | None
    warnings: tuple[Diagnostic, ...] = ()

    @property
    def viewers(self) -> tuple[Viewer, ...]:
        """The observers of the story's audiences."""
        return viewers_of(self.spec, self.story.observers) if self.story else (Viewer(self.spec),)

    @property
    def module(self) -> Module:
        """The names that questions may use."""
        return self.story.module if self.story else Module(Source("script", ""))

    @property
    def assumption(self) -> ty.Mask:
        """What beliefs are conditioned on."""
        return self.story.assumption if self.story else default_assumption(vocabulary_of(self.spec))

    @property
    def audiences(self) -> tuple[Audience, ...]:
        return self.story.audiences if self.story else (usual_audience(vocabulary_of(self.spec)),)

    @cached_property
    def rules(self) -> World:
        """A world that knows what can happen, not what anyone expects."""
        return kind_of(self.spec).rules(self.spec)

    def read(self, record: Record) -> Trajectory:
        """A script in the world's numbers, held against its rules. Raises StoryError."""
        return kind_of(self.spec).read(self.rules, record)

    def of_length(self, length: int) -> Stored:
        """The same where the search has chosen so many frames."""
        return replace(self, story=self.story.of_length(length)) if self.story else self


def stored(record: Record, folder: Path | None) -> Stored:
    """What a record says of its world and its story. Raises StoryError where its world is wrong."""
    spec = _stored_world(record, folder)
    return Stored(spec, *_stored_story(record, spec, folder))


def _stored_world(record: Record, folder: Path | None) -> Spec:
    """The world of a script, with its settings. Raises StoryError."""
    name, text = record.world["name"], record.world["source"]
    where = whole_file(record.where)
    spec: Spec | None = None
    if text:
        known_as = plain_name(name)
        spec = parse_world(
            Source(f"{known_as}.world", text), known_as, within(record.world.get("drawings", {}))
        )
    elif is_plain_name(name):
        spec = find_spec(name, folder)
    if spec is None:
        raise error("no-world", f"there is no world `{shorten(name)}`", where)
    known = vocabulary_of(spec).settings
    settings: dict[str, Any] = {}
    for key, value in record.world["settings"].items():
        if key not in known:
            message = f"world {spec.name} has no setting `{shorten(key)}`"
            raise error("script", message, where, did_you_mean(key, known))
        if not known[key].holds(value):
            message = f"the setting `{key}` cannot be {shorten(json.dumps(value))}"
            raise error("script", message, where, f"it can be: {known[key].possible}")
        settings[key] = _plain(value)
    return spec.with_settings(settings)


def _plain(value: Any) -> Any:
    """A setting as stories have it: floats for numbers, so that equal worlds are equal."""
    if isinstance(value, list):
        return tuple(float(x) for x in value)
    return value if isinstance(value, str) else float(value)


def _stored_story(
    record: Record, spec: Spec, folder: Path | None
) -> tuple[TypedStory | None, tuple[Diagnostic, ...]]:
    """The story that a script was made from, if its text is there and understood.

    It is read against the script's own world, whatever has become of the .world file since. What
    is said of the story is never an error: it informs. But whoever asks about the script misses
    its names, its assumption and its audience, so a text that is not understood is warned about.
    """
    text, file = record.text, record.story.get("file")
    if not text.strip():
        return None, ()
    name = file if isinstance(file, str) and file else "story"
    try:
        place = Path(name).parent if Path(name).is_file() else folder
    except (OSError, ValueError):  # a name that no file can have
        place = folder
    vocabulary = vocabulary_of(spec)
    try:
        checked = check_source(Source(name, text), lambda *_: vocabulary, place)
    except StoryError as problem:
        reason = problem.diagnostics[0].message
    else:
        if isinstance(checked, TypedStory):
            return checked, ()
        reason = "it is a library"
    message = f"the story stored in the script is not understood: {reason}"
    hint = "its names, its assumption and its audience are not used"
    where = whole_file(record.where)
    return None, (Diagnostic("stored-story", message, where, hint, severity="warning"),)
