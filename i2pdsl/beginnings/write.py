"""A story to begin with, as a text with comments for people. No JAX."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from pathlib import Path

from i2pdsl.beginnings.roles import kind_called, roles_of
from i2pdsl.beginnings.table import BEGINNINGS, KINDS, Beginning, holes_of
from i2pdsl.errors import Source, StoryError, closest, error, shorten, whole_file
from i2pdsl.language.builtins import RESERVED
from i2pdsl.language.check import check_source
from i2pdsl.language.story import TypedStory
from i2pdsl.language.vocabulary import Settings, Vocabulary
from i2pdsl.library.description import PatternLibrary
from i2pdsl.library.fits import example_call, uses_of
from i2pdsl.worlds.find import vocabulary_of
from i2pdsl.worlds.kind import Spec

_START = "start "
_WIDTH = 96  # characters of a line of a comment
_ABOUT = (
    "Lines that begin with # are for people. Change what you like: `i2p check` says what is wrong, "
    "`i2p run` makes the film, `i2p repl` answers questions about it."
)
# What may be added, with the comment before it, and the holes of the table. A statement stands
# behind a #, until somebody takes that away.
_MORE = {
    "map": (
        ("what must be seen", "require eventually [touching({helper}, {helped})]"),
        ("the first picture: the two begin apart", "start distance({helper}, {helped}) > 2"),
        ("it costs more that nothing moves (0.2 without this line)", "liveliness 0.5"),
        ("viewers who forget", "audience bayesian(forgetting = 0.05)"),
    ),
    "plane": (
        ("the first picture", "start at({helped}, {other})"),
        ("viewers who forget", "audience bayesian(forgetting = 0.05)"),
    ),
    "hill": (("viewers who look less closely", "audience bayesian(sigma = 2)"),),
}


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
        return roles_of(self.spec, self.words)

    @property
    def kind(self) -> str:
        return kind_called(self.spec)

    @property
    def reference(self) -> str:
        """The name as it stands behind `world`."""
        is_word = self.name.isidentifier() and self.name not in RESERVED
        return self.name if is_word else f'"{self.name}"'


def template(kind: str) -> str:
    """The text of a world to begin with."""
    return (files("i2pdsl.beginnings") / f"{kind}.world").read_text(encoding="utf-8")


def folded(name: str) -> str:
    """A name as the table has it."""
    return name.strip().lower().replace("_", "-")


def beginnings_in(place: Place) -> list[Beginning]:
    """The beginnings of the table that a world can give all parts to."""
    return [b for b in BEGINNINGS[place.kind] if b.holes <= place.roles.keys()]


def named(name: str, kind: str | None) -> Beginning | None:
    """A beginning of the table by its name, else by that of its pattern; of any kind if that is
    not said."""
    among = [b for k in ([kind] if kind else KINDS) for b in BEGINNINGS[k]]
    by_name = {b.name: b for b in reversed(among)}
    by_pattern = {folded(b.pattern): b for b in reversed(among)}
    return by_name.get(folded(name)) or by_pattern.get(folded(name))


def kind_of_beginning(beginning: Beginning) -> str:
    return next(kind for kind in KINDS if beginning in BEGINNINGS[kind])


def beginning_in(name: str, place: Place, standard: Callable[[], PatternLibrary]) -> Beginning:
    """What `--pattern` means in a world: a beginning of the table, or a call of one of the
    `standard` patterns, which are opened only where they are needed.

    Raises StoryError where there is no such thing, or the world cannot have it.
    """
    fitting = beginnings_in(place)
    found = named(name, place.kind)
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
            known = {b.name for kind in KINDS for b in BEGINNINGS[kind]}
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
        for about, line in _MORE[place.kind]
        if holes_of(line) <= roles.keys() and is_right(line.format(**roles))
    ]
    if any(line.startswith(_START) for _, line in kept):
        more = [(about, line) for about, line in more if not line.startswith(_START)]
    return "\n\n".join([
        f"{comment(f'{told[0].upper()}{told[1:]}.')}\n#\n{comment(_ABOUT)}",
        f"{comment(f'Where it happens. `i2p worlds {place.name}` tells all about it.')}\n{world}",
        f"{comment('How long it is, in frames.')}\n{frames}",
        *(f"{comment(about)}\n{line}" for about, line in kept),
        comment("More to try: take away the first # of a line.") + "\n"
        + "\n".join(f"# {line}  # {about}" for about, line in more),
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
