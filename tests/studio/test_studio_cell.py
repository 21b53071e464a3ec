"""`story.studio()`: what the widget says and hears, and its module in a browser."""

from __future__ import annotations

import json
import queue
import re
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from browser_for_tests import chromium  # noqa: F401
from i2pdsl.errors import StoryError
from i2pdsl.stories import Story
from studio_for_tests import BRIEF, edited
from worlds_for_tests import with_small_world

pytest.importorskip("anywidget")

LONG = 60.0  # seconds that nothing here takes
PAGE = "<!doctype html><meta charset=utf-8><title>cell</title><div id=cell></div>"
MODEL = """
module => {
  const heard = { "msg:custom": [], "change:text": [] };
  window.outbox = [];
  const model = window.model = {
    state: { text: %s, uri: %s },
    get: name => model.state[name],
    set: (name, value) => { model.state[name] = value; },
    save_changes: () => {},
    send: content => window.outbox.push(content),
    on: (name, listener) => heard[name].push(listener),
    off: (name, listener) => { heard[name] = heard[name].filter(each => each !== listener); },
    deliver: content => heard["msg:custom"].forEach(listener => listener(content)),
    changed: text => { model.state.text = text; heard["change:text"].forEach(each => each()); },
    heard,
  };
  const address = URL.createObjectURL(new Blob([module], { type: "text/javascript" }));
  return import(address).then(({ default: widget }) => {
    window.leave = widget.render({ model, el: document.getElementById("cell") });
  });
}
"""


class Kernel:
    """A widget that hears now in this thread and now in another, as in a kernel with subshells:
    neither has a loop that runs."""

    def __init__(self, folder: Path):
        self.said: queue.Queue[dict[str, Any]] = queue.Queue()
        self.count = 0
        self.widget = Story.from_text(BRIEF, folder).studio()
        self.widget.send = self.said.put  # where a comm would be

    def hears(self, content: Any) -> None:
        self.count += 1
        if self.count % 2:
            self.widget._received(self.widget, content, [])
        else:
            arguments = (self.widget, content, [])
            shell = threading.Thread(target=self.widget._received, args=arguments)
            shell.start()
            shell.join(LONG)

    def asked(self, method: str, number: int | None = None, **params: Any) -> None:
        message = {"jsonrpc": "2.0", "method": method, "params": params}
        self.hears({"text": json.dumps(message if number is None else {**message, "id": number})})

    def until(self, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """The next message that is wanted."""
        while True:
            message: dict[str, Any] = json.loads(self.said.get(timeout=LONG)["text"])
            if wanted(message):
                return message

    def reply(self, number: int) -> dict[str, Any]:
        return self.until(lambda message: message.get("id") == number)

    def told(self, method: str, **params: Any) -> dict[str, Any]:
        of = lambda m: m.get("method") == method and params.items() <= m["params"].items()
        found: dict[str, Any] = self.until(of)["params"]
        return found


@pytest.fixture(scope="module")
def kernel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Kernel]:
    found = Kernel(with_small_world(tmp_path_factory.mktemp("cell")))
    yield found
    found.widget.close()


def test_what_a_widget_says_and_hears(kernel: Kernel) -> None:
    widget = kernel.widget
    assert (widget.text, widget.script) == (BRIEF, None)
    about = {"uri": widget.uri, "version": 7}

    def written(text: str, version: int) -> None:
        document = {**about, "version": version}
        changes = [{"text": text}]
        kernel.asked("textDocument/didChange", textDocument=document, contentChanges=changes)

    written(BRIEF, 7)
    kernel.asked("i2p/solve", 1, **about)
    assert kernel.told("i2p/story", version=7)["world"] == "small"
    film = kernel.told("i2p/film", version=7)["film"]
    assert len(film["play"]["captions"]) == 7
    kernel.asked("i2p/pin", 2, **about, frame=3, who="robot", place="(0, 0)")
    pinned = edited(BRIEF, kernel.reply(2)["result"]["edits"])
    assert pinned == BRIEF + "\npin script[3]: at(robot, (0, 0))\n"
    written(pinned, 8)
    kernel.asked("i2p/solve", 3, **{**about, "version": 8})
    assert kernel.told("i2p/film", version=8)["film"]["unmet"] == []
    kernel.asked("i2p/pin", 4, **about, frame=2, who="robot", place=None)
    assert kernel.reply(4)["error"]["data"]["kind"] == "stale"
    assert widget.script.query("[at(robot, (0, 0)) @ script[3]]") == 1
    kernel.asked("i2p/open", 5, path="../secret.story")
    assert "error" in kernel.reply(5)
    for nonsense in ("{", None, {"text": 7}, {"text": "{"}):  # is not worth an answer
        kernel.hears(nonsense)
    widget.text = pinned
    assert [pin.frame for pin in widget.story.typed.pins] == [3]
    widget.text = "world small\nlength\n"
    with pytest.raises(StoryError):
        _ = widget.story
    widget.text = BRIEF
    shown = widget._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in (shown[0] if shown else {})


def test_without_anywidget(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delitem(sys.modules, "i2pdsl.studio.cell", raising=False)
    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(StoryError, match=re.escape("`studio()` needs anywidget")) as found:
        Story.from_text(BRIEF, with_small_world(tmp_path)).studio()
    assert "i2pdsl[notebook]" in (found.value.diagnostics[0].hint or "")


@pytest.mark.browser
def test_its_module_in_a_cell(kernel: Kernel, chromium: Any) -> None:  # noqa: F811
    widget = kernel.widget
    page = chromium.new_context(viewport={"width": 1000, "height": 800}).new_page()
    trouble: list[str] = []
    page.on("console", lambda message: trouble.append(message.text))
    page.on("pageerror", lambda problem: trouble.append(str(problem)))
    page.set_content(PAGE)
    page.evaluate(MODEL % (json.dumps(BRIEF), json.dumps(widget.uri)), widget._esm)

    def until(wanted: str) -> None:
        """Carries messages to and fro until something is so in the cell."""
        for _ in range(int(LONG / 0.05)):
            for content in page.evaluate("window.outbox.splice(0)"):
                kernel.hears(content)
            while not kernel.said.empty():
                page.evaluate("content => model.deliver(content)", kernel.said.get())
            if page.evaluate(f"() => Boolean({wanted})"):
                return
            page.wait_for_timeout(50)
        pytest.fail(f"never: {wanted}; {trouble}")

    in_cell = "document.querySelector('.i2p-studio').shadowRoot"
    until(f"{in_cell}.querySelector('#state').textContent === 'ready'")
    until(f"{in_cell}.querySelector('.curve-card .curve path')")
    page.locator("#scrubber").fill("3")
    robot = page.locator('[data-actor="robot"]').bounding_box()
    x, y = robot["x"] + robot["width"] / 2, robot["y"] + robot["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    spots = "[...[...{0}.querySelectorAll('.screen')][0].shadowRoot.querySelectorAll('.spot')]"
    until(f"{spots.format(in_cell)}.length")
    free = page.locator(".spot:not(.not)").first
    box = free.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, steps=4)
    page.mouse.up()
    until("/pin script.3.: at.robot/.test(model.state.text)")
    until(f"{in_cell}.querySelector('.mark')")
    until(f"{in_cell}.querySelector('#state').textContent === 'ready'")
    page.get_by_role("button", name="Undo").click()
    assert page.evaluate("model.state.text") == BRIEF
    page.evaluate("text => model.changed(text)", BRIEF.replace("length 6", "length 8"))
    until(f"{in_cell}.querySelector('.counter').textContent.endsWith('/ 8')")
    assert "length 8" in page.get_by_label("The story’s text").input_value()
    page.get_by_label("The story’s text").fill(BRIEF.replace("rho", "rhoo"))
    until(f"{in_cell}.querySelector('#state').dataset.kind === 'wrong'")
    page.evaluate("window.leave()")
    assert page.evaluate("model.heard['msg:custom'].length") == 0
    assert trouble == []
