"""Where corners fall when they are cast back onto their board, in mm (5.3.3).

Of a camera that has no centre, such as one that looks into a mirror. The board's pose
is the one that the camera itself finds: a shape that is wrong all over may hide in it,
so beside these errors stand those against a known shape where there is one.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.pose.non_central import pose_from_non_central_rays
from raxel.calibration.views.correspondence import check_view
from raxel.errors import CalibrationError
from raxel.geometry.planes import intersect_rays_plane


class BackProjection(NamedTuple):
    """Of one board: T_camera_grid (4, 4), its own pose, None where none was found, for
    `reason`; errors_mm (N, 2): where the rays of its corners meet its plane, less the
    corners, NaN where a corner was not found or has no ray."""

    name: str
    T_camera_grid: np.ndarray | None
    errors_mm: np.ndarray
    reason: str = ""

    @property
    def distances_mm(self):
        """Lengths (n,) of the errors that are known."""
        found = np.linalg.norm(self.errors_mm, axis=1)
        return found[np.isfinite(found)]


def back_projection(camera, view):
    """BackProjection of a BoardView, whose pose is found from the camera's rays."""
    view = check_view(view)
    rays = camera.rays(view.pixels)
    unknown = np.full(view.pixels.shape, np.nan)
    try:
        T = pose_from_non_central_rays(rays, view.points).T_camera_grid
    except CalibrationError as fault:
        return BackProjection(view.name, None, unknown, str(fault))
    met = intersect_rays_plane(rays.origins, rays.directions, T)
    return BackProjection(view.name, T, met.points - view.points)
