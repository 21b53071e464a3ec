"""The sprites that a grid world's file names: known, or its own and fit to be shown."""

from __future__ import annotations

from i2pdsl.errors import did_you_mean, shorten
from i2pdsl.untrusted import WrongData
from i2pdsl.worlds.blocks import Block, BlockReader
from i2pdsl.worlds.drawings import Files, builtin_sprites, is_own, kept_drawing


class Sprites:
    """Reads the sprites of a file, and says what is wrong with them.

    Attributes:
        drawings: what is kept of each own one, by its name.
    """

    def __init__(self, reader: BlockReader, files: Files | None):
        self.reader, self.files = reader, files
        self.drawings: dict[str, str] = {}

    def of(self, block: Block, key: str, default: str) -> str:
        """The sprite of a block; a wrong one is reported and gives the default."""
        name = self.reader.word(block, key, default)
        value = block.entries.get(key)
        if value is None or name == default:
            return name
        known = builtin_sprites()
        if name in known:
            return name
        if not is_own(name):
            hint = did_you_mean(name, known) or f"there are: {', '.join(known)}"
            hint = f'{hint}; an own one is a file beside the world, "{shorten(name)}.svg"'
            message = f"there is no sprite `{shorten(name)}`"
            self.reader.problem("world-sprite", message, value.span, hint)
            return default
        if self.files is not None and name not in self.drawings:
            try:
                data = self.files(name)
                if data is not None:
                    self.drawings[name] = kept_drawing(name, data)
            except FileNotFoundError:
                hint = "own sprites are .svg or .png files in the folder of the world"
                message = f"there is no file `{shorten(name)}`"
                self.reader.problem("world-sprite", message, value.span, hint)
            except OSError as problem:
                message = f"`{shorten(name)}` cannot be read: {problem.strerror}"
                self.reader.problem("world-sprite", message, value.span)
            except WrongData as problem:
                message = f"`{shorten(name)}` cannot be shown: {problem}"
                self.reader.problem("world-sprite", message, value.span)
        return name
