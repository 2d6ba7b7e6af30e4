"""A film of a mirror that bends and is let back: its true cameras, and its start.

The rig is A with a quarter of the pixels each way, so that all its pictures can be
rendered. Before the film, camera and first shape are calibrated as in 5.3.3, with
Gaussian errors. The board is held once and stays.
"""

from typing import NamedTuple

import numpy as np

from chapters.shared.gaussian_errors import CORNER_PX, DECODED_MM, GaussianErrors
from chapters.shared.mirror_rigs import DYNAMIC_MM, STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import (
    CLAMP_PICKS,
    CLAMP_SD_PX,
    calibrated_viewer,
    decoded,
    outline,
    poses_in_platter,
)
from raxel.calibration.mirror.clamp_line import clamp_line, fixed_line
from raxel.calibration.mirror.primary import primary_from_points
from raxel.calibration.mirror.sightings import normalised
from raxel.calibration.mirror.update import MirrorSettings

# A pixel of the small rig is as wide as four of the camera's.
COARSER = 4
# px between the pixels of the first shape, and between those whose rays are compared.
DECODED_STEP_PX, COMPARED_PX = 16, 24
ERRORS = GaussianErrors(CORNER_PX / COARSER, DECODED_MM)
METHOD = MirrorSettings(noise_px=CORNER_PX / COARSER, prior_sd=0.1)
SETTINGS = {
    "corner_px": ERRORS.corner_px,
    "decoded_mm": ERRORS.decoded_mm,
    "grid_mm": DYNAMIC_MM,
    "prior_mm": METHOD.prior_sd,
}


class FilmedMirror(NamedTuple):
    """rig: MirrorRig; deflections (n,) mm; cameras: the true ones, a picture each;
    T_camera_board (4, 4); first: SplineMirrorCamera of the first shape; clamp:
    FixedLine."""

    rig: object
    deflections: np.ndarray
    cameras: list
    T_camera_board: np.ndarray
    first: object
    clamp: object


def drawn_film(steps, peak_mm, rng):
    """The FilmedMirror of a load that goes out to `peak_mm` in so many steps, and back.

    It starts, turns and stops gently, as a crank does.
    """
    rig = mirror_rig("A", small=True)
    deflections = peak_mm * np.sin(np.pi / 2 * np.linspace(0, 2, 2 * steps + 1)) ** 2
    cameras = [rig.camera(float(deflection)) for deflection in deflections]
    T = rig.board_pose(rng, deflections=STAGES_MM)
    return FilmedMirror(
        rig, deflections, cameras, T, *first_shape(rig, cameras[0], rng)
    )


def first_shape(rig, camera, rng):
    """(SplineMirrorCamera, FixedLine) of the mirror before the film.

    Its knots span the mirror's outline: flat, it fills more of the picture than bent.
    """
    viewer = calibrated_viewer(rig, ERRORS, rng)
    monitor = rig.monitor_poses(rng)
    poses = poses_in_platter(rig, viewer, monitor, ERRORS, rng)
    picks = rig.clamp_pixels(camera, CLAMP_PICKS, rng, CLAMP_SD_PX / COARSER)
    line = clamp_line(viewer, picks)
    found = primary_from_points(
        viewer,
        *decoded(rig, camera, monitor, ERRORS, rng, DECODED_STEP_PX),
        poses,
        shape=METHOD.shape,
        angle=line.angle,
        quantity="inverse depth",
        span=np.vstack([line.points(CLAMP_PICKS), normalised(viewer, outline(camera))]),
    )
    return found.camera, fixed_line(found.camera, line)
