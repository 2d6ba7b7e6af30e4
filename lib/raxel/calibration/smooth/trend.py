"""The lens formula nearest to given rays: what a smooth field is laid upon.

Kannala and Brandt's radial law (2.9) about a free axis and centre, fitted in px, with
Cauchy's loss, so that wrong rays pull little.
"""

from typing import NamedTuple

import numpy as np

from raxel.cameras.lenses.kannala_brandt import KannalaBrandtCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.poses import nearest_rotation, rotation_from_vector

MAX_TERMS = 5
MIN_RAYS = 40


class RayTrend(NamedTuple):
    """camera: a KannalaBrandtCamera with its own axis as z; R_rays_trend (3, 3): to the
    frame of the rays; scale_px: robust standard deviation of a coordinate of pixels
    about the formula's.
    """

    camera: KannalaBrandtCamera
    R_rays_trend: np.ndarray
    scale_px: float


def trend_of_rays(pixels, directions, width, height):
    """The RayTrend of rays with unit directions (N, 3) at pixels (N, 2).

    With as many radial terms, 2 to 5, as let the law rise out to the image's corners.
    Raises CalibrationError for fewer than 40 rays, and where no such law is near.
    """
    if len(pixels) < MIN_RAYS:
        raise CalibrationError(
            f"trend of rays: found {len(pixels)} rays; {MIN_RAYS} are needed",
            code="too-few-rays",
        )
    start, R = _start(pixels, directions, width, height)
    corners = np.array([[x, y] for x in (0, width - 1) for y in (0, height - 1)])
    fits = []
    for terms in range(2, MAX_TERMS + 1):
        values, scale = _fitted(pixels, directions @ R, start[: 7 + terms])
        try:
            camera = _camera(values, width, height)
        except InputError:
            continue
        reach = camera.rays(corners).valid.all() or _passes_pi(values, corners)
        turned = R @ rotation_from_vector(values[:3]).T
        fits.append((reach, -scale, RayTrend(camera, turned, scale)))
        start[: len(values)] = values
    if not fits:
        raise CalibrationError(
            "trend of rays: no radial law is near these rays", code="no-lens-formula"
        )
    return max(fits, key=lambda fit: fit[:2])[2]


def _passes_pi(values, corners):
    """Whether the law reaches pi before the image's corners."""
    radius = np.linalg.norm((corners - values[3:5]) / np.exp(values[5:7]), axis=1)
    return radius.max() > np.pi * np.polyval(values[:6:-1], np.pi**2)


def _start(pixels, directions, width, height):
    """Values (7 + MAX_TERMS,) of r = theta and the rotation of an axis at mid-image.

    The axes that map the rays best to those of an equidistance lens; its focal length
    by the angles between rays and the one in the middle.
    """
    middle = (np.array([width, height]) - 1) / 2
    offset = pixels - middle
    radius = np.linalg.norm(offset, axis=1)
    nearest = np.argsort(radius)[: max(3, len(radius) // 50)]
    z = directions[nearest].mean(axis=0)
    cosine = np.clip(directions @ z / np.linalg.norm(z), -1, 1)
    angle = np.arccos(cosine)
    focal = np.vdot(radius, radius) / max(np.vdot(radius, angle), 1e-12)
    theta = np.minimum(radius / focal, np.pi)
    across = offset / np.maximum(radius, 1e-12)[:, None] * np.sin(theta)[:, None]
    R = nearest_rotation(directions.T @ np.column_stack([across, np.cos(theta)]))
    values = np.zeros(7 + MAX_TERMS)
    values[3:5], values[5:7], values[7] = middle, np.log(focal), 1.0
    return values, R


def _fitted(pixels, directions, start):
    """Values and robust scale. Values: rotation (3,), centre (2,), logarithms of
    pixels per unit (2,), then k1 = 1, which stays, k2, ..."""
    from scipy.optimize import least_squares

    free = np.arange(len(start)) != 7

    def misses(free_values):
        values = start.copy()
        values[free] = free_values
        return (_imaged(directions, values) - pixels).ravel()

    def scale_of(residuals):
        return max(1.4826 * float(np.median(np.abs(residuals))), 1e-9)

    found, scale = start[free], scale_of(misses(start[free]))
    for _ in range(3):
        found = least_squares(
            misses, found, loss="cauchy", f_scale=3 * scale, x_scale="jac",
            xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=60,
        ).x  # fmt: skip
        before, scale = scale, scale_of(misses(found))
        if scale > 0.9 * before:
            break
    values = start.copy()
    values[free] = found
    return values, scale


def _imaged(directions, values):
    """Pixels (N, 2) of directions by the polynomial, even where it does not rise."""
    d = directions @ rotation_from_vector(values[:3]).T
    across = np.hypot(d[:, 0], d[:, 1])
    theta = np.arctan2(across, d[:, 2])
    radius = theta * np.polyval(values[:6:-1], theta**2)
    unit = d[:, :2] / np.maximum(across, 1e-300)[:, None]
    return radius[:, None] * unit * np.exp(values[5:7]) + values[3:5]


def _camera(values, width, height):
    return KannalaBrandtCamera(
        values[7:], np.exp(values[5:7]), values[3:5], width, height
    )
