"""Planes as a kind of world (worlds/kind.py): nothing to plan or train, scripts descended to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from i2pdsl.errors import Diagnostic, Source, whole_file
from i2pdsl.language.forms import Word
from i2pdsl.language.scope import Module
from i2pdsl.language.story import TypedStory
from i2pdsl.language.vocabulary import Vocabulary, show_value
from i2pdsl.worlds.beginnings import roles_among
from i2pdsl.worlds.drawings import Files
from i2pdsl.worlds.kind import Kind, Watch
from i2pdsl.worlds.plane.hypotheses import plane_hypotheses
from i2pdsl.worlds.plane.parse import SYNTAX, parse_plane
from i2pdsl.worlds.plane.spec import PlaneSpec
from i2pdsl.worlds.plane.vocabulary import plane_vocabulary

if TYPE_CHECKING:
    import numpy as np

    from i2pdsl.worlds.plane.world import PlaneWorld
    from i2pdsl.worlds.positions import Inferred, Positions
    from i2pdsl.worlds.record import Record, Trajectory
    from i2pdsl.worlds.world import Viewer


class PlaneKind(Kind):
    syntax = SYNTAX
    suggested = (20, 1000)

    def parse(self, source: Source, name: str, files: Files | None = None) -> PlaneSpec:
        return parse_plane(source, name)

    def imagined_otherwise(self, spec: PlaneSpec) -> PlaneSpec:
        """By the other observer."""
        other = {"step": "path", "path": "step"}[spec.settings.observer]
        return spec.with_settings({"observer": other})

    def vocabulary(self, spec: PlaneSpec) -> Vocabulary:
        return plane_vocabulary(spec)

    def as_json(self, spec: PlaneSpec) -> dict[str, Any]:
        return {
            "size": [spec.width, spec.height],
            "walls": [
                {"points": [list(p) for p in w.points], "closed": w.closed} for w in spec.walls
            ],
            "places": [{"name": p.name, "at": list(p.at), "radius": p.radius} for p in spec.places],
            "characters": [
                {
                    "name": c.name,
                    "at": list(c.at),
                    "radius": c.radius,
                    "speed": c.speed,
                    "mass": c.mass,
                    "goals": list(c.goals),
                    "toward": c.toward,
                    "attitude": list(c.attitude),
                }
                for c in spec.characters
            ],
        }

    def in_words(self, spec: PlaneSpec) -> list[str]:
        walls = len(spec.segments)
        lines = [
            f"{spec.width:g} x {spec.height:g} units, {walls or 'no'} wall{'s' * (walls != 1)}, "
            f"{len(plane_hypotheses(spec))} hypotheses; continuous actions",
            "",
        ]
        for c in spec.characters:
            x, y = c.at
            lines.append(
                f"character {c.name}: radius {c.radius:g}, speed {c.speed:g} a frame, at "
                f"({x:g}, {y:g})"
            )
        lines += [
            f"place {p.name}: radius {p.radius:g}, at ({p.at[0]:g}, {p.at[1]:g})"
            for p in spec.places
        ]
        return lines

    def warnings(
        self, spec: PlaneSpec, where: str, story: TypedStory | None = None
    ) -> tuple[Diagnostic, ...]:
        """Goals that a character cannot reach from where it begins."""
        if story is not None or not spec.walls:
            return ()
        from i2pdsl.worlds.plane.geometry import unreachable

        found = []
        for c in spec.characters:
            goals = [p for p in spec.places if p.name in c.goals]
            beyond = unreachable(spec.segments, c.radius, spec.width, spec.height, c.at,
                                 [p.at for p in goals])  # fmt: skip
            for place, is_beyond in zip(goals, beyond, strict=True):
                if is_beyond:
                    message = f"`{c.name}` cannot get from where it begins to `{place.name}`"
                    span = whole_file(where)
                    found.append(Diagnostic("world-goal", message, span, severity="warning"))
        return tuple(found)

    def roles(self, spec: PlaneSpec, words: Vocabulary) -> dict[str, str]:
        """Who has an attitude counts mostly the other's fortune: nothing else keeps it to its goal,
        and it would never get there. So the other acts."""
        return roles_among(spec.characters, words, first="helped")

    def has_same_rules(self, one: PlaneSpec, other: PlaneSpec) -> bool:
        return replace(one, settings=other.settings) == other

    # Ready to be searched and asked.

    def build(self, spec: PlaneSpec, viewers: tuple[Viewer, ...], watch: Watch) -> PlaneWorld:
        from i2pdsl.worlds.plane.world import build_plane

        return build_plane(spec, viewers)

    def rules(self, spec: PlaneSpec) -> PlaneWorld:
        from i2pdsl.worlds.plane.world import build_plane

        return build_plane(spec)

    # Scripts.

    def start_as_json(self, world: PlaneWorld, state: Any) -> dict[str, Any]:
        from i2pdsl.worlds.plane.script import state_as_json

        return state_as_json(world, state)

    def frames_as_json(self, world: PlaneWorld, path: Trajectory) -> tuple[dict[str, Any], ...]:
        from i2pdsl.worlds.plane.script import frames_as_json

        return frames_as_json(world, path)

    def read(self, world: PlaneWorld, record: Record) -> Trajectory:
        from i2pdsl.worlds.plane.script import read_plane

        return read_plane(world, record)

    def inferred(self, world: PlaneWorld, table: Positions) -> Inferred:
        from i2pdsl.worlds.plane.script import inferred

        return inferred(world, table)

    def begun(self, record: Record) -> str:
        number = lambda x: show_value(float(x))
        places = record.start.items()
        return " and ".join(f"at({who}, ({number(x)}, {number(y)}))" for who, (x, y) in places)

    def kept(self, world: PlaneWorld, path: Trajectory, first: int, last: int) -> list[str]:
        from i2pdsl.worlds.plane.script import kept

        return kept(world, path, first, last)

    def columns(self, words: Vocabulary, record: Record) -> Mapping[str, tuple[list[Any], str]]:
        """NAME_x and NAME_y of each character."""
        states = [record.start, *(frame["state"] for frame in record.frames)]
        return {
            f"{who}_{axis}": ([state[who][number] for state in states], "float64")
            for who in words.characters
            for number, axis in enumerate("xy")
        }

    def naive(
        self,
        world: PlaneWorld,
        story: TypedStory,
        allowed: np.ndarray,
        rational: np.ndarray,
        seed: int,
    ) -> Trajectory:
        from i2pdsl.worlds.plane.naive import walk

        mask, noise = rational & world.rational, story.search.noise
        return walk(world.tables, world.cast, allowed[0], mask, story.length, noise, seed)

    def distance(self, world: PlaneWorld, first: np.ndarray, second: np.ndarray) -> float:
        from i2pdsl.worlds.plane.script import distance

        return distance(world, first, second)

    def meet(self, world: PlaneWorld, states: np.ndarray) -> bool:
        alone = world.cast.count < 2
        return alone or bool(world.feature(world.tables, "touching", (0, 1), states).any())

    # By hand.

    def play(self, words: Vocabulary) -> Word:
        from i2pdsl.worlds.plane.play import play

        return play(words)

    def played(
        self, world: PlaneWorld, module: Module, path: Trajectory, typed: str
    ) -> tuple[Trajectory, str]:
        from i2pdsl.worlds.plane.play import played

        return played(world, path, typed)

    def options(self, words: Vocabulary, before: Sequence[str]) -> list[tuple[str, str]]:
        from i2pdsl.worlds.plane.play import options

        return options(words, before)

    def frame_in_words(self, world: PlaneWorld, path: Trajectory, frame: int) -> str:
        from i2pdsl.worlds.plane.play import frame_in_words

        return frame_in_words(world, path, frame)


KIND = PlaneKind()
