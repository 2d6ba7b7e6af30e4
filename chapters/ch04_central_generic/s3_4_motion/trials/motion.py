"""Motion of the target from matched rays (4.25), and how far it is off."""

from itertools import pairwise

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.trials.stage import (
    STEP_DEG,
    STEP_MM,
    STEPS,
)
from raxel.errors import CalibrationError
from raxel.geometry import vector_from_rotation
from raxel.multiview.epipolar import relative_pose


def motions(rays):
    """T_2_1 (steps, 4, 4) from each picture to the next, and the lost points.

    rays: (pictures, N, 3), NaN for corners without a ray. Raises
    CalibrationError where the rays of a pair leave its motion open.
    """
    found = []
    for first, second in pairwise(rays):
        both = np.isfinite(first[:, 0]) & np.isfinite(second[:, 0])
        found.append(relative_pose(first[both], second[both]).T_2_1)
    return np.stack(found)


def translation_errors(steps):
    """Deviation of steps from their mean, mm; each as long as the stage's step.

    steps: T_2_1 (5, 4, 4). `deviation_mm`: root mean square length of the
    differences from the mean step; `turn_deg`: largest rotation found, of none.
    """
    shifts = STEP_MM * steps[:, :3, 3]
    off = shifts - shifts.mean(axis=0)
    turns = np.linalg.norm(vector_from_rotation(steps[:, :3, :3]), axis=1)
    return {
        "deviation_mm": np.sqrt(np.mean(np.sum(off**2, axis=1))),
        "turn_deg": np.degrees(turns.max()),
        "shifts": shifts,
    }


def rotation_errors(steps):
    """Angle of all steps together, and how far it is from the stage's, degrees."""
    whole, turned = np.eye(3), []
    for T in steps:
        whole = T[:3, :3] @ whole
        turned.append(np.degrees(np.linalg.norm(vector_from_rotation(whole))))
    return {
        "total_deg": turned[-1],
        "off_deg": abs(turned[-1] - STEP_DEG * STEPS["rotation"]),
        "turned": np.array(turned),
    }


ERRORS = {"translation": translation_errors, "rotation": rotation_errors}


def scored(motion, rays):
    """Errors of a "translation" or "rotation", or why there are none."""
    try:
        return ERRORS[motion](motions(rays))
    except CalibrationError as error:
        return {"failed": error.code}
