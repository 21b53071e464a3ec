"""Lines of captions: what belongs together stays together, and what is too long is not lost."""

from __future__ import annotations

import pytest

from i2pdsl.render.lettering import units, wrapped
from i2pdsl.render.raster import text_width

TEXT = "robot is helping (> 99 %), at frame 12 rho > 0 or P = .9 after 3 s, frames 1 to 5 in turn 7"
UNITS = ("(> 99 %),", "frame 12", "rho > 0", "P = .9", "3 s,", "frames 1", "turn 7")


@pytest.mark.parametrize("room", range(90, 700, 30))
def test_a_line_never_ends_inside_a_unit(room: int) -> None:
    lines = wrapped(TEXT, 14, room, 40)
    assert " ".join(lines) == TEXT
    for unit in UNITS:
        assert any(unit in line for line in lines), lines
    assert all(text_width(line, 14) <= room for line in lines)


def test_units_that_are_too_long_are_parted() -> None:
    assert units("t = 3", lambda _: False) == ["t", "=", "3"]
    assert units("t  = 3\n", lambda _: True) == ["t = 3"]
    assert units("", lambda _: True) == [""]


def test_long_names_are_cut_and_not_lost() -> None:
    name = "a_character_whose_name_has_40_characters"
    lines = wrapped(f"{name} wants {name[::-1]} (> 99 %)", 14, 140, 2)
    assert "".join(lines).replace(" ", "") == f"{name}wants{name[::-1]}(>99%)"
    assert lines[0].endswith("_")
    assert all(text_width(line, 14) <= 140 for line in lines)
    assert wrapped("x" * 30, 14, 1e-9)[0] == "x"


def test_what_has_no_room_is_an_ellipsis() -> None:
    assert wrapped("a b c d e f", 14, 30, 2)[-1].endswith("…")
    assert len(wrapped("a b c d e f", 14, 30, 2)) == 2
