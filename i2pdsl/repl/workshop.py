"""Worlds and scripts for a session: all that needs arrays, planning and searching."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from i2pdsl.errors import Source, Span, StoryError, error, whole_file
from i2pdsl.language.check import TypedStory
from i2pdsl.language.methods import LONGEST_STORY
from i2pdsl.language.story import Requirement
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script
from i2pdsl.progress import Bars
from i2pdsl.render.pictures import drawing_for, pictures_of
from i2pdsl.render.reasons import reasons_in_words
from i2pdsl.repl.mistakes import INPUT, placed, put_into, usage, wrong
from i2pdsl.repl.program import NO_OBJECTIVE, Part, Program, read_program
from i2pdsl.repl.showing import Belief, Looked, Moved, Text, belief_line
from i2pdsl.repl.state import Desk, State, Suggestion
from i2pdsl.scripts import Script, script_from, script_of
from i2pdsl.search.searches import search_of, without_requirements
from i2pdsl.search.task import Task
from i2pdsl.stories import Story
from i2pdsl.worlds.kind import Watch
from i2pdsl.worlds.kinds import kind_of
from i2pdsl.worlds.record import Kept, Trajectory, empty, read_record, runs_of
from i2pdsl.worlds.world import World

SHOWN = 3  # suggestions
_PICTURES = (".png", ".svg", ".gif", ".mp4", ".html")


class Workshop:
    """Keeps the last script that was made, so that a question costs milliseconds.

    Attributes:
        remarks: what happened on the way to an answer.
    """

    def __init__(self) -> None:
        self.remarks: list[str] = []
        self._script: Script | None = None
        self._vouched: Script | None = None

    # The script at hand.

    def script(self, desk: Desk) -> Script:
        """The current script as the current story's audience sees it."""
        if desk.state.is_owed:
            state, score, said = self.solved(desk, desk.state.seed)
            self.remarks += [f"solved: {score.text}", *said]
            desk.pay(state)
            desk.state = state
        state = desk.state
        world = self.world(state)
        path = state.path if state.path is not None else first_picture(world, _story(state))
        old = self._script
        if old is None or old.world is not world or old.trajectory is not path:
            if state.path is None:
                desk.state = state = replace(state, path=path)
            self._script = old = _script(state, world, path)
        typed = state.typed
        module, audiences = typed.module, typed.audiences
        return replace(old, module=module, assumption=typed.assumption, audiences=audiences)

    def vouched(self, desk: Desk) -> Script:
        """The same with what is known of its error, found once for all questions."""
        script, known = self.script(desk), self._vouched
        about = lambda s: (id(s.world), id(s.trajectory), s.assumption, s.audiences)
        if known is None or about(known) != about(script):
            with Bars() as bars:
                self._vouched = known = script.vouched(bars.watch)
        return replace(script, trust=known.trust, nearer=known.nearer)

    def world(self, state: State) -> World:
        with Bars() as bars:
            return _story(state).world(bars.watch)

    def moved(self, state: State, desk: Desk) -> tuple[State, tuple[str, ...]]:
        """The session's script in another world or before another audience, if it fits there."""
        assert state.path is not None
        old = _story(desk.state).spec
        new = _story(state).spec
        if not len(state.path.actions):
            return replace(state, path=None), ()
        if kind_of(old) is kind_of(new) and kind_of(old).has_same_rules(old, new):
            return state, ()
        gone = "the script is gone: it is none of this world (`undo` brings it back)"
        return replace(state, path=None, score=None, is_owed=False, kept=None), (gone,)

    # Files.

    def opened(self, path: str) -> tuple[State, Script]:
        """A script's file with the story that is stored in it."""
        record = read_record(path)
        with Bars() as bars:
            script = script_from(record, Path(path).parent, bars.watch)
        spec = script.world.spec
        known = spec if record.world["source"] else None
        folder, text = Path(path).parent, record.story.get("source")
        name = str(record.story.get("file") or "script")
        program: Program | None = None
        if isinstance(text, str) and text.strip() and not script.warnings:
            program = read_program(Source(name, text), folder)
            said = tuple(part for part in program.parts if part.text != NO_OBJECTIVE)
            program = replace(program, parts=said, known=known)
        else:
            settings = [f"{k} = {_written(v)}" for k, v in record.world["settings"].items()]
            world = f"world {spec.name}" + (f"({', '.join(settings)})" if settings else "")
            program = Program((Part("", world),), name, folder, known=known)
        state = State(program, program.understood(), script.trajectory, script.score)
        return state, script

    def saved(self, desk: Desk, path: Path) -> list[str]:
        """Writes the script, or its pictures."""
        if path.suffix.lower() not in (".json", *_PICTURES):
            message = "the name of the file says what to write"
            hint = f"it ends in .story, .json, {', '.join(_PICTURES[:-1])} or {_PICTURES[-1]}"
            raise wrong("save", str(path), message, hint)
        script = self.script(desk)
        if not script.length:
            hint = "`solve`, or `play` a frame"
            raise wrong("save", str(path), "the script has no frames yet", hint)
        # The story may have changed since the script was made.
        now = _script(desk.state, script.world, script.trajectory)
        return [str(now.save(path))] if path.suffix.lower() == ".json" else _drawn(now, path)

    # Changing the script.

    def solved(self, desk: Desk, seed: int) -> tuple[State, Text, tuple[str, ...]]:
        """The script that the story asks for. Raises StoryError, KeyboardInterrupt."""
        before = desk.state
        typed = before.program.check()
        story = replace(story_of(typed, before.program), kept=before.kept)
        with Bars("searching") as bars:
            result = story.solve(seed, watch=bars.watch)
        script = result.script
        state = replace(
            before,
            typed=typed,
            path=script.trajectory,
            score=script.score,
            seed=seed,
            is_owed=False,
            suggestions=(),
        )
        self._script = replace(script, module=typed.module)
        seconds = {name: result.seconds.get(name, 0.0) for name in ("plan", "compile", "search")}
        spent = ", ".join(
            f"{name} {value:.2f}" for name, value in seconds.items() if value >= 0.005
        )
        about = f"{script.length} frames, seed {seed}" + (f" ({spent} s)" if spent else "")
        said: tuple[str, ...] = (about,)
        if not result.finished:
            said = ("interrupted: the best of what was searched so far is kept", *said)
        said = (*(f"not met: {r.text}" for r in result.unmet), *said)
        score = "unknown" if script.score is None else f"{script.score:.6g}"
        return state, Text(f"score {score}"), said

    def played(self, desk: Desk, typed: str) -> tuple[State, Moved]:
        """One more frame by hand, or some of the hopper's own."""
        script = self.script(desk)
        module, line = desk.state.typed.module, f"play {typed}"

        def move(span: Span) -> tuple[int, int] | None:
            inside = span.source.name == "play"
            return (span.start + len("play "), span.end + len("play ")) if inside else None

        try:
            path, told = kind_of(script.world.spec).played(
                script.world, module, script.trajectory, typed
            )
        except StoryError as problem:
            raise StoryError(put_into(problem.diagnostics, line, move)) from None
        return self._longer(desk, script, path, told)

    def accepted(self, desk: Desk, chosen: Suggestion) -> tuple[State, Moved]:
        return self._longer(desk, self.script(desk), chosen.path, chosen.told)

    def rewound(self, desk: Desk, typed: str) -> State:
        script = self.script(desk)
        frame = _frame(typed or "0", script.length, "rewind")
        path = Trajectory(script.trajectory.actions[:frame], script.trajectory.states[: frame + 1])
        return replace(desk.state, path=path, score=None, suggestions=())

    def pinned(self, desk: Desk, typed: str) -> State:
        """The session with frames of its script pinned, which stays as it is."""
        script, state = self.script(desk), desk.state
        frames = _frames(typed, script.length, "pin")
        if not state.typed.vocabulary.enumerable:
            before = state.kept.frames if state.kept is not None else ()
            return replace(state, kept=Kept((*before, *frames), script.trajectory))
        kind, program = kind_of(script.world.spec), state.program
        for first, last in runs_of(frames):
            for line in kind.kept(script.world, script.trajectory, first, last):
                if not any(part.text == line for part in program.parts):
                    program = program.with_part(Part("\n", line))
        return replace(state, program=program, typed=program.understood(), suggestions=())

    def unpinned(self, desk: Desk, typed: str) -> State:
        """The session without what pins some frames, or any."""
        state = desk.state
        frames = set(_frames(typed, LONGEST_STORY, "unpin")) if typed else None
        kept = state.kept if frames is not None else None
        if kept is not None and frames is not None:
            rest = tuple(frame for frame in kept.frames if frame not in frames)
            kept = Kept(rest, kept.path) if rest else None
        texts = {pin.span.text for pin in state.typed.pins if frames is None or pin.frame in frames}
        parts = tuple(part for part in state.program.parts if part.text not in texts)
        if kept == state.kept and len(parts) == len(state.program.parts):
            raise wrong("unpin", typed, "nothing is pinned there", "`story` shows what is")
        program = replace(state.program, parts=parts)
        return replace(state, program=program, typed=program.understood(), kept=kept)

    def _longer(
        self, desk: Desk, script: Script, path: Trajectory, told: str
    ) -> tuple[State, Moved]:
        state = replace(desk.state, path=path, score=None, suggestions=())
        longer = _script(state, script.world, path)
        longer = replace(longer, module=script.module, assumption=script.assumption)
        self._script = longer
        before, after = script.length, longer.length
        beliefs = beliefs_at(longer, after, before)
        return state, Moved(after, told, beliefs)

    # Looking.

    def looked(self, desk: Desk, typed: str) -> Looked:
        """A frame as characters can show it, and what viewers believe after it."""
        script = self.script(desk)
        frame = _frame(typed, script.length, "show") if typed else script.length
        spec, path = script.world.spec, script.trajectory
        told = kind_of(spec).frame_in_words(script.world, path, frame) if frame else "the start"
        drawn = drawing_for(spec).in_characters(script.world, path.states[frame], desk.ink)
        title = f"frame {frame} of {script.length}: {told}"
        return Looked(title, drawn, beliefs_at(script, frame))

    def reasons(self, desk: Desk, typed: str) -> Text:
        """What moved viewers' beliefs, in the whole script or in one of its frames."""
        script = self.script(desk)
        # The story may have changed since the script was made.
        script = _script(desk.state, script.world, script.trajectory).shown()
        frame = _frame(typed, script.length, "why") if typed else None
        if frame == 0 or not script.length:
            message = "nothing has been done yet"
            raise wrong("why", typed, message, "`why 1` asks about the first frame")
        return Text(reasons_in_words(script, frame))

    def suggested(
        self, desk: Desk, typed: str
    ) -> tuple[tuple[Suggestion, ...], Text, tuple[str, ...]]:
        """The best next frames for the story's objective, or for another one."""
        script = self.script(desk)
        match = re.match(r"(\d{1,6})(?=\s|$)", typed)
        expression = typed[match.end() :].strip() if match else typed.strip()
        usual, most = kind_of(script.world.spec).suggested
        frames = int(match[1]) if match else usual
        if not 1 <= frames <= most:
            raise wrong("suggest", typed, f"expected 1 to {most:,} frames", "`suggest 2`")
        story = self._wanted(desk.state, expression, script.length + frames, typed)
        found = self._suggested(story, script, frames)
        if not found:
            raise error("search", "nothing that follows has a finite value", whole_file(INPUT))
        numbers = [f"{s.score:.6g}" for s in found]
        width = max(len("score"), *map(len, numbers))
        lines = [f"   {'score':>{width}}  what comes next"]
        for number, score, each in zip(range(1, SHOWN + 1), numbers, found, strict=False):
            lines.append(f"{number}  {score:>{width}}  {each.told}")
            lines += [f"   {'':>{width}}  breaks: {text}" for text in each.broken]
        others = {2: " (the other: `accept 2`)", 3: " (the others: `accept 2`, `accept 3`)"}
        said = (f"`accept` adds the first{others.get(len(found), '')}",)
        return found, Text("\n".join(lines), found[0].told), said

    def _wanted(self, state: State, expression: str, length: int, typed: str) -> Story:
        """The story with its objective, or another one, for a script of at least that length."""
        program = state.program
        if expression:
            part = Part("\n", f"maximize {expression}")
            program = program.without("maximize").without("minimize").with_part(part)
        if not program.has_audience:
            program = program.without("search")
        if not program.has("maximize", "minimize"):
            raise error(
                "no-objective",
                "the story has no objective yet",
                whole_file(INPUT),
                "`suggest EXPRESSION`, or `maximize EXPRESSION` first",
            )
        if not program.has("length") or state.typed.length < length:
            program = program.with_length(length)
        try:
            return story_of(program.check(), program)
        except StoryError as problem:
            if not expression:
                raise
            mistakes = program.in_words(problem, part)
            line = f"suggest {typed}"
            offset = len(line) - len(part.text)
            raise StoryError(placed(mistakes, part.text, line, offset)) from None

    def _suggested(self, story: Story, script: Script, frames: int) -> tuple[Suggestion, ...]:
        world, path = script.world, script.trajectory
        with Bars("searching") as bars:
            task = Task(story.typed, world, bars.watch)
            found = search_of(story.typed).onward(task, path, frames)[:SHOWN]
            paths, scores = [longer for longer, _ in found], np.array([score for _, score in found])
            broken: list[tuple[Requirement, ...]] = [()] * len(paths)
            if paths and story.typed.requirements:
                scores, broken = without_requirements(task, paths)
        suggestions = []
        for longer, score, missed in zip(paths, scores.tolist(), broken, strict=True):
            told = kind_of(world.spec).continuation_in_words(world, longer, script.length + 1)
            if not told:
                seen = replay(world, longer.states, longer.actions)
                then = replace(script, trajectory=longer, frames=seen)
                beliefs = "; ".join(map(belief_line, beliefs_at(then, len(longer.actions))))
                told = f"[{frames} frames, then {beliefs}]"
            suggestions.append(Suggestion(told, longer, score, tuple(r.text for r in missed)))
        return tuple(suggestions)


def _story(state: State) -> Story:
    return story_of(state.typed, state.program)


def story_of(typed: TypedStory, program: Program) -> Story:
    """A session's story: its world may be known by the script that carried it."""
    known = program.known if program.carries(typed.world) else None  # it may have moved elsewhere
    return Story(typed, program.folder, known)


def first_picture(world: World, story: Story) -> Trajectory:
    """A script of no frames: a first picture that the story allows."""
    return empty(world, Task(story.typed, world, Watch()).first)


def _script(state: State, world: World, path: Trajectory) -> Script:
    """A script from its path: what viewers believe is computed here."""
    typed = state.typed.of_length(len(path.actions))
    frames = replay(world, path.states, path.actions)
    score = state.score
    if score is None and typed.objective and len(path.actions) == typed.length:
        with np.errstate(all="ignore"):
            score = score_script(typed, world, frames)
    return script_of(typed, world, path, frames, state.about(), score)


def beliefs_at(script: Script, frame: int, before: int | None = None) -> tuple[Belief, ...]:
    """What viewers believe of each latent after a frame (and after an earlier one)."""
    words = script.world.vocabulary
    found = []
    for name in words.apart:
        answer = script.ask(f"P({name} | script[:t])")
        columns = answer.columns()
        table = np.stack(list(columns.values()), axis=-1)
        if name in words.rational.values() and (table.max(axis=-1) > 1 - 1e-12).all():
            continue  # assumed
        earlier = None if before is None else table[before]
        found.append(Belief(name, tuple(columns), table[frame], earlier))
    return tuple(found)


def _frame(typed: str, last: int, command: str) -> int:
    text = typed.strip()
    if text.isdecimal() and len(text) < 10 and int(text) <= last:
        return int(text)
    raise wrong(command, text, f"expected a frame from 0 to {last}", f"`{command} {last}`")


def _frames(typed: str, last: int, command: str) -> list[int]:
    """`1-5,9`: the numbers of frames."""
    found: list[int] = []
    for part in typed.split(","):
        ends = [text.strip() for text in part.split("-")]
        if len(ends) > 2 or not all(text.isdecimal() and len(text) < 10 for text in ends):
            raise usage(command, typed)
        if not 1 <= int(ends[0]) <= int(ends[-1]) <= last:
            message = f"expected frames from 1 to {last}"
            raise wrong(command, typed, message, f"`{command} {last}`")
        found.extend(range(int(ends[0]), int(ends[-1]) + 1))
    return found


def _written(value: object) -> str:
    if isinstance(value, list | tuple):
        return "{" + ", ".join(f"{x:g}" for x in value) + "}"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _drawn(script: Script, path: Path) -> list[str]:
    """Pictures of a script: the one kind that was asked for, beside the name that was given."""
    drawing = pictures_of([script])
    with Bars() as bars:
        kinds = (path.suffix[1:].lower(),)
        return [str(p) for _, p in drawing.drawn(path.parent / path.stem, kinds, bars.drawing)]
