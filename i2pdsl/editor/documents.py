"""A file that is open in an editor: its text, what is known around it, and its mistakes."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from i2pdsl.editor.positions import Lines
from i2pdsl.editor.surroundings import Surroundings, at_a_glance, surroundings
from i2pdsl.errors import Diagnostic, Source, StoryError
from i2pdsl.language.check import check_source
from i2pdsl.language.format import format_source
from i2pdsl.worlds.drawings import beside
from i2pdsl.worlds.find import find_vocabulary
from i2pdsl.worlds.kinds import format_world, parse_world

LARGE = 10_000  # characters of a text that is not read while an editor waits
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Document:
    """One version of a file; `path` is None where it has not been saved anywhere yet.

    `language` is what the editor takes it for, `before` what was known of the version before.
    """

    uri: str
    text: str
    path: Path | None
    encoding: str = "utf-16"
    language: str = ""
    before: Surroundings | None = field(default=None, repr=False, compare=False)

    @property
    def is_world(self) -> bool:
        return self.name.endswith(".world") or self.language == "i2p-world"

    @property
    def name(self) -> str:
        return str(self.path) if self.path is not None else self.uri

    @property
    def folder(self) -> Path | None:
        return self.path.parent if self.path is not None else None

    @cached_property
    def source(self) -> Source:
        return Source(self.name, self.text)

    @cached_property
    def lines(self) -> Lines:
        return Lines(self.text, self.encoding)

    @property
    def around(self) -> Surroundings:
        """What is known around its places.

        A large text is read beside the answers (`diagnostics`); until then it is what was known
        of the version before, or the world alone.
        """
        if "read" in self.__dict__ or len(self.text) <= LARGE:
            return self.read
        return self.before or self.glance

    @cached_property
    def read(self) -> Surroundings:
        return surroundings(self.source, self.folder, find_vocabulary)

    @cached_property
    def glance(self) -> Surroundings:
        return at_a_glance(self.source, self.folder, find_vocabulary)

    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """The mistakes and warnings, as `i2p check` has them."""
        try:
            if self.is_world:
                files = beside(self.folder) if self.folder else None
                parse_world(self.source, Path(self.name).stem, files)
                return ()
            if len(self.text) > LARGE:
                _ = self.read  # before the mistakes: it is quicker, and waited for
            return check_source(self.source, find_vocabulary, self.folder).warnings
        except StoryError as problem:
            return problem.diagnostics
        except Exception:  # an editor goes on where the checker has a bug
            _log.exception("%s could not be checked", self.name)
            return ()

    def formatted(self) -> str | None:
        """The text in the usual layout; None where it cannot be parsed."""
        try:
            form = format_world if self.is_world else format_source
            return form(self.source)
        except StoryError:
            return None
