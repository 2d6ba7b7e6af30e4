"""How wide a field the bent mirror shows: by the beam, by the rig, as calibrated."""

import numpy as np

from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_scores import angles_between
from raxel.geometry import transform

INSET_MM = 2.0  # from the clamp and from the free edge, where the mirror is still seen


def end_pixels(true):
    """Pixels (2, 2) that see the sheet's middle line next to the clamp and next to the
    free edge."""
    x = np.array([INSET_MM, true.mirror.end - INSET_MM])
    z = true.mirror.height(x, np.zeros(2))[0]
    points = transform(true.T_viewer_mirror, np.column_stack([x, np.zeros(2), z]))
    return true.viewer.project(points).pixels


def field_of_view(camera, true):
    """Angle, degrees, between the scene rays of a camera next to the clamp and next to
    the free edge of the true one's mirror."""
    rays = camera.rays(end_pixels(true)).directions
    return float(angles_between(rays[:1], rays[1:])[0])


def beam_widening(load_mm, deflection_mm):
    """Degrees by which a field of view widens, as a beam has it whose load deflects it:
    twice the slope where the load acts (5.1)."""
    return float(np.degrees(2 * 3 * deflection_mm / (2 * load_mm)))


def widening(geometry):
    """Degrees by which the field of the true cameras has widened at stages 1 to 3."""
    rig = mirror_rig(geometry)
    fields = [field_of_view(camera, camera) for camera in rig.stages()]
    return [field - fields[0] for field in fields[1:]]


def beam_widenings(geometry):
    """The same by `beam_widening`."""
    load_mm = mirror_rig(geometry).load_mm
    return [beam_widening(load_mm, deflection) for deflection in STAGES_MM[1:]]
