"""What a line of the REPL came to, and how a terminal and a pipe show it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from i2pdsl.answers import Answer, number
from i2pdsl.errors import Diagnostic, display_width, padded
from i2pdsl.render.characters import NOTHING, Ink, curves_of, draw_curves, extent, laid_out
from i2pdsl.repl.texts import wrapped

MOST_VALUES = 40  # of a curve that are listed below it


@dataclass(frozen=True)
class Asked:
    """An answer to one question."""

    answer: Answer


@dataclass(frozen=True)
class Plotted:
    """Curves side by side."""

    answers: tuple[Answer, ...]
    frames: range


@dataclass(frozen=True)
class Tabled:
    """Answers side by side as numbers."""

    answers: tuple[Answer, ...]
    frames: range


@dataclass(frozen=True)
class Moved:
    """Beliefs before and after frames that were added by hand.

    Attributes:
        number: of the last of them.
        told: their turns as stories write them, `[cheese: west, robot: stay] [...]`.
    """

    number: int
    told: str
    beliefs: tuple[Belief, ...]


@dataclass(frozen=True)
class Belief:
    """What viewers believe of a latent: before, if that is asked, and after."""

    latent: str
    labels: tuple[str, ...]
    after: np.ndarray
    before: np.ndarray | None = None


@dataclass(frozen=True)
class Looked:
    """A frame: its picture in characters and the beliefs after it."""

    title: str
    picture: str
    beliefs: tuple[Belief, ...]


@dataclass(frozen=True)
class Text:
    """Anything in words; `short` is what a pipe gets, if that is less."""

    text: str
    short: str | None = None
    is_story: bool = False


Shown = Asked | Plotted | Tabled | Moved | Looked | Text


@dataclass(frozen=True)
class Reply:
    """What a line came to.

    Attributes:
        noted: what happened on the way to the results, for standard error.
        shown: results, for standard output.
        said: remarks, for standard error.
        diagnostics: mistakes and warnings.
        leaves: whether the session ends.
    """

    shown: tuple[Shown, ...] = ()
    said: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    leaves: bool = False
    noted: tuple[str, ...] = ()


# In a pipe: one line for each answer.


def in_a_line(shown: Shown) -> str:
    """A result on one line (pictures and texts that were asked for may be longer)."""
    match shown:
        case Asked(answer):
            return _line(answer)
        case Plotted(answers, frames):
            return draw_curves([c for a in answers for c in curves_of(a, frames)], Ink())
        case Tabled(answers, frames):
            return table(answers, frames)
        case Moved(count, told, beliefs):
            turns = (f"frame {n}: {turn}" for n, turn in _turns(count, told))
            return "; ".join((*turns, *map(belief_line, beliefs)))
        case Looked(title, picture, beliefs):
            return "\n".join((title, picture, *(f"  {belief_line(b)}" for b in beliefs)))
        case Text(text, short):
            return text if short is None else short


def _line(answer: Answer) -> str:
    columns = answer.columns()
    joined = {name: " ".join(map(number, np.atleast_1d(v))) for name, v in columns.items()}
    if answer.labels is None:
        return next(iter(joined.values()))
    mark = "; " if answer.t is not None else ", "
    return mark.join(f"{name} {values}" for name, values in joined.items())


def _turns(last: int, told: str) -> list[tuple[int, str]]:
    """The turns up to a frame without their brackets, each with its frame."""
    turns = told[1:-1].split("] [")
    return list(enumerate(turns, last + 1 - len(turns)))


def belief_line(belief: Belief) -> str:
    parts = (f"{n} {number(v)}" for n, v in zip(belief.labels, belief.after, strict=True))
    return f"{belief.latent}: {', '.join(parts)}"


# On a terminal.


def on_a_terminal(shown: Shown, ink: Ink) -> str:
    """A result with curves, bars and colours, as far as the terminal has them."""
    match shown:
        case Asked(answer):
            return _asked(answer, ink)
        case Plotted(answers, frames):
            return draw_curves([c for a in answers for c in curves_of(a, frames)], ink)
        case Tabled(answers, frames):
            return table(answers, frames)
        case Moved(count, told, beliefs):
            heads = (f"{ink.paint(f'frame {n}', 1)}  {turn}" for n, turn in _turns(count, told))
            return "\n".join((*heads, *(_change(b, ink) for b in beliefs)))
        case Looked(title, picture, beliefs):
            rows = [line for b in beliefs for line in _bars(b.latent, b.labels, b.after, ink)]
            return "\n".join((ink.paint(wrapped(title, ink.columns), 1), picture, *rows))
        case Text(text, _, is_story):
            return text if is_story else wrapped(text, ink.columns)


def _asked(answer: Answer, ink: Ink) -> str:
    if answer.t is not None:
        if not answer.t:
            return ""
        frames = range(answer.t[0], answer.t[-1] + 1)
        if len(frames) < 2:
            return table((answer,), frames, columns=ink.columns)
        drawn = draw_curves(curves_of(answer, frames), ink)
        return f"{drawn}\n{table((answer,), frames, MOST_VALUES, ink.columns)}"
    if answer.labels is None:
        return number(answer.value)
    columns = answer.columns()
    values = np.array(list(columns.values()))
    return "\n".join(_bars(answer.latent or "", tuple(columns), values, ink))


def _bars(latent: str, labels: Sequence[str], values: np.ndarray, ink: Ink) -> list[str]:
    """A latent's values with their probabilities, and bars."""
    width = max(map(display_width, labels))
    longest = max(8, min(24, ink.columns - 26))
    lines = [f"  {ink.paint(latent, 1)}"] if latent else []
    for label, value in zip(labels, values, strict=True):
        bar = ink.paint(_bar(float(value), longest, ink.unicode), 34)
        lines.append(f"    {padded(label, width)}  {float(value):8.4f}  {bar}".rstrip())
    return lines


def _bar(share: float, width: int, unicode: bool) -> str:
    if not unicode:
        return "#" * round(share * width)
    eighths = round(share * width * 8)
    return "█" * (eighths // 8) + ("▏▎▍▌▋▊▉"[eighths % 8 - 1] if eighths % 8 else "")


def _change(belief: Belief, ink: Ink) -> str:
    """How a belief moved; what moved by more than a hundredth stands out."""
    assert belief.before is not None
    arrow = "→" if ink.unicode else "->"
    parts = []
    for label, old, new in zip(belief.labels, belief.before, belief.after, strict=True):
        told = f"{label} {old:.3f}{arrow}{new:.3f}"
        shown = ink.paint(told, 32 if new > old else 31) if abs(new - old) > 0.01 else told
        parts.append((told, shown))
    lines = laid_out(parts, 3, 13, ink.columns)
    return "\n".join((f"  {belief.latent:<10} {lines[0].lstrip()}", *lines[1:]))


def table(
    answers: Sequence[Answer], frames: range, most: int | None = None, columns: int = 80
) -> str:
    """Numbers over frames, a row each; of long ones every so many, and the last.

    Args:
        most: rows at most, about; None is all.
        columns: characters in a line, for a single curve.
    """
    curves = [c for a in answers for c in curves_of(a, frames)]
    if not any(len(c.t) for c in curves):
        return NOTHING
    names = [c.name for c in curves]
    if len(answers) == 1:
        names = list(answers[0].columns()) if answers[0].labels else ["value"]
    first, last = extent(curves)
    step = 1 if most is None else max(1, -(-(last - first + 1) // most))
    rows = [*range(first, last + 1, step)]
    if rows[-1] != last:
        rows.append(last)
    if len(names) == 1:
        return _packed(curves[0].t, curves[0].value, rows, max(1, min(4, columns // 18)))
    by_frame = [dict(zip(map(int, c.t), c.value, strict=True)) for c in curves]
    width = [max(10, len(n)) for n in names]
    lines = ["    t  " + "  ".join(f"{n:>{w}}" for n, w in zip(names, width, strict=True))]
    for t in rows:
        cells = [
            f"{number(c[t]) if t in c else '':>{w}}" for c, w in zip(by_frame, width, strict=True)
        ]
        lines.append(f"{t:>5}  " + "  ".join(cells).rstrip())
    return "\n".join(lines)


def _packed(t: np.ndarray, values: np.ndarray, rows: Sequence[int], across: int) -> str:
    """One column of numbers in several, to be read from left to right."""
    known = dict(zip(map(int, t), values, strict=True))
    cells = [f"{row:>5} {number(known[row]):<11}" for row in rows if row in known]
    starts = range(0, len(cells), across)
    return "\n".join("".join(cells[i : i + across]).rstrip() for i in starts)
