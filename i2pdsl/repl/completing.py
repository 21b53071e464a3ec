"""How a line of the REPL can go on: commands and their arguments, and the language."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from i2pdsl.editor.complete import Completion, complete
from i2pdsl.editor.surroundings import Surroundings
from i2pdsl.language.builtins import STATEMENT_WORDS
from i2pdsl.repl.helping import every_word
from i2pdsl.repl.state import State
from i2pdsl.repl.words import COMMAND_WORDS
from i2pdsl.worlds.kinds import kind_of

_WORD = re.compile(r"[^\W\d]?\w*$")
_STATEMENTS = frozenset(STATEMENT_WORDS) - frozenset(COMMAND_WORDS)
_PATHS = {"load": (".story", ".json"), "save": ()}


def complete_line(text: str, offset: int, state: State) -> list[Completion]:
    """What can be written at a place of a line (or of several that belong together)."""
    typed = state.typed
    given = (typed.vocabulary, typed.module, state.program.folder, None, typed.length)
    around = Surroundings(*given, typed.audiences)
    head = text[:offset].lstrip()
    skipped = len(text[:offset]) - len(head)
    first = head.split(None, 1)[0] if head else ""
    if first in STATEMENT_WORDS and first != head:
        # Alone: what stands once in the session may be replaced.
        return complete(text, offset, around, "file")
    if first in COMMAND_WORDS and first != head:
        begins = skipped + len(first) + 1
        return list(_argument(first, text, begins, offset, state, around))
    found = []
    if first == head:
        words = [(c.name, "command", c.signature, c.documentation) for c in state.commands]
        found = [
            Completion(name, skipped, offset, kind, signature, about)
            for name, kind, signature, about in words
            if name.startswith(first)
        ]
        whole = complete(head, len(head), around, "file")
        words_of_stories = [c for c in whole if c.text in _STATEMENTS]
        found += [replace(c, start=skipped, end=offset) for c in words_of_stories]
    return found + complete(text, offset, around, "expression")


def _argument(
    command: str, text: str, begins: int, offset: int, state: State, around: Surroundings
) -> Iterator[Completion]:
    """What can stand behind a command."""
    typed = text[begins:offset]
    if command in _PATHS:
        yield from _paths(typed, begins, offset, _PATHS[command])
    elif command in ("help", "forget"):
        names = every_word(state) if command == "help" else state.program.forgettable()
        start = begins + len(typed) - len(typed.lstrip())
        for name in sorted(names, key=lambda n: (n.lower(), n)):
            if name.startswith(typed.strip()):
                yield Completion(name, start, offset, "word", "", "")
    elif command == "accept":
        start = offset - len(typed.strip())
        for place, suggestion in enumerate(state.suggestions, 1):
            if str(place).startswith(typed.strip()):
                yield Completion(str(place), start, offset, "number", suggestion.told, "")
    elif command == "play":
        yield from _move(typed, begins, offset, state)
    elif command in ("plot", "table", "suggest"):
        number = re.match(r"\s*\d+\s", typed) if command == "suggest" else None
        shift = begins + (number.end() if number else 0)
        part = text[shift:offset]
        # The expressions are separate; the last one is being written.
        from i2pdsl.language.statements import split_outside

        last = split_outside(part, ",")[-1]
        shift += len(part) - len(last)
        for each in complete(last, len(last), around, "expression"):
            yield replace(each, start=each.start + shift, end=each.end + shift)


def _move(typed: str, begins: int, offset: int, state: State) -> Iterator[Completion]:
    """`play cheese west!`: who, then what."""
    words = state.typed.vocabulary
    part = typed.rpartition(",")[2]
    match = _WORD.search(part)
    written = match[0] if match else ""
    start = offset - len(written)
    before = part[: len(part) - len(written)].replace("[", " ").replace(":", " ").split()
    spec = state.spec
    options = kind_of(spec).options(words, before) if spec is not None else []
    for text, kind in options:
        if text.startswith(written):
            yield Completion(text, start, offset, kind, kind, "")


def _paths(typed: str, begins: int, offset: int, wanted: tuple[str, ...]) -> Iterator[Completion]:
    """Files and folders beside what is typed."""
    text = typed.lstrip().lstrip('"')
    folder, slash, name = text.rpartition("/")
    place = Path((folder + slash) or ".").expanduser()
    start = offset - len(name)
    try:
        entries = sorted(place.iterdir())
    except OSError:
        return
    for entry in entries:
        if not entry.name.startswith(name) or (entry.name.startswith(".") and not name):
            continue
        if entry.is_dir():
            yield Completion(f"{entry.name}/", start, offset, "folder", "", "")
        elif not wanted or entry.suffix in wanted:
            yield Completion(entry.name, start, offset, "file", "", "")
