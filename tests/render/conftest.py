"""Chromium for the tests of pages."""

import pytest

from browser_for_tests import chromium  # noqa: F401


@pytest.fixture
def open_page(chromium, tmp_path):  # noqa: F811
    """Opens a page; at the end, no message and no request beyond the file itself is allowed."""
    contexts, trouble = [], []

    def open_text(text, width=1280, height=900, motion="reduce", **settings):
        path = tmp_path / f"page-{len(contexts)}.html"
        path.write_text(text, encoding="utf-8")
        context = chromium.new_context(
            viewport={"width": width, "height": height}, reduced_motion=motion, **settings
        )
        contexts.append(context)
        shown = context.new_page()
        shown.on("console", lambda message: trouble.append(message.text))
        shown.on("pageerror", lambda error: trouble.append(str(error)))
        shown.on("request", lambda r: r.url == path.as_uri() or trouble.append(r.url))
        shown.goto(path.as_uri())
        return shown

    yield open_text
    for context in contexts:
        context.close()
    assert trouble == []
