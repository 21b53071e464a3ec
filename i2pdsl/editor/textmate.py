"""The TextMate grammars of the VS Code extension, made from the tables of words.

`python -m i2pdsl.editor.textmate` writes vscode/syntaxes/*.json; a test compares them. They use
`match` rules only, line by line, so that they stay as simple as what they describe.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from i2pdsl.editor.colours import LATENT, TERMINALS
from i2pdsl.editor.words import spellings
from i2pdsl.language.builtins import FUNCTIONS, STATEMENT_WORDS
from i2pdsl.resources import write_text
from i2pdsl.worlds.kinds import KINDS as WORLDS
from i2pdsl.worlds.kinds import kind_named

FOLDER = Path(__file__).parent / "vscode" / "syntaxes"
SCOPES = {
    "keyword": "keyword.control",
    "form": "support.function",
    "story": "variable.language",
    "reduction": "keyword.operator.word",
    "function": "support.function.math",
    "call": "entity.name.function",
    "latent": "variable.other.constant",
    "definition": "entity.name.type",
    "constant": "constant.language",
    "name": "variable.other",
    "number": "constant.numeric",
    "string": "string.quoted.double",
    "comment": "comment.line.number-sign",
    "operator": "keyword.operator",
    "sign": "punctuation.separator",
    "bracket": "punctuation.section",
    "map": "string.unquoted",
    "error": "invalid.illegal",
}
"""The scope of each kind of colours.py, without the name of the language at its end."""

_NAME = r"[^\W\d]\w*"
_NUMBER = r"\d+(\.\d+)?([eE][+-]?\d+)?"
_Rules = Iterator[dict[str, Any]]


def story_grammar() -> dict[str, Any]:
    """The grammar of stories."""
    return _grammar("i2p story", "story", list(_story_rules()))


def world_grammar() -> dict[str, Any]:
    """The grammar of worlds."""
    return _grammar("i2p world", "world", list(_world_rules()))


def _grammar(name: str, suffix: str, rules: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "name": name,
        "scopeName": f"source.{suffix}",
        "fileTypes": [suffix],
        "patterns": [_named(rule, suffix) for rule in rules],
    }


def _named(rule: dict[str, Any], suffix: str) -> dict[str, Any]:
    """A rule with scopes for kinds."""
    if "name" in rule:
        return {**rule, "name": f"{SCOPES[rule['name']]}.{suffix}"}
    captures = {
        number: {"name": f"{SCOPES[kind]}.{suffix}"} for number, kind in rule["captures"].items()
    }
    return {**rule, "captures": captures}


def _rule(kind: str, pattern: str) -> dict[str, Any]:
    return {"match": pattern, "name": kind}


def _story_rules() -> _Rules:
    yield from _common()
    definition = rf"^(let|pattern)\s+({_NAME})"
    yield {"match": definition, "captures": {"1": "keyword", "2": "definition"}}
    audience = rf"^(audience)\s+({_NAME})(?=\s*=)"
    yield {"match": audience, "captures": {"1": "keyword", "2": "definition"}}
    yield _rule("keyword", rf"^(?:{'|'.join(STATEMENT_WORDS)})\b")
    # `deus: table at (1, 3)`; elsewhere `at` is a predicate.
    fall = rf"(:)\s*({_NAME})\s+(at)\b"
    yield {"match": fall, "captures": {"1": "sign", "2": "name", "3": "keyword"}}
    # `require [...] before [...]`; elsewhere `before` is a name.
    yield {"match": r"(\])\s*(before)\b", "captures": {"1": "bracket", "2": "keyword"}}
    yield _rule("reduction", r"\b(?:sum|mean|min|max)_(?:t\b|\{)")
    for kind in ("keyword", "form", "story"):
        yield _rule(kind, rf"\b(?:{'|'.join(_words(kind))})\b")
    yield _rule("function", rf"\b(?:{'|'.join(FUNCTIONS)})\b")
    yield _rule("constant", r"\bpi\b")
    yield _rule("latent", rf"\b(?:{LATENT.pattern})\b")
    yield _rule("call", rf"{_NAME}(?=[ \t]*\()")
    yield _rule("name", _NAME)
    yield _rule("number", _NUMBER)
    for kind in ("operator", "sign", "bracket"):
        signs = [s for name, texts in spellings().items() if TERMINALS[name] == kind for s in texts]
        yield _rule(kind, _any_of(signs))
    yield _rule("error", r"\S")


def _world_rules() -> _Rules:
    # A row of the map: an indented line with no spaces in it and no `=`; or with a space or a wall
    # between each two cells; or walls below some of them.
    row = r"^\s+([^\s=]+|[^\s=](?:[ |][^\s=])+|-(?:\s+-)*)\s*$"
    yield {"match": row, "captures": {"1": "map"}}
    yield from _common()
    words = dict.fromkeys(w for kind in WORLDS for w in kind_named(kind).syntax.keywords)
    yield _rule("keyword", rf"^(?:{'|'.join(words)})\b")
    yield _rule("definition", rf"{_NAME}(?=\s*=)")
    yield _rule("name", _NAME)
    yield _rule("number", _NUMBER)
    yield _rule("operator", r"=|-")
    yield _rule("sign", ",|:")
    yield _rule("bracket", r"\(|\)|\{|\}|\[|\]")
    yield _rule("error", r"\S")


def _common() -> _Rules:
    yield _rule("comment", r"#.*$")
    yield _rule("string", '"[^"]*(?:"|$)')


def _words(kind: str) -> list[str]:
    """The words of a kind that no statement begins with."""
    words = {
        text for name, texts in spellings().items() if TERMINALS[name] == kind for text in texts
    }
    return sorted(words - set(STATEMENT_WORDS) - {"at", "before"})


def _any_of(signs: list[str]) -> str:
    """A pattern of signs, longer ones first."""
    special = "+*^|.()[]{}"
    escape = lambda sign: "".join(f"\\{c}" if c in special else c for c in sign)
    return "|".join(escape(s) for s in sorted(set(signs), key=lambda s: (-len(s), s)))


GRAMMARS = {"story.tmLanguage.json": story_grammar, "world.tmLanguage.json": world_grammar}


def written(name: str) -> str:
    """The text of one of the files."""
    return json.dumps(GRAMMARS[name](), indent=2, ensure_ascii=False) + "\n"


def main() -> None:
    for name in GRAMMARS:
        write_text(FOLDER / name, written(name))


if __name__ == "__main__":
    main()
