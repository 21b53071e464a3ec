"""Small pictures of a catalogue's examples, to lie beside a library: `i2p patterns` names them.

    i2p patterns --page /tmp/catalogue
    python -m i2pdsl.library.thumbnails /tmp/catalogue stories/patterns

made those of the standard patterns.
"""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

from i2pdsl.library.examples import FIRST_WORLD
from i2pdsl.render.pictures import drawing_for
from i2pdsl.resources import atomic_path
from i2pdsl.worlds.find import find_spec

WIDEST, COLOURS = 900, 128


def write_thumbnails(catalogue: Path, library: Path) -> list[Path]:
    """Reduces the comics of a catalogue to a few colours, into `pictures/` of a library's folder.

    A pattern whose own example is told elsewhere has one in the first world too, which is not
    shown.
    """
    found: dict[str, Path] = {}
    for path in sorted((catalogue / "pictures").glob("*.png")):
        pattern, _, world = path.stem.rpartition("-")
        spec = find_spec(world)
        is_told = spec is None or drawing_for(spec).strip_tells
        if is_told and (pattern not in found or world != FIRST_WORLD):
            found[pattern] = path
    written = []
    for path in found.values():
        target = library / "pictures" / path.name
        with Image.open(path) as picture:
            write_small(picture, target)
        written.append(target)
    return written


def write_small(picture: Image.Image, target: Path) -> None:
    """Writes a picture with few pixels and colours, as PNG; on white where one sees through it."""
    whole = picture.convert("RGBA")
    small = Image.alpha_composite(Image.new("RGBA", whole.size, "white"), whole).convert("RGB")
    small.thumbnail((WIDEST, WIDEST * 2), Image.Resampling.LANCZOS)
    # A palette of the commonest colours would turn small figures grey.
    few = small.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE)
    with atomic_path(target) as temporary:
        few.save(temporary, optimize=True)


if __name__ == "__main__":
    for written in write_thumbnails(Path(sys.argv[1]), Path(sys.argv[2])):
        print(written)
