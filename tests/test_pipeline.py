"""From a story to answers in Python, and the caches behind it: whatever happens to them."""

from __future__ import annotations

import doctest
import errno
import io
import json
import os
import shutil
import subprocess
import sys
import threading
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest

import i2pdsl
from fuzz_for_tests import FULL
from i2pdsl import pipeline, scripts
from i2pdsl.language.naming import same_name
from i2pdsl.planning import store
from i2pdsl.render.pictures import pictures_of
from i2pdsl.resources import cache_folder
from i2pdsl.worlds.grid.naive import naive_rollout
from i2pdsl.worlds.grid.planning import load_or_plan
from i2pdsl.worlds.grid.script import APART, distance
from worlds_for_tests import SMALL_MAP, kitchen_text, planned, small_kitchen

WORLD = kitchen_text(SMALL_MAP, gamma="0.9")
HELP = """world small
length 5
maximize sum_t P(rho > 0 | script[:t])
search beam(starts = 50, polish = 1)
"""
WALK = "world small\nlength 4\nsearch naive\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("stories")
    (place / "small.world").write_text(WORLD, encoding="utf-8")
    (place / "help.story").write_text(HELP, encoding="utf-8")
    return place


def story(folder: Path, text: str, name: str = "test.story") -> i2pdsl.Story:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return i2pdsl.load(path)


@pytest.fixture(scope="module")
def result(folder: Path) -> i2pdsl.Result:
    return i2pdsl.load(str(folder / "help.story")).solve(seed=0)


# Python's interface (interfaces.md).


def test_answers_are_arrays_over_t(result: i2pdsl.Result) -> None:
    script = result.script
    belief = script.query("P(rho > 0 | script[:t])")
    assert isinstance(belief, np.ndarray)
    assert belief.shape == (6,)
    assert belief[0] == pytest.approx(12 / 28)  # of the 28 hypotheses with both rational
    goals = script.query("P(G_robot | script[:t])")
    assert goals.shape == (6, 3)
    pink = script.query("P(G_robot = pink | script[:t])")
    np.testing.assert_allclose(goals[:, 0], pink, rtol=1e-12)
    np.testing.assert_allclose(goals.sum(1), 1)
    assert script.query("P(rho | script[:T])").shape == (5,)
    assert script.query("[at(robot, pink) @ script[t]]").shape == (5,)
    assert script.query("sum_t P(rho > 0 | script[:t])").shape == ()
    assert float(script.query("sum_t P(rho > 0 | script[:t])")) == pytest.approx(belief[1:].sum())
    assert script.query("1").dtype == float


def test_the_score_is_the_objective_with_the_automatic_terms(result: i2pdsl.Result) -> None:
    script = result.script
    wanted = float(script.query("sum_t P(rho > 0 | script[:t])"))
    rational = float(script.query("sum_t P(R_cheese and R_robot | script[:t])", assume="nothing"))
    tried = [f["cheese"]["action"] != "stay" for f in script.record.frames]
    assert result.score == script.score
    assert wanted + rational - 0.36 * any(tried) <= result.score <= wanted + rational
    assert result.finished
    assert set(result.seconds) >= {"plan", "compile", "search"}


def test_another_assumption_can_be_made(result: i2pdsl.Result) -> None:
    script = result.script
    assert float(script.query("P(R_robot | script[:T])")) == pytest.approx(1)
    free = script.query("P(R_robot | script[:t])", assume="nothing")
    assert free[0] == pytest.approx(31 / 34)
    sure = script.query("P(rho > 0 | script[:t])", assume="G_robot = pink and rho != 0")
    assert sure.shape == (6,)
    everything = script.query("P(rho | script[:t])", assume="nothing")
    unknown = 1 - everything.sum(1)
    assert unknown[0] == pytest.approx(3 / 34)  # the rho of an irrational robot


def test_mistakes_are_diagnostics(folder: Path, result: i2pdsl.Result) -> None:
    with pytest.raises(i2pdsl.StoryError) as caught:
        story(folder, "world small\nlength 0\nmaximize P(G_cheese = blue | script[:2])\n")
    assert len(caught.value.diagnostics) >= 2
    first = caught.value.diagnostics[0]
    assert isinstance(first, i2pdsl.Diagnostic)
    assert first.as_json()["line"] == 2
    with pytest.raises(i2pdsl.StoryError, match="G_robot"):
        result.script.query("P(G_robt = pink | script[:t])")
    with pytest.raises(i2pdsl.StoryError, match="condition"):
        result.script.query("1", assume="rho")
    with pytest.raises(i2pdsl.StoryError, match="there is no such file"):
        i2pdsl.load(folder / "nothing.story")
    with pytest.raises(i2pdsl.StoryError, match="library"):
        story(folder, "pattern p(x) = x\n", "library.story")


def test_what_is_infinite_is_an_answer_without_a_warning(result: i2pdsl.Result) -> None:
    never = "P(rho > 0 | script[:t]) - P(rho > 0 | script[:t])"
    assert np.all(np.isneginf(result.script.query(f"log({never})")))
    checked = result.script.check(f"sqrt({never} - 1)")
    assert np.isnan(result.script.answer(checked).value).all()


def test_answers_say_no_minus_zero_and_no_nan(result: i2pdsl.Result) -> None:
    script = result.script
    assert script.ask("0 * -P(rho > 0 | script[:t])").in_words().split()[1::2] == ["0"] * 6
    assert json.dumps(script.ask("-1 * (0 * T)").as_json()) == "0.0"
    never = "(P(rho > 0 | script[:T]) - P(rho > 0 | script[:T]))"
    for asked, told in [
        (f"log({never})", "-infinite"),
        (f"1 / {never}", "infinite"),
        (f"{never} / {never}", "undefined"),
    ]:
        assert script.ask(asked).in_words() == told


def test_what_a_viewer_holds_for_impossible_is_no_condition(folder: Path) -> None:
    text = HELP + "audience average(bayesian, bayesian(prior = if rho > 0 then 0 else 1))\n"
    script = story(folder, text).solve().script
    again = i2pdsl.Script.load(script.save(folder / "possible.json"))
    for each in (script, again):
        for asked in ("rho > 0", "rho = 3", "rho in {1, 3} and G_robot = pink"):
            with pytest.raises(i2pdsl.StoryError, match="prior of 0"):
                each.query("P(G_robot = pink | script[:t])", assume=asked)
            with pytest.raises(i2pdsl.StoryError, match="prior of 0"):
                each.query(f"E[V(robot) | script[:t], {asked}]")
        assert np.isfinite(each.query("P(G_robot | script[:t])", assume="rho <= 0")).all()
        assert np.isinf(each.query("KL(rho; script[:t] || script[:0])"))[1:].all()
        assert np.isfinite(each.query("KL(rho; script[:0] || script[:t])")).all()


AWKWARD = (
    *("frames", "to", "true", "false", "action", "moved", "index", "name", "values", "goal"),
    *("__proto__", "constructor", "toString", "_", "__", "_x", "nan", "inf", "null", "None"),
    *("sin", "max", "pi", "points", "at", "absent", "pushes", "fell", "depict", "twist", "arc"),
    *("G_", "R_x", "rho", "t_", "map", "rewards", "who", "猫", "e\u0301te\u0301", "か\u3099"),
    *("event", "state", "unknown", "script", "north", "none"),
)


@pytest.mark.parametrize("kind", ["character", "tile", "object"])
def test_any_name_is_refused_or_works_everywhere(kind: str, tmp_path: Path) -> None:
    """Run, save, load, ask, tables and pictures: what is written is read back."""
    refused = set()
    for name in AWKWARD if FULL else AWKWARD[::5] + AWKWARD[-6:]:
        names = {"character": "me", "tile": "home", "object": "stone", kind: name}
        who, tile, thing = names["character"], names["tile"], names["object"]
        (tmp_path / "w.world").write_text(
            f"map\n    A..B\ntile {tile}\n    symbol = A\ntile market\n    symbol = B\n"
            f"character {who}\n    goals = {{{tile}, market}}\n    pushes = {{{thing}}}\n"
            f"object {thing}\n    may_be_absent = yes\nevent deus\n    drops = {{{thing}}}\n",
            encoding="utf-8",
        )
        text = (
            f"world w\nlength 2\nstart absent({thing})\nallow deus({thing})\n"
            f"let event = G_{who} = {tile}\nsearch beam(starts = 2, polish = 0)\n"
            f"maximize sum_t P(event | script[:t]) + [fell({thing}) @ script[1]]\n"
        )
        try:
            made = story(tmp_path, text).solve().script
        except i2pdsl.StoryError as problem:
            if "reserved" not in {d.code for d in problem.diagnostics}:
                raise
            refused.add(name)
            continue
        again = i2pdsl.Script.load(made.save(tmp_path / "script.json"))
        assert again.record == made.record
        goal = again.ask(f"P(G_{who} | script[:t])")
        assert len(goal.as_json()[0]) == 3
        assert goal.to_pandas().shape == (3, 2)
        assert goal.to_xarray().dims == ("t", f"G_{same_name(who)}")
        assert f"{same_name(who)}_action" in again.frame_table()
        again.query(f"P(G_{who} = {tile} | (script ++ [{who}: east])[:T+1])")
        again.query(f"E[V({who}) | script[:t]] + [at({who}, {tile}) @ script[T]]")
        drawn = dict(pictures_of([again]).drawn(tmp_path / "drawn", ("svg", "html"), None))
        assert {path.suffix for path in drawn.values()} == {".svg", ".html"}
    assert refused == {"event", "state", "unknown", "script", "north", "none"}


def test_a_script_is_saved_and_loaded(result: i2pdsl.Result, tmp_path: Path) -> None:
    path = result.script.save(tmp_path / "deeper" / "script.json")
    assert [p.name for p in path.parent.iterdir()] == ["script.json"]
    again = i2pdsl.Script.load(str(path))
    assert again.record == result.script.record
    assert again.score == result.score
    assert again.length == 5
    assert again.warnings == ()
    for question in ("P(rho | script[:t])", "E[V(robot) | script[:t]]"):
        np.testing.assert_array_equal(again.query(question), result.script.query(question))


def test_the_same_seed_is_the_same_story(folder: Path, result: i2pdsl.Result) -> None:
    again = i2pdsl.load(folder / "help.story").solve(seed=0)
    assert again.script.record == result.script.record


def test_candidates_differ_and_come_best_first(folder: Path) -> None:
    found = i2pdsl.load(folder / "help.story").solve(seed=0, candidates=3, choose="score")
    scores = [s.score or 0 for s in found.candidates]
    assert scores == sorted(scores, reverse=True)
    assert found.script is found.candidates[0]
    for i, one in enumerate(found.candidates):
        for other in found.candidates[:i]:
            assert distance(one.world, one.trajectory.states, other.trajectory.states) >= APART


def test_the_examples_of_the_documentation_are_python() -> None:
    """They need planned kitchens and folders of their own, so they are compiled, not run."""
    found = []
    for module in (i2pdsl, pipeline, scripts):
        for test in doctest.DocTestFinder().find(module):
            for example in test.examples:
                compile(example.source, test.name, "single")
                found.append(example.source.strip())
    assert 'result.script.query("P(rho > 0 | script[:t])")' in "\n".join(found)
    assert len(found) >= 10


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = "import i2pdsl, sys; print(*sys.modules)"
    names = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {name.split(".")[0] for name in names.stdout.split()}
    assert not loaded & {"jax", "jaxlib", "matplotlib", "numpy", "lark", "click", "PIL", "tqdm"}
    for name in i2pdsl.__all__:
        assert getattr(i2pdsl, name).__doc__
    with pytest.raises(AttributeError):
        _ = i2pdsl.nothing  # type: ignore[attr-defined]


# Naive planning.


def test_naive_stories_need_no_objective(folder: Path) -> None:
    first = story(folder, WALK).solve(seed=3)
    again = story(folder, WALK).solve(seed=3)
    assert first.script.record == again.script.record
    assert first.script.length == 4
    assert first.finished
    assert first.script.record.frames[0]["event"] is None


@pytest.mark.parametrize("text", ["depict(rho > 0)", "depict(G_robot = pink and rho < 0)"])
def test_naive_depicts_an_event(folder: Path, text: str) -> None:
    found = story(folder, f"world small\nlength 4\nmaximize {text}\n").solve(naive=True)
    assert found.script.length == 4


@pytest.mark.parametrize(
    "objective",
    [
        "twist(rho > 0, rho < 0)",
        "arc(robot)",
        "irony(G_cheese = green, G_cheese = pink, rho > 0, rho < 0)",
        "sum_t entropy(rho | script[:t])",
    ],
)
def test_naive_needs_one_event(folder: Path, objective: str) -> None:
    made = story(folder, f"world small\nlength 4\nmaximize {objective}\n")
    with pytest.raises(i2pdsl.StoryError, match="depicts one event"):
        made.solve(naive=True)


def test_naive_of_an_event_that_no_rational_hypothesis_fulfils(folder: Path) -> None:
    text = "world small\nlength 4\nassume nothing\nmaximize depict(not R_robot)\n"
    with pytest.raises(i2pdsl.StoryError, match="no rational hypothesis"):
        story(folder, text).solve(naive=True)


def test_minimising_depicts_the_opposite(folder: Path) -> None:
    more = story(folder, "world small\nlength 4\nmaximize depict(rho > 0)\n")
    less = story(folder, "world small\nlength 4\nminimize depict(not rho > 0)\n")
    paths = [s.solve(naive=True).script.trajectory.actions for s in (more, less)]
    np.testing.assert_array_equal(paths[0], paths[1])


def test_naive_characters_do_what_is_best_for_them() -> None:
    """Every action has the highest value of its character under the drawn hypothesis."""
    world = small_kitchen().world
    rows = world.vocabulary.hypotheses
    rational = np.array([bool(r["R_robot"] and r["R_cheese"]) for r in rows])
    allowed = np.arange(world.dynamics.state_count)
    for seed in range(20):
        start, actions, hypothesis = naive_rollout(world, 6, allowed, rational, seed)
        assert rational[hypothesis]
        state = start
        for action in actions:
            rows_here = world.log_rows(
                world.tables, np.asarray(state), np.asarray(action), np.asarray(state)
            )
            cheese = rows_here[0][0, hypothesis]
            # A best action has at least the share of one among five.
            assert cheese >= np.log(1 / 5) - 1e-9
            assert rows_here[1][0, hypothesis] >= np.log(1 / 5) - 1e-9
            state = int(world.transition(world.tables, np.asarray(state), action))


# Scripts and the stories they were made from.

RICH = """world small(beta = 1.5)
length 4
start absent(table)
allow deus(table)
let near = [adjacent(cheese, robot) @ script[T]]
pattern twice(x) = 2 * x
assume rho != 0
audience bayesian(beta = 0.7, forgetting = 0.01, prior = if rho > 0 then 3 else 1)
search naive
"""
QUESTIONS = ("P(rho | script[:t])", "E[V(cheese) | script[:t]]", "twice(near)")


@pytest.fixture(scope="module")
def rich(folder: Path) -> pipeline.Script:
    return story(folder, RICH).solve().script


def check_same(script: pipeline.Script, again: pipeline.Script) -> None:
    assert again.warnings == ()
    for question in QUESTIONS:
        np.testing.assert_array_equal(again.query(question), script.query(question))


def test_settings_audience_and_names_come_with_the_script(
    rich: pipeline.Script, tmp_path: Path
) -> None:
    again = i2pdsl.Script.load(rich.save(tmp_path / "script.json"))
    check_same(rich, again)
    prior = again.query("P(rho > 0 | script[:0])")
    assert float(prior) == pytest.approx(3 * 12 / (3 * 12 + 12))  # 28 rows less 4 of rho = 0
    assert again.record.world["settings"] == {"beta": 1.5}


def test_a_script_outlives_the_files_it_was_made_from(
    rich: pipeline.Script, tmp_path: Path
) -> None:
    """The world's text lies in it: neither its removal nor another of its name matters."""
    content = rich.record.as_json()
    content["story"]["file"] = "/nowhere/gone.story"
    path = tmp_path / "script.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    check_same(rich, i2pdsl.Script.load(path))
    other = kitchen_text(("PG.",), gamma="0.5").replace("character robot", "character android")
    (tmp_path / "small.world").write_text(other, encoding="utf-8")
    check_same(rich, i2pdsl.Script.load(path))


def test_settings_may_be_whole_numbers(rich: pipeline.Script, tmp_path: Path) -> None:
    content = rich.record.as_json()
    beliefs = []
    for beta in (1, 1.0):
        content["world"]["settings"] = {"beta": beta}
        path = tmp_path / "script.json"
        path.write_text(json.dumps(content), encoding="utf-8")
        script = i2pdsl.Script.load(path)
        beliefs.append(script.query("P(rho | script[:t])"))
        assert isinstance(script.world.spec.settings.beta, float)  # the plan's key is of floats
    np.testing.assert_array_equal(*beliefs)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("world small\nlength 3\nmaximize nonsense(\n", "not understood"),
        ("\x00\x01", "not understood"),
        ("pattern p(x) = x\n", "it is a library"),
        ("import gone\n" + WALK, "not understood"),
    ],
)
def test_a_stored_story_that_is_not_understood_is_a_warning(
    rich: pipeline.Script, tmp_path: Path, text: str, words: str
) -> None:
    content = rich.record.as_json()
    content["story"] = {"source": text, "file": "n" * 5000}
    content["world"]["settings"] = {}
    path = tmp_path / "script.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    script = i2pdsl.Script.load(path)
    assert [w.severity for w in script.warnings] == ["warning"]
    assert words in script.warnings[0].render()
    assert float(script.query("P(rho > 0 | script[:0])")) == pytest.approx(12 / 28)


def test_a_story_of_other_hypotheses_than_the_script(rich: pipeline.Script, tmp_path: Path) -> None:
    """The settings of the script's world hold, not those of the story's text."""
    content = rich.record.as_json()
    content["story"]["source"] = RICH.replace("beta = 1.5", "hypotheses = literal")
    content["world"]["settings"] = {}
    path = tmp_path / "script.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    assert i2pdsl.Script.load(path).query("P(rho | script[:t])").shape == (5, 5)


def test_start_and_allow_restrict_only_the_search(tmp_path: Path) -> None:
    """A table that is there from the start, or falls though no story allows it, is fine."""
    world = small_kitchen().world
    paths = (small_kitchen().random_script(Random(seed), 6, 0.5) for seed in range(9))
    path = next(p for p in paths if (p.actions >= world.moves.turn_count).any())
    text = "world small\nlength 3\nstart not absent(table)\nmaximize depict(rho > 0)\n"
    content = small_kitchen().document(path)
    content["story"] = {"source": text}
    content["world"] = {"name": "small", "source": WORLD}
    file = tmp_path / "script.json"
    file.write_text(json.dumps(content), encoding="utf-8")
    script = i2pdsl.Script.load(file)
    assert script.warnings == ()
    assert script.query("P(rho > 0 | script[:t])").shape == (7,)
    assert script.query("[fell(table) @ script[t]]").sum() == 1


def test_a_world_without_text_is_looked_for_by_name(
    rich: pipeline.Script, folder: Path, tmp_path: Path
) -> None:
    content = rich.record.as_json()
    for text in (None, ""):
        content["world"]["source"] = text
        beside = folder / "beside.json"
        beside.write_text(json.dumps(content), encoding="utf-8")
        check_same(rich, i2pdsl.Script.load(beside))
    elsewhere = tmp_path / "script.json"
    elsewhere.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(i2pdsl.StoryError, match="there is no world `small`"):
        i2pdsl.Script.load(elsewhere)


# Caches.


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of one's own."""
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def get_plan(said: list[str] | None = None) -> Any:
    world = planned(WORLD)
    return load_or_plan(
        world.spec, lambda: world.dynamics, None, None if said is None else said.append
    )


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The cached plan of the small world, made once."""
    with pytest.MonkeyPatch.context() as patch:
        root = tmp_path_factory.mktemp("cache")
        patch.setenv("I2PDSL_CACHE", str(root))
        get_plan()
        (file,) = (root / "plans").iterdir()
    return file


def flipped(data: bytes, place: float) -> bytes:
    number = int(place * len(data))
    return data[:number] + bytes([data[number] ^ 0xFF]) + data[number + 1 :]


DAMAGE = [
    lambda data: b"",
    lambda data: data[: len(data) // 2],
    lambda data: data[:-1],
    lambda data: b"\x00" * len(data),
    lambda data: b"garbage" * 100,
    lambda data: flipped(data, 0.3),
    lambda data: flipped(data, 0.9),
    lambda data: data[:4000] + data[5000:],
]


@pytest.mark.parametrize("number", range(len(DAMAGE)))
def test_a_damaged_plan_is_said_and_made_again(number: int, cache: Path, plan_file: Path) -> None:
    copy = cache / "plans" / plan_file.name
    copy.parent.mkdir(parents=True)
    copy.write_bytes(DAMAGE[number](plan_file.read_bytes()))
    said: list[str] = []
    assert store.load(copy.name.removesuffix(f"-v{store.VERSION}.npz"), said.append) is None
    assert len(said) == 1
    assert "is damaged" in said[0]
    assert "\n" not in said[0]
    assert not copy.exists()


def forged(**changes: Callable[[np.ndarray], Any]) -> Callable[[dict[str, Any]], dict[str, Any]]:
    return lambda arrays: {k: changes.get(k, lambda a: a)(a) for k, a in arrays.items()}


def with_entry(number: float) -> Callable[[np.ndarray], np.ndarray]:
    def change(array: np.ndarray) -> np.ndarray:
        array = array.copy()
        array[3, 1] = number
        return array

    return change


FORGERIES: dict[str, Callable[[dict[str, np.ndarray]], dict[str, Any]]] = {
    "other shape": lambda arrays: {"continuation_0": np.zeros((3, 2))},
    "nothing": lambda arrays: {},
    "one more": lambda arrays: {**arrays, "residual": np.array(0.0)},
    "zeros": forged(continuation_1=np.zeros_like),
    "zeros for both": forged(continuation_0=np.zeros_like, continuation_1=np.zeros_like),
    "huge": forged(continuation_1=lambda a: np.full_like(a, 1e308)),
    "half floats": forged(continuation_1=lambda a: a.astype(np.float16)),
    "single floats": forged(continuation_1=lambda a: a.astype(np.float32)),
    "other bytes": forged(continuation_1=lambda a: a.astype(">f8")),
    "truth values": forged(continuation_0=lambda a: a > 0),
    "complex": forged(continuation_0=lambda a: a + 0j),
    "text": forged(continuation_0=lambda a: a.astype("U8")),
    "not a number": forged(continuation_1=with_entry(np.nan)),
    "infinite": forged(continuation_1=with_entry(np.inf)),
    "one wrong": forged(continuation_1=with_entry(0.5)),
    "slightly wrong": forged(continuation_1=lambda a: a * (1 + 1e-4)),
    "shifted": forged(continuation_0=lambda a: a + 1e-3),
    "another order": forged(continuation_1=lambda a: a[:, ::-1].copy()),
    "another's": lambda arrays: {
        "continuation_0": arrays["continuation_0"],
        "continuation_1": arrays["continuation_1"][::-1].copy(),
    },
    "transposed": forged(continuation_1=lambda a: a.T.copy()),
}


@pytest.mark.parametrize("name", FORGERIES)
def test_a_plan_that_does_not_fit_is_said_and_made_again(
    name: str, cache: Path, plan_file: Path
) -> None:
    stored = plan_file.name.removesuffix(f"-v{store.VERSION}.npz")
    with np.load(plan_file) as archive:
        right = dict(archive)
    store.save(stored, FORGERIES[name](right))
    said: list[str] = []
    plan = get_plan(said)
    assert plan.seconds > 0
    assert len(said) == 1
    assert "does not fit" in said[0]
    assert "damaged" not in said[0]
    said.clear()
    again = get_plan(said)
    assert (again.seconds, said) == (0, [])
    for i, array in enumerate(again.continuation):
        np.testing.assert_allclose(array, right[f"continuation_{i}"], atol=1e-4)


def test_what_is_told_of_a_cached_plan_is_measured(cache: Path, plan_file: Path) -> None:
    fresh = get_plan()
    again = get_plan()
    assert again.seconds == 0
    assert 0 < again.residual <= fresh.residual * 1.01
    assert again.bound <= 1e-2


def npy(header: str, data: bytes = b"") -> bytes:
    text = header.encode() + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + data


def zipped(entries: dict[str, bytes], compression: int = zipfile.ZIP_STORED) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as archive:
        for name, data in entries.items():
            archive.writestr(name, data)
    return buffer.getvalue()


HEADER = "{{'descr': {}, 'fortran_order': False, 'shape': {}, }}"
BOMBS = {
    "compressed": lambda: zipped({"continuation_0.npy": bytes(2**26)}, zipfile.ZIP_DEFLATED),
    "a huge shape": lambda: zipped(
        {"continuation_0.npy": npy(HEADER.format("'<f8'", (2**40, 2**20)))}
    ),
    "a large shape": lambda: zipped({"continuation_0.npy": npy(HEADER.format("'<f8'", (2**28,)))}),
    "a negative shape": lambda: zipped({"continuation_0.npy": npy(HEADER.format("'<f8'", (-1,)))}),
    "objects": lambda: zipped(
        {"continuation_0.npy": npy(HEADER.format("'|O'", (1,)), b"\x80\x04N.")}
    ),
    "a wide type": lambda: zipped(
        {"continuation_0.npy": npy(HEADER.format("'<U100000000'", (9,)))}
    ),
    "a header that is code": lambda: zipped({"continuation_0.npy": npy("__import__('os')")}),
    "no array": lambda: zipped({"continuation_0.npy": b"text"}),
    "larger than it can be": lambda: b"\0" * 2**22,
}


@pytest.mark.parametrize("name", BOMBS)
def test_files_that_claim_to_be_large_take_no_memory(
    name: str, cache: Path, plan_file: Path
) -> None:
    copy = cache / "plans" / plan_file.name
    copy.parent.mkdir(parents=True)
    copy.write_bytes(BOMBS[name]())
    said: list[str] = []
    tracemalloc.start()
    assert store.load(copy.name.removesuffix(f"-v{store.VERSION}.npz"), said.append, 2**20) is None
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 2**24
    assert len(said) == 1
    assert "is damaged" in said[0]
    assert not copy.exists()


def test_a_pipe_where_the_plan_should_lie(cache: Path, plan_file: Path) -> None:
    (cache / "plans").mkdir(parents=True)
    os.mkfifo(cache / "plans" / plan_file.name)
    said: list[str] = []
    assert get_plan(said).seconds > 0
    assert said == [
        f"the cached plan {plan_file.name} is damaged (it is a pipe, not a file); it is made again"
    ]
    assert get_plan().seconds == 0


@pytest.mark.parametrize("reason", [errno.EACCES, errno.EIO])
def test_a_plan_that_cannot_be_read_is_not_called_damaged(
    reason: int, cache: Path, plan_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = cache / "plans" / plan_file.name
    copy.parent.mkdir(parents=True)
    copy.write_bytes(plan_file.read_bytes())

    def refused(*_: Any) -> Any:
        raise OSError(reason, os.strerror(reason))

    monkeypatch.setattr(store, "read_arrays", refused)
    said: list[str] = []
    assert store.load(copy.name.removesuffix(f"-v{store.VERSION}.npz"), said.append) is None
    assert said == [
        f"the cached plan {copy} cannot be read: {os.strerror(reason)}; it is made again"
    ]
    assert copy.exists()


def test_a_full_disk_is_said_with_the_file(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(np, "savez", full)
    said: list[str] = []
    store.save("x", {"a": np.zeros(1)}, said.append)
    path = cache / "plans" / f"x-v{store.VERSION}.npz"
    assert said == [f"the plan could not be cached in {path}: No space left on device"]


def test_any_flipped_byte_is_noticed_or_harmless(cache: Path) -> None:
    arrays = {"a": np.arange(12.0).reshape(3, 4), "residual": np.float64(1e-5)}
    store.save("x", arrays)
    file = cache_folder("plans") / f"x-v{store.VERSION}.npz"
    data = file.read_bytes()
    for number in range(0, len(data), 3):
        file.write_bytes(flipped(data, number / len(data)))
        found = store.load("x")
        if found is not None and set(found) == set(arrays):
            for key, array in arrays.items():
                np.testing.assert_array_equal(found[key], array)


def test_a_cache_that_cannot_be_written_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, plan_file: Path
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path / "file" / "cache"))
    said: list[str] = []
    assert store.load("x", said.append) is None
    store.save("x", {"a": np.zeros(1)}, said.append)
    assert len(said) == 1
    assert "could not be cached" in said[0]
    store.save("x", {"a": np.zeros(1)})  # nobody listens


def test_a_folder_where_the_plan_should_lie(cache: Path) -> None:
    (cache / "plans" / f"x-v{store.VERSION}.npz" / "inner").mkdir(parents=True)
    said: list[str] = []
    assert store.load("x", said.append) is None
    store.save("x", {"a": np.zeros(1)}, said.append)
    assert "is damaged (it is a folder)" in said[0]
    assert "could not be cached" in said[1]
    assert sorted(p.name for p in (cache / "plans").iterdir()) == [f"x-v{store.VERSION}.npz"]


def test_a_cache_deleted_between_two_uses(cache: Path) -> None:
    store.save("x", {"a": np.zeros(1)})
    assert store.load("x") is not None
    shutil.rmtree(cache)
    assert store.load("x") is None
    store.save("x", {"a": np.zeros(1)})
    assert store.load("x") is not None


def test_many_at_once(cache: Path) -> None:
    """Readers see nothing or a whole entry, whatever writers and deleters do meanwhile."""
    stop = threading.Event()
    problems: list[str] = []
    file = cache / "plans" / f"x-v{store.VERSION}.npz"

    def write(value: float) -> None:
        while not stop.is_set():
            store.save("x", {"a": np.full(3000, value)}, problems.append)

    def delete() -> None:
        while not stop.is_set():
            file.unlink(missing_ok=True)
            stop.wait(0.002)  # now and then there is something to be read

    threads = [threading.Thread(target=write, args=(v,)) for v in (1.0, 2.0)]
    threads.append(threading.Thread(target=delete))
    for thread in threads:
        thread.start()
    seen = tries = 0
    while tries < 300 or (seen == 0 and tries < 30_000):
        tries += 1
        found = store.load("x", problems.append)
        if found is not None:
            assert len(set(found["a"].tolist())) == 1
            seen += 1
    stop.set()
    for thread in threads:
        thread.join()
    assert problems == []
    assert seen
    assert {p.name for p in file.parent.iterdir()} <= {file.name}
