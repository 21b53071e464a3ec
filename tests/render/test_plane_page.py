"""The plane's page: a player that draws what Python draws."""

import json
import re
import xml.etree.ElementTree as ET
from html import unescape

import numpy as np
import pytest
from plane_performances import DUET, performance, svg_document

from i2pdsl.render.mind import Window
from i2pdsl.render.performances import compared
from i2pdsl.render.plane.figures import face_moves, film_svg
from i2pdsl.render.plane.page import SHOWN, page_html
from i2pdsl.render.plane.stage import stage_within

SVG = "{http://www.w3.org/2000/svg}"
ODD = "</script><i> & \"x\" 'y'"
ONE = performance(spec=DUET, windows=(Window(10, 20, "stumble & fall"),))
PAIR = (performance("long"), performance("short <b>", 20))
STAGE = stage_within(DUET, *SHOWN)


def page(*performances, title="A title"):
    chosen = performances or (ONE,)
    panels = compared(chosen) if len(chosen) > 1 else chosen[0].panels
    return page_html(chosen, panels, title, ONE.windows)


def data_of(text):
    return json.loads(re.search(r'id="film-data">(.*?)</script>', text, re.S)[1])


def numbers(text):
    return [float(x) for x in re.findall(r"-?\d+(?:\.\d+)?", text)]


def scrub(shown, time):
    shown.locator("#scrubber").evaluate(
        "(s, t) => { s.value = t; s.dispatchEvent(new Event('input', {bubbles: true})); }", time
    )


def test_courses_are_kept_to_a_hundredth_of_a_pixel():
    cast = data_of(page())["performances"][0]["cast"]
    drawn = np.array([[who["x"], who["y"]] for who in cast]).transpose(2, 0, 1)
    assert drawn == pytest.approx(STAGE.view.pixels(ONE.positions), abs=0.0051)
    assert [who["dashed"] for who in cast] == [False, True]
    assert data_of(page())["seconds"] == pytest.approx([0.07] * 80)


def test_the_page_tells_source_windows_and_captions():
    text = unescape(page())
    assert "story legible" in text
    assert "Shaded: frames 10 to 20, stumble & fall." in text
    assert ONE.captions[80] in text
    assert "room · 80 frames" in text


def test_any_text_stays_text():
    odd = performance(ODD, spec=DUET, windows=(Window(1, 5, ODD),))
    for text in (page(odd, title=ODD), page(odd, odd, title=ODD)):
        assert text.count("</script>") == 2
        assert "<i>" not in text.split("</head>")[1]
        assert data_of(text)["performances"][0]["windows"] == [[1, 5, ODD]]
        assert re.search(r"script-src 'sha256-[\w+/]{43}='", text)


def test_captions_that_change_all_the_time_are_told_now_and_then():
    assert 2 < page(performance(frames=90)).count("data-frame=") <= 16


# ------------------------------------------------------------------------------------ in a browser


def drawn_by(shown, show=0):
    """The transforms of the cast with their faces and pupils, and the visible trails' paths."""
    figures = shown.locator(f"#show-{show} .figure").evaluate_all(
        "nodes => nodes.map(n => [n, n.querySelector('.face'), n.querySelector('.pupils')]"
        ".map(m => m.getAttribute('transform')))"
    )
    trails = shown.locator(f"#show-{show} .trail path[d]").evaluate_all(
        "nodes => nodes.map(n => [n.getAttribute('d'), n.getAttribute('stroke-width'),"
        " n.getAttribute('stroke-opacity')])"
    )
    return figures, trails


@pytest.mark.browser
@pytest.mark.parametrize("time", [0, 7, 33.4, 46.71, 80])
def test_the_player_draws_what_python_draws(open_page, time):
    shown = open_page(page())
    scrub(shown, time)
    figures, trails = drawn_by(shown)
    places, gazes = ONE.at(time)
    for drawn, place, gaze in zip(figures[-2:], STAGE.view.pixels(places), gazes, strict=True):
        assert numbers(drawn[0])[:2] == pytest.approx(place, abs=0.02)
        for move, expected in zip(drawn[1:], face_moves(gaze), strict=True):
            assert numbers(move) == pytest.approx(numbers(expected), abs=0.4)
    moving = ET.fromstring(svg_document(STAGE.view, film_svg(ONE, STAGE.view, time)))
    expected = [
        [p.get("d"), p.get("stroke-width"), p.get("stroke-opacity")]
        for p in moving.findall(f"./{SVG}path")
    ]
    # There: each one's way and then its trail; here: all ways, and then all trails.
    assert len(trails) == len(expected)
    for one, other in zip(sorted(trails), sorted(expected), strict=True):
        for mine, theirs in zip(one, other, strict=True):
            assert numbers(mine) == pytest.approx(numbers(theirs), abs=0.11)


@pytest.mark.browser
def test_windows_show_while_they_last_and_who_ends_early_rests(open_page):
    shown = open_page(page())
    for time, is_shown in ((9.5, False), (10, True), (15, True), (21, False)):
        scrub(shown, time)
        assert shown.locator(".window-sign").is_visible() == is_shown
    both = open_page(page(*PAIR))
    scrub(both, 20)
    then = drawn_by(both, 1)
    scrub(both, 60)
    assert drawn_by(both, 1) == then
    assert drawn_by(both, 0) != then
    assert both.locator(".signs .name").all_inner_texts() == ["long", "short <b>"]
