"""The forms about what viewers believe, in one table: all that checker, formatter, help and editor
need to know of each. What it means for a belief stands in objective/meanings.py.

A new form is an entry here and its meaning there; the grammar takes its words from here.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Word:
    """A form of the language."""

    name: str
    signature: str
    documentation: str
    example: str


@dataclass(frozen=True)
class Shape:
    """How forms are written: a rule of grammar/story.lark, whose words are its forms' names."""

    terminal: str
    shown: str  # NAME and ABOUT stand for the form's own

    def written(self, name: str, about: str) -> str:
        """How a form is written, for hints."""
        return self.shown.replace("NAME", name).replace("ABOUT", about)


ABOUT = Shape("BELIEF_KW", "NAME(ABOUT | script[:t])")
EXPECTED = Shape("EXPECTED_KW", "NAME[ABOUT | script[:t]]")
UNSURE = Shape("UNSURE_KW", "NAME(ABOUT | script[:t])")  # or NAME(script[:t])
APART = Shape("APART_KW", "NAME(script[:t-1] || script[:t])")  # or NAME(ABOUT; ...)
SEEN = Shape("SEEN_KW", "NAME(script[t])")
HIDDEN = Shape("HIDDEN_KW", "NAME(ABOUT)")  # depends on the hypothesis, stands inside EXPECTED
SHAPES = (ABOUT, EXPECTED, HIDDEN, APART, UNSURE, SEEN)


@dataclass(frozen=True)
class Form(Word):
    """A form about what viewers believe.

    Attributes:
        shape: how it is written.
        about: what it is asked of: an event, a quantity, a latent, a character; '' for a frame.
        called: what it is, in messages, with its article.
        looks_ahead: it is about the frame after those that are given, so it needs a world whose
            actions can be listed; in messages, what it does.
        tabulates: asked of what is no event (of latents, of a character) it is a table of
            probabilities, which a query shows and an objective cannot use.
    """

    shape: Shape = ABOUT
    about: str = ""
    called: str = ""
    looks_ahead: str = ""
    tabulates: bool = False

    @property
    def written(self) -> str:
        """How it is written, for hints."""
        return self.shape.written(self.name, self.about.upper())

    @property
    def is_table(self) -> bool:
        """Whether it is never a number."""
        return self.tabulates and self.about == "character"

    @property
    def asks_frame(self) -> bool:
        """Whether it asks of a frame itself, not of the belief after it."""
        return self.shape is SEEN


BELIEFS: tuple[Form, ...] = (
    Form(
        "P",
        "P(event | script[:k], condition, ...)",
        "the audience's posterior probability after the first k frames; of one latent or several "
        "a table; with `event @ script[j]` that of what held in frame j",
        "P(rho > 0 | script[:T], G_cheese = pink)",
        ABOUT,
        about="event",
        called="a probability",
        tabulates=True,
    ),
    Form(
        "next",
        "next(who | script[:k], condition, ...)",
        "the probabilities of a character's next action, as viewers predict it (in queries)",
        "next(robot | script[:T])",
        ABOUT,
        about="character",
        called="a prediction",
        looks_ahead="`next` looks one frame ahead",
        tabulates=True,
    ),
    Form(
        "E",
        "E[quantity | script[:k], condition, ...]",
        "the posterior expectation of a quantity that depends on the hypothesis",
        "E[V(robot) | script[:T]]",
        EXPECTED,
        about="quantity",
        called="an expectation",
    ),
    Form(
        "V",
        "V(who)",
        "a character's value function at the state that the script of the expectation ends in",
        "E[V(cheese) | script[:T]]",
        HIDDEN,
        about="character",
    ),
    Form(
        "KL",
        "KL(latent; script[:a] || script[:b])",
        "the divergence of the belief after b frames from the belief after a, in nats; about "
        "`others(event, ...)` of all latents but those that the events are about",
        "KL(rho; script[:T-1] || script[:T])",
        APART,
        about="latent",
        called="a divergence",
    ),
    Form(
        "entropy",
        "entropy(latent | script[:k])",
        "the uncertainty about a latent, or without one about everything, in nats",
        "entropy(rho | script[:T])",
        UNSURE,
        about="latent",
        called="an entropy",
    ),
    Form(
        "surprise",
        "surprise(script[k])",
        "-log of the probability that viewers gave to the actions of frame k, in nats",
        "surprise(script[T])",
        SEEN,
    ),
    Form(
        "suspense",
        "suspense(latent | script[:k])",
        "the variance of the belief after the next frame, as viewers predict it",
        "suspense(rho | script[:T])",
        ABOUT,
        about="latent",
        called="suspense",
        looks_ahead="suspense looks one frame ahead",
    ),
)
BY_NAME = {form.name: form for form in BELIEFS}
BY_TERMINAL = {
    shape.terminal: tuple(form for form in BELIEFS if form.shape is shape) for shape in SHAPES
}
"""The forms of each terminal of the grammar."""


def with_words(grammar: str) -> str:
    """A grammar with the forms' names in place of `<TERMINAL>`."""
    for terminal, forms in BY_TERMINAL.items():
        grammar = grammar.replace(f"<{terminal}>", "|".join(form.name for form in forms))
    return grammar
