"""Holes filled from neighbours, and shares of noise, on a few pixels."""

import numpy as np
import pytest

from raxel.features.active_grid.coding import DARK, DECODED, FILLED
from raxel.features.active_grid.errors import share_noise
from raxel.features.active_grid.phase_unwrapping import fill_holes

PITCH = np.float32([2.0, 0.5])  # of places from column to column, along x and y


def filled(jumps=(0, 0)):
    """(location, sigma, cells) of a hole amid 3 x 3 pixels, and whether it was filled.

    jumps: of the right column's places, along x and y.
    """
    location = np.tile(np.arange(3, dtype=np.float32), (2, 3, 1))
    location *= PITCH[:, None, None]
    location[:, :, 2] += np.reshape(jumps, (2, 1))
    sigma = np.full_like(location, 0.3)
    status = np.full((3, 3), DECODED, np.uint8)
    status[1, 1], location[:, 1, 1], sigma[:, 1, 1] = DARK, np.nan, np.nan
    # Above and below are others' holes: what is left lies to the sides.
    status[0], status[2] = DARK, DARK
    cells, reach = np.zeros((2, 3, 3), np.int16), np.float32([5, 5])
    fill_holes(location, sigma, cells, status, reach, np.float32([0.8, 0.2]))
    at = location[:, 1, 1], sigma[:, 1, 1], cells[:, 1, 1]
    return at, status[1, 1] == FILLED


def test_filled_hole_is_mean_of_neighbours():
    (place, sigma, cells), found = filled()
    assert found
    np.testing.assert_allclose(place, PITCH)
    np.testing.assert_allclose(sigma, 0.3)
    np.testing.assert_array_equal(cells, [2, 2])  # of 0.8 and 0.2


@pytest.mark.parametrize("jumps", [(12, 0), (0, 12), (-12, 0), (0, -12)])
def test_disagreeing_neighbours_do_not_fill_hole(jumps):
    assert not filled(jumps)[1]


def test_correlated_noise_does_not_scale_bias():
    """Each axis has a share of its own, and what is marked by a minus sign stays so."""
    noise, length, bias = 0.02, np.float32([3, 2]), np.float32([0.03, 0.01])
    shared = np.float32([2.5, 1.5])
    sigma = np.tile((length * np.hypot(noise, bias))[:, None, None], (1, 4, 6))
    sigma[:, 0, 0] *= -1
    squared = np.tile(np.square(bias)[:, None, None], (1, 1, 6))
    share_noise(sigma, squared, length, shared)
    due = length * np.hypot(shared * noise, bias)
    np.testing.assert_allclose(np.abs(sigma), np.tile(due[:, None, None], (1, 4, 6)))
    assert (sigma < 0).sum() == 2
