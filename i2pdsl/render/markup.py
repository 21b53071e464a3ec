"""Text in HTML."""

import unicodedata
from html import escape


def plain(text: str) -> str:
    """Escaped for HTML, in elements and in quoted attributes; what HTML cannot hold becomes �."""
    known = "".join(
        "\ufffd" if unicodedata.category(c) in ("Cc", "Cs") and c not in "\n\t" else c
        for c in text.replace("\r\n", "\n").replace("\r", "\n")
    )
    return escape(known, quote=True)
