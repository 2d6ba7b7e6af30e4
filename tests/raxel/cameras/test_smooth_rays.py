"""Rays from polynomials are those of the camera, for every kind of camera."""

import numpy as np
import pytest

from lab_cameras import EVERY, H, W
from raxel.cameras import pixel_grid
from raxel.cameras.core.smooth_rays import EXACT, NODE_POSITIONS, SmoothRays, _weights

# Far below what a pixel's value or a corner's place can show, px and mm.
NEAR_PX, NEAR_MM = 1e-5, 1e-6
INSIDE = np.random.default_rng(3).uniform(-0.5, [W - 0.5, H - 0.5], (4000, 2))


def differences(camera, found, pixels):
    """Greatest difference of the directions, px, and of the origins, mm."""
    exact = camera.rays(pixels)
    np.testing.assert_array_equal(found.valid, exact.valid)
    both = exact.valid
    step = np.ptp(exact.directions[both], axis=0).max() / max(W, H)
    turn = np.abs(found.directions - exact.directions)[both].max()
    away = np.abs(found.origins - exact.origins)[both].max()
    return turn / step if step else turn, away


@pytest.mark.parametrize("name", EVERY)
def test_smooth_rays_equal_camera_at_positions(name):
    camera = EVERY[name][0]
    turn, away = differences(camera, SmoothRays(camera).rays(INSIDE), INSIDE)
    assert turn < NEAR_PX
    assert away < NEAR_MM


@pytest.mark.parametrize("name", EVERY)
def test_smooth_rays_equal_camera_on_grid(name):
    camera = EVERY[name][0]
    u, v = np.arange(2 * W + 1) / 2 - 0.5, np.arange(H) + 0.25
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    turn, away = differences(camera, SmoothRays(camera).grid(u, v), pixels)
    assert turn < NEAR_PX
    assert away < NEAR_MM


def test_smooth_rays_do_not_depend_on_history():
    camera = EVERY["hyperboloid"][0]
    one, other = SmoothRays(camera), SmoothRays(camera)
    u, v = np.arange(40.0, 90), np.arange(30.0, 100)
    whole = one.grid(u, v)
    for row, place in enumerate(v):
        alone = other.grid(u, np.array([place]))
        for field, part in zip(whole, alone, strict=True):
            part_of_whole = field.reshape(len(v), len(u), -1)[row]
            np.testing.assert_array_equal(part_of_whole, part.reshape(len(u), -1))


def test_discontinuous_camera_has_exact_rays():
    camera = EVERY["planar mirrors"][0]
    rays = SmoothRays(camera)
    rays.grid(np.arange(W, dtype=float), np.arange(H, dtype=float))
    assert 0 < np.mean(rays._tiles == EXACT) < 1
    pixels = pixel_grid(W, H)
    turn, _ = differences(camera, rays.rays(pixels), pixels)
    assert turn < NEAR_PX


class BrokenGlass:
    """A pinhole behind two panes of which one lies 5 mm before the other: directions
    are smooth, places where rays leave are not."""

    width, height, central = W, H, False

    def rays(self, pixels):
        """Rays of pixels (N, 2)."""
        seen = EVERY["perspective"][0].rays(pixels)
        depth = np.where(pixels[:, :1] < 93.0, 40.0, 45.0)
        return seen._replace(origins=depth * seen.directions)


def test_smooth_rays_keep_stepped_origins():
    rays = SmoothRays(BrokenGlass()).rays(INSIDE)
    turn, away = differences(BrokenGlass(), rays, INSIDE)
    assert turn < NEAR_PX
    assert away < NEAR_MM


def test_positions_outside_image_use_camera():
    camera = EVERY["equidistance"][0]
    far = [[-9.0, 20.0], [W + 8.0, H + 30.0], [20.0, -1e200], [np.nan, 9.0]]
    far = np.array([*far, [9.0, np.inf]])
    found, exact = SmoothRays(camera).rays(far), camera.rays(far)
    np.testing.assert_array_equal(found.directions, exact.directions)
    np.testing.assert_array_equal(found.valid, exact.valid)


def test_weights_reproduce_polynomials_of_nodes():
    x = np.linspace(-1, 1, 41)
    weights = _weights(x)
    for degree in range(len(NODE_POSITIONS)):
        np.testing.assert_allclose(
            weights @ NODE_POSITIONS**degree, x**degree, atol=1e-13
        )
