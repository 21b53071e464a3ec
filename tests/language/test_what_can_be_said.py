"""Every listing and statement of design/language.md, through the checker with the kitchen."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from i2pdsl.errors import Source, StoryError
from i2pdsl.language import typed as ty
from i2pdsl.language.check import Library, TypedQuery, TypedStory, check_query, check_source
from i2pdsl.language.scope import Module
from i2pdsl.language.vocabulary import Vocabulary, Weights
from i2pdsl.worlds.find import find_vocabulary
from i2pdsl.worlds.grid.parse import parse_world
from i2pdsl.worlds.grid.vocabulary import grid_vocabulary

ROOT = Path(__file__).parents[2]
KITCHEN = find_vocabulary("kitchen")
assert KITCHEN is not None
HYPOTHESES = KITCHEN.hypotheses
RATIONAL = tuple(bool(h["R_robot"] and h["R_cheese"]) for h in HYPOTHESES)

# The listings of language.md, letter for letter.
HELP = """\
# help.story
world kitchen
length 15

maximize sum_t P(rho > 0 | script[:t])
"""
PATTERNS = """\
pattern depict(event, over = script) = sum_{t in 1..last(over)} P(event | over[:t])

pattern irony(truth, mistaken, meant, done) =
    sum_t (P(truth | script[:t])
           + P(done | script[:t], truth)
           + P(meant | script[:t], mistaken))

pattern arc(who, shape = sin(t/T * 3*pi), scale = 0.02, steady = 0.1) =
    sum_t (scale * shape * E[V(who) | script[:t]] - steady * KL(script[:t-1] || script[:t]))
"""


def story(text: str, *statements: str, length: int = 15) -> TypedStory:
    lines = (f"world kitchen\nlength {length}", *statements, f"maximize {text}\n")
    checked = check_source(Source("said.story", "\n".join(lines)), find_vocabulary)
    assert isinstance(checked, TypedStory)
    return checked


def objective(text: str, *statements: str, length: int = 15) -> ty.Typed:
    ((_, value),) = story(text, *statements, length=length).objective
    return value


def codes(text: str, folder: Path | None = None) -> list[str]:
    with pytest.raises(StoryError) as caught:
        check_source(Source("said.story", text), find_vocabulary, folder)
    return [d.code for d in caught.value.diagnostics]


def query(text: str, length: int = 5) -> TypedQuery:
    assert KITCHEN is not None
    source = Source("query", text)
    return check_query(source, KITCHEN, Module(Source("none", "")), length)


def mask(event: str) -> ty.Mask:
    value = query(f"P({event} | script[:0])").value
    assert isinstance(value, ty.Belief)
    return value.about


def test_the_first_listing() -> None:
    checked = check_source(Source("help.story", HELP), find_vocabulary)
    assert isinstance(checked, TypedStory)
    assert (checked.name, checked.world, checked.length) == ("help", "kitchen", 15)
    ((sign, value),) = checked.objective
    rho_positive = tuple(h.get("rho", 0) > 0 for h in HYPOTHESES)
    moment = ty.Moment((), range(1, 16), 1)
    body = ty.Belief("P", rho_positive, (ty.Given(moment, RATIONAL),))
    assert (sign, value) == (1, ty.Reduction("sum", 1, 15, body))
    assert checked.weights == Weights()
    assert (checked.search.method, checked.search.starts, checked.search.width) == ("beam", 500, 1)


def test_the_patterns_of_the_paper_are_the_standard_library() -> None:
    library = check_source(Source("patterns.story", PATTERNS), find_vocabulary)
    assert isinstance(library, Library)
    own = PATTERNS.rstrip("\n")
    for text in (
        "depict(rho > 0)",
        "irony(G_cheese = green, G_cheese = pink, rho > 0, rho < 0)",
        "arc(robot)",
    ):
        assert objective(text, own, length=25) == objective(text, length=25)


@pytest.mark.parametrize("path", sorted((ROOT / "stories").rglob("*.story")), ids=lambda p: p.stem)
def test_every_story_that_is_shipped_is_right(path: Path) -> None:
    source = Source(str(path), path.read_text(encoding="utf-8"))
    checked = check_source(source, find_vocabulary, path.parent)
    assert checked.warnings == ()


def test_every_statement_is_right() -> None:
    path = ROOT / "tests" / "language" / "every_statement.story"
    checked = check_source(Source(str(path), path.read_text()), find_vocabulary, ROOT)
    assert isinstance(checked, TypedStory)
    assert checked.settings == (("beta", 1.5),)
    assert checked.allow == (("deus", "table"),)
    assert checked.start == ty.Feature("absent", (2,), None)
    assert [sign for sign, _ in checked.objective] == [1, -1, 1]
    assert checked.weights == Weights(0.5, 0.0, 0.2, 1.0, 0.05)
    assert len(checked.observers) == 2
    assert checked.observers[0].settings == (("beta", 1.0),)
    weights = checked.observers[1].prior
    assert weights is not None
    assert sum(weights) == pytest.approx(1)
    favoured = [w for w, h in zip(weights, HYPOTHESES, strict=True) if h.get("rho", 0) > 0]
    assert favoured == pytest.approx([2 * min(weights)] * len(favoured))


SAID = [
    "P(rho > 0 | script[:0])",
    "P(rho > 0 | script[:T])",
    "P(rho in {1, 3} | script[:T], G_cheese = pink, G_robot != none)",
    "P(G_robot in {pink, none} or not rho <= 0 | script[:T])",
    "P(G_robot = G_cheese | script[:T])",
    "P(pink = G_cheese | script[:T])",
    "P(-1 <= rho < 3 | script[:T])",
    "P(R_robot and rho > 0 | script[:T])",
    "P(rho > 0 | (script ++ [cheese: stay, robot: east])[:T+1])",
    "P(rho > 0 | (script ++ [cheese: west!, robot: east] ++ [deus: table at (1, 3)])[:T+2])",
    "P(rho > 0 | script[:if T > 3 then 2 else 1])",
    "sum_t E[V(robot) | script[:t]]",
    "sum_t E[rho | script[:t], G_cheese = pink]",
    "sum_t E[if rho > 0 then V(cheese) else t * rho | script[:t]]",
    "sum_t KL(script[:t-1] || script[:t])",
    "sum_t KL(rho; script[:t-1] || script[:t], G_cheese = pink)",
    "sum_t (entropy(rho | script[:t]) + entropy(script[:t]))",
    "sum_t surprise(script[t])",
    "sum_t suspense(rho | script[:t])",
    "sum_t ([at(robot, pink) @ script[t]] + [at(cheese, (1, 1)) @ script[T]])",
    "sum_t [absent(table) or adjacent(robot, cheese) @ script[t]]",
    "sum_t [pushes(robot, cheese) and moved(robot) @ script[t]]",
    "sum_t [not tried(cheese) @ script[t]] * [fell(table) @ script[1]]",
    "mean_t t * P(rho > 0 | script[:t]) - (min_t P(rho > 0 | script[:t])) / max_t t",
    "sum_{t in 2..T-1} P(rho > 0 | script[:t+1])",
    "sum_{t in 0..T} P(rho > 0 | script[:t])",
    "sum_t (if 3 <= t <= 5 then -1 else 1) * P(rho > 0 | script[:t])",
    "sum_t (if t > 1 then P(rho > 0 | script[:t-2]) else 0)",
    "sum_t (if t in {1, 2} or t = 3 then 0 else log(t - 3) * P(rho > 0 | script[:t]))",
    "sum_t points((0, 0), (0.3, 1), (1, -1)) * P(rho > 0 | script[:t])",
    "sum_t (sin(t/T * pi) + cos(t) + exp(-t) + log(t) + sqrt(t) + abs(t) ^ 2 + min(t, 1))",
    "if T > 5 then depict(rho > 0) else 0",
    "last(script ++ [cheese: stay, robot: stay]) * depict(rho > 0)",
    "depict(rho = 0)",
    "depict(event = not rho = 0)",
    "depict(event = if G_cheese = pink then rho > 0 else rho < 0)",
    "depict(rho = 0 and G_cheese = pink)",
    "depict(over = script ++ [cheese: stay, robot: east], rho > 0)",
    "twist(rho > 0, rho < 0, turn = T/3)",
    "arc(robot, scale = 0.01, shape = if t < 5 then 1 else t/T)",
    "arc(who = cheese, shape = points((0, 0), (1, 1)))",
]


@pytest.mark.parametrize("text", SAID)
@pytest.mark.parametrize("length", [1, 2, 15])
def test_every_form_is_checked_without_a_warning(text: str, length: int) -> None:
    if length == 1 and ("(script ++" in text or "2..T" in text):
        text = text.replace("2..T-1", "1..0")
    assert story(text, length=length).warnings == ()


def test_a_comparison_on_a_latent_that_plays_no_part_is_false() -> None:
    plays = [("rho" in h, h.get("rho")) for h in HYPOTHESES]
    assert mask("rho = 0") == tuple(p and v == 0 for p, v in plays)
    assert mask("rho != 0") == tuple(p and v != 0 for p, v in plays)
    assert mask("not rho = 0") == tuple(not (p and v == 0) for p, v in plays)
    assert mask("rho in {0, 1}") == tuple(p and v in (0, 1) for p, v in plays)
    assert mask("-1 <= rho <= 1") == tuple(bool(p and -1 <= v <= 1) for p, v in plays)
    assert mask("G_robot = none") == tuple(h.get("G_robot") == "none" for h in HYPOTHESES)


def test_conditions_join_the_assumption() -> None:
    value = objective("P(rho > 0 | script[:T], G_cheese = pink, rho < 3)")
    assert isinstance(value, ty.Belief)
    assert value.given[0].mask == tuple(
        r and h["G_cheese"] == "pink" and h["rho"] < 3
        for r, h in zip(RATIONAL, HYPOTHESES, strict=True)
    )
    nothing = objective("P(R_robot | script[:T])", "assume nothing")
    assert isinstance(nothing, ty.Belief)
    assert all(nothing.given[0].mask)
    assert story("1", "assume not R_robot").assumption == tuple(
        not h["R_robot"] for h in HYPOTHESES
    )


def test_an_expectation_of_a_value_is_taken_given_that_its_owner_is_rational() -> None:
    value = objective("E[V(robot) | script[:T]]", "assume nothing")
    assert isinstance(value, ty.Belief)
    assert value.given[0].mask == tuple(bool(h["R_robot"]) for h in HYPOTHESES)


def test_warnings_for_what_is_certain() -> None:
    for text, hint in (("R_robot", True), ("R_robot and R_cheese", True), ("rho > 5", False)):
        (warning,) = story(f"sum_t P({text} | script[:t])").warnings
        assert (warning.code, warning.severity) == ("certain", "warning")
        assert ("assume nothing" in (warning.hint or "")) == hint
    assert story("sum_t P(R_robot | script[:t])", "assume nothing").warnings == ()
    (argument,) = story("depict(R_robot)").warnings
    assert argument.span.text == "R_robot"


def test_a_free_t_in_what_is_put_in_is_the_t_of_the_sum() -> None:
    direct = objective("sum_t (t / T) * P(rho > 0 | script[:t])")
    assert (
        objective(
            "sum_t slope * P(e | s)", "let slope = t / T", "let e = rho > 0", "let s = script[:t]"
        )
        == direct
    )
    assert objective("f(t / T)", "pattern f(x) = sum_t x * P(rho > 0 | script[:t])") == direct
    assert objective("f()", "pattern f(x = t / T) = sum_t x * P(rho > 0 | script[:t])") == direct


def test_defaults_see_the_parameters_before_them() -> None:
    text = "pattern f(a, b = a + 1) = a * b"
    assert objective("f(3)", text) == ty.Constant(12.0)
    assert objective("f(3, b = 2)", text) == ty.Constant(6.0)


def test_names_of_values_are_understood_beside_their_latent() -> None:
    """`pink` and `none` are not reserved: a `let` may have such a name."""
    lets = ("let pink = G_cheese = pink", "let none = 3", "let robot = 1", "let stay = 2")
    plain = objective("P(G_robot = none and G_cheese = pink | script[:T])")
    assert objective("P(G_robot = none and pink | script[:T])", *lets) == plain
    assert objective("sum_t [at(robot, pink) @ script[t]]", *lets) == objective(
        "sum_t [at(robot, pink) @ script[t]]"
    )
    assert objective("depict(rho > 0, script ++ [cheese: stay, robot: stay])", *lets) == objective(
        "depict(rho > 0, script ++ [cheese: stay, robot: stay])"
    )
    assert objective("none * robot", *lets) == ty.Constant(3.0)


def shadows(text: str, *statements: str, folder: Path | None = None) -> list[tuple[str, str]]:
    """The severities and the places of what is said about names that the world has too."""
    lines = ("world fork", "length 4", *statements, f"maximize {text}", "")
    try:
        found = check_source(Source("s", "\n".join(lines)), find_vocabulary, folder).warnings
    except StoryError as problem:
        found = problem.diagnostics
    assert {d.code for d in found} <= {"shadow"}
    return [(d.severity, d.span.text) for d in found]


def test_a_value_comes_before_lets_and_parameters_of_its_name(tmp_path: Path) -> None:
    plain = "sum_t P(G_robot = left | script[:t])"
    wanted = "pattern wanted(left) = sum_t P(G_robot = left | script[:t])"
    warned, refused = [("warning", "left")], [("error", "left")]
    for let in ("let left = right", "let left = 3", "let left = G_robot"):
        assert shadows(plain, let) == warned
        assert shadows("sum_t P(left != G_robot | script[:t])", let) == warned
        assert shadows("sum_t P(not G_robot in {left} | script[:t])", let) == warned
        assert shadows("depict(G_robot = left)", let) == warned
        assert shadows("f(left)", let, wanted.replace("left", "x").replace("wanted", "f")) == warned
    assert shadows("wanted(right)", wanted) == refused
    assert shadows("wanted(left = right)", wanted) == refused
    assert shadows("wanted()", wanted.replace("(left)", "(left = right)")) == refused
    assert shadows("wanted(left)", wanted) == []
    (tmp_path / "mine.story").write_text(wanted + "\n", encoding="utf-8")
    assert shadows("wanted(right)", "import mine", folder=tmp_path) == refused
    # Elsewhere the name is what the story says.
    assert shadows("left * T", "let left = 3") == []
    assert shadows("f(3)", "pattern f(left) = left * sum_t P(G_robot = right | script[:t])") == []
    # So it is with characters, tiles and actions.
    seen = "sum_t [at(robot, left) @ script[t]]"
    assert shadows(seen, "let robot = 3", "let left = right") == [
        ("warning", "robot"),
        ("warning", "left"),
    ]
    assert shadows("f(robot)", f"pattern f(left) = {seen}") == refused
    assert shadows("depict(G_robot = right, script ++ [robot: east])", "let east = west") == [
        ("warning", "east")
    ]


def test_the_standard_patterns_serve_a_world_with_names_like_their_parameters() -> None:
    text = "map\n    A.B\ntile event\n".replace("event", "shape") + "    symbol = A\ntile over\n"
    text += "    symbol = B\ncharacter who\n    goals = {shape, over}\n"
    words = grid_vocabulary(parse_world(Source("w.world", text), "w"))
    story = "world w\nlength 4\nmaximize arc(who)\nmaximize depict(G_who = over)\n"
    checked = check_source(Source("s", story), lambda *_: words)
    assert checked.warnings == ()


def test_a_condition_needs_a_hypothesis_that_every_viewer_thinks_possible() -> None:
    some = "audience average(bayesian, bayesian(prior = if rho > 0 then 0 else 1))"
    for objective_ in (
        "sum_t P(G_cheese = pink | script[:t], rho > 0)",
        "sum_t P(G_cheese = pink | script[:t], rho >= 0, rho != 0)",
        "irony(G_cheese = pink, rho = 3, rho > 0, rho < 0)",
        "sum_t E[V(robot) | script[:t], rho = 1]",
        "sum_t KL(script[:t-1] || script[:t], rho = 1)",
        "entropy(G_cheese | script[:T], rho in {1, 3})",
        "entropy(script[:T], rho in {1, 3})",
        "suspense(G_cheese | script[:2], rho = 1)",
    ):
        text = f"world kitchen\nlength 5\nmaximize {objective_}\n"
        assert codes(f"{text}{some}\n") == ["impossible"], objective_
        assert codes(f"{some}\n{text}assume rho >= 0\nmaximize 1 + x\n") == [
            "impossible",
            "unknown-name",
        ]
        check_source(Source("s", text), find_vocabulary)
    plain = f"world kitchen\nlength 5\nmaximize depict(rho < 0)\n{some}\n"
    assert codes(plain + "assume rho > 0\n") == ["impossible"]
    check_source(Source("s", plain + "assume rho <= 0\n"), find_vocabulary)
    odd = "world kitchen\nlength 5\nmaximize depict(rho > 0)\naudience bayesian(prior = {})\n"
    usual = odd.format("if R_cheese and R_robot then 0 else 1")
    assert codes(usual) == ["impossible"]
    check_source(Source("s", f"{usual}assume nothing\n"), find_vocabulary)
    for prior in ("1 / rho", "exp(1000 * (if rho > 0 then 1 else 0))", "log(rho)", "0", "-1"):
        assert codes(odd.format(prior)) == ["audience"]
    check_source(Source("s", odd.format("if rho > 0 then 1e308 else 1e307")), find_vocabulary)


def test_an_expression_without_a_value_under_some_hypothesis() -> None:
    for quantity in ("1 / rho", "exp(1000 * rho)", "sqrt(rho)", "rho ^ 0.5"):
        assert codes(f"world kitchen\nlength 3\nmaximize E[{quantity} | script[:T]]\n") == [
            "arithmetic"
        ]
        with pytest.raises(StoryError, match="where rho = "):
            query(f"P({quantity} > 0 | script[:T])")
    query("E[1 / rho | script[:T], rho != 0]")
    query("P(rho != 0 and 1 / rho > 0 | script[:T])")


def test_parameters_may_stand_for_anything() -> None:
    text = "pattern f(who, what, goal, s) = sum_t [at(who, goal) @ s[t]] * P(what = goal | s[:t])"
    direct = "sum_t [at(robot, pink) @ script[t]] * P(G_robot = pink | script[:t])"
    assert objective("f(robot, G_robot, pink, script)", text) == objective(direct)
    turn = "pattern g(who, does) = depict(rho > 0, script ++ [who: does, robot: stay])"
    assert objective("g(cheese, west)", turn) == objective(
        "depict(rho > 0, script ++ [cheese: west, robot: stay])"
    )


def test_an_own_pattern_replaces_the_standard_one_only_for_oneself(tmp_path: Path) -> None:
    assert objective("depict(3)", "pattern depict(x) = x") == ty.Constant(3.0)
    (tmp_path / "mine.story").write_text("pattern show(e) = depict(e)\n")
    text = "import mine\nworld kitchen\nlength 15\npattern depict(x) = 1\nmaximize show(rho > 0)\n"
    checked = check_source(Source("s", text), find_vocabulary, tmp_path)
    assert isinstance(checked, TypedStory)
    assert checked.objective[0][1] == objective("depict(rho > 0)")


def test_imports(tmp_path: Path) -> None:
    (tmp_path / "one.story").write_text("pattern one(e) = depict(e)\n")
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack" / "a.story").write_text("pattern a(e) = b(e)\n")
    (tmp_path / "pack" / "b.story").write_text("import two\npattern b(e) = two(e)\n")
    (tmp_path / "pack" / "two.story").write_text('import "../one.story"\npattern two(e) = one(e)\n')
    direct = objective("depict(rho > 0)")
    for line, call in (
        ("import one", "one"),
        ('import "one.story"', "one"),
        ("import pack", "a"),
        ('import "pack"', "b"),
        ('import "pack/two.story"', "two"),
        ("import depict", "depict"),
    ):
        text = f"{line}\nworld kitchen\nlength 15\nmaximize {call}(rho > 0)\n"
        checked = check_source(Source("s", text), find_vocabulary, tmp_path)
        assert isinstance(checked, TypedStory)
        assert checked.objective[0][1] == direct


def test_imports_that_are_wrong(tmp_path: Path) -> None:
    (tmp_path / "self.story").write_text("import self\npattern p(x) = x\n")
    (tmp_path / "ping.story").write_text("import pong\npattern p(x) = x\n")
    (tmp_path / "pong.story").write_text("import ping\npattern q(x) = x\n")
    (tmp_path / "tale.story").write_text("world kitchen\nlength 3\nmaximize 1\n")
    (tmp_path / "packed.i2plib").write_bytes(b"\x00")
    rest = "world kitchen\nlength 15\nmaximize 1\n"
    for name in ("self", "ping", "packed", "nowhere", '"../../nowhere"', f'"{"x" * 5000}"'):
        assert codes(f"import {name}\n{rest}", tmp_path) == ["import"]
    assert codes(f"import tale\n{rest}", tmp_path) == ["import"] * 3
    many = "".join(f'import "{"./" * i}ping.story"\n' for i in range(50))
    assert set(codes(many + rest, tmp_path)) == {"import"}


def test_libraries_and_stories() -> None:
    for text in ("let x = 1", "pattern p(x) = x", "import depict", "let x = 1\nimport depict"):
        assert isinstance(check_source(Source("l", text), find_vocabulary), Library)
    assert codes("let x = 1\nlength 5") == ["no-world"]
    assert codes("let x = 1\nworld kitchen\nlength 5") == ["no-objective"]
    assert codes("world kitchen\nmaximize 1") == ["no-length"]
    assert codes("") == ["empty"]
    naive = check_source(Source("n", "world kitchen\nlength 5\nsearch naive"), find_vocabulary)
    assert isinstance(naive, TypedStory)
    assert (naive.objective, naive.search.method) == ((), "naive")


def test_world_settings_and_hypotheses() -> None:
    text = "world kitchen(hypotheses = literal, beta = 1)\nlength 5\nmaximize depict(rho > 0)"
    checked = check_source(Source("s", text), find_vocabulary)
    assert isinstance(checked, TypedStory)
    assert checked.settings == (("beta", 1.0), ("hypotheses", "literal"))
    assert len(checked.vocabulary.hypotheses) == len(checked.assumption) == 72


def test_a_world_beside_the_story(tmp_path: Path) -> None:
    (tmp_path / "hall.world").write_text("map\n    ...\n    .#.\ncharacter a\ncharacter b\n")
    text = 'world "hall.world"\nlength 5\nmaximize sum_t [adjacent(a, b) @ script[t]]'
    checked = check_source(Source("s", text), find_vocabulary, tmp_path)
    assert isinstance(checked, TypedStory)
    assert checked.vocabulary.characters == ("a", "b")
    assert codes(text) == ["no-world"]
    assert codes('world "kitchen?hypotheses=literal"\nlength 5\nmaximize 1') == ["no-world"]
    assert codes(f'world "{"x" * 5000}"\nlength 5\nmaximize 1') == ["no-world"]


def test_start_conditions_that_no_state_fulfils() -> None:
    def start(condition: str) -> list[str]:
        return codes(f"world kitchen\nlength 5\nstart {condition}\nmaximize 1")

    assert start("at(robot, (0, 0)) and at(cheese, (0, 0))") == ["impossible"]
    assert start("absent(table) and at(table, pink)") == ["impossible"]
    assert start("adjacent(robot, cheese) and not adjacent(cheese, robot)") == ["impossible"]
    assert start("at(robot, pink) and at(robot, green)") == ["impossible"]
    for possible in (
        "absent(table)",
        "at(robot, pink) and adjacent(robot, cheese)",
        "not absent(table) and not at(table, pink)",
        "at(robot, pink) or absent(table)",
    ):
        story("1", f"start {possible}")


def test_empty_sums_are_zero_and_other_empty_ranges_mistakes() -> None:
    assert objective("sum_{t in 2..T} P(rho > 0 | script[:t])", length=1) == ty.Constant(0.0)
    for text in ("mean_{t in 2..T} t", "sum_{t in 3..T} t"):
        assert codes(f"world kitchen\nlength 1\nmaximize {text}") == ["range"]


@pytest.mark.parametrize(
    ("text", "times"),
    [
        ("P(rho > 0 | script[:t])", range(6)),
        ("P(G_robot | script[:t])", range(6)),
        ("script_t", None),
        ("P(rho > 0 | script[:T])", None),
        ("sum_t P(rho > 0 | script[:t])", None),
        ("surprise(script[t])", range(1, 6)),
        ("KL(script[:t-1] || script[:t])", range(1, 6)),
        ("[moved(robot) @ script[t]]", range(1, 6)),
        ("if t > 0 then surprise(script[t]) else 0", range(6)),
        ("if t > 1 then P(rho > 0 | script[:t-2]) else 1", range(6)),
        ("P(rho > 0 | script[:t]) > 0.5", range(6)),
        ("t / T", range(6)),
        ("P(rho > 0 | (script ++ [cheese: stay, robot: east])[:t+1])", range(6)),
    ],
)
def test_the_frames_of_a_query(text: str, times: range | None) -> None:
    if text == "script_t":
        with pytest.raises(StoryError):
            query(text)
        return
    assert query(text).times == times


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("P(rho > 0 | script[:t+1])", "index"),
        ("P(rho > 0 | script[:t-2])", "index"),
        ("surprise(script[t+1])", "index"),
        ("1 / t", "arithmetic"),
        ("script[:t]", "type"),
        ("G_robot", "type"),
        ("P(G_robot | script[:t]) + 1", "type"),
        ("", "syntax"),
        ("1\n2", "syntax"),
        ("(1", "bracket"),
    ],
)
def test_queries_that_are_wrong(text: str, code: str) -> None:
    with pytest.raises(StoryError) as caught:
        query(text)
    assert [d.code for d in caught.value.diagnostics] == [code]


def test_query_over_an_empty_script() -> None:
    assert query("P(rho > 0 | script[:t])", 0).times == range(1)
    assert query("surprise(script[t])", 0).times == range(1, 1)
    assert query("T", 0).value == ty.Constant(0.0)


def test_query_with_another_assumption() -> None:
    assert KITCHEN is not None
    module = Module(Source("none", ""))
    source = Source("query", "P(R_robot | script[:t])")
    value = check_query(source, KITCHEN, module, 5, assume=Source("a", "nothing"))
    assert value.warnings == ()
    with pytest.raises(StoryError):
        check_query(source, KITCHEN, module, 5, assume=Source("a", "rho > 7"))


def frames(text: str, length: int = 10) -> tuple[list[int], int | None]:
    value = objective(f"sum_t P(rho > 0 | script[:{text}])", length=length)
    assert isinstance(value, ty.Reduction)
    assert isinstance(value.body, ty.Belief)
    moment = value.body.given[0].moment
    return list(moment.frames), moment.offset


@pytest.mark.parametrize(
    ("index", "expected", "offset"),
    [
        ("t", lambda t: t, 0),
        ("t-1", lambda t: t - 1, -1),
        ("(2*t - t) - 1", lambda t: t - 1, -1),
        ("T-t", lambda t: 10 - t, None),
        ("t/1", lambda t: t, 0),
        ("abs(t-5)", lambda t: abs(t - 5), None),
        ("if t > 5 then t-5 else t", lambda t: t - 5 if t > 5 else t, None),
        ("min(t, 3)", lambda t: min(t, 3), None),
        ("t*t - t*t + 4", lambda t: 4, None),
    ],
)
def test_indices_are_evaluated_at_every_t(index: str, expected: object, offset: int | None) -> None:
    assert callable(expected)
    assert frames(index) == ([expected(t) for t in range(1, 11)], offset)


def test_tables_agree_with_evaluation_at_each_t() -> None:
    text = (
        "sin(t/T * 3*pi) + points((0, 0), (0.3, 1), (1, -1)) * (if 2 < t <= 5 or t = 7 then t ^ 2 "
        "else if not t > 3 and t != 1 then -t else exp(-t)) / max(t, 3, T - t)"
    )
    value = objective(f"sum_t ({text}) * P(rho > 0 | script[:t])")
    assert isinstance(value, ty.Reduction)
    assert isinstance(value.body, ty.Apply)
    table = value.body.arguments[0]
    assert isinstance(table, ty.TimeTable)
    for t in range(1, 16):
        at_t = re.sub(r"\bt\b", str(t), re.sub(r"points\(.*?\)\)", str(curve(t / 15)), text))
        one = objective(at_t)
        assert isinstance(one, ty.Constant)
        assert table.values[t - 1] == pytest.approx(one.value)


def curve(x: float) -> float:
    """The curve of the test above, by hand."""
    return x / 0.3 if x <= 0.3 else 1 - 2 * (x - 0.3) / 0.7


def test_a_world_without_latents_named_so() -> None:
    """The same pattern text serves any world where it names nothing of a world."""
    assert KITCHEN is not None
    renamed = replace(
        KITCHEN,
        characters=("hen", "fox"),
        rational={"hen": "R_cheese", "fox": "R_robot"},
        can_fail=frozenset(("hen",)),
    )

    def find(name: str, folder: Path | None) -> Vocabulary:
        return renamed

    checked = check_source(Source("s", "world farm\nlength 5\nmaximize arc(fox)"), find)
    assert isinstance(checked, TypedStory)
    walked = list(ty.walk(checked.objective[0][1]))
    assert [n.who for n in walked if isinstance(n, ty.ValueAt)] == [1]
