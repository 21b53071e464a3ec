"""Imports run one way: no module imports what imports it, and no room what stands above it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "i2pdsl"
FILES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for path in PACKAGE.rglob("*.py")
}


def imported(path: Path) -> Iterator[str]:
    """The modules of ours that a module imports anywhere, but for the names of types alone."""
    waiting: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting += node.orelse
            continue
        waiting += ast.iter_child_nodes(node)
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in FILES)
        elif isinstance(node, ast.ImportFrom) and node.module in FILES:
            assert node.level == 0
            for alias in node.names:
                inside = f"{node.module}.{alias.name}"
                yield inside if inside in FILES else node.module


@cache
def graph() -> dict[str, set[str]]:
    """Which modules import which."""
    return {name: {m for m in imported(path) if m != name} for name, path in FILES.items()}


# From below to above; what is not listed stands beside the room that it is named after.
FLOORS = (
    ("errors", "forks", "interrupts", "sizes", "shown"),
    ("resources", "untrusted", "npz", "computing", "programs", "signed"),
    ("language", "planning"),
    ("worlds", "audience", "answers"),
    ("objective", "folders"),
    ("stored", "scripts", "questions", "tables", "explain"),
    ("search",),
    ("results", "sampling", "vouching", "keeping"),
    ("pipeline", "fit"),
    ("stories",),
    ("progress", "sweep"),
    ("render", "describe"),
    ("editor",),
    ("library", "study"),
    ("repl", "notebook", "output", "beginnings"),
    ("studio",),
    ("commands",),
    ("cli", "__main__"),
)
FLOOR = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}


def room_of(module: str) -> str:
    return module.split(".")[1]


def test_no_circles() -> None:
    try:
        tuple(TopologicalSorter(graph()).static_order())
    except CycleError as circle:
        pytest.fail(" -> ".join(reversed(circle.args[1])))


def test_every_room_has_its_floor() -> None:
    rooms = {room_of(name) for name in FILES if "." in name}
    assert rooms == set(FLOOR)


def test_imports_run_down() -> None:
    """Nothing low imports what shows it, or what stands upon it."""
    up = [
        f"{name} imports {other}"
        for name, others in sorted(graph().items())
        for other in sorted(others)
        if "." in name and "." in other and FLOOR[room_of(other)] > FLOOR[room_of(name)]
    ]
    assert up == []


def test_kinds_of_worlds_know_nothing_of_each_other() -> None:
    """A kind is its folder below worlds/ and its folder below render/; nobody else names one."""
    from i2pdsl.worlds.kinds import KINDS

    wrong = []
    for name, others in sorted(graph().items()):
        for kind in KINDS:
            own = (f"i2pdsl.worlds.{kind}", f"i2pdsl.render.{kind}")
            if not name.startswith(own):
                wrong += [f"{name} imports {other}" for other in others if other.startswith(own)]
    assert wrong == []


def test_nobody_asks_which_kind_a_world_is() -> None:
    classes = ("GridWorld", "HillWorld", "GridSpec", "HillSpec", "PlaneWorld", "PlaneSpec")
    asked = [
        f"{name}: {line.strip()}"
        for name, path in FILES.items()
        for line in path.read_text(encoding="utf-8").splitlines()
        if "isinstance(" in line and any(each in line for each in classes)
    ]
    assert asked == []


def test_no_search_is_asked_for_its_name() -> None:
    """What a search can do its entry in language/methods.py says, or it itself."""
    from i2pdsl.language.methods import METHODS
    from i2pdsl.search.searches import SEARCHES

    assert list(METHODS) == list(SEARCHES)
    asked = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in FILES.values()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Compare)
        for part in (node.left, *node.comparators)
        if isinstance(part, ast.Constant) and part.value in METHODS
    ]
    assert asked == []
