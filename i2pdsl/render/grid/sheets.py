"""The dope sheets: what a body does during a beat."""

from math import pi, sin
from typing import NamedTuple


class Cue(NamedTuple):
    """A key in the actor's own terms: `u` runs from 0 to 1 over its beat, `along` is the way gone
    in the beat's direction (cells), `lean` tips toward it (turns), `press` squeezes against it,
    `squash` makes low and wide (positive) or long and thin (negative)."""

    u: float
    along: float = 0.0
    squash: float = 0.0
    press: float = 0.0
    lean: float = 0.0
    lift: float = 0.0
    ease: str = "in-out"
    pose: str = "idle"


def _hop(u0: float, u1: float, start: float, end: float, height: float) -> list[Cue]:
    """A smooth leap. Height and way have different shapes, so it is cut into straight pieces."""
    cues = []
    for i in range(1, 8):
        s = i / 8
        along = start + (end - start) * s * s * (3 - 2 * s)
        stretch = 0.10 - 0.19 * sin(pi * s)
        lift = height * 4 * s * (1 - s)
        cues.append(Cue(u0 + (u1 - u0) * s, along, stretch, 0, 0.012, lift, "linear", "walk"))
    return cues


STEP = [
    Cue(0.05),
    Cue(0.22, -0.05, 0.10, ease="linear", pose="walk"),  # anticipation: crouch, a little back
    *_hop(0.22, 0.70, -0.05, 1.0, 0.15),
    Cue(0.70, 1.0, 0.11, pose="walk"),  # landing
    Cue(0.81, 1.0, -0.035),
    Cue(0.92, 1.0),
]
CONTACT = 0.16  # how far two neighbours' outlines are apart, in cells
PUSH = [
    Cue(0.05),
    Cue(0.21, -0.15, 0.09, lean=-0.034, ease="in", pose="push"),  # winds up
    Cue(0.30, CONTACT, lean=0.024, ease="out", pose="push"),  # contact comes first ...
    Cue(0.43, CONTACT, 0.03, press=0.12, lean=0.044, ease="in", pose="push"),  # ... then effort ...
    Cue(0.73, 1 + CONTACT, press=0.02, lean=0.040, ease="out", pose="push"),  # ... both go ...
    Cue(0.82, 0.97, -0.03, lean=-0.012, pose="push"),  # ... and it falls back on its feet
    Cue(0.93, 1.0),
]
PUSHED = [  # same times and eases as PUSH from 0.43 to 0.73, so that the two stay in touch
    Cue(0.30, pose="surprised"),
    Cue(0.43, press=0.14, lean=0.010, ease="in", pose="surprised"),
    Cue(0.73, 1.0, press=0.04, lean=-0.020, ease="out", pose="surprised"),
    Cue(0.81, 1.10, press=-0.06, lean=-0.034, pose="surprised"),  # is carried on, and sways
    Cue(0.90, 1.0, lean=0.014, pose="surprised"),
    Cue(0.96, 1.0),
]
PULL = [  # its face is turned to what it pulls, which follows at the same times
    Cue(0.05),
    Cue(0.21, -CONTACT, lean=-0.020, ease="in-out", pose="push"),  # takes hold ...
    Cue(0.43, -CONTACT + 0.08, 0.05, lean=0.040, ease="in", pose="push"),  # ... leans back ...
    Cue(0.78, 1.0, lean=0.020, ease="out", pose="push"),  # ... both go
    Cue(0.93, 1.0),
]
PULLED = [
    Cue(0.43, ease="in"),
    Cue(0.80, 1.0, ease="out"),
    Cue(0.96, 1.0),
]
FAIL = [
    Cue(0.05),
    Cue(0.19, -0.05, 0.12, ease="out", pose="try"),
    Cue(0.36, 0.27, -0.06, lean=0.036, pose="try"),  # reaches for the cell ...
    Cue(0.44, 0.21, 0.00, lean=0.006, pose="try"),  # ... wobbles ...
    Cue(0.52, 0.25, -0.03, lean=0.042, pose="try"),
    Cue(0.60, 0.18, 0.02, lean=0.000, pose="try"),
    Cue(0.80, 0.00, 0.13, lean=-0.012, pose="sad"),  # ... and sinks back where it was
    Cue(0.94, 0.00, 0.03, pose="sad"),
]
BUMP = [
    Cue(0.08),
    Cue(0.20, -0.09, 0.07, ease="in", pose="walk"),
    Cue(0.30, CONTACT, lean=0.020, ease="out", pose="bump"),
    Cue(0.35, CONTACT, press=0.20, ease="out", pose="bump"),  # hard stop
    Cue(0.48, -0.09, -0.05, lean=-0.030, lift=0.05, pose="bump"),  # thrown back
    Cue(0.62, 0.0, 0.06, pose="bump"),
    Cue(0.80),
]
PUT = [  # leans to where it goes, and back
    Cue(0.05),
    Cue(0.30, 0.14, lean=0.030, pose="push"),
    Cue(0.62, 0.14, lean=0.030, pose="push"),
    Cue(0.90),
]
STAY = [Cue(0.25), Cue(0.52, squash=-0.035), Cue(0.80)]
SHEETS = {"step": STEP, "push": PUSH, "pull": PULL, "put": PUT}
SHEETS |= {"fail": FAIL, "bump": BUMP, "stay": STAY}
