"""The REPL on a terminal: prompt_toolkit's line editor around a session."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from prompt_toolkit import PromptSession
from prompt_toolkit.auto_suggest import AutoSuggestFromHistory
from prompt_toolkit.completion import CompleteEvent, Completer
from prompt_toolkit.completion import Completion as Offer
from prompt_toolkit.document import Document
from prompt_toolkit.formatted_text import HTML
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.key_binding import KeyBindings, KeyPressEvent
from prompt_toolkit.lexers import PygmentsLexer
from prompt_toolkit.output import ColorDepth
from prompt_toolkit.shortcuts import CompleteStyle
from prompt_toolkit.styles import Style, merge_styles, style_from_pygments_cls

from i2pdsl.errors import harmless
from i2pdsl.interrupts import HungUp
from i2pdsl.output import output
from i2pdsl.render.characters import Ink
from i2pdsl.repl.completing import complete_line
from i2pdsl.repl.faults import taken
from i2pdsl.repl.piped import entries
from i2pdsl.repl.session import Session, told
from i2pdsl.repl.showing import Reply, Shown, Text, on_a_terminal
from i2pdsl.repl.texts import is_unfinished

_STYLE = Style.from_dict(
    {
        "prompt": "bold ansiblue",
        "bottom-toolbar": "noreverse ansibrightblack",
    }
)


def converse(session: Session) -> None:
    """Reads and answers until Ctrl-D or `quit`."""
    editor = line_editor(session)
    click.echo(f"i2p repl: {told(session.state)}\n`help` explains, Ctrl-D leaves")
    while True:
        try:
            line = editor.prompt()
        except HungUp:
            raise
        except KeyboardInterrupt:
            continue
        except EOFError:
            break
        if not answered(session, line):
            break


def answered(session: Session, typed: str) -> bool:
    """Does what was typed, or pasted: one entry after the other. False where that ends it all."""
    for entry in entries(typed.splitlines()):
        session.ink = terminal_ink()  # windows change their size
        try:
            if not taken(session, entry, lambda reply: tell(reply, session.ink)):
                return False
        except HungUp:
            raise
        except KeyboardInterrupt:
            click.echo("interrupted: nothing is changed", err=True)
            return True
    return True


def terminal_ink() -> Ink:
    """What this terminal can show."""
    dumb = os.environ.get("TERM") == "dumb"
    colour = sys.stdout.isatty() and "NO_COLOR" not in os.environ and not dumb
    encoding = (sys.stdout.encoding or "").lower().replace("-", "")
    return Ink(colour, encoding.startswith("utf"), shutil.get_terminal_size().columns)


def tell(reply: Reply, ink: Ink) -> None:
    """Shows what a line came to."""
    texts = [_coloured(shown, ink) for shown in reply.shown]
    for remark in reply.noted:
        click.echo(ink.paint(remark, 2), err=True, color=ink.colour)
    for diagnostic in reply.diagnostics:
        head, line, rest = diagnostic.render().partition("\n")
        code = 31 if diagnostic.severity == "error" else 33
        click.echo(ink.paint(head, code) + line + rest, err=True, color=ink.colour)
    for text in texts:
        output(text, ink.colour)
    for remark in reply.said:
        click.echo(ink.paint(remark, 2), err=True, color=ink.colour)


def _coloured(shown: Shown, ink: Ink) -> str:
    if isinstance(shown, Text):
        shown = replace(shown, text=harmless(shown.text))
    if isinstance(shown, Text) and shown.is_story and ink.colour:
        from pygments import highlight
        from pygments.formatters import TerminalFormatter

        from i2pdsl.editor.lexer import StoryLexer

        return highlight(shown.text, StoryLexer(), TerminalFormatter()).rstrip("\n")
    return on_a_terminal(shown, ink)


def history_file() -> Path | None:
    """Where lines are kept from one session to the next; None where nothing can be written."""
    from platformdirs import user_state_path

    try:
        folder = user_state_path("i2pdsl")
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "history"
        with path.open("a", encoding="utf-8"):
            return path
    except OSError:
        return None


class KeptHistory(FileHistory):
    """Lines in a file, whatever they hold; a full disk ends no session."""

    def store_string(self, string: str) -> None:
        with suppress(OSError):
            super().store_string(string.encode("utf-8", "replace").decode())


def line_editor(session: Session, **streams: Any) -> PromptSession[str]:
    """The line editor; `streams` are prompt_toolkit's input and output, for tests."""
    path = history_file()
    history: History = InMemoryHistory() if path is None else KeptHistory(path)
    plain = "NO_COLOR" in os.environ
    return PromptSession(
        message=HTML("<prompt>i2p&gt; </prompt>"),
        prompt_continuation=lambda width, number, wrapped: " " * (width - 2) + "· ",
        multiline=True,
        key_bindings=keys(),
        history=history,
        auto_suggest=AutoSuggestFromHistory(),
        completer=LineCompleter(session),
        complete_while_typing=True,
        complete_style=CompleteStyle.COLUMN,
        lexer=story_colours(),
        style=merge_styles([_pygments_style(), _STYLE]),
        bottom_toolbar=lambda: _toolbar(session),
        reserve_space_for_menu=6,
        color_depth=ColorDepth.DEPTH_1_BIT if plain else None,
        **streams,
    )


def story_colours() -> PygmentsLexer:
    from i2pdsl.editor.lexer import StoryLexer

    return PygmentsLexer(StoryLexer, sync_from_start=True)


def _pygments_style() -> Any:
    from pygments.styles import get_style_by_name

    return style_from_pygments_cls(get_style_by_name("default"))


def keys() -> KeyBindings:
    """Enter ends what is finished; Alt-Enter begins a new line in any case."""
    bindings = KeyBindings()

    @bindings.add("enter")
    def _(event: KeyPressEvent) -> None:
        buffer = event.current_buffer
        if buffer.complete_state is not None and buffer.complete_state.current_completion:
            buffer.complete_state = None  # Enter takes what is chosen in the menu
            return
        at_end = not buffer.document.text_after_cursor.strip()
        if is_unfinished(buffer.text) and at_end and not buffer.text.endswith("\n"):
            buffer.insert_text("\n    ")
        else:
            buffer.validate_and_handle()

    @bindings.add("escape", "enter")
    def _(event: KeyPressEvent) -> None:
        event.current_buffer.insert_text("\n")

    return bindings


def _toolbar(session: Session) -> str:
    state = session.state
    score = "" if state.score is None else f"   score {state.score:.4g}"
    return f" {Path(state.program.name).name}   {told(state)}{score}"


class LineCompleter(Completer):
    """The completions of a session as prompt_toolkit wants them."""

    def __init__(self, session: Session):
        self.session = session

    def get_completions(self, document: Document, event: CompleteEvent) -> Iterable[Offer]:
        offset = document.cursor_position
        before = document.text[:offset]
        # While one types, a menu that lists everything is in the way.
        if event.text_inserted and not (before[-1:].isalnum() or before[-1:] in "_=:{([@| "):
            return
        if event.text_inserted and not before.strip():
            return
        try:
            found = complete_line(document.text, offset, self.session.state)
        except Exception:  # a menu is no reason to lose what is being typed
            return
        for each in found:
            if each.text == document.text[each.start : each.end]:
                continue
            yield Offer(
                each.text,
                start_position=each.start - offset,
                display_meta=each.detail or each.kind,
            )
