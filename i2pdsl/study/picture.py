"""The picture of a study: a bar for each film, as in the paper's figure (section "Human subject
studies"): sorted, dashed lines at the means, and what people answered beside them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np

from i2pdsl.resources import atomic_path
from i2pdsl.study.analysis import Share
from i2pdsl.study.spec import Study

COLORS = ("#8a8c99", "#0068b0", "#c65102", "#00664a", "#b07300", "#d9468f")  # of methods
PEOPLE = "#1d1e24"
LETTERS = 16  # of a line above a plot
GAP = 0.16  # between the films of two methods, as a share of the width


def draw_shares(study: Study, shares: Sequence[Share], title: str, path: Path) -> None:
    """A plot for each condition, with a block of bars for each method; of pairs one plot, with a
    block for each pair. It makes its own figure."""
    from matplotlib.figure import Figure

    groups = {g.name: g.label for g in study.groups}
    blocks = {name: [s for s in shares if s.group == name] for name in groups}
    blocks = {name: own for name, own in blocks.items() if own}
    if not blocks:
        return
    colors = {m.name: COLORS[n % len(COLORS)] for n, m in enumerate(study.methods)}
    wide = 0.8 + 0.55 * len(study.methods)  # inches
    figure = Figure(figsize=(max(4.2, wide * len(blocks)), 3.6), layout="constrained")
    plots = figure.subplots(1, len(blocks), sharey=True, squeeze=False)[0]
    for axes, (name, own) in zip(plots, blocks.items(), strict=True):
        _draw_group(axes, own, colors)
        axes.set_title(fill(groups[name], LETTERS), fontsize=9 if study.pairs else 10)
    plots[0].set_ylabel("the first is chosen" if study.pairs else "answers that match")
    plots[0].set_yticks([0, 0.25, 0.5, 0.75, 1], ["0", "25 %", "50 %", "75 %", "100 %"])
    figure.suptitle(title, fontsize=11)
    figure.legend(handles=_legend(study, shares, colors), loc="outside lower center", ncols=3,
                  fontsize=8, frameon=False)  # fmt: skip
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=150)


def _draw_group(axes: Any, shares: Sequence[Share], colors: dict[str, str]) -> None:
    at = 0.0
    for share in shares:
        bars = np.sort(share.each)[::-1]
        width = 1 / len(bars)
        axes.bar(
            at + width * (np.arange(len(bars)) + 0.5), bars, width, color=colors[share.method],
            edgecolor="white", linewidth=0.4,
        )  # fmt: skip
        ends = [[share.share - share.low], [share.high - share.share]]
        axes.errorbar(at + 1.01, share.share, ends, color="0.1", linewidth=1.2, capsize=2.5)
        axes.plot([at, at + 1], [share.share] * 2, color="0.1", linestyle="--", linewidth=1.2)
        if share.people is not None:
            axes.plot(at + 0.5, share.people, marker="D", color=PEOPLE, markersize=7,
                      markeredgecolor="white")  # fmt: skip
        at += 1 + GAP
    axes.set(xlim=(-GAP, at), ylim=(0, 1.03), xticks=[])
    axes.spines[["top", "right"]].set_visible(False)


def _legend(study: Study, shares: Sequence[Share], colors: dict[str, str]) -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    used = [m for m in study.methods if any(s.method == m.name for s in shares)]
    found: list[Any] = [Patch(color=colors[m.name], label=m.label) for m in used]
    if len(study.methods) == 1:
        found = []
    found.append(Line2D([], [], color="0.1", linestyle="--", label="mean, with 95 % interval"))
    if any(share.people is not None for share in shares):
        found.append(Line2D([], [], marker="D", color=PEOPLE, linestyle="none", label="people"))
    return found
