"""Chromium for the tests of pages."""

from contextlib import ExitStack

import pytest

from browser_for_tests import chromium  # noqa: F401


@pytest.fixture(scope="module")
def usual(chromium):  # noqa: F811
    """The page that a module's tests open anew, one after the other."""
    context = chromium.new_context()
    yield context.new_page()
    context.close()


@pytest.fixture
def open_page(request, chromium, tmp_path):  # noqa: F811
    """Opens a page; at the end, no message and no request beyond the file itself is allowed."""
    paths, contexts, trouble, ending = [], [], [], ExitStack()

    def page_for(settings):
        if settings or paths:  # the usual one is in use already
            contexts.append(chromium.new_context(**settings))
            return contexts[-1].new_page()
        found = request.getfixturevalue("usual")
        found.mouse.move(0, 0)
        return found

    def open_text(text, width=1280, height=900, motion="reduce", color_scheme="light", **settings):
        shown = page_for(settings)
        path = tmp_path / f"page-{len(paths)}.html"
        paths.append(path)
        path.write_text(text, encoding="utf-8")
        shown.set_viewport_size({"width": width, "height": height})
        shown.emulate_media(reduced_motion=motion, color_scheme=color_scheme)
        for event, hear in (
            ("console", lambda message: trouble.append(message.text)),
            ("pageerror", lambda error: trouble.append(str(error))),
            ("request", lambda r: r.url == path.as_uri() or trouble.append(r.url)),
        ):
            shown.on(event, hear)
            ending.callback(shown.remove_listener, event, hear)
        shown.goto(path.as_uri())
        return shown

    yield open_text
    ending.close()
    for context in contexts:
        context.close()
    assert trouble == []
