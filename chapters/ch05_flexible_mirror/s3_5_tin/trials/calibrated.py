"""Stage 3 of a bending mirror, calibrated as published and by all stages at once."""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_rigs import DYNAMIC_MM, STAGES_MM
from chapters.shared.mirror_runs import (
    PUBLISHED,
    MirrorMethod,
    deflected,
    primary,
    seen_board,
)
from raxel.calibration import BoardView, StageView, bundle_stages
from raxel.errors import CalibrationError

# Inverse depth, the clamp's slope too and the prior that `ext_mirror_prior_runs` chose
# on other seeds, mm.
AIMED = MirrorMethod("inverse depth", slope=True, prior_sd=0.1)
LAST = len(STAGES_MM) - 1
# How the last stage is known, the second as in the thesis.
EVERY_WAY = ("true", "published", "bundle")
SETTINGS = {"stages_mm": list(STAGES_MM), "grid_mm": DYNAMIC_MM, "prior_mm": 0.1}


class BentMirror(NamedTuple):
    """rig: MirrorRig; cameras: the true ones of all stages; errors: of its pictures;
    pictures: pixels (182, 2) of the board of step k, before and after it."""

    rig: object
    cameras: list
    errors: object
    pictures: list

    @property
    def true(self):
        """The camera that sees the tin."""
        return self.cameras[LAST]


def boards_by_hand(rig, rng):
    """T_camera_board (3, 4, 4) of the boards of all steps, held by hand."""
    steps_mm = [STAGES_MM[k : k + 2] for k in range(LAST)]
    return np.stack([rig.board_pose(rng, deflections=pair) for pair in steps_mm])


def bent_mirror(rig, bench, errors, T_camera_boards, rng):
    """The BentMirror of a bench, calibrated with boards that are held so."""
    seed = int(rng.integers(2**32))
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    pictures = []
    for k, T in enumerate(T_camera_boards):
        pair = cameras[k : k + 2]
        pictures.append([seen_board(rig, camera, T, errors, rng) for camera in pair])
    return BentMirror(rig, cameras, errors, pictures)


def calibrations(bent, seed, ways=EVERY_WAY):
    """{way: (camera of the last stage, "")}, or (None, why) where it was refused.

    Both ways draw the primary stage's errors from one seed.
    """
    found = {"true": (bent.true, "")} if "true" in ways else {}
    for way, method, last in (
        ("published", PUBLISHED, stage_by_stage),
        ("bundle", AIMED, all_stages),
    ):
        if way not in ways:
            continue
        rng = np.random.default_rng(seed)
        try:
            first = primary(bent.rig, bent.cameras[0], method, bent.errors, rng)
            found[way] = last(bent, first, method), ""
        except CalibrationError as refusal:
            found[way] = None, str(refusal)
    return found


def stage_by_stage(bent, first, method):
    """The camera of the last stage, each stage from the one before."""
    return steps(bent, first, method)[-1].camera


def all_stages(bent, first, method):
    """The camera of the last stage, of all stages and boards together."""
    found = steps(bent, first, method)
    cameras = [first.camera, *(stage.camera for stage in found)]
    poses = np.stack([stage.pose.T_camera_grid for stage in found])
    bundle = bundle_stages(
        cameras, views(bent), poses, clamp=first.clamp, prior_sd=method.prior_sd
    )
    return bundle.cameras[-1]


def steps(bent, first, method):
    """MirrorUpdates of stages 1 to 3."""
    found, before, points = [], first.camera, bent.rig.board.points()
    for pair, camera in zip(bent.pictures, bent.cameras[1:], strict=True):
        found.append(deflected(before, camera, pair, points, first.clamp, method))
        before = found[-1].camera
    return found


def views(bent):
    """StageViews of the board of each step, known to what corners scatter by."""
    board, points = bent.rig.board, bent.rig.board.points()
    sd = np.full(len(points), np.sqrt(np.mean(bent.errors.corner**2)))
    size = board.columns, board.rows
    return [
        StageView(k + after, k, BoardView(pixels, points, *size, sd=sd))
        for k, pair in enumerate(bent.pictures)
        for after, pixels in enumerate(pair)
    ]
