"""Study files: what they say, and what is said of those that are wrong."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from commands_for_tests import Run
from i2pdsl.errors import Source, StoryError
from i2pdsl.study.parse import SYNTAX, load_study, parse_study
from i2pdsl.study.spec import Between, Film, Item, OneOf
from studies_for_tests import TINY

STUDIES = sorted((Path(__file__).parents[2] / "studies").glob("*.study"))


def test_a_study_says_what_is_shown_asked_and_compared(place: Path) -> None:
    study = load_study(place / "tiny.study")
    assert (study.title, study.seeds, study.question.kind) == (
        "Help or hinder",
        (0, 1, 2, 3),
        "choice",
    )
    assert [(c.name, c.label, c.right) for c in study.conditions] == [
        ("help", "helping", "helping"),
        ("hinder", "hinder", "hindering"),
    ]
    assert study.method("short").settings == (("length", "2"),)
    assert (study.method("short").against, study.method("naive").against) == ("naive", "")
    assert [(a.name, a.event) for a in study.answers][1:] == [
        ("hindering", "rho < 0"),
        ("unclear", ""),
    ]
    assert study.people == {("help", "naive"): 0.5}
    drawn = study.panels[0].drawn
    assert drawn["sharpness"] == Between(0.3, 2.0, True)
    assert drawn["lapse"] == Between(0.0, 0.1, False)
    assert drawn["forgetting"] == OneOf((0.001, 0.1))
    assert len(study.films) == len({film.place for film in study.films}) == 16
    assert study.items[5] == Item("help", "short", (Film("help", "short", 1),), "helping")


def test_pairs_are_films_side_by_side() -> None:
    hill = next(path for path in STUDIES if path.stem == "hill")
    study = load_study(hill)
    films = {
        pair.name: [i.films for i in study.items if i.group == pair.name] for pair in study.pairs
    }
    assert films["mime_heavy"][1] == (Film("mime", "story", 1), Film("heavy", "story", 1))
    last = len(study.seeds) - 1
    assert films["light_light"][last] == (Film("light", "story", last), Film("light", "story", 0))
    assert study.figure("mime_light", "story") == 0.957


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_studies_that_come_with_it_are_right(path: Path, i2p: Run) -> None:
    assert i2p("check", path).status == 0
    source = Source(path.name, path.read_text(encoding="utf-8"))
    assert SYNTAX.formatted(source) == source.text


WRONG = {
    'seeds = "0-3"': ('seeds = "a-3"', "4:13: error[study-value]: these are no seeds"),
    "condition help\n": ("condition\n", "6:1: error[study-block]: every condition needs a name"),
    "    right = helping\n": (
        "    right = helpful\n",
        "9:13: error[study-name]: there is no answer `helpful`",
    ),
    "    right = hindering\n": ("", "10:11: error[study-block]: which answer is right for"),
    '    story = "hinder.story"\n': ("", "10:11: error[study-block]: `hinder` has no story"),
    '"length = 2"': ('"length 2"', "18:12: error[study-value]: this sets nothing"),
    "against = naive": ("against = short", "19:15: error[study-name]: there is no method `short`"),
    'ask = "W': ('kind = slider\n    ask = "W', "21:1: error[study-block]: a slider needs"),
    'ask = "What was the robot doing?"': ("ask = what", "22:11: error[study-value]: `ask` must be"),
    "answer unclear": ("answer helping", "27:8: error[duplicate]: there are two `answer helping`"),
    "naive = 0.5": ("told = 0.5", "30:5: error[study-name]: there is no method `told`"),
    "people help": ("people halp", "29:8: error[study-name]: there is no condition `halp`"),
    "(0.3, 2)": ("(2, 0.3)", "34:17: error[study-range]: the range is empty"),
    "{0.001, 0.1}": ("(0, 0.1)", "35:18: error[study-range]: this range must begin above 0"),
    "lapse = (0": ("lapses = (0", "39:5: error[study-key]: `panel` has no `lapses`"),
    "doubt = 0.5": ("doubt = -1", "36:13: error[study-range]: `doubt` must be from 0 to 10"),
    "matching}": ("guessing}", "37:22: error[study-name]: there is no rule `guessing`"),
    "viewers = 6": ("viewers = 0", "33:15: error[study-range]: `viewers` must be a whole number"),
    "panel own": ("panel own\n    people = 1", "41:14: error[study-value]: `people` must"),
    "question\n": ("quest\n", "21:1: error[study-block]: `quest` begins no block of a study"),
}  # fmt: skip


@pytest.mark.parametrize("right", WRONG)
def test_mistakes_are_told_at_their_places(right: str) -> None:
    wrong, told = WRONG[right]
    with pytest.raises(StoryError) as caught:
        parse_study(Source("a.study", TINY.replace(right, wrong, 1)), Path("a.study"))
    assert f"a.study:{told}" in str(caught.value)


OF_STORIES = {
    '"hinder.story"': ('"no.story"', "tiny.study:11:13: error[no-file]"),
    '"length = 2"': ('"size = 2"', "tiny.study:18:11: error[set]: the story has no `size` to set"),
    '"rho < 0"': ('"rho < blue"', "tiny.study:26:20"),
    "doubt = 0.5": ("mood = 1", "tiny.study:36:12: error[study-key]: viewers of world"),
    "doubt = 0.6": ("level0 = wild", "tiny.study:36:14: error[study-value]: `level0` cannot"),
    "panel own": ('panel own\n    people = "none.toml"', "there is no audience file `none.toml`"),
}  # fmt: skip


@pytest.mark.parametrize("right", OF_STORIES)
def test_mistakes_about_stories_are_told_there(right: str, place: Path, i2p: Run) -> None:
    wrong, told = OF_STORIES[right]
    text = TINY.replace(right.replace("0.6", "0.5"), wrong, 1)
    (place / "tiny.study").write_text(text, encoding="utf-8")
    done = i2p("check", place)
    assert (done.status, told in done.err) == (1, True), done.err
    done = i2p("study", place / "tiny.study", "--out", place / "out")
    assert (done.status, told in done.err, (place / "out").exists()) == (1, True, False)


def test_names_lead_nowhere_else(place: Path) -> None:
    """A name is a name; one that no file can have is replaced by one that it can."""
    for name in ("con", "n" * 300):
        text = TINY.replace("condition help", f"condition {name}").replace(
            "people help", f"people {name}"
        )
        study = parse_study(Source("a.study", text), place / "a.study")
        where = study.films[0].place
        assert not where.startswith(f"{name}/")
        assert all(len(part) < 100 for part in where.split("/"))
    for name in ("../up", "/etc", '"a/b"'):
        text = TINY.replace("condition help", f"condition {name}")
        with pytest.raises(StoryError):
            parse_study(Source("a.study", text), place / "a.study")


def test_given_scripts_are_films(place: Path, i2p: Run, here: list[str]) -> None:
    """In the order of their names, as many as the study wants."""
    assert i2p("study", place / "tiny.study", "--out", place / "out").status == 0
    for condition in ("help", "hinder"):
        (place / "given" / condition).mkdir(parents=True)
        for seed in range(4):
            made = place / "out/films" / condition / "short" / f"seed-{seed}" / "script.json"
            made.rename(place / "given" / condition / f"{9 - seed}.json")
    text = TINY.replace('set = ["length = 2"]', 'scripts = "given"').replace(
        "    naive = yes\n    scr", "    scr"
    )
    (place / "tiny.study").write_text(text, encoding="utf-8")
    here.clear()
    done = i2p("study", place / "tiny.study", "--out", place / "again", "--json")
    assert done.status == 0, done.err
    assert not any("short" in place for place in here)
    before = json.loads(i2p("study", place / "tiny.study", "--out", place / "again", "--json").out)
    share = next(
        s for s in before["panels"][1]["shares"] if (s["group"], s["method"]) == ("help", "short")
    )
    assert share["films"] == 4
    assert "../given/help/6.json" in (place / "again/answers-own.csv").read_text(encoding="utf-8")
    first = place / "given/help/6.json"
    text = first.read_text(encoding="utf-8")
    first.write_text(text.replace('"settings": {}', '"settings": {"beta": 1.0}'), encoding="utf-8")
    assert "7.json is of another world than the scripts before it" in i2p("check", place).err
    first.unlink()
    done = i2p("check", place)
    assert "`help` has 3 scripts, the study wants number 3" in done.err
