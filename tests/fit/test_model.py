"""The model of answers against plain Python, and viewers against the product's own replay."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest

import i2pdsl
from i2pdsl.computing import computing
from i2pdsl.objective.replay import evaluate, replay
from i2pdsl.programs import BRIEF, once
from i2pdsl.worlds.ready import ready_world
from i2pdsl.worlds.world import Viewer as SpecViewer
from worlds_for_tests import with_small_world

STORY = "world small\nlength {}\nmaximize depict(rho > 0)\n"
QUESTIONS = (
    "P(rho > 0 | script[:t])",
    "E[rho | script[:t]]",
    "P(rho > 0 | script[:T])",
    "entropy(G_cheese | script[:t])",
    "surprise(script[t])",
    "E[V(robot) | script[:t]]",
    "P(rho > 0 | script[:t]) - P(rho > 0 | script[:t-1])",
    "mean_t P(rho < 0 | script[:t])",
    "P(G_robot = pink | script[:t, cheese])",
    "P(rho > 0 | script[:t]) * [at(robot, pink) @ script[t]]",
    "P(G_cheese = pink @ script[1] | script[:T])",
)


@pytest.fixture(scope="module")
def scripts(tmp_path_factory: pytest.TempPathFactory) -> list[i2pdsl.Script]:
    """Three scripts of two lengths."""
    folder = with_small_world(tmp_path_factory.mktemp("fit"))
    found = []
    for number, length in enumerate((5, 3, 5)):
        path = folder / f"{number}.story"
        path.write_text(STORY.format(length))
        found.append(i2pdsl.load(path).solve(seed=number, naive=True).script)
    return found


def test_viewers_answer_as_queries_do(scripts: list[i2pdsl.Script]) -> None:
    """For three kinds of viewers, at all frames, whether evaluated together or alone."""
    spec = scripts[0].world.spec.with_settings({"switching": 0.1})
    world = ready_world(spec, (SpecViewer(spec),))
    with computing():
        import jax

        from i2pdsl.fit.viewers import Answers, Question, Viewer, Watched, what_is_seen

        watched = [Watched(world, script.trajectory) for script in scripts]
        cells, expected = [], []
        tilt = np.linspace(-1, 1, len(world.vocabulary.hypotheses))
        log_prior = tilt - np.log(np.exp(tilt).sum())
        kinds = [(1.0, 1e-5), (0.4, 0.05), (3.0, 0.2)]
        worlds = [world.with_audience(k, np.array([e]), log_prior[None]) for k, e in kinds]
        for number, script in enumerate(scripts):
            path = script.trajectory
            seen = [replay(w, path.states, path.actions) for w in worlds]
            for text in QUESTIONS:
                query = script.check(text)
                for frame in query.times or (script.length,):
                    cells.append(Question(number, query.value, query.times, frame))
                    place = None if query.times is None else frame - query.times.start
                    values = [
                        evaluate(w, f, query.value, query.times)
                        for w, f in zip(worlds, seen, strict=True)
                    ]
                    expected.append(
                        [float(v) if place is None else float(v[place]) for v in values]
                    )
        with jax.enable_x64(True):
            answers = jax.jit(Answers(watched, cells).__call__, compiler_options=BRIEF)
            seen_by_all = what_is_seen(watched)
            found = [answers(seen_by_all, Viewer(k, e, log_prior)) for k, e in kinds]
            np.testing.assert_allclose(np.stack(found, 1), expected, rtol=1e-9, atol=1e-9)


def test_slopes_are_finite_in_single_precision(scripts: list[i2pdsl.Script]) -> None:
    """Also of viewers who are very sharp, and where one script is shorter than another: what
    stands in the place of its missing frames must not get in."""
    with computing():
        import jax
        import jax.numpy as jnp

        from i2pdsl.fit.viewers import Answers, Question, Viewer, Watched, what_is_seen

        spec = scripts[0].world.spec
        world = ready_world(spec, (SpecViewer(spec),))
        watched = [Watched(world, script.trajectory) for script in scripts]
        query = scripts[0].check("P(rho > 0 | script[:t])")
        cells = [Question(n, query.value, query.times, s.length) for n, s in enumerate(scripts)]
        answers, seen = Answers(watched, cells), what_is_seen(watched)
        log_prior = jnp.asarray(world.log_prior(world.tables)[0], jnp.float32)

        def total(sharpness: jax.Array) -> jax.Array:
            viewer = Viewer(sharpness, jnp.float32(0.03), log_prior)
            return answers(seen, viewer) @ jnp.array([0.3, -1.1, 0.7])

        sharpness = np.exp(np.arange(-1.0, 3.0, 0.25), dtype=np.float32)
        slope = once(jax.vmap(jax.grad(total)), sharpness)
        assert np.isfinite(slope).all()


def logistic(x: float) -> float:
    return 1 / (1 + math.exp(-x))


def chance(answer: float, p: float, own: dict[str, float]) -> float:
    """The probability of a slider's position, as docs/fit.md has it."""
    middle = own["bias"] + own["slope"] * math.log(p / (1 - p))
    width = own["noise"] * math.sqrt(3) / math.pi
    below = lambda x: logistic((math.log(x / (1 - x)) - middle) / width)
    high = 1.0 if answer > 0.995 else below(answer + 0.005)
    low = 0.0 if answer < 0.005 else below(answer - 0.005)
    return (1 - own["lapse"]) * (high - low) + own["lapse"] / 101


def test_sliders_and_choices_against_plain_python() -> None:
    with computing():
        import jax

        from i2pdsl.fit.answering import log_choice, log_slider, slider_mean

        with jax.enable_x64(True):
            positions = [k / 100 for k in range(101)]

            @partial(jax.jit, compiler_options=BRIEF)
            def told(places: Any, p: Any, own: Any) -> Any:
                total = lambda own: log_slider(places, p, own).sum()
                return log_slider(places, p, own), jax.grad(total)(own), slider_mean(p, own)

            for p, lapse, noise, bias, slope in (
                (0.3, 0.05, 0.7, 0.2, 1.0),
                (0.999, 0.01, 2.0, -1.0, 0.5),
                (0.02, 0.2, 0.4, 0.0, 2.0),
            ):
                own = {"lapse": lapse, "noise": noise, "bias": bias, "slope": slope}
                arrays = {name: np.full(101, value) for name, value in own.items()}
                logs, slopes, means = told(np.array(positions), np.full(101, p), arrays)
                plain = [chance(a, p, own) for a in positions]
                np.testing.assert_allclose(np.exp(logs), plain, rtol=1e-9)
                assert sum(plain) == pytest.approx(1, abs=1e-9)
                step = 1e-6
                for name in own:
                    moved = {**own, name: own[name] + step}
                    rise = sum(math.log(chance(a, p, moved)) for a in positions)
                    rise -= sum(map(math.log, plain))
                    assert float(slopes[name].sum()) == pytest.approx(rise / step, rel=1e-3)
                assert float(means[0]) == pytest.approx(np.dot(plain, positions), abs=1e-9)
            chosen = once(
                log_choice,
                np.array([1, 0]),
                np.array([[0.2, 0.7, 0.1], [0.5, 0.25, 0.5]]),
                np.array([3, 2]),
                {"slope": np.array([2.0, 1.0]), "lapse": np.array([0.1, 0.0])},
            )
            first = 0.9 * 0.49 / (0.04 + 0.49 + 0.01) + 0.1 / 3
            np.testing.assert_allclose(np.exp(chosen), [first, 2 / 3], rtol=1e-6)


def test_pairs_against_plain_python() -> None:
    """The chance that the first film is chosen, and how often it is expected to be by other films
    that lie apart as far."""
    p, slope, lapse, misfit, deviation = (0.8, 0.3), 0.7, 0.1, 0.6, (0.4, -0.5)
    odds = lambda p: math.log(p / (1 - p))
    apart = slope * (odds(p[0]) - odds(p[1]))
    told = apart + misfit * (deviation[0] - deviation[1])
    first = (1 - lapse) * logistic(told) + lapse / 2
    steps = np.linspace(-8, 8, 4001)
    shares = [logistic(apart + math.sqrt(2) * misfit * z) for z in steps]
    mean = (1 - lapse) * np.average(shares, weights=np.exp(-(steps**2) / 2)) + lapse / 2
    with computing():
        import jax

        from i2pdsl.fit.model import PAIR, Asked, Cues, Model

        with jax.enable_x64(True):
            fixed = {"noise": 1.0, "bias": 0.0, "slope": slope, "lapse": lapse}
            model = Model(Cues(("odds",)), 1, fixed, cells=2)
            values = {"cue[always]": 0.0, "cue[odds]": 1.0}
            values |= {"misfit": misfit, "deviation": misfit * np.array(deviation)}
            seen = np.array([[odds(p[0])], [odds(p[1])]])
            asked = Asked(
                np.zeros(2, int),
                np.array([[0, 1], [0, 1]]),
                np.array([PAIR, PAIR]),
                np.array([1.0, 0.0]),
            )
            logs, expected = once(
                lambda own: (
                    model.log_likelihoods(own, seen, asked),
                    model.expected(own, seen, asked),
                ),
                values,
            )
            np.testing.assert_allclose(np.exp(logs), [first, 1 - first], rtol=1e-9)
            np.testing.assert_allclose(expected[:, 0], mean, rtol=1e-6)


def test_people_who_think_of_plans_differently_against_plain_python() -> None:
    """Two ways of planning, of which each of three people thinks of one; two questions, each with a
    deviation of its own. What is believed is told by one cue, so that it can be written down."""
    beliefs = {("a", 0): 0.2, ("a", 1): 0.9, ("b", 0): 0.7, ("b", 1): 0.4}  # way, question
    odds = lambda p: math.log(p / (1 - p))
    rows = [(0, 0, 0.1), (0, 1, 0.85), (1, 0, 0.8), (1, 1, 0.5), (2, 0, 0.0), (2, 1, 1.0)]
    own = {"lapse": 0.05, "noise": 0.7, "bias": 0.2, "slope": 0.8}
    shares, deviation, misfit = {"a": 0.7, "b": 0.3}, (0.5, -0.3), 0.6
    total, given_others = 0.0, []
    for person in range(3):
        mine = [(question, answer) for who, question, answer in rows if who == person]

        def together(way: str, answers: list[tuple[int, float]]) -> float:
            moved = [{**own, "bias": own["bias"] + d} for d in deviation]
            each = (chance(y, beliefs[way, q], moved[q]) for q, y in answers)
            return shares[way] * math.prod(each)

        every = sum(together(way, mine) for way in shares)
        total += math.log(every)
        for one in mine:
            rest = [other for other in mine if other != one]
            given_others.append(math.log(every / sum(together(way, rest) for way in shares)))
    with computing():
        import jax

        from i2pdsl.fit.model import Asked, Cues, Model

        with jax.enable_x64(True):
            model = Model(Cues(("odds",)), 3, {}, ("plan",), plans=2, cells=2)
            unbounded = {n: math.log(x) for n, x in own.items() if n in ("noise", "slope")}
            unbounded |= {"lapse": odds(own["lapse"]), "bias": own["bias"]}
            unbounded |= {"cue[always]": 0.0, "cue[odds]": 1.0}
            unbounded |= {f"share[{n}]": math.log(s) for n, s in enumerate(shares.values())}
            assert set(unbounded) == set(model.scales)
            values = {**unbounded, "misfit": misfit, "deviation": np.array(deviation)}
            nodes = np.array([[[odds(beliefs[way, q])] for q in (0, 1)] for way in shares])
            person, cell, answer = (np.array(column) for column in zip(*rows, strict=True))
            asked = Asked(person, cell[:, None], np.zeros(6, int), answer)
            found, (logs, groups), means = once(
                lambda own: (
                    model.log_answers(own, nodes, asked, np.ones(6)),
                    model.by_plan(own, nodes, asked, np.ones(6)),
                    model.expected(own, nodes[0], asked),
                ),
                values,
            )
            assert float(found) == pytest.approx(total, rel=1e-9)
            of_each = np.asarray(groups)[:, person]
            without = np.logaddexp(*of_each) - np.logaddexp(*(of_each - np.asarray(logs)))
            np.testing.assert_allclose(without, given_others, rtol=1e-9)
    places = [k / 100 for k in range(101)]
    steps = np.linspace(-6, 6, 2001)
    weights = np.exp(-(steps**2) / 2)
    for question in (0, 1):
        p = beliefs["a", question]
        moved = ({**own, "bias": own["bias"] + misfit * z} for z in steps[::20])
        plain = [sum(y * chance(y, p, o) for y in places) for o in moved]
        expected = np.average(plain, weights=weights[::20])
        assert float(means[question, 0]) == pytest.approx(expected, abs=1e-4)
