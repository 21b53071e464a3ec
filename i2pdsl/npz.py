"""Arrays out of .npz files that anyone may have written."""

from __future__ import annotations

import io
import math
import zipfile
from pathlib import Path

import numpy as np

from i2pdsl.untrusted import read_bytes


def read_arrays(path: Path | str, largest: int) -> dict[str, np.ndarray]:
    """The arrays of an .npz file of at most `largest` bytes, packed and unpacked; no pickles.

    Raises OSError as `read_bytes` does, else what zipfile and NumPy raise for a damaged file.
    """
    found: dict[str, np.ndarray] = {}
    with zipfile.ZipFile(io.BytesIO(read_bytes(path, largest))) as archive:
        entries = archive.infolist()
        # What an entry unpacks to is never more than it says.
        if sum(entry.file_size for entry in entries) > largest:
            raise ValueError(f"its arrays have more than {largest:,} bytes")
        for entry in entries:
            name = entry.filename.removesuffix(".npy")
            if name in found:
                raise ValueError(f"two arrays are called {name[:40]}")
            found[name] = _array(archive.read(entry))
    return found


def _array(data: bytes) -> np.ndarray:
    """An array from the content of an .npy file that is as long as its head says."""
    file = io.BytesIO(data)
    version = np.lib.format.read_magic(file)
    if version not in ((1, 0), (2, 0)):
        raise ValueError(f"an array is of version {version}")
    is_old = version == (1, 0)
    head = np.lib.format.read_array_header_1_0 if is_old else np.lib.format.read_array_header_2_0
    shape, _, kind = head(file)
    if kind.hasobject or math.prod(shape) * kind.itemsize != len(data) - file.tell():
        raise ValueError("an array is not as long as it says")
    file.seek(0)
    return np.lib.format.read_array(file, allow_pickle=False)
