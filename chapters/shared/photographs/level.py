"""How strongly a camera distorts, from its rays alone: no model, no truth."""

from __future__ import annotations

import numpy as np

from raxel.geometry import rotation_from_vector

RAYS = 4000  # of the table; a curve of a few terms needs no more
POWERS = (1, 3, 5, 7)  # of the angle, in the radial curve
FEWEST_RAYS = 100
OUTLIER_PX = 1.0  # where a ray begins to count less
# A pinhole puts what lies at a right angle, or behind, infinitely far out.
LEVEL_AT_RIGHT_ANGLES = 1.0
NUMBERS = ("level", "widest_deg", "focal_px", "u0_px", "v0_px", "fit_px")


def distortion_level(camera):
    """The level of claim c2_real_vs_sim_agree for a table of rays.

    A general camera knows no axis. So the axis, where it meets the image, and a curve
    r(theta) are fitted to the rays. The curve tells r, and its slope at the axis the
    pinhole, r_pinhole = r'(0) tan(theta).

    level: max |r / r_pinhole - 1| over the pixels with a ray; 1 from 90 degrees on,
    where r_pinhole is infinite. widest_deg: largest angle to the axis. focal_px: px per
    radian near the axis. u0_px, v0_px: where the axis meets the image. fit_px: median
    distance of the pixels from the curve. curve: coefficients of its odd powers.
    NaN where there are too few rays.
    """
    rows, columns = np.nonzero(camera.mask)
    step = max(1, len(rows) // RAYS)
    pixels = np.column_stack([columns, rows])[::step].astype(float)
    rays = camera.rays(pixels)
    pixels, directions = pixels[rays.valid], rays.directions[rays.valid]
    if len(pixels) < FEWEST_RAYS:
        numbers = dict.fromkeys(NUMBERS, np.nan)
        return numbers | {"curve": np.full(len(POWERS), np.nan)}
    middle = np.array([camera.width - 1, camera.height - 1]) / 2
    centre, turn, curve, distances = fitted_curve(pixels, directions, middle)
    widest = angles_to_axis(directions, turn).max()
    return {
        "level": level_of(curve, widest),
        "widest_deg": np.degrees(widest),
        "focal_px": curve[0],
        "u0_px": centre[0],
        "v0_px": centre[1],
        "fit_px": np.median(distances),
        "curve": curve,
    }


def level_of(curve, widest):
    """max |r / r_pinhole - 1| up to the angle ``widest``, in radians."""
    if widest >= np.pi / 2:
        return LEVEL_AT_RIGHT_ANGLES
    angle = np.linspace(0, widest, 500)[1:]
    return np.abs(radius(curve, angle) / (curve[0] * np.tan(angle)) - 1).max()


def radius(curve, angle):
    """Distance from the axis's pixel in px at angles (N,) in radians."""
    return sum(a * angle**power for a, power in zip(curve, POWERS, strict=True))


def angles_to_axis(directions, turn):
    """Angles (N,) of directions (N, 3) to the axis, once turned onto z."""
    turned = directions @ rotation_from_vector(turn).T
    return np.arctan2(np.hypot(*turned[:, :2].T), turned[:, 2])


def fitted_curve(pixels, directions, middle):
    """Axis and radial curve of central rays: pixel = centre + r(theta) e.

    e is the unit direction across the axis. Returns centre (2,), the rotation vector
    (3,) that turns the rays so that the axis is z, the curve, and the distances (N,) of
    the pixels from it.
    """
    from scipy.optimize import least_squares

    span = np.linalg.norm(pixels - middle, axis=1).max()

    def residuals(unknown):
        centre, turn, curve = np.split(unknown, [2, 5])
        turned = directions @ rotation_from_vector(turn / span).T
        across = np.hypot(*turned[:, :2].T)
        away = turned[:, :2] / np.maximum(across, 1e-12)[:, None]
        angle = np.arctan2(across, turned[:, 2])
        r = radius(curve, angle)[:, None]
        return (middle + centre + r * away - pixels).ravel()

    angle = angles_to_axis(directions, np.zeros(3))
    out = np.linalg.norm(pixels - middle, axis=1)
    start = np.zeros(5 + len(POWERS))
    start[5] = out @ angle / (angle @ angle)
    found = least_squares(
        residuals, start, loss="soft_l1", f_scale=OUTLIER_PX, x_scale="jac"
    ).x
    distances = np.linalg.norm(residuals(found).reshape(-1, 2), axis=1)
    return middle + found[:2], found[2:5] / span, found[5:], distances
