"""Modules of pages as one module, for places without a server.

Each becomes a function that is called once, in the order of their imports, and what it exports an
object: enough for modules that import names from files, and nothing else. Neither a bundler nor
Node is needed.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Callable

_IMPORT = re.compile(r'^import \{([^}]*)\} from "([^"]+)";\n', re.MULTILINE)
_EXPORT = re.compile(
    r"^export ((?:async )?(?:const|class|function)\*? *)([A-Za-z_$][\w$]*)", re.MULTILINE
)


def one_module(first: str, read: Callable[[str], str]) -> str:
    """A module and all that it imports, directly or not, as one without imports.

    Args:
        first: its path, such as `/widget.js`.
        read: the text of a module by its path.

    What the first one exports is exported.
    """
    done: dict[str, str] = {}

    def take(path: str) -> None:
        text = read(path)
        heads = []
        for names, place in _IMPORT.findall(text):
            other = posixpath.normpath(posixpath.join(posixpath.dirname(path), place))
            if other not in done:
                take(other)
            named = names.replace(" as ", ": ")
            heads.append(f"const {{{named}}} = {_name(other)};\n")
        body = _EXPORT.sub(r"\1\2", _IMPORT.sub("", text))
        exported = ", ".join(name for _, name in _EXPORT.findall(text))
        inside = "".join(heads) + body
        done[path] = f"const {_name(path)} = (() => {{\n{inside}return {{ {exported} }};\n}})();\n"

    take(first)
    exported = ", ".join(name for _, name in _EXPORT.findall(read(first)))
    return "".join(done.values()) + f"export const {{ {exported} }} = {_name(first)};\n"


def _name(path: str) -> str:
    return "$" + re.sub(r"\W", "_", path)
