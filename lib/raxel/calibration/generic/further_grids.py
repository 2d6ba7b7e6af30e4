"""A central camera from decoded grids, by the protocol of section 4.3.1.

The first grids make the linear stage, and the standard method adjusts their poses while
the centre stays. Each further grid is placed from the rays that are known so far, and
extends what is calibrated. The order is that of the grids: a base or a beginning is not
looked for (`raxel.calibration.generic.cgsp` and `standard` do).
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.adjust.bundle import ray_point_distances
from raxel.calibration.adjust.centroid_rays import centroid_directions
from raxel.calibration.adjust.relaxation import relax_poses
from raxel.errors import CalibrationError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform

# A point is taken for right that lies off its ray by so many times the usual.
THRESHOLD = 5.0
MIN_THRESHOLD_MM = 0.5


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


def relaxed_start(points, start, most=None):
    """The linear stage with its poses adjusted as in the thesis, the centre kept.

    points: (n, N, 2) mm, NaN where a ray does not see a grid; start: LinearSolution of
    these grids; most: about so many of the rays take part that see two grids or more,
    all without it.
    """
    seen = np.isfinite(points[..., 0])
    shared = np.flatnonzero(np.sum(seen, axis=0) >= 2)
    chosen = shared if most is None else shared[:: max(1, len(shared) // most)]
    found = relax_poses(
        points[:, chosen], seen[:, chosen], start.centre, start.T_base_grid
    )
    return start._replace(T_base_grid=found.T_base_grid)


def calibrate_central(
    points, start, place, rng, *, weight=1.0, threshold=None, most=None, join=True
):
    """Centre, poses and rays from grids that are decoded in the same pixels.

    points: (n, N, 2) mm on n grids, NaN where a ray does not see one; start: centre and
    T_base_grid (k, 4, 4) of the first k grids, such as a LinearSolution.
    place: `grid_pose_ransac` (CGSP) or `pose_from_rays` (standard), called with rays,
    points, rng, threshold. rng: numpy Generator.
    weight: in a ray, of a point of the first k grids over one of a further grid
    (4.1.3). threshold: mm, of RANSAC; by default five times the median ray-point
    distance of the first grids, and 0.5 at least. most: rays that a grid is placed by,
    drawn. join: whether a grid's points move the rays that the next is placed by.

    Returns CentralCalibration; a grid that cannot be placed is left out, with the
    reason.
    """
    centre, first = start.centre, len(start.T_base_grid)
    seen = np.isfinite(points[..., 0])
    placed, used, failed = list(start.T_base_grid), list(range(first)), {}

    def joined():
        weights = np.where(np.array(used) < first, weight, 1.0)
        return centroid_directions(
            points[used], seen[used], centre, np.stack(placed), weights
        )

    rays = joined()
    if threshold is None:
        usual = np.median(_distances(points[:first], seen[:first], start, rays))
        threshold = max(THRESHOLD * float(usual), MIN_THRESHOLD_MM)
    for grid in range(first, len(points)):
        known = np.flatnonzero(np.isfinite(rays[:, 0] + points[grid, :, 0]))
        if most is not None and len(known) > most:
            known = np.sort(rng.choice(known, most, replace=False))
        try:
            found = place(rays[known], points[grid, known], rng, threshold)
        except CalibrationError as fault:
            failed[grid] = str(fault)
            continue
        T = found.T_camera_grid.copy()
        T[:3, 3] += centre
        placed.append(T)
        used.append(grid)
        if join:
            rays = joined()
    return CentralCalibration(centre, np.stack(placed), joined(), used, failed)


def _distances(points, seen, start, rays):
    """Distances (M,) mm of points from their rays, of rays that two grids share."""
    shared = seen & (np.sum(seen, axis=0) >= 2)
    return np.concatenate(
        [
            ray_point_distances(
                transform(T, on_plane(own[here])), start.centre, rays[here]
            )
            for own, T, here in zip(points, start.T_base_grid, shared, strict=True)
        ]
    )
