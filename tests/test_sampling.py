"""Rollouts under hypotheses: who acts follows the policy, and viewers are calibrated about it."""

from __future__ import annotations

import csv
import json
import math
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import i2pdsl
from commands_for_tests import Run
from i2pdsl import sampling
from i2pdsl.errors import StoryError
from i2pdsl.language.story import TypedStory
from i2pdsl.questions import query
from i2pdsl.sampling import Samples, sample
from i2pdsl.worlds.grid.world import GridWorld
from i2pdsl.worlds.ready import viewers_of
from i2pdsl.worlds.world import log_priors, switching_of
from worlds_for_tests import Pair, small_kitchen, with_small_world

ROWS = ("P.", ".G", "..")
TEXT = "world kitchen\nlength 5\nmaximize depict(rho > 0)\n"
HYPOTHESES = (
    "rho = 3 and G_cheese = pink and G_robot = none",
    "rho = -1 and G_cheese = green and G_robot = green",
)
BEGIN = "start at(cheese, (1, 2)) and at(robot, (0, 2)) and absent(table)\n"


def pair() -> Pair:
    return small_kitchen(ROWS)


def drawn(text: str, count: int, seed: int = 0, **given: str) -> Samples:
    story = pair().story(text)
    return sample(story, with_viewers(story), count, seed, **given)


def with_viewers(story: TypedStory) -> GridWorld:
    """The planned world before the story's viewers, who differ in nothing that is planned."""
    world = pair().world
    viewers = viewers_of(world.spec, story.observers)
    columns = tuple(np.repeat(each, len(viewers), axis=0) for each in world.tables.columns)
    forgetting = np.array([viewer.spec.settings.forgetting for viewer in viewers])
    prior = log_priors(viewers, world.vocabulary)
    told = {"columns": columns, "forgetting": forgetting, "log_prior": prior}
    switching = switching_of(viewers, world.vocabulary, prior)
    return replace(world, tables=world.tables._replace(**told, switching=switching))


def near(share: float, p: float, count: int) -> bool:
    """Within five standard deviations."""
    return abs(share - p) <= 5 * math.sqrt(p * (1 - p) / count) + 1e-9


@pytest.mark.parametrize("given", HYPOTHESES)
def test_actions_come_as_often_as_the_policy_says(given: str) -> None:
    """First those of the cheese, then, from each state that it reached, those of the robot; and
    moves succeed as often as the world says. By plain Python."""
    count = 2000
    found = drawn(TEXT.replace("5", "1") + BEGIN, count, given=given)
    truth = pair().reference
    (number,) = set(found.hypotheses.tolist())
    hypothesis = pair().vocabulary.hypotheses[number]
    frames = [script.record.frames[0] for script in found.scripts]
    start = truth.state(found.scripts[0].record.start)
    seen = Counter(frame["cheese"]["action"] for frame in frames)
    for action, p in truth.policy("cheese", hypothesis, start).items():
        assert near(seen[action] / count, p, count), action
    tried = [f for f in frames if truth.effect(start, "cheese", f["cheese"]["action"]) != start]
    luck = sum(frame["cheese"]["moved"] for frame in tried) / len(tried)
    assert near(luck, 0.6, len(tried))
    reached: dict[object, list[str]] = {}
    for frame in frames:
        (_, _, _, middle), _ = truth.actions(start, frame)
        reached.setdefault(middle, []).append(frame["robot"]["action"])
    for middle, actions in reached.items():
        for action, p in truth.policy("robot", hypothesis, middle).items():
            assert near(actions.count(action) / len(actions), p, len(actions)), (middle, action)


@cache
def many(audience: str = "") -> Samples:
    return drawn(TEXT + audience, 2000, seed=1)


def test_hypotheses_come_as_often_as_the_prior_says() -> None:
    """Uniformly from those that the assumption leaves, 28 of 34."""
    seen = Counter(many().hypotheses.tolist())
    assert all(pair().vocabulary.hypotheses[h]["R_robot"] for h in seen)
    assert len(seen) == 28
    assert all(near(n / 2000, 1 / 28, 2000) for n in seen.values())
    everyone = drawn(TEXT.replace("5", "1"), 500, assume="nothing")
    assert len(set(everyone.hypotheses.tolist())) == 34


CHANGING = "audience bayesian(switching = 0.2, forgetting = 0, prior = if rho > 0 then 2 else 1)"


@pytest.mark.parametrize(
    ("event", "audience", "frame"),
    [
        ("rho > 0", "", 5),
        ("G_cheese = pink", "", 5),
        ("G_robot = none", "", 5),
        ("G_cheese = pink", CHANGING, 5),
        ("G_robot = none", CHANGING, 2),
        ("rho > 0", CHANGING, 2),
    ],
)
def test_beliefs_are_calibrated(event: str, audience: str, frame: int) -> None:
    """Of films for which viewers say p, a share of p is so; also in hindsight."""
    found = many(audience)
    said = query(found.scripts, f"P({event} @ script[{frame}] | script[:T])").value
    latent, _, value = event.split()
    rows = [pair().vocabulary.hypotheses[h][latent] for h in found.courses[:, frame]]
    is_so = np.array([r > 0 if event == "rho > 0" else r == value for r in rows])
    for low in np.arange(0, 1, 0.2):
        some = (said >= low) & (said <= low + 0.2)
        spread = math.sqrt((said[some] * (1 - said[some])).sum())
        assert abs((said[some] - is_so[some]).sum()) <= 4.5 * spread + 0.5, low
    assert said.std() > 0.1  # they learn something


def test_goals_change_as_often_as_viewers_think() -> None:
    """In a frame each goal is drawn anew with probability .2, of two or three given all else."""
    found, rows = many(CHANGING), pair().vocabulary.hypotheses
    before, after = (found.courses[:, part].ravel() for part in (slice(0, -1), slice(1, None)))
    pairs = [(rows[a], rows[b]) for a, b in zip(before, after, strict=True)]
    others = ("rho", "R_cheese", "R_robot")
    assert all(a[x] == b[x] for a, b in pairs for x in others)
    cheese = [a["G_cheese"] != b["G_cheese"] for a, b in pairs]
    assert near(sum(cheese) / len(cheese), 0.2 / 2, len(cheese))
    for rho, options in ((0, 2), (3, 3)):  # an indifferent robot wants something
        robot = [a["G_robot"] != b["G_robot"] for a, b in pairs if a["rho"] == rho]
        assert near(sum(robot) / len(robot), 0.2 * (options - 1) / options, len(robot))
    story = found.scripts[0].record.story
    changes = {change["frame"]: change["drawn"] for change in story.get("changes", ())}
    course, now = [], story["drawn"]
    for t in range(6):
        now = changes.get(t, now)
        course.append(now)
    assert course == [rows[h] for h in found.courses[0]]


def test_viewers_who_know_something_draw_what_they_know() -> None:
    """Each of an audience's viewers with his own prior, as often as the others."""
    text = (
        TEXT.replace("5", "1")
        + "let known = rho > 0\nlet less = if rho < 0 then 1 else 0\n"
        + "audience average(bayesian(given = known), bayesian(prior = less))\n"
    )
    found = drawn(text, 400)
    rhos = np.array([pair().vocabulary.hypotheses[h]["rho"] for h in found.hypotheses])
    assert ((rhos > 0) == (found.observers == 0)).all()
    assert near((found.observers == 0).mean(), 0.5, 400)


def test_the_same_seed_gives_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """However many go on side by side."""
    one = drawn(TEXT, 12, seed=3)
    monkeypatch.setattr(sampling, "AT_ONCE", 5)
    other = drawn(TEXT, 12, seed=3)
    assert [s.record for s in one.scripts] == [s.record for s in other.scripts]
    assert [s.record for s in one.scripts] != [s.record for s in drawn(TEXT, 12, seed=4).scripts]


def test_confusion_counts_what_is_most_believed() -> None:
    found = drawn(TEXT, 60, seed=5)
    for latent in found.latents:
        matrix = found.confusion(latent)
        counts: Counter[tuple[str, str]] = Counter()
        for script, drawn_value in zip(found.scripts, found.drawn(latent), strict=True):
            answer = script.ask(f"P({latent} | script[:T])")
            assert answer.labels == matrix.believed
            counts[drawn_value, answer.labels[int(answer.value.argmax())]] += 1
        for i, row in enumerate(matrix.drawn):
            for j, column in enumerate(matrix.believed):
                assert matrix.counts[i, j] == counts[row, column]
        assert matrix.counts.sum() == 60
        assert matrix.right == sum(n for (a, b), n in counts.items() if a == b) / 60
    assert found.latents == ("rho", "G_cheese", "G_robot")
    irrational = drawn(TEXT, 200, seed=5, assume="nothing")
    assert "unknown" in irrational.confusion("rho").drawn


def test_the_command_writes_scripts_and_what_was_drawn(
    tmp_path: Path, i2p: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = with_small_world(tmp_path)
    (folder / "my.story").write_text(
        "world small\nlength 3\nmaximize depict(rho > 0)\n", encoding="utf-8"
    )
    options = ("--given", "rho > 0 and G_cheese = pink", "-n", 12, "--out", tmp_path / "out")
    done = i2p("sample", folder / "my.story", *options, "--json")
    assert done.status == 0, done.err
    told = json.loads(done.out)
    assert told["confusion"]["G_cheese"]["drawn"] == ["pink"]
    assert np.sum(told["confusion"]["rho"]["counts"]) == 12
    with open(told["table"], encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["script"] for row in rows] == [f"{n:02}.json" for n in range(12)]
    for row in rows:
        script = i2pdsl.Script.load(tmp_path / "out" / row["script"])
        assert script.record.story["drawn"]["rho"] == float(row["rho"]) > 0
        believed = script.query(f"P(rho = {row['rho']} | script[:T])")
        assert float(row["rho_p"]) == pytest.approx(believed)
    monkeypatch.chdir(tmp_path)
    said = i2p("sample", folder / "my.story", "-n", 2).out
    assert "most believed at the end is the truth in" in said
    assert (tmp_path / "out" / "my" / "samples" / "samples.csv").exists()


@pytest.mark.parametrize(
    ("given", "code"),
    [("rho = 7", "no-value"), ("rho > 0 and rho < 0", "impossible"), ("rho >", "syntax")],
)
def test_a_wrong_condition_is_told(given: str, code: str) -> None:
    with pytest.raises(StoryError) as wrong:
        drawn(TEXT, 3, given=given)
    assert [d.code for d in wrong.value.diagnostics] == [code]


def test_what_is_not_thought_possible_cannot_be_drawn() -> None:
    text = TEXT + "audience bayesian(prior = if rho > 0 then 1 else 0)\n"
    with pytest.raises(StoryError, match="no hypothesis"):
        drawn(text, 3, given="rho < 0")


def test_where_nothing_can_be_listed_it_is_told() -> None:
    with pytest.raises(StoryError, match="can be listed"):
        i2pdsl.Story.from_text("world hill\nlength 3\nsearch naive\n").sample(2)
    story = i2pdsl.Story.from_text("world fork\nlength 3\nmaximize depict(G_robot = left)\n")
    with pytest.raises(ValueError, match="at least"):
        story.sample(0)
