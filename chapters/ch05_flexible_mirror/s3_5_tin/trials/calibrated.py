"""Stage 3 of a bending mirror, calibrated as published and by all stages at once."""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_bundle import AIMED, bundled
from chapters.shared.mirror_rigs import DYNAMIC_MM, STAGES_MM
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary, seen_board
from raxel.errors import CalibrationError

LAST = len(STAGES_MM) - 1
# How the last stage is known, the second as in the thesis.
EVERY_WAY = ("true", "published", "bundle")
SETTINGS = {
    "stages_mm": list(STAGES_MM),
    "grid_mm": DYNAMIC_MM,
    "prior_mm": AIMED.prior_sd,
}


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
    """{way: (camera of the last stage, "")}, or (None, code of the error).

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
            found[way] = None, refusal.code
    return found


def stage_by_stage(bent, first, method):
    """The camera of the last stage, each stage from the one before."""
    return steps(bent, first, method)[-1].camera


def all_stages(bent, first, method):
    """The camera of the last stage, of all stages and boards together."""
    bundle = bundled(
        bent.rig,
        first.camera,
        first.clamp,
        bent.pictures,
        steps(bent, first, method),
        bent.errors,
    )
    return bundle.cameras[-1]


def steps(bent, first, method):
    """MirrorUpdates of stages 1 to 3."""
    found, before, points = [], first.camera, bent.rig.board.points()
    for pair, camera in zip(bent.pictures, bent.cameras[1:], strict=True):
        found.append(deflected(before, camera, pair, points, first.clamp, method))
        before = found[-1].camera
    return found
