"""Beliefs and frames as tables of pandas and xarray."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from i2pdsl.answers import Answer
from i2pdsl.errors import Source
from i2pdsl.stories import Result, Script

SHOWN = "P(G_cat | script[:t])"


def test_a_curve_is_a_series_over_frames(friend: Result) -> None:
    script = friend.script
    found = script.ask("P(friend | script[:t])").to_pandas()
    assert isinstance(found, pd.Series)
    assert found.index.name == "t"
    assert found.index.tolist() == list(range(7))
    assert found.name == "P(friend | script[:t])"
    np.testing.assert_array_equal(found, script.query("P(friend | script[:t])"))
    late = script.ask("surprise(script[t])").to_pandas()
    assert late.index.tolist() == list(range(1, 7))


def test_a_belief_over_time_is_a_frame(friend: Result) -> None:
    script = friend.script
    found = script.ask(SHOWN).to_pandas()
    assert isinstance(found, pd.DataFrame)
    assert found.columns.name == "G_cat"
    assert found.columns.tolist() == ["crumbs", "hole", "none"]
    np.testing.assert_allclose(found["hole"], script.query("P(G_cat = hole | script[:t])"))
    whole = script.ask(SHOWN, assume="nothing").to_pandas()
    assert whole.columns.tolist() == ["crumbs", "hole", "none", "unknown"]
    np.testing.assert_allclose(whole.sum(axis=1), 1)


def test_a_belief_at_one_moment_is_a_series_over_values(friend: Result) -> None:
    found = friend.script.ask("P(rho | script[:T])").to_pandas()
    assert found.index.tolist() == ["-2", "0", "2"]
    assert found.index.name == "rho"
    expected = friend.script.query("P(rho = 2 | script[:T])")
    assert found["2"] == pytest.approx(float(expected))
    assert friend.script.ask("T").to_pandas().tolist() == [6]


def test_xarrays_have_named_dimensions(friend: Result) -> None:
    script = friend.script
    found = script.ask(SHOWN, assume="nothing").to_xarray()
    assert isinstance(found, xr.DataArray)
    assert found.dims == ("t", "G_cat")
    one = found.sel(t=3, G_cat="hole")
    expected = script.query("P(G_cat = hole | script[:3])", assume="nothing")
    assert float(one) == pytest.approx(float(expected))
    np.testing.assert_allclose(found.sum("G_cat"), 1)
    assert script.ask("P(rho > 0 | script[:t])").to_xarray().dims == ("t",)
    assert script.ask("P(rho | script[:2])").to_xarray().dims == ("rho",)
    assert script.ask("T").to_xarray().item() == 6


def test_several_latents_have_a_dimension_each(friend: Result) -> None:
    script = friend.script
    answer = script.ask("P(G_cat, rho | script[:t])", assume="nothing")
    found = answer.to_xarray()
    assert found.dims == ("t", "G_cat", "rho")
    assert found.coords["G_cat"].values.tolist() == ["crumbs", "hole", "none", "unknown"]
    np.testing.assert_allclose(found.sum(("G_cat", "rho")), 1)
    expected = script.query("P(G_cat = hole and rho = 2 | script[:t])", assume="nothing")
    np.testing.assert_allclose(found.sel(G_cat="hole", rho="2"), expected)
    table = answer.to_pandas()
    assert table.columns.names == ["G_cat", "rho"]
    np.testing.assert_allclose(table["hole", "2"], expected)
    np.testing.assert_allclose(
        table.T.groupby("G_cat").sum().T["none"],
        script.query("P(G_cat = none | script[:t])", assume="nothing"),
    )
    # Of what plays a part wherever everyone is rational there is no `unknown`.
    assumed = script.ask("P(G_cat, rho | script[:2])")
    assert assumed.to_pandas().index.levels[0].tolist() == ["crumbs", "hole", "none"]
    assert assumed.value.shape == (4, 4)
    side = script.to_pandas("P(G_cat, rho | script[:t])", both="P(rho, G_cat | script[:t])")
    np.testing.assert_allclose(side["G_cat = hole, rho = 2"], side["both: rho = 2, G_cat = hole"])


def test_predictions_are_tables_of_actions(friend: Result) -> None:
    answer = friend.script.ask("next(cat | script[:t])")
    found = answer.to_xarray()
    assert found.dims == ("t", "cat")
    assert found.coords["cat"].values.tolist() == ["north", "south", "east", "west", "stay"]
    np.testing.assert_allclose(found.sum("cat"), 1)
    assert answer.to_pandas().columns.name == "cat"


def test_questions_side_by_side(friend: Result) -> None:
    script = friend.script
    table = script.to_pandas(
        "surprise(script[t])", "T", "P(rho | script[:2])", cat=SHOWN, kind="P(friend | script[:t])"
    )
    assert table.index.tolist() == list(range(7))
    latent = [f"rho = {v}" for v in (-2, 0, 2)]
    goals = [f"cat = {v}" for v in ("crumbs", "hole", "none")]
    assert table.columns.tolist() == ["surprise(script[t])", "T", *latent, *goals, "kind"]
    assert np.isnan(table["surprise(script[t])"][0])
    assert table["surprise(script[t])"][1] == script.query("surprise(script[t])")[0]
    assert set(table["T"]) == {6}
    assert len(set(table["rho = 2"])) == 1
    np.testing.assert_array_equal(table["cat = hole"], script.query(SHOWN)[:, 1])
    with pytest.raises(ValueError, match="two columns are called 'T'"):
        script.to_pandas("T", "T")
    asked = script.to_pandas(R="P(R_cat | script[:t])", assume="nothing")["R"]
    np.testing.assert_array_equal(asked, script.query("P(R_cat | script[:t])", assume="nothing"))


def test_frames_of_a_map(friend: Result) -> None:
    script = friend.script
    table = script.frame_table()
    assert len(table) == 7
    record = script.record
    for t, frame in enumerate(record.frames, 1):
        for who in ("mouse", "cat"):
            assert table[f"{who}_action"][t] == frame[who]["action"]
            assert table[f"{who}_moved"][t] == frame[who]["moved"]
            place = [table[f"{who}_column"][t], table[f"{who}_row"][t]]
            assert place == frame["state"][who]
    assert pd.isna(table["cat_action"][0])
    assert pd.isna(table["cat_moved"][0])
    assert [table["cat_column"][0], table["cat_row"][0]] == record.start["cat"]


def test_absent_things_and_events(tmp_path) -> None:
    import json

    document = {
        "format": "i2p-script",
        "version": 1,
        "world": {"name": "kitchen"},
        "start": {"cheese": [3, 1], "robot": [5, 1], "table": None},
        "frames": [
            {
                "event": {"deus": "table", "to": [9, 5]},
                "state": {"cheese": [3, 1], "robot": [5, 1], "table": [9, 5]},
            }
        ],
    }
    (tmp_path / "script.json").write_text(json.dumps(document), encoding="utf-8")
    table = Script.load(tmp_path / "script.json").frame_table()
    assert table["event"].isna().tolist() == [True, False]
    assert table["event"][1] == "deus(table)"
    assert table["table_column"].isna().tolist() == [True, False]
    assert [table["table_column"][1], table["table_row"][1]] == [9, 5]
    assert table["cheese_action"].isna().all()


def test_frames_of_the_hill(hill: Script) -> None:
    table = hill.frame_table()
    assert table.columns.tolist() == [
        "hopper_fallen",
        "hopper_taut",
        "box_climbed",
        "box_progress",
        "hopper_effort",
    ]
    assert table.index.tolist() == list(range(13))
    assert table.loc[0].isna().all()
    expected = float(hill.query("sum_t [progress(box) @ script[t]]"))
    assert table["box_progress"].sum() == pytest.approx(expected)


def test_a_table_has_the_name_of_its_latent(friend: Result) -> None:
    script = friend.script
    for name in ("G_mouse", "G_cat", "rho"):
        query = script.check(f"P({name} | script[:t])", "nothing")
        assert script.answer(query).latent == name


def test_a_missing_library_is_said_with_how_to_get_it() -> None:
    code = (
        "import sys; sys.modules['pandas'] = sys.modules['xarray'] = None\n"
        "from i2pdsl.answers import Answer\nimport numpy as np\n"
        "a = Answer([0], np.ones(1), None, None)\n"
        "for ask in (a.to_pandas, a.to_xarray):\n"
        "    try:\n        ask()\n    except ImportError as e:\n        print(e)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        f"this needs {name}, which is not installed: pip install 'i2pdsl[tables]'"
        for name in ("pandas", "xarray")
    ]


def test_commands_import_nothing_of_this(tmp_path) -> None:
    """`import i2pdsl` and a question at the command line load neither tables nor notebooks."""
    story = "world maze\nlength 2\nsearch naive\n"
    (tmp_path / "a.story").write_text(story, encoding="utf-8")
    code = (
        "import sys, i2pdsl\n"
        "assert not {'numpy', 'i2pdsl.errors'} & set(sys.modules)\n"
        "from i2pdsl.cli import run_command\n"
        "assert run_command(['query', 'a.story', 'P(rho | script[:t])']) == 0\n"
        "found = {'pandas', 'xarray', 'IPython', 'i2pdsl.tables', 'i2pdsl.notebook'}\n"
        "assert not found & set(sys.modules), found & set(sys.modules)\n"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr


def test_the_public_places_of_answers_stay() -> None:
    import i2pdsl
    from i2pdsl import scripts, stories

    assert i2pdsl.Answer is stories.Answer is scripts.Answer is Answer


def test_no_column_hides_another(tmp_path: Path) -> None:
    """Values that are nearly alike have names of their own; the frames' name is theirs."""
    from i2pdsl import Story
    from i2pdsl.language.vocabulary import show_value
    from i2pdsl.stories import story_from

    (tmp_path / "two.world").write_text(
        "map\n    A.\n    .B\ntile value\n    symbol = A\ntile expr\n    symbol = B\n"
        "character one\n    goals = {value, expr, none}\n"
        "character two\n    goals = {none}\n    toward = one\n"
        "    attitude = {1.0000001, 1.0000002, 1, 1e6}\nplanning\n    gamma = 0.5\n"
    )
    text = (
        "world two\nlength 2\nmaximize depict(G_one = value)\nsearch beam(starts = 1, width = 1)\n"
    )
    story: Story = story_from(Source("s.story", text), tmp_path)
    script = story.solve().script
    values = story.typed.vocabulary.latents["rho"].values
    answer = script.ask("P(rho | script[:t])", assume="nothing")
    assert answer.labels == ("1.0000001", "1.0000002", "1", "1e+06", "0")
    assert answer.labels == tuple(map(show_value, values))
    assert set(answer.as_json()[0]) == {*answer.labels, "unknown"}
    for row in answer.as_json():
        assert sum(row.values()) == pytest.approx(1)
    goals = script.ask("P(G_one | script[:t])", assume="nothing")
    assert list(goals.as_json()[-1]) == ["value", "expr", "none", "unknown"]
    assert goals.to_pandas().columns.tolist() == ["value", "expr", "none", "unknown"]
    for question in ({"t": "P(G_one = value | script[:t])"}, {}):
        with pytest.raises(ValueError, match="the frames are called 't'"):
            script.to_pandas(*(() if question else ("t",)), **question)
    assert script.ask("t").to_pandas().reset_index().shape == (3, 2)
    assert script.ask("t").to_xarray().name is None
