"""`pytest tests/language --update-goldens` rewrites tests/golden/*.txt."""

from __future__ import annotations

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-goldens", action="store_true", help="write the messages of today as golden"
    )
