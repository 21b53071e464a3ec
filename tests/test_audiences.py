"""Named audiences: against the reference, whose knowing viewer is one for whom other hypotheses do
not exist; and what the rest of the program makes of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from random import Random

import numpy as np
import pytest

import reference as R
from i2pdsl.audience import queries
from i2pdsl.audience.filter import update, updated_share
from i2pdsl.errors import Source
from i2pdsl.explain import document, questions_of
from i2pdsl.language import typed as ty
from i2pdsl.language.check import check_query
from i2pdsl.language.scope import Module
from i2pdsl.language.story import TypedStory
from i2pdsl.objective.belief import Belief, first_belief
from i2pdsl.objective.frame import observe
from i2pdsl.objective.panel import panel
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.objective.terms import score_script, story_objective
from i2pdsl.render.pictures import pictures_of
from i2pdsl.render.reasons import reasons_in_words
from i2pdsl.scripts import Script, script_of
from i2pdsl.worlds.grid import looked_up
from i2pdsl.worlds.grid.looked_up import by_problem
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.planning import Plan, solve
from i2pdsl.worlds.grid.problems import problem_keys
from i2pdsl.worlds.grid.world import GridWorld, assemble, unplanned_world
from i2pdsl.worlds.ready import viewers_of
from i2pdsl.worlds.world import Viewer
from worlds_for_tests import Pair, small_kitchen

ROWS = ("P.", ".G", "..")
LENGTH = 3
AUDIENCES = """
audience bayesian(forgetting = 0.02)
audience child = bayesian(beta = 0.5)
audience insider = bayesian(given = G_cheese = pink, forgetting = 0.1)
audience crowd = average(bayesian(given = rho > 0), bayesian)
"""
SECRET = "sum_t (P[insider](rho > 0 | script[:t]) - P(rho > 0 | script[:t]))"
STORY = f"world kitchen\nlength {LENGTH}\n{AUDIENCES}\nmaximize "


def helps(h: dict) -> bool:
    return h.get("rho", 0) > 0


def knowing(world: R.World, event: Callable[[dict], bool]) -> R.World:
    """The world to a viewer who knows an event to be so: no other hypotheses exist."""
    world.hypotheses = [h for h in world.hypotheses if event(h)]
    return world


def reference_of(**settings: float) -> R.World:
    world = R.kitchen(rows=list(ROWS), gamma=0.8, **settings)
    if "beta" not in settings:
        world._values = small_kitchen(ROWS).reference._values
    return world


@cache
def watched() -> dict[str, list[R.World]]:
    """The viewers of each audience."""
    return {
        "viewers": [reference_of(forgetting=0.02)],
        "child": [reference_of(beta=0.5)],
        "insider": [knowing(reference_of(forgetting=0.1), lambda h: h.get("G_cheese") == "pink")],
        "crowd": [knowing(reference_of(), helps), reference_of()],
    }


def pair() -> Pair:
    return small_kitchen(ROWS)


@cache
def told(objective: str) -> tuple[TypedStory, GridWorld]:
    """A story with all audiences, in a world that knows them."""
    own = pair()
    story = own.story(STORY + objective)
    return story, seen_by(story)


@cache
def plan_of(spec: object) -> object:
    return solve(spec, pair().world.dynamics, tolerance=1e-10)


def seen_by(story: TypedStory) -> GridWorld:
    viewers = viewers_of(pair().spec, story.observers)
    plans = {v.spec.planning_key: v.spec for v in viewers}
    chosen = [plan_of(plans[v.spec.planning_key]) for v in viewers]
    return assemble(pair().spec, pair().world.dynamics, viewers, chosen)


@cache
def script(objective: str = SECRET) -> Script:
    story, world = told(objective)
    path = pair().random_script(Random(3), LENGTH, events=0)
    return script_of(story, world, path, replay(world, path.states, path.actions), {}, None)


FORMS = {
    "P[WHO](rho > 0 | script[:t])": lambda w, s, t: R.P(w, s, t, helps),
    "P[WHO](R_robot | script[:t])": lambda w, s, t: R.P(
        w, s, t, lambda h: h["R_robot"], assume=None
    ),
    "E[WHO][V(robot) | script[:t]]": lambda w, s, t: R.EV(w, s, t, "robot"),
    "entropy[WHO](rho | script[:t])": lambda w, s, t: R.entropy(w, s, t, "rho"),
    "KL[WHO](script[:0] || script[:t])": lambda w, s, t: R.KL(w, s, 0, t),
    "surprise[WHO](script[t])": lambda w, s, t: R.surprise(w, s, t),
    "suspense[WHO](rho | script[:t-2])": lambda w, s, t: R.suspense(w, s, t - 2, "rho"),
}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_asks_the_viewers_that_it_names(form: str) -> None:
    path = script().trajectory
    shown = pair().document(path)
    found = set()
    for name, worlds in watched().items():
        assume = "nothing" if "R_robot" in form else None
        question = form.replace("WHO", name)
        if "t-2" in form:
            question = question.replace("t-2", "T-2")
        values = np.atleast_1d(script().query(question, assume))
        first = LENGTH + 1 - len(values)
        for t, value in enumerate(values, LENGTH if "t-2" in form else first):
            expected = np.mean([FORMS[form](w, shown, t) for w in worlds])
            assert value == pytest.approx(expected, abs=1e-6), (name, t)
        found.add(round(float(values[-1]), 6))
    assert len(found) >= 3, "the audiences must differ"


def test_beliefs_without_a_name_are_those_of_viewers() -> None:
    for form in FORMS:
        if "t-2" not in form:
            plain = script().query(form.replace("[WHO]", ""))
            np.testing.assert_array_equal(plain, script().query(form.replace("WHO", "viewers")))


def test_a_fold_and_a_replay_agree() -> None:
    objective = (
        "sum_t (P[insider](rho > 0 | script[:t]) - P(rho > 0 | script[:t])"
        " + 0.1 * E[child][V(robot) | script[:t]] - KL[crowd](script[:t-1] || script[:t])"
        " + surprise[child](script[t]) + 3 * suspense[insider](rho | script[:t]))"
    )
    story, world = told(objective)
    frames = script(objective).frames
    compiled = story_objective(story, world)
    tables, params = world.tables, compiled.params
    carry, belief, frame = (
        compiled.init(tables, params, frames.state[0]),
        first_belief(world, tables),
        None,
    )
    for t in range(1, LENGTH + 1):
        number = np.int64(t)
        frame = observe(world, tables, number, frames.before[t], frames.action[t], belief)
        with np.errstate(invalid="ignore"):  # of what is impossible, which counts for nothing
            carry, belief = compiled.step(tables, params, carry, frame), frame.belief
    with np.errstate(invalid="ignore"):
        expected = score_script(story, world, frames)
        assert float(compiled.score(tables, params, carry, frame)) == pytest.approx(expected)
        assert float(compiled.promise(tables, params, carry, frame)) == pytest.approx(expected)


def test_automatic_terms_ask_the_audience_that_needs_no_name() -> None:
    story, world = told("0")
    plain = pair().story(
        f"world kitchen\nlength {LENGTH}\naudience bayesian(forgetting = 0.02)\nmaximize 0"
    )
    alone = seen_by(plain)
    path = script().trajectory
    both = [
        score_script(s, w, replay(w, path.states, path.actions))
        for s, w in ((story, world), (plain, alone))
    ]
    assert both[0] == pytest.approx(both[1], abs=1e-12)


def test_a_story_without_named_audiences_compiles_to_what_it_did() -> None:
    text = "world kitchen\nlength 3\nmaximize sum_t P(rho > 0 | script[:t])\n"
    plain, named = pair().story(text), pair().story(text + "audience viewers = bayesian\n")
    for story in (plain, named):
        assert story.viewers is None
        beliefs = [n for _, e in story.objective for n in ty.walk(e) if isinstance(n, ty.Belief)]
        assert [belief.viewers for belief in beliefs] == [None]
        assert (
            story_objective(story, pair().world).shape == story_objective(plain, pair().world).shape
        )


def test_who_knows_something_does_not_forget_it() -> None:
    random = np.random.default_rng(0)
    known = np.array([True, True, False, True])
    prior = np.log(np.where(known, 1 / 3, 1.0)) + np.where(known, 0, -np.inf)
    rows = np.log(random.uniform(size=(1, 4)))
    belief = update(prior[None], rows, np.where(known, 0.1, 0.0)[None])
    alone = update(prior[None, known], rows[:, known], np.array([0.1]))
    assert np.exp(belief[0, 2]) == 0
    np.testing.assert_allclose(belief[:, known], alone)
    only = update(np.log(np.eye(4)[:1] + 1e-300), rows, 0.1 * np.eye(4)[:1])
    assert np.exp(only)[0] == pytest.approx([1, 0, 0, 0])


def test_beliefs_held_as_probabilities_are_those_held_as_logs() -> None:
    """After 30 observed actions, some of them all but impossible; of those who know something, too;
    and what is asked of them, under a condition."""
    random = np.random.default_rng(1)
    left = np.array([[True] * 5, [True, False, True, True, True]])
    mask, event = np.array([1, 1, 1, 0, 1], bool), np.array([1, 0, 0, 1, 0], bool)
    quantity = random.normal(size=5)
    prior = np.log(left / left.sum(1, keepdims=True), where=left, out=np.full(left.shape, -np.inf))
    for forgetting in (np.array([0.02, 0.3]), np.where(left, [[0.02], [1e-9]], 0.0)):
        logs = prior if forgetting.ndim == 2 else np.full(left.shape, -np.log(5))
        shares = np.exp(logs)
        for _ in range(30):
            row = np.log(random.uniform(size=(2, 5))) * random.choice([1, 20])
            logs = update(logs, row, forgetting)
            shares = updated_share(shares, row, forgetting)
            np.testing.assert_allclose(shares, np.exp(logs), rtol=1e-9, atol=1e-15)
            for form, about in (
                (queries.probability, event),
                (queries.expectation, quantity),
                (queries.marginal, np.eye(2)[[0, 0, 1, 1, 1]]),
            ):
                exactly = form(logs, about, mask)
                np.testing.assert_allclose(form(logs, about, mask, shares), exactly, rtol=1e-9)
            found = queries.entropy(logs, None, mask, shares)
            assert found == pytest.approx(queries.entropy(logs, None, mask), abs=1e-12)


def test_what_is_known_by_problems_is_what_is_known_by_hypotheses() -> None:
    """The search's way to update beliefs where it has no table of policies."""
    _, world = told("sum_t P(rho > 0 | script[:t])")
    tables = world.tables._replace(by_problem=by_problem(world.tables, 10**6))
    prior = world.log_prior(tables)
    turns = world.turns(tables, np.arange(0, world.dynamics.state_count, 5))
    lifted = prior[:, *(None,) * 3].swapaxes(0, 3)  # [1, 1, 1, O, H]
    belief = Belief(lifted, np.exp(lifted))
    for who, (row, known) in enumerate(zip(turns.log_rows, turns.problems, strict=True)):
        assert known is not None
        each = np.einsum("...oq,oqh->...oh", known.log_rows, known.hypotheses)
        np.testing.assert_allclose(each, row)
        with np.errstate(divide="ignore"):  # the insider knows some hypotheses to be false
            one, other = (belief.seeing(world, tables, who, row, by) for by in (None, known))
        np.testing.assert_allclose(other.share, one.share, rtol=1e-12)
        lacks = row.max(who + 1, keepdims=True) - row
        less = known._replace(log_rows=known.log_rows.max(who + 1, keepdims=True) - known.log_rows)
        odd = one.regret(world, tables, who, lacks)
        np.testing.assert_allclose(one.regret(world, tables, who, lacks, less), odd, rtol=1e-9)
        assert np.ptp(odd) > 0.1
        belief = one


def seen(text: str, viewers: int, monkeypatch: pytest.MonkeyPatch) -> GridWorld:
    """A world as a search without a table of policies sees it, nothing being planned."""
    monkeypatch.setattr(looked_up, "MOST_POLICY_BYTES", 0)
    spec = parse_world(Source("seen.world", text), "seen")
    world = unplanned_world(spec)
    watching = tuple(Viewer(spec, sharpness=1.0 + o) for o in range(viewers))
    tables = world.tables
    values = tuple(np.zeros((len(tables.cells), len(beta))) for beta in tables.sharpness)
    plan = Plan(problem_keys(spec), values, 0.0, 0.0)
    return assemble(spec, world.dynamics, watching, [plan] * viewers)


MAP = "map\n    ...\n    ...\n" + "".join(
    f"tile {name}\n    cell = ({column}, 0)\n" for column, name in enumerate("abc")
)
CHEESE = "character cheese\n    success = 0.6\n    goals = {a, b, c}\n"
ROBOT = "character robot\n    goals = {a, b}\n    pushes = cheese\n    toward = {cheese: {-1, 1}}\n"
DOG = ROBOT.replace("robot", "dog")


def test_problems_are_told_apart_where_that_saves_something(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Not where each hypothesis is another problem of the last to act; and each observer has its
    own problems only, however many others there are."""
    assert seen(MAP + CHEESE + ROBOT, 1, monkeypatch).search_tables.by_problem == ()
    sizes = []
    for viewers in (1, 3):
        world = seen(MAP + CHEESE + ROBOT + DOG, viewers, monkeypatch)
        tables = world.search_tables
        assert tables.policies is None
        count = len(world.vocabulary.hypotheses)
        each = [np.asarray(known.hypotheses) for known in tables.by_problem]
        assert len(each) == 3
        sizes.append([known.shape[1] for known in each])
        for known in each:
            assert known.shape == (viewers, known.shape[1], count)
            assert (known.sum(1) == 1).all()  # one problem under each hypothesis
            assert known.shape[1] <= count / 2
    assert sizes[0] == sizes[1]


def test_the_panel_changes_all_audiences_alike_and_leaves_what_they_know() -> None:
    story, world = told("sum_t P(rho > 0 | script[:t])")
    path = script().trajectory
    frames = replay(world, path.states, path.actions)
    asked = [
        check_query(Source("query", q), world.vocabulary, Module(Source("query", "")), LENGTH,
                    audiences=story.audiences).value
        for q in ("P[insider](G_cheese = pink | script[:T])", "P[insider](rho > 0 | script[:T])")
    ]  # fmt: skip
    known, helped = zip(
        *([float(evaluate(m.world, m.watch([path], [frames])[0], q, None)) for q in asked]
          for m in panel(story, world)), strict=True
    )  # fmt: skip
    assert known == pytest.approx([1.0] * len(known))
    assert np.ptp(helped) > 0.01


def test_captions_curves_and_reasons_say_whose_belief_they_are() -> None:
    pictures = pictures_of([script()], "told")
    caption = pictures.captions([0])[0]
    assert caption.startswith("the insider ")
    assert "viewers " in caption
    labels = [series.label for series in pictures.panels[0].series]
    assert labels == ["insider: helping", "viewers: helping"]
    curves = {s.label: s.values for s in pictures.panels[0].series}
    for name, values in curves.items():
        audience = name.partition(":")[0]
        np.testing.assert_allclose(values, script().query(f"P[{audience}](rho > 0 | script[:t])"))
    assert [q.audience for q in questions_of(script())] == ["insider", "viewers"]
    data = document(script())
    for question in data["questions"]:
        told_by = script().query(f"P[{question['audience']}](rho > 0 | script[:t])")
        np.testing.assert_allclose(question["course"], told_by)
    for reason in data["reasons"]:
        for effect in reason["effects"]:
            assert 0 <= effect["after"] <= 1
    assert "insider: robot means to help cheese" in reasons_in_words(script())


def test_viewers_may_rule_out_that_somebody_is_rational() -> None:
    """Then nothing that is done is odd to them, and who is not rational has no value to show."""
    own = pair()
    text = "assume nothing\naudience bayesian(given = not R_robot)\n"
    story = own.story(
        f"world kitchen\nlength {LENGTH}\n{text}maximize sum_t P(G_cheese = pink | script[:t])"
    )
    world = seen_by(story)
    path = own.random_script(Random(3), LENGTH, events=0)
    frames = replay(world, path.states, path.actions)
    assert (frames.regret == 0).all()
    assert np.isfinite(score_script(story, world, frames))
    panels = pictures_of([script_of(story, world, path, frames, {}, None)], "doubt").panels
    (values,) = [panel for panel in panels if panel.title == "expected value"]
    assert [series.label for series in values.series] == ["cheese"]
