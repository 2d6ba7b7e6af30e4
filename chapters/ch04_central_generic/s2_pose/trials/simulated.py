"""Section 4.2.2's simulation: a further grid before rays that are known."""

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.estimators import (
    all_estimates,
    scored,
)
from chapters.shared.wide_angle import (
    CENTRE_MM,
    RADIUS_PX,
    T_BASE_CAMERA,
    draw_poses,
    radial_lens,
)
from raxel.geometry import inverse_pose, on_plane, pose, transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

LEVELS = (0.1, 0.25, 0.5, 1.0, 2.0)
DOMAINS = ("px", "mm")
RAYS = ("measured on the base grid", "exact")
POINTS = 999
# RANSAC's threshold in standard deviations of the noise of ray and point.
WIDE = 4 * np.sqrt(2)
SIZES = {
    "usual": {"grid_mm": 1200.0, "distance_mm": 600.0},
    "halved, doubled": {"grid_mm": 600.0, "distance_mm": 1200.0},
}
SIZE_NOISE = 0.5
TRIALS = {"quick": 5, "full": 100}


def normalised(vectors):
    """Vectors (..., 3) at length one."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def moved(T, shift):
    """A pose (4, 4) seen from an origin elsewhere: its shift grows."""
    return pose(T[:3, :3], T[:3, 3] + shift)


# How RANSAC compares a ray and a point, by the reading `pose_threshold`.
METRICS = {"length": "ray-point", "angle": "angle"}


def threshold(camera, noise, domain, unit):
    """RANSAC's threshold: a ray-point distance 600 mm away, or its angle."""
    away = np.linalg.norm(CENTRE_MM)
    length = WIDE * noise * (away / camera.K[0, 0] if domain == "px" else 1)
    return length if unit == "length" else length / away


def rays_and_points(scene, rays):
    """Rays (N, 3) that were calibrated before, and their points on a grid.

    Frame: the base grid's axes, from the camera's centre.
    """
    if rays == "exact":
        return scene.directions, scene.noisy[1]
    return normalised(on_plane(scene.noisy[0]) - CENTRE_MM), scene.noisy[1]


def points_on_grid(T_camera_grid, half_mm, camera, noise, rng):
    """Rays (N, 3) of noisy pixels and the points (N, 2) that they see."""
    points = np.empty((0, 2))
    while len(points) < POINTS:
        drawn = rng.uniform(-half_mm, half_mm, (2 * POINTS, 2))
        seen = camera.project(transform(T_camera_grid, on_plane(drawn)))
        middle = np.array([camera.width - 1, camera.height - 1]) / 2
        off = np.linalg.norm(seen.pixels - middle, axis=1)
        points = np.concatenate([points, drawn[off <= RADIUS_PX]])
    points = points[:POINTS]
    pixels = camera.project(transform(T_camera_grid, on_plane(points))).pixels
    noisy = pixels + noise * rng.standard_normal(pixels.shape)
    return camera.rays(noisy).directions, points


def size_trial(condition, rng):
    """Errors on a grid of one size and distance, and on the smaller, farther."""
    camera = radial_lens()
    T = draw_poses(rng, 2)[1]
    out = {}
    for name, size in SIZES.items():
        ahead = T_BASE_CAMERA.copy()
        ahead[2, 3] = size["distance_mm"]
        T_camera_grid = inverse_pose(ahead) @ T
        directions, points = points_on_grid(
            T_camera_grid, size["grid_mm"] / 2, camera, SIZE_NOISE, rng
        )
        mm_per_px = size["distance_mm"] / camera.K[0, 0]
        found = all_estimates(directions, points, rng, WIDE * SIZE_NOISE * mm_per_px)
        out[name] = {
            estimator: scored(pose, T_camera_grid) for estimator, pose in found.items()
        }
    return out


@experiment("exp_c4_real_larger", artefact="fig_4_4")
def real_larger(effort):
    """The same grids, and half as large at twice the distance."""
    settings = {"sizes": SIZES, "noise_px": SIZE_NOISE, "points": POINTS}
    return Plan(size_trial, [{}], TRIALS[effort], settings)
