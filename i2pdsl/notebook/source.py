"""The text of a story as coloured HTML, and places in it as places in a cell."""

from __future__ import annotations

from dataclasses import replace

from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.style import Style
from pygments.token import Comment, Error, Keyword, Name, Number, Operator, String

from i2pdsl.editor.lexer import StoryLexer
from i2pdsl.errors import Diagnostic, Source, Span


class NotebookStyle(Style):
    """Colours with a contrast of 4.5 on white and 3.6 on the dark grey of dark themes: a notebook
    does not tell which one it is shown on, and GitHub takes style sheets out."""

    styles = {  # noqa: RUF012, as Pygments declares it
        Keyword: "bold #ad45d0",
        Name.Builtin: "#2473e0",
        Name.Builtin.Pseudo: "#2473e0",
        Name.Function: "#2473e0",
        Operator.Word: "#2473e0",
        Name.Variable: "#c15515",
        Name.Class: "bold",
        Name.Constant: "#0f8383",
        Number: "#228743",
        String: "#228743",
        Comment: "italic #71757f",
        Error: "#d53a53",
    }


def story_html(text: str) -> str:
    """A story in colours, on whatever ground."""
    formatter = HtmlFormatter(
        style=NotebookStyle, noclasses=True, nobackground=True, prestyles="font-family: monospace"
    )
    return highlight(text, StoryLexer(), formatter)


def placed(diagnostic: Diagnostic, name: str, cell: str, offset: int) -> Diagnostic:
    """A diagnostic whose places in the source called `name` are told as those of a cell's text,
    `offset` characters further on."""

    def span(old: Span) -> Span:
        if old.source.name != name:
            return old
        # What `--set` replaced has another length than what stands in the cell.
        text = cell[:offset] + old.source.text + cell[offset + len(old.source.text) :]
        return Span(Source(name, text), old.start + offset, old.end + offset)

    notes = tuple(replace(note, span=span(note.span)) for note in diagnostic.notes)
    return replace(diagnostic, span=span(diagnostic.span), notes=notes)
