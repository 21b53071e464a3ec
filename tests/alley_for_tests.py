"""A kind of listed world: two who act one after the other, of whom one may act at random."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from typing import Any

from i2pdsl.language.vocabulary import STAY, Latent, Value, Vocabulary
from i2pdsl.render.listed import ListedDrawing
from i2pdsl.worlds.blocks import BlockReader, Syntax
from i2pdsl.worlds.kinds import KINDS, Place
from i2pdsl.worlds.listed.kind import ListedKind, Picture
from i2pdsl.worlds.listed.words import ListedSpec, listed_vocabulary

CELLS = [(0, 0), (1, 0), (2, 0)]
STEPS = {"west": -1, "east": 1, STAY: 0}
ACTIONS = {"ann": ("west", "east", STAY), "bob": (STAY, "east")}


@dataclass(frozen=True)
class AlleySpec(ListedSpec):
    kind = "alley"
    narrow: bool = True


class Alley(ListedKind[AlleySpec]):
    """Ann and Bob in an alley of three cells. Bob never goes back; a box lies in the middle. A file
    may say that there is room for two."""

    spec = AlleySpec
    syntax = Syntax("world.lark", {**ListedKind.syntax.keys, "planning": ("width",)}, ())

    def vocabulary(self, spec: AlleySpec) -> Vocabulary:
        return listed_vocabulary(
            spec,
            latents=[
                Latent("G_ann", "symbol", ("first", "last")),
                Latent("R_bob", "truth", (True, False)),
            ],
            actions=ACTIONS,
            places={"first": CELLS[:1], "last": CELLS[-1:]},
            cells=CELLS,
            things=("box",),
            rational={"bob": "R_bob"},
        )  # fmt: skip

    def states(self, spec: AlleySpec) -> Iterable[Picture]:
        return [(a, b, CELLS[1]) for a, b in product(CELLS, CELLS)]

    def step(self, spec: AlleySpec, state: Picture, who: str, action: str) -> Picture:
        number = list(ACTIONS).index(who)
        there = (state[number][0] + STEPS[action], 0)
        if there not in CELLS or (spec.narrow and there == state[1 - number]):
            return state
        return (*state[:number], there, *state[number + 1 :])

    def worth(
        self, spec: AlleySpec, hypothesis: Mapping[str, Value], state: Picture, who: str
    ) -> float:
        if who == "bob":
            return state[1][0] if hypothesis["R_bob"] else 0.0
        return -abs(state[0][0] - (0 if hypothesis["G_ann"] == "first" else 2))

    def told(self, reader: BlockReader) -> dict[str, Any]:
        blocks = [block for block in reader.blocks if block.keyword == "planning"]
        said = [reader.word(block, "width", "narrow", ("narrow", "wide")) for block in blocks]
        return {"narrow": "wide" not in said}

    def begins(self, spec: AlleySpec, state: Picture) -> bool:
        return state[0] != state[1]


ALLEY = KIND = Alley()
DRAWING = ListedDrawing()


@contextmanager
def in_the_table() -> Iterator[None]:
    """Where files can be of this kind."""
    KINDS["alley"] = Place(__name__, __name__)
    try:
        yield
    finally:
        del KINDS["alley"]
