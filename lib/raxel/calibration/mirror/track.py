"""Tracking of a flexible mirror through a video of a static grid.

Between two images of a video the mirror bends little. The previous shape is the initial
one, the grid's pose and the knots stay, and constant terms are computed once. Each
image is fitted independently, so errors do not accumulate. Corners are given, or
tracked from the previous image.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.mirror.clamp import (
    Clamp,
    FixedLine,
    bending_prior,
    clamped,
    plane_through,
    soft_clamp,
)
from raxel.calibration.mirror.observations import (
    MIN_N_POSE_CORNERS,
    RayPoints,
    clamped_end,
    magnification,
    need_support,
    normalised,
    support_of,
)
from raxel.calibration.mirror.refine import residual_sd, stacked
from raxel.calibration.mirror.update import MirrorSettings
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.features.video import TrackedCorners, track_corners
from raxel.geometry.least_squares import damped_step

# Convergence: change of the residuals in standard deviations.
STEP_TOL_SIGMAS, MAX_N_STEPS = 1e-3, 6
# Outlier threshold in medians of the residuals, and minimum median in mm.
OUTLIER_MEDIANS, MIN_MEDIAN_MM, MAX_N_ROUNDS = 6.0, 1e-6, 6


class Followed(NamedTuple):
    """Hold the shape of a mirror in one image of a sequence.

    Attributes
    ----------
    coefficients : ndarray, shape (K,)
        Coefficients of this image.
    residuals : ndarray, shape (N,)
        Distances from the scene rays, mm, NaN for features that do not count.
    used : ndarray of bool, shape (N,)
        Features that count.
    settled : bool
        Whether the last step was small.
    flags : tuple of str
        Warnings, one text each.
    """

    coefficients: np.ndarray
    residuals: np.ndarray
    used: np.ndarray
    settled: bool
    flags: tuple


class MirrorTracker:
    """Track a mirror from a stage that `update_mirror` or a primary stage calibrated.

    Parameters
    ----------
    camera : SplineMirrorCamera
        Camera whose knots span all that will be visible.
    scene_points : array_like, shape (N, 3)
        Features in the frame of the viewing camera, mm.
    clamp : Clamp or FixedLine
        Clamp of the primary stage.
    settings : MirrorSettings
        Settings of the fit.
    """

    def __init__(
        self,
        camera: SplineMirrorCamera,
        scene_points: ArrayLike,
        clamp: Clamp | FixedLine,
        settings: MirrorSettings,
    ) -> None:
        self.camera, self.points = camera, np.asarray(scene_points, float)
        self.coefficients = camera.coefficients.ravel("F")
        self._settings = settings
        grid, quantity = camera.grid, camera.quantity
        self._clamp_at = clamped_end(grid, clamp)
        soft = soft_clamp(grid, clamp)
        self._space = clamped(grid, clamp if soft is None else None)
        prior = None
        if settings.prior_sd is not None:
            plane = plane_through(camera.mirror.points(grid.corners))
            prior = bending_prior(grid, quantity, plane, settings.prior_sd)
        parts = [part for part in (soft, prior) if part is not None]
        self._rows, self._values = stacked(parts, grid.size)

    def follow(self, pixels: ArrayLike) -> Followed:
        """Fit the shape to the features of the next image.

        The tracker's shape becomes the new one.

        Parameters
        ----------
        pixels : array_like, shape (N, 2)
            Features, px, NaN where one is not detected.

        Returns
        -------
        Followed
            Shape of this image.

        Raises
        ------
        CalibrationError
            ``too-few-features``: too few features. ``outside-knots``: most lie outside
            the knots; then place the knots anew with `update_mirror`.
            ``shape-diverged``: the mirror moved too far.
        """
        camera = self.camera
        p = normalised(camera.viewer, pixels)
        used = camera.grid.inside(p)
        if 2 * np.count_nonzero(used) < np.count_nonzero(np.isfinite(p[:, 0])):
            raise CalibrationError(
                "mirror in motion: most features are outside the knots; calibrate a "
                "stage to place new knots",
                code="outside-knots",
            )
        if np.count_nonzero(used) < MIN_N_POSE_CORNERS:
            raise CalibrationError(
                f"mirror in motion: found {np.count_nonzero(used)} features; detect "
                f"{MIN_N_POSE_CORNERS} or more in the whole image",
                code="too-few-features",
            )
        support = support_of(camera.grid, p[used])
        flags = need_support(support, self._clamp_at, len(self._rows) > 0)
        noise = self._settings.noise_px / np.median(
            magnification(camera.viewer, np.asarray(pixels)[used][::20])
        )
        used, c, errors, settled = self._right_ones(p, used, noise)
        left = np.count_nonzero(camera.grid.inside(p)) - np.count_nonzero(used)
        if left:
            flags.append(f"{left} wrong matches rejected")
        if not settled:
            flags.append("refinement: not converged")
        self.coefficients = c
        residuals = np.full(len(p), np.nan)
        residuals[used] = errors
        return Followed(c, residuals, used, settled, tuple(flags))

    def camera_now(self) -> SplineMirrorCamera:
        """Return the camera of the last image."""
        return SplineMirrorCamera.on_grid(
            self.camera.viewer, self.camera.grid, self.coefficients,
            self.camera.quantity,
        )  # fmt: skip

    def _right_ones(self, p, used, noise):
        """Features that count, and the result of `_fitted` for them."""
        for _ in range(MAX_N_ROUNDS):
            rays = RayPoints(p[used], self.camera.grid, self.camera.quantity)
            c, errors, settled = self._fitted(rays, self.points[used], noise)
            far = errors > OUTLIER_MEDIANS * max(np.median(errors), MIN_MEDIAN_MM)
            if not far.any():
                break
            used = used.copy()
            used[np.flatnonzero(used)[far]] = False
        return used, c, errors[~far], settled

    def _fitted(self, rays, points, noise):
        """Coefficients, distances (n,) mm, and whether the last step was small."""
        space, size = self._space, len(self.coefficients)
        free = space.free(self.coefficients)
        c = space.coefficients(free)
        sd = residual_sd(rays, c, points, noise)
        settled = False
        for _ in range(MAX_N_STEPS):
            r = rays.residuals(c, points) / sd
            J = rays.jacobian(c, points).reshape(-1, size) / sd
            J = np.vstack([J, self._rows]) @ space.directions
            whole = np.concatenate([r.ravel(), self._rows @ c - self._values])
            step = damped_step(J.T @ J, J.T @ whole, 1e-9)
            free = free + step
            c = space.coefficients(free)
            if not rays.in_front(c):
                raise CalibrationError(
                    "mirror in motion: the fit diverged (large motion since the last "
                    "image); calibrate a new stage",
                    code="shape-diverged",
                )
            settled = np.linalg.norm(J @ step) <= STEP_TOL_SIGMAS * np.sqrt(len(J))
            if settled:
                break
        return c, np.linalg.norm(rays.residuals(c, points), axis=1), settled


class TrackedImage(NamedTuple):
    """Hold the corners of an image and the shape that follows from them.

    Attributes
    ----------
    corners : TrackedCorners
        Corners of the image.
    shape : Followed
        Shape of the mirror.
    """

    corners: TrackedCorners
    shape: Followed


class VideoTracker:
    """Track a mirror through a video, with corners detected in its images.

    Parameters
    ----------
    tracker : MirrorTracker
        Tracker whose scene points are the corners of one chessboard, row by row.
    image : ndarray of uint8, shape (H, W)
        First image, with the mirror in the tracker's state.
    corners : array_like, shape (rows * columns, 2)
        Corners in the first image, px, NaN for those not detected.
    columns, rows : int
        Numbers of corners of the chessboard.
    """

    def __init__(
        self,
        tracker: MirrorTracker,
        image: NDArray[np.uint8],
        corners: ArrayLike,
        columns: int,
        rows: int,
    ) -> None:
        self.tracker, self.image = tracker, image
        self.corners, self._size = np.array(corners, float), (columns, rows)

    def follow(self, image: NDArray[np.uint8]) -> TrackedImage:
        """Track the corners and the shape to the next image.

        After an error the sequence stays at the previous image. If all corners are
        lost, begin anew with corners detected in the whole image.

        Parameters
        ----------
        image : ndarray of uint8, shape (H, W)
            Next image, not more than half a square from the previous one.

        Returns
        -------
        TrackedImage
            Corners and shape.

        Raises
        ------
        InputError
            The image does not fit.
        CalibrationError
            As `MirrorTracker.follow`.
        """
        found = track_corners(self.image, image, self.corners, *self._size)
        shape = self.tracker.follow(found.corners)
        self.image, self.corners = image, found.corners
        return TrackedImage(found, shape)
