"""What is offered at a place of a line: exact sets where they are finite."""

from __future__ import annotations

from pathlib import Path

import pytest

from i2pdsl.language.builtins import FUNCTIONS, STATEMENT_WORDS
from i2pdsl.language.scope import standard_library
from i2pdsl.repl.completing import complete_line
from i2pdsl.repl.session import Session
from i2pdsl.repl.words import COMMAND_WORDS
from i2pdsl.worlds.find import builtin_worlds
from worlds_for_tests import STORIES

LATENTS = {"rho", "G_cheese", "G_robot", "R_cheese", "R_robot"}
EVENTS = LATENTS | {"friend", "not", "("}
BUILTIN = set(builtin_worlds())
MOVES = {"north", "south", "east", "west", "stay"}
FAILING = {"north!", "south!", "east!", "west!"}
FORMS = {"P", "E", "KL", "entropy", "surprise", "suspense", "last"}
SUMS = {f"{word}_{end}" for word in ("sum", "mean", "min", "max") for end in ("t", "{")}
PATTERNS = {*standard_library().names, "often"}


@pytest.fixture(scope="module")
def session() -> Session:
    session = Session()
    for line in ("pattern often(x, k = 2) = k * sum_t P(x | script[:t])", "let friend = rho > 0"):
        assert not session.run(line).diagnostics
    return session


def offered(session: Session, line: str) -> set[str]:
    """What is offered where `‸` stands: at the end, without one."""
    text, _, rest = line.partition("‸")
    found = complete_line(text + rest, len(text), session.state)
    for each in found:
        assert 0 <= each.start <= each.end <= len(text + rest)
        typed = text[each.start :]
        assert each.text.lower().startswith(typed.lower())
    assert len({c.text for c in found}) == len(found), "something is offered twice"
    return {c.text for c in found}


@pytest.mark.parametrize(
    ("line", "found"),
    [
        # Commands.
        ("pl", {"plot", "play", "plausibility"}),
        ("sh", {"show", "shared_secret"}),
        ("so", {"solve"}),
        ("  un", {"undo", "unpin"}),
        ("h", {"help"}),
        ("q", {"quit"}),
        ("w", {"when", "why", "world"}),
        ("mini", {"minimize"}),
        # Their arguments.
        ("play ", {"cheese", "robot", "deus"}),
        ("play c", {"cheese"}),
        ("play [", {"cheese", "robot", "deus"}),
        ("play cheese ", MOVES | FAILING),
        ("play cheese: w", {"west", "west!"}),
        ("play robot ", MOVES),
        ("play robot s", {"south", "stay"}),
        ("play cheese west!, ", {"cheese", "robot", "deus"}),
        ("play cheese west, robot e", {"east"}),
        ("play deus ", {"table at ("}),
        ("play nobody ", set()),
        ("forget ", {"often", "friend"}),
        ("forget o", {"often"}),
        ("help KL", {"KL"}),
        ("help G_", {"G_cheese", "G_robot"}),
        ("help sug", {"suggest"}),
        ("accept ", set()),
        ("undo ", set()),
        ("quit ", set()),
        ("story ", set()),
        ("show ", set()),
        ("solve 1", set()),
        # Expressions behind commands.
        ("plot P(", EVENTS),
        ("plot P(rho > 0 | script[:t]), P(", EVENTS),
        ("plot P(rho > 0 | script[:t]), P(G_cheese = ", {"pink", "green"}),
        ("table P(G_robot = ", {"pink", "green", "none"}),
        ("table T, P(rho = ", {"-3", "-1", "0", "1", "3"}),
        ("suggest P(", EVENTS),
        ("suggest 3 P(", EVENTS),
        ("suggest of", {"often"}),
        ("suggest 12 of", {"often"}),
        ("plot T, of", {"often"}),
        # Questions.
        ("G_cheese =", {"pink", "green"}),
        ("P(G_cheese =", {"pink", "green"}),
        ("P(G_cheese = ‸)", {"pink", "green"}),
        ("P(G_cheese = p", {"pink"}),
        ("P(G_robot = ", {"pink", "green", "none"}),
        ("P(rho = ", {"-3", "-1", "0", "1", "3"}),
        ("P(rho > 0 | ", {"script", "("}),
        ("P(rho > 0 | scr", {"script"}),
        ("P(fr", {"friend"}),
        ("P(fr‸ | script[:t])", {"friend"}),
        ("E[V(", {"cheese", "robot"}),
        ("[at(", {"cheese", "robot", "table"}),
        ("[at(robot, ", {"pink", "green", "("}),
        ("script ++ [", {"cheese", "robot", "deus"}),
        ("script ++ [cheese: ", MOVES),
        ("entropy(", LATENTS | {"friend", "script", "others", "("}),
        ("sum_", {"sum_t", "sum_{"}),
        ("# P(", set()),
        # Statements.
        ("world ", BUILTIN),
        ("world kit", {"kitchen"}),
        ("audience ", {"average", "particles", "bayesian"}),
        ("search ", {"beam", "naive"}),
        ("assume ", EVENTS | {"nothing"}),
        ("start at(", {"cheese", "robot", "table"}),
        ("allow ", {"deus"}),
        ("allow deus(", {"table"}),
        ("length ", set()),
        ("maximize of", {"often"}),
        ("let x = P(G_cheese = ", {"pink", "green"}),
        ("pattern two(x) =\n    sum_t P(rho > 0 | scr", {"script"}),
    ],
)
def test_all_that_can_follow(session: Session, line: str, found: set[str]) -> None:
    assert offered(session, line) == found


@pytest.mark.parametrize("line", ["", "plot ", "suggest ", "suggest 2 ", "table T, "])
def test_expressions_begin_with_forms_sums_patterns_and_functions(
    session: Session, line: str
) -> None:
    found = offered(session, line)
    functions = set(FUNCTIONS) - {"pi", "others", "believes"}  # of latents, and of events
    assert found >= FORMS | SUMS | PATTERNS | functions | {"t", "T", "if"}
    assert not found & (MOVES | LATENTS | {"pink"})
    assert (set(COMMAND_WORDS) <= found) == (line == "")
    assert (set(STATEMENT_WORDS) <= found) == (line == "")


def test_everything_that_help_explains_is_offered(session: Session) -> None:
    found = offered(session, "help ")
    assert found >= {*COMMAND_WORDS, *STATEMENT_WORDS, *LATENTS, *PATTERNS, *FORMS, "pink", "deus"}


def test_files(session: Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("one.story", "other.json", "notes.txt", ".hidden.story"):
        (tmp_path / name).touch()
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "inside.story").touch()
    monkeypatch.chdir(tmp_path)
    assert offered(session, "load ") == {"one.story", "other.json", "folder/"}
    assert offered(session, "load o") == {"one.story", "other.json"}
    assert offered(session, "load .h") == {".hidden.story"}
    assert offered(session, "load folder/") == {"inside.story"}
    assert offered(session, "load nowhere/") == set()
    assert offered(session, f"load {tmp_path}/on") == {"one.story"}
    assert offered(session, "save n") == {"notes.txt"}
    assert offered(session, f"load {STORIES}/hill/m") == {"mime.story"}


def test_what_the_session_knows_is_offered() -> None:
    session = Session()
    assert offered(session, "P(bor") == set()
    session.run("let boring = rho = 0")
    assert offered(session, "P(bor") == {"boring"}
    session.run("world hill")
    assert offered(session, "P(weight = ") == {"0.1", "0.5"}
    assert offered(session, "E[V(") == {"hopper"}
    assert offered(session, "play ") == set()


def test_suggestions_can_be_accepted_by_number(session: Session) -> None:
    from dataclasses import replace

    from i2pdsl.repl.state import Suggestion

    new = Session()
    each = Suggestion("[cheese: stay, robot: east]", None, 1.0)  # type: ignore[arg-type]
    new.state = replace(session.state, suggestions=(each, each, each))
    assert offered(new, "accept ") == {"1", "2", "3"}
    assert offered(new, "accept 2") == {"2"}
