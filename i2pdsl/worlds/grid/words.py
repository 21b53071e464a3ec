"""The words of .world files: their blocks and keys, the names that mean something else already,
and what other tools have and grid worlds have not."""

from __future__ import annotations

from i2pdsl.language.builtins import RESERVED, STATEMENT_WORDS
from i2pdsl.worlds.grid.spec import ALL_ACTIONS, NO_GOAL

KEYS: dict[str, tuple[str, ...]] = {
    "tile": ("symbol", "cell", "cost", "one_way", "sprite", "color"),
    "object": ("symbol", "cell", "may_be_absent", "count", "opened_by", "sprite", "color"),
    "character": (
        *(
            "success",
            "goals",
            "pushes",
            "pulls",
            "carries",
            "puts_down",
            "diagonals",
            "toward",
            "attitude",
            "models",
            "misreads",
            "supposes",
            "via",
            "symbol",
            "cell",
            "sprite",
            "color",
        ),
    ),
    "event": ("drops",),
    "rewards": ("goal", "move", "stay", "end"),
    "planning": ("gamma", "beta", "level0", "order", "horizon", "method", "at_once", "states"),
    "audience": ("forgetting", "switching", "hypotheses"),
    "drawing": ("floor", "ground", "wall", "wall_sprite", "frame"),
}
"""The keys of each block."""

NAMED = ("tile", "object", "character", "event")
"""The blocks that have a name, and may occur several times."""

_OF_FILES = {
    "event": "a key of every frame in a script's file",
    "state": "a key of every frame in a script's file",
    "unknown": "what answers call a value that plays no part",
}


def taken(name: str) -> str | None:
    """What a name means already, so that nothing in a world can be called so; None if it is free.

    The latents of a world are not among them, since they depend on its cast.
    """
    if name in _OF_FILES:
        return _OF_FILES[name]
    if name in RESERVED or name in (*ALL_ACTIONS, NO_GOAL, "nothing"):
        return "a word of the language"
    return None


_MOVES = (
    "a move goes one cell north, south, east or west, or aslant where a character has "
    "`diagonals = yes`"
)
_FIXED = "a door is an `object` with `opened_by = KEY`; who opens it has `carries = KEY`"
_SWITCHED = "there are no switches or ways from afar: a cell is a wall or free from first to last"
_SEEN = "everyone sees everything but goals; who may be wrong has `misreads` or `supposes`"
_ENDLESS = "no tile ends a story; how many frames there are is `horizon` in the block `planning`"
_WORTH = "all goals are worth the same, `goal` in the block `rewards`; a tile can have a `cost`"
_LENGTH = "how long it takes is said in the story: `length 15`"
_START = "belongs in the story: `start at(WHO, (column, row))`"
_CHANCE = "the one thing left to chance is whether a move succeeds: `success` of a character"
_ONLY_CELL = "there is nothing to lose or remember: a character is in its cell, and carries objects"
_LEVELS = "a character plans against another with `models`, or with `toward` and `attitude`"
_PRIOR = "weights of a latent's values stand in `audience`: `prior(LATENT) = {VALUE: WEIGHT}`"
_WHO = "someone who acts is a `character`"
_WHAT = "a thing that stands in the way is an `object`, and a character `pushes` it"
_FLOOR = "a kind of floor is a `tile`; it can be a goal, and have a `cost` or be `one_way`"
_MAP = "the size is that of the rows below `map`"

_ELSEWHERE = {
    _WHO: "agent agents player players npc actor person robot human enemy ghost predator prey",
    _WHAT: "box boxes block crate boulder ball item thing furniture obstacle",
    _FIXED: "door doors gate key keys lock carry take takes put puts drop give gives hand",
    _SWITCHED: "switch button lever portal teleport bridge",
    _MOVES: "moves actions action diagonal diagonals northeast northwest southeast southwest speed "
    "jump wait noop neighbours neighbors connectivity directions",
    _SEEN: "sees vision view fog visibility visible observes observation sensor field_of_view "
    "radius partial hidden",
    _ENDLESS: "terminal terminates absorbing terminate episode deadline time_limit "
    "max_steps steps exit done",
    _LENGTH: "length duration frames",
    _WORTH: "reward utility value payoff score points bonus",
    _START: "start starts position location spawn initial init at place",
    _CHANCE: "noise slip slippery wind stochastic randomness epsilon probability chance fail",
    _ONLY_CELL: "inventory holds pickup health lives energy fuel hunger memory capacity",
    _LEVELS: "level levels depth belief beliefs knows theory_of_mind policy planner team",
    _PRIOR: "prior priors",
    _FLOOR: "water lava ice river grass goal exit_tile terrain zone region room ground",
    _MAP: "width height size columns rows dimensions",
    "a wall is drawn as `#` on the map, and one between two cells as `|` or `-`": "wall walls",
    "how sharply characters prefer what is best is `beta` in the block `planning`": "temperature "
    "alpha rationality softmax inverse_temperature",
    "what is late is discounted by `gamma` in the block `planning`": "discount discounting",
    "what a move costs is `move` in the block `rewards`": "cost costs move_cost step_cost "
    "action_cost penalty living_reward time_cost",
    "who acts first is said by `order` in the block `planning`": "turn turns sequence",
}
ELSEWHERE: dict[str, str] = {
    word: told for told, words in _ELSEWHERE.items() for word in words.split()
}
"""What other tools for grids have, and what is to be said of it here."""


def hint_elsewhere(word: str, block: str = "") -> str | None:
    """Where a word that has no meaning in a block belongs, or that there is no such thing.

    Without a block it is one that seems to begin one, where `wall` is more than a colour.
    """
    told = ELSEWHERE.get(word.lower())
    owners = [f"`{owner}`" for owner, keys in KEYS.items() if word in keys and owner != block]
    if owners and (block or told is None):
        return f"`{word}` belongs to {' or '.join(owners)}"
    if told is not None:
        return f"`{word}` {told}" if told.startswith("belongs") else told
    return f"`{word}` belongs in the story" if word in STATEMENT_WORDS else None
