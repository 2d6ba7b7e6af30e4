"""Refinement by ray-point vectors: Jacobian, recovery, clamp, prior, covariance."""

import numpy as np
import pytest

from raxel.calibration.mirror.clamp import bending_prior, clamp_of_camera
from raxel.calibration.mirror.observations import RayPoints, normalised
from raxel.calibration.mirror.refine import camera_of_shape, ray_sd, refine_shape
from raxel.geometry import on_plane, spline_grid, transform
from tests.bent_mirror_scenes import (
    GRID,
    T_VIEWER_MIRROR,
    VIEWER,
    bent,
    edge_pixels,
    grid_pose,
    seen,
    spline_like,
    visible_pixels,
)
from tests.raised import raises_code

QUANTITIES = pytest.mark.parametrize("quantity", ["distance", "inverse depth"])
NOISE = 0.2 / 7600
PLANE = T_VIEWER_MIRROR[:3, 2], T_VIEWER_MIRROR[:3, 2] @ T_VIEWER_MIRROR[:3, 3]
T_GRID = grid_pose()


def scene(deflection=10.0, quantity="inverse depth", points=GRID, **more):
    """Camera, its clamp, coefficients before bending, p and points of what it shows."""
    camera = spline_like(bent(deflection), deflection, quantity=quantity, **more)
    clamp = clamp_of_camera(camera, edge_pixels())
    pixels = seen(camera, T_GRID, points=points)
    shown = np.isfinite(pixels[:, 0])
    placed = transform(T_GRID, on_plane(points))[shown]
    flat = spline_like(bent(0.0), deflection, quantity=quantity, **more)
    return camera, clamp, flat.coefficients.ravel("F"), normalised(
        VIEWER, pixels[shown]
    ), placed  # fmt: skip


def dense(camera):
    """p and points 260 mm along the rays of pixels all over the mirror."""
    pixels = visible_pixels(10.0)[::2]
    rays = camera.rays(pixels)
    kept = rays.valid
    far = rays.origins[kept] + 260 * rays.directions[kept]
    return normalised(VIEWER, pixels[kept]), far


@QUANTITIES
def test_jacobians_agree_with_differences(quantity):
    camera, _, _, p, points = scene(quantity=quantity, degree=(3, 2))
    c = camera.coefficients.ravel("F") * (1 + 1e-3)
    rays = RayPoints(p, camera.grid, quantity)
    size = np.abs(c)
    for found, value in (
        (rays.jacobian(c, points), lambda c: rays.residuals(c, points)),
        (rays.direction_jacobian(c), lambda c: rays.surface(c)[1]),
    ):
        for k in range(len(c)):
            step = 1e-5 * size[k] * np.eye(len(c))[k]
            slope = (value(c + step) - value(c - step)) / (2e-5 * size[k])
            assert np.abs(found[:, :, k] - slope).max() < 1e-6 * np.abs(found).max()


@QUANTITIES
def test_refinement_recovers_spline_mirror_exactly(quantity):
    camera, clamp, flat, _, _ = scene(quantity=quantity)
    p, points = dense(camera)
    found = refine_shape(p, points, camera.grid, quantity, flat, noise=NOISE,
                         clamp=clamp)  # fmt: skip
    true = camera.coefficients.ravel("F")
    assert found.converged
    np.testing.assert_allclose(found.coefficients, true, rtol=1e-7)
    assert np.abs(found.residuals).max() < 1e-6
    assert len(found.costs) < 15


@QUANTITIES
def test_prior_keeps_plane_and_extrapolates(quantity):
    camera, clamp, flat, p, points = scene(10.0, quantity)
    prior = bending_prior(camera.grid, quantity, PLANE, 0.5)
    gap = prior.rows @ flat - prior.values
    # A distance spline of this size follows a plane to some hundredths of a mm.
    assert np.abs(gap).max() < (0.1 if quantity == "distance" else 1e-9)
    near = camera.grid.turned(p)[:, 0] < camera.grid.breaks[0][4]
    settings = {"noise": NOISE, "clamp": clamp}
    with raises_code("open-coefficients"):
        refine_shape(p[near], points[near], camera.grid, quantity, flat, **settings)
    found = refine_shape(
        p[near], points[near], camera.grid, quantity, flat, **settings, prior=prior
    )
    assert 0.15 < found.prior_share < 0.9
    # Its own uncertainty says where there is nothing.
    outer, inner = camera.grid.corners[1] * 0.999, p[near][0]
    sd = ray_sd(np.stack([outer, inner]), camera.grid, quantity, found.coefficients,
                found.covariance)  # fmt: skip
    assert sd[0] > 10 * sd[1]


def test_prior_of_rotated_spline_uses_its_knots():
    rng = np.random.default_rng(8)
    grid = spline_grid(np.array([[0.1, -0.6], [0.8, 0.5]]), angle=0.7)
    normal, offset = np.array([0.5, -0.2, 0.8]) / np.sqrt(0.93), 400.0
    p = rng.uniform([-0.2, -0.8], [1.0, 0.8], (4000, 2))
    w = np.column_stack([p, np.ones(len(p))])[grid.inside(p)]
    distance = offset / (w @ normal) * np.linalg.norm(w, axis=1)
    flat = np.linalg.lstsq(grid.rows(w[:, :2])[0], distance)[0]
    prior = bending_prior(grid, "distance", (normal, offset), 0.5)
    assert rms(prior.rows @ flat - prior.values) < 0.1 * rms(prior.values)


def rms(values):
    return np.sqrt(np.mean(values**2))


def test_covariance_predicts_scatter():
    """Noise alone, on a mirror of the spline's own space: all within its deviations."""
    camera, clamp, flat, p, points = scene(5.0)
    prior = bending_prior(camera.grid, "inverse depth", PLANE, 1.0)
    true, rng = camera.coefficients.ravel("F"), np.random.default_rng(3)
    prior = prior._replace(values=prior.rows @ true)
    look = normalised(VIEWER, visible_pixels(5.0)[::7] * 0.9 + [150, 110])
    rays = RayPoints(look, camera.grid, "inverse depth")
    wanted, squares = rays.surface(true)[1], []
    for _ in range(20):
        noisy = p + NOISE * rng.standard_normal(p.shape)
        inside = camera.grid.inside(noisy)
        found = refine_shape(noisy[inside], points[inside], camera.grid,
                             "inverse depth", flat, noise=NOISE, clamp=clamp,
                             prior=prior)  # fmt: skip
        off = rays.surface(found.coefficients)[1] - wanted
        sd = ray_sd(look, camera.grid, "inverse depth", found.coefficients,
                    found.covariance)  # fmt: skip
        squares.append(np.mean(np.sum(off**2, axis=1) / (2 * sd**2)))
    assert 0.6 < np.mean(squares) < 1.4


def test_shape_behind_camera_is_calibration_error():
    """The spline's own error is about its coefficients, which are no user input."""
    grid = spline_grid(np.array([[-0.1, -0.1], [0.1, 0.1]]))
    shape = np.full(grid.size, 1 / 400)
    assert camera_of_shape(VIEWER, grid, shape, "inverse depth").viewer is VIEWER
    shape[-1] = -1 / 400
    with raises_code("behind-camera"):
        camera_of_shape(VIEWER, grid, shape, "inverse depth")


@QUANTITIES
def test_residuals_follow_image_points(quantity):
    camera, _, _, p, points = scene(quantity=quantity)
    c = 1.01 * camera.coefficients.ravel("F")
    inside = np.all(np.abs(p - p.mean(axis=0)) < 0.3 * np.ptp(p, axis=0), axis=1)
    p, points, step = p[inside], points[inside], 1e-5
    slopes = RayPoints(p, camera.grid, quantity).image_jacobian(c, points)
    off = [
        RayPoints(p + sign * step * np.array([0.6, -0.8]), camera.grid, quantity)
        for sign in (1, -1)
    ]
    moved = np.subtract(*(rays.residuals(c, points) for rays in off)) / (2 * step)
    due = slopes @ [0.6, -0.8]
    np.testing.assert_allclose(moved, due, atol=1e-5 * np.abs(due).max())
