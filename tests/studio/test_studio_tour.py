"""The pictures of docs/studio.md, taken while the studio is used as the tour tells.

`python tests/studio/test_studio_tour.py` takes them anew.
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
if __name__ == "__main__":
    sys.path[:0] = [str(ROOT / "tests")]

from browser_for_tests import CHROMIUM, FLAGS  # noqa: E402
from studio.conftest import Desk  # noqa: E402
from studio_for_tests import Served  # noqa: E402

PICTURES = ROOT / "docs" / "pictures" / "studio"
NAMES = (
    *("desk", "drag", "pinned", "curve", "others", "wishes", "why", "patterns"),
    *("plane", "stretch", "world", "phone"),
)
WALK = "world meadow\nlength 60\n\nmaximize depict(G_wolf = approach)\nsearch naive\n"
PULL = "world hill\nlength 160\n\nmaximize depict(weight = 0.5)\nsearch naive\n"
STORIES = ROOT / "stories"


def tour(served: Served, browser: Any, save: Callable[[str, bytes], None]) -> None:
    """Walks through the studio and takes its pictures."""

    def opened(path: str, **settings: Any) -> Desk:
        context = browser.new_context(reduced_motion="reduce", **settings)
        context.set_default_timeout(120_000)
        return Desk(context.new_page()).open(served.address, path)

    def taken(name: str, of: str = "body") -> None:
        save(name, page.locator(of).screenshot())

    shown = opened("betrayal.story", viewport={"width": 1280, "height": 800})
    page = shown.page
    page.get_by_text("ready", exact=True).wait_for()
    shown.seek(9)
    taken("desk")

    shown.seek(4)
    start = shown.place("robot")
    page.mouse.move(*start)
    page.mouse.down()
    spots = shown.spots()
    page.mouse.move(*spots["(6, 4)"], steps=6)
    taken("drag", "div#stage")
    page.mouse.up()
    shown.says(r"pin script\[4\]: at\(robot, \(6, 4\)\)")
    shown.solved()
    taken("pinned", "#film")
    page.keyboard.press("Control+z")

    shown.write("world kitchen\nlength 15\nmaximize depict(G_cheese = pink)\n")
    shown.solved()
    plot = page.locator(".arc .plot")
    page.locator(".arc select").select_option(label="rho > 0")
    box = plot.bounding_box()
    at = lambda share, value: (
        box["x"] + box["width"] * (30 + 204 * share) / 240,
        box["y"] + box["height"] * (106 - 96 * value) / 128,
    )
    shown.drag(at(0, 0.4), at(0.4, 0.95), at(0.55, 0.9), at(0.8, 0.08), at(1, 0.05))
    shown.says("points")
    shown.solved()
    page.get_by_text("ready", exact=True).wait_for()
    taken("curve", "#curves .arc")

    shown = opened("betrayal.story", viewport={"width": 1280, "height": 1000})
    page = shown.page
    page.get_by_text("ready", exact=True).wait_for()
    page.get_by_role("tab", name="Others").click()
    page.locator("#others .wall li").nth(5).wait_for()
    taken("others", ".side")
    page.get_by_role("tab", name="Wishes").click()
    page.locator("#wishes li").first.wait_for()
    taken("wishes", "#wishes")
    page.get_by_role("tab", name="Why").click()
    page.locator("#why nav button").first.wait_for()
    shown.seek(9)
    taken("why", "#why")
    page.get_by_role("tab", name="Patterns").click()
    page.get_by_label("What it shall be like, in words").fill("seems to help, then hinders")
    page.wait_for_timeout(1000)
    page.locator("#patterns summary").first.click()
    taken("patterns", "#patterns")

    shown = opened("walk.story", viewport={"width": 1100, "height": 760})
    page = shown.page
    shown.seek(24)
    x, y = shown.place("wolf")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 90, y + 40, steps=6)
    page.locator("#stage .spot.room").wait_for(state="attached")
    page.mouse.move(x - 95, y + 45)
    page.wait_for_timeout(400)
    taken("plane", "div#stage")
    page.keyboard.press("Escape")
    page.mouse.up()

    shown = opened("pull.story", viewport={"width": 1100, "height": 900})
    page = shown.page
    shown.seek(90)
    page.get_by_role("button", name="Pin a stretch").click()
    page.get_by_label("Last frame").fill("130")
    page.get_by_label("What shall hold").select_option("taut(hopper)")
    page.wait_for_timeout(1000)
    taken("stretch", "#film")

    context = browser.new_context(viewport={"width": 1280, "height": 760}, reduced_motion="reduce")
    page = context.new_page()
    page.goto(served.address)
    page.locator('[data-path="mine.world"]').click()
    page.get_by_text("planned: stories").wait_for(timeout=120_000)
    box = page.locator("#world svg").bounding_box()
    page.mouse.move(box["x"] + 0.45 * box["width"], box["y"] + 0.75 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.62 * box["width"], box["y"] + 0.75 * box["height"], steps=6)
    taken("world")
    page.mouse.up()

    shown = opened("betrayal.story", viewport={"width": 400, "height": 800}, color_scheme="dark")
    page = shown.page
    shown.seek(9)
    taken("phone")


def small(png: bytes) -> bytes:
    """The same picture in 128 colours."""
    from PIL import Image

    smaller = io.BytesIO()
    with Image.open(io.BytesIO(png)) as image:
        flat = image.convert("RGB").quantize(128, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=0)
        flat.save(smaller, "PNG", optimize=True)
    return smaller.getvalue()


def taken_in(folder: Path, browser: Any, save: Callable[[str, bytes], None]) -> None:
    shutil.copy(STORIES / "kitchen" / "betrayal.story", folder)
    shutil.copy(STORIES / "worlds" / "maze.world", folder / "mine.world")
    (folder / "walk.story").write_text(WALK, encoding="utf-8")
    (folder / "pull.story").write_text(PULL, encoding="utf-8")
    served = Served(folder)
    served.start()
    try:
        tour(served, browser, save)
    finally:
        served.kill()


@pytest.mark.slow
@pytest.mark.browser
def test_the_tour_can_be_walked(tmp_path: Path, chromium: Any) -> None:
    pytest.importorskip("starlette")
    found: dict[str, bytes] = {}
    taken_in(tmp_path, chromium, found.__setitem__)
    assert tuple(found) == NAMES
    assert all((PICTURES / f"{name}.png").is_file() for name in NAMES)


if __name__ == "__main__":
    from playwright.sync_api import sync_playwright

    PICTURES.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as place:
        launched = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        taken_in(
            Path(place),
            launched,
            lambda name, png: (PICTURES / f"{name}.png").write_bytes(small(png)) and None,
        )
        launched.close()
