"""Planes through points in space: total least squares."""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.geometry.poses import pose
from raxel.multiview.fits.orthogonal import Settled, checked_points, spread, weights_of

FLAT = 1e-9  # of the extent: points nearer to a line than this lie on it


class PlaneFit(NamedTuple):
    """The plane z = 0 of T_frame_plane (4, 4), in the frame of the points.

    Its origin is the points' mean, x the direction in which they spread most, both
    weighted as the distances are, z the normal, away from the frame's origin.
    covariance: (3, 3) of turns about x and y, radians, and of the shift along z; the
    plane's frame. residuals: (N,) distances of all points, positive on the side of z;
    sigma: see `Settled`.
    """

    T_frame_plane: np.ndarray
    covariance: np.ndarray
    residuals: np.ndarray
    sigma: float

    @property
    def normal(self):
        """Unit (3,)."""
        return self.T_frame_plane[:3, 2]


def fit_plane(points, sigma=None):
    """The plane of least squared distances, in closed form.

    points: (N, 3), N >= 3, any unit; sigma: standard deviations of the distances, a
    number or (N,), or None: equal, and measured by what is left. Returns PlaneFit.
    Raises InputError for fewer than three points, values that are not finite, and
    points on one line.
    Source: Pearson 1901, doi:10.1080/14786440109462720.
    """
    points = checked_points("plane", points, 3, 3)
    return _as_fit(_settled(points, sigma), points)


def _settled(points, sigma):
    weight = weights_of("plane", sigma, len(points)) ** 2
    middle = weight @ points / weight.sum()
    off = points - middle
    extents, axes = np.linalg.svd(off * np.sqrt(weight)[:, None], full_matrices=False)[
        1:
    ]
    if not extents[1] > FLAT * extents[0]:
        raise InputError("plane: the points lie on one line; give points beside it")
    normal = axes[2]
    distances = off @ normal
    # In the frame of the axes a turn (a, b) and a shift s change the distances by
    # b x - a y - s, and x and y are uncorrelated.
    inverse = np.diag(1 / np.array([extents[1] ** 2, extents[0] ** 2, weight.sum()]))
    covariance, scatter = spread(inverse, weight @ distances**2, len(points), sigma)
    parameters = np.concatenate([middle, normal, axes[0]])
    return Settled(parameters, distances, covariance, scatter)


def _as_fit(fit, points):
    middle, normal, x = fit.parameters.reshape(3, 3)
    normal = normal * (-1 if normal @ middle < 0 else 1)
    x = x * np.sign(x[np.argmax(np.abs(x))])
    T = pose(np.column_stack([x, np.cross(normal, x), normal]), middle)
    residuals = (points - middle) @ normal
    return PlaneFit(T, fit.covariance, residuals, fit.sigma)
