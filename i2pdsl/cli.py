"""The command `i2p`: arguments in, results on standard output, messages on standard error.

Exit status (interfaces.md): 0 done, 1 the story, world or script is wrong, 2 wrong usage,
130 interrupted. The commands are in i2pdsl/commands/, imported once interrupts are met.
"""

from __future__ import annotations

import gc
import os

from i2pdsl.interrupts import INTERRUPTED, Terminated, finish, ready, watch_signals

TYPE_CHECKING = False  # as typing's, which takes time to import
if TYPE_CHECKING:
    from typing import Any


def main(arguments: list[str] | None = None) -> None:
    """The program."""
    watch_signals()
    # A command ends soon, and what it imports stays: looking for garbage in it took a tenth of it.
    gc.set_threshold(20_000, 20, 20)
    os.environ["MPLBACKEND"] = "agg"  # of windows, which we have none of; a wrong one is fatal
    # Our matrices are small, and threads of a BLAS wait for each other by spinning.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from i2pdsl.commands.program import run_command

    status = INTERRUPTED
    try:
        ready()
        status = run_command(arguments)
    except (KeyboardInterrupt, Terminated):
        pass  # another one, while the first was being told
    finish(status)


def __getattr__(name: str) -> Any:
    """`run_command` and all else of i2pdsl/commands/program.py."""
    if name.startswith("__"):  # the import system looks for some
        raise AttributeError(name)
    from i2pdsl.commands import program

    return getattr(program, name)


if __name__ == "__main__":
    main()
