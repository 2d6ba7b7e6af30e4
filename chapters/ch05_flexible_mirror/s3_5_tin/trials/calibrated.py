"""Stage 3 of a bending mirror, calibrated stage by stage as published."""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_rigs import DYNAMIC_MM, STAGES_MM
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary, seen_board
from raxel.errors import CalibrationError

LAST = len(STAGES_MM) - 1
# Mirrors of the last stage, the second as in the thesis.
EVERY_WAY = ("true", "published")
SETTINGS = {"stages_mm": list(STAGES_MM), "grid_mm": DYNAMIC_MM}


class BentMirror(NamedTuple):
    """A bent mirror and its images.

    rig: MirrorRig; cameras: the true ones of all stages; errors: of its images;
    pictures: pixels (182, 2) of the board of step k, before and after it.
    """

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
    """The BentMirror at an error level, with boards in these poses."""
    seed = int(rng.integers(2**32))
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    pictures = []
    for k, T in enumerate(T_camera_boards):
        pair = cameras[k : k + 2]
        pictures.append([seen_board(rig, camera, T, errors, rng) for camera in pair])
    return BentMirror(rig, cameras, errors, pictures)


def calibrations(bent, seed, ways=EVERY_WAY):
    """{way: (camera of the last stage, "")}, or (None, code of the error).

    seed: of the errors of the primary stage.
    """
    found = {"true": (bent.true, "")} if "true" in ways else {}
    if "published" in ways:
        try:
            found["published"] = stage_by_stage(bent, seed), ""
        except CalibrationError as refusal:
            found["published"] = None, refusal.code
    return found


def stage_by_stage(bent, seed):
    """The camera of the last stage, each stage from the one before."""
    rng = np.random.default_rng(seed)
    first = primary(bent.rig, bent.cameras[0], PUBLISHED, bent.errors, rng)
    found, points = first.camera, bent.rig.board.points()
    for pair, true in zip(bent.pictures, bent.cameras[1:], strict=True):
        found = deflected(found, true, pair, points, first.clamp, PUBLISHED).camera
    return found
