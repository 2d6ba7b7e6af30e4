"""A chessboard 5 m away in a smooth and an uneven mirror, rendered (Fig. 5.6)."""

from dataclasses import replace

import numpy as np

from chapters.shared.mirror_bench import ABERRATION_UM
from chapters.shared.mirror_pictures import board_picture
from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import lattice
from raxel.sets import Chessboard

DEPTH_MM = 5000.0
# Columns, rows and pitch, mm, of a board large enough to be visible at 5 m.
BOARD = 24, 24, 120.0
# Strain from cutting at the free edges is as high as the unevenness: the thesis
# mentions it (5.3.3) without its size.
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
    """Two images (h, w) uint8 of one board, and its displacement in the uneven mirror.

    moved.<depth>: mean displacement, mm, of the point that a pixel sees at a depth. The
    camera is the small one, the same lens with 768 x 576 pixels.
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
    """Mean distance (mm) of the rays of one mirror from points on those of the other.

    depth: mm along the even mirror's rays.
    """
    pixels = lattice(even, STEP_PX)
    first, second = even.rays(pixels), uneven.rays(pixels)
    away = first.origins + depth * first.directions - second.origins
    along = np.sum(away * second.directions, axis=1, keepdims=True)
    return float(np.nanmean(np.linalg.norm(away - along * second.directions, axis=1)))
