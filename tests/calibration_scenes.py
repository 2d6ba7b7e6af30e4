"""Exact synthetic data for the calibration tests: a centre, grids, rays, points."""

import numpy as np
from scipy.spatial.transform import Rotation

from raxel.geometry import intersect_rays_plane, pose


def cone_directions(rng, count, field_deg, side=1.0):
    """Unit directions (count, 3), uniform in a cone about -side * z."""
    z = rng.uniform(np.cos(np.radians(field_deg / 2)), 1.0, count)
    angle = rng.uniform(0, 2 * np.pi, count)
    r = np.sqrt(1 - z**2)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), -np.sign(side) * z])


def tilted_grids(rng, count, tilt_deg=30.0, shift=150.0):
    """Poses (count, 4, 4) in the base frame; the first is the identity."""
    angles = rng.uniform(-tilt_deg, tilt_deg, (count - 1, 3))
    rotations = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
    grids = pose(rotations, rng.uniform(-shift, shift, (count - 1, 3)))
    return np.concatenate([np.eye(4)[None], grids])


def meet_grids(centre, directions, T_base_grid):
    """points (n, N, 2) and seen (n, N) of rays from one centre on all grids."""
    hits = [intersect_rays_plane(centre, directions, T) for T in T_base_grid]
    return np.stack([h.points for h in hits]), np.stack([h.valid for h in hits])


def scene(seed, centre=(10.0, -20.0, 600.0), *, count=300, grids=3, field_deg=60.0):
    """centre, T_base_grid, directions, points (n, N, 2) seen by all N rays."""
    rng = np.random.default_rng(seed)
    centre = np.asarray(centre, float)
    T_base_grid = tilted_grids(rng, grids)
    directions = cone_directions(rng, count, field_deg, centre[2])
    points, seen = meet_grids(centre, directions, T_base_grid)
    keep = seen.all(axis=0)
    return centre, T_base_grid, directions[keep], points[:, keep]


def partly_seen(seed, share, *, grids=4, count=60, noise=0.0):
    """centre, T_base_grid, directions, points (n, N, 2), seen (n, N): a share is."""
    centre, T_base_grid, directions, points = scene(seed, grids=grids, count=count)
    rng = np.random.default_rng(seed + 100)
    seen = rng.random(points.shape[:2]) < share
    points = points + noise * rng.normal(size=points.shape)
    points = np.where(seen[..., None], points, np.nan)
    return centre, T_base_grid, directions, points, seen


def central_difference(function, size, h=1e-5):
    """Derivative of a function of (size,) at zero; its values come first."""
    steps = h * np.eye(size)
    return np.stack([(function(s) - function(-s)) / (2 * h) for s in steps], axis=-1)
