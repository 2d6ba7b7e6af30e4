"""Points of a flat target in the picture of a central camera, and its pose from them.

Image points are normalised: (x/z, y/z) of the viewing ray, without distortion. Their
errors are told in pixels, by the local magnification of the camera.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.pose.grid_pose import refine_pose_angular
from raxel.calibration.pose.three_point import placed_points
from raxel.errors import CalibrationError, InputError
from raxel.geometry.homography import homography_dlt
from raxel.geometry.plane_pose import pose_from_homography
from raxel.geometry.poses import nearest_rotation, pose

FEWEST = 6  # corners: a pose's six numbers from twelve
LEAST_SD_PX = 1e-3  # no corner is known better, also where it is true by construction


class Sighting(NamedTuple):
    """image (N, 2), normalised; scale (N,) px for a unit of it; points (N, 2) of the
    target, mm; sd (N,) px, of each corner along an axis, NaN where unknown."""

    image: np.ndarray
    scale: np.ndarray
    points: np.ndarray
    sd: np.ndarray
    unknown_sd: bool = False

    def alike(self):
        """The same, with all corners equally certain, as is unknown how much."""
        return self._replace(sd=np.ones(len(self.points)), unknown_sd=True)

    def residuals(self, p):
        """(2N,) px over sd: found less projected, of points p (N, 3) ahead."""
        with np.errstate(divide="ignore", invalid="ignore"):
            projected = np.where(p[:, 2:] > 0, p[:, :2] / p[:, 2:], np.nan)
        return ((self.image - projected) * (self.scale / self.sd)[:, None]).ravel()

    def change(self, p, motion):
        """(2N, k): change of the residuals as points p move, motion (N, 3, k)."""
        depth = p[:, 2]
        weight = -self.scale / self.sd / depth
        projected = (p[:, :2] / depth[:, None])[:, :, None]
        across = motion[:, :2] - projected * motion[:, 2:]
        return (weight[:, None, None] * across).reshape(2 * len(p), -1)


def normalised(viewer, pixels):
    """(x/z, y/z) (N, 2) of pixels' viewing rays, NaN where there is none ahead."""
    d = viewer.rays(pixels).directions
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(d[:, 2:] > 0, d[:, :2] / d[:, 2:], np.nan)


def magnification(viewer, pixels):
    """Pixels (N,) for a unit of `normalised`, the mean over directions, by area."""
    step = 0.5 * np.eye(2)
    ends = np.concatenate([np.asarray(pixels) + s for s in (*step, *-step)])
    ends = normalised(viewer, ends).reshape(2, 2, -1, 2)
    across, down = ends[0] - ends[1]
    area = np.abs(across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0])
    return 1 / np.sqrt(area)


def sighting(viewer, view, name):
    """Sighting of the corners of a view that were found and have a viewing ray.

    Raises CalibrationError for fewer than FEWEST.
    """
    pixels, points = np.asarray(view.pixels, float), np.asarray(view.points, float)
    sd = np.full(len(pixels), np.nan) if view.sd is None else np.asarray(view.sd, float)
    image = normalised(viewer, pixels)
    found = np.isfinite(image).all(axis=1)
    if np.count_nonzero(found) < FEWEST:
        raise CalibrationError(
            f"{name}: found {np.count_nonzero(found)} corners; at least {FEWEST} are "
            "needed",
            code="too-few-corners",
        )
    scale = magnification(viewer, pixels[found])
    return Sighting(
        image[found], scale, points[found], np.maximum(sd[found], LEAST_SD_PX)
    )


def seen_pose(seen):
    """T_camera_grid (4, 4), right-handed, of the target of a Sighting.

    From the homography, then by least angles. A flat target that is small or far has a
    second minimum, of the opposite tilt: both are tried. Raises CalibrationError for
    points that leave the pose open.
    """
    rays = np.column_stack([seen.image, np.ones(len(seen.image))])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    try:
        first = pose_from_homography(homography_dlt(seen.points, seen.image))
    except InputError as error:
        raise CalibrationError(f"pose of a board: {error}", code=error.code) from None
    starts = first, other_tilt(first, seen.points)
    found = [refine_pose_angular(rays, seen.points, T) for T in starts]
    return min(found, key=lambda refined: refined.rms).T_camera_grid


def other_tilt(T_camera_grid, points):
    """The pose (4, 4) that looks alike from far: tilted the other way to the line of
    sight, about the middle of points (N, 2)."""
    middle = points.mean(axis=0)[None]
    at = placed_points(middle, T_camera_grid)[0]
    sight = at / np.linalg.norm(at)
    axes = T_camera_grid[:3, :2]
    R = nearest_rotation(axes - 2 * np.outer(sight, sight @ axes))
    return pose(R, at - R[:, :2] @ middle[0])
