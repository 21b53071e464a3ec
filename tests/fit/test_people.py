"""Audiences in files, and the sharpness that viewers may have."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import i2pdsl
from commands_for_tests import Run
from i2pdsl.errors import StoryError
from i2pdsl.language.people import MOST_VIEWERS, Person, read_people, written
from i2pdsl.objective.replay import replay
from worlds_for_tests import with_small_world

CROWD = (
    Person(1.5, 0.01, {"rho": {"-3": 0.1, "3": 0.5}, "G_cheese": {"pink": 0.9}}),
    Person(0.5, 0.0, {'a "quoted" name': {"b": 1.0}}, {"beta": 3.0}),
)
STORY = "world small\nlength 4\nmaximize depict(rho > 0)\nsearch beam(starts = 20, polish = 0)\n"


def story(folder: Path, audience: str) -> i2pdsl.Story:
    (with_small_world(folder) / "told.story").write_text(STORY + audience)
    return i2pdsl.load(folder / "told.story")


def test_a_file_says_what_was_written(tmp_path: Path) -> None:
    path = tmp_path / "people.toml"
    path.write_text(written(CROWD, {"r": 0.97}, "made\nby hand"))
    assert read_people(path) == CROWD


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "has no `format`"),
        ("format = 'x'\nversion = 1\nviewer = []", "format is not 'i2p-audience'"),
        ("format = 'i2p-audience'\nversion = 2\nviewer = []", "version is not 1"),
        ("format = 'i2p-audience'\nversion = 1\nviewer = []", "0 viewers, not 1 to 64"),
        ("format = ", "it is not TOML"),
        ("format = 'i2p-audience'\nversion = 1\nviewer = [3]", "viewer 1 is no table"),
    ],
)
def test_a_file_that_is_none(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "p.toml").write_text(text)
    with pytest.raises(StoryError) as caught:
        read_people(tmp_path / "p.toml")
    assert said in str(caught.value)
    assert str(caught.value).startswith(f"{tmp_path / 'p.toml'}:1:1: error[audience]")


@pytest.mark.parametrize(
    "viewer",
    [
        "sharpness = 0\nforgetting = 0",
        "sharpness = nan\nforgetting = 0",
        "sharpness = true\nforgetting = 0",
        "sharpness = 1\nforgetting = 2",
        "sharpness = 1",
        "sharpness = 1\nforgetting = 0\nprior.rho = { 1 = -1 }",
        "sharpness = 1\nforgetting = 0\nprior.rho = 3",
        "sharpness = 1\nforgetting = 0\nsettings = { beta = 'x y' }",
        "sharpness = 1\nforgetting = 0\nother = 1",
    ],
)
def test_viewers_that_are_none(tmp_path: Path, viewer: str) -> None:
    text = f"format = 'i2p-audience'\nversion = 1\n[[viewer]]\n{viewer}\n"
    (tmp_path / "p.toml").write_text(text)
    with pytest.raises(StoryError, match=r"p\.toml:3:1: error\[audience\]: viewer 1"):
        read_people(tmp_path / "p.toml")


def test_too_many_viewers(tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text(written(CROWD[:1] * (MOST_VIEWERS + 1), {}, ""))
    with pytest.raises(StoryError, match="65 viewers"):
        read_people(tmp_path / "p.toml")


def test_a_story_names_a_file(tmp_path: Path) -> None:
    """The viewers of a file are those that the same numbers make by hand."""
    (tmp_path / "people.toml").write_text(written(CROWD, {}, ""))
    prior = (
        "(if rho = -3 then 0.1 else if rho = 3 then 0.5 else 1)"
        " * (if G_cheese = pink then 0.9 else 1)"
    )
    by_hand = (
        f"average(bayesian(sharpness = 1.5, forgetting = 0.01, prior = {prior}), "
        "bayesian(sharpness = 0.5, forgetting = 0, beta = 3))"
    )
    told = story(tmp_path, 'audience "people.toml"\n')
    (warning,) = told.warnings
    assert warning.severity == "warning"
    assert """world small has no `a "quoted" name`: what viewers think""" in warning.message
    first = told.typed.audiences[0].observers
    other = story(tmp_path, f"audience {by_hand}\n").typed.audiences[0].observers
    for one, two in zip(first, other, strict=True):
        assert (one.settings, one.sharpness) == (two.settings, two.sharpness)
        assert one.prior is not None
        uniform = (1 / len(one.prior),) * len(one.prior)
        assert one.prior == pytest.approx(two.prior or uniform)
    named = story(
        tmp_path, 'audience friends = "people.toml"\nmaximize P[friends](rho = 1 | script[:T])\n'
    )
    assert len(named.typed.audiences[1].observers) == 2


@pytest.mark.parametrize(
    ("audience", "said"),
    [
        ('audience "nothing.toml"', "no audience file `nothing.toml`"),
        ('audience "people.toml"(beta = 1)', "an audience in a file has no settings"),
        ("audience bayesian(sharpness = 0)", "`sharpness` must be above 0"),
        ("audience bayesian(sharpness = rho)", "expected a number"),
    ],
)
def test_mistakes_are_told_where_they_are(
    tmp_path: Path, i2p: Run, audience: str, said: str
) -> None:
    (tmp_path / "people.toml").write_text(written(CROWD, {}, ""))
    (with_small_world(tmp_path) / "told.story").write_text(STORY + audience + "\n")
    done = i2p("check", tmp_path / "told.story")
    assert done.status == 1
    assert f"{tmp_path / 'told.story'}:5:" in done.err
    assert said in done.err


def test_sharpness_is_the_power_of_what_is_expected(tmp_path: Path) -> None:
    """P(a | H) to the power of it, normalised; also beside others who expect the same plan."""
    crowd = "audience average(bayesian, bayesian(sharpness = 2), bayesian(sharpness = 0.5))\n"
    script = story(tmp_path, crowd).solve(seed=0).script
    world, path = script.world, script.trajectory
    states, actions = path.states[:-1], path.actions
    for log_policy, _ in world.alternatives(world.tables, states, actions, path.states[1:]):
        usual = np.exp(log_policy[:, :, 0])
        for observer, power in ((1, 2.0), (2, 0.5)):
            expected = usual**power / (usual**power).sum(1, keepdims=True)
            np.testing.assert_allclose(np.exp(log_policy[:, :, observer]), expected, rtol=1e-9)
    assert np.ptp(replay(world, path.states, actions).log_belief[-1], axis=0).max() > 0.01
