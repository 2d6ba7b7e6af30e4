"""Predicted and true ray errors of three deflections, calibrated together.

No image is rendered: corners and decoded points have Gaussian errors.
"""

import numpy as np

from chapters.shared.gaussian_errors import CORNER_PX, GaussianErrors
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import (
    MirrorMethod,
    deflected,
    lattice,
    poses_in_platter,
    primary,
    seen_board,
)
from chapters.shared.mirror_scores import ray_angles
from raxel.calibration import BoardView, StageView, bundle_stages
from raxel.errors import CalibrationError

STEPS = len(STAGES_MM) - 1
# Inverse depth, the clamp's slope too, and a prior. Its SD, mm, has the least ray error
# at stage 3 among 1, 0.3, 0.1, 0.03, 0.01 and none, on eight runs of either geometry,
# smooth and uneven by 10 µm, that no other run has.
AIMED = MirrorMethod("inverse depth", slope=True, prior_sd=0.1)
COMPARED_PX = 96  # px between the pixels whose rays are compared


def trust_trial(condition, rng):
    """Root mean square ray errors over the whole mirror, degrees, by stage: true,
    predicted, and predicted without the misfit term."""
    rig, errors = mirror_rig(condition["geometry"]), GaussianErrors()
    um, seed = condition["aberration_um"], int(rng.integers(2**32))
    cameras = rig.stages(aberration_um=um, seed=seed)
    first = primary(rig, cameras[0], AIMED, errors, rng)
    # Not used: these draws keep those of the boards as they were.
    poses_in_platter(rig, first.camera.viewer, rig.monitor_poses(rng), errors, rng)
    pictures = []
    for k in range(STEPS):
        T = rig.board_pose(rng, deflections=STAGES_MM[k : k + 2])
        pair = cameras[k : k + 2]
        pictures.append([seen_board(rig, camera, T, errors, rng) for camera in pair])
    try:
        bundle = bundled(rig, cameras, first, pictures)
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    return {f"stage{k}": of_rays(bundle, k, cameras[k]) for k in range(1, STEPS + 1)}


def bundled(rig, cameras, first, pictures):
    """StageBundle of all stages and boards, from updates of each step."""
    board, points, updates = rig.board, rig.board.points(), []
    before, views = first.camera, []
    size, sd = (board.columns, board.rows), np.full(len(points), CORNER_PX)
    for k, pair in enumerate(pictures):
        update = deflected(before, cameras[k + 1], pair, points, first.clamp, AIMED)
        updates.append(update)
        before = update.camera
        views += [
            StageView(k + after, k, BoardView(pixels, points, *size, sd=sd))
            for after, pixels in enumerate(pair)
        ]
    return bundle_stages(
        [first.camera, *(update.camera for update in updates)],
        views,
        np.stack([update.pose.T_camera_grid for update in updates]),
        clamp=first.clamp,
        prior_sd=AIMED.prior_sd,
    )


def of_rays(bundle, k, true):
    """The errors of stage k. Both components of a direction have the predicted SD."""
    pixels = lattice(true, COMPARED_PX)
    off = np.radians(ray_angles(bundle.cameras[k], true, pixels))
    sd, misfit = bundle.ray_sd(k, pixels), bundle.misfit[k]
    return {
        "true_deg": _rms_degrees(off),
        "predicted_deg": _rms_degrees(np.sqrt(2) * sd),
        "without_deg": _rms_degrees(np.sqrt(2 * (sd**2 - misfit**2))),
    }


def _rms_degrees(angles):
    return float(np.degrees(np.sqrt(np.nanmean(angles**2))))
