"""The case that Fig. 4.3 is drawn from, and how long each estimator takes."""

import time

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.estimators import (
    by_angles,
    by_distances,
)
from chapters.ch04_central_generic.s2_pose.trials.simulated import (
    moved,
    normalised,
    points_on_grid,
)
from chapters.shared.wide_angle import CENTRE_MM, T_BASE_CAMERA, draw_poses, radial_lens
from raxel.calibration.pose.grid_pose import (
    grid_pose_ransac,
    linear_grid_pose,
    synthetic_plane_normal,
)
from raxel.calibration.pose.three_point import pose_three_point_ransac
from raxel.geometry import inverse_pose, on_plane, pose, rotation_from_vector, transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

COLUMNS, ROWS, PITCH_MM = 5, 4, 60.0
SHIFT_MM = (330.0, 60.0, -40.0)
TURN_DEG = (20.0, -25.0, 10.0)
PLANE_MM = 260.0  # from the centre to the synthetic plane

TIMED = {"quick": (1000,), "full": (1000, 20_000)}
RUNS = 7


def lattice():
    """Points (N, 2) of the drawn grid, its middle at the origin."""
    x = PITCH_MM * (np.arange(COLUMNS) - (COLUMNS - 1) / 2)
    y = PITCH_MM * (np.arange(ROWS) - (ROWS - 1) / 2)
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def case_trial(condition, rng):
    """Points, rays, synthetic plane and image of one case, and its pose."""
    true = pose(rotation_from_vector(np.radians(TURN_DEG)), SHIFT_MM)
    points = lattice()
    there = transform(true, on_plane(points))
    rays = normalised(there - CENTRE_MM)
    normal = synthetic_plane_normal(rays)
    image = CENTRE_MM + PLANE_MM * rays / (rays @ normal)[:, None]
    found = linear_grid_pose(rays, points, normal=normal).T_camera_grid
    return {
        "there": there,
        "rays": rays,
        "normal": normal,
        "image": image,
        "true": true,
        "found": moved(found, CENTRE_MM),
    }


@experiment("fig_4_3_case", artefact="fig_4_3")
def drawn_case(effort):
    """One grid, its image on the synthetic plane, and the pose from it."""
    return Plan(case_trial, [{}], 1, {"shift_mm": SHIFT_MM, "turn_deg": TURN_DEG})


def fastest(call):
    """Processor seconds of the fastest of RUNS calls."""
    taken = []
    for _ in range(RUNS):
        start = time.process_time()
        call()
        taken.append(time.process_time() - start)
    return min(taken)


def time_trial(condition, rng):
    """Processor seconds of every estimator on one noisy scene."""
    camera, T = radial_lens(), draw_poses(rng, 2)[1]
    T_camera_grid = inverse_pose(T_BASE_CAMERA) @ T
    views = [
        points_on_grid(T_camera_grid, 600.0, camera, 0.5, rng)
        for _ in range(-(-condition["points"] // 999))
    ]
    directions, points = (
        np.concatenate(part)[: condition["points"]] for part in zip(*views, strict=True)
    )
    given, limit = (directions, points), 6.0
    three = pose_three_point_ransac(*given, rng, limit)
    linear = grid_pose_ransac(*given, rng, limit)
    ransac = fastest(lambda: pose_three_point_ransac(*given, rng, limit))
    robust = fastest(lambda: grid_pose_ransac(*given, rng, limit))
    return {
        "three_points": ransac,
        "standard": ransac
        + fastest(lambda: by_distances(*given, three, limit, "ray-point")),
        "cgsp": fastest(lambda: linear_grid_pose(*given)),
        "cgsp_ransac": robust,
        "angular": robust + fastest(lambda: by_angles(*given, linear)),
    }


@experiment("ext_pose_times_run", artefact="ext_pose_times")
def times(effort):
    """How long each estimator takes, on one processor."""
    return Plan(time_trial, crossed(points=TIMED[effort]), 1, {"runs": RUNS})
