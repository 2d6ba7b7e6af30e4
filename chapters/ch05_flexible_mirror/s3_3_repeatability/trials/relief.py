"""Errors of relief that a spline cannot represent, at stage 0, and more knots.

The same viewer, monitor, platter and errors with a smooth mirror and with one with
relief; the primary stage alone, with several numbers of knots.
"""

import numpy as np

from chapters.shared.mirror_bench import ABERRATION_UM
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import (
    CLAMP_PICKS,
    CLAMP_SD_PX,
    PUBLISHED,
    calibrated_viewer,
    decoded,
    lattice,
    poses_in_platter,
    seen_board,
    shape_name,
)
from chapters.shared.mirror_scores import back_projection, lengths, ray_angles
from raxel.calibration.mirror.clamp_line import clamp_line
from raxel.calibration.mirror.primary import primary_from_points
from raxel.errors import CalibrationError

FEW, MANY = (7, 3), (14, 9)  # basis functions along u and v
# Four waves of 45 to 110 mm: relief of the first solved level, and none.
RELIEFS_UM = {"smooth": 0.0, "relief": ABERRATION_UM}
COMPARED_PX = 168


def relief_trial(condition, rng, errors):
    """Residuals of the primary stage, back-projection and rays, by mirror and shape."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    errors = errors[condition["geometry"]]
    viewer, true = calibrated_viewer(rig, errors, rng), rig.monitor_poses(rng)
    poses = poses_in_platter(rig, viewer, true, errors, rng)
    T = rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[:1])
    drawn, found = int(rng.integers(2**32)), {}
    for name, height_um in RELIEFS_UM.items():
        # The same draws before either mirror.
        again = np.random.default_rng(drawn)
        camera = rig.camera(STAGES_MM[0], height_um, seed)
        line = clamp_line(viewer, rig.clamp_pixels(camera, CLAMP_PICKS, again,
                                                   CLAMP_SD_PX))  # fmt: skip
        seen = decoded(rig, camera, true, errors, again)
        corners = seen_board(rig, camera, T, errors, again)
        for shape in (FEW, MANY):
            try:
                calibration = primary_from_points(
                    viewer, *seen, poses, shape=shape, angle=line.angle,
                    quantity=PUBLISHED.quantity, span=line.points(CLAMP_PICKS),
                )  # fmt: skip
            except CalibrationError as refusal:
                found[f"{name}.{shape_name(shape)}"] = {"refused": refusal.code}
                continue
            off = ray_angles(calibration.camera, camera, lattice(camera, COMPARED_PX))
            own = back_projection(calibration.camera, corners, rig.board.points())
            found[f"{name}.{shape_name(shape)}"] = {
                "residual_mm": float(calibration.residuals.mean()),
                "back_mm": float(lengths(own).mean()),
                "angle_deg": float(np.nanmean(off)),
            }
    return found
