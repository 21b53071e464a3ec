"""Scripts as data: the JSON document (interfaces.md, "Script file"), and a world's own numbers."""

from __future__ import annotations

import json
import math
import sys
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from i2pdsl.errors import Source, Span, error, shorten, whole_file
from i2pdsl.language.methods import LONGEST_STORY
from i2pdsl.language.naming import same_name
from i2pdsl.language.statements import LONGEST_FILE, read_source
from i2pdsl.resources import write_text
from i2pdsl.untrusted import RepeatedKeyError, json_excess, without_repetition
from i2pdsl.worlds.world import World

FORMAT, VERSION = "i2p-script", 1
ERROR = {"trust": dict, "particles": list}
_LONGEST_ERROR = 10_000  # characters
_DEEPEST = 60  # brackets in brackets; the format has 5, and a story may say more of itself
_LONGEST_TITLE = 300  # characters


@dataclass(frozen=True)
class Record:
    """A script file as data: what interfaces.md describes, read but not yet held against a world.

    Attributes:
        story: name, file, source and seed; informs and is never checked.
        world: name, source (or None for the built-in world) and settings; `drawings`, by their
            names, where the world has own sprites.
        start: the initial state, as in the file.
        frames: as in the file.
        where: the file's name, for messages.
        error: what was known of the error of its world and its viewers (`trust`, `particles`),
            where these are approximate; it informs, and is never believed.
    """

    story: dict[str, Any]
    world: dict[str, Any]
    score: float | None
    start: dict[str, Any]
    frames: tuple[dict[str, Any], ...]
    where: str = field(default="script", compare=False)
    error: dict[str, Any] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """What the story is called, for pictures; empty where it has no name."""
        name = self.story.get("name")
        return str(name)[:_LONGEST_TITLE] if isinstance(name, str | int | float) else ""

    @property
    def text(self) -> str:
        """The story's source, if it is there and of a length that stories can have."""
        text = self.story.get("source")
        return text if isinstance(text, str) and len(text) <= LONGEST_FILE else ""

    def as_json(self) -> dict[str, Any]:
        """The JSON document. JSON has no infinity: such a score is null."""
        return {
            "format": FORMAT,
            "version": VERSION,
            "story": self.story,
            "world": self.world,
            "score": self.score if self.score is None or math.isfinite(self.score) else None,
            **self.error,
            "start": self.start,
            "frames": list(self.frames),
        }

    def save(self, path: Path | str) -> Path:
        """Writes the script as JSON, atomically."""
        path = Path(path)
        text = _lines(self.as_json(), ascii_only=False)
        try:
            text.encode()
        except UnicodeEncodeError:  # of a file name that is not UTF-8
            text = _lines(self.as_json(), ascii_only=True)
        write_text(path, text + "\n")
        return path


def _lines(document: dict[str, Any], ascii_only: bool) -> str:
    """The document with one line for each frame: easy to read, and a third of the size."""
    show = lambda value: json.dumps(value, ensure_ascii=ascii_only)
    parts = []
    for key, value in document.items():
        if key == "frames":
            frames = ",\n  ".join(show(frame) for frame in value)
            parts.append(f' "frames": [\n  {frames}\n ]')
        else:
            parts.append(f" {show(key)}: {show(value)}")
    return "{\n" + ",\n".join(parts) + "\n}"


@dataclass(frozen=True)
class Trajectory:
    """A script in a world's own numbers.

    Attributes:
        actions: [T], or [T, n] where they are vectors.
        states: [T + 1] or [T + 1, n], the start included.
    """

    actions: np.ndarray
    states: np.ndarray

    @property
    def start(self) -> Any:
        """The initial state."""
        return self.states[0]


@dataclass(frozen=True)
class Kept:
    """Frames of a script that another shall have too, where actions have no names: from 1 on."""

    frames: tuple[int, ...]
    path: Trajectory

    @property
    def runs(self) -> list[tuple[int, int]]:
        """The first and last frame of each stretch of neighbours."""
        return runs_of(self.frames)


def runs_of(frames: Sequence[int]) -> list[tuple[int, int]]:
    """The first and last number of each stretch of neighbours."""
    found: list[tuple[int, int]] = []
    for frame in sorted(set(frames)):
        if found and found[-1][1] == frame - 1:
            found[-1] = (found[-1][0], frame)
        else:
            found.append((frame, frame))
    return found


def extended(world: World, path: Trajectory, actions: Sequence[int] | np.ndarray) -> Trajectory:
    """A path with more actions [k, ...] and the states that they lead to."""
    states = [np.asarray(path.states[-1])]
    for action in actions:
        after = world.transition(world.tables, states[-1], np.asarray(action))
        states.append(np.asarray(after))
    more = np.array(states[1:], dtype=path.states.dtype).reshape(-1, *path.states.shape[1:])
    acts = np.asarray(actions, dtype=path.actions.dtype).reshape(-1, *path.actions.shape[1:])
    return Trajectory(np.concatenate([path.actions, acts]), np.concatenate([path.states, more]))


def followed(world: World, starts: np.ndarray, actions: np.ndarray) -> list[Trajectory]:
    """Scripts from their starts [N] and actions [N, T], all at once."""
    states = [np.asarray(starts)]
    for action in actions.T:
        states.append(np.asarray(world.transition(world.tables, states[-1], action)))
    every = np.stack(states, axis=1).astype(states[0].dtype)
    return [Trajectory(a, s) for a, s in zip(actions.astype(every.dtype), every, strict=True)]


def empty(world: World, start: Any) -> Trajectory:
    """A script of no frames."""
    start = np.asarray(start)
    return Trajectory(np.zeros((0, *world.action_shape), start.dtype), start[None])


def is_script(source: Source) -> bool:
    """Whether a text is meant as a script: JSON, or in a file of that name."""
    return source.name.endswith(".json") or source.text.lstrip().startswith("{")


def read_record(path: Path | str) -> Record:
    """Reads a script file. Raises StoryError for anything that is not one."""
    source = read_source(path)
    return parse_record(source)


def _same_names(value: Any) -> Any:
    """Plain data with every name and word in the one form that the language gives them."""
    if isinstance(value, dict):
        return {same_name(key): _same_names(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_same_names(item) for item in value]
    return same_name(value) if isinstance(value, str) else value


def parse_record(source: Source) -> Record:
    """Reads the text of a script file."""
    excess = json_excess(source.text, _DEEPEST)
    if excess:
        raise error("script", f"this JSON is {excess}", Span(source, 0, 0))
    try:
        document = json.loads(source.text, object_pairs_hook=without_repetition)
    except json.JSONDecodeError as problem:
        span = Span(source, problem.pos, problem.pos + 1)
        raise error("script", f"this is no JSON: {problem.msg}", span) from None
    except RepeatedKeyError as problem:
        message = f"an object of this JSON has `{shorten(str(problem))}` twice"
        raise error("script", message, Span(source, 0, 0)) from None
    except ValueError:  # Python reads no integers of more than 4300 digits
        message = "this JSON has a number that is too long"
        raise error("script", message, Span(source, 0, 0)) from None
    whole = whole_file(source.name)

    def wrong(message: str, hint: str | None = None) -> NoReturn:
        raise error("script", message, whole, hint)

    if not isinstance(document, dict) or document.get("format") != FORMAT:
        wrong("this is no i2p script", f'a script begins with {{"format": "{FORMAT}", ...}}')
    version = document.get("version")
    if version != VERSION or isinstance(version, bool):
        shown = shorten(json.dumps(version))
        wrong(f"scripts of version {shown} cannot be read; version {VERSION} can")
    world = document.get("world")
    if not isinstance(world, dict) or not isinstance(world.get("name"), str):
        wrong("the script names no world", '"world": {"name": "kitchen"}')
    text, settings = world.get("source"), world.get("settings")
    if text is not None and not isinstance(text, str):
        wrong('"source" of the world must be the text of a .world file', "leave it out, or null")
    if settings is not None and not isinstance(settings, dict):
        wrong('"settings" of the world must be an object', '"settings": {"beta": 1.0}')
    drawings = world.get("drawings", {})
    if not isinstance(drawings, dict) or not all(isinstance(d, str) for d in drawings.values()):
        wrong('"drawings" of the world must hold texts by the names of sprites')
    start, frames = document.get("start"), document.get("frames")
    if not unicodedata.is_normalized("NFC", source.text):
        start, frames = _same_names(start), _same_names(frames)
    if not isinstance(start, dict):
        wrong('the script has no "start"', '"start": {"cheese": [3, 1], ...}')
    if not isinstance(frames, list):
        wrong('"frames" must be a list of objects')
    if len(frames) > LONGEST_STORY:
        wrong(f"the script has {len(frames):,} frames; at most {LONGEST_STORY:,} are read")
    for number, frame in enumerate(frames, 1):
        if not isinstance(frame, dict):
            wrong(f"frame {number}: a frame is an object, not {shorten(json.dumps(frame))}")
    if not frames:
        wrong("the script has no frames")
    story = document.get("story")
    score = document.get("score")
    if not isinstance(score, int | float) or not abs(score) <= sys.float_info.max:
        score = None
    return Record(
        story if isinstance(story, dict) else {},
        {"name": world["name"], "source": text or None, "settings": settings or {}}
        | ({"drawings": drawings} if drawings else {}),
        None if score is None else float(score),
        start,
        tuple(frames),
        source.name,
        {key: document[key] for key, kind in ERROR.items() if _is_told(document.get(key), kind)},
    )


def _is_told(value: Any, kind: type) -> bool:
    """Whether something is what we may have written of an error: short, its numbers finite."""
    try:
        told = json.dumps(value, allow_nan=False)
    except ValueError:
        return False
    return isinstance(value, kind) and len(told) <= _LONGEST_ERROR
