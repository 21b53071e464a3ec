"""The committed bundle of CodeMirror is the one that was built from the committed lock file."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
CLIENT = ROOT / "i2pdsl" / "studio" / "client"
LOCK = ROOT / "codemirror" / "package-lock.json"


def test_the_bundle_is_the_one_that_was_built() -> None:
    told = dict(
        line.split()[::-1]
        for line in (CLIENT / "codemirror.sha256").read_text("utf-8").splitlines()
    )
    for path in (CLIENT / "codemirror.js", LOCK):
        assert hashlib.sha256(path.read_bytes()).hexdigest() == told[path.name], (
            f"{path.name} was changed by hand: run `make codemirror`"
        )


def test_the_lock_file_pins_everything_and_names_no_host() -> None:
    text = LOCK.read_text(encoding="utf-8")
    assert "resolved" not in text
    assert "://" not in re.sub(r'"funding": \{[^}]*\}|"url": "[^"]*"', "", text)
    packages = json.loads(text)["packages"]
    assert all("integrity" in each for name, each in packages.items() if name)


def test_every_package_in_the_bundle_has_its_licence_beside_it() -> None:
    licences = (CLIENT / "codemirror.licences.txt").read_text(encoding="utf-8")
    packages = json.loads(LOCK.read_text(encoding="utf-8"))["packages"]
    used = [n for n, each in packages.items() if n and not each.get("dev")]
    assert len(used) >= 10
    told = set(re.findall(r"^(\S+) \d\S* \((?:MIT)\)$", licences, re.MULTILINE))
    grammar_builders = {"@lezer/lr"}  # imported by what is not used of @codemirror/language
    assert {name.removeprefix("node_modules/") for name in used} - told <= grammar_builders
