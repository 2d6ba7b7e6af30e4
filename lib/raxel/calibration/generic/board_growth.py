"""Growth of a generic calibration: the other boards, their rays, the table.

Common part of the generic methods after centre and poses of three boards or more are
known. The others are added one after the other, with a pose from the known rays and an
adjustment of all poses each time. In the end every pixel that a board covers gets a
ray.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.adjust.bundle import (
    bundle_adjust_fixed_centre,
    ray_point_residuals,
)
from raxel.calibration.linear.cgsp import CgspSolution
from raxel.calibration.linear.standard import LinearSolution
from raxel.calibration.pose.three_point import pose_from_rays
from raxel.cameras.tables.general import GeneralCamera
from raxel.errors import CalibrationError
from raxel.geometry.poses import nearest_rotation, pose, transform

# Ray of every pixel that a board covers: the table at the end of Algorithm 1. Millions
# of pairs of a pixel and a board are summed, with nine numbers stored per pixel.


ROWS_PER_BLOCK = 16  # of the table, handled at once


def ray_table(views, T_base_grid, centre, width, height, weights=None):
    """Directions (height, width, 3) in base axes, NaN where no board covers a pixel.

    views: BoardViews or DenseViews; T_base_grid: (n, 4, 4), their poses; centre: (3,).
    Least squares of the ray-point distances (4.18): the dominant eigenvector of the
    second moments of a pixel's points about the centre, which are summed view by view;
    DenseViews weight their points with 1/sigma^2, and all points of a view count with
    its weight (n,), where given (4.1.3). Memory: nine numbers per pixel.
    """
    sums = np.zeros((height, width, 9))
    weights = np.ones(len(views)) if weights is None else weights
    for view, T, weight in zip(views, T_base_grid, weights, strict=True):
        view.add_moments(sums, T, centre, weight)
    table = np.empty((height, width, 3))
    for start in range(0, height, ROWS_PER_BLOCK):
        rows = slice(start, start + ROWS_PER_BLOCK)
        of_rows = np.ascontiguousarray(np.moveaxis(sums[rows], -1, 0))
        table[rows] = np.moveaxis(_main_axes(*of_rows), 0, -1)
    return table


def _main_axes(xx, yy, zz, xy, xz, yz, x, y, z):
    """Dominant eigenvectors (3, ...) of symmetric matrices, NaN where all is zero.

    Power iteration from (x, y, z); the points of a ray are nearly on one line already.
    """
    for _ in range(2):
        x, y, z = (
            xx * x + xy * y + xz * z,
            xy * x + yy * y + yz * z,
            xz * x + yz * y + zz * z,
        )
        length = np.sqrt(x * x + y * y + z * z)
        length = np.where(length > 0, length, np.nan)
        x, y, z = x / length, y / length, z / length
    return np.stack([x, y, z])


MIN_N_COMMON_SAMPLES = 40  # coarse samples that two boards must share to be compared
N_POSE_SAMPLES = 400  # samples for the estimate of a pose
# Samples within INLIER_THRESHOLD_PX, for a board to be added.
MIN_INLIER_FRACTION = 0.6
INLIER_THRESHOLD_PX = 3.0


class GenericCalibration(NamedTuple):
    """Hold a generic camera and the course of its calibration.

    Attributes
    ----------
    camera : GeneralCamera
        The camera. Its frame has the centre as origin, z close to the ray of the image
        centre and x along the image's u (best fit to the rays of an equidistance
        fisheye).
    centre : ndarray, shape (3,)
        Camera centre in the base board's frame, mm.
    T_base_grid, T_camera_grid : ndarray, shape (m, 4, 4)
        Poses of the boards in `used`.
    used : tuple of int
        Indices of views; those of the linear stage come first, the first is the base.
    left_out : dict
        Reason by index of an excluded view.
    share_with_ray : float
        Fraction of the image's pixels with a ray.
    rms_deg : float
        Root mean square angle between rays and their points, degrees, of the rays that
        two or more of the used boards share, as adjusted.
    linear : LinearSolution or CgspSolution
        Result of the linear stage.
    interpolation : tuple of str
        For each view "homographic" or "smooth", or "none" where every pixel was
        decoded.
    grid_rms_deg : ndarray, shape (m,)
        As `rms_deg`, for each board.
    weights : ndarray, shape (m,)
        Weight of each board's points in the rays.
    pixels_of_one_grid : int
        Number of pixels with a ray from the only board that they see.
    """

    camera: GeneralCamera
    centre: np.ndarray
    T_base_grid: np.ndarray
    T_camera_grid: np.ndarray
    used: list
    left_out: dict
    share_with_ray: float
    rms_deg: float
    linear: LinearSolution | CgspSolution
    interpolation: tuple
    grid_rms_deg: np.ndarray
    weights: np.ndarray
    pixels_of_one_grid: int


class Start(NamedTuple):
    """Boards of the linear stage, and its result."""

    boards: tuple
    linear: LinearSolution | CgspSolution


class Growth(NamedTuple):
    """Added boards, their poses, ray directions of the samples, RMS angle."""

    boards: list
    T_base_grid: np.ndarray
    directions: np.ndarray
    rms: float
    reasons: dict
    start: Start


class AdjustedBoards(NamedTuple):
    """centre (3,), T_base_grid (m, 4, 4) of the added boards, directions (M, 3)."""

    centre: np.ndarray
    T_base_grid: np.ndarray
    directions: np.ndarray


# ------------------------------------------------------------------ the other boards


def grown(samples, start, rng):
    """Growth from three boards to all that agree, most common rays first."""
    centre = start.linear.centre
    boards, poses = list(start.boards), start.linear.T_base_grid
    poses, directions, rms = adjusted(samples, boards, centre, poses)
    waiting = [k for k in range(len(samples.points)) if k not in boards]
    reasons = {}
    while waiting:
        known = np.isfinite(directions[:, 0])
        waiting.sort(key=lambda k: -np.count_nonzero(samples.seen[k] & known))
        threshold = INLIER_THRESHOLD_PX * _radians_per_px(samples, directions)
        for k in waiting:
            usable = samples.seen[k] & known
            T, reasons[k] = _posed(
                directions[usable], samples.points[k, usable], rng, threshold
            )
            if T is not None:
                break
        else:
            break
        waiting.remove(k)
        del reasons[k]
        T[:3, 3] += centre
        boards.append(k)
        poses = np.concatenate([poses, T[None]])
        poses, directions, rms = adjusted(samples, boards, centre, poses)
    return Growth(boards, poses, directions, rms, reasons, start)


def _posed(directions, points, rng, threshold):
    """Pose (4, 4) of one board from known rays, or None and the reason."""
    if len(points) < MIN_N_COMMON_SAMPLES:
        return None, f"shares {len(points)} samples with the known rays (too few)"
    picked = rng.permutation(len(points))[:N_POSE_SAMPLES]
    try:
        found = pose_from_rays(
            directions[picked], points[picked], rng, threshold, metric="angle"
        )
    except CalibrationError as error:
        return None, str(error)
    share = np.mean(found.inliers)
    if share < MIN_INLIER_FRACTION:
        return None, (
            f"its pose agrees with {100 * share:.0f} % of the known rays within "
            f"{INLIER_THRESHOLD_PX:g} px (required: {100 * MIN_INLIER_FRACTION:.0f} %)"
        )
    return found.T_camera_grid.copy(), ""


def adjusted(samples, boards, centre, poses, tolerance=1e-5):
    """Poses, directions (M, 3) and RMS angle after adjustment with the centre fixed."""
    points, seen = samples.points[boards], samples.seen[boards]
    poses, directions, _, _ = bundle_adjust_fixed_centre(
        points, seen, centre, poses, tolerance=tolerance
    )
    sines, shared = _angles(samples, boards, AdjustedBoards(centre, poses, directions))
    return poses, directions, float(np.sqrt(np.mean(sines[shared] ** 2)))


def _angles(samples, boards, found):
    """Sines (m, M) of the angles between rays and points; which rays are shared."""
    points, seen = samples.points[boards], samples.seen[boards]
    residuals = ray_point_residuals(points, seen, *found)
    places = transform(found.T_base_grid, _flat(points))
    lengths = np.linalg.norm(places - found.centre, axis=2)
    shared = seen & (np.sum(seen, axis=0) >= 2)
    return np.linalg.norm(residuals, axis=2) / lengths, shared


def _radians_per_px(samples, directions):
    """Median angle between rays of neighbouring samples, per pixel."""
    known = np.isfinite(directions[:, 0])
    pixels, rays = samples.pixels[known], directions[known]
    order = np.lexsort((pixels[:, 0], pixels[:, 1]))
    pixels, rays = pixels[order], rays[order]
    adjacent = np.all(np.diff(pixels, axis=0) == [samples.step, 0], axis=1)
    gaps = np.linalg.norm(rays[1:] - rays[:-1], axis=1)[adjacent]
    return np.median(gaps) / samples.step


def _flat(points):
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)


# -------------------------------------------------------------------------- the table


def completed(views, width, height, units, samples, growth, found, chosen):
    """GenericCalibration from the chosen boards, as adjusted: table, frame, counts."""
    boards, centre = growth.boards, found.centre
    sines, shared = _angles(samples, boards, found)
    sines = np.where(shared, sines, np.nan)
    rms = np.sqrt(np.nanmean(sines**2, axis=1))
    weights = np.ones(len(boards))
    began = len(growth.start.boards)
    # The error of a pose from rays adds to that of its points.
    weights[began:] = np.minimum(1.0, np.mean(rms[:began] ** 2) / rms[began:] ** 2)
    used = [views[k] for k in boards]
    table = ray_table(used, found.T_base_grid, centre, width, height, weights)
    mask = np.isfinite(table[..., 0])
    rotation = _camera_axes(samples, found.directions, width, height)
    T_camera_base = pose(rotation, -rotation @ centre)
    camera = GeneralCamera(table @ rotation.T, mask, units=units)
    grids = sum(view.covered(width, height).astype(np.uint16) for view in used)
    return GenericCalibration(
        camera,
        centre,
        found.T_base_grid,
        T_camera_base @ found.T_base_grid,
        boards,
        growth.reasons,
        float(np.mean(mask)),
        float(np.degrees(np.sqrt(np.nanmean(sines**2)))),
        growth.start.linear,
        chosen,
        np.degrees(rms),
        weights,
        int(np.count_nonzero(mask & (grids == 1))),
    )


def _camera_axes(samples, directions, width, height):
    """Rotation camera from base: z image centre, x along u, from the known rays.

    The rotation that maps the known rays best to those of an equidistance fisheye with
    the same angle per pixel.
    """
    known = np.isfinite(directions[:, 0])
    offset = samples.pixels[known] - np.array([width - 1, height - 1]) / 2
    radius = np.linalg.norm(offset, axis=1)
    angle = radius * _radians_per_px(samples, directions)
    across = offset / np.maximum(radius, 1e-12)[:, None] * np.sin(angle)[:, None]
    nominal = np.column_stack([across, np.cos(angle)])
    return nearest_rotation(nominal.T @ directions[known])
