"""Plücker lines (2.11, 2.12) and ray-plane intersection (4.15)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from raxel.geometry import (
    intersect_lines_plane,
    intersect_rays_plane,
    on_plane,
    plane_of_pose,
    pluecker_matrix,
    pluecker_matrix_of_rays,
    pluecker_vector,
    pose,
    rotation_from_vector,
    transform,
)

seeds = st.integers(0, 2**32 - 1)


def finite_points(rng, n):
    return np.hstack([rng.normal(0, 100, (n, 3)), np.ones((n, 1))])


@given(seeds)
def test_pluecker_matrix_is_skew_and_independent_of_points(seed):
    rng = np.random.default_rng(seed)
    A, B = finite_points(rng, 20), finite_points(rng, 20)
    M = pluecker_matrix(A, B)
    np.testing.assert_array_equal(M, -np.swapaxes(M, -1, -2))
    a, b, c, d = rng.normal(size=(4, 20, 1))
    other = pluecker_matrix(a * A + b * B, c * A + d * B)
    np.testing.assert_allclose(other, (a * d - b * c)[..., None] * M, atol=1e-9)


def test_order_2_12_is_direction_then_negated_moment():
    rng = np.random.default_rng(1)
    A, B = finite_points(rng, 20), finite_points(rng, 20)
    L = pluecker_vector(pluecker_matrix(A, B))
    np.testing.assert_allclose(L[:, :3], 2 * (B - A)[:, :3], rtol=1e-12)
    moment = np.cross(A[:, :3], (B - A)[:, :3])
    np.testing.assert_allclose(L[:, 3:], -2 * moment, rtol=1e-9, atol=1e-9)


def test_line_through_origin_has_no_moment():
    d = np.random.default_rng(2).normal(size=(10, 3))
    L = pluecker_vector(pluecker_matrix_of_rays(3.5 * d, d))
    np.testing.assert_allclose(L[:, 3:], 0, atol=1e-13)


@given(seeds)
def test_ray_vector_is_direction_and_negated_moment(seed):
    rng = np.random.default_rng(seed)
    origins, d = rng.normal(0, 50, (8, 3)), rng.normal(size=(8, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    M = pluecker_matrix_of_rays(origins, d)
    vectors = np.hstack([d, -np.cross(origins, d)])
    np.testing.assert_allclose(pluecker_vector(M), 2 * vectors, atol=1e-11)


def test_stacked_product_4_15_equals_direct_intersection():
    rng = np.random.default_rng(3)
    T = pose(rotation_from_vector([0.3, -0.4, 1.2]), [20.0, -30, 500])
    origins, d = rng.normal(0, 40, (500, 3)), rng.normal(size=(500, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    found = intersect_rays_plane(origins, d, T)
    assert 0.2 < found.valid.mean() < 0.8
    matrices = pluecker_matrix_of_rays(origins, d)
    X = intersect_lines_plane(matrices, plane_of_pose(T))
    literal = (-np.hstack(list(matrices)).T @ plane_of_pose(T)).reshape(-1, 4)
    np.testing.assert_allclose(literal, X, rtol=1e-12, atol=1e-9)
    X = X[found.valid] / X[found.valid, 3:]
    direct = on_plane(found.points[found.valid])
    np.testing.assert_allclose(X[:, :3], transform(T, direct), rtol=1e-9, atol=1e-7)
    along = origins + found.range[:, None] * d
    np.testing.assert_allclose(
        along[found.valid], transform(T, direct), rtol=1e-9, atol=1e-7
    )


def test_rays_behind_or_parallel_are_invalid():
    T = pose(np.eye(3), [0, 0, 10.0])
    d = np.array([[0, 0, 1.0], [0, 0, -1], [1, 0, 0], [1, 0, 1e-9]])
    points, distance, valid = intersect_rays_plane(np.zeros(3), d, T)
    assert valid.tolist() == [True, False, False, True]
    np.testing.assert_array_equal(points[0], [0, 0])
    assert np.isnan(points[1:3]).all()
    assert distance[1] == -10
    assert np.isnan(distance[2])
    assert distance[3] == pytest.approx(1e10)


def test_stacked_planes_equal_single_ones():
    rng = np.random.default_rng(4)
    T = pose(rotation_from_vector(rng.normal(size=(3, 3))), rng.normal(size=(3, 3)))
    d = rng.normal(size=(7, 3))
    stack = intersect_rays_plane([1.0, 2, 3], d, T)
    for k in range(3):
        one = intersect_rays_plane([1.0, 2, 3], d, T[k])
        np.testing.assert_allclose(stack.points[k], one.points, rtol=1e-12)
        np.testing.assert_array_equal(stack.valid[k], one.valid)


def test_on_plane_appends_zero_z():
    points = np.arange(12).reshape(2, 3, 2)
    lifted = on_plane(points)
    assert (lifted.shape, lifted.dtype) == ((2, 3, 3), points.dtype)
    np.testing.assert_array_equal(lifted[..., :2], points)
    assert not lifted[..., 2].any()
    np.testing.assert_array_equal(on_plane([0.5, 2.0]), [0.5, 2.0, 0.0])
