"""Look-up in a decoded grid: points at subpixel positions, and pixels of points."""

import numpy as np

from raxel.features.active_grid.positions import pixels_of, points_at
from raxel.geometry.homography import apply_homography

H = np.array([[0.5, 0.03, 12.0], [-0.02, 0.55, 7.0], [2e-4, -1e-4, 1.0]])


def decoded_plane(width=120, height=90, noise=0.0, seed=0):
    """A decoded plane (height, width, 2) that a pinhole sees, and its pixels."""
    v, u = np.indices((height, width))
    pixels = np.column_stack([u.ravel(), v.ravel()]).astype(float)
    points = apply_homography(H, pixels).reshape(height, width, 2)
    rng = np.random.default_rng(seed)
    return (points + rng.normal(0, noise, points.shape)).astype(np.float32)


PLACES = np.random.default_rng(1).uniform([2, 2], [117, 87], (200, 2))


def test_pixel_lookup_is_exact():
    found = pixels_of(decoded_plane(), apply_homography(H, PLACES))
    np.testing.assert_allclose(found, PLACES, atol=2e-4)
    back = points_at(decoded_plane(), found)
    # Bilinear, where the true map has a little perspective.
    np.testing.assert_allclose(back, apply_homography(H, PLACES), atol=1e-3)


def test_lookup_propagates_location_noise():
    """Four pixels are interpolated: the error is about that of one of them."""
    found = pixels_of(decoded_plane(noise=0.02), apply_homography(H, PLACES))
    assert 0.4 * 0.02 / 0.5 < (found - PLACES).std() < 1.2 * 0.02 / 0.5


def test_lookup_bridges_holes():
    location = decoded_plane()
    location[np.random.default_rng(2).random(location.shape[:2]) < 0.2] = np.nan
    found = pixels_of(location, apply_homography(H, PLACES))
    known = np.isfinite(found).all(axis=1)
    assert known.mean() > 0.9
    np.testing.assert_allclose(found[known], PLACES[known], atol=1e-3)
    # Bilinear between the four around, and one of these may be a hole.
    assert 0.2 < np.isfinite(points_at(location, PLACES)[:, 0]).mean() < 0.7


def test_invisible_points_are_nan():
    location = decoded_plane()
    outside = apply_homography(H, np.array([[-20.0, 40.0], [150.0, 40.0], [60, 130]]))
    assert np.isnan(pixels_of(location, outside)).all()
    outside = np.array([[-0.2, 5.0], [119.5, 5.0], [5.0, 89.1], [np.nan, 3.0]])
    assert np.isnan(points_at(location, outside)).all()
    location[:] = np.nan
    assert np.isnan(pixels_of(location, apply_homography(H, PLACES))).all()


def test_lookup_uses_one_facet():
    """A facet further right that sees other points does not disturb the search."""
    left, right = decoded_plane(), decoded_plane() + np.float32(500)
    both = np.concatenate([left, right], axis=1)
    found = pixels_of(both, apply_homography(H, PLACES) + [[500, 500]])
    np.testing.assert_allclose(found, PLACES + [120, 0], atol=1e-3)


def test_nonfinite_points_are_nan():
    points = apply_homography(H, PLACES[:3])
    points[1, 0] = np.nan
    found = pixels_of(decoded_plane(), points)
    assert np.isnan(found[1]).all()
    np.testing.assert_allclose(found[[0, 2]], PLACES[[0, 2]], atol=1e-3)
    assert pixels_of(decoded_plane(), np.empty((0, 2))).shape == (0, 2)


def test_point_outside_image_is_nan():
    """One and a half pixels beyond its border, all four see it from one side."""
    outside = np.array([[-1.5, 40.0], [60.0, -1.5], [120.5, 40.0], [60.0, 90.5]])
    assert np.isnan(pixels_of(decoded_plane(), apply_homography(H, outside))).all()
