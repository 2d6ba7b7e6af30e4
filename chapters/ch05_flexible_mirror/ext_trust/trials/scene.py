"""What a seed sees: a mirror at four stages, its primary calibration, and pictures.

Drawn once for all the ways in which the stages are calibrated, so that these differ in
nothing else. No picture is rendered: corners and decoded points have Gaussian errors.
"""

from typing import NamedTuple

import numpy as np

from chapters.shared.gaussian_errors import CORNER_PX, DECODED_MM, GaussianErrors
from chapters.shared.mirror_rigs import (
    BACK_PROJECTION_MM,
    DYNAMIC_MM,
    STAGES_MM,
    mirror_rig,
)
from chapters.shared.mirror_runs import (
    MirrorMethod,
    poses_in_platter,
    primary,
    seen_board,
)
from raxel.geometry import inverse_pose, transform
from raxel.geometry.planes import on_plane

STEPS = len(STAGES_MM) - 1
# Inverse depth, the clamp's position and slope; no prior.
METHOD = MirrorMethod("inverse depth", slope=True)
# The ways that are compared. The prior's strength, mm, is that of least ray error at
# stage 3 in `ext_mirror_prior_runs`: of the medians of its seeds, the geometric mean
# over both geometries, smooth and uneven. One for all, on seeds that no other run has.
PRIORS = {"prior": 0.1, "plain": None}
SETTINGS = {
    "corner_px": CORNER_PX,
    "decoded_mm": DECODED_MM,
    "stages_mm": list(STAGES_MM),
    "grid_mm": DYNAMIC_MM,
    "prior_mm": PRIORS["prior"],
}


class SureViewer(GaussianErrors):
    """The same but for boards that the viewer sees directly, so that it is exact."""

    def corners(self, pixels, rng):
        """Pixels (N, 2) of corners, as they are."""
        return pixels


class TrustScene(NamedTuple):
    """rig: MirrorRig; cameras: the true ones of stages 0 to 3; first: Primary;
    separation: mm and degrees by which the monitor's motion was found wrong; pictures:
    pixels (182, 2) of the board of step k before and after it; stay: of one board at
    all stages; scored: (pixels, T_camera_board) at 400 mm of stages 1 to
    3."""

    rig: object
    cameras: list
    first: object
    separation: tuple
    pictures: list
    stay: list
    scored: list

    @property
    def points(self):
        """Points (182, 2) mm of the board."""
        return self.rig.board.points()


def drawn_scene(geometry, aberration_um, rng, at_first=None):
    """The TrustScene of a geometry, "A" or "B"; at_first: the errors of the primary
    stage, where they are others."""
    rig, errors = mirror_rig(geometry), GaussianErrors()
    seed = int(rng.integers(2**32))
    cameras = rig.stages(aberration_um=aberration_um, seed=seed)
    first = primary(rig, cameras[0], METHOD, at_first or errors, rng)
    separation = separation_errors(rig, first.camera.viewer, errors, rng)
    pictures = []
    for k in range(STEPS):
        T = rig.board_pose(rng, deflections=STAGES_MM[k : k + 2])
        pictures.append(
            [seen_board(rig, c, T, errors, rng) for c in cameras[k : k + 2]]
        )
    T = rig.board_pose(rng, deflections=STAGES_MM)
    stay = [seen_board(rig, camera, T, errors, rng) for camera in cameras]
    scored = []
    for camera, deflection in zip(cameras[1:], STAGES_MM[1:], strict=True):
        T = rig.board_pose(rng, BACK_PROJECTION_MM, (deflection,))
        scored.append((seen_board(rig, camera, T, errors, rng), T))
    return TrustScene(rig, cameras, first, separation, pictures, stay, scored)


def separation_errors(rig, viewer, errors, rng):
    """By how much the platter gets the monitor's motion wrong: mm in the length of the
    shift of the monitor's middle, and degrees in the rotation."""
    true = rig.monitor_poses(rng)
    found = poses_in_platter(rig, viewer, true, errors, rng).T_camera_grid
    corner, size = rig.monitor.extent
    middle = on_plane((corner + size / 2)[None])
    shifts = [
        np.linalg.norm(transform(T[1], middle) - transform(T[0], middle))
        for T in (found, true)
    ]
    turns = [(inverse_pose(T[0]) @ T[1])[:3, :3] for T in (found, true)]
    cosine = (np.trace(turns[0] @ turns[1].T) - 1) / 2
    angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return abs(shifts[0] - shifts[1]), float(angle)
