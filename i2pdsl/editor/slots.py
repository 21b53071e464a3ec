"""What makes sense at a place: an event, a value of a latent, a script, the name of a setting..."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lark import Token

from i2pdsl.editor.enclosure import COMPARISONS, Enclosure, argument_name
from i2pdsl.editor.surroundings import Surroundings
from i2pdsl.language import ast
from i2pdsl.language.builtins import FUNCTIONS
from i2pdsl.language.forms import ABOUT, APART, BY_NAME, EXPECTED, UNSURE
from i2pdsl.language.kinds import parameter_kinds
from i2pdsl.language.scope import Module
from i2pdsl.language.settings import OF_VIEWERS
from i2pdsl.language.vocabulary import Weights

_ARITHMETIC = ("PLUS", "MINUS", "STAR", "SLASH", "CARET")
_OF_PARAMETER = {
    "number": "number",
    "shape": "number",
    "frame": "number",
    "event": "event",
    "character": "character",
    "latent": "latent",
    "value": "values",
    "script": "script",
    "predicate": "predicate",
    "thing": "thing",
    "object": "object",
    "place": "place",
    "spot": "spot",
    "audience": "whose",
}
_OF_STATEMENT = {
    "world": "world",
    "length": "nothing",
    "start": "state",
    "allow": "occurrence",
    "import": "library",
    "maximize": "number",
    "minimize": "number",
    **dict.fromkeys(Weights._fields, "constant"),
    "assume": "assumption",
    "audience": "audience",
    "search": "search",
    "require": "condition",
    "pin": "script",
}


def _first_part(word: str) -> str:
    """What the first part of a form holds; that of `last` is a script."""
    form = BY_NAME.get(word)
    if form is None or not form.about:
        return "script"
    return f"{form.about} or script" if form.shape in (APART, UNSURE) else form.about


@dataclass(frozen=True)
class Slot:
    """What makes sense at a place.

    Attributes:
        kind: any, number, constant, event, quantity, condition (of frames and numbers), latent,
            script, latent or script, script or event, value (of the latent `name`), share (a value
            of it that gets a weight), values (of any), quantity or value, index, predicate, state
            (a predicate of the start), character, object, thing (either), place, spot (any of
            them), cell, point, actor, action, dropped (by the event `name`), world, library,
            audience (a kind of them), whose (an audience with a name), search, setting (of the
            owner `name`),
            setting value (`owner name`), occurrence, assumption, new (a name that is being given)
            or nothing.
        parameters: the parameters of a pattern that can be named here, and `slot` is then that of
            the next one by position.
        time: whether `t` means something.
        reductions: whether a `sum_t` may stand here.
        value: whether `V(who)` may.
    """

    kind: str
    name: str = ""
    parameters: tuple[str, ...] = ()
    time: bool = False
    reductions: bool = True
    value: bool = False


@dataclass(frozen=True)
class Place:
    """Where a word stands: the brackets around it, and what of it is `typed` already."""

    stack: tuple[Enclosure, ...]
    tokens: tuple[Token, ...]
    around: Surroundings
    typed: str = ""

    @property
    def keyword(self) -> str:
        return self.stack[0].name

    @property
    def own(self) -> tuple[str, ...]:
        """The parameters of the pattern that is being defined."""
        if self.keyword != "pattern":
            return ()
        depth, found = 0, []
        before = ""
        for token in self.tokens:
            if token.type in ("LPAR", "LSQB", "LBRACE", "BIG_OPEN"):
                depth += 1
            elif token.type in ("RPAR", "RSQB", "RBRACE"):
                depth -= 1
                if depth == 0:
                    break
            elif depth == 1 and token.type in ("NAME", "NAMED") and before in ("LPAR", "COMMA"):
                found.append(str(token))
            before = token.type
        return tuple(found)

    @property
    def defined(self) -> str:
        """The name that the statement gives, which its own value cannot use."""
        if self.keyword in ("let", "pattern") and len(self.tokens) > 1:
            return str(self.tokens[1])
        return ""

    @property
    def may_be_audience(self) -> bool:
        """Whether this begins the brackets of an expectation: `E[insider][...]`."""
        inner = self.stack[-1]
        begins = not inner.part and not inner.separator
        before = self.stack[-2].part if len(self.stack) > 1 else []
        first = bool(before) and before[-1].type == EXPECTED.terminal
        return begins and inner.kind in BY_NAME and first

    def slot(self) -> Slot:
        """What makes sense here."""
        slot = self._at(len(self.stack) - 1)
        sums = [e.in_sum for e in self.stack]
        calls = any(e.kind == "call" and self._pattern(e.name) for e in self.stack)
        free = self.keyword in ("let", "pattern") or self.stack[0].kind == "expression"
        quantity = any(_first_part(e.kind) == "quantity" and not e.separator for e in self.stack)
        return replace(
            slot,
            time=free or calls or any(sums),
            reductions=not any(sums) and not any(e.kind == "range" for e in self.stack),
            value=quantity or self.keyword in ("let", "pattern"),
        )

    def _at(self, level: int) -> Slot:
        enclosure = self.stack[level]
        base = self._base(enclosure, level)
        return self._refined(base, enclosure)

    def _base(self, enclosure: Enclosure, level: int) -> Slot:
        match enclosure.kind:
            case "statement":
                return self._of_statement(enclosure)
            case "expression":
                return Slot("number")
            case "group":
                around = self._at(level - 1)
                return Slot("cell") if around.kind in ("place", "spot", "point") else around
            case "call":
                return self._of_call(enclosure, level)
            case "parameters":
                return Slot("any" if enclosure.argument else "new")
            case "settings":
                return self._of_setting(enclosure)
            case "index":
                return Slot("character" if enclosure.separator == "COMMA" else "index")
            case "range":
                return Slot("index" if enclosure.separator or enclosure.part else "nothing")
            case "holds":
                return Slot("script" if enclosure.separator == "AT" else "predicate")
            case "prior":
                return Slot("nothing" if enclosure.part else "latent")
            case "whose":
                return Slot("nothing" if enclosure.part else "whose")
            case "turn":
                return self._of_turn(enclosure)
            case "set":
                return self._of_set(enclosure)
        if enclosure.separator in ("BAR", "SEMI", "DBAR", "AT"):
            return Slot("script")
        if enclosure.separator == "COMMA":
            # `entropy(script[:t], ...)` has no bar.
            given = [*enclosure.given, *(t for p in enclosure.parts for t in p)]
            form = BY_NAME.get(enclosure.kind)
            if form is not None and form.shape is ABOUT and not enclosure.barred:
                return Slot("latent" if form.tabulates and not form.is_table else "nothing")
            apart = form is not None and form.shape is APART
            seen = apart or any(map(self.is_script, given))
            return Slot("event" if seen else "script or event")
        return Slot(_first_part(enclosure.kind))

    def is_script(self, token: Token) -> bool:
        """Whether a token is a script, or a name that may be one."""
        if token.type == "SCRIPT_KW":
            return True
        if token.type != "NAME":
            return False
        if str(token) in self.own:
            return True
        found = self.around.module.find(str(token))
        return found is not None and self.around.sort(found) in ("script", "any")

    def _of_statement(self, enclosure: Enclosure) -> Slot:
        keyword, part = enclosure.name, enclosure.part
        if keyword in ("let", "pattern"):
            return Slot("any" if any(t.type == "EQ" for t in part) else "new")
        if keyword == "pin" and enclosure.separator:
            return Slot("predicate")
        return Slot(_OF_STATEMENT.get(keyword, "number"))

    # Calls.

    def _pattern(self, name: str) -> ast.Pattern | None:
        found = self.around.module.find(name)
        return found.item if found is not None and isinstance(found.item, ast.Pattern) else None

    def _of_call(self, enclosure: Enclosure, level: int) -> Slot:
        name, position = enclosure.name, len(enclosure.parts)
        world = self.around.vocabulary
        if self.keyword == "allow":
            return Slot("dropped", name)
        pattern = self.around.module.find(name)
        if pattern is not None and isinstance(pattern.item, ast.Pattern):
            return self._of_parameter(pattern.item, pattern.module, enclosure)
        if world is not None and name in world.predicates:
            kinds = world.predicates[name].parameters
            return Slot(kinds[position] if position < len(kinds) else "nothing")
        if name == "points":
            return Slot("point")
        if name in FUNCTIONS and FUNCTIONS[name].takes != "number":
            return Slot(FUNCTIONS[name].argument(position))
        if name in FUNCTIONS:
            around = self._at(level - 1)
            return Slot("quantity" if around.kind in ("event", "quantity", "value") else "number")
        return Slot("any")

    def _of_parameter(self, pattern: ast.Pattern, module: Module, enclosure: Enclosure) -> Slot:
        names = [p.name.id for p in pattern.parameters]
        free = list(names)
        for part in enclosure.parts:
            given = argument_name(part)
            used = given if given in free else (free[0] if free else "")
            if used:
                free.remove(used)
        named = enclosure.argument
        kinds = self._kinds(pattern, module)
        if named in names:
            return Slot(_OF_PARAMETER.get(kinds[named], "any"))
        if not free:
            return Slot("nothing")
        kind = _OF_PARAMETER.get(kinds[free[0]], "any")
        return Slot(kind, parameters=() if enclosure.part else tuple(free))

    def _kinds(self, pattern: ast.Pattern, module: Module) -> dict[str, str]:
        """The kinds of the parameters; the world knows those of the arguments of predicates."""
        kinds = parameter_kinds(pattern, module)
        predicates = self.around.vocabulary.predicates if self.around.vocabulary else {}
        for node in ast.walk(pattern.body):
            if isinstance(node, ast.Call) and node.callee.id in predicates:
                wanted = predicates[node.callee.id].parameters
                for kind, argument in zip(wanted, node.arguments, strict=False):
                    value = argument.value
                    if isinstance(value, ast.Name) and kinds.get(value.id) == "any":
                        kinds[value.id] = kind
        return kinds

    # Settings.

    def _of_setting(self, enclosure: Enclosure) -> Slot:
        if enclosure.argument in OF_VIEWERS:
            return Slot("quantity" if enclosure.argument == "prior" else "event")
        if enclosure.argument:
            return Slot("setting value", f"{enclosure.name} {enclosure.argument}")
        if enclosure.name == "audience average":
            return Slot("audience")
        return Slot("nothing" if enclosure.part else "setting", enclosure.name)

    def _of_set(self, enclosure: Enclosure) -> Slot:
        if self.stack[-2].kind == "settings":
            is_share = self.stack[-2].part[0] == "prior" and enclosure.separator != "COLON"
            return Slot("share" if is_share and not enclosure.part else "nothing", enclosure.name)
        return Slot("value", enclosure.name)

    # Turns.

    def _of_turn(self, enclosure: Enclosure) -> Slot:
        part = enclosure.part
        if not part:
            return Slot("actor")
        if part[-1].type == "AT_KW":
            return Slot("place")
        world = self.around.vocabulary
        if world is not None and str(part[0]) in world.events:
            return Slot("dropped", str(part[0]))
        return Slot("action", str(part[0]))

    # What stands before, in the same brackets.

    def _refined(self, base: Slot, enclosure: Enclosure) -> Slot:
        """The right side of a comparison, or the condition of an `if`."""
        part = enclosure.part
        if base.kind in ("setting value", "nothing", "new"):
            return base
        if enclosure.argument and self._is_parameter(enclosure):
            part = part[2:]
        compared = _compared(part)
        if compared is not None:
            operator, left = compared
            world = self.around.vocabulary
            if world is not None and left in world.latents:
                if operator in ("=", "!=") or world.latents[left].kind == "number":
                    return Slot("value", left)
                return Slot("nothing")
            if base.kind == "event" and left:
                return Slot("quantity or value" if operator in ("=", "!=") else "quantity")
            if base.kind in ("event", "assumption"):
                return Slot("quantity")
        if base.kind in ("event", "assumption") and part and part[-1].type in _ARITHMETIC:
            return Slot("quantity")
        if enclosure.in_condition:
            kinds = {"any": "any", "event": "event", "quantity": "event"}
            return Slot(kinds.get(base.kind, "condition"))
        return replace(base, parameters=()) if part else base

    def _is_parameter(self, enclosure: Enclosure) -> bool:
        pattern = self._pattern(enclosure.name) if enclosure.kind == "call" else None
        if enclosure.kind in ("parameters", "settings"):
            return True
        names = [p.name.id for p in pattern.parameters] if pattern else []
        return enclosure.argument in names


def _compared(part: list[Token]) -> tuple[str, str] | None:
    """The operator right before the place and the name on its left ('' where it is no name)."""
    signed = bool(part) and part[-1].type == "MINUS"
    tokens = part[:-1] if signed else part
    if not tokens or tokens[-1].type not in COMPARISONS:
        return None
    left = ""
    if len(tokens) >= 2 and tokens[-2].type in ("NAME", "NAMED"):
        left = str(tokens[-2])
    return str(tokens[-1]), left
