"""The picture a pinhole would have taken: undistortion through a camera's rays."""

from typing import NamedTuple

import numpy as np

from raxel.cameras.core.base import closest_point, pixel_grid
from raxel.cameras.lenses.perspective import PerspectiveCamera
from raxel.errors import InputError

STEP_PX = 4.0
GRID = 101
WIDEST = np.radians(60)
LEAST_SLOPE = 1e-9
BLOCK = 1 << 16
NOWHERE = -10.0
# Points stand for directions at this range, mm: beyond any mirror of the camera's.
FAR = 1e6


class PerspectiveView(NamedTuple):
    """A virtual pinhole at the camera's centre.

    K (3, 3) in pixels; R_camera_view (3, 3) turns directions of the view into the
    camera frame; centre (3,) in the camera frame; width, height in pixels.
    """

    K: np.ndarray
    R_camera_view: np.ndarray
    centre: np.ndarray
    width: int
    height: int

    def directions(self, pixels):
        """Unit directions (N, 3), in the camera frame, of the view's pixels (N, 2)."""
        homogeneous = np.column_stack((pixels, np.ones(len(pixels))))
        straight = homogeneous @ np.linalg.inv(self.K).T
        straight /= np.linalg.norm(straight, axis=1, keepdims=True)
        return straight @ self.R_camera_view.T


def perspective_view(camera):
    """The pinhole that shows what `camera` saw.

    A PerspectiveCamera keeps its K and loses its distortion. Any other central camera
    is looked along the ray nearest to the image's middle, with the image's u to the
    right: at the image's own scale there, or smaller, so that all rays within 60
    degrees of that one are in the picture. Raises InputError for a camera without a
    single centre, or with too few rays.
    """
    size = camera.width, camera.height
    if isinstance(camera, PerspectiveCamera):
        return PerspectiveView(camera.K, np.eye(3), np.zeros(3), *size)
    if not camera.central:
        raise InputError(
            f"camera of kind {camera.kind}: its rays do not meet in one point, so a "
            "perspective view would depend on the range; give a central camera"
        )
    middle, rays = _middle_rays(camera)
    ahead = rays.directions[0]
    right = (rays.directions[1] - rays.directions[2]) / (2 * STEP_PX)
    down = (rays.directions[3] - rays.directions[4]) / (2 * STEP_PX)
    x = right - ahead * (ahead @ right)
    x /= np.linalg.norm(x)
    R_camera_view = np.column_stack((x, np.cross(ahead, x), ahead))
    own_scale = 1 / np.sqrt(np.linalg.norm(right) * np.linalg.norm(down))
    focal = min(own_scale, _focal_that_holds(camera, R_camera_view, middle))
    K = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])
    return PerspectiveView(K, R_camera_view, closest_point(rays), *size)


def _focal_that_holds(camera, R_camera_view, middle):
    """The largest focal length (px) whose picture holds all rays within WIDEST."""
    size = np.array([camera.width, camera.height])
    rays = camera.rays(_grid(camera))
    seen = rays.directions[rays.valid] @ R_camera_view
    seen = seen[seen[:, 2] > np.cos(WIDEST)]
    slopes = seen[:, :2] / seen[:, 2:]
    room = np.where(slopes > 0, size - 1 - middle, middle)
    return float((room / np.maximum(np.abs(slopes), LEAST_SLOPE)).min())


def source_pixels(camera, view):
    """Where each pixel of the view comes from, (height, width, 2) float32.

    view: anything with `directions`, `centre`, `width` and `height`. The position is
    far outside the image where the camera does not see that direction.
    """
    sources = np.full((view.height * view.width, 2), NOWHERE, dtype=np.float32)
    rows = max(1, BLOCK // view.width)
    for top in range(0, view.height, rows):
        count = min(rows, view.height - top)
        pixels = pixel_grid(view.width, count) + [0, top]
        seen, valid = camera.project(FAR * view.directions(pixels) + view.centre)
        block = sources[top * view.width : (top + count) * view.width]
        block[valid] = seen[valid]
    return sources.reshape(view.height, view.width, 2)


def share_seen(sources, camera):
    """The share of a view's pixels whose `source_pixels` lie in the camera's image."""
    last = np.array([camera.width, camera.height]) - 0.5
    return float(((sources >= -0.5) & (sources <= last)).all(axis=-1).mean())


def resample(image, sources):
    """The image (H, W[, 3]) at `sources` (h, w, 2); black where there is nothing."""
    import cv2

    u, v = np.ascontiguousarray(sources[..., 0]), np.ascontiguousarray(sources[..., 1])
    return cv2.remap(image, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)


def _middle_rays(camera):
    """The pixel nearest to the middle that has rays all around, and those five rays.

    The rays are those of the pixel itself, then at STEP_PX right, left, below, above.
    """
    pixels = _grid(camera)
    middle = (np.array([camera.width, camera.height]) - 1) / 2
    order = np.argsort(np.linalg.norm(pixels - middle, axis=1), kind="stable")
    around = STEP_PX * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    crosses = pixels[order][:, None] + around
    valid = camera.rays(crosses.reshape(-1, 2)).valid.reshape(-1, 5).all(axis=1)
    if not valid.any():
        raise InputError(
            f"camera of kind {camera.kind}: no pixel has a ray with rays around it; "
            "calibrate with boards that cover more of the image"
        )
    cross = crosses[np.argmax(valid)]
    return cross[0], camera.rays(cross)


def _grid(camera):
    """GRID x GRID pixels spread over the image."""
    size = np.array([camera.width, camera.height])
    return pixel_grid(GRID, GRID) * (size - 1) / (GRID - 1)
