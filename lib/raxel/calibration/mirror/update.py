"""Dynamic calibration: shape of a mirror after a deflection, from one stage (5.2.2).

A static grid is seen before and after. Its pose is estimated with the previous camera.
The linear stage keeps the previous scene directions (5.28); the refinement minimises
the distances of the grid's points from their rays. Knots are placed anew over the new
image, and the clamp of the primary stage is kept.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.mirror.bundle import MISFIT_SIGMAS
from raxel.calibration.mirror.clamp import (
    TRUNCATION_TOL,
    Clamp,
    FixedLine,
    bending_prior,
    plane_through,
)
from raxel.calibration.mirror.observations import (
    Support,
    clamped_end,
    magnification,
    need_support,
    normalised,
    support_of,
    supported_grid,
    wrong_matches,
)
from raxel.calibration.mirror.refine import (
    MAX_SWING_DEG,
    PRIOR_MM,
    ShapeFit,
    camera_of_shape,
    edge_flags,
    ray_sd,
    refine_shape,
    reflection_normals,
    shape_with_clamp,
)
from raxel.calibration.pose.non_central import (
    NonCentralPose,
    pose_from_non_central_rays,
)
from raxel.calibration.pose.three_point import motion_of_points
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform
from raxel.geometry.spline_grids import spline_grid

# Residuals beyond this many medians belong to wrong matches.
OUTLIER_MEDIANS, MAX_N_ROUNDS = 10.0, 5
# Error of a slope in the linear stage from near scene points, over one interval, mm.
LINEAR_SLOPE_SD_MM = 0.1
MAX_OUTLIER_FRACTION = 0.25
# Ratio of pose residuals with exchanged and given images: below, they are exchanged.
MAX_EXCHANGED_RATIO = 0.5
# Residual of a correct image order; smaller ones are not tested.
EXCHANGE_TEST_MM = 0.1
# Number of features with a common misfit, which averages out less than noise. Chosen on
# eight simulated runs of geometry A, even and uneven by 10 um, that no claim uses.
MISFIT_CORRELATION = 1.5


class MirrorSettings(NamedTuple):
    """Hold the settings of a stage.

    Attributes
    ----------
    shape : tuple of int
        Largest numbers (Kf, Kg) of basis functions.
    degree : tuple of int
        Degrees of the spline along u and v.
    fixed_shape : bool
        Whether `shape` stays where features do not support it. Then a prior must
        determine the rest, or the stage is rejected.
    noise_px : float
        Standard deviation of a feature along each axis, px.
    prior_sd : float or None
        Standard deviation of `bending_prior`, mm; None for no prior.
    truncation : float
        Share of the largest singular value; see `clamped`.
    swinging_deg : float
        A stage is rejected where rays at an end would turn by this angle, degrees, if
        the mirror bent there evenly. Infinite for the published method, which has no
        such test.

    Examples
    --------
    >>> from raxel.calibration import MirrorSettings
    >>> settings = MirrorSettings(shape=(6, 3), prior_sd=0.1)
    >>> settings.shape, settings.degree, settings.noise_px
    ((6, 3), (2, 2), 0.2)
    """

    shape: tuple[int, int] = (7, 3)
    degree: tuple[int, int] = (2, 2)
    fixed_shape: bool = True
    noise_px: float = 0.2
    prior_sd: float | None = None
    truncation: float = TRUNCATION_TOL
    swinging_deg: float = MAX_SWING_DEG


class MirrorUpdate(NamedTuple):
    """Hold the calibration of one stage.

    Attributes
    ----------
    camera, linear : SplineMirrorCamera
        Refined camera, and that of the linear stage.
    fit : ShapeFit
        Fit of the shape.
    residuals : ndarray, shape (N,)
        Distances of the points from their scene rays, mm, NaN where a feature was not
        common.
    misfit : float
        Part of the residuals beyond noise, as the standard deviation of each component
        of a ray's direction, rad.
    widening : float
        Factor of the covariance by the misfit, 1 where noise explains the residuals.
    used : ndarray of bool, shape (N,)
        Features that count.
    wrong : ndarray of bool, shape (N,)
        Features rejected as wrong matches.
    support : Support
        Features per knot interval.
    pose : NonCentralPose or None
        Pose of the grid, None for a known scene.
    swing_deg : float
        Largest rotation of rays at an end, degrees, which `swinging_deg` of the
        settings limits.
    flags : tuple of str
        Warnings, one text each.
    """

    camera: SplineMirrorCamera
    linear: SplineMirrorCamera
    fit: ShapeFit
    residuals: np.ndarray
    misfit: float
    widening: float
    used: np.ndarray
    wrong: np.ndarray
    support: Support
    pose: NonCentralPose | None
    swing_deg: float
    flags: tuple

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Return the covariance (K, K) of vec(C) of `camera`, widened by the misfit."""
        return self.widening * self.fit.covariance

    def ray_sd(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Return the predicted standard deviation of ray directions.

        It combines the covariance with the part of the misfit that no spline can
        follow. Where no feature is near, it includes the covariance alone.

        Parameters
        ----------
        pixels : array_like, shape (N, 2)
            Pixels, px.

        Returns
        -------
        ndarray, shape (N,)
            Standard deviation of each of the two components of a direction, rad.
        """
        camera = self.camera
        known = ray_sd(
            normalised(camera.viewer, pixels),
            camera.grid,
            camera.quantity,
            self.fit.coefficients,
            self.covariance,
        )
        return np.hypot(known, self.misfit)


def update_mirror(
    before: SplineMirrorCamera,
    pixels_before: ArrayLike,
    pixels_after: ArrayLike,
    points: NDArray[np.float64],
    clamp: Clamp | FixedLine,
    settings: MirrorSettings | None = None,
    *,
    outline: ArrayLike | None = None,
    start_pose: NDArray[np.float64] | None = None,
) -> MirrorUpdate:
    """Calibrate a bent mirror from a stationary grid seen before and after.

    Parameters
    ----------
    before : SplineMirrorCamera
        Camera of the previous stage.
    pixels_before, pixels_after : array_like, shape (N, 2)
        Corners, px, NaN where one was not found. All found before give the pose, those
        common to both images the shape.
    points : array_like, shape (N, 2)
        Corners on the grid, mm.
    clamp : Clamp or FixedLine
        Clamp of the primary stage.
    settings : MirrorSettings or None
        Settings; None for the defaults.
    outline : array_like, shape (M, 2), or None
        Pixels that the knots are to span in addition to the features, such as the
        corners of the mirror in the image after.
    start_pose : ndarray, shape (4, 4), or None
        T_camera_grid of the grid where it is nearly known.

    Returns
    -------
    MirrorUpdate
        Camera after the deflection, with its fit.

    Raises
    ------
    CalibrationError
        Names what is missing. ``too-few-features``: too few common corners.
        ``no-feature-at-end``: unsupported knot intervals. ``wrong-matches``: more than
        a quarter of wrong matches. ``exchanged-images``: the images are exchanged.

    References
    ----------
    Thesis 5.2.2, (5.28), (5.29).
    """
    rays, pose, placed, pixels, wrong = _placed_grid(
        before, pixels_before, pixels_after, points, start_pose
    )
    found = _shape(
        before, pixels, placed, rays.directions, clamp, settings or MirrorSettings(),
        outline, (motion_of_points(points, pose.T_camera_grid), pose.covariance),
    )  # fmt: skip
    flags = list(found.flags)
    if pose.ambiguous:
        flags.append("grid pose: the other tilt fits nearly as well")
    wrong |= found.wrong
    common = np.isfinite(np.add(pixels_before, pixels_after)).all(axis=1)
    _not_too_many(wrong, common)
    if wrong.any():
        flags.append(f"{np.count_nonzero(wrong)} wrong matches rejected")
    return found._replace(pose=pose, wrong=wrong, flags=tuple(flags))


def linear_stage(
    before: SplineMirrorCamera,
    pixels_before: ArrayLike,
    pixels_after: ArrayLike,
    points: ArrayLike,
    clamp: Clamp | FixedLine,
    settings: MirrorSettings | None = None,
    *,
    outline: ArrayLike | None = None,
) -> SplineMirrorCamera:
    """Return the camera of the linear stage of `update_mirror`.

    Parameters
    ----------
    before, pixels_before, pixels_after, points, clamp, settings, outline
        See `update_mirror`.

    Returns
    -------
    SplineMirrorCamera
        Camera before the refinement.

    Raises
    ------
    CalibrationError
        Too few common corners, unsupported knot intervals, or exchanged images; codes
        as `update_mirror`.

    References
    ----------
    Thesis (5.28).
    """
    rays, _, _, pixels, _ = _placed_grid(before, pixels_before, pixels_after, points)
    p = normalised(before.viewer, pixels)
    used = _common(p, rays.directions)
    start = _start(
        before, p, rays.directions, used, clamp, settings or MirrorSettings(), outline
    )
    return camera_of_shape(
        before.viewer, start.grid, start.coefficients, before.quantity
    )


def _placed_grid(before, pixels_before, pixels_after, points, start_pose=None):
    """Rays (N,) to the grid, its NonCentralPose, its points (N, 3) in that pose, pixels
    (N, 2) after, NaN where a corner does not count, and wrong matches (N,)."""
    pixels_before, pixels_after, points = (
        np.asarray(a, float) for a in (pixels_before, pixels_after, points)
    )
    wrong = wrong_matches(points, pixels_before) | wrong_matches(points, pixels_after)
    seen = np.where(wrong[:, None], np.nan, pixels_before)
    rays = before.rays(seen)
    pose = pose_from_non_central_rays(rays, points, start_pose)
    wrong |= rays.valid & ~pose.inliers
    _not_exchanged(before, pixels_after, points, wrong, pose)
    counts = np.isfinite(pixels_after).all(axis=1) & ~wrong & pose.inliers
    pixels = np.where(counts[:, None], pixels_after, np.nan)
    return rays, pose, transform(pose.T_camera_grid, on_plane(points)), pixels, wrong


def update_from_scene(
    before: SplineMirrorCamera,
    pixels: ArrayLike,
    scene_points: ArrayLike,
    clamp: Clamp | FixedLine,
    settings: MirrorSettings | None = None,
    *,
    outline: ArrayLike | None = None,
) -> MirrorUpdate:
    """Calibrate a bent mirror from points of a static scene with known positions.

    The linear stage takes the directions from the mirror before, at the same pixels.

    Parameters
    ----------
    before : SplineMirrorCamera
        Camera of the previous stage.
    pixels : array_like, shape (N, 2)
        Features after bending, px, NaN where not detected.
    scene_points : array_like, shape (N, 3)
        Points in the frame of the viewing camera, mm, such as those of an active grid
        in a known pose.
    clamp, settings, outline
        See `update_mirror`.

    Returns
    -------
    MirrorUpdate
        Camera after the deflection; its `pose` is None.

    Raises
    ------
    CalibrationError
        As `update_mirror`.

    References
    ----------
    Thesis 5.5.
    """
    pixels, scene_points = np.asarray(pixels, float), np.asarray(scene_points, float)
    mirror = before.rays(pixels).origins
    mirror = np.where(np.isfinite(mirror), mirror, np.nanmean(mirror, axis=0))
    found = _shape(
        before, pixels, scene_points, scene_points - mirror, clamp,
        settings or MirrorSettings(), outline, (None, None),
    )  # fmt: skip
    _not_too_many(found.wrong, np.isfinite(pixels).all(axis=1))
    return found


def _shape(before, pixels, points, directions, clamp, settings, outline, moved):
    """MirrorUpdate without a pose: linear stage and refinement on the given rows."""
    viewer, quantity = before.viewer, before.quantity
    p = normalised(viewer, pixels)
    used = _common(p, directions)
    start = _start(before, p, directions, used, clamp, settings, outline)
    grid, prior = start.grid, start.prior
    noise = settings.noise_px / np.median(magnification(viewer, pixels[used][::10]))
    c, wrong = start.coefficients, np.zeros(len(p), bool)
    motion, pose_covariance = moved
    for left in reversed(range(MAX_N_ROUNDS + 1)):
        fit = refine_shape(
            p[used], points[used], grid, quantity, c, noise=noise, clamp=clamp,
            prior=prior, point_motion=None if motion is None else motion[used],
            pose_covariance=pose_covariance, truncation=settings.truncation,
        )  # fmt: skip
        errors = np.linalg.norm(fit.residuals, axis=1)
        far = errors > OUTLIER_MEDIANS * max(np.median(errors), fit.sd_mm)
        if not (far.any() and left):
            break
        wrong[np.flatnonzero(used)[far]] = True
        used, c = used & ~wrong, fit.coefficients
    support = support_of(grid, p[used])
    flags = need_support(support, start.clamp_at, prior is not None)
    camera = camera_of_shape(viewer, grid, fit.coefficients, quantity)
    mirror_points = camera.mirror.points(p[used])
    misfit, widening = _beyond_noise(fit, points[used] - mirror_points)
    plane = plane_through(mirror_points)
    evenly = bending_prior(grid, quantity, plane, PRIOR_MM)
    turn, at_edges = edge_flags(
        grid, quantity, fit, widening, evenly, settings.swinging_deg
    )
    flags += at_edges
    residuals = np.full(len(p), np.nan)
    residuals[used] = np.linalg.norm(fit.residuals, axis=1)
    if not fit.converged:
        flags.append("refinement: not converged")
    if far.any():
        flags.append(f"{np.count_nonzero(far)} outlying matches kept")
    return MirrorUpdate(
        camera,
        camera_of_shape(viewer, grid, start.coefficients, quantity),
        fit, residuals, misfit, widening, used, wrong,
        support, None, turn, tuple(flags),
    )  # fmt: skip


class _LinearStart(NamedTuple):
    """Linear stage: SplineGrid, its end at the clamp, PriorRows or None, coefficients
    (K,)."""

    grid: object
    clamp_at: tuple | None
    prior: object
    coefficients: np.ndarray


def _start(before, p, directions, used, clamp, settings, outline):
    """_LinearStart from the features (N, 2) that are `used`."""
    if np.count_nonzero(used) < 3:
        raise CalibrationError(
            f"mirror shape: found {np.count_nonzero(used)} features common to both "
            "images; give images of one static grid",
            code="too-few-features",
        )
    span = [p[used], clamp.points]
    if outline is not None:
        span.append(normalised(before.viewer, np.asarray(outline, float)))
    grid, clamp_at = _knots(np.vstack(span), p[used], clamp, before, settings)
    prior = None
    if settings.prior_sd is not None:
        plane = plane_through(before.mirror.points(_inside(before, p[used])))
        prior = bending_prior(grid, before.quantity, plane, settings.prior_sd)
    c = _linear(p, directions, used, grid, before.quantity, clamp, prior, settings)
    return _LinearStart(grid, clamp_at, prior, c)


def _common(p, directions):
    """Which (N,) features have a pixel after and a scene ray."""
    return np.isfinite(p).all(axis=1) & np.isfinite(directions).all(axis=1)


def _beyond_noise(fit, reach):
    """(misfit in rad, widening of the covariance) of a ShapeFit.

    reach: (n, 3) mm, from the mirror to the points.
    """
    squares = np.sum(fit.residuals**2, axis=1)
    variance = np.mean(squares) / (2 * fit.sd_mm**2)
    if variance <= 1 + MISFIT_SIGMAS / np.sqrt(len(squares)):
        return 0.0, 1.0
    angles = np.mean(squares / np.sum(reach**2, axis=1)) / 2
    return float(np.sqrt((1 - 1 / variance) * angles)), 1 + MISFIT_CORRELATION * (
        variance - 1
    )


def _linear(p, directions, used, grid, quantity, clamp, prior, settings):
    """Coefficients (K,) of the linear stage; a prior is weighted by its size."""
    w = np.column_stack([p[used], np.ones(np.count_nonzero(used))])
    normals = reflection_normals(w, directions[used])
    further = None
    if prior is not None:
        # Slopes over one knot interval are lengths, as those of the prior.
        width = min(np.diff(breaks).min() for breaks in grid.breaks)
        weight = LINEAR_SLOPE_SD_MM / prior.sd / width / prior.mm
        further = weight * prior.rows, weight * prior.values
    return shape_with_clamp(
        p[used], normals, grid, quantity, clamp, truncation=settings.truncation,
        further=further,
    )  # fmt: skip


def _knots(span, p, clamp, before, settings):
    """SplineGrid of the new image, and its end at the clamp."""
    angle, degree = before.grid.angle, settings.degree
    whole = spline_grid(span, settings.shape, degree, angle)
    clamp_at = clamped_end(whole, clamp)
    if settings.fixed_shape:
        need_support(support_of(whole, p), clamp_at, settings.prior_sd is not None)
        return whole, clamp_at
    return supported_grid(span, p, settings.shape, degree, angle, clamp_at), clamp_at


def _not_exchanged(before, pixels_after, points, wrong, pose):
    """Reject an image after that fits the previous camera better than its own."""
    if pose.rms < EXCHANGE_TEST_MM:
        return
    rays = before.rays(np.where(wrong[:, None], np.nan, pixels_after))
    if np.count_nonzero(rays.valid) < np.count_nonzero(pose.inliers) / 2:
        return
    other = pose_from_non_central_rays(rays, points, pose.T_camera_grid)
    sufficient = other.inliers.sum() > pose.inliers.sum() / 2
    if sufficient and other.rms < MAX_EXCHANGED_RATIO * pose.rms:
        raise CalibrationError(
            f"mirror stage: the image after fits the previous camera better "
            f"({other.rms:.3g} mm) than the image before ({pose.rms:.3g} mm); exchange "
            "the images",
            code="exchanged-images",
        )


def _not_too_many(wrong, common):
    found, whole = np.count_nonzero(wrong & common), np.count_nonzero(common)
    if found > MAX_OUTLIER_FRACTION * max(whole, 1):
        raise CalibrationError(
            f"mirror shape: {found} of {whole} matches are outliers; match the two "
            "images of the grid anew",
            code="wrong-matches",
        )


def _inside(before, p):
    """Rows of p (n, 2) inside the camera's knots."""
    inside = before.grid.inside(p)
    return p[inside] if np.count_nonzero(inside) > 3 else before.grid.corners
