"""The hill as a kind (worlds/kind.py): its controllers are trained, its scripts descended to."""

from __future__ import annotations

from collections.abc import Hashable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from i2pdsl.errors import Source, StoryError, error, first_of, whole_file
from i2pdsl.language.forms import Word
from i2pdsl.language.scope import Module
from i2pdsl.language.story import TypedStory
from i2pdsl.language.vocabulary import Vocabulary, show_value
from i2pdsl.worlds.blocks import BlockReader, Syntax
from i2pdsl.worlds.drawings import Files
from i2pdsl.worlds.hill.spec import NAME, HillSpec
from i2pdsl.worlds.hill.vocabulary import BOX, HOPPER, hill_vocabulary
from i2pdsl.worlds.kind import Kind, Prepared, Watch, refused

if TYPE_CHECKING:
    import numpy as np

    from i2pdsl.worlds.hill.world import HillWorld
    from i2pdsl.worlds.record import Record, Trajectory
    from i2pdsl.worlds.world import Viewer

MOST_FRAMES = 10_000  # that one `play` or `suggest` adds
APART = 2.0  # units: two scripts look alike if their bodies are closer than this, on average


class HillKind(Kind):
    syntax = Syntax("world.lark", {}, ())
    suggested = (100, MOST_FRAMES)
    catalogued = (NAME,)
    acts_by_hypothesis = False  # the box has its weight, whatever viewers think

    def parse(self, source: Source, name: str, files: Files | None = None) -> HillSpec:
        """The one hill: what stories replace of it, they say."""
        reader = BlockReader(source, self.syntax)
        reader.read()
        if reader.problems:
            raise StoryError(first_of(reader.problems))
        return HillSpec()

    def vocabulary(self, spec: HillSpec) -> Vocabulary:
        return hill_vocabulary(spec)

    def as_json(self, spec: HillSpec) -> dict[str, Any]:
        return {"characters": [{"name": HOPPER}], "objects": [{"name": BOX}]}

    def in_words(self, spec: HillSpec) -> list[str]:
        return [
            f"{spec.settings.slope:g} rad steep; 20 frames a unit of time; continuous actions",
            "",
            f"character {HOPPER}: six muscles; it pulls",
            f"object {BOX}: on a rope",
        ]

    def roles(self, spec: HillSpec, words: Vocabulary) -> dict[str, str]:
        """What the box may weigh."""
        weights = [v for v in words.latents["weight"].values if isinstance(v, float)]
        return {"light": show_value(min(weights)), "heavy": show_value(max(weights))}

    # Ready to be searched and asked.

    def version(self, spec: HillSpec) -> Hashable:
        from i2pdsl.worlds.hill.controllers import controllers_version

        return controllers_version(spec)

    def build(self, spec: HillSpec, viewers: tuple[Viewer, ...], watch: Watch) -> HillWorld:
        from i2pdsl.worlds.hill.world import build_hill

        return build_hill(spec, viewers, watch.say)

    def rules(self, spec: HillSpec) -> HillWorld:
        from i2pdsl.worlds.hill.world import build_hill

        return build_hill(spec)

    def plan(self, spec: HillSpec, watch: Watch) -> Prepared:
        message = f"world {spec.name} is not planned but trained"
        raise error("no-plan", message, whole_file(spec.name), f"`i2p train {spec.name}`")

    def training_settings(self, spec: HillSpec) -> tuple[str, ...]:
        return spec.training_settings

    def train(
        self,
        spec: HillSpec,
        seed: int | None,
        iterations: int | None,
        out: str | None,
        restart: bool,
        watch: Watch,
    ) -> Prepared:
        from i2pdsl.planning.actor_critic import Recipe
        from i2pdsl.worlds.hill.training import train_hill

        seed = spec.settings.controller if seed is None else seed
        recipe = Recipe() if iterations is None else Recipe(iterations=iterations)
        folder = None if out is None else Path(out)
        done = train_hill(spec, seed, folder, recipe, not restart, watch.training, watch.say)
        weights = done.controllers.weights
        document = {
            "world": spec.name,
            "seed": seed,
            "weights": list(weights),
            "iterations": done.controllers.about["iterations"],
            "reward": done.look.reward,
            "falls": done.look.falls,
            "climbs": list(done.look.climbs),
            "controllers": None if done.path is None else str(done.path),
            "finished": done.finished,
            "seconds": round(done.seconds, 1),
        }
        climbs = ", ".join(
            f"weight {w:g} {c:.1f}" for w, c in zip(weights, done.look.climbs, strict=True)
        )
        words = (
            f"{spec.name} (seed {seed}): the box goes up {climbs} units in 800 frames; "
            f"{100 * done.look.falls:.1f} % of the rollouts fall; {done.seconds:.0f} s"
        )
        if done.path is not None:
            words += f"\n  {done.path}"
        return Prepared(document, words, done.finished)

    # Scripts.

    def start_as_json(self, world: HillWorld, state: Any) -> dict[str, Any]:
        from i2pdsl.worlds.hill.script import hill_state

        return hill_state(state)

    def frames_as_json(self, world: HillWorld, path: Trajectory) -> tuple[dict[str, Any], ...]:
        from i2pdsl.worlds.hill.script import hill_frames

        return hill_frames(path)

    def read(self, world: HillWorld, record: Record) -> Trajectory:
        from i2pdsl.worlds.hill.script import read_hill

        return read_hill(world, record)

    def naive(
        self,
        world: HillWorld,
        story: TypedStory,
        allowed: np.ndarray,
        rational: np.ndarray,
        seed: int,
    ) -> Trajectory:
        import numpy as np

        from i2pdsl.worlds.hill.world import hill_rollout

        with np.errstate(all="ignore"):  # what is not finite is refused
            return hill_rollout(world, story.length, story.search.noise, seed)

    def distance(self, world: HillWorld, first: np.ndarray, second: np.ndarray) -> float:
        import numpy as np

        from i2pdsl.worlds.hill.hopper import NODE_COUNT

        places = [s[:, : 2 * NODE_COUNT].reshape(len(s), 2, -1) for s in (first, second)]
        apart: np.ndarray = np.hypot(*np.moveaxis(places[0] - places[1], 1, 0))
        return float(apart.mean() / APART)

    # By hand.

    def play(self, words: Vocabulary) -> Word:
        about = "adds so many frames of what the hopper does by itself"
        return Word("play", "play N", about, "play 50")

    def played(
        self, world: HillWorld, module: Module, path: Trajectory, typed: str
    ) -> tuple[Trajectory, str]:
        """So many frames of the controller's own motion."""
        import numpy as np

        from i2pdsl.worlds.record import extended

        if not typed.isdecimal() or len(typed) > 9 or not 1 <= int(typed) <= MOST_FRAMES:
            message = f"expected a number of frames from 1 to {MOST_FRAMES:,}"
            raise refused(message, typed, "`play 50`")
        frames = int(typed)
        longer = extended(world, path, np.zeros((frames, *world.action_shape)))
        if not np.isfinite(longer.states[-1]).all():
            raise refused("the motion is not finite", typed)
        return longer, f"[{frames} frames of the hopper's own motion]"

    def frame_in_words(self, world: HillWorld, path: Trajectory, frame: int) -> str:
        residual = path.actions[frame - 1]
        if not residual.any():
            return "the hopper's own motion"
        return f"muscles changed by {', '.join(f'{x:+.2f}' for x in residual)}"


KIND = HillKind()
