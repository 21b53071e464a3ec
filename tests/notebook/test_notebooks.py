"""The notebooks of the documents run from top to bottom, and what is stored in them is true.

`python tests/notebook/test_notebooks.py` runs them and stores what comes out.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from copy import deepcopy
from pathlib import Path
from typing import Any, NamedTuple

import nbformat
import pytest

from fuzz_for_tests import FULL

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs").glob("*.ipynb"))
LARGEST = 1_000_000  # bytes: larger ones are slow to read on GitHub, or are not shown at all
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d*)?(?:e-?\d+)?(?![\w.])")
# Tags of cells that only `make test-all` runs: the searches of three more stories of the kitchen,
# with what is asked of them; and a story of the hill, whose numbers differ between machines, since
# a hopper is chaotic. What is left has each kind of cell.
LONG, VARIES = "long", "varies"
PLACES = ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR")


class Book(NamedTuple):
    """A notebook as it is stored, and cells of it as they are stored and as they come out now."""

    path: Path
    whole: Any
    stored: Any
    fresh: Any


def read(path: Path, whole: bool) -> Any:
    notebook = nbformat.read(path, as_version=4)
    if not whole:
        notebook.cells = [c for c in notebook.cells if not {LONG, VARIES} & set(tags(c))]
    return notebook


def tags(cell: Any) -> list[str]:
    found: list[str] = cell.metadata.get("tags", [])
    return found


def executed(path: Path, folder: Path, whole: bool) -> Any:
    """The notebook with what its cells show now; raises where a cell fails."""
    from nbclient import NotebookClient

    notebook = read(path, whole)
    settings = {name: str(folder / name) for name in PLACES}  # nobody's own
    client = NotebookClient(
        notebook,
        timeout=500,
        kernel_name="python3",
        record_timing=False,
        resources={"metadata": {"path": str(path.parent)}},
    )
    client.execute(env={**os.environ, **settings})
    return notebook


def code_cells(notebook: Any) -> list[Any]:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def words(cell: Any) -> str:
    """What the outputs of a cell say in words."""
    told = (o.get("text") or o.get("data", {}).get("text/plain", "") for o in cell.outputs)
    return "\n".join(told)


def kinds(cell: Any) -> list[set[str]]:
    """The forms in which each output of a cell shows itself."""
    return [set(output.get("data", {"text": ""})) for output in cell.outputs]


def storable(notebook: Any) -> Any:
    """Without players, which GitHub and an unrun notebook do not show: the comic strips stay."""
    notebook = deepcopy(notebook)
    notebook.metadata.language_info = {"name": "python"}
    for cell in code_cells(notebook):
        for output in cell.outputs:
            if "<iframe" in output.get("data", {}).get("text/html", ""):
                del output.data["text/html"]
    return notebook


@pytest.fixture(scope="module", params=NOTEBOOKS, ids=lambda path: path.stem)
def book(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Book:
    path = request.param
    folder = tmp_path_factory.mktemp("jupyter")
    return Book(path, read(path, True), read(path, FULL), executed(path, folder, FULL))


def test_there_is_a_notebook() -> None:
    assert [path.name for path in NOTEBOOKS] == ["from-question-to-figure.ipynb"]


def test_every_cell_runs(book: Book) -> None:
    """In order and without an error (nbclient raises for those), and nothing is complained of."""
    cells = code_cells(book.fresh)
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    for cell in cells:
        for output in cell.outputs:
            assert output.output_type != "error"
            assert output.get("name") != "stderr", output.text


def test_what_is_stored_comes_out_again(book: Book) -> None:
    fresh = code_cells(storable(book.fresh))
    for old, new in zip(code_cells(book.stored), fresh, strict=True):
        assert old.source == new.source
        assert kinds(old) == kinds(new), old.source
        if VARIES in tags(old):
            continue
        assert NUMBER.sub("0", words(old)).split() == NUMBER.sub("0", words(new)).split()
        numbers = [[float(x) for x in NUMBER.findall(words(cell))] for cell in (old, new)]
        # The last digits depend on where exactly planning stopped.
        assert numbers[1] == pytest.approx(numbers[0], rel=0.01, abs=0.002), old.source


def test_scripts_are_players_when_run(book: Book) -> None:
    """The naive script and those made by `%%story`."""
    shown = [output for cell in code_cells(book.fresh) for output in cell.outputs]
    html = [output.get("data", {}).get("text/html", "") for output in shown]
    assert sum("<iframe" in text for text in html) == (4 if FULL else 2)


def test_the_file_is_small_and_of_no_machine(book: Book) -> None:
    text = book.path.read_text(encoding="utf-8")
    assert len(text.encode()) < LARGEST
    nbformat.validate(book.whole)
    for place in (str(ROOT), str(Path.home()) + "/", tempfile.gettempdir() + "/", sys.executable):
        assert place not in text
    for cell in book.whole.cells:
        assert set(cell.metadata) <= {"tags"}
    assert set(book.whole.metadata) == {"kernelspec", "language_info"}
    assert set(book.whole.metadata.language_info) == {"name"}


def test_links_lead_somewhere(book: Book) -> None:
    for cell in book.whole.cells:
        if cell.cell_type == "markdown":
            for target in re.findall(r"\]\((?!https?:)([^)\s]+)\)", cell.source):
                assert (book.path.parent / target).is_file(), target


PLAIN = """
import i2pdsl
story = i2pdsl.load("stories/kitchen/help.story")
naive = story.solve(seed=0, naive=True).script
print(float(naive.query("P(rho > 0 | script[:T])")))
"""
SEARCHED = """
helping = story.solve(seed=0).script
print(float(helping.query("P(rho > 0 | script[:T])")))
print(float(helping.query("mean_t P(rho > 0 | script[:t])")))
"""


def test_the_numbers_are_those_of_a_plain_process(book: Book) -> None:
    code = PLAIN + (SEARCHED if FULL else "")  # which takes ten seconds
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True
    )
    naive, *searched = map(float, done.stdout.split())
    told = {cell.source: words(cell) for cell in code_cells(book.fresh)}
    if searched:
        end, average = searched
        (printed,) = (text for source, text in told.items() if source.startswith("print("))
        assert printed == f"at the end: {end:.4f}\non average: {average:.4f}\n"
    (curve,) = (text for source, text in told.items() if source.startswith("%query --of naive"))
    assert curve.splitlines()[-1].split() == ["15", f"{naive:.6g}"]
    assert naive == pytest.approx(2 / 3, abs=0.01)  # as the text says, and the paper's figure 1


def test_what_the_text_says_is_so(book: Book) -> None:
    told = {cell.source: words(cell) for cell in code_cells(book.fresh)}
    (what_if,) = (text for source, text in told.items() if "moves = [" in source)
    after = dict(re.findall(r"robot: (\w+) +([\d.]+)", what_if))  # where the cheese stays
    assert set(after) == {"stay", "north", "south", "east", "west"}
    assert min(map(float, after.values())) > 0.5  # still taken for a friend
    if not FULL:
        return
    (secret,) = (text for source, text in told.items() if source.startswith("%%query"))
    rows = [line.split() for line in secret.splitlines()[:16]]
    beliefs = [float(value) for _, value in rows]
    assert all(0.4 < p < 0.6 for p in beliefs[1:9])
    assert min(beliefs[9:]) > 0.85


if __name__ == "__main__":
    for notebook_path in NOTEBOOKS:
        with tempfile.TemporaryDirectory() as place:
            nbformat.write(storable(executed(notebook_path, Path(place), True)), notebook_path)
