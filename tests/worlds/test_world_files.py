"""World files: every mistake at its place, the number of states, and the hypotheses."""

from __future__ import annotations

from collections import Counter
from itertools import product
from pathlib import Path

import pytest

from i2pdsl.errors import Diagnostic, Source, StoryError
from i2pdsl.worlds.find import find_spec
from i2pdsl.worlds.grid.hypotheses import grid_hypotheses
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.spec import GridSpec
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary
from i2pdsl.worlds.grid.words import ELSEWHERE, KEYS

ROOT = Path(__file__).parents[2]
KITCHEN = (ROOT / "stories" / "worlds" / "kitchen.world").read_text(encoding="utf-8")


def world(text: str) -> GridSpec:
    return parse_world(Source("some.world", text), "some")


def mistakes(text: str) -> tuple[Diagnostic, ...]:
    with pytest.raises(StoryError) as caught:
        world(text)
    return caught.value.diagnostics


def changed(old: str, new: str) -> str:
    assert KITCHEN.count(old) >= 1
    return KITCHEN.replace(old, new, 1)


# What is changed in the kitchen, and the one mistake: its text in the changed file, and its code.
WRONG = [
    ("    ...#...#...\n", "    ...#...#..\n", "...#...#..\n", "world-map"),
    (".P.........", ".X.........", "X", "world-map"),
    ("symbol = P", "symbol = PP", "PP", "world-tile"),
    ("symbol = P", 'symbol = "#"', '"#"', "world-tile"),
    ("symbol = P", "symbol = {P}", "{P}", "world-tile"),
    ("symbol = G", "cell = (0, 1)\n    symbol = G", "green\n    cell", "world-tile"),
    ("tile pink\n    symbol = P", "tile pink", "pink\n    color", "world-tile"),
    ("success = 0.6", "success = 1.4", "1.4", "world-range"),
    ("success = 0.6", "success = 0", "0\n", "world-range"),
    ("success = 0.6", "success = -0.5", "-0.5", "world-range"),
    ("success = 0.6", "success = high", "high", "world-value"),
    ("success = 0.6", "sucess = 0.6", "sucess", "world-key"),
    ("success = 0.6", "success = 0.6\n    success = 0.7", "success = 0.7", "duplicate"),
    ("success = 0.6", "success 0.6", "0.6", "syntax"),
    ("success = 0.6", "success = 0.6\n    models = robot", "toward = cheese", "world-cast"),
    ("goals = {pink, green}", "goals = {pink, blue}", "blue", "world-name"),
    ("goals = {pink, green}", "goals = {pink, 3}", "3}", "world-value"),
    ("goals = {pink, green}", "goals = {}", "{}", "world-value"),
    ("goals = {pink, green}", "goals = {pink, green", "{pink, green\n", "bracket"),
    ("pushes = {cheese, table}", "pushes = {cheese, robot}", "robot}", "world-name"),
    ("toward = cheese", "toward = robot", "robot\n    attitude", "world-name"),
    ("    toward = cheese\n", "", "attitude =", "world-cast"),
    ("    attitude = {-3, -1, 0, 1, 3}\n", "", "toward", "world-cast"),
    ("{-3, -1, 0, 1, 3}", "{}", "{}", "world-value"),
    ("{-3, -1, 0, 1, 3}", "{-3, x}", "x}", "world-value"),
    ("{-3, -1, 0, 1, 3}", "{1e400}", "1e400", "world-range"),
    (
        "    success",
        "    toward = robot\n    attitude = {1}\n    success",
        "toward = cheese",
        "world-cast",
    ),
    ("character cheese", "character robot", "robot\n    goals", "duplicate"),
    ("character cheese", "character stay", "stay\n", "reserved"),
    ("character cheese", "character maximize", "maximize", "reserved"),
    ("character cheese", "character", "character\n", "world-block"),
    ("character robot", "character mouse\ncharacter robot", "[cheese, robot]", "world-value"),
    ("object table", "object pink", "pink\n    may_be", "duplicate"),
    ("object table", "objct table", "objct", "world-block"),
    ("may_be_absent = yes", "may_be_absent = no", "{table}\n\nrewards", "world-cast"),
    ("may_be_absent = yes", "may_be_absent = maybe", "maybe", "world-value"),
    ("drops = {table}", "drops = {robot}", "robot}\n\nrewards", "world-name"),
    ("    drops = {table}\n", "", "deus\n", "world-block"),
    ("event deus", "event rain", "rain", "world-name"),
    ("gamma = 0.99", "gamma = 1", "1\n    beta", "world-range"),
    ("beta = 2.0", "beta = -1", "-1\n    level0", "world-range"),
    ("beta = 2.0", "beta =", "= uniform", "syntax"),
    ("level0 = uniform", "level0 = costss", "costss", "world-value"),
    ("order = [cheese, robot]", "order = [cheese]", "[cheese]", "world-value"),
    ("order = [cheese, robot]", "order = [cheese, mouse]", "mouse", "world-name"),
    ("forgetting = 1e-5", "forgetting = 2", "2\n    hyp", "world-range"),
    ("hypotheses = merged", "hypotheses = all", "all\n\ndrawing", "world-value"),
    ("goal = 1.0", "goal = 1e7", "1e7", "world-range"),
    ("rewards\n", "rewards mine\n", "mine", "world-block"),
    ("rewards\n", "rewards\n    move = 1\nrewards\n", "rewards\n    goal", "duplicate"),
    ('color = "#f2c14e"', "color = yellow", "yellow", "world-value"),
    ('floor = "#f3e6d0"', 'flor = "#f3e6d0"', "flor", "world-key"),
    ('sprite = "robot"', 'sprite = "robot', '"robot\n', "string"),
    ("map\n", "map\n    ...\nmap\n", "map\n    ...#", "duplicate"),
]


@pytest.mark.parametrize(
    ("old", "new", "at", "code"), WRONG, ids=[f"{w[3]}: {w[1]!r}" for w in WRONG]
)
def test_one_mistake_is_one_message_at_its_place(old: str, new: str, at: str, code: str) -> None:
    text = changed(old, new)
    if (old, code) == ("map\n", "duplicate"):
        text = text.replace("symbol = P", "cell = (0, 0)").replace("symbol = G", "cell = (1, 0)")
    found = mistakes(text)
    assert [d.code for d in found] == [code], [d.render() for d in found]
    assert text[found[0].span.start :].startswith(at), found[0].render()


SMALL = "map\n    ...\n    #.P\n"


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        ("", ["empty"]),
        ("# nothing\n", ["world-map", "world-cast"]),
        ("map\n    ...\n", ["world-cast"]),
        ("character a\n", ["world-map"]),
        ("map\ncharacter a\n", ["world-map"]),
        ("map\n...\n...\ncharacter a\n", ["world-map"]),
        ("map ... ...\ncharacter a\n", ["world-map"]),
        ("map\n    ... # top\n    ...\ncharacter a\n", ["world-map"]),
        ("map\n    ###\ncharacter a\n", ["world-map"]),
        ("map\n    #.#\ncharacter a\ncharacter b\n", ["world-map"]),
        ("map\n    ..\ncharacter a\nobject b\nobject c\n", ["world-map"]),
        (SMALL + "character a\n", ["world-map"]),
        (
            SMALL + "tile x\n    cell = (0, 1)\ntile p\n    symbol = P\ncharacter a\n",
            ["world-tile"],
        ),
        (
            SMALL + "tile x\n    cell = (9, 1)\ntile p\n    symbol = P\ncharacter a\n",
            ["world-tile"],
        ),
        (
            SMALL + "tile x\n    cell = (1.5, 1)\ntile p\n    symbol = P\ncharacter a\n",
            ["world-tile"],
        ),
        (
            SMALL + "tile x\n    cell = (1e400, 1)\ntile p\n    symbol = P\ncharacter a\n",
            ["world-tile"],
        ),
        (
            SMALL + "tile x\n    cell = (a, 1)\ntile p\n    symbol = P\ncharacter a\n",
            ["world-tile"],
        ),
        (
            SMALL + "tile x\n    cell = (2, 1)\ntile p\n    symbol = P\ncharacter a\n",
            ["world-tile"],
        ),
        ("  map\n    ...\ncharacter a\n", ["indentation"]),
        ("hello\n", ["world-block"]),
        ("map\n    ...\x00\n", ["not-text"]),
    ],
)
def test_small_worlds_that_are_wrong(text: str, codes: list[str]) -> None:
    assert [d.code for d in mistakes(text)] == codes


def test_all_mistakes_in_one_go_and_in_order() -> None:
    text = KITCHEN
    for old, new in (
        ("success = 0.6", "success = 1.4"),
        ("gamma = 0.99", "gama = 0.99"),
        ("{pink, green, none}", "{pink, blue}"),
        ("...#...#...\n", "...#...#..\n"),
        ('floor = "#f3e6d0"', "floor = beige"),
    ):
        text = text.replace(old, new, 1)
    found = mistakes(text)
    assert [d.code for d in found] == [
        *("world-map", "world-range", "world-name", "world-key", "world-value")
    ]
    assert [d.span.start for d in found] == sorted(d.span.start for d in found)


def test_the_kitchen() -> None:
    spec = find_spec("kitchen")
    assert spec.name == "kitchen"
    assert (len(spec.free_cells), spec.state_count) == (60, 208_860)
    assert spec.entities == ("cheese", "robot", "table")
    assert {t.name: t.cells for t in spec.tiles} == {"pink": ((1, 1),), "green": ((1, 5),)}
    assert spec.documentation.startswith("A robot, a living cube of cheese")


def brute_force_states(spec: GridSpec) -> int:
    """Every way to put the entities on free cells, or away, with no two on a cell."""
    options: list[list[tuple[int, int] | None]] = []
    for name in spec.entities:
        absent = any(t.name == name and t.may_be_absent for t in spec.things)
        options.append([*spec.free_cells, *([None] if absent else [])])
    count = 0
    for state in product(*options):
        present = [cell for cell in state if cell is not None]
        count += len(present) == len(set(present))
    return count


@pytest.mark.parametrize("rows", [["."], ["..", ".#"], ["...", "#.#"], ["....", "....", "#..#"]])
@pytest.mark.parametrize("cast", ["character a\n", "character a\ncharacter b\n"])
@pytest.mark.parametrize(
    "objects",
    [
        "",
        "object x\n",
        "object x\n    may_be_absent = yes\n",
        "object x\n    may_be_absent = yes\nobject y\n",
        "object x\n    may_be_absent = yes\nobject y\n    may_be_absent = yes\n",
    ],
)
def test_state_count_agrees_with_brute_force(rows: list[str], cast: str, objects: str) -> None:
    text = "map\n" + "".join(f"    {row}\n" for row in rows) + cast + objects
    free = sum(row.count(".") for row in rows)
    needed = cast.count("character") + objects.count("object") - objects.count("yes")
    if free < needed:
        assert [d.code for d in mistakes(text)] == ["world-map"]
        return
    spec = world(text)
    assert spec.state_count == brute_force_states(spec) > 0


def test_the_hypotheses_of_the_kitchen() -> None:
    """model.md: 28 with both rational, 3, 2 and 1; or the paper's tuple taken literally, 72."""
    rows = grid_hypotheses(world(KITCHEN))
    kinds = Counter((row["R_cheese"], row["R_robot"]) for row in rows)
    assert kinds == {(True, True): 28, (False, True): 3, (True, False): 2, (False, False): 1}
    assert len({tuple(sorted(row.items())) for row in rows}) == len(rows) == 34
    both = [row for row in rows if row["R_cheese"] and row["R_robot"]]
    assert not any(row["rho"] == 0 and row["G_robot"] == "none" for row in both)
    assert all(row["rho"] == 0 for row in rows if not row["R_cheese"] and row["R_robot"])
    assert all("rho" not in row and "G_robot" not in row for row in rows if not row["R_robot"])
    assert all("G_cheese" not in row for row in rows if not row["R_cheese"])
    positive = sum(row.get("rho", 0) > 0 for row in rows)  # type: ignore[operator]
    assert round(positive / len(both), 2) == 0.43
    literal = grid_hypotheses(world(KITCHEN.replace("merged", "literal")))
    assert Counter((row["R_cheese"], row["R_robot"]) for row in literal) == {
        (True, True): 30,
        (False, True): 6,
        (True, False): 30,
        (False, False): 6,
    }


def test_the_hypotheses_of_other_casts() -> None:
    one = world(
        "map\n    PG\ntile pink\n    symbol = P\ntile green\n    symbol = G\n"
        "character mouse\n    goals = {pink, green, none}\n"
    )
    assert grid_hypotheses(one) == (
        {"G_mouse": "pink", "R_mouse": True},
        {"G_mouse": "green", "R_mouse": True},
        {"G_mouse": "none", "R_mouse": True},
        {"R_mouse": False},
    )
    assert "rho" not in grid_vocabulary(one).latents
    plain = KITCHEN.replace("    attitude = {-3, -1, 0, 1, 3}\n", "")
    two = world(plain.replace("toward = cheese", "models = cheese"))
    kinds = Counter((row["R_cheese"], row["R_robot"]) for row in grid_hypotheses(two))
    assert kinds[(False, True)] == 3
    assert kinds[(True, False)] == 2
    assert kinds[(False, False)] == 1
    assert not any("rho" in row for row in grid_hypotheses(two))
    assert kinds[(True, True)] == 6


# Names, maps that are pasted in, and words of other tools.

PAIR = """map
    A...B
tile {tile}
    symbol = A
tile other
    symbol = B
character {who}
    goals = {{{tile}, other}}
    pushes = {{{thing}}}
    toward = friend
    attitude = {{-1, 1}}
character friend
    goals = {{other}}
object {thing}
    may_be_absent = yes
"""


@pytest.mark.parametrize("kind", ["who", "tile", "thing"])
@pytest.mark.parametrize("name", ["event", "state", "unknown", "rho", "script", "north", "none"])
def test_names_that_mean_something_else_are_refused_at_their_place(kind: str, name: str) -> None:
    text = PAIR.format(**{"who": "me", "tile": "home", "thing": "stone", kind: name})
    (found,) = mistakes(text)
    assert found.code == "reserved"
    assert found.hint == "choose another name"
    assert found.span.text == name


def test_latents_keep_their_names() -> None:
    for name in ("G_me", "R_me", "G_friend"):
        found = mistakes(PAIR.format(who="me", tile=name, thing="stone"))
        assert [d.code for d in found] == ["reserved"]
    world(PAIR.format(who="me", tile="G_you", thing="R_you"))
    alone = "map\n    A.\ntile rho\n    symbol = A\ncharacter me\n    goals = {rho}\n"
    assert "rho" not in grid_vocabulary(world(alone)).latents


def test_a_tile_may_be_called_like_a_block_or_a_key() -> None:
    for name in ("planning", "rewards", "map", "tile", "goals", "symbol", "order"):
        text = PAIR.format(who="me", tile=name, thing="stone")
        assert (
            world(text + "planning\n    beta = 1\nrewards\n    move = -2\n").tiles[0].name == name
        )


def test_one_name_has_many_spellings() -> None:
    two, one = "e\u0301te\u0301", "\u00e9t\u00e9"
    text = PAIR.format(who="me", tile=two, thing="stone").replace(f"{{{two},", f"{{{one},")
    assert world(text).tiles[0].name == one
    for a, b in ((two, one), ("\uff21", "A"), ("\ufb01sh", "fish")):
        (found,) = mistakes(PAIR.format(who="me", tile=a, thing=b).replace("pushes", "# pushes"))
        assert found.code == "duplicate"
        assert found.notes


@pytest.mark.parametrize(
    "name", ["猫", "بيت", "חתול", "बिल्ली", "แมวน้ำ", "か\u3099", "Straße", "x\u0308y"]
)
def test_names_of_every_script(name: str) -> None:
    spec = world(PAIR.format(who=name, tile="home", thing="stone"))
    assert f"G_{spec.characters[0].name}" in grid_vocabulary(spec).latents


def test_a_pasted_map_has_one_mistake_for_each_symbol() -> None:
    kitchen = (
        "map\n    XXXPX\n    X 1 P\n    D2X X\n    O   X\n    XOSXX\ncharacter one\ncharacter two\n"
    )
    found = mistakes(kitchen)
    counts = {"X": "11 cells", "P": "2 cells", "O": "2 cells"}
    counts |= dict.fromkeys("12DS", "1 cell")
    told = {d.message.split("`")[1]: d for d in found if "unknown symbol" in d.message}
    assert len(found) == len(told) + 1
    assert {s for s in told if f"on {counts[s]} of the map" in told[s].message} == set(counts)
    assert all("`tile NAME`" in (d.hint or "") for d in told.values())
    assert "start at(NAME, (2, 1))" in (told["1"].hint or "")
    (spaces,) = (d for d in found if d not in told.values())
    assert spaces.message.endswith("has 6")
    # Levels are ragged, and begin with spaces.
    level = "map\n      #####\n    ###   #\n    # $ # ##\n    # #  @ #\n    ########\ncharacter a\n"
    assert [d.code for d in mistakes(level)] == ["world-map"] * 3


@pytest.mark.parametrize("sign", [*"@$*+()[]{}!=,|%&<>?;:^~\\/'", "\N{CAT FACE}"])
def test_a_sign_that_is_a_symbol_needs_quotes(sign: str) -> None:
    text = f"map\n    .{sign}..\ntile a\n    symbol = SIGN # here\n    color = red\ncharacter b\n"
    text += "    goals = {a, c}\n"
    quotes, color, tile = mistakes(text.replace("SIGN", sign))
    assert quotes.hint == f'write `symbol = "{sign}"`'
    assert quotes.span.text == sign
    assert (color.span.text, tile.span.text) == ("red", "c")
    assert len(mistakes(text.replace("SIGN", f'"{sign}"'))) == 2


def test_no_kind_of_mistake_hides_another() -> None:
    text = """map
    A..X
    ..X.
    B...
tile a
    symbol = A
    reward 3
    colour = red
tile b
    symbol = B
tile state
    cell = (9, 9)
character bob
    goals = {a, state, zzz}
    success 0.5
    pushes = {nobody
    toward = tim
object crate
    heavy = = 2
    may_be_absent = perhaps
event deus
    drops = {crte}
planning
    gama = 1
    beta = -1
length 15
agent tim
    goals = {a}
"""
    lines = [d.span.source.position(d.span.start)[0] for d in mistakes(text)]
    #        X  rew col state cell zzz succ { heavy perh crte gama beta length agent
    assert lines == [2, 7, 8, 11, 12, 14, 15, 16, 19, 20, 22, 24, 25, 26, 27]


def test_words_of_other_blocks_and_of_other_tools_are_told_where_they_belong() -> None:
    base = "map\n    ..\ncharacter bob\n{}\n"
    for line, hint in [
        ("    forgetting = 0.1", "`forgetting` belongs to `audience`"),
        ("    start = (1, 0)", "`start` belongs in the story: `start at(bob, (column, row))`"),
        ("    sees = 2", "everyone sees everything but goals"),
        ("    moves = {north, northeast}", "where a character has `diagonals = yes`"),
        ("    goal = a", "did you mean `goals`?"),
        ("    horizon = 3", "`horizon` belongs to `planning`"),
        ("    terminal = a", "how many frames there are is `horizon`"),
        ("door d", "a door is an `object` with `opened_by = KEY`"),
        ("agent tim", "someone who acts is a `character`"),
        ("Box b", "is an `object`"),
        ("maximize 3", "`maximize` belongs in the story"),
        ("beta = 3", "`beta` belongs to `planning`"),
        ("wall w", "drawn as `#`"),
        ("floor f", "`floor` belongs to `drawing`"),
        ("zebra z", "blocks: map, tile"),
    ]:
        (found,) = mistakes(base.format(line))
        assert hint in (found.hint or ""), found.render()
    for word, told in ELSEWHERE.items():
        assert word == word.lower()
        assert len(told) < 100
        assert word not in KEYS


def test_worlds_tell_their_own_number_of_hypotheses() -> None:
    for name in ("kitchen", "fork", "maze"):
        spec = find_spec(name)
        about = grid_vocabulary(spec).settings["hypotheses"].documentation
        for kind in ("merged", "literal"):
            count = len(grid_hypotheses(spec.with_settings({"hypotheses": kind})))
            assert f"({count})" in about.split(kind)[1]
