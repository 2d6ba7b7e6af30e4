"""Rays that are known to within something: how far each may turn and shift.

What noise in the image does to a ray depends on the camera. In a central one the ray
turns about the centre; before a bent mirror it turns about a point of the caustic that
is another one in each direction. Both are a covariance of origin and direction.
Frame: the camera's; mm, radians.
"""

from typing import NamedTuple

import numpy as np

from raxel.cameras.core.base import Rays, closest_point
from raxel.errors import CalibrationError

STEP_PX = 0.25  # over which a camera's rays are differenced
UNIT = 1e-6  # by which a unit direction may be off
FARTHEST = 1e15  # mm: no camera has a ray that begins there


class NoisyRays(NamedTuple):
    """origins (N, 3), mm; directions (N, 3), unit; covariance (N, 6, 6) of (origin,
    direction), mm and radians. Only what is across the ray counts: an origin may slide
    along it, taking its covariance with it, and nothing changes."""

    origins: np.ndarray
    directions: np.ndarray
    covariance: np.ndarray

    def of(self, which):
        """Those that an index or a mask (N,) selects."""
        return NoisyRays(*(field[which] for field in self))

    def moved(self, shift):
        """The rays in a frame whose origin is at `shift` (3,), with the same axes."""
        return self._replace(origins=self.origins - shift)

    def slid(self, along):
        """The same rays with their origins moved by (N,) mm along them."""
        slide = np.broadcast_to(np.eye(6), (len(along), 6, 6)).copy()
        slide[:, [0, 1, 2], [3, 4, 5]] = along[:, None]
        C = slide @ self.covariance @ np.swapaxes(slide, 1, 2)
        o = self.origins + along[:, None] * self.directions
        return self._replace(origins=o, covariance=C)

    def pivots(self):
        """(points (N, 3), sd (N,)): where each ray is best known, and its turn there.

        The noise that comes nearest to the ray's own while it turns alike to all sides
        about one point of it. sd: radians, along one axis. Raises CalibrationError for
        rays that noise shifts but does not turn, as in an orthographic camera.
        """
        C = self.covariance
        turn = np.trace(C[:, 3:, 3:], axis1=1, axis2=2)
        if not np.all(turn > 0):
            raise CalibrationError(
                f"rays: noise does not turn {np.count_nonzero(~(turn > 0))} of"
                f" {len(turn)}, as in an orthographic camera; give angular_rays"
            )
        along = -np.trace(C[:, :3, 3:], axis1=1, axis2=2) / turn
        return self.origins + along[:, None] * self.directions, np.sqrt(turn / 2)


def angular_rays(rays, sd=1.0, *, about=None):
    """NoisyRays of rays that turn alike to all sides, as those of a central camera.

    rays: anything with origins (N, 3) and unit directions (N, 3), such as the `Rays`
    of a camera; sd: radians, (N,) or one, of each of a direction's two components.
    Where it is not known, leave it: residuals are then radians. about: (3,), each ray
    turns about its own point next to this one; default: the point next to all rays.
    Raises CalibrationError for rays that are not finite or directions not unit.
    """
    o, d = checked_rays(rays)
    if len(o) == 0:
        raise CalibrationError("rays: found none; give those of pixels that have one")
    if about is not None and not _finite(about, (3,)):
        raise CalibrationError("rays: about is no place; give three finite numbers, mm")
    if np.shape(sd) not in ((), (len(o),)):
        raise CalibrationError(
            f"rays: found standard deviations {np.shape(sd)} of {len(o)} rays; give "
            "one, or one for each"
        )
    if about is None:
        about = closest_point(Rays(o, d, np.ones(len(o), bool)))
    back = np.einsum("ni,ni->n", o - np.asarray(about, float), d)[:, None, None]
    sd = np.broadcast_to(np.asarray(sd, float), len(o))
    if not np.all((sd > 0) & np.isfinite(sd)):
        raise CalibrationError(
            "rays: standard deviations must be above zero and finite"
        )
    across = sd[:, None, None] ** 2 * (np.eye(3) - d[:, :, None] * d[:, None, :])
    C = np.block([[back**2 * across, back * across], [back * across, across]])
    return NoisyRays(o, d, C)


def rays_of_pixels(camera, pixels, sd_px=1.0):
    """NoisyRays (N,) that a camera has for pixels (N, 2) with noise.

    sd_px: one, or (N,), of each coordinate, px. The noise goes through the camera:
    origin and direction move together as the pixel does. Raises CalibrationError for
    pixels without a ray, a quarter of a pixel around them included: leave them out.
    """
    pixels = np.asarray(pixels, float)
    if pixels.ndim != 2 or pixels.shape[1] != 2:
        raise CalibrationError(f"rays: found pixels {pixels.shape}; give (N, 2)")
    if np.shape(sd_px) not in ((), (len(pixels),)) or not np.all(
        np.isfinite(sd_px) & (np.asarray(sd_px) > 0)
    ):
        raise CalibrationError(
            f"rays: standard deviations {np.shape(sd_px)} of {len(pixels)} pixels must "
            "be one or one for each, finite and above zero"
        )
    steps = STEP_PX * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    rays = camera.rays((pixels + steps[:, None]).reshape(-1, 2))
    lines = np.concatenate([rays.origins, rays.directions], axis=1)
    middle, *sides = lines.reshape(5, -1, 6)
    seen = rays.valid.reshape(5, -1).all(axis=0)
    if not seen.all():
        raise CalibrationError(
            f"rays: {np.count_nonzero(~seen)} of {len(pixels)} pixels, or places a"
            " quarter of a pixel beside them, have no ray; leave these out"
        )
    by_u, by_v = sides[0] - sides[1], sides[2] - sides[3]
    J = np.stack([by_u, by_v], axis=2) / (2 * STEP_PX)
    J = J * np.broadcast_to(np.asarray(sd_px, float), len(pixels))[:, None, None]
    return NoisyRays(middle[:, :3], middle[:, 3:], J @ np.swapaxes(J, 1, 2))


def with_noise(rays):
    """Rays as they are if they know their noise, else as `angular_rays` of 1 radian."""
    if hasattr(rays, "covariance"):
        o, _ = checked_rays(rays)
        C = rays.covariance
        if not _finite(C, (len(o), 6, 6)) or np.any(np.einsum("nii->ni", C) < 0):
            raise CalibrationError(
                f"rays: found covariance {np.shape(C)} of {len(o)} rays; give (N, 6, "
                "6), finite, without negative variances"
            )
        return rays
    return angular_rays(rays)


def checked_rays(rays):
    """(origins, directions), (N, 3); CalibrationError where they are not finite."""
    if not (hasattr(rays, "origins") and hasattr(rays, "directions")):
        raise CalibrationError(
            f"rays: found {type(rays).__name__}; give what camera.rays(pixels) returns"
        )
    o, d = np.asarray(rays.origins, float), np.asarray(rays.directions, float)
    if o.ndim != 2 or o.shape[1] != 3 or o.shape != d.shape:
        raise CalibrationError(
            f"rays: found origins {o.shape} and directions {d.shape}; give two equal"
            " arrays (N, 3)"
        )
    bad = np.count_nonzero(~np.isfinite(o + d).all(axis=1))
    if bad:
        raise CalibrationError(
            f"rays: {bad} of {len(o)} are not finite; leave pixels without a ray out"
        )
    if len(d) and np.abs(np.linalg.norm(d, axis=1) - 1).max() > UNIT:
        raise CalibrationError("rays: directions are not of length 1; normalise them")
    if np.abs(o).max(initial=0) > FARTHEST:
        raise CalibrationError(
            f"rays: an origin is {np.abs(o).max():.3g} mm away; give origins near the "
            "camera, mm"
        )
    return o, d


def _finite(values, shape):
    return np.shape(values) == shape and bool(np.isfinite(values).all())
