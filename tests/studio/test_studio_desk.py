"""The studio as its users have it: they write, draw, drag, undo, lose the server, go on."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Any

import pytest

from render.test_page import CONTRAST
from studio.conftest import Desk
from studio_for_tests import BRIEF, SEARCH, Served

pytestmark = pytest.mark.browser


def test_from_an_empty_folder_to_a_film(desk: Any, served: Served) -> None:
    (served.folder / "help.story").unlink()
    page = desk(path=None).page
    page.get_by_label("Name", exact=True).fill("mine")
    page.get_by_label("World", exact=True).select_option("small")
    page.get_by_role("button", name="Begin").click()
    page.locator("#desk.has-film").wait_for()
    assert (served.folder / "mine.story").is_file()
    assert page.locator("#title").text_content() == "mine"
    assert page.locator('#stage [data-actor="robot"]').is_visible()
    (served.folder / "mine.story").unlink()


def test_what_is_pressed_is_opened_though_the_folder_changes(desk: Any, served: Served) -> None:
    """A list that is shown anew while somebody presses a button in it would take the click."""
    shown: Desk = desk(path=None)
    page, heard = shown.page, list[str]()
    hear = lambda told: heard.append(str(told))
    page.on("websocket", lambda socket: socket.on("framereceived", hear))
    page.reload()
    page.get_by_label("Name", exact=True).wait_for()
    page.locator('[data-path="help.story"]').hover()
    page.mouse.down()
    (served.folder / "new.story").write_text(BRIEF)
    while not any('"files"' in told and "new.story" in told for told in heard):
        page.wait_for_timeout(50)
    page.wait_for_timeout(100)  # what was heard is done
    page.mouse.up()
    shown.solved()
    assert page.locator("#title").text_content() == "help"
    page.locator("#open-files").click()
    page.locator('[data-path="new.story"]').wait_for()
    (served.folder / "new.story").unlink()


def test_who_is_dragged_is_pinned_and_the_film_solved_around_it(desk: Any) -> None:
    shown: Desk = desk()
    shown.seek(3)
    start = shown.place("robot")
    shown.page.mouse.move(*start)
    shown.page.mouse.down()
    spots = shown.spots()
    place, target = max(spots.items(), key=lambda spot: abs(spot[1][0] - start[0]))
    shown.page.mouse.move(*target, steps=6)
    shown.page.mouse.up()
    shown.says(rf"pin script\[3\].*at\(robot, {re.escape(place)}\)")
    shown.solved()
    assert abs(shown.place("robot")[0] - target[0]) < 12
    assert shown.page.get_by_role("button", name=re.compile("Pin in frame 3")).is_visible()
    shown.page.keyboard.press("Control+z")  # one drag is one step
    shown.says(f"^{re.escape(BRIEF)}$")
    shown.solved()
    assert shown.page.get_by_role("button", name=re.compile("Pin in frame")).count() == 0


def test_a_pin_is_dragged_along_time_and_away(desk: Any) -> None:
    shown: Desk = desk()
    shown.write(BRIEF + "pin script[2]: at(robot, (1, 0))\n")
    shown.solved()
    pin = shown.page.get_by_role("button", name=re.compile("Pin in frame 2"))
    pin.press("ArrowRight")
    shown.says(r"pin script\[3\]: at\(robot")
    shown.solved()
    box = shown.page.get_by_role("button", name=re.compile("Pin in frame 3")).bounding_box()
    centre = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    shown.drag(centre, (centre[0], centre[1] + 80))
    shown.says("^(?![^]*pin script)")


def test_places_are_chosen_with_the_keyboard(desk: Any) -> None:
    shown: Desk = desk()
    shown.seek(2)
    shown.page.get_by_role("button", name="robot", exact=True).press("Enter")
    shown.spots()
    shown.page.keyboard.press("ArrowLeft")
    shown.page.keyboard.press("Enter")
    shown.says(r"pin script\[2\].*at\(robot, ")


def test_the_first_picture_is_where_somebody_is_dragged(desk: Any) -> None:
    shown: Desk = desk()
    shown.seek(0)
    start = shown.place("robot")
    shown.page.mouse.move(*start)
    shown.page.mouse.down()
    spots = shown.spots()
    place, target = max(spots.items(), key=lambda spot: abs(spot[1][1] - start[1]))
    shown.page.mouse.move(*target, steps=6)
    shown.page.mouse.up()
    shown.says(rf"start .*at\(robot, {re.escape(place)}\)")
    shown.solved()
    assert shown.place("robot") == pytest.approx(target, abs=25)


def test_a_drawn_curve_is_in_the_text_and_the_measured_one_follows(desk: Any) -> None:
    shown: Desk = desk()
    shown.write(f"world small\nlength 6\nmaximize 0.1 * depict(G_cheese = pink)\n{SEARCH}")
    shown.solved()
    card = shown.page.locator(".arc")
    names = card.locator("option").all_inner_texts()
    assert "rho > 0" in names
    card.locator("select").select_option(label="rho > 0")
    plot = card.locator(".plot")
    plot.locator(".measured").wait_for(state="attached")
    shown.drag(on_plot(card, 0, 0.4), on_plot(card, 0.5, 0.05), on_plot(card, 1, 0.02))
    shown.says(r"points\(\(0, 0\.\d+\).*\(1, 0(\.0\d*)?\)\)")
    shown.solved()
    for _ in range(100):  # viewers believe it less and less, as was drawn
        if max(float(v) for v in curve(card)[3:]) < 0.3:
            break
        shown.page.wait_for_timeout(100)
    else:
        pytest.fail(f"the measured curve stays where it was: {curve(card)}")
    shown.page.locator(".handle").last.focus()
    for _ in range(8):
        shown.page.keyboard.press("ArrowUp")
    shown.says(r"points\(.*\(1, 0\.2\d*\)\)")


def test_a_finger_draws_and_drags_on_a_phone(desk: Any) -> None:
    shown: Desk = desk(width=400, height=800, has_touch=True, is_mobile=True)
    session = shown.page.context.new_cdp_session(shown.page)

    def finger(*ways: tuple[float, float]) -> None:
        touch = lambda kind, points: session.send(
            "Input.dispatchTouchEvent",
            {"type": kind, "touchPoints": [{"x": x, "y": y} for x, y in points]},
        )
        touch("touchStart", ways[:1])
        for (x0, y0), (x1, y1) in pairwise(ways):
            for step in range(1, 9):
                touch("touchMove", [(x0 + (x1 - x0) * step / 8, y0 + (y1 - y0) * step / 8)])
        touch("touchEnd", [])

    shown.seek(3)
    start = shown.place("robot")
    box = shown.box("#stage svg")
    finger(start, (box["x"] + 0.75 * box["width"], box["y"] + 0.75 * box["height"]))
    shown.says(r"pin script\[3\]: at\(robot, \(2, 2\)\)")
    card = shown.page.locator(".arc")
    card.scroll_into_view_if_needed()
    card.locator("select").select_option(label="rho > 0")
    finger(on_plot(card, 0.02, 0.9), on_plot(card, 0.5, 0.1), on_plot(card, 0.98, 0.05))
    shown.says(r"points\(")


def on_plot(card: Any, share: float, value: float) -> tuple[float, float]:
    """Where a share of the film and a probability are on the screen."""
    x, y = card.locator(".plot").evaluate(
        """(svg, [x, y]) => { const at = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
                              return [at.x, at.y]; }""",
        [30 + 204 * share, 106 - 96 * value],
    )
    return x, y


def curve(card: Any) -> list[str]:
    """Heights of the measured curve, as shares of the plot."""
    path = card.locator(".measured").get_attribute("d")
    return [f"{(106 - float(y)) / 96:.3f}" for y in re.findall(r"[ML][\d.]+ ([\d.]+)", path)]


def test_numbers_are_slid_and_one_slide_is_one_step(desk: Any) -> None:
    shown: Desk = desk()
    shown.page.locator("#text .number", has_text="6").first.hover()
    slider = shown.page.locator("#text .slide input").first
    slider.focus()
    for _ in range(3):
        shown.page.keyboard.press("ArrowRight")
    shown.says("length 9")
    shown.solved()
    assert shown.page.locator("#timeline .counter").inner_text().endswith("/ 9")
    for _ in range(3):
        shown.page.locator("#undo").click()
    shown.says("length 6")


def test_two_tabs_and_an_editor_outside(desk: Any, served: Served) -> None:
    file = served.folder / "help.story"
    one, other = desk(), desk()
    one.write(BRIEF + "# saved\n")
    one.page.keyboard.press("Control+s")
    other.says("# saved")  # it had no changes of its own
    other.write(BRIEF + "# mine\n")
    file.write_text(BRIEF + "# outside\n", encoding="utf-8")
    one.says("# outside")
    other.page.get_by_role("button", name="Show both").click()
    both = other.page.get_by_role("dialog", name="Two texts of one file")
    assert "# mine" in both.inner_text()
    assert "# outside" in both.inner_text()
    both.get_by_role("button", name="Keep mine").click()
    one.says("# mine")
    assert "# mine" in file.read_text(encoding="utf-8")


def test_what_was_typed_is_offered_again(desk: Any) -> None:
    shown: Desk = desk()
    shown.write(BRIEF + "# not saved\n")
    shown.page.wait_for_timeout(300)
    shown.page.once("dialog", lambda dialog: dialog.accept())
    shown.page.reload()
    shown.page.get_by_role("button", name="Bring it back").click()
    shown.says("# not saved")


def test_a_mistake_is_told_and_the_film_stays(desk: Any) -> None:
    shown: Desk = desk()
    shown.write(BRIEF.replace("length 6", "length    6"))
    shown.page.get_by_role("button", name="Tidy").click()
    shown.says("^length 6$|\nlength 6\n")
    shown.write(BRIEF.replace("rho", "rhoo"))
    shown.page.locator("#text .cm-lintRange-error").wait_for()
    assert "unknown name" in shown.page.locator("#state").inner_text()
    assert shown.page.locator('#stage [data-actor="robot"]').is_visible()


def test_other_films_play_side_by_side_and_one_is_chosen(desk: Any, served: Served) -> None:
    shown: Desk = desk()
    shown.page.get_by_role("tab", name="Others").click()
    films = shown.page.locator("#others .wall li")
    films.nth(2).wait_for()
    assert films.locator('[data-actor="robot"]').count() == films.count()  # each in its own root
    panels = [float(text.replace("−", "-")) for text in films.locator("b").all_inner_texts()[::2]]
    assert panels == sorted(panels, reverse=True)
    films.nth(1).locator(".pick").click()
    assert "chosen" in films.nth(1).get_attribute("class")
    films.nth(1).get_by_role("button", name="Go on from it").click()
    shown.says(r"pin script\[1")
    shown.page.keyboard.press("Control+z")
    shown.says("^(?![^]*pin script)")


def test_wishes_and_reasons_lead_to_their_frames(desk: Any) -> None:
    shown: Desk = desk()
    shown.page.get_by_role("tab", name="Wishes").click()
    wish = shown.page.locator("#wishes li", has_text="maximize depict(rho > 0)")
    wish.wait_for()
    assert "alone" in wish.inner_text()
    shown.page.get_by_role("tab", name="Why").click()
    shown.page.locator("#why nav button").first.wait_for()
    shown.page.locator("#why nav button").first.click()
    told = shown.page.locator("#why .reasons > li:visible")
    assert "→" in " ".join(told.all_inner_texts())
    assert shown.page.locator("#scrubber").input_value() != "0"


def test_patterns_are_found_by_words_and_wished_for(desk: Any) -> None:
    shown: Desk = desk()
    shown.page.get_by_role("tab", name="Patterns").click()
    shown.page.get_by_label("What it shall be like, in words").fill("a twist that surprises")
    name = shown.page.locator("strong", has_text=re.compile("^twist$"))
    pattern = shown.page.locator("#patterns li", has=name)
    pattern.locator("summary").click()
    pattern.get_by_role("button", name="Wish for it").click()
    shown.says(r"maximize twist\(")
    shown.page.locator("#undo").click()
    shown.says(f"^{re.escape(BRIEF)}$")


def test_beats_change_places_and_any_expression_is_drawn_over(desk: Any) -> None:
    shown: Desk = desk()
    beats = ("depict(rho > 0)", "depict(rho < 0)")
    shown.write(f"world small\nlength 6\nmaximize beats({', '.join(beats)})\n{SEARCH}")
    shown.solved()
    shown.page.get_by_role("button", name=re.compile("Beat 1")).press("ArrowRight")
    shown.says(re.escape(f"beats({', '.join(beats[::-1])})"))
    card = shown.page.locator(".arc")
    card.locator("select").select_option(label="an expression …")
    card.get_by_label("Expression to draw").fill("P(rho > 0 | script[:t]) / 2")
    card.get_by_label("Expression to draw").press("Enter")
    shown.page.wait_for_function("() => document.querySelector('.arc .measured').getAttribute('d')")
    assert max(float(v) for v in curve(card)) <= 0.5


def test_films_are_exported(desk: Any) -> None:
    shown: Desk = desk()
    shown.page.get_by_role("button", name="Export").click()
    dialog = shown.page.get_by_role("dialog", name="Export")
    dialog.locator("[value=mp4]").uncheck()
    dialog.locator("[value=timeline]").check()
    dialog.get_by_role("button", name="Make them").click()
    with shown.page.expect_download() as download:
        dialog.get_by_role("link").first.click()
    assert "robot" in download.value.path().read_text(encoding="utf-8")


def test_a_map_is_painted(desk: Any, served: Served) -> None:
    shown: Desk = desk(path=None)
    shown.page.locator('[data-path="small.world"]').click()
    screen = shown.page.locator("#world svg")
    screen.wait_for()
    shown.page.get_by_role("radio", name="floor").check(force=True)
    cell = screen.evaluate(
        """svg => { const at = new DOMPoint(50, 150).matrixTransform(svg.getScreenCTM());
                    return [at.x, at.y]; }"""
    )
    shown.page.mouse.click(*cell)
    shown.says(r"\n    \.\.G\n")
    shown.page.locator("#undo").click()
    shown.says(r"\n    #\.G\n")


def test_walls_attitudes_and_places_of_a_world_by_hand(desk: Any) -> None:
    shown: Desk = desk(path=None)
    page = shown.page
    page.locator('[data-path="small.world"]').click()
    screen = page.locator("#world svg").first
    screen.wait_for()

    def at(x: float, y: float) -> Any:
        page.locator(".film").evaluate("film => film.scrollTo(0, 0)")
        return screen.evaluate(
            """(svg, [x, y]) => { const at = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
                                  return [at.x, at.y]; }""",
            [x, y],
        )

    page.get_by_role("radio", name="edge wall").check(force=True)
    shown.drag(at(105, 40), at(105, 60))
    shown.says(r"\n    P\|\. \.\n")
    shown.solved()
    shown.drag(at(130, 195), at(270, 205))  # below two cells
    shown.says(r"\n    # \. G\n      - -\n")
    shown.solved()
    shown.drag(at(105, 40), at(105, 60))  # the first one goes again
    shown.says(r"\n    P \. \.\n")
    shown.solved()
    page.locator("details[data-name=robot] summary").click()
    attitude = page.get_by_label("robot: attitude")
    attitude.fill("{-1, 2}")
    attitude.press("Enter")
    shown.says(r"character robot[^]*attitude = \{-1, 2\}")
    shown.solved()
    goals = page.get_by_role("group", name="robot: goals")
    goals.get_by_role("button", name="green").click()
    shown.says(r"character robot[^]*goals = \{pink, none\}")
    shown.solved()
    page.locator("details[data-what=rewards] summary").click()
    page.get_by_label("rewards: move").fill("-2")
    page.get_by_label("rewards: move").press("Enter")
    shown.says(r"rewards\n[^]*move = -2")
    shown.solved()
    page.get_by_role("radio", name="table", exact=True).check(force=True)
    page.mouse.click(*at(150, 50))
    shown.says(r"object table\n[^]*cell = \(1, 0\)")
    shown.solved()
    for _ in range(7):
        page.locator("#undo").click()
    shown.says(r"\n    P\.\.\n    #\.G\n")
    shown.solved()


def test_contrast_and_names(desk: Any) -> None:
    shown: Desk = desk()
    shown.page.get_by_role("tab", name="Patterns").click()
    shown.page.locator("#patterns summary").first.click()
    for scheme in ("light", "dark"):
        shown.page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        shown.page.wait_for_timeout(300)
        found = shown.page.evaluate(CONTRAST)
        assert len(found) > 60
        for kind, what, ratio in found:
            assert ratio >= (4.5 if kind == "text" else 3), (
                f"{scheme}, {kind} {what!r}: {ratio:.2f}"
            )
    nameless = shown.page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, [role=slider]")]
            .filter(e => e.checkVisibility() && !(e.ariaLabel || e.innerText?.trim() || e.title
                || e.labels?.length)).map(e => e.outerHTML)"""
    )
    assert nameless == []


def test_stage_and_beliefs_are_in_sight_together(desk: Any) -> None:
    shown: Desk = desk(scheme="dark")
    for width, height in ((1440, 900), (1024, 768), (400, 800), (360, 640)):
        shown.page.set_viewport_size({"width": width, "height": height})
        shown.page.wait_for_timeout(100)
        for place in ("#stage svg", "#scrubber", "#curves .curve-card:visible"):
            box = shown.page.locator(place).first.bounding_box()
            assert box["y"] >= 0
            assert box["y"] + 40 < height
            assert box["x"] + min(box["width"], 60) <= width
        assert shown.page.evaluate("document.documentElement.scrollWidth") <= width
        assert shown.page.evaluate("document.documentElement.scrollHeight") <= height
        if width <= 400:  # all that is done to turns can be reached
            turns = shown.page.locator(".turns")
            assert turns.evaluate("node => node.scrollWidth - node.clientWidth") <= 1
