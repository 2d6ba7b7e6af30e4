"""Rigid poses: target from source, rotations, fits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from raxel.errors import InputError
from raxel.geometry import (
    angle_between_rotations,
    fit_pose,
    inverse_pose,
    nearest_rotation,
    pose,
    rotate,
    rotation_from_vector,
    transform,
    vector_from_rotation,
)
from raxel.geometry.poses import cross_matrix

seeds = st.integers(0, 2**32 - 1)


def random_pose(rng, n=None):
    shape = (3,) if n is None else (n, 3)
    return pose(rotation_from_vector(rng.normal(size=shape)), rng.normal(0, 100, shape))


@given(seeds)
def test_poses_chain_and_invert(seed):
    rng = np.random.default_rng(seed)
    T_world_camera, T_camera_grid = random_pose(rng), random_pose(rng)
    points = rng.normal(0, 100, (10, 3))
    chained = transform(T_world_camera @ T_camera_grid, points)
    stepwise = transform(T_world_camera, transform(T_camera_grid, points))
    np.testing.assert_allclose(chained, stepwise, atol=1e-10)
    back = transform(inverse_pose(T_camera_grid), transform(T_camera_grid, points))
    np.testing.assert_allclose(back, points, atol=1e-11)


def test_rotate_ignores_translation():
    rng = np.random.default_rng(0)
    T = random_pose(rng)
    a, b = rng.normal(size=(2, 5, 3))
    np.testing.assert_allclose(
        rotate(T, b - a), transform(T, b) - transform(T, a), atol=1e-12
    )


def test_stack_of_poses_maps_one_or_many_point_sets():
    rng = np.random.default_rng(1)
    T, points = random_pose(rng, 4), rng.normal(size=(4, 6, 3))
    for k in range(4):
        np.testing.assert_allclose(transform(T, points)[k], transform(T[k], points[k]))
        np.testing.assert_allclose(
            transform(T, points[0])[k], transform(T[k], points[0])
        )


@pytest.mark.parametrize("angle", [0, 1e-200, 1e-9, 1e-4, 1.0, 3.1, np.pi - 1e-9])
def test_rotation_vector_roundtrip(angle):
    axis = np.array([2.0, -3, 6]) / 7
    R = rotation_from_vector(angle * axis)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(
        vector_from_rotation(R), angle * axis, rtol=1e-8, atol=1e-16
    )
    assert angle_between_rotations(np.eye(3), R) == pytest.approx(angle, abs=1e-15)


def test_rotation_is_right_handed():
    R = rotation_from_vector([0, 0, np.pi / 2])
    np.testing.assert_allclose(R @ [1, 0, 0], [0, 1, 0], atol=1e-15)


def test_cross_matrix_is_cross_product():
    a, b = np.random.default_rng(2).normal(size=(2, 5, 3))
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", cross_matrix(a), b), np.cross(a, b), atol=1e-15
    )


@given(seeds)
def test_nearest_rotation_is_a_minimum(seed):
    rng = np.random.default_rng(seed)
    M = rng.normal(size=(3, 3))
    for columns in (2, 3):
        A = M[:, :columns]
        R = nearest_rotation(A)
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) > 0
        gap = np.linalg.norm(R[:, :columns] - A)
        for w in rng.normal(0, 1e-2, (10, 3)):
            other = (R @ rotation_from_vector(w))[:, :columns]
            assert gap <= np.linalg.norm(other - A) + 1e-12


def test_nearest_rotation_ignores_column_scale():
    R = rotation_from_vector(np.random.default_rng(3).normal(size=(5, 3)))
    np.testing.assert_allclose(nearest_rotation(7 * R[..., :2]), R, atol=1e-14)
    with pytest.raises(InputError, match="rank below 2"):
        nearest_rotation(np.ones((3, 2)))


@given(seeds)
def test_fit_pose_is_exact_on_planar_points(seed):
    rng = np.random.default_rng(seed)
    T = random_pose(rng)
    source = rng.normal(0, 50, (6, 3)) * [1, 1, rng.integers(0, 2)]
    target = transform(T, source)
    np.testing.assert_allclose(fit_pose(source, target), T, atol=1e-9)
    target[0] += 1000
    weights = [0.0, 1, 1, 2, 2, 3]
    np.testing.assert_allclose(fit_pose(source, target, weights), T, atol=1e-9)


def test_fit_pose_rejects_degenerate_points():
    line = np.outer(np.arange(5.0), [1, 2, 3])
    with pytest.raises(InputError, match="rank below 2"):
        fit_pose(line, line)
    with pytest.raises(InputError, match="at least three"):
        fit_pose(line[:2], line[:2])
    with pytest.raises(InputError, match="must be finite"):
        fit_pose(line, line * np.nan)
