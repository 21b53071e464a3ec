"""What the parameters of a pattern are, what a pattern comes to, and which names it uses: read off
its body and the patterns that it passes them on to. Nothing here knows a world.

Kinds (`PARAMETER_KINDS`) are inferred from the places where a parameter stands. They help people,
editors and the proof that a pattern fits a world; the checker does not depend on them.
"""

from __future__ import annotations

from collections.abc import Iterator

from i2pdsl.language import ast
from i2pdsl.language.arguments import MismatchError, bind
from i2pdsl.language.builtins import FUNCTIONS
from i2pdsl.language.forms import HIDDEN
from i2pdsl.language.scope import Module
from i2pdsl.language.statements import room_for_nesting

PARAMETER_KINDS = {
    "event": "something hidden that may hold, such as `rho > 0`",
    "number": "a number",
    "character": "a character of the world",
    "latent": "something hidden about the characters, such as `G_cheese`",
    "value": "a value of a latent",
    "script": "a script, such as `script`",
    "frame": "the number of a frame, such as `T/2`",
    "predicate": "what can be seen in a frame, such as `moved(robot)`",
    "shape": "a number over `t`, such as `t/T`",
    "audience": "an audience of the story, such as `viewers`, those that need no name",
    "any": "any expression",
}
"""What a parameter can be. A pattern's result can also be `first frames` or `one frame`."""

# Where a parameter stands in places of several kinds, the first of these is what fits them all.
_STRICTEST = (
    "audience",
    "script",
    "character",
    "latent",
    "value",
    "predicate",
    "event",
    "frame",
    "number",
    "shape",
)
_DEEPEST_CALLS = 60  # patterns that pass a parameter on to patterns; people need three
_NUMBERS = (
    ast.Number, ast.Length, ast.Time, ast.Sum, ast.Product, ast.Negative, ast.Power, ast.LastOf,
    ast.Reduction, ast.Form, ast.Holds,
)  # fmt: skip
_ABOUT = {"quantity": "number"}  # the kind of what a form is about, where it has another name
_CONDITIONS = (ast.Compare, ast.Member, ast.Not, ast.And, ast.Or)


def parameter_kinds(
    pattern: ast.Pattern, module: Module, inference: Inference | None = None
) -> dict[str, str]:
    """The kind of each parameter, by its name.

    >>> arc = standard_library().names["arc"]
    >>> parameter_kinds(arc.item, arc.module)
    {'who': 'character', 'shape': 'shape', 'scale': 'number', 'steady': 'number'}

    Args:
        module: the names that the pattern's body was written among.
        inference: what is known already, where many patterns are asked about.
    """
    with room_for_nesting():
        return dict((inference or Inference()).kinds(pattern, module))


def result_kind(
    item: ast.Let | ast.Pattern, module: Module, inference: Inference | None = None
) -> str:
    """What a pattern or a `let` comes to: `number` for an objective, `event`, `script`, ...

    `shape` where a `t` is left free, `first frames` for `script[:k]`, `one frame` for `script[k]`.
    """
    with room_for_nesting():
        return (inference or Inference()).result(item, module, 0)


def used_names(item: ast.Let | ast.Pattern, module: Module) -> set[str]:
    """The names in a definition that are not its own parameters."""
    parameters = item.parameters if isinstance(item, ast.Pattern) else ()
    own = {p.name.id for p in parameters}
    bodies = [p.default for p in parameters if p.default is not None]
    bodies.append(item.body if isinstance(item, ast.Pattern) else item.value)
    return {name for body in bodies for name in _names(body, module)} - own


def _names(body: ast.Expr, module: Module) -> Iterator[str]:
    waiting: list[ast.Node] = [body]
    while waiting:
        node = waiting.pop()
        match node:
            case ast.Name(id=name):
                yield name
            case ast.Call(callee=callee):
                yield callee.id
                waiting.extend(arguments_of(node, module).values())
                continue
            case ast.Append(turn=turn):
                for part in turn:
                    words = (
                        (part.who, part.action)
                        if isinstance(part, ast.Move)
                        else (part.event, part.thing)
                    )
                    yield from (word.id for word in words)
        waiting.extend(ast.children(node))


def arguments_of(node: ast.Call, module: Module) -> dict[str, ast.Expr]:
    """The arguments of a call by parameter; by position where no pattern of the module is called,
    or the call does not fit its signature."""
    found = module.find(node.callee.id)
    if found is not None and isinstance(found.item, ast.Pattern):
        try:
            return bind(found.item, node, lambda _: True)
        except MismatchError:
            pass
    return {
        str(number): a.comparison if a.comparison is not None else a.value
        for number, a in enumerate(node.arguments)
    }


class Inference:
    """Follows parameters through patterns; each pattern is read once."""

    def __init__(self) -> None:
        self.known: dict[int, dict[str, str]] = {}
        self.results: dict[int, str] = {}
        self.calls = 0

    def kinds(self, pattern: ast.Pattern, module: Module) -> dict[str, str]:
        found = self.known.get(id(pattern))
        if found is not None:
            return found
        names = [p.name.id for p in pattern.parameters]
        # A pattern that calls itself (an error of its own) finds this.
        self.known[id(pattern)] = dict.fromkeys(names, "any")
        if self.calls >= _DEEPEST_CALLS:
            return self.known[id(pattern)]
        self.calls += 1
        roles: dict[str, set[str]] = {name: set() for name in names}
        reader = _Roles(self, module, roles)
        reader.visit(pattern.body, "number", "")
        self.calls -= 1
        for parameter in pattern.parameters:
            if parameter.default is not None:
                reader.visit(parameter.default, "any", "")
        kinds = {}
        for parameter in pattern.parameters:
            kind = next((k for k in _STRICTEST if k in roles[parameter.name.id]), "any")
            if parameter.default is not None:
                kind = _with_default(kind, parameter.default)
            kinds[parameter.name.id] = kind
        self.known[id(pattern)] = kinds
        return kinds

    def result(self, item: ast.Let | ast.Pattern, module: Module, depth: int) -> str:
        if id(item) not in self.results:
            self.results[id(item)] = "any"
            body = item.body if isinstance(item, ast.Pattern) else item.value
            own = self.kinds(item, module) if isinstance(item, ast.Pattern) else {}
            self.results[id(item)] = self.expression(body, module, own, depth)
        return self.results[id(item)]

    def expression(
        self, node: ast.Expr, module: Module, own: dict[str, str], depth: int = 0
    ) -> str:
        """What an expression comes to; `own` are the kinds of the parameters around it."""
        if depth > _DEEPEST_CALLS:
            return "any"
        match node:
            case ast.Prefix():
                return "first frames"
            case ast.FrameOf():
                return "one frame"
            case ast.Script() | ast.Append():
                return "script"
            case ast.If(then=then):
                kind = self.expression(then, module, own, depth + 1)
                return self.over_time(node, module, own) if kind == "number" else kind
            case ast.Name(id=name) if name in own:
                return own[name]
            case ast.Name(id=name) | ast.Call(callee=ast.Name(id=name)):
                found = module.find(name)
                if found is not None:
                    kind = self.result(found.item, found.module, depth + 1)
                    over = kind == "number" and isinstance(node, ast.Call)
                    return self.over_time(node, module, own) if over else kind
                gives = FUNCTIONS[name].gives if name in FUNCTIONS else ""
                if gives in ("number", "event"):
                    return gives if gives == "event" else self.over_time(node, module, own)
                return "predicate" if isinstance(node, ast.Call) else "any"
        if isinstance(node, ast.Ever):
            return "number" if node.word == "when" else "event"
        if isinstance(node, _CONDITIONS):
            return "event"
        return self.over_time(node, module, own) if isinstance(node, _NUMBERS) else "any"

    def over_time(self, node: ast.Expr, module: Module, own: dict[str, str]) -> str:
        """`shape` where a `t` is free in an expression of numbers, else `number`."""
        waiting: list[ast.Node] = [node]
        while waiting:
            part = waiting.pop()
            match part:
                case ast.Time():
                    return "shape"
                case ast.Reduction():
                    continue
                case ast.Name(id=name) if own.get(name) == "shape":
                    return "shape"
                case ast.Call(callee=callee) if callee.id == "points":
                    return "shape"
                case ast.Call():
                    # The arguments of a pattern are mostly put into its own sum over t.
                    if module.find(part.callee.id) is None:
                        waiting.extend(a.value for a in part.arguments)
                    continue
            waiting.extend(ast.children(part))
        return "number"


class _Roles:
    """Notes in which places the parameters stand, through one body."""

    def __init__(self, inference: Inference, module: Module, roles: dict[str, set[str]]):
        self.inference = inference
        self.module = module
        self.roles = roles

    def visit(self, node: ast.Node, role: str, inside: str) -> None:
        """`role` is what the place of the node wants; `inside` is 'event', 'frame' or ''."""
        match node:
            case ast.Name(id=name):
                if name in self.roles and role != "any":
                    self.roles[name].add(role)
            case ast.Sum(terms=parts) | ast.Product(factors=parts):
                # `turn + 1` is a frame if `turn` is one; `T * share` may be one with any share.
                kept = role if role == "frame" and isinstance(node, ast.Sum) else "number"
                self.each(parts, kept, inside)
            case ast.Negative(operand=operand):
                self.visit(operand, "shape" if role == "shape" else "number", inside)
            case ast.Power(base=base, exponent=exponent):
                self.each((base, exponent), "number", inside)
            case ast.Compare(operands=operands):
                self.compared(operands, inside)
            case ast.Member(item=item, items=items):
                self.compared((item, *items.items), inside)
            case ast.Not(operand=operand):
                self.visit(operand, role, inside)
            case ast.And(operands=operands) | ast.Or(operands=operands):
                self.each(operands, role, inside)
            case ast.If(condition=condition, then=then, otherwise=otherwise):
                self.visit(condition, inside or "any", inside)
                self.each((then, otherwise), role, inside)
            case ast.Reduction(first=first, last=last, body=body):
                self.each([x for x in (first, last) if x is not None], "frame", inside)
                self.visit(body, "number", inside)
            case ast.Prefix(script=script, end=number, until=who):
                self.visit(script, "script", inside)
                self.visit(number, "frame", "")
                self.each(() if who is None else (who,), "character", inside)
            case ast.FrameOf(script=script, number=number):
                self.visit(script, "script", inside)
                self.visit(number, "frame", "")
            case ast.LastOf(script=script):
                self.visit(script, "script", inside)
            case ast.Append(script=script, turn=turn):
                self.visit(script, "script", inside)
                for part in turn:
                    if isinstance(part, ast.Move):
                        self.visit(part.who, "character", inside)
                    self.each(ast.children(part), "any", inside)
            case ast.Form(about=about, given=given):
                believed = "" if node.kind.shape is HIDDEN else "event"
                self.each(about, _ABOUT.get(node.kind.about, node.kind.about), believed or inside)
                self.each(() if node.moment is None else (node.moment,), "any", "")
                self.given(given)
                self.each(() if node.audience is None else (node.audience,), "audience", inside)
            case ast.Ever(predicate=predicate):
                self.visit(predicate, "predicate", "frame")
            case ast.Holds(predicate=predicate, frame=frame):
                self.visit(predicate, "predicate", "frame")
                self.visit(frame, "any", "")
            case ast.Call():
                self.called(node, role, inside)
            case _:
                self.each(ast.children(node), "any", inside)

    def each(self, nodes: object, role: str, inside: str) -> None:
        for node in nodes:  # type: ignore[attr-defined]
            self.visit(node, role, inside)

    def given(self, parts: tuple[ast.Expr, ...]) -> None:
        """Behind a bar: scripts with an index, and conditions."""
        scripts = [isinstance(p, ast.Prefix | ast.FrameOf) for p in parts]
        for part in parts:
            # Without another script the parameter is the script itself, with its index.
            self.visit(part, "event" if any(scripts) else "any", "event")

    def compared(self, operands: tuple[ast.Expr, ...], inside: str) -> None:
        """Events compare latents with their values; elsewhere numbers are compared."""
        if inside != "event":
            frames = any(_counts_frames(operand) for operand in operands)
            self.each(operands, "frame" if frames else "number", inside)
            return
        first, *others = operands
        fixed = any(isinstance(other, ast.Number) for other in others)
        is_ours = isinstance(first, ast.Name) and first.id in self.roles
        if isinstance(first, ast.Name) and (is_ours or not fixed):
            self.visit(first, "latent", inside)
            self.each(others, "value", inside)
        elif isinstance(first, ast.Name):
            self.each(others, "number", inside)
        else:  # `0 < rho`
            self.visit(first, "number", inside)
            self.each(others, "latent", inside)

    def called(self, node: ast.Call, role: str, inside: str) -> None:
        arguments = arguments_of(node, self.module)
        found = self.module.find(node.callee.id)
        kinds: dict[str, str] = {}
        if found is not None and isinstance(found.item, ast.Pattern):
            kinds = self.inference.kinds(found.item, found.module)
        function = FUNCTIONS.get(node.callee.id) if found is None else None
        for number, (name, value) in enumerate(arguments.items()):
            usual = function.argument(number) if function is not None else "any"
            kind = kinds.get(name, usual)
            self.visit(value, kind, "event" if kind in ("event", "latent") else inside)


def _counts_frames(node: ast.Expr) -> bool:
    """`t`, `t - 1` or `when [...]`: what is compared with it is the number of a frame."""
    if isinstance(node, ast.Sum):
        return any(_counts_frames(term) for term in node.terms)
    return isinstance(node, ast.Time) or (isinstance(node, ast.Ever) and node.word == "when")


def _with_default(kind: str, default: ast.Expr) -> str:
    """The kind of a parameter whose default says more than its places, or the contrary."""
    parts = list(ast.walk(default))
    if isinstance(default, ast.Script | ast.Append):
        return "script"
    if kind in ("any", "number", "shape"):
        calls = {p.callee.id for p in parts if isinstance(p, ast.Call)}
        if any(isinstance(p, ast.Time) for p in parts) or "points" in calls:
            return "shape"
        if isinstance(default, _CONDITIONS) and kind == "any":
            return "event"
        if isinstance(default, _NUMBERS):
            return "number"
    return kind
