"""A mirror after it was bent, from a static scene that nobody knows (5.4).

Features are matched between a picture before and one after; the mirror before is
calibrated. `linear_update` takes the scene to be infinitely far away, as the thesis's
self-calibration does; `feedback_updates` puts points that are triangulated from the two
pictures in its place, again and again (the loop that 5.4 suggests); `one_depth_update`
takes one depth for the whole scene, unknown, and a mirror that bends evenly. All find
shapes that fit. Whether they are right, no residual says: depth of the scene and
bending of the mirror move features alike.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from raxel.calibration.mirror.linear import reflection_normals, shape_with_clamp
from raxel.calibration.mirror.prior import bending_prior, plane_through
from raxel.calibration.mirror.refine import camera_of_shape, refine_shape
from raxel.calibration.mirror.sightings import magnification, normalised
from raxel.calibration.mirror.support import clamped_end, need_support, support_of
from raxel.calibration.mirror.update import MirrorSettings
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry.spline_grid import spline_grid

FEWEST = 12  # matches, for the coefficients that a clamp leaves open
# Of the scene from the mirror, mm: nearest that is looked for, and what is infinity.
NEAREST_MM, INFINITY_MM = 200.0, 1e7
# Of one over the depth, as a share of one over the nearest.
DEPTH_TOLERANCE = 1e-4
# Rays more nearly parallel than this say nothing of a point, radians.
LEAST_ANGLE = 1e-5
# Standard deviations of features beyond which residuals are no matter of noise.
MISFIT = 10.0


class SceneMatches(NamedTuple):
    """Matched features of a scene, ready for a shape.

    p: (N, 2) normalised image coordinates after; origins, directions: (N, 3) of the
    rays before, viewer's frame, mm; used: (M,) which of all the given are these; noise:
    standard deviation of p; grid: SplineGrid of the picture after; flags: of its knots.
    """

    p: np.ndarray
    origins: np.ndarray
    directions: np.ndarray
    used: np.ndarray
    noise: float
    grid: object
    flags: tuple

    def at(self, depth_mm):
        """Points (N, 3), mm: so far along the rays before."""
        return self.origins + depth_mm * self.directions


class SelfUpdate(NamedTuple):
    """camera: SplineMirrorCamera after; depth_mm: of the scene from the mirror, the
    median of its points, infinite for the linear one; rms: of the residuals, in
    standard deviations of the features, NaN where there are none; used: (M,) features
    that count; flags: what a reader should know, one text each."""

    camera: SplineMirrorCamera
    depth_mm: float
    rms: float
    used: np.ndarray
    flags: tuple


def scene_matches(
    before, pixels_before, pixels_after, clamp, settings=None, *, outline=None
):
    """SceneMatches of pixels (M, 2) before and after, NaN where one was not found.

    before: SplineMirrorCamera; clamp, outline: as `update_mirror` takes them. Raises
    CalibrationError for too few matches and for outermost knot intervals without any.
    """
    settings = settings or MirrorSettings()
    pixels_before, pixels_after = (
        np.asarray(pixels, float) for pixels in (pixels_before, pixels_after)
    )
    if pixels_before.shape[:1] != pixels_after.shape[:1]:
        raise CalibrationError(
            f"self-calibration: {len(pixels_before)} pixels before and "
            f"{len(pixels_after)} after; give matched ones",
            code="unmatched-features",
        )
    _check_given(pixels_before, pixels_after, clamp, settings, outline)
    rays, p = before.rays(pixels_before), normalised(before.viewer, pixels_after)
    used = rays.valid & np.isfinite(p).all(axis=1)
    if np.count_nonzero(used) < FEWEST:
        raise CalibrationError(
            f"self-calibration: {np.count_nonzero(used)} features are matched; "
            f"{FEWEST} or more are needed",
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
    px = np.median(magnification(before.viewer, pixels_after[used][::10]))
    return SceneMatches(
        p, rays.origins[used], rays.directions[used], used, settings.noise_px / px,
        grid, tuple(flags),
    )  # fmt: skip


def _check_given(pixels_before, pixels_after, clamp, settings, outline):
    """Refuse arrays of another shape, no clamp, and sizes of noise that are none."""
    for what, pixels in (("before", pixels_before), ("after", pixels_after)):
        if pixels.ndim != 2 or pixels.shape[1] != 2:
            raise CalibrationError(
                f"self-calibration: pixels {what} are {pixels.shape}; give (M, 2)",
                code="wrong-shape",
            )
    if clamp is None:
        raise CalibrationError(
            "self-calibration: no clamp is given, which leaves the shape open; give "
            "that of the primary calibration",
            code="no-clamp",
        )
    sizes = [settings.noise_px, *filter(None, [settings.prior_sd])]
    if settings.prior_sd == 0 or not all(0 < size < np.inf for size in sizes):
        raise CalibrationError(
            f"self-calibration: noise_px {settings.noise_px} and prior_sd "
            f"{settings.prior_sd} must be above zero",
            code="bad-setting",
        )
    if outline is not None:
        outline = np.asarray(outline, float)
        if outline.shape != (len(outline), 2) or not np.isfinite(outline).all():
            raise CalibrationError(
                f"self-calibration: outline {outline.shape}; give (L, 2), finite",
                code="wrong-shape",
            )


def linear_update(
    before, pixels_before, pixels_after, clamp, settings=None, *, outline=None
):
    """SelfUpdate by the linear stage alone: the scene at infinity (5.4, 5.28).

    Arguments and errors as `scene_matches`. It takes a deflection for less than it is,
    by about Z / (Z + D) at a depth Z, with the viewer D before the mirror.
    """
    matches = scene_matches(
        before, pixels_before, pixels_after, clamp, settings, outline=outline
    )
    c = _linear(matches, before, clamp)
    camera = camera_of_shape(before.viewer, matches.grid, c, before.quantity)
    return SelfUpdate(camera, np.inf, np.nan, matches.used, matches.flags)


def feedback_updates(
    before, pixels_before, pixels_after, clamp, settings=None, *, outline=None, rounds=5
):
    """SelfUpdates of the loop of 5.4, the linear one first: list, at most 1 + rounds.

    Each round triangulates the scene from the rays before and those of the last shape,
    and refines the shape to these points. Points that come out behind the mirror, or
    whose rays are parallel, are left out. It ends early, and its last one has a flag,
    where a round leaves no shape.
    """
    matches = scene_matches(
        before, pixels_before, pixels_after, clamp, settings, outline=outline
    )
    c = _linear(matches, before, clamp)
    camera = camera_of_shape(before.viewer, matches.grid, c, before.quantity)
    found = [SelfUpdate(camera, np.inf, np.nan, matches.used, matches.flags)]
    pixels_after = np.asarray(pixels_after, float)[matches.used]
    for number in range(1, rounds + 1):
        last = found[-1]
        points, ahead = met_points(
            (matches.origins, matches.directions), last.camera.rays(pixels_after)
        )
        try:
            found.append(_refined(matches, before, clamp, c, points, ahead))
        except CalibrationError as fault:
            text = f"round {number} left no shape: {fault}"
            found[-1] = last._replace(flags=(*last.flags, text))
            break
        c = found[-1].camera.coefficients.ravel(order="F")
    return found


def one_depth_update(
    before, pixels_before, pixels_after, clamp, settings, *, outline=None
):
    """SelfUpdate with the scene at one depth that is found with the shape.

    The depth is counted along the rays before, from the mirror; the one is taken at
    which mirror and features agree best. settings.prior_sd is needed: what tells depth
    from bending is only that a sheet bends evenly. Arguments and errors as
    `scene_matches`; a depth at an end of what is looked for is flagged.
    """
    if settings.prior_sd is None:
        raise CalibrationError(
            "self-calibration: the scene's depth is open without a prior on bending; "
            "give settings with prior_sd",
            code="no-prior",
        )
    matches = scene_matches(
        before, pixels_before, pixels_after, clamp, settings, outline=outline
    )
    start = _linear(matches, before, clamp)
    plane = plane_through(matches.origins)
    prior = bending_prior(matches.grid, before.quantity, plane, settings.prior_sd)

    def fitted(near):
        depth = 1 / max(near / NEAREST_MM, 1 / INFINITY_MM)
        return depth, _fit(matches, before, clamp, start, matches.at(depth), prior)

    found = minimize_scalar(
        lambda near: fitted(near)[1].costs[-1],
        bounds=(0.0, 1.0),
        method="bounded",
        options={"xatol": DEPTH_TOLERANCE},
    )
    depth, fit = fitted(found.x)
    flags = list(matches.flags)
    if not 2 * DEPTH_TOLERANCE < found.x < 1 - 2 * DEPTH_TOLERANCE:
        flags.append("the scene's depth lies at an end of what was looked for")
    return _update(matches, before, fit, depth, flags)


def met_points(first, second):
    """Points (N, 3) nearest to two rays each, and whether (N,) they lie ahead of both.

    first: (origins, directions); second: Rays; (N, 3) each, one frame, mm.
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
        ahead = (s > 0) & (t > 0) & (sine > LEAST_ANGLE**2)
    return points, ahead


def _linear(matches, before, clamp):
    """Coefficients (K,) for a scene at infinity (5.28)."""
    w = np.column_stack([matches.p, np.ones(len(matches.p))])
    normals = reflection_normals(w, matches.directions)
    return shape_with_clamp(matches.p, normals, matches.grid, before.quantity, clamp)


def _refined(matches, before, clamp, c, points, ahead):
    """SelfUpdate to points (N, 3), of those that lie ahead."""
    if np.count_nonzero(ahead) < FEWEST:
        raise CalibrationError(
            f"self-calibration: {np.count_nonzero(ahead)} of {len(ahead)} points lie "
            f"ahead of the mirror; {FEWEST} or more are needed",
            code="too-few-features",
        )
    used = matches.used.copy()
    used[used] = ahead
    kept = matches._replace(
        p=matches.p[ahead],
        origins=matches.origins[ahead],
        directions=matches.directions[ahead],
        used=used,
    )
    fit = _fit(kept, before, clamp, c, points[ahead])
    depth = np.median(np.linalg.norm(points[ahead] - kept.origins, axis=1))
    return _update(kept, before, fit, depth, kept.flags)


def _fit(matches, before, clamp, start, points, prior=None):
    return refine_shape(
        matches.p, points, matches.grid, before.quantity, start,
        noise=matches.noise, clamp=clamp, prior=prior,
    )  # fmt: skip


def _update(matches, before, fit, depth, flags):
    camera = camera_of_shape(
        before.viewer, matches.grid, fit.coefficients, before.quantity
    )
    rms = np.sqrt(np.mean(np.sum(fit.residuals**2, axis=1)) / 2) / fit.sd_mm
    if rms > MISFIT:
        flags = [
            *flags,
            f"features miss their points by {rms:.0f} standard deviations: some are "
            "matched wrongly, or the scene is not as it is taken to be",
        ]
    return SelfUpdate(camera, float(depth), float(rms), matches.used, tuple(flags))
