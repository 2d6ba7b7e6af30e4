"""Are a shape's residuals noise? The correlation of neighbours, beside noise's own.

Where a spline is too coarse for a mirror, neighbouring residuals point the same way. A
fit leaves noise correlated as well, and against itself: it takes up what neighbours
have in common. So the correlation is told beside the mean and the deviation that white
noise would have after the same fit, which are exact. What an error of the grid's pose
or of the clamp does to residuals says nothing of the spline: whatever moving grids or
changing any coefficient could do is taken out first.
Sources: Moran, Biometrika 37 (1950) 17-23; of residuals: Cliff and Ord, Geographical
Analysis 4 (1972) 267-284.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.spatial import Delaunay, QhullError

from raxel.errors import CalibrationError

# Standard deviations above what noise has, one-sided: one set of white residuals in 44.
BOUND = 2.0
# Neighbours are joined in a triangulation; along its rim are longer sides: of the
# median's length.
LONGEST = 1.5
# Of the largest singular value: what a fit cannot change.
RANK = 1e-9
FEWEST = 10  # degrees of freedom


class Whiteness(NamedTuple):
    """Neighbouring residuals of a fit.

    correlation: mean product of neighbours' residuals over the mean square; expected,
    sd: of it after this fit, if the noise is white; pairs: how many neighbours.
    """

    correlation: float
    expected: float
    sd: float
    pairs: int

    @property
    def excess(self):
        """By how many standard deviations neighbours agree better than noise's."""
        return (self.correlation - self.expected) / self.sd

    @property
    def white(self):
        """Whether nothing speaks against noise."""
        return bool(self.excess < BOUND)


class FittedPoints(NamedTuple):
    """What a shape was fitted to, and what its residuals may be blamed on else.

    rays: RayPoints of N places in the picture; coefficients: (K,); points: (N, 3) mm,
    viewer's frame; motion: (N, 3, m), how they move with the poses of their grids;
    grids: (N,) of which grid each is: only those of one grid are neighbours.
    """

    rays: object
    coefficients: np.ndarray
    points: np.ndarray
    motion: np.ndarray
    grids: np.ndarray

    @property
    def residuals(self):
        """Vectors (N, 3), mm."""
        return self.rays.residuals(self.coefficients, self.points)

    @property
    def variance(self):
        """Squared residuals for each degree of freedom, mm^2."""
        free = 2 * len(self.points) - len(self.coefficients)
        return float(np.sum(self.residuals**2) / free) if free > 0 else np.inf


def whiteness(fitted):
    """Whiteness of FittedPoints.

    Raises CalibrationError where hardly a degree of freedom is left to tell it by, and
    where a grid's places lie on a line.
    """
    rays, c = fitted.rays, fitted.coefficients
    across = _across(rays.surface(c)[1])
    changes = [rays.jacobian(c, fitted.points), rays.across(c) @ fitted.motion]
    fit = _orthonormal(across @ np.concatenate(changes, axis=2))
    count, _, columns = fit.shape
    freedom = 2 * count - columns
    if freedom < FEWEST:
        raise CalibrationError(
            f"mirror shape: {count} features leave {freedom} degrees of freedom beside "
            f"{len(c)} coefficients; whether residuals are noise cannot be told"
        )
    left = np.einsum("nij,nj->ni", across, fitted.residuals)
    left = left - fit @ np.einsum("nik,ni->k", fit, left)
    joined = neighbours(rays.p, fitted.grids)
    shared = _with_neighbours(joined, fit)
    among = np.einsum("nik,nil->kl", fit, shared)
    trace = -np.trace(among)
    squares = 2 * joined.nnz - 2 * np.sum(shared**2) + np.sum(among**2)
    mean = trace / freedom
    variance = (2 * squares + trace**2) / (freedom * (freedom + 2)) - mean**2
    found = np.sum(left * (joined @ left)) / np.sum(left**2)
    unit = count / joined.nnz
    return Whiteness(
        float(unit * found), float(unit * mean), float(unit * np.sqrt(variance)),
        joined.nnz // 2,
    )  # fmt: skip


def neighbours(p, grids):
    """Sparse symmetric (N, N) matrix with a 1 for each pair of neighbours.

    p: (N, 2) places in the picture; grids: (N,) of which grid each is. Raises
    CalibrationError where a grid's places lie on a line.
    """
    pairs = [np.zeros((0, 2), int)]
    for grid in np.unique(grids):
        own = np.flatnonzero(grids == grid)
        if len(own) < 4:
            continue
        corners = _triangles(p[own])
        sides = np.sort(np.vstack([corners[:, [k, (k + 1) % 3]] for k in range(3)]), 1)
        sides = own[np.unique(sides, axis=0)]
        length = np.linalg.norm(p[sides[:, 0]] - p[sides[:, 1]], axis=1)
        pairs.append(sides[length < LONGEST * np.median(length)])
    i, j = np.vstack(pairs).T
    ends = np.concatenate([i, j]), np.concatenate([j, i])
    return coo_array((np.ones(2 * len(i)), ends), shape=(len(p), len(p))).tocsr()


def _triangles(p):
    try:
        return Delaunay(p).simplices
    except QhullError:
        raise CalibrationError(
            f"mirror shape: {len(p)} features of a grid lie on a line in the picture; "
            "take features that cover an area"
        ) from None


def _across(directions):
    """(N, 2, 3): two unit vectors across each ray, alike for neighbouring rays."""
    least = np.argmin(np.abs(directions).max(axis=0))
    first = np.eye(3)[least] - directions[:, least, None] * directions
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(directions, first)], axis=1)


def _orthonormal(columns):
    """Basis (N, 2, k) of the space that columns (N, 2, m) span."""
    flat = columns.reshape(-1, columns.shape[2])
    size = np.linalg.norm(flat, axis=0)
    flat = flat[:, size > 0] / size[size > 0]
    U, values, _ = np.linalg.svd(flat, full_matrices=False)
    kept = U[:, values > RANK * values[0]]
    return kept.reshape(*columns.shape[:2], -1)


def _with_neighbours(joined, fit):
    """The sum over the neighbours of each row of (N, 2, k)."""
    flat = fit.reshape(len(fit), -1)
    return (joined @ flat).reshape(fit.shape)
