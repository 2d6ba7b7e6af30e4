"""A flat mirror beside a chessboard, on one plate: what shows where a monitor stands.

The silvered ring of a hard disk's platter lies on a board (thesis 5.2.1, Fig. 5.3b).
The board's corners give the mirror's plane; in the mirror the viewer sees the monitor.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from raxel.cameras.mirrors.planar import PlanarMirrorsCamera
from raxel.geometry.poses import pose
from raxel.lab.laboratory import Laboratory
from raxel.lab.scenes import board_scene
from raxel.lab.surfaces import Disc, Rectangle
from raxel.lab.textures import Plain

# Corners of the polygon along half of a rim.
RIM_CORNERS = 90
# How far the plate reaches beyond the mirror, mm, what it reflects, and how far it lies
# behind the board's face, mm.
PLATE_MARGIN_MM, PLATE, BEHIND_MM = 4.0, 0.25, 1e-3


class PlatterRing(NamedTuple):
    """centre_mm: (2,) of the ring in the board's plane, whose origin is the first
    interior corner; radius_mm, hub_mm: of the silver; thickness_mm: how far its face is
    before the board's, towards the viewer."""

    centre_mm: tuple[float, float]
    radius_mm: float
    hub_mm: float
    thickness_mm: float

    def T_board_mirror(self):
        """Pose (4, 4) of the silvered face: origin at its centre, z away from light."""
        return pose(np.eye(3), [*self.centre_mm, -self.thickness_mm])


def camera_in_platter(viewer, ring, T_camera_board):
    """The camera (PlanarMirrorsCamera) that sees the world in the ring alone.

    viewer: central camera; ring: PlatterRing on the board in pose T_camera_board
    (4, 4), mm. A ring is no polygon; its two halves are.
    """
    angle = np.linspace(0, np.pi, RIM_CORNERS)
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    half = np.concatenate([ring.radius_mm * rim, ring.hub_mm * rim[::-1]])
    T = T_camera_board @ ring.T_board_mirror()
    return PlanarMirrorsCamera(viewer, [T, T], [half, -half])


def photograph_plate(rig, ring, T_camera_board, rng):
    """The picture (H, W) of the board with the ring, which shows a dark room.

    rig: a Rig of a central camera before the board; ring: PlatterRing; T_camera_board:
    (4, 4), mm; rng: numpy Generator of the picture's noise.
    """
    scene = board_scene(rig.target, T_camera_board, rig.border_mm, **rig.radiances)
    disc = Disc(T_camera_board @ ring.T_board_mirror(), ring.radius_mm, ring.hub_mm)
    reach = ring.radius_mm + PLATE_MARGIN_MM
    corner = np.array(ring.centre_mm) - reach
    behind = T_camera_board @ pose(np.eye(3), [0, 0, BEHIND_MM])
    plate = Rectangle(behind, 2 * reach, 2 * reach, corner)
    parts = (disc, Plain(0.0)), *scene.parts, (plate, Plain(PLATE))
    laboratory = Laboratory(rig.camera, rig.sensor, rig.optics)
    light = laboratory.irradiance(replace(scene, parts=parts), np.eye(4))
    return rig.sensor.expose(light, rng, colour=False)
