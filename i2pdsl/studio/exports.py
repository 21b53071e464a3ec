"""Films as files: what `i2p run` writes, to be fetched by the page."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from i2pdsl.render.files import FORMATS, FilmLook, Progress
from i2pdsl.render.pictures import pictures_of
from i2pdsl.studio.protocol import USAGE, Refusal
from i2pdsl.untrusted import plain_name

if TYPE_CHECKING:
    from i2pdsl.studio.made import Made
    from i2pdsl.studio.studio import Studio

SLOWEST, FASTEST = 0.1, 10.0


def exported(
    studio: Studio,
    made: Made,
    formats: list[str],
    pace: float,
    transparent: bool,
    progress: Progress,
) -> dict[str, Any]:
    """Writes a film in some formats (or `script`), and says where it is fetched; of several files
    there is an archive of all, too. Raises StoryError."""
    wrong = [each for each in formats if each not in (*FORMATS, "script")]
    if wrong or not SLOWEST <= pace <= FASTEST:
        raise Refusal(USAGE, f"formats are {', '.join(FORMATS)} and script; a pace is 0.1 to 10")
    secret, folder = studio.room_for_files()
    pictures = pictures_of([made.script], None, FilmLook(pace=pace, transparent=transparent))
    drawn = tuple(each for each in formats if each != "script")
    paths = [path for _, path in pictures.drawn(folder, drawn, progress)]
    if "script" in formats:
        paths.append(made.script.save(folder / "script.json"))
    if len(paths) > 1:
        paths.append(_together(paths, folder / f"{plain_name(made.story.typed.name)}.zip"))
    files = [
        {"name": path.name, "url": f"/made/{secret}/{path.name}", "size": path.stat().st_size}
        for path in paths
    ]
    return {"files": files}


def _together(paths: list[Path], archive: Path) -> Path:
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for path in paths:
            packed.write(path, path.name)
    return archive
