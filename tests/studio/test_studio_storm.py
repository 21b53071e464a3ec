"""Many edits while films are made, with messages and work that are late: what was asked last is
answered last, and nothing that was asked stays without an answer.

What takes long is played: a film is a number of waits, some of which hear that they are stopped and
some (as while something is compiled) do not. All delays are drawn from a seed.
"""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections import Counter
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("starlette")

from i2pdsl.errors import Diagnostic, Source, Span, StoryError
from i2pdsl.studio import films, making, outline
from i2pdsl.studio import solver as solving
from i2pdsl.studio.making import Better
from i2pdsl.studio.studio import Studio
from i2pdsl.worlds.kind import Watch

LONG = 30.0  # seconds that nothing here takes
TINY = 0.002  # seconds: the longest of one wait
INITIALIZE = {"processId": None, "rootUri": None, "capabilities": {}}


class Played:
    """Films that are played, not made; their delays are drawn from their texts."""

    def __init__(self, seed: int):
        self.seed = seed

    def wait(self, about: str, watch: Watch) -> None:
        random = Random(f"{self.seed} {about}")
        assert watch.searching is not None
        for _ in range(random.randrange(4)):
            time.sleep(TINY * random.random())
            if random.random() < 0.6:  # else it hears nothing, as while something is compiled
                watch.searching(1, 2)

    def read(self, text: str, path: str, folder: Path) -> Any:
        if "wrong" in text:
            raise mistake(text)
        method = "descend" if "moves" in text else "beam"
        return SimpleNamespace(
            text=text, typed=SimpleNamespace(search=SimpleNamespace(method=method))
        )

    def made(self, story: Any, quality: str, watch: Watch) -> Better:
        self.wait(f"{story.text} {quality}", watch)
        if quality == "preview" and "rare" in story.text:
            raise mistake(story.text)
        record = SimpleNamespace(start={}, frames=(story.text, quality))
        score = {"preview": 1.0, "refined": 2.0, "best": 3.0}[quality]
        return Better(SimpleNamespace(score=score, unmet=(), record=record, world=self))  # type: ignore[arg-type]


def mistake(text: str) -> StoryError:
    return StoryError([Diagnostic("objective", "nothing", Span(Source("a.story", text), 0, 0))])


@pytest.fixture(params=range(3))
def played(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Played:
    play = Played(request.param)
    monkeypatch.setattr(solving, "QUIET", 0.003)
    monkeypatch.setattr(making, "read", play.read)
    monkeypatch.setattr(making, "world_of", lambda story, watch: play.wait(story.text, watch))
    monkeypatch.setattr(outline, "outline", lambda story, folder: {})
    for quality in ("preview", "refined", "best"):
        make = lambda story, *rest, quality=quality: play.made(story, quality, rest[-1])
        monkeypatch.setattr(making, quality, make)
    monkeypatch.setattr(
        making, "ready_for_pins", lambda story, watch: play.wait(f"{story.text} ready", watch)
    )
    shown = lambda made: {"id": made.name, "quality": made.quality}
    monkeypatch.setattr(films, "film_as_json", shown)
    return play


class Client:
    """A page without a browser. `replies` counts the answers to each request, `told` are the
    notifications with what the text's version was when each came."""

    def __init__(self, studio: Studio, uri: str):
        self.studio, self.uri = studio, uri
        self.version = 0
        self.asked: dict[int, int] = {}
        self.replies: Counter[int] = Counter()
        self.answers: dict[int, dict[str, Any]] = {}
        self.told: list[dict[str, Any]] = []
        self.page = studio.joined(self._heard)

    def _heard(self, text: str) -> None:
        message = json.loads(text)
        if "id" in message and "method" not in message:
            self.replies[message["id"]] += 1
            self.answers[message["id"]] = message
        elif message["method"].startswith("i2p/"):
            self.told.append(message)

    def say(self, method: str, params: dict[str, Any], number: int | None = None) -> None:
        message = {"jsonrpc": "2.0", "method": method, "params": params}
        self.page.channel.received(
            json.dumps(message if number is None else message | {"id": number})
        )

    def write(self, text: str) -> None:
        self.version += 1
        here = {"uri": self.uri, "version": self.version}
        if self.version == 1:
            told = {"textDocument": {**here, "languageId": "story", "text": text}}
            self.say("textDocument/didOpen", told)
        else:
            changes = [{"text": text}]
            told = {"textDocument": here, "contentChanges": changes}
            self.say("textDocument/didChange", told)

    def ask(self, method: str, **more: Any) -> int:
        number = len(self.asked) + 1
        self.asked[number] = self.version
        self.say(f"i2p/{method}", {"uri": self.uri, "version": self.version, **more}, number)
        return number

    async def until_answered(self, number: int) -> dict[str, Any]:
        async with asyncio.timeout(LONG):
            while number not in self.answers:
                await asyncio.sleep(TINY)
        return self.answers[number]


def test_the_last_text_always_has_its_film(played: Played, tmp_path: Path) -> None:
    random = Random(played.seed)

    async def storm() -> None:
        studio = Studio(tmp_path, None)
        client = Client(studio, (tmp_path / "a.story").as_uri())
        client.say("initialize", INITIALIZE, 0)
        for count in range(150):
            kind = random.choice(["plain", "plain", "rare", "moves", "wrong"])
            client.write(f"{kind} {count}")
            if random.random() < 0.9:
                last = client.ask("solve", seed=0)
            for _ in range(random.randrange(3)):
                what = random.random()
                if what < 0.15:
                    client.ask("cancel")
                elif what < 0.3:
                    last = client.ask("solve", seed=1)  # the same text once more
                else:
                    await asyncio.sleep(random.choice([0, 0, TINY, 4 * TINY]))
        client.write("plain, the last")
        begun = len(client.told)
        last = client.ask("solve", seed=0)
        assert (await client.until_answered(last))["result"]["finished"]
        films = [m["params"] for m in client.told[begun:] if m["method"] == "i2p/film"]
        assert {film["version"] for film in films} == {client.version}
        qualities = [film["film"]["quality"] for film in films]
        assert qualities == ["preview", "refined", "best"]
        for number in client.asked:  # whoever asked was answered, once
            await client.until_answered(number)
        assert set(client.replies.values()) == {1}
        versions = [m["params"]["version"] for m in client.told if m["method"] == "i2p/film"]
        assert versions == sorted(versions)
        assert len(set(versions)) > 3  # some of the earlier ones had films, too
        studio.left(client.page)

    asyncio.run(storm())


def test_few_first_pictures_without_a_film_are_not_the_last_word(
    played: Played, tmp_path: Path
) -> None:
    async def one(kind: str) -> tuple[dict[str, Any], list[str]]:
        studio = Studio(tmp_path, None)
        client = Client(studio, (tmp_path / "a.story").as_uri())
        client.say("initialize", INITIALIZE, 0)
        client.write(kind)
        answer = await client.until_answered(client.ask("solve", seed=0))
        studio.left(client.page)
        films = [m["params"]["film"] for m in client.told if m["method"] == "i2p/film"]
        return answer, [film["quality"] for film in films]

    answer, qualities = asyncio.run(one("rare"))
    assert answer["result"]["finished"]
    assert qualities == ["refined", "best"]
    answer, qualities = asyncio.run(one("rare moves"))  # where bodies move, there is one look only
    assert answer["error"]["data"]["kind"] == "story"
    assert qualities == []


def test_pages_that_come_and_go(played: Played, tmp_path: Path) -> None:
    """A page that is closed in the middle of a film takes nothing from another."""
    random = Random(played.seed)

    async def storm() -> None:
        studio = Studio(tmp_path, None)
        stays = Client(studio, (tmp_path / "a.story").as_uri())
        stays.say("initialize", INITIALIZE, 0)
        for count in range(25):
            goes = Client(studio, stays.uri)
            goes.say("initialize", INITIALIZE, 0)
            goes.write(f"plain {count} of another")
            goes.ask("solve", seed=0)
            stays.write(f"plain {count}")
            asked = stays.ask("solve", seed=0)
            await asyncio.sleep(random.choice([0, TINY, 3 * TINY]))
            studio.left(goes.page)
            assert (await stays.until_answered(asked))["result"]["finished"]
        studio.left(stays.page)
        assert studio.pages == set()

    asyncio.run(storm())


def test_what_a_thread_makes_that_did_not_hear_is_not_shown(
    played: Played, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """An older text is at work where nothing is heard while a newer one has its films."""
    goes_on, begun = threading.Event(), threading.Event()
    waits = making.world_of

    def world_of(story: Any, watch: Watch) -> Any:
        if "old" in story.text:
            begun.set()
            assert goes_on.wait(LONG)
        return waits(story, watch)

    monkeypatch.setattr(making, "world_of", world_of)
    forgotten: list[str] = []

    class Watched(dict[str, Any]):
        def pop(self, key: str, *default: Any) -> Any:
            forgotten.append(threading.current_thread().name)
            return super().pop(key, *default)

    async def both() -> None:
        studio = Studio(tmp_path, None)
        client = Client(studio, (tmp_path / "a.story").as_uri())
        client.say("initialize", INITIALIZE, 0)
        client.page._best = Watched()
        client.write("old")
        client.ask("solve", seed=0)
        assert await asyncio.to_thread(begun.wait, LONG)
        client.write("new")
        await client.until_answered(client.ask("solve", seed=0))
        shown = client.page._best[client.uri]
        times = len(forgotten)
        goes_on.set()
        await client.until_answered(1)
        assert client.page._best[client.uri] is shown
        assert len(forgotten) == times
        assert client.page.works[client.uri].version == client.version
        studio.left(client.page)

    asyncio.run(both())


def test_whoever_asks_for_what_is_no_json_is_answered(played: Played, tmp_path: Path) -> None:
    async def odd() -> dict[str, Any]:
        studio = Studio(tmp_path, None)
        client = Client(studio, (tmp_path / "a.story").as_uri())

        async def answer(asked: Any) -> Any:
            return {"odd": object()}

        client.page.channel.answers("studio", answer)
        client.say("i2p/studio", {}, 7)
        return await client.until_answered(7)

    assert "JSON" in asyncio.run(odd())["error"]["message"]
