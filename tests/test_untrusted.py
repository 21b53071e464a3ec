"""Files that anyone may have written: names that lead nowhere, only regular files of bounded size,
and whatever stands in them is an error that names the file, soon; never anything else."""

from __future__ import annotations

import errno
import json
import os
import socket
from pathlib import Path

import pytest

from commands_for_tests import Run
from i2pdsl.errors import Diagnostic, Source, Span, StoryError
from i2pdsl.language.statements import LARGEST_TEXT, read_source
from i2pdsl.untrusted import (
    RepeatedKeyError,
    below,
    is_plain_name,
    json_excess,
    plain_name,
    read_bytes,
    without_repetition,
)

NO_NAMES = [
    "", ".", "..", "...", " ", "a/b", "/a", "../a", "a\\b", "C:", "C:a", "a\0", "a\nb", "\x1b[31m",
    " a", "a ", "a.", ".a", "con", "CON", "nul.story", "Com1", "lpt9.world", "x" * 201, "é" * 101,
    "a\u202eb", "a\u200bb", "a\ud800", "\uff0e\uff0e", "\u2025", "\uff0fetc", "a\uff3cb",
    "COM\u00b9", 3, None, ["a"], b"a",
]  # fmt: skip
NAMES = [
    "a", "moods", "my world", "a.b", "x" * 200, "é" * 100, "厨房", "第一章：开始", "why?",
    "connie", "com", "common1", "nulla", "a-b_c (2)", "½", "it's",
]  # fmt: skip


@pytest.mark.parametrize("name", NO_NAMES)
def test_what_is_no_name(name: object, tmp_path: Path) -> None:
    assert not is_plain_name(name)
    if not isinstance(name, str):
        return
    assert is_plain_name(plain_name(name))
    with pytest.raises((OSError, ValueError)):
        below(tmp_path, name)


def test_names() -> None:
    for name in NAMES:
        assert is_plain_name(name), name
        assert plain_name(name) == name
    named = {plain_name(name) for name in (*NAMES, *(n for n in NO_NAMES if isinstance(n, str)))}
    assert len(named) == len(NAMES) + sum(isinstance(n, str) for n in NO_NAMES)


def test_no_link_leads_out(tmp_path: Path) -> None:
    inside, outside = tmp_path / "in", tmp_path / "out"
    inside.mkdir()
    outside.mkdir()
    assert below(inside, "a", "b.txt") == inside / "a" / "b.txt"
    (inside / "link").symlink_to(outside)
    (inside / "gone").symlink_to(tmp_path / "nowhere")
    for name in ("link", "gone"):
        with pytest.raises(OSError, match="a link leads out of"):
            below(inside, name, "b.txt")
    (inside / "here").symlink_to(inside)
    (inside / "last").symlink_to(outside / "b.txt")
    (tmp_path / "also").symlink_to(inside)
    assert below(inside, "here", "b.txt").name == "b.txt"
    assert below(tmp_path / "also", "b.txt").name == "b.txt", "the folder itself may be a link"
    assert below(inside, "last") == inside / "last", "it is replaced, not followed"


def special(folder: Path) -> dict[str, Path]:
    """Files that cannot be read like others, by what is said of them."""
    os.mkfifo(folder / "pipe")
    (folder / "folder").mkdir()
    (folder / "zero").symlink_to("/dev/zero")
    (folder / "piped").symlink_to("pipe")
    (folder / "loop").symlink_to("loop")
    with (folder / "large").open("wb") as file:
        file.truncate(50 * 2**30)
    with socket.socket(socket.AF_UNIX) as listener:
        here = Path.cwd()
        os.chdir(folder)  # the name of a socket may not be long
        try:
            listener.bind("socket")
        finally:
            os.chdir(here)
    said = {
        "pipe": "it is a pipe", "piped": "it is a pipe", "folder": "it is a folder",
        "zero": "it is a device", "socket": "it is a socket", "loop": "symbolic links",
        "large": "it has 53,687,091,200 bytes; at most 1,000 are read",
    }  # fmt: skip
    return {words: folder / name for name, words in said.items()} | {
        "it is a pipe, not": folder / "piped"
    }


def test_only_regular_files_are_read(tmp_path: Path) -> None:
    for words, path in special(tmp_path).items():
        with pytest.raises(OSError, match=r".") as caught:
            read_bytes(path, 1000)
        assert words in str(caught.value.strerror), path
        assert caught.value.filename == str(path)
    (tmp_path / "plain").write_bytes(b"x" * 1000)
    assert len(read_bytes(tmp_path / "plain", 1000)) == 1000
    with pytest.raises(OSError, match="at most 999") as caught:
        read_bytes(tmp_path / "plain", 999)
    assert caught.value.errno == errno.EFBIG
    for name in ("none", "nu\0l", "half\ud800"):
        with pytest.raises(FileNotFoundError):
            read_bytes(tmp_path / name, 1000)


@pytest.mark.parametrize("suffix", [".story", ".world", ".study", ".json", ".i2plib"])
def test_no_command_waits_for_or_fills_memory_with_a_file(
    suffix: str, tmp_path: Path, i2p: Run
) -> None:
    commands = {
        ".story": ["check", "fmt", "run", "render", "repl", "patterns", "compile", "extract"],
        ".world": ["check", "fmt", "worlds", "plan"],
        ".study": ["check", "fmt", "study"],
        ".json": ["query", "render", "repl", "run"],
        ".i2plib": ["patterns"],
    }[suffix]
    more = {
        "query": ["1"], "compile": ["-o", str(tmp_path / "x.i2plib")],
        "extract": ["-o", str(tmp_path / "new.story")],
    }  # fmt: skip
    found = special(tmp_path)
    for number, path in enumerate(dict.fromkeys(found.values())):
        place = tmp_path / f"of{number}"
        place.mkdir()
        named = place / f"a{suffix}"
        named.symlink_to(path)
        if path.name in ("folder", "loop"):
            continue
        for command in commands:
            where = place if command == "compile" else named
            done = i2p(command, where, *more.get(command, []))
            assert done.status == 1, (command, path.name, done)
            assert str(named) in done.err, (command, path.name)
            assert "error" in done.err
            assert "\n" in done.err


def test_text_that_is_none(tmp_path: Path, i2p: Run) -> None:
    story = tmp_path / "a.story"
    for data in (b"\xff\xfe", b"\x00" * 100, bytes(range(256)), b"world kitchen\xed\xa0\x80\n"):
        story.write_bytes(data)
        done = i2p("check", story)
        assert done.status == 1
        assert f"{story}:" in done.err
    story.write_bytes(b"\xef\xbb\xbfworld kitchen\nlength 3\nmaximize depict(rho > 0)\n")
    assert i2p("check", story).status == 0
    story.write_bytes(b"x" * (LARGEST_TEXT + 1))
    with pytest.raises(StoryError, match=r"error\[too-long\]: cannot be read: it has 2,000,004"):
        read_source(story)


def test_json_is_measured_before_it_is_read() -> None:
    assert json_excess('{"a": [[1, "[[[[[[[[", {}]]}', 4) is None
    assert json_excess('{"a": [[1, "]", [{}]]]}', 4) == "nested too deeply"
    assert json_excess("[[]" + ", []" * 20 + "]", 4, 20) == "of more than 20 parts"
    assert json_excess("[" * 10**6, 60) == "nested too deeply"
    # Texts that never end, with quotes in them: a reader that goes back takes hours.
    for text in ('"' + '\\"' * 10**6, '"' + "\\" * (2 * 10**6 + 1), '{"a": "' + '\\\\"' * 10**6):
        assert json_excess(text, 60) is None


def test_a_key_is_given_once() -> None:
    with pytest.raises(RepeatedKeyError, match="b"):
        json.loads('{"a": {"b": 1, "c": 2, "b": 1}}', object_pairs_hook=without_repetition)


def test_nothing_in_a_message_steers_a_terminal() -> None:
    source = Source("a\x1b]0;evil\x07.story", "one \x9b31m\n")
    wrong = Diagnostic("x", "no \x1b[2J\u202e`\r`", Span(source, 0, 3), "try \x07")
    shown = wrong.render()
    assert all(c.isprintable() or c == "\n" for c in shown)
    assert shown.startswith("a�]0;evil�.story:1:1: error[x]: no �[2J�`�`\n")
    kept = Diagnostic("x", "caf\udce9", Span(Source("caf\udce9.story", ""), 0, 0))
    assert kept.render() == "caf\udce9.story:1:1: error[x]: caf\udce9"
