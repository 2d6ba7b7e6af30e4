"""Calibrations of the mirror camera whose decoding errors are drawn again.

Each pixel of a lattice meets up to six grids. The first three give the centre and
their poses, by the standard method or by CGSP; the others are posed from the rays
that are known by then.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.trials.stage import RIG
from chapters.shared.decoding_errors import drawn_again, lattice_rays, true_lattice
from chapters.shared.grid_rigs import rig_named
from raxel.calibration.adjust.centroid_rays import centroid_directions
from raxel.calibration.adjust.relaxation import relax_poses
from raxel.calibration.linear.cgsp import linear_cgsp
from raxel.calibration.linear.standard import linear_as_printed, linear_well_conditioned
from raxel.calibration.pose.grid_pose import grid_pose_ransac
from raxel.calibration.pose.three_point import pose_from_rays
from raxel.geometry import pose

LATTICE_PX = 16
LINEAR_GRIDS = 3
THRESHOLD_MM = 1.0  # of RANSAC, ray-point distance
METHODS = ("as printed", "well conditioned", "CGSP")


class Calibrated(NamedTuple):
    """centre (3,) and T_base_grid (6, 4, 4), base frame of the first grid."""

    centre: np.ndarray
    T_base_grid: np.ndarray


class SeenGrids(NamedTuple):
    """True poses T_camera_grid (6, 4, 4) of a seed, the decoding errors of its
    pictures, and points (6, N, 2) mm of a lattice of pixels, seen (6, N)."""

    T_camera_grid: np.ndarray
    errors: object
    points: np.ndarray
    seen: np.ndarray


def drawn_grids(errors, rng):
    """Six grids set up by hand before the camera, and what is decoded of them."""
    rig = rig_named(RIG)
    size_mm = np.array(rig.target.monitor_mm)
    rays, shape = lattice_rays(rig.camera, LATTICE_PX)
    poses = rig.draw_poses(rng, rig.count)
    points = []
    for T in poses:
        true, cosine = true_lattice(rays, shape, T, size_mm)
        decoded = drawn_again(errors, true, cosine, rng, LATTICE_PX)
        points.append(decoded.reshape(-1, 2))
    points = np.stack(points)
    used = np.isfinite(points[..., 0]).any(axis=0)
    points = points[:, used]
    seen = np.isfinite(points).all(axis=2)
    return SeenGrids(poses, errors, points, seen)


def calibrated(method, grids, rng):
    """Centre and poses of all grids by one method; see `Calibrated`."""
    points, seen = grids.points, grids.seen
    first = slice(0, LINEAR_GRIDS)
    if method == "CGSP":
        found = linear_cgsp(points[first], seen[first], robust="ransac", rng=rng)
        poses = found.T_base_grid
    else:
        found = standard_start(method, points[first], seen[first])
        common = seen[first].sum(axis=0) >= 2
        poses = relax_poses(
            points[first][:, common],
            seen[first][:, common],
            found.centre,
            found.T_base_grid,
        ).T_base_grid
    rays = centroid_directions(
        np.nan_to_num(points[first]), seen[first], found.centre, poses
    )
    known = seen[first].any(axis=0)
    for k in range(LINEAR_GRIDS, len(points)):
        both = known & seen[k]
        given = rays[both], points[k][both], rng, THRESHOLD_MM
        if method == "CGSP":
            further = grid_pose_ransac(*given).T_camera_grid
        else:
            further = pose_from_rays(*given).T_camera_grid
        further = pose(further[:3, :3], further[:3, 3] + found.centre)
        poses = np.concatenate([poses, further[None]])
    return Calibrated(found.centre, poses)


def standard_start(method, points, seen):
    """The standard linear stage; as printed it needs rays that meet all grids."""
    if method == "well conditioned":
        return linear_well_conditioned(points, seen)
    return linear_as_printed(*points[:, seen.all(axis=0)])


def rays_of_pixels(pixels, grids, found, rng):
    """Unit rays (M, 3), base frame, of a table at pixels (M, 2); NaN without grid.

    Each is the join of the centre and the centroid of the points that its pixel
    sees, decoded with the seed's errors, on the grids as they were calibrated.
    """
    rig = rig_named(RIG)
    size_mm = np.array(rig.target.monitor_mm)
    rays = rig.camera.rays(pixels)
    points = []
    for T in grids.T_camera_grid:
        true, cosine = true_lattice(rays, (len(pixels),), T, size_mm)
        off = grids.errors.bias_at(np.nan_to_num(true), cosine)
        noise = rng.standard_normal(true.shape)
        points.append(true + off + noise * grids.errors.sd_at(cosine))
    points = np.stack(points)
    seen = np.isfinite(points).all(axis=2)
    out = np.full((len(pixels), 3), np.nan)
    some = seen.any(axis=0)
    out[some] = centroid_directions(
        np.nan_to_num(points[:, some]), seen[:, some], *found
    )
    return out
