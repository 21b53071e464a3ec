"""What people answered, from the tables that a kit hands over, or any like them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from i2pdsl.errors import Diagnostic, StoryError, error, first_of, shorten, whole_file
from i2pdsl.fit.judgements import Choice, Judgement, Named, Pair, read_judgements
from i2pdsl.study.answers import Answers
from i2pdsl.study.check import Ground
from i2pdsl.study.kit import asked_as, read_key
from i2pdsl.study.spec import SLIDER, Film, Item, Study

KEY = "key.csv"
CELL = ("condition", "method", "seed")  # columns that tell what a film is, without a key
FAILED, PARTIAL = "attention", "incomplete"

Known = Callable[[Path], Film | None]
"""The film of a script's path, where it is one of the study's own."""

Grounds = Mapping[tuple[str, str], Ground]
"""What films are about, by condition and method."""


@dataclass(frozen=True)
class Collected:
    """People's answers.

    Attributes:
        rows: those that count, and `folders` where the table of each lies.
        excluded: participants who do not count, by why.
        twice: answers about a film that the participant had answered already.
    """

    answers: Answers
    rows: tuple[Judgement, ...] = field(repr=False)
    items: tuple[Item, ...] = field(repr=False)
    folders: tuple[Path, ...] = field(repr=False)
    excluded: dict[str, tuple[str, ...]]
    twice: int


def tables_in(places: Iterable[Path]) -> list[Path]:
    """The tables among files and folders, without keys. Raises StoryError where there are none."""
    found: list[Path] = []
    for place in places:
        inside = sorted(place.glob("*.csv")) if place.is_dir() else [place]
        tables = [path for path in inside if path.name != KEY]
        if not tables:
            raise error("no-file", "there is no table of answers here", whole_file(str(place)))
        found += tables
    return list(dict.fromkeys(found))


def collect(
    study: Study,
    tables: Sequence[Path],
    known: Known,
    keep_all: bool,
    grounds: Grounds | None = None,
) -> Collected:
    """Reads tables.

    Args:
        known: what a script is that no key names.
        keep_all: whether those count, too, who failed an attention check or stopped early.
        grounds: by which a question is known that is put in other words than the study's now, as
            an earlier kit may have it; without them none is.

    Raises StoryError with the mistakes of a table, at the cells that are wrong.
    """
    rows: list[Judgement] = []
    items: list[Item] = []
    flips: list[bool] = []
    folders: list[Path] = []
    for table in tables:
        found = _read(study, table)
        finder = _Finder(study, table.parent, known, grounds or {})
        for row in found:
            item, flipped = finder.item(row)
            rows.append(finder.asked(row, item.films[0]))
            items.append(item)
            flips.append(flipped)
            folders.append(table.parent)
        if finder.problems:
            raise StoryError(first_of(finder.problems))
    excluded = {} if keep_all else _excluded(rows)
    out = {name for names in excluded.values() for name in names}
    counted = [n for n, row in enumerate(rows) if row.participant not in out]
    if not counted:
        message = "nobody is left: everybody failed an attention check or stopped early"
        raise error("table", message, whole_file(str(tables[0])), "`--keep-all` counts them, too")
    people = tuple(dict.fromkeys(rows[n].participant for n in counted))
    shown = [item for item in study.items if item in {items[n] for n in counted}]
    given = np.full((len(people), len(shown)), np.nan)
    names = Answers(study, people, tuple(shown), given).names
    who = {name: number for number, name in enumerate(people)}
    which = {item: number for number, item in enumerate(shown)}
    used = []
    for n in counted:
        place = who[rows[n].participant], which[items[n]]
        if np.isnan(given[place]):  # the first answer counts
            given[place] = _number(rows[n], names, flips[n])
            used.append(n)
    of = lambda values: tuple(values[n] for n in used)
    answers = Answers(study, people, tuple(shown), given)
    twice = len(counted) - len(used)
    return Collected(answers, of(rows), of(items), of(folders), excluded, twice)


def _read(study: Study, table: Path) -> tuple[Judgement, ...]:
    asked, scale = asked_as(study), 100
    named: Named = {}
    match study.question.kind:
        case "choice":
            named = {asked: Choice(dict.fromkeys((a.name for a in study.answers), ""))}
        case "pair":
            named = {asked: Pair("")}
    found = read_judgements(table, scale, asked, named)
    wrong = [row for row in found if row.question != asked]
    if wrong and study.question.kind != SLIDER:  # else it may mean the same
        message = f"the study asks `{asked}`"
        raise StoryError(first_of([row.wrong("question", message) for row in wrong]))
    return found


def _number(row: Judgement, names: Sequence[str], flipped: bool) -> float:
    """An answer as Answers.given has it; of a pair for its films in the study's order."""
    if not names:
        return 100 * float(row.answer)
    number = names.index(str(row.answer))
    return float(1 - number if flipped else number)


class _Finder:
    """What the rows of a folder's tables are about; collects what is wrong with them."""

    def __init__(self, study: Study, folder: Path, known: Known, grounds: Grounds):
        self.study, self.folder, self.known, self.grounds = study, folder, known, grounds
        self.right = asked_as(study)
        self.means: dict[tuple[object, ...], bool] = {}  # of other questions, by film
        keys = [place / KEY for place in (folder, folder.parent) if (place / KEY).is_file()]
        self.key = read_key(keys[0]) if keys else {}
        self.problems: list[Diagnostic] = []
        self.unknown: set[str] = set()  # scripts that were told of
        self.items = {item.films: item for item in study.items}

    def item(self, row: Judgement) -> tuple[Item, bool]:
        """What was shown, and whether a pair stood the other way round."""
        nothing = self.study.items[0], False
        films = [self.film(row, "script", row.script)]
        if row.other is not None:
            films.append(self.film(row, "other", row.other))
        shown = tuple(film for film in films if film is not None)
        if len(shown) < len(films):
            return nothing
        for order, flipped in ((shown, False), (shown[::-1], True)):
            if order in self.items:
                return self.items[order], flipped
        named = " beside ".join(film.place for film in shown)
        self.problem(row, "script", f"the study does not show {named}")
        return nothing

    def film(self, row: Judgement, column: str, name: str) -> Film | None:
        if Path(name).stem in self.key:
            return self.key[Path(name).stem]
        told = [row.more.get(each, "") for each in CELL]
        if column == "script" and all(told) and told[2].isdecimal() and told[2].isascii():
            return Film(told[0], told[1], int(told[2]))
        film = self.known(self.folder / name)
        if film is None and name not in self.unknown:
            self.unknown.add(name)
            message = f"`{shorten(name)}` is no film of the study"
            hint = f"is `{KEY}` of the kit beside the table? or `--out` the folder of its films?"
            self.problem(row, column, message, hint)
        return film

    def asked(self, row: Judgement, film: Film) -> Judgement:
        """The row with the study's question, if that is what it asks."""
        if row.question != self.right:
            key = row.question, row.frame, film.condition, film.method
            if key not in self.means:
                self.means[key] = self.is_asked(*key)
            if not self.means[key]:
                self.problem(row, "question", f"the study asks `{self.right}`")
        return replace(row, question=self.right)

    def is_asked(self, question: str, frame: int | None, condition: str, method: str) -> bool:
        """Whether a question means the study's own."""
        ground = self.grounds.get((condition, method))
        if ground is None:
            return False
        try:
            return ground.asked(question, frame) == ground.asked(self.right, None)
        except StoryError:
            return False

    def problem(self, row: Judgement, column: str, message: str, hint: str | None = None) -> None:
        self.problems.append(row.wrong(column, message, hint))


def _excluded(rows: Sequence[Judgement]) -> dict[str, tuple[str, ...]]:
    """Who failed an attention check, and who, having passed, stopped early."""
    failed = dict.fromkeys(r.participant for r in rows if r.more.get("attention") == "failed")
    partial = dict.fromkeys(r.participant for r in rows if r.more.get("complete") == "no")
    found = {FAILED: tuple(failed), PARTIAL: tuple(p for p in partial if p not in failed)}
    return {why: names for why, names in found.items() if names}
