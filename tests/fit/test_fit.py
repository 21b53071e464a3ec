"""`i2p fit` from a table to an audience that stories can name, and back to the truth."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import i2pdsl
from commands_for_tests import Outcome, Run, process
from i2pdsl.computing import computing
from i2pdsl.language.people import read_people
from worlds_for_tests import with_small_world

QUESTION = "P(rho > 0 | script[:t])"
TRUTH = {"sharpness": 1.5, "noise": 0.8, "bias": -0.4, "slope": 0.8, "lapse": 0.03}
PEOPLE = 12


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six scripts of the small kitchen."""
    folder = with_small_world(tmp_path_factory.mktemp("fit"))
    story = "world small\nlength 5\nmaximize depict(rho {} 0)\n"
    for number, sign in enumerate("<>=<>="):
        (folder / "told.story").write_text(story.format(sign))
        script = i2pdsl.load(folder / "told.story").solve(seed=number, naive=True).script
        script.save(folder / f"{number}.json")
    return folder


def simulated(folder: Path, truth: dict[str, float], seed: int) -> Path:
    """A table of what PEOPLE who are all alike would answer."""
    generator = np.random.default_rng(seed)
    rows = []
    for number in range(6):
        script = i2pdsl.Script.load(folder / f"{number}.json")
        sharper = f"bayesian(sharpness = {truth['sharpness']}, forgetting = 0.001)"
        text = f"world small\nlength 5\naudience {sharper}\nmaximize depict(rho > 0)\n"
        (folder / "seen.story").write_text(text)
        document = json.loads((folder / f"{number}.json").read_text())
        document["story"]["source"] = text
        (folder / "seen.json").write_text(json.dumps(document))
        beliefs = i2pdsl.Script.load(folder / "seen.json").query(QUESTION)
        assert not np.allclose(beliefs, script.query(QUESTION))
        for frame in (1, 2, 3, 5):
            odds = np.log(beliefs[frame] / (1 - beliefs[frame]))
            for person in range(PEOPLE):
                noise = generator.logistic() * truth["noise"] * np.sqrt(3) / np.pi
                answer = 1 / (1 + np.exp(-(truth["bias"] + truth["slope"] * odds + noise)))
                if generator.random() < truth["lapse"]:
                    answer = generator.random()
                rows.append((f"person {person}", f"{number}.json", frame, round(100 * answer)))
    path = folder / f"table-{seed}.csv"
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("participant", "script", "frame", "answer"))
        writer.writerows(rows)
    return path


@pytest.fixture(scope="module")
def fitted(folder: Path) -> tuple[Outcome, Path]:
    table = simulated(folder, TRUTH, 0)
    out = folder / "people.toml"
    given = ("--question", QUESTION, "--scale", "100", "--chains", "2", "--draws", "60")
    baseline = ("--cue", "mean_t [idle(robot) @ script[t]]", "--cue", "t")
    baseline = (*baseline, "--against", "hypotheses=literal")
    given = (*given, *baseline, "--warmup", "100", "--vary", "nothing", "--json")
    return process("fit", table, "-o", out, *given), out


def test_the_truth_comes_back(fitted: tuple[Outcome, Path]) -> None:
    """Within four standard deviations of the posterior, which a wrong model misses by far."""
    done, _ = fitted
    told = json.loads(done.out)
    assert done.status == (0 if told["converged"] else 1)
    assert told["converged"] == ("not converged" not in done.err)
    for name, value in TRUTH.items():
        each = told["estimates"][name]
        spread = (each["high"] - each["low"]) / 3.3
        assert abs(each["mean"] - value) < 4 * spread + 0.02, (name, each)
    prior = sum(told["estimates"][f"P(rho = {v})"]["mean"] for v in (-3, -1, 0, 1, 3))
    assert prior == pytest.approx(1)
    assert told["r"] > 0.97
    assert told["rmse"] < 8
    assert told["loo"]["loo"] < -100
    assert 0.8 < told["predictive"]["within_90"] < 0.99
    assert (told["people"], told["answers"], len(told["cells"])) == (PEOPLE, 288, 24)


def test_its_files_are_what_they_say(fitted: tuple[Outcome, Path], folder: Path) -> None:
    arviz = pytest.importorskip("arviz")
    done, out = fitted
    told = json.loads(done.out)
    (person,) = read_people(out)
    assert person.sharpness == pytest.approx(told["estimates"]["sharpness"]["mean"], rel=0.1)
    data = arviz.from_netcdf(out.with_suffix(".nc"))
    assert data.posterior["sharpness"].shape == (2, 60)
    assert data.log_likelihood["answer"].shape[-1] == 288
    assert out.with_suffix(".png").read_bytes()[:4] == b"\x89PNG"
    text = 'world small\nlength 3\naudience "people.toml"\nmaximize depict(rho > 0)\n'
    (folder / "to-people.story").write_text(text)
    (observer,) = i2pdsl.load(folder / "to-people.story").typed.observers
    assert observer.sharpness == person.sharpness


def test_an_inverse_planner_beats_what_can_be_counted(fitted: tuple[Outcome, Path]) -> None:
    told = json.loads(fitted[0].out)["comparison"]
    assert {one["name"] for one in told} == {"this audience", "hypotheses=literal", "cues"}
    first, second = told[0], told[-1]
    assert second["name"] == "cues"
    assert first["difference"] == 0
    assert second["difference"] == pytest.approx(first["loo"] - second["loo"])
    assert second["difference"] > 2 * second["se"] > 0
    assert first["rmse"] < second["rmse"]


@pytest.mark.parametrize(
    ("row", "place", "said"),
    [
        ("a,no.json,1,P(rho > 0 | script[:t]),1", "2:3", "this script cannot be read"),
        ("a,0.json,9,P(rho > 0 | script[:t]),1", "2:10", "the script has 5 frames"),
        ("a,0.json,1,P(rho > 0 | script[:t],1", "2:12", "`(` is never closed"),
        ("a,0.json,1,P(rh > 0 | script[:t]),1", "2:12", "unknown name `rh`"),
        ("a,0.json,1,P(rho | script[:t]),1", "2:12", "this is a distribution"),
        ("a,0.json,0,surprise(script[t]),1", "2:12", "cannot be asked after frame 0"),
        ("a,0.json,2,P(rho > 0 | script[:T]),1", "2:12", "frames that nobody has seen"),
        ("a,0.json,2,mean_t P(rho > 0 | script[:t]),1", "2:12", "ask about `script[:t]`"),
        ("a,0.json,2,P(rho > 0 | script[:t]) - P(rho > 0 | script[:3]),0", "2:12", "after frame 2"),
    ],
)
def test_questions_that_cannot_be_asked(folder: Path, row: str, place: str, said: str) -> None:
    from i2pdsl.errors import StoryError
    from i2pdsl.fit.fit import study
    from i2pdsl.fit.judgements import read_judgements

    (folder / "wrong.csv").write_text(f"participant,script,frame,question,answer\n{row}\n")
    with pytest.raises(StoryError) as caught:
        study(read_judgements(folder / "wrong.csv"), folder)
    assert f"wrong.csv:{place}: error[judgement]" in str(caught.value)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("options", "status", "said"),
    [
        (("--fix", "sharpnes=1"), 1, "did you mean `sharpness`?"),
        (("--fix", "sharpness=-1"), 1, "`sharpness` cannot be -1"),
        (("--fix", "lapse=1.5"), 1, "`lapse` cannot be 1.5"),
        (("-o", "people.json"), 2, "does not end in .toml"),
        (("--grid", "gamma=2"), 1, "`gamma` cannot be 2"),
        (("--grid", "horizon=3,5"), 1, "its values have no common grid"),
        (("--against", "level0=none"), 1, "`level0` cannot be none: it is uniform, costs"),
        (("--against", "beta=1,2"), 2, "is not NAME=VALUE"),
        (("--fix", "noise=much"), 1, "`noise` cannot be much"),
        (("--fix", "bias"), 2, "is not NAME=VALUE"),
        (("--vary", "moods"), 2, "'moods' is none of"),
        (("--choice", "why"), 2, "is not NAME:LABEL=EXPR"),
    ],
)
def test_options_that_mean_nothing(
    i2p: Run, folder: Path, options: tuple[str, ...], status: int, said: str
) -> None:
    text = f"participant,script,frame,question,answer\na,0.json,1,{QUESTION},1\n"
    (folder / "wrong.csv").write_text(text)
    done = i2p("fit", folder / "wrong.csv", *options)
    assert (done.status, done.out) == (status, "")
    assert said in done.err


@pytest.mark.slow
def test_intervals_hold_the_truth_at_their_rate(folder: Path) -> None:
    """Of 20 simulated tables with parameters drawn from what is thought of them beforehand, 90 %
    intervals hold them 90 times in 100: between 76 and 99 of 100 figures."""
    from i2pdsl.fit.fit import fit, study
    from i2pdsl.fit.judgements import read_judgements
    from i2pdsl.fit.report import Report

    held = []
    for seed in range(1, 21):
        generator = np.random.default_rng(seed)
        truth = {
            "sharpness": float(np.exp(generator.normal(0, 1))),
            "noise": float(np.exp(generator.normal(0, 0.7))),
            "bias": float(generator.normal(0, 0.5)),
            "slope": float(np.exp(generator.normal(0, 0.5))),
            "lapse": float(1 / (1 + np.exp(-generator.normal(-3, 1)))),
        }
        table = simulated(folder, truth, seed)
        with computing():
            people = study(read_judgements(table, 100.0, QUESTION), folder, 100.0)
            given = {"forgetting": 0.001}
            found = fit(people, fixed=given, varies=(), chains=2, warmup=200, draws=200, seed=seed)
            estimates = Report(found).estimates
        held += [estimates[n].low <= value <= estimates[n].high for n, value in truth.items()]
    assert 76 <= sum(held) <= 99, sum(held)
