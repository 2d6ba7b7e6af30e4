"""Undoing the tone curve of sRGB."""

import numpy as np

from raxel.features.detector import undo_srgb

GREY = np.arange(256, dtype=np.uint8)[None]


def test_undo_srgb_inverts_curve_monotonically():
    light = undo_srgb(GREY)[0] / 255.0
    assert (np.diff(light) >= 0).all()
    again = np.where(
        light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055
    )
    # One of 256 levels of light is several of grey where the curve is steep.
    assert np.abs(255 * again - GREY[0])[GREY[0] > 60].max() < 3


def test_undo_srgb_keeps_black_and_white():
    assert undo_srgb(GREY)[0, [0, 255]].tolist() == [0, 255]
    image = np.random.default_rng(0).integers(0, 256, (7, 9), dtype=np.uint8)
    np.testing.assert_array_equal(undo_srgb(image), undo_srgb(GREY)[0][image])
