"""Compiled programs on disk: a story whose shape was searched before starts without tracing.

Two caches work together: the traced program (StableHLO, by jax.export; no pickle) and XLA's own
cache of compiled code. Both may be deleted, damaged or shared at any time.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
import jax.export

from i2pdsl.resources import atomic_path, cache_folder

Array = Any

# A program is made of these files; another version of them makes other programs.
_SOURCES = ("audience", "objective", "planning", "programs.py", "search", "worlds")
_LIBRARIES = ("equinox", "jax", "jaxlib", "jaxopt", "optax", "optimistix")


@dataclass(frozen=True)
class Program:
    """A compiled program.

    Attributes:
        run: of the arguments that it was compiled for, or others of their shapes.
        shape: its name, whatever the versions and the machine.
        is_new: whether the cache did not have it.
    """

    run: Callable[..., Any]
    shape: str
    is_new: bool


_memory: dict[str, Program] = {}


def compiled_program(
    key: tuple[Any, ...],
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    result: Any,
    say: Callable[[str], None] | None = None,
) -> Program:
    """`function` compiled for arrays like those of `arguments`; from memory or from the cache if it
    was compiled before.

    Args:
        key: everything that the program depends on besides the arrays' shapes.
        function: of trees of arrays; traced only where the cache does not have it.
        result: a tree like the one that the function returns.
        say: is told of damaged entries, which are made again.
    """
    leaves, structure = jax.tree.flatten(arguments)
    shapes = [jax.ShapeDtypeStruct(a.shape, a.dtype) for a in leaves]
    description = repr((key, [(s.shape, str(s.dtype)) for s in shapes]))
    if description in _memory:
        return replace(_memory[description], is_new=False)

    def flat(*arrays: Array) -> list[Array]:
        return jax.tree.leaves(function(*jax.tree.unflatten(structure, arrays)))

    compiled, is_new = _compiled(description, flat, shapes, say or (lambda message: None))
    ending = jax.tree.structure(result)

    def run(*given: Any) -> Any:
        return jax.tree.unflatten(ending, compiled(*jax.tree.leaves(given)))

    shape = hashlib.sha256(description.encode()).hexdigest()[:16]
    _memory[description] = Program(run, shape, is_new)
    return _memory[description]


def _compiled(
    description: str,
    function: Callable[..., list[Array]],
    shapes: list[jax.ShapeDtypeStruct],
    say: Callable[[str], None],
) -> tuple[Callable[..., Any], bool]:
    """A function of flat arrays, compiled, and whether it had to be traced."""
    _enable_compilation_cache()
    digest = hashlib.sha256(f"{_fingerprint()} {description}".encode()).hexdigest()[:32]
    path = _program_path(digest)
    exported = _load(path, say)
    is_new = exported is None
    if exported is None:
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
    return compiled, is_new


@cache
def _fingerprint() -> str:
    """The versions that matter."""
    package = Path(__file__).parent
    content = hashlib.sha256()
    for name in _SOURCES:
        source = package / name
        for path in sorted(source.rglob("*.py")) if source.is_dir() else [source]:
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
