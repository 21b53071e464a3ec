"""JAX as this library uses it: with settings of our own while we compute, on a machine that may
lack what the user's environment asks for, and never in a forked process.

Nothing of JAX is imported before it is needed.
"""

from __future__ import annotations

import os
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

from i2pdsl.forks import jax_is_lost, jax_is_running

Say = Callable[[str], None]

# What our programs were written for. The names are JAX's own context managers, of this thread only.
_OURS: dict[str, Any] = {
    "check_tracer_leaks": False,
    "debug_infs": False,
    "debug_nans": False,
    "default_matmul_precision": None,
    "default_prng_impl": "threefry2x32",
    "disable_jit": False,
    "enable_custom_prng": False,
    "enable_x64": False,
    "log_compiles": False,
    "numpy_dtype_promotion": "standard",
    "numpy_rank_promotion": "allow",
    "threefry_partitionable": True,
    "transfer_guard": "allow",
}
# Settings of the whole process, changed while anybody computes and put back afterwards. What we
# compile is kept by programs.py, not among the user's own programs.
_CODE_CACHE = "jax_compilation_cache_dir"
_GLOBAL: dict[str, Any] = {
    _CODE_CACHE: None,
    # What programs.py does not compile are single operations, which are compiled for longer than
    # they run: 10 to 100 ms, and a third of that without optimizing.
    "jax_disable_most_optimizations": True,
    "jax_no_execution": False,
    "jax_no_tracing": False,
    "jax_raise_persistent_cache_errors": False,
    "jax_random_seed_offset": 0,
}

FORKED = (
    "JAX was already running when this process was forked, and would hang in it; start processes "
    'with multiprocessing.get_context("spawn")'
)


class NoComputing(RuntimeError):
    """JAX cannot run in this process: its environment is wrong, or it was forked."""


_lock = threading.RLock()
_depth = 0  # blocks that compute just now, in all threads
_before: dict[str, Any] = {}  # the user's settings


@contextmanager
def computing(say: Say | None = None) -> Iterator[None]:
    """JAX started and with our settings; afterwards those of the user are as they were.

    Modules that import JAX are imported inside. `say` is told what of the environment cannot be
    had (without it, a warning); raises NoComputing where nothing can be computed.
    """
    global _depth
    if jax_is_lost():
        raise NoComputing(FORKED)
    jax = _jax()
    with _lock:
        _depth += 1
        if _depth == 1:
            _before.update(jax.config.values)
            _change(jax, _GLOBAL)
    try:
        with _lock:
            _start(jax, say or (lambda message: warnings.warn(message, stacklevel=5)))
        with ExitStack() as ours:
            for name, value in _OURS.items():
                place = jax if hasattr(jax, name) else jax.experimental
                if hasattr(place, name):  # not every version has all of them
                    ours.enter_context(getattr(place, name)(value))
            yield
    finally:
        with _lock:
            _depth -= 1
            if _depth == 0:
                _change(jax, _before)
                _before.clear()


def _change(jax: Any, settings: dict[str, Any]) -> None:
    """Changes global settings of JAX, those that this version has."""
    now = jax.config.values
    for name, value in settings.items():
        if name in now and now[name] != value:
            jax.config.update(name, value)
            if name == _CODE_CACHE:
                from jax.experimental.compilation_cache import compilation_cache

                compilation_cache.reset_cache()  # JAX looks at the setting once


def _jax() -> Any:
    """The module. Raises NoComputing where a variable of the environment has no value of JAX's."""
    try:
        import jax
        import jax.experimental
    except ValueError as problem:
        import re

        what = re.sub(r"JAX flag (\w+)", lambda found: found[1].upper(), str(problem))
        raise NoComputing(f"the environment's settings of JAX: {what}") from None
    return jax


def _start(jax: Any, say: Say) -> None:
    """Starts JAX, on the CPU where the environment asks for what is not there."""
    flags = os.environ.get("XLA_FLAGS")
    mistake = _mistake_in_flags(jax) if flags and not jax_is_running() else None
    if mistake is not None:
        say(f"XLA_FLAGS={flags} is left out: {mistake}")
        del os.environ["XLA_FLAGS"]
    try:
        _start_somewhere(jax, say)
    finally:
        if mistake is not None and flags is not None:
            os.environ["XLA_FLAGS"] = flags


def _start_somewhere(jax: Any, say: Say) -> None:
    try:
        jax.devices()
        return
    except Exception as problem:  # JAX raises RuntimeError and AssertionError
        reason = _in_words(problem)
    variables = ("JAX_PLATFORMS", "JAX_PLATFORM_NAME")
    asked = [f"{v}={_before[v.lower()]}" for v in variables if _before.get(v.lower())]
    if not asked:
        raise NoComputing(f"JAX does not start{reason}")
    jax.config.update("jax_platforms", "cpu")
    jax.config.update("jax_platform_name", "")
    try:
        jax.devices()
    except Exception as problem:
        raise NoComputing(f"JAX does not start{_in_words(problem)}") from None
    say(f"{' '.join(asked)} cannot be had here{reason}; computing on {jax.default_backend()}")


def _in_words(problem: Exception) -> str:
    """The first line of a reason, in brackets, without JAX's advice."""
    reason = str(problem).partition(" (set JAX_PLATFORMS")[0].partition("\n")[0].rstrip(" .")
    return f" ({reason})" if reason else ""


def _mistake_in_flags(jax: Any) -> str | None:
    """What XLA does not understand of XLA_FLAGS. It ends the process then: a child tries them."""
    if not hasattr(os, "fork") or threading.active_count() > 1:
        return None
    end, start = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            import resource

            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            os.dup2(start, 2)
            jax.config.update("jax_platforms", "cpu")  # no time for other devices; same flags
            jax.devices()
        finally:
            os._exit(0)  # an exception is met again; what XLA does is none
    os.close(start)
    with os.fdopen(end, encoding="utf-8", errors="replace") as stream:
        said = stream.read()
    if os.waitpid(child, 0)[1] == 0:
        return None
    told = [line.partition("] ")[2] for line in said.splitlines() if "XLA_FLAGS" in line]
    return told[0] if told else "XLA does not understand it"
