"""The general method: rays of pixels from grids in known poses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.calibration import rays_from_known_motion
from raxel.errors import CalibrationError, InputError
from raxel.geometry import (
    intersect_rays_plane,
    pluecker_matrix,
    pose,
    rotation_from_vector,
    transform,
)
from tests.raised import raises_line


def bundle(seed, count=60, central=False):
    """Rays near the z axis, each with an anchor point of its own unless central."""
    rng = np.random.default_rng(seed)
    origins = np.zeros((count, 3)) if central else rng.uniform(-40, 40, (count, 3))
    directions = rng.normal(0, 0.2, (count, 3)) + [0, 0, 1]
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def grids(seed, count=2):
    """Tilted planes, each behind those before it wherever the bundle looks."""
    rng = np.random.default_rng(seed)
    tilts = rotation_from_vector(rng.uniform(-0.15, 0.15, (count, 3)))
    shifts = [[*rng.uniform(-20, 20, 2), 500.0 + 400 * k] for k in range(count)]
    return pose(tilts, np.array(shifts))


def seen_on(origins, directions, T_base_grid):
    return intersect_rays_plane(origins, directions, T_base_grid).points


def line_gap(rays, origins):
    """Distance of points from the found lines."""
    offset = origins - rays.origins
    along = np.sum(offset * rays.directions, axis=1, keepdims=True)
    return np.linalg.norm(offset - along * rays.directions, axis=1)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10**6), count=st.sampled_from([2, 3, 5]), central=st.booleans()
)
def test_known_motion_rays_are_exact(seed, count, central):
    origins, directions = bundle(seed, central=central)
    T = grids(seed + 1, count)
    rays = rays_from_known_motion(seen_on(origins, directions, T), T)
    assert rays.valid.all()
    assert np.abs(np.cross(rays.directions, directions)).max() < 1e-12
    assert np.sum(rays.directions * directions, axis=1).min() > 0
    assert line_gap(rays, origins).max() < 1e-9
    assert rays.rms.max() < 1e-10


def test_two_points_give_join():
    origins, directions = bundle(1)
    T = grids(2)
    points = seen_on(origins, directions, T)
    rays = rays_from_known_motion(points, T)
    flat = np.concatenate([points, np.zeros((*points.shape[:2], 1))], axis=2)
    a, b = transform(T, flat)
    np.testing.assert_array_equal(rays.origins, a)
    join = pluecker_matrix(np.c_[a, np.ones(len(a))], np.c_[b, np.ones(len(b))])
    join /= np.linalg.norm(b - a, axis=1)[:, None, None]
    np.testing.assert_allclose(rays.pluecker(), join, atol=1e-9)


def test_rays_start_on_first_seen_grid():
    origins, directions = bundle(4)
    T = grids(5, 4)
    points = seen_on(origins, directions, T)
    seen = np.ones(points.shape[:2], bool)
    seen[0, ::2] = False
    rays = rays_from_known_motion(points, T, seen)
    first = [transform(T[k], np.c_[points[k], np.zeros(len(origins))]) for k in (0, 1)]
    due = np.where(seen[0][:, None], *first)
    np.testing.assert_allclose(rays.origins, due, atol=1e-8)


def test_several_points_give_least_squares_line():
    origins, directions = bundle(7, count=4)
    T = grids(8, 4)
    rng = np.random.default_rng(9)
    points = seen_on(origins, directions, T) + rng.normal(0, 0.5, (4, 4, 2))
    rays = rays_from_known_motion(points, T)
    corners = transform(T, np.concatenate([points, np.zeros((4, 4, 1))], axis=2))

    def cost(origin, direction):
        q = corners - origin
        along = np.sum(q * direction, axis=2, keepdims=True)
        return np.sum((q - along * direction) ** 2, axis=(0, 2))

    best = cost(rays.origins, rays.directions)
    np.testing.assert_allclose(np.sqrt(best / 4), rays.rms, rtol=1e-9)
    for step in np.vstack([np.eye(3), -np.eye(3)]):
        turned = rays.directions + 1e-4 * step
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        assert np.all(cost(rays.origins + 0.01 * step, rays.directions) > best - 1e-9)
        assert np.all(cost(rays.origins, turned) > best - 1e-9)


def test_pixel_needs_two_seen_grids():
    origins, directions = bundle(10, count=5)
    T = grids(11, 3)
    points = seen_on(origins, directions, T)
    seen = np.ones((3, 5), bool)
    seen[0, 1] = seen[1, 2] = False
    seen[:2, 3] = False
    points[:, 4] = np.nan
    rays = rays_from_known_motion(points, T, seen)
    assert rays.valid.tolist() == [True, True, True, False, False]
    for values in (rays.origins, rays.directions, rays.rms):
        assert np.isfinite(values[:3]).all()
        assert np.isnan(values[3:]).all()
    assert line_gap(rays, origins)[:3].max() < 1e-9


def test_pixel_on_intersection_has_no_ray():
    T = pose(
        rotation_from_vector([[0.0, 0, 0], [0, 0.5, 0]]), np.array([[0, 0, 500.0]] * 2)
    )
    # The planes cross where x = 0.
    x = np.array([0.0, 30.0])
    points = np.stack([np.c_[x, [1.0, 2.0]], np.c_[x, [1.0, 2.0]]])
    assert rays_from_known_motion(points, T).valid.tolist() == [False, True]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p, T: (p[:1], T[:1], None), "'points'"),
        (lambda p, T: (p[..., :1], T, None), "'points'"),
        (lambda p, T: (p, T[:1], None), "'T_base_grid'"),
        (lambda p, T: (p, T, np.ones(3, bool)), "'seen'"),
        (lambda p, T: (p, T, np.ones(p.shape[:2])), "'seen'"),
        (lambda p, T: (p, 2 * T, None), "'T_base_grid': pose 0"),
        (lambda p, T: (p, T * [1, 1, -1, 1], None), "'T_base_grid': pose 0"),
        (lambda p, T: (p, np.full_like(T, np.nan), None), "'T_base_grid': pose 0"),
        (lambda p, T: (p, T[[0, 0]], None), "grids 0 and 1"),
        (lambda p, T: (np.full_like(p, np.nan), T, None), "known motion: "),
    ],
)
def test_known_motion_errors_have_one_line(change, words):
    origins, directions = bundle(14)
    T = grids(15)
    arguments = change(seen_on(origins, directions, T), T)
    with raises_line(words):
        rays_from_known_motion(*arguments)


def test_coplanar_grids_are_rejected():
    origins, directions = bundle(16)
    T = grids(17)
    turned = T[0] @ pose(rotation_from_vector([0, 0, 0.4]), [80.0, -30.0, 0.0])
    T = np.stack([T[0], turned])
    with pytest.raises(InputError, match="grids 0 and 1"):
        rays_from_known_motion(seen_on(origins, directions, T), T)


def test_no_overlap_is_calibration_error():
    origins, directions = bundle(18, count=4)
    T = grids(19)
    seen = np.array([[True, True, False, False], [False, False, True, True]])
    with pytest.raises(CalibrationError):
        rays_from_known_motion(seen_on(origins, directions, T), T, seen)


def test_rays_do_not_need_last_grid():
    """As few as the first two of five tell where a ray comes from and leads to."""
    origins, directions = bundle(8)
    T = grids(9, 5)
    points = seen_on(origins, directions, T)
    seen = np.ones(points.shape[:2], bool)
    last = np.random.default_rng(10).integers(1, 5, len(origins))
    seen[np.arange(5)[:, None] > last] = False
    rays = rays_from_known_motion(points, T, seen)
    assert rays.valid.all()
    np.testing.assert_allclose(rays.directions, directions, atol=1e-11)
    assert line_gap(rays, origins).max() < 1e-8
