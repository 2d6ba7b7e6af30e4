"""Rigs with impossible numbers are rejected, with file and field."""

import numpy as np
import pytest

from raxel.lab.optics import Optics, _levels
from raxel.lab.rig import load_rig
from tests import sample_rigs as rigs
from tests.raised import raises_line
from tests.raxel.lab.test_rig import MIRROR, changed, leaf

GRID = {
    "kind": "active_grid",
    "monitor_px": leaf([64, 48], "px"),
    "monitor_mm": leaf([64, 48], "mm"),
    "gamma": leaf(2.2, "1"),
    "gray_bits": leaf([2, 1], "1"),
}
SHARES = leaf([1, 0], "1")
SPOTS = {"spots": leaf(10_000, "1"), "spot_radius": leaf([1, 9], "px")}
AROUND = rigs.AROUND | {"axis": leaf([0, 0, 0], "1")}


def deep(levels):
    camera = MIRROR["viewer"]
    for _ in range(levels):
        camera = MIRROR | {"viewer": camera}
    return camera


ABSURD = {
    "blur": (
        {"optics": {"blur_sd": leaf([0, 60], "px")}},
        r"optics.blur_sd.value: found \[0, 60\], up to 60 px in .* at most 3, a",
    ),
    "blur far from its centre": (
        {"optics": {"blur_sd": leaf([0, 3], "px"), "centre": leaf([-90, 0], "px")}},
        "optics.blur_sd.value: found .*, up to 8",
    ),
    "optical centre": (
        {"optics": {"centre": leaf([1e9, 0], "px")}},
        "optics.centre.value: found .*; give a pixel in the image of 160 x 120 px",
    ),
    "exit pupil": (
        {"optics": {"exit_pupil": leaf(1e-300, "px")}},
        "optics.exit_pupil.value: found 1e-300; give 1 px or more",
    ),
    "steps of a falloff": (
        {"optics": {"falloff": {"radius": leaf([0, 1e-9], "px"), "light": SHARES}}},
        "optics.falloff: 2 radii",
    ),
    "periods": (
        {"target": GRID | {"phase_periods": leaf([1e6, 0], "1")}},
        "target.phase_periods.value: 1e.06 periods along x .* at most 32",
    ),
    "bits": (
        {"target": GRID | {"gray_bits": leaf([2, 15], "1")}},
        "target.gray_bits.value: 15 bits along y make 32768 cells .* at most 5",
    ),
    "gamma of a monitor": (
        {"target": GRID | {"gamma": leaf(1e-300, "1")}},
        "target.gamma.value: found 1e-300; give an exponent, 0.1 to 10",
    ),
    "corners": (
        {"target__columns": leaf(1000, "1"), "target__rows": leaf(1000, "1")},
        "target.columns.value: 1000 x 1000 corners have squares of less than 2 px",
    ),
    "pitch": (
        {"target__pitch": leaf(1e-300, "mm")},
        "target.pitch.value: found 1e-300; give a length above 0, from 1.0e-6",
    ),
    "well": (
        {"sensor__full_well": leaf(1e-300, "e")},
        "sensor.full_well.value: found 1e-300; give a number of electrons, 1 or more",
    ),
    "tone curve": (
        {
            "sensor__response": {
                "charge": leaf([0, 1e-300, 1], "1"),
                "value": leaf([0, 0.5, 1], "1"),
            }
        },
        "sensor.response: 3 charges",
    ),
    "spots": (
        {"blemishes": SPOTS},
        "blemishes.spots.value: found 10000 of up to 9 px, .* more than 10 times",
    ),
    "glare": (
        {"blemishes": {"glare_radius": leaf([1, 1e6], "px")}},
        r"blemishes.glare_radius.value: found 1e\+06 px in an image of 160 x 120 px",
    ),
    "glares": (
        {"blemishes": {"glare": leaf([0, 10_000], "1")}},
        r"blemishes.glare.value\[1\]: found 10000; give a whole number, 0 to 100",
    ),
    "views": (
        {"poses__count": leaf(10_000, "1")},
        "poses.count.value: found 10000; give a whole number, 1 to 1000",
    ),
    "margin": (
        {"poses__margin": leaf(60, "px")},
        "poses.margin.value: found 60 px, which leaves nothing of an image",
    ),
    "spacing": (
        {"poses__least_spacing": leaf(1e9, "px")},
        r"poses.least_spacing.value: found 1e\+09 px",
    ),
    "axis": ({"poses": AROUND}, r"poses.axis.value: found \[0, 0, 0\], which is no"),
    "degrees": (
        {"camera__max_angle": leaf([["x"], [2, 3]], "deg")},
        "camera.max_angle.value: not a number; give degrees",
    ),
    "pixels": (
        {"camera__width": leaf([160], "px")},
        r"camera.width: found \[160\]; give a whole number of pixels",
    ),
    "integer beyond all": (
        {"camera__focal_px": leaf(10**400, "px")},
        "camera.focal_px.value: found .1000",
    ),
    "coefficient beyond all": (
        {"camera__focal_px": leaf(1e101, "px")},
        r"camera.focal_px: values not finite, or beyond 1e\+100",
    ),
    "nested": ({"camera": deep(120)}, "nested too deeply"),
    "mirrors": (
        {"camera": deep(9)},
        "camera(.viewer){5}: camera nested in 4 others; use fewer levels",
    ),
}


@pytest.mark.parametrize("case", ABSURD)
def test_impossible_rig_values_are_rejected(tmp_path, case):
    changes, message = ABSURD[case]
    path = changed(tmp_path / "bad.yaml", **changes)
    with raises_line(f"^{path}: {message}"):
        load_rig(path)


def test_integers_may_be_written_as_floats(tmp_path):
    counts = {name: leaf(4.0, "1") for name in ("target__columns", "poses__count")}
    rig = load_rig(changed(tmp_path / "rig.yaml", **counts))
    assert type(rig.target.columns) is int
    assert type(rig.count) is int
    assert rig.target.points().shape == (12, 2)


def test_decreasing_blur_ends_at_zero():
    optics = Optics(blur_sd_px=(2.0, 0.0), centre_px=(0.0, 0.0))
    image = np.random.default_rng(0).random((40, 60)).astype(np.float32)
    far = optics.apply(image)[-3:, -3:]
    np.testing.assert_allclose(far, image[-3:, -3:], atol=1e-6)


def test_strong_blur_uses_few_levels():
    levels = _levels(0.0, 100.0**2)
    assert len(levels) < 60
    assert (levels[0], levels[-1]) == (0, pytest.approx(100**2))
    steps = np.diff(np.sqrt(levels))
    assert (steps > 0).all()
    assert (steps <= np.maximum(0.1, 0.15 * np.sqrt(levels[:-1])) * 1.001).all()
