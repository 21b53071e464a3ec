"""Compiled programs on disk: what was compiled for one world or story serves all of its shape.

A file of the cache is machine code, which is run as it is; so it is signed (signed.py).
"""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
from jax.experimental import serialize_executable

from i2pdsl.signed import read_signed, signed_path, write_signed

Array = Any
Say = Callable[[str], None]

# A program is made of these files; another version of them makes other programs.
_SOURCES = ("audience", "objective", "planning", "programs.py", "search", "sizes.py", "worlds")
_LIBRARIES = ("equinox", "jax", "jaxlib", "jaxopt", "optax", "optimistix")

_MOST_BYTES = 256 * 2**20  # of a file: a program has some 1 MB


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


# How hard the compiler tries: BRIEF programs are compiled in a third of the time of LASTING ones
# (the kitchen's search: 1.2 s, 4 s) and run ten times as long. Not asked for, since they cost more
# than they bring: the usual level (2 or 3); the fusion emitters, which make LLVM's input by way of
# MLIR (half as long again to compile, a tenth faster at best); and the library YNN, which takes
# twice as long as XLA's own loops for sums as short as ours.
Options = dict[str, str | bool]
LEVEL = "xla_backend_optimization_level"
LASTING: Options = {
    LEVEL: "1",
    "xla_llvm_disable_expensive_passes": False,  # computing.py asks for them to be left out
    "xla_cpu_use_fusion_emitters": False,
    "xla_cpu_experimental_ynn_fusion_type": "",
}
BRIEF: Options = {**LASTING, LEVEL: "0"}
FOR_HOURS: Options = {LEVEL: "3", "xla_llvm_disable_expensive_passes": False}  # XLA's own default

_memory: dict[tuple[str, bool], Program] = {}
_MOST_KEPT = 64  # programs in memory: who edits stories for hours asks for one after the other


def compiled_program(
    key: tuple[Any, ...],
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    result: Any,
    say: Say | None = None,
    brief: bool = False,
    apart: tuple[int, ...] = (),
) -> Program:
    """`function` compiled for arrays like those of `arguments`; from memory or from the cache if it
    was compiled before.

    Args:
        key: everything that the program depends on besides the arrays' shapes.
        function: of trees of arrays; traced only where the cache does not have it.
        result: a tree like the one that the function returns.
        say: is told of damaged entries, which are made again.
        brief: whether it runs so briefly that a slower program which is there sooner is better.
        apart: which of the arguments have another axis in front, for devices: each computes the
            function with its own share of them. The results have that axis too.
    """
    leaves, structure = jax.tree.flatten(arguments)
    split = [n in apart for n, each in enumerate(arguments) for _ in jax.tree.leaves(each)]
    devices = len(leaves[split.index(True)]) if apart else 1
    shapes = [
        jax.ShapeDtypeStruct(a.shape, a.dtype, sharding=_place(part, devices))
        for a, part in zip(leaves, split, strict=True)
    ]
    description = repr((key, brief, [(s.shape, str(s.dtype)) for s in shapes], apart))
    known = (description, bool(jax.config.jax_enable_x64))  # type: ignore[attr-defined]
    if known in _memory:
        _memory[known] = _memory.pop(known)  # the last one to be forgotten
        return replace(_memory[known], is_new=False)

    def flat(*arrays: Array) -> list[Array]:
        return jax.tree.leaves(function(*jax.tree.unflatten(structure, arrays)))

    ending = jax.tree.structure(result)
    say = say or (lambda message: None)
    path = _program_path(description, say)
    compiled = _load(path, len(shapes), len(jax.tree.leaves(result)), devices, say)
    is_new = compiled is None
    if compiled is None:
        side_by_side = _on_devices(flat, split, devices) if apart else flat
        compiled = _compile(side_by_side, shapes, BRIEF if brief else LASTING)
        _store(path, compiled, say)
    ready = compiled

    def run(*given: Any) -> Any:
        return jax.tree.unflatten(ending, ready(*jax.tree.leaves(given)))

    shape = hashlib.sha256(description.encode()).hexdigest()[:16]
    program = _memory[known] = Program(run, shape, is_new)
    while len(_memory) > _MOST_KEPT:
        del _memory[next(iter(_memory))]
    return program


def _program_path(description: str, say: Say) -> Path | None:
    """The file of a program, or None where none can be kept; that is said once."""
    try:
        return signed_path("program", f"{_fingerprint()} {description}")
    except OSError as problem:
        _say_once(f"compiled programs are not kept for the next run: {problem}", say)
    return None


_said: set[str] = set()


def _say_once(message: str, say: Say) -> None:
    if message not in _said:
        _said.add(message)
        say(message)


@cache
def _fingerprint() -> str:
    """The versions and the machine: what else a program depends on."""
    package = Path(__file__).parent
    content = hashlib.sha256()
    for name in _SOURCES:
        source = package / name
        for path in sorted(source.rglob("*.py")) if source.is_dir() else [source]:
            content.update(path.read_bytes())
    versions = " ".join(f"{name} {version(name)}" for name in _LIBRARIES)
    devices = [d.device_kind for d in jax.devices()]
    flags = os.environ.get("XLA_FLAGS", "")
    return f"{versions} {devices} {_processor()} {flags} {content.hexdigest()}"


def _processor() -> str:
    """What the processor can do: machine code for one is not for every other."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return platform.platform()
    said = ("model name", "flags", "Features")
    lines = {line for line in text.splitlines() if line.startswith(said)}
    return hashlib.sha256("".join(sorted(lines)).encode()).hexdigest()


def _on_devices(
    function: Callable[..., list[Array]], split: list[bool], devices: int
) -> Callable[..., list[Array]]:
    """The function on several devices, with what is split between them."""

    def on_each(*arrays: Array) -> list[Array]:
        mine = (a[0] if part else a for a, part in zip(arrays, split, strict=True))
        return [made[None] for made in function(*mine)]

    if devices == 1:
        return on_each
    own, shared = jax.P("device"), jax.P()
    # What devices share stays shared without a proof that they agree on it (check_vma).
    return jax.shard_map(
        on_each,
        mesh=_mesh(devices),
        in_specs=tuple(own if part else shared for part in split),
        out_specs=own,
        check_vma=False,
    )


def _mesh(devices: int) -> jax.sharding.Mesh:
    return jax.make_mesh((devices,), ("device",), devices=jax.devices()[:devices])


def _place(is_split: bool, devices: int) -> jax.NamedSharding | None:
    """Where an argument lies, if there are several devices."""
    if devices == 1:
        return None
    return jax.NamedSharding(_mesh(devices), jax.P("device") if is_split else jax.P())


def on_devices(arrays: Any, devices: int, apart: bool = False) -> Any:
    """A tree of arrays that several devices share, copied to each of them once; or `apart`, where
    each has its own part along their first axis."""
    if devices == 1 and not apart:
        return arrays
    return jax.device_put(arrays, _place(apart, devices))


def _compile(
    function: Callable[..., list[Array]],
    shapes: list[jax.ShapeDtypeStruct],
    options: Options,
) -> jax.stages.Compiled:
    return compiled(jax.jit(function).lower(*shapes), options)


def compiled(lowered: jax.stages.Lowered, options: Options = LASTING) -> jax.stages.Compiled:
    """A lowered function compiled as hard as ours are."""
    try:
        return lowered.compile(compiler_options=options)
    except jax.errors.JaxRuntimeError as problem:
        if "No such compile option" not in str(problem):  # options of XLA come and go
            raise
    return lowered.compile(compiler_options={LEVEL: options[LEVEL]})


def once(function: Callable[..., Any], *arguments: Any, options: Options = BRIEF) -> Any:
    """What a function of trees of arrays returns: for what is computed once in a run, as a single
    program that is there soon."""
    return compiled(jax.jit(function).lower(*arguments), options)(*arguments)


def _load(
    path: Path | None, given: int, made: int, devices: int, say: Say
) -> Callable[..., Any] | None:
    """The program in a file, for so many arguments, results and devices, or None."""
    if path is None:
        return None
    try:
        return serialize_executable.deserialize_and_load(
            read_signed(path, _MOST_BYTES),
            jax.tree.structure(((0,) * given, {})),
            jax.tree.structure([0] * made),
            execution_devices=jax.devices()[:devices],
        )
    except FileNotFoundError:
        return None
    except OSError as problem:
        say(f"the cached program {path.name} cannot be read: {problem.strerror}; it is made again")
    except Exception as problem:  # whatever makes the loader raise
        say(f"the cached program {path.name} is damaged ({problem}); it is made again")
    return None


def _store(path: Path | None, compiled: jax.stages.Compiled, say: Say) -> None:
    if path is None:
        return
    program, _, _ = serialize_executable.serialize(compiled)
    try:
        write_signed(path, program)
    except OSError as problem:
        _say_once(f"compiled programs are not kept for the next run: {problem}", say)
