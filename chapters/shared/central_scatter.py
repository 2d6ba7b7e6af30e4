"""How rays scatter about the centre of a calibration (4.3.2, Fig. 4.6)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from raxel.geometry import on_plane, transform

EDGE = 1e-9  # mm, a point so near to the hull lies in it
GAUSSIAN_KURTOSIS = 8.0  # Mardia's, of two coordinates
TILTS_DEG, TOWARDS = (10.0, 20.0, 30.0), 8  # of planes, in so many directions


class Lines(NamedTuple):
    """Lines by points on them, middles (N, 3) mm, and unit directions (N, 3)."""

    middles: np.ndarray
    directions: np.ndarray

    def some(self, chosen):
        """Those of them that are chosen (N,)."""
        return Lines(self.middles[chosen], self.directions[chosen])


def best_lines(points, T_base_grid):
    """The Lines nearest to the points of rays, (n, N, 2) mm on grids (n, 4, 4)."""
    placed = transform(T_base_grid, on_plane(points))
    middles = placed.mean(axis=0)
    off = np.moveaxis(placed - middles, 1, 0)
    _, vectors = np.linalg.eigh(np.swapaxes(off, 1, 2) @ off)
    return Lines(middles, vectors[:, :, 2])


def facing_plane(directions):
    """Axes (2, 3) in the plane that lies across directions (N, 3), as by (4.24).

    Its normal makes the sum of squared sines of the angles to them least.
    """
    _, vectors = np.linalg.eigh(directions.T @ directions)
    return vectors[:, :2].T


def crossings(centre, lines):
    """Where Lines cross the plane through the centre that lies across them.

    (N, 2) mm; the centre is at (0, 0).
    """
    middles, directions = lines
    across = facing_plane(directions)
    normal = np.cross(*across)
    reach = ((centre - middles) @ normal) / (directions @ normal)
    return (middles + reach[:, None] * directions - centre) @ across.T


def tilted_over_facing(centre, lines):
    """Smallest RMS distance from the centre at which Lines cross a tilted plane
    through it, over that on the plane which lies across them.
    """
    middles, directions = lines
    normals = normals_about(facing_plane(directions))
    off = middles - centre
    # Along a ray, from its middle to each plane: (planes, N).
    reach = -(normals @ off.T) / (normals @ directions.T)
    along = np.sum(off * directions, axis=1)
    beside = off - along[:, None] * directions
    squared = np.sum(beside**2, axis=1) + (along + reach) ** 2
    facing, *tilted = np.sqrt(squared.mean(axis=1))
    return float(min(tilted) / facing)


def normals_about(across):
    """Unit normals (1 + planes, 3): that of the plane with axes (2, 3), then those of
    planes tilted from it by TILTS_DEG in TOWARDS directions."""
    ahead = np.cross(*across)
    towards = np.linspace(0, 2 * np.pi, TOWARDS, endpoint=False)
    aside = np.column_stack([np.cos(towards), np.sin(towards)]) @ across
    tilted = [
        np.cos(tilt) * ahead + np.sin(tilt) * aside for tilt in np.radians(TILTS_DEG)
    ]
    return np.concatenate([ahead[None], *tilted])


def scatter_of(crossing):
    """Measures of the scatter of points (N, 2) about (0, 0).

    rms_mm: RMS distance from it; eigenvalues: ratio of the smaller to the larger of the
    covariance, 1 if it is the same in all directions; kurtosis: |b - 8| by Mardia,
    0 of a Gaussian; inside: whether the convex hull holds it.
    """
    off = crossing - crossing.mean(axis=0)
    covariance = off.T @ off / len(off)
    values = np.linalg.eigvalsh(covariance)
    white = off @ np.linalg.inv(np.linalg.cholesky(covariance)).T
    kurtosis = np.mean(np.sum(white**2, axis=1) ** 2)
    planes = ConvexHull(crossing).equations
    return {
        "rms_mm": float(np.sqrt(np.mean(np.sum(crossing**2, axis=1)))),
        "eigenvalues": float(values[0] / values[1]),
        "kurtosis": float(abs(kurtosis - GAUSSIAN_KURTOSIS)),
        "inside": float(np.all(planes[:, 2] <= EDGE)),
    }
