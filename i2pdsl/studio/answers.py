"""Who answers what a page asks about films, texts and worlds (docs/studio-protocol.md)."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from i2pdsl.language.naming import same_name
from i2pdsl.studio import protocol as ask
from i2pdsl.studio.protocol import REFUSED, USAGE, Refusal
from i2pdsl.studio.solver import SOON

if TYPE_CHECKING:
    from i2pdsl.studio.page import Page
    from i2pdsl.studio.text import StoryText
    from i2pdsl.worlds.kind import Watch

Handler = Callable[["Page", Any], Awaitable[dict[str, Any]]]
HANDLERS: dict[str, Handler] = {}
_PLACE = re.compile(r"\w{1,80}|\(\d{1,4}(\.\d{1,4})?, ?\d{1,4}(\.\d{1,4})?\)")
MOST_CANDIDATES = 24


def answers(handler: Handler) -> Handler:
    """Notes down who answers the request of the same name."""
    HANDLERS[handler.__name__] = handler
    return handler


def _who(name: str) -> str:
    if not name.isidentifier():
        raise Refusal(USAGE, f"`{name[:40]}` is no name")
    return same_name(name)


def _place(place: str | None) -> str | None:
    if place is not None and not _PLACE.fullmatch(place):
        raise Refusal(USAGE, f"`{place[:40]}` is no place")
    return place


# Texts.


async def by_hand(
    page: Page, asked: ask.OfDocument, do: Callable[[StoryText], StoryText]
) -> dict[str, Any]:
    """The edits that make another text of the present one."""
    from i2pdsl.studio.text import StoryText

    _, text = page.channel.document(asked.uri, asked.version)
    old = StoryText(text)
    return {"version": asked.version, "edits": old.edits(do(old).text)}


@answers
async def pin(page: Page, asked: ask.Pin) -> dict[str, Any]:
    from i2pdsl.studio import asking, hands

    who, place = _who(asked.who), _place(asked.place)
    if asked.at is None:
        return await by_hand(page, asked, lambda text: hands.pin(text, asked.frame, who, place))
    made, at = page.films[asked.film or ""], asked.at
    said = await page.aside(lambda: asking.said_of(made, asked.frame, who, at))
    return await by_hand(page, asked, lambda text: hands.say(text, asked.frame, who, said))


@answers
async def during(page: Page, asked: ask.Stretch) -> dict[str, Any]:
    made = page.films[asked.film]

    def found() -> list[dict[str, Any]]:
        from i2pdsl.studio.during import offers

        return offers(made, asked.first, asked.last)

    return {"offers": await page.aside(found)}


@answers
async def say(page: Page, asked: ask.Say) -> dict[str, Any]:
    from i2pdsl.studio import hands

    do = lambda text: hands.during(text, asked.first, asked.last, asked.condition)
    return await by_hand(page, asked, do)


@answers
async def unpin(page: Page, asked: ask.Unpin) -> dict[str, Any]:
    from i2pdsl.studio import hands

    who = _who(asked.who) if asked.who else None
    do = lambda text: hands.unpin(text, asked.frame, who, asked.last)
    return await by_hand(page, asked, do)


@answers
async def move(page: Page, asked: ask.Move) -> dict[str, Any]:
    from i2pdsl.studio import hands

    who = _who(asked.who) if asked.who else None
    return await by_hand(page, asked, lambda text: hands.move(text, asked.frame, who, asked.to))


@answers
async def hold(page: Page, asked: ask.Hold) -> dict[str, Any]:
    from i2pdsl.studio import asking, hands

    made = page.films[asked.film]
    lines = await page.aside(
        lambda: asking.kept(made, asked.first, asked.last, lambda: page.written(made))
    )
    do = lambda text: hands.hold(text, lines, asked.first, asked.last)
    return await by_hand(page, asked, do)


@answers
async def curve(page: Page, asked: ask.Curve) -> dict[str, Any]:
    from i2pdsl.studio import hands
    from i2pdsl.studio.text import Change

    drawn = hands.drawn(asked.points or [], asked.low, asked.high)

    def do(text: StoryText) -> StoryText:
        if asked.range is not None:
            start, end = text.offsets(asked.range)
            return text.with_changes([Change(start, end, drawn)])
        if not asked.expression:
            raise Refusal(USAGE, "which curve?")
        return hands.wish(text, hands.followed(asked.expression, drawn, asked.low, asked.high))

    return await by_hand(page, asked, do)


@answers
async def edit(page: Page, asked: ask.Edit) -> dict[str, Any]:
    from i2pdsl.studio import asking, hands

    frame, value, order = asked.frame or 0, asked.value or 0, asked.order or []
    do: dict[str, Callable[[StoryText], StoryText]] = {
        "length": lambda text: hands.length(text, value),
        "insert": lambda text: hands.insert(text, frame),
        "cut": lambda text: hands.cut(text, frame),
        "beats": lambda text: hands.beats(text, order),
        "start": lambda text: hands.start(text, asking.first_picture(page.films[asked.film or ""])),
    }
    if asked.what not in do:
        raise Refusal(USAGE, f"`what` is one of {', '.join(do)}")
    return await by_hand(page, asked, do[asked.what])


@answers
async def pattern(page: Page, asked: ask.UsePattern) -> dict[str, Any]:
    from i2pdsl.studio import hands, palette

    known = await page.aside(lambda: palette.standard().patterns)
    found = next((each for each in known if each["name"] == asked.name), None)
    if found is None:
        raise Refusal(USAGE, f"there is no pattern `{asked.name[:40]}`")
    called = palette.call(asked.name, asked.arguments or {}, found)
    return await by_hand(page, asked, lambda text: hands.wish(text, f"maximize {called}"))


@answers
async def patterns(page: Page, asked: ask.Patterns) -> dict[str, Any]:
    work = page.works.get(asked.uri or "")
    words = None if work is None else work.story.typed.vocabulary

    def found() -> list[dict[str, Any]]:
        from i2pdsl.studio import palette

        return palette.palette(words, asked.words)

    return {"patterns": await page.aside(found)}


@answers
async def play(page: Page, asked: ask.Play) -> dict[str, Any]:
    who, story = _who(asked.who), page.story(asked)
    page.studio.solver.touch()  # a hand is on something: soon something newer will be asked

    def found() -> dict[str, Any]:
        from i2pdsl.studio.making import world_of
        from i2pdsl.studio.spots import spots
        from i2pdsl.worlds.kind import Watch

        return spots(story, world_of(story, Watch()), asked.frame, who)

    return {"version": asked.version, **await page.aside(found)}


# Films.


@answers
async def candidates(page: Page, asked: ask.Candidates) -> dict[str, Any]:
    story = page.story(asked)
    count = min(max(asked.count, 1), MOST_CANDIDATES)

    def look(watch: Watch) -> dict[str, Any]:
        from i2pdsl.studio.asking import less_polished

        found = less_polished(story).solve(asked.seed, count, watch=watch)
        pairs = list(zip(found.candidates, found.judgements, strict=True))[:count]
        films = [page.made(asked, asked.seed, story, "candidate", *pair) for pair in pairs]
        return {"candidates": films, "finished": found.finished}

    told = {"uri": asked.uri, "version": asked.version}
    result = await page.work((asked.uri, "candidates"), told, SOON, look)
    return {"version": asked.version, **result}


@answers
async def suggest(page: Page, asked: ask.Suggest) -> dict[str, Any]:
    made = page.films[asked.film]

    def look(watch: Watch) -> dict[str, Any]:
        from i2pdsl.studio.asking import suggestions

        found = suggestions(made, asked.frame, asked.frames, watch)
        about = ask.OfDocument(made.uri, made.version)
        return {
            "suggestions": [
                {
                    "text": text,
                    "score": score,
                    "breaks": [each.text for each in script.unmet],
                    "film": page.made(about, made.seed, made.story, "suggested", script),
                }
                for text, score, script in found
            ]
        }

    return await page.about_film(made, "suggest", look)


@answers
async def wishes(page: Page, asked: ask.OfFilm) -> dict[str, Any]:
    made = page.films[asked.film]

    def look(watch: Watch) -> dict[str, Any]:
        from i2pdsl.studio import asking

        return asking.wishes(made, watch)

    return await page.about_film(made, "wishes", look)


@answers
async def why(page: Page, asked: ask.OfFilm) -> dict[str, Any]:
    from i2pdsl.studio import asking

    made = page.films[asked.film]
    return await page.aside(lambda: asking.why(made))


@answers
async def query(page: Page, asked: ask.Query) -> dict[str, Any]:
    from i2pdsl.studio import asking

    made = page.films[asked.film]
    return await page.aside(lambda: asking.query(made, asked.expression, asked.assume))


@answers
async def curves(page: Page, asked: ask.OfFilm) -> dict[str, Any]:
    from i2pdsl.studio import asking

    made = page.films[asked.film]
    return await page.aside(lambda: asking.curves(made))


@answers
async def keep(page: Page, asked: ask.Keep) -> dict[str, Any]:
    made, folder = page.films[asked.film], page.studio.folder
    return await page.aside(lambda: folder.keep_script(asked.path, made.script))


@answers
async def export(page: Page, asked: ask.Export) -> dict[str, Any]:
    from i2pdsl.studio.exports import exported

    made = page.films[asked.film]
    wanted = asked.formats or ["html"]
    told = {"uri": made.uri, "version": made.version}

    def progress(name: str, done: int, total: int) -> None:
        how = {"stage": "drawing", "done": done, "total": total, "text": f"drawing {name}"}
        page.about(told, "progress", how)

    return await page.drawing(
        lambda: exported(page.studio, made, wanted, asked.pace, asked.transparent, progress)
    )


# Worlds.


async def _world_by_hand(
    page: Page, asked: ask.OfDocument, do: Callable[[str, str], str]
) -> dict[str, Any]:
    path, text = page.channel.document(asked.uri, asked.version)
    if Path(path).suffix != ".world":
        raise Refusal(REFUSED, "this is no world")
    return await by_hand(page, asked, lambda old: type(old)(do(text, path)))


@answers
async def paint(page: Page, asked: ask.Paint) -> dict[str, Any]:
    from i2pdsl.studio import worlds

    cells = asked.cells or []
    do = lambda text, path: worlds.painted(text, path, cells, asked.symbol)
    return await _world_by_hand(page, asked, do)


@answers
async def side(page: Page, asked: ask.Sides) -> dict[str, Any]:
    from i2pdsl.studio import worlds

    sides = asked.sides or []
    do = lambda text, path: worlds.walled(text, path, sides, asked.wall)
    return await _world_by_hand(page, asked, do)


@answers
async def size(page: Page, asked: ask.Size) -> dict[str, Any]:
    from i2pdsl.studio import worlds

    do = lambda text, path: worlds.sized(text, path, asked.columns, asked.rows)
    return await _world_by_hand(page, asked, do)


@answers
async def entity(page: Page, asked: ask.Entity) -> dict[str, Any]:
    from i2pdsl.studio import worlds

    given = asked.what, asked.name, asked.settings, asked.another
    do = lambda text, path: worlds.with_block(text, path, *given)
    return await _world_by_hand(page, asked, do)


# Beginnings.


@answers
async def beginnings(page: Page, asked: ask.Nothing) -> dict[str, Any]:
    from i2pdsl.studio.begin import ways

    return await page.aside(lambda: ways(page.studio.folder))


@answers
async def new(page: Page, asked: ask.New) -> dict[str, Any]:
    from i2pdsl.studio.begin import begun

    return await page.aside(
        lambda: begun(page.studio.folder, asked.name, asked.beginning, asked.world)
    )
