"""Both generic methods on the same decoded grids, and their rays on a lattice (4.3.1).

The standard method adjusts the poses of three grids (centre kept) and places further
grids by three points and a refinement. CGSP does not adjust its linear stage, and
places further grids linearly. Outliers are detected once, and both get the same
points.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chapters.shared.active_grid_sets import seen_grids, true_camera, true_poses
from chapters.shared.bench_noise import NOISES
from chapters.shared.decoding_errors import drawn_again, lattice_rays, true_lattice
from chapters.shared.methods import LINEAR_STAGES
from raxel.calibration import (
    calibrate_central,
    grid_pose_ransac,
    linear_cgsp,
    pose_from_rays,
    relaxed_start,
)
from raxel.cameras import GeneralCamera
from raxel.errors import CalibrationError
from repro.run.rendered import rendered_set

LINEAR = 3  # grids of the linear stage
# weight: of the linear stage's points in the rays, against those of further grids;
# most: points used for the pose of a further grid.
PROTOCOL = {"weight": 10.0, "most": 2000}
ADJUSTED = 2000  # rays that the poses are adjusted on
# Linear stages by their names in these trials.
SWEPT_METHODS = ("printed", "cgsp")  # along the sweep of the noise level
METHODS = {"printed": "as_printed", "conditioned": "well_conditioned", "cgsp": "cgsp"}


def without_outliers(points, rng):
    """Return points (n, N, 2) with NaN where the grids of the linear stage disagree.

    Points of a grid that fit no homography to the base grid are outliers.
    """
    first = points[:LINEAR]
    found = linear_cgsp(first, robust="ransac", rng=rng)
    shared = np.isfinite(first[0, :, 0]) & np.isfinite(first[..., 0])
    kept = points.copy()
    kept[:LINEAR][shared & ~found.inliers] = np.nan
    return kept


def by_protocol(points, method, rng):
    """Return the CentralCalibration of one of METHODS from points (n, N, 2).

    Raises CalibrationError where the linear stage fails. As printed, it needs
    rays that see all three grids.
    """
    first = points[:LINEAR]
    seen = np.isfinite(first[..., 0]).all(axis=0)
    given = first[:, seen] if method == "printed" else first
    start = LINEAR_STAGES[METHODS[method]](given)
    if method == "cgsp":
        return calibrate_central(points, start, grid_pose_ransac, rng, **PROTOCOL)
    start = relaxed_start(first, start, ADJUSTED)
    return calibrate_central(points, start, pose_from_rays, rng, **PROTOCOL)


STEP = {"quick": 2, "full": 6}  # px between neighbours of the lattice of rays
ALL_SETS = {
    "quick": (
        "onevr-d70-small/0",
        "coolpix-4500-fce8-small/0",
        "onevr-d70-boards-small/0",
        "coolpix-4500-fce8-boards-small/0",
    ),
    "full": (
        "onevr-d70/0",
        "onevr-d70/1",
        "onevr-d70/2",
        "coolpix-4500-fce8/0",
        "coolpix-4500-fce8/1",
        "coolpix-4500-fce8/2",
        "onevr-d70-boards/0",
        "onevr-d70-boards/1",
        "onevr-d70-boards/2",
        "coolpix-4500-fce8-boards/0",
        "coolpix-4500-fce8-boards/1",
        "coolpix-4500-fce8-boards/2",
    ),
}


class Lattice(NamedTuple):
    """Every step-th pixel of an image in both directions, from ``step // 2``.

    shape: (h, w); pixels: (N, 2), the nodes that see at least one grid.
    """

    step: int
    shape: tuple
    pixels: np.ndarray

    def places(self, pixels):
        """Return lattice positions (N, 2), with nodes at whole numbers."""
        return (np.asarray(pixels, float) - self.step // 2) / self.step

    def table(self, values):
        """Return node values (N, ...) as an array (h, w, ...), NaN elsewhere."""
        u, v = self.places(self.pixels).astype(int).T
        table = np.full((*self.shape, *np.shape(values)[1:]), np.nan)
        table[v, u] = values
        return table


class LatticeRays(NamedTuple):
    """A method's rays on a lattice, and the grids they come from.

    camera: GeneralCamera over the lattice's nodes, in the true camera's axes;
    calibration: CentralCalibration; sources (h, w): a bit for every grid used.
    """

    camera: GeneralCamera
    calibration: object
    sources: np.ndarray


def decoded_points(folder, step, rng, noises=NOISES):
    """Return (Lattice, {noise: points (n, N, 2)}) of a rendered and decoded set.

    noises: {name: DecodingNoise}.
    """
    nodes = np.s_[step // 2 :: step, step // 2 :: step]
    decoded, true = [], []
    for grid in seen_grids(folder):
        seen = grid.decoded.mask[nodes][..., None]
        decoded.append(np.where(seen, grid.decoded.location[nodes], np.nan))
        true.append(grid.points[nodes])
    return _at_noises(decoded, true, step, rng, noises)


@lru_cache(maxsize=4)
def true_lattices(rig, seed, step, size_mm):
    """Return `true_lattice` of every grid of a rendered set."""
    folder = rendered_set(rig, seed)
    rays = lattice_rays(true_camera(folder), step)
    return [true_lattice(*rays, T, size_mm) for T in true_poses(folder).values()]


def redrawn_points(rig, seed, step, rng, errors, noises, size_mm=(376.9, 301.5)):
    """Return the same as `decoded_points`, with redrawn DecodingErrors.

    The errors are drawn once, and scaled for the thesis-matched level.
    """
    decoded, true = [], []
    for points, cosine in true_lattices(rig, seed, step, size_mm):
        decoded.append(drawn_again(errors, points, cosine, rng, step))
        true.append(points)
    return _at_noises(decoded, true, step, rng, noises)


def _at_noises(decoded, true, step, rng, noises):
    """Return (Lattice, {noise: points (n, N, 2)}) of lattice tables (n, h, w, 2)."""
    shape = decoded[0].shape[:2]
    decoded, true = (
        np.reshape(tables, (len(tables), -1, 2)).astype(float)
        for tables in (decoded, true)
    )
    some = np.isfinite(decoded[..., 0]).any(axis=0)
    v, u = np.divmod(np.flatnonzero(some), shape[1])
    lattice = Lattice(step, shape, np.column_stack([u, v]) * float(step) + step // 2)
    points = {
        name: without_outliers(noise.points(decoded[:, some], true[:, some], rng), rng)
        for name, noise in noises.items()
    }
    return lattice, points


def calibrated(folder, lattice, points, rng, methods=tuple(METHODS)):
    """Return {method: LatticeRays, or the code of its error}.

    The true pose of the base grid rotates the rays to the camera's axes. Only the
    drawn view and the vertical depend on it.
    """
    R_camera_base = next(iter(true_poses(folder).values()))[:3, :3]
    out = {}
    for method in methods:
        try:
            found = by_protocol(points, method, rng)
            out[method] = on_lattice(lattice, points, found, R_camera_base)
        except CalibrationError as fault:
            out[method] = fault.code
    return out


def on_lattice(lattice, points, found, R_camera_base):
    """Return the LatticeRays of a CentralCalibration."""
    table = lattice.table(found.directions @ R_camera_base.T)
    mask = np.isfinite(table[..., 0])
    bits = np.isfinite(points[found.used][..., 0]).T @ (1 << np.array(found.used))
    camera = GeneralCamera(np.where(mask[..., None], table, 1.0), mask)
    return LatticeRays(camera, found, lattice.table(bits))
