"""A run from images to rays: calibration in two ways, and its errors.

As published, and as `raxel calibrate` does with a user's own images. Both have the same
views.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.trials.pictures import (
    drawn_scene,
    read_pictures,
)
from chapters.shared.mirror_bench import BENCHES
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import CLAMP_PICKS, PUBLISHED, lattice
from chapters.shared.mirror_scores import (
    back_projection,
    lengths,
    load_height,
    ray_angles,
)
from raxel.calibration.mirror.clamp_line import clamp_line, fixed_line
from raxel.calibration.mirror.platter import grid_poses_in_platter
from raxel.calibration.mirror.primary import calibrate_primary
from raxel.calibration.mirror.stages import calibrate_mirror
from raxel.calibration.mirror.update import update_mirror
from raxel.errors import InputError

COMPARED_PX = 96  # px between the pixels whose rays are compared
FALSE_PX = 2.0  # a corner farther than this from all true ones is false


def rendered_trial(condition, rng, sizes):
    """All measures of one run; `refused`, of the run or of a way, is the code of its
    rejection.

    sizes: RunSizes.
    """
    rig = mirror_rig(condition["geometry"], small=sizes.small)
    scene = drawn_scene(rig, BENCHES[condition["bench"]], sizes.steps, rng)
    try:
        read = read_pictures(scene, sizes, rng)
    except InputError as refusal:
        return {"refused": refusal.code}
    held_out = scoring_boards(scene, rng)
    return corner_errors(scene, read) | {
        "published": as_published(scene, read, held_out),
        "own": as_a_reader(scene, read, held_out),
    }


def corner_errors(scene, read):
    """Median distance, px, of corners from the nearest true one, and how many are
    false."""
    off = []
    for k, step in enumerate(read.views.steps):
        cameras = scene.cameras[k : k + 2]
        for view, camera in zip((step.before, step.after), cameras, strict=True):
            true, _ = scene.rig.corners(camera, scene.boards[k])
            found = view.pixels[np.isfinite(view.pixels[:, 0])]
            apart = np.linalg.norm(found[:, None] - true[None], axis=2)
            off.append(np.nanmin(apart, axis=1))
    off = np.concatenate(off)
    return {
        "corner_px": float(np.median(off)),
        "false": int(np.count_nonzero(off > FALSE_PX)),
    }


def as_published(scene, read, held_out):
    """Primary stage and each deflection from the one before."""
    views, cameras, out = read.views, [], {}
    try:
        first, held = primary(views)
        cameras.append(first)
        for k, step in enumerate(views.steps, 1):
            stage = update_mirror(
                cameras[-1], step.before.pixels, step.after.pixels, step.before.points,
                held, PUBLISHED.settings, outline=read.outlines[k - 1],
            )  # fmt: skip
            cameras.append(stage.camera)
            residual = {"residual_mm": float(np.nanmean(stage.residuals))}
            out[f"stage{k}"] = residual | scored(scene, k, cameras, held_out)
    except InputError as refusal:
        out["refused"] = refusal.code
    return out


def primary(views):
    """(camera of stage 0, what the clamp holds)"""
    poses = grid_poses_in_platter(views.viewer, views.platter, views.thickness)
    line = clamp_line(views.viewer, views.clamp.points)
    found = calibrate_primary(
        views.viewer, views.grids, poses,
        shape=PUBLISHED.shape, angle=line.angle, quantity=PUBLISHED.quantity,
        span=line.points(CLAMP_PICKS),
    )  # fmt: skip
    return found.camera, fixed_line(found.camera, line)._replace(slopes=None)


def as_a_reader(scene, read, held_out):
    """The same as `raxel calibrate` makes of a reader's own set."""
    try:
        found = calibrate_mirror(read.views)
    except InputError as refusal:
        return {"refused": refusal.code}
    return {
        f"stage{k}": {"residual_mm": float(found.residuals_mm(k).mean())}
        | scored(scene, k, found.cameras, held_out)
        for k in range(1, len(found.cameras))
    }


def scoring_boards(scene, rng):
    """(T_camera_board, exact pixels (182, 2)) at 400 mm, for each stage."""
    found = []
    for k in range(len(scene.boards) + 1):
        T = scene.rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[k : k + 1])
        pixels, seen = scene.rig.corners(scene.cameras[k], T)
        found.append((T, np.where(seen[:, None], pixels, np.nan)))
    return found


def scored(scene, k, cameras, held_out):
    """The deflection from stage k - 1 to k, and how far camera k is off the truth."""
    camera, true, (T, pixels) = cameras[k], scene.cameras[k], held_out[k]
    points, rays = scene.rig.board.points(), lattice(true, COMPARED_PX)
    before, after = (
        load_height(scene.rig, cameras[j], scene.cameras[j]) for j in (k - 1, k)
    )
    own, of_true = (
        lengths(back_projection(camera, pixels, points, where)) for where in (None, T)
    )
    return {
        "deflection_mm": after - before,
        "angle_deg": float(np.nanmean(ray_angles(camera, true, rays))),
        "back_mm": float(own.mean()),
        "back_true_mm": float(of_true.mean()),
    }
