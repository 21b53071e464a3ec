"""Priors that are told latent by latent, against what they must be: shares as told, and otherwise
as close as can be to what is believed without."""

from __future__ import annotations

import math

import numpy as np
import pytest

from i2pdsl.errors import Source
from i2pdsl.language.check import Library, check_source
from i2pdsl.language.priors import fitted
from i2pdsl.language.story import TypedStory
from i2pdsl.worlds.find import find_vocabulary
from i2pdsl.worlds.plane.parse import parse_plane
from worlds_for_tests import SMALL_MAP, kitchen_text, planned

KITCHEN = find_vocabulary("kitchen", None)
ROWS = KITCHEN.hypotheses
RATIONAL = np.array([row["R_cheese"] and row["R_robot"] for row in ROWS])


def of(latent: str, value: object) -> np.ndarray:
    return np.array([row.get(latent) == value for row in ROWS])


def told(settings: str, world: str = "kitchen") -> np.ndarray:
    """The prior of viewers."""
    text = f"world {world}\nlength 3\naudience bayesian({settings})\nmaximize 0\n"
    story = check_source(Source("test.story", text), find_vocabulary)
    assert isinstance(story, TypedStory)
    return np.array(story.observers[0].prior)


def test_shares_are_those_of_the_values_and_nothing_else_changes() -> None:
    shares = {-3: 0.05, -1: 0.05, 0: 0.6, 1: 0.15, 3: 0.15}
    settings = (
        "prior(rho) = {0: 12, 1: 3, 3: 3, others: 2}, prior(G_robot) = {none: 0.2, others: 0.8}"
    )
    prior = told(settings)
    assert prior.sum() == pytest.approx(1)
    rational = prior[RATIONAL].sum()
    assert rational == pytest.approx(28 / 34)  # as before
    for value, share in shares.items():
        assert prior[RATIONAL & of("rho", value)].sum() == pytest.approx(share * rational, abs=1e-7)
    for goal, share in (("none", 0.2), ("pink", 0.4), ("green", 0.4)):
        assert prior[RATIONAL & of("G_robot", goal)].sum() == pytest.approx(
            share * rational, abs=1e-7
        )
    # The closest to equal weights: the logarithm is a sum of a number for each told value.
    values = [(x, v) for x in ("rho", "G_robot") for v in KITCHEN.latents[x].values]
    design = np.array([of(x, v)[RATIONAL] for x, v in values], float).T
    logs = np.log(prior[RATIONAL])
    found = design @ np.linalg.lstsq(design, logs, rcond=None)[0]
    np.testing.assert_allclose(found, logs, atol=1e-6)
    # Beside an irrational cheese the robot is indifferent, and wants something as often as told.
    alone = ~of("R_cheese", True) & of("R_robot", True)
    assert prior[alone].sum() == pytest.approx(3 / 34)
    assert prior[alone & of("G_robot", "none")].sum() == pytest.approx(0.2 * 3 / 34, abs=1e-7)


def test_who_is_rational_may_be_told_too() -> None:
    prior = told("prior(R_cheese) = {true: 9, false: 1}, prior(G_cheese) = {pink: 0, green: 1}")
    assert prior[of("R_cheese", True)].sum() == pytest.approx(0.9)
    assert prior[of("G_cheese", "pink")].sum() == 0
    assert len(set(prior[RATIONAL & of("G_cheese", "green")].round(12))) == 1


def test_a_prior_of_hypotheses_is_what_shares_are_closest_to() -> None:
    base = told("prior = if rho > 0 then 4 else 1")
    prior = told("prior = if rho > 0 then 4 else 1, prior(G_cheese) = {pink: 3, green: 1}")
    pink = RATIONAL & of("G_cheese", "pink")
    assert prior[pink].sum() == pytest.approx(0.75 * prior[RATIONAL].sum())
    np.testing.assert_allclose(prior[pink] / prior[pink].sum(), base[pink] / base[pink].sum())


def test_what_no_prior_has_is_none() -> None:
    both = {"rho": {0.0: 1.0}, "G_robot": {"none": 1.0}}
    assert fitted(ROWS, (1.0,) * len(ROWS), both) is None
    half = {"rho": {0.0: 0.6, 1.0: 0.4}, "G_robot": {"none": 0.6, "pink": 0.4}}
    assert fitted(ROWS, (1.0,) * len(ROWS), half) is None  # .6 and .6 exclude each other
    less = {"rho": {0.0: 0.3, 1.0: 0.7}, "G_robot": {"none": 0.6, "pink": 0.4}}
    assert fitted(ROWS, (1.0,) * len(ROWS), less) is not None


def test_a_world_says_what_its_viewers_think_at_first() -> None:
    """Stories change single latents of it, or with a prior of hypotheses all."""
    told = "prior(rho) = {-3: 0.5, others: 0.5}\n    prior(G_cheese) = {pink: 3, green: 1}"
    text = kitchen_text(SMALL_MAP, gamma="0.8").replace("audience\n", f"audience\n    {told}\n")
    world = planned(text, "thinking")
    words = world.vocabulary
    usual = np.exp(world.log_prior(world.tables)[0])
    assert usual[RATIONAL & of("rho", -3)].sum() == pytest.approx(0.5 * 28 / 34, abs=1e-7)
    assert usual[RATIONAL & of("G_cheese", "pink")].sum() == pytest.approx(0.75 * 28 / 34, abs=1e-7)

    def prior(line: str) -> np.ndarray:
        lines = f"world thinking\nlength 2\n{line}\nmaximize 0\n"
        story = check_source(Source("test.story", lines), lambda *_: words)
        assert not isinstance(story, Library)
        return np.array(story.observers[0].prior)

    for line in ("", "audience bayesian(beta = 1)"):
        np.testing.assert_allclose(prior(line), usual)
    changed = prior("audience bayesian(prior(rho) = {-3: 1, others: 4})")
    assert changed[RATIONAL & of("rho", -3)].sum() == pytest.approx(0.2 * 28 / 34, abs=1e-7)
    assert changed[RATIONAL & of("G_cheese", "pink")].sum() == pytest.approx(
        0.75 * 28 / 34, abs=1e-7
    )
    np.testing.assert_allclose(prior("audience bayesian(prior = 1)"), 1 / 34)


def test_planes_and_the_hill_have_such_priors_too() -> None:
    np.testing.assert_allclose(told("prior(weight) = {0.1: 1, 0.5: 4}", "hill"), [0.2, 0.8])
    text = """kind = plane
size
    width = 4
    height = 4
place a
    at = (1, 1)
place b
    at = (3, 3)
character one
    at = (2, 2)
    goals = {a, b}
audience
    prior(G_one) = {a: 1, b: 3}
"""
    spec = parse_plane(Source("t.world", text), "t")
    assert math.isclose(dict(spec.shares[0][1])["b"], 3)
