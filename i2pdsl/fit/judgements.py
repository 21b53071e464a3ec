"""People's judgements as they come: a table with a row for each answer.

Its columns are `participant, script, frame, question, answer` (interfaces.md), and where two films
were compared `other`, the second one's script. Anybody may have
written it, so every cell is looked at, and every mistake is told with its line and column.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from i2pdsl.errors import Diagnostic, Source, Span, StoryError, did_you_mean, first_of, shorten
from i2pdsl.language.statements import read_source

COLUMNS = ("participant", "script", "frame", "question", "answer")
OTHER = "other"
FIRST, SECOND = "first", "second"  # of two films
LAST = "T"  # the frame after which everything was seen
SEPARATORS = ",;\t"
_SIGNS = {",": "a comma", ";": "a semicolon", "\t": "a tab"}
_CELLS = {sign: re.compile(rf' *(?:"(?:[^"]|"")*"|[^{sign}\n]*)') for sign in SEPARATORS}


@dataclass(frozen=True)
class Choice:
    """A question that is answered by choosing one of several named events: label -> expression."""

    options: Mapping[str, str]


@dataclass(frozen=True)
class Pair:
    """A question that is answered by choosing the film of two of which an expression says more."""

    value: str


Named = Mapping[str, Choice | Pair]
"""What questions mean that stand in a table by a name."""


@dataclass(frozen=True)
class Judgement:
    """One answer of one person.

    Attributes:
        frame: how much of the script was seen; None for all of it.
        question: the text in the table.
        answer: between 0 and 1, the label of a choice, or FIRST or SECOND.
        other: of two films the second one's script.
        more: what its row says in further columns.
    """

    participant: str
    script: str
    frame: int | None
    question: str
    answer: float | str
    other: str | None = None
    more: Mapping[str, str] = field(default_factory=dict)
    spans: Mapping[str, Span] = field(compare=False, repr=False, default_factory=dict)

    @property
    def scripts(self) -> Iterator[tuple[str, str]]:
        """What was seen: columns with what stands there."""
        yield "script", self.script
        if self.other is not None:
            yield OTHER, self.other

    def wrong(self, column: str, message: str, hint: str | None = None) -> Diagnostic:
        """What is wrong with one of its cells."""
        return Diagnostic("judgement", message, self.spans[column], hint)


def read_judgements(
    path: Path | str,
    scale: float = 1.0,
    question: str | None = None,
    named: Named | None = None,
) -> tuple[Judgement, ...]:
    """The judgements of a CSV or Parquet file.

    Args:
        scale: what an answer of certainty is: 1, or 100 for sliders from 0 to 100.
        question: what was asked where the table has no such column, or an empty cell.
        named: what is meant by the names that stand in the table's column `question`.

    Raises StoryError with the table's mistakes; ImportError where a Parquet file needs what is not
    installed.
    """
    source = _as_csv(Path(path))
    rows = read_table(source)
    head = next(rows, None)
    if head is None:
        message, hint = "the table is empty", f"its first line is {','.join(COLUMNS)}"
        raise StoryError([Diagnostic("table", message, Span(source, 0, 0), hint)])
    names = [name for name, _ in head]
    problems = _wrong_head(head, needs_question=question is None)
    if problems:
        raise StoryError(problems)
    reader = _Reader(scale, question, named or {}, names, _separator(source.text))
    texts = ((cells, [text for text, _ in cells]) for cells in rows)
    # Tables that were put behind each other repeat their first line.
    found = [reader.judgement(cells) for cells, row in texts if any(row) and row != names]
    if reader.problems:
        raise StoryError(first_of(reader.problems))
    if not found:
        end = Span(source, len(source.text), len(source.text))
        raise StoryError([Diagnostic("table", "the table has no answers", end)])
    return tuple(judgement for judgement in found if judgement is not None)


def repeated(judgements: tuple[Judgement, ...]) -> str | None:
    """What is to be said where somebody was asked the same twice, as in a file that was joined to
    itself; None where nobody was."""
    first: dict[tuple[object, ...], Judgement] = {}
    again = []
    for each in judgements:
        key = (each.participant, each.script, each.other, each.frame, each.question)
        if first.setdefault(key, each) is not each:
            again.append(each)
    if not again:
        return None
    span = again[0].spans["participant"]
    line, _ = span.source.position(span.start)
    return (
        f"{len(again)} of {len(judgements)} answers are to what the same person was asked before "
        f"(first in line {line}); all of them count"
    )


def _as_csv(path: Path) -> Source:
    """The text of a table; what Parquet holds is shown as the CSV that says the same."""
    if path.suffix.lower() != ".parquet":
        return read_source(path)
    from i2pdsl.answers import optional
    from i2pdsl.errors import error, whole_file

    pandas = optional("pandas")
    try:
        table = pandas.read_parquet(path)
    except (OSError, ValueError) as problem:
        reason = " ".join(str(problem).split())
        raise error("no-file", f"it is no Parquet table: {reason}", whole_file(str(path))) from None
    return Source(str(path), table.to_csv(index=False, lineterminator="\n"))


def read_table(source: Source) -> Iterator[list[tuple[str, Span]]]:
    """The rows as texts of cells with their places."""
    at = 0
    text = source.text
    separator = _separator(text)
    while at < len(text):
        cells: list[tuple[str, Span]] = []
        while True:
            found = _CELLS[separator].match(text, at)
            assert found is not None, "it matches nothing as well"
            begin = at + len(found[0]) - len(found[0].lstrip(" \r"))
            end = at + len(found[0].rstrip())
            cells.append((_plain(text[begin:end]), Span(source, min(begin, end), end)))
            at = found.end()
            if text[at : at + 1] != separator:
                break
            at += 1
        rest = text.find("\n", at)
        after = len(text) if rest < 0 else rest
        if text[at:after].strip():
            message = "there is more behind the closing quote"
            raise StoryError([Diagnostic("table", message, Span(source, at, after))])
        at = after + 1
        yield cells


def _separator(text: str) -> str:
    """What stands between cells: of the signs that spreadsheets write the most frequent in the
    first line."""
    head = text.partition("\n")[0]
    return max(SEPARATORS, key=head.count)


def _plain(cell: str) -> str:
    return next(csv.reader(io.StringIO(cell)), [""])[0].strip() if cell[:1] == '"' else cell


def _wrong_head(head: list[tuple[str, Span]], needs_question: bool) -> list[Diagnostic]:
    names = [name for name, _ in head]
    optional = {"frame"} | (set() if needs_question else {"question"})
    problems = []
    for name, span in head:
        if names.count(name) > 1:
            problems.append(Diagnostic("table", f"two columns are called `{shorten(name)}`", span))
    for column in COLUMNS:
        if column not in names and column not in optional:
            hint = did_you_mean(column, names) if names else None
            if column == "question":
                hint = "or say what was asked with `--question EXPRESSION`"
            message = f"there is no column `{column}`"
            problems.append(Diagnostic("table", message, head[0][1].to(head[-1][1]), hint))
    return problems


@dataclass
class _Reader:
    """Reads rows; collects what is wrong with them."""

    scale: float
    question: str | None
    named: Named
    names: list[str]
    separator: str
    problems: list[Diagnostic] = field(default_factory=list)

    def judgement(self, cells: list[tuple[str, Span]]) -> Judgement | None:
        """A row as a judgement; None, and a mistake, where it is none."""
        before = len(self.problems)
        if len(cells) != len(self.names):
            message = f"there are {len(cells)} cells, and {len(self.names)} columns"
            hint = f"a cell with {_SIGNS[self.separator]} in it stands in quotes"
            self.problem(message, cells[0][1].to(cells[-1][1]), hint)
            return None
        row = dict(zip(self.names, cells, strict=True))
        spans = {name: span for name, (_, span) in row.items()}
        texts = {name: text for name, (text, _) in row.items()}
        question = texts.get("question") or self.question or ""
        spans.setdefault("question", cells[0][1])
        spans.setdefault("frame", cells[0][1])
        for column in ("participant", "script", "answer"):
            if not texts[column]:
                self.problem(f"`{column}` is empty", spans[column])
        if not question:
            self.problem("nothing was asked", spans["question"], "or give `--question EXPRESSION`")
        frame = self.frame(texts.get("frame", LAST) or LAST, spans["frame"])
        other = texts.get(OTHER) or None
        if other is None and isinstance(self.named.get(question), Pair):
            message = f"`{shorten(question)}` is about two films, and there is no second one"
            self.problem(message, spans.get(OTHER, spans["script"]), "its script stands in `other`")
        elif other is not None and isinstance(self.named.get(question), Choice):
            message = f"`{shorten(question)}` is a choice among events, about one film"
            self.problem(message, spans[OTHER], "what is asked of two films, `--pair` says")
        of_two = other is not None or isinstance(self.named.get(question), Pair)
        answer = self.answer(texts["answer"], question, of_two, spans["answer"])
        if len(self.problems) > before:
            return None
        more = {name: text for name, text in texts.items() if name not in (*COLUMNS, OTHER)}
        return Judgement(
            texts["participant"], texts["script"], frame, question, answer, other, more, spans
        )

    def frame(self, text: str, span: Span) -> int | None:
        if text == LAST:
            return None
        number = text.removesuffix(".0")
        if not (number.isdecimal() and number.isascii() and len(number) < 10):
            message = f"`{shorten(text)}` is no frame"
            self.problem(message, span, f"a number from 0, or `{LAST}` for the whole script")
            return None
        return int(number)

    def answer(self, text: str, question: str, of_two: bool, span: Span) -> float | str:
        asked = self.named.get(question)
        if of_two:
            if text not in (FIRST, SECOND):
                message = f"of two films `{shorten(text)}` is neither `{FIRST}` nor `{SECOND}`"
                self.problem(message, span, did_you_mean(text, (FIRST, SECOND)))
            return text
        if isinstance(asked, Choice):
            if text not in asked.options:
                message = f"`{shorten(text)}` is none of the choices of `{shorten(question)}`"
                self.problem(message, span, did_you_mean(text, asked.options))
            return text
        # Where a semicolon stands between cells, a comma may stand before decimals.
        plain = text if self.separator == "," else text.replace(",", ".")
        try:
            number = float(plain) / self.scale
        except ValueError:
            number = math.nan
        if not 0 <= number <= 1:
            high = f"{self.scale:g}"
            what = f"`{shorten(text)}` is no answer between 0 and {high}"
            wide = not math.isnan(number) and self.scale == 1 and number <= 100
            self.problem(what, span, "sliders from 0 to 100 need `--scale 100`" if wide else None)
        return number

    def problem(self, message: str, span: Span, hint: str | None = None) -> None:
        self.problems.append(Diagnostic("table", message, span, hint))
