"""`i2p repl` on a pseudo-terminal, with an emulator that knows what stands on it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pexpect
import pyte
import pytest
from pexpect import fdpexpect

from commands_for_tests import I2P, PATIENCE
from fuzz_for_tests import FULL
from repl.conftest import HELP

UP, DOWN, TAB, ENTER = "\x1b[A", "\x1b[B", "\t", "\r"
TAKE_TERMINAL = """
import fcntl, os, sys, termios
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
os.execv(sys.argv[1], sys.argv[1:])
"""


class Terminal:
    """A program on a terminal of its own, and what that shows."""

    def __init__(self, arguments: tuple[str, ...], columns: int, rows: int, env: dict[str, str]):
        self.size = rows, columns
        self.screen = pyte.HistoryScreen(columns, rows, history=2000)
        self.stream = pyte.ByteStream(self.screen)
        self.raw = b""
        # JAX forbids forking this process, as pexpect.spawn would: a program of its own takes the
        # terminal, and becomes `i2p repl`.
        self.master, slave = os.openpty()
        termios.tcsetwinsize(slave, (rows, columns))
        command = [sys.executable, "-c", TAKE_TERMINAL, *I2P, "repl", *arguments]
        self.process = subprocess.Popen(
            command, stdin=slave, stdout=slave, stderr=slave, env=env, start_new_session=True
        )
        os.close(slave)
        self.child = fdpexpect.fdspawn(self.master)

    def read(self, seconds: float = 0.05) -> None:
        """Takes in what the program writes; says where the cursor is when that is asked."""
        try:
            data = self.child.read_nonblocking(65536, seconds)
        except (pexpect.TIMEOUT, pexpect.EOF, OSError):
            return
        self.raw += data
        self.stream.feed(data)
        if b"\x1b[6n" in data:
            self.child.send(f"\x1b[{self.screen.cursor.y + 1};{self.screen.cursor.x + 1}R")

    def shown(self) -> str:
        """All lines, those too that have left the window at its top."""
        gone = [
            "".join(line[x].data for x in range(self.screen.columns)).rstrip()
            for line in self.screen.history.top
        ]
        return "\n".join((*gone, *(line.rstrip() for line in self.screen.display))).rstrip()

    def until(self, is_there: Callable[[str], object]) -> str:
        """Reads until the terminal shows what is waited for."""
        end = time.monotonic() + PATIENCE
        while not is_there(self.shown()):
            assert time.monotonic() < end, self.shown()
            if self.process.poll() is not None:
                self.read()
                assert is_there(self.shown()), self.shown()
            self.read()
        return self.shown()

    def prompts(self) -> int:
        return len(re.findall(r"^i2p>", self.shown(), re.MULTILINE))

    def type(self, text: str) -> None:
        self.child.send(text)

    def enter(self, line: str) -> str:
        """Types a line; what stands between it and the next prompt."""
        before = self.prompts()
        self.type(line + ENTER)
        text = self.until(lambda _: self.prompts() > before)
        parts = re.split(r"^i2p>", text, flags=re.MULTILINE)
        return parts[before]

    def status(self) -> int:
        """Waits for the end."""
        end = time.monotonic() + PATIENCE
        while self.process.poll() is None:
            assert time.monotonic() < end, self.shown()
            self.read()
        self.read()
        return self.process.returncode

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        os.close(self.master)


Open = Callable[..., Terminal]


def begun(state: Path, *arguments: str, columns: int = 100, rows: int = 40, **env: str) -> Terminal:
    """A terminal that is ready, with a history in a folder."""
    plain = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "COLUMNS", "LINES")}
    own = {"TERM": "xterm-256color", "XDG_STATE_HOME": str(state), "LANG": "C.UTF-8"}
    found = Terminal(arguments, columns, rows, {**plain, **own, **env})
    found.until(lambda text: re.search(r"^i2p>", text, re.MULTILINE))
    return found


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Open]:
    """Opens terminals with a history of their own."""
    opened: list[Terminal] = []

    def open_(*arguments: str, **more: Any) -> Terminal:
        opened.append(begun(tmp_path, *arguments, **more))
        return opened[-1]

    yield open_
    for each in opened:
        each.close()


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Terminal]:
    """One for tests that can do with whatever was done before."""
    found = begun(tmp_path_factory.mktemp("usual"))
    yield found
    found.close()


def test_a_session(terminal: Open, tmp_path: Path) -> None:
    """Answers, a mistake, several lines, the menu, and the end: one start of the program."""
    story = tmp_path / "help.story"
    story.write_text(f"{HELP.read_text(encoding='utf-8')}search beam(starts = 20, polish = 0)\n")
    one = terminal(str(story))
    text = one.until(lambda text: "help.story" in text.splitlines()[-1])  # the toolbar
    assert "`help` explains, Ctrl-D leaves" in text

    answer = one.enter("P(rho > 0 | script[:7])")
    assert re.search(r"^0\.9\d+$", answer, re.MULTILINE)
    assert answer.index("solved: score") < answer.index("\n0.9")

    wrong = one.enter("P(G_robt = pink | script[:t])").splitlines()
    assert wrong[1:5] == [
        "input:1:3: error[unknown-name]: unknown name `G_robt`",
        "    1 | P(G_robt = pink | script[:t])",
        "      |   ^^^^^^",
        "  hint: did you mean `G_robot`?",
    ]

    curve = one.enter("P(rho > 0 | script[:t])")
    assert re.search("[\u2801-\u28ff]", curve)
    assert max(map(len, curve.splitlines())) <= 100

    # What is not finished goes on in the next line.
    one.type("P(rho > 0 |" + ENTER)
    one.until(lambda text: "·" in text.splitlines()[-2] or "\n   ·" in text)
    assert "0.9" in one.enter("script[:7])").rpartition("·")[2]

    # After `G_cheese =` there are two values.
    one.type("P(G_cheese =")
    text = one.until(lambda text: "green  G_cheese = green" in text)
    below = text[text.rindex("i2p>") :].splitlines()[1:]
    menu = [line.split()[0] for line in below if "G_cheese = " in line]
    assert menu == ["pink", "green"]
    one.type(DOWN + DOWN)
    one.until(lambda text: "P(G_cheese =green" in text)
    one.type(ENTER)  # takes it and leaves the line
    text = one.until(lambda text: "green  G_cheese = green" not in text)
    assert text.rstrip().count("i2p>") == one.prompts()
    assert "error" not in text[text.rindex("i2p>") :]

    # Ctrl-C drops the line, Ctrl-D on an empty one leaves.
    before = one.prompts()
    one.type("\x03")
    one.until(lambda _: one.prompts() > before)
    assert one.enter("1 + 1").splitlines()[1] == "2"
    one.type("\x04")
    assert one.status() == 0
    assert "Traceback" not in one.shown()


def test_history_from_one_session_to_the_next(terminal: Open, tmp_path: Path) -> None:
    one = terminal()
    assert "42" in one.enter("6 * 7")
    one.enter("let x = 3")
    one.type("quit" + ENTER)
    assert one.status() == 0
    two = terminal()
    two.type(UP + UP + UP)
    two.until(lambda text: "i2p> 6 * 7" in text)
    two.type(ENTER)
    two.until(lambda text: "\n42" in text)
    assert "6 * 7" in (tmp_path / "i2pdsl" / "history").read_text()


def test_leaving_at_once(terminal: Open) -> None:
    for _ in range(2 if FULL else 1):
        one = terminal()
        one.type("\x04")
        assert one.status() == 0
        assert "Traceback" not in one.shown()
        assert "Fatal" not in one.shown()


def test_pasted_lines_are_done_one_after_the_other(usual: Terminal) -> None:
    one = usual
    one.type("\x1b[200~let a = 2\nlet b =\n    a + 3\nb ^ 2\nb + 1\x1b[201~")
    one.until(lambda text: "b + 1" in text)
    text = one.enter("")
    assert "\n25\n" in text
    assert "\n6\n" in text
    one.enter("let a = 3")
    assert "\n6\n" in one.enter("b")


@pytest.mark.slow  # test_session.py interrupts one in this process
def test_interrupting_a_search(terminal: Open, tmp_path: Path) -> None:
    # Many starts are searched in blocks, between which it can be interrupted.
    story = tmp_path / "long.story"
    story.write_text(
        "world kitchen\nlength 15\nmaximize depict(rho > 0)\n"
        "search beam(starts = 100000, polish = 0)\n"
    )
    one = terminal(str(story))
    before = one.prompts()
    one.type("solve" + ENTER)
    one.until(lambda text: re.search(r"searching: +[1-9]\d? %", text))
    one.type("\x03")
    text = one.until(lambda _: one.prompts() > before)
    assert "interrupted: the best of what was searched so far is kept" in text
    assert "score 29." in text
    assert "15" in one.enter("T")


def test_interrupting_before_anything_is_found(terminal: Open, tmp_path: Path) -> None:
    one = terminal(I2PDSL_CACHE=str(tmp_path / "cache"))
    one.enter("let x = rho > 0")
    before = one.prompts()
    one.type("P(x | script[:T])" + ENTER)  # the world must be planned first
    one.until(lambda text: "planning" in text)
    one.type("\x03")
    text = one.until(lambda _: one.prompts() > before)
    assert "interrupted: nothing is changed" in text
    assert "Traceback" not in text
    assert "let x = rho > 0" in one.enter("story")


def test_without_colour_and_where_no_history_can_be_written(terminal: Open, tmp_path: Path) -> None:
    (tmp_path / "i2pdsl").write_text("a file, not a folder")
    one = terminal(NO_COLOR="1")
    assert "\n2\n" in one.enter("1 + 1")
    text = one.enter("show")
    assert "C cheese" in text
    one.enter("P(rho > 0 | scrpt[:t])")
    one.enter("plot 0.5, 0.7")
    one.enter("story")
    assert not re.search(rb"\x1b\[[0-9;]*(?:3[0-7]|38;[25];[0-9;]+)m", one.raw)
    assert "* 0.5" in one.shown()


def test_colours(usual: Terminal) -> None:
    one = usual
    before = len(one.raw)
    one.enter("story")
    start = one.raw.index(b"story", before)
    assert re.search(rb"\x1b\[[0-9;]+mworld", one.raw[start:])


def test_a_terminal_that_can_do_nothing(terminal: Open) -> None:
    one = terminal(TERM="dumb")
    assert "\n2\n" in one.enter("1 + 1")
    assert "error[unknown-name]" in one.enter("P(rhu > 0 | script[:T])")
    assert "C cheese" in one.enter("show")
    assert b"\x1b[3" not in one.raw
    one.type("\x04")
    assert one.status() == 0


def test_a_narrow_window(terminal: Open) -> None:
    one = terminal(columns=40, rows=24)
    one.enter("play cheese west, robot south")
    plot = one.enter("plot P(rho > 0 | script[:t])")
    drawn = [line for line in plot.splitlines() if "│" in line or "└" in line]
    assert len(drawn) == 11
    assert "G_cheese" in one.enter("show")
    one.type("P(G_cheese =")
    one.until(lambda text: "green" in text[text.rindex("i2p>") :])
    assert "Traceback" not in one.shown()


def test_a_window_that_changes_its_size(usual: Terminal) -> None:
    one = usual
    termios.tcsetwinsize(one.master, (40, 50))
    one.screen.resize(40, 50)
    time.sleep(0.2)
    plot = one.enter("plot 0.25")
    feet = [line for line in plot.splitlines() if "└" in line]
    rows, columns = one.size
    termios.tcsetwinsize(one.master, one.size)
    one.screen.resize(rows, columns)
    assert len(feet) == 1
    assert len(feet[0]) <= 50
