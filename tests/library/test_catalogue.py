"""The catalogue: a page that needs nothing from outside, and pictures kept while they are right."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from libraries_for_tests import Forgery
from PIL import Image

from browser_for_tests import chromium  # noqa: F401
from commands_for_tests import Run, on_a_terminal
from i2pdsl.commands.patterns import open_library
from i2pdsl.library.examples import gallery_files
from i2pdsl.library.films import pack_film, read_film

VOID = {"meta", "img", "br", "link", "input"}
PATTERNS = """\
# A side is taken: <b>viewers</b> & all believe the `event`.
# Use it to begin. `event`: what they believe. `weight`: what it counts.
# After Nobody 2026, DOI 10.1000/1.
pattern side(event, weight = 1) = sum_t weight * P(event | script[:t])

pattern other(event) = side(not event)

pattern grid_only(latent) = sum_t suspense(latent | script[:t])
"""
STORY = """\
# The robot shows its door.
world fork
length 4
start at(robot, (4, 4))
import sides

maximize side(G_robot = left)
search beam(starts = 1, width = 2)

# expect mean_t P(G_robot = left | script[:t]) >= 0.9
"""


class Page(HTMLParser):
    """Every element is closed in its order; ids are there once; what is linked to."""

    def __init__(self, text: str):
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.words = ""
        self.feed(text)
        self.close()
        assert self.open == []
        assert len(set(self.ids)) == len(self.ids)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        if found.get("id"):
            self.ids.append(str(found["id"]))
        self.links += [str(found[key]) for key in ("href", "src") if found.get(key)]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words += data


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A compiled library of three patterns, alone."""
    from i2pdsl import cli

    made = tmp_path_factory.mktemp("sides")
    folder = made / "source"
    folder.mkdir()
    (folder / "sides.story").write_text(PATTERNS, encoding="utf-8")
    (folder / "door.story").write_text(STORY, encoding="utf-8")
    arguments = ["compile", str(folder), "-o", str(made / "sides.i2plib"), "--no-programs"]
    assert cli.run_command(arguments) == 0
    return made


BRIEFLY = ("--world", "fork", "--seeds", "1")


pytestmark = pytest.mark.usefixtures("search_once")  # how good the examples are is not asked here


def write(place: Path, i2p: Run, *more: str) -> dict[str, Any]:
    done = i2p(
        "patterns", place / "sides.i2plib", "--page", place / "book", *BRIEFLY, "--json", *more
    )
    assert done.status == 0, done.err
    return json.loads(done.out)


def pages(folder: Path) -> dict[str, Page]:
    """The pages of a catalogue, by name."""
    return {p.stem: Page(p.read_text(encoding="utf-8")) for p in sorted(folder.glob("*.html"))}


def test_the_pages(place: Path, i2p: Run) -> None:
    said = write(place, i2p)
    assert (said["patterns"], said["examples"], said["failed"]) == (3, 3, {})
    found = pages(place / "book")
    assert list(found) == ["beliefs", "index", "questions"]
    assert {"side", "other", "top"} <= set(found["beliefs"].ids)
    assert {"grid_only", "top"} <= set(found["questions"].ids)
    contents = found["index"]
    assert "A side is taken: <b>viewers</b> & all believe the event" in contents.words
    assert {"beliefs.html#side", "questions.html#grid_only"} <= set(contents.links)
    for page in found.values():
        for link in page.links:
            assert not re.match(r"[a-z]+:|//", link), "nothing from outside"
            name, _, anchor = link.partition("#")
            assert not name or (place / "book" / name).is_file(), link
            if anchor:
                assert anchor in found[name.removesuffix(".html")].ids if name else page.ids
    page = found["beliefs"]
    assert "A side is taken: <b>viewers</b> & all believe the event." in page.words
    assert "what it counts." in page.words
    assert "After Nobody 2026, DOI 10.1000/1." in page.words
    assert "import sides" in page.words
    assert "# expect" not in page.words
    assert "not hill: suspense looks one frame ahead" in found["questions"].words
    for name in ("side-fork", "other-fork"):
        assert f"pictures/{name}.html" in page.links
    for path in (place / "book").glob("*.html"):
        text = path.read_text(encoding="utf-8")
        assert "url(" not in text
        assert "@import" not in text


def test_of_several_seeds_the_panel_chooses(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Among equal scores the panel's mean decides, and what is far behind comes last."""
    from dataclasses import replace

    from i2pdsl.objective.panel import Judgement
    from i2pdsl.stories import Story

    real, seen = Story.solve, []
    means = {0: 1.0, 1: 3.0, 2: 9.0}

    def solve(self: Story, seed: int = 0, **more: Any) -> Any:
        found = real(self, 0, **more)
        score = found.score * (0.5 if seed == 2 else 1)
        seen.append(seed)
        scripts = tuple(replace(s, record=replace(s.record, score=score)) for s in found.candidates)
        return replace(
            found, candidates=scripts, judgements=(Judgement(means[seed], 0.0),) * len(scripts)
        )

    monkeypatch.setattr(Story, "solve", solve)
    done = i2p("patterns", place / "sides.i2plib", "--page", tmp_path, "--world", "fork", "--json")
    assert done.status == 0
    assert seen == [0, 1, 2] * 3
    assert "panel 3<" in (tmp_path / "beliefs.html").read_text(encoding="utf-8")
    assert "best of 3 seeds" in Page((tmp_path / "index.html").read_text(encoding="utf-8")).words


def test_pictures_are_kept_while_they_are_right(place: Path, i2p: Run) -> None:
    write(place, i2p)
    pictures = place / "book" / "pictures"
    before = {p.name: p.stat().st_mtime_ns for p in pictures.iterdir()}
    assert write(place, i2p)["made"] == 0
    assert {p.name: p.stat().st_mtime_ns for p in pictures.iterdir()} == before
    (pictures / "side-fork.png").unlink()
    assert write(place, i2p)["made"] == 1
    manifest = json.loads((pictures / "manifest.json").read_text(encoding="utf-8"))
    manifest["other-fork"]["key"] = "old"
    manifest["grid_only-fork"]["curves"] = "none"
    (pictures / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    assert write(place, i2p)["made"] == 2
    (pictures / "manifest.json").write_text("[", encoding="utf-8")
    assert write(place, i2p)["made"] == 3
    assert not list(pictures.glob(".new*"))


def test_pictures_are_named_in_the_list(place: Path, i2p: Run) -> None:
    write(place, i2p)
    library = place / "book" / "sides.i2plib"
    library.write_bytes((place / "sides.i2plib").read_bytes())
    done = i2p("patterns", library)
    assert f"picture: {place / 'book' / 'pictures' / 'side-fork.png'}" in done.out
    assert done.err == ""
    found = {p["name"]: p for p in json.loads(i2p("patterns", library, "--json").out)}
    assert found["side"]["pictures"] == {"fork": str(place / "book/pictures/side-fork.png")}
    assert found["grid_only"]["worlds"] == [
        "cellar",
        "court",
        "estate",
        "farm",
        "fork",
        "kitchen",
        "maze",
        "nursery",
        "park",
        "porters",
    ]
    library.unlink()
    assert "i2p patterns --page FOLDER" in i2p("patterns", place / "sides.i2plib").err


def test_ctrl_c_keeps_what_is_there(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from i2pdsl.library import examples

    real = examples.Gallery.make

    def interrupted(self: Any, example: Any, bars: Any) -> Any:
        found = pages(tmp_path)  # whole from the first moment on, with what there is
        assert ("pictures/grid_only-fork.html" in found["questions"].links) == (
            example.name != "grid_only-fork"
        )
        assert f"{int(example.name != 'grid_only-fork')} of 3 examples" in found["index"].words
        assert "Reload the page for more" in found["index"].words
        assert "is not made yet" in found["beliefs"].words
        if example.name == "other-fork":
            raise KeyboardInterrupt
        return real(self, example, bars)

    monkeypatch.setattr(examples.Gallery, "make", interrupted)
    arguments = ("patterns", place / "sides.i2plib", "--page", tmp_path, "--world", "fork")
    done = i2p(*arguments, "--seeds", "1")
    assert done.status == 130
    assert "interrupted: the page has the 1 of 3 examples made so far" in done.err
    found = pages(tmp_path)
    assert "pictures/grid_only-fork.html" in found["questions"].links
    assert "no example yet" in found["index"].words
    monkeypatch.setattr(examples.Gallery, "make", real)
    assert json.loads(i2p(*arguments, "--seeds", "1", "--json").out)["made"] == 2
    assert "Reload" not in pages(tmp_path)["index"].words


def test_ctrl_c_between_seeds_shows_the_best_so_far(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """It is shown, and not kept as if it were the best of all."""
    from i2pdsl.stories import Story

    real = Story.solve

    def solve(self: Story, seed: int = 0, **more: Any) -> Any:
        if seed:
            raise KeyboardInterrupt
        return real(self, seed, **more)

    monkeypatch.setattr(Story, "solve", solve)
    done = i2p("patterns", place / "sides.i2plib", "--page", tmp_path, "--world", "fork", "--json")
    assert done.status == 130
    assert json.loads(done.out)["examples"] == 1
    assert not (tmp_path / "pictures" / "manifest.json").exists()


def test_bars_say_which_example_of_how_many(place: Path, tmp_path: Path) -> None:
    done = on_a_terminal(
        *("patterns", place / "sides.i2plib", "--page", tmp_path, *BRIEFLY),
        until="2 of 3, other-fork: ",
    )
    assert done.status == 130
    assert "1 of 3, grid_only-fork: " in done.err
    assert "interrupted: the page has the 1 of 3" in done.err


def test_an_example_that_cannot_be_made_is_said(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from i2pdsl.errors import error, whole_file
    from i2pdsl.library import examples

    def fails(self: Any, example: Any, bars: Any) -> Any:
        raise error("start", "nothing is < possible", whole_file("x"))

    monkeypatch.setattr(examples.Gallery, "make", fails)
    done = i2p(
        "patterns", place / "sides.i2plib", "--seeds", "1", "--page", tmp_path, "--world", "fork"
    )
    assert done.status == 0
    assert "warning: side-fork could not be made: nothing is < possible" in done.err
    assert "could not be made: nothing is < possible." in pages(tmp_path)["beliefs"].words


@pytest.mark.browser
@pytest.mark.parametrize(
    ("scheme", "width"),
    [
        *(("dark", 320), ("light", 400), ("light", 1200)),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (("light", 320), ("dark", 400), ("dark", 1200))
        ),
    ],
)
def test_in_a_browser(
    place: Path,
    i2p: Run,
    chromium: Any,  # noqa: F811
    width: int,
    scheme: str,
) -> None:
    write(place, i2p)
    context = chromium.new_context(viewport={"width": width, "height": 800}, color_scheme=scheme)
    page = context.new_page()
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto((place / "book" / "index.html").as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.locator(".contents a").first.click()
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    for picture in page.locator("img").all():
        picture.scroll_into_view_if_needed()
        page.wait_for_function(
            "e => e.complete && e.naturalWidth > 0", arg=picture.element_handle()
        )
    assert all(url.startswith("file:") for url in asked)
    trouble: list[str] = []
    page.on("console", lambda message: trouble.append(message.text))
    page.on("pageerror", lambda problem: trouble.append(str(problem)))
    page.get_by_role("button", name=re.compile("^Play it here")).first.click()
    player = page.locator(".player").first
    player.locator("[data-actor]").first.wait_for()
    player.locator("#counter", has_text=re.compile(r"[1-9]\d* / \d+")).wait_for()
    player.locator("#play").press("End")
    player.locator("#counter", has_text=re.compile(r"(\d+) / \1")).wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert trouble == []
    page.locator(".example-head a").first.click()
    assert page.locator("#play").is_visible()
    context.close()


def test_every_standard_pattern_has_a_small_picture() -> None:
    """Made by i2pdsl/library/thumbnails.py, and named by `i2p patterns`."""
    library, place = open_library(None, with_stories=False)
    for pattern in library.patterns:
        files = [f for f in gallery_files(place) if f.stem.rpartition("-")[0] == pattern["name"]]
        assert len(files) == 1, pattern["name"]
        with Image.open(files[0]) as picture:
            assert picture.width > 400
            # Figures keep their colours.
            colours = np.asarray(picture.convert("HSV"))[..., 1]
            assert (colours > 120).mean() > 0.002


# What a catalogue finds in its own folder, and what a library says, is input.

HOSTILE = '"><script>alert(1)</script>'


@pytest.mark.parametrize("name", ["../evil", "/tmp/evil", ".", "..", "a\0b", "CON", "", " "])
def test_a_forged_name_writes_nowhere(name: str, place: Path, tmp_path: Path, i2p: Run) -> None:
    for kind in ("patterns", "outside", "stories", "worlds"):
        forgery = Forgery((place / "sides.i2plib").read_bytes())
        forgery.add(kind, name, "")
        library = tmp_path / "forged.i2plib"
        library.write_bytes(forgery.zipped())
        done = i2p(
            "patterns", library, "--seeds", "1", "--page", tmp_path / "book", "--world", "fork"
        )
        assert done.status == 1
        assert done.err.startswith(f"{library}:1:1: error[library]: the library is damaged: ")
        assert [p.name for p in tmp_path.iterdir()] == ["forged.i2plib"]


def test_a_library_is_called_what_its_file_is(place: Path, tmp_path: Path, i2p: Run) -> None:
    library = tmp_path / "other name.i2plib"
    library.write_bytes((place / "sides.i2plib").read_bytes())
    done = i2p(
        "patterns",
        library,
        "--page",
        tmp_path / "book",
        *BRIEFLY,
        "--json",
    )
    assert json.loads(done.out)["failed"] == {}
    found = pages(tmp_path / "book")
    assert "The patterns of other name" in found["index"].words
    assert 'import "other name.i2plib"' in found["beliefs"].words


def test_no_link_in_the_folder_is_followed(place: Path, tmp_path: Path, i2p: Run) -> None:
    book, outside = tmp_path / "book", tmp_path / "outside"
    book.mkdir()
    outside.mkdir()
    arguments = ("patterns", place / "sides.i2plib", "--page", book, *BRIEFLY)
    (book / "pictures").symlink_to(outside)
    done = i2p(*arguments)
    assert done.status == 1
    assert "error: a link leads out of" in done.err
    (book / "pictures").unlink()
    (book / "pictures").mkdir()
    links = [
        book / "index.html", book / "beliefs.html", book / "pictures" / "manifest.json",
        book / "pictures" / "side-fork.png", book / "pictures" / "side-fork.html",
    ]  # fmt: skip
    for link in links:
        (outside / link.name).write_text("mine", encoding="utf-8")
        link.symlink_to(outside / link.name)
    done = i2p(*arguments)
    assert done.status == 0
    assert "no JSON" in done.err, "the list was none"
    for link in links:
        assert not link.is_symlink()
        assert (outside / link.name).read_text(encoding="utf-8") == "mine"


BAD_ENTRIES: list[tuple[tuple[Any, ...], Any]] = [
    ((), 7), ((), None), (("key",), 7), (("score",), "1"), (("score",), True),
    (("size",), [HOSTILE, 1]), (("size",), [1, 2, 3]), (("size",), [0, -1]), (("size",), 5),
    (("size",), [10**9, 1]), (("curves",), {}), (("curves", 0), []), (("curves", 0, "title"), 1),
    (("curves", 0, "low"), "x"), (("curves", 0, "high"), None), (("curves", 0, "low"), 1e308),
    (("curves", 0, "last"), HOSTILE), (("curves", 0, "last"), -1), (("curves", 0, "more"), 1),
    (("curves", 0, "series"), [1]), (("curves", 0, "series", 0, "label"), [1]),
    (("curves", 0, "series", 0, "color"), "red;background:url(//evil)"),
    (("curves", 0, "series", 0, "dash"), [HOSTILE]),
    (("curves", 0, "series", 0, "values"), [[1]]), (("curves", 0, "series", 0, "values"), ["1"]),
]  # fmt: skip


def test_the_list_of_pictures_is_held_against_its_form(place: Path, i2p: Run) -> None:
    from i2pdsl.library.examples import _read_manifest

    write(place, i2p)
    path = place / "book" / "pictures" / "manifest.json"
    good = json.loads(path.read_text(encoding="utf-8"))
    said: list[str] = []
    assert _read_manifest(path, said.append) == good
    assert said == []
    for way, value in BAD_ENTRIES:
        document = json.loads(json.dumps(good))
        inner = document
        for step in ("side-fork", *way)[:-1]:
            inner = inner[step]
        inner[("side-fork", *way)[-1]] = value
        path.write_text(json.dumps(document), encoding="utf-8")
        said.clear()
        assert set(_read_manifest(path, said.append)) == set(good) - {"side-fork"}, (way, value)
        assert len(said) == 1
        assert str(path) in said[0]
        assert "is damaged: " in said[0]
        assert said[0].endswith("it is made again")
    wrong = (
        b"[1]",
        b"",
        b"\xff",
        b"[" * 10**5,
        b'{"a": NaN}',
        b'{"a": 1, "a": 2}',
        b'{"' + b'\\"' * 10**5,
    )
    for data in wrong:  # fmt: skip
        path.write_bytes(data)
        said.clear()
        assert _read_manifest(path, said.append) == {}
        assert len(said) == 1
        assert said[0].endswith("the pictures are made again")
    path.unlink()
    path.mkdir()
    said.clear()
    assert _read_manifest(path, said.append) == {}
    assert said == [f"{path} cannot be read: it is a folder; the pictures are made again"]
    path.rmdir()
    path.write_text(json.dumps(good), encoding="utf-8")


def test_whatever_the_list_says_nothing_gets_into_the_page(place: Path, i2p: Run) -> None:
    """Texts that are right by their form are escaped."""
    write(place, i2p)
    path = place / "book" / "pictures" / "manifest.json"
    good = path.read_text(encoding="utf-8")
    document = json.loads(good)
    panel = document["side-fork"]["curves"][0]
    panel["title"] = HOSTILE
    panel["series"][0]["label"] = HOSTILE
    path.write_text(json.dumps(document), encoding="utf-8")
    said = write(place, i2p)
    assert said["made"] == 0
    text = (place / "book" / "beliefs.html").read_text(encoding="utf-8")
    assert set(re.findall("<script[^>]*>", text)) == {
        '<script type="module">',
        '<script type="application/gzip" data-script="grid/kitchen.js">',
    }
    assert text.count('<script type="module">') == 1
    assert HOSTILE in Page(text).words
    (policy,) = re.findall(r"script-src '([^']*)'; object-src 'none'", text)
    (script,) = re.findall('<script type="module">(.*?)</script>', text, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert policy == f"sha256-{digest}"
    index = (place / "book" / "index.html").read_text(encoding="utf-8")
    assert "<script" not in index
    assert "script-src 'none'" in index
    path.write_text(good, encoding="utf-8")


def test_films_that_are_no_films_are_made_again(place: Path, i2p: Run) -> None:
    write(place, i2p)
    path = place / "book" / "pictures" / "side-fork.film"
    good = path.read_text(encoding="utf-8")
    film = read_film(path)
    assert film is not None
    assert film.as_text() == good
    played = json.loads(gzip.decompress(base64.b64decode(film.data)))
    assert (played["last"], played["script"]) == (4, "grid/kitchen.js")
    for wrong in (
        "",
        "grid/kitchen.js\n",
        f"grid/other.js\n{film.data}",
        f"grid/kitchen.js\n{film.data}</script><script>alert(1)</script>",
        f"../kitchen.js\n{film.data}",
    ):
        path.write_text(wrong, encoding="utf-8")
        assert read_film(path) is None
    path.unlink()
    assert read_film(path) is None
    assert write(place, i2p)["made"] == 1
    assert read_film(path) == film


@pytest.mark.browser
def test_a_forged_film_runs_nothing(place: Path, i2p: Run, chromium: Any) -> None:  # noqa: F811
    write(place, i2p)
    path = place / "book" / "pictures" / "side-fork.film"
    good = path.read_text(encoding="utf-8")
    film = read_film(path)
    assert film is not None
    played = json.loads(gzip.decompress(base64.b64decode(film.data)))
    played["stage"] += "<img src=x onerror='document.title = 1'><script>document.title = 2</script>"
    path.write_text(pack_film(played).as_text(), encoding="utf-8")
    assert write(place, i2p)["made"] == 0
    page = chromium.new_page()
    page.goto((place / "book" / "beliefs.html").as_uri())
    title = page.title()
    page.get_by_role("button", name="Play it here: side").click()
    page.locator(".player [data-actor]").first.wait_for()
    page.wait_for_timeout(200)
    assert page.title() == title
    page.close()
    path.write_text(good, encoding="utf-8")


def test_hostile_texts_of_a_library_are_escaped(tmp_path: Path, i2p: Run) -> None:
    folder = tmp_path / "source"
    folder.mkdir()
    name = "a<script>alert(1)</script>&'\""
    (folder / "sides.story").write_text(
        f"# {HOSTILE} `{HOSTILE}` </style><style>\n# See A{HOSTILE}.\n{PATTERNS}", encoding="utf-8"
    )
    story = STORY.replace("# The robot", f"# {HOSTILE} </pre>\n# The robot")
    (folder / f"{name.replace('/', '')}.story").write_text(story, encoding="utf-8")
    done = i2p("patterns", folder, "--page", tmp_path / "book", *BRIEFLY, "--json")
    assert done.status == 0, done.err
    assert json.loads(done.out)["failed"] == {}
    for path in sorted((tmp_path / "book").rglob("*.html")):
        text = path.read_text(encoding="utf-8")
        assert "<script>alert" not in text
        assert "</style><style>" not in text
    assert HOSTILE in Page((tmp_path / "book" / "index.html").read_text(encoding="utf-8")).words


def test_pictures_of_a_world_that_lies_in_a_folder(tmp_path: Path, i2p: Run) -> None:
    """Its name is a way in the library, and none in the catalogue."""
    from i2pdsl.library.examples import picture_name

    assert picture_name("side", "fork") == "side-fork"
    for world in ("deep/x.world", "../x", "/x", "a?b#c", "x" * 500):
        assert "/" not in picture_name("side", world)
    assert picture_name("side", "a/b") != picture_name("side", "a_b")


def test_a_story_of_a_library_that_cannot_be_made(place: Path, tmp_path: Path, i2p: Run) -> None:
    forgery = Forgery((place / "sides.i2plib").read_bytes())
    library = tmp_path / "sides.i2plib"
    arguments = ("patterns", library, "--page", tmp_path / "book", *BRIEFLY)
    forgery.text("door.story", STORY.replace("length 4", "length 0"))
    library.write_bytes(forgery.zipped())
    done = i2p(*arguments)
    assert done.status == 0
    assert "warning: side-fork could not be made: " in done.err
    forgery.text("door.story", "world (((\n")
    library.write_bytes(forgery.zipped())
    done = i2p(*arguments, "--json")
    assert json.loads(done.out)["failed"] == {}, "an example is made from the signature"
    forgery.add("worlds", "yard.world", "nonsense\n")
    library.write_bytes(forgery.zipped())
    done = i2p("patterns", library, "--json")
    assert done.status == 0
    assert all("yard" not in p["worlds"] for p in json.loads(done.out))
