"""Where the grammar, the standard stories and the caches lie, in a checkout and when installed."""

from __future__ import annotations

import os
import re
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_PACKAGE = Path(__file__).parent


def data_folder(name: str) -> Path:
    """The folder `grammar` or `stories`: inside an installed wheel, else beside the package."""
    shipped = _PACKAGE / "data" / name
    return shipped if shipped.is_dir() else _PACKAGE.parent / name


def cache_folder(kind: str) -> Path:
    """The user's cache folder for `kind` (made if missing); I2PDSL_CACHE overrides its root."""
    root = os.environ.get("I2PDSL_CACHE")
    if root is None:
        from platformdirs import user_cache_dir

        root = user_cache_dir("i2pdsl")
    folder = Path(root) / kind
    folder.mkdir(parents=True, exist_ok=True)
    return folder


# Of the names of temporary files: nothing else is called so, and what is old was left by a process
# that was killed.
_TEMPORARY = ".i2p-new-"
_LEFT = re.compile(r"\.i2p-new-\w{8}(?:\..*)?", re.ASCII | re.DOTALL)
_OLD = 3600.0  # seconds since the last write


@contextmanager
def atomic_path(path: Path, new: bool = False) -> Iterator[Path]:
    """A temporary path beside `path` that becomes `path` if the block succeeds, else vanishes.
    A `new` one takes the place of nothing: FileExistsError where there is something, if only a
    broken link.

    The temporary name keeps the suffix, because writers choose their format by it. Old temporary
    files in the folder, which processes left that were killed, are removed.

    Raises OSError that names `path` where it cannot be written (the disk is full).
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    _sweep(path.parent)
    temporary: Path | None = None
    try:
        handle, name = tempfile.mkstemp(prefix=_TEMPORARY, suffix=path.suffix, dir=path.parent)
        os.close(handle)
        temporary = Path(name)
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        if new:
            _claim(temporary, path)
        else:
            temporary.replace(path)
    except OSError as problem:
        names = [str(n) for n in (problem.filename, problem.filename2) if n is not None]
        if problem.errno is None or (names and not any(_TEMPORARY in name for name in names)):
            raise  # of another file, or not of a file at all
        raise OSError(problem.errno, problem.strerror or str(problem), str(path)) from problem
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def _claim(temporary: Path, path: Path) -> None:
    """Gives a file a name that nothing has."""
    try:
        os.link(temporary, path)  # fails where there is something, whoever put it there meanwhile
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY))
        temporary.replace(path)


def _sweep(folder: Path) -> None:
    """Removes old temporary files of ours: regular files of such a name, never through a link."""
    before = time.time() - _OLD
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith(_TEMPORARY) and _LEFT.fullmatch(entry.name):
                with suppress(OSError):
                    if (
                        entry.is_file(follow_symlinks=False)
                        and entry.stat(follow_symlinks=False).st_mtime < before
                    ):
                        os.unlink(entry.path)


def write_text(path: Path, text: str, new: bool = False) -> None:
    """Writes a text file atomically, as UTF-8 with plain line ends; see `atomic_path`."""
    with atomic_path(path, new) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
