"""What a story's text is made of, for hands: its wishes, pins, numbers and drawn curves."""

from __future__ import annotations

from typing import Any

from i2pdsl.pipeline import Story
from i2pdsl.studio.folder import Folder


def outline(story: Story, folder: Folder) -> dict[str, Any]:
    typed = story.typed
    return {
        "name": typed.name,
        "world": typed.world,
        "length": [typed.lengths[0].length if typed.lengths else typed.length, typed.length],
    }
