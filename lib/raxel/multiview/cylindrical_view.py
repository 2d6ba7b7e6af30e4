"""The panorama around a camera: its picture unrolled from a cylinder.

Directions are given by azimuth, to the right of straight ahead, and elevation, upwards
from the horizon. A cylinder of radius f px shows a direction at
    u = u_0 + f azimuth,   v = v_0 - f tan(elevation):
what stands upright in the world becomes a column, the horizon a row.
"""

from typing import NamedTuple

import numpy as np

from raxel.cameras.core.base import closest_point, pixel_grid
from raxel.errors import InputError

# Rays at most this far from the horizon set the height of the picture.
STEEPEST = np.radians(75)
GRID = 401


class CylindricalView(NamedTuple):
    """An upright cylinder about the camera's centre, unrolled once around.

    radius and horizon (the row of elevation 0) in pixels; R_camera_view (3, 3) turns
    directions of the view, x right and y down, z to the middle column, into the camera
    frame; centre (3,) in the camera frame; width, height in pixels.
    """

    radius: float
    horizon: float
    R_camera_view: np.ndarray
    centre: np.ndarray
    width: int
    height: int

    @property
    def middle(self):
        """The column, px, of azimuth 0."""
        return (self.width - 1) / 2

    def elevations(self, rows):
        """Elevations, radians, of rows (N,) px."""
        return np.arctan((self.horizon - np.asarray(rows, float)) / self.radius)

    def directions(self, pixels):
        """Unit directions (N, 3), in the camera frame, of the view's pixels (N, 2)."""
        azimuth = (pixels[:, 0] - self.middle) / self.radius
        drop = (pixels[:, 1] - self.horizon) / self.radius
        out = np.column_stack([np.sin(azimuth), drop, np.cos(azimuth)])
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        return out @ self.R_camera_view.T

    def project(self, points):
        """Where the view shows points (N, 3) of the camera frame: (N, 2) px.

        NaN for points on the cylinder's axis. Behind the camera the picture begins
        anew: azimuth runs from -pi to pi.
        """
        x, y, z = ((points - self.centre) @ self.R_camera_view).T
        across = np.hypot(x, z)
        with np.errstate(divide="ignore", invalid="ignore"):
            v = self.horizon + self.radius * y / across
        u = self.middle + self.radius * np.arctan2(x, z)
        return np.where(across[:, None] > 0, np.column_stack([u, v]), np.nan)


def cylindrical_view(camera, down, ahead, width):
    """The cylinder that holds a central camera's rays, `width` px around.

    down: (3,) the axis of the cylinder, ahead: (3,) what the middle column looks at,
    both in the camera frame, of any length; ahead is made level. The height follows
    from the highest and the lowest ray within 75 degrees of the horizon, at the scale
    that the width has; rows end on the last whole pixel. Raises InputError for a
    camera without a single centre or such rays, and for directions that span no frame.
    """
    if not camera.central:
        raise InputError(
            f"camera of kind {camera.kind}: its rays do not meet in one point, so a "
            "panorama would depend on the range; give a central camera",
            code="not-central",
        )
    R_camera_view = _level_frame(down, ahead)
    size = np.array([camera.width, camera.height])
    rays = camera.rays(pixel_grid(GRID, GRID) * (size - 1) / (GRID - 1))
    x, y, z = (rays.directions[rays.valid] @ R_camera_view).T
    across = np.hypot(x, z)
    near = np.abs(y) <= np.tan(STEEPEST) * across
    if not near.any():
        raise InputError(
            f"camera of kind {camera.kind}: no ray is within "
            f"{np.degrees(STEEPEST):.0f} degrees of the horizon; is 'down' down?",
            code="outside-image",
        )
    radius = width / (2 * np.pi)
    drop = radius * y[near] / across[near]
    horizon = float(np.floor(-drop.min()))
    height = int(np.floor(drop.max() + horizon)) + 1
    return CylindricalView(
        radius, horizon, R_camera_view, closest_point(rays), width, height
    )


def _level_frame(down, ahead):
    """R_camera_view (3, 3): y down, z ahead made level, x to the right."""
    y = np.asarray(down, float)
    x = np.cross(y, np.asarray(ahead, float))
    sizes = np.linalg.norm(y), np.linalg.norm(x)
    if not min(sizes) > 0:
        raise InputError(
            f"found down {list(map(float, down))} and ahead {list(map(float, ahead))}; "
            "give two directions that are not parallel",
            code="parallel-directions",
        )
    y, x = y / sizes[0], x / sizes[1]
    return np.column_stack([x, y, np.cross(x, y)])
