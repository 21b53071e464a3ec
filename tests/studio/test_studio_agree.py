"""Page, text and server agree in the end, whatever happens on the way: many edits at once, messages
that are late, connections that are lost, a server that is killed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from random import Random
from typing import Any

import pytest

from studio.conftest import Desk
from studio_for_tests import BRIEF, Served

pytestmark = pytest.mark.browser
MANY = pytest.param(200, marks=pytest.mark.slow)


@pytest.mark.parametrize("count", [6, MANY])
def test_page_and_text_agree_after_many_edits_during_solves(desk: Any, count: int) -> None:
    shown: Desk = desk()
    edit_at_random(shown, count, 0)
    agree(shown)


@pytest.mark.parametrize(("seed", "count"), [(1, 4), pytest.param(2, 150, marks=pytest.mark.slow)])
def test_they_agree_where_messages_are_late_and_connections_are_lost(
    desk: Any, seed: int, count: int
) -> None:
    shown: Desk = desk(late=seed)
    edit_at_random(shown, count, seed, ["lose"])
    agree(shown)


def edit_at_random(shown: Desk, count: int, seed: int, more: Sequence[str] = ()) -> None:
    """Does things one after the other, without waiting for a film."""
    random = Random(seed)
    page = shown.page
    for _ in range(count):
        what = random.choice(["type", "pin", "undo", "redo", "seek", "length", "play", *more])
        if what == "type":
            shown.write(BRIEF.replace("length 6", f"length {random.randint(4, 9)}"))
        elif what == "pin":
            shown.seek(random.randint(0, 4))
            x, y = shown.place("robot")
            box = shown.box("#stage svg")
            target = (
                box["x"] + random.random() * box["width"],
                box["y"] + random.random() * box["height"],
            )
            shown.drag((x, y), target)
        elif what == "seek":
            shown.seek(random.randint(0, 6))
        elif what == "play":
            page.locator("#timeline .main").click()
        elif what == "length":
            page.get_by_role("button", name="+ turn").click()
        elif what == "lose":
            page.evaluate("sockets.at(-1).readyState === 1 && sockets.at(-1).close()")
        else:
            button = page.locator(f"#{what}")
            if button.is_enabled():
                button.click()


def agree(shown: Desk) -> None:
    """Waits for the film of the text, and compares the two."""
    page = shown.page
    page.keyboard.press("Escape")
    page.wait_for_timeout(400)
    shown.solved_or_undone()
    told = re.search(r"^length (\d+)", shown.text(), re.MULTILINE)
    assert told is not None
    assert page.locator("#timeline .counter").inner_text().endswith(f"/ {told[1]}")
    pins = len(re.findall(r"^pin ", shown.text(), re.MULTILINE))
    assert (pins > 0) == (page.locator("#timeline .mark").count() > 0)


def test_who_is_only_pressed_keeps_no_film_waiting(desk: Any) -> None:
    shown: Desk = desk()
    shown.seek(2)
    shown.page.mouse.click(*shown.place("robot"))
    shown.spots()
    shown.write(BRIEF.replace("length 6", "length 8"))
    shown.solved()
    assert shown.page.locator("#timeline .counter").inner_text().endswith("/ 8")
    assert shown.page.locator("#stage .spot").count() == 0


def test_the_server_is_killed_and_the_page_goes_on(desk: Any, served: Served) -> None:
    shown: Desk = desk()
    shown.write(BRIEF.replace("length 6", "length 8"))
    shown.trouble.clear()
    served.kill()
    notice = shown.page.locator('[data-notice="lost"]')
    notice.wait_for()
    shown.write(BRIEF.replace("length 6", "length 9"))
    shown.page.keyboard.press("Control+s")
    shown.page.get_by_text("Not saved").wait_for()
    served.start()
    notice.wait_for(state="detached")
    shown.solved()
    assert "length 9" in shown.text()
    shown.page.keyboard.press("Control+s")
    shown.page.get_by_role("button", name="Saved").wait_for()
    assert "length 9" in (served.folder / "help.story").read_text(encoding="utf-8")
    assert all("WebSocket" in each for each in shown.trouble)  # that nobody answers
    shown.trouble.clear()
