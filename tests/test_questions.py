"""Many scripts, questions and audiences at once: the same answers as one after the other."""

from __future__ import annotations

import csv
import io
import json
import math
from functools import cache
from pathlib import Path
from random import Random

import numpy as np
import pytest

import i2pdsl
import reference
from commands_for_tests import Run
from i2pdsl.errors import StoryError
from i2pdsl.questions import NO_FRAME, Table, query
from i2pdsl.scripts import Script, make_record, script_from
from i2pdsl.stories import Story
from i2pdsl.worlds.record import Record
from worlds_for_tests import SMALL_MAP, Pair, kitchen_text, small_kitchen

TEXT = """world small
length {length}

let friend = rho > 0

audience bayesian(forgetting = 0.05)
audience child = bayesian(beta = 0.5)
audience insider = bayesian(given = G_cheese = pink)

maximize sum_t P(friend | script[:t])
"""
QUESTIONS = (
    "P(friend | script[:t])",
    "P(friend | script[:T])",
    "P(friend | script[:t]) - P(friend | script[:0])",
    "P(G_robot | script[:t])",
    "P(G_robot | script[:T])",
    "P(G_cheese, rho | script[:t])",
    "P[child](friend | script[:t], G_cheese = pink)",
    "P[insider](friend | script[:t]) - P(friend | script[:t])",
    "E[V(robot) | script[:t]]",
    "E[V(cheese) * rho | script[:t], friend]",
    "entropy(rho | script[:t])",
    "KL(script[:t-1] || script[:t])",
    "P(friend @ script[t] | script[:T])",
    "P(G_robot @ script[2] | script[:t])",
    "E[V(robot) @ script[t-1] | script[:t, cheese]]",
    "KL[insider](rho @ script[1]; script[:t] || script[:T])",
    "P(G_cheese @ script[T] | (script ++ [cheese: stay, robot: east])[:T+1])",
    "surprise(script[t])",
    "suspense(rho | script[:t])",
    "next(cheese | script[:t])",
    "mean_t P(friend | script[:t])",
    "max_t (t * P(friend | script[:t]))",
    "sum_{t in 2..3} P(friend | script[:t]) - min_t P(friend | script[:t])",
    "sum_t sin(t / T) * [adjacent(cheese, robot) @ script[t]]",
    "if t < 2 then [moved(robot) @ script[t]] else points((0, 0), (1, 1))",
    "eventually [pushes(robot, cheese)]",
    "beats(sum_t P(friend | script[:t]), sum_t (1 - P(friend | script[:t])))",
    "when [moved(cheese)]",
    "P(friend | (script ++ [cheese: stay, robot: stay])[:T+1])",
    "sum_t surprise((script ++ [cheese: east, robot: west])[t])",
)


def pair() -> Pair:
    return small_kitchen()


def record(length: int, seed: int) -> Record:
    """A script of random turns and events, and the story that it came from."""
    path = pair().random_script(Random(seed), length, events=0.3)
    about = {"name": "friend", "file": "friend.story", "source": TEXT.format(length=length)}
    world = kitchen_text(SMALL_MAP, gamma="0.8")
    made = make_record(pair().world, path, about, {}, None)
    return Record(made.story, {**made.world, "source": world}, None, made.start, made.frames)


@cache
def scripts() -> tuple[Script, ...]:
    """Of two lengths, in turns."""
    return tuple(script_from(record(3 + number % 2, number), None) for number in range(6))


def alone(script: Script, question: str) -> np.ndarray:
    """Its rows, from the script's own answer."""
    answer = script.ask(question)
    if answer.axes:
        return answer.present()[1].reshape(-1)
    if answer.labels is None:
        return answer.value.reshape(-1)
    return np.stack(list(answer.columns().values()), axis=-1).reshape(-1)


def rows(table: Table, script: str, question: str) -> Table:
    return table[(table.script == script) & (table.question == question)]


def test_all_at_once_is_one_after_the_other() -> None:
    """Whatever is asked, of scripts with events and without, of two lengths, before viewers with
    names: to the last digit."""
    table = query(scripts(), QUESTIONS)
    for number, script in enumerate(scripts()):
        for question in QUESTIONS:
            found = rows(table, str(number), question).value
            assert np.array_equal(found, alone(script, question)), (number, question)
    assert list(dict.fromkeys(table.script)) == [str(n) for n in range(6)]


def test_a_row_says_what_it_is() -> None:
    table = query(
        scripts()[:1], {"wants": "P(G_robot | script[:t])", "at last": "P(friend | script[:T])"}
    )
    assert table.dtype.names == ("script", "question", "audience", "t", "event", "value")
    wants = table[table.question == "wants"]
    assert list(wants.t) == [t for t in range(4) for _ in range(3)]
    assert list(wants.event[:3]) == [f"G_robot = {goal}" for goal in ("pink", "green", "none")]
    assert np.allclose(wants.value.reshape(4, 3).sum(1), 1)
    last = table[table.question == "at last"]
    assert list(zip(last.t, last.event, last.audience, strict=True)) == [(NO_FRAME, "", "")]
    irrational = query(scripts()[:1], "P(G_robot | script[:t])", assume="nothing")
    assert list(irrational.event[:4])[-1] == "G_robot = unknown"
    assert np.allclose(irrational.value.reshape(4, 4).sum(1), 1)


def test_a_table_goes_into_pandas() -> None:
    frame = query(scripts()[:2], ("P(friend | script[:T])", "P(friend | script[:t])")).to_pandas()
    assert frame["t"].isna().sum() == 2
    assert len(frame) == 2 + 4 + 5


def test_other_viewers_are_those_that_a_story_would_have() -> None:
    """Against the same script in a story with that audience, and with the others' names kept."""
    given = "average(bayesian(beta = 0.5), bayesian(given = rho < 0))"
    line = "audience bayesian(forgetting = 0.05)"
    own = record(3, 0)
    text = TEXT.format(length=3).replace(line, f"audience {given}")
    told = script_from(Record({**own.story, "source": text}, *list(vars(own).values())[1:5]), None)
    asked = ("P(friend | script[:t])", "P[insider](friend | script[:t])", "P(G_robot | script[:t])")
    table = query(scripts()[0], asked, [None, given, "child"])
    for question in asked:
        found = rows(table, "0", question)
        assert np.array_equal(found[found.audience == given].value, alone(told, question))
        assert np.array_equal(found[found.audience == ""].value, alone(scripts()[0], question))
        assert np.array_equal(scripts()[0].query(question, audience=given), told.query(question))
    child = rows(table, "0", asked[0])
    assert np.array_equal(
        child[child.audience == "child"].value, scripts()[0].query("P[child](friend | script[:t])")
    )


def test_who_excludes_what_explains_all_is_followed_like_others() -> None:
    """Actions that a sharp viewer finds less likely than a double can hold under all that he
    thinks possible, and likely under what he excludes: Bayes' rule in plain Python."""
    e, gaps = 0.05, []
    viewer = f"bayesian(sharpness = 1000, forgetting = {e}, given = R_cheese and R_robot)"
    for told in scripts():
        seen = told.seen_by(viewer)
        world, path = seen.world, seen.trajectory
        prior = world.log_prior(world.tables)[0]
        held = [h for h, log in enumerate(prior) if log > -np.inf]
        friend = [row.get("rho", 0) > 0 for row in world.vocabulary.hypotheses]
        belief = {h: math.exp(prior[h]) for h in held}
        expected = [sum(p for h, p in belief.items() if friend[h])]
        for t in range(len(path.actions)):
            at = (path.states[[t]], path.actions[[t]], path.states[[t + 1]])
            rows = world.log_rows(world.tables, *at) if world.is_observed(at[1])[0] else ()
            for row in rows:
                logs = {h: math.log(belief[h]) + row[0, 0, h] for h in held}
                top = max(logs.values())
                gaps.append(max(row[0, 0]) - top)
                weights = {h: math.exp(log - top) for h, log in logs.items()}
                p = {h: weights[h] / sum(weights.values()) for h in held}
                belief = {h: p[h] * (1 - e) + (1 - p[h]) * e / (len(held) - 1) for h in held}
            expected.append(sum(p for h, p in belief.items() if friend[h]))
        assert seen.query("P(friend | script[:t])") == pytest.approx(expected, abs=1e-9)
    assert max(gaps) > 800


@pytest.mark.parametrize(
    ("audience", "code"),
    [
        ("bayesian(bet = 1)", "setting"),
        ("nobody", "audience"),
        ("3 + 4", "audience"),
        ("bayesian(", "bracket"),
        ("bayesian(given = not R_robot)", "impossible"),
    ],
)
def test_wrong_viewers_are_told(audience: str, code: str) -> None:
    with pytest.raises(StoryError) as wrong:
        scripts()[0].query("P(friend | script[:T])", audience=audience)
    assert [d.code for d in wrong.value.diagnostics] == [code]


def test_viewers_who_take_it_for_impossible_can_be_asked_without_an_assumption() -> None:
    """Who knows that the robot acts at random."""
    expression, audience = "P(R_robot | script[:T])", "bayesian(given = not R_robot)"
    assert scripts()[0].query(expression, "nothing", audience) == 0


@pytest.mark.parametrize("number", range(4))
def test_evidence_is_the_marginal_likelihood(number: int) -> None:
    """Of viewers who forget nothing: log sum_H P(H) prod P(action | H), by plain Python; with and
    without an assumption."""
    truth = pair().reference
    script, hypotheses = scripts()[number], truth.hypotheses
    logs, state = [0.0] * len(hypotheses), truth.state(script.record.start)
    for frame in script.record.frames:
        for who, action, acted_from, _ in truth.actions(state, frame):
            for i, h in enumerate(hypotheses):
                logs[i] += truth.log_likelihood(who, h, acted_from, action)
        state = truth.after(state, frame)
    for assume, event in ((None, reference.rational), ("nothing", lambda h: True)):
        some = [log for log, h in zip(logs, hypotheses, strict=True) if event(h)]
        expected = math.log(math.fsum(map(math.exp, some)) / len(some))
        found = script.evidence(assume, "bayesian(forgetting = 0)")
        assert found == pytest.approx(expected, abs=1e-6)


def test_a_turn_that_cannot_follow_has_no_value() -> None:
    """Where one script is asked it is a mistake; of many it is said in its row."""
    question = "P(friend | (script ++ [deus: table at (0, 0)])[:T+1])"
    found = query(scripts(), question).value
    for script, value in zip(scripts(), found, strict=True):
        try:
            assert value == script.query(question)
        except StoryError:
            assert np.isnan(value)
    assert np.isnan(found).sum() > 0


def test_scripts_may_be_files_or_what_stands_in_them(tmp_path: Path) -> None:
    """With the mistakes of all of them."""
    paths = [script.save(tmp_path / f"{n}.json") for n, script in enumerate(scripts()[:2])]
    content = json.loads(paths[0].read_text(encoding="utf-8"))
    asked = "P(friend | script[:t])"
    named = {"path": paths[0], "text": str(paths[0]), "dict": content, "record": record(3, 0)}
    table = query(named, asked)
    for name in named:
        assert np.array_equal(rows(table, name, asked).value, scripts()[0].query(asked))
    folder = query(tmp_path, asked)
    assert list(dict.fromkeys(folder.script)) == [str(path) for path in paths]
    assert np.array_equal(folder.value, query(paths, asked).value)
    content["start"]["cheese"] = [9, 9]
    (tmp_path / "wrong.json").write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(StoryError) as wrong:
        query([*paths, tmp_path / "wrong.json", tmp_path / "none.json"], asked)
    assert [d.code for d in wrong.value.diagnostics] == ["script", "no-file"]
    assert len(query([], asked)) == 0


@pytest.mark.parametrize("text", ["world desk\nlength 4\n", "world hill(weight = 0.1)\nlength 3\n"])
def test_where_bodies_move(text: str) -> None:
    story = Story.from_text(f"{text}search naive(noise = 0.2)\n")
    found = [story.solve(seed).script for seed in (0, 1)]
    words = story.typed.vocabulary
    latent, who = next(iter(words.latents)), words.characters[0]
    asked = (f"P({latent} | script[:t])", f"E[V({who}) | script[:t]]", "sum_t surprise(script[t])")
    table = query(found, asked)
    for number, script in enumerate(found):
        for question in asked:
            expected = alone(script, question)
            assert np.allclose(rows(table, str(number), question).value, expected, rtol=1e-9)


# Stories from texts.


def test_a_story_from_a_text_is_one_from_a_file(tmp_path: Path) -> None:
    text = "world maze\nlength 6\nlet friend = rho > 0\nmaximize depict(friend)\n"
    (tmp_path / "story.story").write_text(text, encoding="utf-8")
    story, read = Story.from_text(text), i2pdsl.load(tmp_path / "story.story")
    assert story.typed.objective == read.typed.objective
    other = story.with_(length=4, beta=0.5, friend="rho < 0", starts=20, rationality=np.int64(2))
    same = Story.from_text(text, length=4, beta=0.5, friend="rho < 0", starts=20, rationality=2)
    assert other.typed.source == same.typed.source
    assert (other.typed.length, other.typed.search.starts) == (4, 20)
    assert dict(other.typed.settings) == {"beta": 0.5}
    hill = Story.from_text("world hill\nlength 4\nsearch naive\n", weights=(0.1, 0.3))
    assert dict(hill.typed.settings)["weights"] == (0.1, 0.3)


def test_a_text_finds_what_lies_in_its_folder(tmp_path: Path) -> None:
    world = kitchen_text(SMALL_MAP, gamma="0.8")
    (tmp_path / "tiny.world").write_text(world, encoding="utf-8")
    story = Story.from_text("world tiny\nlength 2\nmaximize depict(rho > 0)\n", str(tmp_path))
    assert story.with_(length=3).spec.name == "tiny"


@pytest.mark.parametrize(
    ("settings", "code"), [({"nobody": 1}, "set"), ({"beta": -1}, "setting"), ({"length": "x"}, "")]
)
def test_wrong_settings_are_told(settings: dict[str, object], code: str) -> None:
    story = Story.from_text("world maze\nlength 6\nmaximize depict(rho > 0)\n")
    with pytest.raises(StoryError) as wrong:
        story.with_(**settings)
    assert code in [d.code for d in wrong.value.diagnostics] or not code


# The command.


def test_the_command_writes_the_same_table(tmp_path: Path, i2p: Run) -> None:
    for number, script in enumerate(scripts()[:3]):
        script.save(tmp_path / "scripts" / str(number) / "script.json")
    (tmp_path / "scripts" / "timeline.json").write_text("{}", encoding="utf-8")
    asked = ("P(friend | script[:t])", "P(friend | script[:T])")
    options = [word for question in asked for word in ("--ask", question)]
    done = i2p("query", tmp_path / "scripts", *options, "--audience", "bayesian(beta = 0.5)")
    assert done.status == 0, done.err
    told = list(csv.DictReader(io.StringIO(done.out)))
    names = [str(tmp_path / "scripts" / str(n) / "script.json") for n in range(3)]
    expected = query(dict(zip(names, scripts(), strict=False)), asked, "bayesian(beta = 0.5)")
    assert [row["script"] for row in told] == list(expected.script)
    assert [float(row["value"]) for row in told] == list(expected.value)
    assert [row["t"] for row in told] == [str(t) if t >= 0 else "" for t in expected.t]
    done = i2p("query", *names, *options, "--json", "--out", tmp_path / "table.json")
    assert (done.status, done.out) == (0, "")
    table = json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))
    assert len(table) == len(expected)
    assert table[-1].keys() == {"script", "question", "audience", "t", "event", "value"}


def test_one_script_may_have_other_viewers(tmp_path: Path, i2p: Run) -> None:
    path = scripts()[0].save(tmp_path / "script.json")
    done = i2p("query", path, "P(friend | script[:T])", "--audience", "child", "--json")
    expected = scripts()[0].query("P[child](friend | script[:T])")
    assert json.loads(done.out)["value"] == expected


@pytest.mark.parametrize("arguments", [(), ("a.json",), ("a.json", "b.json", "P(rho > 0)")])
def test_what_is_asked_must_be_clear(arguments: tuple[str, ...], i2p: Run) -> None:
    assert i2p("query", *arguments).status == 2
