"""The illustrated catalogue of a library, for an animator to pick patterns from: contents, and a
page for each family of patterns."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any
from urllib.parse import quote

from i2pdsl.editor.colours import colour
from i2pdsl.language.kinds import PARAMETER_KINDS
from i2pdsl.library.curves import Curves
from i2pdsl.library.description import MADE_WITH, PatternLibrary
from i2pdsl.library.examples import Example, Shown, place_of
from i2pdsl.library.families import Family, by_family
from i2pdsl.library.films import PackedFilm
from i2pdsl.render.film_page import controls, part
from i2pdsl.render.modules import one_module
from i2pdsl.resources import write_text
from i2pdsl.untrusted import below

_REFERENCE = re.compile(
    r"(?:^|(?<=[.!?)] ))(?:After|See|From) (?=[A-Z]).*|(?<=\. )[^.]*\bet al\..*$"
)
_SPARK = (120, 36)  # units of the little curves in the contents
_PLOT = {"left": 26, "right": 196, "top": 8, "bottom": 88, "width": 200, "height": 104}


@dataclass(frozen=True)
class _Told:
    """What a documentation says: what the pattern means, its parameters, and where it is from."""

    meaning: list[str]
    parameters: dict[str, str]
    reference: str


def save_catalogue(
    folder: Path,
    library: PatternLibrary,
    examples: dict[str, list[Example]],
    shown: dict[str, Shown],
    failed: dict[str, str],
    seeds: int,
) -> None:
    """Writes `index.html` and a page for each family into a folder; the pictures are in its folder
    `pictures`. While examples are made they are written anew: each page is whole at any time.

    Args:
        examples: those that each pattern has.
        shown: those that were made, by their names.
        failed: why others could not be made.
        seeds: of which each example is the best.
    """
    families = by_family(library.patterns)
    names = {"standard": "The standard patterns"}
    title = names.get(library.name, f"The patterns of {library.name}")
    every = sum(map(len, examples.values()))
    about = f"{len(shown)} of {every} example{'s' * (every != 1)}, made by {MADE_WITH}"
    if seeds > 1:
        about += f"; each is the best of {seeds} seeds for viewers whom it was not made for"
    if len(shown) + len(failed) < every:
        about += ". Reload the page for more, while they are being made"
    count = len(library.patterns)
    lead = (
        f"{count} way{'s' * (count != 1)} to shape what viewers come to believe. Each curve below "
        "is measured: what somebody who watches its example believes, from the first frame to the "
        "last."
    )
    cards = "\n".join(
        _cards(family, members, examples, shown) for family, members in families.items()
    )
    _save_page(folder, "index", title, lead, about, f"{cards}\n")
    for family, members in families.items():
        sections = [_section(p, examples[p["name"]], shown, failed) for p in members]
        pages = {"index": "All patterns"} | {f.name: f.title for f in families if f is not family}
        links = "".join(f'<li><a href="{n}.html">{t}</a></li>' for n, t in pages.items())
        links = f'  <nav aria-label="Pages"><ul class="pages">{links}</ul></nav>'
        body = "\n".join([links, *sections])
        every_film = (shown[e.name].film for p in members for e in examples[p["name"]]
                      if e.name in shown)  # fmt: skip
        scripts = sorted({film.script for film in every_film if film is not None})
        head = f"{title}: {family.title}"
        _save_page(folder, family.name, head, family.lead, about, body, scripts)


def _save_page(
    folder: Path,
    name: str,
    title: str,
    lead: str,
    about: str,
    body: str,
    scripts: Sequence[str] = (),
) -> None:
    """A page; `scripts` are those of its films."""
    allowed, player = _player(scripts)
    page = Template(_part("library", "catalogue.html")).substitute(
        scripts=allowed,
        player=player,
        title=escape(title),
        style=_part("render", "page.css") + _part("library", "catalogue.css"),
        lead=lead,
        about=escape(about),
        body=body,
    )
    write_text(below(folder, f"{name}.html"), page)


def _player(scripts: Sequence[str]) -> tuple[str, str]:
    """What a page's policy allows, and what plays films in it; nothing where there are none.

    A hash allows one script: no text of a library could bring another one in.
    """
    if not scripts:
        return "'none'", ""
    imports = "".join(
        f'import {{ makeStage as make{n} }} from "/render/{script}";\n'
        for n, script in enumerate(scripts)
    )
    makers = ", ".join(f'"{script}": make{n}' for n, script in enumerate(scripts))

    def read(path: str) -> str:
        if path == "/makers.js":
            return f"{imports}export const makers = {{ {makers} }};\n"
        if path == "/catalogue.js":
            return f"{_part('library', 'catalogue.js')}export const done = true;\n"
        return part(path.removeprefix("/render/"))

    script = one_module("/catalogue.js", read)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    template = f"""\
<template id="player">
  <section class="theatre">
    <figure class="stage">
      <figcaption><span id="frame-number" class="badge">Start</span> \
<span id="caption"></span></figcaption>
    </figure>
{controls(0)}  </section>
</template>
<script type="module">{script}</script>"""
    return f"'sha256-{digest}'", template


def _cards(
    family: Family,
    patterns: list[dict[str, Any]],
    examples: dict[str, list[Example]],
    shown: dict[str, Shown],
) -> str:
    """A family in the contents."""
    cards = "\n".join(_entry(family, p, examples[p["name"]], shown) for p in patterns)
    return f"""\
  <nav aria-labelledby="{family.name}-heading">
    <h2 id="{family.name}-heading"><a href="{family.name}.html">{family.title}</a></h2>
    <p class="meaning">{family.lead}</p>
    <ul class="contents">
{cards}
    </ul>
  </nav>"""


def _part(room: str, name: str) -> str:
    return (files(f"i2pdsl.{room}") / "page" / name).read_text(encoding="utf-8")


def _entry(
    family: Family, pattern: dict[str, Any], examples: list[Example], shown: dict[str, Shown]
) -> str:
    """A card of the contents."""
    name = escape(pattern["name"])
    found = next((shown[e.name] for e in examples if e.name in shown), None)
    picture = '<span class="blank">no example yet</span>'
    if found is not None and found.curves:
        picture = _spark(found.curves[0])
    meaning = _told(pattern).meaning
    first = meaning[0].split(". ")[0].rstrip(".") if meaning else ""
    said = f"<span>{_prose(first)}</span>" if first else ""
    told = f"{picture}<strong>{_title(name)}</strong>{said}"
    return f'      <li><a href="{family.name}.html#{name}">{told}</a></li>'


def _title(name: str) -> str:
    return name.replace("_", " ")


def _section(
    pattern: dict[str, Any],
    examples: list[Example],
    shown: dict[str, Shown],
    failed: dict[str, str],
) -> str:
    """All about one pattern."""
    name = escape(pattern["name"])
    told = _told(pattern)
    lines = [f'  <section class="pattern" id="{name}" aria-labelledby="{name}-heading">']
    lines.append(f'    <h2 id="{name}-heading"><a href="#{name}">{_title(name)}</a></h2>')
    lines += [f'    <p class="meaning">{_prose(p)}</p>' for p in told.meaning]
    if told.reference:
        lines.append(f'    <p class="reference">{_prose(told.reference)}</p>')
    names = {p["name"]: "parameter" for p in pattern["parameters"]}
    formula = f"pattern {_signature(pattern)} =\n{_indented(pattern['body'])}"
    lines.append(
        '    <div class="how">\n      <div>\n        <h3>Formula</h3>\n        '
        f'<pre class="text"><code>{_coloured(formula, names)}</code></pre>\n      </div>'
    )
    lines.append(f"      <div>\n        <h3>You give</h3>\n{_parameters(pattern, told)}")
    lines.append(f"{_fits(pattern)}\n      </div>\n    </div>")
    for example in examples:
        if example.name in shown:
            lines.append(_example(shown[example.name]))
        elif example.name not in failed:
            where = escape(place_of(example.world))
            lines.append(f'    <p class="missing">The example {where} is not made yet.</p>')
        else:
            why, where = _prose(failed[example.name]), escape(place_of(example.world))
            lines.append(
                f'    <div class="example"><p class="missing">The example {where} '
                f"could not be made: {why}.</p></div>"
            )
    lines.append('    <p class="back"><a href="#top">To the top</a></p>')
    return "\n".join([*lines, "  </section>"])


def _told(pattern: dict[str, Any]) -> _Told:
    """The parts of a pattern's documentation, by how the standard patterns are documented."""
    paragraphs = _paragraphs(pattern["documentation"])
    last = paragraphs[-1]
    reference = _REFERENCE.search(last)
    if reference is not None:
        paragraphs[-1] = last[: reference.start()].strip()
    names = "|".join(re.escape(p["name"]) for p in pattern["parameters"]) or "(?!)"
    parameters: dict[str, str] = {}
    meaning = []
    for paragraph in paragraphs:
        first, *rest = re.split(
            rf"(?:^|(?<=[.;:] ))(`(?:{names})`(?:, `(?:{names})`)*): ", paragraph
        )
        meaning += [part.strip() for part in re.split(r"(?<=[.!?]) (?=Use it )", first)]
        for about, text in zip(rest[::2], rest[1::2], strict=True):
            for name in re.findall(r"`(\w+)`", about):
                parameters[name] = text.strip()
    said = reference.group() if reference is not None else ""
    return _Told([m for m in meaning if m], parameters, said)


def _paragraphs(documentation: str) -> list[str]:
    found = [" ".join(p.split()) for p in re.split(r"\n\s*\n", documentation)]
    return found or [""]


def _prose(text: str) -> str:
    """Text with its `code`."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text, quote=False))


def _signature(pattern: dict[str, Any]) -> str:
    parts = [
        p["name"] if p["default"] is None else f"{p['name']} = {p['default']}"
        for p in pattern["parameters"]
    ]
    return f"{pattern['name']}({', '.join(parts)})" if parts else str(pattern["name"])


def _indented(body: str) -> str:
    """A formula's lines, the shortest margin of those after the first taken away."""
    first, *rest = body.split("\n")
    margins = [len(line) - len(line.lstrip()) for line in rest if line.strip()]
    cut = max(0, min(margins, default=0) - 4)
    return "\n".join([f"    {first.strip()}", *(line[cut:].rstrip() for line in rest)])


def _coloured(text: str, names: dict[str, str]) -> str:
    pieces = []
    for piece in colour(text, names):
        word = escape(text[piece.start : piece.end], quote=False)
        plain = piece.kind in ("space", "name", "sign", "operator", "bracket")
        pieces.append(word if plain else f'<span class="k-{piece.kind}">{word}</span>')
    return "".join(pieces)


def _parameters(pattern: dict[str, Any], told: _Told) -> str:
    rows = []
    for parameter in pattern["parameters"]:
        name, default = parameter["name"], parameter["default"]
        kind = _prose(PARAMETER_KINDS.get(parameter["kind"], parameter["kind"]))
        text = told.parameters.get(name, "")
        said = f"{_prose(text)} " if text else ""
        usual = f"; without it <code>{escape(default, quote=False)}</code>" if default else ""
        rows.append(
            f"          <dt><code>{escape(name)}</code></dt>"
            f'<dd>{said}<span class="kind">{kind}{usual}</span></dd>'
        )
    if not rows:
        return '        <p class="missing">Nothing: it stands by itself.</p>'
    return "\n".join(['        <dl class="parameters">', *rows, "        </dl>"])


def _fits(pattern: dict[str, Any]) -> str:
    items = []
    for world, proof in pattern["worlds"].items():
        name = escape(world)
        if proof["fits"]:
            items.append(f"<li>{name}</li>")
        else:
            items.append(f'<li class="no">not {name}: {_prose(proof["because"])}</li>')
    return f'        <h3 class="next">It fits</h3>\n        <ul class="fits">{"".join(items)}</ul>'


def _example(made: Shown) -> str:
    example = made.example
    name, place = escape(quote(example.name)), escape(place_of(example.world))
    taken = f"{escape(example.story)}; " if example.story else ""
    panels = "\n".join(_panel(panel) for panel in made.curves)
    label = f"{_title(escape(example.pattern))} {place}"
    width, height = made.size
    return f"""\
    <article class="example" aria-label="{label}">
      <div class="example-head">
        <h3>{place[0].upper()}{place[1:]}</h3>
        <p>{taken}score {made.score:.4g}, panel {made.panel:.4g}</p>
        <a href="pictures/{name}.html">Watch it<span class="unseen">: {label}</span></a>
      </div>
      <div{_place(made.film, label)}>
        <a class="strip" href="pictures/{name}.html"><img src="pictures/{name}.png" \
width="{width}" height="{height}" loading="lazy" alt="The comic of {label}"></a>{_film(made.film)}
      </div>
      <div class="below">
        <div>
          <h3>What viewers believe</h3>
          <div class="panels">
{panels}
          </div>
        </div>
        <div>
          <h3>The story</h3>
          <pre class="text"><code>{_coloured(example.source.rstrip(), {})}</code></pre>
        </div>
      </div>
    </article>"""


def _place(film: PackedFilm | None, label: str) -> str:
    """Where a film plays in place of its comic."""
    return "" if film is None else f' class="place" data-label="{label}"'


def _film(film: PackedFilm | None) -> str:
    if film is None:
        return ""
    return f"""
        <script type="application/gzip" data-script="{film.script}">{film.data}</script>"""


# Curves.


def _path(
    curves: Curves, values: list[float | None], box: tuple[float, float, float, float]
) -> str:
    """A curve's path data in a box (left, top, right, bottom); a gap where a value is missing."""
    left, top, right, bottom = box
    path, pen = [], "M"
    for number, value in enumerate(values):
        if value is None:
            pen = "M"
            continue
        x = left + (right - left) * number / max(1, len(values) - 1)
        y = bottom - (bottom - top) * (value - curves.low) / ((curves.high - curves.low) or 1)
        path.append(f"{pen}{x:.1f} {y:.1f}")
        pen = "L"
    return "".join(path)


def _spark(curves: Curves) -> str:
    """The curves small, without axes."""
    width, height = _SPARK
    box = (2.0, 3.0, width - 2.0, height - 3.0)
    lines = [
        f'<g class="curve" style="--hue: {escape(s["color"])}">'
        f'<path d="{_path(curves, s["values"], box)}"/></g>'
        for s in curves.series
    ]
    floor = f'<path class="floor" d="M0 {height - 1}H{width}"/>'
    return (
        f'<svg class="spark" viewBox="0 0 {width} {height}" preserveAspectRatio="none" '
        f'aria-hidden="true">{floor}{"".join(lines)}</svg>'
    )


def _panel(curves: Curves) -> str:
    """The curves with axes and names."""
    names, lines = [], []
    box = tuple(float(_PLOT[side]) for side in ("left", "top", "right", "bottom"))
    for one in curves.series:
        hue = f'style="--hue: {escape(one["color"])}"'
        dash = " ".join(f"{2.2 * part:g}" for part in one["dash"])
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        names.append(
            f'<li><svg class="swatch" viewBox="0 0 26 10" aria-hidden="true" {hue}>'
            f'<path d="M1 5H25"{dashed}/></svg>{escape(one["label"], quote=False)}</li>'
        )
        path = _path(curves, one["values"], box)  # type: ignore[arg-type]
        lines.append(f'<g class="curve" {hue}><path d="{path}"{dashed}/></g>')
    title = escape(curves.title, quote=False)
    return f"""\
            <figure class="panel">
              <figcaption><h4 class="panel-title">{title}</h4></figcaption>
              <ul>{"".join(names)}</ul>
              <div class="plot"><svg viewBox="0 0 {_PLOT["width"]} {_PLOT["height"]}" role="img" \
aria-label="{escape(_in_words(curves))}">{"".join(_axes(curves))}{"".join(lines)}</svg></div>
            </figure>"""


def _axes(curves: Curves) -> Iterable[str]:
    left, right, top, bottom = (_PLOT[side] for side in ("left", "right", "top", "bottom"))
    for share in (0.0, 0.5, 1.0):
        y = bottom - (bottom - top) * share
        value = curves.low + (curves.high - curves.low) * share
        yield f'<path class="grid" d="M{left} {y:g}H{right}"/>'
        yield f'<text x="{left - 4}" y="{y + 3:g}" text-anchor="end">{value:g}</text>'
    for share, anchor in ((0.0, "start"), (1.0, "end")):
        x = left + (right - left) * share
        told = "start" if not share else f"frame {curves.last}"
        yield f'<text x="{x:g}" y="{bottom + 12}" text-anchor="{anchor}">{told}</text>'


def _in_words(curves: Curves) -> str:
    """How the curves begin and end, for those who do not see them."""
    ends = []
    for one in curves.series:
        known = [v for v in one["values"] if v is not None]
        if known:
            ends.append(f"{one['label']} from {known[0]:.2g} to {known[-1]:.2g}")
    return f"{curves.title}: {'; '.join(ends)}"
