"""Calibrations of the mirror camera with redrawn decoding errors.

Each pixel of a lattice sees up to six grids. The first three determine the centre and
their poses, by the standard method or by CGSP. The others are posed from the rays
known so far.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.trials.stage import RIG
from chapters.shared.decoding_errors import drawn_lattices, lattice_rays, true_lattice
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
SWEPT_METHODS = ("as printed", "CGSP")  # along the sweep of the noise level


class SeenGrids(NamedTuple):
    """Points of the six grids of a run that pixels see.

    T_camera_grid: (6, 4, 4), true; true, points: (6, N, 2) mm, true and decoded points
    of lattice pixels, NaN outside a grid.
    """

    T_camera_grid: np.ndarray
    true: np.ndarray
    points: np.ndarray

    @property
    def seen(self):
        """Return (6, N), whether a pixel sees a grid."""
        return np.isfinite(self.points).all(axis=2)

    def at(self, noise, rng):
        """Return the same with decoding errors of a `DecodingNoise`."""
        return self._replace(points=noise.points(self.points, self.true, rng))


def drawn_grids(errors, rng):
    """Return the SeenGrids of random poses in front of the camera, DecodingErrors."""
    rig = rig_named(RIG)
    size_mm = np.array(rig.target.monitor_mm)
    rays, shape = lattice_rays(rig.camera, LATTICE_PX)
    poses = rig.draw_poses(rng, rig.count)
    true, decoded = (
        points.reshape(len(poses), -1, 2)
        for points in drawn_lattices(
            rays, shape, poses, size_mm, LATTICE_PX, rng, errors
        )
    )
    some = np.isfinite(decoded).all(axis=2).any(axis=0)
    return SeenGrids(poses, true[:, some], decoded[:, some])


def calibrated(method, grids, rng):
    """Return the CentralCalibration by one of METHODS; CalibrationError if it fails."""
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
    """Return the adjusted linear stage; as printed it needs rays of all grids."""
    points, seen = grids.points[:LINEAR_GRIDS], grids.seen[:LINEAR_GRIDS]
    if method == "well conditioned":
        return relaxed_start(points, linear_well_conditioned(points, seen))
    start = linear_as_printed(*points[:, seen.all(axis=0)])
    return relaxed_start(points, start)


def grids_at_pixels(pixels, T_camera_grid, errors, rng):
    """Return the SeenGrids of any pixels (M, 2), with DecodingErrors."""
    rig = rig_named(RIG)
    size_mm = np.array(rig.target.monitor_mm)
    rays = rig.camera.rays(pixels)
    true, decoded = [], []
    for T in T_camera_grid:
        points, cosine = true_lattice(rays, (len(pixels),), T, size_mm)
        bias = errors.bias_at(np.nan_to_num(points), cosine)
        noise = rng.standard_normal(points.shape)
        true.append(points)
        decoded.append(points + bias + noise * errors.sd_at(cosine))
    return SeenGrids(T_camera_grid, np.stack(true), np.stack(decoded))


def table_rays(grids, found):
    """Return unit rays (M, 3), base frame, of a table at the pixels of SeenGrids.

    Each ray joins the centre and the centroid of the points that its pixel sees on the
    calibrated grids; NaN where it sees none.
    """
    seen = grids.seen
    out = np.full((seen.shape[1], 3), np.nan)
    some = seen.any(axis=0)
    out[some] = centroid_directions(
        grids.points[:, some], seen[:, some], found.centre, found.T_base_grid
    )
    return out
