"""Files of trained controllers are input: whatever is in one, it is refused with a reason, soon."""

from __future__ import annotations

import io
import json
import os
import shutil
import zipfile
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest

from i2pdsl.resources import cache_folder
from i2pdsl.worlds.hill.controllers import (
    SHIPPED,
    file_name,
    find_controllers,
    load_controllers,
    save_controllers,
)
from i2pdsl.worlds.hill.spec import HillSpec

GOOD = SHIPPED / file_name(HillSpec(), 0)


def arrays() -> dict[str, np.ndarray]:
    with np.load(GOOD, allow_pickle=False) as archive:
        return {key: archive[key] for key in archive.files}


def about(**changes: Any) -> dict[str, np.ndarray]:
    """The good arrays with other words about them; None leaves one out."""
    found = {**json.loads(str(arrays()["about"])), **changes}
    kept = {key: value for key, value in found.items() if value is not None}
    return {**arrays(), "about": np.array(json.dumps(kept))}


def with_array(name: str, array: np.ndarray) -> dict[str, np.ndarray]:
    return {**arrays(), name: array}


def packed(content: dict[str, np.ndarray], pickled: bool = False) -> bytes:
    file = io.BytesIO()
    if pickled:
        np.savez(file, **{k: np.array([v], dtype=object) for k, v in content.items()})  # type: ignore[arg-type]
    else:
        np.savez_compressed(file, **content)  # type: ignore[arg-type]
    return file.getvalue()


def zipped(entries: dict[str, bytes]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries.items():
            archive.writestr(name, data)
    return file.getvalue()


def head(shape: str, kind: str = "<f4") -> bytes:
    """An .npy file with no content behind its head."""
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    return b"\x93NUMPY\x01\x00" + (len(text)).to_bytes(2, "little") + text.encode()


def doubled() -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name in ("about.npy", "about"):
            archive.writestr(name, head("()", "<U0"))
    return file.getvalue()


FIRST, BIAS = "policy_0_matrix", "policy_0_bias"
WRONG = {
    "empty": lambda: b"",
    "text": lambda: b"world hill\n",
    "half": lambda: GOOD.read_bytes()[:50_000],
    "pickle": lambda: packed(arrays(), pickled=True),
    "bare pickle": lambda: b"cos\nsystem\n(S'touch /tmp/evil'\ntR.",
    "bomb": lambda: zipped({"about.npy": b"\0" * 200 * 2**20}),
    "many": lambda: zipped({f"a{i}.npy": b"\0" * 10**6 for i in range(40)}),
    "large array": lambda: zipped({"about.npy": head("(10**9,)")}),
    "larger array": lambda: zipped({"about.npy": head("(1000000000000,)")}),
    "negative array": lambda: zipped({"about.npy": head("(-5, -1)")}),
    "code in the head": lambda: zipped({"about.npy": head("(__import__('os').getpid(),)")}),
    "two of one name": doubled,
    "nothing": lambda: packed({}),
    "no about": lambda: packed({k: v for k, v in arrays().items() if k != "about"}),
    "no json": lambda: packed(with_array("about", np.array("{"))),
    "deep json": lambda: packed(with_array("about", np.array("[" * 100_000))),
    "list": lambda: packed(with_array("about", np.array("[]"))),
    "format": lambda: packed(about(format="x")),
    "version": lambda: packed(about(version=[2])),
    "weights": lambda: packed(about(weights="ab")),
    "no weights": lambda: packed(about(weights=None)),
    "one weight": lambda: packed(about(weights=[1])),
    "equal weights": lambda: packed(about(weights=[1, 1])),
    "falling weights": lambda: packed(about(weights=[0.5, 0.1])),
    "weights nan": lambda: packed(about(weights=[float("nan"), 1])),
    "weights true": lambda: packed(about(weights=[0.1, True])),
    "weights huge": lambda: packed(about(weights=[0.1, 10**400])),
    "iterations": lambda: packed(about(iterations=["many"])),
    "no policy": lambda: packed({k: v for k, v in arrays().items() if "policy" not in k}),
    "no bias": lambda: packed({k: v for k, v in arrays().items() if k != BIAS}),
    "nan": lambda: packed(with_array(BIAS, arrays()[BIAS] * np.nan)),
    "infinite": lambda: packed(with_array(FIRST, arrays()[FIRST] + np.inf)),
    "texts": lambda: packed(with_array(BIAS, arrays()[BIAS].astype(str))),
    "whole numbers": lambda: packed(with_array(BIAS, arrays()[BIAS].astype(int))),
    "complex": lambda: packed(with_array(BIAS, arrays()[BIAS].astype(complex))),
    "turned": lambda: packed(with_array(FIRST, arrays()[FIRST].T.copy())),
    "short": lambda: packed(with_array(BIAS, arrays()[BIAS][:-1])),
    "scalar": lambda: packed(with_array(FIRST, np.array(1.0))),
    "other inputs": lambda: packed(with_array(FIRST, arrays()[FIRST][:, :-1])),
    "other outputs": lambda: packed(
        with_array("value_2_matrix", np.ones((2, 64)))
        | {"value_2_bias": np.ones(2)}
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_refused(case: str, tmp_path: Path) -> None:
    path = tmp_path / "c.npz"
    path.write_bytes(WRONG[case]())
    with pytest.raises(ValueError, match="it is damaged"):
        load_controllers(path)


def test_what_was_saved_is_read(tmp_path: Path) -> None:
    found = load_controllers(GOOD)
    save_controllers(tmp_path / "c.npz", found)
    again = load_controllers(tmp_path / "c.npz")
    assert again.weights == found.weights == HillSpec().trained_weights
    for old, new in zip((*found.policy, *found.value), (*again.policy, *again.value), strict=True):
        for a, b in zip(old, new, strict=True):
            np.testing.assert_array_equal(a, b)


def test_any_bytes_changed(tmp_path: Path) -> None:
    random, good, path = Random(5), GOOD.read_bytes(), tmp_path / "c.npz"
    for _ in range(60):
        data = bytearray(good)
        for _ in range(random.randint(1, 4)):
            # The directory at the end and the heads between the arrays are where it matters.
            at = random.choice([random.randrange(len(data)), len(data) - random.randint(1, 900)])
            data[at] = random.randrange(256)
        path.write_bytes(bytes(data))
        try:
            load_controllers(path)
        except ValueError as problem:
            assert str(problem).startswith("it is damaged")  # noqa: PT017


def test_why_controllers_are_not_used_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only what is damaged is called so, and those that ship are used then."""
    monkeypatch.setenv("I2PDSL_CACHE", str(tmp_path))
    spec, said = HillSpec(), list[str]()
    path = cache_folder("controllers") / file_name(spec, 0)
    shutil.copyfile(GOOD, path)
    find_controllers(spec, 0, said.append)
    assert said == []
    other = packed(about(weights=[0.1, 0.9]))
    for data, reason in ((b"", "it is damaged"), (other, "they were trained for other weights")):
        path.write_bytes(data)
        said.clear()
        assert find_controllers(spec, 0, said.append).weights == spec.trained_weights
        assert said[0].startswith(f"the controllers {path} cannot be used: {reason}")
    for kind, reason in ((os.mkfifo, "it is a pipe, not a file"), (os.mkdir, "it is a folder")):
        path.unlink()
        kind(path)
        said.clear()
        find_controllers(spec, 0, said.append)
        assert said == [f"the controllers {path} cannot be used: {reason}"]
