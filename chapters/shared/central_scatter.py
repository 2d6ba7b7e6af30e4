"""How rays scatter about the centre of a calibration (4.3.2, Fig. 4.6)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from raxel.geometry import on_plane, transform

EDGE = 1e-9  # mm, a point so near to the hull lies in it
GAUSSIAN_KURTOSIS = 8.0  # Mardia's, of two coordinates


class Scatter(NamedTuple):
    """Where best-fit rays cross the plane through the centre.

    points: (N, 2) mm, the centre at (0, 0); rms_mm: RMS distance from it; eigenvalues:
    ratio of the smaller to the larger of the covariance, 1 if it is the same in all
    directions; kurtosis: |b - 8| by Mardia, skewness: his b1, both 0 of a Gaussian;
    inside: whether the centre lies in the convex hull.
    """

    points: np.ndarray
    rms_mm: float
    eigenvalues: float
    kurtosis: float
    skewness: float
    inside: bool

    def measures(self):
        """All but the points, as a dict of numbers."""
        return {
            "rms_mm": self.rms_mm,
            "eigenvalues": self.eigenvalues,
            "kurtosis": self.kurtosis,
            "skewness": self.skewness,
            "inside": float(self.inside),
        }


def best_lines(points, T_base_grid):
    """Middles (N, 3) and unit directions (N, 3) of lines nearest to the points of rays.

    points: (n, N, 2) mm on n grids with poses (n, 4, 4).
    """
    placed = transform(T_base_grid, on_plane(points))
    middles = placed.mean(axis=0)
    off = np.moveaxis(placed - middles, 1, 0)
    _, vectors = np.linalg.eigh(np.swapaxes(off, 1, 2) @ off)
    return middles, vectors[:, :, 2]


def facing_plane(directions):
    """Axes (2, 3) in the plane that lies across directions (N, 3), as by (4.24).

    Its normal makes the sum of squared sines of the angles to them least.
    """
    _, vectors = np.linalg.eigh(directions.T @ directions)
    return vectors[:, :2].T


def scatter_about(centre, points, T_base_grid):
    """The Scatter of the rays through points (n, N, 2) about an estimated centre."""
    middles, directions = best_lines(points, T_base_grid)
    across = facing_plane(directions)
    normal = np.cross(*across)
    reach = ((centre - middles) @ normal) / (directions @ normal)
    crossing = (middles + reach[:, None] * directions - centre) @ across.T
    return described(crossing)


def described(crossing):
    """The Scatter of points (N, 2) about (0, 0)."""
    off = crossing - crossing.mean(axis=0)
    covariance = off.T @ off / len(off)
    values = np.linalg.eigvalsh(covariance)
    white = off @ np.linalg.inv(np.linalg.cholesky(covariance)).T
    kurtosis = np.mean(np.sum(white**2, axis=1) ** 2)
    planes = ConvexHull(crossing).equations
    return Scatter(
        crossing,
        float(np.sqrt(np.mean(np.sum(crossing**2, axis=1)))),
        float(values[0] / values[1]),
        float(abs(kurtosis - GAUSSIAN_KURTOSIS)),
        _skewness(white),
        bool(np.all(planes[:, 2] <= EDGE)),
    )


def _skewness(white):
    """Mardia's b1 of points (N, 2) of unit covariance, from their third moments."""
    x, y = white.T
    thirds = x * x * x, x * x * y, x * y * y, y * y * y
    moments = [np.mean(product) for product in thirds]
    return float(np.dot([1, 3, 3, 1], np.square(moments)))
