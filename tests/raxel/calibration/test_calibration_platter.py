"""Poses of grids that a camera sees in a plane mirror on a chessboard (5.26, 5.27)."""

import numpy as np
import pytest

from raxel.calibration.mirror.observations import other_tilt, sighting, target_pose
from raxel.calibration.mirror.platter import (
    FlatMirrorImage,
    _Problem,
    grid_motion,
    grid_poses_in_platter,
    platter_plane,
    reflected_pose,
    reflection,
)
from raxel.errors import CalibrationError, InputError
from raxel.geometry import on_plane, pose, rotate, transform, vector_from_rotation
from raxel.geometry.poses import cross_matrix
from tests.mirror_scenes import THICKNESS, VIEWER, lattice, platter_scene, posed, view
from tests.raised import raises_code

MIDDLE = np.array([120.0, 90.0])


def test_reflection_keeps_plane_and_mirrors_camera():
    T = posed([10, -37, 3], [-40, 20, 300])
    plane = platter_plane(T, 1.5)
    n, d = plane[:3], plane[3]
    on_surface = transform(T, np.array([[20, 30, 0.0], [-9, 4, 0]])) + 1.5 * n
    R = reflection(plane)
    np.testing.assert_allclose(transform(R, on_surface), on_surface, atol=1e-12)
    np.testing.assert_allclose(R @ R, np.eye(4), atol=1e-12)
    # The camera's image is twice as far as the surface, behind it.
    np.testing.assert_allclose(R[:3, 3], -2 * d * n, atol=1e-12)
    assert n @ R[:3, 3] + d == pytest.approx(-d)
    assert R[2, 3] > 0
    # A board seen from behind has the same plane.
    behind = T @ pose(np.diag([1.0, -1, -1]), np.zeros(3))
    np.testing.assert_allclose(platter_plane(behind, 1.5), plane, atol=1e-12)


def test_reflected_pose_is_proper_and_self_inverse():
    plane = platter_plane(posed([5, -40, 0], [0, 0, 320]), 0.8)
    T = posed([20, 10, -70], [30, 40, 600])
    found = reflected_pose(T, plane)
    assert np.linalg.det(found[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(reflected_pose(found, plane), T, atol=1e-10)
    flat = on_plane(lattice(3, 4, 20.0))
    image = transform(reflection(plane), transform(found, flat))
    np.testing.assert_allclose(image, transform(T, flat), atol=1e-10)


def turned_together(one, other):
    """Poses of two grids, and (12, 3): how both move as all turns about the camera."""
    T = np.stack(
        [posed([one, 10, -70], [30, 40, 600]), posed([5, 60, other], [90, 9, 500])]
    )
    towards = np.swapaxes(T[:, :3, :3], 1, 2)
    shift = -towards @ cross_matrix(T[:, :3, 3])
    return T, np.concatenate([towards, shift], axis=1).reshape(12, 3)


def test_common_rotation_is_no_grid_motion():
    """Errors that two poses share, as a platter's plane makes them, move both alike."""
    T, shared = turned_together(20, 25)
    little = 1e-14 * np.eye(12)
    found = grid_motion(T, 1e-4 * shared @ shared.T + little, 0, 1, MIDDLE)
    assert found.angle_sd < 1e-6
    assert found.distance_sd < 1e-4
    alone = np.zeros((12, 12))
    alone[:6, :6] = 1e-4 * (shared @ shared.T)[:6, :6]
    one = grid_motion(T, alone, 0, 1, MIDDLE)
    assert one.angle_sd == pytest.approx(1e-2 * np.sqrt(3))


@pytest.mark.parametrize("places", [1, 2])
def test_flat_mirror_poses_are_exact_without_noise(places):
    flat_images, grids = platter_scene(places=places)
    found = grid_poses_in_platter(VIEWER, flat_images, THICKNESS)
    np.testing.assert_allclose(found.T_camera_grid, grids, atol=1e-8)
    motion = found.motion(0, 1, MIDDLE)
    assert motion.distance == pytest.approx(100.0, abs=1e-8)
    assert motion.angle < 1e-10


def test_jacobian_equals_differences():
    flat_images, _ = platter_scene(np.random.default_rng(1), 0.2, places=2)
    problem = _Problem(
        [sighting(VIEWER, p.board, "") for p in flat_images],
        [sighting(VIEWER, p.grid, "") for p in flat_images],
        np.array([p.platter for p in flat_images]),
        np.array([p.position for p in flat_images]),
        THICKNESS,
    )
    state = problem.start()
    J, size = problem.jacobian(state), 6 * len(state)
    for k in range(size):
        step = 1e-6 * np.eye(size)[k]
        up, down = (problem.residuals(problem.moved(state, s)) for s in (step, -step))
        np.testing.assert_allclose(
            J[:, k], (up - down) / 2e-6, atol=2e-6 * abs(J[:, k]).max()
        )


def test_covariance_predicts_errors():
    squared, motions = [], []
    for seed in range(12):
        flat_images, grids = platter_scene(np.random.default_rng(seed), 0.2, places=2)
        found = grid_poses_in_platter(VIEWER, flat_images, THICKNESS)
        R = found.T_camera_grid[:, :3, :3]
        turn = vector_from_rotation(np.swapaxes(R, 1, 2) @ grids[:, :3, :3])
        shift = grids[:, :3, 3] - found.T_camera_grid[:, :3, 3]
        error = np.concatenate(
            [[turn[k], rotate(R[k].T, shift[k : k + 1])[0]] for k in range(2)]
        ).ravel()
        squared.append(error @ np.linalg.solve(found.covariance[:12, :12], error) / 12)
        motions.append(found.motion(0, 1, MIDDLE))
    assert 0.6 < np.mean(squared) < 1.6
    far = [((m.distance - 100) / m.distance_sd) ** 2 for m in motions]
    turned = [(m.angle / m.angle_sd) ** 2 for m in motions]
    assert 0.4 < np.mean(far) < 2.0
    assert 0.4 < np.mean(turned) < 2.0


def test_unknown_corner_noise_follows_from_scatter():
    flat_images, _ = platter_scene(np.random.default_rng(5), 0.2, places=2)
    reported = grid_poses_in_platter(VIEWER, flat_images, THICKNESS)
    bare = [
        p._replace(board=p.board._replace(sd=None), grid=p.grid._replace(sd=None))
        for p in flat_images
    ]
    found = grid_poses_in_platter(VIEWER, bare, THICKNESS)
    ratio = np.diag(found.covariance) / np.diag(reported.covariance)
    # 0.04 px^2, known to a few per cent by so many corners.
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-3)
    assert ratio[0] == pytest.approx(1, abs=0.1)


def test_small_board_tries_both_tilts():
    points = lattice(5, 4, 4.0)
    T = posed([0, 12, 30], [20, 10, 900])
    seen = sighting(
        VIEWER, view(VIEWER, T, points, 5, 4, np.random.default_rng(3), 0.02), ""
    )
    assert np.degrees(np.arccos(other_tilt(T, points)[:3, 2] @ T[:3, 2])) > 15
    assert np.degrees(np.arccos(min(target_pose(seen)[:3, 2] @ T[:3, 2], 1.0))) < 5


def test_flat_mirror_rejects_impossible_images():
    (first, second), _ = platter_scene()
    exchanged = FlatMirrorImage(first.grid, first.board)
    moved = second._replace(position=0)
    none = first.grid._replace(pixels=np.full_like(first.grid.pixels, np.nan))
    for rejected, arguments in (
        (raises_code("image-before-mirror"), (VIEWER, [exchanged], THICKNESS)),
        (
            pytest.raises(InputError, match="field 'position'"),
            (VIEWER, [second], THICKNESS),
        ),
        (
            pytest.raises(InputError, match="field 'thickness': 400"),
            (VIEWER, [first], 400),
        ),
        (raises_code("poses-misfit"), (VIEWER, [first, moved], THICKNESS)),
        (
            pytest.raises(CalibrationError, match="image 0: grid"),
            (VIEWER, [first._replace(grid=none)], THICKNESS),
        ),
    ):
        with rejected:
            grid_poses_in_platter(*arguments)


def few(seen, rng):
    """Six of a view's corners, from one end to the other, off by 0.2 px."""
    found = np.flatnonzero(np.isfinite(seen.pixels[:, 0]))
    some, pixels = found[np.linspace(0, len(found) - 1, 6).astype(int)], seen.pixels
    pixels = pixels[some] + 0.2 * rng.standard_normal((6, 2))
    return seen._replace(pixels=pixels, points=seen.points[some])


def test_flat_mirror_noise_of_few_corners_is_unbiased():
    """Of six corners of the board and six of the monitor, half of all numbers."""
    reported, rng, (result, *_) = [], np.random.default_rng(6), platter_scene()[0]
    for _ in range(12):
        parts = [few(part, rng) for part in result[:2]]
        known, found = (
            grid_poses_in_platter(
                VIEWER,
                [FlatMirrorImage(*(p._replace(sd=sd) for p in parts))],
                THICKNESS,
            )
            for sd in (np.full(6, 0.2), None)
        )
        reported.append(found.covariance[0, 0] / known.covariance[0, 0])
    # Of 12 draws of a chi square with twelve, the mean is known to 12 %.
    assert np.mean(reported) == pytest.approx(1, abs=0.35)


@pytest.mark.parametrize("turn", [0, 13, 29, 44, 71])
def test_equal_errors_give_zero_motion_uncertainty(turn):
    """Rounding may make a variance of nothing less than nothing: NaN is no answer."""
    T, shared = turned_together(turn, turn)
    found = grid_motion(T, 1e-4 * shared @ shared.T, 0, 1, MIDDLE)
    assert 0 <= found.angle_sd < 1e-6
    assert 0 <= found.distance_sd < 1e-4


def test_corner_sd_is_kept_with_missing_corners():
    shown = view(VIEWER, posed([10, -20, 5], [0, 0, 400]), lattice(4, 5, 20.0), 5, 4)
    pixels, sd = shown.pixels.copy(), np.linspace(0.05, 0.24, 20)
    pixels[[0, 7]] = np.nan
    seen = sighting(VIEWER, shown._replace(pixels=pixels, sd=sd), "")
    kept = np.delete(np.arange(20), [0, 7])
    np.testing.assert_array_equal(seen.sd, sd[kept])
    np.testing.assert_array_equal(seen.points, shown.points[kept])
