"""Maps of other tools: what comes in is a right world, and what is wrong is said at its place."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

from commands_for_tests import Run
from i2pdsl.beginnings.imported import first_story
from i2pdsl.cli import DONE, USAGE, WRONG
from i2pdsl.errors import Source, StoryError
from i2pdsl.stories import load
from i2pdsl.worlds.grid.dynamics import build_dynamics
from i2pdsl.worlds.grid.foreign.write import FORMATS, imported
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.spec import GridSpec

SOKOBAN = """; the first
  ####
###  ####
#     $ #
# #  #$ #
# . *#+ #
#########

Second
#####
#@$.#
#####
"""
MINIGRID = "WGWGWGWGWG\nWG>>WGAPWG\nWG  LY  WG\nWGKYWGGGWG\nWGVR__DRWG\nWGWGWGWGWG\n"
FETCH = "WGWGWGWGWG\nWG>>  KBWG\nWG  LRARWG\nWGBYWGARWG\nWGWGWGWGWG"
GEMS = """;; ASCII ;;
; W: wall, D: door, k: key, g: gem, G: goal-gem, s: start, .: empty
; ...D.
; .W.Wg
; sWkW.
; .W.WG
; ...D.
(define (problem doors-keys-gems-2) (:domain doors-keys-gems)
"""
COLORED = "..R.g\nh.W.r\nm.W.b\n..B.g\n"
WALK = """var ___ = ' ';
var D = { name : 'Donut N' };
var grid = [  // from above
  ['#', D , ___],
  [___, '#', {name: "Veg"}],
  [___, ___, ___]
];
var mdp = makeGridWorldMDP({ grid, start: [0, 1], totalTime: 9 });
"""
TEXTS = (SOKOBAN, MINIGRID, FETCH, GEMS, COLORED, WALK)


def read(text: str, number: int = 1) -> GridSpec:
    found = imported(Source("map.txt", text), "map.txt", "map", number)
    return parse_world(Source("map.world", found.text), "map")


def places(spec: GridSpec) -> dict[str, tuple[tuple[int, int], ...]]:
    found = {tile.name: tile.cells for tile in spec.tiles}
    found |= {c.name: (c.cell,) for c in spec.characters if c.cell}
    return found | {thing.name: thing.cells for thing in spec.things}


def test_sokoban() -> None:
    spec = read(SOKOBAN)
    assert spec.rows[0] == "#########"  # what is outside is a wall
    assert len(spec.free_cells) == 2 + 7 + 5 + 6
    assert places(spec) == {
        "goal_1": ((2, 4),),
        "goal_2": ((4, 4),),
        "goal_3": ((6, 4),),
        "keeper": ((6, 4),),
        "box": ((6, 2), (6, 3), (4, 4)),
    }
    assert spec.character("keeper").pushes == ("box",)
    small = read(SOKOBAN, 2)
    assert small.state_count == 6
    with pytest.raises(StoryError, match="2 levels in this file, no level 3"):
        read(SOKOBAN, 3)


def test_minigrid() -> None:
    spec = read(MINIGRID)
    agent = spec.character("agent")
    assert agent.goals == ("goal", "none")
    assert set(agent.carries) == {"key_yellow", "ball_purple"}
    assert places(spec) == {
        "goal": ((3, 3),),
        "way_red": ((3, 4),),
        "lava": ((1, 4),),
        "agent": ((1, 1),),
        "key_yellow": ((1, 3),),
        "ball_purple": ((3, 1),),
        "door_yellow": ((2, 2),),
    }
    assert spec.things[-1].opened_by == ("key_yellow",)
    assert next(tile for tile in spec.tiles if tile.name == "lava").cost == 10
    assert (2, 4) in spec.free_cells  # an open door


def test_what_a_mission_may_name_is_a_tile_where_there_is_no_goal() -> None:
    spec = read(FETCH)
    assert spec.characters[0].goals == (
        "key_blue",
        "ball_red_1",
        "ball_red_2",
        "box_yellow",
        "none",
    )
    assert spec.things == ()
    assert (2, 2) not in spec.free_cells  # no key opens that door


def test_doors_keys_and_gems() -> None:
    spec = read(GEMS)
    assert spec.free_cells == tuple(
        (c, r) for r in range(5) for c in range(5) if not (c in (1, 3) and r in (1, 2, 3))
    )
    assert places(spec) == {
        "gem_1": ((4, 1),),
        "gem_2": ((4, 3),),
        "human": ((0, 2),),
        "key": ((2, 2),),
        "door_1": ((3, 0),),
        "door_2": ((3, 4),),
    }
    colored = read(COLORED)
    assert [c.name for c in colored.characters] == ["human", "robot"]
    opened = {thing.name: thing.opened_by for thing in colored.things if thing.opened_by}
    assert opened == {"door_red": ("key_red",), "door_blue": ("key_blue",)}


def test_agentmodels_counts_rows_from_below() -> None:
    spec = read(WALK)
    assert places(spec) == {"donut_n": ((1, 0),), "veg": ((2, 1),), "bob": ((0, 1),)}
    assert (0, 0) not in spec.free_cells
    as_json = json.dumps({"grid": [[" ", "#"], [{"name": "A b"}, " "]], "start": [0, 1]})
    assert places(read(as_json)) == {"a_b": ((0, 1),), "bob": ((0, 0),)}


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("#####\n#@?.#\n#####", 2, 3, "`?` means nothing"),
        ("#####\n#@@.#\n#####", 1, 1, "2 times who pushes"),
        ("WGWGWG\nWG>>XX\nWGWGWG\nWGWGWG", 2, 5, "`XX` means nothing"),
        ("WGWGWG\nWG  WG\nWGWGWG", 1, 1, "0 times who acts"),
        ("s.W.\nWW?g", 2, 3, "`?` means nothing"),
        ("[[' ', X]]", 1, 8, "what `X` is, the file does not say"),
        ("[[' ', 'b']]", 1, 8, "a cell is"),
        ("[[' ', ' '], [' ']]", 1, 15, "this row has 1 cells"),
        ("[[' '], [' ']", 1, 13, "this is no cell"),
        ("[[' ']] start: [0, 4]", 1, 9, r"cannot begin at \[0, 4\]"),
        ("hello", 1, 1, "a map of no tool"),
        (" \n", 1, 1, "is empty"),
        ("#" * 20_000 + "@#", 1, 1, "20,002 cells; at most 10,000"),
        ("####\n#@$#\n" + "#$$#\n" * 4 + "####", 1, 1, "9 boxes; at most 8"),
    ],
)
def test_what_is_wrong_is_said_where_it_stands(
    text: str, line: int, column: int, message: str
) -> None:
    with pytest.raises(StoryError, match=message) as caught:
        read(text)
    span = caught.value.diagnostics[0].span
    assert span.source.name == "map.txt"
    assert span.source.position(span.start) == (line, column)


def test_any_text_is_a_world_or_a_mistake() -> None:
    generator = random.Random(3)
    kinds, wrong = {each.what: 0 for each in FORMATS}, set()
    for _ in range(300):
        text = list(generator.choice(TEXTS))
        for _ in range(generator.choice((0, 1, 1, 2, 5))):
            at = generator.randrange(len(text))
            text[at : at + generator.randrange(3)] = generator.choice(
                ["#", " ", "W", "\n", "[", "]", ",", "$", '"', "é", "\t", "", "g", "#} <b>"]
            )
        source = Source("map.txt", "".join(text))
        try:
            found = imported(source, "map.txt", "map", 1)
        except StoryError as problem:
            wrong.update(d.span.source.name for d in problem.diagnostics)
            continue
        kinds[found.what] += 1
        assert "<b>" not in found.text
        first_story(found, "map", "map.story")
    assert wrong == {"map.txt"}
    assert min(kinds.values()) > 5


@pytest.mark.parametrize("number", range(len(TEXTS)))
def test_what_comes_in_is_checked_and_told(number: int, i2p: Run, tmp_path: Path) -> None:
    (tmp_path / "Any map!.txt").write_text(TEXTS[number])
    done = i2p("worlds", "--import", tmp_path / "Any map!.txt", "--out", tmp_path)
    assert done.status == DONE
    assert done.out.splitlines() == [str(tmp_path / f"any_map.{end}") for end in ("story", "world")]
    assert done.err.startswith("otherwise here: ")
    head = (tmp_path / "any_map.world").read_text().partition("\nmap\n")[0].replace("\n# ", " ")
    assert all(line.split(": ", 1)[1] in head for line in done.err.splitlines())
    assert i2p("fmt", "--check", tmp_path).status == DONE
    story = load(tmp_path / "any_map.story")
    assert not [w for w in story.warnings if w.code != "world-goal"]


def test_a_first_story_is_found(i2p: Run, tmp_path: Path) -> None:
    (tmp_path / "doors.txt").write_text("W.D.g\nsk.Wg\n")
    done = i2p("worlds", "--import", tmp_path / "doors.txt", "--out", tmp_path, "--json")
    told = json.loads(done.out)
    assert told["from"] == "a map of doors, keys and gems"
    result = load(told["story"]).solve(0)
    assert result.script.query("P(G_human = gem_1 | script[:T])") > 0.9


def test_names_lead_nowhere_and_nothing_is_overwritten(i2p: Run, tmp_path: Path) -> None:
    file = tmp_path / "map.txt"
    file.write_text(WALK)
    for name in ("../up", "a/b", "", 'a"b', "kitchen", "CON"):
        done = i2p("worlds", "--import", file, "--out", tmp_path / "out", "--name", name)
        assert done.status == WRONG
        assert "no world can be called" in done.err
        assert not (tmp_path / "out").exists()
    assert i2p("worlds", "--import", file, "--out", tmp_path, "--name", "walk").status == DONE
    before = (tmp_path / "walk.world").read_bytes()
    again = i2p("worlds", "--import", file, "--out", tmp_path, "--name", "walk")
    assert again.status == WRONG
    assert "nothing is overwritten" in again.err
    assert (tmp_path / "walk.world").read_bytes() == before
    assert i2p("worlds", "kitchen", "--import", file).status == USAGE


LARGE = """    #####
    #   #
    #$  #
  ###  $##
  #  $ $ #
### # ## #   ######
#   # ## #####  ..#
# $  $          ..#
##### ### #@##  ..#
    #     #########
    #######
"""


def test_of_a_large_level_there_are_the_states_that_can_be_reached_in_time() -> None:
    spec = read(LARGE)
    assert spec.state_count > 10**9
    assert spec.settings.horizon == 20
    assert spec.is_sparse
    assert build_dynamics(spec).state_count < 10_000
