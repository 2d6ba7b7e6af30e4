"""Primary calibration of a mirror of unknown shape, and of a flat one (5.2.1)."""

import numpy as np
import pytest

from raxel.calibration import RayPoints, grid_poses_in_platter, rays_from_known_motion
from raxel.calibration.mirror.primary import _refined, calibrate_primary, mirror_points
from raxel.errors import InputError
from raxel.geometry import intersect_rays_plane
from tests.mirror_scenes import (
    THICKNESS,
    VIEWER,
    flexible_camera,
    lattice,
    lit_views,
    monitor_pose,
    platter_scene,
    posed,
    small,
    spline_camera,
    view,
)
from tests.raised import raises_code

GRIDS = np.stack([monitor_pose(0.0), monitor_pose(100.0)])
BOARD, CELLS = lattice(13, 11, 25.0), (13, 11)
BOARDS = np.stack([posed([2, 73, 3], [-290, -140, 400 - 30 * k]) for k in range(2)])
BOARDS[:, 0, 3] -= [0, 100]


def angles_deg(found, true, pixels):
    """Angles (N,) between the rays of two cameras, where both have one."""
    a, b = found.rays(pixels), true.rays(pixels)
    both = a.valid & b.valid
    size = np.linalg.norm(np.cross(a.directions, b.directions), axis=1)
    return np.degrees(np.arcsin(size))[both]


def test_mirror_points_are_on_mirror():
    true = flexible_camera(6.0)
    pixels = np.random.default_rng(1).uniform([400, 200], [2700, 2100], (300, 2))
    rays = true.rays(pixels)
    points = [
        intersect_rays_plane(rays.origins, rays.directions, T).points for T in GRIDS
    ]
    for order in ([0, 1], [1, 0]):
        known = rays_from_known_motion(np.array(points)[order], GRIDS[order])
        found = mirror_points(VIEWER.rays(pixels).directions, known)
        np.testing.assert_array_equal(found.valid, rays.valid)
        np.testing.assert_allclose(found.points, rays.origins, atol=1e-8)
        np.testing.assert_allclose(found.directions, rays.directions, atol=1e-10)
        assert np.nanmax(found.misses) < 1e-8


@pytest.mark.parametrize("quantity", ["distance", "inverse depth"])
def test_primary_recovers_spline_mirror(quantity):
    true = spline_camera(quantity, viewer=small())
    found = calibrate_primary(
        true.viewer,
        lit_views(true, GRIDS),
        GRIDS,
        quantity=quantity,
        span=true.grid.corners,
    )
    # Decoded points have single precision.
    np.testing.assert_allclose(found.camera.coefficients, true.coefficients, rtol=1e-6)
    np.testing.assert_allclose(found.linear.coefficients, true.coefficients, rtol=1e-5)
    assert found.residuals.max() < 1e-3
    assert found.mirror.misses.max() < 1e-3
    assert found.motions[0].distance == pytest.approx(100.0)


def test_primary_accepts_static_boards():
    true = spline_camera()
    views = [view(true, T, BOARD, *CELLS) for T in BOARDS]
    found = calibrate_primary(VIEWER, views, BOARDS, span=true.grid.corners)
    np.testing.assert_allclose(found.camera.coefficients, true.coefficients, rtol=1e-9)
    # Between corners the linear stage must interpolate.
    assert 1e-7 < np.abs(found.linear.coefficients / true.coefficients - 1).max() < 0.02


def test_primary_fits_bent_sheet_with_noise():
    """0.2 px on boards, 5 um on the monitor: rays as the clean bench gives them."""
    true = flexible_camera(viewer=small())
    rng = np.random.default_rng(5)
    flat_images, _ = platter_scene(rng, 0.2, places=3, pitch=3.0, grid_sd=0.07)
    poses = grid_poses_in_platter(VIEWER, flat_images, THICKNESS)
    found = calibrate_primary(true.viewer, lit_views(true, GRIDS, rng, 0.005), poses)
    assert np.mean(found.mirror.misses) < 0.05
    assert np.mean(angles_deg(found.camera, true, found.pixels)) < 0.03
    motion = found.motions[0]
    assert abs(motion.distance - 100) < 0.05
    assert np.degrees(motion.angle) < 0.02


def wrongly_decoded(view, share, where, rng):
    """A DenseView of which a share of all points is 20 mm off: each its own way, or
    all alike along one border of the mirror."""
    location = view.location.copy()
    rows, columns = np.nonzero(np.isfinite(location[..., 0]))
    angle = rng.uniform(0, 2 * np.pi, len(rows))
    order = rng.permutation(len(rows))
    if where == "border":
        angle[:], order = 0.4, np.argsort(-columns, kind="stable")
    chosen = order[: int(share * len(rows))]
    off = 20 * np.column_stack([np.cos(angle), np.sin(angle)])
    location[rows[chosen], columns[chosen]] += off[chosen]
    return view._replace(location=location)


@pytest.mark.parametrize(
    ("where", "share"), [("anywhere", 0.05), ("border", 0.05), ("anywhere", 0.2)]
)
@pytest.mark.parametrize("grids", [[0], [0, 1]])
def test_primary_rejects_and_counts_wrong_points(where, share, grids):
    true = flexible_camera(viewer=small())
    rng = np.random.default_rng(4)
    views = lit_views(true, GRIDS, rng, 0.005)
    right = calibrate_primary(true.viewer, views, GRIDS)
    assert right.flags == ()
    for k in grids:
        views[k] = wrongly_decoded(views[k], share, where, rng)
    found = calibrate_primary(true.viewer, views, GRIDS)
    was, now = (
        np.mean(angles_deg(one.camera, true, right.pixels)) for one in (right, found)
    )
    assert now < 1.2 * was < 0.03
    assert found.residuals.max() < 1
    (flag,) = found.flags
    out, of = (int(flag.split()[k]) for k in (0, 2))
    assert 0.6 * share < out / of * 2 / len(grids) < 1.2 * share


def test_primary_rejects_wrong_corner():
    true = spline_camera()
    views = [view(true, T, BOARD, *CELLS) for T in BOARDS]
    k = np.flatnonzero(np.isfinite(views[0].pixels[:, 0]))[20]
    views[0].pixels[k] += [150.0, 0.0]
    found = calibrate_primary(VIEWER, views, BOARDS, span=true.grid.corners)
    np.testing.assert_allclose(found.camera.coefficients, true.coefficients, rtol=1e-7)
    assert "rejected as outliers" in found.flags[0]


def test_primary_covariance_includes_pose_errors():
    true = spline_camera(viewer=small(24))
    rng, squared = np.random.default_rng(7), []
    for _ in range(6):
        flat_images, _ = platter_scene(rng, 0.2, places=2)
        poses = grid_poses_in_platter(VIEWER, flat_images, THICKNESS)
        found = calibrate_primary(
            true.viewer,
            lit_views(true, GRIDS, rng, 0.005),
            poses,
            span=true.grid.corners,
        )
        off = (found.camera.coefficients - true.coefficients).ravel("F")
        squared.append(off @ np.linalg.solve(found.covariance, off) / len(off))
    assert 0.6 < np.mean(squared) < 1.6


def test_primary_rejects_degenerate_input():
    true = spline_camera(viewer=small(24))
    views = lit_views(true, GRIDS)
    mirrored = views[1]._replace(mirrored=not views[1].mirrored)
    for rejected, arguments in (
        (
            pytest.raises(InputError, match="1 views"),
            (true.viewer, views[:1], GRIDS[:1]),
        ),
        (raises_code("rays-do-not-meet"), (true.viewer, views, GRIDS[::-1])),
        (raises_code("mixed-views"), (true.viewer, [views[0], mirrored], GRIDS)),
    ):
        with rejected:
            calibrate_primary(*arguments)
    narrow = [v._replace(location=np.where(
        np.arange(v.location.shape[1])[:, None] < 50, v.location, np.nan
    )) for v in views]  # fmt: skip
    with raises_code("no-feature-at-end"):
        calibrate_primary(true.viewer, narrow, GRIDS, span=true.grid.corners)


def test_primary_noise_of_few_points_is_unbiased():
    """Of 64 numbers, 21 are coefficients."""
    true, rng, squares = spline_camera(), np.random.default_rng(9), []
    u, v = (
        np.linspace(b[0], b[-1], 4 * k)
        for b, k in zip(true.grid.breaks, (2, 1), strict=True)
    )
    image = true.grid.unturned(np.stack(np.meshgrid(u, v), -1).reshape(-1, 2))
    exact = true.coefficients.ravel("F")
    S, scene = RayPoints(image, true.grid, "inverse depth").surface(exact)
    points = intersect_rays_plane(S, scene, GRIDS[0]).points
    unknown = np.full((6, 6), np.nan)
    for _ in range(25):
        noisy = points + 0.01 * rng.standard_normal(points.shape)
        sighted = [(image, noisy)]
        found = _refined(true.grid, "inverse depth", exact, sighted, GRIDS[:1], unknown)
        off = found.coefficients - exact
        squares.append(off @ np.linalg.solve(found.covariance, off) / len(off))
    # Over a variance that 43 numbers tell: 43 / 41, known to 7 %.
    assert np.mean(squares) == pytest.approx(43 / 41, abs=0.2)
