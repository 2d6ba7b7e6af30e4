"""Tensor-product B-splines: against scipy, derivatives, turned axes, the box."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from raxel.errors import InputError
from raxel.geometry.spline_grids import SplineGrid, basis, open_knots, spline_grid

ANGLE = 0.3


def points_in(grid, count, seed=0, margin=0.0):
    rng = np.random.default_rng(seed)
    ends = np.array([[b[0], b[-1]] for b in grid.breaks]).T
    gap = margin * (ends[1] - ends[0])
    return grid.unturned(rng.uniform(ends[0] + gap, ends[1] - gap, (count, 2)))


@pytest.mark.parametrize(("count", "degree"), [(7, 2), (3, 2), (2, 1), (9, 3), (8, 5)])
def test_basis_equals_scipy(count, degree):
    knots = open_knots(-0.2, 0.5, count, degree)
    x = np.append(np.linspace(-0.2, 0.5, 50), [-0.2, 0.5])
    found = basis(knots, degree, x, min(degree, 2))
    for i in range(count):
        spline = BSpline(knots, np.eye(count)[i], degree)
        for order, values in enumerate(found):
            expected = spline.derivative(order)(x) if order else spline(x)
            np.testing.assert_allclose(values[:, i], expected, atol=1e-9)
    np.testing.assert_allclose(found[0].sum(axis=1), 1, atol=1e-14)


def test_coefficients_are_stacked_by_columns():
    grid = spline_grid([[0, 0], [1, 2]], (7, 3), angle=ANGLE)
    assert grid.shape == (7, 3)
    C = np.random.default_rng(1).normal(size=grid.shape)
    points = points_in(grid, 20)
    u, v = grid.turned(points).T
    f, g = basis(grid.knots_u, 2, u)[0], basis(grid.knots_v, 2, v)[0]
    expected = np.einsum("ni,ij,nj->n", f, C, g)
    np.testing.assert_allclose(grid.rows(points)[0] @ C.ravel("F"), expected)


def test_spline_grid_derivatives_equal_differences():
    grid = spline_grid([[0, 0], [0.3, 0.2]], (6, 5), (2, 3), ANGLE)
    points, step = points_in(grid, 40, margin=0.01), 1e-5
    _, *first = grid.rows(points)
    xx, xy, yy = grid.second_rows(points)
    second = [[xx, xy], [xy, yy]]
    for k in range(2):
        after, before = (points + sign * step * np.eye(2)[k] for sign in (1, -1))
        same = np.all(grid.intervals(after) == grid.intervals(before), axis=1)
        ends = zip(grid.rows(after), grid.rows(before), strict=True)
        slopes = [(up - down)[same] / (2 * step) for up, down in ends]
        np.testing.assert_allclose(first[k][same], slopes[0], atol=1e-6)
        for i in range(2):
            np.testing.assert_allclose(second[k][i][same], slopes[i + 1], atol=1e-4)


def test_spline_grid_is_nan_outside_box():
    grid = spline_grid([[0, 0], [1, 1]], (4, 3))
    rows = grid.rows(np.array([[0.5, 0.5], [1.0, 1.0], [1.01, 0.5], [np.nan, 0]]))
    for part in rows:
        np.testing.assert_array_equal(np.isnan(part).any(axis=1), [0, 0, 1, 1])
    found = grid.intervals([[0.1, 0.5], [1, 1], [0.9, -0.1], [np.nan, 0]])
    np.testing.assert_array_equal(found, [[0, 0], [1, 0], [-1, -1], [-1, -1]])
    np.testing.assert_array_equal(grid.inside(grid.corners), True)


def test_rotated_grid_spans_all_points():
    points = np.random.default_rng(2).uniform(-1, 1, (100, 2))
    grid = spline_grid(points, (7, 3), angle=ANGLE)
    assert grid.inside(points).all()
    assert grid.inside(grid.corners).all()
    again = SplineGrid(grid.knots_u, grid.knots_v, grid.degree, grid.angle)
    np.testing.assert_array_equal(again.rows(points)[1], grid.rows(points)[1])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: spline_grid([[0, 0], [1, 1]], (2, 3)), "2 basis functions"),
        (lambda: spline_grid([[0, 0], [1, 0]]), r"\[0, 0\]"),
        (lambda: spline_grid([[np.nan, 0]]), "spline: "),
        (lambda: SplineGrid([0, 0, 1, 1], [0, 0, 0, 1, 1, 1]), "'knots_u'"),
        (lambda: SplineGrid([0, 0, 0, 1, 1, 2], [0] * 3 + [1] * 3), "'knots_u'"),
        (lambda: SplineGrid([0] * 3 + [1] * 3, [0] * 3 + [1] * 3, (2, 0)), "'degree'"),
        (lambda: SplineGrid([0] * 3 + [1] * 3, [0] * 3 + [1] * 3, angle=np.nan),
         "'angle'"),
    ],
)  # fmt: skip
def test_impossible_splines_are_rejected(make, words):
    with pytest.raises(InputError, match=words):
        make()
