"""Files of the cache that are believed as they are, so only what this user's i2pdsl wrote is read.

Each file begins with a keyed digest (HMAC-SHA256, RFC 2104) of its name and the rest, under a key
that lies outside the cache and that only the user can read. The cache may be deleted, damaged or
shared at any time; whoever has another key has files of other names.
"""

from __future__ import annotations

import errno
import hashlib
import hmac
import os
import secrets
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path

from i2pdsl.resources import atomic_path, cache_folder
from i2pdsl.untrusted import read_bytes

_DIGEST = hashlib.sha256().digest_size


def signed_path(kind: str, description: str) -> Path:
    """The file, in the cache's folder for such things, of what is described so.

    Raises OSError where none can be kept.
    """
    name = hmac.digest(_key(), b"name", "sha256").hex()[:8]
    digest = hashlib.sha256(description.encode()).hexdigest()[:32]
    return cache_folder(f"{kind}s") / f"{digest}-{name}.{kind}"


def read_signed(path: Path, most: int) -> bytes:
    """What was written there, of at most so many bytes.

    Raises OSError, and ValueError where it is not what was written.
    """
    written = read_bytes(path, most)
    data = written[_DIGEST:]
    if not hmac.compare_digest(_signature(path, data), written[:_DIGEST]):
        raise ValueError("it is not what was written")
    return data


def write_signed(path: Path, data: bytes) -> None:
    """Raises OSError."""
    with atomic_path(path) as temporary:
        temporary.write_bytes(_signature(path, data) + data)


def _signature(path: Path, data: bytes) -> bytes:
    """Of what is in a file, and of which file it is: one is not taken for another."""
    return hmac.digest(_key(), path.name.encode() + b"\0" + data, "sha256")


@cache
def _key() -> bytes:
    """The secret under which this user's files are signed; made at its first use.

    Raises OSError where it can neither be read nor kept.
    """
    from platformdirs import user_state_path

    path = user_state_path("i2pdsl") / "program-key"
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    for _ in range(3):  # another process may be making it
        try:
            key = read_bytes(path, _DIGEST)
            if len(key) == _DIGEST:
                return key
            path.unlink()
        except FileNotFoundError:
            pass
        handle, name = tempfile.mkstemp(dir=path.parent)  # only the user may read it
        try:
            with open(handle, "wb") as file:
                file.write(secrets.token_bytes(_DIGEST))
            with suppress(FileExistsError):
                os.link(name, path)  # of several processes the first one's counts
        finally:
            os.unlink(name)
    raise OSError(errno.EIO, "it cannot be read back", str(path))
