"""The hill's page: a player that draws what Python draws."""

import json
import re
from html import unescape

import numpy as np
import pytest
from hill_performances import performance

from i2pdsl.render.hill.figures import LAYERS, muscle_color, rig
from i2pdsl.render.hill.page import alone, page_html
from i2pdsl.render.hill.pictures import compared
from i2pdsl.render.hill.rig import path_data, pose_vector
from i2pdsl.render.hill.scene import camera_way, pose_at
from i2pdsl.render.mind import Window

ONE = performance(windows=(Window(10, 20, "stumble & fall"),))
PAIR = (performance("long"), performance("short <b>", 20, 0.5))


def page(*performances):
    chosen = performances or (ONE,)
    panels = compared(chosen) if len(chosen) > 1 else chosen[0].panels
    return page_html(chosen, panels, "A title", ONE.windows)


def data_of(text):
    return json.loads(re.search(r'id="film-data">(.*?)</script>', text, re.S)[1])


def numbers(text):
    return [float(x) for x in re.findall(r"-?\d+(?:\.\d+)?", text)]


def scrub(shown, time):
    shown.locator("#scrubber").evaluate(
        "(s, t) => { s.value = t; s.dispatchEvent(new Event('input', {bubbles: true})); }", time
    )


def test_positions_are_kept_to_a_hundredth():
    text = page()
    recorded = data_of(text)["performances"][0]
    positions = np.cumsum(recorded["positions"], axis=1).T / 100
    assert abs(positions.reshape(-1, 2, 19) - ONE.positions).max() <= 0.005 + 1e-9
    assert len(json.dumps(recorded["positions"], separators=(",", ":"))) < 41 * 38 * 5


def test_the_page_tells_source_windows_and_captions():
    text = unescape(page())
    assert "story mime" in text
    assert "Shaded: frames 10 to 20, stumble & fall." in text
    assert text.count('class="window"') == 2
    assert "at frame 40 <so> & so" in text


def test_captions_that_change_all_the_time_are_told_now_and_then():
    assert 2 < page(performance(frames=90)).count("data-frame=") <= 16


def test_names_are_escaped_and_sources_told_once():
    text = page(*PAIR)
    assert "short &lt;b&gt;" in text
    assert "short <b>" not in re.sub(r"<script.*?</script>", "", text, flags=re.S)
    assert page(PAIR[0], PAIR[0]).count("story long") == 1


def test_a_film_alone_says_nothing_about_itself():
    mime = performance("the mime", windows=(Window(10, 20, "stumble"),))
    one, two = alone([mime, performance("heavy", 20)], places=2)
    text = json.dumps([one.stages, one.data])
    for word in ("stumble", "units up", "story long"):
        assert word not in text
    assert one.told == ()
    assert one.aspect == two.aspect, "both at one scale"
    first, second = one.stages
    assert first.replace('id="show-0"', 'id="show-1"') != second, "each place has its own crate"
    assert (len(one.seconds), len(two.seconds)) == (40, 20)


@pytest.mark.browser
@pytest.mark.parametrize("time", [0, 7, 12.4, 40])
def test_the_player_draws_the_poses_that_python_draws(open_page, time):
    shown = open_page(page())
    scrub(shown, time)
    positions, pull = pose_at(ONE, time)
    vector = pose_vector(positions, ONE.slope)
    parts = [part for layer in LAYERS for part in rig()[layer]]
    drawn = shown.locator(".cast path").evaluate_all(
        "ps => ps.map(p => [p.getAttribute('d'), getComputedStyle(p).stroke])"
    )
    assert len(drawn) == len(parts)
    for part, (path, stroke) in zip(parts, drawn, strict=True):
        wanted = path_data(part.shape, part.points @ vector)
        assert re.sub(r"[^A-Z]", "", path) == part.shape
        assert numbers(path) == pytest.approx(numbers(wanted), abs=0.35)
        if part.muscle is not None:
            color = muscle_color(pull[part.muscle])
            told = [int(color[i : i + 2], 16) for i in (1, 3, 5)]
            assert numbers(stroke) == pytest.approx(told, abs=2)
    x = 10 * np.interp(time, range(41), camera_way(ONE))
    moved = shown.locator(".layer > g").last.get_attribute("transform")
    assert numbers(moved) == pytest.approx([-x, x * np.tan(ONE.slope)], abs=0.1)


@pytest.mark.browser
def test_windows_are_signed_while_they_last(open_page):
    shown = open_page(page())
    sign = shown.locator(".window-sign")
    for time, seen in ((9, False), (10, True), (20, True), (20.5, False)):
        scrub(shown, time)
        assert sign.is_visible() == seen, time
    scrub(shown, 15)
    assert sign.inner_text() == "stumble & fall"


@pytest.mark.browser
def test_who_ends_early_rests_and_lanes_tell_the_way(open_page):
    shown = open_page(page(*PAIR))
    paths = "ps => ps.map(p => p.getAttribute('d')).join()"
    seen = {}
    for time in (20, 40):
        scrub(shown, time)
        seen[time] = [shown.locator(f"#show-{k} .cast path").evaluate_all(paths) for k in (0, 1)]
        told = shown.locator(".lanes b").all_inner_texts()
        ways = [p.distance[min(time, p.frames)] for p in PAIR]
        assert told == [f"{way:.0f} units".replace("-0", "0").replace("-", "−") for way in ways]
    assert seen[20][1] == seen[40][1]
    assert seen[20][0] != seen[40][0]


@pytest.mark.browser
@pytest.mark.parametrize("width", [360, 1280])
def test_nothing_sticks_out_of_the_page(open_page, width):
    for text in (page(), page(*PAIR)):
        shown = open_page(text, width=width, height=740)
        assert shown.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.browser
def test_the_player_plays_in_the_worlds_time(open_page):
    from playwright.sync_api import expect

    shown = open_page(page(), motion="no-preference")
    expect(shown.locator("#counter")).to_have_text("40 / 40")
    expect(shown.locator("#play")).to_have_attribute("aria-label", "Play")


@pytest.mark.browser
def test_without_scripts_the_start_is_shown(open_page):
    shown = open_page(page(), java_script_enabled=False)
    assert shown.locator(".cast path").first.get_attribute("d").startswith("M")
    assert shown.locator("#still").is_visible()
