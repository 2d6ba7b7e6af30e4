"""The methods of section 4.3 on the rays of three grids, scored alike."""

import numpy as np

from chapters.shared.central_scatter import (
    best_lines,
    crossings,
    scatter_of,
    tilted_over_facing,
)
from chapters.shared.methods import LINEAR_STAGES
from raxel.calibration import ray_point_distances, relax_poses
from raxel.calibration.adjust.centroid_rays import centroid_directions
from raxel.errors import CalibrationError
from raxel.geometry import angle_between_rotations, on_plane, transform

# Where grids cross, a ray's points nearly coincide and no line goes through them.
LEAST_SPREAD = 0.1


def calibrated(points, true, centrality=True, methods=tuple(LINEAR_STAGES)):
    """What each of the methods makes of rays, points (3, N, 2) mm.

    By method: centre and poses as Table 4.2 has them, ray-point errors before and
    after adjustment as Table 4.3, the scatter of Fig. 4.6, and errors against `true`
    (TrueGrids); or the code of its error.
    """
    out = {}
    for name in methods:
        try:
            out[name] = _calibrated(LINEAR_STAGES[name], points, true, centrality)
        except CalibrationError as fault:
            out[name] = {"failed": fault.code}
    return out


def _calibrated(stage, points, true, centrality):
    start = stage(points, side=-1)
    centre, poses = start.centre, start.T_base_grid
    seen = np.ones(points.shape[:2], bool)
    rays = centroid_directions(points, seen, centre, poses)
    adjusted = relax_poses(points, seen, centre, poses)
    before = ray_point_errors(points, centre, poses, rays)
    after = ray_point_errors(points, centre, *adjusted[:2])
    found = parameters(centre, poses) | {
        "ray_mean_mm": before.mean(),
        "ray_sd_mm": before.std(),
        "ba_mean_mm": after.mean(),
        "ba_sd_mm": after.std(),
        "centre_off_mm": float(np.linalg.norm(centre - true.centre)),
    }
    if centrality:
        found |= _scatters(centre, points, poses)
    return found


def _scatters(centre, points, poses):
    """Measures of the scatter of all rays, and of those whose points lie apart."""
    apart = depth_spread(centre, points, poses) >= LEAST_SPREAD
    lines = best_lines(points, poses)
    crossing = crossings(centre, lines)

    def measures(some, crossing):
        tilted = tilted_over_facing(centre, some)
        return scatter_of(crossing) | {"tilted_over_facing": tilted}

    far = lines.some(apart)
    return {
        "all": measures(lines, crossing),
        "apart": measures(far, crossings(centre, far)),
        "share_apart": float(apart.mean()),
        "crossing": np.column_stack([crossing, apart]).astype(np.float32),
    }


def depth_spread(centre, points, T_base_grid):
    """How far apart the points of each ray lie, (N,), as a share of their distance."""
    placed = transform(T_base_grid, on_plane(points))
    distance = np.linalg.norm(placed - centre, axis=2)
    return np.ptp(distance, axis=0) / distance.mean(axis=0)


def parameters(centre, T_base_grid):
    """The numbers of Table 4.2: centre (mm), |R| (deg) and |t| (mm) of grids 2, 3."""
    found = dict(zip(("cx", "cy", "cz"), map(float, centre), strict=True))
    for number, T in enumerate(T_base_grid[1:], 2):
        found[f"r{number}"] = _turn(T)
        found[f"t{number}"] = float(np.linalg.norm(T[:3, 3]))
    return found


def _turn(T):
    return float(np.degrees(angle_between_rotations(np.eye(3), T[:3, :3])))


def ray_point_errors(points, centre, T_base_grid, directions):
    """Distances (n * N,) mm of points from their rays, (4.18)."""
    placed = transform(T_base_grid, on_plane(points))
    return ray_point_distances(placed, centre, directions).ravel()
