"""A mirror tracked through a video: accuracy, no drift, wrong matches."""

import numpy as np

from raxel.calibration import MirrorSettings, MirrorTracker
from raxel.calibration.mirror.clamp import FixedLine, clamp_of_camera
from raxel.geometry import on_plane, transform
from tests.bent_mirror_scenes import (
    GRID,
    bent,
    edge_pixels,
    force_pixel,
    grid_pose,
    heights_at,
    seen,
    spline_like,
)
from tests.raised import raises_code

T_GRID = grid_pose()
SCENE = transform(T_GRID, on_plane(GRID))
FLAT = spline_like(bent(0.0), 0.0)
SETTINGS = MirrorSettings(prior_sd=0.1)


def tracker():
    return MirrorTracker(FLAT, SCENE, clamp_of_camera(FLAT, edge_pixels()), SETTINGS)


def test_tracker_follows_motion_without_drift():
    rng, following = np.random.default_rng(0), tracker()
    for deflection in (1.0, 2.0, 3.0, 2.0, 1.0, 0.0):
        pixels = seen(bent(deflection), T_GRID, rng)
        found = following.follow(pixels)
        assert found.settled
        height = heights_at(following.camera_now(), force_pixel(deflection))[0]
        assert abs(height - deflection) < 0.03
        assert np.nanmean(found.residuals) < 0.06
    wrong = np.flatnonzero(found.used)[::7]
    pixels[wrong] += 150.0
    found = following.follow(pixels)
    assert not found.used[wrong].any()
    assert "wrong matches" in found.flags[-1]


def test_tracker_accepts_soft_clamp_line():
    clamp = clamp_of_camera(FLAT, edge_pixels())
    firm = 1e-7 * np.ones(len(clamp.points))
    line = FixedLine(*clamp, firm, 10 * firm, FLAT.grid.angle)
    following = MirrorTracker(FLAT, SCENE, line, SETTINGS)
    rng = np.random.default_rng(2)
    for deflection in (1.0, 2.0):
        assert following.follow(seen(bent(deflection), T_GRID, rng)).settled
        height = heights_at(following.camera_now(), force_pixel(deflection))[0]
        assert abs(height - deflection) < 0.03
    held = FLAT.grid.rows(clamp.points)[0] @ following.coefficients
    np.testing.assert_allclose(held, clamp.values, atol=1e-6)


def test_features_outside_knots_are_rejected():
    pixels = seen(bent(0.0), T_GRID)
    with raises_code("outside-knots"):
        tracker().follow(pixels + [2500, 0])
