"""What matched rays tell of a motion: rotation, direction, and how far it went.

Rays through one point leave the length of a motion open. Rays that pass it tell the
length, by as much as they do: the nearer a camera is to central, the less. How much is
no matter of one lucky run: the Fisher information of the rays about the motion says it
before any is made, and so do the standard deviations that no unbiased method can beat.

The six numbers are a turn w (3) about the rays' centre, a turn of the direction in
which the centre moves (2), and the logarithm of how far it moves (1): all radians or
shares, so that their eigenvalues can be compared.
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import CalibrationError
from raxel.geometry.poses import tangent_bases
from raxel.multiview.ray_gaps import ONE_POINT, checked_motion, gap_system, matched_rays

# Eigenvalues below this share of the largest are zero: standard deviations are then
# as large as can be told.
LEAST_SHARE = 1e-15
# Lengths are told where they are known to this share, three standard deviations of one
# over the length: noise shifts that alike, whatever the length.
TOLD = 1 / 3


class MotionInformation(NamedTuple):
    """information (6, 6), about (w, direction, log length); baseline: mm, how far the
    centre of the rays moves; centre (3,): that centre, frame of view 1; spread: mm, RMS
    distance of the rays from it."""

    information: np.ndarray
    baseline: float
    centre: np.ndarray
    spread: float

    @property
    def covariance(self):
        """Cramer-Rao bound (6, 6), all six unknown."""
        return inverse_information(self.information)

    @property
    def rotation_sd(self):
        """Radians: root of the summed variances of the three turns."""
        return _root(self.covariance, slice(0, 3))

    @property
    def direction_sd(self):
        """Radians: of the direction of motion, both ways aside together."""
        return _root(self.covariance, slice(3, 5))

    @property
    def scale_sd(self):
        """Share of the motion's length by which that length is uncertain."""
        return _root(self.covariance, slice(5, 6))

    @property
    def scale_told(self):
        """Whether the rays tell the length to better than a third of itself."""
        return self.scale_sd < TOLD

    def __str__(self):
        told = "told" if self.scale_told else "not told"
        return (
            f"rotation to {np.degrees(self.rotation_sd):.2g} deg, direction to"
            f" {np.degrees(self.direction_sd):.2g} deg, length {told}: to"
            f" {100 * self.scale_sd:.2g} % of {self.baseline:.3g} mm"
        )


def motion_information(T_2_1, rays_1, rays_2, *, about=None):
    """MotionInformation of a motion T_2_1 (4, 4) and matched rays with noise.

    rays: NoisyRays (N,), with the noise that they are known to have, or as for
    `angular_rays`, then for 1 radian of noise; those of a scene seen without noise tell
    what any method may expect of it. about: (3,), else the point next to all rays.
    The noise of different rays is taken as independent: an error of calibration is not
    in it. Raises CalibrationError for rays as `matched_rays`, and for a centre at rest.
    """
    pairs = matched_rays(rays_1, rays_2, about=about, fewest=1)
    R, u = pairs.about_centre(checked_motion(T_2_1))
    if not np.linalg.norm(u) > ONE_POINT * np.abs(pairs.rays_1.origins).max():
        raise CalibrationError(
            "motion: the rays' centre does not move, so that no direction or length of"
            " it can be told; give another centre with about=",
            code="no-translation",
        )
    J = gap_system(R, u, pairs)[1]
    D = polar_steps(u)
    return MotionInformation(
        D.T @ (J.T @ J) @ D, float(np.linalg.norm(u)), pairs.centre, pairs.spread
    )


def polar_steps(u):
    """D (6, 6): steps (w, v) of a motion by (w, direction, log length)."""
    length = np.linalg.norm(u)
    D = np.zeros((6, 6))
    D[:3, :3] = np.eye(3)
    D[3:, 3:5] = length * tangent_bases((u / length)[None])[0]
    D[3:, 5] = u
    return D


def inverse_information(information):
    """Its inverse (p, p); what is not told at all gets a variance beyond all others."""
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, V = np.linalg.eigh(information / np.outer(scale, scale))
    values = np.maximum(values, LEAST_SHARE * values[-1])
    return (V / values) @ V.T / np.outer(scale, scale)


def _root(covariance, which):
    return float(np.sqrt(np.trace(covariance[which, which])))
