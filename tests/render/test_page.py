"""The page: whole and harmless as a text, and, in Chromium, a player that keeps to the script."""

import base64
import hashlib
import json
import re
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from i2pdsl.render.grid.choreography import choreograph
from i2pdsl.render.grid.film import lengths
from i2pdsl.render.grid.page import CELL, FOOT, frame_captions, page_html
from i2pdsl.render.grid.stage import Actor, Stage, Tile
from i2pdsl.render.grid.tracks import sample
from i2pdsl.render.mind import PALETTE, Mark, Panel, Series
from i2pdsl.render.reasons import Account, Asked, Change, Observation

KITCHEN = """\
...#...#...
.P.........
...#...#...
#.#######.#
...#...#...
.G.........
...#...#..."""
SOURCE = "world kitchen\nlength 10\n\nmaximize sum_t P(rho > 0 | script[:t])\n"


def kitchen(cheese="cheese"):
    return Stage(
        "kitchen",
        tuple(KITCHEN.split("\n")),
        (Tile("pink", (1, 1), "#e889ae"), Tile("green", (1, 5), "#7fbf7f")),
        (Actor(cheese, "cheese"), Actor("robot", "robot"), Actor("table", "table", "", "object")),
    )


def helping(cheese="cheese"):
    """A hand-written script of ten frames: the robot brings the cheese home, a table falls."""
    turns = [  # cheese's action, robot's action ('!' did not move), their cells, the table's
        ("west", "west", (5, 1), (7, 1), None),
        ("west!", "west", (5, 1), (6, 1), None),
        ("west!", "west", (4, 1), (5, 1), None),
        ("stay!", "west", (3, 1), (4, 1), None),
        (None, None, (3, 1), (4, 1), (9, 5)),
        ("west", "west", (2, 1), (3, 1), (9, 5)),
        ("west!", "west", (1, 1), (2, 1), (9, 5)),
        ("stay!", "north", (1, 1), (2, 0), (9, 5)),
        ("stay!", "north!", (1, 1), (2, 0), (9, 5)),
        ("stay!", "stay!", (1, 1), (2, 0), (9, 5)),
    ]
    frames = []
    for first, second, *cells in turns:
        names = (cheese, "robot", "table")
        state = {n: c and list(c) for n, c in zip(names, cells, strict=True)}
        if first is None:
            frames.append({"event": {"deus": "table", "to": [9, 5]}, "state": state})
            continue
        acts = {
            name: {"action": act.rstrip("!"), "moved": not act.endswith("!")}
            for name, act in ((cheese, first), ("robot", second))
        }
        frames.append({**acts, "event": None, "state": state})
    start = {cheese: [6, 1], "robot": [8, 1], "table": None}
    story = {"name": "help", "seed": 3}
    return {"story": story, "score": 27.1, "start": start, "frames": frames}


LAST = len(helping()["frames"])
PINK = np.linspace(0.5, 1.0, LAST + 1) ** 0.5


def five_panels():
    half = (1 - PINK) / 2
    return (
        Panel("The cheese's goal", "probability", curves(pink=PINK, green=1 - PINK)),
        Panel("The robot's goal", "probability", curves(pink=half, green=half, none=PINK)),
        Panel(
            "The robot's alignment",
            "probability",
            curves(hindering=half, indifferent=half, helping=PINK),
        ),
        Panel("Rationality", "probability", curves(cheese=PINK, robot=PINK**2)),
        Panel("Expected values", "value", curves(cheese=90 * PINK - 70, robot=300 * PINK), "value"),
    )


def curves(**values):
    return tuple(Series(name, value, PALETTE[name]) for name, value in values.items())


def account(text="robot means to help cheese", formal=""):
    """Reasons made up: in frame 2 two deeds, of which one changes something; in frame 5 an event;
    frames 6 to 9 as one; and nothing else."""
    rise = Change(text, 0.5, 0.9, f"9 times likelier if {text}", ("stay", 0.4, 0.0001))
    fall = Change(text, 0.9, 0.3, f"{text} < others", None, is_forgotten=True)
    return Account(
        (Asked(text, formal, 0.5, 0.3),),
        (
            Observation(2, 2, f"{text} goes", 0.25, ()),
            Observation(2, 2, "robot pushes cheese west", 0.0002, (rise,)),
            Observation(5, 5, "table falls", None, (), is_event=True),
            Observation(6, 9, "what is seen", None, (fall, rise)),
        ),
        ("likelier: `had it been`",),
    )


def page(title="A helping hand", source=SOURCE, cheese="cheese", panels=None, **more):
    stage, script = kitchen(cheese), helping(cheese)
    panels = five_panels() if panels is None else panels
    return page_html(stage, script, choreograph(stage, script), panels, title, source, **more)


# -------------------------------------------------------------------------------- as a text

VOID = {"meta", "input", "br", "hr", "img", "link"}


class Reader(HTMLParser):
    """Collects elements and checks that every one is closed in its turn."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.elements, self.texts = [], [], {}
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        assert len(dict(attrs)) == len(attrs), f"an attribute twice in <{tag}>"
        if tag not in VOID:
            self.open.append((tag, dict(attrs)))

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop()[0] == tag

    def handle_data(self, data):
        if self.open:
            tag, attrs = self.open[-1]
            key = attrs.get("id", tag)
            self.texts[key] = self.texts.get(key, "") + data


def film_data(text):
    return json.loads(Reader(text).texts["film-data"])


def test_page_is_well_formed_and_described():
    text = page()
    assert text.startswith("<!doctype html>")
    reader = Reader(text)
    tags = [tag for tag, _ in reader.elements]
    assert dict(reader.elements)["html"]["lang"] == "en"
    assert tags.count("h1") == tags.count("main") == tags.count("title") == 1
    assert reader.texts["title"] == reader.texts["h1"] == "A helping hand"
    assert reader.texts["code"] == SOURCE
    assert "kitchen · 10 frames · seed 3 · score 27.1" in text
    ids = [attrs["id"] for _, attrs in reader.elements if "id" in attrs]
    assert len(ids) == len(set(ids))


def test_page_is_the_same_every_time_and_small():
    assert page() == page()
    assert len(page().encode()) < 200_000


def test_nothing_comes_from_outside():
    text = page()
    for address in re.findall(r"(?:[a-z]+:)?//[\w.-]+\.[\w./-]+", text):
        assert address == "http://www.w3.org/2000/svg"
    assert "@import" not in text
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]*)\)", text))
    for tag, attrs in Reader(text).elements:
        assert tag not in ("link", "iframe", "img", "object", "embed", "base")
        assert not [name for name in attrs if name.startswith("on")]
        for name in ("href", "xlink:href", "src"):
            assert attrs.get(name, "#").startswith("#")


def test_only_the_player_may_run():
    reader = Reader(page())
    policy = next(a["content"] for t, a in reader.elements if t == "meta" and "http-equiv" in a)
    digest = base64.b64encode(hashlib.sha256(reader.texts["script"].encode()).digest()).decode()
    assert "default-src 'none'" in policy
    assert f"script-src 'sha256-{digest}'" in policy
    assert [a.get("type") for t, a in reader.elements if t == "script"] == [
        "application/json",
        None,
    ]


HOSTILE = [
    "</script><script>window.pwned = 1</script>",
    "</code></pre></title><!-- <script> --!> ]]>",
    "\"' onmouseover='window.pwned=1' \"><img src=x onerror=window.pwned=1>",
    "${title} $source $$ {{}} %s \\u003c &lt; &amp;",
    "芝士 🧀 \u2028\u2029 \u202e ﷽ e\u0301",
    "\x00\x07\x1b[31m \ud800 \r\n tab\there",
]


@pytest.mark.parametrize("text", HOSTILE)
def test_any_text_stays_text(text):
    odd = Panel(text, text, (Series(text, PINK, "#d9468f"), Series("b", PINK, "#00664a")))
    captions = [text] * (LAST + 1)
    more = {"captions": captions, "marks": [Mark(3, text)], "account": account(text)}
    written = page(text, text, text, [odd], **more)
    harmless = page("t", "s", panels=[five_panels()[0]], account=account("x"))
    reader, plain = Reader(written), Reader(harmless)
    # Not one element more than with harmless texts, but for the other poses and marks drawn.
    structure = [tag for tag, _ in reader.elements if tag not in ("path", "text", "g", "use")]
    assert structure == [t for t, _ in plain.elements if t not in ("path", "text", "g", "use")]
    data = json.loads(reader.texts["film-data"])
    assert data["captions"][3] == data["panels"][0]["title"] == data["actors"][0]["name"] == text
    written.encode("utf-8")
    if "\x00" not in text:
        assert reader.texts["code"] == text
        assert reader.texts["h1"] == text.strip()


def test_keyframes_and_beliefs_are_embedded_whole():
    stage, script = kitchen(), helping()
    film = choreograph(stage, script)
    data = film_data(page())
    for actor in data["actors"]:
        keys, track = actor["keys"], film.tracks[actor["name"]]
        assert len(keys) == len(track)
        assert {key[9] for key in keys} == set(actor["symbols"])
        for mine, theirs in zip(keys, track, strict=True):
            assert mine[:8] == pytest.approx(theirs[:8], abs=1e-5)
            assert mine[8:] == list(theirs[8:])
        text = page()
        assert all(f'id="{symbol}"' in text for symbol in actor["symbols"].values())
    assert data["panels"][0]["series"][0]["values"] == pytest.approx(PINK, rel=1e-5)
    assert data["last"] == LAST


def test_missing_values_are_null_and_leave_a_gap():
    values = PINK.copy()
    values[[0, 4]] = np.nan
    text = page(panels=[Panel("a", "b", (Series("c", values, "#d9468f"),))])
    assert [v is None for v in film_data(text)["panels"][0]["series"][0]["values"]] == [
        k in (0, 4) for k in range(LAST + 1)
    ]
    curve = re.search(r'class="curve"[^>]*><path d="([^"]*)"', text).group(1)
    assert curve.count("M") == 2


def test_captions_tell_every_frame():
    stage, script = kitchen(), helping()
    told = frame_captions(stage, script, choreograph(stage, script))
    assert len(told) == LAST + 1
    assert told[0] == "cheese at (6, 1), robot at (8, 1), table absent"
    assert told[3] == "cheese tries west and fails; robot pushes cheese west"
    assert "table falls" in told[5]
    for caption in told:
        assert caption in page()


def test_mistakes_are_said():
    with pytest.raises(ValueError, match="11 captions are needed"):
        page(captions=["only one"])
    short = Panel("short", "y", (Series("a", np.zeros(3), "#000000"),))
    with pytest.raises(ValueError, match="'short' covers 2 frames, not 10"):
        page(panels=[short])


def test_page_without_panels_and_with_strange_particulars():
    stage, script = kitchen(), {**helping(), "story": None, "score": float("nan")}
    text = page_html(stage, script, choreograph(stage, script), [], " ", "")
    assert Reader(text).texts["h1"] == "kitchen"
    assert "audience’s mind" not in text
    assert "nan" not in Reader(text).texts["p"].lower()


def test_player_stays_readable():
    folder = Path(__file__).parents[2] / "i2pdsl" / "render" / "page"
    assert len((folder / "player.js").read_text(encoding="utf-8").splitlines()) < 400


# ------------------------------------------------------------------------------ in a browser

browser_test = pytest.mark.browser


@pytest.fixture
def show(open_page):
    """Opens a page in Chromium: the text, or else the usual film's."""
    return lambda text=None, **settings: open_page(text or page(), **settings)


def scrub(shown, time):
    shown.locator("#scrubber").evaluate(
        "(s, t) => { s.value = t; s.dispatchEvent(new Event('input', {bubbles: true})); }", time
    )


def transform(shown, name="cheese"):
    return shown.locator(f'[data-actor="{name}"]').get_attribute("transform")


def numbers(text):
    return [float(x) for x in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", text)]


def cell_of(shown, name="cheese"):
    """The cell that an actor's foot stands on, as a pair of exact numbers."""
    x, y = numbers(transform(shown, name))[:2]
    return x / CELL - 0.5, y / CELL - FOOT


def frame_of(shown):
    return int(shown.locator("#counter").inner_text().split(" / ")[0])


def panel_numbers(shown, index):
    return shown.locator(".panel").nth(index).locator("li b").all_inner_texts()


@browser_test
def test_play_moves_and_space_stops(show):
    shown = show()
    still = transform(shown)
    shown.wait_for_timeout(150)
    assert transform(shown) == still  # reduced motion: nothing moves by itself
    shown.get_by_role("button", name="Play").click()
    shown.wait_for_function(
        "t => document.querySelector('[data-actor=cheese]').getAttribute('transform') !== t",
        arg=still,
    )
    shown.locator("h1").click()
    shown.keyboard.press("Space")
    shown.get_by_role("button", name="Play").wait_for()
    stopped = transform(shown)
    shown.wait_for_timeout(150)
    assert transform(shown) == stopped
    shown.keyboard.press("Space")
    shown.get_by_role("button", name="Pause").wait_for()


@browser_test
def test_plays_by_itself_to_the_end_and_again(show):
    quick = tuple(each / 4 for each in lengths(choreograph(kitchen(), helping())))
    shown = show(page(clock=quick), motion="no-preference")
    shown.get_by_role("button", name="Pause").wait_for()
    shown.get_by_role("radio", name="4×").check()
    shown.get_by_role("button", name="Play").wait_for()
    assert frame_of(shown) == LAST
    shown.get_by_role("button", name="Play").click()
    shown.wait_for_function(
        "n => document.querySelector('#counter').textContent !== `${n} / ${n}`", arg=LAST
    )


@browser_test
def test_frames_last_as_long_as_in_films(show):
    """Against a clock that is turned by hand, a twentieth of a second at a time."""
    seconds, rests = lengths(choreograph(kitchen(), helping()), twists={3: 1.0, 6: 0.5})
    shown = show(page(clock=(seconds, rests)))
    shown.evaluate(
        """() => {
            const due = [];
            let now = 0;
            performance.now = () => now;
            window.requestAnimationFrame = (each) => due.push(each);
            window.pass = () => {
                now += 50;
                for (const each of due.splice(0)) each(now);
                return Number(document.getElementById("scrubber").value);
            };
        }"""
    )
    shown.locator("#play").click()
    ends = np.cumsum(np.stack([seconds, rests], axis=1).ravel())
    count = int(ends[-1] / 0.05)
    seen = shown.evaluate("n => Array.from({ length: n }, window.pass)", count)
    expected = np.interp(
        0.05 * np.arange(1, count + 1), [0, *ends], [0, *np.repeat(np.arange(1, LAST + 1), 2)]
    )
    assert seen == pytest.approx(expected, abs=0.0051)  # the slider knows hundredths
    assert np.ptp(np.diff(expected)) > 0.03


@browser_test
def test_reasons_follow_the_film_and_lead_to_it(show):
    shown = show(page(account=account(formal="rho > 0")))
    reasons = shown.locator("#reasons > li")
    told = lambda: [each.inner_text() for each in reasons.all() if each.is_visible()]
    assert "0.500 robot means to help cheese rho > 0" in " ".join(told()[0].split())
    scrub(shown, 1)
    assert told() == []
    scrub(shown, 1.5)  # in the middle of frame 2
    (now,) = told()
    assert "robot pushes cheese west expected with < 0.001" in now
    assert "0.500 → 0.900" in now
    assert "9 times likelier if robot means to help cheese" in now
    assert "had it been “stay” (expected with 0.400): < 0.001" in now
    scrub(shown, 5)
    assert "table falls from which nobody learns" in told()[0]
    links = shown.get_by_role("navigation", name="What moved them most").get_by_role("button")
    assert [link.split("\n")[0] for link in links.all_inner_texts()] == ["frame 2", "frames 6 to 9"]
    links.nth(1).focus()
    shown.keyboard.press("Enter")
    assert frame_of(shown) == 9
    scrub(shown, 7)
    assert "forget faster" in told()[0]
    assert links.nth(1).get_attribute("aria-current") == "step"
    assert shown.locator(".why [aria-current]").count() == 1
    shown.get_by_role("button", name="frames 6 to 9", exact=True).press("Space")
    assert frame_of(shown) == 9


@browser_test
def test_without_scripts_all_reasons_are_told(show):
    shown = show(page(account=account()), java_script_enabled=False)
    assert all(each.is_visible() for each in shown.locator("#reasons > li").all())
    boxes = [each.bounding_box() for each in shown.locator("#reasons > li").all()]
    assert all(a["y"] + a["height"] <= b["y"] for a, b in pairwise(boxes))


@browser_test
def test_every_frame_shows_the_script_exactly(show):
    shown, script = show(), helping()
    states = [script["start"], *(frame["state"] for frame in script["frames"])]
    for k, state in enumerate(states):
        scrub(shown, k)
        assert frame_of(shown) == k
        assert shown.locator("#frame-number").inner_text() == (f"Frame {k}" if k else "Start")
        for name, cell in state.items():
            actor = shown.locator(f'[data-actor="{name}"]')
            if cell is None:
                assert actor.get_attribute("opacity") == "0"
            else:
                assert cell_of(shown, name) == pytest.approx(cell, abs=1e-9)
                assert actor.get_attribute("opacity") == "1"


@browser_test
def test_between_frames_the_player_interpolates_as_python_does(show):
    shown, film = show(), choreograph(kitchen(), helping())
    rng = np.random.default_rng(0)
    times = sorted(k + u for k in range(LAST) for u in rng.integers(16, 84, 4) / 100)
    for time, (actors, marks) in zip(times, shown.evaluate(DRAWN_AT, times), strict=True):
        assert {name for name, *_ in actors} == film.tracks.keys()
        for name, place, opacity, symbol in actors:
            key = sample(film.tracks[name], time)
            x, y, angle, scale_x, scale_y = numbers(place)[:5]
            expected = (key.x, key.y - key.lift, key.angle, key.scale_x, key.scale_y)
            actual = (x / CELL - 0.5, y / CELL - FOOT, angle / 360, scale_x, scale_y)
            assert actual == pytest.approx(expected, abs=2e-4)
            assert float(opacity) == pytest.approx(key.opacity, abs=1e-4)
            assert symbol == f"#{name}--{key.pose}"
        assert marks == [m.track[0].time < time < m.track[-1].time for m in film.marks]
        heights = [sample(film.tracks[name], time).y for name, *_ in actors]
        assert all(a <= b + 1e-6 for a, b in pairwise(heights))


# At each of some times the actors, in the order in which they are drawn, and which marks are seen.
DRAWN_AT = """times => times.map((time) => {
    const scrubber = document.getElementById("scrubber");
    scrubber.value = time;
    scrubber.dispatchEvent(new Event("input", { bubbles: true }));
    const told = (node) => [
        node.dataset.actor, ...["transform", "opacity", "href"].map((n) => node.getAttribute(n))];
    return [[...document.querySelectorAll("[data-actor]")].map(told),
            [...document.querySelectorAll("#marks > use")].map((u) => u.style.display !== "none")];
})"""


@browser_test
def test_step_buttons_and_keys(show):
    shown = show()
    forward, back = (shown.get_by_role("button", name=n) for n in ("Forward", "Back"))
    forward.click()
    forward.click()
    assert frame_of(shown) == 2
    back.click()
    assert frame_of(shown) == 1
    scrub(shown, 3.5)
    forward.click()
    assert cell_of(shown) == pytest.approx((3, 1))
    scrub(shown, 3.5)
    back.click()
    assert cell_of(shown) == pytest.approx((4, 1))
    shown.get_by_role("button", name="Restart").click()
    assert frame_of(shown) == 0
    back.click()
    assert frame_of(shown) == 0
    presses = [("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("End", LAST), ("Home", 0)]
    for where in ("h1", "#scrubber", ".plot >> nth=1"):
        shown.locator(where).focus() if where != "h1" else shown.locator("h1").click()
        for key, frame in presses:
            shown.keyboard.press(key)
            assert frame_of(shown) == frame
    shown.locator("#scrubber").focus()
    for key, frame in [("ArrowUp", 1), ("PageUp", 6), ("PageUp", LAST), ("ArrowDown", LAST - 1)]:
        shown.keyboard.press(key)
        assert frame_of(shown) == frame


@browser_test
def test_speed_by_key_and_by_choice(show):
    shown = show()
    chosen = lambda: shown.locator("[name=speed]:checked").get_attribute("value")
    assert chosen() == "1"
    for key, speed in [("+", "2"), ("+", "4"), ("+", "4"), ("-", "2"), ("-", "1"), ("-", "0.5")]:
        shown.keyboard.press(key)
        assert chosen() == speed
    shown.get_by_role("radio", name="4×").focus()
    shown.keyboard.press("ArrowLeft")  # a radio group's own key: no step of the film
    assert chosen() == "2"
    assert frame_of(shown) == 0


@browser_test
def test_space_on_a_button_presses_that_button(show):
    shown = show()
    shown.locator("#forward").focus()
    shown.keyboard.press("Space")
    assert frame_of(shown) == 1
    assert shown.locator("#play").get_attribute("aria-label") == "Play"


@browser_test
def test_pointing_shows_values_and_pressing_goes_there(show):
    shown = show()
    scrub(shown, 2)
    plot = shown.locator(".plot").first
    box = plot.bounding_box()
    place = lambda k: (box["width"] * (30 + 164 * k / LAST) / 200, box["height"] / 2)
    x, y = place(7)
    plot.hover(position={"x": x, "y": y})
    tip = shown.locator("#tip")
    assert tip.is_visible()
    expected = [f"{PINK[7]:.3f}", f"{1 - PINK[7]:.3f}"]
    assert re.split(r"\s+", tip.inner_text()) == [
        *f"frame 7 of {LAST} pink {expected[0]} green {expected[1]}".split()
    ]
    assert panel_numbers(shown, 0) == expected
    assert panel_numbers(shown, 3)[0] == expected[0]  # all panels tell of the same moment
    assert frame_of(shown) == 2
    plot.click(position={"x": x, "y": y})
    assert frame_of(shown) == 7
    shown.mouse.move(5, 5)
    assert not tip.is_visible()
    line = shown.locator(".plot .now").first.get_attribute("transform")
    assert numbers(line)[0] == pytest.approx(30 + 164 * 7 / LAST)


@browser_test
def test_focus_shows_values_and_they_are_spoken(show):
    shown = show()
    plot = shown.get_by_role("slider", name="The cheese's goal")
    plot.focus()
    for k in range(1, 4):
        shown.keyboard.press("ArrowRight")
        assert f"{PINK[k]:.3f}" in shown.locator("#tip").inner_text()
        assert plot.get_attribute("aria-valuenow") == str(k)
        assert f"pink {PINK[k]:.3f}" in plot.get_attribute("aria-valuetext")
    spoken = shown.locator("#live").text_content()
    assert spoken.startswith(f"frame 3 of {LAST}: cheese tries west and fails; robot pushes")
    assert f"The cheese's goal: pink {PINK[3]:.3f}" in spoken
    shown.locator("#play").focus()
    assert not shown.locator("#tip").is_visible()


@browser_test
def test_dragging_on_a_touch_screen_scrubs(show):
    shown = show(width=360, height=740, has_touch=True, is_mobile=True)
    plot = shown.locator(".plot").nth(1)
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    x = box["x"] + box["width"] * (30 + 164 * 4 / LAST) / 200
    shown.touchscreen.tap(x, box["y"] + box["height"] / 2)
    assert frame_of(shown) == 4


@browser_test
def test_list_of_happenings_follows_and_leads(show):
    shown = show()
    shown.get_by_text("What happens, frame by frame").click()
    lines = shown.locator("#happenings button")
    assert lines.count() == LAST + 1
    lines.nth(3).click()
    assert cell_of(shown) == pytest.approx((4, 1))
    assert lines.nth(3).get_attribute("aria-current") == "step"
    assert shown.locator("#happenings [aria-current]").count() == 1
    assert shown.locator("#caption").inner_text() in lines.nth(3).inner_text()


@browser_test
@pytest.mark.parametrize("width", [320, 390, 768, 1280, 2560])
@pytest.mark.parametrize("wild", [False, True])
def test_no_sideways_scrolling(show, width, wild):
    long = "unbreakable" * 40
    text = page(account=account())
    if wild:
        captions = [long] * (LAST + 1)
        text = page(long, f"let a = {long}", captions=captions, account=account(long))
    shown = show(text, width=width, height=740)
    for summary in shown.locator("summary").all():
        summary.click()
    shown.locator(".plot").last.focus()
    assert shown.evaluate("document.documentElement.scrollWidth") <= width
    outside = shown.evaluate(
        """w => [...document.querySelectorAll("button, input, fieldset, .plot, summary, #tip")]
            .filter(e => e.getBoundingClientRect().right > w + 0.5).map(e => e.outerHTML)""",
        width,
    )
    assert outside == []


@browser_test
@pytest.mark.parametrize("index", range(len(HOSTILE)))
def test_hostile_texts_do_nothing(show, index):
    text = HOSTILE[index]
    odd = Panel(text, text, (Series(text, PINK, "#d9468f"), Series("b", PINK, "#00664a")))
    more = {"captions": [text] * (LAST + 1), "marks": [Mark(3, text)], "account": account(text)}
    shown = show(page(text, text, text, [odd], **more))
    scrub(shown, 3)
    shown.locator(".plot").focus()
    assert cell_of(shown, "robot") == pytest.approx((5, 1))
    assert shown.evaluate("window.pwned") is None
    assert shown.locator("#tip strong").inner_text() == f"frame 3 of {LAST}"


# ---------------------------------------------------------------------------- accessibility


@browser_test
def test_everything_that_acts_has_a_name(show):
    shown = show(page(account=account()))
    for summary in shown.locator("summary").all():
        summary.click()
    session = shown.context.new_cdp_session(shown)
    nodes = session.send("Accessibility.getFullAXTree")["nodes"]
    seen = {}
    for node in nodes:
        role = node.get("role", {}).get("value", "")
        if not node.get("ignored"):
            seen.setdefault(role, []).append(node.get("name", {}).get("value", "").strip())
    for role in ("button", "slider", "radio", "image", "DisclosureTriangle", "heading", "region"):
        assert seen.get(role), f"no {role} on the page"
        assert all(seen[role]), f"a {role} without a name: {seen[role]}"
    assert len(seen["slider"]) == 6
    assert len(seen["radio"]) == 4
    assert set(seen["button"]) >= {"Restart", "Back one frame", "Play", "Forward one frame"}
    assert seen["image"] == ["A helping hand: the film"]
    levels = shown.locator("h1, h2, h3").evaluate_all("hs => hs.map(h => Number(h.tagName[1]))")
    assert levels[0] == 1
    assert all(b - a <= 1 for a, b in pairwise(levels))


@browser_test
def test_focus_goes_in_order_and_is_seen(show):
    shown = show()
    order = []
    for _ in range(13):
        shown.keyboard.press("Tab")
        order.append(
            shown.evaluate(
                """() => {
                    const e = document.activeElement;
                    const drawn = e.type === "radio" ? e.nextElementSibling : e;
                    const style = getComputedStyle(drawn);
                    const outline = style.outlineStyle !== "none" && parseFloat(style.outlineWidth);
                    return [e.id || e.name || e.className || e.tagName, outline >= 2];
                }"""
            )
        )
    assert all(seen for _, seen in order)
    names = [name for name, _ in order]
    assert names[:6] == ["restart", "back", "play", "forward", "scrubber", "speed"]
    assert names[6:11] == ["plot"] * 5
    assert names[11:13] == ["SUMMARY", "SUMMARY"]


CONTRAST = """() => {
    const canvas = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const rgba = (color) => {
        canvas.clearRect(0, 0, 1, 1);
        canvas.fillStyle = color;
        canvas.fillRect(0, 0, 1, 1);
        return [...canvas.getImageData(0, 0, 1, 1).data];
    };
    const behind = (node) => {
        for (let e = node; e; e = e.parentElement) {
            const color = rgba(getComputedStyle(e).backgroundColor);
            if (color[3] > 0) return color;
        }
        return [255, 255, 255, 255];
    };
    const light = ([r, g, b]) => {
        const f = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
        return 0.2126 * f(r / 255) + 0.7152 * f(g / 255) + 0.0722 * f(b / 255);
    };
    const ratio = (a, b) => {
        const [x, y] = [light(a), light(b)].sort((p, q) => p - q);
        return (y + 0.05) / (x + 0.05);
    };
    const found = [];
    const line = (e, what, color) => found.push(["line", what, ratio(rgba(color), behind(e))]);
    const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walk.nextNode()) {
        const e = walk.currentNode.parentElement;
        if (!walk.currentNode.data.trim() || e.closest("script, #stage, noscript")) continue;
        const style = getComputedStyle(e);
        const color = rgba(e.closest("svg") ? style.fill : style.color);
        found.push(["text", walk.currentNode.data.trim().slice(0, 30), ratio(color, behind(e))]);
    }
    for (const e of document.querySelectorAll(".curve path, .now line, .probe line, .event"))
        line(e, e.parentNode.className.baseVal, getComputedStyle(e).stroke);
    for (const e of document.querySelectorAll(".buttons svg"))
        line(e, e.parentNode.id, getComputedStyle(e).fill);
    for (const e of document.querySelectorAll("fieldset"))
        line(e, "speeds", getComputedStyle(e).borderTopColor);
    return found;
}"""


@browser_test
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_contrast_of_texts_and_lines(show, scheme):
    shown = show(page(account=account()), color_scheme=scheme)
    for summary in shown.locator("summary").all():
        summary.click()
    scrub(shown, 4)
    shown.locator(".plot").nth(2).hover()
    found = shown.evaluate(CONTRAST)
    assert len(found) > 100
    for kind, what, ratio in found:
        assert ratio >= (4.5 if kind == "text" else 3), f"{kind} {what!r}: {ratio:.2f}"


@browser_test
def test_without_scripts_the_start_and_the_words_are_there(show):
    shown = show(java_script_enabled=False)
    assert shown.locator('[data-actor="cheese"]').is_visible()
    assert shown.get_by_text("The film needs JavaScript to move").is_visible()
    assert shown.locator(".curve path").first.is_visible()


# ------------------------------------------------------------------------- for the eye

if __name__ == "__main__":  # python tests/render/test_page.py FILE: the sample page, to look at
    import sys

    Path(sys.argv[1]).write_text(page(), encoding="utf-8")
