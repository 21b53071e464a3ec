"""The magics of notebooks: `%%story` makes a story, `%query` and `%%query` ask about it."""

from __future__ import annotations

import keyword
import re
import shlex
import sys
from pathlib import Path
from typing import Any

from IPython.core.error import UsageError
from IPython.core.interactiveshell import InteractiveShell
from IPython.core.magic import Magics, cell_magic, line_cell_magic, magics_class, no_var_expand
from IPython.core.magic_arguments import MagicArgumentParser
from IPython.display import display

from i2pdsl.answers import Answer
from i2pdsl.errors import Diagnostic, Source, StoryError
from i2pdsl.notebook.progress import CellBars
from i2pdsl.notebook.source import placed
from i2pdsl.progress import Bars
from i2pdsl.stories import Result, Script, Story, story_from

SCRIPT = "script"  # the usual name of the variable


def load_magics(shell: InteractiveShell) -> None:
    """Registers the magics."""
    shell.register_magics(StoryMagics)


def _story_arguments() -> MagicArgumentParser:
    parser = MagicArgumentParser("%%story", description="Makes the story of the cell.")
    parser.add_argument("name", nargs="?", default=SCRIPT, metavar="NAME")
    parser.add_argument("--seed", type=int, default=0, metavar="N")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--candidates", type=int, default=1, metavar="K")
    parser.add_argument("--no-solve", action="store_true")
    return parser


OPTION = re.compile(r"""--(assume|of)(?:\s+|=)("[^"]*"|'[^']*'|\S+)\s*""")


@magics_class
class StoryMagics(Magics):
    """Magics that share the name of the script made last."""

    shell: InteractiveShell
    name = SCRIPT

    @no_var_expand
    @cell_magic
    def story(self, line: str, cell: str) -> None:
        """Makes the story of the cell, and shows it.

            %%story [NAME] [--seed N] [--set NAME=VALUE]... [--candidates K] [--no-solve]

        The script goes into the variable NAME (default: script), the checked story into
        NAME_story, and the result of the search, with all candidates, into NAME_result.
        `--no-solve` only checks: there is a NAME_story then, which is shown. Imports and worlds
        are looked for in the folder that the notebook runs in.
        """
        chosen = _story_arguments().parse_args(_words(line))
        name = chosen.name
        if not name.isidentifier() or keyword.iskeyword(name):
            raise UsageError(f"%%story: {name!r} is no name of a variable")
        if chosen.seed < 0 or not 1 <= chosen.candidates <= 100:
            raise UsageError("%%story: a seed is at least 0, and candidates are 1 to 100")
        head = f"%%story {line}".rstrip() + "\n"
        place = lambda diagnostic: placed(diagnostic, name, head + cell, len(head))
        try:
            story = story_from(Source(name, cell), Path(), [_setting(text) for text in chosen.set])
            self.shell.push({f"{name}_story": story})
            if chosen.no_solve:
                _warn(map(place, story.warnings))
                display(story)
                return
            result, said = self._solved(story, chosen.seed, chosen.candidates)
        except StoryError as problem:
            raise StoryError([place(d) for d in problem.diagnostics]) from None
        self.name = name
        self.shell.push({name: result.script, f"{name}_result": result})
        _warn(map(place, story.warnings))
        for message in said:
            print(message, file=sys.stderr)
        if not result.finished:
            print("interrupted: the best of what was searched so far is kept", file=sys.stderr)
        display(result if chosen.candidates > 1 else result.script)

    def _solved(self, story: Story, seed: int, candidates: int) -> tuple[Result, list[str]]:
        """The result, and what is to be said of it once the bars are gone."""
        if not hasattr(self.shell, "kernel"):  # IPython in a terminal
            with Bars() as bars:
                return story.solve(seed, candidates, watch=bars.watch), []
        cell = CellBars()
        with cell:
            found = story.solve(seed, candidates, watch=cell.watch)
        self.shell.display_pub.clear_output(wait=True)
        return found, cell.said

    @no_var_expand
    @line_cell_magic
    def query(self, line: str, cell: str | None = None) -> Answer | None:
        """Asks about the script that `%%story` made last (else about the variable `script`).

            %query [--assume CONDITION] [--of NAME] EXPR

            %%query [--assume CONDITION] [--of NAME]
            EXPR
            ...

        `--assume` replaces the story's assumption (`nothing` drops it; put a condition of several
        words into quotation marks), `--of` names the variable of another script. The answer can be
        kept: `answer = %query EXPR`. In a cell, each line is a question, and each answer is shown.
        """
        name, assume, rest = self.name, None, line.strip()
        while option := OPTION.match(rest):
            value, rest = option[2].strip("\"'"), rest[option.end() :]
            if option[1] == "of":
                name = value
            else:
                assume = value
        script = self.shell.user_ns.get(name)
        if not isinstance(script, Script):
            raise UsageError(f"%query: there is no script {name!r}: make one with %%story")
        if cell is None:
            if not rest:
                raise UsageError("%query: what is asked? `%query P(rho > 0 | script[:t])`")
            return _answer(script, rest, assume, rest, 0)
        if rest:
            raise UsageError("%%query: the questions stand in the lines below")
        text = f"%%query {line}".rstrip() + "\n" + cell
        start = len(text) - len(cell)
        answers = []
        for row in cell.splitlines(keepends=True):
            asked = row.strip()
            if asked and not asked.startswith("#"):
                answers.append(_answer(script, asked, assume, text, start + row.find(asked)))
            start += len(row)
        for answer in answers:
            if answer.t is None:  # curves carry their question
                print(f"{answer.expression}:")
            display(answer)
        return None


def _words(line: str) -> list[str]:
    """The words of a magic's line; quotation marks keep those of a value together."""
    try:
        return shlex.split(line)
    except ValueError as problem:
        raise UsageError(f"%%story: {problem}") from None


def _setting(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals or not name.strip().isidentifier() or not value.strip():
        raise UsageError(f"%%story: {text!r} is not NAME=VALUE")
    return name.strip(), value.strip()


def _answer(script: Script, asked: str, assume: str | None, cell: str, offset: int) -> Answer:
    """The answer to a question that stands at `offset` of a cell's text. Raises StoryError."""
    place = lambda diagnostic: placed(diagnostic, "query", cell, offset)
    try:
        _warn(map(place, script.check(asked, assume).warnings))
        return script.ask(asked, assume)
    except StoryError as problem:
        raise StoryError([place(d) for d in problem.diagnostics]) from None


def _warn(warnings: Any) -> None:
    for warning in warnings:
        assert isinstance(warning, Diagnostic)
        print(warning.render(), file=sys.stderr)
