"""Three pushes of 5 mm, calibrated from boards and from unknown scenes.

Over 5 mm no feature of a distant scene remains in the last knot interval, so each push
is self-calibrated in two steps of 2.5 mm. Whether one step is rejected is kept too.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.trials.scene import (
    Field,
    SceneFrame,
    features,
)
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.stereo import (
    between_states,
    four_views,
)
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import (
    COMPARED_PX,
    PUBLISHED,
    deflected,
    lattice,
    outline,
    primary,
    seen_board,
)
from chapters.shared.mirror_scores import (
    back_projection,
    lengths,
    load_height,
    ray_angles,
)
from raxel.calibration.mirror.self_calibration import linear_update
from raxel.errors import CalibrationError
from raxel.geometry import transform

STEPS_MM = (0.0, 2.5, 5.0, 7.5, 10.0, 12.5, 15.0)
# Features of a run: (clustered, near ones at the free end). The first is that of 5.4.
SCENES = {
    "told": (True, True),
    "clustered": (True, False),
    "near": (False, True),
    "even": (False, False),
}
# Scenes for which back-projection with an estimated pose is measured.
OWN_POSE = ("told", "even")
# Places along the sheet's middle line, and across it at the load, mm.
ALONG_MM, ACROSS_MM = np.linspace(5.0, 150.0, 30), np.linspace(-40.0, 40.0, 9)
NEWTON_STEPS = 8


def course_trial(condition, rng, errors, benches, pushes):
    """Run all pushes at each of some error levels, with the same draws."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    of_rig = errors[condition["geometry"]]
    return {
        name: course(rig, bench, of_rig.on(bench), seed, pushes)
        for name, bench in benches.items()
    }


def course(rig, bench, errors, seed, pushes):
    """Calibrate from boards and scenes, and reconstruct between the states.

    `X.refused`: code of the error that ended a method.

    stage{k} of `board` and of each of SCENES; `whole.refused`: of 5 mm in one step.
    """
    rng = np.random.default_rng(seed)
    steps_mm = STEPS_MM[: 2 * pushes + 1]
    cameras = [rig.camera(mm, bench.aberration_um, seed) for mm in steps_mm]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    stages = cameras[::2]
    boards = [
        (T, seen_board(rig, camera, T, errors, rng))
        for mm, camera in zip(steps_mm[::2], stages, strict=True)
        for T in [rig.board_pose(rng, BACK_PROJECTION_MM, (mm,))]
    ]
    view = SceneFrame.of(cameras[0])
    score = _Scores(rig, stages, boards, load_height(rig, first.camera, cameras[0]))
    board, chain = by_boards(rig, stages, first, score, errors, rng)
    fields = [Field(camera) for camera in cameras]
    found = {"board": board}
    for name, kind in SCENES.items():
        points, _ = features(view, fields, rng, *kind)
        seen = [field.pictured(points, errors, rng) for field in fields]
        found[name] = by_scene(cameras, first, seen, score, name in OWN_POSE)
    found["whole"] = in_one_step(cameras, first, seen)
    found["stereo"] = between_states(rig, view, fields[::2], chain, errors, rng)
    found["multi"] = four_views(view, fields[::2], chain, errors, rng)
    return found


class _Scores:
    """Errors of a calibrated camera at a stage."""

    def __init__(self, rig, stages, boards, height):
        self.rig, self.stages, self.boards, self.height = rig, stages, boards, height

    def angle(self, k, camera):
        """Mean angle to the true rays, degrees."""
        true = self.stages[k]
        return float(np.nanmean(ray_angles(camera, true, lattice(true, COMPARED_PX))))

    def stage(self, k, camera, height, own=True):
        """Errors at stage k.

        height: of the load at the stage before, as estimated; own: whether to measure
        back-projection with an estimated pose, too.
        """
        points, (T, pixels) = self.rig.board.points(), self.boards[k]
        found = load_height(self.rig, camera, self.stages[k])
        true = back_projection(camera, pixels, points, T)
        middle = np.column_stack([ALONG_MM, 0 * ALONG_MM])
        load = np.full(len(ACROSS_MM), self.rig.load_mm)
        across = beyond(self.rig, camera, self.stages[k], load, ACROSS_MM)
        out = {
            "deflection_mm": found - height,
            "height_mm": found,
            "back_true_mm": float(lengths(true).mean()),
            "angle_deg": self.angle(k, camera),
            "profile_mm": beyond(self.rig, camera, self.stages[k], *middle.T)
            + self.stages[k].mirror.height(*middle.T)[0],
            "sag_mm": float(across[[0, -1]].mean() - across[len(across) // 2]),
        }
        if own:
            by_own_pose = back_projection(camera, pixels, points)
            out["back_mm"] = float(lengths(by_own_pose).mean())
        return out


def by_boards(rig, stages, first, score, errors, rng):
    """Scores of the published method, and its cameras from stage 0 on."""
    out, chain, height = {}, [first.camera], score.height
    for k in range(1, len(stages)):
        T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
        pair = stages[k - 1 : k + 1]
        seen = [seen_board(rig, camera, T, errors, rng) for camera in pair]
        try:
            stage = deflected(
                chain[-1], stages[k], seen, rig.board.points(), first.clamp, PUBLISHED
            )
            found = score.stage(k, stage.camera, height)
        except CalibrationError as refusal:
            return out | {"refused": refusal.code}, chain
        found["linear_mm"] = load_height(rig, stage.linear, stages[k]) - height
        out[f"stage{k}"], height = found, found["height_mm"]
        chain.append(stage.camera)
    return out, chain


def by_scene(cameras, first, seen, score, own):
    """Linear self-calibration, two steps for a stage; seen: pixels (N, 2) of each."""
    out, before, height = {}, first.camera, score.height
    for j, camera in enumerate(cameras[1:], 1):
        try:
            before = linear_update(
                before, seen[j - 1], seen[j], first.clamp, PUBLISHED.settings,
                outline=outline(camera),
            ).camera  # fmt: skip
            if j % 2:
                continue
            out[f"stage{j // 2}"] = score.stage(j // 2, before, height, own)
        except CalibrationError as refusal:
            return out | {"refused": refusal.code}
        height = out[f"stage{j // 2}"]["height_mm"]
    return out


def in_one_step(cameras, first, seen):
    """Whether 5 mm in one step are rejected, from the evenly spread far scene."""
    try:
        linear_update(
            first.camera, seen[0], seen[2], first.clamp, PUBLISHED.settings,
            outline=outline(cameras[2]),
        )  # fmt: skip
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    return {"went": 1.0}


def beyond(rig, found, true, x, y):
    """Displacement (n,) mm of a calibrated mirror from the true one, along the push.

    x, y: (n,) mm, positions on the sheet.
    """
    along = rig.deflection_direction()
    z = true.mirror.height(x, y)[0]
    points = transform(true.T_viewer_mirror, np.column_stack([x, y, z]))
    shift = np.zeros(len(points))
    for _ in range(NEWTON_STEPS):
        P = points + shift[:, None] * along
        S = found.mirror.points(P[:, :2] / P[:, 2:])
        n = found.mirror.normals(S)
        shift += np.sum(n * (S - P), axis=1) / (n @ along)
    return shift
