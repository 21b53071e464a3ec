"""Films of a catalogue's examples, packed to lie in its pages until somebody plays them."""

from __future__ import annotations

import base64
import gzip
import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from i2pdsl.untrusted import WrongData, read_bytes

LARGEST = 4 * 2**20  # bytes of a packed film
_PACKED = re.compile(r"[A-Za-z0-9+/]+={0,2}")


@dataclass(frozen=True)
class PackedFilm:
    """A film: JSON for the player, compressed by gzip, in base64; `script` moves it."""

    script: str
    data: str

    def as_text(self) -> str:
        """A file of it."""
        return f"{self.script}\n{self.data}\n"


def pack_film(film: dict[str, Any]) -> PackedFilm:
    """A film as `mount` takes it (render/film_page.py, `to_mount`)."""
    text = json.dumps(film, separators=(",", ":"), allow_nan=False)
    packed = gzip.compress(text.encode("utf-8"), mtime=0)
    return PackedFilm(film["script"], base64.b64encode(packed).decode("ascii"))


def read_film(path: Path) -> PackedFilm | None:
    """What `as_text` wrote; None where there is nothing of that form."""
    try:
        script, _, data = read_bytes(path, LARGEST).decode("ascii").partition("\n")
    except (OSError, WrongData, ValueError):
        return None
    from i2pdsl.render.pictures import page_scripts

    data = data.rstrip("\n")
    right = script in page_scripts() and _PACKED.fullmatch(data)
    return PackedFilm(script, data) if right else None
