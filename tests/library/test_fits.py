"""That a pattern fits a world is proved by the checker, call by call."""

from __future__ import annotations

from pathlib import Path

import pytest

from i2pdsl.errors import Source
from i2pdsl.language.check import check_source
from i2pdsl.language.imports import build_module
from i2pdsl.language.parse import parse
from i2pdsl.language.vocabulary import Vocabulary
from i2pdsl.library import fits
from i2pdsl.library.description import PatternLibrary
from i2pdsl.library.fits import LENGTH, candidates, example_call, fit
from i2pdsl.library.pack import pack
from i2pdsl.worlds.find import builtin_worlds, find_vocabulary


def world(name: str) -> Vocabulary:
    found = find_vocabulary(name)
    assert found is not None
    return found


def packed(tmp_path: Path, text: str) -> PatternLibrary:
    path = tmp_path / "one.story"
    path.write_text(f"{text}\n", encoding="utf-8")
    return pack(tmp_path, [path], "one").library


GRID = "cellar court estate farm fork kitchen maze nursery park porters"
ALL = " ".join(builtin_worlds())
MOVING = " ".join(name for name in builtin_worlds() if name != "hill")
SOCIAL = "cellar estate farm house kitchen maze pasture porters"


@pytest.mark.parametrize(
    ("pattern", "worlds"),
    [
        ("pattern p(e) = depict(e)", ALL),
        ("pattern p(who) = arc(who)", ALL),
        ("pattern p(x) = sum_t suspense(x | script[:t])", GRID),
        ("pattern p(level) = sum_t P(rho > level | script[:t])", SOCIAL),
        ("pattern p = depict(weight = 0.5)", "hill"),
        ("pattern p(who) = sum_t [fallen(who) @ script[t]]", "hill"),
        ("pattern p(who) = sum_t [moved(who) @ script[t]]", MOVING),
        ("pattern p = depict(G_cheese = purple)", ""),
        ("pattern p(rho) = depict(rho)", "court desk fork hill meadow nursery park"),
        ("pattern p(x, v) = sum_t P(x = v | script[:t])", ALL),
        ("pattern p = rho > 0", SOCIAL),
        # A pattern cannot stand for the first frames of a script behind a bar.
        ("pattern p(e) = script[:5]", ""),
        ("pattern p = t/T", ALL),
    ],
)
def test_worlds_that_a_pattern_fits(tmp_path: Path, pattern: str, worlds: str) -> None:
    library = packed(tmp_path, pattern)
    (record,) = library.patterns
    found = record["worlds"]
    assert list(found) == ALL.split()
    assert [name for name, proof in found.items() if proof["fits"]] == worlds.split()
    for name, proof in found.items():
        if not proof["fits"]:
            assert proof["because"]
        elif "rho > 0" not in pattern and "t/T" not in pattern:
            call = example_call(record, library.exports, library.vocabularies[name])
            text = f"world {name}\nlength {LENGTH}\n{pattern}\nmaximize {call}\n"
            checked = check_source(Source("proof", text), find_vocabulary)
            assert checked.warnings == (), "an example without a warning is chosen"


def test_every_character_must_do() -> None:
    """What one character can do is not enough."""
    kitchen = world("kitchen")
    record = {
        "name": "p",
        "parameters": [{"name": "who", "kind": "character", "default": None}],
        "result": "number",
    }
    text = "pattern p(who) = last(script ++ [cheese: stay, who: stay])"
    module = build_module(parse(Source("m", text)), lambda _: None, None)
    proof = fit(record, module, kitchen)
    assert not proof["fits"], "`cheese` would act twice, though `robot` would do"
    assert "twice" in proof["because"]


def test_candidates_are_of_the_world() -> None:
    kitchen = world("kitchen")
    assert candidates("character", kitchen) == ["cheese", "robot"]
    assert candidates("latent", kitchen) == ["rho", "G_cheese", "G_robot"]
    assert "G_cheese = pink" in candidates("event", kitchen)
    assert candidates("event", kitchen)[:2] == ["rho > 0", "rho < 0"]
    for event in candidates("event", kitchen):
        text = f"world kitchen\nlength 3\nassume nothing\nmaximize depict({event})\n"
        check_source(Source("event", text), find_vocabulary)
    for seen in candidates("predicate", kitchen):
        text = f"world kitchen\nlength 3\nmaximize sum_t [{seen} @ script[t]]\n"
        check_source(Source("seen", text), find_vocabulary)


def test_work_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was not tried is said to be so."""
    monkeypatch.setattr(fits, "MOST_WORK", 6000)
    lines = [f"pattern p{i}(e) = {' + '.join(['depict(e)'] * 20)}" for i in range(20)]
    first, *_, last = packed(tmp_path, "\n".join(lines)).patterns
    assert fits.was_tried(first)
    assert first["worlds"]["fork"]["fits"]
    assert not fits.was_tried(last)
    assert {proof["because"] for proof in last["worlds"].values()} == {fits.NOT_TRIED}
