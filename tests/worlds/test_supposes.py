"""Where one takes a thing to be: hypotheses and plans against a world without, and `believes`."""

from __future__ import annotations

import numpy as np
import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import check_query
from i2pdsl.language.scope import Module
from i2pdsl.worlds.find import find_vocabulary
from i2pdsl.worlds.grid.hypotheses import grid_hypotheses
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.policy import log_policy
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.world import build_world

TEXT = """
map
    A..B
    .#.C
tile a
    symbol = A
tile b
    symbol = B
tile c
    symbol = C
character ann
    success = 0.7
    goals = {ball, c}
    supposes = {ball: {a, b}}
character bob
    pushes = {ann, ball}
    toward = ann
    attitude = {-1, 2}
object ball
"""
PLAIN = TEXT.replace("{ball, c}", "{a, b, c}").replace("    supposes = {ball: {a, b}}\n", "")


def spec_of(text: str = TEXT) -> GridSpec:
    return parse_world(Source("cell.world", text), "cell")


def test_the_hypotheses() -> None:
    rows = grid_hypotheses(spec_of())
    both = [row for row in rows if row["R_ann"] and row["R_bob"]]
    found = {(row["G_ann"], row.get("B_ann_ball"), row["rho"]) for row in both}
    wants = (("ball", "a"), ("ball", "b"), ("c", None))
    assert found == {(*want, rho) for want in wants for rho in (-1.0, 2.0)}
    assert len(rows) == 6 + 3 + 1 + 1
    literal = grid_hypotheses(spec_of(TEXT + "audience\n    hypotheses = literal\n"))
    assert len(literal) == 2 * (3 * 2) + 2 * (3 * 1)


def test_who_wants_a_thing_goes_to_where_it_takes_that_to_be() -> None:
    """As one who wants the tile, in all states, and so do others who see through it."""
    world, plain = build_world(spec_of()), build_world(spec_of(PLAIN))
    known = grid_hypotheses(plain.spec)
    states = np.arange(world.dynamics.state_count)
    for who in (0, 1):
        one, other = (log_policy(w.tables, who, states)[..., 0, :] for w in (world, plain))
        for number, row in enumerate(grid_hypotheses(world.spec)):
            seen = {k: v for k, v in row.items() if k != "B_ann_ball"}
            seen |= {"G_ann": row["B_ann_ball"]} if "B_ann_ball" in row else {}
            np.testing.assert_allclose(one[..., number], other[..., known.index(seen)], atol=1e-9)


def test_goals_that_switch_draw_the_place_anew() -> None:
    world = build_world(spec_of(TEXT + "audience\n    switching = 0.2\n"))
    rows = grid_hypotheses(world.spec)
    ann = world.tables.switching[0]
    group = [n for n, row in enumerate(rows) if row["R_ann"] and row.get("rho") == 2.0]
    members = {int(n) for n in ann.members[ann.group[group[0]]] if n < len(rows)}
    assert members == set(group)
    assert len(group) == 3


def mask(text: str, world: str) -> tuple[bool, ...]:
    words = find_vocabulary(world)
    assert words is not None
    asked = Source("query", f"P({text} | script[:T])")
    return check_query(asked, words, Module(Source("query", "")), 4).value.about


@pytest.mark.parametrize(
    ("world", "believed", "event"),
    [
        ("nursery", "believes(sally, at(ball, basket))", "B_sally_ball = basket"),
        ("nursery", "not believes(sally, at(ball, box))", "not B_sally_ball = box"),
        (
            "nursery",
            "believes(sally, at(ball, basket) or at(ball, box) and G_sally = ball)",
            "B_sally_ball = basket or B_sally_ball = box and G_sally = ball",
        ),
        ("farm", "believes(dog, G_duck = hay)", "B_dog_duck = hay"),
        ("farm", "believes(dog, G_duck in {hay}) and rho > 0", "B_dog_duck = hay and rho > 0"),
        ("farm", "believes(dog, G_duck != hay and rho > 0)", "B_dog_duck != hay and rho > 0"),
        ("farm", "G_duck = hay and believes(dog, G_duck = pond) and G_duck = hay",
         "G_duck = hay and B_dog_duck = pond"),
    ],
)  # fmt: skip
def test_what_somebody_believes(world: str, believed: str, event: str) -> None:
    assert mask(believed, world) == mask(event, world)
    assert len(set(mask(believed, world))) == 2


@pytest.mark.parametrize(
    ("world", "text", "message"),
    [
        ("nursery", "believes(anne, at(ball, basket))", "`anne` is never wrong"),
        ("nursery", "believes(sally, G_anne = box)", "`sally` cannot be wrong about this"),
        ("nursery", "believes(sally, at(ball, swing))", "`B_sally_ball` is never `swing`"),
        ("nursery", "believes(sally, at(anne, basket))", "expected the name of an object"),
        ("nursery", "believes(sally, at(ball))", "takes 2 arguments"),
        ("nursery", "believes(sally)", "`believes` takes 2 arguments"),
        ("nursery", "believes(kim, at(ball, basket))", "there is no character `kim`"),
        ("nursery", "believes(sally, believes(sally, at(ball, box)))", "about what another"),
        ("nursery", "at(ball, basket)", "`at` is asked of a frame"),
        ("kitchen", "believes(robot, G_cheese = pink)", "`robot` is never wrong"),
    ],
)
def test_what_nobody_can_believe(world: str, text: str, message: str) -> None:
    with pytest.raises(StoryError) as caught:
        mask(text, world)
    assert any(message in d.message for d in caught.value.diagnostics)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("{ball: {a, b}}", "{ball: {a, d}}", "no tile `d`"),
        ("{ball: {a, b}}", "{bell: {a, b}}", "no object `bell`"),
        ("{ball: {a, b}}", "ball", "needs places"),
        ("{ball: {a, b}}", "{ball: a, ball: b}", "`ball` is given twice"),
        ("{ball, c}", "{c}", "never wants `ball`"),
        ("    attitude = {-1, 2}", "    attitude = {-1, 2}\n    misreads = ann", "be wrong itself"),
        ("{ball, c}", "{ball, bell}", "there is no tile `bell`"),
    ],
)
def test_what_cannot_be_is_said(old: str, new: str, message: str) -> None:
    with pytest.raises(StoryError) as caught:
        spec_of(TEXT.replace(old, new))
    assert any(message in d.message for d in caught.value.diagnostics)
