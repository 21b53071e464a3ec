"""What can be asked about a film, and what could become of it: in a thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from i2pdsl.errors import StoryError, error, whole_file
from i2pdsl.language.methods import has_audience
from i2pdsl.language.vocabulary import Vocabulary, show_value
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script
from i2pdsl.render.pictures import drawing_for
from i2pdsl.render.reasons import Change, account_of, frames_in_words
from i2pdsl.scripts import script_of
from i2pdsl.search.searches import search_of
from i2pdsl.search.task import Task
from i2pdsl.stories import Script, Story
from i2pdsl.studio.films import numbers
from i2pdsl.studio.made import Made
from i2pdsl.studio.protocol import REFUSED, USAGE, Refusal
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.record import Trajectory

LESS_POLISH = 1  # of a search for candidates, or for what one wish alone could have
SHOWN = 3  # ways to go on


def wishes(made: Made, watch: Watch) -> dict[str, Any]:
    """What the film reaches of all that its story asks for, and what could be had of each."""
    story = less_polished(made.story)
    found, finished = story.wishes(made.script, made.seed, watch=watch)
    told = [
        {
            "kind": "wish",
            "source": each.source,
            "reached": each.reached,
            "possible": each.possible,
            "frames": list(each.frames),
        }
        for each in found
    ]
    unmet = {each.span.start for each in made.script.unmet}
    for required in (*story.typed.requirements, *story.typed.pins):
        met = float(required.span.start not in unmet)
        frame = getattr(required, "frame", None)
        what = {"kind": "require" if frame is None else "pin", "source": required.text}
        if what not in [{k: each[k] for k in what} for each in told]:
            frames = [] if met or frame is None else [frame]
            told.append({**what, "reached": met, "possible": 1.0, "frames": frames})
    doubts = [each.as_json() for each in story.doubts(made.script)]
    return {"wishes": told, "finished": finished, "doubts": doubts}


def less_polished(story: Story) -> Story:
    """The same, looked for in less time."""
    plan = story.typed.search
    brief = replace(plan, polish=min(plan.polish, LESS_POLISH))
    return replace(story, typed=replace(story.typed, search=brief))


def why(made: Made) -> dict[str, Any]:
    """What made viewers believe it, observation by observation."""
    account = account_of(made.script.shown())
    if account is None:
        return {"legend": [], "asked": [], "moments": []}
    moments = [
        {
            "first": seen.first,
            "last": seen.last,
            "name": frames_in_words(seen),
            "what": seen.seen,
            "expected": seen.expected,
            "event": seen.is_event,
            "changes": [
                {
                    "claim": change.claim,
                    "before": change.before,
                    "after": change.after,
                    "because": _because(change),
                    "audience": change.audience,
                }
                for change in seen.changes
            ],
        }
        for seen in account.observations
    ]
    asked = [
        {"claim": e.claim, "formal": e.formal, "before": e.before, "after": e.after}
        for e in account.asked
    ]
    return {"legend": list(account.legend), "asked": asked, "moments": moments}


def _because(change: Change) -> list[str]:
    """Why a belief changed, in words."""
    told = [change.ratio]
    if change.instead is not None:
        action, expected, belief = change.instead
        told.append(f"had it been `{action}` (expected with {expected:.2g}): {belief:.3g}")
    if change.is_forgotten:
        told.append("they forget faster than that tells them")
    return told


def query(made: Made, expression: str, assume: str | None) -> dict[str, Any]:
    """The answer to a question, as curves. Raises StoryError."""
    answer = made.script.ask(expression, assume)
    if answer.axes:
        raise Refusal(USAGE, "this is a table of several latents: ask for one of them")
    columns = answer.columns()
    series = [
        {"label": label, "values": numbers(np.atleast_1d(np.asarray(values, float)))}
        for label, values in columns.items()
    ]
    return {"times": answer.t, "series": series}


def curves(made: Made) -> dict[str, Any]:
    """What can be drawn over: the names of the story first, then what viewers wonder about."""
    words, script = made.script.world.vocabulary, made.script
    names = [name for name in script.module.names if name.isidentifier()]
    offered = [(name, name) for name in names] + list(usual_curves(words))
    found = []
    for label, expression in offered:
        try:
            answer = script.ask(expression)
        except StoryError:  # a pattern, an event
            continue
        if answer.t is not None and answer.labels is None and not answer.axes:
            found.append({"label": label, "expression": expression})
    return {"curves": found}


def usual_curves(words: Vocabulary) -> list[tuple[str, str]]:
    """Labels and expressions of what viewers believe in a world, over t."""
    found = []
    for latent in words.latents.values():
        values = [v for v in latent.values if isinstance(v, float)]
        events = [f"{latent.name} = {show_value(value)}" for value in latent.values]
        if values and min(values) < 0 < max(values):
            events = [f"{latent.name} > 0", f"{latent.name} < 0", *events]
        if latent.kind == "truth":
            events = [latent.name]
        found += [(event, f"P({event} | script[:t])") for event in events]
    found += [(f"{who}'s fortune", f"E[V({who}) | script[:t]]") for who in words.characters]
    found += [
        (f"doubt about {latent.name}", f"entropy({latent.name} | script[:t])")
        for latent in words.latents.values()
        if latent.kind != "truth"
    ]
    found.append(("surprise at a frame", "surprise(script[t])"))
    return found


def suggestions(
    made: Made, frame: int, frames: int | None, watch: Watch
) -> list[tuple[str, float, Script]]:
    """How a film could go on after a frame, best first: in words, what it is worth, and the
    beginning of the film with it. Raises StoryError."""
    story, script = made.story, made.script
    world, kind = script.world, kind_of(script.world.spec)
    usual, most = kind.suggested
    count = min(frames or usual, most, story.typed.length - frame)
    if not 0 <= frame <= script.length or count < 1:
        raise Refusal(USAGE, f"nothing follows frame {frame}")
    if not has_audience(story.typed.search.method):
        raise Refusal(REFUSED, "this story is made without an audience")
    path = script.trajectory
    begun = Trajectory(path.actions[:frame], path.states[: frame + 1])
    task = Task(story.typed, world, watch)
    found = search_of(story.typed).onward(task, begun, count)[:SHOWN]
    if not found:
        where = whole_file(story.typed.source.name)
        raise error("search", "nothing that follows has a finite value", where)
    told = []
    for longer, worth in found:
        said = kind.continuation_in_words(world, longer, frame + 1)
        said = said or kind.frame_in_words(world, longer, frame + 1)
        told.append((said, float(worth), as_script(story, longer, script)))
    return told


def as_script(story: Story, path: Trajectory, like: Script) -> Script:
    """A path as a script of a story, with a score where it is as long as the story."""
    typed = story.typed.of_length(len(path.actions))
    frames = replay(like.world, path.states, path.actions)
    score = None
    if len(path.actions) == typed.length:
        with np.errstate(all="ignore"):
            score = score_script(typed, like.world, frames)
    return script_of(typed, like.world, path, frames, dict(like.record.story), score)


def said_of(made: Made, frame: int, who: str, at: Sequence[float]) -> str:
    """What a story says of somebody who is put at a point of the stage. Raises StoryError."""
    drawing, spec = drawing_for(made.script.world.spec), made.script.world.spec
    if who not in drawing.held(spec) or len(at) != 2 or not 0 <= frame <= made.script.length:
        raise Refusal(USAGE, f"`{who[:40]}` cannot be put there")
    return drawing.said_of(made.script, frame, who, (at[0], at[1]))


def kept(made: Made, first: int, last: int, write: Callable[[], str]) -> list[str]:
    """Statements that pin frames of a film as they are: in words, or as those of its script, which
    `write` puts beside the story; it returns under which name."""
    script = made.script
    if not 1 <= first <= last <= script.length:
        raise Refusal(USAGE, f"the film has frames 1 to {script.length}")
    if not script.world.vocabulary.enumerable:
        frames = f"{first}" if first == last else f"{first}..{last}"
        return [f'pin script[{frames}] = "{write()}"']
    return kind_of(script.world.spec).kept(script.world, script.trajectory, first, last)


def first_picture(made: Made) -> str:
    """A condition that describes the first picture of a film."""
    told = kind_of(made.script.world.spec).begun(made.script.record)
    if not told:
        raise Refusal(REFUSED, "in this world stories have no words for the first picture")
    return told
