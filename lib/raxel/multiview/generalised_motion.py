"""Motion of a general camera from matched rays, best fit: length included.

What is minimised is how far the rays of each pair miss each other, in standard
deviations (`ray_gaps`). Rays that miss their common centre tell the length of the
motion (thesis 5.3.5); how well, `GeneralisedPose.scale_sd` says. Where they do not, it
is given.

T_2_1 maps points of view 1 to view 2, X_2 = R X_1 + t, both in the frame of the camera;
mm.
Source: Pless 2003, doi:10.1109/CVPR.2003.1211520 (motion of rays without a centre).
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import CalibrationError
from raxel.geometry.least_squares import descend, gauss_newton
from raxel.multiview.motion_information import TOLD, inverse_information
from raxel.multiview.ray_gaps import (
    FEWEST,
    along_sphere,
    checked_motion,
    gap_system,
    matched_rays,
    moved_motion,
    share_ahead,
)

AT_REST = 1e-12  # a sum of squares that falls by a smaller share is at rest
ROUNDING = 1e-15  # radians, of exact pairs


class GeneralisedPose(NamedTuple):
    """T_2_1 (4, 4), mm; inliers: (N,) bool, the pairs it was found from; rms: of their
    `gaps`, in standard deviations of the rays, or radians if these are not known;
    ahead: share of the inliers that meet ahead along both rays. covariance (6, 6) of
    (w, v): the motion is exp([w]x) R about `centre` (3,), and the centre's shift u + v;
    by the scatter of the gaps, NaN where there are no more pairs than unknowns, none
    along u if the length was given. baseline: mm,
    |u|; spread: mm, RMS distance of the rays from the centre. margin: of the linear
    system, how far the second least singular value is above the least; near 1 the
    motion is open.
    """

    T_2_1: np.ndarray
    inliers: np.ndarray
    rms: float
    ahead: float
    covariance: np.ndarray
    centre: np.ndarray
    spread: float
    margin: float

    @property
    def shift(self):
        """u (3,): of the rays' centre, frame of view 2."""
        T = self.T_2_1
        return T[:3, 3] - self.centre + T[:3, :3] @ self.centre

    @property
    def baseline(self):
        """How far the rays' centre moves, mm."""
        return float(np.linalg.norm(self.shift))

    @property
    def scale_sd(self):
        """Standard deviation of the motion's length, as a share of it; 0
        where it was given."""
        along = self.shift / self.baseline
        variance = max(along @ self.covariance[3:, 3:] @ along, 0.0)
        return float(np.sqrt(variance) / self.baseline)

    @property
    def rotation_sd(self):
        """Radians: root of the summed variances of the three turns."""
        return float(np.sqrt(np.trace(self.covariance[:3, :3])))

    @property
    def scale_told(self):
        """Whether the length is known to better than a third of itself."""
        return self.scale_sd < TOLD


def refine_generalised_pose(rays_1, rays_2, start, *, length=None, most=50):
    """The motion that minimises the sum of squared `gaps`.

    rays: NoisyRays (N,), or as for `angular_rays`, N >= 6 right pairs; start:
    GeneralisedPose, whose inliers are used where they are as many as the pairs, or
    T_2_1 (4, 4); length: mm, of the shift of the rays' centre where it is known. Rays
    that all pass through one point need it. Levenberg-Marquardt on se(3), analytic
    Jacobian. Returns GeneralisedPose. Raises CalibrationError for rays as
    `matched_rays`, and where the length is open or there is no motion to find.
    """
    pairs = matched_rays(rays_1, rays_2)
    inliers = np.ones(len(pairs.rays_1.origins), bool)
    margin, T = np.nan, start
    if isinstance(start, GeneralisedPose):
        T, margin = start.T_2_1, start.margin
        if len(start.inliers) == len(inliers):
            inliers = start.inliers
    R, u = pairs.about_centre(checked_motion(T))
    return adjusted(pairs, inliers, R, u, length, margin, most)


def adjusted(pairs, inliers, R, u, length=None, margin=np.nan, most=50):
    """GeneralisedPose from a start R, u about the centre of all MatchedRays."""
    need_length(pairs, length)
    used = pairs.of(inliers)
    if np.count_nonzero(inliers) < FEWEST:
        raise CalibrationError(
            f"motion: {np.count_nonzero(inliers)} right pairs of {len(inliers)};"
            f" {FEWEST} or more are needed",
            code="too-few-rays",
        )
    if length is not None:
        u = to_length(u, length)

    def steps(state):
        return np.eye(6) if length is None else along_sphere(state[1])

    def evaluate(state):
        residuals, jacobian = gap_system(*state, used)
        return gauss_newton(residuals, lambda: jacobian @ steps(state))

    def move(state, step):
        R, u = moved_motion(state, steps(state) @ step)
        return R, u if length is None else to_length(u, length)

    smallest = min(rays.pivots()[1].min() for rays in (used.rays_1, used.rays_2))
    (R, u), _, _ = descend(
        evaluate,
        move,
        (R, u),
        iterations=most,
        tolerance=AT_REST,
        rounding=len(used.rays_1.origins) * (ROUNDING / smallest) ** 2,
    )
    return described(pairs, inliers, R, u, margin, steps((R, u)))


def described(pairs, inliers, R, u, margin, steps):
    """GeneralisedPose of a motion R, u about the centre of MatchedRays.

    steps: (6, p), the steps that were free.
    """
    used = pairs.of(inliers)
    residuals, jacobian = gap_system(R, u, used)
    J = jacobian @ steps
    freedom = len(residuals) - J.shape[1]
    variance = residuals @ residuals / freedom if freedom > 0 else np.nan
    known = variance * inverse_information(J.T @ J)
    return GeneralisedPose(
        pairs.whole(R, u),
        inliers,
        float(np.sqrt(np.mean(residuals**2))),
        share_ahead(R, u, used),
        steps @ known @ steps.T,
        pairs.centre,
        pairs.spread,
        float(margin),
    )


def need_length(pairs, length):
    """Refuse rays through one point without a length, and a length that is none."""
    if length is None and not pairs.spread:
        raise CalibrationError(
            "motion: all rays pass through one point, so nothing tells how long the"
            " motion is; give its length, or use raxel.multiview.epipolar",
            code="no-scale",
        )
    if length is not None and not (np.isfinite(length) and length > 0):
        raise CalibrationError(
            f"motion: found length {length}; give one above 0 mm", code="length"
        )


def to_length(u, length):
    """u (3,) stretched to a length; along z where it has none."""
    norm = np.linalg.norm(u)
    return u * (length / norm) if norm > 0 else np.array([0.0, 0.0, length])
