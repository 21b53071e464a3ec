"""What stops the program `i2p`: Ctrl-C, the end of its terminal, and being told to end.

SIGINT and SIGHUP raise KeyboardInterrupt (exit status 130), SIGTERM raises Terminated (the process
ends by that signal, as usual). Neither comes in the middle of an import, whose half-made modules,
and exceptions turned into others, would hide it; it comes as soon as the import is done. This
module is imported before anything that takes time, and imports nothing that does.
"""

from __future__ import annotations

import os
import sys

TYPE_CHECKING = False  # as typing's, which takes time to import
if TYPE_CHECKING:
    import signal
    from types import FrameType
    from typing import NoReturn
else:
    import _signal as signal  # the same without its enumerations, which take longer than all this

INTERRUPTED = 130  # exit status (interfaces.md)
_SOON = 0.02  # seconds until a signal that came at a bad moment is tried again


class HungUp(KeyboardInterrupt):
    """The terminal is gone: nobody can be asked anything more."""


class Terminated(SystemExit):
    """Somebody told the process to end."""


_came: list[int] = []  # signals that were met, in their order
_ready = False  # whether interrupts can be told and cleaned up after


def watch_signals() -> None:
    """From now on an interrupt ends the process at once, until `ready`: nothing is begun yet."""
    for name in ("SIGINT", "SIGHUP", "SIGTERM"):
        number = getattr(signal, name, None)
        # Who started us may have said that we are to go on (nohup): then it is ignored.
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _on_signal)
    sys.unraisablehook = keep_interrupt


def ready() -> None:
    """From now on interrupts are raised."""
    global _ready
    _ready = True


def finish(status: int) -> NoReturn:
    """Ends the process with a status; no interrupt comes in between.

    What goes wrong because of an interrupt (a program that we use is ended too) is one as well.
    """
    for name in ("SIGINT", "SIGHUP", "SIGTERM", "SIGALRM"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    if not _came:
        sys.exit(status)
    # JAX may still be computing: to take Python down around its threads crashes (SIGSEGV).
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError, AttributeError):
            continue
    _leave(_came[-1], INTERRUPTED if status else status)


def keep_interrupt(lost: sys.UnraisableHookArgs) -> None:
    """Sends again what Python would drop: in JAX's callback of the garbage collector."""
    if issubclass(lost.exc_type, Terminated):
        _again(signal.SIGTERM)
    elif issubclass(lost.exc_type, KeyboardInterrupt):
        _again(signal.SIGINT)
    else:
        sys.__unraisablehook__(lost)


def _on_signal(number: int, frame: FrameType | None) -> None:
    _came.append(number)
    if not _ready:
        try:
            os.write(2, b"interrupted\n" if number != signal.SIGTERM else b"")
        finally:
            _leave(number, INTERRUPTED)
    if _is_importing(frame):
        _again(number)
    elif number == signal.SIGTERM:
        raise Terminated(128 + number)
    elif number == signal.SIGINT:
        raise KeyboardInterrupt
    else:
        raise HungUp


def _again(number: int) -> None:
    """Sends a signal once more, soon."""
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, lambda alarm, frame: signal.raise_signal(number))
        signal.setitimer(signal.ITIMER_REAL, _SOON)


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _leave(number: int, status: int) -> NoReturn:
    """Ends the process at once: by SIGTERM if it is that, else with a status."""
    if number == signal.SIGTERM:
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
    os._exit(status)
