"""CELECT's compiled loops compared with reference formulas."""

import cv2
import numpy as np
import pytest

from raxel.features.celect import compiled
from raxel.features.celect.trace import N_ANGLE_BINS, normal_of, vote

SEEDS = range(4)


def window(seed, radius=24.0):
    """(pixels (n, 2) within a window, its centre)."""
    rng = np.random.default_rng(seed)
    centre = np.round(rng.uniform(60, 90, 2), seed)
    pixels = np.rint(centre + rng.uniform(-radius, radius, (300, 2)))
    return pixels[np.linalg.norm(pixels - centre, axis=1) <= radius], centre


@pytest.mark.parametrize("seed", SEEDS)
def test_hough_pixel_votes_once_per_angle(seed):
    pixels, centre = window(seed)
    angles = np.radians(np.arange(N_ANGLE_BINS))
    normals = np.stack([-np.sin(angles), np.cos(angles)]).astype(np.float32)
    R = (pixels - centre).astype(np.float32) @ normals
    raw = np.zeros((51, N_ANGLE_BINS), np.float32)
    for column in range(N_ANGLE_BINS):
        rows = np.floor(R[:, column] + 25.5).astype(int)
        raw[:, column] = np.bincount(rows, minlength=51)
    smooth = cv2.GaussianBlur(raw, (3, 3), 0, borderType=cv2.BORDER_REPLICATE)
    space = vote(pixels, centre, 24.0)
    assert space.dtype == np.float32
    assert space.sum() == pytest.approx(N_ANGLE_BINS * len(pixels))
    # A pixel whose distance lies between two bins may go into either.
    assert (space != smooth).mean() < 1e-3


def plain_strongest(space, limits, neighbourhood, share, columns):
    """Non-maximal suppression by trying every cell, the strongest first."""
    across, along = neighbourhood
    i, j = np.indices(space.shape)

    def near(row, column):
        return (abs(i - row) <= across) & (abs(j - column) <= along)

    is_top = np.zeros(space.shape, bool)
    for row, column in np.argwhere(space > 0):
        is_top[row, column] = space[row, column] >= space[near(row, column)].max()
    allowed = (j >= columns[0]) & (j < columns[1])
    found = []
    for values, limit in ((is_top * space, limits[1]), (space, limits[0])):
        rest = np.where(allowed, values, 0)
        for row, column, _ in found:
            rest[near(row, column)] = 0
        while len(found) < limit and rest.max() > 0:
            row, column = np.unravel_index(rest.argmax(), rest.shape)
            votes = rest[row, column]
            if len(found) >= limits[0] and votes < share * found[0][2]:
                break
            found.append((row, column, votes))
            rest[near(row, column)] = 0
    return found


@pytest.mark.parametrize("columns", [None, (70, 111)])
@pytest.mark.parametrize("seed", SEEDS)
def test_strongest_peaks_match_reference(seed, columns):
    space = vote(*window(seed), 24.0)
    if seed == 3:  # one line: the second peak is enforced
        space = np.zeros_like(space)
        space[20:23, 85:88] = [[1, 2, 1], [2, 7, 2], [1, 2, 1]]
    rules = (2, 5), (3, 10), 0.5, columns or (0, N_ANGLE_BINS)
    highest = cv2.dilate(space, np.ones((7, 21), np.uint8))
    expected = plain_strongest(space, *rules)
    assert expected
    found = compiled.strongest_peaks(space, highest, *rules)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("seed", SEEDS)
def test_farthest_ahead_matches_reference(seed):
    pixels, centre = window(seed)
    rng = np.random.default_rng(seed)
    theta, direction = rng.uniform(0, 180), rng.normal(0, 1, 2)
    away_from, normal, R = centre - 10 * direction, normal_of(theta), rng.uniform(-3, 3)
    near = abs((pixels - centre) @ normal - R) < 2.0
    ahead = near & ((pixels - centre) @ direction > 0)
    off = np.where(ahead, np.linalg.norm(pixels - away_from, axis=1), -1)
    rules = centre, normal, R, 2.0, away_from, direction
    assert compiled.farthest_ahead(pixels, *rules) == off.argmax()
    assert compiled.farthest_ahead(pixels[~ahead], *rules) == -1


@pytest.mark.parametrize("seed", SEEDS)
def test_harris_response_matches_formula(seed):
    u, v = np.random.default_rng(seed).normal(0, 9, (2, 30, 41)).astype(np.float32)
    tensor = compiled.structure_tensor(u, v)
    np.testing.assert_array_equal(tensor, np.stack((u * u, v * v, u * v), axis=2))
    M = tensor[..., [0, 2, 2, 1]].reshape(30, 41, 2, 2).astype(float)
    expected = np.linalg.det(M) - 0.04 * np.trace(M, axis1=2, axis2=3) ** 2
    found = compiled.response_of(tensor, np.float32(0.04))
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())
