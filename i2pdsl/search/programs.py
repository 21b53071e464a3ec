"""Compiled programs on disk: a story whose shape was searched before starts without tracing.

Two caches work together: the traced program (StableHLO, by jax.export; no pickle) and XLA's own
cache of compiled code. Both may be deleted, damaged or shared at any time.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
import jax.export

from i2pdsl.resources import atomic_path, cache_folder

Array = Any

# A program is made of these files; another version of them makes other programs.
_SOURCES = ("audience", "objective", "planning", "search", "worlds")
_LIBRARIES = ("equinox", "jax", "jaxlib", "jaxopt", "optax", "optimistix")


class ReadyError(Exception):
    """Inside `compiling_only`: a program is compiled, and would now be run."""


@dataclass
class Compiling:
    """What was compiled inside `compiling_only`.

    Attributes:
        shape: names the program that was compiled last, whatever the versions and the machine.
        traced: the shapes of those that the cache did not have.
        known: of all programs.
    """

    shape: str = ""
    traced: list[str] = field(default_factory=list)
    known: set[str] = field(default_factory=set)


_compiling: Compiling | None = None


@contextmanager
def compiling_only(compiling: Compiling) -> Iterator[None]:
    """Inside, `compiled_program` compiles (each program once) and raises ReadyError."""
    global _compiling
    before, _compiling = _compiling, compiling
    try:
        yield
    finally:
        _compiling = before


def compiled_program(
    description: str,
    function: Callable[..., Any],
    arguments: Sequence[Array],
    say: Callable[[str], None] | None = None,
) -> Callable[..., Any]:
    """`function` compiled for arrays like `arguments`, from the cache if it was compiled before.

    Args:
        description: names everything that the program depends on besides the arrays' shapes.
        function: of flat arrays; traced only where the cache does not have it.
        say: is told of damaged entries, which are made again.
    """
    say = say or (lambda message: None)
    _enable_compilation_cache()
    shapes = [jax.ShapeDtypeStruct(a.shape, a.dtype) for a in arguments]
    digest = hashlib.sha256(f"{_fingerprint()} {description}".encode()).hexdigest()[:32]
    path = _program_path(digest)
    if _compiling is not None:
        _compiling.shape = hashlib.sha256(description.encode()).hexdigest()[:16]
        if digest in _compiling.known:
            raise ReadyError
    exported = _load(path, say)
    if exported is None:
        if _compiling is not None:
            _compiling.traced.append(_compiling.shape)
        exported = jax.export.export(jax.jit(function))(*shapes)
        _store(path, exported, say)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        compiled = jax.jit(exported.call).lower(*shapes).compile()
    if any("compilation cache" in str(w.message) for w in caught):
        # JAX never overwrites an entry that it cannot read, so all are made anew.
        say("the cache of compiled programs is damaged; it is made again")
        folder = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
        for entry in Path(folder).glob("*-cache"):
            entry.unlink(missing_ok=True)
    if _compiling is not None:
        _compiling.known.add(digest)
        raise ReadyError
    return compiled


@cache
def _fingerprint() -> str:
    """The versions that matter."""
    package = Path(__file__).parent.parent
    content = hashlib.sha256()
    for folder in _SOURCES:
        for path in sorted((package / folder).rglob("*.py")):
            content.update(path.read_bytes())
    versions = " ".join(f"{name} {version(name)}" for name in _LIBRARIES)
    return f"{versions} {jax.default_backend()} {content.hexdigest()}"


def _program_path(digest: str) -> Path | None:
    try:
        return cache_folder("programs") / f"{digest}.jax"
    except OSError:
        return None


def _load(path: Path | None, say: Callable[[str], None]) -> jax.export.Exported | None:
    if path is None:
        return None
    try:
        data = path.read_bytes()
        check, program = data[:32], data[32:]
        if hashlib.sha256(program).digest() != check:
            raise ValueError("the checksum is wrong")
        return jax.export.deserialize(bytearray(program))
    except FileNotFoundError:
        return None
    except Exception as problem:  # whatever a damaged file makes the reader raise
        say(f"the cached program {path.name} is damaged ({problem}); it is made again")
        return None


def _store(path: Path | None, exported: jax.export.Exported, say: Callable[[str], None]) -> None:
    if path is None:
        return
    program = bytes(exported.serialize())
    try:
        with atomic_path(path) as temporary:
            temporary.write_bytes(hashlib.sha256(program).digest() + program)
    except OSError as problem:
        say(f"the compiled program could not be cached: {problem}")


def _enable_compilation_cache() -> None:
    """Keeps XLA's compiled code between runs, unless the user has chosen a place already."""
    if jax.config.jax_compilation_cache_dir is not None:  # type: ignore[attr-defined]
        return
    try:
        folder = cache_folder("compiled")
    except OSError:
        return
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
