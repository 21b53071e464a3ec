"""What hands do to a story, done to its text: pins, the first picture, turns, beats, curves.

`who` and `place` are names and places as stories write them. Everything also works on a text with
mistakes, as far as the statement at hand can be read: a pin that contradicts another can be taken
away.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from i2pdsl.errors import Source, StoryError
from i2pdsl.language import ast
from i2pdsl.language.methods import LONGEST_STORY
from i2pdsl.language.naming import same_name
from i2pdsl.language.parse import parse_expression
from i2pdsl.studio.protocol import REFUSED, USAGE, Refusal
from i2pdsl.studio.text import Change, StoryText, parts, whose

HEAD, PINS = (ast.World, ast.LengthIs), (ast.Pin,)
MOST_POINTS = 12  # of a drawn curve are kept
FINENESS = 0.015  # of its height: what is nearer to a line than that needs no point
WANTED = 4.0  # what a frame counts in which a curve is as far as can be from what was drawn


def where(who: str, place: str | None) -> str:
    """A condition: somebody is at a place, or nowhere."""
    return f"absent({who})" if place is None else f"at({who}, {place})"


# Pins.


def pin(text: StoryText, frame: int, who: str, place: str | None) -> StoryText:
    """Somebody is at a place in a frame, instead of what was said of it there before."""
    return say(text, frame, who, where(who, place))


def say(text: StoryText, frame: int, who: str, condition: str) -> StoryText:
    """A condition about somebody in a frame, instead of what was said of it there before."""
    if frame == 0:
        return _start(text, who, condition)
    instead: list[Change] = []
    freed: list[Change] = []
    for statement in text.program.of(ast.Pin):
        frames = text.frames(statement)
        if frames is None or frame not in frames or statement.condition is None:
            continue
        if not _speaks_of(statement, who):
            continue
        if len(frames) == 1 and not instead:
            instead = _said(text, statement.condition, who, condition)
        else:
            freed += _freed(text, statement, frame, who)
    left = text.with_changes([*instead, *freed])
    return left if instead else left.with_statements([f"pin script[{frame}]: {condition}"], PINS)


def _said(text: StoryText, condition: ast.Expr, who: str, new: str) -> list[Change]:
    """The first thing that a condition says of somebody, said otherwise; the others go."""
    mine = [part for part in parts(condition) if whose(part) == who]
    first, *others = mine
    said = Change(first.span.start, first.span.end, new)
    return [said, *(_without_part(text, condition, other) for other in others)]


def _without_part(text: StoryText, condition: ast.Expr, part: ast.Expr) -> Change:
    """A condition of several parts without one of them, and without the `and` beside it."""
    every = parts(condition)
    number = every.index(part)
    if number:
        return Change(every[number - 1].span.end, part.span.end, "")
    return Change(part.span.start, every[1].span.start, "")


def _start(text: StoryText, who: str, condition: str) -> StoryText:
    starts = text.program.of(ast.Start)
    if not starts:
        return text.with_statements([f"start {condition}"], HEAD)
    told = starts[-1].condition
    if any(whose(part) == who for part in parts(told)):
        return text.with_changes(_said(text, told, who, condition))
    if isinstance(told, ast.And | ast.Call | ast.Compare | ast.Not):
        return text.with_changes([Change(told.span.end, told.span.end, f" and {condition}")])
    together = f"({told.span.text}) and {condition}"
    return text.with_changes([Change(told.span.start, told.span.end, together)])


def unpin(text: StoryText, frame: int, who: str | None, last: int | None = None) -> StoryText:
    """A frame without what pins it, or without what pins somebody in it; with `last`, that only
    which pins these frames together."""
    changes = []
    if frame == 0:
        for start in text.program.of(ast.Start):
            changes += _freed_of(text, start, start.condition, who)
    for statement in text.program.of(ast.Pin):
        frames = text.frames(statement)
        if frames is None or frame not in frames:
            continue
        if last is None:
            changes += _freed(text, statement, frame, who)
        elif frames == range(frame, last + 1):
            changes += _freed_at_all(text, statement, who)
    if not changes:
        raise Refusal(USAGE, "nothing is pinned there")
    return text.with_changes(changes)


def _freed(text: StoryText, pin: ast.Pin, frame: int, who: str | None) -> list[Change]:
    """A statement without one of its frames, as far as it says something of somebody there."""
    frames = text.frames(pin)
    assert frames is not None
    if len(frames) == 1:
        return _freed_at_all(text, pin, who)
    if who is not None and not _speaks_of(pin, who):
        return []
    behind = text.text[_behind(text, pin) : pin.span.end]
    pieces = [(frames[0], frame - 1), (frame + 1, frames[-1])]
    left = [
        f"pin script[{first}{'' if first == last else f'..{last}'}]{behind}"
        for first, last in pieces
        if first <= last
    ]
    return [Change(pin.span.start, pin.span.end, "\n".join(left))]


def _freed_at_all(text: StoryText, pin: ast.Pin, who: str | None) -> list[Change]:
    """A statement without what it says of somebody, in all of its frames."""
    if pin.condition is not None:
        return _freed_of(text, pin, pin.condition, who)
    acts = _acts(pin)
    mine = [act for act in acts if same_name(act.who.id) == who]
    if who is None or (mine and len(acts) == 1):
        return [text.without(pin.span)]
    if not mine:
        return []
    number = acts.index(mine[0])
    if number:
        return [Change(acts[number - 1].span.end, mine[0].span.end, "")]
    return [Change(mine[0].span.start, acts[1].span.start, "")]


def _behind(text: StoryText, pin: ast.Pin) -> int:
    """Where a statement goes on behind the brackets of its frames."""
    index = pin.first if pin.last is None else pin.last
    return text.text.index("]", index.span.end) + 1


def _acts(pin: ast.Pin) -> list[ast.Move]:
    return [part for part in pin.turn if isinstance(part, ast.Move)]


def _told(pin: ast.Pin) -> tuple[object, ...]:
    """The things that a statement says."""
    return pin.turn if pin.condition is None else parts(pin.condition)


def _speaks_of(pin: ast.Pin, who: str) -> bool:
    if pin.condition is not None:
        return any(whose(part) == who for part in parts(pin.condition))
    return any(same_name(act.who.id) == who for act in _acts(pin))


def _freed_of(
    text: StoryText, statement: ast.Pin | ast.Start, condition: ast.Expr, who: str | None
) -> list[Change]:
    every = parts(condition)
    mine = [part for part in every if whose(part) == who]
    if who is None or len(mine) == len(every):
        return [text.without(statement.span)]
    return [_without_part(text, condition, part) for part in mine[:1]]


def during(text: StoryText, first: int, last: int, condition: str) -> StoryText:
    """A condition holds in frames first..last."""
    if not 1 <= first <= last <= (text.length or LONGEST_STORY):
        raise Refusal(USAGE, f"there are no frames {first} to {last}")
    _check_expression(condition)
    frames = f"{first}" if first == last else f"{first}..{last}"
    return text.with_statements([f"pin script[{frames}]: {condition}"], PINS)


def move(text: StoryText, frame: int, who: str | None, to: int) -> StoryText:
    """What pins somebody in a frame is said of another frame; of nobody, all that is said there."""
    if to < 1 or frame < 1 or to == frame:
        raise Refusal(USAGE, "a pin moves from one frame to another one")
    for statement in text.program.of(ast.Pin):
        frames = text.frames(statement)
        if frames is None or frame not in frames:
            continue
        if who is not None and not _speaks_of(statement, who):
            continue
        if len(frames) == 1 and (who is None or len(_told(statement)) == 1):
            index = statement.first.span
            return text.with_changes([Change(index.start, index.end, str(to))])
        left = text.with_changes(_freed(text, statement, frame, who))
        if who is None:
            behind = text.text[_behind(text, statement) : statement.span.end]
            line = f"pin script[{to}]{behind}"
        elif statement.condition is None:
            act = next(part for part in _acts(statement) if same_name(part.who.id) == who)
            line = f"pin script[{to}] = [{act.span.text}]"
        else:
            part = next(p for p in parts(statement.condition) if whose(p) == who)
            line = f"pin script[{to}]: {part.span.text}"
        return left.with_statements([line], PINS)
    raise Refusal(USAGE, f"{who or 'nobody'} is not pinned there")


def hold(text: StoryText, lines: Sequence[str], first: int, last: int) -> StoryText:
    """Statements that pin frames first..last, instead of what pinned them before."""
    gone: list[Change] = []
    for statement in text.program.of(ast.Pin):
        frames = text.frames(statement)
        if frames is None or frames[-1] < first or last < frames[0]:
            continue
        if frames[0] < first or last < frames[-1]:
            raise Refusal(REFUSED, "a pin of more frames than these is in the way")
        gone.append(text.without(statement.span))
    return text.with_changes(gone).with_statements(lines, PINS)


# The whole.


def start(text: StoryText, condition: str) -> StoryText:
    """A first picture instead of the one before."""
    starts = text.program.of(ast.Start)
    if starts:
        span = starts[-1].condition.span
        return text.with_changes([Change(span.start, span.end, condition)])
    return text.with_statements([f"start {condition}"], HEAD)


def length(text: StoryText, frames: int) -> StoryText:
    """So many frames."""
    if not 1 <= frames <= LONGEST_STORY:
        raise Refusal(USAGE, f"a film has 1 to {LONGEST_STORY:,} frames")
    said = text.program.of(ast.LengthIs)
    if said:
        span = said[-1].value
        return text.with_changes([Change(span.start, span.end, str(frames))])
    return text.with_statements([f"length {frames}"], (ast.World,))


def insert(text: StoryText, frame: int) -> StoryText:
    """A turn more before a frame; pins from there on move along."""
    if not 1 <= frame <= _frames(text) + 1:
        raise Refusal(USAGE, f"there is no frame {frame}")
    moved = lambda at: at + (at >= frame)
    return text.with_changes([*_longer(text, 1), *_moved(text, moved, moved)])


def cut(text: StoryText, frame: int) -> StoryText:
    """A turn less; what pinned it goes, and later pins move along."""
    if not 1 <= frame <= _frames(text) or _frames(text) == 1:
        raise Refusal(USAGE, f"frame {frame} cannot be cut")
    alone = [s for s in text.program.of(ast.Pin) if text.frames(s) == range(frame, frame + 1)]
    moved = _moved(text, lambda at: at - (at > frame), lambda at: at - (at >= frame), alone)
    gone = [text.without(statement.span) for statement in alone]
    return text.with_changes([*_longer(text, -1), *gone, *moved])


def _frames(text: StoryText) -> int:
    if text.length is None:
        raise Refusal(REFUSED, "the story's length is not written as a number")
    return text.length


def _longer(text: StoryText, by: int) -> list[Change]:
    said = text.program.of(ast.LengthIs)[-1]
    numbers = [n for n in (said.frames, said.most) if isinstance(n, ast.Number)]
    return [Change(n.span.start, n.span.end, f"{max(1, int(n.value) + by)}") for n in numbers]


def _moved(
    text: StoryText,
    first: Callable[[int], int],
    last: Callable[[int], int],
    but: Sequence[ast.Pin] = (),
) -> list[Change]:
    """The frames of pins elsewhere, where they are written as numbers."""
    changes = []
    for statement in text.program.of(ast.Pin):
        if statement.file is not None and statement not in but and _is_moved(text, statement, last):
            message = f"frames of {statement.file.value} are pinned here or later: they cannot move"
            raise Refusal(REFUSED, message)
        for index, moved in ((statement.first, first), (statement.last, last)):
            if isinstance(index, ast.Number) and statement not in but:
                changes.append(
                    Change(index.span.start, index.span.end, str(moved(int(index.value))))
                )
    return changes


def _is_moved(text: StoryText, statement: ast.Pin, moved: Callable[[int], int]) -> bool:
    frames = text.frames(statement)
    return frames is not None and moved(frames[-1]) != frames[-1]


def beats(text: StoryText, order: Sequence[int]) -> StoryText:
    """The beats of a story in another order."""
    for wanted in text.program.of(ast.Objective):
        for node in ast.walk(wanted.value):
            if isinstance(node, ast.Call) and node.callee.id == "beats":
                spans = [argument.span for argument in node.arguments]
                if sorted(order) != list(range(len(spans))):
                    raise Refusal(USAGE, f"an order of the numbers 0 to {len(spans) - 1}")
                pairs = zip(spans, order, strict=True)
                return text.with_changes(
                    [Change(to.start, to.end, spans[number].text) for to, number in pairs]
                )
    raise Refusal(USAGE, "the story has no `beats`")


def wish(text: StoryText, statement: str) -> StoryText:
    """One more thing to wish for: a `maximize` or `minimize`."""
    return text.with_statements([statement], (ast.Objective,))


# Curves.


def drawn(points: Sequence[Sequence[float]], low: float, high: float) -> str:
    """`points(...)` of what was drawn: pairs of a share of the film and a height."""
    if any(len(point) != 2 for point in points) or not 0 < high - low < math.inf:
        raise Refusal(USAGE, "points are pairs of a share of the film and a height")
    far = high - low
    reach = lambda y: min(max(y, low - far), high + far)
    by_time = {round(min(max(x, 0.0), 1.0), 3): reach(y) for x, y in points}
    ways = sorted(by_time.items())
    if len(ways) < 2:
        raise Refusal(USAGE, "a curve needs two points or more, from left to right")
    fine = FINENESS * far
    while len(kept := _simplified(ways, fine)) > MOST_POINTS:
        fine *= 1.4
    digits = max(0, 2 - math.floor(math.log10(far)))
    told = ", ".join(f"({x:g}, {_plain(round(y, digits))})" for x, y in kept)
    return f"points({told})"


def _plain(value: float) -> str:
    return f"{value + 0.0:.10g}"


def _simplified(ways: Sequence[tuple[float, float]], fine: float) -> list[tuple[float, float]]:
    """A line with fewer points, none of the others further from it (up or down) than `fine`:
    Ramer 1972, DOI 10.1016/S0146-664X(72)80017-0; Douglas and Peucker 1973."""
    (x0, y0), (x1, y1) = ways[0], ways[-1]
    off = [abs(y - (y0 + (y1 - y0) * (x - x0) / (x1 - x0))) for x, y in ways]
    worst = max(range(len(ways)), key=off.__getitem__)
    if off[worst] <= fine:
        return [ways[0], ways[-1]]
    return _simplified(ways[: worst + 1], fine)[:-1] + _simplified(ways[worst:], fine)


def followed(expression: str, curve: str, low: float, high: float) -> str:
    """A wish that an expression follow a curve: squared differences, each frame alike."""
    _check_expression(expression)
    weight = WANTED / (high - low) ** 2
    return f"minimize {weight:.3g} * sum_t ({expression} - {curve})^2"


def _check_expression(text: str) -> None:
    """Refuses what would be more than an expression, or none, behind a statement's words."""
    if "\n" in text or "\r" in text:
        raise Refusal(USAGE, "an expression stands on one line")
    try:
        parse_expression(Source("typed", text))
    except StoryError as problem:
        raise Refusal(USAGE, f"this is no expression: {problem.diagnostics[0].message}") from None
