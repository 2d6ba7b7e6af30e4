"""One run of SPFC2, watched: which stage of the code followed which (Fig. 5.4)."""

import sys
from collections import Counter
from itertools import pairwise

import numpy as np

from chapters.shared.mirror_bench import BENCHES, LEVEL
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import (
    BOARDS,
    PUBLISHED,
    deflected,
    primary,
    seen_board,
)
from raxel.errors import CalibrationError

# Stage -> the function that does it, as Python finds it: module and name.
MIRROR, POSE = "raxel.calibration.mirror.", "raxel.calibration.pose."
STAGES = {
    "viewer": "raxel.calibration.parametric.zhang.calibrate_zhang",
    "platter": MIRROR + "platter.grid_poses_in_platter",
    "line": MIRROR + "clamp_line.clamp_line",
    "rays": "raxel.calibration.generic.known_motion.rays_from_known_motion",
    "points": MIRROR + "primary_start.mirror_points",
    "shape": MIRROR + "linear.shape_up_to_scale",
    "scale": MIRROR + "linear.scaled_to_points",
    "first": MIRROR + "primary._refined",
    "held": MIRROR + "clamp_line.fixed_line",
    "pose": POSE + "non_central.pose_from_non_central_rays",
    "order": MIRROR + "update._not_exchanged",
    "knots": MIRROR + "update._knots",
    "linear": MIRROR + "linear.shape_with_clamp",
    "refine": MIRROR + "refine.refine_shape",
    "open": MIRROR + "edges.edge_flags",
}
REFUSED = "refused"


class Watch:
    """While it is entered: `order`, the stages as they begin, without the innermost.

    stages: name -> function, "module.name". What a stage calls of the others is a part
    of it and does not count.
    """

    def __init__(self, stages):
        self.names = {function: stage for stage, function in stages.items()}
        self.order, self._within = [], None

    def __enter__(self):
        sys.setprofile(self._saw)
        return self

    def __exit__(self, *_):
        sys.setprofile(None)

    def _saw(self, frame, event, _):
        if event == "call" and self._within is None:
            called = f"{frame.f_globals.get('__name__')}.{frame.f_code.co_name}"
            if called in self.names:
                self.order.append(self.names[called])
                self._within = frame
        elif event == "return" and frame is self._within:
            self._within = None

    def ways(self):
        """{"one > other": how often the one was followed by the other}."""
        return Counter(f"{a} > {b}" for a, b in pairwise(self.order))


def watched_trial(condition, rng, errors):
    """Transitions of one run of three deflections, with its inputs and results.

    A rejected stage ends the run, with its own transition.
    """
    rig, bench = mirror_rig("A"), BENCHES[LEVEL]
    errors = errors.on(bench)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=condition["seed"])
    points, stages, refused = rig.board.points(), [], {}
    with Watch(STAGES) as watch:
        first = primary(rig, cameras[0], PUBLISHED, errors, rng)
        before = first.camera
        for k in (1, 2, 3):
            pair = cameras[k - 1 : k + 1]
            T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
            pictures = [seen_board(rig, camera, T, errors, rng) for camera in pair]
            try:
                found = deflected(
                    before, pair[1], pictures, points, first.clamp, PUBLISHED
                )
            except CalibrationError as refusal:
                watch.order.append(REFUSED)
                refused = {"refused": refusal.code}
                break
            stages.append(found)
            before = found.camera
    return refused | {
        "ways": dict(watch.ways()),
        "boards": BOARDS,
        "positions": len(first.poses.T_camera_grid),
        "pixels": len(first.calibration.pixels),
        "mirror_points": int(first.calibration.mirror.valid.sum()),
        "primary_steps": len(first.calibration.costs) - 1,
        "coefficients": before.coefficients.size,
        **{f"stage{k}": counted(stage) for k, stage in enumerate(stages, 1)},
    }


def counted(stage):
    """What a MirrorUpdate had, and how many steps it took."""
    return {
        "posed": int(np.count_nonzero(stage.pose.inliers)),
        "common": int(np.count_nonzero(stage.used)),
        "steps": len(stage.fit.costs) - 1,
        "residual_mm": float(np.nanmean(stage.residuals)),
    }
