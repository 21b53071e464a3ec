"""A page that is open: what it asks, and who answers."""

from __future__ import annotations

import asyncio
import base64
import binascii
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from i2pdsl.studio import protocol as ask
from i2pdsl.studio.channel import Channel
from i2pdsl.studio.folder import TEXTS
from i2pdsl.studio.protocol import REFUSED, Refusal
from i2pdsl.studio.solver import IDLE, NOW, SOON, Job

if TYPE_CHECKING:
    from i2pdsl.pipeline import Story
    from i2pdsl.studio.films import Films, Made
    from i2pdsl.studio.making import Better
    from i2pdsl.studio.studio import Studio
    from i2pdsl.worlds.kind import Watch

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
        self._films: Films | None = None
        self._best: dict[str, Made] = {}
        for name in ask.REQUESTS:
            handler = getattr(self, f"on_{name}", None)
            if handler is not None:
                channel.answers(name, handler)

    @property
    def films(self) -> Films:
        if self._films is None:
            from i2pdsl.studio.films import Films

            self._films = Films()
        return self._films

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

        def first(watch: Watch) -> Story:
            from i2pdsl.studio import making
            from i2pdsl.studio.outline import outline

            story = making.read(text, path, self.studio.folder.place(path).parent)
            self.works[asked.uri] = Work(path, asked.version or 0, story)
            self.about(told, "story", outline(story, self.channel.folder))
            making.world_of(story, watch)
            self._best.pop(asked.uri, None)
            self.show(asked, story, "preview", making.preview(story, asked.seed, watch))
            return story

        def again(watch: Watch) -> bool:
            from i2pdsl.studio import making

            if story.typed.search.method == "beam":
                found = making.refined(story, asked.seed, watch)
                self.show(asked, story, "refined", found)
            return True

        def at_last(watch: Watch) -> bool:
            from i2pdsl.studio import making

            found = making.best(story, asked.seed, asked.effort, watch)
            self.show(asked, story, "best", found)
            return found.finished

        story = await self.work(asked.uri, told, NOW, first)
        await self.work(asked.uri, told, SOON, again)
        finished = await self.work(asked.uri, told, IDLE, at_last)
        self.channel.notify(
            "progress", {**told, "stage": "idle", "done": 0, "total": 0, "text": ""}
        )
        return {"version": asked.version, "finished": finished}

    async def on_cancel(self, asked: ask.OfDocument) -> dict[str, Any]:
        owner = (id(self), asked.uri)
        self.studio.solver.stop(lambda each: each == owner)
        return {}

    async def work(
        self, uri: str, told: dict[str, Any], urgency: int, do: Callable[[Watch], Any]
    ) -> Any:
        """Has something done by the worker, and tells how far it is."""
        said = [0.0, ""]

        def progress(stage: str, done: int, total: int, text: str) -> None:
            now = time.monotonic()
            if stage != said[1] or now - said[0] >= SAID_EVERY:  # type: ignore[operator]
                said[:] = [now, stage]
                how = {"stage": stage, "done": done, "total": total, "text": text}
                self.about(told, "progress", how)

        job = Job((id(self), uri), urgency, do, progress)
        return await asyncio.wrap_future(self.studio.solver.submit(job))

    def about(self, told: dict[str, Any], name: str, params: dict[str, Any]) -> None:
        """A notification about a version of a document, unless that is another by now."""

        def send() -> None:
            if self.channel.is_present(told["uri"], told["version"]):
                self.channel.notify(name, {**told, **params})

        self.channel.loop.call_soon_threadsafe(send)

    def show(self, asked: ask.Solve, story: Story, quality: str, found: Better) -> None:
        """A film, where it is better than the one before; in the worker's thread."""
        from i2pdsl.studio.films import Made, film_as_json

        made = Made(
            self.films.name(), asked.uri, asked.version or 0, asked.seed, quality, story,
            found.script, found.judgement,
        )  # fmt: skip
        before = self._best.get(asked.uri)
        if before is not None and quality != "best" and made.worth <= before.worth:
            return
        same = before is not None and (
            before.script.record.frames == made.script.record.frames
            and before.script.record.start == made.script.record.start
        )
        self._best[asked.uri] = made
        self.films.keep(made)
        told = {"uri": asked.uri, "version": asked.version}
        film = {**film_as_json(made), "same": before.name if same and before else None}
        self.about(told, "film", {"seed": asked.seed, "film": film})
