"""What parameters are, inferred from their places, against what their authors say of them."""

from __future__ import annotations

import time

import pytest

from i2pdsl.errors import Source
from i2pdsl.language import ast
from i2pdsl.language.builtins import FUNCTIONS
from i2pdsl.language.imports import build_module
from i2pdsl.language.kinds import PARAMETER_KINDS, parameter_kinds, result_kind, used_names
from i2pdsl.language.parse import parse
from i2pdsl.language.scope import Module, standard_library

STANDARD = {
    "arc": "who character, shape shape, scale number, steady number",
    "cinderella": "who character, scale number, steady number",
    "deceptive": "who character, truth event, decoy event, scale number",
    "depict": "event event, over script",
    "flashback": "event event, shown script, picture predicate",
    "foreshadowing": "event event, hint frame, comes frame",
    "icarus": "who character, scale number, steady number",
    "irony": "truth event, mistaken event, meant event, done event",
    "legible": "event event",
    "man_in_a_hole": "who character, scale number, steady number",
    "mystery": "latent latent",
    "oedipus": "who character, scale number, steady number",
    "rags_to_riches": "who character, scale number, steady number",
    "red_herring": "event event, dropped frame",
    "reveal": "event event, moment frame",
    "riches_to_rags": "who character, scale number, steady number",
    "shared_secret": "friend audience, foe audience, event event",
    "surprising": "event event",
    "suspenseful": "latent latent",
    "twist": "before event, after event, turn frame",
}


def kinds(text: str, name: str = "p") -> str:
    """The kinds of a pattern's parameters, in words."""
    found = module(text).names[name]
    assert isinstance(found.item, ast.Pattern)
    return ", ".join(f"{n} {k}" for n, k in parameter_kinds(found.item, found.module).items())


def module(text: str) -> Module:
    return build_module(parse(Source("test", text)), lambda _: None, None)


@pytest.mark.parametrize("name", sorted(STANDARD))
def test_standard_patterns(name: str) -> None:
    """Parameters that were added later may have any kind; those above keep theirs."""
    found = standard_library().names[name]
    assert isinstance(found.item, ast.Pattern)
    inferred = parameter_kinds(found.item, found.module)
    expected = dict(pair.split() for pair in STANDARD[name].split(", "))
    assert expected.items() <= inferred.items()
    assert result_kind(found.item, found.module) == "number"
    known = {*standard_library().names, *FUNCTIONS, "pi"}
    assert used_names(found.item, found.module) <= known, "it names nothing of a world"


def test_every_standard_parameter_has_a_kind() -> None:
    for found in standard_library().names.values():
        assert isinstance(found.item, ast.Pattern)
        for name, kind in parameter_kinds(found.item, found.module).items():
            assert kind in PARAMETER_KINDS, f"{name} of {found.item.name.id}"
            assert kind != "any", f"{name} of {found.item.name.id}"


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        ("p(e) = sum_t P(e | script[:t])", "e event"),
        ("p(e) = sum_t P(not e and rho > 0 | script[:t])", "e event"),
        ("p(given) = sum_t P(rho > 0 | script[:t], given)", "given event"),
        ("p(who) = sum_t E[V(who) | script[:t]]", "who character"),
        ("p(x) = sum_t entropy(x | script[:t])", "x latent"),
        ("p(x) = sum_t KL(x; script[:t-1] || script[:t])", "x latent"),
        ("p(x) = sum_t suspense(x | script[:t])", "x latent"),
        ("p(x, v) = sum_t P(x = v | script[:t])", "x latent, v value"),
        ("p(level) = sum_t P(rho > level | script[:t])", "level value"),
        ("p(x) = sum_t P(x > 0 | script[:t])", "x latent"),
        ("p(x) = sum_t P(x in {pink, green} | script[:t])", "x latent"),
        ("p(v) = sum_t P(G_cheese in {v, green} | script[:t])", "v value"),
        ("p(s) = sum_t P(rho > 0 | s[:t])", "s script"),
        ("p(k) = P(rho > 0 | script[:k + 1])", "k frame"),
        ("p(a, b) = sum_{t in a..b} t", "a frame, b frame"),
        ("p(a) = sum_t (if t < a then 1 else 0)", "a frame"),
        ("p(a) = sum_t (if t/T < a then 1 else 0)", "a number"),
        ("p(seen) = sum_t [seen @ script[t]]", "seen predicate"),
        ("p(w = t/T) = sum_t w * t", "w shape"),
        ("p(w = points((0, 0), (1, 1))) = sum_t w", "w shape"),
        ("p(w = 2) = sum_t w * t", "w number"),
        ("p(w) = max(w, 0)", "w number"),
        ("p(s = script) = last(s)", "s script"),
        ("p(nothing) = 1", "nothing any"),
        ("p(e = rho > 0) = 1", "e event"),
        # Passed on, by position and by name, through two patterns and with a default.
        ("p(e, who) = depict(e) + arc(who)", "e event, who character"),
        ("p(s, e) = depict(over = s, event = e)", "s script, e event"),
        ("p(s) = q(s)\npattern q(x) = arc(robot, shape = x)", "s shape"),
        ("p(e) = depict(not e or rho > 0)", "e event"),
        ("p(k) = twist(rho > 0, rho < 0, turn = k)", "k frame"),
        ("p(m) = P(rho > 0 | (script ++ [robot: east, cheese: stay])[:m])", "m frame"),
    ],
)
def test_a_place_tells_the_kind(pattern: str, expected: str) -> None:
    assert kinds(f"pattern {pattern}") == expected


def test_several_places_take_the_strictest() -> None:
    assert kinds("pattern p(k) = k * P(rho > 0 | script[:k])") == "k frame"
    assert kinds("pattern p(x) = sum_t (P(x > 0 | script[:t]) + entropy(x | script[:t]))") == (
        "x latent"
    )


def test_circles_and_wrong_calls_end() -> None:
    assert kinds("pattern p(e) = q(e)\npattern q(e) = p(e)") == "e any"
    assert kinds("pattern p(e) = depict(e, e, e, e)") == "e any"
    chain = "".join(f"pattern p{i}(e) = p{i + 1}(e)\n" for i in range(900))
    assert kinds(chain + "pattern p900(e) = depict(e)", "p850") == "e event"
    assert kinds(chain + "pattern p900(e) = depict(e)", "p0") in ("e any", "e event")


def test_doubling_patterns_are_read_once() -> None:
    """Put in, these would have 2^40 parts."""
    lines = [f"pattern p{i}(e) = p{i - 1}(e) + p{i - 1}(e)" for i in range(1, 40)]
    began = time.process_time()
    assert kinds("\n".join(["pattern p0(e) = depict(e)", *lines]), "p39") == "e event"
    assert time.process_time() - began < 2


@pytest.mark.parametrize(
    ("pattern", "result"),
    [
        ("p = sum_t P(rho > 0 | script[:t])", "number"),
        ("p = rho > 0 and G_cheese = pink", "event"),
        ("p = script ++ [robot: stay, cheese: stay]", "script"),
        ("p = t/T", "shape"),
        ("p = P(rho > 0 | script[:t])", "shape"),
        ("p = P(rho > 0 | script[:T])", "number"),
        ("p(k) = script[:k]", "first frames"),
        ("p(k) = script[k]", "one frame"),
        ("p = moved(robot)", "predicate"),
        ("p = q\nlet q = rho > 0", "event"),
        ("p = if T > 3 then 1 else t", "shape"),
        ("p = depict(rho > 0) - 1", "number"),
    ],
)
def test_results(pattern: str, result: str) -> None:
    found = module(f"pattern {pattern}").names["p"]
    assert result_kind(found.item, found.module) == result


def test_names_that_a_definition_uses() -> None:
    text = """
pattern own(who) = sum_t E[V(who) | script[:t], low]
let low = rho < 0
pattern seen(a) = sum_t [pushes(robot, a) @ over[t]]
let over = script ++ [cheese: stay, robot: east]
pattern free(x, scale = 2) = sum_t scale * sin(pi * t) * depict(x)
pattern inside = own(cheese) + depict(rho = 0) + depict(event = G_robot = none)
"""
    names = module(text)
    used = {n: used_names(d.item, d.module) for n, d in names.names.items()}
    assert used["own"] == {"low"}
    assert used["low"] == {"rho"}
    assert used["seen"] == {"pushes", "robot", "over"}
    assert used["over"] == {"cheese", "east", "robot", "stay"}
    assert used["free"] == {"sin", "pi", "depict"}
    assert used["inside"] == {"own", "cheese", "depict", "rho", "G_robot", "none"}
