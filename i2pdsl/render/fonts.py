"""Fonts of the pictures: DejaVu Sans, which matplotlib brings along, the same on every machine.

For characters that it lacks a font of the system is looked for; where none has them, that is said,
since boxes are all that can be drawn.
"""

from __future__ import annotations

import logging
import unicodedata
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from importlib.util import find_spec
from pathlib import Path

FAMILY = "DejaVu Sans"
_COMMON = 0x180  # all characters before it are in DejaVu Sans
_USELESS = ("lastresort", "colr")  # one has everything, as boxes; one has colours and no outlines
_UNSEEN = ("Cc", "Cf", "Cs", "Zs", "Zl", "Zp")
_EAST_ASIAN = ("CJK", "HIRAGANA", "KATAKANA", "HANGUL", "BOPOMOFO", "KANGXI")

_noted: ContextVar[set[str] | None] = ContextVar("noted", default=None)
_logged: set[str] = set()


@cache
def font_files() -> tuple[str, str]:
    """Paths of DejaVu Sans, regular and bold, found without importing matplotlib."""
    spec = find_spec("matplotlib")
    if spec is None or not spec.submodule_search_locations:
        raise FileNotFoundError("matplotlib, whose DejaVu Sans the pictures use, is not installed")
    folder = Path(spec.submodule_search_locations[0], "mpl-data", "fonts", "ttf")
    return str(folder / "DejaVuSans.ttf"), str(folder / "DejaVuSans-Bold.ttf")


def further_fonts(text: str) -> tuple[str, ...]:
    """Paths of the system's fonts for what DejaVu Sans lacks; notes what none of them has."""
    lacking = lacked(text)
    if not lacking:
        return ()
    paths, left = _found(lacking)
    _note(left)
    return paths


def families(text: str) -> list[str]:
    """The families, in order, in which matplotlib finds all characters of a text."""
    names = [FAMILY]
    for path in further_fonts(text):
        from matplotlib.font_manager import FontProperties, fontManager

        fontManager.addfont(path)
        names.append(FontProperties(fname=path).get_name())
    return names


def lacked(text: str) -> frozenset[str]:
    """The characters of a text that can be seen and that DejaVu Sans does not have."""
    unusual = {c for c in text if ord(c) >= _COMMON and _is_seen(c)}
    return frozenset(c for c in unusual if ord(c) not in _covered(font_files()[0]))


@contextmanager
def quiet_glyphs() -> Iterator[None]:
    """Without matplotlib's own words about fonts: what is missing is told here."""
    log = logging.getLogger("matplotlib.font_manager")
    before = log.level
    log.setLevel(logging.ERROR)  # a fallback need not be there in bold
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Glyph .* missing")
            yield
    finally:
        log.setLevel(before)


@contextmanager
def noting(tell: Callable[[str, str], None]) -> Iterator[None]:
    """Tells once, at the end, of all characters that no font had: a message and a hint.

    Outside of it each is logged once.
    """
    token = _noted.set(set())
    try:
        yield
    finally:
        missing = _noted.get()
        _noted.reset(token)
        if missing:
            tell(*in_words(missing))


def in_words(missing: Iterable[str]) -> tuple[str, str]:
    """What is said of characters that no font has: a message and a hint."""
    signs = sorted(missing)
    told = " ".join(signs[:12]) + (f" and {len(signs) - 12} more" if len(signs) > 12 else "")
    scripts = {_script(c) for c in signs}
    wanted = ", ".join(sorted({_remedy(script) for script in scripts}))
    message = f"no font of this machine has {told}: these are boxes in the pictures"
    return message, f"install {wanted}; web pages use the fonts of whoever looks at them"


def _note(missing: frozenset[str]) -> None:
    noted = _noted.get()
    if noted is not None:
        noted |= missing
    elif missing - _logged:
        _logged.update(missing)
        logging.getLogger(__name__).warning("%s; %s", *in_words(missing))


def _is_seen(character: str) -> bool:
    is_variant = "\ufe00" <= character <= "\ufe0f"
    return unicodedata.category(character) not in _UNSEEN and not is_variant


def _script(character: str) -> str:
    if unicodedata.category(character) == "So":
        return "SYMBOL"
    return unicodedata.name(character, "UNKNOWN").split()[0].split("-")[0]


def _remedy(script: str) -> str:
    if script in _EAST_ASIAN:
        return "Noto Sans CJK (Debian, Ubuntu: fonts-noto-cjk)"
    if script == "SYMBOL":
        return "Symbola (Debian, Ubuntu: fonts-symbola)"
    return f"a font for {script.title()}, such as one of Noto Sans (fonts-noto-core)"


@cache
def _covered(path: str) -> frozenset[int]:
    """The code points of a font that can be drawn as outlines; none if it cannot be read."""
    from matplotlib.ft2font import FT2Font

    try:
        font = FT2Font(path)
        return frozenset(font.get_charmap()) if font.scalable else frozenset()
    except (OSError, RuntimeError):
        return frozenset()  # damaged, or of a kind that nobody draws


@cache
def _found(lacking: frozenset[str]) -> tuple[tuple[str, ...], frozenset[str]]:
    """Fonts of the system, the one that has most first, and what they all lack."""
    from matplotlib.font_manager import findSystemFonts

    left = {ord(c) for c in lacking}
    fonts = [p for p in findSystemFonts() if not any(x in p.lower() for x in _USELESS)]
    candidates = sorted(fonts, key=_preference)
    chosen: list[str] = []
    while left:
        best, most = "", 0
        for path in candidates:
            count = len(left & _covered(path))
            if count > most:
                best, most = path, count
            if count == len(left):
                break
        if not best:
            break
        chosen.append(best)
        left -= _covered(best)
    return tuple(chosen), frozenset(map(chr, left))


def _preference(path: str) -> tuple[bool, bool, bool, str]:
    """Upright sans serifs of the usual weight first; the same order on every run."""
    name = Path(path).stem.lower()
    unusual = ("bold", "light", "thin", "black", "italic", "oblique", "condensed", "mono")
    return "sans" not in name, any(x in name for x in unusual), "serif" in name, path
