"""Undoing the tone curve of sRGB."""

import numpy as np

from raxel.features.detector import undo_srgb

GREY = np.arange(256, dtype=np.uint8)[None]


def test_it_is_the_inverse_of_the_curve_and_keeps_order():
    light = undo_srgb(GREY)[0] / 255.0
    assert (np.diff(light) >= 0).all()
    again = np.where(
        light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055
    )
    # One of 256 levels of light is several of grey where the curve is steep.
    bright = GREY[0] > 60
    assert np.abs(255 * again - GREY[0])[bright].max() < 3


def test_black_and_white_stay_and_every_pixel_is_treated_alike():
    assert undo_srgb(GREY)[0, [0, 255]].tolist() == [0, 255]
    image = np.random.default_rng(0).integers(0, 256, (7, 9), dtype=np.uint8)
    np.testing.assert_array_equal(undo_srgb(image), undo_srgb(GREY)[0][image])
