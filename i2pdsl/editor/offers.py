"""A word that can be offered, and the words of statements: worlds, libraries, settings..."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from i2pdsl.editor.slots import Place, Slot
from i2pdsl.editor.surroundings import Surroundings
from i2pdsl.errors import Source
from i2pdsl.language.check import known_worlds
from i2pdsl.language.methods import METHODS
from i2pdsl.language.packed import SUFFIX
from i2pdsl.language.settings import AUDIENCES, OF_VIEWERS, PARTICLES
from i2pdsl.language.statements import split_statements
from i2pdsl.language.story import Audience
from i2pdsl.language.vocabulary import Setting
from i2pdsl.resources import data_folder
from i2pdsl.untrusted import read_bytes

_WORDS_OF_LIBRARIES = ("let", "pattern", "import")
_LARGEST_LIBRARY = 200_000  # bytes; larger files are not looked into


@dataclass(frozen=True)
class Offer:
    """A word that may stand at a place.

    Attributes:
        kind: latent, value, character, object, place, predicate, event, action, pattern, let,
            parameter, function, constant, setting, world, library, audience, search, and for
            fixed words keyword, form, story, reduction, operator, sign, bracket.
        detail: what it is, on one line: a signature or a domain.
        after: what is usually written behind it: ` = ` for a named argument.
    """

    text: str
    kind: str
    detail: str = ""
    documentation: str = ""
    after: str = ""


def _worlds(place: Place, _: Slot) -> Iterator[Offer]:
    world = place.around.vocabulary
    for name in sorted(known_worlds(place.around.folder)):
        about = world.documentation if world is not None and world.world == name else ""
        yield Offer(name, "world", f"world {name}", about)


def _libraries(place: Place, _: Slot) -> Iterator[Offer]:
    """Those beside the file; then the standard ones, which are known without an import."""
    folder = place.around.folder or Path()
    for path in _entries(folder):
        name = path.stem if path.suffix in (".story", SUFFIX) else path.name
        if name.isidentifier() and _is_library(path, place.around):
            yield Offer(name, "library", path.name)
    for path in _entries(data_folder("stories") / "patterns"):
        if path.stem.isidentifier():
            yield Offer(path.stem, "library", "of the standard library")


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:
        return []


def _is_library(path: Path, around: Surroundings) -> bool:
    """Whether a path beside the file can be imported: it holds patterns and lets only."""
    try:
        if path.is_dir():
            files = sorted(path.glob("*.story"))[:1]
            return bool(files) and _is_library(files[0], around)
        if path.suffix == SUFFIX:
            return True
        if path.suffix != ".story":
            return False
        if around.file is not None and path.name == around.file.name:
            return False
        source = Source(path.name, read_bytes(path, _LARGEST_LIBRARY).decode("utf-8"))
    except (OSError, ValueError):
        return False
    words = [p.keyword for p in split_statements(source, _WORDS_OF_LIBRARIES).pieces]
    return bool(words) and all(word in _WORDS_OF_LIBRARIES for word in words)


def _audiences(place: Place, _: Slot) -> Iterator[Offer]:
    about = {
        "bayesian": "viewers who reason by Bayes' rule",
        "particles": "the same of viewers who hold some hypotheses instead of all",
        "average": "average(AUDIENCE, ...): several viewers, whose beliefs are averaged",
    }
    world = place.around.vocabulary
    for name in AUDIENCES:
        if name != "particles" or world is None or world.holds_particles:
            yield Offer(name, "audience", about.get(name, ""))


def named_audiences(place: Place, _: Slot) -> Iterator[Offer]:
    """The audiences that beliefs can be asked of."""
    yield from map(audience_offer, place.around.audiences)


def audience_offer(audience: Audience) -> Offer:
    """An audience of the story."""
    statement = audience.span
    told = "the viewers of beliefs that name no others" if statement is None else statement.text
    return Offer(audience.name, "audience", " ".join(told.split()))


def _searches(place: Place, _: Slot) -> Iterator[Offer]:
    world = place.around.vocabulary
    for name, method in METHODS.items():
        settings = method.settings(None if world is None else world.enumerable)
        if settings is not None:
            shown = ", ".join(f"{s.name} = {shown_default(s)}" for s in settings)
            yield Offer(name, "search", f"{name}({shown})")


def settings_of(owner: str, around: Surroundings) -> dict[str, Setting]:
    """The settings of `world kitchen`, `audience bayesian` or `search beam`."""
    keyword, _, name = owner.partition(" ")
    world = around.vocabulary
    if keyword == "search":
        if name not in METHODS:
            return {}
        offered = METHODS[name].settings(None if world is None else world.enumerable)
        return {s.name: s for s in offered or ()}
    if world is None:
        return {}
    if keyword == "world":
        return world.settings
    if name not in ("bayesian", "particles"):
        return {}
    own = PARTICLES if name == "particles" else {}
    return {**own, **{k: world.settings[k] for k in world.observer_settings}, **OF_VIEWERS}


def shown_default(setting: Setting) -> str:
    """A setting's default as a story has it."""
    value = setting.default
    if isinstance(value, tuple):
        return "{" + ", ".join(f"{x:g}" for x in value) + "}"
    return f"{value:g}" if isinstance(value, float | int) else str(value)


def setting_offer(setting: Setting) -> Offer:
    """The name of a setting."""
    detail = f"{setting.name} = {shown_default(setting)}"
    about = f"{setting.documentation} ({setting.possible})"
    return Offer(setting.name, "setting", detail, about, " = ")


def _settings(place: Place, slot: Slot) -> Iterator[Offer]:
    given = {str(part[0]) for part in place.stack[-1].parts if part}
    for name, setting in settings_of(slot.name, place.around).items():
        if name not in given:
            yield setting_offer(setting)


def _setting_values(place: Place, slot: Slot) -> Iterator[Offer]:
    owner, _, name = slot.name.rpartition(" ")
    setting = settings_of(owner, place.around).get(name)
    if setting is None:
        return
    default = shown_default(setting)
    detail = f"{name} = {default}, the default"
    if setting.choices:
        for choice in setting.choices:
            usual = detail if choice == default else f"{name} = {choice}"
            yield Offer(choice, "value", usual, setting.documentation)
    elif default != "inf":
        yield Offer(default, "value", detail, f"{setting.documentation} ({setting.possible})")


OF_STATEMENTS: dict[str, Callable[[Place, Slot], Iterator[Offer]]] = {
    "world": _worlds,
    "library": _libraries,
    "audience": _audiences,
    "whose": named_audiences,
    "search": _searches,
    "setting": _settings,
    "setting value": _setting_values,
}
