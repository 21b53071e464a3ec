"""Judgements against the model: what tells points apart in the picture."""

from __future__ import annotations

import pytest

from i2pdsl.fit.picture import _names
from i2pdsl.fit.report import Cell


def cell(script: str, other: str | None = None, frame: int = 5, label: str | None = None) -> Cell:
    return Cell(script, other, "q", frame, label, 1, *(0.5,) * 6)


def film(condition: str, seed: int) -> str:
    return f"films/{condition}/story/seed-{seed}/script.json"


@pytest.mark.parametrize(
    ("cells", "names"),
    [
        ([cell("a/trial_01.json"), cell("a/trial_12.json")], ["01", "12"]),
        ([cell("a/x.json")], ["x"]),
        ([cell("x.json", frame=2), cell("x.json"), cell("y.json")], ["x @ 2", "x @ 5", "y"]),
        ([cell("x.json", label="a"), cell("x.json", label="b")], ["x", "x"]),
        (
            [cell(film("help", 0), film("hinder", 3)), cell(film("help", 3), film("help", 0))],
            ["help 0 | hinder 3", "help 3 | help 0"],
        ),
        ([cell("a.json"), cell("b/a.json")], ["a.json", "b/a.json"]),
    ],
)
def test_points_are_named_by_what_tells_them_apart(cells: list[Cell], names: list[str]) -> None:
    assert _names(tuple(cells)) == names
