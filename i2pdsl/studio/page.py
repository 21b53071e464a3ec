"""A page that is open: what it asks, and who answers."""

from __future__ import annotations

import asyncio
import base64
import binascii
import math
import threading
import time
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from i2pdsl.errors import StoryError
from i2pdsl.studio import protocol as ask
from i2pdsl.studio.answers import HANDLERS
from i2pdsl.studio.channel import Channel
from i2pdsl.studio.folder import TEXTS
from i2pdsl.studio.made import Films, Made
from i2pdsl.studio.protocol import REFUSED, Refusal
from i2pdsl.studio.solver import IDLE, NOW, SOON, Job

if TYPE_CHECKING:
    from i2pdsl.objective.panel import Judgement
    from i2pdsl.stories import Script, Story
    from i2pdsl.studio.making import Better
    from i2pdsl.studio.studio import Studio
    from i2pdsl.worlds.kind import Watch

T = TypeVar("T")
READY = "ready"  # what is compiled before anybody needs it
SAID_EVERY = 0.08  # seconds between two words about how far something is


@dataclass(frozen=True)
class Work:
    """The last version of a document that was a story."""

    path: str
    version: int
    story: Story


class Page:
    """One connection."""

    def __init__(self, studio: Studio, channel: Channel):
        self.studio, self.channel = studio, channel
        self.works: dict[str, Work] = {}
        self.films = Films()
        self._asked: dict[str, ask.Solve] = {}  # the last time that each document was solved
        self._best: dict[str, tuple[str, Script]] = {}  # by document: the film that is shown
        self._written: dict[str, tuple[str, str]] = {}  # scripts of films: their paths, and digests
        self._showing = threading.Lock()  # an older thread may not hear at once that it is stopped
        for name in ask.REQUESTS:
            own = getattr(self, f"on_{name}", None)
            channel.answers(name, own or partial(HANDLERS[name], self))

    def close(self) -> None:
        self.channel.close()

    # The folder.

    async def on_studio(self, asked: ask.Nothing) -> dict[str, Any]:
        return self.studio.about()

    async def on_files(self, asked: ask.Nothing) -> dict[str, Any]:
        return {"files": await asyncio.to_thread(self.studio.files)}

    async def on_open(self, asked: ask.OfFile) -> dict[str, Any]:
        folder = self.studio.folder
        place = folder.place(asked.path)
        if place.suffix not in TEXTS:
            raise Refusal(REFUSED, "only stories and worlds are opened")
        text, digest = folder.read(asked.path)
        told = {"path": asked.path, "uri": place.as_uri(), "language": TEXTS[place.suffix]}
        return {**told, "text": text, "digest": digest}

    async def on_save(self, asked: ask.Save) -> dict[str, Any]:
        folder = self.studio.folder
        digest = await asyncio.to_thread(folder.save, asked.path, asked.text, asked.digest)
        return {"path": asked.path, "uri": folder.uri(asked.path), "digest": digest}

    async def on_upload(self, asked: ask.Upload) -> dict[str, Any]:
        try:
            data = base64.b64decode(asked.data, validate=True)
        except (binascii.Error, ValueError):
            raise Refusal(REFUSED, "this is no base64") from None
        digest = await asyncio.to_thread(self.studio.folder.put_picture, asked.path, data)
        return {"path": asked.path, "digest": digest, "sprite": asked.path.rpartition("/")[2]}

    # Solving.

    async def on_solve(self, asked: ask.Solve) -> dict[str, Any]:
        path, text = self.channel.document(asked.uri, asked.version)
        told = {"uri": asked.uri, "version": asked.version}
        self._asked[asked.uri] = asked
        self.studio.solver.stop(lambda owner: owner == (id(self), (asked.uri, READY)))
        if path.endswith(".world"):
            return await self.plan(asked, path, text, told)
        folder = self.studio.folder

        def first(watch: Watch) -> Story:
            from i2pdsl.studio import making
            from i2pdsl.studio.outline import outline

            story = making.read(text, path, folder.place(path).parent)
            self.about(told, "story", outline(story, folder))
            making.world_of(story, watch)
            with self._showing:
                if self._asked.get(asked.uri) is asked:
                    self.works[asked.uri] = Work(path, asked.version or 0, story)
                    self._best.pop(asked.uri, None)
            try:
                found = making.preview(story, asked.seed, watch)
            except StoryError:
                if not making.looks_again(story):
                    raise  # where few first pictures have no film, all of them may have one
            else:
                self.show(asked, story, "preview", found)
            return story

        def again(watch: Watch) -> None:
            from i2pdsl.studio import making

            if making.looks_again(story):
                found = making.refined(story, asked.seed, watch)
                self.show(asked, story, "refined", found)

        def at_last(watch: Watch) -> bool:
            from i2pdsl.studio import making

            found = making.best(story, asked.seed, asked.effort, watch)
            self.show(asked, story, "best", found)
            return found.finished

        def ready(watch: Watch) -> None:
            from i2pdsl.studio import making

            making.ready_for_pins(story, watch)

        story = await self.work(asked.uri, told, NOW, first)
        await self.work(asked.uri, told, SOON, again)
        self.submit((asked.uri, READY), told, IDLE, ready)
        finished = await self.work(asked.uri, told, IDLE, at_last)
        idle = {"stage": "idle", "done": 0, "total": 0, "text": ""}
        self.about(told, "progress", idle)
        return {"version": asked.version, "finished": finished}

    async def plan(
        self, asked: ask.Solve, path: str, text: str, told: dict[str, Any]
    ) -> dict[str, Any]:
        """Plans a world."""

        def first(watch: Watch) -> dict[str, Any]:
            from i2pdsl.studio import making, worlds

            spec = worlds.read(text, path, self.studio.folder.place(path).parent)
            world = worlds.world_as_json(spec, text, path)
            self.about(told, "world", {**world, "planned": False})
            made = making.planned(spec, watch)
            self.about(told, "world", {**world, "planned": True, "plan": made})
            return {"version": asked.version, "finished": True}

        result: dict[str, Any] = await self.work(asked.uri, told, NOW, first)
        return result

    async def on_cancel(self, asked: ask.OfDocument) -> dict[str, Any]:
        uris = (asked.uri, (asked.uri, READY), (asked.uri, "candidates"))
        self.studio.solver.stop(lambda owner: owner[0] == id(self) and owner[1] in uris)
        return {}

    async def work(
        self, about: Hashable, told: dict[str, Any], urgency: int, do: Callable[[Watch], Any]
    ) -> Any:
        """What comes of something that is done by the worker."""
        return await asyncio.wrap_future(self.submit(about, told, urgency, do))

    def submit(
        self, about: Hashable, told: dict[str, Any], urgency: int, do: Callable[[Watch], Any]
    ) -> Future[Any]:
        """Has something done by the worker, and tells how far it is; a newer thing about the same
        takes its place."""
        said: tuple[float, str] = 0.0, ""

        def progress(stage: str, done: int, total: int, text: str) -> None:
            nonlocal said
            now = time.monotonic()
            if stage != said[1] or now - said[0] >= SAID_EVERY:
                said = now, stage
                how = {"stage": stage, "done": done, "total": total, "text": text}
                self.about(told, "progress", how)

        job = Job((id(self), about), urgency, do, progress)
        return self.studio.solver.submit(job)

    async def about_film(
        self, made: Made, what: str, do: Callable[[Watch], dict[str, Any]]
    ) -> dict[str, Any]:
        told = {"uri": made.uri, "version": made.version}
        result: dict[str, Any] = await self.work((made.uri, what), told, SOON, do)
        return result

    async def aside(self, do: Callable[[], T]) -> T:
        """What is soon done, in a thread that nothing longer keeps waiting."""
        return await asyncio.get_running_loop().run_in_executor(self.studio.asker, do)

    async def drawing(self, do: Callable[[], T]) -> T:
        """What takes long and needs no worker."""
        return await asyncio.get_running_loop().run_in_executor(self.studio.drawer, do)

    def story(self, asked: ask.OfDocument) -> Story:
        """The story of a version of a document. Raises StoryError where it is none."""
        from i2pdsl.studio import making

        path, text = self.channel.document(asked.uri, asked.version)
        work = self.works.get(asked.uri)
        if work is not None and work.version == asked.version:
            return work.story
        return making.read(text, path, self.studio.folder.place(path).parent)

    def about(self, told: dict[str, Any], name: str, params: dict[str, Any]) -> None:
        """A notification about a version of a document, unless that is another by now; from any
        thread."""

        def send() -> None:
            if self.channel.is_present(told["uri"], told["version"]):
                self.channel.notify(name, {**told, **params})

        self.channel.loop.call_soon_threadsafe(send)

    # Films.

    def made(
        self,
        asked: ask.OfDocument,
        seed: int,
        story: Story,
        quality: str,
        script: Script,
        judgement: Judgement | None = None,
    ) -> dict[str, Any]:
        """A film that is kept under a name, as the page gets it; in any thread."""
        from i2pdsl.studio.films import film_as_json

        name, version = self.films.name(), asked.version or 0
        made = Made(name, asked.uri, version, seed, quality, story, script, judgement)
        self.films.keep(made)
        return film_as_json(made)

    def show(self, asked: ask.Solve, story: Story, quality: str, found: Better) -> None:
        """A film of a text, where it is better than the one before; in the worker's thread."""
        with self._showing:
            if self._asked.get(asked.uri) is not asked:
                return  # a newer one was asked for, maybe while this one could not hear of it
            before = self._best.get(asked.uri)
            worth = worth_of(found.script)
            if before is not None and quality != "best" and worth <= worth_of(before[1]):
                return
            film = self.made(asked, asked.seed, story, quality, found.script, found.judgement)
            same = before is not None and is_same(before[1], found.script)
            told = {"uri": asked.uri, "version": asked.version}
            film["same"] = before[0] if same and before is not None else None
            self._best[asked.uri] = film["id"], found.script
            self.about(told, "film", {"seed": asked.seed, "film": film})

    def written(self, made: Made) -> str:
        """The name of a film's script beside its story, where it is written if it was not."""
        known = self._written.get(made.name)
        folder = self.studio.folder
        if known is None or folder.digest(known[0]) != known[1]:
            beside = folder.path_of(made.uri).removesuffix(".story")
            kept = folder.keep_script(f"{beside}.kept.json", made.script)
            known = self._written[made.name] = kept["path"], kept["digest"]
        return known[0].rpartition("/")[2]

    def best(self, uri: str) -> Script | None:
        """The best script of a document's present text, so far."""
        found = self._best.get(uri)
        return None if found is None else found[1]


def worth_of(script: Script) -> tuple[int, float]:
    """What films of one text are compared by: what they break, then their scores."""
    score = script.score
    return -len(script.unmet), score if score is not None else -math.inf


def is_same(one: Script, other: Script) -> bool:
    """Whether the same is seen in two films."""
    return one.record.start == other.record.start and one.record.frames == other.record.frames
