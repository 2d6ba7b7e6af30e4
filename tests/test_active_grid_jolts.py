"""Camera or monitor moves by parts of a pixel, once: sigma holds it, and it is told."""

import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.checks.doubts import examine
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
