"""Simulated viewers believe what the audience's own model says, and answer by their rules."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import i2pdsl
from i2pdsl.errors import Source
from i2pdsl.fit.judgements import Choice, read_judgements
from i2pdsl.language.people import Person, written
from i2pdsl.study.answers import panel_answers
from i2pdsl.study.check import check_study
from i2pdsl.study.films import Films
from i2pdsl.study.panel import (
    Viewer,
    chances,
    first_chosen,
    positions,
    prior_of,
    viewers_of,
)
from i2pdsl.study.parse import load_study, parse_study
from i2pdsl.study.spec import Between, OneOf, Panel, Study
from i2pdsl.sweep.work import run_job
from i2pdsl.tables import as_csv
from i2pdsl.worlds.kind import Watch

SURE = Viewer(1.0, None, {}, False, (), False, 0.0, 0.0, 1.0)


@pytest.fixture
def films(place: Path) -> Films:
    """The films of the study, made."""
    study = load_study(place / "tiny.study")
    found = Films(study, check_study(study), place / "out")
    found.make(lambda jobs: ((job, run_job(job)) for job in jobs), lambda *_: None)
    return found


PEOPLE = (
    Person(0.7, 0.02, {"rho": {"1": 3.0, "-1": 0.4}, "R_robot": {"true": 5.0}}),
    Person(2.5, 0.2, {"G_cheese": {"pink": 4.0}}, {"beta": 1.0}),
)


def test_known_viewers_answer_what_they_believe(films: Films, place: Path) -> None:
    """Computed another way: each is asked by `i2pdsl.query`, and takes what is most believed."""
    (place / "people.toml").write_text(written(PEOPLE, {}, "two"), encoding="utf-8")
    drawn = {"confidence": OneOf((0.5,)), "rule": OneOf(("maximum",))}
    panel = Panel("two", "two", 2, 0, place / "people.toml", drawn, {})
    answers = panel_answers(panel, films, Watch())
    assert len(answers.items) == 16
    for number, person in enumerate(PEOPLE):
        alone = place / f"{number}.toml"
        alone.write_text(written((person,), {}, "one"), encoding="utf-8")
        for column, item in enumerate(answers.items):
            path = films.path(item.films[0])
            events = {"helping": "rho > 0", "hindering": "rho < 0"}
            asked = {name: f"P({event} | script[:T])" for name, event in events.items()}
            table = i2pdsl.query(path, asked, [f'"{alone}"'], assume="nothing")
            believed = dict(zip(table.question, table.value, strict=True))
            best = max(believed, key=believed.__getitem__)
            expected = best if believed[best] >= 0.5 else "unclear"
            assert answers.names[int(answers.given[number, column])] == expected
    assert len({*answers.given.ravel()}) > 1


def test_beliefs_throughout_are_means_over_frames(films: Films, place: Path) -> None:
    text = (place / "tiny.study").read_text(encoding="utf-8")
    text = text.replace("question\n", 'question\n    kind = slider\n    event = "rho > 0"\n')
    text = text.replace('event = "rho > 0"\n', 'event = "rho > 0"\n    when = throughout\n', 1)
    text = text.replace("right = helping", "right = high")
    text = text.replace("right = hindering", "right = low")
    text = text[: text.index("answer helping")] + text[text.index("people help") :]
    study = parse_study(Source("tiny.study", text), place / "tiny.study")
    drawn = {"noise": OneOf((0.0,))}
    study = replace(study, panels=(Panel("own", "own", 1, 0, None, drawn, {}),))
    made = Films(study, check_study(study), place / "out")
    answers = panel_answers(study.panels[0], made, Watch())
    assert answers.names == ()
    for column, item in enumerate(answers.items):
        asked = "mean_t P(rho > 0 | script[:t])"
        (believed,) = i2pdsl.query(made.path(item.films[0]), asked, assume="nothing").value
        assert answers.given[0, column] == round(100 * believed)
        assert answers.matches[0, column] == (
            believed > 0.505 if item.group == "help" else believed < 0.495
        )
    rows = answers.columns(lambda film: film.place)
    assert rows["question"][0] == asked


def test_answers_are_a_table_that_fit_reads(films: Films, place: Path) -> None:
    panel = films.study.panels[0]
    answers = panel_answers(panel, films, Watch())
    path = place / "out" / "answers.csv"
    columns = answers.columns(lambda film: films.name(film, place / "out"))
    path.write_text(as_csv(columns), encoding="utf-8")
    choice = Choice(dict.fromkeys(answers.names, "1"))
    read = read_judgements(path, named={"tiny": choice})
    assert len(read) == answers.given.size == 6 * 16
    assert (path.parent / read[0].script).is_file()
    assert read[0].answer == answers.names[int(answers.given[0, 0])]


# Rules.


@pytest.fixture(scope="module")
def study() -> Study:
    return load_study(Path(__file__).parents[2] / "studies" / "kitchen.study")


def test_maximum_takes_what_is_most_believed(study: Study) -> None:
    believed = np.array([[0.5, 0.3, 0.1], [0.2, 0.2, 0.1], [0.4, 0.4, 0.1]])
    viewer = replace(SURE, confidence=0.3)
    expected = [[1, 0, 0, 0], [0, 0, 0, 1], [0.5, 0.5, 0, 0]]
    np.testing.assert_allclose(chances(study, viewer, believed), expected)
    lapsing = chances(study, replace(viewer, lapse=0.2), believed)
    np.testing.assert_allclose(lapsing, 0.8 * np.array(expected) + 0.05)


def test_matching_answers_as_often_as_it_is_believed(study: Study) -> None:
    believed = np.array([[0.5, 0.3, 0.1], [0.7, 0.7, 0.6]])
    found = chances(study, replace(SURE, matching=True), believed)
    np.testing.assert_allclose(found, [[0.5, 0.3, 0.1, 0.1], [0.35, 0.35, 0.3, 0]])


def test_the_film_in_which_more_is_believed_is_chosen() -> None:
    first, second = np.array([0.8, 0.5, 0.0]), np.array([0.5, 0.5, 0.0])
    np.testing.assert_allclose(first_chosen(SURE, first, second), [0.8, 0.5, 0.5])
    sharp = first_chosen(replace(SURE, noise=0.0, lapse=0.1), first, second)
    np.testing.assert_allclose(sharp, [0.95, 0.5, 0.5])
    loud = first_chosen(replace(SURE, noise=2.0), first, second)
    np.testing.assert_allclose(loud[0], 1 / (1 + 4**-0.5))


def test_sliders_stand_where_it_is_believed() -> None:
    believed, middle = np.array([0.8, 0.8]), np.array([[0.5, 0.5], [0.05, 0.3]])
    np.testing.assert_allclose(positions(SURE, believed, middle)[0], 80)
    lapsed = positions(replace(SURE, lapse=0.1), believed, middle)
    np.testing.assert_allclose(lapsed, [80, 30])
    shares = np.random.default_rng(0).random((4000, 2))
    odds = positions(replace(SURE, noise=0.5), np.full(4000, 0.8), shares)
    assert np.median(odds) == pytest.approx(80, abs=1)
    assert np.quantile(odds, 0.75) == pytest.approx(100 / (1 + 1 / (4 * 3**0.5)), abs=1.5)


# Who they are.


def test_viewers_are_drawn_from_what_is_stated(study: Study) -> None:
    words = [ground.vocabulary for ground in list(check_study(study).values())[:1]]
    drawn = {
        "sharpness": Between(0.25, 4.0, True),
        "lapse": Between(0.0, 0.1, False),
        "rule": OneOf(("maximum", "matching")),
        "doubt": OneOf((0.5,)),
    }
    panel = Panel("x", "x", 800, 3, None, drawn, {"level0": OneOf(("uniform", "costs"))})
    viewers = viewers_of(panel, words)
    sharpness = np.log([v.sharpness for v in viewers])
    assert np.log(0.25) < sharpness.min() < sharpness.max() < np.log(4)
    error = np.log(16) / 12**0.5 / 800**0.5
    assert abs(sharpness.mean()) < 4 * error
    assert abs(np.mean([v.lapse for v in viewers]) - 0.05) < 4 * 0.1 / 12**0.5 / 800**0.5
    for either in ([v.matching for v in viewers], [v.settings[0][1] == "costs" for v in viewers]):
        assert abs(np.mean(either) - 0.5) < 4 * 0.5 / 800**0.5
    weights = np.log([v.weights["rho"]["3"] for v in viewers])
    assert abs(weights.std() - 0.5) < 4 * 0.5 / 1600**0.5
    more = viewers_of(replace(panel, viewers=801, drawn={**drawn, "noise": OneOf((2.0,))}), words)
    assert [replace(v, noise=1.0) for v in more[:800]] == list(viewers)


def test_an_even_prior_makes_answers_alike(study: Study) -> None:
    ground = next(iter(check_study(study).values()))
    even = prior_of(replace(SURE, even=True), ground)
    masks = np.array(ground.masks)
    np.testing.assert_allclose(masks @ even, masks.sum() / masks.shape[1] / 3)
    alone = replace(ground, masks=ground.masks[:1])
    np.testing.assert_allclose(masks[0] @ prior_of(replace(SURE, even=True), alone), 0.5)
    np.testing.assert_allclose(prior_of(SURE, ground), 1 / masks.shape[1])


def test_the_prior_of_a_world_counts(study: Study) -> None:
    ground = next(iter(check_study(study).values()))
    masks = np.array(ground.masks)
    rows = ground.vocabulary.hypotheses
    goals = list(ground.vocabulary.latents["G_cheese"].values)
    weights = tuple((goal, 1.0 + 4.0 * (goal == goals[0])) for goal in goals)
    told = replace(ground, spec=replace(ground.spec, shares=(("G_cheese", weights),)))
    said = prior_of(SURE, told)
    wants = np.array([row.get("G_cheese") == goals[0] for row in rows])
    known = np.array(["G_cheese" in row for row in rows])
    assert said[wants].sum() / said[known].sum() == pytest.approx(5 / (4 + len(goals)))
    even = prior_of(replace(SURE, even=True), told)
    np.testing.assert_allclose(masks @ even, masks.sum(0) @ said / 3)
    among = masks[0]  # the answers change, not what is likelier among those who give one
    np.testing.assert_allclose(even[among] / even[among].sum(), said[among] / said[among].sum())
