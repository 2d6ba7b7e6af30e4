"""The three rigs of chapter 5 with a flexible mirror, by name: "A", "B" and "C".

`mirror_rig("A")` gives what the experiments of 5.3 use: the camera at every stage of
deflection, with aberration and strain as wanted; boards in hand-held poses in front of
the mirror, at least so many corners of which are seen at all the stages that are named;
the monitor's two positions; the platter on its chessboard; and the pixels of the
visible line that is nearest to the clamp. All is in the frame of the viewer, mm and
radians; a calibration is given boards, pixels and the size of the image alone.

A and B were chosen before any calibration was run with them, by one question alone: is
the target in view? C was chosen after all printed cells had been seen, by the turns of
the rays in Table 5.3 alone. The rigs are data/rigs/flexible-mirror-a.yaml, -b.yaml,
-c.yaml and those with -monitor.
"""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import PurePosixPath
from typing import NamedTuple

import numpy as np

from chapters.shared.rigs import rig_named
from raxel.cameras import FlexibleMirrorCamera
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.lab import Rig
from raxel.sets import Chessboard

# The rigs' files, for experiments to name among their inputs.
FILES = {
    "A": (
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
    ),
    "B": (
        "data/rigs/flexible-mirror-b.yaml",
        "data/rigs/flexible-mirror-b-monitor.yaml",
    ),
    "C": (
        "data/rigs/flexible-mirror-c.yaml",
        "data/rigs/flexible-mirror-c-monitor.yaml",
    ),
}
SMALL_FILES = {
    "A": (
        "data/rigs/flexible-mirror-a-small.yaml",
        "data/rigs/flexible-mirror-a-monitor-small.yaml",
    ),
    "B": (
        "data/rigs/flexible-mirror-b-small.yaml",
        "data/rigs/flexible-mirror-b-monitor-small.yaml",
    ),
}
# Deflections of stages 0 to 3 at the load, mm (5.3.3).
STAGES_MM = (0.0, 5.0, 10.0, 15.0)
# From mirror to board, mm: in dynamic calibration "less than 300", for back-projection
# "approximately 400" (5.3.3).
DYNAMIC_MM, BACK_PROJECTION_MM = 260.0, 400.0
# How a board is held by hand: tilt out of facing the mirror, turn in its own plane, and
# its middle off the middle of what the mirror shows, as a share of the distance.
TILT, TURN, ASIDE = np.radians(20), np.radians(8), 0.04
TRIES = 400
# Corners visible at all required stages: six for each of 21 spline coefficients
# would be 126; what the mirror of A shows at 260 mm has room for some 110.
MIN_CORNERS = 90
# A 1.8 inch hard disk's platter: outer and hub radius and thickness, mm. Larger ones
# leave no room in the image for a board next to them.
PLATTER_MM, HUB_MM, PLATTER_THICKNESS_MM = 24.0, 6.0, 0.381
# Its board: columns, rows, pitch, and where on it the middle of the platter is, mm: to
# one side, so that no corner is hidden.
PLATTER_BOARD, PLATTER_AT = (9, 13, 5.0), (72.0, 30.0)
# Its depth in front of the camera as a share of the clamp's.
PLATTER_DEPTH = 0.75


class Platter(NamedTuple):
    """A platter mirror on a chessboard, between camera and flexible mirror (5.3).

    board: the Chessboard; T_camera_board: (4, 4); centre_mm: (2,) the platter's in the
    board's plane; radius_mm, hub_mm: of the silvered ring; thickness_mm: of the
    platter, whose silvered face is so far in front of the board, towards the camera;
    T_board_off: (4, 4), by which the face is off that place, about its centre.
    """

    board: Chessboard
    T_camera_board: np.ndarray
    centre_mm: np.ndarray
    radius_mm: float
    hub_mm: float
    thickness_mm: float
    T_board_off: np.ndarray | None = None

    @property
    def T_camera_mirror(self):
        """Pose (4, 4) of the silvered face: origin at its centre, z away from light."""
        shift = [*self.centre_mm, -self.thickness_mm]
        T = self.T_camera_board @ pose(np.eye(3), shift)
        return T if self.T_board_off is None else T @ self.T_board_off


@lru_cache(maxsize=4)
def mirror_rig(name, small=False):
    """The `MirrorRig` of geometry "A", "B" or "C"; small, of A and B: with 768 x 576 px
    of four times the size, for images of quick builds and tests."""
    files = (SMALL_FILES if small else FILES)[name]
    return MirrorRig(name, *(rig_named(PurePosixPath(path).stem) for path in files))


@dataclass(frozen=True, eq=False)
class MirrorRig:
    """rig, monitor: `raxel.lab` rigs with a board and with an active grid, stage 0."""

    name: str
    rig: Rig
    monitor: Rig

    @property
    def viewer(self):
        """The perspective camera with its distortion."""
        return self.rig.camera.viewer

    @property
    def board(self):
        """The Chessboard of 14 x 13 corners, 18 mm apart."""
        return self.rig.target

    @property
    def load_mm(self):
        """How far from the clamp, along the sheet, the load acts."""
        return float(self.rig.camera.mirror.profile.loads[0])

    def camera(
        self, deflection, aberration_um=0.0, seed=None, strain_um=0.0, holder_mm=0.0
    ):
        """The FlexibleMirrorCamera at a deflection, mm, at its load.

        aberration_um: RMS of four waves of 45 to 110 mm, drawn from `seed` (whole
        number; the same at all deflections); strain_um: height of the free edges,
        falling off within 5 mm; holder_mm: length of sheet that the holder hides.
        """
        fields = self.rig.camera.arguments() | {
            "deflections": deflection,
            "aberration": aberration_um / 1000,
            "seed": 0 if seed is None else seed,
            "strain": strain_um / 1000,
            "holder": holder_mm,
        }
        return FlexibleMirrorCamera(**fields)

    def stages(self, **optional):
        """The cameras of stages 0 to 3; optional: as for `camera`."""
        return [self.camera(deflection, **optional) for deflection in STAGES_MM]

    def load_point(self, camera):
        """Point (3,) of the sheet's middle line where the load acts, viewer's frame."""
        x = camera.mirror.profile.places[:1]
        return _on_sheet(camera, x, np.zeros(1))[0]

    def deflection_direction(self):
        """Unit vector (3,), viewer's frame, along which a load deflects the sheet."""
        return self.rig.camera.T_viewer_mirror[:3, 2]

    def corners(self, camera, T_camera_board):
        """(pixels (182, 2), seen (182,)) of the board's corners, exact.

        seen: in the image, and shown by the mirror.
        """
        points = transform(T_camera_board, on_plane(self.board.points()))
        pixels, valid = camera.project(points)
        return pixels, valid & camera.in_image(pixels)

    def board_pose(
        self, rng, distance_mm=DYNAMIC_MM, deflections=(0.0,), least=MIN_CORNERS
    ):
        """T_camera_board (4, 4) of a board held in front of the mirror by hand.

        Its middle is `distance_mm` from the mirror, on the line that the mirror's
        middle shows on average over the `deflections` (mm), up to 4 % of the distance
        aside; it is tilted by up to 20 degrees and turned by up to 8. Drawn from `rng`
        until at least `least` corners are seen at all of the deflections and it hides
        the mirror from the viewer at none. Raises RuntimeError where none is found.
        """
        cameras = [self.camera(deflection) for deflection in deflections]
        for _ in range(TRIES):
            T = self._held(rng, distance_mm, cameras)
            seen = [self.corners(camera, T)[1] for camera in cameras]
            if np.all(seen, axis=0).sum() >= least and self.rig.shows(T):
                return T
        raise RuntimeError(
            f"geometry {self.name}: no pose of {TRIES} at {distance_mm} mm shows "
            f"{least} corners at all of {deflections} mm"
        )

    def clamp_pixels(self, camera, count=9, rng=None, noise_px=0.0):
        """Pixels (count, 2) along the visible line that is nearest to the clamp.

        It is the clamp's own line, or the edge of the holder where the camera has one:
        then the line is `camera.mirror.holder` mm along the sheet from the clamp.
        Spread over nine tenths of the mirror's width; noise_px: standard deviation of
        each coordinate, drawn from `rng`.
        """
        mirror = camera.mirror
        y = 0.9 * mirror.half_width * np.linspace(-1, 1, count)
        x = np.full(count, mirror.holder)
        if mirror.holder:
            x = x - (mirror.flat(x, y)[0] - mirror.holder)
        pixels = self.viewer.project(_on_sheet(camera, x, y)).pixels
        if noise_px:
            pixels = pixels + rng.normal(0, noise_px, pixels.shape)
        return pixels

    def monitor_poses(self, rng=None):
        """T_camera_monitor (2, 4, 4): the active grid's near and far position.

        Exactly 100 mm of translation apart; with `rng`, each off by what vibration
        during the travel leaves (0.1 mm and 0.05 degrees, standard deviations).
        """
        poses = self.monitor.poses.poses.copy()
        if rng is not None:
            for T in poses:
                T[:3, 3] += rng.normal(0, 0.1, 3)
                turn = rotation_from_vector(rng.normal(0, np.radians(0.05), 3))
                T[:3, :3] = turn @ T[:3, :3]
        return poses

    def platter(self, rng=None):
        """The `Platter`, so turned that the viewer sees both monitor positions in it.

        It is in front of the flexible mirror, its silver in the middle of the image,
        its board at the side that is farther away. rng: draws how far it is off by
        hand, 2 mm and 1 degree.
        """
        board = Chessboard(*PLATTER_BOARD)
        depth = PLATTER_DEPTH * self.rig.camera.T_viewer_mirror[2, 3]
        middle = np.array([0.0, 0.0, depth])
        towards = self._monitor_middles().mean(axis=0) - middle
        R = _facing(np.array([0, 0, 1]) - towards / np.linalg.norm(towards))
        if rng is not None:
            R = rotation_from_vector(rng.normal(0, np.radians(1), 3)) @ R
            middle = middle + rng.normal(0, 2, 3)
        on_board = [*PLATTER_AT, -PLATTER_THICKNESS_MM]
        T = pose(R, middle - R @ on_board)
        ring = PLATTER_MM, HUB_MM
        return Platter(board, T, np.array(PLATTER_AT), *ring, PLATTER_THICKNESS_MM)

    def _monitor_middles(self):
        corner, size = self.monitor.extent
        middle = on_plane((corner + size / 2)[None])
        return np.concatenate([transform(T, middle) for T in self.monitor_poses()])

    def _held(self, rng, distance_mm, cameras):
        origin, direction = np.mean([_middle_ray(camera) for camera in cameras], axis=0)
        direction /= np.linalg.norm(direction)
        azimuth = rng.uniform(0, 2 * np.pi)
        tilt = rng.uniform(0, TILT) * np.array([np.cos(azimuth), np.sin(azimuth), 0])
        turn = np.array([0, 0, rng.uniform(-TURN, TURN)])
        R = _facing(direction) @ rotation_from_vector(tilt) @ rotation_from_vector(turn)
        aside = _facing(direction)[:, :2] @ rng.uniform(-ASIDE, ASIDE, 2)
        middle = origin + distance_mm * (direction + aside)
        return pose(R, middle - R @ [*np.ptp(self.board.points(), axis=0) / 2, 0])


def _facing(direction):
    """Rotation (3, 3) whose z axis lies along a direction (3,), its x axis level."""
    z = direction / np.linalg.norm(direction)
    x = np.cross([0, 1, 0], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _middle_ray(camera):
    """Where on the mirror its middle is, and the direction it shows: (2, 3)."""
    middle = _on_sheet(camera, np.array([camera.mirror.end / 2]), np.zeros(1))
    rays = camera.rays(camera.viewer.project(middle).pixels)
    return np.stack([rays.origins[0], rays.directions[0]])


def _on_sheet(camera, x, y):
    z = camera.mirror.height(x, y)[0]
    return transform(camera.T_viewer_mirror, np.column_stack([x, y, z]))


# The files of the three rigs of chapter 5, for experiments to name as their inputs.


GEOMETRY_A = (
    "data/rigs/flexible-mirror-a.yaml",
    "data/rigs/flexible-mirror-a-monitor.yaml",
)
GEOMETRY_B = (
    "data/rigs/flexible-mirror-b.yaml",
    "data/rigs/flexible-mirror-b-monitor.yaml",
)
BOTH = (
    "data/rigs/flexible-mirror-a.yaml",
    "data/rigs/flexible-mirror-a-monitor.yaml",
    "data/rigs/flexible-mirror-b.yaml",
    "data/rigs/flexible-mirror-b-monitor.yaml",
)
ALL_THREE = (
    "data/rigs/flexible-mirror-a.yaml",
    "data/rigs/flexible-mirror-a-monitor.yaml",
    "data/rigs/flexible-mirror-b.yaml",
    "data/rigs/flexible-mirror-b-monitor.yaml",
    "data/rigs/flexible-mirror-c.yaml",
    "data/rigs/flexible-mirror-c-monitor.yaml",
)
GEOMETRY_C = (
    "data/rigs/flexible-mirror-c.yaml",
    "data/rigs/flexible-mirror-c-monitor.yaml",
)
SMALL_A = (
    "data/rigs/flexible-mirror-a-small.yaml",
    "data/rigs/flexible-mirror-a-monitor-small.yaml",
)
