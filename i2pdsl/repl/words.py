"""The commands of the REPL in one table, as language/builtins.py has the language's words."""

from __future__ import annotations

from i2pdsl.language.forms import Word

COMMANDS: tuple[Word, ...] = (
    Word("load", "load FILE", "opens a story or a script", "load stories/kitchen/help.story"),
    Word(
        "save",
        "save FILE",
        "writes the story (.story), the script (.json), or its pictures into a folder of that "
        "name (.png, .svg, .gif, .mp4, .html)",
        "save help.json",
    ),
    Word("story", "story", "shows the story as it stands now", "story"),
    Word(
        "show",
        "show [FRAME]",
        "what happens in a frame, and what viewers believe after it; the last one without a number",
        "show 7",
    ),
    Word(
        "why",
        "why [FRAME]",
        "which actions moved what viewers believe, by how much, and what they would believe had "
        "something else been done; of one frame in full",
        "why 4",
    ),
    Word(
        "plot",
        "plot EXPR, EXPR, ... [> FILE]",
        "draws curves over t here, or into a file (.png, .svg, .pdf)",
        "plot P(rho > 0 | script[:t]), P(rho < 0 | script[:t]) > beliefs.png",
    ),
    Word(
        "table",
        "table EXPR, EXPR, ...",
        "the same as numbers, a row for each frame",
        "table P(rho > 0 | script[:t]), entropy(rho | script[:t])",
    ),
    Word(
        "solve",
        "solve [SEED]",
        "looks for the script that the story asks for; it becomes the current one",
        "solve 3",
    ),
    Word(
        "play",
        "play ...",
        "adds frames by hand, in the words of the world at hand",  # Kind.play says which
        "play cheese west!",
    ),
    Word(
        "suggest",
        "suggest [N] [EXPR]",
        "asks the search for the best next N frames from here, for the story's objective "
        "or another one",
        "suggest 2 sum_t P(rho < 0 | script[:t])",
    ),
    Word("accept", "accept [NUMBER]", "adds the frames of a suggestion to the script", "accept 1"),
    Word("rewind", "rewind [FRAME]", "goes back to a frame (to the start without one)", "rewind 7"),
    Word(
        "pin",
        "pin FRAMES",
        "keeps frames of the script as they are, in what `solve` finds next",
        "pin 1-5,9",
    ),
    Word(
        "unpin",
        "unpin [FRAMES]",
        "lets `solve` change them again; all that is pinned without numbers",
        "unpin 9",
    ),
    Word("forget", "forget NAME", "removes a `let`, a `pattern` or statements", "forget maximize"),
    Word("undo", "undo", "takes the last change back", "undo"),
    Word(
        "help",
        "help [WORD]",
        "explains a word of the language, of the world, or of this",
        "help KL",
    ),
    Word("quit", "quit", "leaves (so does Ctrl-D)", "quit"),
)
COMMAND_WORDS = tuple(word.name for word in COMMANDS)


def commands_with(play: Word | None) -> tuple[Word, ...]:
    """The commands where `play` is what a kind of world says (Kind.play)."""
    return tuple(play if play is not None and w.name == play.name else w for w in COMMANDS)
