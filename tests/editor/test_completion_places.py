"""What is offered at chosen places. `¦` is the cursor; `|` belongs to the language."""

from __future__ import annotations

from pathlib import Path

import pytest

from i2pdsl.editor.complete import Completion, Surroundings, complete, surroundings
from i2pdsl.errors import Source
from i2pdsl.language.builtins import STATEMENT_WORDS
from i2pdsl.language.scope import Module
from i2pdsl.worlds.find import builtin_worlds, find_vocabulary

ROOT = Path(__file__).parents[2]
KITCHEN = """world kitchen
length 15
let shown = script ++ [cheese: stay, robot: east]
let helpful = rho > 0
let n = 3
pattern show(event, over = script, scale = 1) = scale * sum_t P(event | over[:t])
"""
HILL = "world hill(weight = 0.5)\nlength 100\n"
LATENTS = "rho G_cheese G_robot R_cheese R_robot"
SCRIPTS = "script shown"
SIGNS = ("operator", "sign", "bracket")


def offered(marked: str, before: str = KITCHEN, start: str = "file") -> list[Completion]:
    text, _, after = (before + marked).partition("¦")
    full = text + after
    around = surroundings(Source("own.story", full), ROOT / "nowhere", find_vocabulary)
    return complete(full, len(text), around, start)


def words(found: list[Completion]) -> set[str]:
    """What is offered but signs and the patterns of the standard library."""
    return {
        c.text.removesuffix(" = ")
        for c in found
        if c.kind not in SIGNS and (c.kind != "pattern" or c.text == "show")
    }


THREE = "world court\nlength 5\n"
OF_THREE = {
    "maximize P(rho_¦": "rho_knight_princess rho_ghost_princess rho_ghost_knight",
    "maximize P(rho_ghost_knight = ¦": "-2 2 0",
    "pin script[2] = [princess: west, ¦": "knight ghost",
    "let x = script ++ [princess: stay, knight: west, ¦": "ghost",
    "maximize P(rho_ghost_knight > 0 | script[:t, ¦": "princess knight ghost",
}


@pytest.mark.parametrize("marked", OF_THREE)
def test_the_words_of_a_world_with_three(marked: str) -> None:
    assert words(offered(marked, THREE)) == set(OF_THREE[marked].split())


SEEN = "at absent adjacent touching sees distance"
EXACT = {
    # Values of latents.
    "maximize P(G_cheese = ¦": "pink green",
    "maximize P(G_cheese != ¦": "pink green",
    "maximize P(G_robot = ¦": "pink green none",
    "maximize P(G_robot = p¦": "pink",
    "maximize P(rho > 0 and G_cheese = ¦": "pink green",
    "maximize P(not G_cheese = ¦": "pink green",
    "maximize P((G_cheese = ¦": "pink green",
    "maximize P(rho in {¦": "-3 -1 0 1 3 n",
    "maximize P(rho in {1, ¦": "-3 -1 0 3 n",
    "maximize P(G_robot in {none, ¦": "pink green",
    "maximize P(rho > ¦": "-3 -1 0 1 3 n",
    "maximize P(rho = -¦": "3 1 n",
    "maximize P(-1 < rho <= ¦": "-3 -1 0 1 3 n",
    "maximize P(R_robot = ¦": "",
    "maximize P(G_cheese < ¦": "",
    "maximize show(G_cheese = ¦": "pink green",
    "maximize show(rho < ¦": "-3 -1 0 1 3 n",
    "maximize irony(G_cheese = green, G_cheese = ¦": "pink green",
    "maximize P(rho > 0 | script[:t], G_cheese = ¦": "pink green",
    # Events.
    "maximize P(¦": f"{LATENTS} helpful not",
    "maximize sum_t P(¦": f"{LATENTS} helpful not",
    "maximize P(rho > 0 and ¦": f"{LATENTS} helpful not",
    "maximize P(not ¦": f"{LATENTS} helpful not",
    "maximize P((¦": f"{LATENTS} helpful not",
    "maximize P(R_¦": "R_cheese R_robot",
    "maximize P(g_¦": "G_cheese G_robot",
    "assume ¦": f"{LATENTS} helpful not nothing",
    "assume R_cheese and ¦": f"{LATENTS} helpful not nothing",
    "maximize show(¦": f"event over scale {LATENTS} helpful not",
    "maximize show(event = ¦": f"{LATENTS} helpful not",
    # Scripts.
    "maximize P(rho > 0 | ¦": SCRIPTS,
    "maximize P(rho > 0 | sh¦": "shown",
    "maximize E[V(robot) | ¦": SCRIPTS,
    "maximize P(rho > 0 | (¦": SCRIPTS,
    "maximize P(rho > 0 | script[:t], ¦": f"{LATENTS} helpful not",
    "maximize P(rho > 0 | (script ++ [cheese: stay, robot: east])[:t], ¦": f"{LATENTS} helpful not",
    "maximize P(rho > 0 | rho < 3, ¦": f"{LATENTS} helpful not {SCRIPTS}",
    "maximize KL(¦": f"{LATENTS} helpful {SCRIPTS} others",
    "maximize KL(rho; ¦": SCRIPTS,
    "maximize KL(script[:t-1] || ¦": SCRIPTS,
    "maximize KL(script[:t-1] || script[:t], ¦": f"{LATENTS} helpful not",
    "maximize entropy(¦": f"{LATENTS} helpful {SCRIPTS} others",
    "maximize entropy(rho | ¦": SCRIPTS,
    "maximize suspense(¦": f"{LATENTS} helpful",
    "maximize suspense(rho, ¦": "",
    "maximize P(G_cheese, ¦": f"{LATENTS} helpful",
    "maximize P(G_cheese, rho | ¦": SCRIPTS,
    "maximize P(rho > 0 | script[:3, ¦": "cheese robot",
    "maximize KL(script[:3] || script[:3, r¦": "robot",
    "maximize surprise(¦": SCRIPTS,
    "let x = last(¦": SCRIPTS,
    "maximize [moved(robot) @ ¦": SCRIPTS,
    "maximize show(rho > 0, over = ¦": SCRIPTS,
    "maximize show(rho > 0, ¦": f"over scale {SCRIPTS}",
    # The cast, what it does, and what is seen.
    "maximize E[V(¦": "cheese robot",
    "maximize arc(who = ¦": "cheese robot",
    "maximize [¦": f"{SEEN} pushes moved tried fell idle faces not",
    "maximize [not ¦": f"{SEEN} pushes moved tried fell idle faces not",
    "maximize [at(¦": "cheese robot table",
    "maximize [at(robot, ¦": "pink green",
    "maximize [pushes(¦": "cheese robot",
    "maximize [pushes(robot, ¦": "cheese robot table",
    "maximize [absent(¦": "table",
    "start ¦": f"{SEEN} not",
    "start absent(table) and ¦": f"{SEEN} not",
    "start at(robot, ¦": "pink green",
    "let s = script ++ [¦": "cheese robot deus",
    "let s = script ++ [cheese: ¦": "north south east west stay",
    "let s = script ++ [cheese: west, ¦": "robot",
    "let s = script ++ [cheese: west!, robot: s¦": "south stay",
    "let s = script ++ [deus: ¦": "table",
    "let s = script ++ [deus: table ¦": "at",
    "let s = script ++ [deus: table at ¦": "pink green",
    "allow ¦": "deus",
    "allow deus(¦": "table",
    "maximize P(rho > 0 @ ¦": "script shown",
    "maximize P(rho > 0 @ script[¦": "n T last",
    # Time.
    "maximize sum_{¦": "t",
    "maximize sum_{t ¦": "in",
    "maximize sum_{t in 1..¦": "n T last",
    "maximize sum_t P(rho > 0 | script[:¦": "n t T last",
    "maximize P(rho > 0 | script[:¦": "n T last",
    "maximize [moved(robot) @ script[¦": "n T last",
    # Statements and their settings.
    "world ¦": " ".join(builtin_worlds()),
    "audience ¦": "bayesian particles average",
    "audience bayesian(¦": "beta forgetting given level0 prior sharpness switching",
    "audience bayesian(beta = 1, ¦": "forgetting given level0 prior sharpness switching",
    "audience bayesian(beta = ¦": "2",
    "audience bayesian(level0 = ¦": "uniform costs",
    "audience bayesian(switching = ¦": "0",
    "audience bayesian(prior(¦": "G_cheese G_robot R_cheese R_robot helpful rho",
    "audience bayesian(prior(G_robot) = {¦": "green none pink others",
    "audience bayesian(prior(rho) = {-3: 1, ¦": "-1 0 1 3 others",
    "audience bayesian(prior(R_robot) = {¦": "true false others",
    "audience bayesian(prior(rho) = {-3: ¦": "",
    "audience average(¦": "bayesian particles average",
    "audience average(bayesian(¦": "beta forgetting given level0 prior sharpness switching",
    "search ¦": "beam naive",
    "search beam(¦": "polish starts width",
    "search beam(starts = ¦": "500",
    "search beam(starts = 3, ¦": "polish width",
    "search naive(¦": "",
    "let ¦": "",
    "pattern ¦": "",
    "pattern mine(¦": "",
    "length ¦": "",
    # Nowhere.
    "maximize 1¦5": "",
    "maximize 0.¦": "",
    "maximize 0.5¦": "",
    "# maximize P(¦": "",
    "maximize P(rho > 0 # ¦": "",
    'world "ki¦': "",
}


@pytest.mark.parametrize("place", EXACT)
def test_exactly_these_words_are_offered(place: str) -> None:
    assert words(offered(place)) == set(EXACT[place].split())


OF_KITCHEN = (
    "goal move stay end gamma level0 forgetting switching horizon method at_once states hypotheses"
)
IN_WORLDS = {
    "world kitchen(¦": "beta " + OF_KITCHEN,
    "world kitchen(beta = 1, ¦": OF_KITCHEN,
    "world kitchen(beta = ¦": "2",
    "world kitchen(hypotheses = ¦": "merged literal",
    "world kitchen(method = ¦": "auto exact additive",
    "world hill(evidence = ¦": "motion mass",
    "world hill(weight = ¦": "0.1",
    "world hill(will = ¦": "eager lazy",
    "world hill(lazy = 0.15)\nlength 9\nmaximize P(will = ¦": "eager lazy",
    "world kit¦": "kitchen",
}


@pytest.mark.parametrize("place", IN_WORLDS)
def test_the_settings_of_worlds(place: str) -> None:
    assert words(offered(place, before="")) == set(IN_WORLDS[place].split())


ON_THE_HILL = {
    "maximize P(¦": "weight not",
    "maximize P(weight = ¦": "0.1 0.5",
    "maximize [¦": "fallen taut climbed progress effort not",
    "maximize [progress(¦": "hopper box",
    "search ¦": "descend naive",
    "search naive(¦": "noise",
    "search descend(optimiser = ¦": "adam lbfgs ncg",
}


@pytest.mark.parametrize("place", ON_THE_HILL)
def test_another_world_has_other_words(place: str) -> None:
    assert words(offered(place, before=HILL)) == set(ON_THE_HILL[place].split())


SOME = {  # place: (must be there, must not be there)
    "maximize ¦": ("sum_t P E KL n show if", "rho t V script shown helpful cheese pink world"),
    "maximize sum_t ¦": ("t T P E n", "sum_t rho script"),
    "maximize sum_t (P(rho > 0 | script[:t]) + ¦": ("P t", "sum_t"),
    "maximize (sum_t t) + ¦": ("P sum_t", "t"),
    "maximize E[¦": ("V rho n if", "P sum_t script G_cheese"),
    "maximize sum_t (if ¦": ("t T n not P", "rho sum_t"),
    "maximize sum_t (if t < 5 ¦": ("then and or", "else rho"),
    "maximize sum_t (if t < 5 then 1 ¦": ("else", "then"),
    "maximize P(rho ¦": ("in and or", "then rho"),
    "audience bayesian(prior = ¦": ("rho if", "P script"),
    "audience bayesian(prior = if ¦": ("rho R_robot not", "P script"),
    "let x = ¦": ("P sum_t script rho t n V", "x world"),
    "pattern mine(a, b = 2) = a * ¦": ("a b P sum_t t", "mine"),
    "pattern mine(a, b = ¦": ("a P sum_t T", "mine"),
    "pattern mine(a) = sum_t P(¦": ("a rho not", "P script"),
    "pattern mine(a) = sum_t P(rho > 0 | ¦": ("a script shown", "rho P"),
    "maximize arc(robot, shape = ¦": ("t T sin pi points", "rho script"),
    "maximize rubbish rubbish P(G_cheese = ¦": ("pink green", "P rho"),
    "maximize P(rho rho | ¦": ("script shown", "rho P"),
    "maximize show(rho rho, over = script[:¦": ("t T", "rho"),
    "maximise P(¦": ("rho helpful", "P script"),
    "maximize (¦": ("P sum_t n", "rho"),
    "maximize twist(rho > 0, rho < 0, turn = ¦": ("T n", "rho pink"),
    "maximize KL(rho; script[:t-1] ¦": ("", "in and or rho"),
}


@pytest.mark.parametrize("place", SOME)
def test_these_words_are_offered_and_those_are_not(place: str) -> None:
    required, forbidden = (set(part.split()) for part in SOME[place])
    found = words(offered(place))
    assert required <= found
    assert not forbidden & found


NAMED = "audience insider = bayesian(given = G_cheese = pink)\n"


def test_audiences_are_offered_where_a_belief_can_name_them() -> None:
    def found(marked: str) -> set[str]:
        return {c.text for c in offered(marked, KITCHEN + NAMED)}

    for marked in ("maximize P[¦", "maximize sum_t entropy[¦", "maximize shared_secret(¦"):
        assert found(marked) >= {"insider", "viewers"}
        assert not found(marked) & {"rho", "P"}
    assert found("maximize E[¦") >= {"insider", "rho", "V"}
    assert "insider" not in found("maximize E[rho + ¦")
    assert found("maximize P[insider](¦") >= {"rho", "G_cheese", "not"}
    assert "[" in found("maximize P¦")
    assert "[" not in {c.text for c in offered("maximize P¦")}
    assert found("maximize E[insider][¦") >= {"V", "rho"}
    assert found("maximize E[insider][rho | ¦") >= {"script"}
    assert found("audience other = ¦") == {"bayesian", "particles", "average"}
    on_the_hill = words(offered("audience ¦", HILL))
    assert "bayesian" in on_the_hill
    assert "particles" not in on_the_hill
    assert found("audience other = bayesian(given = ¦") >= {"rho", "G_cheese", "not"}
    assert "=" in found("audience other ¦")
    assert "insider" not in found("maximize ¦")


def signs(marked: str) -> set[str]:
    return {c.text for c in offered(marked) if c.kind in SIGNS}


def test_signs_follow_finished_words() -> None:
    assert {">", "=", ")", "|", "<="} <= signs("maximize P(rho¦")
    assert "(" not in signs("maximize P(rho¦")
    assert "(" in signs("maximize show¦")
    assert "++" in signs("let x = script¦")
    assert "++" not in signs("maximize n¦")
    assert signs("let s = script ++ [cheese: west¦") == {"!", ",", "]"}
    assert signs("let s = script ++ [robot: west¦") == {",", "]"}
    assert signs("let s = script ++ [cheese: stay¦") == {",", "]"}
    assert signs("let s = script ++ [deus: table at (1, 3)¦") >= {"]"}
    assert signs("maximize sum_{t in 1¦") >= {".."}
    assert signs("maximize P(ro¦") == set()


def test_statements_in_the_first_column() -> None:
    found = words(offered("¦"))
    assert found == set(STATEMENT_WORDS) - {"world", "length"}
    assert words(offered("ma¦")) == {"maximize"}
    assert "world" in words(offered("¦", before=""))
    assert "world" in words(offered("¦", before="\nlength 3\n"))
    # A word that stands there already does not hide itself.
    assert "world" in words(offered("wor¦ld kitchen\nlength 3\n", before=""))


def test_inside_brackets_a_line_may_go_on_in_the_first_column() -> None:
    found = words(offered("maximize P(\n¦"))
    assert {"rho", "helpful", "let", "maximize"} <= found


def test_a_line_that_is_indented_goes_on() -> None:
    assert words(offered("maximize\n    P(G_cheese =\n    ¦")) == {"pink", "green"}


def test_named_arguments_bring_their_equals_sign() -> None:
    texts = [c.text for c in offered("maximize show(rho > 0, o¦")]
    assert "over = " in texts
    texts = [c.text for c in offered("maximize show(rho > 0, o¦ = script)")]
    assert "over" in texts
    assert [c.text for c in offered("search beam(w¦")][:1] == ["width = "]


def test_the_world_comes_first() -> None:
    found = [c.text for c in offered("maximize P(¦")]
    assert found[:5] == LATENTS.split()
    found = [c.text for c in offered("maximize show(¦")]
    assert found[:5] == LATENTS.split()
    assert "over = " in found[5:]
    assert [c.text for c in offered("maximize P(G_cheese = ¦")] == ["pink", "green"]


def test_what_begins_in_the_same_case_comes_first() -> None:
    found = [c.text for c in offered("maximize P¦")]
    assert found[0] == "P"


def test_completions_say_what_they_are() -> None:
    by_text = {c.text: c for c in offered("maximize P(¦")}
    rho = by_text["rho"]
    assert (rho.kind, rho.detail) == ("latent", "rho in {-3, -1, 0, 1, 3}")
    assert "attitude toward cheese" in rho.documentation
    assert by_text["helpful"].detail == "helpful = rho > 0"
    by_text = {c.text: c for c in offered("maximize ¦")}
    assert by_text["P"].detail == "P(event | script[:k], condition, ...)"
    assert by_text["show"].detail == "show(event, over = script, scale = 1)"
    assert by_text["sum_{"].documentation == by_text["sum_t"].documentation != ""
    (beta,) = [c for c in offered("world kitchen(be¦", before="") if c.text == "beta = "]
    assert "between 0 and 1000" in beta.documentation


def test_the_range_is_the_word_before_the_cursor() -> None:
    (found,) = [c for c in offered("maximize P(hel¦pful | script[:1])") if c.kind == "let"]
    start = len(KITCHEN) + len("maximize P(")
    assert (found.text, found.start, found.end) == ("helpful", start, start + 3)


def test_in_an_expression_t_is_free() -> None:
    vocabulary = find_vocabulary("kitchen")
    around = Surroundings(vocabulary, Module(Source("", "")))
    for text in ("", "P(rho > 0 | script[:"):
        assert "t" in {c.text for c in complete(text, len(text), around, "expression")}
    found = complete("P(G_cheese = ", 13, around, "expression")
    assert [c.text for c in found] == ["pink", "green"]
    # A statement's word has no place in an expression.
    assert "world" not in {c.text for c in complete("", 0, around, "expression")}


def test_without_a_world_its_words_are_unknown(tmp_path: Path) -> None:
    text = "pattern mine(a) = sum_t P("
    around = surroundings(Source("lib.story", text), tmp_path, find_vocabulary)
    assert around.vocabulary is None
    found = {c.text for c in complete(text, len(text), around)}
    assert "a" in found
    assert "rho" not in found


def test_libraries_and_worlds_beside_the_file(tmp_path: Path) -> None:
    (tmp_path / "mine.story").write_text("pattern a(x) = x\n", encoding="utf-8")
    (tmp_path / "other.story").write_text("# note\nlet y = 3\n", encoding="utf-8")
    (tmp_path / "own.story").write_text("let z = 3\n", encoding="utf-8")
    (tmp_path / "a-story.story").write_text("world kitchen\nlength 3\n", encoding="utf-8")
    (tmp_path / "tale.story").write_text("world kitchen\nlet n = 3\n", encoding="utf-8")
    (tmp_path / "packed.i2plib").write_bytes(b"")
    (tmp_path / "empty").mkdir()
    (tmp_path / "many").mkdir()
    (tmp_path / "many" / "one.story").write_text("let y = 3\n", encoding="utf-8")
    kitchen = (ROOT / "stories" / "worlds" / "kitchen.world").read_text(encoding="utf-8")
    (tmp_path / "larder.world").write_text(kitchen.replace("pink", "red"), encoding="utf-8")
    source = Source(str(tmp_path / "own.story"), "import ")
    around = surroundings(source, tmp_path, find_vocabulary)
    found = [c.text for c in complete("import ", 7, around)]
    assert found[:4] == ["many", "mine", "other", "packed"]
    assert "depict" in found[4:]
    assert not {"own", "tale", "empty"} & set(found)
    assert "larder" in {c.text for c in complete("world ", 6, around)}
    text = "world larder\nmaximize P(G_cheese = "
    around = surroundings(Source("x.story", text), tmp_path, find_vocabulary)
    assert [c.text for c in complete(text, len(text), around)] == ["red", "green"]


def test_imported_names_are_offered(tmp_path: Path) -> None:
    (tmp_path / "mine.story").write_text(
        "# What it does.\npattern lovely(who, turn = T) = [moved(who) @ script[turn]]\n",
        encoding="utf-8",
    )
    text = "world kitchen\nimport mine\nmaximize lovely("
    around = surroundings(Source("x.story", text), tmp_path, find_vocabulary)
    found = {c.text: c for c in complete(text, len(text), around)}
    assert set(found) == {"who = ", "turn = ", "cheese", "robot"}
    (pattern,) = complete(text, len(text) - 1, around)[:1]
    assert (pattern.text, pattern.documentation) == ("lovely", "What it does.")


def test_a_world_with_other_values(tmp_path: Path) -> None:
    text = "world hill(weights = {0.2, 0.4, 0.8})\nlength 10\nmaximize P(weight = "
    around = surroundings(Source("x.story", text), tmp_path, find_vocabulary)
    assert [c.text for c in complete(text, len(text), around)] == ["0.2", "0.4", "0.8"]


def test_what_is_asked_of_all_frames_needs_no_frame() -> None:
    def found(line: str) -> set[str]:
        text = f"world kitchen\n{line}"
        around = surroundings(Source("x.story", text), None, find_vocabulary)
        return {c.text for c in complete(text, len(text), around)}

    assert {"never", "eventually", "when", "P", "["} <= found("require ")
    assert found("require never ") == found("require [moved(robot)] before ") == {"["}
    assert {"moved", "pushes", "at"} <= found("require eventually [")
    assert "@" not in found("require eventually [moved(robot)")
    assert {"@", "]"} <= found("require [moved(robot)")
    assert found("require [moved(robot)] bef") == {"before"}
    assert {"when"} <= found("maximize twist(rho > 0, rho < 0, turn = ")


def test_pins() -> None:
    def found(line: str) -> set[str]:
        text = f"world kitchen\n{line}"
        around = surroundings(Source("x.story", text), None, find_vocabulary)
        return {c.text for c in complete(text, len(text), around)}

    assert "script" in found("pin ")
    assert {"at", "moved"} <= found("pin script[4]: ")
    assert {"cheese", "robot"} <= found("pin script[4] = [")
    assert "south" in found("pin script[4] = [robot: ")


def test_what_somebody_believes_is_offered_where_somebody_may_be_wrong() -> None:
    asked = "maximize depict("
    farm, kitchen = "world farm\nlength 5\n", "world kitchen\nlength 5\n"
    assert "believes" in words(offered(f"{asked}¦", farm))
    assert "believes" not in words(offered(f"{asked}¦", kitchen))
    assert {"dog", "duck"} <= words(offered(f"{asked}believes(¦", farm))
    assert "G_duck" in words(offered(f"{asked}believes(dog, ¦", farm))
    assert "believes" not in words(offered("maximize sum_t ¦", farm))
