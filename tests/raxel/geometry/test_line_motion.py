"""Plücker vectors of rays: the stated order, their transform, lines that meet."""

import numpy as np
import pytest

from raxel.geometry.planes import pluecker_matrix_of_rays, pluecker_vector
from raxel.geometry.poses import (
    cross_matrix,
    generalised_essential,
    pluecker_of_rays,
    pose,
    rotation_from_vector,
    side_products,
    transform,
)
from tests.ray_scenes import unit

T = pose(rotation_from_vector([0.3, -0.8, 0.5]), [20.0, -7.0, 11.0])


@pytest.fixture
def rays():
    rng = np.random.default_rng(0)
    return 50 * rng.standard_normal((40, 3)), unit(rng.standard_normal((40, 3)))


def test_pluecker_order_matches_thesis(rays):
    o, d = rays
    L = pluecker_of_rays(o, d)
    by_matrix = pluecker_vector(pluecker_matrix_of_rays(o, d)) / 2
    np.testing.assert_allclose(L, by_matrix, atol=1e-12)
    np.testing.assert_allclose(-L[:, 3:], np.cross(o, d), atol=1e-12)
    # Any point of the line will do.
    np.testing.assert_allclose(pluecker_of_rays(o + 13 * d, d), L, atol=1e-12)


def test_stacked_motions_equal_single_ones():
    turns = np.random.default_rng(1).standard_normal((2, 3, 3))
    stack = pose(rotation_from_vector(turns), 9 * turns[..., ::-1])
    found = generalised_essential(stack)
    assert found.shape == (2, 3, 6, 6)
    for place in np.ndindex(2, 3):
        one = generalised_essential(stack[place])
        np.testing.assert_allclose(found[place], one, atol=1e-13)


def test_meeting_lines_satisfy_5_30(rays):
    o, d = rays
    X = o + 300 * d
    p = np.roll(o, 1, axis=0)
    L_1, L_2 = (pluecker_of_rays(o, d), pluecker_of_rays(p, unit(transform(T, X) - p)))
    assert np.abs(side_products(L_1, L_2, T)).max() < 1e-11
    # The usual order, (d; o x d).
    sign = np.array([1, 1, 1, -1, -1, -1])
    usual = sign[:, None] * generalised_essential(T) * sign
    in_usual = np.einsum("ni,ij,nj->n", sign * L_2, usual, sign * L_1)
    np.testing.assert_allclose(in_usual, side_products(L_1, L_2, T), atol=1e-10)
    assert np.abs(np.einsum("ni,ij,nj->n", L_2, usual, L_1)).max() > 1
    np.testing.assert_array_equal(usual[:3, :3], cross_matrix(T[:3, 3]) @ T[:3, :3])


def test_side_product_is_distance_times_sine():
    L_1 = pluecker_of_rays([[0.0, 0, 0]], [[1.0, 0, 0]])
    L_2 = pluecker_of_rays([[4.0, 0, 3]], [[0, np.sin(0.2), np.cos(0.2)]])
    L_3 = pluecker_of_rays([[4.0, 9, 3]], [[np.cos(0.2), np.sin(0.2), 0]])
    assert side_products(L_1, L_2, np.eye(4))[0] == pytest.approx(0, abs=1) is not None
    assert abs(side_products(L_1, L_3, np.eye(4))[0]) == pytest.approx(3 * np.sin(0.2))
