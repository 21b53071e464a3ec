"""From a .study file to a Study, with every mistake of the file in one go.

The text is read as that of a world (worlds/blocks.py). Stories and events are looked at by
study/check.py.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from i2pdsl.errors import Note, Source, Span, StoryError, closest, first_of, shorten
from i2pdsl.language.statements import check_text, read_source
from i2pdsl.study.spec import (
    CHOICE,
    HIGH,
    LOW,
    PAIR,
    PRIORS,
    QUESTIONS,
    RULES,
    SLIDER,
    STORY,
    Between,
    Condition,
    Drawn,
    Method,
    OneOf,
    Option,
    Pair,
    Panel,
    Question,
    Study,
)
from i2pdsl.worlds.blocks import Block, BlockReader, Syntax, Value

Valid = tuple[Callable[[float], bool], str]
Settings = tuple[tuple[str, str], ...]


def _between(low: float, high: float) -> Valid:
    return lambda x: low <= x <= high, f"from {low:g} to {high:g}"


def _whole(low: int, high: int) -> Valid:
    return lambda x: x == x // 1 and low <= x <= high, f"a whole number from {low} to {high:,}"


MOST_FILMS, MOST_VIEWERS = 10_000, 10_000
PARAMETERS: dict[str, Valid] = {
    "sharpness": _between(1e-3, 1e3),
    "forgetting": _between(0, 0.5),
    "doubt": _between(0, 10),
    "confidence": _between(0, 1),
    "lapse": _between(0, 1),
    "noise": _between(0, 100),
}
"""The numbers that viewers differ in, beside settings of the world as they imagine it."""

WORDS: dict[str, tuple[str, ...]] = {"rule": RULES, "prior": PRIORS}
IN_LOGS = ("sharpness", "forgetting", "noise")
KEYS: dict[str, tuple[str, ...]] = {
    "study": ("title", "seeds"),
    "condition": ("label", "story", "set", "right"),
    "method": ("label", "naive", "set", "scripts", "against"),
    "question": ("ask", "kind", "event", "low", "high", "when", "assume"),
    "answer": ("label", "event"),
    "pair": ("label", "first", "second", "people"),
    "panel": ("label", "viewers", "seed", "people", *WORDS, *PARAMETERS),
    "people": (),  # the study's methods
}
_NAMED = ("condition", "method", "answer", "pair", "panel", "people")
SYNTAX = Syntax("study.lark", KEYS, _NAMED, what="study")


def load_study(path: Path | str) -> Study:
    """Reads a study. Raises StoryError with all mistakes of its file."""
    return parse_study(read_source(path), Path(path))


def parse_study(source: Source, path: Path) -> Study:
    """Parses the text of a study; its stories lie relative to `path`. Raises StoryError."""
    check_text(source)
    reader = _Reader(source, path)
    reader.read()
    study = reader.study()
    if reader.problems:
        raise StoryError(first_of(sorted(reader.problems, key=lambda d: d.span.start)))
    return study


class _Reader(BlockReader):
    """Turns the blocks of a file into a Study."""

    def __init__(self, source: Source, path: Path):
        super().__init__(source, SYNTAX)
        self.path = path

    def problem(
        self, code: str, message: str, span: Span, hint: str | None = None, note: Note | None = None
    ) -> None:
        super().problem(code.replace("world", "study"), message, span, hint, note)

    def study(self) -> Study:
        of = lambda keyword: [b for b in self.blocks if b.keyword == keyword]
        self.unique_names()
        for block in self.blocks:
            if block.keyword not in ("panel", "people"):
                self.known_keys(block)
        title = ""
        seeds: tuple[int, ...] = (0,)
        for block in of("study"):
            title, seeds = self.text(block, "title"), self.seeds(block)
        answers = tuple(map(self.answer, of("answer")))
        question = self.question(of("question"), of("answer"), of("pair"))
        rights = {CHOICE: [a.name for a in answers], SLIDER: [HIGH, LOW], PAIR: []}[question.kind]
        methods = tuple(self.method(b, [x.name for x in of("method")]) for b in of("method"))
        conditions = tuple(self.condition(b, rights) for b in of("condition"))
        if not of("method") and "method" not in self.unsure:
            methods = (Method(STORY, STORY),)
        self.needed(of("condition"), conditions, methods)
        names = tuple(c.name for c in conditions)
        if len(names) * len(methods) * len(seeds) > MOST_FILMS:
            whole = Span(self.source, 0, 0)
            self.problem("study-range", f"these are more than {MOST_FILMS:,} films", whole)
        return Study(
            self.path.stem,
            self.path,
            title or self.path.stem,
            seeds,
            conditions,
            methods,
            question,
            answers,
            tuple(self.pair(block, names) for block in of("pair")),
            tuple(map(self.panel, of("panel"))),
            self.people(of("people"), names, methods),
        )

    def unique_names(self) -> None:
        seen: dict[tuple[str, str], Span] = {}
        for block in self.blocks:
            other = seen.setdefault((block.keyword, block.name), block.span)
            if other is not block.span:
                message = f"there are two `{block.keyword} {block.name}`"
                if block.keyword not in _NAMED:
                    message = f"a study has only one `{block.keyword}`, this is another"
                self.problem("duplicate", message, block.span, note=Note("the other one", other))

    def needed(
        self, blocks: list[Block], conditions: tuple[Condition, ...], methods: tuple[Method, ...]
    ) -> None:
        """Reports what is missing."""
        if not blocks and not self.incomplete:
            hint = '`condition NAME` with `story = "PATH"`'
            self.problem("study-block", "the study shows nothing", Span(self.source, 0, 0), hint)
        told = [method for method in methods if method.scripts is None]
        for block, condition in zip(blocks, conditions, strict=True):
            if condition.story is None and told and not block.damaged:
                hint = 'give `story = "PATH"`, or every method `scripts = "FOLDER"`'
                message = f"`{block.name}` has no story"
                self.problem("study-block", message, block.span, hint)

    # Values.

    def text(self, block: Block, key: str) -> str:
        """A text as it was written, in quotes."""
        value = block.entries.get(key)
        if value is None:
            return ""
        if value.kind != "text":
            hint = f'write `{key} = "..."`'
            self.problem("study-value", f"`{key}` must be a text", value.span, hint)
            return ""
        return value.span.text[1:-1]

    def file(self, block: Block, key: str) -> Path | None:
        """A path, relative to the study's file."""
        name = self.text(block, key)
        return self.path.parent / name if name else None

    def seeds(self, block: Block) -> tuple[int, ...]:
        """`0`, `{0, 1}` or `"0-19"`."""
        value = block.entries.get("seeds")
        if value is None:
            return (0,)
        items = value.value if value.kind == "list" else [value]
        found: list[int] = []
        for item in items:
            first, dash, last = item.span.text.strip('"').partition("-")
            ends = [first.strip(), last.strip()] if dash else [first.strip()]
            if not all(e.isascii() and e.isdecimal() and len(e) < 10 for e in ends):
                hint = 'write `seeds = "0-19"` or `seeds = {0, 1, 4}`'
                self.problem("study-value", "these are no seeds", item.span, hint)
                continue
            span = range(int(ends[0]), int(ends[-1]) + 1)
            if not 0 < len(span) <= MOST_FILMS:
                self.problem("study-range", "this range is empty or too long", item.span)
                continue
            found += span
        return tuple(dict.fromkeys(found)) or (0,)

    def set_values(self, block: Block) -> Settings:
        """What stands behind `--set` on the command line: `set = ["length = 7"]`."""
        value = block.entries.get("set")
        if value is None:
            return ()
        found = []
        for item in value.value if value.kind == "list" else [value]:
            name, equals, text = item.span.text.strip('"').partition("=")
            if item.kind != "text" or not (equals and name.strip().isidentifier() and text.strip()):
                hint = 'write `set = ["NAME = VALUE", ...]`'
                self.problem("study-value", "this sets nothing", item.span, hint)
                continue
            found.append((name.strip(), text.strip()))
        return tuple(found)

    def one_of(self, block: Block, key: str, known: list[str], what: str) -> str:
        """The name of another block."""
        found = self.words(block, key, tuple(known), what)
        if len(found) > 1:
            self.problem("study-value", f"`{key}` is one {what}", block.entries[key].span)
        return found[0] if found else ""

    # Blocks.

    def condition(self, block: Block, rights: list[str]) -> Condition:
        right = self.one_of(block, "right", rights, "answer") if rights else ""
        if rights and "right" not in block.entries and not block.damaged:
            hint = "give `right = ANSWER`: " + ", ".join(rights)
            message = f"which answer is right for `{block.name}`?"
            self.problem("study-block", message, block.span, hint)
        return Condition(
            block.name,
            self.text(block, "label") or block.name,
            self.file(block, "story"),
            self.set_values(block),
            right,
            _spans(block),
        )

    def method(self, block: Block, names: list[str]) -> Method:
        others = [name for name in names if name != block.name]
        return Method(
            block.name,
            self.text(block, "label") or block.name,
            self.word(block, "naive", "no", ("yes", "no")) == "yes",
            self.set_values(block),
            self.file(block, "scripts"),
            self.one_of(block, "against", others, "method"),
            _spans(block),
        )

    def answer(self, block: Block) -> Option:
        label, event = self.text(block, "label") or block.name, self.text(block, "event")
        span = block.entries["event"].span if event else block.span
        return Option(block.name, label, event, span)

    def question(self, blocks: list[Block], answers: list[Block], pairs: list[Block]) -> Question:
        usual = PAIR if pairs else CHOICE
        if not blocks:
            if not self.incomplete:
                whole, hint = Span(self.source, 0, 0), '`question` with `ask = "..."`'
                self.problem("study-block", "the study asks nothing", whole, hint)
            return Question("", usual, "", "", "", False, "nothing")
        block = blocks[0]
        kind = self.word(block, "kind", usual, QUESTIONS)
        event = self.text(block, "event")
        need = lambda message, hint: (
            None
            if block.damaged or self.incomplete
            else self.problem("study-block", message, block.span, hint)
        )
        if not self.text(block, "ask"):
            need("what is asked?", 'give `ask = "..."`, in plain words')
        if kind == CHOICE and len(answers) < 2:
            need("a choice needs two answers", '`answer NAME` with `event = "..."`')
        if kind != CHOICE and not event:
            need(f"a {kind} needs an event", 'give `event = "rho > 0"`, what is more so')
        if kind == PAIR and not pairs:
            need("which films are shown side by side?", "`pair NAME` with `first` and `second`")
        for other, of_kind in ((answers, CHOICE), (pairs, PAIR)):
            if other and kind != of_kind:
                message = f"the question is a {kind}, and has no `{other[0].keyword}`"
                self.problem("study-block", message, other[0].span)
        when = self.word(block, "when", "end", ("end", "throughout"))
        return Question(
            self.text(block, "ask"),
            kind,
            event,
            self.text(block, "low"),
            self.text(block, "high"),
            when == "throughout",
            self.text(block, "assume") or "nothing",
            _spans(block),
        )

    def pair(self, block: Block, conditions: tuple[str, ...]) -> Pair:
        side = lambda key: self.one_of(block, key, list(conditions), "condition")
        for key in ("first", "second"):
            if key not in block.entries and not block.damaged:
                hint = "give `first` and `second`, a condition each"
                self.problem("study-block", f"`{block.name}` has no `{key}`", block.span, hint)
        people = self.number(block, "people", -1.0, *_between(0, 1))
        known = None if people < 0 else people
        label = self.text(block, "label") or block.name
        return Pair(block.name, label, side("first"), side("second"), known)

    def people(
        self, blocks: list[Block], conditions: tuple[str, ...], methods: tuple[Method, ...]
    ) -> dict[tuple[str, str], float]:
        """What people answered: `people CONDITION` with `METHOD = SHARE`."""
        found = {}
        names = tuple(method.name for method in methods)
        for block in blocks:
            if block.name not in conditions:
                if not self.may_be_lost(block.name, "condition"):
                    message = f"there is no condition `{shorten(block.name)}`"
                    self.problem("study-name", message, block.span)
                continue
            for key, span in block.keys.items():
                if key in names:
                    found[block.name, key] = self.number(block, key, 0.0, *_between(0, 1))
                elif not self.may_be_lost(key, "method"):
                    hint = "methods: " + ", ".join(names)
                    self.problem("study-name", f"there is no method `{key}`", span, hint)
        return found

    def panel(self, block: Block) -> Panel:
        drawn: dict[str, Drawn] = {}
        for key, valid in PARAMETERS.items():
            if key in block.entries:
                drawn[key] = self.drawn(block.entries[key], key, valid)
        for key, known in WORDS.items():
            if key in block.entries:
                drawn[key] = OneOf(self.words(block, key, known, key))
        # Whether the world has such a setting is seen where its story is (study/check.py).
        others = [key for key in block.entries if key not in KEYS["panel"]]
        for key in others:
            meant = closest(key, KEYS["panel"])
            if meant is not None:
                hint = f"did you mean `{meant}`?"
                self.problem("study-key", f"`panel` has no `{key}`", block.keys[key], hint)
        settings: dict[str, Drawn] = {key: self.planned(block.entries[key], key) for key in others}
        people = self.file(block, "people")
        if people is not None:
            for key in ("sharpness", "forgetting", "doubt", "prior", *settings):
                if key in block.keys:
                    hint = "remove one of the two"
                    message = f"the people of the file have `{key}` of their own"
                    self.problem("study-key", message, block.keys[key], hint)
        return Panel(
            block.name,
            self.text(block, "label") or block.name,
            int(self.number(block, "viewers", 100, *_whole(1, MOST_VIEWERS))),
            int(self.number(block, "seed", 0, *_whole(0, 2**31 - 1))),
            people,
            drawn,
            settings,
            _spans(block),
        )

    def drawn(self, value: Value, key: str, valid: Valid) -> Drawn:
        """A number, `(low, high)` or a set of numbers."""
        holds, range_ = valid
        items = list(value.value) if value.kind in ("list", "pair") else [value]
        numbers: list[float] = []
        for item in items:
            if item.kind != "number":
                hint = f"`{key} = 1`, `{key} = (0.5, 2)` for a range, or `{key} = {{0.5, 1, 2}}`"
                self.problem("study-value", f"`{key}` must be of numbers", item.span, hint)
            elif not holds(item.value):
                message = f"`{key}` must be {range_}, not {item.span.text}"
                self.problem("study-range", message, item.span)
            else:
                numbers.append(float(item.value))
        if value.kind != "pair" or len(numbers) < 2:
            return OneOf(tuple(numbers))
        low, high = numbers
        if not low < high:
            self.problem("study-range", "the range is empty", value.span, "write (low, high)")
        elif key in IN_LOGS and low == 0:
            hint = f"the logarithm of `{key}` is drawn evenly; or give some values, {{...}}"
            self.problem("study-range", "this range must begin above 0", value.span, hint)
        return Between(low, high, key in IN_LOGS)

    def planned(self, value: Value, key: str) -> Drawn:
        """A number, a word, or a set of them: for each of them the world is planned."""
        items = value.value if value.kind == "list" else [value]
        found = [item.value for item in items if item.kind in ("number", "name", "text")]
        if value.kind == "pair" or len(found) < len(items) or not found:
            hint = f"for each value worlds are planned: `{key} = {{1, 2, 4}}`"
            self.problem("study-value", f"`{key}` is no range", value.span, hint)
        return OneOf(tuple(found))


def _spans(block: Block) -> dict[str, Span]:
    """Where things stand: the block's name, and the value of each of its keys."""
    return {"": block.span, **{key: value.span for key, value in block.entries.items()}}


def with_seeds(study: Study, seeds: tuple[int, ...]) -> Study:
    """The same with fewer or other films."""
    return replace(study, seeds=seeds)
