"""Belief plots: files appear, are not blank, are the same every time, and hold to their scales."""

import subprocess
import sys
import xml.etree.ElementTree as ET
from itertools import combinations, pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from i2pdsl.render.grid.pictures import GridPictures
from i2pdsl.render.mind import (
    PALETTE,
    PANELS_MAX,
    Mark,
    Panel,
    Series,
    frame_ticks,
    mind_figure,
    panel_values,
    save_mind,
    spread,
    value_axis,
)

T = 15


def panel(title="The cheese's goal", kind="probability", labels=("pink", "green"), scale=1.0):
    rising = np.linspace(0.5, 1.0, T + 1) * scale
    values = [rising, scale - rising, np.full(T + 1, 0.1 * scale), rising**2]
    colors = list(PALETTE.values())
    series = tuple(Series(label, v, c) for label, v, c in zip(labels, values, colors, strict=False))
    return Panel(title, kind, series, kind)


FIVE = (
    panel(),
    panel("The robot's goal", labels=("pink", "green", "none")),
    panel("The robot's alignment", labels=("hindering", "indifferent", "helping")),
    panel("Rationality", labels=("cheese", "robot")),
    panel("Expected values", "value", ("cheese", "robot"), scale=345.0),
)


def test_png_has_a_picture_on_it(tmp_path):
    path = save_mind(tmp_path / "mind.png", FIVE, "help")
    assert path == tmp_path / "mind.png"
    with Image.open(path) as image:
        assert image.width > 4 * image.height  # a row, as in the paper
        pixels = np.asarray(image.convert("RGB"), dtype=float)
    assert pixels.std() > 10
    inked = (pixels < 200).any(axis=2)
    for fifth in np.array_split(inked, 5, axis=1):  # every panel drew something
        assert fifth.mean() > 0.005


def test_svg_parses_and_holds_no_date(tmp_path):
    path = save_mind(tmp_path / "mind.svg", FIVE, "help")
    root = ET.parse(path).getroot()
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    text = path.read_text(encoding="utf-8")
    assert "dc:date" not in text
    assert "<text" not in text  # drawn as outlines: looks alike everywhere


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_same_bytes_every_time(tmp_path, kind):
    marks = (Mark(5, "the table falls"),)
    first, second = (
        save_mind(tmp_path / f"{name}.{kind}", FIVE, "help", 6.5, marks).read_bytes()
        for name in ("first", "second")
    )
    assert first == second


def test_frame_changes_the_picture(tmp_path):
    still = save_mind(tmp_path / "a.png", FIVE, "help").read_bytes()
    assert save_mind(tmp_path / "b.png", FIVE, "help", frame=3).read_bytes() != still


@pytest.mark.parametrize("count", range(1, 9))
def test_any_number_of_panels(count):
    figure = mind_figure([*FIVE, *FIVE][:count], "help")
    assert len(figure.axes) == count
    boxes = [axes.get_position() for axes in figure.axes]
    for a, b in combinations(boxes, 2):
        assert not a.overlaps(b)
    for box in boxes:
        assert box.x0 > 0
        assert box.y0 > 0
        assert box.x1 < 1
        assert box.y1 < 1


@pytest.mark.parametrize(("columns", "rows"), [(1, 5), (3, 2), (5, 1), (9, 1)])
def test_panels_stack_in_columns(columns, rows):
    figure = mind_figure(FIVE, "help", columns=columns)
    assert len({round(axes.get_position().y0, 6) for axes in figure.axes}) == rows


def test_texts_stay_on_the_figure_and_off_the_data():
    figure = mind_figure(FIVE, "help", marks=(Mark(5, "the table falls"),))
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    whole = figure.bbox
    for axes in figure.axes:
        names = [text for text in axes.texts if text.get_text()]
        boxes = [name.get_window_extent() for name in names]
        for box in boxes:
            assert whole.x0 <= box.x0
            assert box.x1 <= whole.x1
            assert box.x0 >= axes.bbox.x1  # beside the plot, never over it
        for a, b in combinations(boxes, 2):
            assert min(a.y1, b.y1) - max(a.y0, b.y0) < 0.25 * a.height


def test_series_are_cut_to_the_axes():
    values = np.array([-0.5, 0.25, 1.0 + 1e-9, 7.0, np.nan, np.inf])
    wild = Panel("wild", "probability", (Series("a", values, "#000000"),))
    assert panel_values(wild, wild.series[0]).tolist()[:4] == [0.0, 0.25, 1.0, 1.0]
    axes = mind_figure([wild], "wild").axes[0]
    low, high = axes.get_ylim()
    for line in axes.lines:
        y = np.asarray(line.get_ydata(), dtype=float)
        y = y[np.isfinite(y)]
        assert ((low <= y) & (y <= high)).all()
    assert axes.get_xlim()[0] <= 0
    assert axes.get_xlim()[1] >= 5


def test_probabilities_share_one_scale_and_values_have_their_own():
    axes = mind_figure(FIVE, "help").axes
    assert [a.get_ylim() for a in axes[:4]] == [axes[0].get_ylim()] * 4
    assert list(axes[0].get_yticks()) == [0, 0.5, 1]
    assert axes[4].get_ylim()[1] >= 345


@pytest.mark.parametrize(
    "title",
    [
        "",
        "$x^2$ and $",
        "\\frac{1}{2} 100% _under_",
        "芝士 🧀 \u202e rtl \ud800 \x00\x07 -->",
        "w" * 400,
        "many words " * 60,
    ],
)
def test_any_text_is_drawn_without_a_warning(tmp_path, title):
    odd = Panel(title, title, (Series(title, np.linspace(0, 1, T + 1), "#000000"),))
    path = save_mind(tmp_path / "odd.svg", [odd], title, marks=(Mark(2, title),))
    ET.parse(path)
    assert save_mind(tmp_path / "odd.png", [odd], title).exists()


@pytest.mark.parametrize("values", [[0.5], [np.nan, np.nan], [3.0, 3.0, 3.0], [0.0] * 801])
def test_degenerate_series(tmp_path, values):
    for kind in ("probability", "value"):
        odd = Panel("odd", "y", (Series("a", np.array(values), "#000000"),), kind)
        assert save_mind(tmp_path / f"{kind}.png", [odd], "odd", frame=0).exists()


def test_mistakes_are_said(tmp_path):
    with pytest.raises(ValueError, match="1 to 8 panels, not 0"):
        mind_figure([], "none")
    with pytest.raises(ValueError, match="1 to 8 panels, not 9"):
        mind_figure([panel()] * 9, "many")
    short = Panel("short", "y", (Series("a", np.zeros(3), "#000000"),))
    with pytest.raises(ValueError, match="same frames"):
        mind_figure([panel(), short], "odd")
    with pytest.raises(ValueError, match=r"\[T \+ 1\]"):
        Series("a", np.zeros((2, 2)), "#000000")
    with pytest.raises(ValueError, match="#rrggbb"):
        Series("a", np.zeros(2), "red;}")
    with pytest.raises(ValueError, match="one and the same length"):
        Panel("a", "y", (Series("a", np.zeros(2), "#000000"), Series("b", np.zeros(3), "#000000")))
    with pytest.raises(ValueError, match=r"\.png or \.svg"):
        save_mind(tmp_path / "mind.pdf", FIVE, "help")
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "mind.png"
    path.write_text("old")

    def interrupt(self, target, **_):
        Path(target).write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", interrupt)
    with pytest.raises(KeyboardInterrupt):
        save_mind(path, FIVE, "help")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_matplotlib_is_imported_late_and_never_pyplot(tmp_path):
    program = f"""
import sys
import numpy as np
from i2pdsl.render.mind import Panel, Series, save_mind
assert "matplotlib" not in sys.modules
panel = Panel("a", "b", (Series("c", np.zeros(3), "#000000"),))
save_mind({str(tmp_path / "a.png")!r}, [panel], "d")
assert "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-W", "error", "-c", program], check=True)


@given(
    st.lists(st.floats(0, 1), min_size=1, max_size=8),
    st.floats(0.01, 0.3),
)
def test_labels_keep_their_distance_and_their_order(wanted, gap):
    places = spread(wanted, gap, 0.0, 1.0)
    fitting = min(gap, 1 / max(1, len(wanted) - 1))
    ordered = sorted(places)
    assert all(b - a >= fitting - 1e-9 for a, b in pairwise(ordered))
    assert ordered[0] >= -1e-9
    assert ordered[-1] <= 1 + 1e-9
    for (a, p), (b, q) in combinations(zip(wanted, places, strict=True), 2):
        assert a == b or (a < b) == (p < q)


@given(
    st.floats(-1e6, 1e6, allow_subnormal=False),
    st.floats(1e-6, 1e6, allow_subnormal=False),
)
def test_value_axes_enclose_the_values(low, span):
    values = np.array([low, low + span])
    drawn = Panel("a", "b", (Series("c", values, "#000000"),), "value")
    bottom, top, ticks = value_axis(drawn)
    slack = 1e-6 * max(1.0, abs(low), span)
    assert bottom <= values.min() + slack
    assert top >= values.max() - slack
    assert 2 <= len(ticks) <= 7
    assert all(a < b for a, b in pairwise(ticks))


@given(st.integers(0, 100_000))
def test_frame_ticks_are_few(last):
    ticks = frame_ticks(last)
    assert ticks[0] == 0
    assert ticks[-1] <= last
    assert 1 <= len(ticks) <= 8


# Machado, Oliveira, Fernandes 2009, severity 1: linear RGB as a dichromat sees it.
SIGHT = {
    "normal": np.eye(3),
    "protan": np.array([[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]]),
    "deutan": np.array([[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]),
    "tritan": np.array([[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]]),
}


def linear(color):
    rgb = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    to_xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    xyz = to_xyz @ np.clip(rgb, 0, 1) / [0.9505, 1, 1.089]
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("sight", SIGHT)
@pytest.mark.parametrize(
    "names",
    [("pink", "green", "none"), ("hindering", "indifferent", "helping"), ("cheese", "robot")],
)
def test_colours_are_tellable_apart(names, sight):
    seen = [lab(SIGHT[sight] @ linear(PALETTE[name])) for name in names]
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 20


@pytest.mark.parametrize("name", PALETTE)
def test_colours_stand_out_from_paper(name):
    luminance = linear(PALETTE[name]) @ [0.2126, 0.7152, 0.0722]
    assert 1.05 / (luminance + 0.05) >= 3


def test_names_that_begin_alike_are_told_apart():
    from i2pdsl.render.mind import LABEL_WIDTH, TEXT_SIZE, _fit_name, _width

    one = _fit_name("the_first_of_many_places_in_this_world_north")
    other = _fit_name("the_first_of_many_places_in_this_world_south")
    assert one != other
    assert one.startswith("the_first")
    assert one.endswith("north")
    assert _width(one, TEXT_SIZE) <= 1.03 * LABEL_WIDTH
    assert _fit_name("short") == "short"


def test_predicates_are_drawn_as_steps():
    values = np.array([0.0, 1.0, 1.0, 0.0])
    curves = [Series("a", values, "#0068b0", steps) for steps in (False, True)]
    drawn = [
        mind_figure([Panel("p", "value", (one,))], "").axes[0].lines[0].get_drawstyle()
        for one in curves
    ]
    assert drawn == ["default", "steps-mid"]


def test_of_more_curves_than_a_figure_has_the_first_are_drawn(tmp_path: Path) -> None:
    """Four characters have ten; what the story is about comes first."""
    ten = tuple(panel(f"the goal of {number}") for number in range(PANELS_MAX + 2))
    pictures = SimpleNamespace(panels=ten, marks=())
    path = GridPictures.save_mind(pictures, tmp_path / "mind.svg", "ten")
    assert path == save_mind(tmp_path / "eight.svg", ten[:PANELS_MAX], "ten").with_name("mind.svg")
    assert path.read_bytes() == (tmp_path / "eight.svg").read_bytes()
