"""Searches on several devices: each has its own share, and finds what one alone would find."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import i2pdsl
from stories_for_tests import BARE
from worlds_for_tests import with_small_world

ROOT = Path(__file__).parents[2]
MAP = f"world small\nlength 3\nmaximize depict(rho > 0)\n{BARE}search beam (starts = 70)\n"
PLANE = (
    "world desk\nlength 40\nmaximize legible(G_hand = left)\n"
    "search descend (seeds = 4, steps = 3)\n"
)
SOLVE = """
import json, sys
from pathlib import Path
import i2pdsl, jax
found = i2pdsl.Story.from_text(Path(sys.argv[1]).read_text(), folder=sys.argv[2]).solve(seed=1)
scores = [one.score for one in found.candidates]
print(json.dumps({"devices": len(jax.devices()), "score": found.score, "scores": scores}))
"""


def solved(text: str, folder: Path, devices: int) -> dict[str, float]:
    path = folder / "told.story"
    path.write_text(text)
    flags = f"{os.environ['XLA_FLAGS']} --xla_force_host_platform_device_count={devices}"
    done = subprocess.run(
        [sys.executable, "-c", SOLVE, path, folder],
        env={**os.environ, "XLA_FLAGS": flags},
        capture_output=True,
        text=True,
        check=True,
    )
    found: dict[str, float] = json.loads(done.stdout)
    assert found["devices"] == devices
    return found


def test_two_devices_find_what_one_finds(tmp_path: Path) -> None:
    folder = with_small_world(tmp_path)
    one = i2pdsl.Story.from_text(MAP, folder=folder).solve(seed=1)  # there is one here
    two = solved(MAP, folder, 2)
    np.testing.assert_allclose(two["scores"], [each.score for each in one.candidates], rtol=1e-5)


@pytest.mark.slow
def test_seeds_are_shared_out(tmp_path: Path) -> None:
    """Seeds that do not divide evenly among the devices go to fewer of them."""
    one, four, three = (solved(PLANE, tmp_path, devices) for devices in (1, 4, 3))
    np.testing.assert_allclose(four["scores"], one["scores"], rtol=1e-2)
    np.testing.assert_allclose(three["scores"], one["scores"], rtol=1e-2)
