"""What the documents say is true: their stories are checked, their code is run, their references
and links are there, and their tables are those of the code.

The word behind a fence tells what a block is:

    story, world            is right (`file=NAME` keeps it for the blocks below)
    story-fragment          is right once it has a world (the kitchen), a length and an objective
    story-error, world-error  is wrong; the block that follows is what is said about it
    repl                    lines typed into `i2p repl`, behind `i2p>`, and the answers (or none)
    expr                    questions, one a line, about a script of the kitchen
    sh                      commands that there are; `sh run` runs them
    python no-run           is Python; `python run` runs it, `file=NAME` keeps it
    output                  what the block above prints
    text                    anything (`file=NAME` keeps it)

`python tests/test_docs.py` writes the outputs and the generated tables anew.
"""

from __future__ import annotations

import ast
import contextlib
import io
import math
import os
import re
import shlex
import sys
import tempfile
import tomllib
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from pathlib import Path

import pytest

from documents_for_tests import TYPED, Block, blocks
from i2pdsl.cli import command_named, run_command
from i2pdsl.describe import shown_value
from i2pdsl.errors import Source, StoryError
from i2pdsl.language.builtins import FORMS, FUNCTIONS, STATEMENTS
from i2pdsl.language.check import Library, TypedStory, check_query, check_source
from i2pdsl.language.methods import METHODS
from i2pdsl.language.scope import Module
from i2pdsl.language.vocabulary import ASKED, Setting
from i2pdsl.render.characters import Ink
from i2pdsl.repl.session import Session as Lines
from i2pdsl.repl.terminal import tell
from i2pdsl.worlds.find import find_vocabulary
from i2pdsl.worlds.grid.parse import SETTING_RANGES, SETTING_WORDS, parse_world
from i2pdsl.worlds.grid.spec import Settings
from i2pdsl.worlds.grid.words import ELSEWHERE, KEYS
from i2pdsl.worlds.hill.spec import HillSpec
from i2pdsl.worlds.hill.vocabulary import hill_vocabulary
from i2pdsl.worlds.kinds import KINDS
from i2pdsl.worlds.kinds import parse_world as parse_any_world

ROOT = Path(__file__).parent.parent
DOCUMENTS = [p for p in (*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md") if p.is_file()]
NAMES = [p.stem for p in DOCUMENTS]
LONG = ("sweep",)  # it begins many processes, as test_sweep.py does
REFERENCE = re.compile(r"`([\w/.-]+\.py):([\w.]+)`")
NUMBER = re.compile(r" *(?<![\w.])-?\d+(?:\.\d*)?(?:e-?\d+)?(?![\w.])")
LINK = re.compile(r"\]\(([^)\s]*)\)")
GENERATED = re.compile(r"<!-- generated: (\w+) -->\n(.*?)<!-- end -->", re.DOTALL)


class Session:
    """Reads a document from top to bottom, in a folder of its own."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.names: dict[str, object] = {"__name__": "docs"}
        self.lines = Lines()

    def said(self, block: Block) -> str | None:
        """What a block prints; None where nothing is run."""
        kind = block.words[0] if block.words else ""
        method = getattr(self, kind.replace("-", "_"), None)
        assert method is not None, f"a block of no known kind: {kind!r}"
        found = method(block)
        return found if found is None else found.replace(f"{ROOT}/", "")

    def keep(self, block: Block) -> Source:
        name = block.option("file")
        if name is not None:
            (self.folder / name).write_text(block.text, encoding="utf-8")
        return Source(name or f"my.{block.words[0].partition('-')[0]}", block.text)

    def check(self, text: Source) -> TypedStory | Library:
        checked = check_source(text, find_vocabulary, self.folder)
        assert not checked.warnings, checked.warnings[0].render()
        return checked

    def story(self, block: Block) -> None:
        self.check(self.keep(block))

    def story_fragment(self, block: Block) -> None:
        text = "world kitchen\n" * (not re.search(r"^world ", block.text, re.MULTILINE))
        text += "length 15\n" * (not re.search(r"^length ", block.text, re.MULTILINE)) + block.text
        if not re.search(r"^(maximize|minimize|search naive)", block.text, re.MULTILINE):
            text += "maximize depict(rho > 0)\n"
        self.check(Source("my.story", text))

    def world(self, block: Block) -> None:
        parse_any_world(self.keep(block), Path(block.option("file") or "my").stem)

    def mistakes(self, block: Block, read: object) -> str:
        try:
            read(self.keep(block))  # type: ignore[operator]
        except StoryError as problem:
            return "\n".join(d.render() for d in problem.diagnostics) + "\n"
        raise AssertionError("this is right, but is shown as wrong")

    def story_error(self, block: Block) -> str:
        return self.mistakes(block, self.check)

    def world_error(self, block: Block) -> str:
        return self.mistakes(block, lambda source: parse_world(source, "my"))

    def expr(self, block: Block) -> None:
        kitchen = find_vocabulary("kitchen")
        assert kitchen is not None
        for line in block.text.splitlines():
            check_query(Source("query", line), kitchen, Module(Source("query", "")), 15)

    def repl(self, block: Block) -> str:
        said = io.StringIO()
        typed = [line for line in block.text.splitlines() if line.startswith(TYPED)]
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            for line in typed:
                print(line)
                reply = self.lines.run(line.removeprefix(TYPED))
                if not block.holds_answers:
                    assert not reply.diagnostics, reply.diagnostics[0].render()
                # The remarks say how many seconds it took.
                tell(replace(reply, said=(), noted=()), Ink(colour=False, columns=76))
        return said.getvalue()

    def sh(self, block: Block) -> str | None:
        if "run" not in block.words:
            for command in commands(block.text):
                parse_command(command)
            return None
        said = io.StringIO()
        for line in block.text.splitlines():
            expected = re.search(r"# status (\d+)$", line)
            (command,) = commands(line)
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
                status = run_command(command)
            assert status == int(expected[1] if expected else 0), f"{line}\n{said.getvalue()}"
        return said.getvalue()

    def python(self, block: Block) -> str | None:
        code = compile(block.text, "docs", "exec")
        if block.option("file") is not None:
            self.keep(block)
            return None
        if "no-run" in block.words:
            return None
        assert "run" in block.words, "write `python run`, `python no-run` or `python file=NAME`"
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(code, self.names)
        return said.getvalue()

    def text(self, block: Block) -> None:
        """Anything."""
        self.keep(block)


def commands(text: str) -> list[list[str]]:
    """The arguments of each `i2p` in a piece of shell."""
    found = []
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words[:1] == ["i2p"]:
            ends = [i for i, w in enumerate(words) if w in ("|", ">", "<", "&&", ";")]
            found.append(words[1 : min(ends, default=len(words))])
    return found


def parse_command(arguments: list[str]) -> None:
    """Fails where there is no such command, argument or option."""
    if arguments[0].startswith("-"):
        return
    command = command_named(arguments[0])
    command.make_context(arguments[0], list(arguments[1:]), resilient_parsing="-h" in arguments)


@contextlib.contextmanager
def session(folder: Path) -> Iterator[Session]:
    """A session in a folder that has the stories beside it."""
    (folder / "stories").symlink_to(ROOT / "stories")
    before, kinds, path, modules = Path.cwd(), dict(KINDS), list(sys.path), set(sys.modules)
    os.chdir(folder)
    try:
        yield Session(folder)
    finally:
        os.chdir(before)
        for name in set(KINDS) - set(kinds):  # a document may add one
            del KINDS[name]
        sys.path[:] = path
        for name in set(sys.modules) - modules:
            if not name.startswith(("i2pdsl", "numpy", "jax")) and (folder / f"{name}.py").exists():
                del sys.modules[name]


# Tables that follow the code.


def builtins_table() -> str:
    """The forms and functions of the language."""
    rows = ["| write | meaning | example |", "|---|---|---|"]
    for word in (*FORMS, *FUNCTIONS.values()):
        cells = (f"`{word.signature}`", word.documentation, f"`{word.example}`")
        rows.append("| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |")
    return "\n".join(rows) + "\n"


def statements_table() -> str:
    """The statements of the language."""
    rows = ["| statement | meaning | example |", "|---|---|---|"]
    for word in STATEMENTS:
        ways = re.split(r", (?=import|assume)", word.signature)
        signature = ", ".join(f"`{way}`" for way in ways)
        cells = (signature, word.documentation, f"`{word.example}`")
        rows.append("| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |")
    return "\n".join(rows) + "\n"


def settings_table() -> str:
    """The numbers of a world."""
    kitchen = find_vocabulary("kitchen")
    assert kitchen is not None
    rows = ["| key | block | default | range | meaning |", "|---|---|---|---|---|"]
    for field in fields(Settings):
        name = field.name
        if name == ASKED:  # that no world's file has (docs/particles.md)
            continue
        words = ", ".join(f"`{w}`" for w in SETTING_WORDS.get(name, ()))
        range_ = words or SETTING_RANGES[name][1]
        meaning = kitchen.settings[name].documentation
        default = field.default if isinstance(field.default, str) else f"{field.default:g}"
        block = next(block for block, keys in KEYS.items() if name in keys)
        rows.append(f"| `{name}` | `{block}` | {default} | {range_} | {meaning} |")
    return "\n".join(rows) + "\n"


def elsewhere_table() -> str:
    """What other tools have: the sentence of worlds/grid/words.py, and its words."""
    told: dict[str, list[str]] = {}
    for word, sentence in ELSEWHERE.items():
        told.setdefault(sentence, []).append(f"`{word}`")
    rows = [f"| {', '.join(words)} | {sentence} |\n" for sentence, words in told.items()]
    return "| word | here |\n|---|---|\n" + "".join(rows)


def rows_of(settings: Iterable[Setting]) -> str:
    """A table of settings."""
    rows = ["| setting | default | can be | meaning |", "|---|---|---|---|"]
    for s in settings:
        default = "none" if s.default == math.inf else shown_value(s.default)
        rows.append(f"| `{s.name}` | {default} | {s.possible} | {s.documentation} |")
    return "\n".join(rows) + "\n"


TABLES = {
    "statements": statements_table,
    "builtins": builtins_table,
    "settings": settings_table,
    "elsewhere": elsewhere_table,
    "hill": lambda: rows_of(hill_vocabulary(HillSpec()).settings.values()),
    "descend": lambda: rows_of(METHODS["descend"].continuous),
}


# Tests.


@pytest.mark.parametrize(
    "document",
    [pytest.param(d, marks=[pytest.mark.slow] * (d.stem in LONG)) for d in DOCUMENTS],
    ids=NAMES,
)
def test_blocks_are_right(document: Path, tmp_path: Path) -> None:
    with session(tmp_path) as reader:
        for block in blocks(document.read_text(encoding="utf-8")):
            place = f"{document.name}:{block.first}"
            try:
                said = reader.said(block)
            except StoryError as problem:
                pytest.fail(f"{place}\n{problem}")
            except Exception as problem:
                pytest.fail(f"{place}: {type(problem).__name__}: {problem}")
            if block.output is not None:
                assert said is not None, place
                assert NUMBER.sub("0", said) == NUMBER.sub("0", block.output.text), place
                shown = [float(x) for x in NUMBER.findall(block.output.text)]
                found = [float(x) for x in NUMBER.findall(said)]
                # The last digits depend on where exactly planning stopped.
                assert found == pytest.approx(shown, rel=0.01, abs=0.002), place
            elif said is not None and block.words[0].endswith("-error"):
                pytest.fail(f"{place}: what is said about this mistake is missing")


@pytest.mark.parametrize("document", DOCUMENTS, ids=NAMES)
def test_generated_tables_follow_the_code(document: Path) -> None:
    for name, table in GENERATED.findall(document.read_text(encoding="utf-8")):
        assert table == TABLES[name](), f"{document.name}: {name}"


def test_examples_of_the_table_are_right() -> None:
    kitchen, farm = find_vocabulary("kitchen"), find_vocabulary("farm")
    assert kitchen is not None
    assert farm is not None
    for word in (*FORMS, *FUNCTIONS.values()):
        example = word.example
        if word.name in ("script", "T", "++"):  # a script is no answer
            example = f"entropy({example})"
        if word.name in FUNCTIONS and word.name != "beats":  # which is a sum over t itself
            example = f"sum_t ({example})"
        # In the kitchen nobody is wrong about anything.
        words = farm if word.name == "believes" else kitchen
        check_query(Source(word.name, example), words, Module(Source("query", "")), 15)


def test_every_dependency_is_explained() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = {
        re.split(r"[<>=\[]", line)[0]
        for line in (*project["dependencies"], *project["optional-dependencies"]["dev"])
    }
    text = (ROOT / "docs" / "dependencies.md").read_text(encoding="utf-8")
    explained = set(re.findall(r"^\| ([\w-]+) \|", text, re.MULTILINE)) - {"package"}
    assert explained == wanted


def defined(path: Path) -> set[str]:
    """The names that a module defines, methods as `Class.method`."""
    found: set[str] = set()

    def visit(body: list[ast.stmt], prefix: str) -> None:
        for node in body:
            match node:
                case ast.FunctionDef(name=name):
                    found.add(prefix + name)
                case ast.ClassDef(name=name):
                    found.add(prefix + name)
                    visit(node.body, f"{prefix}{name}.")
                case ast.Assign(targets=targets):
                    found.update(prefix + t.id for t in targets if isinstance(t, ast.Name))
                case ast.AnnAssign(target=ast.Name(id=name)):
                    found.add(prefix + name)

    visit(ast.parse(path.read_text(encoding="utf-8")).body, "")
    return found


@pytest.mark.parametrize("document", DOCUMENTS, ids=NAMES)
def test_references_to_the_code_are_there(document: Path) -> None:
    missing = []
    for file, name in REFERENCE.findall(document.read_text(encoding="utf-8")):
        path = ROOT / file
        if not path.is_file() or name not in defined(path):
            missing.append(f"{file}:{name}")
    assert not missing


def anchors(path: Path) -> set[str]:
    """The anchors of a document's headings, as GitHub makes them."""
    text = re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
    heads = (h.strip().lower() for h in re.findall(r"^#+ (.*)$", text, re.MULTILINE))
    return {re.sub(r"[^\w\- ]", "", h).replace(" ", "-") for h in heads}


@pytest.mark.parametrize("document", DOCUMENTS, ids=NAMES)
def test_links_lead_somewhere(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"(?<!\[)`[^`\n]+`(?!\])", "", text)  # code, such as `P[friend](...)`
    for target in LINK.findall(text):
        if re.match(r"https?:", target):
            continue
        file, _, anchor = target.partition("#")
        path = document.parent / file if file else document
        assert path.exists(), target
        if anchor and path.suffix == ".md":
            assert anchor in anchors(path), target


def rewrite(document: Path, folder: Path) -> None:
    """Writes a document's outputs and generated tables anew."""
    text = document.read_text(encoding="utf-8")
    text = GENERATED.sub(
        lambda m: f"<!-- generated: {m[1]} -->\n{TABLES[m[1]]()}<!-- end -->", text
    )
    lines = text.splitlines()
    with session(folder) as reader:
        changes = [(b.output, reader.said(b)) for b in blocks(text)]
    for output, said in reversed(changes):
        if output is not None and said is not None:
            lines[output.first : output.last] = said.splitlines()
    document.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    warnings.simplefilter("error")
    chosen = [Path(a).resolve() for a in sys.argv[1:]] or DOCUMENTS
    for one in chosen:
        with tempfile.TemporaryDirectory() as place:
            rewrite(one, Path(place))
