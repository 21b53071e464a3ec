"""A studio in a process of its own, on a small world, and pages of it in Chromium."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from browser_for_tests import chromium  # noqa: F401
from studio_for_tests import BRIEF, Served, fill

POLLING = 50  # milliseconds; by default a page draws a picture for each look
LATE = """(() => {
  // Every third message is late in either direction, and all after it with it: by a seed.
  let seed = SEED;
  const draw = () => (seed = (seed * 1103515245 + 12345) % 2147483648) / 2147483648;
  const late = () => new Promise((done) => setTimeout(done, draw() < 0.33 ? 350 * draw() : 0));
  window.sockets = [];
  window.WebSocket = class extends WebSocket {
    #there = Promise.resolve();
    #back = Promise.resolve();
    constructor(...given) {
      super(...given);
      window.sockets.push(this);
    }
    send(text) {
      this.#there = this.#there.then(late).then(() => this.readyState === 1 && super.send(text));
    }
    addEventListener(kind, listener) {
      const heard = (event) => (this.#back = this.#back.then(late).then(() => listener(event)));
      super.addEventListener(kind, kind === "message" ? heard : listener);
    }
  };
})()"""


class Desk:
    """A page of the studio, as its user sees it."""

    def __init__(self, page: Any):
        self.page = page
        self.trouble: list[str] = []
        page.on("console", self._hear)
        page.on("pageerror", self._fail)

    def leave(self) -> None:
        """Hears no more of the page."""
        self.page.remove_listener("console", self._hear)
        self.page.remove_listener("pageerror", self._fail)

    def _fail(self, problem: Any) -> None:
        self.trouble.append(str(problem))

    def _hear(self, message: Any) -> None:
        # The picture that a test opens first has no icon, which browsers look for at any time.
        if not message.location["url"].endswith("/favicon.ico"):
            self.trouble.append(message.text)

    def open(self, address: str, path: str | None = "help.story") -> Desk:
        self.page.goto(address)
        if path is not None:
            self.page.locator(f'[data-path="{path}"]').click()
            self.solved()
        return self

    def text(self) -> str:
        """What the editor holds."""
        lines = self.page.locator("#text .cm-line").all_inner_texts()
        return "\n".join(line.replace("\n", "") for line in lines)

    def solved(self, milliseconds: int = 240_000) -> None:
        """Waits until the film on the stage is one of the text as it is."""
        self.page.wait_for_function(
            "() => { const { text, film } = document.getElementById('desk').dataset;"
            " return text !== undefined && text === film; }",
            timeout=milliseconds,
            polling=POLLING,
        )

    def solved_or_undone(self) -> None:
        """Takes back what was done last as long as the page says that it cannot be told: where
        somebody is let go may be a place for which the rest of the story leaves no way."""
        from playwright.sync_api import TimeoutError as Waited

        while True:
            try:
                return self.solved(60_000)
            except Waited:
                assert self.page.locator(".stale").count() == 1, "neither a film nor a reason"
                self.page.locator("#undo").click()

    def says(self, pattern: str) -> None:
        """Waits until the text matches a pattern."""
        self.page.wait_for_function(
            """pattern => new RegExp(pattern).test(
                [...document.querySelector("#text").shadowRoot.querySelectorAll(".cm-line")]
                    .map(line => line.textContent).join("\\n"))""",
            arg=pattern,
            polling=POLLING,
        )

    def write(self, text: str) -> None:
        """Types a text in place of all."""
        self.page.locator("#text .cm-content").click()
        self.page.keyboard.press("Control+a")
        self.page.keyboard.insert_text(text)

    def seek(self, frame: int) -> None:
        self.page.locator("#scrubber").fill(str(frame))

    def place(self, who: str) -> tuple[float, float]:
        """Where somebody is on the screen, in pixels."""
        box = self.box(f'#stage [data-actor="{who}"]')
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def box(self, selector: str) -> Any:
        """Where something is drawn, once it is: a film takes the place of another at any time."""
        for _ in range(100):
            if (box := self.page.locator(selector).bounding_box()) is not None:
                return box
            self.page.wait_for_timeout(50)
        raise AssertionError(f"{selector} is not drawn")

    def spots(self) -> dict[str, tuple[float, float]]:
        """The places that are lit up, and where they are on the screen."""
        self.page.locator("#stage .spot:not(.not)").first.wait_for()
        found = {}
        for spot in self.page.locator("#stage .spot:not(.not)").all():
            box = spot.bounding_box()
            place = spot.get_attribute("data-place")
            found[place] = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        return found

    def drag(self, start: tuple[float, float], *ways: tuple[float, float]) -> None:
        self.page.mouse.move(*start)
        self.page.mouse.down()
        for way in ways:
            self.page.mouse.move(*way, steps=5)
        self.page.mouse.up()


@pytest.fixture(scope="session")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """One studio for all tests of a worker: what it has compiled is at hand to all."""
    pytest.importorskip("starlette")
    studio = Served(fill(tmp_path_factory.mktemp("stories")))
    studio.start()
    yield studio
    studio.kill()


class Usual:
    """The context that pages of a module's tests share, and one page of it that is opened anew for
    each test: what a browser has once compiled it keeps."""

    def __init__(self, chromium: Any):  # noqa: F811
        self.context = chromium.new_context(reduced_motion="reduce")
        # A film may wait for what is compiled for pages that are gone, with half a core.
        self.context.set_default_timeout(240_000)
        self._rests: list[Any] = []

    def page(self) -> Any:
        return self._rests.pop() if self._rests else self.context.new_page()

    def take_back(self, pages: list[Any], empty: str) -> None:
        """Keeps one of a test's pages for the next test. `empty` is the address of something of the
        same origin: nothing that any of them remembers is there for another test."""
        for page in pages:
            page.mouse.move(0, 0)
            page.mouse.up()
            page.goto(empty)  # a page that is left keeps what was typed in it
        for page in pages[:1]:
            page.evaluate("() => [localStorage, sessionStorage].forEach(kept => kept.clear())")
            self._rests.append(page)
        for page in pages[1:]:
            page.close()


@pytest.fixture(scope="module")
def usual(chromium: Any) -> Iterator[Usual]:  # noqa: F811
    found = Usual(chromium)
    yield found
    found.context.close()


@pytest.fixture
def desk(chromium: Any, usual: Usual, served: Served) -> Iterator[Callable[..., Desk]]:  # noqa: F811
    """Opens pages of the studio, its story as it was; in the end nothing may have gone wrong."""
    fill(served.folder)
    (served.folder / "help.story").write_text(BRIEF, encoding="utf-8")
    desks: list[Desk] = []
    own: list[Any] = []

    def page_for(late: int | None, more: dict[str, Any]) -> Any:
        if late is not None or more:
            context = chromium.new_context(reduced_motion="reduce", **more)
            context.set_default_timeout(240_000)
            if late is not None:
                context.add_init_script(LATE.replace("SEED", str(late)))
            own.append(context)
        return own[-1].new_page() if own else usual.page()

    def opened(
        path: str | None = "help.story",
        width: int = 1280,
        height: int = 860,
        scheme: str = "light",
        late: int | None = None,
        **more: Any,
    ) -> Desk:
        page = page_for(late, more)
        page.set_viewport_size({"width": width, "height": height})
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        desk = Desk(page)
        desks.append(desk)
        return desk.open(served.address, path)

    yield opened
    for context in own:
        context.close()
    for desk in desks:
        desk.leave()
    pages = [desk.page for desk in desks if desk.page.context is usual.context]
    usual.take_back(pages, f"{served.address.partition('#')[0]}icon.svg")
    assert [trouble for desk in desks for trouble in desk.trouble] == []
