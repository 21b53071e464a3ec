"""Shared by all tests: the caches of a test run do not touch the user's."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

os.environ.setdefault("I2PDSL_CACHE", str(Path(tempfile.gettempdir()) / "i2pdsl-test-cache"))
