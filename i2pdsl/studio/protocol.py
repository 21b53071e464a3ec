"""What the page asks of the server beside the language server protocol: JSON-RPC messages whose
methods begin with `i2p/` (docs/studio-protocol.md has examples of all of them).

Parameters are dataclasses, read strictly (reading.py). JSON-RPC 2.0:
https://www.jsonrpc.org/specification.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

PROTOCOL = 1
OURS = "i2p/"
LARGEST_MESSAGE = 8 * 2**20  # bytes of a text frame: an upload, or a long story

STALE, CANCELLED, STORY, CONFLICT, FILE, REFUSED, USAGE = (
    "stale", "cancelled", "story", "conflict", "file", "refused", "usage",
)  # fmt: skip


class Refusal(Exception):
    """An answer that is an error: its kind, what is said, and data beside that."""

    def __init__(self, kind: str, message: str, **data: Any) -> None:
        super().__init__(message)
        self.kind, self.message, self.data = kind, message, data

    def as_json(self) -> dict[str, Any]:
        return {"code": 1, "message": self.message, "data": {"kind": self.kind, **self.data}}


# What is asked. A place on the stage, of a map or in a text is a pair of numbers.


@dataclass(frozen=True)
class Nothing:
    """`i2p/studio`, `i2p/files`, `i2p/beginnings`."""


@dataclass(frozen=True)
class OfFile:
    """`i2p/open`."""

    path: str


@dataclass(frozen=True)
class Save:
    """`i2p/save`: `digest` is that of the file as it was read, None where there shall be none."""

    path: str
    text: str
    digest: str | None = None


@dataclass(frozen=True)
class New:
    """`i2p/new`: the text of a story to begin with."""

    name: str
    beginning: str | None = None
    world: str = "kitchen"


@dataclass(frozen=True)
class Upload:
    """`i2p/upload`: a picture, in base64."""

    path: str
    data: str


@dataclass(frozen=True)
class OfDocument:
    """A version of an open document. `i2p/cancel` has no version."""

    uri: str
    version: int | None = None


@dataclass(frozen=True)
class Solve(OfDocument):
    """`i2p/solve`."""

    seed: int = 0
    effort: int = 1


@dataclass(frozen=True)
class Candidates(OfDocument):
    """`i2p/candidates`."""

    seed: int = 0
    count: int = 8


@dataclass(frozen=True)
class OfFilm:
    """`i2p/wishes`, `i2p/why`, `i2p/curves`."""

    film: str


@dataclass(frozen=True)
class Query(OfFilm):
    """`i2p/query`."""

    expression: str = ""
    assume: str | None = None


@dataclass(frozen=True)
class Suggest(OfFilm):
    """`i2p/suggest`: what could follow after a frame."""

    frame: int = 0
    frames: int | None = None


@dataclass(frozen=True)
class Keep(OfFilm):
    """`i2p/keep`: the script as a file of the folder."""

    path: str = ""
    digest: str | None = None


@dataclass(frozen=True)
class Export(OfFilm):
    """`i2p/export`."""

    formats: list[str] | None = None
    pace: float = 1.0
    transparent: bool = False


@dataclass(frozen=True)
class Play(OfDocument):
    """`i2p/play`: where somebody can be in a frame."""

    frame: int = 0
    who: str = ""


@dataclass(frozen=True)
class Pin(Play):
    """`i2p/pin`: at a place (None for nowhere), or at a point of the stage that shows a film."""

    place: str | None = None
    film: str | None = None
    at: list[float] | None = None


@dataclass(frozen=True)
class Stretch(OfFilm):
    """`i2p/during`: what can be said of frames first..last."""

    first: int = 1
    last: int = 1


@dataclass(frozen=True)
class Say(OfDocument):
    """`i2p/say`: a condition holds in frames first..last."""

    first: int = 1
    last: int = 1
    condition: str = ""


@dataclass(frozen=True)
class Unpin(OfDocument):
    """`i2p/unpin`: what pins a frame, or frames up to `last` together."""

    frame: int = 0
    who: str | None = None
    last: int | None = None


@dataclass(frozen=True)
class Move(Play):
    """`i2p/move`: a pin to another frame."""

    to: int = 0


@dataclass(frozen=True)
class Hold(OfDocument):
    """`i2p/hold`: frames as they are in a film."""

    film: str = ""
    first: int = 1
    last: int = 1


@dataclass(frozen=True)
class Position:
    line: int
    character: int


@dataclass(frozen=True)
class Range:
    start: Position
    end: Position


@dataclass(frozen=True)
class Curve(OfDocument):
    """`i2p/curve`: points drawn over the frames' share of the film, in 0 to 1, and the curve's
    own axis, which goes from `low` to `high`."""

    points: list[list[float]] | None = None
    range: Range | None = None
    expression: str | None = None
    low: float = -1.0
    high: float = 1.0


@dataclass(frozen=True)
class Edit(OfDocument):
    """`i2p/edit`: `length` with `value`; `insert` or `cut` at `frame`; `beats` in an `order`;
    `start` as in a `film`."""

    what: str = ""
    value: int | None = None
    frame: int | None = None
    order: list[int] | None = None
    film: str | None = None


@dataclass(frozen=True)
class UsePattern(OfDocument):
    """`i2p/pattern`: a wish that calls a pattern."""

    name: str = ""
    arguments: dict[str, str] | None = None


@dataclass(frozen=True)
class Patterns:
    """`i2p/patterns`."""

    uri: str | None = None
    words: str = ""


@dataclass(frozen=True)
class Paint(OfDocument):
    """`i2p/paint`: cells of a map, with a symbol of it."""

    cells: list[list[int]] | None = None
    symbol: str = "."


@dataclass(frozen=True)
class Sides(OfDocument):
    """`i2p/side`: walls between neighbouring cells, put up or taken away."""

    sides: list[list[list[int]]] | None = None
    wall: bool = True


@dataclass(frozen=True)
class Size(OfDocument):
    """`i2p/size`: of a map."""

    columns: int = 1
    rows: int = 1


@dataclass(frozen=True)
class Entity(OfDocument):
    """`i2p/entity`: a block of a world's file; without settings it goes, an empty one goes; with
    `another` there is one more of its kind."""

    what: str = "character"
    name: str = ""
    settings: dict[str, str] | None = None
    another: bool = False


REQUESTS: dict[str, type] = {
    "studio": Nothing,
    "files": Nothing,
    "open": OfFile,
    "save": Save,
    "new": New,
    "beginnings": Nothing,
    "upload": Upload,
    "solve": Solve,
    "cancel": OfDocument,
    "candidates": Candidates,
    "wishes": OfFilm,
    "why": OfFilm,
    "query": Query,
    "curves": OfFilm,
    "suggest": Suggest,
    "keep": Keep,
    "export": Export,
    "play": Play,
    "pin": Pin,
    "during": Stretch,
    "say": Say,
    "unpin": Unpin,
    "move": Move,
    "hold": Hold,
    "curve": Curve,
    "edit": Edit,
    "pattern": UsePattern,
    "patterns": Patterns,
    "paint": Paint,
    "side": Sides,
    "size": Size,
    "entity": Entity,
}
"""What each request's parameters are, by its name behind `i2p/`."""
