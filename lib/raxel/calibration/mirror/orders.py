"""How many knots, and of which degree: raised until the residuals are noise (6.3.3).

Few functions cannot follow a mirror's relief, many are guessed where features are far
apart. So functions are added step by step, always where they lower the residual
variance most: knots along u, knots along v, or a degree. No more are added once
neighbouring residuals agree no better than noise's do.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.primary import primary_from_points
from raxel.calibration.mirror.ray_points import RayPoints
from raxel.calibration.mirror.sightings import normalised
from raxel.calibration.mirror.update import MirrorSettings, update_mirror
from raxel.calibration.mirror.whiteness import FittedPoints, Whiteness, whiteness
from raxel.calibration.pose.three_point import motion_of_points
from raxel.errors import CalibrationError, InputError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform

MOST_COEFFICIENTS, HIGHEST_DEGREE = 160, 4
MANY = 4  # functions for each that is added at once
# Residuals of the primary stage beyond this many medians are of wrong points.
FAR = 10.0


class SplineOrder(NamedTuple):
    """shape: (Kf, Kg) basis functions; degree: along u and along v."""

    shape: tuple = (4, 3)
    degree: tuple = (2, 2)

    @property
    def size(self):
        """How many coefficients."""
        return self.shape[0] * self.shape[1]

    def raised(self):
        """The SplineOrders with more knots along u, with more along v, and with a
        degree more over the same knots. One knot more can be worse than none, where it
        moves the others off what they followed: so two more are tried as well, of many
        a fourth.
        """
        (f, g), (k, m) = self.shape, self.degree
        found = [SplineOrder((f + more, g), (k, m)) for more in (1, max(2, f // MANY))]
        found += [SplineOrder((f, g + more), (k, m)) for more in (1, max(2, g // MANY))]
        if max(k, m) < HIGHEST_DEGREE:
            found.append(SplineOrder((f + 1, g + 1), (k + 1, m + 1)))
        return found


class OrderStep(NamedTuple):
    """One order that was taken. found: PrimaryCalibration or MirrorUpdate; variance:
    squared residuals for each degree of freedom, mm^2; whiteness: Whiteness."""

    order: SplineOrder
    found: object
    variance: float
    whiteness: Whiteness


class OrderSearch(NamedTuple):
    """steps: OrderSteps, from the least order on; white: whether the last one's
    residuals are; reason: why it went no further, one text."""

    steps: tuple
    white: bool
    reason: str

    @property
    def order(self):
        """The last SplineOrder that was taken."""
        return self.steps[-1].order

    @property
    def found(self):
        """The calibration of that order."""
        return self.steps[-1].found


def raised_until_white(calibrate, least=None, most=MOST_COEFFICIENTS):
    """OrderSearch from the least SplineOrder on.

    calibrate: of a SplineOrder gives (calibration, FittedPoints), such as
    `primary_by_order` and `stage_by_order` make; most: coefficients. Where no higher
    order can be calibrated, or `most` is reached, the residuals stay what they are, and
    `white` is False: then more features are needed, or the noise itself is not white,
    and the last order may be worse than one before. Raises CalibrationError where even
    the least order is refused.
    """
    steps = []
    for step in rising(calibrate, least):
        if steps and step.order.size > most:
            reason = f"{most} coefficients are the most"
            return OrderSearch(tuple(steps), False, reason)
        steps.append(step)
        if step.whiteness.white:
            return OrderSearch(tuple(steps), True, "residuals are white")
    return OrderSearch(
        tuple(steps), False, "no higher order is supported by the features"
    )


def rising(calibrate, least=None):
    """OrderSteps from the least SplineOrder on, each with the step up that lowers the
    residual variance most, for as long as one can be calibrated.

    Arguments and errors as `raised_until_white`, which stops where residuals are white.
    """
    order = least or SplineOrder()
    found, fitted = calibrate(order)
    while True:
        yield OrderStep(order, found, fitted.variance, whiteness(fitted))
        tried = [
            (higher, result)
            for higher in order.raised()
            if (result := _calibrated(calibrate, higher)) is not None
        ]
        if not tried:
            return
        order, (found, fitted) = min(tried, key=lambda one: one[1][1].variance)


def _calibrated(calibrate, order):
    """What `calibrate` gives, None where it is refused."""
    try:
        return calibrate(order)
    except (CalibrationError, InputError):
        return None


def primary_by_order(viewer, pixels, points, T_camera_grid, **optional):
    """The primary stage as a function of a SplineOrder.

    pixels (N, 2), points (n, N, 2) mm, NaN where a pixel does not see a grid: as for
    `primary_from_points`; T_camera_grid: (n, 4, 4); optional: its angle, quantity and
    span.
    """
    image = normalised(viewer, np.asarray(pixels, float))
    known = np.isfinite(points).all(axis=2) & np.isfinite(image).all(axis=1)

    def calibrate(order):
        found = primary_from_points(
            viewer, pixels, points, T_camera_grid, shape=order.shape,
            degree=order.degree, **optional,
        )  # fmt: skip
        camera = found.camera
        inside = known & camera.grid.inside(image)
        grids, which = np.nonzero(inside)
        flat = points[grids, which]
        placed = np.concatenate(
            [transform(T, on_plane(xy[k]))
             for T, xy, k in zip(T_camera_grid, points, inside, strict=True)]
        )  # fmt: skip
        motion = np.zeros((len(flat), 3, 6 * len(T_camera_grid)))
        for grid, T in enumerate(T_camera_grid):
            own = grids == grid
            motion[own, :, 6 * grid : 6 * grid + 6] = motion_of_points(flat[own], T)
        fitted = _fitted(camera, image[which], placed, motion, grids)
        off = np.linalg.norm(fitted.residuals, axis=1)
        near = off <= FAR * np.median(off)
        return found, _fitted(
            camera, image[which][near], placed[near], motion[near], grids[near]
        )

    return calibrate


def stage_by_order(
    before, pixels_before, pixels_after, points, clamp, settings=None, **optional
):
    """A dynamic stage as a function of a SplineOrder.

    Arguments as `update_mirror`; of the settings, shape and degree do not count.
    Raises InputError for settings with a prior, after which residuals of noise are not
    white.
    """
    settings = settings or MirrorSettings()
    if settings.prior_sd is not None:
        raise InputError(
            "field 'prior_sd': residuals after a prior are not noise's; give none, and "
            "settle the order first"
        )
    pixels_after = np.asarray(pixels_after, float)

    def calibrate(order):
        own = settings._replace(shape=order.shape, degree=order.degree)
        found = update_mirror(
            before, pixels_before, pixels_after, points, clamp, own, **optional
        )
        used, T = found.used, found.pose.T_camera_grid
        flat = np.asarray(points, float)[used]
        fitted = _fitted(
            found.camera, normalised(before.viewer, pixels_after[used]),
            transform(T, on_plane(flat)), motion_of_points(flat, T),
            np.zeros(len(flat), int),
        )  # fmt: skip
        return found, fitted

    return calibrate


def _fitted(camera, image, placed, motion, grids):
    rays = RayPoints(image, camera.grid, camera.quantity)
    return FittedPoints(rays, camera.coefficients.ravel("F"), placed, motion, grids)
