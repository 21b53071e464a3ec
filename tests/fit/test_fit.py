"""`i2p fit` from a table to an audience that stories can name, and back to the truth."""

from __future__ import annotations

import csv
import io
import json
import warnings
from contextlib import redirect_stderr, redirect_stdout
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest

import i2pdsl
from commands_for_tests import Outcome, Run, process
from fuzz_for_tests import FULL
from i2pdsl.cli import run_command
from i2pdsl.computing import computing
from i2pdsl.language.people import read_people
from worlds_for_tests import with_small_world

QUESTION = "P(rho > 0 | script[:t])"
TRUTH = {"sharpness": 1.5, "noise": 0.8, "bias": -0.4, "slope": 0.8, "lapse": 0.03}
PEOPLE, SCRIPTS = 12, 6


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


def believed(folder: Path, sharpness: float) -> np.ndarray:
    """What a viewer believes after each frame of the scripts, [6, T + 1]."""
    found = []
    for number in range(SCRIPTS):
        script = i2pdsl.Script.load(folder / f"{number}.json")
        sharper = f"bayesian(sharpness = {sharpness}, forgetting = 0.001)"
        found.append(script.query(QUESTION, audience=sharper))
        assert not np.allclose(found[-1], script.query(QUESTION))
    return np.array(found)


def simulated(
    folder: Path,
    truth: dict[str, float],
    seed: int,
    frames: tuple[int, ...],
    pairs: bool,
    people: int = PEOPLE,
    spread: float = 0.0,
) -> Path:
    """A table of what people would answer, about scripts after each of `frames` on a slider, and
    about which of two says more. They differ in bias, and in the logarithm of noise, by `spread`.
    """
    generator = np.random.default_rng(seed)
    bias = truth["bias"] + spread * generator.normal(size=people)
    wide = truth["noise"] * np.exp(spread * generator.normal(size=people))
    beliefs = believed(folder, truth["sharpness"])
    odds = np.log(beliefs / (1 - beliefs))
    rows: list[tuple[object, ...]] = []
    for number, frame, person in product(range(SCRIPTS), frames, range(people)):
        noise = generator.logistic() * wide[person] * np.sqrt(3) / np.pi
        placed = bias[person] + truth["slope"] * odds[number, frame] + noise
        answer = 1 / (1 + np.exp(-placed))
        if generator.random() < truth["lapse"]:
            answer = generator.random()
        told = (f"person {person}", f"{number}.json", "", frame, QUESTION, round(100 * answer))
        rows.append(told)
    for (one, other), person in product(combinations(range(SCRIPTS), 2), range(people)):
        if not pairs:
            break
        apart = truth["slope"] * (odds[one, -1] - odds[other, -1])
        chosen = generator.random() < 1 / (1 + np.exp(-apart))
        if generator.random() < truth["lapse"]:
            chosen = generator.random() < 0.5
        both = [f"{one}.json", f"{other}.json"]
        if generator.random() < 0.5:  # they stood either way round
            both, chosen = both[::-1], not chosen
        told = (f"person {person}", *both, "T", "more", "first" if chosen else "second")
        rows.append(told)
    path = folder / f"table-{seed}.csv"
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("participant", "script", "other", "frame", "question", "answer"))
        writer.writerows(rows)
    return path


@pytest.fixture(scope="module")
def fitted(folder: Path) -> tuple[Outcome, Path]:
    """In `make test` from sliders alone, without a baseline: NumPyro's programs take long to
    compile."""
    table = simulated(folder, TRUTH, 0, (2, 5), pairs=FULL)
    out = folder / "people.toml"
    given = ["--scale", "100", "--chains", "2", "--warmup", "60", "--draws", "60", "--json"]
    given += ["--vary", "nothing", "--fix", "forgetting=0.001"]
    if FULL:
        given += ["--pair", f"more:{QUESTION}"]
        given += ["--cue", "mean_t [idle(robot) @ script[t]]", "--cue", "t"]
    said, problems = io.StringIO(), io.StringIO()
    with redirect_stdout(said), redirect_stderr(problems), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of libraries, as a command does
        status = run_command(["fit", str(table), "-o", str(out), *given])
    return Outcome(status, said.getvalue(), problems.getvalue()), out


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
    assert told["r"] > 0.95
    assert told["rmse"] < 14
    assert told["loo"]["loo"] < (-100 if FULL else 0)
    assert 0.8 < told["predictive"]["within_90"] <= 1
    pairs = 15 if FULL else 0
    assert (told["people"], told["answers"]) == (PEOPLE, PEOPLE * (2 * SCRIPTS + pairs))
    cells = told["cells"]
    assert [cell["other"] is None for cell in cells] == [True] * 12 + [False] * pairs
    for pair in cells[12:13]:
        assert (pair["script"], pair["other"], pair["count"]) == ("0.json", "1.json", PEOPLE)


def test_its_files_are_what_they_say(fitted: tuple[Outcome, Path], folder: Path) -> None:
    done, out = fitted
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # once a day it speaks of its own future
        arviz = pytest.importorskip("arviz")
    told = json.loads(done.out)
    (person,) = read_people(out)
    data = arviz.from_netcdf(out.with_suffix(".nc"))
    logs = np.log(data.posterior["sharpness"].values)
    assert person.sharpness == pytest.approx(np.exp(logs.mean()), rel=1e-3)
    assert data.posterior["sharpness"].shape == (2, 60)
    assert data.log_likelihood["answer"].shape[-1] == told["answers"]
    assert out.with_suffix(".png").read_bytes()[:4] == b"\x89PNG"
    text = 'world small\nlength 3\naudience "people.toml"\nmaximize depict(rho > 0)\n'
    (folder / "to-people.story").write_text(text)
    (observer,) = i2pdsl.load(folder / "to-people.story").typed.observers
    assert observer.sharpness == person.sharpness


def test_what_arviz_says_of_its_own_future_is_not_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """It warns once a day as it is imported."""
    from i2pdsl.fit import report

    told = lambda *_: warnings.warn("it will change", FutureWarning, stacklevel=1)
    monkeypatch.setattr(report, "optional", told)
    report._arviz()


@pytest.mark.slow
def test_an_inverse_planner_beats_what_can_be_counted(fitted: tuple[Outcome, Path]) -> None:
    told = json.loads(fitted[0].out)["comparison"]
    ours, cues = (next(c for c in told if c["name"] == n) for n in ("this audience", "cues"))
    assert told == sorted(told, key=lambda one: -one["loo"])
    for one in told:
        assert one["difference"] == pytest.approx(told[0]["loo"] - one["loo"])
    assert ours["best_for"] + cues["best_for"] == PEOPLE
    assert ours["rmse"] < cues["rmse"] / 2


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
    from i2pdsl.fit.judgements import read_judgements
    from i2pdsl.fit.questions import study

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
        (("--pair", "more"), 2, "is not NAME:EXPR"),
        (("--assume", "rh > 0"), 1, "assume:1:1: error[unknown-name]: unknown name `rh`"),
        (("--pair", "a:T", "--choice", "a:b=T;c=T"), 2, "a name is given twice"),
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


def test_pairs_that_cannot_be_asked(folder: Path) -> None:
    """Both films are looked at, and a question is told where it stands."""
    from i2pdsl.errors import StoryError
    from i2pdsl.fit.judgements import Pair, read_judgements
    from i2pdsl.fit.questions import study

    named = {"more": Pair(QUESTION), "odd": Pair("P(rh > 0 | script[:t])")}
    rows = (
        "a,0.json,no.json,T,more,first\na,0.json,1.json,9,more,first\na,0.json,1.json,T,odd,first\n"
    )
    (folder / "wrong.csv").write_text(f"participant,script,other,frame,question,answer\n{rows}")
    with pytest.raises(StoryError) as caught:
        study(read_judgements(folder / "wrong.csv", named=named), folder, named=named)
    told = str(caught.value)
    for place, said in (
        ("2:10", "this script cannot be read"),
        ("3:17", "the script has 5 frames"),
        ("4:19", "unknown name `rh`"),
    ):
        assert f"wrong.csv:{place}: error[judgement]: {said}" in told


def test_which_film_stood_first_does_not_matter(folder: Path) -> None:
    from i2pdsl.fit.judgements import Pair, read_judgements
    from i2pdsl.fit.questions import study

    named = {"more": Pair("mean_t P(rho > 0 | script[:t])")}
    rows = ("0.json,1.json,T,first", "1.json,0.json,T,second", "1.json,0.json,T,first")
    lines = [f"p{number},{row},more" for number, row in enumerate(rows)]
    head = "participant,script,other,frame,answer,question"
    (folder / "turned.csv").write_text("\n".join([head, *lines]))
    asked = study(read_judgements(folder / "turned.csv", named=named), folder, named=named).asked
    assert asked.answer.tolist() == [1, 1, 0]
    assert len(np.unique(asked.cell, axis=0)) == 1


@pytest.mark.slow
def test_audiences_are_compared(folder: Path) -> None:
    """From pairs alone: parameters of sliders are not fitted, and the truth comes back."""
    table = simulated(folder, TRUTH, 99, (), pairs=True)
    given = ("--pair", f"more:{QUESTION}", "--vary", "nothing", "--chains", "2", "--json")
    done = process("fit", table, *given, "--against", "hypotheses=literal")
    told = json.loads(done.out)
    assert {one["name"] for one in told["comparison"]} == {"this audience", "hypotheses=literal"}
    assert not {"noise", "bias"} & set(told["estimates"])
    for name in ("sharpness", "slope", "lapse"):
        each = told["estimates"][name]
        spread = (each["high"] - each["low"]) / 3.3
        assert abs(each["mean"] - TRUTH[name]) < 4 * spread + 0.02, (name, each)


@pytest.mark.slow
def test_intervals_hold_the_truth_at_their_rate(folder: Path) -> None:
    """Of 20 simulated tables of 40 people with parameters drawn from what is thought of them
    beforehand, 90 % intervals hold them 90 times in 100: between 76 and 99 of 100 figures. In every
    second table they chose between films, too; in half of all they differ."""
    from i2pdsl.fit.fit import fit
    from i2pdsl.fit.judgements import Pair, read_judgements
    from i2pdsl.fit.questions import study
    from i2pdsl.fit.report import Report

    held = []
    named = {"more": Pair(QUESTION)}
    for seed in range(1, 21):
        generator = np.random.default_rng(seed)
        truth = {
            "sharpness": float(np.exp(generator.normal(0, 1))),
            "noise": float(np.exp(generator.normal(0, 0.7))),
            "bias": float(generator.normal(0, 0.5)),
            "slope": float(np.exp(generator.normal(0, 0.5))),
            "lapse": float(1 / (1 + np.exp(-generator.normal(-3, 1)))),
        }
        differ = seed > 10
        spread = abs(float(generator.normal(0, 0.3))) if differ else 0.0
        of_table = {"pairs": seed % 2 == 0, "people": 40, "spread": spread}
        table = simulated(folder, truth, seed, (1, 2, 3, 5), **of_table)
        with computing():
            people = study(read_judgements(table, 100.0, None, named), folder, 100.0, named)
            varies = ("noise", "bias") if differ else ()
            settings = {"fixed": {"forgetting": 0.001}, "varies": varies, "seed": seed}
            found = fit(people, chains=2, warmup=200, draws=200, **settings)
            estimates = Report(found).estimates
        held += [estimates[n].low <= value <= estimates[n].high for n, value in truth.items()]
        print(seed, "held", held[-5:], flush=True)
    assert 76 <= sum(held) <= 99, sum(held)
