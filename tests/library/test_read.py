"""Libraries that are damaged, forged, cut or of another version: an error that names the file and
says what is wrong, soon; never anything else."""

from __future__ import annotations

import json
import time
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from libraries_for_tests import Forgery, make_folder, packed, zipped

from commands_for_tests import Run
from fuzz_for_tests import FULL
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import check_source
from i2pdsl.language.imports import read_library
from i2pdsl.language.packed import LARGEST, encode
from i2pdsl.library import fits
from i2pdsl.worlds.find import builtin_worlds, find_vocabulary

SETTINGS = settings(
    derandomize=True,
    max_examples=100,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
COMMON = "outside/common.story"


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return encode(packed(make_folder(tmp_path_factory.mktemp("good"))).contents)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "moods.i2plib"


def said(path: Path) -> str:
    """What is said about a library that is wrong: one diagnostic that names it."""
    with pytest.raises(StoryError) as caught:
        read_library(path)
    (problem,) = caught.value.diagnostics
    assert problem.span.source.name == str(path)
    assert problem.code in ("library", "no-file")
    return problem.message


def test_what_was_packed_is_read(good: bytes, path: Path) -> None:
    path.write_bytes(good)
    library = read_library(path)
    assert encode(library.contents) == good
    assert set(library.exports.names) == {
        "after", "both", "dark", "middle", "pink_mind", "slow_depict", "slowness",
    }  # fmt: skip
    assert read_library(path) is library, "it is read once"


def test_a_file_that_has_changed_is_read_again(good: bytes, path: Path) -> None:
    path.write_bytes(good)
    first = read_library(path)
    path.write_text("{}", encoding="utf-8")
    assert "not a compiled library" in said(path)
    path.write_bytes(good)
    assert read_library(path) is not first


def test_missing_and_unreadable(tmp_path: Path) -> None:
    assert "no such file" in said(tmp_path / "none.i2plib")
    (tmp_path / "folder.i2plib").mkdir()
    assert "cannot be read" in said(tmp_path / "folder.i2plib")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is empty"),
        (b" \n ", "is empty"),
        (b"\xff\xfe\x00", "not a compiled library"),
        (b"world kitchen\n", "not a compiled library"),
        (b'{"format": "i2p-script", "version": 1}', "not a compiled library"),
        (b"PK\x03\x04", "no whole zip"),
        (b"PK\x05\x06" + b"\0" * 18, "has no manifest.json"),
        (b"PK" * 100_000, "no whole zip"),
    ],
)
def test_no_library(path: Path, data: bytes, message: str) -> None:
    path.write_bytes(data)
    assert message in said(path)


HEAD = b'{"format": "i2p-library", "version": '


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is empty"),
        (b"\xff", "byte 0 is not UTF-8"),
        (b"world kitchen\n", "no JSON from line 1"),
        (b"[]", "not a compiled library"),
        (b"null", "not a compiled library"),
        (b'{"format": "i2p-script", "version": 2}', "not a compiled library"),
        (b'{"format": "i2p-library"}', "version is no number"),
        (HEAD + b"true}", "version is no number"),
        (HEAD + b'"2"}', "version is no number"),
        (HEAD + b"1}", "version is no number"),
        (HEAD + b"2}", "the manifest has no `made_with`"),
        (HEAD + b'2, "version": 2}', "is not its JSON"),
        (HEAD + b'2, "x": NaN}', "is not its JSON"),
        (HEAD + b'2, "x": ' + b"9" * 9999 + b"}", "is not its JSON"),
        (HEAD + b"3}", "a later version of i2pdsl (format 3); this one reads format 2"),
        (b"[" * 100_000, "nested too deep"),
        (b"{" + b'"a":{' * 5000, "nested too deep"),
        (b'{"a": "' + b'\\"' * 1_000_000, "no JSON"),
    ],
)
def test_no_manifest(path: Path, data: bytes, message: str) -> None:
    path.write_bytes(zipped([("manifest.json", data)]))
    assert message in said(path)


def test_a_library_of_the_first_format(path: Path, i2p: Run) -> None:
    """It was one JSON document."""
    path.write_text('{\n "format": "i2p-library",\n "version": 1,\n "name": "moods"', "utf-8")
    done = i2p("patterns", path)
    assert done.status == 1
    assert done.err == (
        f"{path}:1:1: error[library]: made by an earlier version of i2pdsl (format 1); "
        "this one reads format 2\n"
        "  hint: compile it again: `i2p compile FOLDER -o moods.i2plib`\n"
    )


def test_a_file_that_is_too_large(path: Path) -> None:
    path.write_bytes(b" " * (LARGEST + 1))
    began = time.process_time()
    assert "too large" in said(path)
    assert time.process_time() - began < 1


def test_a_cut_file(good: bytes, path: Path) -> None:
    for end in range(2, len(good), 97):
        path.write_bytes(good[:end])
        assert "is its end missing?" in said(path)


def test_a_changed_byte_is_noticed(good: bytes, path: Path) -> None:
    path.write_bytes(good.replace(b"sum_t slowness", b"sum_t slowmess"))
    assert said(path) == f"the library is damaged: {COMMON} cannot be read"
    forgery = Forgery(good)
    forgery.files[COMMON] = forgery.files[COMMON].replace(b"slowness", b"slowmess")
    path.write_bytes(forgery.zipped())
    assert said(path) == f"the library is damaged: {COMMON} does not have the hash that is stated"


# Zips that no library is.


def test_nothing_is_expanded(good: bytes, path: Path) -> None:
    """A zip of 4 kB can hold 4 MB of zeros, and one of 4 MB a disk full."""
    for method in (zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA):
        forgery = Forgery(good)
        forgery.text(COMMON, " " * 2**22)
        path.write_bytes(forgery.zipped(method))
        assert "is compressed" in said(path)


def members_of(good: bytes) -> list[tuple[str, bytes]]:
    forgery = Forgery(good)
    return [("manifest.json", json.dumps(forgery.manifest).encode()), *forgery.files.items()]


@pytest.mark.parametrize(
    "name",
    ["more.story", "../evil.story", "/tmp/evil", "deep/", "a\\b", "C:\\x", "", "moods.story"],
)
def test_files_that_the_manifest_has_not(good: bytes, path: Path, name: str) -> None:
    path.write_bytes(zipped([*members_of(good), (name, b"x")]))
    message = "two of its files have one name" if name == "moods.story" else "not in its manifest"
    assert message in said(path)
    assert [p.name for p in path.parent.iterdir()] == ["moods.i2plib"]


def test_a_file_that_is_only_in_the_manifest(good: bytes, path: Path) -> None:
    path.write_bytes(zipped(m for m in members_of(good) if m[0] != COMMON))
    assert said(path).endswith(f"{COMMON} is either not in it or not in its manifest")


def test_two_manifests(good: bytes, path: Path) -> None:
    members = members_of(good)
    path.write_bytes(zipped([*members, members[0]]))
    assert "two of its files have one name" in said(path)
    forgery = Forgery(good)
    forgery.manifest["worlds"].append({**forgery.record(COMMON), "file": "manifest.json"})
    path.write_bytes(forgery.zipped())
    assert "two of its files have one name" in said(path)


def central(data: bytes, field: int, value: int, size: int = 2) -> bytes:
    """A zip whose directory says something else of the last file; `field` is the place of it."""
    at = data.rindex(b"PK\x01\x02") + field
    return data[:at] + value.to_bytes(size, "little") + data[at + size :]


@pytest.mark.parametrize(
    ("field", "value", "size", "message"),
    [
        (8, 1, 2, "cannot be read"),
        (8, 0x40, 2, "cannot be read"),
        (10, 99, 2, "is compressed"),
        (20, 1, 4, "is compressed"),
        (42, 10, 4, "cannot be read"),
        (42, 2**32 - 2, 4, "cannot be read"),
        (42, 0, 4, "cannot be read"),
    ],
)
def test_a_directory_that_lies(
    good: bytes, path: Path, field: int, value: int, size: int, message: str
) -> None:
    path.write_bytes(central(good, field, value, size))
    assert message in said(path)


def test_files_that_overlap(good: bytes, path: Path) -> None:
    """What is stored once cannot be read many times: a large file under a thousand names."""
    large = len(good).to_bytes(4, "little")
    at = good.rindex(b"PK\x01\x02")
    path.write_bytes(good[: at + 20] + 2 * large + good[at + 28 :])
    assert "overlap" in said(path)


# Manifests that are forged, with the hashes that the files have.


def manifest(key: str, value: object) -> Callable[[Forgery], None]:
    return lambda forgery: forgery.manifest.update({key: value})


def record(key: str, value: object, name: str = COMMON) -> Callable[[Forgery], None]:
    return lambda forgery: forgery.record(name).update({key: value})


def text(new: str) -> Callable[[Forgery], None]:
    return lambda forgery: forgery.text(COMMON, new)


def named(new: str) -> Callable[[Forgery], None]:
    return lambda forgery: forgery.rename(COMMON, new)


TURNS = "deep/turns.story"
LEADS_OUT = "leads out of the library or is no file's name"
FORGED: dict[str, tuple[Callable[[Forgery], None], str]] = {
    "hash": (record("sha256", "0" * 64), f"{COMMON} does not have the hash"),
    "hash of another kind": (record("sha256", 7), "outside[0].sha256 is not a text"),
    "imports": (record("imports", {}, TURNS), f"{TURNS}:1:8: it is not said what this import"),
    "import to nowhere": (
        record("imports", {"twist": ["none.story"]}, TURNS),
        "the import `twist` leads to no file",
    ),
    "import is a story": (
        record("imports", {"twist": ["secret.story"]}, TURNS),
        "the import `twist` leads to no file",
    ),
    "import is a word": (record("imports", {"twist": "elsewhere"}, TURNS), "leads to no file"),
    "import is a way": (record("imports", {"twist": ["../x"]}, TURNS), LEADS_OUT),
    "import of half a character": (record("imports", {"\ud800": "x"}, TURNS), "leads to no file"),
    "statement": (text("world kitchen\n"), f"{COMMON}:1:1: a library has no `world`"),
    "syntax": (text("pattern (\n"), f"{COMMON}:1:9"),
    "control characters": (text("let x\x00 = 1"), "not text"),
    "dots": (named("../x.story"), LEADS_OUT),
    "absolute": (named("/etc/passwd"), LEADS_OUT),
    "drive": (named("C:\\x.story"), LEADS_OUT),
    "device": (named("deep/nul.story"), LEADS_OUT),
    "turned around": (named("a\u202eb.story"), LEADS_OUT),
    "space at the end": (named("a /b.story"), LEADS_OUT),
    "empty name": (named(""), "no file's name"),
    "long name": (named("x" * 5000), "no file's name"),
    "no name": (record("file", 3), "no file's name"),
    "world is a way": (record("world", "../../x", "secret.story"), LEADS_OUT),
    "world is absolute": (record("world", "/tmp/x", "secret.story"), LEADS_OUT),
    "world is a device": (record("world", "a/CON.world", "secret.story"), LEADS_OUT),
    "types": (manifest("patterns", {"a": 1}), "patterns is not a list"),
    "texts": (manifest("made_with", 3), "made_with is not a text"),
    "null": (record("imports", None), "outside[0].imports is not a record"),
    "more": (manifest("code", "import os"), "has an unknown `code`"),
    "more of a file": (record("code", "import os"), "has an unknown `code`"),
    "less": (lambda forgery: forgery.manifest.pop("standard"), "has no `standard`"),
    "standard": (manifest("standard", ["\ud800"]), "standard[0] is no name"),
    "no UTF-8": (lambda forgery: forgery.files.update({COMMON: b"\xff"}), "hash that is stated"),
}  # fmt: skip


@pytest.mark.parametrize("case", FORGED)
def test_forged(good: bytes, path: Path, case: str) -> None:
    apply, message = FORGED[case]
    forgery = Forgery(good)
    apply(forgery)
    path.write_bytes(forgery.zipped())
    found = said(path)
    assert found.startswith("the library is damaged: ")
    assert message in found
    assert [p.name for p in path.parent.iterdir()] == ["moods.i2plib"]


def test_circles(good: bytes, path: Path) -> None:
    forgery = Forgery(good)
    forgery.text(COMMON, 'import "a"\nlet slowness = 1\n')
    forgery.record(COMMON)["imports"] = {"a": [TURNS]}
    path.write_bytes(forgery.zipped())
    assert "the imports go in a circle" in said(path)
    forgery = Forgery(good)
    forgery.text(COMMON, "pattern slow_depict(event) = slowness\nlet slowness = slow_depict(1)\n")
    path.write_bytes(forgery.zipped())
    text = "world kitchen\nlength 3\nimport moods\nmaximize slow_depict(rho > 0)\n"
    with pytest.raises(StoryError, match="is defined by itself"):
        check_source(Source(str(path.parent / "s.story"), text), find_vocabulary, path.parent)


def test_a_chain_of_imports_as_long_as_a_library(good: bytes, path: Path) -> None:
    forgery = Forgery(good)
    for number in range(450):
        before = f"n{number - 1}.story" if number else COMMON
        pattern = f'import "before"\npattern n{number}(e) = slow_depict(e)\n'
        forgery.add("outside", f"n{number}.story", pattern, imports={"before": [before]})
    forgery.record(TURNS)["imports"]["../../common.story"] = ["n449.story"]
    path.write_bytes(forgery.zipped())
    assert {"n0", "n449"} <= read_library(path).exports.names.keys()
    forgery.record(COMMON)["imports"] = {f"x{i}": ["n0.story"] * 100 for i in range(5)}
    path.write_bytes(forgery.zipped())
    assert "files of patterns, at most 500 are read" in said(path)
    forgery = Forgery(good)
    forgery.record("secret.story")["imports"] = {"moods": ["moods.story"] * 30_000}
    path.write_bytes(forgery.zipped())
    assert "30,000 files that stories import, at most 20,000 are read" in said(path)


def test_a_standard_pattern_that_this_version_has_not(good: bytes, path: Path) -> None:
    forgery = Forgery(good)
    forgery.manifest |= {"made_with": "i2pdsl 9.0", "standard": ["later", "twist"]}
    path.write_bytes(forgery.zipped())
    assert said(path) == (
        "made with i2pdsl 9.0: it uses the standard pattern `later`, which this version has not"
    )


def test_much_of_everything_is_bounded(
    good: bytes, path: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As large as is allowed, and as hard to follow: chains, doubling, long lists."""
    if not FULL:  # the bound is reached with less work
        monkeypatch.setattr(fits, "MOST_WORK", fits.MOST_WORK // 4)

    def listed(source: str, most: float) -> str:
        forgery = Forgery(good)
        forgery.text(COMMON, "let slowness = 1\n")
        forgery.text("moods.story", source)
        path.write_bytes(forgery.zipped())
        began = time.process_time()
        done = i2p("patterns", path)
        assert time.process_time() - began < most
        return done.out + done.err

    chain = ["pattern p0(e) = depict(e)"]
    chain += [f"pattern p{i}(e) = p{i - 1}(e) + p{i // 2}(e)" for i in range(1, 900)]
    out = listed("\n".join(chain), 40)
    assert "which worlds they fit: not tried, since the patterns grow to more than 500,000" in out
    worlds = ", ".join(builtin_worlds())
    assert f"\np1(e)\n    e: event\n    fits {worlds}\n" in out
    assert "\np5(e)\n    e: event\n    fits no world that is known here; other worlds" in out
    for text in ("let x{0} = {0}\n", "import x{0}\n", "nothing{0} at all\n"):
        assert "too large: " in listed("".join(text.format(i) for i in range(10_000)), 3)
    assert "p(x)" in listed("pattern p(x) = x" + " + x" * 45_000, 20)


def survives(data: bytes, path: Path) -> None:
    path.write_bytes(data)
    with suppress(StoryError):
        read_library(path)
    story = Source(str(path.parent / "s.story"), "world kitchen\nlength 3\nimport moods\n"
                   "maximize dark(rho > 0)\n")  # fmt: skip
    with suppress(StoryError):
        check_source(story, find_vocabulary, path.parent)


@SETTINGS
@given(st.data())
def test_any_bytes_changed(good: bytes, tmp_path: Path, data: st.DataObject) -> None:
    """Most of them where zip keeps its directory, at the end."""
    changed = bytearray(good)
    for _ in range(data.draw(st.integers(1, 4))):
        whole = data.draw(st.booleans())
        at = data.draw(st.integers(0 if whole else good.index(b"PK\x01\x02"), len(good) - 1))
        changed[at] = data.draw(st.integers(0, 255))
    survives(bytes(changed), tmp_path / "moods.i2plib")


@SETTINGS
@given(st.data())
def test_any_piece_cut_out_or_put_twice(good: bytes, tmp_path: Path, data: st.DataObject) -> None:
    first, last = sorted(data.draw(st.integers(0, len(good))) for _ in range(2))
    piece = data.draw(st.sampled_from([b"", 2 * good[first:last]]))
    survives(good[:first] + piece + good[last:], tmp_path / "moods.i2plib")


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=20),
    lambda x: st.lists(x, max_size=3) | st.dictionaries(st.text(max_size=8), x, max_size=3),
    max_leaves=6,
)  # fmt: skip
STORY_TEXT = st.sampled_from(
    [
        "", "pattern dark(e) = dark(e)", "let middle = middle", "import moods", "import twist",
        "pattern dark(rho) = rho", "pattern p(x = y, y = x) = x", "pattern sin(x) = x",
        "maximize 1",
        "pattern dark(event, share = 0.8) =\n    sum_t P(event | script[:t])", "let T = 1", "# x",
        "pattern p(a, a) = 1", "pattern p = p2\npattern p2 = p3\npattern p3 = p", "(" * 300,
    ]
)  # fmt: skip


def places(value: Any, here: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The ways to all values in a document."""
    items: list[tuple[Any, Any]] = []
    if isinstance(value, dict):
        items = list(value.items())
    elif isinstance(value, list):
        items = list(enumerate(value))
    return [here, *(p for k, v in items for p in places(v, (*here, k)))]


@SETTINGS
@given(st.data())
def test_any_value_replaced_with_a_right_hash(
    good: bytes, tmp_path: Path, data: st.DataObject
) -> None:
    forgery = Forgery(good)
    for name in sorted(forgery.files):
        if data.draw(st.integers(0, 2)) == 0:
            forgery.text(name, data.draw(STORY_TEXT))
    for _ in range(data.draw(st.integers(0, 2))):
        way = data.draw(st.sampled_from(places(forgery.manifest)[1:]))
        inner: Any = forgery.manifest
        for step in way[:-1]:
            inner = inner[step]
        inner[way[-1]] = data.draw(JSON | STORY_TEXT)
    survives(forgery.zipped(), tmp_path / "moods.i2plib")
