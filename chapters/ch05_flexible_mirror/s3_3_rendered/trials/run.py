"""A run from pictures to rays: what is read is calibrated in three ways and scored.

As published; with inverse depth, the slope of the clamp and a prior; and as `raxel
calibrate` takes a reader's own pictures. All three get the same views.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_rendered.trials.pictures import (
    drawn_scene,
    read_pictures,
)
from chapters.shared.mirror_bench import BENCHES
from chapters.shared.mirror_bundle import AIMED
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import CLAMP_PICKS, PUBLISHED, lattice
from chapters.shared.mirror_scores import (
    back_projection,
    lengths,
    load_height,
    ray_angles,
)
from raxel.calibration.mirror.bundle import StageView, bundle_stages
from raxel.calibration.mirror.clamp_line import clamp_line, fixed_line
from raxel.calibration.mirror.platter import grid_poses_in_platter
from raxel.calibration.mirror.primary import calibrate_primary
from raxel.calibration.mirror.stages import calibrate_mirror
from raxel.calibration.mirror.update import update_mirror
from raxel.errors import InputError
from raxel.geometry import rotation_from_vector, transform
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import vector_from_rotation

WAYS = {"published": PUBLISHED, "aimed": AIMED}
OWN = "own"  # as `raxel calibrate` does it
# px between the pixels whose rays are compared.
COMPARED_PX = 96
FALSE_PX = 2.0  # what is found farther than this from all true corners is none


def rendered_trial(condition, rng, sizes):
    """Every measure of one run; `refused`, of the run or of a way, says where it ended,
    if early. The first run of a rig and bench keeps pictures.

    sizes: RunSizes.
    """
    rig = mirror_rig(condition["geometry"], small=sizes.small)
    scene = drawn_scene(rig, BENCHES[condition["bench"]], sizes.steps, rng)
    try:
        read = read_pictures(scene, sizes, rng)
    except InputError as refusal:
        return {"refused": str(refusal)}
    held_out = scoring_boards(scene, rng)
    out = of_pictures(scene, read)
    for name, way in WAYS.items():
        out[name] = by_stages(scene, read, held_out, way)
    out[OWN] = as_a_reader(scene, read, held_out)
    if condition["run"] == 0:
        out |= {
            f"step{k}.{when}": shown._asdict()
            for k, pair in enumerate(read.shown, 1)
            for when, shown in zip(("before", "after"), pair, strict=True)
        }
    return out


def of_pictures(scene, read):
    """How well pictures were read: errors of corners, px, and of the viewer.

    A corner's error is its distance from the nearest true one; false: found where there
    is none; lost: those seen in the mirror, less those found.
    """
    rig, off, lost = scene.rig, [], 0
    for k, step in enumerate(read.views.steps):
        cameras = scene.cameras[k : k + 2]
        for view, camera in zip((step.before, step.after), cameras, strict=True):
            true, seen = rig.corners(camera, scene.boards[k])
            found = view.pixels[np.isfinite(view.pixels[:, 0])]
            apart = np.linalg.norm(found[:, None] - true[None], axis=2)
            off.append(np.nanmin(apart, axis=1))
            lost += int(seen.sum()) - len(found)
    focal = read.views.viewer.K[0, 0] / rig.viewer.K[0, 0]
    off = np.concatenate(off)
    return {
        "corner_px": float(np.median(off)),
        "corners": len(off),
        "false": int(np.count_nonzero(off > FALSE_PX)),
        "lost": lost,
        "focal_percent": float(100 * (focal - 1)),
    }


def by_stages(scene, read, held_out, way):
    """Primary stage and each deflection from the one before, by a MirrorMethod; and
    with a prior all stages together."""
    views, out = read.views, {}
    try:
        poses = grid_poses_in_platter(views.viewer, views.platter, views.thickness)
        calibration, held = primary(views, poses, way)
        first = calibration.camera
        out["stage0"] = {
            "miss_mm": float(np.nanmean(calibration.mirror.misses)),
            **separation(scene, poses),
            **heights(scene, 0, first, first),
            **scored(scene, 0, first, held_out),
        }
        before, updates = first, []
        for k, step in enumerate(views.steps, 1):
            stage = update_mirror(
                before, step.before.pixels, step.after.pixels, step.before.points,
                held, way.settings, outline=read.outlines[k - 1],
            )  # fmt: skip
            before = stage.camera
            updates.append(stage)
            residuals = stage.residuals[np.isfinite(stage.residuals)]
            out[f"stage{k}"] = {
                "residual_mm": float(residuals.mean()),
                "common": len(residuals),
                "wrong": int(np.count_nonzero(stage.wrong)),
                **heights(scene, k, first, before),
                **scored(scene, k, before, held_out),
            }
        if way.prior_sd is not None:
            bundle = bundled(views, first, held, updates, way)
            out["bundle"] = {
                f"stage{k}": heights(scene, k, first, camera)
                | scored(scene, k, camera, held_out)
                for k, camera in enumerate(bundle.cameras)
            }
    except InputError as refusal:
        out["refused"] = str(refusal)
    return out


def separation(scene, poses):
    """By how much the platter got the monitor's way wrong: mm in the shift of its
    middle, and degrees in its turn."""
    corner, size = scene.rig.monitor.extent
    middle = corner + size / 2
    # The monitor's y axis points upwards in views that show it as in a mirror.
    motion = poses.motion(0, 1, middle * [1, -1])
    first, second = scene.places
    way = transform(second, on_plane(middle[None])) - transform(
        first, on_plane(middle[None])
    )
    # Turned as in a mirror, too: about x and y the other way.
    turn = np.diag([1, -1, -1]) @ vector_from_rotation(first[:3, :3].T @ second[:3, :3])
    off = rotation_from_vector(motion.rotation).T @ rotation_from_vector(turn)
    return {
        "separation_mm": float(abs(motion.distance - np.linalg.norm(way))),
        "separation_deg": float(np.degrees(np.linalg.norm(vector_from_rotation(off)))),
    }


def primary(views, poses, way):
    """(PrimaryCalibration, what the clamp holds)"""
    line = clamp_line(views.viewer, views.clamp.points)
    found = calibrate_primary(
        views.viewer, views.grids, poses,
        shape=way.shape, angle=line.angle, quantity=way.quantity,
        span=line.points(CLAMP_PICKS),
    )  # fmt: skip
    held = fixed_line(found.camera, line)
    return found, held if way.slope else held._replace(slopes=None)


def bundled(views, first, held, updates, way):
    """StageBundle of all stages and boards together."""
    cameras = [first, *(update.camera for update in updates)]
    poses = np.stack([update.pose.T_camera_grid for update in updates])
    shown = []
    for k, (step, update) in enumerate(zip(views.steps, updates, strict=True)):
        for stage, view in ((k, step.before), (k + 1, step.after)):
            right = np.where(update.wrong[:, None], np.nan, view.pixels)
            shown.append(StageView(stage, k, view._replace(pixels=right)))
    return bundle_stages(cameras, shown, poses, clamp=held, prior_sd=way.prior_sd)


def as_a_reader(scene, read, held_out):
    """The same as `raxel calibrate` makes of a reader's own set."""
    try:
        found = calibrate_mirror(read.views)
    except InputError as refusal:
        return {"refused": str(refusal)}
    first, out = found.cameras[0], {"flags": len(found.flags)}
    for k, camera in enumerate(found.cameras):
        out[f"stage{k}"] = heights(scene, k, first, camera) | scored(
            scene, k, camera, held_out
        )
        if k:
            residuals = found.residuals_mm(k)
            out[f"stage{k}"]["residual_mm"] = float(residuals.mean())
    return out


def heights(scene, k, first, camera):
    """What was found of the deflection from stage 0 to stage k."""
    start = load_height(scene.rig, first, scene.cameras[0])
    reached = load_height(scene.rig, camera, scene.cameras[k])
    found = {"height_mm": reached}
    if k:
        off = abs(reached - start - STAGES_MM[k]) / STAGES_MM[k]
        found["deflection_percent"] = 100 * off
    return found


def scoring_boards(scene, rng):
    """(T_camera_board, exact pixels (182, 2)) at 400 mm, for each stage."""
    found = []
    for k in range(len(scene.boards) + 1):
        T = scene.rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[k : k + 1])
        pixels, seen = scene.rig.corners(scene.cameras[k], T)
        found.append((T, np.where(seen[:, None], pixels, np.nan)))
    return found


def scored(scene, k, camera, held_out):
    """How far a calibrated camera of stage k is off the true one."""
    true, (T, pixels) = scene.cameras[k], held_out[k]
    points, rays = scene.rig.board.points(), lattice(true, COMPARED_PX)
    off = ray_angles(camera, true, rays)
    own, of_true = (
        lengths(back_projection(camera, pixels, points, where)) for where in (None, T)
    )
    return {
        "angle_deg": float(np.nanmean(off)),
        "largest_deg": float(np.nanmax(off)),
        "reach_percent": float(100 * np.isfinite(off).mean()),
        "back_own_mm": float(own.mean()),
        "back_true_mm": float(of_true.mean()),
    }
