"""Compiled libraries as stories use them: as if their patterns were written in the file."""

from __future__ import annotations

from pathlib import Path

import pytest
from libraries_for_tests import TURNS, make_folder, packed, zipped

from commands_for_tests import Run
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.language.packed import encode, write_contents
from i2pdsl.worlds.find import find_vocabulary

HEAD = "world kitchen\nlength 6\n"


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A folder with moods.i2plib and nothing of what it was made from."""
    folder = make_folder(tmp_path / "made")
    write_contents(tmp_path / "moods.i2plib", packed(folder).contents)
    (tmp_path / "made").rename(tmp_path / ".away")
    return tmp_path


def story(text: str, place: Path) -> TypedStory:
    checked = check_source(Source(str(place / "my.story"), text), find_vocabulary, place)
    assert isinstance(checked, TypedStory)
    return checked


def refused(text: str, place: Path) -> str:
    with pytest.raises(StoryError) as caught:
        story(text, place)
    return str(caught.value).replace(f"{place}/", "")


def test_the_same_objective_as_with_the_text_itself(place: Path) -> None:
    written = (place / ".away" / "moods" / "moods.story").read_text(encoding="utf-8")
    turns = TURNS.replace('import "../../common.story"\n', "")
    common = (place / ".away" / "common.story").read_text(encoding="utf-8")
    use = "maximize both(rho > 0, G_cheese = pink)\nminimize middle * pink_mind(0)\n"
    imported = story(f"{HEAD}import moods\n{use}", place)
    inline = story(f"{HEAD}{written}{turns}{common}{use}", place)
    assert imported.objective == inline.objective
    assert imported.warnings == ()


@pytest.mark.parametrize(
    "statement", ["import moods", 'import "moods.i2plib"', 'import "deep/../moods.i2plib"']
)
def test_ways_to_import(place: Path, statement: str) -> None:
    (place / "deep").mkdir()
    story(f"{HEAD}{statement}\nmaximize dark(rho > 0)\n", place)


def test_files_and_folders_come_first(place: Path) -> None:
    (place / "moods.story").write_text("pattern dark(x) = 2 * depict(x)\n", encoding="utf-8")
    checked = story(f"{HEAD}import moods\nmaximize dark(rho > 0)\n", place)
    doubled = story(f"{HEAD}maximize 2 * depict(rho > 0)\n", place)
    assert checked.objective == doubled.objective


def test_own_names_and_earlier_imports_hide_those_of_a_library(place: Path) -> None:
    (place / "first.story").write_text("pattern dark(x) = 3 * depict(x)\n", encoding="utf-8")
    use = "maximize dark(rho > 0)\n"
    own = story(f"{HEAD}import moods\npattern dark(x) = 2 * depict(x)\n{use}", place)
    assert own.objective == story(f"{HEAD}maximize 2 * depict(rho > 0)\n", place).objective
    first = story(f"{HEAD}import first\nimport moods\n{use}", place)
    assert first.objective == story(f"{HEAD}maximize 3 * depict(rho > 0)\n", place).objective


def test_a_library_of_patterns_can_import_one(place: Path) -> None:
    text = "import moods\npattern twice(x) = 2 * dark(x)\n"
    (place / "more.story").write_text(text, encoding="utf-8")
    story(f"{HEAD}import more\nmaximize twice(rho > 0) + dark(rho < 0)\n", place)


def test_a_mistake_inside_a_pattern_shows_both_places(place: Path) -> None:
    said = refused("world fork\nlength 6\nimport moods\nmaximize pink_mind(0)\n", place)
    line = next(i for i, x in enumerate(TURNS.splitlines(), 1) if "pattern pink_mind" in x)
    column = TURNS.splitlines()[line - 1].index("G_cheese") + 1
    assert f"moods.i2plib/deep/turns.story:{line}:{column}: error[" in said
    assert f"    {line} | {TURNS.splitlines()[line - 1]}" in said
    assert "in `pink_mind`, used here (my.story:4:10)" in said
    assert "    4 | maximize pink_mind(0)" in said


def test_a_wrong_argument_is_shown_where_it_was_written(place: Path) -> None:
    said = refused(f"{HEAD}import moods\nmaximize both(rho > 0, G_cheese)\n", place)
    assert said.startswith("my.story:4:24: error[distribution]")
    assert "moods.i2plib/" in said


def test_a_damaged_library_is_an_error_at_the_import(place: Path) -> None:
    path = place / "moods.i2plib"
    path.write_bytes(path.read_bytes()[:-40])
    said = refused(f"{HEAD}import moods\nmaximize dark(rho > 0)\n", place)
    first = said.splitlines()[0]
    assert first.startswith(
        "my.story:3:8: error[import]: `moods.i2plib` cannot be used: the library is damaged"
    )
    assert "unknown-pattern" not in said, "what follows from it is not reported"
    assert "hint: compile it again" in said


def test_an_earlier_version_says_so(place: Path) -> None:
    (place / "moods.i2plib").write_text('{"format": "i2p-library", "version": 1}')
    said = refused(f"{HEAD}import moods\nmaximize dark(rho > 0)\n", place)
    assert "`moods.i2plib` cannot be used: made by an earlier version of i2pdsl (format 1)" in said
    assert "hint: compile it again: `i2p compile FOLDER -o moods.i2plib`" in said


def test_a_later_version_says_so(place: Path) -> None:
    manifest = b'{"format": "i2p-library", "version": 3}'
    (place / "moods.i2plib").write_bytes(zipped([("manifest.json", manifest)]))
    said = refused(f"{HEAD}import moods\nmaximize dark(rho > 0)\n", place)
    assert "made by a later version of i2pdsl (format 3); this one reads format 2" in said
    assert "hint: update i2pdsl" in said


def test_recursion_that_a_forged_library_brings_ends(place: Path) -> None:
    """Patterns that grow without bound are refused where they are used, not when they are read."""
    folder = place / "grow"
    folder.mkdir()
    lines = ["pattern p0(e) = depict(e)"]
    lines += [f"pattern p{i}(e) = p{i - 1}(e) + p{i - 1}(e)" for i in range(1, 18)]
    (folder / "grow.story").write_text("\n".join(lines) + "\n", encoding="utf-8")
    write_contents(place / "grow.i2plib", packed(folder, "grow").contents)
    story(f'{HEAD}import "grow.i2plib"\nmaximize p9(rho > 0)\n', place)
    said = refused(f'{HEAD}import "grow.i2plib"\nmaximize p17(rho > 0)\n', place)
    assert "error[nesting]" in said


def test_commands_use_it(place: Path, i2p: Run) -> None:
    (place / "my.story").write_text(f"{HEAD}import moods\nmaximize dark(rho > 0)\n")
    assert i2p("check", place / "my.story").status == 0
    said = i2p("patterns", place / "moods.i2plib").out
    assert "dark(event, share = 0.8)\n    Viewers are kept in the dark.\n" in said
    assert "slow_depict" not in said
    again = encode(packed(place / ".away" / "moods").contents)
    assert again == (place / "moods.i2plib").read_bytes()
