"""Scripts of grid worlds: frames as JSON, and frames held against the world's rules."""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import product
from typing import Any, NoReturn

import numpy as np

from i2pdsl.errors import did_you_mean, error, shorten, whole_file
from i2pdsl.worlds.grid import model
from i2pdsl.worlds.grid.arrays import arrangement
from i2pdsl.worlds.grid.dynamics import initial_marks
from i2pdsl.worlds.grid.following import successor
from i2pdsl.worlds.grid.spec import PULLS, PUTS, STAY, Character, GridSpec
from i2pdsl.worlds.grid.symmetry import symmetries
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.record import Record, Trajectory

APART = 2.0  # cells: two scripts look alike if everyone stands closer than this, on average
_FAR = 4.0  # distance of something present from something absent


def state_as_json(spec: GridSpec, dynamics: Any, state: int) -> dict[str, list[int] | str | None]:
    """A state as the script file has it: [column, row] for each entity, the name of who carries
    it, or None."""
    found: dict[str, list[int] | str | None] = {}
    for name, cell in zip(spec.entities, dynamics.cells_of(state), strict=False):
        if cell < dynamics.absent:
            found[name] = [int(x) for x in dynamics.coordinates[cell]]
        else:
            who = int(cell) - dynamics.absent - 1
            found[name] = None if who < 0 else spec.characters[who].name
    return found


def frames_as_json(world: GridWorld, path: Trajectory) -> tuple[dict[str, Any], ...]:
    """The frames of a script file."""
    spec, dynamics, moves = world.spec, world.dynamics, world.moves
    frames = []
    for before, action, after in zip(path.states, path.actions, path.states[1:], strict=False):
        state = state_as_json(spec, dynamics, int(after))
        if action >= moves.turn_count:
            number = int(action) - moves.turn_count
            entity = moves.events[number // moves.slots]
            name = next(e for e, things in spec.events if spec.entities[entity] in things)
            to = [int(x) for x in dynamics.coordinates[number % moves.slots]]
            frames.append({"event": {name: spec.entities[entity], "to": to}, "state": state})
            continue
        frame: dict[str, Any] = {}
        steps, _ = model.steps(world.tables, moves, before, action)
        for who, (act, _) in enumerate(_decoded(world, int(action))):
            moved = bool(steps[who].after != steps[who].before)
            frame[spec.characters[who].name] = {"action": moves.actions[who][act], "moved": moved}
        frames.append({**frame, "event": None, "state": state})
    return tuple(frames)


def turn_in_words(world: GridWorld, action: int) -> str:
    """An action as a story appends it: `[cheese: west!, robot: stay]`."""
    moves = world.moves
    if action >= moves.turn_count:
        number = action - moves.turn_count
        thing = world.spec.entities[moves.events[number // moves.slots]]
        event = next(e for e, things in world.spec.events if thing in things)
        column, row = (int(x) for x in world.dynamics.coordinates[number % moves.slots])
        return f"[{event}: {thing} at ({column}, {row})]"
    acts = zip(world.spec.characters, _decoded(world, action), strict=True)
    told = (
        f"{who.name}: {who.actions[act]}{'' if success else '!'}" for who, (act, success) in acts
    )
    return f"[{', '.join(told)}]"


def kept_in_words(world: GridWorld, path: Trajectory, first: int, last: int) -> list[str]:
    """Statements that pin frames of a script as they are: the first in full, which leaves one
    picture from which it can come, and then what is done."""
    spec, states, actions = world.spec, path.states, path.actions
    state = state_as_json(spec, world.dynamics, int(states[first]))
    told = [placed_in_words(name, place) for name, place in state.items()]
    if actions[first - 1] < world.moves.turn_count:
        ask = lambda name, *arguments: world.feature(
            world.tables, name, arguments, states[first], states[first - 1], actions[first - 1]
        )
        for who, character in enumerate(spec.characters):
            told.append(f"{'' if ask('moved', who) else 'not '}moved({character.name})")
            movable = spec.numbers_of(character.pushes + character.pulls)
            for thing in sorted(movable) if ask("moved", who) else ():
                pushed, name = ask("pushes", who, thing), spec.entities[thing]
                told.append(f"{'' if pushed else 'not '}pushes({character.name}, {name})")
    return [
        f"pin script[{first}]: {' and '.join(told)}",
        *(
            f"pin script[{k}] = {turn_in_words(world, int(actions[k - 1]))}"
            for k in range(first, last + 1)
        ),
    ]


def placed_in_words(name: str, place: Sequence[int] | str | None) -> str:
    """Where something is in a state of a script file, as a condition."""
    if isinstance(place, str):
        return f"holds({place}, {name})"
    return f"absent({name})" if place is None else f"at({name}, ({place[0]}, {place[1]}))"


def _decoded(world: GridWorld, action: int) -> list[tuple[int, bool]]:
    numbers = np.unravel_index(action, world.moves.counts)
    return [world.moves.outcomes[who][int(n)] for who, n in enumerate(numbers)]


def distance(world: GridWorld, first: np.ndarray, second: np.ndarray) -> float:
    """How differently two scripts look, in cells; mirror images look alike (symmetry.py).

    The largest, over the characters and the things that move in either script, of the mean
    distance over time between where it stands in the one and in the other.

    Args:
        first, second: states [T + 1].
    """
    cells_of, absent = world.dynamics.cells_of, world.dynamics.absent
    a, b = cells_of(first).astype(np.int64), cells_of(second).astype(np.int64)
    nowhere = range(absent, world.spec.place_count)
    images = (np.array((*image, *nowhere)) for image in symmetries(world.spec))
    return min(_apart(world, a, image[b]) for image in images)


def _apart(world: GridWorld, a: np.ndarray, b: np.ndarray) -> float:
    """The distance of two scripts as they are, of cells [T + 1, E]."""
    characters = len(world.spec.characters)
    moves = (a != a[:1]).any(0) | (b != b[:1]).any(0)
    moves[:characters] = True
    place = world.tables.coordinates
    apart = np.abs(place[a] - place[b]).sum(-1).astype(float)
    absent = world.dynamics.absent
    apart = np.where((a >= absent) != (b >= absent), _FAR, np.minimum(apart, 2 * _FAR))
    return float(apart.mean(0)[moves].max())


def _somewhere(place: list[int] | str | None) -> str:
    if isinstance(place, str):
        return f"with {place}"
    return "absent" if place is None else f"at {place}"


class GridReader:
    """Holds a record against a world's rules, frame by frame."""

    def __init__(self, world: GridWorld, record: Record):
        self.world, self.record = world, record
        self.spec, self.dynamics = world.spec, world.dynamics

    def wrong(self, where: str, message: str, hint: str | None = None) -> NoReturn:
        raise error("script", f"{where}: {message}", whole_file(self.record.where), hint)

    def read(self) -> Trajectory:
        most = self.spec.settings.horizon
        if most and len(self.record.frames) > most:
            hint = f"the `horizon` of {self.spec.name} is {most}"
            self.wrong(f"frame {most + 1}", "the time is up", hint)
        states = [self.state(self.record.start, "start")]
        actions = []
        for number, frame in enumerate(self.record.frames, 1):
            action, after = self.frame(frame, states[-1], f"frame {number}")
            actions.append(action)
            states.append(after)
        # With a horizon, the number of a state tells its frame (model.py).
        frames = np.minimum(np.arange(len(states)), self.world.moves.frames - 1)
        numbers = np.array(states, dtype=np.int64) + frames * self.dynamics.state_count
        return Trajectory(np.array(actions, dtype=np.int64), numbers)

    def state(self, cells: Any, where: str, like: int | None = None) -> int:
        """The state that a file gives. Where everyone has been it does not say: nowhere else, or as
        in the state that it shall be `like`."""
        if not isinstance(cells, dict):
            self.wrong(where, "a state gives the cell of everyone")
        places = []
        for name in self.spec.entities:
            if name not in cells:
                self.wrong(where, f"where is `{name}`?")
            places.append(self.cell(name, cells[name], where))
        marks = initial_marks(self.spec, np.array(places))
        if like is not None:
            marks = self.dynamics.cells_of(like)[len(places) : len(places) + len(marks)]
        for name in cells:
            if name not in self.spec.entities:
                hint = did_you_mean(name, self.spec.entities)
                self.wrong(where, f"there is no `{shorten(name)}` in {self.spec.name}", hint)
        state = int(self.dynamics.state_of(np.array([*places, *marks])))
        if state < 0:
            there = [tuple(c) for c in cells.values() if isinstance(c, list | tuple)]
            for thing in filter(self.spec.is_fixed, self.spec.things):
                place = cells[thing.name]
                if isinstance(place, list | tuple) and tuple(place) != thing.cells[0]:
                    self.wrong(where, f"`{thing.name}` cannot be moved to {list(place)}")
            if len(set(there)) == len(there):
                self.wrong(where, "nobody can come there in time from where they are at first")
            self.wrong(where, "two of them stand on one cell")
        if where == "start" and not self.world.begins(np.asarray(state)):
            begins = state_as_json(self.spec, self.dynamics, int(self.world.starts()[0]))
            hint = ", ".join(f"{name} {place}" for name, place in begins.items())
            self.wrong(where, f"{self.spec.name} begins in another way", hint)
        return state

    def cell(self, name: str, place: Any, where: str) -> int:
        thing = next((t for t in self.spec.things if t.name == name), None)
        if place is None:
            if thing is None or not (thing.may_be_absent or thing.opened_by):
                self.wrong(where, f"`{name}` cannot be absent")
            return self.dynamics.absent
        holders = self.spec.holders(name) if thing else ()
        if isinstance(place, str) and holders:
            who = next((i for i in holders if self.spec.characters[i].name == place), None)
            if who is None:
                self.wrong(where, f"`{shorten(place)}` cannot carry `{name}`")
            return self.dynamics.absent + 1 + who
        good = (
            isinstance(place, list | tuple)
            and len(place) == 2
            and all(isinstance(x, int) and not isinstance(x, bool) for x in place)
        )
        if not good:
            self.wrong(where, f"the place of `{name}` is written [column, row]")
        column, row = place
        number = self.world.cell_number.get((column, row))
        if number is None:
            shown = shorten(f"[{column}, {row}]")
            self.wrong(where, f"`{name}` cannot stand at {shown}: there is no free cell")
        return number

    def frame(self, frame: dict[str, Any], state: int, where: str) -> tuple[int, int]:
        # Where everyone has been only the rules say, by what was done.
        expected = None if self.spec.marks else self.state(frame.get("state"), where)
        if frame.get("event") is not None:
            action, after = self.event(frame, state, where)
        else:
            action, after = self.turn(frame, state, where)
        if expected is None:
            expected = self.state(frame.get("state"), where, after)
        if after != expected:
            self.differs(after, expected, where)
        return action, after

    def differs(self, after: int, expected: int, where: str) -> NoReturn:
        rules = state_as_json(self.spec, self.dynamics, after)
        given = state_as_json(self.spec, self.dynamics, expected)
        for name, place in rules.items():
            if given[name] != place:
                shown, got = map(_somewhere, (place, given[name]))
                self.wrong(where, f"by the world's rules `{name}` is {shown}, not {got}")
        raise AssertionError("two states differ in no entity")

    def event(self, frame: dict[str, Any], state: int, where: str) -> tuple[int, int]:
        event = frame["event"]
        for name in frame:
            if any(name == c.name for c in self.spec.characters):
                self.wrong(where, f"an event fills a whole frame, but `{name}` acts in it")
            if name not in ("event", "state"):
                self.wrong(where, f"there is no character `{shorten(name)}`")
        known = dict(self.spec.events)
        names = [k for k in event if k != "to"] if isinstance(event, dict) else []
        if len(names) != 1 or names[0] not in known or event[names[0]] not in known[names[0]]:
            shown = [
                f'{{"{e}": "{t}", "to": [column, row]}}' for e, ts in known.items() for t in ts
            ]
            hint = "events: " + ", ".join(shown) if shown else "this world has no events"
            self.wrong(where, f"there is no event {shorten(json.dumps(event))}", hint)
        thing = event[names[0]]
        if event.get("to") is None:
            self.wrong(where, f"where does `{thing}` fall?", '"to": [column, row]')
        entity = self.spec.entities.index(thing)
        cell = self.cell(thing, event.get("to"), where)
        tables, moves = self.world.tables, self.world.moves
        number = moves.events.index(entity) * moves.slots + cell
        after, possible = self.world.drops(tables, np.asarray(state))
        if not possible[number]:
            place = int(self.dynamics.cells_of(state)[entity])
            why = "the cell is taken" if place == self.dynamics.absent else "it is there already"
            self.wrong(where, f"`{thing}` cannot fall there: {why}")
        return moves.turn_count + number, int(arrangement(tables, after[number]))

    def turn(self, frame: dict[str, Any], state: int, where: str) -> tuple[int, int]:
        code, current = 0, state
        known = [c.name for c in self.spec.characters]
        for name in frame:
            if name not in ("event", "state", *known):
                hint = did_you_mean(name, known)
                self.wrong(where, f"there is no character `{shorten(name)}`", hint)
        acts = [self.act(frame.get(c.name), c, where) for c in self.spec.characters]
        if self.world.moves.together:
            return self.turn_together(acts, state, where)
        for who, (act, moved) in enumerate(acts):
            after = int(successor(self.world.tables, who, np.asarray(act), np.asarray(current)))
            self.check_moved(who, act, moved, after != current, where)
            success = moved or after == current
            outcome = self.world.moves.outcomes[who].index((act, success))
            code = code * self.world.moves.counts[who] + outcome
            current = after if success else current
        return code, current

    def turn_together(
        self, acts: list[tuple[int, bool]], state: int, where: str
    ) -> tuple[int, int]:
        """Two who act together: whether one can move may hang on whether the other does."""
        tables, moves = self.world.tables, self.world.moves
        options = [
            [(act, True), (act, False)] if moves.weak[who] and act != STAY else [(act, True)]
            for who, (act, _) in enumerate(acts)
        ]
        would: list[bool] = []
        for chosen in product(*options):
            number = self.world.turn_number(chosen)
            steps, end = model.steps(tables, moves, np.asarray(state), number)
            seen = [bool(step.after != step.before) for step in steps]
            if seen == [moved for _, moved in acts]:
                return int(number), int(end)
            would = would or [bool(step.would) for step in steps]
        for who, (act, moved) in enumerate(acts):
            self.check_moved(who, act, moved, would[who], where)
        return self.wrong(where, "by the world's rules they cannot move so at the same time")

    def check_moved(self, who: int, act: int, moved: bool, can: bool, where: str) -> None:
        """Refuses a move of what is blocked, and a failure of who is strong."""
        character = self.spec.characters[who]
        name, action = character.name, character.actions[act]
        if moved and not can:
            reason = "staying moves nobody" if act == STAY else "the way is blocked"
            reason = "there is nothing to pull, or no room" if action in PULLS else reason
            reason = "it holds nothing that could go there" if action in PUTS else reason
            self.wrong(where, f"`{name}` cannot move {action}: {reason}")
        if not moved and can and not character.is_weak:
            message = f"`{name}` goes {action} and must move: only a weak one can fail"
            self.wrong(where, message, '"moved": true')

    def act(self, entry: Any, character: Character, where: str) -> tuple[int, bool]:
        name, known = character.name, character.actions
        if not isinstance(entry, dict) or "action" not in entry:
            example = f'"{name}": {{"action": "stay", "moved": false}}'
            self.wrong(where, f"what does `{name}` do?", example)
        if entry["action"] not in known:
            word = str(entry["action"])
            hint = did_you_mean(word, known)
            self.wrong(where, f"there is no action `{shorten(word)}`", hint)
        if not isinstance(entry.get("moved"), bool):
            self.wrong(where, f"did `{name}` move?", '"moved": true or false')
        return known.index(entry["action"]), entry["moved"]
