"""What stories on the hill begin as."""

from __future__ import annotations

from i2pdsl.worlds.beginnings import Beginning, Beginnings
from i2pdsl.worlds.hill.spec import NAME

_WAYS = (
    Beginning(
        "mime", "the box is light, and the hopper moves as if it were heavy", "depict", 350,
        (("After every frame viewers shall believe that the box is heavy, and that the hopper does "
          "its best.", "maximize depict(weight = {heavy} and will = eager)"),
         ("Its muscles shall work, up to a half of what they can, and the rope be stretched.",
          "maximize sum_t (0.2 * min([effort(hopper) @ script[t]], 1.3)\n"
          "    - 0.1 * [effort(hopper) @ script[t]] + 0.3 * [taut(hopper) @ script[t]])"),
         ("It shall move as viewers imagine such a hopper: without this it trembles.",
          "naturalness 1.3"),
         ("How the search looks: 50 frames at a time, 60 steps for each.",
          "search descend(seeds = 4, window = 50, overlap = 0, lookahead = 0, steps = 60)")),
        "(weight = {light}, lazy = 0.1)",
    ),
    Beginning(
        "stumble", "the hopper stumbles half way, and recovers", "", 400,
        (("From frame 160 to 240 things shall look bad for the hopper, else good.",
          "maximize sum_t (if 160 <= t <= 240 then -1 else 1)\n"
          "    * E[V(hopper) | script[:t], weight = {heavy}]"),
         ("It shall stumble, and not fall.",
          "minimize sum_t 50000 * [fallen(hopper) @ script[t]]")),
        "(weight = {heavy})",
    ),
)  # fmt: skip

_MORE = (("viewers who look less closely", "audience bayesian(sigma = 2)"),)

BEGINNINGS = Beginnings("hill", _WAYS, _MORE, world=NAME)
