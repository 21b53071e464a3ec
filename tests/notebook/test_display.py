"""How things show themselves in notebooks, by IPython's protocol."""

from __future__ import annotations

import base64
import io
import re
from html import unescape
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from PIL import Image

from i2pdsl.answers import Answer
from i2pdsl.errors import Source
from i2pdsl.notebook.source import NotebookStyle, placed, story_html
from i2pdsl.stories import Result, Script, story_from

PLAYER = re.compile(r"srcdoc='([^']*)'")


class Reader(HTMLParser):
    """The elements and the text of some HTML whose elements are all closed."""

    def __init__(self, text: str):
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag != "img":
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def bundle(thing: Any) -> dict[str, Any]:
    data, _ = thing._repr_mimebundle_()
    return data


def picture(data: str) -> Image.Image:
    return Image.open(io.BytesIO(base64.b64decode(data)))


def test_a_story_shows_its_text_in_colours(friend: Result) -> None:
    text = "# <b>not bold</b>\nworld maze\nlength 6\nmaximize depict(rho > 0)\n"
    data = bundle(story_from(Source("a <story>", text)))
    reader = Reader(data["text/html"])
    assert text.rstrip() in reader.text
    assert "world maze, 6 frames, search beam" in reader.text
    assert [tag for tag, _ in reader.elements if tag not in ("span", "div", "pre", "p")] == [
        "small"
    ]
    assert text.rstrip() in data["text/plain"]


def test_colours_are_readable_on_light_and_on_dark() -> None:
    """Contrast after WCAG 2: 4.5 for text on white, 3 for large or bold text on dark."""

    def luminance(colour: str) -> float:
        parts = [int(colour[i : i + 2], 16) / 255 for i in (0, 2, 4)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return float(np.dot(linear, (0.2126, 0.7152, 0.0722)))

    used = set(re.findall(r"color: #(\w{6})", story_html("# a\nlet x = 3 'a'\nmaximize P(rho)")))
    assert len(used) >= 4
    for colour in {token["color"] for _, token in NotebookStyle if token["color"]}:
        light = 1.05 / (luminance(colour) + 0.05)
        dark = (luminance(colour) + 0.05) / (luminance("111111") + 0.05)
        assert light >= 4.5, colour
        assert dark >= 4, colour


@pytest.mark.parametrize("name", ["friend", "hill"])
def test_a_script_shows_its_page_and_its_comic(
    name: str, request: pytest.FixtureRequest, tmp_path: Any
) -> None:
    from i2pdsl.render.pictures import pictures_of
    from i2pdsl.render.raster import svg_png

    found = request.getfixturevalue(name)
    script: Script = found if name == "hill" else found.script
    data = bundle(script)
    reader = Reader(data["text/html"])
    assert [tag for tag, _ in reader.elements] == ["div", "img", "iframe"]
    frame = dict(reader.elements)["iframe"]
    assert frame["sandbox"] == "allow-scripts"
    page = pictures_of([script]).page()
    assert frame["srcdoc"] == page
    comic = picture(data["image/png"])
    width, height = comic.size
    assert width > 2 * height / 3 > 100
    original = Image.open(io.BytesIO(svg_png(pictures_of([script]).comic())))
    both = (np.asarray(image.convert("RGB"), dtype=int) for image in (comic, original))
    assert np.abs(np.subtract(*both)).max() < 30  # of 255: its colours are the same to the eye
    assert dict(reader.elements)["img"]["src"] == f"data:image/png;base64,{data['image/png']}"
    assert data["text/plain"] == repr(script)
    assert len(str(data)) < 350_000


def test_any_text_in_a_story_stays_text(friend: Result) -> None:
    hostile = "# '</iframe><script>window.x = 1</script>\" &amp; <b>\n"
    text = f"{hostile}world maze\nlength 2\nsearch naive\n"
    script = story_from(Source("'\"<b>&", text)).solve().script
    html = bundle(script)["text/html"]
    assert [tag for tag, _ in Reader(html).elements] == ["div", "img", "iframe"]
    (page,) = PLAYER.findall(html)
    assert hostile.strip() in unescape(unescape(page))
    Reader(bundle(story_from(Source("x", text)))["text/html"])


def test_a_result_lists_its_candidates_and_shows_the_best(friend: Result) -> None:
    data = bundle(friend)
    reader = Reader(data["text/html"])
    rows = [tag for tag, _ in reader.elements].count("tr")
    assert rows == 1 + len(friend.candidates) == 4
    pairs = zip(friend.candidates, friend.judgements, strict=True)
    for number, (script, judgement) in enumerate(pairs, 1):
        assert f"{number}{script.score:.4f}{judgement.mean:.4f}" in reader.text
    (page,) = PLAYER.findall(data["text/html"])
    assert unescape(page) in Reader(bundle(friend.script)["text/html"]).elements[2][1].values()


def test_a_number_shows_itself(friend: Result) -> None:
    assert bundle(friend.script.ask("T")) == {"text/plain": "6"}


def test_a_belief_at_one_moment_is_a_small_table(friend: Result) -> None:
    answer = friend.script.ask("P(G_cat | script[:0])", assume="nothing")
    data = bundle(answer)
    reader = Reader(data["text/html"])
    cells = re.findall(r"<t[dh]>([^<]*)</t[dh]>", data["text/html"])
    assert cells[:2] == ["G_cat", "probability"]
    assert cells[2::2] == ["crumbs", "hole", "none", "unknown"]
    numbers = [float(cell) for cell in cells[3::2]]
    assert sum(numbers) == pytest.approx(1, abs=2e-4)
    assert "image/png" not in data
    assert not [attrs for _, attrs in reader.elements if attrs]  # the theme's own colours


@pytest.mark.parametrize(
    "expression",
    [
        "P(rho > 0 | script[:t])",
        "P(rho | script[:t])",
        "surprise(script[t])",
        "log([moved(cat) @ script[t]])",
    ],
)
def test_what_goes_on_over_time_is_a_curve(friend: Result, expression: str) -> None:
    data, about = friend.script.ask(expression)._repr_mimebundle_()
    assert sorted(data) == ["image/png", "text/plain"]
    drawn = picture(data["image/png"])
    assert about["image/png"]["width"] * 1.4 < drawn.size[0] < about["image/png"]["width"] * 1.7
    pixels = np.asarray(drawn.convert("RGB"))
    inked = (pixels.max(axis=-1) - pixels.min(axis=-1)) > 60  # coloured
    assert inked.any()
    assert len(data["text/plain"].splitlines()) >= friend.script.length


def test_a_curve_that_begins_at_frame_1_is_not_drawn_at_the_start(friend: Result) -> None:
    """The same numbers, once from frame 0 on: the pictures differ."""
    late = friend.script.ask("surprise(script[t])")
    assert late.t == [1, 2, 3, 4, 5, 6]
    values = np.concatenate([[0.0], late.value])
    whole = Answer([0, *late.t], values, None, None, late.expression)
    assert bundle(late)["image/png"] != bundle(whole)["image/png"]


def test_long_answers_are_cut_in_words(hill: Script) -> None:
    many = Answer(list(range(801)), np.linspace(0, 1, 801), None, None, "t")
    lines = bundle(many)["text/plain"].splitlines()
    assert len(lines) == 31
    assert lines[15].strip() == "… 771 more"
    assert lines[-1].split() == ["800", "1"]


def test_places_are_moved_only_in_their_own_source() -> None:
    from i2pdsl.errors import Diagnostic, Note, Span

    here, there = Source("a", "xy\nzz"), Source("b", "zz")
    told = Diagnostic("c", "m", Span(here, 3, 5), notes=(Note("n", Span(there, 0, 2)),))
    moved = placed(told, "a", "head\nxy\nzz", 5)
    assert moved.span.text == "zz"
    assert moved.span.source.position(moved.span.start) == (3, 1)
    assert moved.notes[0].span.source is there


def test_short_names_in_plain_python(friend: Result) -> None:
    assert re.fullmatch(r"<Script friend: world maze, 6 frames, score [\d.]+>", repr(friend.script))
    assert repr(friend).startswith("<Result: 3 found, the best <Script friend:")


# In Chromium.

THEMES = {"light": "background:#fff;color:#000", "dark": "background:#111;color:#ddd"}


@pytest.mark.browser
@pytest.mark.parametrize("theme", THEMES)
def test_the_player_plays_inside_its_frame(friend: Result, open_page: Any, theme: str) -> None:
    body = f"<!doctype html><body style='{THEMES[theme]}'>{bundle(friend)['text/html']}</body>"
    page = open_page(body, width=1000, height=900, color_scheme=theme)
    inner = page.frames[1]
    inner.wait_for_selector("#play")
    inner.locator("#scrubber").press("Home")  # it plays by itself, unless motion is to be reduced
    assert inner.locator("#counter").text_content() == "0 / 6"
    before = inner.locator("[data-actor=cat]").first.get_attribute("transform")
    inner.locator("#forward").click()
    inner.locator("#forward").click()
    assert inner.locator("#counter").text_content() == "2 / 6"
    after = inner.locator("[data-actor=cat]").first.get_attribute("transform")
    states = friend.script.record.frames
    if states[1]["state"]["cat"] != friend.script.record.start["cat"]:
        assert after != before
    # The frame is as large as said, covers the comic, and cannot reach the notebook around it.
    box, comic = (page.locator(tag).bounding_box() for tag in ("iframe", "img"))
    assert box["height"] == 760
    assert box["y"] <= comic["y"]
    assert box["y"] + box["height"] >= comic["y"] + comic["height"]
    reach = "() => { try { return parent.document.title } catch { return null } }"
    assert inner.evaluate(reach) is None
    # The film is in sight without scrolling.
    stage = inner.locator("#stage").bounding_box()
    controls = inner.locator("#play").bounding_box()
    assert controls["y"] + controls["height"] <= box["y"] + 760
    assert stage["height"] > 250


@pytest.mark.browser
def test_without_frames_the_comic_is_seen(friend: Result, open_page: Any) -> None:
    html = re.sub(r"<iframe.*</iframe>", "", bundle(friend.script)["text/html"], flags=re.DOTALL)
    page = open_page(f"<!doctype html><body>{html}</body>", width=1000, height=900)
    comic = page.locator("img").bounding_box()
    assert comic["width"] > 500
    assert page.evaluate("() => document.querySelector('img').naturalWidth") > 500
