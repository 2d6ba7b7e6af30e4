"""The detector's compiled loops compared with OpenCV and reference formulas."""

import cv2
import numpy as np
import pytest

from raxel.features.chessboard import compiled
from raxel.features.chessboard.links import Atlas
from raxel.features.chessboard.saddles import RING_RADII_PX, Level, ring_test

SEEDS = range(3)


def noise_image(seed, shape=(61, 83)):
    noise = np.random.default_rng(seed).normal(128, 60, shape).astype(np.float32)
    return cv2.GaussianBlur(noise, (0, 0), 1.5)


@pytest.mark.parametrize("seed", SEEDS)
def test_grey_at_matches_opencv(seed):
    rng = np.random.default_rng(seed)
    grey = noise_image(seed)
    u, v = rng.uniform(-5, 90, (2, 8, 60)).astype(np.float32)
    expected = cv2.remap(grey, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    found = [
        compiled.grey_at(grey, *at) for at in zip(u.ravel(), v.ravel(), strict=True)
    ]
    np.testing.assert_allclose(found, expected.ravel(), atol=2e-5)


@pytest.mark.parametrize("seed", SEEDS)
def test_strongest_saddles_match_opencv_hessian(seed):
    grey, least = noise_image(seed), np.float32(2.0)
    half = np.array([-0.5, 0, 0.5], np.float32)
    xx = cv2.Sobel(grey, cv2.CV_32F, 2, 0, ksize=1)
    yy = cv2.Sobel(grey, cv2.CV_32F, 0, 2, ksize=1)
    xy = cv2.sepFilter2D(grey, cv2.CV_32F, half, half)
    strength = xy * xy - xx * yy
    top = (strength > least) & (strength == cv2.dilate(strength, np.ones((3, 3))))
    top[:2] = top[-2:] = top[:, :2] = top[:, -2:] = False
    place, found = compiled.strongest_saddles(grey, least)
    assert len(place) > 20
    np.testing.assert_array_equal(place, np.flatnonzero(top))
    np.testing.assert_allclose(found, strength.ravel()[place], rtol=1e-4)


@pytest.mark.parametrize("turn", np.linspace(0.02, 3.1, 7))
def test_ring_test_finds_edge_directions(turn):
    v, u = np.indices((41, 41)) - 20.0
    along, across = (
        u * np.cos(turn) + v * np.sin(turn),
        v * np.cos(turn) - u * np.sin(turn),
    )
    soft = np.clip(along, -1, 1) * np.clip(across, -1, 1)
    level = Level((128 + 100 * soft).astype(np.float32), 1, 1.0)
    points, root = np.array([[20.0, 20.0], [8.0, 20.0]]), np.full(2, 200, np.float32)
    found, angles, signs, contrast = ring_test(level, points, root, RING_RADII_PX)
    assert found.tolist() == [True, False]
    expected = np.sort((turn + np.pi / 2 * np.arange(4)) % (2 * np.pi))
    off = (angles[0] - expected + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(off).max() < 0.05
    assert (signs[0] == -np.roll(signs[0], 1)).all()
    assert contrast[0] > 150


def edge_atlas(angle, corner, hidden=False):
    """A level of a straight edge through (30, 40) with one known corner (index 6)."""
    v, u = np.indices((160, 200)).astype(float)
    across = (v - 40) * np.cos(angle) - (u - 30) * np.sin(angle)
    along = (v - 40) * np.sin(angle) + (u - 30) * np.cos(angle)
    side = np.where(along < 30, 1, -1) if hidden else 1
    grey = (128 + 80 * np.clip(across / 2, -1, 1) * side).astype(np.float32)
    known = np.zeros(grey.shape, np.int32)
    cv2.circle(known, corner, 3, 7, -1)
    one = (np.array([x], np.float32) for x in (0, 0, 200, 160, 1))
    return Atlas(grey, known, *one)


def follow(atlas, angle, own=0, aside=0.0):
    d = np.array([[np.cos(angle), np.sin(angle)]], np.float32)
    start = np.array([[30, 40]], np.float32) + 3 * d + aside * d[:, ::-1]
    sign, usual = np.ones((2, 1), np.float32) * [[1], [60]]
    end, heading = compiled.followed(
        atlas,
        start.astype(np.float32),
        d,
        sign.astype(np.float32),
        usual.astype(np.float32),
        np.array([0]),
        np.array([own]),
    )
    return end[0], heading[0]


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.7, 1.1])
def test_follow_edge_reaches_corner(angle):
    corner = round(30 + 50 * np.cos(angle)), round(40 + 50 * np.sin(angle))
    atlas = edge_atlas(angle, corner)
    end, heading = follow(atlas, angle + 0.1, aside=0.5)
    assert end == 6
    assert abs(np.arctan2(heading[1], heading[0]) - angle) < 0.06
    assert follow(atlas, angle, own=6)[0] == -1
    assert follow(atlas, angle + np.pi / 2)[0] == -1


def test_follow_edge_ends_at_polarity_change():
    assert follow(edge_atlas(0.0, (80, 40)), 0.0)[0] == 6
    assert follow(edge_atlas(0.0, (80, 40), hidden=True), 0.0)[0] == -1
