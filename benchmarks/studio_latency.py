"""How soon the studio answers: pages of it in headless Chromium, in the kitchen.

What is waited for is measured in the page: from the pointer's release to the picture of the first
film of the new text, with the times of the messages in between; beside it the CPU time of the
server, which a busy machine does not stretch. The kitchen should be planned (`i2p plan kitchen`).

    python benchmarks/studio_latency.py [start|pins|curves|typing|memory|size ...] [--count N]

Needs the extra `studio`, Playwright and a Chromium.
"""

from __future__ import annotations

import argparse
import gzip
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

STORY = """# The robot helps.
world kitchen
length 15

maximize depict(rho > 0)
"""
CLIENT = Path(__file__).parent.parent / "i2pdsl" / "studio" / "client"
RENDER = CLIENT.parent.parent / "render"
LONG = 240_000  # milliseconds that nothing here takes

# Notes down when each message went and came, and when the film of the present text was shown.
WATCHED = """(() => {
  const note = window.noted = [];
  const told = (text, way) => {
    const { method, id, params } = JSON.parse(text);
    note.push({ way, method, id, quality: params?.film?.quality, at: performance.now() });
  };
  window.WebSocket = class extends WebSocket {
    constructor(...given) {
      super(...given);
      this.addEventListener("message", ({ data }) => told(data, "in"));
    }
    send(text) {
      told(text, "out");
      super.send(text);
    }
  };
  addEventListener("pointerup", () => note.push({ way: "up", at: performance.now() }), true);
  addEventListener("DOMContentLoaded", () => {
    const desk = document.getElementById("desk");
    new MutationObserver(() => {
      const { text, film } = desk.dataset;
      const shown = () => note.push({ way: "shown", at: performance.now() });
      if (text === film) requestAnimationFrame(shown);
    }).observe(desk, { attributes: true, attributeFilter: ["data-film"] });
  });
})()"""


@dataclass
class Server:
    """`i2p studio` at work on a folder with one story in the kitchen."""

    folder: Path
    address: str = ""
    seconds: float = 0.0
    process: Any = field(default=None, repr=False)

    def start(self) -> None:
        began = time.perf_counter()
        command = [sys.executable, "-m", "i2pdsl", "studio", str(self.folder), "--no-browser"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().strip()
        self.seconds = time.perf_counter() - began

    def cpu(self) -> float:
        """Seconds of CPU time so far."""
        told = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(told[11]) + int(told[12])) / os.sysconf("SC_CLK_TCK")

    def memory(self) -> float:
        """MB that it holds."""
        pages = int(Path(f"/proc/{self.process.pid}/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") / 1e6

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()


@contextmanager
def serving() -> Iterator[Server]:
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "help.story").write_text(STORY, encoding="utf-8")
        server = Server(Path(folder))
        server.start()
        try:
            yield server
        finally:
            server.kill()


@contextmanager
def browsing() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    names = ("chromium", "chromium-browser", "google-chrome")
    path = next(filter(None, map(shutil.which, names)), None)
    with sync_playwright() as playwright:
        flags = ["--no-sandbox", "--disable-gpu", "--enable-precise-memory-info"]
        browser = playwright.chromium.launch(executable_path=path, args=flags)
        yield browser
        browser.close()


class Desk:
    """A page of the studio with the story open."""

    def __init__(self, browser: Any, server: Server):
        self.page = browser.new_page(viewport={"width": 1280, "height": 860})
        self.page.set_default_timeout(LONG)
        self.page.add_init_script(WATCHED)
        self.server = server

    def open(self) -> Desk:
        self.page.goto(self.server.address)
        self.page.locator('[data-path="help.story"]').click()
        self.solved()
        return self

    def solved(self, best: bool = False) -> None:
        """Waits for a film of the present text, or for the last one of it."""
        self.page.wait_for_function(
            "(best) => { const { text, film } = document.getElementById('desk').dataset;"
            " return text !== undefined && text === film"
            " && (!best || /^ready/.test(document.getElementById('state').textContent)); }",
            arg=best,
        )

    def quiet(self) -> None:
        """Waits until the server has nothing more to do."""
        self.solved(best=True)
        calm = 0
        while calm < 2:  # idle work begins a moment after all else
            before = self.server.cpu()
            self.page.wait_for_timeout(700)
            calm = calm + 1 if self.server.cpu() - before < 0.1 else 0

    def box(self, selector: str) -> Any:
        for _ in range(200):
            if (box := self.page.locator(selector).first.bounding_box()) is not None:
                return box
            self.page.wait_for_timeout(20)
        raise RuntimeError(f"{selector} is not drawn")

    def centre(self, selector: str) -> tuple[float, float]:
        box = self.box(selector)
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def noted(self) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self.page.evaluate("noted.splice(0)")
        return found


def table(title: str, rows: dict[str, list[float]], unit: str = "ms") -> None:
    print(f"\n{title}\n\n| | median | worst | least | of |\n|---|---|---|---|---|")
    for name, values in rows.items():
        if values:
            told = [statistics.median(values), max(values), min(values)]
            figures = " | ".join(
                f"{value:.3g}" if value < 100 else f"{value:.0f}" for value in told
            )
            print(f"| {name}, {unit} | {figures} | {len(values)} |")


# Start.


def start(count: int) -> None:
    """From the command to a page in which one can write, and to its first film."""
    rows: dict[str, list[float]] = {}
    note = lambda name, value: rows.setdefault(name, []).append(value)
    with browsing() as browser:
        for _ in range(min(count, 5)):
            with serving() as server:
                note("address", 1000 * server.seconds)
                desk = Desk(browser, server)
                began = time.perf_counter()
                desk.page.goto(server.address)
                desk.page.locator('[data-path="help.story"]').wait_for()
                note("address to gallery", 1000 * (time.perf_counter() - began))
                desk.page.locator('[data-path="help.story"]').click()
                desk.page.locator("#text .cm-content", has_text="maximize").wait_for()
                usable = time.perf_counter() - began + server.seconds
                note("command to usable page", 1000 * usable)
                note("server's CPU until then", 1000 * server.cpu())
                desk.solved()
                note("command to first film", 1000 * (time.perf_counter() - began + server.seconds))
                note("server's CPU until then, film", 1000 * server.cpu())
                desk.page.close()
    table("Start", rows)


# By hand.


def stages(noted: list[dict[str, Any]], method: str) -> dict[str, float] | None:
    """Milliseconds from the release to each stage that followed; None where no film followed."""
    up = next((n["at"] for n in noted if n["way"] == "up"), None)
    if up is None:
        return None
    after = [n for n in noted if n["at"] >= up]
    asked = next((n for n in after if n["way"] == "out" and n["method"] == method), None)
    if asked is None:
        return None
    first = lambda wanted: next((n["at"] - up for n in after if wanted(n)), None)
    found: dict[str, Any] = {
        "edits come back": first(lambda n: n["way"] == "in" and n["id"] == asked["id"]),
        "story is read": first(lambda n: n["way"] == "in" and n["method"] == "i2p/story"),
        "film comes": first(lambda n: n["way"] == "in" and n["method"] == "i2p/film"),
    }
    if None in found.values():
        return None
    came = up + found["film comes"]
    found["film is shown"] = first(lambda n: n["way"] == "shown" and n["at"] > came)
    return None if found["film is shown"] is None else found


def measured(
    desk: Desk, count: int, method: str, once: Callable[[Random], None], title: str
) -> None:
    random = Random(0)
    rows: dict[str, list[float]] = {}
    tries = 0
    while len(rows.get("film is shown", [])) < count and tries < 2 * count:
        tries += 1
        desk.quiet()
        desk.noted()
        spent = desk.server.cpu()
        once(random)
        desk.page.wait_for_timeout(60)
        if desk.page.locator("#stage .spot").count() > 0:
            desk.page.keyboard.press("Escape")  # let go where it was: it still looks for a place
        desk.solved()
        desk.page.wait_for_timeout(30)
        cpu = desk.server.cpu() - spent
        found = stages(desk.noted(), method)
        if found is not None:
            for name, value in found.items():
                rows.setdefault(name, []).append(value)
            rows.setdefault("server's CPU until then", []).append(1000 * cpu)
    table(title, rows)


def pins(count: int) -> None:
    """From letting go of somebody to the first film around the pin."""
    with serving() as server, browsing() as browser:
        desk = Desk(browser, server).open()

        def once(random: Random) -> None:
            if random.random() < 0.3 and desk.page.locator("#undo").is_enabled():
                while desk.page.locator("#timeline .mark").count() > 1:
                    desk.page.locator("#undo").click()
                    desk.solved()
            desk.page.locator("#scrubber").fill(str(random.randint(2, 12)))
            start = desk.centre(f'#stage [data-actor="{random.choice(["robot", "cheese"])}"]')
            desk.page.mouse.move(*start)
            desk.page.mouse.down()
            spot = desk.page.locator("#stage .spot:not(.not)")
            spot.first.wait_for()
            box = spot.nth(random.randrange(spot.count())).bounding_box()
            desk.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, steps=4)
            desk.noted()
            desk.page.mouse.up()

        measured(desk, count, "i2p/pin", once, "A pin is let go, kitchen, compiled")


def curves(count: int) -> None:
    """From the end of a stroke over a curve to the first film that shall follow it."""
    with serving() as server, browsing() as browser:
        desk = Desk(browser, server).open()
        card = desk.page.locator(".arc")
        card.locator("select").select_option(label="rho > 0")
        card.locator(".plot .measured").wait_for(state="attached")

        def once(random: Random) -> None:
            box = desk.box(".arc .plot")
            at = lambda x, y: (box["x"] + x * box["width"], box["y"] + y * box["height"])
            desk.page.mouse.move(*at(0.2, 0.2 + 0.6 * random.random()))
            desk.page.mouse.down()
            for x in (0.4, 0.6, 0.9):
                desk.page.mouse.move(*at(x, 0.15 + 0.6 * random.random()), steps=5)
            desk.noted()
            desk.page.mouse.up()

        once(Random(1))  # compiles
        desk.page.wait_for_timeout(300)
        measured(desk, count, "i2p/curve", once, "A curve is drawn, kitchen, compiled")


# Typing.


def typing(count: int) -> None:
    """From a key to the letter on the screen, and to what the language server says of the text,
    while films are made all the time."""
    letters, told = [], []
    with serving() as server, browsing() as browser:
        desk = Desk(browser, server).open()
        desk.page.locator("#text .cm-content").click()
        desk.page.keyboard.press("Control+End")
        desk.page.keyboard.press("Enter")
        desk.page.keyboard.type("# ")
        for number in range(count):
            desk.noted()
            wait = """() => new Promise((done) => {
                const root = document.querySelector("#text").shadowRoot;
                addEventListener("keydown", () => {
                  const began = performance.now();
                  const look = new MutationObserver(() => {
                    look.disconnect();
                    requestAnimationFrame(() => done([began, performance.now()]));
                  });
                  look.observe(root.querySelector(".cm-content"), { subtree: true,
                    childList: true, characterData: true });
                }, { once: true, capture: true });
                })"""
            desk.page.evaluate(f"() => {{ window.typed = ({wait})(); }}")  # not waited for
            desk.page.keyboard.press("abcdefgh"[number % 8])
            began, seen = desk.page.evaluate("window.typed")
            letters.append(seen - began)
            desk.page.wait_for_timeout(450)  # the film is begun, and the text was checked
            found = [n for n in desk.noted() if n["at"] > began]
            answers = [n for n in found if n.get("method") == "textDocument/publishDiagnostics"]
            if answers:
                told.append(answers[0]["at"] - began)
    table(
        "Typing while films are made",
        {"key to letter": letters, "key to what is wrong with the text": told},
    )


# Memory.


def memory(count: int) -> None:
    """What server and page hold over many solves, each of another text."""
    with serving() as server, browsing() as browser:
        desk = Desk(browser, server).open()
        desk.quiet()
        print("\nMemory\n\n| solves | server, MB | page, MB | server's CPU, s |\n|---|---|---|---|")
        random = Random(0)
        for number in range(count + 1):
            if number % max(1, count // 10) == 0:
                desk.quiet()
                desk.page.request_gc()
                heap = desk.page.evaluate("performance.memory.usedJSHeapSize") / 1e6
                told = f"| {number} | {server.memory():.0f} | {heap:.1f} | {server.cpu():.0f} |"
                print(told, flush=True)
            weight, place = random.randint(1, 99) / 100, random.choice(["pink", "green"])
            text = STORY.replace("depict", f"{weight} * depict")
            if random.random() < 0.5:
                text += f"pin script[{random.randint(3, 14)}]: not at(robot, {place})\n"
            desk.page.locator("#text .cm-content").click()
            desk.page.keyboard.press("Control+a")
            desk.page.keyboard.insert_text(text)
            desk.page.wait_for_timeout(30)
            desk.solved(best=number % 10 == 0)


def size(count: int) -> None:
    """What a page fetches."""
    told = lambda data: f"{len(data) / 1000:.0f} | {len(gzip.compress(data)) / 1000:.0f}"
    editor = CLIENT / "codemirror.js"
    own = [p for p in CLIENT.iterdir() if p.suffix in (".js", ".css", ".html") and p != editor]
    player = [p for p in RENDER.rglob("*") if p.suffix in (".js", ".css")]
    print("\nSize\n\n| | kB | gzipped |\n|---|---|---|")
    print(f"| CodeMirror, one bundle | {told(editor.read_bytes())} |")
    print(f"| the studio's own | {told(b''.join(p.read_bytes() for p in own))} |")
    print(f"| players of films | {told(b''.join(p.read_bytes() for p in player))} |")


MEASURES = {f.__name__: f for f in (size, start, pins, curves, typing, memory)}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", nargs="*", choices=[*MEASURES, []], default=list(MEASURES))
    parser.add_argument("--count", type=int, default=50)
    given = parser.parse_args()
    print(f"load {os.getloadavg()[0]:.1f} at the start, {os.cpu_count()} cores")
    for name in given.what or MEASURES:
        MEASURES[name](500 if name == "memory" and given.count == 50 else given.count)
    print(f"\nload {os.getloadavg()[0]:.1f} at the end")
