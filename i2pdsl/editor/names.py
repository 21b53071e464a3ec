"""The names that make sense at a place: the world's, the file's, and the library's."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from i2pdsl.editor.offers import OF_STATEMENTS, Offer, named_audiences
from i2pdsl.editor.slots import Place, Slot
from i2pdsl.language import ast
from i2pdsl.language.builtins import FUNCTIONS
from i2pdsl.language.scope import Definition
from i2pdsl.language.shares import OTHERS
from i2pdsl.language.vocabulary import Latent, Predicate, Vocabulary, show_value

# What the slots hold, from the world's own words to those of all stories.
_SORTS = {
    "any": (
        "number",
        "shape",
        "event",
        "script",
        "latent",
        "character",
        "place",
        "predicate",
        "object",
    ),
    "number": ("number", "shape"),
    "constant": ("number",),
    "index": ("number", "shape"),
    "cell": ("number",),
    "condition": ("number", "shape", "event"),
    "event": ("event", "latent"),
    "assumption": ("event", "latent"),
    "quantity": ("number", "shape"),
    "quantity or value": ("number", "latent"),
    "latent": ("latent", "event"),
    "latent or script": ("latent", "event", "script"),
    "script": ("script",),
    "script or event": ("script", "event", "latent"),
    "value": (),
    "values": (),
    "share": (),
    "predicate": ("predicate",),
    "state": ("predicate",),
    "character": ("character",),
    "thing": ("character", "object"),
    "object": ("object",),
    "place": ("place",),
    "spot": ("character", "object", "place"),
    "whose": (),
}
_LATENTS = ("any", "event", "assumption", "quantity", "quantity or value", "latent")
_HIDDEN = (*_LATENTS, "latent or script", "script or event")
_WITHOUT_BELIEFS = ("value", "quantity", "quantity or value", "index", "constant", "cell")
MOST_LOOKED_AT = 200  # lets and patterns; of more, those come first that begin as what is typed
_SUMMARISED = ("latent or script",)  # where what is hidden is taken together
_CALCULATED = ("any", "number", "condition", "quantity", "quantity or value")
_GIVEN = {  # where what functions give can stand
    "number": _CALCULATED,
    "latents": _SUMMARISED,
    "event": ("event", "assumption", "script or event"),
}


def names_at(place: Place, slot: Slot) -> Iterator[Offer]:
    """The names that make sense at a place, the most likely first."""
    if slot.kind in OF_STATEMENTS:
        yield from OF_STATEMENTS[slot.kind](place, slot)
    elif place.around.vocabulary is not None:
        yield from _of_world(place, slot, place.around.vocabulary)
    if slot.kind in _SORTS:
        for name in place.own:
            yield Offer(name, "parameter", "a parameter of this pattern")
        yield from _definitions(place, slot)
    yield from _named_parameters(place, slot)
    if slot.kind == "quantity" and len(place.around.audiences) > 1 and place.may_be_audience:
        yield from named_audiences(place, slot)
    if slot.kind == "assumption":
        yield Offer("nothing", "keyword", "assume nothing", "drops the usual assumption")


def functions_at(place: Place, slot: Slot) -> Iterator[Offer]:
    """The functions of numbers, and those that stand for latents or events, where there can be
    any."""
    words = place.around.vocabulary
    for word in FUNCTIONS.values():
        # Nobody believes anything where nobody may be wrong.
        fits = word.gives != "event" or (words is not None and words.readings)
        if slot.kind in _GIVEN[word.gives] and fits and (word.name != "points" or slot.time):
            yield Offer(word.name, "function", word.signature, word.documentation)
    if slot.kind in (*_CALCULATED, "constant", "cell"):
        yield Offer("pi", "constant", "pi = 3.14159...")


# Lets, patterns and their parameters.


def _named_parameters(place: Place, slot: Slot) -> Iterator[Offer]:
    if not slot.parameters:
        return
    found = place.around.module.find(place.stack[-1].name)
    if found is None or not isinstance(found.item, ast.Pattern):
        return
    for parameter in found.item.parameters:
        if parameter.name.id in slot.parameters:
            detail = " ".join(parameter.span.text.split())
            about = f"a parameter of `{found.item.signature}`"
            yield Offer(parameter.name.id, "argument", detail, about, " = ")


def _definitions(place: Place, slot: Slot) -> Iterator[Offer]:
    wanted = (*_SORTS[slot.kind], "any")
    if slot.kind == "value" and _kind_of(slot.name, place.around.vocabulary) == "number":
        wanted = ("number",)
    elif not _SORTS[slot.kind]:
        return
    begun = (d for d in place.around.definitions() if _begins(d, place.typed))
    for definition in islice(begun, MOST_LOOKED_AT):
        if definition.item.name.id == place.defined:
            continue
        if slot.kind in _WITHOUT_BELIEFS and _believes(definition, place.around.believing):
            continue
        sort = place.around.sort(definition)
        if sort in wanted and (slot.time or sort != "shape"):
            yield definition_offer(definition)


def _begins(definition: Definition, typed: str) -> bool:
    return definition.item.name.id.lower().startswith(typed.lower())


def _believes(definition: Definition, known: dict[int, bool]) -> bool:
    """Whether a definition, or one that it uses, has beliefs or sums over t in it.

    What is found on the way is put into `known`.
    """
    chain = {id(definition.item): definition}
    waiting = {id(definition.item): list(_used(definition, known))}
    while chain:
        key = next(reversed(chain))
        following = waiting[key].pop() if waiting[key] else None
        if known.get(key) or following is None:
            known.setdefault(key, False)
            del chain[key]
            if known[key] and chain:
                known[next(reversed(chain))] = True
        elif known.get(id(following.item)):
            known[key] = True
        elif id(following.item) not in known and id(following.item) not in chain:
            chain[id(following.item)] = following
            waiting[id(following.item)] = list(_used(following, known))
    return known[id(definition.item)]


def _used(definition: Definition, known: dict[int, bool]) -> Iterator[Definition]:
    """The definitions that one uses; where it has beliefs in itself, that is noted."""
    item = definition.item
    for node in ast.walk(item.value if isinstance(item, ast.Let) else item.body):
        if ast.is_belief(node) or isinstance(node, ast.Reduction):
            known[id(item)] = True
        name = node.callee.id if isinstance(node, ast.Call) else ""
        used = definition.module.find(node.id if isinstance(node, ast.Name) else name)
        if used is not None:
            yield used


def _kind_of(latent: str, world: Vocabulary | None) -> str:
    return world.latents[latent].kind if world is not None and latent in world.latents else ""


def definition_offer(definition: Definition) -> Offer:
    """A let or a pattern."""
    item = definition.item
    if isinstance(item, ast.Pattern):
        return Offer(item.name.id, "pattern", item.signature, item.documentation)
    value = " ".join(item.value.span.text.split())
    return Offer(item.name.id, "let", f"{item.name.id} = {value}")


# The world's words.


def _predicate_offer(predicate: Predicate) -> Offer:
    signature = f"{predicate.name}({', '.join(predicate.parameters)})"
    return Offer(predicate.name, "predicate", signature, predicate.documentation)


def _of_world(place: Place, slot: Slot, world: Vocabulary) -> Iterator[Offer]:
    kind = slot.kind
    if kind == "value" and slot.name in world.latents:
        yield from _values(world.latents[slot.name], place)
    if kind == "share" and slot.name in world.latents:
        yield from _shared(world.latents[slot.name], place)
    if kind in ("values", "quantity or value"):
        symbols = {
            str(v): x for x in world.latents.values() if x.kind == "symbol" for v in x.values
        }
        for value, latent in symbols.items():
            yield Offer(value, "value", f"a value of {latent.name}", latent.documentation)
    if kind in _HIDDEN:
        for latent in world.latents.values():
            if latent.kind == "number" or kind not in ("quantity", "quantity or value"):
                yield latent_offer(latent)
    if kind in ("predicate", "state"):
        for predicate in world.predicates.values():
            if kind == "predicate" or not predicate.needs_action:
                yield _predicate_offer(predicate)
    read = {what for each in world.readings.values() for what in each}
    if kind == "event" and place.stack[-1].name == "believes" and read & {*world.things}:
        yield _predicate_offer(world.predicates["at"])  # all that is both seen and believed
    if kind in ("character", "thing", "spot", "any"):
        yield from _characters(world)
    if kind in ("object", "thing", "spot"):
        yield from _objects(world)
    if kind in ("place", "spot"):
        for name, cells in world.places.items():
            yield Offer(name, "place", ", ".join(map(str, cells)))
    if kind == "actor":
        acting = {str(part[0]) for part in place.stack[-1].parts if part}
        yield from (o for o in _characters(world) if o.text not in acting)
        if not acting:
            for event, things in world.events.items():
                detail = f"{event}: {things[0] if things else 'OBJECT'} at (COLUMN, ROW)"
                yield Offer(event, "event", detail, "an object appears on a free cell")
    if kind == "action":
        for action in world.actions:
            yield Offer(action, "action", f"{slot.name}: {action}")
    if kind == "dropped":
        for thing in world.events.get(slot.name, ()):
            yield Offer(thing, "object", f"{slot.name}({thing})")
    if kind == "occurrence":
        for event, things in world.events.items():
            shown = ", ".join(f"{event}({thing})" for thing in things)
            yield Offer(event, "event", shown, "an extraordinary event of the world")


def latent_offer(latent: Latent) -> Offer:
    """Something hidden."""
    domain = "true or false" if latent.kind == "truth" else f"in {{{latent.domain}}}"
    return Offer(latent.name, "latent", f"{latent.name} {domain}", latent.documentation)


def _shared(latent: Latent, place: Place) -> Iterator[Offer]:
    """The values of a latent that `prior(latent) = {...}` has not weighed yet, and the rest."""
    parts = place.stack[-1].parts  # values and their weights in turn
    given = {"".join(map(str, part)) for part in parts[::2]}
    for value in (show_value(v) for v in latent.values):
        if value not in given:
            yield Offer(value, "value", f"{latent.name} = {value}", latent.documentation)
    yield Offer(OTHERS, "value", f"{OTHERS}: WEIGHT", "the weight of all other values together")


def _values(latent: Latent, place: Place) -> Iterator[Offer]:
    """The values of a latent but those that stand in the same set already."""
    if latent.kind == "truth":
        return
    part = place.stack[-1].part
    given = {"".join(map(str, p)) for p in place.stack[-1].parts}
    negated = bool(part) and part[-1].type == "MINUS"
    for value in map(show_value, latent.values):
        if place.stack[-1].kind == "set" and value in given:
            continue
        if negated:
            if value.startswith("-"):
                yield Offer(value[1:], "value", f"{latent.name} = {value}", latent.documentation)
        else:
            yield Offer(value, "value", f"{latent.name} = {value}", latent.documentation)


def _characters(world: Vocabulary) -> Iterator[Offer]:
    for name in world.characters:
        strength = "a weak character" if name in world.can_fail else "a character"
        yield Offer(name, "character", f"{strength} of world {world.world}")


def _objects(world: Vocabulary) -> Iterator[Offer]:
    for name in sorted(world.things, key=lambda n: n not in world.may_be_absent):
        absent = ", may be absent" if name in world.may_be_absent else ""
        yield Offer(name, "object", f"an object of world {world.world}{absent}")
