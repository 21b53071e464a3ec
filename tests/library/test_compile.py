"""From a folder to a library: what is packed, what is refused, and that the same folder gives the
same bytes."""

from __future__ import annotations

import json
from hashlib import sha256
from pathlib import Path

import pytest
from libraries_for_tests import MOODS, YARD, files_of, make_folder

from commands_for_tests import Run
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import check_source
from i2pdsl.language.imports import read_library
from i2pdsl.language.packed import LARGEST, encode
from i2pdsl.library.description import PatternLibrary
from i2pdsl.library.examples import Gallery, examples_of
from i2pdsl.library.fits import example_call
from i2pdsl.library.pack import Packed, pack
from i2pdsl.resources import data_folder
from i2pdsl.worlds.find import find_vocabulary


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Not compiled yet: its story needs the library that it imports."""
    return make_folder(tmp_path)


def packed(folder: Path, name: str = "moods") -> Packed:
    return pack(folder, files_of(folder), name)


def refused(folder: Path) -> str:
    with pytest.raises(StoryError) as caught:
        packed(folder)
    return str(caught.value)


def test_what_is_packed(folder: Path) -> None:
    library = packed(folder).library
    contents = library.contents
    kinds = (contents.patterns, contents.outside, contents.stories, contents.worlds)
    assert [[file.name for file in files] for files in kinds] == [
        ["deep/turns.story", "moods.story"], ["outside/common.story"], ["secret.story"], [],
    ]  # fmt: skip
    assert contents.standard == ("twist",)
    assert contents.patterns[0].imports == {
        "../../common.story": ["outside/common.story"],
        "twist": "standard",
    }
    assert contents.patterns[1].source.text == MOODS
    records = {r["name"]: r for r in library.patterns}
    dark = records["dark"]
    assert dark["signature"] == "dark(event, share = 0.8)"
    assert dark["documentation"] == "Viewers are kept in the dark.\nUse it for a question."
    assert dark["file"] == "moods.story"
    assert dark["body"] == MOODS.split("=\n    ")[1].split("\n\n")[0]
    assert dark["result"] == "number"
    assert dark["parameters"] == [
        {"name": "event", "kind": "event", "default": None},
        {"name": "share", "kind": "number", "default": "0.8"},
    ]
    assert sorted(library.lets) == ["middle", "slowness"]
    # A pattern that a pattern of the library uses is packed but not its own.
    assert list(library.definitions) == ["after", "both", "dark", "pink_mind"]
    assert list(records) == ["after", "both", "dark", "pink_mind"]
    assert "slow_depict" in library.exports.names


def test_what_is_said_is_the_same_when_the_file_is_read(folder: Path, tmp_path: Path) -> None:
    """Kinds, worlds and examples are computed from the sources each time."""
    (folder / "yard.world").write_text(YARD, encoding="utf-8")
    library = packed(folder).library
    path = tmp_path / "moods.i2plib"
    path.write_bytes(encode(library.contents))
    again = PatternLibrary("moods", read_library(path))
    assert again.patterns == library.patterns
    assert again.stories == library.stories
    assert again.worlds.keys() == library.worlds.keys() == {"yard"}


def test_examples_are_the_stories_that_use_a_pattern(folder: Path) -> None:
    library = packed(folder).library
    (story,) = library.stories
    assert (story["file"], story["world"]) == ("secret.story", "kitchen")
    assert story["calls"] == {"dark": "dark(G_cheese = pink, share = 0.5)"}
    assert story["source"] == (folder / "secret.story").read_text(encoding="utf-8")
    records = {r["name"]: r["examples"] for r in library.patterns}
    call = {"file": "secret.story", "world": "kitchen", "call": story["calls"]["dark"]}
    assert records["dark"] == [call]
    assert records["both"] == []


def test_a_story_that_means_another_pattern_is_no_example(folder: Path, tmp_path: Path) -> None:
    """Its own, the standard one where it does not import the library, one from elsewhere."""
    head = "world kitchen\nlength 5\n"
    use = "maximize dark(rho > 0)\n"
    other = "pattern dark(x) = 2 * depict(x)\n"
    (tmp_path / "elsewhere.story").write_text(other, encoding="utf-8")
    (folder / "twists.story").write_text("pattern legible(x) = 3 * depict(x)\n", encoding="utf-8")
    stories = {
        "own.story": f"{head}import moods\n{other}{use}",
        "elsewhere.story": f'{head}import "../elsewhere.story"\nimport moods\n{use}',
        "standard.story": f"{head}maximize legible(rho > 0)\n",
        "by-let.story": f"{head}import moods\nlet mine = dark(rho > 0)\nmaximize mine\n",
        "legible.story": f"{head}import twists\nmaximize legible(rho > 0)\n",
    }
    for name, text in stories.items():
        (folder / name).write_text(text, encoding="utf-8")
    library = packed(folder).library
    assert {s["file"]: list(s["calls"]) for s in library.stories} == {
        "own.story": [], "elsewhere.story": [], "standard.story": [], "by-let.story": ["dark"],
        "legible.story": ["legible"], "secret.story": ["dark"],
    }  # fmt: skip
    assert [file.name for file in library.contents.outside] == [
        "outside/common.story", "outside/elsewhere.story",
    ]  # fmt: skip


def test_worlds_that_patterns_fit(folder: Path) -> None:
    (folder / "yard.world").write_text(YARD, encoding="utf-8")
    library = packed(folder).library
    records = {r["name"]: r["worlds"] for r in library.patterns}
    assert records["dark"]["yard"]["fits"]
    (dark,) = (r for r in library.patterns if r["name"] == "dark")
    call = example_call(dark, library.exports, library.vocabularies["yard"])
    assert call is not None
    assert call.startswith("dark(G_cart = ")
    assert records["dark"]["hill"]["fits"]
    assert records["pink_mind"]["kitchen"]["fits"]
    assert not records["pink_mind"]["hill"]["fits"]
    assert "rho" in records["pink_mind"]["hill"]["because"] or (
        "G_cheese" in records["pink_mind"]["hill"]["because"]
    )
    assert [(w.name, w.source.text) for w in library.contents.worlds] == [("yard.world", YARD)]


def test_an_example_calls_its_world_by_its_name(folder: Path) -> None:
    """It is made in a folder of its own, with the library and its worlds beside it."""
    (folder / "yard.world").write_text(YARD, encoding="utf-8")
    text = 'world "../yard.world"\nimport "../moods.story"\nlength 4\nmaximize dark(G_cart = red)\n'
    (folder / "deep" / "far.story").write_text(text, encoding="utf-8")
    library = packed(folder).library
    (dark,) = (r for r in library.patterns if r["name"] == "dark")
    (example,) = examples_of(library, dark, ["yard"])
    assert example.source == ("world yard\nimport moods\nlength 4\nmaximize dark(G_cart = red)\n")
    place = Gallery(folder / "book", library, print, 1).unpacked(str(folder / "alone"))
    story = check_source(Source("example", example.source), find_vocabulary, place)
    assert story.warnings == ()


def test_worlds_of_one_name(folder: Path, tmp_path: Path) -> None:
    """Built-in, in the folder, in a folder of it, and from two places outside."""
    for place in (folder, folder / "deep", tmp_path / "a", tmp_path / "b"):
        place.mkdir(exist_ok=True)
        for name in ("yard", "maze") if place == folder else ("yard",):
            (place / f"{name}.world").write_text(f"# {place.name}\n{YARD}", encoding="utf-8")
    for place in ("a", "b"):
        text = f'world "../{place}/yard.world"\nlength 3\nmaximize depict(G_cart = red)\n'
        (folder / f"{place}.story").write_text(text, encoding="utf-8")
    library = packed(folder).library
    assert {name: (f.name, f.source.text[:8]) for name, f in library.worlds.items()} == {
        "yard": ("deep/yard.world", "# deep\nm"),
        "maze.world": ("maze.world", "# moods\n"),
        "outside/yard.world": ("outside/yard.world", "# a\nmap\n"),
        "yard-2": ("outside/yard-2.world", "# b\nmap\n"),
        "yard.world": ("yard.world", "# moods\n"),
    }
    assert {s["file"]: s["world"] for s in library.stories} == {
        "a.story": "outside/yard.world", "b.story": "yard-2",
        "secret.story": "kitchen",
    }  # fmt: skip


def test_the_same_folder_gives_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    first = encode(packed(folder).library.contents)
    moved = tmp_path / "elsewhere" / "again"
    moved.mkdir(parents=True)
    again = make_folder(moved)
    assert encode(packed(again, "other").library.contents) == first
    assert str(tmp_path).encode() not in first
    (folder / "moods.story").write_text(MOODS + "# more\n", encoding="utf-8")
    assert encode(packed(folder).library.contents) != first


def test_names_that_clash_are_shown_in_both_places(folder: Path) -> None:
    (folder / "other.story").write_text("pattern dark(x) = depict(x)\n", encoding="utf-8")
    (folder / "secret.story").unlink()
    said = refused(folder)
    assert "other.story:1:9: error[duplicate]: `dark` is defined in two files" in said
    assert "the first one (" in said
    assert "moods.story:4:9)" in said


def test_every_mistake_of_every_file_is_reported(folder: Path) -> None:
    (folder / "wrong.story").write_text("world kitchen\nlength 0\nmaximize rho\n", encoding="utf-8")
    (folder / "bad.story").write_text("pattern p(x) = depict(x, y, z)\n", encoding="utf-8")
    (folder / "odd.world").write_text("map\n", encoding="utf-8")
    said = refused(folder)
    for place in ("wrong.story:2:8", "wrong.story:3:10", "odd.world:1:1"):
        assert place in said
    (folder / "wrong.story").unlink()
    (folder / "odd.world").unlink()
    assert "bad.story:1:" in refused(folder)


def test_patterns_of_two_files_that_go_in_a_circle(folder: Path) -> None:
    (folder / "a.story").write_text("pattern one(x) = two(x)\n", encoding="utf-8")
    (folder / "b.story").write_text("pattern two(x) = one(x)\n", encoding="utf-8")
    assert "is defined by itself" in refused(folder)


def test_imports_that_go_in_a_circle(folder: Path) -> None:
    (folder / "a.story").write_text("import b\npattern one(x) = depict(x)\n", encoding="utf-8")
    (folder / "b.story").write_text("import a\npattern two(x) = depict(x)\n", encoding="utf-8")
    assert "the imports go in a circle" in refused(folder)


def test_an_import_that_is_not_there(folder: Path) -> None:
    (folder / "a.story").write_text("import nothere\npattern one(x) = x\n", encoding="utf-8")
    assert "a.story:1:8: error[import]: there is no library `nothere`" in refused(folder)


def test_a_folder_without_patterns(tmp_path: Path) -> None:
    (tmp_path / "a.story").write_text(
        "world kitchen\nlength 3\nmaximize depict(rho > 0)\n", encoding="utf-8"
    )
    assert "error[no-pattern]: there are no patterns in this folder" in refused(tmp_path)


def test_a_library_that_would_not_be_read_is_not_written(folder: Path) -> None:
    for number in range(6):
        text = f"pattern p{number}(x) = depict(x)\n" + "# long\n" * 15_000
        (folder / f"p{number}.story").write_text(text, encoding="utf-8")
    assert "at most 200,000 are read" in refused(folder)
    assert LARGEST > 4 * 200_000


def test_libraries_within_libraries(folder: Path, tmp_path: Path, i2p: Run) -> None:
    """What a compiled library imports of its own goes into the library that imports it."""
    i2p("compile", folder, "-o", tmp_path / "moods.i2plib", "--no-programs")
    upper = tmp_path / "upper"
    upper.mkdir()
    text = 'import "../moods.i2plib"\npattern top(x) = both(x, not x)\n'
    (upper / "top.story").write_text(text, encoding="utf-8")
    contents = packed(upper, "upper").library.contents
    assert [f.name for f in contents.patterns] == ["top.story"]
    assert contents.patterns[0].imports == {
        "../moods.i2plib": ["moods.i2plib/deep/turns.story", "moods.i2plib/moods.story"],
    }
    assert [f.name for f in contents.outside] == [
        "moods.i2plib/deep/turns.story",
        "moods.i2plib/moods.story",
        "moods.i2plib/outside/common.story",
    ]
    i2p("compile", upper, "-o", tmp_path / "both.i2plib", "--no-programs")
    (tmp_path / "moods.i2plib").unlink()
    story = tmp_path / "use.story"
    text = "world kitchen\nlength 4\nimport both\nmaximize top(rho > 0) + slow_depict(rho > 0)\n"
    story.write_text(text, encoding="utf-8")
    assert i2p("check", story).status == 0


def test_the_command(folder: Path, tmp_path: Path, i2p: Run) -> None:
    target = tmp_path / "moods.i2plib"
    done = i2p("compile", folder, "-o", target, "--no-programs")
    assert done.status == 0, done.err
    assert f"{target}: 4 patterns, 1 story checked\n  " in done.out
    written = target.read_bytes()
    done = i2p("compile", folder, "-o", target, "--no-programs", "--json")
    assert target.read_bytes() == written
    said = json.loads(done.out)
    assert said["patterns"] == ["after", "both", "dark", "pink_mind"]
    assert said["bytes"] == len(written)
    assert said["hash"] == f"sha256:{sha256(written).hexdigest()}"
    assert (said["name"], said["lets"], said["stories"]) == ("moods", 2, 1)


def test_wrong_usage_and_wrong_folders(folder: Path, tmp_path: Path, i2p: Run) -> None:
    for name in ("lib.json", "lib", ".i2plib"):
        done = i2p("compile", folder, "-o", tmp_path / name)
        assert done.status == 2
        assert "NAME.i2plib" in done.err
    assert i2p("compile", folder).status == 2
    target = tmp_path / "lib.i2plib"
    assert i2p("compile", tmp_path / "none", "-o", target).status == 1
    assert i2p("compile", tmp_path / "common.story", "-o", target).status == 1
    (folder / "wrong.story").write_text("maximize 1\n", encoding="utf-8")
    done = i2p("compile", folder, "-o", target)
    assert done.status == 1
    assert "wrong.story:1:1: error[no-world]" in done.err
    assert not target.exists()


def test_the_standard_library_compiles(i2p: Run, tmp_path: Path) -> None:
    target = tmp_path / "standard.i2plib"
    done = i2p("compile", data_folder("stories"), "-o", target, "--no-programs")
    assert done.status == 0, done.err
    library = PatternLibrary("standard", read_library(target))
    used = {name for story in library.stories for name in story["calls"]}
    assert {"arc", "depict", "irony", "twist"} <= used
    for record in library.patterns:
        assert record["documentation"], record["name"]
        assert record["worlds"]["kitchen"]["fits"], record["name"]


@pytest.mark.parametrize("name", ["con.story", "a:b.story", " x.story", "a..world", "nul.world"])
def test_a_file_whose_name_no_system_has(name: str, tmp_path: Path, i2p: Run) -> None:
    """It is said, and not stored: nobody could read the library."""
    folder = tmp_path / "source"
    folder.mkdir()
    (folder / "good.story").write_text("pattern p(e) = depict(e)\n", encoding="utf-8")
    world = "map\n    A.\ntile a\n    symbol = A\ncharacter r\n    goals = {a}\n"
    text = world if name.endswith(".world") else "pattern q(e) = depict(e)\n"
    (folder / name).write_text(text, encoding="utf-8")
    done = i2p("compile", folder, "-o", tmp_path / "x.i2plib")
    assert done.status == 1
    assert f"{folder / name}:1:1: error[library]: a file of this name cannot be" in done.err
    assert not (tmp_path / "x.i2plib").exists()


@pytest.mark.parametrize("name", ["CON", " x", "x ", ".x", "x" * 201])
def test_a_library_whose_name_no_system_has(name: str, tmp_path: Path, i2p: Run) -> None:
    done = i2p("compile", tmp_path, "-o", tmp_path / f"{name}.i2plib")
    assert done.status == 2
    assert "a library is called NAME.i2plib, not " in done.err
