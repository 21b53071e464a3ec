"""A plane in a session and in an editor: looked at, played by hand, gone on with, completed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from i2pdsl.editor.complete import complete, surroundings
from i2pdsl.editor.hover import hover
from i2pdsl.errors import Source
from i2pdsl.repl.session import Session
from i2pdsl.repl.showing import Looked
from i2pdsl.worlds.find import find_vocabulary
from repl.conftest import asked, refused, right

LEFT = "P(G_hand = left | script[:t])"
STORY = "world desk\nlength 20\nmaximize legible(G_hand = left)\n"


@pytest.fixture
def session(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Session:
    monkeypatch.chdir(tmp_path)
    session = Session()
    right(session, "world desk")
    return session


def picture(session: Session) -> str:
    (shown,) = right(session, "show").shown
    assert isinstance(shown, Looked)
    return shown.picture


def test_everybody_begins_where_the_file_says(session: Session) -> None:
    assert "H hand (6.0, 1.0)" in picture(session)
    right(session, "start at(hand, left)")
    assert "H hand (4.0, 7.0)" in picture(session)


def test_it_is_played_by_direction_and_speed(session: Session) -> None:
    right(session, "play hand 45 0.5 6")  # to the upper right, half as fast as it likes
    assert asked(session, LEFT).shape == (7,)
    assert asked(session, LEFT)[-1] < 0.5
    apart = "[distance(hand, (6, 1)) @ script[T]]"
    speed = asked(session, "[speed(hand) @ script[t]]")
    np.testing.assert_allclose(speed, speed[0])
    assert asked(session, apart) == pytest.approx(speed.sum())
    assert "hand" in refused(session, "play somebody 45")
    assert "play" in refused(session, "play hand sideways")


def test_it_is_gone_on_with(session: Session) -> None:
    right(session, "search descend(seeds = 1, steps = 10, window = 8)")
    right(session, "suggest 6 P(G_hand = left | script[:T])")
    right(session, "accept")
    answer = asked(session, LEFT)
    assert answer.shape == (7,)
    assert answer[-1] > answer[0]


def offered(marked: str) -> set[str]:
    before, _, after = (STORY + marked).partition("¦")
    around = surroundings(Source("own.story", before + after), Path("nowhere"), find_vocabulary)
    return {each.text for each in complete(before + after, len(before), around, "file")}


def test_its_words_are_completed_and_explained() -> None:
    assert {"left", "right"} <= offered("start at(hand, ¦")
    assert {"hand"} <= offered("maximize sum_t [heads(¦")
    assert {"descend", "naive"} <= offered("search ¦")
    assert "beam" not in offered("search ¦")
    text = STORY + "maximize sum_t [heads(hand, left) @ script[t]]\n"
    around = surroundings(Source("own.story", text), Path("nowhere"), find_vocabulary)
    told = hover(text, text.index("heads"), around)
    assert told is not None
    assert told.signature.startswith("heads(")
