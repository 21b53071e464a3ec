"""The catalogue: a page that needs nothing from outside, and pictures kept while they are right."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from commands_for_tests import Run
from i2pdsl.commands.patterns import open_library
from i2pdsl.library.examples import gallery_files

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


def write(place: Path, i2p: Run, *more: str) -> dict[str, Any]:
    done = i2p("patterns", place / "sides.i2plib", "--page", place / "book", "--world", "fork",
               "--json", *more)  # fmt: skip
    assert done.status == 0, done.err
    return json.loads(done.out)


def test_the_page(place: Path, i2p: Run) -> None:
    said = write(place, i2p)
    assert (said["patterns"], said["examples"], said["failed"]) == (3, 3, {})
    text = (place / "book" / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    assert {"side", "other", "grid_only", "top"} <= set(page.ids)
    assert "A side is taken: <b>viewers</b> & all believe the event." in page.words
    assert "what it counts." in page.words
    assert "After Nobody 2026, DOI 10.1000/1." in page.words
    assert "import sides" in page.words
    assert "# expect" not in page.words
    assert "not hill: suspense looks one frame ahead" in page.words
    for link in page.links:
        assert not re.match(r"[a-z]+:|//", link), "nothing from outside"
        if link.startswith("#"):
            assert link[1:] in page.ids
        else:
            assert (place / "book" / link).is_file(), link
    for name in ("side-fork", "other-fork", "grid_only-fork"):
        assert f"pictures/{name}.html" in page.links
    assert "url(" not in text
    assert "@import" not in text


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
    assert found["grid_only"]["worlds"] == ["fork", "kitchen", "maze", "porters"]
    library.unlink()
    assert "i2p patterns --page FOLDER" in i2p("patterns", place / "sides.i2plib").err


def test_ctrl_c_keeps_what_is_there(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from i2pdsl.library import examples

    real = examples.Gallery.make

    def interrupted(self: Any, example: Any, bars: Any) -> Any:
        if example.name == "other-fork":
            raise KeyboardInterrupt
        return real(self, example, bars)

    monkeypatch.setattr(examples.Gallery, "make", interrupted)
    done = i2p("patterns", place / "sides.i2plib", "--page", tmp_path, "--world", "fork")
    assert done.status == 130
    assert "interrupted: the page has the 1 of 3 examples made so far" in done.err
    page = Page((tmp_path / "index.html").read_text(encoding="utf-8"))
    assert "pictures/grid_only-fork.html" in page.links
    assert "no example yet" in page.words


def test_an_example_that_cannot_be_made_is_said(
    place: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from i2pdsl.errors import error, whole_file
    from i2pdsl.library import examples

    def fails(self: Any, example: Any, bars: Any) -> Any:
        raise error("start", "nothing is < possible", whole_file("x"))

    monkeypatch.setattr(examples.Gallery, "make", fails)
    done = i2p("patterns", place / "sides.i2plib", "--page", tmp_path, "--world", "fork")
    assert done.status == 0
    assert "warning: side-fork could not be made: nothing is < possible" in done.err
    page = Page((tmp_path / "index.html").read_text(encoding="utf-8"))
    assert "could not be made: nothing is < possible." in page.words


@pytest.mark.browser
@pytest.mark.parametrize("width", [320, 400, 1200])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_in_a_browser(place: Path, i2p: Run, width: int, scheme: str) -> None:
    if not Path("/usr/bin/chromium").exists():
        pytest.skip("needs the system's Chromium")
    write(place, i2p)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as player:
        browser = player.chromium.launch(executable_path="/usr/bin/chromium")
        context = browser.new_context(
            viewport={"width": width, "height": 800},
            color_scheme=scheme,  # type: ignore[arg-type]
        )
        page = context.new_page()
        asked: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.goto((place / "book" / "index.html").as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        for picture in page.locator("img").all():
            picture.scroll_into_view_if_needed()
            page.wait_for_function(
                "e => e.complete && e.naturalWidth > 0", arg=picture.element_handle()
            )
        assert all(url.startswith("file:") for url in asked)
        page.locator(".example-head a").first.click()
        assert page.locator("#play").is_visible()
        browser.close()


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
