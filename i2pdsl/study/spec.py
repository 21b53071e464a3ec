"""A study as data: what is shown, what is asked, and who answers. No arrays and no JAX."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from i2pdsl.errors import Span
from i2pdsl.fit.judgements import FIRST
from i2pdsl.untrusted import plain_name

CHOICE, SLIDER, PAIR = QUESTIONS = ("choice", "slider", "pair")
HIGH, LOW = "high", "low"  # the sides of a slider
MAXIMUM, MATCHING = RULES = ("maximum", "matching")
WORLD, EVEN = PRIORS = ("world", "even")
STORY = "story"  # the method of a study that names none


@dataclass(frozen=True)
class Condition:
    """What films are to show.

    Attributes:
        story: the path of its file, None where every method has scripts of its own.
        settings: (name, value) pairs, as behind `--set`.
        right: the answer that matches: of a choice its name, of a slider a side; empty for pairs.
        spans: where its name, its story and its settings stand in the file.
    """

    name: str
    label: str
    story: Path | None
    settings: tuple[tuple[str, str], ...]
    right: str
    spans: Mapping[str, Span] = field(compare=False, repr=False, default_factory=dict)


@dataclass(frozen=True)
class Method:
    """A way to make the films of every condition.

    Attributes:
        naive: without an audience, the characters do what is best for them.
        scripts: a folder that holds finished scripts instead, one folder for each condition.
        against: the method that it is compared with; empty where there is none.
    """

    name: str
    label: str
    naive: bool = False
    settings: tuple[tuple[str, str], ...] = ()
    scripts: Path | None = None
    against: str = ""
    spans: Mapping[str, Span] = field(compare=False, repr=False, default_factory=dict)


@dataclass(frozen=True)
class Option:
    """One of the answers of a choice.

    Attributes:
        event: of which those who choose it are sure; empty for the answer of those who are unsure.
    """

    name: str
    label: str
    event: str
    span: Span | None = field(compare=False, repr=False, default=None)


@dataclass(frozen=True)
class Question:
    """What is asked about each film, or each pair of films.

    Attributes:
        ask: in plain words.
        kind: `choice` among answers, a `slider` from 0 to 100, or one film of a `pair`.
        event: what a slider's high side claims, or what is more so in the film that is chosen.
        low, high: what stands at the ends of a slider.
        throughout: whether viewers answer by what they believed on average, not in the end.
        assume: what their beliefs are conditioned on (`nothing`: they wonder about everything).
    """

    ask: str
    kind: str
    event: str
    low: str
    high: str
    throughout: bool
    assume: str
    spans: Mapping[str, Span] = field(compare=False, repr=False, default_factory=dict)

    def believed(self, event: str) -> str:
        """How much of an event a viewer believes, as an expression about what he saw."""
        return f"mean_t P({event} | script[:t])" if self.throughout else f"P({event} | script[:T])"


@dataclass(frozen=True)
class Pair:
    """Two conditions whose films are shown side by side; `people`: the share that chose the
    first."""

    name: str
    label: str
    first: str
    second: str
    people: float | None


@dataclass(frozen=True)
class Between:
    """A number is drawn evenly between two others, or its logarithm between theirs."""

    low: float
    high: float
    in_logs: bool


@dataclass(frozen=True)
class OneOf:
    """One of some values is drawn, all equally likely."""

    values: tuple[float | str, ...]


Drawn = Between | OneOf


@dataclass(frozen=True)
class Panel:
    """The viewers who are simulated, each of whom is an audience of its own.

    Attributes:
        viewers: how many; `seed` of what is drawn.
        people: a file that `i2p fit` wrote, whose viewers they are; None where they are drawn.
        drawn: what each parameter that is given is drawn from (study/parse.py:PARAMETERS, WORDS).
        settings: the same for what they believe of how the world works (observer_settings).
    """

    name: str
    label: str
    viewers: int
    seed: int
    people: Path | None
    drawn: Mapping[str, Drawn]
    settings: Mapping[str, Drawn]
    spans: Mapping[str, Span] = field(compare=False, repr=False, default_factory=dict)

    @property
    def is_usual(self) -> bool:
        """Whether what they believe is what a story's usual audience does: then a study says only
        that the search works."""
        own = {"sharpness", "forgetting", "doubt", "prior"} & set(self.drawn)
        return self.people is None and not own and not self.settings


@dataclass(frozen=True)
class Film:
    """One film: of a condition, by a method, with a seed (or its number among given scripts)."""

    condition: str
    method: str
    seed: int

    @property
    def place(self) -> str:
        """The folder of its script, below that of the films."""
        return f"{plain_name(self.condition)}/{plain_name(self.method)}/seed-{self.seed}"


@dataclass(frozen=True)
class Item:
    """What is shown and answered at once: a film, or a pair of films.

    Attributes:
        group: the condition, or the pair.
        right: the answer that matches; of a pair `first`.
    """

    group: str
    method: str
    films: tuple[Film, ...]
    right: str


@dataclass(frozen=True)
class Study:
    """A study, read.

    Attributes:
        name: of its file.
        people: (condition, method) -> the share of people whose answer matched, where it is known.
        panels: the first one is the panel; others show how much depends on it.
    """

    name: str
    path: Path
    title: str
    seeds: tuple[int, ...]
    conditions: tuple[Condition, ...]
    methods: tuple[Method, ...]
    question: Question
    answers: tuple[Option, ...]
    pairs: tuple[Pair, ...]
    panels: tuple[Panel, ...]
    people: Mapping[tuple[str, str], float]

    def condition(self, name: str) -> Condition:
        return next(c for c in self.conditions if c.name == name)

    def method(self, name: str) -> Method:
        return next(m for m in self.methods if m.name == name)

    @property
    def groups(self) -> tuple[Condition | Pair, ...]:
        """What shares are told of, for each method."""
        return self.pairs or self.conditions

    def figure(self, group: str, method: str) -> float | None:
        """People's share for a group, where it is known."""
        pair = next((p for p in self.pairs if p.name == group), None)
        return pair.people if pair else self.people.get((group, method))

    @property
    def films(self) -> tuple[Film, ...]:
        """All films that are made or taken, in the order of conditions, methods, seeds."""
        return tuple(
            Film(c.name, m.name, seed)
            for c in self.conditions
            for m in self.methods
            for seed in self.seeds
        )

    @property
    def items(self) -> tuple[Item, ...]:
        """All that is shown, in the order of groups, methods, seeds.

        The n-th film of a pair's first condition stands beside the n-th of its second; beside the
        one after it where both are the same condition.
        """
        if not self.pairs:
            right = {c.name: c.right for c in self.conditions}
            return tuple(Item(f.condition, f.method, (f,), right[f.condition]) for f in self.films)
        found = []
        for pair in self.pairs:
            shift = int(pair.first == pair.second)
            for method in self.methods:
                for number, seed in enumerate(self.seeds):
                    other = self.seeds[(number + shift) % len(self.seeds)]
                    films = (
                        Film(pair.first, method.name, seed),
                        Film(pair.second, method.name, other),
                    )
                    found.append(Item(pair.name, method.name, films, FIRST))
        return tuple(found)
