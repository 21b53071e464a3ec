"""The commands on the hill."""

from __future__ import annotations

import json
import os
import signal
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from commands_for_tests import Run, on_a_terminal
from hill_for_tests import BRIEFLY, DESCENT
from i2pdsl.cli import DONE, INTERRUPTED, WRONG
from i2pdsl.planning.actor_critic import Recipe
from i2pdsl.worlds.hill import training

MIME = f"""world hill(weight = 0.1)
length 20
let heavy = weight = 0.5
maximize depict(heavy)
{DESCENT}
"""


# Of ten windows, each of a second.
LONG = MIME.replace("length 20", "length 200").replace("steps = 2", "steps = 20")


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "mime.story").write_text(MIME, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_run_query_and_render(place: Path, i2p: Run) -> None:
    done = i2p("run", "mime.story", "--format", "png,html", "--json")
    assert done.status == DONE, done.err
    result = json.loads(done.out)
    assert set(result["files"]) == {"comic.png", "mind.png", "html"}
    assert set(result["seconds"]) == {"plan", "compile", "search", "render"}
    script = result["script"]
    asked = i2p("query", script, "P(heavy | script[:t])", "--json")
    answer = json.loads(asked.out)
    assert answer["t"] == list(range(21))
    assert answer["value"][0] == pytest.approx(0.5)
    table = json.loads(i2p("query", script, "P(weight | script[:T])", "--json").out)
    assert table["value"].keys() == {"0.1", "0.5", "unknown"}
    drawn = i2p("render", script, "--format", "svg", "--out", "again")
    assert drawn.status == DONE
    assert {p.name for p in (place / "again").iterdir()} == {"comic.svg", "mind.svg"}
    lacking = i2p("render", script, "--format", "sheet", "--out", "again")
    assert (lacking.status, lacking.out) == (DONE, "")
    assert "warning[pictures]: there is no sheet of hill" in lacking.err
    opaque = i2p("render", script, "--format", "gif", "--transparent", "--out", "again")
    assert opaque.status == WRONG
    assert "films of hill cannot be transparent" in opaque.err


def test_candidates_of_a_descent_are_its_seeds(place: Path, i2p: Run) -> None:
    one = json.loads(i2p("run", "mime.story", "--format", "", "--json").out)
    assert len(one["candidates"]) == 1
    two = json.loads(i2p("run", "mime.story", "--format", "", "--candidates", "2", "--json").out)
    assert two["candidates"][0]["score"] == one["score"]
    assert len(two["candidates"]) == 2
    many = i2p("run", "mime.story", "--format", "", "--candidates", "9")
    assert "2 scripts found" in many.err


def test_several_scripts_are_drawn_side_by_side(place: Path, i2p: Run) -> None:
    for name, more in (("light", "0.1"), ("heavy", "0.5")):
        text = f"world hill(weight = {more})\nlength 12\nsearch naive\n"
        (place / f"{name}.story").write_text(text, encoding="utf-8")
    done = i2p("render", "light.story", "heavy.story", "--format", "png,html", "--json")
    assert done.status == DONE, done.err
    document = json.loads(done.out)
    assert document["script"] == ["light.story", "heavy.story"]
    assert {Path(f).name for f in document["files"].values()} == {
        "together.png", "mind.png", "together.html",
    }  # fmt: skip
    (place / "walk.story").write_text("world fork\nlength 3\nsearch naive\n", encoding="utf-8")
    mixed = i2p("render", "light.story", "walk.story")
    assert mixed.status == WRONG
    assert "these scripts cannot be drawn side by side" in mixed.err


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("heavy=weight = 0.1", "let heavy = weight = 0.1"),
        ("sigma=2", "world hill(weight = 0.1, sigma = 2)"),
        ("weights={0.5, 0.1}", "world hill(weight = 0.1, weights = {0.5, 0.1})"),
        ("damping=0.9", DESCENT.replace(")", ", damping = 0.9)")),
        # Another program, which takes long to compile: it is enough that the story is right.
        ("length=5", "length 5"),
        ("steps=1", DESCENT.replace("steps = 2", "steps = 1")),
        ("bound=1.5", DESCENT.replace(")", ", bound = 1.5)")),
    ],
)
def test_set_on_the_hill(place: Path, i2p: Run, setting: str, expected: str) -> None:
    naive = ["--naive"] if setting.startswith(("length", "steps", "bound")) else []
    done = i2p("run", "mime.story", "--set", setting, *naive, "--format", "", "--json")
    assert done.status == DONE, done.err
    script = json.loads(Path(json.loads(done.out)["script"]).read_text())
    assert expected in script["story"]["source"].splitlines()


def test_what_only_other_worlds_can_do_is_said(place: Path, i2p: Run) -> None:
    planned = i2p("plan", "hill")
    assert planned.status == WRONG
    assert "`i2p train hill`" in planned.err
    trained = i2p("train", "kitchen")
    assert trained.status == WRONG
    assert "`i2p plan kitchen`" in trained.err
    untrained = i2p("run", "mime.story", "--set", "slope=0.3")
    assert untrained.status == WRONG
    assert "`i2p train hill --set slope=0.3 --seed 2`" in untrained.err
    beam = i2p("run", "mime.story", "--set", "width=3")
    assert beam.status == WRONG
    assert "no `width` to set" in beam.err


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("weights=0.3", "`weights` cannot be 0.3"),
        ("weights={0.3}", "it can be: 2 to 16 different numbers"),
        ("weights={a, b}", "`weights` cannot be {a, b}"),
        ("slope=steep", "it can be: between -0.3 and 0.6"),
        ("stiffness=3", "no setting `stiffness`"),
        ("controller=nan", "`controller` cannot be nan"),
        ("sigma=2", "training does not depend on `sigma`"),
    ],
)
def test_training_settings_that_are_wrong(i2p: Run, setting: str, words: str) -> None:
    done = i2p("train", "hill", "--set", setting)
    assert done.status == WRONG
    assert words in done.err


ANOTHER = ("--set", "weights={0.1,0.3,0.5}", "--set", "slope=0.2")
TRAIN = ("train", "hill", *ANOTHER, "--iterations", "6")

# One hill for all trainings that follow: its programs are compiled once.
SAME_HILL, SAME_LOOKER = cache(training.hill_environment), cache(training.looker)


@pytest.fixture
def quick(place: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("I2PDSL_CACHE", str(place / "cache"))
    monkeypatch.setattr(training, "FRAMES", 20)
    monkeypatch.setattr(training, "CHUNK", 2)
    monkeypatch.setattr(training, "improve_often", BRIEFLY)
    monkeypatch.setattr(training, "hill_environment", SAME_HILL)
    monkeypatch.setattr(training, "looker", SAME_LOOKER)
    return place


def test_train_stores_what_a_story_then_uses(quick: Path, i2p: Run) -> None:
    """Three weights on another slope, hardly trained at all."""
    done = i2p(*TRAIN, "--json")
    assert done.status == DONE, done.err
    document = json.loads(done.out)
    assert document["weights"] == [0.1, 0.3, 0.5]
    assert len(document["climbs"]) == 3
    assert document["finished"]
    assert Path(document["controllers"]).is_file()
    heavy = ("--set", "heavy=weight >= 0.3")
    run = i2p("run", "mime.story", *ANOTHER, *heavy, "--naive", "--format", "png", "--json")
    assert run.status == DONE, run.err
    asked = i2p("query", json.loads(run.out)["script"], "P(weight | script[:T])", "--json")
    assert json.loads(asked.out)["value"].keys() == {"0.1", "0.3", "0.5", "unknown"}


@pytest.mark.slow  # test_descent.py and test_cli.py interrupt searches in this process
def test_an_interrupted_run_keeps_what_it_has(place: Path) -> None:
    (place / "mime.story").write_text(LONG, encoding="utf-8")
    done = on_a_terminal("run", "mime.story", "--format", "", until="searching:")
    assert done.status == INTERRUPTED, done.err
    assert "interrupted: the best of what was searched so far is kept" in done.err
    assert "mime (seed 0): score" in done.out


FOREVER = ("train", "hill", "--iterations", "100000", "--set", "slope=0.15")


@pytest.mark.slow
def test_an_interrupted_training_keeps_what_it_has(place: Path) -> None:
    environment = {**os.environ, "I2PDSL_CACHE": str(place / "cache")}
    done = on_a_terminal(*FOREVER, until="training:", env=environment)
    assert done.status == INTERRUPTED, done.err
    assert "interrupted: the best so far is kept" in done.err
    assert list((place / "cache" / "controllers").glob("*.npz"))


def test_a_signal_while_it_trains_keeps_what_there_is(
    quick: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same in this process, in small pieces."""
    pieces = []

    def improve(*given: Any) -> Any:
        pieces.append(BRIEFLY(*given))
        if len(pieces) == 2:
            signal.raise_signal(signal.SIGINT)
        return pieces[-1]

    monkeypatch.setattr(training, "improve_often", improve)
    done = i2p(*TRAIN)
    assert done.status == INTERRUPTED, done.err
    assert "interrupted: the best so far is kept" in done.err
    assert len(pieces) == 2
    assert list((quick / "cache" / "controllers").glob("*.npz"))


def test_a_recipe_is_what_was_measured() -> None:
    """What ships was trained with it; another recipe would need other weights."""
    recipe = Recipe()
    assert (recipe.environments, recipe.horizon, recipe.iterations) == (64, 32, 2400)
    assert recipe.gamma == pytest.approx(0.99)
    assert np.allclose(recipe.noise, (0.3, 0.2))
