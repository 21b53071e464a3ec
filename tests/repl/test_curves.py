"""Curves in characters against the numbers that they draw."""

from __future__ import annotations

import re

import numpy as np
import pytest

from i2pdsl.render.characters import COLOURS, LETTERS, Canvas, Curve, Ink, draw_curves

PLAIN = Ink(colour=False, unicode=False, columns=60)
FINE = Ink(colour=True, unicode=True, columns=60)
# The bit of each dot of a braille character (Unicode, "Braille Patterns"), by column and row.
BITS = {(0, 0): 1, (0, 1): 2, (0, 2): 4, (1, 0): 8, (1, 1): 16, (1, 2): 32, (0, 3): 64, (1, 3): 128}


def curve(*values: float, name: str = "it", first: int = 0) -> Curve:
    return Curve(name, np.arange(first, first + len(values)), np.array(values, float))


def drawn_rows(text: str, axis: str) -> list[str]:
    """The rows between the axis and the foot, without colours."""
    bare = re.sub(r"\x1b\[[0-9;]*m", "", text)
    return [line.split(axis, 1)[1] for line in bare.splitlines() if axis in line]


def dots(text: str) -> set[tuple[int, int]]:
    """(x, y) of every dot of a drawing in braille, y downwards."""
    found = set()
    for row, line in enumerate(drawn_rows(text, "│")):
        for column, sign in enumerate(line):
            bits = ord(sign) - 0x2800 if sign != " " else 0
            found |= {(2 * column + x, 4 * row + y) for (x, y), b in BITS.items() if bits & b}
    return found


def signs(text: str) -> dict[tuple[int, int], str]:
    """The letters of a drawing by (column, row)."""
    rows = drawn_rows(text, "|")
    return {(x, y): s for y, row in enumerate(rows) for x, s in enumerate(row) if s != " "}


def test_every_value_has_its_dot() -> None:
    values = np.random.default_rng(0).uniform(-3, 5, 12)
    found = dots(draw_curves([curve(*values)], FINE))
    width = 1 + max(x for x, _ in found)
    low, high = values.min(), values.max()
    places = {
        (round(t / 11 * (width - 1)), round((high - v) / (high - low) * 39))
        for t, v in enumerate(values)
    }
    near = {(x + a, y + b) for x, y in found for a in (-1, 0, 1) for b in (-1, 0, 1)}
    assert places <= near
    assert min(x for x, _ in found) == 0
    assert {0, 39} <= {y for _, y in found}


def test_nothing_is_drawn_off_the_lines_between_values() -> None:
    found = dots(draw_curves([curve(0.0, 1.0)], FINE))
    across = max(x for x, _ in found)
    for x, y in found:
        assert abs((1 - x / across) * 39 - y) <= 1.01


def test_probabilities_have_the_whole_scale() -> None:
    text = draw_curves([curve(0.4, 0.6)], PLAIN)
    assert [line.split("|")[0].strip() for line in text.splitlines()[:10]] == [
        *("1", "", "", "", "", "0.5", "", "", "", "0"),
    ]
    rows = [y for _, y in signs(text)]
    assert (min(rows), max(rows)) == (round(0.4 * 9), round(0.6 * 9))


def test_small_and_large_numbers_have_their_own_scale() -> None:
    for values in ((0.001, 0.002), (100.0, 250.0), (-5.0, -4.0)):
        text = draw_curves([curve(*values)], PLAIN)
        ticks = [line.split("|")[0].strip() for line in text.splitlines()[:10]]
        assert [float(x) for x in ticks if x] == pytest.approx(
            [max(values), sum(values) / 2, min(values)], rel=0.01
        )
        rows = [y for _, y in signs(text)]
        assert (min(rows), max(rows)) == (0, 9)


def test_letters_tell_curves_apart_without_colour() -> None:
    values = (0.1, 0.25, 0.4, 0.6, 0.8, 1.0)
    curves = [curve(v, v, v, name=f"curve {v}") for v in values]
    text = draw_curves(curves, PLAIN)
    assert "\x1b" not in text
    assert text.isascii()
    found = signs(text)
    for value, letter in zip(values, LETTERS, strict=True):
        rows = {y for (_, y), sign in found.items() if sign == letter}
        assert rows == {round((1 - value) * 9)}
        assert f"  {letter} curve {value}" in text


def test_colours_tell_curves_apart() -> None:
    text = draw_curves([curve(0, 0, name="low"), curve(1, 1, name="high")], FINE)
    top, bottom = text.splitlines()[0], text.splitlines()[9]
    assert f"\x1b[{COLOURS[1]}m" in top
    assert f"\x1b[{COLOURS[0]}m" not in top
    assert f"\x1b[{COLOURS[0]}m" in bottom
    assert f"\x1b[{COLOURS[1]}m" not in bottom


def test_gaps_where_there_is_no_number() -> None:
    found = signs(draw_curves([curve(0, 0, np.nan, 0, 0, np.inf, 1)], PLAIN))
    width = 60 - 3 - 5
    step = (width - 1) / 6
    columns = {x for x, _ in found}
    assert not columns & set(range(round(step) + 1, round(3 * step)))
    assert not columns & set(range(round(4 * step) + 1, round(6 * step)))
    assert round(6 * step) in columns
    assert set(range(round(step) + 1)) <= columns


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_no_finite_value(value: float) -> None:
    assert draw_curves([curve(value, value)], FINE) == "nothing to draw: no value is finite"
    assert draw_curves([], FINE) == "nothing to draw: no value is finite"


@pytest.mark.parametrize("value", [0.0, 0.3, -7.0, 1e9, 1e-12])
def test_a_constant(value: float) -> None:
    found = signs(draw_curves([curve(*[value] * 5)], PLAIN))
    assert len({y for _, y in found}) == 1


def test_one_frame() -> None:
    text = draw_curves([curve(0.25)], PLAIN)
    assert len(signs(text)) == 1
    assert text.splitlines()[11].split() == ["0", "t"]


def test_eight_hundred_frames() -> None:
    t = np.arange(801)
    values = np.sin(t / 800 * 4 * np.pi)
    text = draw_curves([Curve("wave", t, values)], FINE)
    assert all(len(re.sub(r"\x1b\[[0-9;]*m", "", line)) <= 60 for line in text.splitlines())
    found = dots(text)
    across = max(x for x, _ in found)
    for x in range(across + 1):
        here = [y for a, y in found if a == x]
        assert here, f"a gap at {x}"
        wanted = (1 - np.sin(x / across * 4 * np.pi)) / 2 * 39
        assert min(here) - 2 <= wanted <= max(here) + 2
    assert text.splitlines()[11].split() == ["0", "400", "800", "t"]


def test_curves_that_begin_later() -> None:
    text = draw_curves([curve(1, 1, 1), curve(0, 0, first=1)], PLAIN)
    found = signs(text)
    second = [x for (x, _), sign in found.items() if sign == LETTERS[1]]
    assert min(second) == round(0.5 * (60 - 1 - 5 - 1))


@pytest.mark.parametrize("columns", [1, 20, 40, 60, 110, 500])
def test_a_drawing_fits_its_window(columns: int) -> None:
    text = draw_curves([curve(0, 1, 0.5, name="short")], Ink(False, True, columns))
    widest = max(map(len, text.splitlines()))
    assert widest <= max(columns, 30)
    assert len(text.splitlines()) == 13


def test_a_canvas_cuts_what_is_outside() -> None:
    for ink in (PLAIN, FINE):
        canvas = Canvas(3, 2, ink)
        canvas.line(-10, -10, 50, 50, 0)
        canvas.dot(-1, 0, 0)
        canvas.dot(0, 1000, 0)
        assert len(canvas.lines()) == 2
        assert canvas.dots[0, 0]
        assert not canvas.dots[1, 2 if ink is PLAIN else 0]
