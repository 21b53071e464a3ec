"""How often viewers are sure of what a story depicts (P > 0.9 after the last of 7 frames), with
an audience in the loop and without one ("naive planning"; paper, section 4.1).

    python benchmarks/naive.py [SEEDS]
"""

from __future__ import annotations

import sys
from pathlib import Path

from i2pdsl.errors import Source
from i2pdsl.stories import story_from

STORIES = {"help": "rho > 0", "hinder": "rho < 0", "indifferent": "rho = 0"}
TEXT = """world kitchen
length 7
maximize depict({event})
search beam(starts = 100, width = 1)
"""


def main() -> None:
    """Prints the shares."""
    seeds = range(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
    print(f"{'story':<14}{'naive':>8}{'i2p':>8}   share of {len(seeds)} seeds with P > 0.9")
    for name, event in STORIES.items():
        story = story_from(Source(f"{name}.story", TEXT.format(event=event)), Path())
        sure = {}
        for naive in (True, False):
            asked = f"P({event} | script[:T])"
            beliefs = [story.solve(s, naive=naive).script.query(asked) for s in seeds]
            sure[naive] = sum(float(b) > 0.9 for b in beliefs) / len(beliefs)
        print(f"{name:<14}{sure[True]:>8.0%}{sure[False]:>8.0%}")


if __name__ == "__main__":
    main()
