"""How stories, scripts, results and answers show themselves in a notebook.

Each function returns what IPython's `_repr_mimebundle_` does: data by MIME type, and metadata.
Of a script there are three pictures, since viewers of notebooks differ: the page with its player
in an iframe; the comic strip behind it, inside the same HTML, which stays where iframes are taken
out (GitHub, notebooks that are not trusted); and the comic strip by itself, for PDFs. All of it
comes to some 180 kB in the kitchen and 320 kB on the hill.
"""

from __future__ import annotations

import base64
import io
import tempfile
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from i2pdsl.answers import Answer
from i2pdsl.notebook.source import story_html
from i2pdsl.scripts import Script
from i2pdsl.shown import Bundle, shows
from i2pdsl.stories import Result, Story

PLAYER_HEIGHT = 760  # pixels: the film with its controls, and the curves' heads below it
SHARPNESS, ENLARGED = 200, 130  # of a curve: dots to an inch, and CSS pixels to an inch
# Of curves that the palette does not name, by names that it has.
HUES = ("helping", "hindering", "green", "pink", "none", "indifferent", "cheese", "robot")
LINES = 30  # of an answer in plain text


def show_story(story: Story) -> Bundle:
    """The story's text in colours, and in a line what it comes to."""
    told = story.typed
    about = f"world {told.world}, {told.frames}, search {told.search.method}"
    html = f"<div>{story_html(told.source.text)}<p><small>{escape(about)}</small></p></div>"
    return {"text/html": html, "text/plain": f"{story!r}\n{told.source.text.rstrip()}"}, {}


def show_script(script: Script) -> Bundle:
    """The page with its player, and the comic strip."""
    return _shown(script, "", repr(script))


def show_result(result: Result) -> Bundle:
    """The scores of all candidates and what the panel makes of them, and the best script."""
    rows: list[tuple[str, ...]] = []
    for script, judgement in zip(result.candidates, result.judgements, strict=True):
        score = "–" if script.score is None else f"{script.score:.4f}"
        told = (f"{judgement.mean:.4f}", f"{judgement.worst:.4f}", f"{100 * script.still:.0f} %")
        rows.append((str(len(rows) + 1), score, *told, str(script.length)))
    heads = ("candidate", "score", "panel", "worst", "still", "frames")
    table = table_html(heads, rows) if len(rows) > 1 else ""
    seconds = ", ".join(f"{name} {value:.1f} s" for name, value in result.seconds.items())
    ended = "" if result.finished else "interrupted; "
    note = f"<p><small>{ended}{escape(seconds)}</small></p>"
    plain = "\n".join((repr(result), *(f"{n:>4}  {score}" for n, score, *_ in rows)))
    return _shown(result.script, table + note, plain)


def show_answer(answer: Answer) -> Bundle:
    """A number as it is; a small table for latents; curves for what goes on over t."""
    lines = answer.in_words().splitlines()
    if len(lines) > LINES:
        lines[LINES // 2 : -LINES // 2] = [f"   … {len(lines) - LINES} more"]
    data: dict[str, Any] = {"text/plain": "\n".join(lines)}
    if answer.axes:
        if answer.t is None:
            heads, found = answer.grid()
            cells = [(*keys, *(f"{v:.4f}" for v in values)) for keys, values in found]
            data["text/html"] = table_html(heads, cells)
        return data, {}
    if answer.t is not None:
        png, width = curves_png(answer)
        data["image/png"] = _base64(png)
        return data, {"image/png": {"width": width}}
    if answer.labels is not None:
        rows = [(name, f"{float(value):.4f}") for name, value in answer.columns().items()]
        data["text/html"] = table_html((answer.latent or "value", "probability"), rows)
    return data, {}


def table_html(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table without colours of its own: those of the notebook's theme are right for it."""
    cells = lambda tag, row: "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in row)
    body = "".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    return f"<table><thead><tr>{cells('th', heads)}</tr></thead><tbody>{body}</tbody></table>"


def curves_png(answer: Answer) -> tuple[bytes, int]:
    """The curves of an answer over t, drawn as in all pictures; and a width to show them in."""
    from i2pdsl.render.mind import PALETTE, Panel, Series, mind_figure, save_mind

    assert answer.t is not None
    columns = answer.columns()
    hues = [PALETTE[name] for name in HUES]
    inside = all(((v >= 0) & (v <= 1)).all() for v in columns.values())
    is_belief = answer.labels is not None or answer.expression.startswith("P(")
    curves = [
        Series(
            name if answer.labels is not None else "",
            np.concatenate([np.full(answer.t[0], np.nan), values]),  # some begin at frame 1
            PALETTE.get(name, hues[number % len(hues)]),
            answer.steps,
        )
        for number, (name, values) in enumerate(columns.items())
    ]
    kind: Any = "probability" if inside and is_belief else "value"
    unit = "probability" if is_belief else "value"
    panel = Panel(answer.expression, unit, tuple(curves), kind)
    width = mind_figure([panel], "").get_figwidth()
    with tempfile.TemporaryDirectory() as folder:
        path = save_mind(Path(folder, "curve.png"), [panel], "", dpi=SHARPNESS)
        return path.read_bytes(), round(width * ENLARGED)


def _shown(script: Script, above: str, plain: str) -> Bundle:
    """The player of a script below some HTML, with the comic strip behind it; the strip alone where
    films cannot be played."""
    from i2pdsl.render.pictures import pictures_of
    from i2pdsl.render.raster import svg_png

    pictures = pictures_of([script])
    comic = _base64(_small(svg_png(pictures.comic())))
    title = escape(pictures.title)
    over = "position:absolute;inset:0;width:100%;height:100%;border:0"
    strip = (
        f'<img alt="{title}: comic strip" src="data:image/png;base64,{comic}" '
        'style="max-width:100%;max-height:100%">'
    )
    if "html" not in pictures.offered:
        return {"text/html": above + strip, "image/png": comic, "text/plain": plain}, {}
    framed = (
        pictures.page().replace("&", "&amp;").replace("'", "&#39;")
    )  # of its 7000 " each stays one letter
    html = (
        f'{above}<div style="position:relative;height:{PLAYER_HEIGHT}px">{strip}'
        f'<iframe title="{title}: player" sandbox="allow-scripts" style="{over}" '
        f"srcdoc='{framed}'></iframe></div>"
    )
    return {"text/html": html, "image/png": comic, "text/plain": plain}, {}


def _small(png: bytes) -> bytes:
    """The same picture in 256 colours: it looks the same, at a third of the size. The palette
    covers all the picture's colours, or small things would turn grey, and then follows their means.
    """
    from PIL import Image

    smaller = io.BytesIO()
    with Image.open(io.BytesIO(png)) as image:
        flat = image.convert("RGB").quantize(
            256, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE
        )
        flat.save(smaller, "PNG", optimize=True)
    return smaller.getvalue()


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


shows(Story, show_story)
shows(Script, show_script)
shows(Result, show_result)
shows(Answer, show_answer)
