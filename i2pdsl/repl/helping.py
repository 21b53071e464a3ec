"""What `help` says: of the language, of the world at hand, and of the session's commands."""

from __future__ import annotations

from i2pdsl.describe import shown_value
from i2pdsl.errors import did_you_mean, error, whole_file
from i2pdsl.language import ast
from i2pdsl.language.builtins import FORMS, FUNCTIONS, STATEMENTS, word_named
from i2pdsl.language.forms import Word
from i2pdsl.repl.examples import example_here, in_words_of
from i2pdsl.repl.mistakes import INPUT
from i2pdsl.repl.state import State
from i2pdsl.repl.words import COMMANDS
from i2pdsl.worlds.find import builtin_worlds

_ASKED = ("P(rho > 0 | script[:T])", "P(G_robot | script[:t])", "E[V(robot) | script[:t]]")


def explain(word: str, state: State) -> str:
    """A word's signature, meaning and example. Raises StoryError for one that means nothing."""
    if not word:
        return _overview(state)
    parts = [_entry(found, state) for found in (state.command(word), word_named(word)) if found]
    parts += _of_the_story(word, state)
    if parts:
        return "\n\n".join(parts)
    hint = did_you_mean(word, every_word(state))
    raise error("help", f"`{word}` means nothing here", whole_file(INPUT), hint)


def every_word(state: State) -> set[str]:
    """All that `help` can explain."""
    words = state.typed.vocabulary
    named = {w.name for w in (*COMMANDS, *STATEMENTS, *FORMS, *FUNCTIONS.values())}
    named |= {"then", "else", *state.typed.module.known(), *builtin_worlds()}
    named |= {*words.latents, *words.predicates, *words.characters, *words.things}
    named |= {audience.name for audience in state.typed.audiences}
    return named | {*words.places, *words.actions, *words.events, *words.settings}


def _entry(word: Word, state: State) -> str:
    lines = [word.signature, f"    {word.documentation}"]
    is_of_world = word in state.commands and word not in COMMANDS
    example = word.example if is_of_world else example_here(word.example, state)
    return "\n".join((*lines, f"    for instance: {example}") if example else lines)


def _overview(state: State) -> str:
    commands = state.commands
    width = max(len(c.signature) for c in commands)
    asked = (in_words_of(example, state.typed.vocabulary) for example in _ASKED)
    lines = [f"Ask anything: {', '.join(example for example in asked if example)}"]
    lines += ["Statements as in a story: let, pattern, import, assume, world, maximize ...", ""]
    lines += [f"{c.signature:<{width}}  {c.documentation}" for c in commands]
    words = state.typed.vocabulary
    latents = ", ".join(f"{x.name} in {{{x.domain}}}" for x in words.latents.values())
    forms = " ".join(w.name for w in FORMS)
    lines += ["", f"hidden in world {words.world}: {latents}"]
    lines += [f"characters and things: {', '.join((*words.characters, *words.things))}"]
    lines += [f"forms: {forms}", f"functions: {' '.join(FUNCTIONS)}"]
    patterns = sorted(state.typed.module.known_patterns())
    return "\n".join((*lines, f"patterns: {' '.join(patterns)}", "", "help WORD explains each."))


def _of_the_story(name: str, state: State) -> list[str]:
    """What a name means in the world and the story at hand."""
    words, found = state.typed.vocabulary, []
    if name in words.latents:
        latent = words.latents[name]
        found.append(
            f"{name} in {{{latent.domain}}}\n    {latent.documentation}; hidden from viewers"
        )
    if name in words.predicates:
        predicate = words.predicates[name]
        call = f"{name}({', '.join(predicate.parameters)})"
        found.append(f"[{call} @ script[k]]\n    {predicate.documentation}")
    if name in words.characters:
        found.append(
            f"{name}\n    a character; its actions: {', '.join(words.actions) or 'continuous'}"
        )
    if name in words.things:
        absent = "; may be absent" if name in words.may_be_absent else ""
        found.append(f"{name}\n    an object{absent}")
    if name in words.places:
        cells = ", ".join(map(str, words.places[name]))
        found.append(f"{name}\n    a tile, (column, row): {cells}")
    if name in words.actions:
        found.append(f"{name}\n    an action; `{name}!` fails")
    for event, things in words.events.items():
        if name == event:
            found.append(
                f"{event}({', '.join(things)})\n    an event; `allow {event}({things[0]})`"
            )
    if name in words.settings:
        setting = words.settings[name]
        usual = shown_value(setting.default)
        found.append(f"{name} = {usual}\n    a setting of the world: {setting.documentation}")
    definition = state.typed.module.find(name)
    if definition is not None:
        item = definition.item
        if isinstance(item, ast.Pattern):
            about = [f"    {line}" for line in item.documentation.splitlines()]
            body = " ".join(item.body.span.text.split())
            found.append("\n".join((item.signature, *about, f"    = {body}")))
        else:
            found.append(f"let {name} = {' '.join(item.value.span.text.split())}")
    for audience in state.typed.audiences:
        if name == audience.name:
            told = "the audience that needs no name"
            if audience.span is not None:
                told = " ".join(audience.span.text.split())
            found.append(f"{name}\n    {told}; `P[{name}](...)` is what it believes")
    if name in builtin_worlds():
        found.append(f"world {name}\n    `i2p worlds {name}` describes it")
    return found
