"""Answers of viewers, simulated or not: the table that `i2p study --analyse` and `i2p fit` read.

A row for each answer: `participant, script, frame, question, answer`, and of a pair of films
`other`, the second one's script. `answer` is the name of an answer, a slider's position from 0 to
100, or `first` or `second`.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from i2pdsl.fit.judgements import FIRST, OTHER, SECOND
from i2pdsl.study.films import Films
from i2pdsl.study.panel import (
    Viewer,
    beliefs,
    chances,
    first_chosen,
    positions,
    viewers_of,
)
from i2pdsl.study.spec import (
    CHOICE,
    HIGH,
    PAIR,
    SLIDER,
    Film,
    Item,
    Panel,
    Study,
)
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.record import Trajectory, read_record

LAST = "T"  # the frame after which it is asked


@dataclass(frozen=True)
class Answers:
    """What participants answered.

    Attributes:
        participants: their names, [P].
        items: what they were shown, [I].
        given: what each answered to each, [P, I]: the number of an answer of a choice, a position,
            0 for the first film of a pair and 1 for the second; NaN where nothing was asked.
    """

    study: Study
    participants: tuple[str, ...]
    items: tuple[Item, ...]
    given: np.ndarray

    @property
    def names(self) -> tuple[str, ...]:
        """Of the answers, by their numbers; none for sliders."""
        match self.study.question.kind:
            case "choice":
                return tuple(answer.name for answer in self.study.answers)
            case "pair":
                return FIRST, SECOND
            case _:
                return ()

    @property
    def matches(self) -> np.ndarray:
        """Whether each answer matches what the film is to show, [P, I]; NaN where there is none."""
        found = np.full(self.given.shape, np.nan)
        there = ~np.isnan(self.given)
        for number, item in enumerate(self.items):
            own = self.given[:, number]
            if self.names:
                right = own == self.names.index(item.right)
            else:
                right = own > 50 if item.right == HIGH else own < 50
            found[:, number] = np.where(there[:, number], right, np.nan)
        return found

    def columns(self, script_of: Callable[[Film], str]) -> dict[str, list[Any]]:
        """The table. `script_of` gives the path of a film's script as it stands there."""
        asked = self.study.question
        question = asked.believed(asked.event) if asked.kind == SLIDER else self.study.name
        found: dict[str, list[Any]] = {name: [] for name in ("participant", "script")}
        if asked.kind == PAIR:
            found[OTHER] = []
        found |= {name: [] for name in ("frame", "question", "answer")}
        for p, i in zip(*np.nonzero(~np.isnan(self.given)), strict=True):
            value, films = self.given[p, i], self.items[i].films
            for name, film in zip(("script", OTHER), films, strict=False):
                found[name].append(script_of(film))
            found["participant"].append(self.participants[p])
            found["frame"].append(LAST)
            found["question"].append(question)
            found["answer"].append(self.names[int(value)] if self.names else int(value))
        return found


def panel_answers(
    panel: Panel, films: Films, watch: Watch, report: Callable[[int, int], None] = lambda *_: None
) -> Answers:
    """What a simulated panel answers about the films that are there; `report` is told how many
    groups of films are watched. Raises StoryError."""
    study = films.study
    viewers = viewers_of(panel, [ground.vocabulary for ground in films.grounds.values()])
    believed = _beliefs(viewers, films, watch, report)
    items = [item for item in study.items if all(film in believed for film in item.films)]
    given = np.full((len(viewers), len(items)), np.nan)
    for number, item in enumerate(items):
        # Random numbers of its own: a film or a viewer more changes no other answer.
        own = zlib.crc32(" ".join(film.place for film in item.films).encode())
        draws = np.random.default_rng([panel.seed, own]).random((len(viewers), 2))
        seen = [believed[film] for film in item.films]  # [V, E] each
        for who, viewer in enumerate(viewers):
            told = [belief[who][None] for belief in seen]
            if study.question.kind == PAIR:
                (chosen,) = first_chosen(viewer, told[0][:, 0], told[1][:, 0])
                given[who, number] = draws[who, 0] >= chosen
            elif study.question.kind == CHOICE:
                upto = np.cumsum(chances(study, viewer, told[0]), axis=1)
                given[who, number] = (draws[who, 0] >= upto[0, :-1]).sum()
            else:
                (given[who, number],) = positions(viewer, told[0][:, 0], draws[who][None])
    names = tuple(f"{panel.name}-{number}" for number in range(1, len(viewers) + 1))
    return Answers(study, names, tuple(items), given)


def _beliefs(
    viewers: Sequence[Viewer], films: Films, watch: Watch, report: Callable[[int, int], None]
) -> dict[Film, np.ndarray]:
    """P(event) of all viewers at each film that is there, [V, E]."""
    study, found = films.study, dict[Film, np.ndarray]()
    for done, ((condition, method), ground) in enumerate(films.grounds.items()):
        report(done, len(films.grounds))
        rules = kind_of(ground.spec).rules(ground.spec)
        read: dict[int, list[tuple[Film, Trajectory]]] = {}
        for seed in study.seeds:
            film = Film(condition, method, seed)
            path = films.path(film)
            if path is not None:
                script = kind_of(ground.spec).read(rules, read_record(path))
                read.setdefault(len(script.actions), []).append((film, script))
        for alike in read.values():
            paths = [script for _, script in alike]
            believed = beliefs(study, viewers, ground, paths, watch)
            found |= {film: believed[:, n] for n, (film, _) in enumerate(alike)}
    return found
