"""A chessboard 5 m away in an even mirror and in an uneven one, rendered (Fig. 5.6)."""

from dataclasses import replace

import numpy as np

from chapters.shared.mirror_bench import ABERRATION_UM
from chapters.shared.mirror_pictures import board_picture
from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import lattice
from raxel.sets import Chessboard

DEPTH_MM = 5000.0
# Columns, rows and pitch, mm, of a board that is large enough to be seen at 5 m.
BOARD = 24, 24, 120.0
# Free edges are bent by cutting as high as the mirror is uneven: the thesis names the
# strain (5.3.3), and not its size.
STRAIN_UM = ABERRATION_UM
# mm from the mirror at which rays are compared; px between them.
DEPTHS_MM, STEP_PX = (280.0, 1000.0, DEPTH_MM), 16
SETTINGS = {
    "depth_mm": DEPTH_MM,
    "board": list(BOARD),
    "aberration_um": ABERRATION_UM,
    "strain_um": STRAIN_UM,
}


def picture_trial(condition, rng):
    """Two pictures (h, w) uint8 of one board, and how far the uneven mirror moves it.

    moved.<depth>: mean mm by which what a pixel sees lies aside, at a depth. The camera
    is the small one, the same lens before 768 x 576 pixels.
    """
    rig = mirror_rig(condition["geometry"], small=True)
    rig = replace(rig, rig=replace(rig.rig, target=Chessboard(*BOARD)))
    seed = int(rng.integers(2**32))
    even, uneven = rig.camera(0.0), rig.camera(0.0, ABERRATION_UM, seed, STRAIN_UM)
    T = rig.board_pose(rng, DEPTH_MM)
    moved = {f"{depth:g}": aside(even, uneven, depth) for depth in DEPTHS_MM}
    return {
        "even": board_picture(rig, even, T, rng).picture,
        "uneven": board_picture(rig, uneven, T, rng).picture,
        "moved": moved,
    }


def aside(even, uneven, depth):
    """Mean distance (mm) of rays of the one mirror from where those of the other are.

    depth: mm along the even mirror's rays.
    """
    pixels = lattice(even, STEP_PX)
    first, second = even.rays(pixels), uneven.rays(pixels)
    away = first.origins + depth * first.directions - second.origins
    along = np.sum(away * second.directions, axis=1, keepdims=True)
    return float(np.nanmean(np.linalg.norm(away - along * second.directions, axis=1)))
