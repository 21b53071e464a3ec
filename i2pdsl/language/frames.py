"""Time: scripts and their frames, appended turns, and sums over t."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from i2pdsl.errors import did_you_mean
from i2pdsl.language import ast
from i2pdsl.language import typed as ty
from i2pdsl.language.elaboration import INSIDE, ITEMS_IN_WORDS, Item, LeavesAtZero, Stop
from i2pdsl.language.evaluate import NotFiniteError, affine, evaluate, finite_values, is_pure
from i2pdsl.language.predicates import Predicates
from i2pdsl.language.scope import Env
from i2pdsl.language.vocabulary import STAY

_WHOLE = 1e-9  # how far an index may be from a whole number


class Frames(Predicates):
    """Scripts, frames and sums."""

    # Sums over t.

    def on_reduction(self, node: ast.Reduction, env: Env) -> Item:
        if env.inside:
            what = f"stand inside {INSIDE[env.inside]}"
            raise self.misplaced_sum(f"a sum over t cannot {what}", node, env)
        if env.sum_span is not None:
            raise self.misplaced_sum("sums over t do not nest", node, env)
        times = self.summed_frames(node, env)
        reached = () if env.is_dead else None
        inner = replace(env, times=times, reached=reached, sum_span=node.span, after_sum=False)
        body = self.number(node.body, inner)
        if not times:
            return Item("number", ty.Constant(0.0))
        longest = self.length + max(
            (len(n.turns) for n in ty.walk(body) if isinstance(n, ty.Moment)), default=0
        )
        if times[-1] > longest:
            span = node.last.span if node.last is not None else node.span
            message = f"the script has {_frames(longest)}, this goes to {times[-1]}"
            raise self.fail("range", message, span, env)
        body = self.folded(body, times, node, inner)
        total: ty.Typed = ty.Reduction(node.kind, times[0], times[-1], body)
        if node.kind == "sum" and self.weight is not None and self.grows(node, times, env):
            total = ty.Apply("multiply", (ty.Constant(self.weight), total))
        return Item("number", total)

    def grows(self, node: ast.Reduction, times: range, env: Env) -> bool:
        """Whether a sum covers other frames where the story is longer."""
        if node.first is None:
            return True
        self.length += 1
        try:
            return self.summed_frames(node, env) != times
        finally:
            self.length -= 1

    def beats(self, node: ast.Call, env: Env) -> Item:
        """Sums over t that take turns: none has fewer frames than half of an equal share."""
        self.check_arity(node, env)
        if env.inside or env.sum_span is not None:
            place = INSIDE[env.inside] if env.inside else "a sum over t"
            raise self.fail("nested-sum", f"beats cannot stand inside {place}", node.span, env)
        count = len(node.arguments)
        if self.length < count:
            message = f"{count} beats need {count} frames, the story has {self.length}"
            raise self.fail("range", message, node.span, env)
        values = self.each([lambda a=a: self.number(a.value, env) for a in node.arguments])  # type: ignore[misc]
        parts = self.each(
            [
                lambda a=a, v=v: self.of_a_frame(v, a.value, env)  # type: ignore[misc]
                for a, v in zip(node.arguments, values, strict=True)
            ]
        )
        least = max(1, self.length // (2 * count))
        return Item("number", ty.Beats(tuple(parts), least, self.length))

    def of_a_frame(self, value: ty.Typed, node: ast.Expr, env: Env) -> ty.Typed:
        """What a sum over all frames adds up, of sums that are added and scaled too."""
        match value:
            case ty.Reduction(kind="sum", first=1, last=self.length):
                return value.body
            case ty.Apply(operation="add" | "negate", arguments=arguments):
                each = tuple(self.of_a_frame(a, node, env) for a in arguments)
                return replace(value, arguments=each)
            case ty.Apply(operation="multiply" | "divide", arguments=(one, other)):
                if is_pure(other):
                    return replace(value, arguments=(self.of_a_frame(one, node, env), other))
                if is_pure(one) and value.operation == "multiply":
                    return replace(value, arguments=(one, self.of_a_frame(other, node, env)))
        message = "a beat is a sum over all t, which this is not"
        raise self.blame("type", message, node, env, "`beats(depict(A), sum_t ...)`")

    def summed_frames(self, node: ast.Reduction, env: Env) -> range:
        """The frames that a sum covers; one short of its beginning it is empty."""
        if node.first is None or node.last is None:
            return range(1, self.length + 1)
        lower, upper = node.first, node.last
        bounds = self.each([lambda: self.constant(lower, env), lambda: self.constant(upper, env)])
        first, last = math.ceil(bounds[0]), math.floor(bounds[1])
        span = lower.span.to(upper.span)
        if first < 0:
            message = "frames count from 1, and 0 is the state before anything moved"
            raise self.fail("range", message, span, env)
        if first > last + 1 or (first > last and node.kind != "sum"):
            raise self.fail("range", f"there is no frame in {first}..{last}", span, env)
        if last > 2 * self.length + 1000:
            message = f"the story has {_frames(self.length)}, this goes to {last:,}"
            raise self.fail("range", message, span, env)
        return range(first, last + 1)

    def misplaced_sum(self, message: str, node: ast.Reduction, env: Env) -> Stop:
        """Reports a sum inside a sum or an event; one within a pattern, where it was used."""
        around = env.sum_span
        within = [
            i
            for i, (_, span) in enumerate(env.uses)
            if around is not None
            and span.source is around.source
            and around.start <= span.start < around.end
        ]
        written_inside = (
            around is not None
            and around.source is node.span.source
            and around.start < node.span.start < around.end
        )
        if not env.uses or written_inside:
            hint = "one `sum_t` over everything is enough" if not env.inside else None
            return self.fail("nested-sum", message, node.span, env, hint)
        index = within[0] if within else len(env.uses) - 1
        name, span = env.uses[index]
        hint = f"`{name}` is a sum over t already"
        return self.fail("nested-sum", message, span, replace(env, uses=env.uses[:index]), hint)

    # Scripts and their frames.

    def on_script(self, node: ast.Script, env: Env) -> Item:
        return Item("script", ())

    def on_append(self, node: ast.Append, env: Env) -> Item:
        turns, turn = self.both(
            lambda: self.script(node.script, env), lambda: self.turn(node.turn, env)
        )
        if isinstance(turn, tuple):
            self.check_whole(turn, node.turn, env)
        if self.world.longest is not None and self.length + len(turns) >= self.world.longest:
            message = f"after {self.world.longest} frames the time in {self.world.world} is up"
            raise self.fail(
                "turn", message, node.span, env, "a shorter story, or a longer `horizon`"
            )
        return Item("script", (*turns, turn))

    def script(self, node: ast.Expr, env: Env) -> tuple[ty.Turn, ...]:
        item = self.item(node, env)
        if item.kind != "script":
            hint = "a script is `script` or `script ++ [...]`, without an index"
            raise self.blame(
                "type", f"expected a script, found {ITEMS_IN_WORDS[item.kind]}", node, env, hint
            )
        return item.value

    def turn(
        self, turn: tuple[ast.Move | ast.Fall, ...], env: Env
    ) -> tuple[ty.Act | None, ...] | ty.Drop:
        """What is done in a frame, None for who is not named."""
        if not self.world.enumerable:
            span = turn[0].span.to(turn[-1].span)
            message = "turns can be given where actions have names; this world's are continuous"
            raise self.fail("world", message, span, env)
        falls = [m for m in turn if isinstance(m, ast.Fall)]
        if falls:
            if len(turn) > 1:
                message = "an event has its frame for itself, nobody acts in it"
                hint = "it is a turn of its own: `script ++ [...] ++ [...]`"
                raise self.fail("turn", message, turn[1].span, env, hint)
            return self.fall(falls[0], env)
        moves = [m for m in turn if isinstance(m, ast.Move)]
        acts: dict[str, ty.Act] = {}
        for name, act, move in self.each([lambda m=m: self.act(m, env) for m in moves]):  # type: ignore[misc]
            if name in acts:
                raise self.fail("turn", f"`{name}` acts twice in this turn", move.span, env)
            acts[name] = act
        return tuple(map(acts.get, self.world.characters))

    def check_whole(
        self, acts: Sequence[ty.Act | None], turn: tuple[ast.Move | ast.Fall, ...], env: Env
    ) -> None:
        """Refuses a turn in which it is not said what everybody does."""
        missing = [c for c, act in zip(self.world.characters, acts, strict=True) if act is None]
        if missing:
            message = f"the turn does not say what {' and '.join(missing)} does"
            span = turn[0].span.to(turn[-1].span)
            raise self.fail("turn", message, span, env, f"add `{missing[0]}: stay`")

    def act(self, move: ast.Move, env: Env) -> tuple[str, ty.Act, ast.Move]:
        def action() -> int:
            stripped, inner = self.strip(move.action, env, self.world.actions, "an action")
            if not isinstance(stripped, ast.Name) or stripped.id not in self.world.actions:
                shown = stripped.span.text
                hint = did_you_mean(shown, self.world.actions)
                message = f"there is no action `{shown}`"
                raise self.fail("no-action", message, stripped.span, inner, hint)
            return self.world.actions.index(stripped.id)

        who, chosen = self.both(lambda: self.character(move.who, env), action)
        name = self.world.characters[who]
        known = self.world.actions_of(name)
        if self.world.actions[chosen] not in known:
            message = f"`{name}` cannot do this: {self.world.actions[chosen]}"
            raise self.fail(
                "no-action", message, move.action.span, env, f"it can: {', '.join(known)}"
            )
        stays = self.world.actions[chosen] == STAY
        if move.fails and (name not in self.world.can_fail or stays):
            reason = "staying" if stays else f"a move of {name}"
            raise self.fail("turn", f"{reason} cannot fail", move.span, env, "leave out the `!`")
        return name, ty.Act(chosen, move.fails), move

    def fall(self, fall: ast.Fall, env: Env) -> ty.Drop:
        event, thing = fall.event.id, fall.thing.id
        if event not in self.world.events:
            hint = did_you_mean(event, self.world.events)
            raise self.fail("no-event", f"there is no event `{event}`", fall.event.span, env, hint)
        stripped, inner = self.strip(fall.thing, env, self.world.events[event], "an object")
        thing = stripped.id if isinstance(stripped, ast.Name) else stripped.span.text
        if thing not in self.world.events[event]:
            hint = did_you_mean(thing, self.world.events[event])
            message = f"`{event}` brings no `{thing}`"
            raise self.fail("no-event", message, stripped.span, inner, hint)
        cells = self.place(fall.place, env)
        assert not isinstance(cells, ty.Point)  # events happen on maps
        if len(cells) != 1:
            message = f"this tile lies on {len(cells)} cells, and only one can be hit"
            raise self.blame("no-place", message, fall.place, env, "write (column, row)")
        return ty.Drop(event, thing, cells[0])

    def on_lastof(self, node: ast.LastOf, env: Env) -> Item:
        turns = self.script(node.script, env)
        return Item("number", ty.Constant(float(self.length + len(turns))))

    def on_prefix(self, node: ast.Prefix, env: Env) -> Item:
        if node.until is None:
            return Item("prefix", self.at(node.script, node.end, 0, env))
        until = node.until
        moment, seen = self.both(
            lambda: self.at(node.script, node.end, 1, env), lambda: self.observed(until, env)
        )
        return Item("prefix", replace(moment, seen=seen))

    def observed(self, node: ast.Expr, env: Env) -> int | None:
        """How many actions of a frame viewers have seen once a character has acted; None is all."""
        number = self.character(node, replace(env, inside="")) + 1
        if not self.world.enumerable:
            message = (
                f"viewers of world {self.world.world} see a frame at once, not action by action"
            )
            raise self.blame("world", message, node, env, "write `script[:t]`")
        return number if number < len(self.world.characters) else None

    def on_frameof(self, node: ast.FrameOf, env: Env) -> Item:
        return Item("frame", self.at(node.script, node.number, 1, env))

    def at(self, script: ast.Expr, index: ast.Expr, lowest: int, env: Env) -> ty.Moment:
        """The moment that an index points to, for every t."""
        plain = replace(env, inside="")
        turns, value = self.both(
            lambda: self.script(script, plain), lambda: self.number(index, plain)
        )
        if not is_pure(value) or value.axes.hypothesis:
            message = "the number of a frame depends on t and constants only"
            raise self.blame("index", message, index, env)
        longest = self.length + len(turns)
        if env.is_dead:
            return ty.Moment(turns, (lowest,), None)
        if not value.axes.time:
            frames = self.whole_numbers([float(evaluate(value))], (None,), index, env)
            self.check_frames(zip((None,), frames, strict=True), lowest, longest, index, env)
            return ty.Moment(turns, tuple(frames), None)
        assert env.times is not None
        line = affine(value)
        if line is not None and line[0] != 0 and all(x == int(x) for x in line):
            # A line leaves the script at its ends first.
            slope, height = int(line[0]), int(line[1])
            numbers = range(
                slope * env.times.start + height, slope * env.times.stop + height, slope
            )
            ends = sorted({*env.ts[:1], *env.ts[-1:]})
            if any(not lowest <= slope * t + height <= longest for t in ends):
                every = ((t, slope * t + height) for t in env.ts)
                self.check_frames(every, lowest, longest, index, env)
            return ty.Moment(turns, numbers, env.times.start)
        try:
            exact = list(map(float, finite_values(value, env.ts)))
        except NotFiniteError as problem:
            raise self.not_finite(problem, index, env) from None
        frames = self.whole_numbers(exact, env.ts, index, env)
        self.check_frames(zip(env.ts, frames, strict=True), lowest, longest, index, env)
        known = dict(zip(env.ts, frames, strict=True))
        every_frame = tuple(known.get(t, lowest) for t in env.times)
        return ty.Moment(turns, every_frame, env.times.start)

    def whole_numbers(
        self, exact: list[float], ts: Sequence[int | None], index: ast.Expr, env: Env
    ) -> list[int]:
        for t, number in zip(ts, exact, strict=True):
            if abs(number - round(number)) > _WHOLE:
                where = "" if t is None else f" at t = {t}"
                message = f"frames have whole numbers, this is {number:g}{where}"
                raise self.blame("index", message, index, env)
        return [round(x) for x in exact]

    def check_frames(
        self,
        numbers: Iterable[tuple[Any, int]],
        lowest: int,
        longest: int,
        index: ast.Expr,
        env: Env,
    ) -> None:
        """Refuses an index that leaves the script at some t that reaches it."""
        numbers = list(numbers)
        wrong = next(((t, f) for t, f in numbers if not lowest <= f <= longest), None)
        if wrong is None:
            return
        t, frame = wrong
        if frame < lowest and self.query and t == 0 and env.sum_span is None:
            raise LeavesAtZero
        where = "" if t is None else f" at t = {t}"
        message = f"the script has {_frames(longest)}, this is {frame}{where}"
        if frame < lowest:
            rule = "frames count from 1" if lowest else "a script has no fewer than 0 frames"
            message = f"{rule}, this is {frame}{where}"
        inside = [t for t, f in numbers if lowest <= f <= longest]
        hint = None
        if t is not None and inside and env.sum_span is not None:
            last = f"T-{self.length - inside[-1]}" if inside[-1] < self.length else "T"
            hint = f"sum over fewer frames: `sum_{{t in {inside[0]}..{last}}} ...`"
        raise self.blame("index", message, index, env, hint)


def _frames(count: int) -> str:
    return f"{count:,} frame{'' if count == 1 else 's'}"
