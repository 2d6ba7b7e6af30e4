"""One colour and marker per method: the table, and the check on every figure."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from chapters.ch04_central_generic.s1_4_bundle_adjustment import report as adjustment
from chapters.ch04_central_generic.s2_pose.experiment import NAMES as ESTIMATORS
from chapters.shared.methods import LINEAR_NAMES
from chapters.shared.methods import NAMES as CALIBRATIONS
from repro.page import style
from repro.page.method_looks import (
    GROUPS,
    LOOKS,
    LookError,
    check_looks,
    look_of,
    named_in,
)
from repro.run.outcomes import Drawing


def test_methods_have_unique_colour_and_marker():
    pairs = [(colour, marker) for group in GROUPS for colour, marker, _ in group]
    assert len(set(pairs)) == len(pairs)


def test_names_belong_to_one_method():
    names = [name for group in GROUPS for of in group.values() for name in of]
    assert len(set(names)) == len(names)


def test_method_colours_contrast_with_white():
    for look in LOOKS.values():
        luminance = np.dot(np.array(to_rgb(look["color"])) ** 2.2, (0.21, 0.72, 0.07))
        assert 1.05 / (luminance + 0.05) > 2.2, look


@pytest.mark.parametrize(
    "names", [CALIBRATIONS, LINEAR_NAMES, ESTIMATORS, adjustment.TITLES]
)
def test_compared_methods_have_looks(names):
    assert [name for name in names.values() if name not in LOOKS] == []


def test_names_of_method_share_look():
    assert look_of("CGSP") == look_of("CGSP's linear stage")
    assert look_of("standard, as printed") == look_of("central generic, as printed")
    first, then = look_of("CGSP"), look_of("CGSP", hollow=True)
    assert (first["color"], first["marker"]) == (then["color"], then["marker"])
    assert then["markerfacecolor"] == "white"


def test_unknown_method_is_rejected():
    with pytest.raises(LookError, match=r"'CGPS': not in .*; add its look"):
        look_of("CGPS")


@pytest.mark.parametrize(
    ("label", "name"),
    [
        ("CGSP", "CGSP"),
        ("CGSP, 4 grids", "CGSP"),
        ("CGSP + RANSAC, angles refined", "CGSP + RANSAC, angles refined"),
        ("standard, as printed, adjusted", "standard, as printed"),
        ("CELECT, tone curve undone", "CELECT, tone curve undone"),
        ("CELECTed", None),
        ("noise of 0.5 px", None),
    ],
)
def test_label_matches_longest_method(label, name):
    assert named_in(label) == name


def drawn_with(look, label, bars=False):
    drawn, axes = style.new_figure()
    x = np.arange(3.0)
    style.plot_interval(axes, x, x, x - 1, x + 1, look=look, label=label, bars=bars)
    axes.set(xlabel="Noise (px)", ylabel="Error (mm)")
    return drawn


@pytest.mark.parametrize("bars", [False, True])
def test_method_with_other_look_is_rejected(tmp_path, bars):
    drawn = drawn_with(style.series(0), "CGSP, linear", bars)
    with pytest.raises(
        LookError, match="fig_9_9: 'CGSP, linear' is drawn with #0072b2"
    ):
        style.save_drawing(Drawing(drawn, {"x": [0]}, ""), tmp_path / "fig_9_9")
    assert not list(tmp_path.iterdir())


def test_method_with_other_marker_is_rejected():
    with pytest.raises(LookError, match="and 'o'"):
        check_looks(drawn_with(look_of("CGSP") | {"marker": "o"}, "CGSP"), "fig_9_9")


@pytest.mark.parametrize("bars", [False, True])
def test_method_with_own_look_is_accepted(bars):
    check_looks(drawn_with(look_of("CGSP", hollow=True), "CGSP, 4", bars), "fig_9_9")
    check_looks(drawn_with(style.series(0), "noise of 0.5 px", bars), "fig_9_9")
    check_looks(drawn_with(look_of("CGSP") | {"marker": ""}, "CGSP"), "fig_9_9")
