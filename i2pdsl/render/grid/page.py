"""The whole story on one HTML page: the film, the audience's mind, what happens, the source."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from i2pdsl.objective.wishes import Wish
from i2pdsl.render import film_page
from i2pdsl.render.alone import NAME, Alone
from i2pdsl.render.grid.film import lengths
from i2pdsl.render.grid.scene import (
    FOOT,
    actor_svg,
    labels_svg,
    life,
    scene_size,
    shadow_svg,
    stage_background,
    stage_symbols,
    view_box,
)
from i2pdsl.render.grid.sprites import symbol_id
from i2pdsl.render.grid.stage import TURNING, Stage, describe
from i2pdsl.render.grid.tracks import Film, Key, Track
from i2pdsl.render.markup import plain
from i2pdsl.render.mind import Mark, Panel
from i2pdsl.render.reasons import Account

SCRIPT = "grid/kitchen.js"  # what moves films in pages
CELL = 100.0  # units of the stage's viewBox to a cell
SHOWN = 900.0, 600.0  # pixels of a usual screen that a stage has, about


def page_html(
    stage: Stage,
    script: Mapping[str, Any],
    film: Film,
    panels: Sequence[Panel],
    title: str,
    source: str,
    captions: Sequence[str] | None = None,
    marks: Sequence[Mark] | None = None,
    language: str = "en",
    wishes: Sequence[Wish] = (),
    account: Account | None = None,
    clock: tuple[np.ndarray, np.ndarray] | None = None,
    note: str = "",
) -> str:
    """A self-contained page for a finished script (the dict of script.json, T frames).

    `panels` cover the frames 0..T. `captions` has T + 1 texts, for the start and each frame;
    without it they are told from the film. `marks` are the moments to line out in the curves;
    without it, those when something falls or vanishes. `clock` is how long frames last, as
    film.lengths has it; without it, what that says of the film alone. `note` stands below the
    title.
    """
    told = tuple(captions) if captions is not None else frame_captions(stage, script, film)
    events = tuple(marks) if marks is not None else _events(film)
    heading = title.strip() or stage.name
    return film_page.film_page(
        moving(stage, film, heading, told, lengths(film) if clock is None else clock),
        panels,
        heading,
        " · ".join(filter(None, (_about(stage, script), note))),
        source,
        events,
        language=language,
        wishes=wishes,
        account=account,
    )


def moving(
    stage: Stage,
    film: Film,
    heading: str,
    captions: Sequence[str],
    clock: tuple[np.ndarray, np.ndarray],
) -> film_page.Film:
    """The film as pages play it; `captions` are of its frames 0..T."""
    last = len(clock[0])
    width, height = scene_size(stage, CELL)
    return film_page.Film(
        stage_svg(stage, film, heading), width / height, last, *clock, captions,
        range(last + 1), SCRIPT, film_data(stage, film),
    )  # fmt: skip


def alone(stage: Stage, script: Mapping[str, Any], film: Film, places: int) -> Alone:
    """The film without a word about it. No frame rests because of what viewers think then."""
    width, height = scene_size(stage, CELL)
    seconds, _ = lengths(film)
    symbols = stage_symbols(stage, poses_of(film))
    return Alone(
        [stage_svg(stage, film, NAME, f"-{place}", symbols) for place in range(places)],
        width / height,
        seconds.tolist(),
        SCRIPT,
        {"shows": [film_data(stage, film)]},
        frame_captions(stage, script, film),
    )


def frame_captions(stage: Stage, script: Mapping[str, Any], film: Film) -> tuple[str, ...]:
    """T + 1 sentences: where everybody is at the start, then what happens in each frame."""
    places = []
    for actor in stage.cast:
        at = script["start"].get(actor.name)
        places.append(f"{actor.name} {somewhere(at)}")
    told = [", ".join(places)]
    for frame in range(1, len(script["frames"]) + 1):
        beats = [describe(beat) for beat in film.beats if beat.frame == frame]
        told.append("; ".join(beats) or "nothing moves")
    return tuple(told)


def somewhere(place: Sequence[int] | str | None) -> str:
    """Where something is in a state of a script file."""
    if isinstance(place, str):
        return f"with {place}"
    return "absent" if place is None else f"at ({place[0]}, {place[1]})"


def _events(film: Film) -> tuple[Mark, ...]:
    unusual = (beat for beat in film.beats if beat.verb in TURNING)
    return tuple(Mark(beat.frame, describe(beat)) for beat in unusual)


def _about(stage: Stage, script: Mapping[str, Any]) -> str:
    """One line under the title; `story` and `score` inform only, and may be missing."""
    count = len(script["frames"])
    told = [f"{stage.name}", f"{count} frame{'' if count == 1 else 's'}"]
    story = script.get("story")
    if isinstance(story, Mapping) and isinstance(story.get("seed"), int):
        told.append(f"seed {story['seed']}")
    score = script.get("score")
    if isinstance(score, (int, float)) and math.isfinite(score):
        told.append(f"score {score:.4g}")
    return " · ".join(told)


# ------------------------------------------------------------------------------------ the stage


def stage_svg(
    stage: Stage, film: Film, heading: str, number: str = "", symbols: str | None = None
) -> str:
    """The drawing at time 0, its background and symbols inside.

    Of several on one page each has its `number` ('-0', '-1', ...), and the first all `symbols`.
    """
    symbols = stage_symbols(stage, poses_of(film)) if symbols is None else symbols
    return f"""\
      <svg id="stage{number}" role="img" aria-label="{plain(heading)}: the film" \
aria-describedby="caption" viewBox="{view_box(stage, CELL)}">
<defs>{symbols}</defs>{stage_background(stage, CELL)}
<g id="actors{number}">
{chr(10).join(_cast(stage, film))}
</g>
<g id="labels{number}">{labels_svg(stage, CELL)}</g>
<g id="marks{number}"></g>
      </svg>"""


def poses_of(film: Film) -> dict[str, tuple[str, ...]]:
    """The poses that each actor takes: only these are drawn into the page."""
    return {name: tuple(sorted({key.pose for key in track})) for name, track in film.tracks.items()}


def _cast(stage: Stage, film: Film) -> Iterable[str]:
    """The cast at time 0; the player moves it. First all shadows: they lie under everybody."""
    large = _life(stage)
    ground = Key(0, -0.5, 0.015 - FOOT)  # a shadow about (0, 0), for the player to move
    for index, actor in enumerate(stage.cast):
        key = film.tracks[actor.name][0]
        x, y = (key.x + 0.5) * CELL, (key.y + FOOT - 0.015) * CELL
        yield (
            f'<g data-index="{index}" data-part="shadow" opacity="{key.opacity:g}" '
            f'transform="translate({x:g} {y:g}) scale({large:g})">{shadow_svg(ground, CELL)}</g>'
        )
    for index, actor in enumerate(stage.cast):
        key = film.tracks[actor.name][0]
        key = key._replace(scale_x=large * key.scale_x, scale_y=large * key.scale_y)
        drawn = actor_svg(actor, key, CELL)
        more = f'data-index="{index}" data-part="actor" data-actor="{plain(actor.name)}"'
        yield drawn.replace("<use ", f"<use {more} ", 1)


def film_data(stage: Stage, film: Film) -> dict[str, Any]:
    """What the player of kitchens reads; keys in the order of `tracks.Key`."""
    actors = []
    for actor in stage.cast:
        symbols = {pose: symbol_id(actor, pose) for pose in poses_of(film)[actor.name]}
        keys = _keys(film.tracks[actor.name])
        actors.append({"name": actor.name, "symbols": symbols, "keys": keys})
    marks = [{"symbol": f"mark--{mark.kind}", "keys": _keys(mark.track)} for mark in film.marks]
    shared = {"cell": CELL, "foot": 100 * FOOT, "life": _life(stage)}
    return {**shared, "actors": actors, "marks": marks}


def _life(stage: Stage) -> float:
    """How much larger than life the cast is drawn, whose cells a screen shows small."""
    width, height = scene_size(stage, CELL)
    return round(life(CELL * min(SHOWN[0] / width, SHOWN[1] / height)), 3)


def _keys(track: Track) -> list[list[Any]]:
    return [[round(v, 5) if isinstance(v, float) else v for v in key] for key in track]
