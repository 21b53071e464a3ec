"""What commands are given: stories, scripts and worlds, by name or path."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from i2pdsl.errors import Diagnostic, StoryError, error, whole_file
from i2pdsl.output import DONE, INTERRUPTED, show

if TYPE_CHECKING:
    from i2pdsl.stories import Script, Story


def load_stories(paths: tuple[str, ...], settings: tuple[tuple[str, str], ...]) -> list[Story]:
    """The checked stories. Raises StoryError with the mistakes of all of them."""
    loaded: list[Story] = []
    problems: list[Diagnostic] = []
    for path in dict.fromkeys(paths):
        try:
            loaded.append(load_story(path, settings))
        except StoryError as problem:
            problems.extend(problem.diagnostics)
    if problems:
        raise StoryError(problems)
    return loaded


def load_story(path: str, settings: tuple[tuple[str, str], ...] = ()) -> Story:
    """A checked story, with `--set` applied."""
    from i2pdsl.language.statements import read_source
    from i2pdsl.stories import story_from
    from i2pdsl.worlds.record import is_script

    source, folder = read_source(path), Path(path).parent
    if is_script(source):
        hint = "`i2p render` draws it, `i2p query` asks about it"
        message = "this is a finished script, not a story"
        raise error("not-a-story", message, whole_file(path), hint)
    return story_from(source, folder, settings)


def script_or_story(path: str, seed: int) -> tuple[Script, int]:
    """A script file, or the script of a story that is solved now; and the exit status.

    Raises KeyboardInterrupt if it is interrupted before a script was found.
    """
    from i2pdsl.language.statements import read_source
    from i2pdsl.progress import Bars
    from i2pdsl.stories import Script
    from i2pdsl.worlds.record import is_script

    with Bars() as bars:
        if not path.endswith(".story") and is_script(read_source(path)):
            script = Script.load(path, bars.watch)
            show(script.warnings)
            return script, DONE
        story = load_story(path)
        show(story.warnings)
        found = story.solve(seed, watch=bars.watch)
    if not found.finished:
        click.echo("interrupted: the best of what was searched so far is used", err=True)
    return found.script, DONE if found.finished else INTERRUPTED


def spec_of(name: str) -> Any:
    """A world by name or path. Raises StoryError."""
    from i2pdsl.errors import did_you_mean
    from i2pdsl.language.check import known_worlds
    from i2pdsl.worlds.find import find_spec

    spec = find_spec(name, Path())
    if spec is None:
        hint = did_you_mean(Path(name).stem, known_worlds(Path(name).parent))
        raise error("no-world", f"there is no world `{name}`", whole_file(name), hint)
    return spec
