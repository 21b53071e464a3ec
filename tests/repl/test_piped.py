"""`i2p repl` at the end of a pipe."""

from __future__ import annotations

import io
import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from commands_for_tests import I2P, PATIENCE, Run, process
from i2pdsl.repl.piped import entries
from i2pdsl.stories import Result
from repl.conftest import HELP

Repl = Callable[..., tuple[str, str]]


@pytest.fixture
def repl(i2p: Run, monkeypatch: pytest.MonkeyPatch) -> Repl:
    """What comes out of a command that reads lines and ends well, in this process."""

    def run(typed: str | bytes, *arguments: str) -> tuple[str, str]:
        data = typed.encode() if isinstance(typed, str) else typed
        monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(data)))
        done = i2p("repl", *arguments)
        assert done.status == 0, done.err
        return done.out, done.err

    return run


def test_a_process_at_the_end_of_a_pipe() -> None:
    done = process("repl", input="1 + 1\nlet x = 3\nhepl\nx ^ 2")
    assert done.out == "2\n9\n"
    assert "unknown name `hepl`" in done.err


def test_an_answer_for_each_question_in_its_order(solved_help: Result, repl: Repl) -> None:
    typed = (
        "P(rho > 0 | script[:7])\n"
        "P(rho > 0 | script[:t])\n"
        "P(G_robt = pink | script[:t])\n"
        "# a comment, then nothing\n"
        "\n"
        "let friend = rho > 0\n"
        "P(friend |\n"
        "    script[:T])\n"
        "hepl\n"
        "P(G_cheese | script[:T])\n"
        "T"  # and no end of line
    )
    out, err = repl(typed, str(HELP))
    ask = solved_help.script.query
    first, curve, friend, goals, length = out.splitlines()
    assert float(first) == pytest.approx(float(ask("P(rho > 0 | script[:7])")), rel=1e-5)
    numbers = [float(x) for x in curve.split()]
    assert numbers == pytest.approx(list(ask("P(rho > 0 | script[:t])")), rel=1e-5)
    assert float(friend) == pytest.approx(float(ask("P(rho > 0 | script[:T])")), rel=1e-5)
    pink, green = (float(part.split()[1]) for part in goals.split(", "))
    assert [pink, green] == pytest.approx(list(ask("P(G_cheese | script[:T])")), rel=1e-5)
    assert length == "15"
    heads = [line for line in err.splitlines() if ": error[" in line]
    assert heads == [
        "input:1:3: error[unknown-name]: unknown name `G_robt`",
        "input:1:1: error[unknown-name]: unknown name `hepl`",
    ]


def test_lines_of_other_systems_and_junk(repl: Repl) -> None:
    out, err = repl(b"T\r\nlet x = 2\r\nx\r\n\x00\xff\xfe\x1b[31m\r\n" + b"x + 1\r\n")
    assert out.splitlines() == ["0", "2", "3"]
    assert err.count("error[") == 1


def test_empty_input(repl: Repl) -> None:
    assert repl("") == ("", "")
    assert repl("\n\n  \n# only this\n")[0] == ""


def test_a_very_long_line(repl: Repl) -> None:
    long = "1" + " + 1" * 20_000
    out, err = repl(f"{long}\n{'(' * 5000}\nT\n")
    assert out.splitlines()[-1] == "0"
    assert out.splitlines()[0] == "20001" or "error[" in err
    assert len(err) < 5000


def test_quit_ends_early(repl: Repl) -> None:
    assert repl("1 + 1\nquit\n2 + 2\n")[0] == "2\n"
    assert repl("exit\n2 + 2\n")[0] == ""


def test_a_story_that_is_wrong_is_told_at_once(tmp_path: Path) -> None:
    (tmp_path / "wrong.story").write_text("world kitchen\nlength many\nmaximize 1\n")
    done = subprocess.run(
        [*I2P, "repl", "wrong.story"], input=b"1 + 1\n", capture_output=True, cwd=tmp_path
    )
    assert b"wrong.story:2:8: error[length]" in done.stderr
    assert (done.returncode, done.stdout) == (1, b"")


def test_every_answer_comes_before_the_next_question() -> None:
    with subprocess.Popen(
        [*I2P, "repl"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        for typed, answer in (
            (b"1 + 1\n", b"2\n"),
            (b"let x = 3\nx ^ 2\n", b"9\n"),
            (b"P(rho > 0 |\n  script[:T])\n", b"0.428571\n"),
        ):
            process.stdin.write(typed)
            process.stdin.flush()
            assert process.stdout.readline() == answer  # or it would wait for ever
        process.stdin.close()
        assert process.wait(PATIENCE) == 0


def test_a_reader_who_leaves() -> None:
    lines = "plot 1 + T\n" * 2000
    command = f"{' '.join(I2P)} repl | head -1"
    done = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {command}"], input=lines.encode(), capture_output=True
    )
    assert len(done.stdout.splitlines()) == 1
    assert b"Traceback" not in done.stderr
    assert b"Error" not in done.stderr


def test_answers_without_unicode() -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run([*I2P, "repl"], input=b"show\n", capture_output=True, env=environment)
    assert done.returncode == 0
    assert done.stdout.isascii()
    assert b"frame 0 of 0" in done.stdout


# What belongs together.


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        (["a", "b"], ["a", "b"]),
        (["P(x |", "  y)"], ["P(x |\n  y)"]),
        (["P(x |", "y)"], ["P(x |", "y)"]),
        (["let x =", "    1 +", "    2", "x"], ["let x =\n    1 +\n    2", "x"]),
        (["let f =", "    (x", "      + 1)"], ["let f =\n    (x\n      + 1)"]),
        (["1 + # more", "  2"], ["1 + # more\n  2"]),
        (["(1"], ["(1"]),
        ([], []),
    ],
)  # fmt: skip
def test_what_is_not_finished_goes_on_in_indented_lines(lines: list[str], found: list[str]) -> None:
    assert list(entries(f"{line}\n" for line in lines)) == found


def test_no_line_is_read_ahead() -> None:
    read: list[str] = []

    def lines() -> object:
        for line in ("a\n", "b +\n", "  c\n", "d\n"):
            read.append(line)
            yield line

    found = entries(lines())  # type: ignore[arg-type]
    assert next(found) == "a"
    assert read == ["a\n"]
    assert next(found) == "b +\n  c"
    assert read == ["a\n", "b +\n", "  c\n"]
