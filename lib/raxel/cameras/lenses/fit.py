"""Fit the radial law of a camera to angles and image radii."""

from typing import NamedTuple

import numpy as np

from raxel.cameras.core.base import Camera
from raxel.errors import InputError

# Step of the differences that give the Jacobian, in pixels of the largest radius.
STEP_PX = 1e-3
# A trial camera that cannot be built, and how far inside its limit one must stay.
UNBUILT_PX = 1e6
MARGIN = 1e-4
# How steeply a radius runs back beyond a trial's limit, in mean slopes of the data.
PENALTIES = (20, 2000)


class RadialFit(NamedTuple):
    """camera: the fitted one; rms_px; residuals_px (N,); free: number of parameters."""

    camera: Camera
    rms_px: float
    residuals_px: np.ndarray
    free: int


def radii_of(camera, angles):
    """Image radius in pixels at angles (N,) from the axis, rows along u; NaN unseen."""
    angles = np.asarray(angles, float)
    # The first is the axis.
    angles = np.concatenate([[0.0], angles])
    points = np.column_stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)])
    pixels = camera.project(points).pixels
    return np.hypot(*(pixels[1:] - pixels[0]).T)


def fit_camera(camera, angles, radii):
    """Refit the radial parameters of a radially symmetric camera by least squares.

    camera: where to start; it must see all angles. angles: (N,), radians from the
    axis; radii: (N,), pixels along u. Free are the fields that shape r(theta): of K
    only its size; centre, aspect and skew stay. Minimises the sum of squared radius
    errors. Returns a RadialFit.

    Raises InputError for a kind that is not radially symmetric, a camera with
    decentring or asymmetric terms, arrays of unequal length or too few values, and
    angles that the starting camera does not see (a model of the image plane sees less
    than 90 degrees).
    """
    angles, radii = np.asarray(angles, float), np.asarray(radii, float)
    start = _free_values(camera)
    _check(camera, angles, radii, len(start))

    values = start
    # A coefficient more at a time, so that no more of them never fit worse.
    for count in range(min(2, len(start)), len(start) + 1):
        values = _least_squares(camera, values, count, angles, radii, PENALTIES[0])
    # Drives what is left beyond the limit back inside.
    values = _least_squares(camera, values, len(start), angles, radii, PENALTIES[1])
    best = _rebuilt(camera, values)
    residuals = radii_of(best, angles) - radii
    if np.isnan(residuals).any():
        raise InputError(
            f"the best {camera.kind} camera ends at {np.degrees(_limit(best)):.2f} "
            "degrees, inside the angles; give a smaller range, or more terms"
        )
    rms = float(np.sqrt(np.mean(residuals**2)))
    return RadialFit(best, rms, residuals, len(start))


def _least_squares(camera, start, count, angles, radii, slope):
    """The first `count` free values that fit best, the others as they are.

    Beyond a trial's limit its radius runs back.
    """
    from scipy.optimize import least_squares

    penalty = slope * radii.max() / angles.max()

    def misses(values):
        try:
            trial = _rebuilt(camera, values)
        except InputError:
            return np.full(len(angles), UNBUILT_PX)
        inside = np.minimum(angles, _limit(trial) - MARGIN)
        miss = radii_of(trial, inside) - radii - penalty * (angles - inside)
        return np.where(np.isfinite(miss), miss, UNBUILT_PX)

    # From steps of about a pixel to values; those that are not free get none.
    scale = np.diag(_pixel_steps(misses, start))[:, :count]

    def jacobian(steps):
        columns = []
        for shift in STEP_PX * np.eye(count):
            ahead, behind = (
                misses(start + scale @ (steps + s)) for s in (shift, -shift)
            )
            columns.append((ahead - behind) / (2 * STEP_PX))
        return np.column_stack(columns)

    found = least_squares(
        lambda steps: misses(start + scale @ steps),
        np.zeros(count),
        jac=jacobian,
        x_scale="jac",
        xtol=1e-13,
        ftol=1e-13,
        gtol=1e-13,
        max_nfev=100,
    )
    return start + scale @ found.x


def _limit(camera):
    """Largest angle the camera sees."""
    if camera.kind == "perspective":
        return float(np.arctan(camera.max_radius))
    return camera.max_angle


def _check(camera, angles, radii, free):
    if angles.ndim != 1 or angles.shape != radii.shape or len(angles) < free:
        raise InputError(
            f"angles {angles.shape} and radii {radii.shape} found; give as many of one "
            f"as of the other, and at least {free} for a {camera.kind} camera"
        )
    if not (np.isfinite(angles).all() and np.isfinite(radii).all()):
        raise InputError("angles and radii must be finite")
    unseen = np.isnan(radii_of(camera, angles))
    if unseen.any():
        raise InputError(
            f"the {camera.kind} camera to start from does not see "
            f"{np.count_nonzero(unseen)} of the angles, the smallest "
            f"{np.degrees(angles[unseen].min()):.2f} degrees; give angles in its field "
            "of view, or a start with a wider one"
        )


def _free_values(camera):
    """The free values in one vector; K stands for one factor, 1 at the start."""
    even = not (
        np.any(getattr(camera, "tangential", 0)) or not getattr(camera, "symmetric", 1)
    )
    if not (camera.radial_fields and even):
        raise InputError(
            f"a {camera.kind} camera that is not radially symmetric cannot be fitted "
            "to angles and radii; leave out its decentring terms or take another kind"
        )
    return np.concatenate(
        [
            np.atleast_1d(1.0 if name == "K" else getattr(camera, name))
            for name in camera.radial_fields
        ]
    )


def _rebuilt(camera, values):
    """The camera with other radial values, seeing as far as its law allows."""
    fields = camera._fields() | {"width": camera.width, "height": camera.height}
    for name, value in list(fields.items()):
        if np.ndim(value) == 0 and not isinstance(value, int):
            fields[name] = value.item()
    if camera.kind != "fisheye":
        fields.pop("max_angle", None)
    for name in camera.radial_fields:
        old = np.asarray(fields[name])
        count = 1 if name == "K" else old.size
        new, values = values[:count], values[count:]
        if name == "K":
            fields[name] = old * [[new[0]] * 2 + [1], [new[0]] * 2 + [1], [1, 1, 1]]
        else:
            fields[name] = new.reshape(old.shape) if old.ndim else float(new[0])
    return type(camera)(**fields)


def _pixel_steps(misses, start):
    """For each value the change that moves the largest radius error by about 1 px."""
    here, scale = misses(start), np.empty(len(start))
    for k in range(len(start)):
        step = 1e-3 * max(abs(start[k]), 1.0)
        while True:
            values = start.copy()
            values[k] += step
            change = np.abs(misses(values) - here).max()
            if change < 1 or step < 1e-60:
                break
            step /= 4
        scale[k] = step / max(change, 1e-12)
    return scale
