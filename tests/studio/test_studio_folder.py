"""The studio's folder: no path leads out of it, and nothing is written over what changed."""

from __future__ import annotations

import base64
import io
import os
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from i2pdsl.studio.folder import Folder, digest_of
from i2pdsl.studio.made import Films, Made
from i2pdsl.studio.protocol import CONFLICT, FILE, REFUSED, Refusal

OUT = (
    "../secret.story",
    "/etc/passwd",
    "sub/../../secret.story",
    "sub/..",
    ".",
    "..",
    "",
    "sub//a.story",
    "a\x00.story",
    "C:\\secret.story",
    "sub\\..\\secret.story",
    ".hidden.story",
    ".git/config.story",
    "\u2024\u2024/secret.story",
    "NUL.story",
    "x" * 300 + ".story",
    "/".join("abcdefghij") + "/a.story",
)
CAT = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"><title>x</title>'
    '<circle cx="5" cy="5" r="4" fill="#123456"/></svg>'
)


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    (tmp_path / "secret.story").write_text("secret")
    inside = tmp_path / "stories"
    (inside / "sub").mkdir(parents=True)
    (inside / "a.story").write_text("# One.\n# Two.\nworld a\n")
    (inside / ".hidden.story").write_text("x")
    (inside / "sub" / "b.world").write_text("map\n")
    (inside / "notes.txt").write_text("x")
    return Folder(inside)


def kind_of(problem: pytest.ExceptionInfo[Refusal]) -> str:
    return problem.value.kind


@pytest.mark.parametrize("path", OUT)
def test_paths_out_of_the_folder(folder: Folder, path: str) -> None:
    for act in (
        lambda: folder.read(path),
        lambda: folder.save(path, "x", None),
        lambda: folder.put_picture(path, CAT.encode()),
    ):
        with pytest.raises(Refusal) as problem:
            act()
        assert kind_of(problem) in (REFUSED, FILE)
    assert (folder.root.parent / "secret.story").read_text() == "secret"


def test_links_out_of_the_folder(folder: Folder) -> None:
    (folder.root / "link.story").symlink_to(folder.root.parent / "secret.story")
    (folder.root / "way").symlink_to(folder.root.parent)
    (folder.root / "own.story").symlink_to(folder.root / "a.story")
    for path in ("link.story", "way/secret.story", "way/new.story"):
        with pytest.raises(Refusal):
            folder.read(path)
        with pytest.raises(Refusal):
            folder.save(path, "changed", digest_of(b"secret"))
    assert (folder.root.parent / "secret.story").read_text() == "secret"
    assert not (folder.root.parent / "new.story").exists()
    assert folder.read("own.story") == folder.read("a.story")
    assert [seen.path for seen in folder.files()] == ["a.story", "own.story", "sub/b.world"]


def test_uris(folder: Folder) -> None:
    assert folder.path_of(folder.uri("sub/b.world")) == "sub/b.world"
    root = folder.root.as_uri()
    for uri in (
        "https://a.example/b",
        "file://a.example/x",
        "untitled:1",
        f"{folder.root.parent.as_uri()}/secret.story",
        f"{root}/../secret.story",
        f"{root}/%2e%2e/secret.story",
        f"{root}/.hidden.story",
        root,
    ):
        with pytest.raises(Refusal):
            folder.path_of(uri)


def test_what_is_listed(folder: Folder) -> None:
    seen = folder.files()
    assert [(each.path, each.kind) for each in seen] == [
        ("a.story", "story"),
        ("sub/b.world", "world"),
    ]
    assert folder.about(seen[0]) == "One. Two."


def test_saving(folder: Folder) -> None:
    text, digest = folder.read("a.story")
    newer = folder.save("a.story", text + "length 3\n", digest)
    assert folder.read("a.story") == (text + "length 3\n", newer)
    # Whoever comes later, with what was there before, is told what is there now.
    with pytest.raises(Refusal) as problem:
        folder.save("a.story", "mine", digest)
    assert kind_of(problem) == CONFLICT
    assert problem.value.data == {"text": text + "length 3\n", "digest": newer}
    # The same text is no conflict.
    assert folder.save("a.story", text + "length 3\n", digest) == newer
    with pytest.raises(Refusal) as problem:
        folder.save("a.story", "mine", None)
    assert kind_of(problem) == CONFLICT
    (folder.root / "a.story").unlink()
    with pytest.raises(Refusal) as problem:
        folder.save("a.story", "mine", newer)
    assert problem.value.data == {"text": None, "digest": None}
    folder.save("a.story", "mine", None)
    assert folder.read("a.story")[0] == "mine"
    assert not list(folder.root.glob(".i2p-new-*"))


def test_only_one_of_many_saves_at_once(folder: Folder) -> None:
    _, digest = folder.read("a.story")
    won, lost = [], []

    def save(number: int) -> None:
        try:
            won.append((number, folder.save("a.story", f"text {number}\n", digest)))
        except Refusal:
            lost.append(number)

    threads = [threading.Thread(target=save, args=(n,)) for n in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    ((number, kept),) = won
    assert len(lost) == 7
    assert folder.read("a.story") == (f"text {number}\n", kept)


def test_texts_of_other_machines(folder: Folder) -> None:
    (folder.root / "dos.story").write_bytes(b"\xef\xbb\xbfworld a\r\nlength 3\r\n")
    text, digest = folder.read("dos.story")
    assert text == "world a\nlength 3\n"
    folder.save("dos.story", text + "#\n", digest)
    (folder.root / "bad.story").write_bytes(b"world \xff")
    with pytest.raises(Refusal):
        folder.read("bad.story")
    os.mkfifo(folder.root / "pipe.story")
    with pytest.raises(Refusal):
        folder.read("pipe.story")
    with pytest.raises(Refusal):
        folder.save("large.story", "x" * 3_000_000, None)
    with pytest.raises(Refusal):
        folder.save("program.py", "x", None)


def test_pictures(folder: Folder) -> None:
    folder.put_picture("cat.svg", CAT.encode())
    kept = (folder.root / "cat.svg").read_text()
    assert "circle" in kept
    assert "title" not in kept
    folder.put_picture("cat.svg", CAT.encode())  # the same again
    with pytest.raises(Refusal):
        folder.put_picture("cat.svg", CAT.replace("5", "6").encode())


@pytest.mark.parametrize(
    "inside",
    [
        "<script>alert(1)</script>",
        '<image href="https://a.example/x.png"/>',
        '<rect onload="alert(1)" width="1" height="1"/>',
        '<rect fill="url(https://a.example/x)" width="1" height="1"/>',
        "<style>@import url(https://a.example/x.css)</style>",
        '<foreignObject><p xmlns="http://www.w3.org/1999/xhtml">x</p></foreignObject>',
        '<use href="https://a.example/x.svg#a"/>',
    ],
)
def test_pictures_that_do_something(folder: Folder, inside: str) -> None:
    with pytest.raises(Refusal):
        folder.put_picture("cat.svg", CAT.replace("<circle", f"{inside}<circle").encode())
    assert not (folder.root / "cat.svg").exists()


def test_pictures_that_are_none(folder: Folder) -> None:
    from PIL import Image

    made = io.BytesIO()
    Image.new("RGBA", (600, 300), "red").save(made, "PNG")
    folder.put_picture("large.png", made.getvalue())
    with Image.open(folder.root / "large.png") as kept:
        assert kept.size == (256, 128)
    for name, data in (
        ("x.png", b"\x89PNG but no more"),
        ("x.svg", b"<html></html>"),
        ("x.svg", b"<svg>" + b" " * 300_000),
        ("x.gif", b"GIF89a"),
        ("x.png", base64.b64encode(made.getvalue())),
    ):
        with pytest.raises(Refusal):
            folder.put_picture(name, data)
    assert [seen.path for seen in folder.files() if seen.kind == "sprite"] == ["large.png"]


def test_films_at_hand() -> None:
    """The last ones, and none that keep worlds in memory which nobody is in any more."""
    films = Films()
    made = lambda world: Made(
        films.name(), "a", 1, 0, "best", SimpleNamespace(), SimpleNamespace(world=world)
    )
    kept = [made(world) for world in [KITCHEN] * 80 + [MAZE] * 3]
    for film in kept:
        films.keep(film)
    assert films[kept[-1].name] is kept[-1]
    assert films[kept[60].name] is kept[60]
    films.keep(made(object()))
    assert films[kept[-1].name] is kept[-1]  # of the maze
    for gone in (kept[0], kept[79]):
        with pytest.raises(Refusal):
            films[gone.name]
    assert len({film.name for film in kept}) == len(kept)


KITCHEN, MAZE = object(), object()
