"""The REPL's session against Python's answers, against searches by hand, and against itself after
files and `undo`."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import i2pdsl
from i2pdsl.errors import Source, display_width
from i2pdsl.language.builtins import FORMS, STATEMENTS
from i2pdsl.language.check import TypedStory, check_source
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script
from i2pdsl.render.characters import NOTHING, Ink, curves_of
from i2pdsl.render.reasons import reasons_in_words
from i2pdsl.repl.helping import explain
from i2pdsl.repl.session import NO_FRAMES, Session
from i2pdsl.repl.showing import (
    Asked,
    Looked,
    Moved,
    Plotted,
    Tabled,
    Text,
    in_a_line,
    on_a_terminal,
)
from i2pdsl.repl.state import State
from i2pdsl.repl.words import COMMANDS
from i2pdsl.scripts import Script
from i2pdsl.stories import Result, story_from
from i2pdsl.worlds.find import find_vocabulary
from i2pdsl.worlds.grid.world import GridWorld
from repl.conftest import HELP, asked, copied, refused, right, saved_and_read, shown
from searches_for_tests import compiling_briefly
from stories_for_tests import BARE
from worlds_for_tests import STORIES

QUESTIONS = (
    "P(rho > 0 | script[:7])",
    "P(rho > 0 | script[:t])",
    "P(rho | script[:T])",
    "P(G_robot | script[:t])",
    "P(G_cheese, rho | script[:t])",
    "P(G_cheese, G_robot, rho | script[:T])",
    "next(robot | script[:t])",
    "next(cheese | script[:3])",
    "P(rho > 0 | script[:t, cheese])",
    "entropy(rho | script[:t])",
    "KL(rho; script[:t-1] || script[:t])",
    "E[V(robot) | script[:t]]",
    "sum_t P(rho > 0 | script[:t], G_cheese = pink)",
    "T",
    "depict(rho > 0)",
    "P(rho > 0 | (script ++ [cheese: west, robot: south])[:T+1])",
)


def same(one: object, other: object) -> bool:
    return np.array_equal(np.asarray(one), np.asarray(other), equal_nan=True)


# Questions.


@pytest.mark.parametrize("question", QUESTIONS)
def test_answers_are_those_of_python(session: Session, solved_help: Result, question: str) -> None:
    assert same(asked(session, question), solved_help.script.query(question))


def test_why_is_what_the_command_says(session: Session, solved_help: Result) -> None:
    for line, frame in (("why 4", 4), ("why", None)):
        found = shown(session, line)
        assert isinstance(found, Text)
        assert found.text == reasons_in_words(solved_help.script, frame)
    assert "expected a frame from 0 to 15" in refused(session, "why 16")
    assert "nothing has been done yet" in refused(session, "why 0")


def test_why_follows_what_the_story_asks_now(session: Session) -> None:
    right(session, "forget maximize")
    right(session, "maximize sum_t P(G_robot = pink | script[:t])")
    found = shown(session, "why 4")
    assert isinstance(found, Text)
    assert "[G_robot = pink]" in found.text
    assert "[rho > 0]" not in found.text


def test_a_story_is_solved_when_it_is_first_asked_about(solved_help: Result) -> None:
    session = Session()
    session.open(str(HELP))
    assert session.state.path is None
    reply = right(session, "P(rho > 0 | script[:7])")
    assert reply.noted[0] == f"solved: score {solved_help.score:.6g}"
    assert session.state.path is not None
    assert same(session.state.path.states, solved_help.script.trajectory.states)
    assert right(session, "P(rho > 0 | script[:7])").noted == ()


def test_a_bare_latent_is_a_table_in_the_order_of_the_world(
    session: Session, solved_help: Result
) -> None:
    values = solved_help.script.query("P(rho | script[:T])")
    lines = on_a_terminal(shown(session, "P(rho | script[:T])"), session.ink).splitlines()
    told = [line.split()[:2] for line in lines[1:]]
    assert [name for name, _ in told] == ["-3", "-1", "0", "1", "3"]
    assert [float(x) for _, x in told] == pytest.approx(values, abs=1e-4)


def test_continued_lines_and_comments(session: Session) -> None:
    plain = asked(session, "P(rho > 0 | script[:T])")
    assert same(plain, asked(session, "P(rho > 0 |\n    script[:T])"))
    assert same(plain, asked(session, "   P(rho > 0 | script[:T])  # at the end"))
    assert right(session, "# nothing but this").shown == ()
    assert right(session, "").shown == ()


def test_warnings_come_with_the_answer(session: Session) -> None:
    reply = session.run("P(R_robot | script[:T])")
    assert [d.severity for d in reply.diagnostics] == ["warning"]
    (found,) = reply.shown
    assert isinstance(found, Asked)
    assert found.answer.value == pytest.approx(1)


@pytest.mark.parametrize(
    ("line", "marked"),
    [
        ("P(G_robt = pink | script[:t])", "G_robt"),
        ("plot P(rho > 0 | script[:t]),  P(G_robot = pnk | script[:t])", "pnk"),
        ("table P(rho > 0 | script[:t]), P(rho > 0 | scrpt[:t])", "scrpt"),
        ("suggest 2 P(rhu > 0 | script[:T])", "rhu"),
        ("suggest P(rhu > 0 | script[:T])", "rhu"),
        ("play cheese wast", "wast"),
        ("play cheese west, robot: shouth", "shouth"),
        ("play [cheese: west, robt: south]", "robt"),
        ("play deus tabel at (1, 3)", "tabel"),
        ("play cheese west, cheese east", "cheese east"),
        ("let x = P(rho > 0 | scrpt[:T])", "scrpt"),
        ("assume rho = 7", "7"),
        ("world nowhere", "nowhere"),
        ("length many", "many"),
        ("show 99", "99"),
        ("rewind 16", "16"),
        ("forget me", "me"),
        ("accept 1", "1"),
        ("solve -1", "-1"),
        ("save it.txt", "it.txt"),
        ("suggest 21", "21"),
    ],
)
def test_the_mark_is_under_what_was_typed(session: Session, line: str, marked: str) -> None:
    refused(session, line)
    (first, *_) = session.run(line).diagnostics
    assert first.span.source.text == line
    assert first.span.text == marked
    assert first.render().startswith(f"input:1:{line.rindex(marked) + 1}: error[")


def test_what_is_wrong_is_told_and_changes_nothing(session: Session) -> None:
    assert "did you mean `help`?" in refused(session, "hepl")
    assert "the command is `help`" in refused(session, "help()")
    assert "the command is `help`" in refused(session, "?")
    assert "did you mean `show`?" in refused(session, "shwo 3")
    assert "did you mean `maximize`?" in refused(session, "maximise depict(rho > 0)")
    assert "`plot` needs more" in refused(session, "plot")
    assert "`load FILE`" in refused(session, "load")
    assert "no such file" in refused(session, "load nowhere.story")
    assert "`suggest` first" in refused(session, "accept")
    assert ".png, .svg, .pdf" in refused(session, "plot P(rho > 0 | script[:t]) > it.jpg")
    assert "means nothing here" in refused(session, "help nonsense")
    assert "its place is taken" in refused(session, "play deus table at (0, 0)")
    assert "a whole script" in refused(session, "script")


# Statements.


def test_statements_add_or_replace(session: Session) -> None:
    right(session, "let friend = rho > 0")
    assert asked(session, "P(friend | script[:T])") == asked(session, "P(rho > 0 | script[:T])")
    right(session, "let friend = rho < 0")
    assert asked(session, "P(friend | script[:T])") == asked(session, "P(rho < 0 | script[:T])")
    assert session.state.program.text.count("let friend") == 1
    right(session, "# twice the sum\npattern twice(x) =\n    2 * sum_t P(x | script[:t])")
    total = asked(session, "sum_t P(rho > 0 | script[:t])")
    assert asked(session, "twice(rho > 0)") == pytest.approx(2 * total)
    right(session, "pattern twice(x) = 3 * sum_t P(x | script[:t])")
    assert asked(session, "twice(rho > 0)") == pytest.approx(3 * total)
    right(session, "length 20")
    assert "length 15" not in session.state.program.text
    reply = right(session, "maximize depict(G_cheese = pink)")
    assert "adds to the objective" in reply.said[0]
    assert len(session.state.typed.objective) == 2
    right(session, "forget maximize")
    assert "maximize" not in session.state.program.text.replace("# expect", "")
    right(session, "forget friend")
    assert "unknown name `friend`" in refused(session, "P(friend | script[:T])")


def test_audiences_come_and_go_by_their_names(session: Session) -> None:
    right(session, "audience insider = bayesian(given = G_cheese = pink)")
    pink = asked(session, "entropy[insider](script[:2])")
    usual = asked(session, "entropy(script[:2])")
    right(session, "audience bayesian(forgetting = 0.1)")
    assert asked(session, "entropy(script[:2])") != pytest.approx(usual)
    right(session, "audience insider = bayesian(given = G_cheese = green)")
    assert asked(session, "entropy[insider](script[:2])") != pytest.approx(pink)
    assert session.state.program.text.count("audience insider") == 1
    assert "given = G_cheese = green" in explain("insider", session.state)
    right(session, "forget insider")
    assert "no audience `insider`" in refused(session, "P[insider](rho > 0 | script[:T])")
    assert asked(session, "entropy(script[:2])") != pytest.approx(usual)


def test_a_comment_before_a_definition_is_its_documentation(session: Session) -> None:
    right(session, "# How sure viewers are.")
    right(session, "pattern sure(x) = sum_t P(x | script[:t])")
    help_ = shown(session, "help sure")
    assert isinstance(help_, Text)
    assert "How sure viewers are." in help_.text
    assert "= sum_t P(x | script[:t])" in help_.text


def test_the_story_is_kept_as_it_was_written(session: Session) -> None:
    text = HELP.read_text(encoding="utf-8")
    told = shown(session, "story")
    assert isinstance(told, Text)
    assert told.text == text.strip("\n")
    right(session, "save copy.story")
    assert Path("copy.story").read_text(encoding="utf-8") == text


def test_a_story_written_line_by_line_reads_like_one() -> None:
    session = Session()
    lines = ("maximize depict(friend)", "let friend = rho > 0", "search beam(starts = 5)")
    refused(session, lines[0])
    for line in (lines[1], lines[0], lines[2], "length 9", "let foe = rho < 0", "length 8"):
        right(session, line)
    right(session, "# What it is about.")
    right(session, "pattern twice(x) = 2 * sum_t P(x | script[:t])")
    assert session.state.program.text == (
        "world kitchen\nlength 8\n\nlet friend = rho > 0\nlet foe = rho < 0\n\n"
        "# What it is about.\npattern twice(x) = 2 * sum_t P(x | script[:t])\n\n"
        "maximize depict(friend)\n\nsearch beam(starts = 5)\n"
    )


def test_undo_brings_every_state_back(session: Session) -> None:
    lines = (
        "let friend = rho > 0",
        "maximize depict(friend)",
        "forget maximize",
        "play cheese west!",
        "play robot east",
        "rewind 3",
        "assume nothing",
        "audience bayesian(forgetting = 0.01)",
        "length 4",
        "world maze",
        f"load {STORIES}/kitchen/hinder.story",
    )
    states = []
    for line in lines:
        states.append(session.state)
        right(session, line)
        assert session.state is not states[-1]
    for state in reversed(states):
        right(session, "undo")
        assert session.state is state
    assert right(session, "undo").said == ("there is nothing to take back",)


def test_undo_does_not_search_again(solved_help: Result) -> None:
    session = Session()
    session.open(str(HELP))
    right(session, "let friend = rho > 0")
    right(session, "maximize 2")
    right(session, "undo")
    right(session, "let foe = rho < 0")
    assert right(session, "P(foe | script[:T])").noted
    for _ in range(2):
        right(session, "undo")
        assert right(session, "T").noted == ()
        assert session.state.path is not None
        assert same(session.state.path.states, solved_help.script.trajectory.states)
    assert session.state.program.text == HELP.read_text(encoding="utf-8")
    session = Session()
    session.open(str(HELP))
    right(session, "solve")
    right(session, "undo")
    assert right(session, "T").noted == ()


def test_interrupted_it_keeps_the_best_so_far(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """test_terminal.py presses Ctrl-C."""
    from i2pdsl.search import beam

    (tmp_path / "left.story").write_text(
        "world fork\nlength 3\nmaximize sum_t P(G_robot = left | script[:t])\n"
        "search beam(polish = 0)\n"
    )
    original, seen = beam.beam_search, []

    def search(*arguments: Any) -> Any:
        def report(*done: int) -> None:
            seen.append(done)
            if len(seen) == 2:
                raise KeyboardInterrupt

        *others, _, say, more = arguments
        return original(*others, report, say, more)

    monkeypatch.setattr(beam, "beam_search", search)
    session = Session()
    session.open(str(tmp_path / "left.story"))
    with compiling_briefly(places=4):
        told = right(session, "solve")
    assert "interrupted: the best of what was searched so far is kept" in told.said
    assert 0 < seen[-1][0] < seen[-1][1]
    assert asked(session, "T") == 3


def test_names_do_not_hide_commands(session: Session) -> None:
    assert right(session, "let show = 3").said == ("`show` is a command too: ask `(show)`",)
    assert isinstance(shown(session, "show"), Looked)
    assert asked(session, "(show)") == 3
    right(session, "let undo = 4")
    right(session, "undo")
    assert "undo" not in session.state.program.text


def test_questions_are_no_changes(session: Session) -> None:
    before = session.state
    for line in ("P(rho | script[:t])", "plot T", "table T", "show 2", "story", "help KL", "help"):
        right(session, line)
        assert session.state is before
    assert session.past == []


# What would be.


def test_a_turn_in_thought_and_in_deed(session: Session) -> None:
    what_if = "P(rho > 0 | (script ++ [cheese: west, robot: south])[:T+1])"
    thought = asked(session, what_if)
    right(session, "play cheese west, robot south")
    assert asked(session, "P(rho > 0 | script[:T])") == pytest.approx(thought, abs=1e-12)
    assert asked(session, "T") == 16


def test_a_move_that_fails(session: Session) -> None:
    right(session, "save before.json")
    moved = shown(session, "play cheese west!")
    assert isinstance(moved, Moved)
    assert (moved.number, moved.told) == (16, "[cheese: west!, robot: stay]")
    frame = saved_and_read(session, Path()).record.frames[-1]
    before = json.loads(Path("before.json").read_text())["frames"][-1]["state"]
    assert frame["cheese"] == {"action": "west", "moved": False}
    assert frame["robot"]["action"] == "stay"
    assert frame["state"] == before


def test_played_frames_tell_how_beliefs_move(session: Session) -> None:
    moved = shown(session, "play robot north")
    assert isinstance(moved, Moved)
    by_name = {b.latent: b for b in moved.beliefs}
    assert set(by_name) == {"rho", "G_cheese", "G_robot"}  # that all are rational is assumed
    rho = by_name["rho"]
    assert rho.before is not None
    assert rho.before == pytest.approx(asked(session, "P(rho | script[:15])"))
    assert rho.after == pytest.approx(asked(session, "P(rho | script[:16])"))


@pytest.mark.parametrize("columns", [40, 60, 110])
def test_what_is_shown_fits_the_window(session: Session, columns: int) -> None:
    session.ink = ink = Ink(False, True, columns)
    questions = ("P(rho > 0 | script[:t])", "P(rho | script[:T])", "play cheese west!", "show")
    for line in (*questions, "help", "help audience", "help suggest", "plot T, t"):
        text = on_a_terminal(shown(session, line), ink)
        assert max(map(len, text.splitlines())) <= columns, text


def test_looking_at_a_frame(session: Session, solved_help: Result) -> None:
    looked = shown(session, "show 7")
    assert isinstance(looked, Looked)
    assert looked.title.startswith("frame 7 of 15")
    state = solved_help.script.record.frames[6]["state"]
    rows = [line[4:].split(" ") for line in looked.picture.splitlines()]
    for name, letter in (("cheese", "C"), ("robot", "R"), ("table", "T")):
        if state[name] is not None:
            column, row = state[name]
            assert rows[row][column] == letter
    assert rows[3][0] == "█"
    robot = next(b for b in looked.beliefs if b.latent == "G_robot")
    assert robot.after == pytest.approx(solved_help.script.query("P(G_robot | script[:7])"))


def test_rewinding(session: Session) -> None:
    early = asked(session, "P(rho > 0 | script[:4])")
    right(session, "rewind 4")
    assert asked(session, "T") == 4
    assert asked(session, "P(rho > 0 | script[:T])") == pytest.approx(early, abs=1e-12)
    right(session, "rewind")
    assert asked(session, "T") == 0
    assert asked(session, "P(rho > 0 | script[:t])") == pytest.approx([3 / 7])


def written(text: str) -> TypedStory:
    checked = check_source(Source("longer.story", text), find_vocabulary)
    assert isinstance(checked, TypedStory)
    return checked


@pytest.mark.parametrize("expression", ["", "P(rho < 0 | script[:T])"])
def test_suggestions_are_the_best_of_all_turns(
    session: Session, solved_help: Result, expression: str
) -> None:
    right(session, "rewind 3")
    path = session.state.path
    assert path is not None
    right(session, f"suggest {expression}")
    found = session.state.suggestions
    world = solved_help.script.world
    assert isinstance(world, GridWorld)
    if expression:
        story = written(f"world kitchen\nlength 4\nmaximize {expression}\n")
    else:  # the first four frames of the fifteen that the story has
        text = "world kitchen\nlength 15\nmaximize sum_{t in 1..4} P(rho > 0 | script[:t])\n"
        text += BARE
        story = written(text)
    scores = {}
    for action in np.flatnonzero(world.turns(world.tables, np.asarray(path.states[-1])).valid):
        after = world.transition(world.tables, np.asarray(path.states[-1]), np.asarray(action))
        states = np.append(path.states, int(after))
        frames = replay(world, states, np.append(path.actions, action))
        if expression:
            scores[int(action)] = score_script(story, world, frames)
        else:
            given = [*path.actions, int(action)]
            scores[int(action)] = _prefix_score(world, frames, given)
    best = max(scores.values())
    assert found[0].score == pytest.approx(best, rel=1e-4, abs=1e-4)
    last = [int(each.path.actions[-1]) for each in found]
    assert len(set(last)) == len(last)
    assert sorted((scores[a] for a in last), reverse=True) == pytest.approx(
        sorted(scores.values(), reverse=True)[: len(last)], rel=1e-4, abs=1e-4
    )


def _prefix_score(world: GridWorld, frames: object, actions: list[int]) -> float:
    """The objective of help.story summed over the frames that there are."""
    story = written(f"world kitchen\nlength {len(actions)}\nmaximize depict(rho > 0)\n")
    return score_script(story, world, frames)  # type: ignore[arg-type]


def test_suggestions_tell_what_they_break_apart_from_their_score(session: Session) -> None:
    """The best next frames are those of the story without requirements, where all break one."""
    right(session, "rewind 3")
    wish = "P(rho < 0 | script[:T])"
    plain = shown(session, f"suggest {wish}")
    found = session.state.suggestions
    assert isinstance(plain, Text)
    assert "breaks" not in plain.text
    right(session, "require [at(cheese, (0, 0)) @ script[2]]")
    right(session, "require eventually [pushes(robot, cheese)]")
    text = shown(session, f"suggest {wish}")
    assert isinstance(text, Text)
    broken = session.state.suggestions
    assert [each.told for each in broken] == [each.told for each in found]
    assert [each.score for each in broken] == pytest.approx(
        [each.score for each in found], abs=2e-4
    )
    lost = {"require [at(cheese, (0, 0)) @ script[2]]"}
    assert all(set(each.broken) == lost for each in broken)
    assert text.text.count(f"breaks: {next(iter(lost))}") == len(broken)


def test_accepting_is_playing_what_was_suggested(session: Session) -> None:
    right(session, "rewind 3")
    other = copied(session)
    text = shown(session, "suggest")
    assert isinstance(text, Text)
    second = session.state.suggestions[1]
    moved = shown(session, "accept 2")
    assert isinstance(moved, Moved)
    right(other, f"play {second.told}")
    assert session.state.path is not None
    assert other.state.path is not None
    assert same(session.state.path.states, other.state.path.states)
    assert same(session.state.path.actions, other.state.path.actions)
    assert "`suggest` first" in refused(session, "accept")


def test_several_frames_are_told_one_by_one(session: Session) -> None:
    right(session, "rewind 3")
    right(session, "suggest 2 P(rho > 0 | script[:T])")
    first, second = session.state.suggestions[0].told[1:-1].split("] [")
    moved = shown(session, "accept")
    line = in_a_line(moved)
    assert line.startswith(f"frame 4: {first}; frame 5: {second}; rho: -3 ")
    assert "[" not in line
    lines = on_a_terminal(moved, Ink(columns=100)).splitlines()
    assert lines[:2] == [f"frame 4  {first}", f"frame 5  {second}"]


def test_suggestions_are_for_one_script_and_one_story(session: Session) -> None:
    right(session, "rewind 3")
    for line in ("play robot stay", "maximize T", "forget maximize", "rewind 2", "length 9"):
        right(session, "suggest P(rho > 0 | script[:T])")
        right(session, line)
        refused(session, "accept")


# Curves and tables.


def test_plots_and_tables_hold_the_answers(session: Session, solved_help: Result) -> None:
    line = "P(rho > 0 | script[:t]), min(1, 0.5 + T), P(G_robot | script[:t])"
    for command, kind in (("plot", Plotted), ("table", Tabled)):
        found = shown(session, f"{command} {line}")
        assert isinstance(found, kind)
        assert len(found.answers) == 3
        first = solved_help.script.query("P(rho > 0 | script[:t])")
        assert same(found.answers[0].value, first)
    rows = [r.split() for r in on_a_terminal(found, session.ink).splitlines()[1:]]
    assert [int(r[0]) for r in rows] == list(range(16))
    goals = solved_help.script.query("P(G_robot | script[:t])")
    assert np.array([r[3:] for r in rows], float) == pytest.approx(goals, rel=1e-4)


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_plots_into_files(session: Session, ending: str) -> None:
    reply = right(session, f"plot P(rho > 0 | script[:t]), T > it.{ending}")
    assert reply.shown == ()
    assert reply.said == (f"it.{ending}",)
    head = Path(f"it.{ending}").read_bytes()[:200]
    assert {"png": b"\x89PNG", "svg": b"<svg", "pdf": b"%PDF"}[ending] in head + (
        Path(f"it.{ending}").read_bytes() if ending == "svg" else b""
    )


# Searching.


def test_a_changed_story_is_solved_as_if_it_were_fresh(session: Session) -> None:
    right(session, "forget maximize")
    right(session, "maximize depict(rho < 0)")
    right(session, "solve 2")
    right(session, "save changed.story")
    fresh = i2pdsl.load("changed.story").solve(seed=2)
    assert session.state.path is not None
    assert same(session.state.path.states, fresh.script.trajectory.states)
    assert session.state.score == pytest.approx(fresh.score)
    assert (session.state.seed, session.state.path.actions.size) == (2, 15)


def test_solving_needs_a_whole_story(session: Session) -> None:
    right(session, "forget maximize")
    assert "no-objective" in refused(session, "solve")


def test_the_score_is_that_of_the_story_at_hand(session: Session, solved_help: Result) -> None:
    assert session.state.score == pytest.approx(solved_help.score)
    right(session, "let friend = rho > 0")
    assert session.state.score == pytest.approx(solved_help.score)
    right(session, "rationality 0")
    assert session.state.score is None
    path = solved_help.script.trajectory
    total = float(solved_help.script.query("depict(rho > 0)"))
    story = written("world kitchen\nlength 15\nmaximize 0\nrationality 0\n")
    weak = score_script(story, solved_help.script.world, solved_help.script.frames)
    saved = saved_and_read(session, Path())
    assert saved.score == pytest.approx(total + weak)
    assert same(saved.trajectory.states, path.states)


# Worlds, audiences, assumptions.


def as_fresh(folder: Path, *statements: str) -> i2pdsl.Script:
    """The session's script as a file whose story has other statements."""
    document = json.loads((folder / "plain.json").read_text())
    text = "world kitchen\nlength 15\nmaximize depict(rho > 0)\n" + "\n".join(statements)
    document["story"]["source"] = f"{text}\n"
    (folder / "fresh.json").write_text(json.dumps(document))
    return i2pdsl.Script.load(folder / "fresh.json")


@pytest.mark.parametrize(
    "statement",
    [
        "assume nothing",
        "assume rho > 0 and R_cheese",
        "audience bayesian(forgetting = 0.01)",
        "audience bayesian(prior = if rho < 0 then 3 else 1)",
    ],
)
def test_viewers_are_those_of_a_fresh_story(
    session: Session, tmp_path: Path, statement: str
) -> None:
    right(session, "save plain.json")
    right(session, statement)
    fresh = as_fresh(tmp_path, statement)
    for question in ("P(rho | script[:t])", "entropy(rho | script[:T])", "P(R_robot | script[:t])"):
        answer = session.run(question).shown[0]
        assert isinstance(answer, Asked)
        assert answer.answer.value == pytest.approx(fresh.query(question), abs=1e-12)
    assert same(
        saved_and_read(session, tmp_path).query("P(rho | script[:t])"),
        fresh.query("P(rho | script[:t])"),
    )


def test_settings_of_the_world_keep_the_script(session: Session, tmp_path: Path) -> None:
    before = asked(session, "P(rho | script[:T])")
    path = session.state.path
    right(session, "world kitchen(forgetting = 0.02)")
    assert session.state.path is path
    changed = asked(session, "P(rho | script[:T])")
    assert not np.allclose(changed, before)
    right(session, "save other.json")
    assert json.loads(Path("other.json").read_text())["world"]["settings"] == {"forgetting": 0.02}
    assert i2pdsl.Script.load("other.json").query("P(rho | script[:T])") == pytest.approx(changed)


def test_another_world_has_another_script(session: Session) -> None:
    reply = right(session, "world maze")
    assert any("the script is gone" in remark for remark in reply.said)
    assert asked(session, "T") == 0
    looked = shown(session, "show")
    assert isinstance(looked, Looked)
    assert "M mouse" in looked.picture
    right(session, "play mouse west")
    assert asked(session, "T") == 1


# Files.


def test_played_scripts_and_their_names_are_read_again(session: Session, tmp_path: Path) -> None:
    right(session, "let friend = rho > 0")
    right(session, "assume nothing")
    right(session, "play cheese west!, robot north")
    question = "P(friend and R_robot | script[:t])"
    answer = asked(session, question)
    right(session, "save played.json")
    again = Session()
    reply = again.open("played.json")
    assert reply.said == ("played.json: world kitchen, 16 frames",)
    assert same(asked(again, question), answer)
    assert same(i2pdsl.Script.load("played.json").query(question), answer)


def test_a_session_without_a_whole_story_is_saved_too(session: Session) -> None:
    fresh = Session()
    fresh._workshop = session.workshop
    right(fresh, "let friend = rho > 0")
    right(fresh, "audience bayesian(forgetting = 0.01)")
    right(fresh, "play cheese west, robot south")
    right(fresh, "play robot south")
    answer = asked(fresh, "P(friend | script[:t])")
    right(fresh, "save little.json")
    again = Session()
    again.open("little.json")
    assert same(asked(again, "P(friend | script[:t])"), answer)
    assert "no-objective" in refused(again, "suggest")


def test_a_world_that_a_script_carries_is_not_that_of_others(session: Session) -> None:
    right(session, "save carried.json")
    again = Session()
    again.open("carried.json")
    right(again, "world maze")
    looked = shown(again, "show")
    assert isinstance(looked, Looked)
    assert "M mouse" in looked.picture


def test_pictures_are_written(session: Session) -> None:
    right(session, "rewind 2")
    reply = right(session, "save two.svg")
    assert set(reply.said) == {"two/comic.svg", "two/mind.svg"}
    for name in reply.said:
        assert "<svg" in Path(name).read_text(encoding="utf-8")


def test_a_library_is_opened_in_the_world_at_hand(session: Session) -> None:
    right(session, f"load {STORIES}/patterns/twist.story")
    right(session, "load " + str(STORIES / "patterns" / "twist.story"))
    assert asked(session, "twist(rho > 0, rho < 0)") > 0


def test_a_story_that_is_saved_far_from_what_it_imports(session: Session, tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "mine.story").write_text("let friend = rho > 0\n")
    text = "world kitchen\nlength 15\nimport mine\nmaximize depict(friend)\n"
    (tmp_path / "here" / "told.story").write_text(text)
    right(session, "load here/told.story")
    assert right(session, "save here/again.story").said == ("here/again.story",)
    name, remark = right(session, "save there.story").said
    assert name == "there.story"
    assert remark == "not whole where it is now: there is no library `mine`"


def test_nothing_is_written_before_there_are_frames(session: Session) -> None:
    right(session, "rewind")
    assert "no frames yet" in refused(session, "save it.json")
    assert not Path("it.json").exists()


# The hill.


@pytest.fixture(scope="module")
def hill() -> State:
    session = Session()
    right(session, "world hill(weight = 0.1)")
    right(session, "play 50")
    return session.state


@pytest.fixture
def on_the_hill(hill: State, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Session:
    monkeypatch.chdir(tmp_path)
    session = Session()
    session.state = hill
    return session


def test_pinned_frames_of_the_hill_are_told(on_the_hill: Session) -> None:
    right(on_the_hill, "play 6")
    for typed, told in (("pin 2-3,5", "2-3, 5"), ("pin 3-4", "2-5"), ("unpin 3", "2, 4-5")):
        right(on_the_hill, typed)
        assert shown(on_the_hill, "story").text.endswith(f"as they are in the script: {told}")
    right(on_the_hill, "unpin")
    assert "as they are" not in shown(on_the_hill, "story").text


def test_playing_on_the_hill_is_what_the_hopper_does_by_itself(on_the_hill: Session) -> None:
    text = "world hill(weight = 0.1)\nlength 50\nsearch naive(noise = 0)\n"
    plain = story_from(Source("plain.story", text)).solve(seed=0).script
    for question in ("P(weight = 0.5 | script[:t])", "E[V(hopper) | script[:t]]"):
        assert asked(on_the_hill, question) == pytest.approx(plain.query(question), abs=1e-9)
    looked = shown(on_the_hill, "show")
    assert isinstance(looked, Looked)
    assert "hopper at x =" in looked.picture


def test_frames_of_the_hill_are_saved_and_followed(on_the_hill: Session) -> None:
    right(on_the_hill, "let heavy = weight = 0.5")
    right(on_the_hill, "play 7")
    answer = asked(on_the_hill, "P(heavy | script[:t])")
    assert answer.shape == (58,)
    right(on_the_hill, "save hopped.json")
    again = Session()
    again.open("hopped.json")
    # Files hold the states in single precision.
    assert asked(again, "P(heavy | script[:t])") == pytest.approx(answer, abs=1e-5)
    right(again, "rewind 10")
    assert asked(again, "P(heavy | script[:t])") == pytest.approx(answer[:11], abs=1e-5)
    assert "from 1 to 10,000" in refused(again, "play hopper west")


# Help.


def test_everything_can_be_explained(session: Session) -> None:
    from i2pdsl.repl.helping import every_word

    words = every_word(session.state)
    assert {"KL", "sum_t", "play", "maximize", "rho", "pink", "cheese", "depict", "deus"} <= words
    for word in sorted(words):
        told = shown(session, f"help {word}")
        assert isinstance(told, Text)
        assert word.strip("[ @]") in told.text, word
    overview = shown(session, "help")
    assert isinstance(overview, Text)
    assert "rho in {-3, -1, 0, 1, 3}" in overview.text


# Of scripts without frames, and in other worlds.


@pytest.mark.parametrize(
    "question", ["P(rho > 0 | script[:t]) - P(rho > 0 | script[:t-1])", "P(rho | script[:t-1])"]
)
def test_questions_that_begin_at_frame_1(session: Session, question: str) -> None:
    right(session, "rewind")
    reply = right(session, question)
    assert reply.said == (NO_FRAMES,)
    (answer,) = reply.shown
    assert set(in_a_line(answer)) <= set("; -0123456789")
    assert on_a_terminal(answer, Ink()) == ""
    for command in ("plot", "table"):
        assert in_a_line(shown(session, f"{command} {question}")) == NOTHING
    assert NOTHING in refused(session, f"plot {question} > a.png")
    right(session, "play cheese west!")
    assert right(session, question).said == ()


@pytest.mark.parametrize("number", ["9223372036854775808", "1.7e308", "-1.7e308", "1e-320", "0"])
def test_level_lines_of_any_size(session: Session, number: str) -> None:
    text = in_a_line(shown(session, f"plot {number}"))
    assert text.count("*") > 10
    assert "inf" not in text
    assert "nan" not in text


def test_the_greatest_numbers_are_drawn(session: Session) -> None:
    text = in_a_line(shown(session, "plot -1.7e308, 1.7e308"))
    assert text.count("*") > 10
    assert text.count("o") > 10
    assert "are not drawn into files" in refused(session, "plot 1.7e308 > a.png")
    right(session, "plot 9223372036854775808 > a.png")


def test_predicates_are_steps(session: Session) -> None:
    def drawn(question: str) -> bool:
        plotted = shown(session, f"plot {question}")
        assert isinstance(plotted, Plotted)
        (curve,) = curves_of(plotted.answers[0], plotted.frames)
        return curve.steps

    assert drawn("[moved(robot) @ script[t]]")
    assert drawn("1 - [moved(robot) @ script[t]]")
    assert not drawn("[moved(robot) @ script[t]] / 2")
    assert not drawn("P(rho > 0 | script[:t])")
    assert not drawn("1")
    right(session, "plot [moved(robot) @ script[t]] > steps.svg")
    assert Path("steps.svg").is_file()


@pytest.mark.parametrize("world", ["fork", "hill", "maze", "porters"])
def test_help_speaks_of_the_world_at_hand(world: str) -> None:
    session = Session()
    right(session, f"world {world}")
    words = session.state.typed.vocabulary
    known = {*words.characters, *words.things, *words.places, *words.events, *words.latents}
    foreign = {"cheese", "robot", "table", "deus", "pink", "rho", "G_cheese", "G_robot"} - known
    names = (*(w.name for w in (*STATEMENTS, *FORMS, *COMMANDS)), "")
    examples = 0
    for name in names:
        text = in_a_line(shown(session, f"help {name}"))
        told = [line for line in text.splitlines() if "for instance" in line or "Ask any" in line]
        for line in told:
            line = re.sub(r"instance: table|\w+/\S+", "", line)
            assert not foreign.intersection(re.findall(r"\w+", line)), line
        examples += bool(told)
    assert examples > 20


def test_an_example_of_another_world_is_right_there() -> None:
    session = Session()
    right(session, "world fork")
    text = in_a_line(shown(session, "help P")) + in_a_line(shown(session, "help in"))
    assert "P(G_robot in {left} | script[:T])" in text
    right(session, "P(G_robot in {left} | script[:T])")


def test_a_script_whose_story_names_the_file_of_its_world(
    session: Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The script brings its world along, wherever it lies."""
    (tmp_path / "made").mkdir()
    text = (STORIES / "worlds" / "maze.world").read_text(encoding="utf-8")
    (tmp_path / "made" / "my.world").write_text(text, encoding="utf-8")
    story = tmp_path / "made" / "a.story"
    story.write_text('world "my.world"\nlength 2\nsearch naive\n', encoding="utf-8")
    i2pdsl.load(story).solve(seed=0).script.save(tmp_path / "moved.json")
    right(session, "load moved.json")
    question = "P(rho > 0 | script[:t])"
    assert asked(session, question) == pytest.approx(
        Script.load(tmp_path / "moved.json").query(question)
    )
    right(session, "play mouse west")
    right(session, "world maze")


def test_maps_with_wide_signs_stand_in_columns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    session = Session()
    rows = "map\n    巣..#\n    ....\n    ..種.\n"
    tiles = "tile 巣\n    symbol = 巣\ntile seed\n    symbol = 種\n"
    cat = "character 猫\n    goals = {巣, seed}\n"
    (tmp_path / "han.world").write_text(rows + tiles + cat, encoding="utf-8")
    right(session, "world han")
    looked = shown(session, "show")
    lines = in_a_line(looked).splitlines()[1:4]
    assert {display_width(line) for line in lines} == {4 + 4 * 2 + 3}
    assert lines[0].endswith(" ██")
    bars = on_a_terminal(looked, Ink()).splitlines()[-2:]
    one, other = (display_width(bar[: bar.index("0.5")]) for bar in bars)
    assert one == other


def test_pinned_frames_are_statements_that_can_be_taken_out(session: Session) -> None:
    right(session, "pin 9,2-3")
    told = right(session, "story").shown[0]
    assert isinstance(told, Text)
    assert [told.text.count(f"pin script[{k}]") for k in (2, 3, 9)] == [2, 1, 2]
    right(session, "unpin 9")
    assert {pin.frame for pin in session.state.typed.pins} == {2, 3}
    right(session, "pin script[4]: at(robot, pink)")
    right(session, "unpin")
    assert not session.state.typed.pins
    assert "expected frames from 1 to 15" in refused(session, "pin 16")
    assert "nothing is pinned" in refused(session, "unpin 3")
