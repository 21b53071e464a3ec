"""Libraries that are damaged, forged, cut or of a later version: an error that names the file and
says what is wrong, soon; never anything else."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from libraries_for_tests import copied, files_of, forge, make_folder

from i2pdsl.errors import Source, StoryError
from i2pdsl.language.check import check_source
from i2pdsl.library.document import LARGEST, content_hash, encode
from i2pdsl.library.pack import pack
from i2pdsl.library.read import read_library
from i2pdsl.worlds.find import find_vocabulary

SETTINGS = settings(
    derandomize=True,
    max_examples=150,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
Document = dict[str, Any]


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Document:
    folder = make_folder(tmp_path_factory.mktemp("good"))
    return pack(folder, files_of(folder), "moods").library.document


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


def test_what_was_packed_is_read(good: Document, path: Path) -> None:
    path.write_text(encode(good), encoding="utf-8")
    library = read_library(path)
    assert library.document == good
    assert set(library.exports.names) == {
        "after", "both", "dark", "middle", "pink_mind", "slow_depict", "slowness",
    }  # fmt: skip
    assert read_library(path) is library, "it is read once"


def test_a_file_that_has_changed_is_read_again(good: Document, path: Path) -> None:
    path.write_text(encode(good), encoding="utf-8")
    first = read_library(path)
    path.write_text("{}", encoding="utf-8")
    assert "not a compiled library" in said(path)
    forge(good, path)
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
        (b"\xff\xfe\x00", "byte 0 is not UTF-8"),
        (b"world kitchen\n", "no JSON from line 1"),
        (b"[]", "not a compiled library"),
        (b"null", "not a compiled library"),
        (b'{"format": "i2p-script", "version": 1}', "not a compiled library"),
        (b'{"format": "i2p-library"}', "version is no number"),
        (b'{"format": "i2p-library", "version": true}', "version is no number"),
        (b'{"format": "i2p-library", "version": "1"}', "version is no number"),
        (b'{"format": "i2p-library", "version": 0}', "version is no number"),
        (b'{"format": "i2p-library", "version": 1}', "has no `name`"),
        (b'{"format": "i2p-library", "version": 1, "version": 1}', "is not its JSON"),
        (b'{"format": "i2p-library", "version": 1, "x": NaN}', "is not its JSON"),
        (b'{"format": "i2p-library", "version": 1, "x": ' + b"9" * 9999 + b"}", "is not its JSON"),
        (b'{"format": "i2p-library", "version": 1, "x": "\\ud800"}', "half a character"),
        (b"[" * 100_000, "nested too deep"),
        (b"{" + b'"a":{' * 5000, "nested too deep"),
        (b'{"a": "' + b'\\"' * 1_000_000, "no JSON"),
        (b'"' + b"[" * 100_000 + b'"', "not a compiled library"),
    ],
)
def test_no_library(path: Path, data: bytes, message: str) -> None:
    path.write_bytes(data)
    assert message in said(path)


def test_a_later_version(good: Document, path: Path) -> None:
    later = {**good, "version": 2, "something": "new"}
    path.write_text(encode(later), encoding="utf-8")
    assert said(path) == ("made by a later version of i2pdsl (format 2); this one reads format 1")
    path.write_text('{"format": "i2p-library", "version": 7}', encoding="utf-8")
    assert "format 7" in said(path)


def test_a_file_that_is_too_large(path: Path) -> None:
    path.write_bytes(b" " * (LARGEST + 1))
    began = time.process_time()
    assert "too large" in said(path)
    assert time.process_time() - began < 1


def test_a_cut_file(good: Document, path: Path) -> None:
    text = encode(good)
    for end in range(0, len(text) - 2, 97):
        path.write_text(text[:end], encoding="utf-8")
        assert "damaged" in said(path) or end == 0


def test_a_changed_byte_is_noticed(good: Document, path: Path) -> None:
    text = encode(good).replace("sum_t slowness", "sum_t slowmess")
    path.write_text(text, encoding="utf-8")
    assert "does not have the hash" in said(path)


def change(key: str, value: object, *place: str | int) -> Callable[[Document], None]:
    def apply(document: Document) -> None:
        inner: Any = document
        for step in place:
            inner = inner[step]
        inner[key] = value

    return apply


def without(name: str) -> Callable[[Document], None]:
    def apply(document: Document) -> None:
        document["patterns"] = [p for p in document["patterns"] if p["name"] != name]

    return apply


def swap_order(document: Document) -> None:
    document["patterns"].reverse()


FORGED = {
    "signature": (change("signature", "dark(x)", "patterns", 2), "`signature` of `dark`"),
    "body": (change("body", "1", "patterns", 2), "`body` of `dark`"),
    "documentation": (change("documentation", "x", "patterns", 2), "`documentation` of `dark`"),
    "line": (change("line", 7, "patterns", 2), "`line` of `dark`"),
    "kind": (change("kind", "script", "patterns", 2, "parameters", 0), "`parameters` of `dark`"),
    "default": (change("default", "9", "patterns", 2, "parameters", 1), "`parameters` of `dark`"),
    "result": (change("result", "event", "patterns", 2), "`result` of `dark`"),
    "uses": (change("uses", {"dark": "standard"}, "patterns", 3), "`uses` of `both`"),
    "needs": (change("names_of_worlds", [], "patterns", 1), "`names_of_worlds` of `pink_mind`"),
    "let": (change("body", "9", "lets", 0), "`body` of `middle`"),
    "name": (change("name", "other", "patterns", 2), "patterns are not those of its sources"),
    "missing pattern": (without("dark"), "patterns are not those of its sources"),
    "order": (swap_order, "patterns are not those of its sources"),
    "source": (change("source", "let x = 1\n", "files", 2), "disagree"),
    "imports": (change("imports", {}, "files", 0), "imports of deep/turns.story are not those"),
    "import to nowhere": (
        change("twist", ["none.story"], "files", 0, "imports"),
        "the import `twist` leads to no file",
    ),
    "import is a word": (change("twist", "elsewhere", "files", 0, "imports"), "leads to no file"),
    "statement": (
        change("source", "world kitchen\n", "files", 2),
        "outside/common.story:1:1: a library has no `world`",
    ),
    "syntax": (change("source", "pattern (\n", "files", 2), "outside/common.story:1:9"),
    "control characters": (change("source", "let x\x00 = 1", "files", 2), "not text"),
    "dots": (change("name", "../x.story", "files", 2), "leads out of the library"),
    "absolute": (change("name", "/etc/passwd", "files", 2), "leads out of the library"),
    "drive": (change("name", "C:\\x.story", "files", 2), "leads out of the library"),
    "device": (change("name", "deep/nul.story", "files", 2), "leads out of the library"),
    "turned around": (change("name", "a\u202eb.story", "files", 2), "leads out of the library"),
    "space at the end": (change("name", "a /b.story", "files", 2), "leads out of the library"),
    "library is a way": (change("name", "../../moods"), "name cannot be that of a file"),
    "library is absolute": (change("name", "/tmp/moods"), "name cannot be that of a file"),
    "library has no name": (change("name", ""), "name cannot be that of a file"),
    "library with NUL": (change("name", "a\0b"), "name cannot be that of a file"),
    "library is here": (change("name", "."), "name cannot be that of a file"),
    "library is a device": (change("name", "CON"), "name cannot be that of a file"),
    "library of a long name": (change("name", "x" * 5000), "name cannot be that of a file"),
    "group": (change("group", "../outside", "files", 2), "leads out of the library"),
    "world is a way": (
        change("worlds", [{"name": "../../x", "file": "x.world", "source": ""}]),
        "worlds[0].name leads out of the library",
    ),
    "world is absolute": (
        change("worlds", [{"name": "/tmp/x", "file": "x.world", "source": ""}]),
        "worlds[0].name leads out of the library",
    ),
    "world is a device": (
        change("worlds", [{"name": "a/CON.world", "file": "x.world", "source": ""}]),
        "worlds[0].name leads out of the library",
    ),
    "world of a story": (change("world", "x/../../y", "stories", 0), "stories[0].world leads out"),
    "world of an example": (
        change("examples", [{"file": "a", "world": "x/../y", "call": ""}], "patterns", 2),
        "patterns[2].examples[0].world leads out",
    ),
    "proof": (
        change("worlds", {"../x": {"fits": True, "with": "dark"}}, "patterns", 2),
        "a key of patterns[2].worlds leads out",
    ),
    "empty name": (change("name", "", "files", 2), "no file's name"),
    "two of one name": (change("name", "moods.story", "files", 2), "two of its files"),
    "long line": (change("line", 10**12, "patterns", 2), "no number from 1 on"),
    "true for a number": (change("line", True, "patterns", 2), "no number from 1 on"),
    "types": (change("patterns", {"a": 1}), "patterns is not a list"),
    "texts": (change("name", 3, "files", 0), "no file's name"),
    "null": (change("documentation", None, "patterns", 2), "is not a text"),
    "more": (change("code", "import os", "patterns", 2), "has an unknown `code`"),
    "fits": (change("kitchen", {"fits": "yes"}, "patterns", 2, "worlds"), "damaged"),
}


@pytest.mark.parametrize("case", FORGED)
def test_forged(good: Document, path: Path, case: str) -> None:
    """With the hash that its content has."""
    apply, message = FORGED[case]
    names = [p["name"] for p in good["patterns"]]
    assert names == ["after", "pink_mind", "dark", "both", "slow_depict"]
    document = copied(good)
    apply(document)
    forge(document, path)
    assert message in said(path)


def test_circles(good: Document, path: Path) -> None:
    document = copied(good)
    document["files"][2]["source"] = 'import "a"\nlet slowness = 1\n'
    document["files"][2]["imports"] = {"a": ["deep/turns.story"]}
    forge(document, path)
    assert "the imports go in a circle" in said(path)
    document = copied(good)
    document["files"][2]["source"] = (
        "pattern slow_depict(event) = slowness\nlet slowness = slow_depict(1)\n"
    )
    forge(document, path)
    assert "is defined by itself" in said(path)


def test_another_version_may_see_patterns_otherwise(good: Document, path: Path) -> None:
    """What was inferred by an older i2pdsl is inferred anew; what is text must still agree."""
    document = copied(good)
    document["made_with"] = "i2pdsl 0.0.1"
    document["patterns"][2]["parameters"][0]["kind"] = "mood"
    forge(document, path)
    assert read_library(path).document["patterns"][2]["parameters"][0]["kind"] == "event"
    document["patterns"][2]["body"] = "1"
    forge(document, path)
    assert "`body` of `dark`" in said(path)


def test_a_standard_pattern_that_this_version_has_not(good: Document, path: Path) -> None:
    document = copied(good)
    document["made_with"] = "i2pdsl 9.0"
    document["patterns"][2]["uses"] = {"later": "standard"}
    forge(document, path)
    assert said(path) == (
        "made with i2pdsl 9.0: it uses the standard pattern `later`, which this version has not"
    )


def test_much_of_everything_is_bounded(good: Document, path: Path) -> None:
    """As large as is allowed, and as hard to follow: chains, doubling, long lists."""
    chain = ["pattern p0(e) = depict(e)"]
    chain += [f"pattern p{i}(e) = p{i - 1}(e) + p{i // 2}(e)" for i in range(1, 900)]
    document = copied(good)
    document["files"] = [{**good["files"][1], "source": "\n".join(chain), "imports": {}}]
    forge(document, path)
    began = time.process_time()
    assert "disagree" in said(path)
    assert time.process_time() - began < 10
    for text in ("let x{0} = {0}\n", "import x{0}\n", "nothing{0} at all\n"):
        document["files"][0]["source"] = "".join(text.format(i) for i in range(10_000))
        forge(document, path)
        began = time.process_time()
        assert "too large: " in said(path)
        assert time.process_time() - began < 3
    document["files"][0]["source"] = "pattern p(x) = x" + " + x" * 45_000
    forge(document, path)
    began = time.process_time()
    assert "disagree" in said(path)
    assert time.process_time() - began < 20


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
def test_any_bytes_changed(good: Document, tmp_path: Path, data: st.DataObject) -> None:
    text = bytearray(encode(good).encode("utf-8"))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at] = data.draw(st.integers(0, 255))
    survives(bytes(text), tmp_path / "moods.i2plib")


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
    good: Document, tmp_path: Path, data: st.DataObject
) -> None:
    document = copied(good)
    for _ in range(data.draw(st.integers(1, 3))):
        way = data.draw(st.sampled_from(places(document)[1:]))
        inner: Any = document
        for step in way[:-1]:
            inner = inner[step]
        value = data.draw(STORY_TEXT if way[-1] == "source" else JSON | STORY_TEXT)
        inner[way[-1]] = value
        if not isinstance(document.get("files"), list):
            break
    with suppress(UnicodeEncodeError):
        document["hash"] = content_hash(document)
    survives(json.dumps(document).encode("utf-8"), tmp_path / "moods.i2plib")
