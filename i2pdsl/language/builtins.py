"""The words of the language in one table: signature, documentation, example.

The checker, the tables of docs/language.md, editors and the REPL's help all read it here.
"""

from __future__ import annotations

from dataclasses import dataclass

from i2pdsl.language.forms import BELIEFS, BY_NAME, Word


@dataclass(frozen=True)
class Function(Word):
    """A function of numbers, as in mathematics, or of what it `takes` instead; `arity` is (fewest,
    most) arguments. `first` is what the first of them is, if not that; `gives` is what it is."""

    arity: tuple[int, int] = (1, 1)
    takes: str = "number"
    first: str = ""
    gives: str = "number"

    def argument(self, number: int) -> str:
        """What one of the arguments is, from 0."""
        return self.first or self.takes if number == 0 else self.takes


def _function(
    name: str, signature: str, documentation: str, most: int = 1, fewest: int = 1
) -> Function:
    example = signature.replace("(x)", "(t/T)").replace("a, b, ...", "t, 3")
    return Function(name, signature, documentation, example, (fewest, most))


FUNCTIONS: dict[str, Function] = {
    f.name: f
    for f in (
        _function("sin", "sin(x)", "the sine, of radians"),
        _function("cos", "cos(x)", "the cosine, of radians"),
        _function("exp", "exp(x)", "the exponential"),
        _function("log", "log(x)", "the natural logarithm"),
        _function("sqrt", "sqrt(x)", "the square root"),
        _function("abs", "abs(x)", "the absolute value"),
        _function("min", "min(a, b, ...)", "the smallest", 99, 2),
        _function("max", "max(a, b, ...)", "the greatest", 99, 2),
        Function(
            "points",
            "points((x, y), (x, y), ...)",
            "a drawn arc: piecewise linear in t/T",
            "points((0, 0), (0.3, 1), (1, -1))",
            (2, 999),
        ),
        Function(
            "beats",
            "beats(a, b, ...)",
            "experiences in order, each a sum over t; the search chooses where each of them ends",
            "beats(depict(rho > 0), depict(rho < 0))",
            (2, 9),
        ),
        Function(
            "others",
            "others(event, ...)",
            "all latents but those that the events are about, where a latent stands",
            "KL(others(rho > 0); script[:T-1] || script[:T])",
            (1, 99),
            "event",
            gives="latents",
        ),
        Function(
            "believes",
            "believes(who, event)",
            "the event that somebody takes an event for true: of what another wants, or "
            "`at(object, tile)` of where something is",
            "P(believes(dog, G_duck = pond) | script[:T])",
            (2, 2),
            "event",
            first="character",
            gives="event",
        ),
    )
}

FORMS: tuple[Word, ...] = (
    Word("script", "script", "the story being made", "script[:t]"),
    Word("t", "t", "the current frame, 1 to T", "sum_t t/T"),
    Word("T", "T", "the number of frames of the story", "script[:T]"),
    Word("last", "last(script)", "the number of a script's last frame", "last(script)"),
    Word("sum_t", "sum_t e", "the sum of e over the frames 1..T", "sum_t P(rho > 0 | script[:t])"),
    Word("mean_t", "mean_t e", "the mean over the frames", "mean_t P(rho > 0 | script[:t])"),
    Word("min_t", "min_t e", "the least over the frames", "min_t P(rho > 0 | script[:t])"),
    Word("max_t", "max_t e", "the greatest over the frames", "max_t P(rho > 0 | script[:t])"),
    *BELIEFS,
    Word(
        "[ @ ]",
        "[predicate @ script[k]]",
        "1 where a predicate of the world holds in frame k, else 0",
        "[moved(robot) @ script[T]]",
    ),
    Word(
        "eventually",
        "eventually [predicate]",
        "whether a predicate of the world holds in some frame",
        "eventually [pushes(robot, cheese)]",
    ),
    Word(
        "never",
        "never [predicate]",
        "whether it holds in no frame",
        "never [moved(cheese)]",
    ),
    Word(
        "when",
        "when [predicate]",
        "the number of the first frame in which it holds; T+1 where it never does",
        "sum_t (if t < when [pushes(robot, cheese)] then 1 else 0)",
    ),
    Word(
        "++",
        "script ++ [who: action, ...]",
        "the script with one more turn; `west!` is a move that fails",
        "(script ++ [cheese: stay, robot: east])[:T+1]",
    ),
    Word(
        "if", "if c then a else b", "one of two, by a condition", "sum_t (if t < 5 then 1 else 0)"
    ),
    Word(
        "in", "x in {a, b}", "whether x is one of several values", "P(rho in {1, 3} | script[:T])"
    ),
    Word("and", "a and b", "whether both hold", "P(rho > 0 and G_robot = none | script[:T])"),
    Word("or", "a or b", "whether one of them holds", "P(rho = 0 or rho = 1 | script[:T])"),
    Word("not", "not a", "whether it does not hold", "P(not G_cheese = pink | script[:T])"),
)

STATEMENTS: tuple[Word, ...] = (
    Word(
        "world",
        "world NAME(setting = value, ...)",
        "the world: a built-in one, or `NAME.world` beside the story; "
        '`world "folder/my.world"` gives a path',
        "world kitchen(beta = 1.5)",
    ),
    Word(
        "length",
        "length N, length N..M",
        "the number of frames, T: a whole number from 1 to 100,000; of several the search chooses",
        "length 15",
    ),
    Word(
        "start",
        "start CONDITION",
        "only first pictures that fulfil it; several of them must all hold",
        "start absent(table) and at(robot, (0, 0))",
    ),
    Word(
        "allow",
        "allow EVENT, ...",
        "extraordinary events that the search may use",
        "allow deus(table)",
    ),
    Word(
        "let",
        "let NAME = EXPRESSION",
        "a name for a script, an event, a quantity or a number",
        "let helpful = rho > 0",
    ),
    Word(
        "pattern",
        "pattern NAME(PARAMETER, PARAMETER = DEFAULT) = EXPRESSION",
        "an objective to be used again; the comment above it is its documentation",
        "pattern believed(event, weight = 1) = weight * sum_t P(event | script[:t])",
    ),
    Word(
        "import",
        'import NAME, import "path"',
        "the patterns of another file, folder or compiled library",
        "import twist",
    ),
    Word(
        "maximize",
        "maximize EXPRESSION",
        "the objective; several add up",
        "maximize sum_t P(rho > 0 | script[:t])",
    ),
    Word(
        "minimize",
        "minimize EXPRESSION",
        "the objective, to be small; several add up",
        "minimize entropy(G_cheese | script[:T])",
    ),
    Word(
        "assume",
        "assume CONDITION, assume nothing",
        'what every belief is conditioned on, instead of "everyone is rational"',
        "assume R_cheese and R_robot",
    ),
    Word(
        "rationality",
        "rationality W",
        "the weight of the automatic term by which viewers shall take everyone for rational",
        "rationality 2",
    ),
    Word(
        "plausibility",
        "plausibility W",
        "the weight of the automatic term by which moves fail as often as they should",
        "plausibility 0.5",
    ),
    Word(
        "naturalness",
        "naturalness W",
        "the weight of the automatic term by which nobody does what makes no sense to viewers",
        "naturalness 0.2",
    ),
    Word(
        "luck",
        "luck W",
        "the weight of the automatic term by which luck comes in no long runs",
        "luck 1",
    ),
    Word(
        "liveliness",
        "liveliness W",
        "the weight of the automatic term by which something is seen to happen in each frame",
        "liveliness 0.1",
    ),
    Word(
        "audience",
        "audience KIND(setting = value, ...), audience NAME = KIND(...)",
        "other viewers than the world's own, or more of them, each audience with a name",
        "audience insider = bayesian(given = G_cheese = pink)",
    ),
    Word(
        "search",
        "search NAME(setting = value, ...)",
        "how to look for the script: `beam`, `descend` or `naive`",
        "search beam(starts = 100, width = 5)",
    ),
    Word(
        "require",
        "require CONDITION, require [predicate] before [predicate]",
        "what must hold in the finished script, before any objective counts; several add up",
        "require eventually [at(robot, pink)]",
    ),
    Word(
        "pin",
        "pin script[k]: CONDITION, pin script[k] = [who: action, ...]",
        "how a frame must be (or the frames `script[a..b]`), what is seen in it or done, or (in "
        'planes and on the hill) `= "take.json"`, as there; the rest is solved around it; several '
        "add up",
        "pin script[4]: at(robot, pink)",
    ),
)
"""What a statement can begin with."""

STATEMENT_WORDS = tuple(word.name for word in STATEMENTS)
_SEVERAL = (
    *("start", "allow", "let", "pattern", "import", "maximize", "minimize", "audience"),
    *("require", "pin"),
)
ONCE = frozenset(STATEMENT_WORDS) - frozenset(_SEVERAL)
"""The words of the statements that stand at most once in a story."""

_FORM_WORDS = "script t T last if then else and or not in never eventually when"
_SUMS = "sum_t mean_t min_t max_t"
RESERVED = frozenset((*STATEMENT_WORDS, *BY_NAME, *_FORM_WORDS.split(), *_SUMS.split()))
"""The words that nothing else can be called."""

_PARTS = {"then": "if", "else": "if", "@": "[ @ ]", "[": "[ @ ]", "]": "[ @ ]"}


def word_named(name: str) -> Word | None:
    """What the language says of one of its own words (`then` is a part of `if`)."""
    name = _PARTS.get(name, name)
    return next((w for w in (*STATEMENTS, *FORMS, *FUNCTIONS.values()) if w.name == name), None)
