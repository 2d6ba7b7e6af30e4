"""What every localiser takes and returns."""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError

SMALLEST_WINDOW = 5


class Localised(NamedTuple):
    """Corners after localisation.

    corners: (N, 2) pixels (u, v). sd: (N,) px, standard deviation of the position per
    axis (root mean square of both) from the noise that the image shows about the
    corner; NaN where nothing was found, infinite where the window does not hold the
    corner. converged: (N,); where False the corner is returned where it was put.

    `sd` is the spread that noise gives. What a window sees beyond the corner, such as
    other corners, may move a result further.
    """

    corners: np.ndarray
    sd: np.ndarray
    converged: np.ndarray


def checked(image, corners, window):
    """Grey image as float64 and corners (N, 2), or InputError in one line."""
    image = np.asarray(image)
    if image.ndim != 2:
        raise InputError(
            f"image: found an array of shape {image.shape}; give grey, (height, width)"
        )
    corners = np.asarray(corners, dtype=float)
    if corners.ndim != 2 or corners.shape[1] != 2:
        raise InputError(
            f"corners: found an array of shape {corners.shape}; give (N, 2) pixels"
        )
    if window != int(window) or window < SMALLEST_WINDOW or window % 2 == 0:
        raise InputError(
            f"window: found {window}; give an odd width of {SMALLEST_WINDOW} px or more"
        )
    return image.astype(float), corners


def still_there(found, start, window):
    """Which corners (N,) are finite and within the window they were put in."""
    with np.errstate(invalid="ignore"):
        return (np.abs(found - start) <= window / 2).all(axis=1)


def localised(start, found, variance, converged):
    """A Localised of what converged, and of the start elsewhere.

    variance: (N, 2, 2) px^2, covariance of the position; NaN where there is none.
    """
    corners = np.where(converged[:, None], found, start)
    with np.errstate(invalid="ignore"):
        sd = np.sqrt(np.trace(variance, axis1=1, axis2=2) / 2)
    sd = np.where(np.isfinite(sd), sd, np.inf)
    return Localised(corners, np.where(converged, sd, np.nan), converged)


def inverted(matrices):
    """Inverses of (N, 2, 2); not finite where there is none."""
    a, b, c, d = matrices.reshape(-1, 4).T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.stack([d, -b, -c, a] / (a * d - b * c), axis=1).reshape(-1, 2, 2)
