"""The camera of 3.2.1 before its grid, and two that bend the grid more."""

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
# Of the square's side, between the points of a derivative.
STEP = 1e-3


@dataclass(frozen=True, eq=False)
class GridScene:
    """A square grid of SIDE_MM before a camera, its first corner at its origin."""

    camera: Camera
    T_camera_grid: np.ndarray

    def pixels(self, points):
        """Where points (..., 2) mm of the grid are seen, px; NaN out of sight."""
        flat = np.reshape(points, (-1, 2))
        seen = transform(self.T_camera_grid, on_plane(flat))
        return self.camera.project(seen).pixels.reshape(np.shape(points))

    def view(self, pitch_mm):
        """Its corners from rim to rim, as a BoardView."""
        count = round(SIDE_MM / pitch_mm) + 1
        row, column = np.divmod(np.arange(count**2), count)
        points = pitch_mm * np.column_stack([column, row])
        return BoardView(self.pixels(points), points, count, count)


def lens(share=1.0):
    """The camera of 3.2.1 with a share of its distortion.

    The grid stands one focal length away (E-3.07) and fills the picture: of 1000 px,
    each shows PIXEL_MM of it.
    """
    focal, middle = FOCAL_MM * SIZE_PX / SIDE_MM, (SIZE_PX - 1) / 2
    K = [[focal, 0, middle], [0, focal, middle], [0, 0, 1]]
    radial = tuple(share * np.array(RADIAL))
    camera = BrownCamera(K, radial, (0, 0), SIZE_PX, SIZE_PX)
    return GridScene(camera, facing(FOCAL_MM))


def facing(distance_mm):
    """Pose (4, 4) of the grid straight before a camera."""
    return pose(np.eye(3), [-MIDDLE_MM, -MIDDLE_MM, distance_mm])


def derivatives(scene, points):
    """First and second derivatives of the picture, taken back onto the grid.

    points: (N, 2) mm. Returns J (N, 2, 2) px per mm, whose columns are along x and y of
    the grid, and D_xx, D_xy, D_yy (N, 2) per mm: the second derivatives times J^-1.
    """
    h = STEP * SIDE_MM
    steps = h * np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1], indexing="ij"), -1)
    g = scene.pixels(points[:, None, None] + steps)
    J = np.stack([g[:, 2, 1] - g[:, 0, 1], g[:, 1, 2] - g[:, 1, 0]], -1)
    J = J / (2 * h)
    second = (
        g[:, 2, 1] - 2 * g[:, 1, 1] + g[:, 0, 1],
        (g[:, 2, 2] - g[:, 2, 0] - g[:, 0, 2] + g[:, 0, 0]) / 4,
        g[:, 1, 2] - 2 * g[:, 1, 1] + g[:, 1, 0],
    )
    back = np.linalg.inv(J)
    return J, *(np.einsum("nij,nj->ni", back, d) / h**2 for d in second)


def predicted_bias(scene, points, pitch_mm):
    """The bias (N, 2) mm of the enclosing cell's homography, to second order.

    The cell's second derivatives are those at its middle.
    """
    first = pitch_mm * np.minimum(points // pitch_mm, round(SIDE_MM / pitch_mm) - 1)
    _, xx, xy, yy = derivatives(scene, first + pitch_mm / 2)
    s, t = ((points - first) * (first + pitch_mm - points)).T
    x = (2 * xy[:, 1] - xx[:, 0]) * s - yy[:, 0] * t
    y = (2 * xy[:, 0] - yy[:, 1]) * t - xx[:, 1] * s
    return np.column_stack([x, y]) / 2


def rms(errors):
    """Root mean square length of vectors (..., 2), those that are NaN left out."""
    return float(np.sqrt(np.nanmean(np.sum(np.square(errors), axis=-1))))
