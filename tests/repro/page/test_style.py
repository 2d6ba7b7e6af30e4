"""The figure style: same bytes in every process, units on axes, colours for all."""

import os
import subprocess
import sys

import numpy as np
import pytest

from repro.judge.statistics import Estimate
from repro.page import style
from repro.run.outcomes import Drawing

PROGRAM = """
import sys
from pathlib import Path
import numpy as np
from repro.judge.statistics import Estimate
from repro.page import style
from repro.run.outcomes import Drawing

drawn, axes = style.new_figure(1, 2)
x = np.linspace(0.0, 2.0, 6)
for index in range(3):
    middle = x * (index + 1)
    style.plot_interval(axes[0], x, middle, 0.9 * middle, 1.1 * middle,
                        look=style.series(index), label=f"series {index}",
                        bars=index == 2)
axes[0].set(xlabel="Noise (px)", ylabel="Residual $r$ (px)")
axes[0].legend()
axes[1].imshow(np.arange(12.0).reshape(3, 4))
axes[1].set_axis_off()
style.save_drawing(Drawing(drawn, {"noise_px": x}, "A caption"), Path(sys.argv[1]))
"""


def draw_in_new_process(stem, hash_seed):
    environment = os.environ | {"PYTHONHASHSEED": hash_seed, "PYTHONPATH": "lib"}
    subprocess.run([sys.executable, "-c", PROGRAM, stem], env=environment, check=True)


def test_saved_figures_are_reproducible(tmp_path):
    draw_in_new_process(tmp_path / "one" / "fig_9_9", "1")
    draw_in_new_process(tmp_path / "two" / "fig_9_9", "2")
    names = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert names == ["fig_9_9.csv", "fig_9_9.png", "fig_9_9.svg"]
    for name in names:
        one, two = (tmp_path / side / name for side in ("one", "two"))
        assert one.read_bytes() == two.read_bytes(), name


def test_svg_has_page_width_and_no_font(tmp_path):
    drawn, axes = style.new_figure()
    axes.plot([0, 1], [0, 1])
    axes.set(xlabel="u (px)", ylabel="v (px)")
    style.save_drawing(Drawing(drawn, {"u": [0, 1]}, ""), tmp_path / "fig_1_1")
    svg = (tmp_path / "fig_1_1.svg").read_text("utf-8")
    width_pt = float(svg.split('width="', 1)[1].split("pt", 1)[0])
    # A margin of 0.1 inch is kept, and an empty one trimmed.
    assert width_pt == pytest.approx(72 * style.WIDTH_IN, abs=15)
    assert "<text" not in svg
    assert "<dc:date>" not in svg
    assert (tmp_path / "fig_1_1.csv").read_text("utf-8") == "u\n0\n1\n"


@pytest.mark.parametrize("label", ["", "Ratio (1)", "Noise px", "(px) noise"])
def test_axis_without_quantity_or_with_a_misplaced_unit_is_rejected(tmp_path, label):
    drawn, axes = style.new_figure()
    axes.plot([0, 1], [0, 1])
    axes.set(xlabel=label, ylabel="Residual (px)")
    with pytest.raises(style.StyleError, match="fig_1_2: x axis of axes 1"):
        style.save_drawing(Drawing(drawn, {"x": [0]}, ""), tmp_path / "fig_1_2")
    assert not list(tmp_path.iterdir())


def test_only_lines_detects_images():
    drawn, axes = style.new_figure(1, 2)
    axes[0].plot([0, 1], [0, 1])
    marks = axes[1].scatter([0, 1], [0, 1], c=[0.1, 0.2])
    drawn.colorbar(marks, ax=axes[1])
    assert style.only_lines(drawn)
    axes[1].imshow(np.zeros((2, 2)))
    assert not style.only_lines(drawn)
    whole, _ = style.new_figure()
    whole.figimage(np.zeros((2, 2)))
    assert not style.only_lines(whole)


def test_axes_without_unit_are_accepted():
    drawn, axes = style.new_figure(2, 2, sharex="col")
    for panel in axes.flat:
        panel.plot([0, 1], [1, 2])
        panel.set_ylabel("Error (deg)")
    axes[1, 0].set_xlabel("Field of view (deg)")
    axes[1, 1].set_xlabel("Ratio")
    style.check_axes(drawn, "shared")

    drawn, axes = style.new_figure(1, 3)
    axes[0].bar(["as printed", "well conditioned"], [1, 2])
    axes[0].set_ylabel("Error (mm)")
    axes[1].set_axis_off()
    axes[2].set(xticks=[], yticks=[])
    style.check_axes(drawn, "words, switched off, no ticks")


def test_colour_bar_requires_unit():
    drawn, axes = style.new_figure()
    drawn.colorbar(axes.imshow(np.eye(3)), ax=axes)
    axes.set(xlabel="u (px)", ylabel="v (px)")
    with pytest.raises(style.StyleError, match="y axis of axes 2"):
        style.check_axes(drawn, "bar")


def linear(colour):
    channels = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(
        channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4
    )


def lab(rgb):
    """CIE Lab of linear RGB (D65 white), the space where distance means difference."""
    xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    white = xyz.sum(axis=1)
    ratio = np.clip(xyz @ rgb, 0, None) / white
    f = np.where(ratio > 0.008856, np.cbrt(ratio), 7.787 * ratio + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


# Machado, Oliveira and Fernandes 2009, doi 10.1109/TVCG.2009.113, severity 1.0.
SIGHT = {
    "usual": np.eye(3),
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
}


@pytest.mark.parametrize("sight", SIGHT)
def test_first_colours_differ_for_colour_blind_readers(sight):
    seen = [lab(SIGHT[sight] @ linear(s["color"])) for s in style.SERIES[:4]]
    distances = [
        np.linalg.norm(a - b) for i, a in enumerate(seen) for b in seen[i + 1 :]
    ]
    # A distance of about 2 is just noticeable; 15 is plain at the width of a line.
    assert min(distances) > 15


def test_series_differ_without_colour():
    looks = {(s["marker"], str(s["linestyle"])) for s in style.SERIES}
    assert len(looks) == len(style.SERIES)
    assert len({s["marker"] for s in style.SERIES}) == len(style.SERIES)


def test_series_colours_contrast_with_white():
    for entry in style.SERIES:
        luminance = np.array([0.2126, 0.7152, 0.0722]) @ linear(entry["color"])
        # WCAG asks 3:1 for graphics; the two palest also have a marker with an edge.
        assert 1.05 / (luminance + 0.05) > 2.0


def test_estimates_are_drawn_as_stored():
    drawn, axes = style.new_figure()
    found = [Estimate(2.0, 1.0, 3.0), Estimate(4.0, 3.5, 6.0)]
    rows = style.plot_estimates(
        axes, [10, 20], found, look=style.series(1), label="one"
    )
    assert rows == [(10, 2.0, 1.0, 3.0), (20, 4.0, 3.5, 6.0)]
    np.testing.assert_array_equal(axes.lines[0].get_xydata(), [[10, 2], [20, 4]])
    style.legend_below(drawn, axes, ncols=1)
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == ["one"]
