"""Shape from directions: exact in its own space, rank, clamp, size (5.8-5.25)."""

import numpy as np
import pytest

from raxel.calibration import Clamp, clamp_of_camera, clamped, normalised
from raxel.calibration.mirror.refine import (
    orthogonality_rows,
    reflection_normals,
    scaled_to_points,
    shape_up_to_scale,
    shape_with_clamp,
)
from raxel.geometry.spline_grids import spline_grid
from tests.bent_mirror_scenes import (
    VIEWER,
    bent,
    edge_pixels,
    spline_like,
    visible_pixels,
)
from tests.raised import raises_code

QUANTITIES = pytest.mark.parametrize("quantity", ["distance", "inverse depth"])
DEGREES = pytest.mark.parametrize(
    ("shape", "degree"), [((7, 3), (2, 2)), ((6, 4), (3, 2))]
)


def pairs(camera, pixels):
    """p (N, 2) and unit normals (N, 3) from both directions of each pixel."""
    viewing, scene = VIEWER.rays(pixels).directions, camera.rays(pixels)
    p = normalised(VIEWER, pixels)[scene.valid]
    return p, reflection_normals(viewing[scene.valid], scene.directions[scene.valid])


@QUANTITIES
@DEGREES
def test_normals_recover_spline_mirror(quantity, shape, degree):
    camera = spline_like(bent(12), 12, shape, quantity, degree=degree, angle=0.05)
    true, pixels = camera.coefficients.ravel("F"), visible_pixels(12)[::3]
    p, normals = pairs(camera, pixels)
    found = shape_up_to_scale(p, normals, camera.grid, quantity)
    np.testing.assert_allclose(found, true / np.linalg.norm(true), rtol=1e-8)
    points = camera.rays(pixels).origins
    found = scaled_to_points(
        found, camera.grid, quantity, points[np.isfinite(points[:, 0])]
    )
    np.testing.assert_allclose(found, true, rtol=1e-8)


@QUANTITIES
@pytest.mark.parametrize("slope", [False, True])
def test_clamp_fixes_scale(quantity, slope):
    camera = spline_like(bent(12), 12, quantity=quantity)
    clamp = clamp_of_camera(camera, edge_pixels(), slope=slope)
    p, normals = pairs(camera, visible_pixels(12)[::3])
    found = shape_with_clamp(p, normals, camera.grid, quantity, clamp)
    np.testing.assert_allclose(found, camera.coefficients.ravel("F"), rtol=1e-8)
    # With wrong normals the shape is wrong, and the clamp still where it was.
    wrong = normals + np.random.default_rng(1).normal(0, 1e-2, normals.shape)
    found = shape_with_clamp(p, wrong, camera.grid, quantity, clamp)
    b, b_x, _ = camera.grid.rows(clamp.points)
    np.testing.assert_allclose(b @ found, clamp.values, rtol=1e-6)
    if slope:
        np.testing.assert_allclose(b_x @ found, clamp.slopes[:, 0], rtol=2e-3)


def test_printed_and_corrected_coefficient_order_differ():
    """E-5.04, E-5.05: stacked by rows in place of columns, nothing vanishes."""
    camera = spline_like(bent(12), 12, quantity="distance")
    p, normals = pairs(camera, visible_pixels(12)[::3])
    rows = orthogonality_rows(p, normals, camera.grid, "distance")
    size = np.abs(rows) @ np.abs(camera.coefficients.ravel("F"))
    right = np.abs(rows @ camera.coefficients.ravel("F")) / size
    literal = np.abs(rows @ camera.coefficients.ravel("C")) / size
    assert right.max() < 1e-12
    assert literal.max() > 1e-3


def test_spread_pairs_determine_shape_up_to_scale():
    """E-5.07: 2 n >= Kf Kg - 1; the size is all that stays open."""
    camera = spline_like(bent(12), 12, quantity="distance")
    box, rng = camera.grid.corners, np.random.default_rng(5)

    def rank(count):
        p = rng.uniform(box.min(axis=0), box.max(axis=0), (count, 2)) * 0.98
        pixels = VIEWER.project(np.column_stack([p, np.ones(count)])).pixels
        p, normals = pairs(camera, pixels)
        rows = orthogonality_rows(p, normals, camera.grid, "distance")
        return np.linalg.matrix_rank(rows, tol=1e-9 * np.linalg.norm(rows))

    assert max(rank(9) for _ in range(30)) == 18
    assert max(rank(10) for _ in range(200)) == 20
    assert rank(100) == 20


@pytest.mark.parametrize(("roll", "equations"), [(0.0, 3), (15.0, 5)])
def test_clamp_line_along_axis_gives_one_equation_per_function(roll, equations):
    grid = spline_grid([[-0.2, -0.15], [0.2, 0.15]])
    t, turn = np.linspace(-0.14, 0.14, 11), np.radians(roll)
    line = np.column_stack([-0.16 + t * np.sin(turn), t * np.cos(turn)])
    space = clamped(grid, Clamp(line, np.ones(11)), truncation=1e-2)
    assert 21 - space.directions.shape[1] == equations
    np.testing.assert_allclose(
        grid.rows(line)[0] @ space.particular, 1, atol=1e-9 if roll == 0 else 0.05
    )


def test_directions_without_knot_interval_are_rejected():
    camera = spline_like(bent(12), 12)
    p, normals = pairs(camera, visible_pixels(12)[::3])
    near = camera.grid.turned(p)[:, 0] < camera.grid.breaks[0][4]
    with raises_code("open-coefficients"):
        shape_up_to_scale(p[near], normals[near], camera.grid, "inverse depth")
    clamp = clamp_of_camera(camera, edge_pixels())
    with raises_code("open-coefficients"):
        shape_with_clamp(p[near], normals[near], camera.grid, "inverse depth", clamp)
    with raises_code("outside-knots"):
        clamp_of_camera(camera, edge_pixels() - [400, 0])
