"""What is found out about a mirror set: its calibration, or why there is none."""

import cv2
import numpy as np

from raxel.calibration.mirror.from_pictures import mirror_views
from raxel.calibration.mirror.stages import calibrate_mirror
from raxel.errors import InputError
from raxel.features.detector import as_8_bit
from raxel.report.mirror_pictures import heights, profiles
from raxel.sets import read_image


def settings_of(mirror_set):
    """What a reader has to know about the set."""
    stages = mirror_set.stages
    return {
        "set": mirror_set.name,
        "camera": stages.camera,
        "width_px": mirror_set.size[0],
        "height_px": mirror_set.size[1],
        "steps": [[step.before, step.after] for step in mirror_set.steps],
        "stated_mm": [step.deflection_mm for step in mirror_set.steps],
        "places": [view.label for view in mirror_set.grids.views],
        "licence": str(stages.origin.get("licence", "")),
        "source": str(stages.origin.get("source", "")),
    }


def calibration_of(mirror_set, width_px):
    """Shapes, residuals and flags of all stages; `reason` where it is refused."""
    try:
        found = calibrate_mirror(mirror_views(mirror_set))
    except InputError as refusal:
        return {"reason": str(refusal)}
    along, height = profiles(found)
    motion = found.primary.motions[0]
    out = {
        "reason": None,
        "along": along,
        "height": height,
        "flags": "\n".join(found.flags),
        "meet_mm": float(np.nanmean(found.primary.mirror.misses)),
        "apart_mm": motion.distance,
        "apart_sd_mm": motion.distance_sd,
        "variance": found.bundle.variance,
    }
    photographs = {view.label: view.photograph for view in mirror_set.stages.views}
    residuals = found.bundle.residuals
    for stage in range(len(found.cameras)):
        own = [k for k, view in enumerate(found.views) if view.stage == stage]
        name = found.views[own[0]].view.name
        image = as_8_bit(read_image(mirror_set.stages, photographs[name]))
        out[f"stage{stage}"] = {
            "shown": name,
            "corners": sum(np.isfinite(residuals[k][:, 0]).sum() for k in own),
            "residual_mm": float(np.mean(found.residuals_mm(stage))),
            "predicted_deg": predicted_deg(found.bundle, stage),
            "wrong": 0 if stage == 0 else found.updates[stage - 1].wrong.sum(),
            **pictured(found, stage, image, width_px),
            "pixels": np.concatenate([found.views[k].view.pixels for k in own]),
            "residuals": np.concatenate([residuals[k] for k in own]),
        }
    return out


def predicted_deg(bundle, stage):
    """Median standard deviation, degrees, of the rays of a stage's corners."""
    camera, p = bundle.cameras[stage], bundle.corners[stage]
    pixels = camera.viewer.project(np.column_stack([p, np.ones(len(p))])).pixels
    return float(np.degrees(np.nanmedian(bundle.ray_sd(stage, pixels))))


def pictured(found, stage, image, width_px):
    """A photograph, small (h, w) uint8, and heights (h, w) mm at its pixels."""
    coarser = max(1.0, image.shape[1] / width_px)
    size = round(image.shape[1] / coarser), round(image.shape[0] / coarser)
    u, v = np.meshgrid(*map(np.arange, size))
    pixels = (np.column_stack([u.ravel(), v.ravel()]) + 0.5) * coarser - 0.5
    height = heights(found, stage, pixels).reshape(u.shape)
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    return {"picture": small, "heights": height.astype(np.float32)}
