"""i2pdsl: stories told to a simulated audience, by inverse inverse planning.

>>> import i2pdsl
>>> story = i2pdsl.load("stories/kitchen/help.story")
>>> result = story.solve(seed=0)
>>> result.script.query("P(rho > 0 | script[:t])")

After Chandra, Li, Tenenbaum and Ragan-Kelley 2023, DOI 10.1145/3588432.3591510.
"""

from __future__ import annotations

import i2pdsl.forks  # noqa: F401  looks whether a process is forked, from now on

TYPE_CHECKING = False  # as typing's, which takes time to import
if TYPE_CHECKING:
    from typing import Any

    from i2pdsl.errors import Diagnostic, StoryError
    from i2pdsl.pipeline import Answer, Result, Script, Story, load

__version__ = "0.1.0"
__all__ = ["Answer", "Diagnostic", "Result", "Script", "Story", "StoryError", "load"]

_ERRORS = ("Diagnostic", "StoryError")


def __getattr__(name: str) -> Any:
    """Imports the public names when they are first used, so that `i2p check` starts at once."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    if name in _ERRORS:
        return getattr(importlib.import_module("i2pdsl.errors"), name)
    importlib.import_module("i2pdsl.notebook.display")  # so that notebooks show what they get
    return getattr(importlib.import_module("i2pdsl.pipeline"), name)


def load_ipython_extension(shell: Any) -> None:
    """`%load_ext i2pdsl` in a notebook: the magics `%%story`, `%query` and `%%query`."""
    import i2pdsl.notebook.display  # noqa: F401  registers itself
    from i2pdsl.notebook.magic import load_magics

    load_magics(shell)
