"""The kinds of arguments that commands take."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem


class Numbers(click.ParamType):
    """`0-19`, `3` or `1,4,7`."""

    def __init__(self, name: str):
        self.name = name

    def convert(self, value: Any, param: Any, ctx: Any) -> list[int]:
        seeds: list[int] = []
        for part in str(value).split(","):
            first, dash, last = part.strip().partition("-")
            numbers = [first, last] if dash else [first]
            if not all(number.isdecimal() and len(number) < 19 for number in numbers):
                self.fail(f"{value!r} are no {self.name}; write 0-19 or 1,4,7", param, ctx)
            span = range(int(numbers[0]), int(numbers[-1]) + 1)
            if not span or len(span) > 10_000:
                self.fail(f"{part!r} is an empty or endless range", param, ctx)
            seeds.extend(span)
        return list(dict.fromkeys(seeds))


class Formats(click.ParamType):
    """The names of files.FORMATS, with commas between them."""

    name = "formats"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[str, ...]:
        from i2pdsl.render.files import FORMATS as known

        chosen = tuple(dict.fromkeys(p.strip() for p in str(value).split(",") if p.strip()))
        for name in chosen:
            if name not in known:
                self.fail(
                    f"there is no format {name!r}; formats are {', '.join(known)}", param, ctx
                )
        return chosen


class Size(click.ParamType):
    """`1920x1080`: pixels across and down, both even."""

    name = "WIDTHxHEIGHT"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        width, cross, height = str(value).lower().partition("x")
        if not (
            cross and all(s.isascii() and s.isdecimal() and len(s) < 6 for s in (width, height))
        ):
            self.fail(f"{value!r} is no size; write 1920x1080", param, ctx)
        size = int(width), int(height)
        if not all(160 <= side <= 4096 and side % 2 == 0 for side in size):
            self.fail(f"{value!r}: sides are even numbers from 160 to 4096", param, ctx)
        return size


class Assignment(click.ParamType):
    """`NAME=VALUE`."""

    name = "NAME=VALUE"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[str, str]:
        if isinstance(value, tuple):
            return value
        name, equals, text = str(value).partition("=")
        if not equals or not name.strip().isidentifier() or not text.strip():
            self.fail(f"{value!r} is not NAME=VALUE", param, ctx)
        return name.strip(), text.strip()


class KindOfWorld(click.ParamType):
    """A kind of world that stories can be begun in, as animators call it (beginnings/table.py):
    the kinds are read only when somebody names one, or asks which there are."""

    name = "kind"

    @property
    def _choice(self) -> click.Choice[str]:
        from i2pdsl.beginnings.table import table

        return click.Choice(tuple(table()))

    def get_metavar(self, param: Any, ctx: Any) -> str | None:
        return self._choice.get_metavar(param, ctx)

    def convert(self, value: Any, param: Any, ctx: Any) -> str:
        return self._choice.convert(value, param, ctx)

    def shell_complete(self, ctx: Any, param: Any, incomplete: str) -> list[CompletionItem]:
        return self._choice.shell_complete(ctx, param, incomplete)


def complete_world(ctx: Any, param: Any, incomplete: str) -> list[str]:
    """Shell completion: the built-in worlds."""
    from i2pdsl.worlds.find import builtin_worlds

    return [name for name in builtin_worlds() if name.startswith(incomplete)]
