"""A study for people: a folder of pages that any host can serve, and beside it what only the
researchers see.

`public` holds the pages and the films under names that tell nothing; `scripts` and `key.csv` hold
what they are. Nothing is ever deleted, so that answers of an earlier kit can still be read.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from i2pdsl.errors import Diagnostic, Span, StoryError
from i2pdsl.fit.judgements import SECOND, read_table
from i2pdsl.language.statements import read_source
from i2pdsl.render.alone import Alone
from i2pdsl.render.film_page import as_json, one_script, part
from i2pdsl.render.markup import plain
from i2pdsl.render.pictures import drawing_for
from i2pdsl.resources import write_text
from i2pdsl.scripts import Script
from i2pdsl.study.deal import dealt
from i2pdsl.study.spec import CHOICE, HIGH, PAIR, SLIDER, Film, Item, Study

LISTS = 240  # of which each participant is dealt one
USUAL = 40  # films to a participant, at most
KEY = ("script", "condition", "method", "seed")
ANSWERING = 8.0  # seconds that an answer takes, about


@dataclass(frozen=True)
class Kit:
    """What was written.

    Attributes:
        folder: all of it; `public` of it is for a host.
        films: how many there are, `each` how many a participant sees.
    """

    folder: Path
    films: int
    each: int
    lists: int

    @property
    def public(self) -> Path:
        return self.folder / "public"


def write_kit(
    folder: Path,
    study: Study,
    scripts: Mapping[Film, Path],
    practice: Sequence[Script],
    each: int | None = None,
) -> Kit:
    """Writes the folder.

    Args:
        scripts: the file of each film's script.
        practice: one script, or the two of a pair, that are none of the study's.
        each: how many films (or pairs) a participant sees; USUAL, or all if there are fewer.

    Raises StoryError where a script cannot be read.
    """
    items = study.items
    count = min(USUAL, len(items)) if each is None else min(each, len(items))
    shown = {film: Script.load(scripts[film]) for item in items for film in item.films}
    names = {film: _name(study, film, script) for film, script in shown.items()}
    drawn = drawing_for(practice[0].world.spec).alone(
        [*shown.values(), *practice], places=len(items[0].films)
    )
    public = folder / "public"
    films = dict(zip([*names.values(), *_practice_names(practice)], drawn, strict=True))
    for name, bare in films.items():
        write_text(public / "films" / f"{name}.js", f'FILM("{name}",{as_json(_film(bare))});\n')
    for film, name in names.items():
        shown[film].save(folder / "scripts" / f"{name}.json")
    seconds = [sum(film.seconds) for film in drawn]
    about = _about(study, items, names, _practice_names(practice), count, max(seconds))
    minutes = round(count * (sum(seconds) / len(seconds) + ANSWERING) / 60) + 2
    _write_pages(public, study, about, drawn[0].script, minutes)
    _write_key(folder / "key.csv", names)
    write_text(folder / "README.txt", _read_me(study, minutes))
    return Kit(folder, len(shown), count, LISTS)


def _name(study: Study, film: Film, script: Script) -> str:
    """Of a film: the same whenever the same is shown, and it tells nothing."""
    content = json.dumps([study.name, film.place, script.record.as_json()])
    digest = hashlib.sha256(content.encode("utf-8", "surrogatepass")).digest()
    return "f" + base64.b32encode(digest)[:9].decode().lower()


def _practice_names(practice: Sequence[Script]) -> list[str]:
    return [f"practice{number}" for number in range(1, len(practice) + 1)]


def _film(film: Alone) -> dict[str, Any]:
    """What kit.js reads of a film."""
    return {
        "stages": list(film.stages),
        "aspect": round(film.aspect, 4),
        "seconds": [round(seconds, 4) for seconds in film.seconds],
        "data": film.data,
        "told": list(film.told),
    }


# ----------------------------------------------------------------------------------- the pages


def _about(
    study: Study,
    items: Sequence[Item],
    names: Mapping[Film, str],
    practice: Sequence[str],
    each: int,
    longest: float,
) -> dict[str, Any]:
    """What kit.js reads of the study; no condition and no method is among it."""
    shown: list[list[str]] = []
    cells: dict[tuple[str, str], list[list[int]]] = {}
    ordered = sorted(items, key=lambda item: [names[film] for film in item.films])
    for item in ordered:  # the order of names that tell nothing
        films = [names[film] for film in item.films]
        ways = [films] if len(films) == 1 else [films, films[::-1]]
        numbers = list(range(len(shown), len(shown) + len(ways)))
        shown += ways
        cells.setdefault((item.group, item.method), []).append(numbers)
    seed = int(hashlib.sha256(repr(shown).encode()).hexdigest()[:8], 16)
    lists = dealt(cells, each, LISTS, seed)
    digest = hashlib.sha256(repr((shown, lists)).encode()).hexdigest()[:6]
    asked, check = study.question, _check(study)
    return {
        "id": f"{study.name}-{digest}",
        "name": asked_as(study),
        "question": asked.ask,
        "answers": _answers(study),
        "check": {"question": check[0], "answer": check[1]},
        "instructions": _instructions(study, len(lists[0]), longest),
        "feedback": _feedback(study, len(lists[0])),
        "practice": list(practice),
        "items": shown,
        "lists": lists,
    }


def asked_as(study: Study) -> str:
    """What stands in the column `question` of a study's answers: an expression that `i2p fit`
    takes, or the name of the study, where labels are chosen."""
    asked = study.question
    return asked.believed(asked.event) if asked.kind == SLIDER else study.name


def _answers(study: Study) -> dict[str, Any]:
    asked = study.question
    told: dict[str, Any] = {"kind": asked.kind}
    if asked.kind == CHOICE:
        return told | {"options": [{"value": a.name, "label": a.label} for a in study.answers]}
    return told if asked.kind == PAIR else told | {"low": asked.low, "high": asked.high}


def _check(study: Study) -> tuple[str, str]:
    """What is asked to see whether somebody reads, and the answer that shows it."""
    told = "This question is different: it is here to show that you read it. Whatever you saw,"
    if study.question.kind == CHOICE:
        last = study.answers[-1]
        return f"{told} please choose “{last.label}”.", last.name
    if study.question.kind == PAIR:
        return f"{told} please choose “Film B”.", SECOND
    return f"{told} please move the slider all the way to the right.", HIGH


def _noun(study: Study) -> str:
    return "pair of films" if study.question.kind == PAIR else "film"


def _instructions(study: Study, count: int, longest: float) -> str:
    several = "pairs of short films" if study.question.kind == PAIR else "short films"
    how = {
        CHOICE: "Choose the answer that says best how it looked to you.",
        PAIR: "Choose one of the two, also where you are not sure.",
    }.get(study.question.kind, "Move the slider to where it says best how it looked to you.")
    return (
        f"You will see {count} {several}, one after the other. Each lasts "
        f"{max(1, round(longest))} seconds or less.\n\n"
        f"After each one we ask: “{study.question.ask}” {how}\n\n"
        f"You may watch a {_noun(study)} as often as you like before you answer. Afterwards you "
        "cannot go back to it. If you reload the page or come back later, you go on where you were."
        "\n\nBefore it begins there is one to practise."
    )


def _feedback(study: Study, count: int) -> str:
    return (
        "There is no right or wrong answer: what counts is how it looks to you.\n\n"
        f"This answer does not count yet. Now come {count} more, and one question among them is "
        "there to see whether questions are read."
    )


def _write_pages(
    public: Path, study: Study, about: Mapping[str, Any], stage: str, minutes: int
) -> None:
    page = lambda name: (files("i2pdsl.study") / "page" / name).read_text(encoding="utf-8")
    filled = lambda name, **values: Template(page(name)).substitute(values)
    write_text(public / "index.html", filled("index.html", title=plain(study.title)))
    write_text(public / "style.css", part("page/page.css") + page("kit.css"))
    write_text(public / "stage.js", one_script(stage, "page/clock.js"))
    write_text(public / "kit.js", page("kit.js"))
    write_text(public / "study.js", f"window.STUDY = {as_json(about)};\n")
    if not (public / "settings.js").exists():  # the researchers' own
        write_text(public / "settings.js", filled("settings.js", minutes=minutes))


# --------------------------------------------------------------------- what researchers have


def _write_key(path: Path, names: Mapping[Film, str]) -> None:
    """Which film is what; those of earlier kits stay."""
    known = read_key(path) if path.exists() else {}
    known |= {name: film for film, name in names.items()}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(KEY)
    for name, film in known.items():
        writer.writerow([f"scripts/{name}.json", film.condition, film.method, film.seed])
    write_text(path, text.getvalue())


def read_key(path: Path) -> dict[str, Film]:
    """Which film is what, by the name of its script. Raises StoryError."""
    source = read_source(path)
    rows = read_table(source)
    head = next(rows, [])
    if [text for text, _ in head] != list(KEY):
        message = f"this is no key of a study: its first line is {','.join(KEY)}"
        raise StoryError([Diagnostic("table", message, Span(source, 0, 0))])
    found = {}
    for cells in rows:
        texts = [text for text, _ in cells]
        if len(texts) != len(KEY) or not (texts[3].isdecimal() and texts[3].isascii()):
            message = "this is no line of a key"
            raise StoryError([Diagnostic("table", message, cells[0][1].to(cells[-1][1]))])
        found[Path(texts[0]).stem] = Film(texts[1], texts[2], int(texts[3]))
    return found


def fit_options(study: Study) -> str:
    """How `i2p fit` is told what the answers mean."""
    asked = study.question
    assumed = f'--assume "{asked.assume}"'
    if asked.kind == PAIR:
        return f'--pair "{asked_as(study)}:{asked.believed(asked.event)}" {assumed}'
    if asked.kind != CHOICE:
        return f"--scale 100 {assumed}"
    sure = [f"{a.name}={asked.believed(a.event)}" for a in study.answers if a.event]
    unsure = [f"{a.name}=1 / {len(sure) + 1}" for a in study.answers if not a.event]
    return f'--choice "{asked_as(study)}:{";".join([*sure, *unsure])}" {assumed}'


def _read_me(study: Study, minutes: int) -> str:
    fit = fit_options(study)
    return f"""\
{study.title}: a study for people, made by `i2p study --kit`.

1. Edit public/settings.js: the text of the consent, and if you like where answers are posted to and
   the code that participants get in the end. It is never written again.
2. Open public/index.html, or put the folder `public`, and only that, on any host. It takes a
   participant about {minutes} minutes. Links may carry who comes: index.html?PROLIFIC_PID=...,
   ?participant=..., ?workerId=...; ?list=0 to ?list={LISTS - 1} choose what is shown.
3. Keep `scripts` and `key.csv` to yourself: they tell which film is what.
4. Put the answers' files here, beside `key.csv`, and:

    i2p study {study.path.name} --analyse .

   (with the path of the study's file). It writes all answers as one table, answers.csv.
   The audience that these people are:

    i2p fit answers.csv {fit} -o people.toml
"""
