"""Both generic methods on the same decoded grids, by the protocol of 4.3.1.

Three grids make the linear stage, the others extend what is calibrated. The standard
method adjusts the poses of the three (centre kept) and places further grids by three
points and a refinement; CGSP leaves its linear stage as it is, and places further grids
linearly. Outliers are looked for once, and both get the same points.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from raxel.calibration.adjust.centroid_rays import centroid_directions
from raxel.calibration.adjust.relaxation import relax_poses
from raxel.calibration.linear.cgsp import linear_cgsp
from raxel.calibration.linear.standard import linear_as_printed, linear_well_conditioned
from raxel.calibration.pose.grid_pose import grid_pose_ransac
from raxel.calibration.pose.three_point import pose_from_rays
from raxel.errors import CalibrationError
from raxel.geometry import on_plane, transform

LINEAR = 3  # grids of the linear stage
LINEAR_WEIGHT = 10.0  # of its points, in the rays, against those of further grids
ADJUSTED = 2000  # rays that the poses are adjusted on
POSED = 2000  # points that a further grid is placed by
# RANSAC takes a point for right that lies off its ray by so many times the usual.
THRESHOLD = 5.0
LEAST_THRESHOLD_MM = 0.5
CENTRAL_METHODS = {
    "printed": "standard, as printed",
    "conditioned": "standard, well conditioned",
    "cgsp": "CGSP",
}
# The option of the ledger's question standard_method -> a method.
STANDARD_METHODS = {"as printed": "printed", "well conditioned": "conditioned"}


class CentralCalibration(NamedTuple):
    """centre (3,) and T_base_grid (n, 4, 4) in the frame of the first grid, mm.

    directions: (N, 3) unit, NaN for rays that see no grid in `used`. used: indices of
    the grids that have a pose; failed: {index: reason}.
    """

    centre: np.ndarray
    T_base_grid: np.ndarray
    directions: np.ndarray
    used: list
    failed: dict


def lattice_of(locations, step):
    """Every step-th pixel of decoded grids.

    locations: n arrays (H, W, 2) mm, NaN where nothing was decoded. Returns pixels
    (N, 2), those that see any grid, and points (n, N, 2) float64.
    """
    height, width = locations[0].shape[:2]
    v, u = np.mgrid[step // 2 : height : step, step // 2 : width : step]
    v, u = v.ravel(), u.ravel()
    points = np.stack([location[v, u] for location in locations]).astype(float)
    some = np.isfinite(points[..., 0]).any(axis=0)
    return np.column_stack([u, v])[some].astype(float), points[:, some]


def without_outliers(points, rng):
    """points (n, N, 2) with NaN where three grids of the linear stage disagree.

    A grid's points that no homography relates to the base's are wrong ones.
    """
    found = linear_cgsp(points[:LINEAR], robust="ransac", rng=rng)
    first = points[:LINEAR]
    shared = np.isfinite(first[0, :, 0]) & np.isfinite(first[..., 0])
    kept = points.copy()
    kept[:LINEAR][shared & ~found.inliers] = np.nan
    return kept


def calibrate_central(points, method, rng):
    """The CentralCalibration of one of CENTRAL_METHODS from points (n, N, 2).

    Raises CalibrationError where the linear stage gives nothing; a further grid that
    cannot be placed is left out with the reason.
    """
    seen = np.isfinite(points[..., 0])
    start = _linear(points[:LINEAR], method)
    centre, poses = start.centre, start.T_base_grid
    if method != "cgsp":
        poses = _relaxed(points[:LINEAR], seen[:LINEAR], centre, poses)
    placed, used, failed = list(poses), list(range(LINEAR)), {}
    rays = _rays(points, seen, used, centre, placed)
    threshold = _threshold(points, seen, used, centre, placed, rays)
    for grid in range(LINEAR, len(points)):
        try:
            T = _placed(rays, points[grid], method, rng, threshold)
        except CalibrationError as fault:
            failed[grid] = str(fault)
            continue
        T[:3, 3] += centre
        placed.append(T)
        used.append(grid)
        rays = _rays(points, seen, used, centre, placed)
    return CentralCalibration(centre, np.stack(placed), rays, used, failed)


def _relaxed(points, seen, centre, poses):
    """Poses (3, 4, 4) after the thesis's adjustment, on ADJUSTED rays or so."""
    shared = np.flatnonzero(np.sum(seen, axis=0) >= 2)
    chosen = shared[:: max(1, len(shared) // ADJUSTED)]
    return relax_poses(points[:, chosen], seen[:, chosen], centre, poses).T_base_grid


def _linear(points, method):
    """The linear stage; the printed one needs rays that see all three grids."""
    if method == "printed":
        all_three = np.isfinite(points[..., 0]).all(axis=0)
        return linear_as_printed(*points[:, all_three], tz="corrected")
    if method == "conditioned":
        return linear_well_conditioned(points)
    return linear_cgsp(points)


def _rays(points, seen, used, centre, placed):
    """Rays by the weighted centroid (4.1.3), the linear stage's points ahead."""
    weights = np.where(np.array(used) < LINEAR, LINEAR_WEIGHT, 1.0)
    return centroid_directions(
        points[used], seen[used], centre, np.stack(placed), weights
    )


def _threshold(points, seen, used, centre, placed, rays):
    """mm: a multiple of the median ray-point distance that is there already."""
    distances = ray_point_distances(points, seen, used, centre, placed, rays)
    return max(THRESHOLD * float(np.median(distances)), LEAST_THRESHOLD_MM)


def ray_point_distances(points, seen, used, centre, T_base_grid, rays):
    """Distances (M,) mm of all points of the grids in ``used`` from their rays (4.18).

    T_base_grid: (len(used), 4, 4). Of rays that two or more of these grids share.
    """
    shared = seen[used] & (np.sum(seen[used], axis=0) >= 2)
    found = []
    for grid, T, here in zip(used, T_base_grid, shared, strict=True):
        flat = on_plane(points[grid, here])
        reach = transform(T, flat) - centre
        u = rays[here]
        along = np.sum(reach * u, axis=1, keepdims=True)
        found.append(np.linalg.norm(reach - along * u, axis=1))
    return np.concatenate(found)


def _placed(rays, points, method, rng, threshold):
    """Pose (4, 4) of a further grid, the centre as origin, from known rays."""
    known = np.flatnonzero(np.isfinite(rays[:, 0] + points[:, 0]))
    if len(known) > POSED:
        known = np.sort(rng.choice(known, POSED, replace=False))
    estimate = grid_pose_ransac if method == "cgsp" else pose_from_rays
    return estimate(rays[known], points[known], rng, threshold).T_camera_grid.copy()
