"""Scripts of listed worlds: frames as JSON and in words, and frames held against the rules."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np

from i2pdsl.errors import did_you_mean, error, shorten, whole_file
from i2pdsl.language.typed import Act
from i2pdsl.language.vocabulary import STAY
from i2pdsl.worlds.listed.world import ListedWorld
from i2pdsl.worlds.record import Record, Trajectory, empty, extended

APART = 2.0  # cells: two scripts look alike if everyone stands closer than this, on average


def state_as_json(world: ListedWorld, state: Any) -> dict[str, list[int]]:
    """A state as the script file has it: [column, row] of each character and thing."""
    tables, words = world.tables, world.vocabulary
    places = tables.coordinates[tables.cells[int(state)]].tolist()
    return dict(zip((*words.characters, *words.things), places, strict=True))


def frames_as_json(world: ListedWorld, path: Trajectory) -> tuple[dict[str, Any], ...]:
    """The frames of a script file: what each character does, whether that moved it, and the state
    after it."""
    frames = []
    for before, action, after in zip(path.states, path.actions, path.states[1:], strict=False):
        frame: dict[str, Any] = {}
        for number, (who, name) in enumerate(acts(world, action).items()):
            moved = bool(world.feature(world.tables, "moved", (number,), after, before, action))
            frame[who] = {"action": name, "moved": moved}
        frames.append({**frame, "state": state_as_json(world, after)})
    return tuple(frames)


def acts(world: ListedWorld, action: Any) -> dict[str, str]:
    """What each character does in a frame."""
    numbers = np.unravel_index(int(action), world.counts)
    pairs = zip(world.vocabulary.characters, numbers, strict=True)
    return {who: world.vocabulary.actions_of(who)[number] for who, number in pairs}


def turn_in_words(world: ListedWorld, action: Any) -> str:
    """A turn as a story appends it: `[walker: east]`."""
    return f"[{', '.join(f'{who}: {name}' for who, name in acts(world, action).items())}]"


def kept_in_words(world: ListedWorld, path: Trajectory, first: int, last: int) -> list[str]:
    """Statements that pin frames of a script as they are: where everybody is in the first of them,
    and what is done."""
    state = state_as_json(world, path.states[first])
    told = " and ".join(f"at({who}, ({c}, {r}))" for who, (c, r) in state.items())
    return [
        f"pin script[{first}]: {told}",
        *(
            f"pin script[{k}] = {turn_in_words(world, path.actions[k - 1])}"
            for k in range(first, last + 1)
        ),
    ]


def naive(
    world: ListedWorld, length: int, allowed: np.ndarray, rational: np.ndarray, seed: int
) -> Trajectory:
    """Everybody does what the first viewer expects most, under a hypothesis drawn from `rational`,
    from a start drawn from `allowed`; of what is expected alike, one thing by chance."""
    generator = np.random.default_rng(seed)
    path = empty(world, generator.choice(allowed))
    hypothesis = generator.choice(np.flatnonzero(rational))
    for _ in range(length):
        state, code = path.states[-1], 0
        for policy, after in zip(world.tables.log_policy, world.tables.after, strict=True):
            likely = policy[state, :, 0, hypothesis]
            best = generator.choice(np.flatnonzero(likely >= likely.max() - 1e-9))
            code, state = code * len(likely) + int(best), after[state, best]
        path = extended(world, path, [code])
    return path


def distance(world: ListedWorld, first: np.ndarray, second: np.ndarray) -> float:
    """How far everybody stands from where it stands in another script, on average, in APART
    cells."""
    places = [world.tables.coordinates[world.tables.cells[states]] for states in (first, second)]
    return float(np.abs(places[0] - places[1]).sum(-1).mean() / APART)


def read_listed(world: ListedWorld, record: Record) -> Trajectory:
    """A script in the world's numbers, held against its rules. Raises StoryError."""
    return _Reader(world, record).read()


class _Reader:
    def __init__(self, world: ListedWorld, record: Record):
        self.world, self.record, self.words = world, record, world.vocabulary
        self.names = (*self.words.characters, *self.words.things)

    def wrong(self, where: str, message: str, hint: str | None = None) -> NoReturn:
        raise error("script", f"{where}: {message}", whole_file(self.record.where), hint)

    def read(self) -> Trajectory:
        state = self.start()
        states, actions = [state], []
        for number, frame in enumerate(self.record.frames, 1):
            where = f"frame {number}"
            action = self.action(frame, where)
            state = int(self.world.transition(self.world.tables, np.asarray(state), action))
            told, rules = self.places(frame.get("state"), where), state_as_json(self.world, state)
            for name, place in rules.items():
                if told[name] != place:
                    message = f"by the world's rules `{name}` is at {place}, not at {told[name]}"
                    self.wrong(where, message)
            actions.append(int(action))
            states.append(state)
            self.moved(frame, states, actions, where)
        return Trajectory(np.array(actions, dtype=np.int64), np.array(states, dtype=np.int64))

    def start(self) -> int:
        told = self.places(self.record.start, "start")
        every = self.world.tables.coordinates[self.world.tables.cells]  # [S, E, 2]
        same = (every == np.array([told[name] for name in self.names])).all((-1, -2))
        if not same.any():
            self.wrong("start", "nobody can stand so in this world")
        state = int(np.flatnonzero(same)[0])
        if not self.world.begins[state]:
            self.wrong("start", f"{self.world.name} begins in another way")
        return state

    def places(self, state: Any, where: str) -> dict[str, list[int]]:
        """Where everybody is, [column, row]."""
        if not isinstance(state, dict):
            self.wrong(where, "a state gives the cell of everyone")
        for name in state:
            if name not in self.names:
                hint = did_you_mean(name, self.names)
                self.wrong(where, f"there is no `{shorten(name)}` in {self.world.name}", hint)
        found = {}
        for name in self.names:
            place = state.get(name)
            if not isinstance(place, list | tuple) or [type(x) for x in place] != [int, int]:
                self.wrong(where, f"the place of `{name}` is written [column, row]")
            if tuple(place) not in self.words.free:
                shown = shorten(json.dumps(place))
                self.wrong(where, f"`{name}` cannot stand at {shown}: there is no cell")
            found[name] = list(place)
        return found

    def action(self, frame: dict[str, Any], where: str) -> np.ndarray:
        """What is done in a frame, in the world's numbers."""
        for name in frame:
            if name not in ("state", "event", *self.words.characters):
                hint = did_you_mean(name, self.words.characters)
                self.wrong(where, f"there is no character `{shorten(name)}`", hint)
        if frame.get("event") is not None:
            self.wrong(where, "there are no events in this world")
        turn: list[Act] = []
        for who in self.words.characters:
            entry, own = frame.get(who), self.words.actions_of(who)
            if not isinstance(entry, dict) or not isinstance(entry.get("moved"), bool):
                example = f'"{who}": {{"action": "{STAY}", "moved": false}}'
                self.wrong(where, f"what does `{who}` do?", example)
            if entry.get("action") not in own:
                shown = str(entry.get("action"))
                hint = did_you_mean(shown, own) or f"it can: {', '.join(own)}"
                self.wrong(where, f"there is no action `{shorten(shown)}` of `{who}`", hint)
            turn.append(Act(self.words.actions.index(entry["action"]), False))
        return np.asarray(self.world.act(self.world.tables, np.asarray(0), tuple(turn))[0])

    def moved(
        self, frame: dict[str, Any], states: Sequence[int], actions: Sequence[int], where: str
    ) -> None:
        """Holds against the rules whether each character moved."""
        path = Trajectory(np.array(actions[-1:]), np.array(states[-2:]))
        (rules,) = frames_as_json(self.world, path)
        for who in self.words.characters:
            if frame[who]["moved"] != rules[who]["moved"]:
                does = "moves" if rules[who]["moved"] else "moves nobody"
                message = f"by the world's rules `{frame[who]['action']}` of `{who}` {does} there"
                self.wrong(where, message)
