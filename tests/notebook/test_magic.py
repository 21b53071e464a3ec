"""The magics of notebooks: what they make, what they show, and what they say of mistakes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from IPython.core.displaypub import CapturingDisplayPublisher

from i2pdsl.answers import Answer
from i2pdsl.errors import StoryError
from i2pdsl.stories import Result, Script, Story, load

FRIEND = """world maze
length 6

let friend = rho > 0

maximize depict(friend)
search beam(starts = 50, polish = 1)
"""


def test_a_story_becomes_three_variables_and_a_player(notebook: Any) -> None:
    done = notebook.run(f"%%story cat --seed 2\n{FRIEND}")
    assert done.success, done.out
    script, story, result = (notebook.names[f"cat{end}"] for end in ("", "_story", "_result"))
    assert isinstance(script, Script)
    assert isinstance(story, Story)
    assert isinstance(result, Result)
    assert result.script is script
    assert script.record.story == {"name": "cat", "file": "cat", "source": FRIEND, "seed": 2}
    (shown,) = done.shown
    assert "<iframe" in shown["text/html"]


def test_the_script_is_that_of_the_commands(notebook: Any) -> None:
    Path("friend.story").write_text(FRIEND, encoding="utf-8")
    expected = load("friend.story").solve(seed=1).script
    assert notebook.run(f"%%story --seed 1\n{FRIEND}").success
    found = notebook.names["script"]
    assert (found.trajectory.states == expected.trajectory.states).all()
    assert found.score == expected.score


def test_candidates_are_listed(notebook: Any) -> None:
    done = notebook.run(f"%%story --candidates 3\n{FRIEND}")
    (shown,) = done.shown
    scores = [f"{s.score:.4f}" for s in notebook.names["script_result"].candidates]
    assert len(scores) == 3
    for score in scores:
        assert f"<td>{score}</td>" in shown["text/html"]


def test_values_are_replaced(notebook: Any) -> None:
    head = "%%story --set length=4 --set 'friend=rho < 0' --set beta=1.5"
    assert notebook.run(f"{head}\n{FRIEND}").success
    script = notebook.names["script"]
    assert script.length == 4
    assert script.record.world["settings"] == {"beta": 1.5}
    assert script.query("P(rho < 0 | script[:T])") > 0.9


def test_a_story_can_only_be_checked(notebook: Any) -> None:
    done = notebook.run(f"%%story plan --no-solve\n{FRIEND}")
    assert done.success
    assert isinstance(notebook.names["plan_story"], Story)
    assert "plan" not in notebook.names
    (shown,) = done.shown
    assert "world maze, 6 frames" in shown["text/html"]


def test_imports_and_worlds_are_looked_for_in_the_folder(notebook: Any) -> None:
    worlds = Path(__file__).parents[2] / "stories" / "worlds"
    text = (worlds / "fork.world").read_text(encoding="utf-8")
    Path("mine.world").write_text(text, encoding="utf-8")
    Path("mylib.story").write_text("pattern left() = depict(G_robot = left)\n", encoding="utf-8")
    done = notebook.run("%%story\nworld mine\nlength 3\nimport mylib\nmaximize left()\n")
    assert done.success, done.out
    assert notebook.names["script"].query("P(G_robot = left | script[:T])") > 0.5


MISTAKES = """%%story
world maze
length 6
maximize depict(rhoo > 0)
maximize P(G_cat = blue | script[:T])
"""
SHOWN = """script:4:17: error[unknown-name]: unknown name `rhoo`
    4 | maximize depict(rhoo > 0)
      |                 ^^^^
  hint: did you mean `rho`?
script:5:20: error[no-value]: `G_cat` is never `blue`
    5 | maximize P(G_cat = blue | script[:T])
      |                    ^^^^
"""


def test_mistakes_are_shown_at_their_lines_of_the_cell(notebook: Any) -> None:
    """Lines as Jupyter numbers them, `%%story` being line 1."""
    done = notebook.run(MISTAKES)
    assert isinstance(done.error, StoryError)
    assert done.out.startswith(SHOWN)
    assert "Traceback" not in done.out + done.err
    assert "script_story" not in notebook.names
    assert MISTAKES.splitlines()[4 - 1][17 - 1 :].startswith("rhoo")


def test_a_mistake_in_a_pattern_shows_both_its_places(notebook: Any) -> None:
    done = notebook.run(
        "%%story\nworld maze\nlength 6\npattern f(x) = sum_t P(x | script[:t])\nmaximize f(1)\n"
    )
    assert done.out.startswith("script:5:12: error") or "script:5:12" in done.out, done.out
    assert "    4 | pattern f(x)" in done.out


def test_mistakes_when_solving_are_told_too(notebook: Any) -> None:
    never = "sum_t log([moved(robot) @ script[t]] - 1)"
    done = notebook.run(
        f"%%story\nworld fork\nlength 3\nmaximize {never}\nsearch beam(starts = 1)\n"
    )
    assert isinstance(done.error, StoryError)
    assert "no finite value" in done.out


def test_warnings_do_not_stop_a_story(notebook: Any) -> None:
    text = "world maze\nlength 6\nmaximize depict(rho > 0)\nmaximize P(R_cat | script[:T])\n"
    done = notebook.run(f"%%story --no-solve\n{text}")
    assert done.success
    assert done.err.startswith("script:5:10: warning[certain]")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("--seed x", "invalid int value"),
        ("--seed -1", "a seed is at least 0"),
        ("--candidates 0", "candidates are 1 to 100"),
        ("my-script", "is no name of a variable"),
        ("lambda", "is no name of a variable"),
        ("--set length", "is not NAME=VALUE"),
        ("--set 'length", "No closing quotation"),
        ("--sed 3", "unrecognized arguments"),
    ],
)
def test_wrong_usage_is_said(notebook: Any, line: str, said: str) -> None:
    done = notebook.run(f"%%story {line}\n{FRIEND}")
    assert not done.success
    assert done.err.startswith("UsageError: ")
    assert said in done.err
    assert "Traceback" not in done.out + done.err


def test_questions(notebook: Any) -> None:
    assert "there is no script" in notebook.run("%query T").err
    notebook.run(f"%%story cat\n{FRIEND}")
    script = notebook.names["cat"]
    asked = notebook.run("%query P(friend | script[:t])").value
    assert isinstance(asked, Answer)
    assert (asked.value == script.query("P(friend | script[:t])")).all()
    # Braces are the language's, not Python's.
    member = notebook.run("%query P(rho in {0, 2} | script[:0])").value
    parts = [float(script.query(f"P(rho = {v} | script[:0])")) for v in (0, 2)]
    assert float(member.value) == pytest.approx(sum(parts))
    for assume in ("nothing", "'R_cat or rho = 0'"):
        found = notebook.run(f"%query --assume {assume} P(R_cat | script[:0])").value
        expected = script.query("P(R_cat | script[:0])", assume=assume.strip("'"))
        assert float(found.value) == float(expected)
    assert notebook.run("kept = %query T").success
    assert float(notebook.names["kept"].value) == 6


def test_questions_to_another_script(notebook: Any, friend: Result) -> None:
    notebook.run(f"%%story cat --set length=4\n{FRIEND}")
    notebook.names["other"] = friend.script
    assert float(notebook.run("%query T").value.value) == 4
    assert float(notebook.run("%query --of other T").value.value) == 6
    notebook.names["cat"] = friend.script  # the variable counts, not what it once was
    assert float(notebook.run("%query T").value.value) == 6


def test_a_wrong_question_is_shown(notebook: Any) -> None:
    notebook.run(f"%%story\n{FRIEND}")
    done = notebook.run("%query P(rhoo > 0 | script[:t])")
    assert isinstance(done.error, StoryError)
    assert done.out.startswith("query:1:3: error[unknown-name]")
    assert notebook.run("%query P(R_cat | script[:T])").err.startswith("query:1:1: warning")
    assert "what is asked?" in notebook.run("%query --assume nothing").err


def test_many_questions(notebook: Any) -> None:
    notebook.run(f"%%story\n{FRIEND}")
    done = notebook.run("%%query\nT\n\n# a comment\n  P(friend | script[:t])\n")
    assert done.success
    assert done.out == "T:\n"
    assert [sorted(data) for data in done.shown] == [["text/plain"], ["image/png", "text/plain"]]
    wrong = notebook.run("%%query --assume nothing\nT\n  P(rhoo > 0 | script[:T])\n")
    assert wrong.out.startswith("query:3:5: error[unknown-name]")
    assert "    3 |   P(rhoo > 0" in wrong.out
    assert wrong.shown == []
    assert "in the lines below" in notebook.run("%%query T\nT").err


def test_errors_in_plain_cells_have_no_traceback(notebook: Any) -> None:
    done = notebook.run("import i2pdsl\ni2pdsl.load('nothing.story')")
    assert done.out.strip() == "nothing.story:1:1: error[no-file]: there is no such file"


def test_progress_in_a_kernel_is_shown_and_cleared(
    notebook: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    cleared = []
    monkeypatch.setattr(notebook.shell, "kernel", object(), raising=False)
    clear = lambda self, wait=False: cleared.append(wait)
    monkeypatch.setattr(CapturingDisplayPublisher, "clear_output", clear)
    done = notebook.run(f"%%story --seed 3\n{FRIEND}")
    assert done.success
    assert "searching: 100 %|" in done.err
    assert cleared == [True]  # with what comes next, so that nothing flickers


def test_help_tells_the_options(notebook: Any) -> None:
    for name in ("story", "query"):
        text = notebook.shell.find_cell_magic(name).__doc__
        assert f"%{name}" in text
        assert "NAME" in text
    story = notebook.shell.find_cell_magic("story").__doc__
    assert all(f"--{word}" in story for word in ("seed", "set", "candidates", "no-solve"))
