"""The fixed words and signs of the language: how each terminal of the grammar is written."""

from __future__ import annotations

from functools import cache

from i2pdsl.editor.colours import TERMINALS
from i2pdsl.language.builtins import word_named
from i2pdsl.language.forms import BY_TERMINAL, Word
from i2pdsl.language.parse import tables


@cache
def spellings() -> dict[str, tuple[str, ...]]:
    """The texts of each terminal that has fixed ones: `sum_t`, `mean_t`... for BIG_T."""
    found: dict[str, tuple[str, ...]] = {}
    for terminal in tables().terminals:
        if TERMINALS[terminal.name] == "reduction":
            end = "_t" if terminal.name == "BIG_T" else "_{"
            found[terminal.name] = tuple(f"{w}{end}" for w in ("sum", "mean", "min", "max"))
        elif terminal.name in BY_TERMINAL:
            found[terminal.name] = tuple(form.name for form in BY_TERMINAL[terminal.name])
        elif terminal.is_text:
            found[terminal.name] = (terminal.value,)
        elif TERMINALS[terminal.name] in ("keyword", "form", "story"):
            found[terminal.name] = (terminal.value.removesuffix(r"\b"),)
    return found


def explanation(word: str) -> Word | None:
    """What the table of the language says of a word or a sign."""
    return word_named(word.replace("_{", "_t"))
