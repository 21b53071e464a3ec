"""A session: a story and its script, changed and asked line by line. Lines in, replies out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from i2pdsl.answers import Answer
from i2pdsl.errors import Diagnostic, Source, StoryError, did_you_mean, whole_file
from i2pdsl.language.builtins import STATEMENT_WORDS
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.language.statements import check_text, read_source, split_outside
from i2pdsl.render.fonts import noting
from i2pdsl.repl.faults import fault
from i2pdsl.repl.helping import every_word, explain
from i2pdsl.repl.mistakes import INPUT, misspelt_command, placed, usage, wrong
from i2pdsl.repl.program import Part, Program, read_program
from i2pdsl.repl.showing import Asked, Plotted, Reply, Shown, Tabled, Text
from i2pdsl.repl.state import SCORED, Desk, State, same_story
from i2pdsl.repl.texts import PICTURES, split_file, without_comment
from i2pdsl.repl.words import COMMAND_WORDS
from i2pdsl.worlds.find import find_vocabulary

if TYPE_CHECKING:
    from i2pdsl.repl.workshop import Workshop

FIRST_WORLD = "kitchen"
GOALS = ("maximize", "minimize")
NO_FRAMES = "the script has no frames yet, and this begins at frame 1: no numbers"


class Session(Desk):
    """Takes lines. Nothing that is typed raises anything but KeyboardInterrupt.

    Attributes:
        kept: where the session is kept once something of ours has failed.
        workshop: makes worlds and scripts; loaded when the first line needs it, since it takes
            seconds.
    """

    def __init__(self) -> None:
        program = Program((Part("", f"world {FIRST_WORLD}"),))
        super().__init__(State(program, program.understood()))
        self.comments: list[str] = []
        self.kept: Path | None = None
        self._workshop: Workshop | None = None
        self._commands: dict[str, Callable[[str], Reply]] = {
            name: getattr(self, f"on_{name}") for name in COMMAND_WORDS
        }

    @property
    def workshop(self) -> Workshop:
        if self._workshop is None:
            from i2pdsl.repl.workshop import Workshop

            self._workshop = Workshop()
        return self._workshop

    def run(self, line: str) -> Reply:
        """Does what a line says; what is wrong with it is in the reply, and changes nothing."""
        state, past = self.state, list(self.past)
        warned: list[Diagnostic] = []
        try:
            with noting(lambda *said: warned.append(no_font(*said))):
                reply = self._run(line)
        except StoryError as problem:
            reply = Reply(diagnostics=problem.diagnostics)
        except (OSError, MemoryError) as problem:
            from i2pdsl.output import in_words

            failed = Diagnostic("failed", in_words(problem), whole_file(INPUT))
            reply = Reply(diagnostics=(failed,))
        except Exception as problem:
            self.state, self.past = state, past
            reply = Reply(diagnostics=(fault(self, line, problem),))
        reply = replace(reply, diagnostics=(*reply.diagnostics, *warned))
        if self._workshop is None:
            return reply
        remarks = tuple(self._workshop.remarks)
        self._workshop.remarks.clear()
        return replace(reply, noted=remarks)

    def _run(self, line: str) -> Reply:
        text = line.strip("\n")
        if not text.strip():
            self.comments.clear()
            return Reply()
        while text.lstrip().startswith("#"):
            comment, _, text = text.lstrip().partition("\n")
            self.comments.append(comment)
        if not text.strip():
            return Reply()
        check_text(Source(INPUT, text))
        comments, self.comments = self.comments, []
        first = text.split(None, 1)[0]
        word = first.strip()
        if word == "exit":
            word = "quit"
        is_pin = word == "pin" and text.split(None, 2)[1:2] and "script" in text.split(None, 2)[1]
        if word in self._commands and not is_pin:
            rest = text.lstrip()[len(first) :]
            return self._commands[word]("\n".join(map(without_comment, rest.splitlines())).strip())
        if word in STATEMENT_WORDS:
            return self.statement(text.strip(), comments)
        return self.question(text.strip())

    # What a line can be.

    def question(self, text: str) -> Reply:
        """An expression: its answer."""
        try:
            answer, warnings = self.asked(text, text, 0, judged=True)
        except StoryError as problem:
            raise misspelt_command(problem, text, every_word(self.state)) from None
        said: tuple[str, ...] = () if answer.t is None or answer.t else (NO_FRAMES,)
        said += tuple(each.words for each in self.workshop.script(self).particles)
        said += () if answer.trust is None else (answer.trust.in_words(),)
        return Reply((Asked(answer),), said, warnings)

    def asked(
        self, text: str, line: str, offset: int, judged: bool = False
    ) -> tuple[Answer, tuple[Diagnostic, ...]]:
        """The answer to a question that stands in a line at an offset, and `judged`: with what is
        known of its error. Raises StoryError."""
        script = self.workshop.script(self)
        try:
            query = script.check(text)
            if judged and query.asks_beliefs:
                script = self.workshop.vouched(self)
            answer = replace(script.answer(query), expression=" ".join(text.split()))
        except StoryError as problem:
            raise StoryError(placed(problem.diagnostics, text, line, offset)) from None
        return answer, placed(query.warnings, text, line, offset)

    def statement(self, text: str, comments: list[str]) -> Reply:
        """A statement: it joins the story, or replaces the one that can stand only once."""
        before = "\n" + "".join(f"{line}\n" for line in comments)
        part = Part(before, text)
        program = self.state.program.with_part(part)
        said: tuple[str, ...] = ()
        try:
            typed = program.understood()
        except StoryError as problem:
            mistakes = program.in_words(problem, part)
            new_world = part.keyword == "world" and not any(
                d.span.source.name == INPUT for d in mistakes
            )
            if not new_world:
                raise StoryError(mistakes) from None
            program = Program((Part("", text),), folder=program.folder)
            typed = program.understood()
            said = ("a new story: the old one is not of this world (`undo` brings it back)",)
        warned = program.in_words(StoryError(typed.warnings), part)
        warnings = tuple(d for d in warned if d.span.source.name == INPUT)
        if part.keyword in GOALS and self.state.program.has(*GOALS):
            said = ("this adds to the objective; `forget maximize` drops what it was",)
        if part.keyword in ("let", "pattern") and part.name in self._commands:
            said = (f"`{part.name}` is a command too: ask `({part.name})`",)
        return Reply(said=(*said, *self.rewrite(program, typed, text)), diagnostics=warnings)

    def rewrite(self, program: Program, typed: TypedStory, told: str) -> tuple[str, ...]:
        """Changes the story; returns what that did to the script."""
        old = self.state
        said: tuple[str, ...] = ()
        state = replace(old, program=program, typed=typed, suggestions=())
        if not same_story(old.typed, typed, SCORED):
            state = replace(state, score=None)
        before = (old.typed.world, old.typed.settings, old.typed.start)
        if before != (typed.world, typed.settings, typed.start) and state.path is not None:
            state, said = self.workshop.moved(state, self)
        self.become(state, told)
        return said

    def become(self, state: State, told: str) -> None:
        """Changes the session; `undo` takes it back."""
        self.past.append((" ".join(told.split()), self.state))
        self.state = state

    # Commands.

    def on_load(self, rest: str) -> Reply:
        if not rest:
            raise usage("load", rest)
        return self.open(rest.strip('"'))

    def open(self, path: str) -> Reply:
        """Opens a story, whose script is made when it is first asked about, or a script."""
        from i2pdsl.worlds.record import is_script

        source = read_source(path)
        if not path.endswith(".story") and is_script(source):
            state, script = self.workshop.opened(path)
            self.become(state, f"load {path}")
            return Reply(said=(f"{path}: {told(state)}",), diagnostics=script.warnings)
        folder = Path(path).parent
        # As it stands: a file with a mistake is not read by halves.
        checked = check_source(source, find_vocabulary, folder)
        program = read_program(source, folder)
        if isinstance(checked, TypedStory):
            state = State(program, checked, is_owed=True)
        else:
            world = next(p for p in self.state.program.parts if p.keyword == "world")
            program = program.with_part(world)
            state = replace(self.state, program=program, typed=program.understood())
        self.become(state, f"load {path}")
        return Reply(said=(f"{path}: {told(state)}",), diagnostics=checked.warnings)

    def on_save(self, rest: str) -> Reply:
        if not rest:
            raise usage("save", rest)
        name = rest.strip('"')
        if name.endswith(".story"):
            from i2pdsl.resources import write_text

            program = self.state.program
            write_text(Path(name), program.text)
            try:
                replace(program, folder=Path(name).parent, known=None).understood()
            except StoryError as problem:
                missing = f"not whole where it is now: {problem.diagnostics[0].message}"
                return Reply(said=(name, missing))
            return Reply(said=(name,))
        return Reply(said=tuple(self.workshop.saved(self, Path(name))))

    def on_story(self, rest: str) -> Reply:
        lines = [self.state.program.text.strip("\n")]
        kept = self.state.kept
        if kept is not None:  # where actions have no names, no statement says it
            runs = (f"{first}-{last}" if last > first else f"{first}" for first, last in kept.runs)
            lines.append(f"# frames that stay as they are in the script: {', '.join(runs)}")
        return Reply((Text("\n".join(lines), is_story=True),))

    def on_show(self, rest: str) -> Reply:
        return Reply((self.workshop.looked(self, rest),))

    def on_why(self, rest: str) -> Reply:
        return Reply((self.workshop.reasons(self, rest),))

    def on_plot(self, rest: str) -> Reply:
        expressions, file = split_file(rest)
        if file is not None and not file.lower().endswith(PICTURES):
            message = f"curves are written as {', '.join(PICTURES)}"
            raise wrong("plot", rest, message, "`plot EXPR, EXPR, ... > beliefs.png`")
        answers, warnings = self._several("plot", expressions)
        frames = range(self.workshop.script(self).length + 1)
        if file is None:
            return Reply((Plotted(answers, frames),), diagnostics=warnings)
        from i2pdsl.repl.figure import write_figure

        write_figure(answers, frames, Path(file))
        return Reply(said=(file,), diagnostics=warnings)

    def on_table(self, rest: str) -> Reply:
        answers, warnings = self._several("table", rest)
        frames = range(self.workshop.script(self).length + 1)
        shown: Shown = Tabled(answers, frames)
        if all(a.t is None for a in answers):
            frames = range(frames[-1], frames[-1] + 1)
            shown = Tabled(answers, frames)
        return Reply((shown,), diagnostics=warnings)

    def _several(
        self, command: str, text: str
    ) -> tuple[tuple[Answer, ...], tuple[Diagnostic, ...]]:
        if not text.strip():
            raise usage(command, text)
        line, offset, found = f"{command} {text}", len(command) + 1, []
        for part in split_outside(text, ","):
            blank = len(part) - len(part.lstrip())
            found.append(self.asked(part.strip(), line, offset + blank))
            offset += len(part) + 1
        return tuple(a for a, _ in found), tuple(d for _, w in found for d in w)

    def on_solve(self, rest: str) -> Reply:
        if rest and not (rest.isdecimal() and len(rest) < 10):
            raise usage("solve", rest)
        seed = int(rest) if rest else self.state.seed
        state, shown, said = self.workshop.solved(self, seed)
        self.become(state, "solve")
        self.pay(state)
        return Reply((shown,), said)

    def on_play(self, rest: str) -> Reply:
        if not rest:
            raise usage("play", rest, self.state.commands)
        state, shown = self.workshop.played(self, rest)
        self.become(state, f"play {rest}")
        return Reply((shown,))

    def on_suggest(self, rest: str) -> Reply:
        suggestions, shown, said = self.workshop.suggested(self, rest)
        # Looking changes nothing that `undo` should bring back.
        self.state = replace(self.state, suggestions=suggestions)
        return Reply((shown,), said)

    def on_accept(self, rest: str) -> Reply:
        offered = self.state.suggestions
        if not offered:
            raise wrong("accept", rest, "nothing was suggested for this script", "`suggest` first")
        count = int(rest) if rest.isdecimal() and len(rest) < 10 else 0 if rest else 1
        if not 1 <= count <= len(offered):
            raise wrong("accept", rest, f"there are {len(offered)} suggestions", "accept 1")
        state, shown = self.workshop.accepted(self, offered[count - 1])
        self.become(state, f"accept {count}")
        return Reply((shown,))

    def on_rewind(self, rest: str) -> Reply:
        state = self.workshop.rewound(self, rest)
        self.become(state, f"rewind {rest}")
        return Reply(said=(told(state),))

    def on_pin(self, rest: str) -> Reply:
        if not rest:
            raise usage("pin", rest)
        self.become(self.workshop.pinned(self, rest), f"pin {rest}")
        return Reply(said=("`solve` keeps it",))

    def on_unpin(self, rest: str) -> Reply:
        self.become(self.workshop.unpinned(self, rest), f"unpin {rest}")
        return Reply()

    def on_forget(self, rest: str) -> Reply:
        names = self.state.program.forgettable()
        if rest not in names:
            hint = did_you_mean(rest, names) if rest else "`forget NAME`"
            raise wrong("forget", rest, f"the story has no `{rest}` to forget", hint)
        program = self.state.program.without(rest)
        return Reply(said=self.rewrite(program, program.understood(), f"forget {rest}"))

    def on_undo(self, rest: str) -> Reply:
        if not self.past:
            return Reply(said=("there is nothing to take back",))
        line, self.state = self.past.pop()
        return Reply(said=(f"taken back: {line}",))

    def on_help(self, rest: str) -> Reply:
        return Reply((Text(explain(rest.strip("`"), self.state)),))

    def on_quit(self, rest: str) -> Reply:
        return Reply(leaves=True)


def no_font(message: str, hint: str) -> Diagnostic:
    """A warning about letters in pictures."""
    return Diagnostic("font", message, whole_file(INPUT), hint, severity="warning")


def told(state: State) -> str:
    """A story and its script in a few words."""
    world = state.typed.world
    if state.is_owed:
        return f"world {world}, {state.typed.frames}; solved when it is first asked about"
    count = 0 if state.path is None else len(state.path.actions)
    return f"world {world}, {count} frame{'s' * (count != 1)}"
