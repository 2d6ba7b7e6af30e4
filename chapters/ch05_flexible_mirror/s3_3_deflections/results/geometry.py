"""Distances of a rig, and the share of a deflection that the linear stage finds."""

import numpy as np

from chapters.shared.mirror_rigs import DYNAMIC_MM, mirror_rig
from raxel.geometry import transform


def camera_mm(geometry="A"):
    """Distance from the camera to the middle of the mirror at stage 0, mm."""
    camera = mirror_rig(geometry).camera(0.0)
    half = camera.mirror.end / 2
    height = camera.mirror.height(np.array([half]), np.zeros(1))[0][0]
    on_mirror = np.array([[half, 0.0, height]])
    return float(np.linalg.norm(transform(camera.T_viewer_mirror, on_mirror)[0]))


def by_formula(geometry="A", depth_mm=DYNAMIC_MM):
    """Z / (Z + D): linear over true deflection, as derived in 5.3.1."""
    return depth_mm / (depth_mm + camera_mm(geometry))


def depth_for(share, geometry="A"):
    """The depth Z, mm, at which Z / (Z + D) has this value."""
    return camera_mm(geometry) * share / (1 - share)
