"""Imports run one way: no module imports what imports it, and no room what stands above it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import NamedTuple

import pytest

from i2pdsl.worlds.kinds import KINDS

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "i2pdsl"
FILES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for path in PACKAGE.rglob("*.py")
}


class Said(NamedTuple):
    """What a module says: the modules of ours that it imports, its strings, of what it compares a
    `kind` or looks something up by it, the arguments that are a Spec, and its comparisons, each
    with the strings in it."""

    imports: set[str]
    strings: list[str]
    kinds_of: list[str]
    specs: set[str]
    compared: list[tuple[set[str], str]]


@cache  # to parse all modules takes seconds, and their trees much memory
def said(text: str) -> Said:
    tree = ast.parse(text)
    found = Said(set(imported(tree)), [], [], set(), [])
    for node in ast.walk(tree):
        match node:
            case ast.Constant(value=str(value)):
                found.strings.append(value)
            case ast.arg(annotation=ast.expr() as of) if re.search(r"\bSpec\b", ast.unparse(of)):
                found.specs.add(node.arg)
            case ast.Compare() | ast.MatchValue():
                values = (n.value for n in ast.walk(node) if isinstance(n, ast.Constant))
                strings = {value for value in values if isinstance(value, str)}
                if strings:
                    found.compared.append((strings, ast.unparse(node)))
        found.kinds_of.extend(
            ast.unparse(each.value)
            for asked in decided_by(node)
            for each in ast.walk(asked)
            if isinstance(each, ast.Attribute) and each.attr == "kind"
        )
    return found


def decided_by(node: ast.AST) -> list[ast.expr]:
    """What a comparison, a choice or a look-up depends on."""
    match node:
        case ast.Compare():
            return [node.left, *node.comparators]
        case ast.Match():
            return [node.subject]
        case ast.Subscript():
            return [node.slice]
        case ast.Call(func=ast.Attribute()):  # `names.get(spec.kind)`
            return node.args
    return []


def imported(tree: ast.AST) -> Iterator[str]:
    """The modules of ours that a module imports anywhere, but for the names of types alone."""
    waiting = [tree]
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
    return {name: said_by(name).imports - {name} for name in FILES}


def said_by(name: str) -> Said:
    return said(FILES[name].read_text(encoding="utf-8"))


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


# Strings of scripts, but for a class of a style sheet: `{ class: "grid" }` names lines.
_STRING = re.compile(r"""(?<!\bclass: )(["'`])((?:(?!\1)[^\\]|\\.)*)\1""", re.DOTALL)


def strings_in(text: str, suffix: str) -> list[str]:
    """The strings of a module or of a script."""
    return said(text).strings if suffix == ".py" else [f[2] for f in _STRING.finditer(text)]


def kinds_named(text: str, suffix: str) -> set[str]:
    """The kinds that a text names, by themselves or as a folder."""
    names = "|".join(map(re.escape, KINDS))
    named = re.compile(rf"(?:\S*[./])?({names})(?:[./]\S*)?")
    return {found[1] for s in strings_in(text, suffix) if (found := named.fullmatch(s))}


def specs_asked(text: str) -> list[str]:
    """Where a module decides by the kind of a world's spec: of what is called so, or said to be
    one."""
    found = said(text)
    return [of for of in found.kinds_of if of in found.specs or re.search(r"\bspec$", of)]


@pytest.mark.parametrize(
    ("text", "suffix", "found"),
    [
        ('if spec.kind == "hill": pass', ".py", {"hill"}),
        ('x = {"grid": 1, "plane": f"plane/{1}.js"}', ".py", {"grid", "plane"}),
        ('"""A grid, and a plane."""\nx = "on the hill", "grids"', ".py", set()),
        ("if (world.kind === 'grid') draw(`render/hill/hill.js`);", ".js", {"grid", "hill"}),
        ('s("path", { class: "grid", d: `M0 ${y}` })', ".js", set()),
        ('if world["kind"] == "hill":  # on the plane', ".gd", {"hill"}),
    ],
)
def test_names_of_kinds_are_found(text: str, suffix: str, found: set[str]) -> None:
    assert kinds_named(text, suffix) == found


def test_one_table_names_the_kinds() -> None:
    """Nobody else does, but for a kind's own folders."""
    wrong = []
    for path in sorted(PACKAGE.rglob("*")):
        if path.suffix not in (".py", ".js", ".gd"):
            continue
        place, text = path.relative_to(PACKAGE), path.read_text(encoding="utf-8")
        own = place.parts[1] if place.parts[0] in ("worlds", "render") else ""
        wrong += [f"{place} names {kind}" for kind in kinds_named(text, path.suffix) - {own}]
    assert sorted(wrong) == sorted(f"worlds/kinds.py names {kind}" for kind in KINDS)


def test_nobody_decides_by_the_kind_of_a_world() -> None:
    asked = {name for name in FILES if specs_asked(FILES[name].read_text(encoding="utf-8"))}
    assert asked == set()


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("one.kind == two.kind", ["one"]),
        ("{}[world.spec.kind]", ["world.spec"]),
        ("CALLED.get(spec.kind, 0)", ["spec"]),
        ("two.kind == 1, [spec.kind], kind_named(spec.kind)", []),
    ],
)
def test_decisions_by_kinds_are_found(line: str, found: list[str]) -> None:
    assert (
        specs_asked(f"def f(one: Spec | None, two: int, spec, world):\n    return {line}") == found
    )


def test_no_shared_module_knows_a_world_by_its_name() -> None:
    names = {path.stem for path in (ROOT / "stories" / "worlds").glob("*.world")}
    asked = [
        f"{name}: {compared}"
        for name in FILES
        for strings, compared in said_by(name).compared
        if strings & names
    ]
    # A kitchen of a grid is drawn after its name, as its tiles are after theirs.
    assert asked == ["i2pdsl.render.grid.stage: 'kitchen' in self.name.lower()"]
