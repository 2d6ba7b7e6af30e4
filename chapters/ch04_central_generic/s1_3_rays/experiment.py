"""Section 4.1.3: Plücker rays against planes, and the weights of a ray's points."""

import numpy as np

from chapters.shared.central import RAYS, SIDE, draw_scene, radial_lens
from raxel.calibration import (
    adjust_consistent,
    centroid_directions,
    centroid_weights,
    linear_cgsp,
    ray_point_distances,
    ray_point_system,
    refine_pose_ray_point,
)
from raxel.errors import CalibrationError
from raxel.geometry import (
    intersect_lines_plane,
    intersect_rays_plane,
    on_plane,
    plane_of_pose,
    pluecker_matrix_of_rays,
    pose,
    rotation_from_vector,
    transform,
)
from repro.run import Plan, experiment

TABLE_RAYS = 20_000
LINEAR_GRIDS, ALL_GRIDS = 3, 6
# Weight of the linear grids, relative to the others.
FACTORS = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 64.0)
# Numbers of rays from which the pose of a further grid is estimated.
POSED = (6, 40, RAYS)
NOISE = {"px": 0.5, "mm": 0.5}


def stacked_trial(condition, rng):
    """(4.15) compared with the product of each ray's own matrix with the plane.

    Differences are shares of the largest entry of a ray's homogeneous
    point. on_grid_mm: distance of the points from the direct
    intersection of ray and plane.
    """
    origin = rng.uniform(-100, 100, 3)
    directions = rng.standard_normal((TABLE_RAYS, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    turn = rotation_from_vector(rng.uniform(-0.5, 0.5, 3))
    T = pose(turn, rng.uniform(-100, 100, 3) + [0, 0, 500])
    plane = plane_of_pose(T)
    matrices = pluecker_matrix_of_rays(origin, directions)
    stacked = intersect_lines_plane(matrices, plane)
    # The thesis's M = [M_1 ... M_n], and -M^T S as it is written.
    M = np.concatenate(list(matrices), axis=1)
    printed = (-M.T @ plane).reshape(-1, 4)
    alone = np.array([one @ plane for one in matrices])
    size = np.abs(alone).max(axis=1, keepdims=True)
    hit = intersect_rays_plane(origin, directions, T)
    points = stacked[hit.valid, :3] / stacked[hit.valid, 3:]
    flat = on_plane(hit.points[hit.valid])
    near = np.abs(hit.range[hit.valid]) < 1e4
    return {
        "printed": (np.abs(printed - alone) / size).max(),
        "stacked": (np.abs(stacked - alone) / size).max(),
        "on_grid_mm": np.abs(points - transform(T, flat))[near].max(),
    }


@experiment("exp_c4_mats_intersection", artefact="sec_4_1_3")
def stacked(effort):
    """Intersection of rays with a plane by one transpose and one product."""
    return Plan(stacked_trial, [{}], 5, {"rays": TABLE_RAYS})


def weights_trial(condition, rng):
    """Rays from three linear grids and three whose poses come from rays.

    The first grids are calibrated by CGSP and the consistent adjustment.
    The poses of the others come from the resulting rays, a few or all of
    them. Then all six grids define the rays, with weights. ray_mm: mean
    distance of the rays from the true points of all grids.
    """
    domain = condition["domain"]
    scene = draw_scene(
        radial_lens(), NOISE[domain], rng, grids=ALL_GRIDS, domain=domain
    )
    first = scene.noisy[:LINEAR_GRIDS]
    try:
        start = linear_cgsp(first, side=SIDE)
    except CalibrationError as fault:
        return {"refused": fault.code}
    sigma = NOISE["mm"] if domain == "mm" else None
    found = adjust_consistent(first, None, start.centre, start.T_base_grid, sigma=sigma)
    noise = found.noise if domain == "px" else NOISE["mm"]
    return {
        "ray_mm": {
            str(count): _by_weights(scene, found, noise, domain, count)
            for count in POSED
        }
    }


def _by_weights(scene, found, noise, domain, count):
    """Errors of the rays of all grids, with the other poses from count rays."""
    centre, rays = found.centre, found.directions
    poses, spreads = list(found.T_base_grid), [np.zeros((6, 6))]
    spreads += [found.covariance[at : at + 6, at : at + 6] for at in (3, 9)]
    chosen = slice(0, count)
    for j in range(LINEAR_GRIDS, ALL_GRIDS):
        T, spread = _posed(
            rays[chosen], scene.noisy[j, chosen], scene.T_base_grid[j], centre
        )
        poses.append(T)
        spreads.append(spread)
    poses = np.array(poses)
    seen = np.ones(scene.noisy.shape[:2], bool)
    best = centroid_weights(
        scene.noisy, seen, centre, poses, spreads, noise,
        "image" if domain == "px" else "plane",
    )  # fmt: skip
    given = {f"{factor:g}": _stepped(factor) for factor in FACTORS}
    given |= {"variance": best, "linear grids alone": None}
    out = {}
    for name, weights in given.items():
        grids = LINEAR_GRIDS if weights is None else ALL_GRIDS
        u = centroid_directions(
            scene.noisy[:grids], seen[:grids], centre, poses[:grids], weights
        )
        out[name] = distance_from_true_points(scene, centre, u)
    return out


def _stepped(factor):
    """The thesis's rule: one weight for the linear grids, one for others."""
    weights = np.ones(ALL_GRIDS)
    weights[:LINEAR_GRIDS] = factor
    return weights


def _posed(rays, points, T_start, centre):
    """Pose of a grid from rays, and its covariance (6, 6).

    The fit starts at the true pose, so that only noise causes the error.
    """
    T, cost = refine_pose_ray_point(rays, points, T_start, origins=centre)
    _, jacobian = ray_point_system(rays, points, T, centre, np.ones(len(rays)))
    variance = cost / (2 * len(rays) - 6)
    spread = variance * np.linalg.inv(jacobian.T @ jacobian)
    # Its shift is in the grid's frame.
    turn = np.eye(6)
    turn[3:, 3:] = T[:3, :3]
    return T, turn @ spread @ turn.T


def distance_from_true_points(scene, centre, u):
    """Mean distance (mm) of rays (N, 3) from the true points that they view."""
    placed = transform(scene.T_base_grid, on_plane(scene.points))
    return float(ray_point_distances(placed, centre, u).mean())
