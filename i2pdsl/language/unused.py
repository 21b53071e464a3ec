"""Mistakes in lets and patterns that nothing uses, as far as they can be told."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from i2pdsl.errors import Diagnostic
from i2pdsl.language import ast
from i2pdsl.language.elaborate import Elaborator
from i2pdsl.language.elaboration import LeavesAtZero, Stop
from i2pdsl.language.names import Report, check_names
from i2pdsl.language.scope import Env, Module

# What depends on the sum that a `let` will be put into.
_DEPENDS_ON_USE = ("index", "range", "arithmetic", "free-time", "nested-sum", "certain", "type")
_REPORTED_HERE = ("recursion",)
_LONGEST_SHOWN = 12  # names of a circle


def check_unused(
    program: ast.Program, module: Module, elaborator: Elaborator | None, report: Report
) -> None:
    """Checks every definition of a file that nothing has put in yet.

    Without an elaborator the file is a library, and the world unknown.
    """
    used = elaborator.used if elaborator is not None else set()
    unused = [d for d in program.statements if isinstance(d, ast.Let | ast.Pattern)]
    unused = [d for d in unused if id(d) not in used]
    probe = _probe(elaborator, report) if elaborator is not None else None
    named = [a.name for a in elaborator.audiences] if elaborator is not None else []
    for definition in unused:
        if isinstance(definition, ast.Let) and probe is not None:
            if id(definition) not in probe.used:
                _check_let(definition, module, probe, report)
            continue
        world = elaborator.world if elaborator is not None else None
        parameters: list[str] = []
        if isinstance(definition, ast.Pattern):
            parameters = [p.name.id for p in definition.parameters]
            for parameter in definition.parameters:
                if parameter.default is not None:
                    check_names(parameter.default, module, parameters, world, report, named)
            body = definition.body
        else:
            body = definition.value
        check_names(body, module, parameters, world, report, named)
    check_circles(unused, module, report)


def _probe(elaborator: Elaborator, report: Report) -> Elaborator:
    """Elaborates what nothing uses, and reports what is wrong wherever it will be put in."""

    def report_certain(problem: Diagnostic) -> None:
        if problem.code not in (*_DEPENDS_ON_USE, *_REPORTED_HERE):
            report(problem)

    probe = Elaborator(elaborator.world, elaborator.length, report_certain, query=True)
    probe.assumption, probe.used = elaborator.assumption, elaborator.used
    probe.audiences = elaborator.audiences
    return probe


def _check_let(let: ast.Let, module: Module, probe: Elaborator, report: Report) -> None:
    """Elaborates a `let` as what it seems to be: an event, a quantity, or a number over t."""
    parts = list(ast.walk(let.value))
    calls = {p.callee.id for p in parts if isinstance(p, ast.Call)}
    names = {p.id for p in parts if isinstance(p, ast.Name)}
    names |= {a.name.id for p in parts if isinstance(p, ast.Call) for a in p.arguments if a.name}
    if isinstance(let.value, ast.Name) or calls & probe.world.predicates.keys():
        named = [audience.name for audience in probe.audiences]
        check_names(let.value, module, (), probe.world, report, named)
        return
    env = Env(module, times=range(1, probe.length + 1))
    if any(isinstance(p, ast.Form) and not ast.is_belief(p) for p in parts):
        env = replace(env, inside="quantity")
    elif names & probe.world.latents.keys():
        env = replace(env, inside="event")
    if any(ast.is_belief(p) or isinstance(p, ast.Script) for p in parts):
        env = replace(env, inside="")
    try:
        probe.item(let.value, env)
    except (Stop, LeavesAtZero):
        return


def check_circles(definitions: list[ast.Let | ast.Pattern], module: Module, report: Report) -> None:
    """Reports each circle of definitions once, where it closes."""
    ours = {d.name.id: d for d in definitions}
    done: set[str] = set()
    for name in ours:
        found = module.names.get(name)
        if name not in done and found is not None and found.item is ours[name]:
            _follow(name, ours, done, report)


def _follow(
    first: str, ours: dict[str, ast.Let | ast.Pattern], done: set[str], report: Report
) -> None:
    """Follows the names that a definition uses. No recursion: chains are as long as a story."""
    chain = {first: _used_names(ours[first])}
    while chain:
        name = next(reversed(chain))
        used = next(chain[name], None)
        if used is None:
            done.add(name)
            del chain[name]
        elif used.id in chain:
            names = list(chain)
            circle = [*names[names.index(used.id) :], used.id]
            if len(circle) > _LONGEST_SHOWN:
                circle = [*circle[: _LONGEST_SHOWN - 2], f"... ({len(circle) - 1} names)", used.id]
            message = f"`{used.id}` is defined by itself: {' -> '.join(circle)}"
            report(Diagnostic("recursion", message, used.span))
            done.update(chain)
        elif used.id in ours and used.id not in done:
            chain[used.id] = _used_names(ours[used.id])


def _used_names(definition: ast.Let | ast.Pattern) -> Iterator[ast.Name]:
    """The names in a definition that are not its own parameters."""
    own: set[str] = set()
    bodies: list[ast.Expr] = []
    if isinstance(definition, ast.Pattern):
        own = {p.name.id for p in definition.parameters}
        bodies = [p.default for p in definition.parameters if p.default is not None]
        bodies.append(definition.body)
    else:
        bodies.append(definition.value)
    for part in (p for body in bodies for p in ast.walk(body)):
        if isinstance(part, ast.Call) and part.callee.id not in own:
            yield part.callee
        # In a comparison a name may be a value of its latent: `let pink = G_cheese = pink`.
        if not isinstance(part, ast.Compare | ast.Member | ast.SetOf):
            names = (p for p in ast.children(part) if isinstance(p, ast.Name))
            yield from (name for name in names if name.id not in own)
    yield from (b for b in bodies if isinstance(b, ast.Name) and b.id not in own)
