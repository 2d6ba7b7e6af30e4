"""Isolated pixels outside the lit area are excluded; small facets are kept."""

import numpy as np
import pytest

from raxel.features.active_grid.coding import ALONE, BORDER, DECODED, UNREADABLE
from raxel.features.active_grid.decoding import Decoded
from raxel.features.active_grid.errors import Noise
from raxel.features.active_grid.view import without_isolated_pixels

MARGIN = 3


def decoded(mask, faint=()):
    """A Decoded whose sigma is tenfold where it is faint."""
    status = np.where(mask, DECODED, UNREADABLE).astype(np.uint8)
    places = np.where(mask[..., None], np.float32(1.0), np.nan).repeat(2, axis=2)
    sigma = places.copy()
    sigma[faint] *= 10
    cells = np.zeros(places.shape, np.int16)
    return Decoded(places, sigma, cells, status, "mm", Noise(1.0), 1.0, MARGIN)


def lit():
    mask = np.zeros((120, 160), bool)
    mask[20:100, :70] = True
    return mask


def test_isolated_pixels_and_border_are_excluded():
    noisy = lit()
    noisy[::6, 80::4] = True
    found, share = without_isolated_pixels(decoded(noisy, noisy & ~lit()))
    assert share == np.count_nonzero(noisy[:, 80:]) / np.count_nonzero(noisy)
    # At the border of the image the lit area goes on.
    inner = np.zeros_like(noisy)
    inner[20 + MARGIN : 100 - MARGIN, : 70 - MARGIN] = True
    assert np.array_equal(found.mask, inner)
    assert np.array_equal(np.isfinite(found.location[..., 0]), inner)
    assert np.array_equal(np.isfinite(found.sigma[..., 1]), inner)
    assert set(found.status[::6, 80::4].ravel()) == {ALONE}
    assert set(found.status[lit() & ~inner]) == {BORDER}


@pytest.mark.parametrize("axis", [0, 1])
def test_isolated_pixel_is_faint_along_any_axis(axis):
    noisy = lit()
    noisy[::6, 80::4] = True
    before = decoded(noisy)
    before.sigma[noisy & ~lit(), axis] *= 10
    found, share = without_isolated_pixels(before)
    assert share > 0
    assert not found.mask[:, 80:].any()


def test_facets_and_few_isolated_pixels_are_kept():
    mask = lit()
    mask[::30, 80::30] = True
    mask[50:57, 100:107] = True
    plenty = lit()
    plenty[::6, 80::4] = True  # amid clipped pixels, say
    for before in (decoded(mask, mask & ~lit()), decoded(plenty)):
        found, share = without_isolated_pixels(before)
        assert share == 0
        assert found is before
