"""The VS Code extension: its files are there, name each other rightly, and are well formed."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from i2pdsl.worlds.kinds import kind_named

FOLDER = Path(__file__).parents[2] / "i2pdsl" / "editor" / "vscode"


def read(name: str) -> Any:
    return json.loads((FOLDER / name).read_text(encoding="utf-8"))


def test_the_manifest_names_what_there_is() -> None:
    manifest = read("package.json")
    contributed = manifest["contributes"]
    languages = {language["id"]: language for language in contributed["languages"]}
    assert {e for x in languages.values() for e in x["extensions"]} == {".story", ".world"}
    for grammar in contributed["grammars"]:
        assert grammar["language"] in languages
        assert read(grammar["path"])["scopeName"] == grammar["scopeName"]
    files = [manifest["main"], *(x["configuration"] for x in languages.values())]
    assert all((FOLDER / name).is_file() for name in files)
    script = (FOLDER / manifest["main"]).read_text(encoding="utf-8")
    assert set(re.findall(r'language: "([^"]+)"', script)) == set(languages)
    activated = {f"onLanguage:{name}" for name in languages}
    assert set(manifest["activationEvents"]) == activated
    assert "i2p.command" in contributed["configuration"]["properties"]


def test_a_new_line_behind_a_block_is_indented() -> None:
    rules = [
        re.compile(r["beforeText"]) for r in read("language-configuration.json")["onEnterRules"]
    ]
    for line in ("let x =", "pattern a(b) = ", *kind_named("grid").syntax.keywords):
        assert any(rule.search(line) for rule in rules), line
    for line in ("let x = 3", "length 3", "    symbol = P"):
        assert not any(rule.search(line) for rule in rules), line


def test_the_script_is_javascript() -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node")
    done = subprocess.run(
        [node, "--check", FOLDER / "extension.js"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
