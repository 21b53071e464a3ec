"""What a name is made of, in both languages, and when two names are the same.

A name begins with a letter of any script and goes on with letters, digits, `_` and the marks that
are written on letters or between them. Python's `\\w` lacks the marks (an accent of its own, the
vowels of Hindi or Thai), so that patterns which read names are passed through `with_marks`.
"""

from __future__ import annotations

import unicodedata

_RANGES = (
    (0x0300, 0x036F),  # accents
    (0x0483, 0x0487),  # Cyrillic
    (0x0591, 0x05C7),  # Hebrew points
    (0x0610, 0x061A),  # Arabic
    (0x064B, 0x065F),
    (0x0670, 0x0670),
    (0x06D6, 0x06ED),
    (0x0711, 0x07F3),  # Syriac, Thaana, N’Ko
    (0x0898, 0x0963),  # Arabic, Devanagari
    (0x0966, 0x0DF3),  # the scripts of India
    (0x0E31, 0x0FBC),  # Thai, Lao, Tibetan
    (0x102B, 0x109D),  # Myanmar
    (0x135D, 0x135F),  # Ethiopic
    (0x1712, 0x17DD),  # the Philippines, Khmer
    (0x180B, 0x180F),  # Mongolian
    (0x1920, 0x1CF9),  # Limbu to Vedic signs
    (0x1AB0, 0x1AFF),
    (0x1DC0, 0x1DFF),
    (0x200C, 0x200D),  # joiners
    (0x20D0, 0x20F0),
    (0x3099, 0x309A),  # Japanese voicing
    (0xA66F, 0xA69F),
    (0xA802, 0xABED),  # Javanese, Cham and their neighbours
    (0xFE00, 0xFE0F),  # variants of a letter
    (0xFE20, 0xFE2F),
)
_MARKS = "".join(f"\\u{first:04x}-\\u{last:04x}" for first, last in _RANGES)


def with_marks(pattern: str) -> str:
    """A regular expression (or a grammar of them) whose `\\w` knows marks too."""
    return pattern.replace(r"\w", rf"[\w{_MARKS}]")


NAME = with_marks(r"[^\W\d]\w*")
"""A name, as a regular expression."""


def same_name(text: str) -> str:
    """A name in the one form that all its ways of being written have: an accented letter may be
    one character or two (NFC)."""
    return text if text.isascii() else unicodedata.normalize("NFC", text)
