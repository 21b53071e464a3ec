"""i2pdsl: stories told to a simulated audience, by inverse inverse planning.

>>> import i2pdsl
>>> story = i2pdsl.load("stories/kitchen/help.story")
>>> result = story.solve(seed=0)
>>> result.script.query("P(rho > 0 | script[:t])")

After Chandra, Li, Tenenbaum and Ragan-Kelley 2023, DOI 10.1145/3588432.3591510.
"""

from __future__ import annotations

import i2pdsl.forks  # noqa: F401  looks whether a process is forked, from now on
from i2pdsl.shown import desks_are, shows_later

TYPE_CHECKING = False  # as typing's, which takes time to import
if TYPE_CHECKING:
    from typing import Any

    from i2pdsl.errors import Diagnostic, StoryError
    from i2pdsl.questions import query
    from i2pdsl.stories import Answer, Result, Script, Story, load

__version__ = "0.1.0"
__all__ = ["Answer", "Diagnostic", "Result", "Script", "Story", "StoryError", "load", "query"]

_PLACES = {"Diagnostic": "errors", "StoryError": "errors", "query": "questions"}


def __getattr__(name: str) -> Any:
    """Imports the public names when they are first used, so that `i2p check` starts at once."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    module = importlib.import_module(f"i2pdsl.{_PLACES.get(name, 'stories')}")
    return getattr(module, name)


def _show() -> None:
    import i2pdsl.notebook.display  # noqa: F401  says how notebooks show things


def _desk(story: Story) -> Any:
    import importlib

    return importlib.import_module("i2pdsl.studio.cell").StudioWidget(story)


shows_later(_show)
desks_are(_desk)


def load_ipython_extension(shell: Any) -> None:
    """`%load_ext i2pdsl` in a notebook: the magics `%%story`, `%query` and `%%query`."""
    from i2pdsl.notebook.magic import load_magics

    load_magics(shell)
