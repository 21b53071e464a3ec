"""What a .world file draws on its map: rows, symbols, tiles, and walls between cells."""

from __future__ import annotations

from collections import Counter

from i2pdsl.errors import Note, Span
from i2pdsl.language.naming import same_name
from i2pdsl.worlds.blocks import Block
from i2pdsl.worlds.drawings import sprite_color, tile_look
from i2pdsl.worlds.grid.map import MapReader, is_mark
from i2pdsl.worlds.grid.spec import ACTIONS, FLOOR, STAY, WALL, Cell, Tile
from i2pdsl.worlds.grid.sprites import Sprites

LARGEST = 1e6  # of costs, rewards and attitudes
_COLORS = ("#e58aa8", "#6fae75", "#6f9fd8", "#e0a458", "#a98bd0", "#5bb5b0")


class TileReader(MapReader):
    """Reads what lies on the map."""

    unknown_symbols = False  # whether the map has symbols of no tile
    sprites: Sprites

    def checked_rows(self) -> list[str]:
        rows = self.rows or []
        usual = Counter(len(row) for row, _ in rows).most_common(1)
        for row, span in rows:
            if len(row) != usual[0][0]:
                message = f"this row has {len(row)} cells, the others have {usual[0][0]}"
                self.problem("world-map", message, span, "all rows of a map are equally long")
        self.check_symbols(rows)
        return [row for row, _ in rows]

    def check_symbols(self, rows: list[tuple[str, Span]]) -> None:
        """Reports each symbol of the map that means nothing, once for all its cells."""
        drawn = [
            b
            for b in self.blocks
            if (b.keyword == "tile" and "cell" not in b.entries) or "symbol" in b.entries
        ]
        marks = [self.mark(b) for b in drawn]
        known = {FLOOR, WALL, *(m for m in marks if m is not None)}
        found: dict[str, list[tuple[int, int]]] = {}
        for r, (row, _) in enumerate(rows):
            for c, symbol in enumerate(row):
                if symbol not in known:
                    found.setdefault(symbol, []).append((c, r))
        self.unknown_symbols = bool(found)
        # A tile whose symbol cannot be read may be the one that is drawn here.
        unread = [b for b, mark in zip(drawn, marks, strict=True) if mark is None]
        written = {
            s for b in unread if "symbol" in b.entries for s in b.entries["symbol"].span.text
        }
        open_ = set(found) - written - self.lost_symbols()
        nameless = [b for b in unread if not ("symbol" in b.entries and written & set(found))]
        if len(open_) <= len(nameless) or ("tile" in self.unsure and not open_):
            return
        for symbol in (s for s in found if s in open_):
            self.unknown_symbol(symbol, found[symbol], rows)

    def unknown_symbol(
        self, symbol: str, cells: list[tuple[int, int]], rows: list[tuple[str, Span]]
    ) -> None:
        column, row = cells[0]
        text, span = rows[row]
        at = min(span.start + column * self.step, span.end - 1)
        is_plain = self.step > 1 or len(text) >= len(span.text)
        place = Span(self.source, at, at + 1) if is_plain else span
        written = symbol if symbol.isalnum() else f'"{symbol}"'
        hint = f"a tile? `tile NAME` with `symbol = {written}`; floor is `{FLOOR}`, a wall `{WALL}`"
        count = f"on {len(cells)} cell{'' if len(cells) == 1 else 's'} of the map"
        if len(cells) == 1:
            hint += f"; who stands here is said in the story: `start at(NAME, ({column}, {row}))`"
        self.problem("world-map", f"unknown symbol `{symbol}` {count}", place, hint)

    def mark(self, block: Block) -> str | None:
        """The symbol that a tile has on the map, or None where it has none that is valid."""
        symbol = block.entries.get("symbol")
        if symbol is None or symbol.kind not in ("name", "text", "number"):
            return None
        mark = same_name(symbol.span.text.strip('"'))
        return mark if is_mark(mark) else None

    def tiles(self, blocks: list[Block], rows: list[str]) -> tuple[Tile, ...]:
        tiles: list[Tile] = []
        owner: dict[tuple[int, int], Block] = {}
        for number, block in enumerate(blocks):
            self.known_keys(block)
            sprite = self.sprites.of(block, "sprite", "")
            usual = sprite_color(sprite or tile_look(block.name))
            if not usual or usual in {tile.color for tile in tiles}:
                usual = _COLORS[number % len(_COLORS)]
            color = self.color(block, "color", usual)
            cells = self.tile_cells(block, rows)
            for cell in cells:
                if cell in owner:
                    note = Note("the other one", owner[cell].span)
                    message = f"`{block.name}` lies on a cell of `{owner[cell].name}`"
                    self.problem("world-tile", message, block.span, note=note)
                owner[cell] = block
            cost = self.number(
                block, "cost", 0.0, lambda x: abs(x) <= LARGEST, "between -1e6 and 1e6"
            )
            one_way = self.words(block, "one_way", ACTIONS[:STAY], "direction")
            tiles.append(Tile(block.name, cells, color, sprite, cost, one_way))
        return tuple(tiles)

    def tile_cells(self, block: Block, rows: list[str]) -> tuple[tuple[int, int], ...]:
        symbol, cell = block.entries.get("symbol"), block.entries.get("cell")
        if symbol is None and cell is None and block.damaged:
            return ()
        if (symbol is None) == (cell is None):
            hint = "give `symbol = P`, drawn on the map, or `cell = (column, row)`"
            self.problem("world-tile", f"where does `{block.name}` lie?", block.span, hint)
            return ()
        if symbol is not None:
            mark = self.mark(block)
            if mark is None:
                hint = f"`{WALL}` is a wall and `{FLOOR}` plain floor"
                kind = f"a{'n' if block.keyword == 'object' else ''} {block.keyword}"
                message = f"the symbol of {kind} is a single character of its own"
                self.problem("world-tile", message, symbol.span, hint)
                return ()
            found = tuple(
                (c, r) for r, row in enumerate(rows) for c, s in enumerate(row) if s == mark
            )
            if not found and rows and not self.unknown_symbols:
                hint = "draw it there, or give `cell = (column, row)`"
                self.problem("world-tile", f"`{mark}` does not occur on the map", symbol.span, hint)
            return found
        assert cell is not None
        numbers = [v.value for v in cell.value if v.kind == "number"] if cell.kind == "pair" else []
        if len(numbers) < 2 or any(v != v // 1 for v in numbers):
            hint = "write `cell = (column, row)`, whole numbers that count from 0 at the top left"
            self.problem("world-tile", "this is not a cell", cell.span, hint)
            return ()
        column, row = numbers
        inside = 0 <= row < len(rows) and 0 <= column < len(rows[int(row)])
        if inside and rows[int(row)][int(column)] != WALL:
            return ((int(column), int(row)),)
        if rows:
            hint = "columns and rows count from 0 at the top left"
            where = "on a wall" if inside else "outside the map"
            self.problem(
                "world-tile", f"the {block.keyword} `{block.name}` lies {where}", cell.span, hint
            )
        return ()

    def walls_between(self, rows: list[str]) -> tuple[tuple[Cell, Cell], ...]:
        """The walls between free cells; beside a cell that is a wall they change nothing."""
        inside = lambda cell: cell[1] < len(rows) and cell[0] < len(rows[cell[1]])
        free = lambda cell: inside(cell) and rows[cell[1]][cell[0]] != WALL
        return tuple(sorted((a, b) for a, b in self.walls if free(a) and free(b)))
