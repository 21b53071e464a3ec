"""What can be written at a place of a story or an expression.

The real grammar says which terminals can come next (Lark's interactive parser); what encloses the
place says which names and forms make sense there; the world and the file say which there are.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from i2pdsl.editor.colours import EVER, TERMINALS
from i2pdsl.editor.enclosure import enclosures
from i2pdsl.editor.names import functions_at, names_at
from i2pdsl.editor.offers import Offer
from i2pdsl.editor.reading import Reading, read_before
from i2pdsl.editor.slots import Place, Slot
from i2pdsl.editor.surroundings import Surroundings, surroundings
from i2pdsl.editor.words import explanation, spellings
from i2pdsl.language import ast
from i2pdsl.language.builtins import FUNCTIONS, ONCE, STATEMENT_WORDS
from i2pdsl.language.forms import BY_NAME, BY_TERMINAL, EXPECTED, HIDDEN
from i2pdsl.language.settings import AUDIENCES
from i2pdsl.language.vocabulary import STAY

__all__ = ["Completion", "Offer", "Surroundings", "complete", "offers_at", "surroundings"]

_HIDDEN = HIDDEN.terminal
_NUMERIC = frozenset((*BY_TERMINAL, "LAST_KW")) - {_HIDDEN}
_NUMBER = _NUMERIC | {"BIG_T", "BIG_OPEN", "LSQB", "LPAR", "MINUS", "IF_KW", "T_VAR", "T_END"}
_NUMBER |= {"WHEN_KW"}
_QUANTITY = frozenset((_HIDDEN, "LPAR", "MINUS", "IF_KW", "NOT_KW", "T_VAR", "T_END"))
_INDEX = frozenset(("T_VAR", "T_END", "LAST_KW", "LPAR", "MINUS", "COLON"))
_SCRIPT = frozenset(("SCRIPT_KW", "LPAR"))
_EVENT = frozenset(("NOT_KW", "LPAR"))
_FITTING: dict[str, frozenset[str]] = {
    "any": _NUMBER | _SCRIPT | _EVENT | {_HIDDEN},
    "number": _NUMBER | {_HIDDEN},
    "constant": frozenset(("MINUS", "LPAR")),
    "condition": _NUMBER | {"NOT_KW", "NEVER_KW", "EVENTUALLY_KW"},
    "index": _INDEX,
    "cell": frozenset(("MINUS",)),
    "point": frozenset(("LPAR",)),
    "event": _EVENT,
    "assumption": _EVENT,
    "quantity": _QUANTITY,
    "quantity or value": frozenset(("MINUS", "LPAR")),
    "script": _SCRIPT,
    "latent or script": _SCRIPT,
    "script or event": _SCRIPT | _EVENT,
    "predicate": _EVENT,
    "state": _EVENT,
    "place": frozenset(("LPAR",)),
    "spot": frozenset(("LPAR",)),
}
"""The terminals that can begin what makes sense in a slot; none in those that hold names only."""

_TRUTHS = ("any", "event", "assumption", "quantity", "condition", "predicate", "state")
_COMPARING = frozenset(("LT", "LE", "EQ", "NE", "GE", "GT", "AND_KW", "OR_KW", "IN_KW"))
_NO_SENSE_BEGINNING = frozenset(("PLUS", "NUMBER", "NAME", "NAMED", "STRING", "$END"))
_ORDER = ("form", "reduction", "story", "keyword", "operator", "sign", "bracket")
_LAST = ("operator", "sign", "bracket")


@dataclass(frozen=True)
class Completion:
    """Something that can be written: `text` in place of the range [start, end).

    `kind` is one of those of `offers.Offer`; `detail` is a line, `documentation` may be longer.
    """

    text: str
    start: int
    end: int
    kind: str
    detail: str
    documentation: str


def complete(text: str, offset: int, around: Surroundings, start: str = "file") -> list[Completion]:
    """What can be written at a place, the most likely first; any text at all will do.

    The range is the word that ends at the place; the completions begin with it, in capitals or
    not. Behind a finished word the signs that can follow it are offered too, for an empty range.
    Nothing is offered inside comments, numbers and texts in quotes.

    Args:
        offset: where the cursor stands in the text, in characters.
        around: the world and the names that are known.
        start: `file` for a story or a library, `expression` for a single expression.
    """
    offset = max(0, min(offset, len(text)))
    reading = read_before(text, offset, start)
    if reading is None:
        return []
    typed = text[reading.start : offset]
    equals = bool(re.compile(r"[ \t]*=").match(text, offset))
    found: dict[str, Completion] = {}
    free = True  # whether any name may stand here
    for offer in offers_at(reading, text, around, start, typed):
        free = free and offer.kind in _LAST
        if offer.text.lower().startswith(typed.lower()):
            after = "" if equals else offer.after
            found.setdefault(offer.text, _completion(offer, reading.start, offset, after))
    whole = sorted(found.values(), key=lambda c: not c.text.startswith(typed))
    if typed and (typed in found or free):  # the word is finished: signs can follow it
        ended = read_before(text, offset, start, ended=True)
        if ended is not None:
            signs = [o for o in offers_at(ended, text, around, start) if o.kind in _LAST]
            whole += [_completion(o, offset, offset) for o in signs]
    return whole


def _completion(offer: Offer, start: int, end: int, after: str = "") -> Completion:
    return Completion(offer.text + after, start, end, offer.kind, offer.detail, offer.documentation)


def offers_at(
    reading: Reading, text: str, around: Surroundings, start: str = "file", typed: str = ""
) -> Iterator[Offer]:
    """What can be written at the place up to which the reading goes, the likely first.

    Of many lets and patterns only those that begin with what is `typed`, and not all.
    """
    if reading.begins:
        yield from _statements(text, reading.start)
    if reading.accepts is None:
        return
    expression = start == "expression" or not (
        reading.tokens and reading.tokens[0].type in _STATEMENTS
    )
    place = Place(tuple(enclosures(reading.tokens, expression)), reading.tokens, around, typed)
    slot = place.slot()
    if reading.accepts & {"NAME", "NUMBER", "NAME_T"}:
        yield from _operands(place, slot, reading.accepts)
    else:
        yield from _continuations(place, slot, reading.accepts)


_STATEMENTS = frozenset(f"{word.upper()}_KW" for word in STATEMENT_WORDS)


def _statements(text: str, begin: int) -> Iterator[Offer]:
    """The words that can begin a statement here; none twice that may stand once."""
    word_ends = re.compile(r"\w*").match(text, begin)
    rest = text[:begin] + text[word_ends.end() if word_ends else begin :]
    used = set(re.findall(r"^(\w+)", rest, re.MULTILINE))
    for word in STATEMENT_WORDS:
        if word not in used or word not in ONCE:
            yield _fixed(word, "keyword")


def _fixed(text: str, kind: str) -> Offer:
    """A word or a sign of the language."""
    about = explanation(text)
    if about is None:
        return Offer(text, kind)
    return Offer(text, kind, about.signature, about.documentation)


def _operands(place: Place, slot: Slot, accepts: frozenset[str]) -> Iterator[Offer]:
    """What can begin an operand, or is a name in a statement."""
    if "NAME" in accepts or slot.kind == "value":
        for offer in names_at(place, slot):
            fits = "NUMBER" if offer.text[:1] in "-0123456789" else "NAME"
            if offer.text[:1] == "{":
                fits = "LBRACE"
            if fits in accepts:
                yield offer
    fitting = _FITTING.get(slot.kind, frozenset())
    if "NAME_T" in accepts:
        fitting = frozenset(("NAME_T",))
    if slot.kind in ("new", "nothing"):
        fitting = accepts - {"LPAR"} if "NUMBER" not in accepts else fitting
    if not slot.time:
        fitting = fitting - {"T_VAR"}
    if not slot.reductions:
        fitting = fitting - {"BIG_T", "BIG_OPEN"}
    if not slot.value:
        fitting = fitting - {_HIDDEN}
    chosen = (fitting & accepts) - _NO_SENSE_BEGINNING
    if "RPAR" in accepts and _may_be_empty(place):
        chosen |= {"RPAR"}
    words = [w for w in _terminals(chosen) if not (place.keyword and _is_table(w.text))]
    yield from (w for w in words if w.kind not in _LAST)
    yield from functions_at(place, slot)
    yield from (w for w in words if w.kind in _LAST)


def _is_table(word: str) -> bool:
    """Whether a word is a form that only a query can ask for."""
    return word in BY_NAME and BY_NAME[word].is_table


def _may_be_empty(place: Place) -> bool:
    """Whether the brackets around the place may hold nothing."""
    inner = place.stack[-1]
    if inner.kind in ("settings", "parameters"):
        return True
    found = place.around.module.find(inner.name)
    if found is None or not isinstance(found.item, ast.Pattern):
        return False
    return all(p.default is not None for p in found.item.parameters)


def _continuations(place: Place, slot: Slot, accepts: frozenset[str]) -> Iterator[Offer]:
    """What can follow an operand or a name: operators, separators, closing brackets."""
    inner = place.stack[-1]
    chosen = set(accepts)
    last = inner.part[-1] if inner.part else None
    kind = last.type if last is not None else ""
    scripts = kind in ("RPAR", "RSQB") or (last is not None and place.is_script(last))
    pinned = place.keyword == "pin" and kind == "EQ"
    asked = kind in BY_TERMINAL and (len(place.around.audiences) > 1 or bool(place.own))
    fits = scripts or pinned or asked
    if not fits and kind not in (EXPECTED.terminal, "PLUSPLUS", "BEFORE_KW", *EVER):
        chosen -= {"PLUSPLUS", "LSQB"}
    if inner.kind == "parameters" and len(inner.part) == 1:
        chosen |= {"EQ"}  # the grammar sees a default only with its `=`
    if inner.kind == "statement" and place.keyword == "audience" and len(inner.part) == 1:
        chosen |= {"EQ"} if str(last) not in AUDIENCES else set()
    if kind == "NAME" and not _can_be_called(str(last), place):
        chosen -= {"LPAR"}
    if slot.kind not in _TRUTHS and place.stack[0].kind != "expression" and inner.kind != "range":
        named = kind == "NAME" and inner.kind in ("call", "settings", "parameters")
        assigned = inner.kind == "statement" and "PLUS" not in accepts
        chosen -= _COMPARING - ({"EQ"} if named or assigned else set())
    if inner.kind == "turn":
        chosen -= _unfit_in_turn(place)
    yield from _terminals(chosen)


def _can_be_called(name: str, place: Place) -> bool:
    world = place.around.vocabulary
    if place.keyword in ("world", "audience", "search", "pattern", "allow"):
        return True
    if name in FUNCTIONS or (world is not None and name in world.predicates):
        return True
    found = place.around.module.find(name)
    if found is not None:
        return isinstance(found.item, ast.Pattern)
    return world is None and name not in place.own


def _unfit_in_turn(place: Place) -> set[str]:
    """`!` behind what cannot fail, `at` behind what is no event."""
    world = place.around.vocabulary
    part = place.stack[-1].part
    if world is None or not part:
        return set()
    if str(part[0]) in world.events:
        return {"BANG", *(("COMMA", "RSQB") if len(part) == 3 else ())}
    fails = str(part[0]) in world.can_fail and str(part[-1]) != STAY
    return {"AT_KW"} | (set() if fails else {"BANG"})


def _terminals(terminals: frozenset[str] | set[str]) -> Iterator[Offer]:
    """The words and signs of terminals, the most likely first."""
    known = spellings()
    chosen = [name for name in known if name in terminals]
    for name in sorted(chosen, key=lambda n: _ORDER.index(TERMINALS[n])):
        for text in known[name]:
            yield _fixed(text, TERMINALS[name])
