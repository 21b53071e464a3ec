"""What stands around stories takes any kind of world: `i2p new`, the studio's ways to begin, its
stage in notebooks, the films of a catalogue. Shown with the kind that docs/new-world.md makes, as
it is there, and with all that a kind may bring besides."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import ModuleType

import pytest

from commands_for_tests import Run
from i2pdsl.cli import DONE, USAGE, WRONG
from i2pdsl.commands.patterns import catalogued
from i2pdsl.errors import StoryError
from i2pdsl.library import catalogue
from i2pdsl.library.films import pack_film, read_film
from i2pdsl.render import film_page
from i2pdsl.render.drawing import Drawing
from i2pdsl.render.pictures import page_scripts
from i2pdsl.stories import Story, load
from i2pdsl.studio.begin import begun, ways
from i2pdsl.studio.folder import Folder
from i2pdsl.worlds.beginnings import Beginning, Beginnings
from i2pdsl.worlds.kinds import KINDS, Place, drawing_named, kind_named
from test_new_world import hall  # noqa: F401

SCRIPT = "corridor/corridor.js"
STAGE = "export const makeStage = () => ({ draw: () => {} });  // a corridor's stage\n"


@pytest.fixture
def place(hall: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:  # noqa: F811
    """A folder with a world of the corridor's kind."""
    (tmp_path / "hall.world").write_text((hall / "hall.world").read_text("utf-8"), "utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def begins(place: Path, monkeypatch: pytest.MonkeyPatch) -> Beginning:
    """A way to begin that the corridor's kind offers meanwhile, with a world of one's own."""
    line = ("Viewers shall know where {actor} goes.", "maximize legible(G_{actor} = {here})")
    way = Beginning("stroll", "{actor} strolls to {here}", "legible", 5, (line,))
    module = ModuleType("corridor_beginnings")
    more = (("what must be seen", "require eventually [at({actor}, {here})]"),)
    module.BEGINNINGS = Beginnings("corridor", (way,), more, template=place / "hall.world")
    monkeypatch.setitem(sys.modules, "corridor_beginnings", module)
    known = KINDS["corridor"]
    monkeypatch.setitem(
        KINDS, "corridor", Place(known.worlds, known.drawing, "corridor_beginnings")
    )
    return way


@pytest.fixture
def moved(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The corridor's drawing has a script for pages meanwhile."""
    drawing: type[Drawing] = type(drawing_named("corridor"))
    monkeypatch.setattr(drawing, "page_script", lambda self: SCRIPT)
    part = film_page.part
    for module in (film_page, catalogue, pytest.importorskip("i2pdsl.studio.cell")):
        monkeypatch.setattr(module, "part", lambda name: STAGE if name == SCRIPT else part(name))


def test_a_kind_without_beginnings_is_refused_in_words(i2p: Run, place: Path) -> None:
    for arguments, told in (
        ([], "`i2p patterns` lists them"),
        (["--pattern", "help"], "of the kind map"),
        (["--pattern", "betryal"], "did you mean `betrayal`?"),
    ):
        done = i2p("new", "mine.story", "--world", "hall.world", *arguments)
        assert done.status == WRONG
        assert "error[no-pattern]" in done.err
        assert told in done.err
        assert "hint: " in done.err
    assert not (place / "mine.story").exists()
    assert i2p("new", "mine.story", "--kind", "corridor").status == USAGE
    rows = json.loads(i2p("new", "--list", "--json").out)
    assert "corridor" not in {row["kind"] for row in rows}


def test_a_standard_pattern_begins_in_any_kind(i2p: Run, place: Path) -> None:
    done = i2p("new", "mine.story", "--world", "hall.world", "--pattern", "legible")
    assert done.status == DONE
    path = place / "mine.story"
    story = load(path)
    assert story.warnings == ()
    assert (story.typed.world, story.spec.kind) == ("hall.world", "corridor")
    assert "maximize legible(" in path.read_text("utf-8")
    assert "More to try" not in path.read_text("utf-8")
    told = begun(Folder(place), "yours", "legible", "hall")
    assert set(told) == {"path", "text"}
    assert Story.from_text(told["text"], place).spec.kind == "corridor"


def test_the_studio_refuses_in_words_too(place: Path) -> None:
    found = ways(Folder(place))
    names = {each["name"] for each in found["worlds"]}
    assert "hall" in names
    assert "new corridor" not in names
    for beginning in (None, "", "help"):
        with pytest.raises(StoryError, match=r"can(not)? be told in hall") as wrong:
            begun(Folder(place), "mine", beginning, "hall")
        assert wrong.value.diagnostics[0].hint


def test_a_kind_may_bring_beginnings_and_a_world(i2p: Run, place: Path, begins: Beginning) -> None:
    assert i2p("new", "mine", "--pattern", begins.name).status == DONE
    assert load(place / "mine.story").spec.kind == "corridor"
    assert (place / "mine.world").read_text("utf-8") == (place / "hall.world").read_text("utf-8")
    assert "# require eventually [at(" in (place / "mine.story").read_text("utf-8")
    assert i2p("new", "ours", "--world", "hall.world").status == DONE
    rows = json.loads(i2p("new", "--list", "--kind", "corridor", "--json").out)
    assert [(row["kind"], row["name"], row["pattern"]) for row in rows] == [
        ("corridor", "stroll", "legible")
    ]
    assert "{" not in rows[0]["told"]
    found = ways(Folder(place))
    assert "new corridor" in {each["name"] for each in found["worlds"]}
    assert "stroll" in {each["name"] for each in found["beginnings"]}
    told = begun(Folder(place), "yours", None, "new corridor")
    assert told["world"]["path"] == "yours.world"
    assert "world yours\n" in told["text"]


def test_a_stage_in_notebooks_is_there_for_each_script(place: Path, moved: None) -> None:
    from i2pdsl.studio.cell import StudioWidget

    text = 'world "hall.world"\nlength 3\nmaximize depict(G_walker = left)\n'
    widget = StudioWidget(Story.from_text(text, place))
    assert "a corridor's stage" in widget._esm
    assert all(f'"{script}": kind' in widget._esm for script in page_scripts())
    widget.close()


def test_a_kind_without_a_script_has_no_stage(place: Path) -> None:
    assert [script.partition("/")[0] for script in page_scripts()] == list(KINDS)[:-1]


def test_a_film_is_kept_in_a_catalogue(place: Path, moved: None) -> None:
    film = pack_film({"script": SCRIPT, "last": 3})
    path = place / "a.film"
    path.write_text(film.as_text(), encoding="ascii")
    assert read_film(path) == film
    allowed, player = catalogue._player([film.script])
    assert "a corridor's stage" in player
    assert f'"{SCRIPT}": make0' in player
    assert allowed.startswith("'sha256-")


def test_a_kind_says_where_a_catalogue_shows_patterns(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert catalogued() == ["kitchen", "hill"]
    monkeypatch.setattr(type(kind_named("corridor")), "catalogued", ("hall",))
    assert catalogued() == ["kitchen", "hill", "hall"]


def test_a_film_that_nothing_moves_is_not(place: Path) -> None:
    path = place / "a.film"
    path.write_text(pack_film({"script": SCRIPT}).as_text(), encoding="ascii")
    assert read_film(path) is None
