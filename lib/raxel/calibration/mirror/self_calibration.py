"""Shape of a bent mirror from a static, unmeasured scene (5.4).

Features are matched between images before and after bending; the mirror before is
calibrated. `linear_update` assumes an infinitely distant scene, as the thesis's
self-calibration does. Residuals do not reveal a wrong shape: depth of the scene and
bending of the mirror move features alike.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.mirror.clamp import Clamp, FixedLine
from raxel.calibration.mirror.observations import (
    clamped_end,
    need_support,
    normalised,
    support_of,
)
from raxel.calibration.mirror.refine import (
    camera_of_shape,
    reflection_normals,
    shape_with_clamp,
)
from raxel.calibration.mirror.update import MirrorSettings
from raxel.cameras.core.base import Rays
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry.spline_grids import spline_grid

MIN_N_MATCHES = 12  # matches, for the coefficients that a clamp leaves undetermined
# Rays at a smaller angle determine no point.
MIN_RAY_ANGLE_RAD = 1e-5


class SelfUpdate(NamedTuple):
    """Hold the result of a self-calibration.

    Attributes
    ----------
    camera : SplineMirrorCamera
        Camera after the deflection.
    used : ndarray of bool, shape (M,)
        Features that count.
    flags : tuple of str
        Warnings, one text each.
    """

    camera: SplineMirrorCamera
    used: np.ndarray
    flags: tuple


def linear_update(
    before: SplineMirrorCamera,
    pixels_before: ArrayLike,
    pixels_after: ArrayLike,
    clamp: Clamp | FixedLine,
    settings: MirrorSettings | None = None,
    *,
    outline: ArrayLike | None = None,
) -> SelfUpdate:
    """Estimate a bent mirror by the linear stage alone, with the scene at infinity.

    The estimated deflection is too small, by about Z / (Z + D) at a depth Z, with the
    viewing camera D from the mirror.

    Parameters
    ----------
    before : SplineMirrorCamera
        Camera before the deflection.
    pixels_before, pixels_after : array_like, shape (M, 2)
        Matched features, px, NaN where one was not found.
    clamp, settings, outline
        See `update_mirror`.

    Returns
    -------
    SelfUpdate
        Camera after the deflection.

    Raises
    ------
    CalibrationError
        ``too-few-features``: too few matches. ``no-feature-at-end``: outermost knot
        intervals without any. ``wrong-shape``, ``unmatched-features``, ``no-clamp``:
        input that does not fit.

    References
    ----------
    Thesis 5.4, (5.28).
    """
    settings = settings or MirrorSettings()
    pixels_before, pixels_after = (
        np.asarray(pixels, float) for pixels in (pixels_before, pixels_after)
    )
    _check_given(pixels_before, pixels_after, clamp, outline)
    rays, p = before.rays(pixels_before), normalised(before.viewer, pixels_after)
    used = rays.valid & np.isfinite(p).all(axis=1)
    if np.count_nonzero(used) < MIN_N_MATCHES:
        raise CalibrationError(
            f"self-calibration: found {np.count_nonzero(used)} matched features; give "
            f"{MIN_N_MATCHES} or more",
            code="too-few-features",
        )
    p = p[used]
    span = [p, clamp.points]
    if outline is not None:
        span.append(normalised(before.viewer, np.asarray(outline, float)))
    grid = spline_grid(
        np.vstack(span), settings.shape, settings.degree, before.grid.angle
    )
    flags = need_support(
        support_of(grid, p), clamped_end(grid, clamp), settings.prior_sd is not None
    )
    # The scene is infinitely distant: its rays keep their directions (5.28).
    w = np.column_stack([p, np.ones(len(p))])
    normals = reflection_normals(w, rays.directions[used])
    c = shape_with_clamp(p, normals, grid, before.quantity, clamp)
    camera = camera_of_shape(before.viewer, grid, c, before.quantity)
    return SelfUpdate(camera, used, tuple(flags))


def _check_given(pixels_before, pixels_after, clamp, outline):
    """Reject arrays of another shape, and a missing clamp."""
    for what, pixels in (("before", pixels_before), ("after", pixels_after)):
        if pixels.ndim != 2 or pixels.shape[1] != 2:
            raise CalibrationError(
                f"self-calibration: pixels {what}: found shape {pixels.shape}; give "
                "(M, 2)",
                code="wrong-shape",
            )
    if len(pixels_before) != len(pixels_after):
        raise CalibrationError(
            f"self-calibration: found {len(pixels_before)} pixels before and "
            f"{len(pixels_after)} after; give matched pixels",
            code="unmatched-features",
        )
    if clamp is None:
        raise CalibrationError(
            "self-calibration: a clamp is missing; give that of the primary "
            "calibration",
            code="no-clamp",
        )
    if outline is not None:
        outline = np.asarray(outline, float)
        if outline.shape != (len(outline), 2) or not np.isfinite(outline).all():
            raise CalibrationError(
                f"self-calibration: outline: found shape {outline.shape}; give (L, 2), "
                "finite",
                code="wrong-shape",
            )


def met_points(
    first: tuple[NDArray[np.float64], NDArray[np.float64]], second: Rays
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the points nearest to two rays each.

    Parameters
    ----------
    first : tuple of ndarray
        Origins (N, 3), mm, and directions (N, 3).
    second : Rays
        N rays in the same frame, mm.

    Returns
    -------
    points : ndarray, shape (N, 3)
        Points amid both rays, mm.
    ahead : ndarray of bool, shape (N,)
        Whether they lie ahead of both.
    """
    o, d = first
    q, e = second.origins, second.directions
    gap, cosine = q - o, np.sum(d * e, axis=1)
    sine = np.sum(np.cross(d, e) ** 2, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        by_d, by_e = np.sum(gap * d, axis=1), np.sum(gap * e, axis=1)
        s = (by_d - cosine * by_e) / sine
        t = (cosine * by_d - by_e) / sine
        points = (o + s[:, None] * d + q + t[:, None] * e) / 2
        ahead = (s > 0) & (t > 0) & (sine > MIN_RAY_ANGLE_RAD**2)
    return points, ahead
