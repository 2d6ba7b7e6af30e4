"""Three deflections out and three back, and one step all the way back (Table 5.5).

On the way out, the board has another pose at each deflection. On the way back it is
fixed, so that the same images also calibrate from stage 3 to stage 0 in one step.
"""

import numpy as np

from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, STAGES_MM
from chapters.shared.mirror_runs import (
    COMPARED_PX,
    PUBLISHED,
    deflected,
    lattice,
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

# Stages that the mirror goes through.
LOOP = (0, 1, 2, 3, 2, 1, 0)
OUT = 3  # steps of the loop that go out


def loop(rig, bench, errors, seed):
    """Six steps and the single one; `refused` is the code of a rejection."""
    rng = np.random.default_rng(seed)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    boards, stay = boards_of_loop(rig, rng)
    scored = rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[:1])

    def step(before, start, end, T):
        """MirrorUpdate of one step, and how far it was found to go."""
        pictures = [seen_board(rig, cameras[k], T, errors, rng) for k in (start, end)]
        stage = deflected(
            before, cameras[end], pictures, rig.board.points(), first.clamp, PUBLISHED
        )
        return stage, travelled(rig, before, stage, cameras[start], cameras[end])

    def back(camera, k):
        T = scored
        if k:
            T = rig.board_pose(rng, BACK_PROJECTION_MM, STAGES_MM[k : k + 1])
        pixels = seen_board(rig, cameras[k], T, errors, rng)
        own = back_projection(camera, pixels, rig.board.points())
        true = back_projection(camera, pixels, rig.board.points(), T)
        off = ray_angles(camera, cameras[k], lattice(cameras[k], COMPARED_PX))
        return {
            "angle_deg": float(np.nanmean(off)),
            "back_mm": float(lengths(own).mean()),
            "back_sd_mm": float(lengths(own).std(ddof=1)),
            "back_true_mm": float(lengths(true).mean()),
            "own": own,
        }

    out = {"board_mm": rig.board.points(), "start": back(first.camera, 0)}
    camera, reached = first.camera, {}
    for number, T in enumerate([*boards, *(stay,) * OUT]):
        start, end = LOOP[number : number + 2]
        try:
            stage, found = step(camera, start, end, T)
            out[f"step{number + 1}"] = found | back(stage.camera, end)
        except CalibrationError as refusal:
            return out | {"refused": refusal.code}
        camera = reached[number + 1] = stage.camera
    try:
        stage, found = step(reached[OUT], LOOP[OUT], LOOP[-1], stay)
        return out | {"single": found | back(stage.camera, LOOP[-1])}
    except CalibrationError as refusal:
        return out | {"single_refused": refusal.code}


def boards_of_loop(rig, rng):
    """Boards of the three steps out, and the one that stays on the way back."""
    out = [rig.board_pose(rng, deflections=STAGES_MM[k : k + 2]) for k in range(OUT)]
    return out, rig.board_pose(rng, deflections=STAGES_MM)


def travelled(rig, before, stage, start, end):
    """How far the load was found to go, mm, linearly and finally, without sign."""
    height = load_height(rig, before, start)
    residuals = stage.residuals[np.isfinite(stage.residuals)]
    return {
        "linear_mm": abs(load_height(rig, stage.linear, end) - height),
        "deflection_mm": abs(load_height(rig, stage.camera, end) - height),
        "residual_mm": float(residuals.mean()),
        "residual_sd_mm": float(residuals.std(ddof=1)),
        "swing_deg": stage.swing_deg,
        "common": len(residuals),
    }
