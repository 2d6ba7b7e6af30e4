"""What every camera passes: exact both ways, and flags where there is nothing."""

import numpy as np

from raxel.cameras import load_camera

WILD = [0, 1, -50, 1e-300, 1e20, -1e155, 1e200, 1e308, np.inf, -np.inf, np.nan]


def assert_points_come_back(camera, pixels, depth):
    """Points at depths (N, 1) along the rays of pixels (N, 2) have those pixels.

    Returns the rays; without one, there is no pixel either.
    """
    rays = camera.rays(pixels)
    back = camera.project(rays.origins + depth * rays.directions)
    np.testing.assert_array_equal(back.valid, rays.valid)
    assert np.abs(back.pixels - pixels)[rays.valid].max() < 1e-9
    return rays


def assert_same_from_file(camera, pixels, folder):
    """A saved camera is read with the same rays, to the bit; returns what is read."""
    camera.save(folder / "camera.npz")
    again = load_camera(folder / "camera.npz")
    assert (type(again), again.parameters) == (type(camera), camera.parameters)
    for ours, theirs in zip(again.rays(pixels), camera.rays(pixels), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    return again


def assert_extreme_values_are_flagged(camera):
    """Values are finite where they are valid, and elsewhere NaN, without a warning."""
    rng = np.random.default_rng(4)
    origins, directions, valid = camera.rays(rng.choice(WILD, (5000, 2)))
    seen = camera.project(rng.choice(WILD, (5000, 3)))
    for values, flags in ((origins, valid), (directions, valid), seen):
        np.testing.assert_array_equal(np.isfinite(values).all(axis=1), flags)
        np.testing.assert_array_equal(np.isnan(values).all(axis=1), ~flags)
