"""What a mirror does between its features: a prior on how its bending changes.

Where no feature is, only a prior says how a spline goes on. This one takes the second
derivative along u and along v to change little from one knot interval to the next, as
a beam's does; along an axis that has a single interval it takes it to be small itself.
Both are told from a plane, which in inverse depth has none of them. A large weight
biases the deflection, so the prior's size is part of every result. That it helps on
beams says nothing of a mirror that is none.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from raxel.geometry.spline_grid import basis


class PriorRows(NamedTuple):
    """Equations rows @ c = values with standard deviations sd, one or (R,).

    mm: millimetres for a unit of the spline's quantity, already in the rows of a prior
    on bending.
    """

    rows: np.ndarray
    values: np.ndarray
    sd: float | np.ndarray
    mm: float = 1.0


def bending_prior(grid, quantity, plane, sd):
    """PriorRows for the coefficients of a spline mirror.

    plane: (n (3,), k), n . X = k mm, near the mirror, viewer's frame. sd: mm, of twice
    the bow that a change of the second derivative makes over one knot interval.
    """
    rows = bending_rows(grid)
    flat = _plane_coefficients(grid, quantity, plane)
    # One over depth to mm at the plane's middle.
    mm = 1.0 if quantity == "distance" else 1 / np.mean(flat) ** 2
    return PriorRows(mm * rows, mm * (rows @ flat), float(sd), mm)


@lru_cache(maxsize=8)
def bending_rows(grid):
    """Rows (R, K): change of second derivative between neighbouring knot intervals,
    times the square of the narrowest interval's width.

    Taken from middle to middle of the intervals along one axis, at the Greville places
    of the other. Along an axis of one interval, the second derivative itself. Kept for
    the same SplineGrid, which a stage asks twice.
    """
    f_changes, f = _along(grid.knots_u, grid.degree[0], grid.breaks[0])
    g_changes, g = _along(grid.knots_v, grid.degree[1], grid.breaks[1])
    return np.vstack([np.kron(g, f_changes), np.kron(g_changes, f)])


def plane_through(points):
    """(n (3,), k) of the plane n . X = k nearest to points (N, 3); n unit."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd(points - middle, full_matrices=False)[2][2]
    return normal, normal @ middle


def _along(knots, degree, breaks):
    bend = basis(knots, degree, (breaks[1:] + breaks[:-1]) / 2, 2)[2]
    changes = np.diff(bend, axis=0) if len(bend) > 1 else bend
    width = np.diff(breaks).min()
    return changes * width**2, basis(knots, degree, _greville(knots, degree))[0]


def _greville(knots, degree):
    """Where each basis function is most at home: means of its inner knots."""
    inner = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree)
    return inner.mean(axis=1)


def _plane_coefficients(grid, quantity, plane):
    """(K,) of the spline that meets a plane at the Greville places."""
    normal, offset = plane
    u, v = (
        _greville(knots, degree)
        for knots, degree in zip((grid.knots_u, grid.knots_v), grid.degree, strict=True)
    )
    v, u = (a.ravel() for a in np.meshgrid(v, u, indexing="ij"))
    p = grid.unturned(np.column_stack([u, v]))
    w = np.column_stack([p, np.ones(len(p))])
    inverse = w @ normal / offset
    values = np.linalg.norm(w, axis=1) / inverse if quantity == "distance" else inverse
    return np.linalg.solve(grid.rows(p)[0], values)
