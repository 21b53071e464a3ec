"""A form about beliefs stands in one table, and its meaning in another."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest

from i2pdsl.language.forms import BELIEFS, BY_NAME, BY_TERMINAL, HIDDEN, Form
from i2pdsl.language.parse import tables
from i2pdsl.objective.meanings import NUMBERS, TABLES

SOURCES = sorted((Path(__file__).parents[2] / "i2pdsl").rglob("*.py"))
PLACES = {"forms.py", "meanings.py"}


def test_every_form_has_a_meaning_and_no_other() -> None:
    believed = [form for form in BELIEFS if form.shape is not HIDDEN]
    assert set(NUMBERS) == {form.name for form in believed if not form.is_table}
    assert set(TABLES) == {form.name for form in believed if form.tabulates}
    assert len(BY_NAME) == len(BELIEFS)


@cache
def texts(path: Path) -> set[str]:
    """The strings that a source holds."""
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    return {n.value for n in nodes if isinstance(n, ast.Constant) and isinstance(n.value, str)}


@pytest.mark.parametrize("form", [f for f in BELIEFS if len(f.name) > 1], ids=lambda f: f.name)
def test_nothing_else_names_a_form(form: Form) -> None:
    """`P`, `E` and `V` are looked for by name in some places; the words are not."""
    assert {path.name for path in SOURCES if form.name in texts(path)} == PLACES


def test_the_grammar_has_the_words_of_the_table() -> None:
    patterns = {t.name: t.value for t in tables().terminals}
    for terminal, forms in BY_TERMINAL.items():
        assert forms, f"no form is written as {terminal}"
        assert patterns[terminal] == rf"({'|'.join(form.name for form in forms)})\b"
