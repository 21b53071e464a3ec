"""Letters of all scripts: a font of the system, or one warning that there is none."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import matplotlib.font_manager
import numpy as np
import pytest

from i2pdsl.render import fonts
from i2pdsl.render.fonts import families, font_files, further_fonts, in_words, lacked, noting
from i2pdsl.render.lettering import text_svg
from i2pdsl.render.mind import Panel, Series, save_mind
from i2pdsl.render.raster import svg_png, text_width

OTHER = Path(matplotlib.get_data_path(), "fonts", "ttf", "STIXGeneral.ttf")
ONLY_THERE = "\u2a0a"  # in STIX, and not in DejaVu Sans


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine without fonts of its own."""
    monkeypatch.setattr(matplotlib.font_manager, "findSystemFonts", list)
    monkeypatch.setattr(fonts, "_logged", set())
    fonts._found.cache_clear()


@pytest.fixture
def with_stix(alone: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    damaged = tmp_path / "sans.ttf"
    damaged.write_bytes(b"no font")
    found = [str(damaged), font_files()[1], str(OTHER)]
    monkeypatch.setattr(matplotlib.font_manager, "findSystemFonts", lambda: found)
    fonts._found.cache_clear()


def test_what_dejavu_has_needs_nothing() -> None:
    text = "plain ABC äöü ß Ωμέγα кот ∑ → – … عربي \u200d\ufe0f\u202e\ud800\x00 e\u0301"
    assert lacked(text) == frozenset()
    assert further_fonts(text) == ()
    assert families(text) == ["DejaVu Sans"]


def test_what_nothing_has_is_told_once() -> None:
    told = []
    with noting(lambda *said: told.append(said)):
        svg = f'<svg xmlns="http://www.w3.org/2000/svg">{text_svg(0, 9, "猫 & 種", 9)}</svg>'
        svg_png(svg)
        svg_png(svg.replace("猫", "प🧀"))
        families("種ก")
    ((message, hint),) = told
    assert message.startswith("no font of this machine has प ก 猫 種 🧀: ")
    for name in ("Noto Sans CJK", "fonts-noto-cjk", "Devanagari", "Thai", "fonts-symbola"):
        assert name in hint
    with noting(lambda *said: told.append(said)):
        svg_png(svg.replace("猫", "cat").replace("種", "seed"))
    assert len(told) == 1


def test_elsewhere_it_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    families("猫")
    families("猫")
    families("猫種")
    assert [record.message.count("猫") for record in caplog.records] == [1, 1]


def test_a_font_of_the_system_is_taken(with_stix: None) -> None:
    told = []
    with noting(lambda *said: told.append(said)):
        assert further_fonts(ONLY_THERE) == (str(OTHER),)
        assert families(f"a{ONLY_THERE}") == ["DejaVu Sans", "STIXGeneral"]
        plain = svg_png(_signs(""))
        drawn = svg_png(_signs(ONLY_THERE))
    assert told == []
    assert drawn != plain
    with noting(lambda *said: told.append(said)):
        further_fonts(f"{ONLY_THERE}猫")
    assert told[0][0].startswith("no font of this machine has 猫: ")


def _signs(text: str) -> str:
    size = 'width="40" height="40"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{text_svg(2, 30, text, 30)}</svg>'


def test_room_is_left_for_other_letters() -> None:
    assert text_width("猫猫", 10) == pytest.approx(20)
    assert text_width("a猫", 10) == pytest.approx(10 + text_width("a", 10))


def test_matplotlib_says_nothing_by_itself(
    tmp_path: Path, recwarn: pytest.WarningsRecorder, caplog: pytest.LogCaptureFixture
) -> None:
    panel = Panel("猫's goal", "probability", (Series("種", np.array([0.5, 1.0]), "#0068b0"),))
    told = []
    with noting(lambda *said: told.append(said)):
        save_mind(tmp_path / "mind.png", [panel], "巣")
    assert len(told) == 1
    assert len(recwarn) == 0
    assert caplog.records == []


def test_many_letters_are_not_all_listed() -> None:
    message, _ = in_words(chr(0x4E00 + i) for i in range(100))
    assert "and 88 more" in message
