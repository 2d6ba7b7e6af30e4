"""The loop with the board's known metric, and without it (5.3.3).

The pose of the board comes from the camera before each step. With the metric its
corners are those of a board in that pose. Without it each corner is where the camera's
own ray meets the board's plane: then the next shape inherits all errors of the camera,
not only those that a rigid board can follow. Nothing else differs: images, clamp,
linear stage and refinement are the same.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.run import (
    COMPARED_PX,
    LOOP,
    OUT,
    boards_of_loop,
)
from chapters.shared.mirror_bench import BENCHES, LEVEL
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import PUBLISHED, lattice, outline, primary, seen_board
from chapters.shared.mirror_scores import back_projection, lengths, ray_angles
from raxel.calibration.mirror.update import update_from_scene
from raxel.calibration.pose.non_central import pose_from_non_central_rays
from raxel.errors import CalibrationError
from raxel.geometry import intersect_rays_plane, transform
from raxel.geometry.planes import on_plane

ARMS = ("metric", "without")


def metric_trial(condition, rng, errors):
    """Errors after each of six steps, with the metric and without."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    bench = BENCHES[LEVEL]
    errors = errors[condition["geometry"]].on(bench)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    out, stay = boards_of_loop(rig, rng)
    pictures = [
        [
            seen_board(rig, cameras[stage], T, errors, rng)
            for stage in LOOP[number : number + 2]
        ]
        for number, T in enumerate([*out, *(stay,) * OUT])
    ]
    scored = []
    for camera, deflection in zip(cameras, STAGES_MM, strict=True):
        T = rig.board_pose(rng, BACK_PROJECTION_MM, (deflection,))
        scored.append(seen_board(rig, camera, T, errors, rng))
    return {arm: steps_of(rig, cameras, first, pictures, scored, arm) for arm in ARMS}


def steps_of(rig, cameras, first, pictures, scored, arm):
    """{step: errors} of one arm; `refused` is the code of a rejection."""
    camera, board, found = first.camera, rig.board.points(), {}
    for number, (before, after) in enumerate(pictures, 1):
        stage, true = LOOP[number], cameras[LOOP[number]]
        try:
            scene = scene_points(camera, before, board, arm)
            camera = update_from_scene(
                camera, after, scene, first.clamp, PUBLISHED.settings,
                outline=outline(true),
            ).camera  # fmt: skip
            pixels = scored[stage]
            own = back_projection(camera, pixels, board)
        except CalibrationError as refusal:
            return found | {"refused": refusal.code}
        off = ray_angles(camera, true, lattice(true, COMPARED_PX))
        found[f"step{number}"] = {
            "back_mm": float(lengths(own).mean()),
            "angle_deg": float(np.nanmean(off)),
        }
    return found


def scene_points(camera, pixels, board, arm):
    """Corners (N, 3), viewer's frame, mm, estimated by a camera, NaN if not visible.

    pixels: (N, 2) before the step; board: (N, 2) mm; arm: one of ARMS.
    """
    rays = camera.rays(pixels)
    pose = pose_from_non_central_rays(rays, board)
    T = pose.T_camera_grid
    if arm == "metric":
        flat = board
    else:
        flat = intersect_rays_plane(rays.origins, rays.directions, T).points
    placed = transform(T, on_plane(flat))
    return np.where(pose.inliers[:, None], placed, np.nan)
