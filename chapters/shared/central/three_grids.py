"""The methods of section 4.3 on the rays of three grids, and their errors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from chapters.shared.methods import LINEAR_STAGES
from raxel.calibration import centroid_directions, ray_point_distances, relax_poses
from raxel.errors import CalibrationError
from raxel.geometry import angle_between_rotations, on_plane, transform

# Where grids cross, a ray's points nearly coincide and do not determine its line.
MIN_SPREAD = 0.1


def calibrated(points, true, centrality=True, methods=tuple(LINEAR_STAGES)):
    """Return the results of each method on rays, points (3, N, 2) mm.

    By method: centre and poses as in Table 4.2, ray-point errors before and after
    adjustment as in Table 4.3, the scatter of Fig. 4.6, and errors against `true`
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
    """Return measures of the scatter of all rays, and of those with separate points."""
    apart = depth_spread(centre, points, poses) >= MIN_SPREAD
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
    """Return the depth range of each ray's points, (N,), over their distance."""
    placed = transform(T_base_grid, on_plane(points))
    distance = np.linalg.norm(placed - centre, axis=2)
    return np.ptp(distance, axis=0) / distance.mean(axis=0)


def parameters(centre, T_base_grid):
    """Return Table 4.2: centre (mm), |R| (deg) and |t| (mm) of grids 2 and 3."""
    found = dict(zip(("cx", "cy", "cz"), map(float, centre), strict=True))
    for number, T in enumerate(T_base_grid[1:], 2):
        found[f"r{number}"] = _turn(T)
        found[f"t{number}"] = float(np.linalg.norm(T[:3, 3]))
    return found


def _turn(T):
    return float(np.degrees(angle_between_rotations(np.eye(3), T[:3, :3])))


def ray_point_errors(points, centre, T_base_grid, directions):
    """Return distances (n * N,) mm of points from their rays, (4.18)."""
    placed = transform(T_base_grid, on_plane(points))
    return ray_point_distances(placed, centre, directions).ravel()


# How rays scatter about the centre of a calibration (4.3.2, Fig. 4.6).


EDGE = 1e-9  # mm, a point this near to the hull counts as inside
GAUSSIAN_KURTOSIS = 8.0  # Mardia's, of two coordinates
TILTS_DEG, TOWARDS = (10.0, 20.0, 30.0), 8  # of planes, and the number of directions


class Lines(NamedTuple):
    """Lines by points on them, middles (N, 3) mm, and unit directions (N, 3)."""

    middles: np.ndarray
    directions: np.ndarray

    def some(self, chosen):
        """Return the chosen (N,) lines."""
        return Lines(self.middles[chosen], self.directions[chosen])


def best_lines(points, T_base_grid):
    """Return the Lines nearest to points (n, N, 2) mm on grids (n, 4, 4)."""
    placed = transform(T_base_grid, on_plane(points))
    middles = placed.mean(axis=0)
    off = np.moveaxis(placed - middles, 1, 0)
    _, vectors = np.linalg.eigh(np.swapaxes(off, 1, 2) @ off)
    return Lines(middles, vectors[:, :, 2])


def facing_plane(directions):
    """Return axes (2, 3) of the plane most nearly perpendicular to directions (N, 3).

    Its normal minimises the sum of squared sines of the angles to them (4.24).
    """
    _, vectors = np.linalg.eigh(directions.T @ directions)
    return vectors[:, :2].T


def crossings(centre, lines):
    """Return the crossings of Lines with the facing plane through the centre.

    (N, 2) mm; the centre is at (0, 0).
    """
    middles, directions = lines
    across = facing_plane(directions)
    normal = np.cross(*across)
    reach = ((centre - middles) @ normal) / (directions @ normal)
    return (middles + reach[:, None] * directions - centre) @ across.T


def tilted_over_facing(centre, lines):
    """Return the smallest RMS distance from the centre at which Lines cross a tilted
    plane through it, over that on the facing plane.
    """
    middles, directions = lines
    normals = normals_about(facing_plane(directions))
    off = middles - centre
    # Along a ray, from its middle to each plane: (planes, N).
    reach = -(normals @ off.T) / (normals @ directions.T)
    along = np.sum(off * directions, axis=1)
    adjacent = off - along[:, None] * directions
    squared = np.sum(adjacent**2, axis=1) + (along + reach) ** 2
    facing, *tilted = np.sqrt(squared.mean(axis=1))
    return float(min(tilted) / facing)


def normals_about(across):
    """Return unit normals (1 + planes, 3): that of the plane with axes (2, 3), then of
    planes tilted from it by TILTS_DEG in TOWARDS directions."""
    ahead = np.cross(*across)
    towards = np.linspace(0, 2 * np.pi, TOWARDS, endpoint=False)
    aside = np.column_stack([np.cos(towards), np.sin(towards)]) @ across
    tilted = [
        np.cos(tilt) * ahead + np.sin(tilt) * aside for tilt in np.radians(TILTS_DEG)
    ]
    return np.concatenate([ahead[None], *tilted])


def scatter_of(crossing):
    """Return measures of the scatter of points (N, 2) about (0, 0).

    rms_mm: RMS distance from it; eigenvalues: ratio of the smaller to the larger of the
    covariance, 1 if it is the same in all directions; kurtosis: |b - 8| by Mardia,
    0 for a Gaussian; inside: whether it is in the convex hull.
    """
    off = crossing - crossing.mean(axis=0)
    covariance = off.T @ off / len(off)
    values = np.linalg.eigvalsh(covariance)
    white = off @ np.linalg.inv(np.linalg.cholesky(covariance)).T
    kurtosis = np.mean(np.sum(white**2, axis=1) ** 2)
    planes = ConvexHull(crossing).equations
    return {
        "rms_mm": float(np.sqrt(np.mean(np.sum(crossing**2, axis=1)))),
        "eigenvalues": float(values[0] / values[1]),
        "kurtosis": float(abs(kurtosis - GAUSSIAN_KURTOSIS)),
        "inside": float(np.all(planes[:, 2] <= EDGE)),
    }
