"""The cookbook keeps what it promises: each entry's story tells what it expects of itself, and has
its picture.

`python tests/test_cookbook.py` makes all pictures and the table of prices anew, with names only
those: `python tests/test_cookbook.py kind sheet prices`.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import pytest
from PIL import Image

from documents_for_tests import TYPED, Block, blocks
from i2pdsl.stories import load
from stories_for_tests import check, expectations

ROOT = Path(__file__).parent.parent
BOOK = ROOT / "docs" / "cookbook.md"
PICTURES = ROOT / "docs" / "pictures" / "cookbook"
IMAGE = re.compile(r"^!\[[^]]+\]\(pictures/cookbook/([\w-]+)\.png\)$", re.MULTILINE)
PRICES = re.compile(r"(<!-- measured: prices -->\n).*?(<!-- end -->)", re.DOTALL)
ASKED = (0.0, 0.02, 0.1, 0.3, 1.0)
MOST = 1_500_000  # bytes of all pictures
QUICK = ("legible", "beetle")  # stories that take a second


@dataclass(frozen=True)
class Entry:
    """One `### I want ...`: its blocks, and the name of its picture."""

    title: str
    blocks: list[Block]
    picture: str

    @property
    def maker(self) -> Block:
        """What the picture is made with: a block that says so, else the story."""
        said = [b for b in self.blocks if b.option("picture")]
        return (said or [b for b in self.blocks if b.words[0] == "story"])[0]


def entries() -> list[Entry]:
    found = []
    for part in re.split(r"^### ", BOOK.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]:
        text = re.split(r"^## ", part, flags=re.MULTILINE)[0]
        (picture,) = IMAGE.findall(text)
        found.append(Entry(text.partition("\n")[0], blocks(text), picture))
    return found


ENTRIES = entries()
STORIES = [b.option("file") for e in ENTRIES for b in e.blocks if b.words[0] == "story"]


def unpacked(folder: Path) -> Path:
    """A folder with all files of the book."""
    for block in blocks(BOOK.read_text(encoding="utf-8")):
        name = block.option("file")
        if name is not None:
            (folder / name).write_text(block.text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return unpacked(tmp_path_factory.mktemp("cookbook"))


def test_all_wants_have_their_pictures() -> None:
    assert len(ENTRIES) == 22
    assert all(entry.title.startswith("I want ") for entry in ENTRIES)
    names = [entry.picture for entry in ENTRIES]
    files = sorted(PICTURES.iterdir())
    assert sorted(names) == [file.stem for file in files]
    assert sum(file.stat().st_size for file in files) <= MOST
    for file in files:
        with Image.open(file) as picture:
            assert 240 <= picture.width <= 900
            assert len(picture.convert("RGB").getcolors(256) or ()) > 4


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=() if Path(n).stem in QUICK else pytest.mark.slow)
        for n in STORIES
        if n is not None
    ],
)
def test_entry_tells_what_it_expects(name: str, kept: Path) -> None:
    assert expectations(kept / name)
    check(kept / name, range(1))


def test_stories_are_right_and_expect_something(kept: Path) -> None:
    for name in STORIES:
        assert name is not None
        assert load(kept / name).warnings == ()
        assert expectations(kept / name), name


# The pictures.


def make(names: list[str]) -> None:
    """Makes pictures anew: all, or those of these names."""
    from i2pdsl.library.thumbnails import write_small

    wanted = [e for e in ENTRIES if not names or e.picture in names]
    os.chdir(unpacked(Path(tempfile.mkdtemp())))
    for entry in wanted:
        made = picture_of(entry.maker)
        with Image.open(made) as picture:
            picture.seek(getattr(picture, "n_frames", 1) * 2 // 5)  # of a film, one amid it
            write_small(picture, PICTURES / f"{entry.picture}.png")
        print(entry.picture, Path.cwd(), flush=True)
    if not names or "prices" in names:
        told = PRICES.sub(rf"\g<1>{prices()}\g<2>", BOOK.read_text(encoding="utf-8"))
        BOOK.write_text(told, encoding="utf-8")


def picture_of(maker: Block) -> Path:
    """Runs a block until its picture is there."""
    if maker.words[0] == "story":
        return solved(Path(str(maker.option("file"))).stem) / "comic.png"
    made = Path(str(maker.option("picture")))
    if made.parent.parent == Path("out"):
        solved(made.parent.name)
    lines = maker.text.splitlines()
    while not made.exists():
        line = lines.pop(0)
        if line.startswith(TYPED):
            run_line(line.removeprefix(TYPED))
        else:
            run_command(line)
    return made


def run_command(line: str) -> None:
    import shlex

    from i2pdsl import cli

    assert cli.run_command(shlex.split(line)[1:]) == cli.DONE, line


def run_line(line: str) -> None:
    reply = SESSION.run(line)
    assert not reply.diagnostics, line


def solved(name: str) -> Path:
    """The folder `out/NAME` with a story's script and pictures."""
    from i2pdsl.render.pictures import pictures_of

    folder = Path("out", name)
    if not folder.exists():
        script = load(f"{name}.story").solve().script
        script.save(folder / "script.json")
        for _ in pictures_of([script], name).drawn(folder, ("png",)):
            pass
        for asked in expectations(Path(f"{name}.story")):
            if asked.expression != "still":
                print(f"  {asked.expression}: {script.query(asked.expression, asked.assume):.3f}")
        print(f"  {name}: still {script.still:.2f}")
    return folder


def prices() -> str:
    """What several.story becomes at other prices."""
    text = Path("several.story").read_text(encoding="utf-8")
    titles = (
        "price of a frame",
        "frames side by side, of 10",
        "mean belief in help",
        "other points",
    )
    rows = [f"| {' | '.join(titles)} |", f"|{'---|' * len(titles)}"]
    for price in ASKED:
        told = re.sub(r"^minimize .*\n", "", text, flags=re.MULTILINE)
        Path("priced.story").write_text(told.replace("0.3 *", f"{price:g} *"), encoding="utf-8")
        script = load("priced.story").solve().script
        near = script.query("sum_t [touching(dog, duck) @ script[t]]")
        belief = script.query("mean_t P(rho > 0 | script[:t])")
        assert script.score is not None
        rest = script.score - price * near
        rows.append(f"| {price:g} | {near:.0f} | {belief:.4f} | {rest:.2f} |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    from i2pdsl.repl.session import Session

    SESSION = Session()
    make(sys.argv[1:])
