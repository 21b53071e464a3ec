"""A baseline that any inverse planner must beat: what can be counted in a film, and no planning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from i2pdsl.errors import error, whole_file
from i2pdsl.fit.viewers import Question
from i2pdsl.scripts import Script


def cues(
    scripts: Mapping[str, Script], questions: Sequence[Question], expressions: Sequence[str]
) -> np.ndarray:
    """The values of expressions at each cell, [C, F], less their means and in units of their
    standard deviations: `sum_t [pushes(robot, cheese) @ script[t]]` counts all frames of a script,
    `[at(robot, pink) @ script[t]]` is asked after the frame that the cell is about.

    Raises StoryError where one of them is no number.
    """
    table = np.empty((len(questions), len(expressions)))
    for column, text in enumerate(expressions):
        answers = [script.ask(text) for script in scripts.values()]
        for number, question in enumerate(questions):
            answer = answers[question.script]
            if answer.labels is not None or answer.axes:
                raise error("cue", f"`{text}` is no number", whole_file("cue"))
            place = None if answer.t is None else answer.t.index(question.frame)
            table[number, column] = answer.value if place is None else answer.value[place]
    spread = table.std(0)
    return (table - table.mean(0)) / np.where(spread > 0, spread, 1.0)
