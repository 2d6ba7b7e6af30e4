"""Three deflections of 5 mm, each calibrated from the one before (Tables 5.1 to 5.4).

A board is in front of the mirror, in another pose for each deflection. After each, an
active grid is decoded in two positions for reference, and a board at 400 mm is used for
back-projection.
"""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, STAGES_MM
from chapters.shared.mirror_runs import (
    COMPARED_PX,
    PUBLISHED,
    deflected,
    lattice,
    linearly_deflected,
    measured_rays,
    primary,
    seen_board,
)
from chapters.shared.mirror_scores import (
    back_projection,
    lengths,
    load_height,
    ray_angles,
)
from raxel.errors import CalibrationError
from raxel.geometry import inverse_pose, transform


def three_stages(rig, bench, errors, seed):
    """Primary stage and three deflections; `refused` is the code of a rejection.

    A rejected stage keeps its linear estimate, if there is one. The monitor's travel is
    estimated at all stages, since it does not depend on the mirror's shape.
    """
    rng = np.random.default_rng(seed)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    misses = first.calibration.mirror.misses
    scene = StageScene(rig, cameras, errors)
    viewer = first.camera.viewer
    anew = [measured_rays(rig, true, viewer, errors, rng) for true in cameras]
    own = measured_rays(rig, cameras[0], viewer, errors, rng, first)
    before, height = first.camera, load_height(rig, first.camera, cameras[0])
    out = {
        "miss_mm": float(np.nanmean(misses)),
        "miss_sd_mm": float(np.nanstd(misses, ddof=1)),
        "points": int(np.count_nonzero(np.isfinite(misses))),
        "stage0": scene.scored(0, before, rng)
        | own.against(before)
        | {f"anew_{name}": found for name, found in anew[0].against(before).items()},
    }
    for k in (1, 2, 3):
        out[f"stage{k}"] = anew[k].travel()
        if "refused" in out:
            continue
        T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
        pair = cameras[k - 1 : k + 1]
        pictures = [seen_board(rig, camera, T, errors, rng) for camera in pair]
        given = before, cameras[k], pictures, rig.board.points(), first.clamp, PUBLISHED
        try:
            stage = deflected(*given)
            found = of_deflection(rig, stage, height, cameras[k])
            found |= scene.scored(k, stage.camera, rng, stale=before)
        except CalibrationError as refusal:
            out["refused"] = refusal.code
            found = linear_alone(rig, given, height, cameras[k])
        else:
            found |= anew[k].against(stage.camera)
            before, height = stage.camera, found["height_mm"]
        out[f"stage{k}"] |= found
    return out


def linear_alone(rig, given, height, true):
    """Linear estimate of a rejected deflection, mm; nothing where there is none. given:
    as for `deflected`."""
    try:
        linear = linearly_deflected(*given)
    except CalibrationError:
        return {}
    return {"linear_mm": load_height(rig, linear, true) - height}


def of_deflection(rig, stage, height, true):
    """Estimated deflection of the mirror, and residuals of the refinement."""
    residuals = stage.residuals[np.isfinite(stage.residuals)]
    final = load_height(rig, stage.camera, true)
    return {
        "height_mm": final,
        "deflection_mm": final - height,
        "linear_mm": load_height(rig, stage.linear, true) - height,
        "residual_mm": float(residuals.mean()),
        "residual_sd_mm": float(residuals.std(ddof=1)),
        "swing_deg": stage.swing_deg,
        "common": len(residuals),
        "wrong": int(np.count_nonzero(stage.wrong)),
    }


class StageScene(NamedTuple):
    """The true cameras of stages 0 to 3 of a rig, and the errors of its images."""

    rig: object
    cameras: list
    errors: object

    def scored(self, k, camera, rng, stale=None):
        """Errors of a calibrated camera of stage k.

        stale: the camera before the deflection, on the same image.
        """
        true = self.cameras[k]
        pixels = lattice(true, COMPARED_PX)
        off = ray_angles(camera, true, pixels)
        moved = ray_angles(true, self.cameras[0], pixels)
        return {
            "angle_deg": float(np.nanmean(off)),
            "angle_sd_deg": float(np.nanstd(off, ddof=1)),
            "moved_deg": float(np.nanmax(moved)),
            "pixels": pixels,
            "off_deg": off,
            "sheet": sheet_places(true, pixels),
            **self._back_projected(k, camera, rng, stale),
        }

    def _back_projected(self, k, camera, rng, stale):
        """Errors on a board at 400 mm (Table 5.4)."""
        rig, points = self.rig, self.rig.board.points()
        T = rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[k : k + 1])
        pixels = seen_board(rig, self.cameras[k], T, self.errors, rng)
        own = back_projection(camera, pixels, points)
        out = {
            "back_mm": float(lengths(own).mean()),
            "back_sd_mm": float(lengths(own).std(ddof=1)),
            "back_true_mm": float(
                lengths(back_projection(camera, pixels, points, T)).mean()
            ),
            "corners": len(lengths(own)),
            "board_mm": points,
            "own": own,
            "seen_at": sheet_places(self.cameras[k], pixels),
        }
        if stale is not None:
            was = back_projection(stale, pixels, points)
            out |= {"stale_mm": float(lengths(was).mean()), "stale": was}
        return out


def sheet_places(true, pixels):
    """Points of the sheet that pixels (N, 2) see: shares (N, 2) of its length from the
    clamp and of its width, 0 to 1."""
    points = transform(inverse_pose(true.T_viewer_mirror), true.rays(pixels).origins)
    half = true.mirror.half_width
    return np.column_stack(
        [points[:, 0] / true.mirror.end, (points[:, 1] + half) / (2 * half)]
    )
