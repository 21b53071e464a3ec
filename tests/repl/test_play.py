"""Each kind of world says how it is played: in hints, in `help play` and among the commands."""

from __future__ import annotations

import pytest

from i2pdsl.repl.completing import complete_line
from i2pdsl.repl.helping import explain
from i2pdsl.repl.session import Session
from i2pdsl.worlds.find import builtin_worlds, find_spec, vocabulary_of
from i2pdsl.worlds.kinds import kind_of
from worlds_for_tests import STORIES


def in_world(name: str) -> Session:
    session = Session()
    assert not session.run(f'world "{STORIES}/worlds/{name}.world"').diagnostics
    return session


@pytest.mark.parametrize("name", builtin_worlds())
def test_how_a_world_is_played(name: str) -> None:
    session = in_world(name)
    spec = find_spec(name)
    assert spec is not None
    word = kind_of(spec).play(vocabulary_of(spec))
    (needs,) = session.run("play").diagnostics
    assert needs.hint == f"`{word.signature}`"
    told = explain("play", session.state)
    assert all(part in told for part in (word.signature, word.documentation, word.example))
    (offered,) = (c for c in complete_line("play", 4, session.state) if c.text == "play")
    assert word.documentation in (offered.detail, offered.documentation)


@pytest.mark.parametrize(
    ("name", "signature", "example"),
    [
        ("kitchen", "play WHO ACTION[!], ...", "play cheese west!"),
        ("fork", "play WHO ACTION", "play robot west"),
        ("desk", "play WHO DIRECTION [SPEED [FRAMES]]", "play hand east"),
        ("hill", "play N", "play 50"),
    ],
)
def test_signatures_and_examples(name: str, signature: str, example: str) -> None:
    spec = find_spec(name)
    assert spec is not None
    word = kind_of(spec).play(vocabulary_of(spec))
    assert (word.signature, word.example) == (signature, example)


@pytest.mark.parametrize("name", ["fork", "desk"])
def test_the_example_can_be_typed(name: str) -> None:
    session = in_world(name)
    assert session.state.command("play") is not None
    for command in session.state.commands:
        if command.name == "play":
            assert not session.run(command.example).diagnostics
    assert session.state.path is not None
    assert len(session.state.path.actions) == (1 if name == "fork" else 10)
