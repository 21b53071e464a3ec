"""A story to begin with, as a text with comments for people. No JAX."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.resources.abc import Traversable
from pathlib import Path

from i2pdsl.beginnings.table import table
from i2pdsl.errors import Source, StoryError, closest, error, shorten, whole_file
from i2pdsl.language.builtins import RESERVED
from i2pdsl.language.check import check_source
from i2pdsl.language.story import TypedStory
from i2pdsl.language.vocabulary import Settings, Vocabulary
from i2pdsl.library.description import PatternLibrary
from i2pdsl.library.fits import example_call, uses_of
from i2pdsl.worlds.beginnings import Beginning, Beginnings, holes_of
from i2pdsl.worlds.find import vocabulary_of
from i2pdsl.worlds.kind import Spec
from i2pdsl.worlds.kinds import beginnings_of, kind_of, parse_world

_START = "start "
_WIDTH = 96  # characters of a line of a comment
_ABOUT = (
    "Lines that begin with # are for people. Change what you like: `i2p check` says what is wrong, "
    "`i2p run` makes the film, `i2p repl` answers questions about it."
)


@dataclass(frozen=True)
class Place:
    """The world of a new story: what it is called there, and what it is."""

    name: str
    spec: Spec

    @cached_property
    def words(self) -> Vocabulary:
        return vocabulary_of(self.spec)

    @cached_property
    def roles(self) -> dict[str, str]:
        return kind_of(self.spec).roles(self.spec, self.words)

    @cached_property
    def beginnings(self) -> Beginnings:
        return beginnings_of(self.spec)

    @property
    def reference(self) -> str:
        """The name as it stands behind `world`."""
        is_word = self.name.isidentifier() and self.name not in RESERVED
        return self.name if is_word else f'"{self.name}"'


def new_world(template: Traversable, name: str) -> tuple[Place, str]:
    """A world of one's own to begin in, called so, and the text of its file."""
    text = template.read_text(encoding="utf-8")
    return Place(name, parse_world(Source(f"{name}.world", text), name)), text


def folded(name: str) -> str:
    """A name as the table has it."""
    return name.strip().lower().replace("_", "-")


def beginnings_in(place: Place) -> list[Beginning]:
    """The beginnings of the table that a world can give all parts to."""
    return [b for b in place.beginnings.ways if b.holes <= place.roles.keys()]


def named(name: str, kind: str | None) -> Beginning | None:
    """A beginning of the table by its name, else by that of its pattern; of any kind if that is
    not said."""
    known = table()
    return _named(name, [b for k in ([kind] if kind else known) for b in known[k].ways])


def _named(name: str, among: Sequence[Beginning]) -> Beginning | None:
    by_name = {b.name: b for b in reversed(among)}
    by_pattern = {folded(b.pattern): b for b in reversed(among)}
    return by_name.get(folded(name)) or by_pattern.get(folded(name))


def kind_of_beginning(beginning: Beginning) -> str:
    """As animators call it."""
    return next(called for called, each in table().items() if beginning in each.ways)


def beginning_in(
    name: str | None, place: Place, standard: Callable[[], PatternLibrary]
) -> Beginning:
    """What `--pattern` means in a world: a beginning of the table, or a call of one of the
    `standard` patterns, which are opened only where they are needed; without a name the first of
    the table that fits.

    Raises StoryError where there is no such thing, or the world cannot have it.
    """
    fitting = beginnings_in(place)
    if name is None:
        if not fitting:
            message = f"no way to begin of the list can be told in {place.name}"
            hint = "take a standard pattern: --pattern NAME; `i2p patterns` lists them"
            raise error("no-pattern", message, whole_file(f"--world {place.name}"), hint)
        return fitting[0]
    found = _named(name, place.beginnings.ways)
    if found in fitting:
        return found
    called = shorten(folded(name))
    message = f"`{called}` cannot be told in {place.name}"
    elsewhere = found or named(name, None)
    if found is not None:
        lacks = "helper" in found.holes and "helper" not in place.roles
        what = "has an attitude toward another" if lacks else "chooses between two places"
        message += f": nobody there {what}"
    else:
        library = standard()
        pattern = next((p for p in library.records if folded(p["name"]) == folded(name)), None)
        if pattern is not None:
            call = example_call(pattern, library.exports, place.words)
            if call is not None:
                return _called(pattern, call, place.words.usual_length)
        elif elsewhere is not None:
            message += f": it is for worlds of the kind {kind_of_beginning(elsewhere)}"
        else:
            known = {b.name for each in table().values() for b in each.ways}
            near = closest(folded(name), known | {folded(p["name"]) for p in library.records})
            hint = f"did you mean `{near}`?" if near else "`i2p new --list` tells what there is"
            message = f"there is no way to begin called `{called}`"
            raise error("no-pattern", message, whole_file(f"--pattern {called}"), hint)
    there = ", ".join(b.name for b in fitting) or "none of the list"
    where = whole_file(f"--pattern {called}")
    raise error("no-pattern", message, where, f"what can be told there: {there}")


def _called(pattern: dict[str, str], call: str, length: int) -> Beginning:
    """A beginning with a pattern for which the table has none."""
    told = pattern["documentation"].split(".")[0].split(":")[-1]
    use = uses_of(pattern["result"])[0].format(call).replace("{", "{{").replace("}", "}}")
    about = f"What its parts mean, `i2p patterns` tells of `{pattern['name']}`."
    told = " ".join(told.split()).replace("{", "").replace("}", "")
    return Beginning(pattern["name"], told, pattern["name"], length, ((about, f"maximize {use}"),))


def story_text(title: str, beginning: Beginning, place: Place, length: int | None = None) -> str:
    """The story, checked in its world. A first picture that the world cannot have is left out.

    Raises StoryError where the world cannot have the rest.
    """
    roles = place.roles
    lines = [(about.format(**roles), line.format(**roles)) for about, line in beginning.lines]
    told = beginning.told.format(**roles)
    world = f"world {place.reference}{beginning.settings.format(**roles)}"
    frames = f"length {length or beginning.length}"
    asked = [line for _, line in lines if not line.startswith(_START)]
    bare = "\n".join([world, frames, *asked])
    words = check(title, bare, place)

    def is_right(line: str) -> bool:
        try:
            check(title, f"{bare}\n{line}", place)
        except StoryError:
            return False
        return True

    kept = [(about, line) for about, line in lines if line in asked or is_right(line)]
    more = [
        (about, line.format(**roles))
        for about, line in place.beginnings.more
        if holes_of(line) <= roles.keys() and is_right(line.format(**roles))
    ]
    if any(line.startswith(_START) for _, line in kept):
        more = [(about, line) for about, line in more if not line.startswith(_START)]
    return "\n\n".join([
        f"{comment(f'{told[0].upper()}{told[1:]}.')}\n#\n{comment(_ABOUT)}",
        f"{comment(f'Where it happens. `i2p worlds {place.name}` tells all about it.')}\n{world}",
        f"{comment('How long it is, in frames.')}\n{frames}",
        *(f"{comment(about)}\n{line}" for about, line in kept),
        *([comment("More to try: take away the first # of a line.") + "\n"
           + "\n".join(f"# {line}  # {about}" for about, line in more)] if more else []),
        comment("What viewers wonder about here, and so what you can ask for:") + "\n"
        + "\n".join(_about_latents(words)),
    ]) + "\n"  # fmt: skip


def _about_latents(words: Vocabulary) -> list[str]:
    told = []
    for latent in words.latents.values():
        values = "" if latent.kind == "truth" else f" ({latent.domain})"
        about = f"{latent.name}: {latent.documentation}{values}"
        told.append(
            textwrap.fill(about, _WIDTH, initial_indent="#   ", subsequent_indent="#       ")
        )
    return told


def comment(text: str) -> str:
    """Lines that begin with #."""
    lines = textwrap.wrap(text, _WIDTH, break_long_words=False, break_on_hyphens=False)
    return "\n".join(f"# {line}" for line in lines)


def check(title: str, text: str, place: Place) -> Vocabulary:
    """What viewers wonder about in a story of this world, with the settings that it has there.

    Raises StoryError with what is wrong with it, wherever that lies.
    """

    def words(name: str, folder: Path | None = None, settings: Settings = ()) -> Vocabulary:
        if not settings:
            return place.words
        return vocabulary_of(place.spec.with_settings(dict(settings)))

    checked = check_source(Source(title, text), words)
    assert isinstance(checked, TypedStory)
    return checked.vocabulary
