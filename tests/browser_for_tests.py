"""Chromium, for tests of pages."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)


KEPT = pytest.StashKey[tuple[Any, asyncio.AbstractEventLoop]]()


@pytest.fixture(scope="module")
def chromium(request: pytest.FixtureRequest) -> Iterator[Any]:
    """The browser of all tests of a process."""
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine")
    if KEPT not in request.config.stash:
        request.config.stash[KEPT] = _launched(request.config)
    browser, loop = request.config.stash[KEPT]
    with _running(loop):
        yield browser
        for context in browser.contexts:
            context.close()


def _launched(config: pytest.Config) -> tuple[Any, asyncio.AbstractEventLoop]:
    from playwright.sync_api import sync_playwright

    playwright = sync_playwright().start()
    loop = asyncio.get_running_loop()
    browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)

    def end() -> None:
        with _running(loop):
            browser.close()
            playwright.stop()

    config.add_cleanup(end)
    return browser, loop


@contextmanager
def _running(loop: asyncio.AbstractEventLoop) -> Iterator[None]:
    """Playwright's loop counts as running while it is there; other tests have their own."""
    asyncio._set_running_loop(loop)
    try:
        yield
    finally:
        asyncio._set_running_loop(None)
