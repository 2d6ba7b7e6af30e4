"""Fixed points picked in the image, unchanged and refined to a line."""

import numpy as np

from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import CLAMP_PICKS, PUBLISHED, lattice, outline
from chapters.shared.mirror_scores import load_height
from raxel.calibration.mirror.clamp import Clamp, clamp_of_camera
from raxel.calibration.mirror.clamp_line import clamp_line
from raxel.calibration.mirror.sightings import normalised
from raxel.calibration.mirror.update import update_mirror
from raxel.cameras import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry.spline_grid import spline_grid

# Standard deviations, px: of a pick, of one that was moved onto the edge, of a corner.
PICK_SD_PX, ON_EDGE_SD_PX, CORNER_SD_PX = 1.0, 0.1, 0.2
# px between the pixels that the first shape is fitted to.
FITTED_PX = 48
# Origin of the fixed value: the registry's options of clamp_value.
VALUES = {"at the pick": "pick", "of the fixed point": "point"}


def edge_trial(condition, rng):
    """Error of the estimated deflection, mm, after 5 mm, with picks and with a line;
    NaN where the stage is rejected.

    The first shape is the spline nearest to the true one, so that only corners and
    fixed points have errors.
    """
    rig = mirror_rig("A")
    first, second = (rig.camera(mm) for mm in STAGES_MM[:2])
    fixed = rig.clamp_pixels(first, CLAMP_PICKS)
    picks = fixed + PICK_SD_PX * rng.standard_normal(fixed.shape)
    onto_edge = fixed + ON_EDGE_SD_PX * rng.standard_normal(fixed.shape)
    before = nearest_spline(rig, first, np.concatenate([fixed, picks, onto_edge]))
    line = clamp_line(rig.viewer, onto_edge).points(CLAMP_PICKS)
    places = {"picked": normalised(rig.viewer, picks), "refined": line}
    T = rig.board_pose(rng, deflections=STAGES_MM[:2])
    pictures = [corners(rig, camera, T, rng) for camera in (first, second)]
    start = load_height(rig, before, first)
    out = {}
    for known in VALUES.values():
        for name, at in places.items():
            pixels = rig.viewer.project(np.column_stack([at, np.ones(len(at))])).pixels
            held = clamp_of_camera(before, pixels, slope=False)
            if known == "point":
                true = clamp_of_camera(before, fixed, slope=False)
                held = Clamp(held.points, true.values)
            out[f"{known}.{name}_mm"] = abs(
                travelled(rig, before, second, pictures, held) - start - STAGES_MM[1]
            )
    return out


def travelled(rig, before, true, pictures, held):
    """Estimated height at the load, mm; NaN where the stage is rejected."""
    try:
        found = update_mirror(
            before,
            *pictures,
            rig.board.points(),
            held,
            PUBLISHED.settings,
            outline=outline(true),
        )
    except CalibrationError:
        return np.nan
    return load_height(rig, found.camera, true)


def nearest_spline(rig, true, picks):
    """The published spline nearest to a true mirror, over its whole image and the
    pixels (N, 2) picked along its clamp."""
    edges = np.concatenate([outline(true), picks])
    grid = spline_grid(normalised(rig.viewer, edges), PUBLISHED.shape)
    points = true.rays(lattice(true, FITTED_PX)).origins
    return SplineMirrorCamera.fitted(rig.viewer, grid, points, PUBLISHED.quantity)


def corners(rig, camera, T_camera_board, rng):
    """Pixels of the board's corners with noise, NaN where not seen."""
    pixels, seen = rig.corners(camera, T_camera_board)
    noise = CORNER_SD_PX * rng.standard_normal(pixels.shape)
    return np.where(seen[:, None], pixels + noise, np.nan)
