"""The camera and the grid of section 3.2.1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chapters.shared.synthetic_board import SIZE_PX
from raxel.calibration.views.correspondence import BoardView
from raxel.cameras import BrownCamera, Camera
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import pose, transform

SIDE_MM, MIDDLE_MM = 300.0, 150.0
FOCAL_MM, RADIAL = 680.0, (-0.8, 0.4)
PIXEL_MM = 0.3
POINTS = 500
SETTINGS = {
    "points": POINTS,
    "grid_mm": SIDE_MM,
    "f_mm": FOCAL_MM,
    "k": list(RADIAL),
    "pixel_mm": PIXEL_MM,
}


@dataclass(frozen=True, eq=False)
class GridScene:
    """A square grid of SIDE_MM in front of a camera, first corner at its origin."""

    camera: Camera
    T_camera_grid: np.ndarray

    def pixels(self, points):
        """Pixels of points (..., 2) mm of the grid; NaN if not visible."""
        flat = np.reshape(points, (-1, 2))
        seen = transform(self.T_camera_grid, on_plane(flat))
        return self.camera.project(seen).pixels.reshape(np.shape(points))

    def view(self, pitch_mm):
        """Its corners from border to border, as a BoardView."""
        count = round(SIDE_MM / pitch_mm) + 1
        row, column = np.divmod(np.arange(count**2), count)
        points = pitch_mm * np.column_stack([column, row])
        return BoardView(self.pixels(points), points, count, count)


def lens(share=1.0):
    """The camera of 3.2.1 with a share of its distortion.

    The grid is one focal length away (E-3.07) and fills the image of 1000 px. One
    pixel covers PIXEL_MM of it.
    """
    focal, middle = FOCAL_MM * SIZE_PX / SIDE_MM, (SIZE_PX - 1) / 2
    K = [[focal, 0, middle], [0, focal, middle], [0, 0, 1]]
    radial = tuple(share * np.array(RADIAL))
    camera = BrownCamera(K, radial, (0, 0), SIZE_PX, SIZE_PX)
    return GridScene(camera, facing(FOCAL_MM))


def facing(distance_mm):
    """Pose (4, 4) of the grid, fronto-parallel to the camera."""
    return pose(np.eye(3), [-MIDDLE_MM, -MIDDLE_MM, distance_mm])


def rms(errors):
    """Root mean square length of vectors (..., 2), NaN excluded."""
    return float(np.sqrt(np.nanmean(np.sum(np.square(errors), axis=-1))))
