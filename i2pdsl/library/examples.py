"""Examples of a library's patterns: one story for each pattern and world, made and drawn.

An example is a story of the library that uses the pattern, or a story of one line that calls it as
it was proved to fit. Its pictures are kept as long as nothing that they depend on changes.
"""

from __future__ import annotations

import hashlib
import json
import re
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from i2pdsl.errors import Source, StoryError, error, shorten, whole_file
from i2pdsl.language import ast
from i2pdsl.language.kinds import used_names
from i2pdsl.language.methods import LONGEST_STORY
from i2pdsl.language.packed import LARGEST, SUFFIX, write_contents
from i2pdsl.language.parse import parse
from i2pdsl.language.scope import standard_library
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.library.curves import Curves, decisive_curves
from i2pdsl.library.description import MADE_WITH, PatternLibrary
from i2pdsl.library.films import PackedFilm, pack_film, read_film
from i2pdsl.library.fits import example_call, uses_of
from i2pdsl.resources import write_text
from i2pdsl.untrusted import WrongData, below, decode_json, mismatch, plain_name, read_bytes
from i2pdsl.worlds.find import builtin_worlds, find_vocabulary

if TYPE_CHECKING:
    from i2pdsl.progress import Bars
    from i2pdsl.render.files import PictureFiles

MANIFEST = "manifest.json"
_USUAL_LENGTH = 15  # frames of an example
FIRST_WORLD = "kitchen"  # where patterns are shown that no story of their library shows
_WIDEST = 100_000  # pixels of a picture
_DEEPEST = 12  # brackets in brackets of the manifest, which has 7
_LARGEST_NUMBER = 1e300  # of what is drawn


def _finite(value: Any) -> str | None:
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return None if plain and abs(value) <= _LARGEST_NUMBER else "is no number"


def _size(value: Any) -> str | None:
    plain = isinstance(value, list) and len(value) == 2 and all(type(x) is int for x in value)
    return None if plain and all(0 < x <= _WIDEST for x in value) else "is no size of a picture"


def _frames(value: Any) -> str | None:
    return None if type(value) is int and 0 <= value <= LONGEST_STORY else "is no number of frames"


def _colour(value: Any) -> str | None:
    plain = isinstance(value, str) and re.fullmatch(r"#[0-9a-fA-F]{6}", value)
    return None if plain else "is no colour"


# What the manifest says of an example (untrusted.mismatch).
_ENTRY: dict[str, Any] = {
    "key": str,
    "score": _finite,
    "panel": _finite,
    "size": _size,
    "curves": [
        {
            "title": str, "low": _finite, "high": _finite, "last": _frames,
            "series": [
                {"label": str, "color": _colour, "dash": [_finite], "values": [(_finite, None)]}
            ],
        }
    ],
}  # fmt: skip
_EXPECTATION = re.compile(r"^# expect .*\n?", re.MULTILINE)


@dataclass(frozen=True)
class Example:
    """A story that shows what a pattern does in a world.

    Attributes:
        story: its file in the library, or None where it was made from the pattern's signature.
        call: of the pattern, as it stands in the story.
        source: its text.
    """

    pattern: str
    world: str
    story: str | None
    call: str
    source: str

    @property
    def name(self) -> str:
        """Of its pictures: `pictures/NAME.png`."""
        return picture_name(self.pattern, self.world)


@dataclass(frozen=True)
class Shown:
    """An example that was made: its pictures are pictures/NAME.png and NAME.html.

    `panel` is the mean judgement of viewers whom it was not made for (objective/panel.py); `film`
    is what plays it, None where nothing does.
    """

    example: Example
    score: float
    panel: float
    size: tuple[int, int]
    curves: list[Curves]
    film: PackedFilm | None = None


def picture_name(pattern: str, world: str) -> str:
    """The name of the pictures of a pattern's example in a world, whatever that is called."""
    return f"{pattern}-{plain_name(world)}"


def examples_of(
    library: PatternLibrary, pattern: dict[str, Any], worlds: list[str]
) -> list[Example]:
    """An example in each of the worlds that the pattern fits.

    Where none of them is a story of the library, one that is comes first, from another world.
    """
    found = [e for world in worlds for e in [_example(library, pattern, world)] if e is not None]
    if not any(e.story for e in found):
        elsewhere = sorted({e["world"] for e in pattern["examples"]} - {*worlds})
        more = (_example(library, pattern, world) for world in elsewhere[:1])
        found = [*(e for e in more if e is not None), *found]
    return found


def _example(library: PatternLibrary, pattern: dict[str, Any], world: str) -> Example | None:
    name = pattern["name"]
    stories = [s for s in library.stories if s["world"] == world and name in s["calls"]]
    if stories:
        best = min(stories, key=lambda s: _distance(s, name))
        text = _with_library(_EXPECTATION.sub("", best["source"]), world, library)
        return Example(name, world, best["file"], best["calls"][name], text)
    words = library.vocabularies.get(world)
    if words is None or not pattern["worlds"][world]["fits"]:
        return None
    call = example_call(pattern, library.exports, words)
    if call is None:
        return None
    return Example(name, world, None, call, _generated(library, pattern, world, call))


def _distance(story: dict[str, Any], name: str) -> tuple[Any, ...]:
    """How far a story is from showing one pattern alone."""
    stem = Path(story["file"]).stem.replace("-", "_")
    lines = len(re.findall(r"^(?:maximize|minimize)\b", story["source"], re.MULTILINE))
    return (stem != name, name not in stem, len(story["calls"]), lines, story["file"])


def _with_library(text: str, world: str, library: PatternLibrary) -> str:
    """A story that imports the library, where it imported some of its files, and calls its world by
    the name that this has in the library."""
    try:
        program = parse(Source("example", text))
    except StoryError:
        return text  # it cannot be made, which is said where it is tried
    changes = [(statement.span, _world_line(world)) for statement in program.of(ast.World)]
    for number, statement in enumerate(program.of(ast.Import)):
        changes.append((statement.span, "" if number else _import_line(library)))
    for span, new in sorted(changes, key=lambda change: -change[0].start):
        text = text[: span.start] + new + text[span.end :]
    return re.sub(r"\n{3,}", "\n\n", text).strip("\n") + "\n"


def _world_line(world: str) -> str:
    return f"world {world}" if world.isidentifier() else f'world "{world}"'


def _import_line(library: PatternLibrary) -> str:
    name = library.name
    return f"import {name}" if name.isidentifier() else f'import "{name}{SUFFIX}"'


def _generated(library: PatternLibrary, pattern: dict[str, Any], world: str, call: str) -> str:
    use = uses_of(pattern["result"])[0].format(call)
    known = standard_library().names.get(pattern["name"])
    is_standard = known is not None and known.item.body.span.text == pattern["body"]  # type: ignore[union-attr]
    words = _built_in(world)
    lines = [
        f"# An example of `{pattern['name']}`, made from its signature.",
        _world_line(world),
        f"length {_USUAL_LENGTH if words is None else words.usual_length}",
        *([] if is_standard else [_import_line(library)]),
        "",
        f"maximize {use}",
    ]
    return "\n".join(lines) + "\n"


class Gallery:
    """The pictures in the folder `pictures` of a catalogue, and what they were made from.

    `say` is told where the list of these cannot be used, so that pictures are made again. Each
    example is the best of as many `seeds`, by the panel.

    Raises OSError where a link leads out of the catalogue's folder.
    """

    def __init__(
        self, catalogue: Path, library: PatternLibrary, say: Callable[[str], None], seeds: int
    ):
        self.seeds = seeds
        self.folder = below(catalogue, "pictures", MANIFEST).parent
        self.library = library
        self.known = _read_manifest(self.folder / MANIFEST, say)

    def kept(self, example: Example) -> Shown | None:
        """An example whose pictures are there and still right."""
        entry = self.known.get(example.name)
        if entry is None or entry["key"] != self.key(example):
            return None
        files = (self.folder / f"{example.name}{end}" for end in (".png", ".html"))
        if not all(file.is_file() for file in files):
            return None
        film = read_film(self.folder / f"{example.name}.film")
        if film is None:
            return None
        curves = [Curves(**panel) for panel in entry["curves"]]
        score, panel = float(entry["score"]), float(entry["panel"])
        return Shown(example, score, panel, tuple(entry["size"]), curves, film)

    def key(self, example: Example) -> str:
        """A digest of all that the pictures depend on."""
        world = self.library.worlds.get(example.world)
        own = [] if world is None else [world.source.text]
        parts = [MADE_WITH, f"{self.seeds}", example.source, *own, *self.bodies(example.pattern)]
        return hashlib.sha256(json.dumps(parts).encode("utf-8")).hexdigest()

    def bodies(self, name: str) -> list[str]:
        """The texts of a pattern and of all that it uses."""
        found: dict[str, str] = {}
        waiting = [self.library.definitions.get(name)]
        while waiting:
            definition = waiting.pop()
            if definition is None or definition.item.name.id in found:
                continue
            found[definition.item.name.id] = definition.item.span.text
            names = used_names(definition.item, definition.module)
            waiting += [definition.module.find(name) for name in names]
        return [found[name] for name in sorted(found)]

    def make(self, example: Example, bars: Bars) -> tuple[Shown, bool]:
        """Makes a story with each seed and draws the best; tells whether all were searched.

        Raises StoryError where the story cannot be made, KeyboardInterrupt before there is any.
        """
        from i2pdsl.render.film_page import to_mount
        from i2pdsl.render.pictures import pictures_of
        from i2pdsl.results import best_of
        from i2pdsl.stories import story_from

        with tempfile.TemporaryDirectory() as place:
            story = story_from(
                Source(f"{example.name}.story", example.source), self.unpacked(place)
            )
            found = []
            try:
                for seed in range(self.seeds):
                    found.append(story.solve(seed, watch=bars.watch))
                    if not found[-1].finished:
                        break
            except KeyboardInterrupt:
                if not found:
                    raise
        finished = len(found) == self.seeds and found[-1].finished
        result = best_of(found)
        title = f"{example.pattern.replace('_', ' ')}, {place_of(example.world)}"
        pictures = pictures_of([result.script], title)
        if "html" not in pictures.offered:
            message = f"films in worlds like {result.script.world.name} cannot be played"
            raise error("pictures", message, whole_file(example.name))
        size = self.drawn(pictures, example.name)
        curves = decisive_curves(pictures.panels, example.call)
        film = pack_film(to_mount(pictures.moving(), (), pictures.title))
        write_text(below(self.folder, f"{example.name}.film"), film.as_text())
        shown = Shown(example, result.score, result.judgements[0].mean, size, curves, film)
        if finished:
            self.known[example.name] = {
                "key": self.key(example), "score": shown.score, "panel": shown.panel,
                "size": list(size), "curves": [asdict(panel) for panel in curves],
            }  # fmt: skip
            write_text(self.folder / MANIFEST, json.dumps(self.known, indent=1) + "\n")
        return shown, finished

    def drawn(self, pictures: PictureFiles, name: str) -> tuple[int, int]:
        """Writes the comic and the page of an example; returns the comic's size."""
        from PIL import Image

        from i2pdsl.render.files import COMIC_ZOOM
        from i2pdsl.render.raster import save_png

        page, comic = pictures.page(), below(self.folder, f"{name}.png")
        save_png(comic, pictures.comic(), COMIC_ZOOM)
        write_text(below(self.folder, f"{name}.html"), page)
        with Image.open(comic) as picture:
            return picture.size

    def unpacked(self, place: str) -> Path:
        """A folder with the library and its worlds, for its examples to be read in."""
        write_contents(below(Path(place), f"{self.library.name}{SUFFIX}"), self.library.contents)
        for name, file in self.library.worlds.items():
            path = name if name.endswith(".world") else f"{name}.world"
            write_text(below(Path(place), *path.split("/")), file.source.text)
        return Path(place)


def _read_manifest(path: Path, say: Callable[[str], None]) -> dict[str, Any]:
    """What is written of the pictures. What is not as it should be is said and left out."""
    try:
        known = decode_json(read_bytes(path, LARGEST), "the list", _DEEPEST)
        if not isinstance(known, dict):
            raise WrongData("the list is damaged: it is no record")
    except FileNotFoundError:
        return {}
    except OSError as problem:
        say(f"{path} cannot be read: {problem.strerror}; the pictures are made again")
        return {}
    except WrongData as problem:
        say(f"{path}: {problem}; the pictures are made again")
        return {}
    right: dict[str, Any] = {}
    for name, entry in known.items():
        wrong = mismatch(entry, _ENTRY, "it")
        if wrong is None:
            right[name] = entry
        else:
            say(f"{path}: the entry {shorten(name)} is damaged: {wrong}; it is made again")
    return right


def place_of(world: str) -> str:
    """`in the kitchen`, `on the hill`."""
    words = _built_in(world)
    return f"in {world}" if words is None else words.where


def _built_in(world: str) -> Vocabulary | None:
    """The words of a built-in world: a library's own is never looked for among files."""
    return find_vocabulary(world) if world in builtin_worlds() else None


def gallery_files(library: Path) -> Iterator[Path]:
    """The pictures beside a library, by name."""
    folder = (library if library.is_dir() else library.parent) / "pictures"
    if folder.is_dir():
        yield from sorted(folder.glob("*-*.png"))


def make_all(
    gallery: Gallery,
    examples: list[Example],
    bars: Bars,
    grown: Callable[[dict[str, Shown], dict[str, str]], object],
) -> tuple[dict[str, Shown], dict[str, str], bool]:
    """Makes the examples that are not there yet. Ctrl-C ends it early.

    `grown` is told what there is before the first one is made, and after each.

    Returns: what there is by the examples' names, why others could not be made, and whether all
    were tried.
    """
    shown: dict[str, Shown] = {}
    failed: dict[str, str] = {}
    for example in examples:
        kept = gallery.kept(example)
        if kept is not None:
            shown[example.name] = kept
    missing = [e for e in examples if e.name not in shown]
    try:
        grown(shown, failed)
        for number, example in enumerate(missing, 1):
            finished = True
            with bars.within(f"{number} of {len(missing)}, {example.name}"):
                try:
                    shown[example.name], finished = gallery.make(example, bars)
                except StoryError as problem:
                    failed[example.name] = problem.diagnostics[0].message
            grown(shown, failed)
            if not finished:
                return shown, failed, False
    except KeyboardInterrupt:  # wherever it came: the page has all that was made
        grown(shown, failed)
        return shown, failed, False
    return shown, failed, True
