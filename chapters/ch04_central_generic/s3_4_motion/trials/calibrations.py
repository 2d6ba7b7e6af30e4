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
from chapters.shared.rigs import rig_named
from raxel.calibration import (
    calibrate_central,
    centroid_directions,
    grid_pose_ransac,
    linear_as_printed,
    linear_cgsp,
    linear_well_conditioned,
    pose_from_rays,
    relaxed_start,
)
from raxel.errors import CalibrationError

LATTICE_PX = 16
LINEAR_GRIDS = 3
THRESHOLD_MM = 1.0  # of RANSAC, ray-point distance
METHODS = ("as printed", "well conditioned", "CGSP")


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
    points = points[:, np.isfinite(points[..., 0]).any(axis=0)]
    return SeenGrids(poses, errors, points, np.isfinite(points).all(axis=2))


def calibrated(method, grids, rng):
    """The CentralCalibration by one of METHODS; CalibrationError where a grid fails."""
    if method == "CGSP":
        first, seen = grids.points[:LINEAR_GRIDS], grids.seen[:LINEAR_GRIDS]
        start = linear_cgsp(first, seen, robust="ransac", rng=rng)
        place = grid_pose_ransac
    else:
        start, place = standard_start(method, grids), pose_from_rays
    found = calibrate_central(
        grids.points, start, place, rng, threshold=THRESHOLD_MM, join=False
    )
    if found.failed:
        raise CalibrationError(next(iter(found.failed.values())))
    return found


def standard_start(method, grids):
    """The adjusted linear stage; as printed it needs rays that meet all grids."""
    points, seen = grids.points[:LINEAR_GRIDS], grids.seen[:LINEAR_GRIDS]
    if method == "well conditioned":
        return relaxed_start(points, linear_well_conditioned(points, seen))
    start = linear_as_printed(*points[:, seen.all(axis=0)])
    return relaxed_start(points, start)


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
        points[:, some], seen[:, some], found.centre, found.T_base_grid
    )
    return out
