"""The converter of benchmarks/people, on a stimulus made up here: its format, not its data."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType

import pytest

from i2pdsl.scripts import Script

GRID = " . . | . \n_. .x. . \n . . , .g\n"
TRIAL = {
    "num": 1,
    "red_start": [0, 0],
    "blue_start": [0, 1],
    "red_path": [[1, 0], [1, 0], [0, 1], [0, 1], [1, 0], [1, 0]],
    "blue_path": [[1, 0], [-1, 0], [0, 0]],
    "box_changes": {"1": [[2, 1]], "3": [[1, 1]]},
}


def convert() -> ModuleType:
    path = Path(__file__).parent.parent / "benchmarks" / "people" / "convert.py"
    spec = importlib.util.spec_from_file_location("convert", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["convert"] = module  # for its dataclasses
    spec.loader.exec_module(module)
    return module


def test_a_stimulus_becomes_a_world_and_a_script(tmp_path: Path) -> None:
    data, folder = tmp_path / "data", tmp_path / "made"
    (data / "grids").mkdir(parents=True)
    (data / "grids" / "1.txt").write_text(GRID)
    (data / "experiment1.json").write_text(json.dumps([TRIAL]))
    (path,) = convert().convert(data, folder, beta=1.0)
    text = (folder / "trial_01.world").read_text()
    drawn = ["    r . .|. .", "    b . x . .", "    -", "    . . . . S"]
    assert text.splitlines()[3:7] == drawn
    script = Script.load(path)
    frames = script.record.frames
    acts = ["east", "pull_west", *["stay"] * 4]
    assert [frame["blue"]["action"] for frame in frames] == acts
    assert frames[-1]["state"] == {"blue": [0, 1], "red": [4, 2], "box": [1, 1]}
    belief = script.query("P(rho > 0 | script[:t])")
    assert len(belief) == 7
    assert 0 < belief[-1] < 1


def test_a_box_that_is_dragged_aside_is_no_reading_of_ours() -> None:
    module = convert()
    aside = {**TRIAL, "blue_path": [[1, 0], [0, 1]]}
    with pytest.raises(ValueError, match="dragged aside in step 2"):
        module.frames_of(aside, module.read_map(GRID))
