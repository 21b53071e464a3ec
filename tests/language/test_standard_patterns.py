"""The standard patterns: documented, usable in any world, shown by a story, and what they say.

The formulas are checked against loops over tests/reference.py, an independent audience, on random
scripts of a small kitchen.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random

import pytest

import reference as R
from i2pdsl.errors import Source, StoryError
from i2pdsl.language import ast
from i2pdsl.language.check import Library, TypedStory, check_source
from i2pdsl.language.parse import parse_file
from i2pdsl.objective.replay import replay
from i2pdsl.objective.terms import score_script
from i2pdsl.worlds.find import find_vocabulary
from stories_for_tests import BARE
from worlds_for_tests import STORIES, small_kitchen

FILES = sorted((STORIES / "patterns").glob("*.story"))
PATTERNS = {p.name.id: p for file in FILES for p in parse_file(file).of(ast.Pattern)}
SHAPES = (
    "rags_to_riches",
    "riches_to_rags",
    "man_in_a_hole",
    "icarus",
    "cinderella",
    "oedipus",
)
IN_THE_KITCHEN = {
    "arc": "robot",
    "deceptive": "robot, rho < 0, rho > 0",
    "depict": "rho > 0",
    "flashback": "rho > 0, shown, pushes(robot, cheese)",
    "foreshadowing": "rho < 0",
    "irony": "G_cheese = green, G_cheese = pink, rho > 0, rho < 0",
    "legible": "G_robot = pink",
    "mystery": "G_robot",
    "red_herring": "G_robot = pink",
    "reveal": "rho > 0",
    "shared_secret": "viewers, viewers, rho > 0",
    "surprising": "rho > 0",
    "suspenseful": "rho",
    "twist": "rho > 0, rho < 0",
    **dict.fromkeys(SHAPES, "cheese, G_cheese = pink"),
}
ON_THE_HILL = {
    "arc": "hopper",
    "deceptive": "hopper, weight = 0.1, weight = 0.5",
    "depict": "weight = 0.5",
    "foreshadowing": "weight = 0.5",
    "irony": "weight = 0.1, weight = 0.5, weight = 0.5, weight = 0.1",
    "legible": "weight = 0.5",
    "mystery": "weight",
    "red_herring": "weight = 0.5",
    "reveal": "weight = 0.5",
    "shared_secret": "viewers, viewers, weight = 0.5",
    "surprising": "weight = 0.5",
    "twist": "weight = 0.5, weight = 0.1",
    **dict.fromkeys(SHAPES, "hopper"),
}
REFUSED_ON_THE_HILL = {
    "flashback": "weight = 0.5, script ++ [hopper: east], fallen(hopper)",
    "suspenseful": "weight",
}
SHOWN = "let shown = script ++ [cheese: stay, robot: east]\n"


def checked(text: str) -> TypedStory:
    story = check_source(Source("test.story", text), find_vocabulary)
    assert not isinstance(story, Library)
    return story


@pytest.mark.parametrize("name", PATTERNS)
def test_serves_the_kitchen(name: str) -> None:
    shown = SHOWN if name == "flashback" else ""
    text = f"world kitchen\nlength 12\n{shown}maximize {name}({IN_THE_KITCHEN[name]})\n"
    assert checked(text).warnings == ()


@pytest.mark.parametrize("name", PATTERNS)
def test_serves_the_hill_or_is_refused_for_a_reason(name: str) -> None:
    text = "world hill\nlength 90\nmaximize {}({})\n"
    if name in REFUSED_ON_THE_HILL:
        with pytest.raises(StoryError) as caught:
            checked(text.format(name, REFUSED_ON_THE_HILL[name]))
        assert {d.code for d in caught.value.diagnostics} == {"world"}
    else:
        # That a latent of one value only is certain is no mistake of the pattern.
        assert checked(text.format(name, ON_THE_HILL[name])).length == 90


def words_of(world: str) -> set[str]:
    """Everything that a story can name of a world, but for its settings."""
    vocabulary = find_vocabulary(world, STORIES / "worlds")
    assert vocabulary is not None
    values = {v for x in vocabulary.latents.values() for v in x.values if isinstance(v, str)}
    return {
        *vocabulary.characters,
        *vocabulary.things,
        *vocabulary.latents,
        *vocabulary.places,
        *vocabulary.predicates,
        *values,
    }


@pytest.mark.parametrize("world", ["kitchen", "maze", "porters", "fork", "hill"])
def test_no_pattern_names_anything_of_a_world(world: str) -> None:
    words = words_of(world)
    assert len(words) > 4
    for name, pattern in PATTERNS.items():
        named = set(re.findall(r"\w+", f"{pattern.signature} {pattern.body.span.text}"))
        assert not named & words, name


@pytest.mark.parametrize("name", PATTERNS)
def test_documentation_has_all_its_parts(name: str) -> None:
    pattern = PATTERNS[name]
    sentence, _, rest = pattern.documentation.partition("\nUse it ")
    assert re.fullmatch(r"[A-Z][^.]*\.", sentence), "one sentence in the words of storytelling"
    use, _, source = rest.rpartition("\nAfter ")
    assert use, "when to use it, and after whom"
    for parameter in pattern.parameters:
        assert f"`{parameter.name.id}`" in use, "what each parameter means"
    assert re.search(r"[A-Z]\w+.*? (19|20)\d\d\b", source), "authors and year"
    for doi in re.findall(r"DOI (\S+)", source):
        assert re.match(r"10\.\d{4}/\S+", doi)


@pytest.mark.parametrize("name", PATTERNS)
def test_has_a_story_as_its_example(name: str) -> None:
    stories = [p for p in STORIES.rglob("*.story") if p.parent.name != "patterns"]
    used = [p for p in stories if f"maximize {name}(" in p.read_text(encoding="utf-8")]
    assert used
    assert all("# expect " in p.read_text(encoding="utf-8") for p in used)


def test_the_page_on_the_language_lists_them() -> None:
    page = Path(__file__).parents[2] / "docs" / "language.md"
    rows = re.findall(r"^\| `(\w+\([^`]*\))` \|", page.read_text(encoding="utf-8"), re.MULTILINE)
    listed = {row for row in rows if row.partition("(")[0] in PATTERNS}
    assert listed == {p.signature for p in PATTERNS.values()}


def test_six_shapes_begin_and_end_as_their_names_say() -> None:
    """The turning points of Reagan et al. 2016: from which side to which side of the middle."""
    ways = {
        "rags_to_riches": [-1, 1],
        "riches_to_rags": [1, -1],
        "man_in_a_hole": [1, -1, 1],
        "icarus": [-1, 1, -1],
        "cinderella": [-1, 1, -1, 1],
        "oedipus": [1, -1, 1, -1],
    }
    assert set(ways) == set(SHAPES)
    for name, turns in ways.items():
        shape = re.search(r"arc\(who, (.*?), scale", PATTERNS[name].body.span.text)
        assert shape is not None
        python = shape[1].replace("pi", "math.pi").replace("cos", "math.cos")
        for leg, expected in enumerate(turns):
            t = leg / (len(turns) - 1)
            assert eval(python, {"math": math, "t": t, "T": 1}) == pytest.approx(expected)


# ---- What the formulas say -----------------------------------------------------------------------


@dataclass(frozen=True)
class Told:
    """A script of the small kitchen as the reference sees it."""

    world: R.World
    script: dict
    T: int

    def P(self, t: int, event: Callable[[dict], bool]) -> float:
        return R.P(self.world, self.script, t, event)

    def sum(self, term: Callable[[int], float]) -> float:
        return sum(term(t) for t in range(1, self.T + 1))


def wants(goal: str) -> Callable[[dict], bool]:
    return lambda h: h.get("G_robot") == goal


def undecided(p: float) -> float:
    """How little viewers can tell: the variance of a coin, as a share of that of a fair one."""
    return (p * (1 - p) ** 2 + (1 - p) * p**2) / 0.25


def legible(told: Told) -> float:
    """The integral of P(s) 2 (T - s) / T over the time s, P being constant within a frame."""
    steps = 1000
    weights = [
        sum(2 * (told.T - (t - 1 + (i + 0.5) / steps)) / told.T for i in range(steps)) / steps
        for t in range(1, told.T + 1)
    ]
    assert sum(weights) == pytest.approx(told.T)
    return told.sum(lambda t: weights[t - 1] * told.P(t, wants("pink")))


def moved(told: Told, turn: float, about: str) -> float:
    return 0.5 * R.moved_others(told.world, told.script, turn, {about})


def foreshadowing(told: Told) -> float:
    def term(t: int) -> float:
        p = told.P(t, R.HINDERS)
        if t < told.T / 4:
            return 1 - p
        return undecided(p) if t <= told.T * 3 / 4 else p

    return told.sum(term) - moved(told, told.T * 3 / 4, "rho")


def reveal(told: Told) -> float:
    def term(t: int) -> float:
        p = told.P(t, R.HELPS)
        return undecided(p) if t < told.T / 2 else p

    return told.sum(term) - moved(told, told.T / 2 - 1, "rho")


def mystery(told: Told) -> float:
    """What is left of the question, less the uncertainty about the rest: the chain rule."""

    def rest(t: int) -> float:
        """H(everything | the robot's goal), by the conditional beliefs."""
        total = 0.0
        for goal in ("pink", "green", "none"):
            p = told.P(t, wants(goal))
            conditions = [wants(goal)]
            total += p * R.entropy(told.world, told.script, t, None, conditions)
        return total

    def asked(t: int) -> float:
        return R.entropy(told.world, told.script, t, "G_robot")

    return told.sum(lambda t: asked(t) / asked(0) - 0.5 * rest(t))


def surprising(told: Told) -> float:
    """Euclid's distance of two beliefs about an event and its opposite, without the root 2."""

    def term(t: int) -> float:
        p, q = told.P(t, R.HELPS), told.P(t - 1, R.HELPS)
        return math.dist((p, 1 - p), (q, 1 - q)) / math.sqrt(2)

    return told.sum(term)


def fortune(told: Told, t: int, who: str, wish: Callable[[dict], bool] | None = None) -> float:
    return R.EV(told.world, told.script, t, who, [wish] if wish else [])


def arc(told: Told, shape: Callable[[float], float], wish: Callable[[dict], bool]) -> float:
    return told.sum(
        lambda t: (
            0.02 * shape(t / told.T) * fortune(told, t, "cheese", wish)
            - 0.1 * R.KL(told.world, told.script, t - 1, t)
        )
    )


def drawn(x: float) -> float:
    """From (0, 0) to (0.3, 1) to (1, -1)."""
    return x / 0.3 if x <= 0.3 else 1 - 2 * (x - 0.3) / 0.7


FORMULAS: dict[str, Callable[[Told], float]] = {
    "legible(G_robot = pink)": legible,
    "foreshadowing(rho < 0)": foreshadowing,
    "reveal(rho > 0)": reveal,
    "mystery(G_robot)": mystery,
    "surprising(rho > 0)": surprising,
    "suspenseful(rho)": lambda told: told.sum(
        lambda t: math.sqrt(R.suspense(told.world, told.script, t, "rho"))
    ),
    "red_herring(G_robot = pink, dropped = 4)": lambda told: (
        told.sum(lambda t: told.P(t, wants("pink")) if t <= 4 else 1 - told.P(t, wants("pink")))
        - moved(told, 4, "G_robot")
    ),
    "deceptive(robot, rho < 0, rho > 0)": lambda told: told.sum(
        lambda t: (
            told.P(t, R.HELPS) + 0.02 * (t / told.T) ** 4 * fortune(told, t, "robot", R.HINDERS)
        )
    ),
    "flashback(rho > 0, shown, pushes(robot, cheese))": lambda told: R.flashback(
        told.world, told.script, R.HELPS
    ),
    "cinderella(cheese, G_cheese = pink)": lambda told: arc(
        told, lambda x: -math.cos(3 * math.pi * x), R.PINK
    ),
    "oedipus(cheese, G_cheese = green)": lambda told: arc(
        told, lambda x: math.cos(3 * math.pi * x), R.GREEN
    ),
    "arc(cheese, points((0, 0), (0.3, 1), (1, -1)), wish = (G_cheese = pink))": lambda told: arc(
        told, drawn, R.PINK
    ),
}


@pytest.mark.parametrize("call", FORMULAS)
def test_formula_says_what_it_is_meant_to(call: str) -> None:
    pair, random = small_kitchen(), Random(call)
    shown = SHOWN if "shown" in call else ""
    story = pair.story(f"world kitchen\nlength 6\n{BARE}{shown}maximize {call}\n")
    seen = set()
    for _ in range(3):
        path = pair.random_script(random, story.length)
        frames = replay(pair.world, path.states, path.actions)
        score = score_script(story, pair.world, frames)
        told = Told(pair.reference, pair.document(path), story.length)
        assert score == pytest.approx(FORMULAS[call](told), abs=1e-5)
        seen.add(round(score, 6))
    assert len(seen) == 3, "different scripts are worth different things"
