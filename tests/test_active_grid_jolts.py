"""Camera or monitor moves by parts of a pixel, once: sigma holds it, and it is told."""

import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.checks.doubts import examine
from raxel.features.active_grid.checks.jolts import (
    Jolt,
    changes_over,
    jolts,
    without_means_of,
)
from raxel.features.active_grid.checks.sample import sampled
from raxel.features.active_grid.coding import read_coding
from raxel.features.active_grid.noise import Noise
from tests.active_grids import drawn

USUAL = {"size": (280, 210), "noise": 2.0, "blur": 1.0, "share": 0.95}
MOVED_PX = 0.3


def moved(u, v, monitor):
    """As `drawn` has places, seen by a camera that turned."""
    u = u - MOVED_PX / USUAL["size"][0]
    depth = 1 + 0.2 * u - 0.12 * v
    x = monitor[0] * (0.5 + (u + 0.05 * v) / (USUAL["share"] * depth))
    y = monitor[1] * 0.5 + monitor[0] * (v - 0.04 * u) / (USUAL["share"] * depth)
    return x, y


@pytest.mark.parametrize("first", ["phase-y-0.png", "phase-x-3.png"])
def test_a_movement_for_good(first):
    before, after = (drawn(**USUAL, steps=6, place=p) for p in (None, moved))
    names = [pattern.image for pattern in before.patterns]
    k = names.index(first)
    images = np.concatenate([before.images[:k], after.images[k:]])
    found = decode(images, before.patterns, before.grid)
    told = examine(images, before.patterns, before.grid, found)
    sigma, inner = told.widened(found.sigma), np.s_[12:-12, 12:-12]
    for true in (before.true, after.true):
        off = np.abs(found.location - true)[inner] / sigma[inner]
        off = off[np.isfinite(off)]
        assert np.mean(off < 3) > 0.99
    (text,) = [doubt.text for doubt in told.doubts]
    assert text.startswith("the picture moved by about 0.")
    assert first in text


def test_what_a_program_fills_in_at_the_sides_tells_no_movement():
    """The pictures of y are moved; a grey rim of a pixel is what they do not see."""
    scene = USUAL | {"size": (200, 150), "share": 0.8}
    before, after = (drawn(**scene, place=place) for place in (None, moved))
    of_y = np.array([pattern.axis == "y" for pattern in before.patterns])
    images = np.where(of_y[:, None, None], after.images, before.images)
    filled = images.copy()
    filled[of_y, :, 0] = filled[of_y, :, -1] = 150
    filled[of_y, 0] = filled[of_y, -1] = 150
    codes = read_coding(before.patterns, before.grid.monitor_px)
    shifts = []
    for own in (images, filled):
        asked = own, before.patterns, codes, before.grid, Noise(4.0), ()
        (found,) = jolts(sampled(*asked), scene["blur"])
        shifts.append(found.shift)
    np.testing.assert_allclose(shifts[1], shifts[0], atol=0.01)


def test_places_change_over_a_movement_by_their_slopes():
    """Those along u and v add up, or take from each other; what is unseen has none."""
    v, u = np.indices((30, 40))
    location = np.stack([0.5 * u + 0.2 * v, 0.1 * u - 0.4 * v], axis=-1)
    location[5:9, 5:9] = np.nan
    found = changes_over(np.array([0.3, 0.6]), location)
    np.testing.assert_allclose(found, [0.15 + 0.12, 0.24 - 0.03])


def test_a_step_that_moved_alone_is_no_movement_between_axes():
    """Of six steps it moves their mean by a sixth, and by a third more at a rim."""
    none = np.full(2, 0.01)
    between = [Jolt(0, 1, np.array([px, 0.0]), none) for px in (0.1, 0.2)]
    amid = Jolt(2, 3, np.array([0.0, 0.05]), none, within=0)
    assert without_means_of([*between, amid], 0.5 / 6) == [between[1], amid]
