"""A photograph as a camera without distortion would see it, through a given model."""

from __future__ import annotations

import numpy as np
from raxel.errors import InputError
from raxel.evaluation.distortion import corrected_view, synthetic_plane
from raxel.features.detector import as_8_bit
from raxel.geometry.poses import transform
from raxel.sets import read_image

SUPERSAMPLED = 2
MARGIN = 0.9  # corners lie within this share of the picture's half size
SMALLEST_ZOOM = 0.25
COVERED_PERCENT = 98  # of the corners; one near 90 degrees would shrink all


def reduced(image, width_px):
    """A smaller copy of an 8-bit picture, (h, width_px), averaged over areas."""
    import cv2

    height, width = image.shape
    if width <= width_px:
        return image
    size = width_px, max(1, round(height * width_px / width))
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA)


def undistorted(image_set, cameras, boards, width_px):
    """One photograph through every camera, with masks and corrected corners.

    The view looks where mid-image does, or towards the board where mid-image has no
    ray (a mirror sees the camera there). Both views have the magnification of the
    photograph at that pixel, times a common zoom that keeps the corners inside.
    """
    if not boards or not cameras:
        return {"reason": "no camera to look through"}
    board = _farthest_out(image_set, cameras, boards)
    planes, reasons, towards = _planes(image_set, cameras, board)
    shown = boards if towards == "mid-image" else [board]
    zoom = _zoom(image_set, cameras, planes, shown)
    image = as_8_bit(read_image(image_set, image_set.views[board.index]))
    result = {
        "reason": "",
        "view": board.index,
        "towards": towards,
        "zoom": zoom,
        "original": reduced(image, width_px),
        "corners": board.view.pixels,
    }
    for model, camera in cameras.items():
        result[model] = {"reason": reasons.get(model, "")}
        if model in planes:
            frame = _Frame(image_set, planes[model], zoom, width_px)
            result[model] |= frame.picture(camera, image)
            result[model]["corners"] = frame.corners(camera, board.view)
    return result


def _farthest_out(image_set, cameras, boards):
    """The board whose corners lie farthest from mid-image, where all have rays."""
    middle = np.array([image_set.width - 1, image_set.height - 1]) / 2

    def reach(board):
        pixels = board.view.pixels
        seen = np.all(
            [c.rays(pixels).valid for c in cameras.values()], axis=0
        )
        return np.mean(np.linalg.norm(pixels - middle, axis=1) * seen)

    return max(boards, key=reach)


def _planes(image_set, cameras, board):
    """{model: SyntheticPlane}, {model: reason}, and what the view looks at."""
    middle = np.array([image_set.width - 1, image_set.height - 1]) / 2
    towards = {
        "mid-image": middle,
        "the board": board.view.pixels.mean(axis=0),
    }
    for name, pixel in towards.items():
        planes, reasons = {}, {}
        for model, camera in cameras.items():
            try:
                planes[model] = synthetic_plane(camera, pixel)
            except InputError as refusal:
                reasons[model] = str(refusal)
        if not reasons:
            break
    return planes, reasons, name


def _zoom(image_set, cameras, planes, boards):
    """At most 1; smaller where the corners need a wider view."""
    half = np.array([image_set.width, image_set.height]) / 2
    zooms = [1.0]
    for model, plane in planes.items():
        pixels = np.concatenate([board.view.pixels for board in boards])
        rays = cameras[model].rays(pixels).directions
        seen, valid = corrected_view(rays, plane)
        offset = np.abs(seen[valid] - plane.principal_pixel) / half
        if len(offset):
            needed = np.percentile(offset.max(axis=1), COVERED_PERCENT)
            zooms.append(MARGIN / max(needed, 1e-9))
    return float(max(min(zooms), SMALLEST_ZOOM))


class _Frame:
    """A picture on a synthetic plane: its pixels, and where they lie there."""

    def __init__(self, image_set, plane, zoom, width_px):
        self.plane = plane
        width = min(width_px, image_set.width)
        self.shape = (
            round(width * image_set.height / image_set.width),
            width,
        )
        self.zoom = zoom * width / image_set.width

    def picture(self, camera, image):
        """{picture, mask}: grey as seen, and where the camera answers (255)."""
        import cv2

        fine = np.array(self.shape) * SUPERSAMPLED
        v, u = np.mgrid[: fine[0], : fine[1]] / SUPERSAMPLED
        offset = np.stack([u, v], axis=-1) - self._middle + self._half_step
        place = offset.reshape(-1, 2) / (self.zoom * self.plane.px_per_unit)
        points = transform(
            self.plane.T_camera_plane, np.pad(place, ((0, 0), (0, 1)))
        )
        pixels, valid = camera.project(points)
        valid &= camera.in_image(pixels)
        at = np.where(valid[:, None], pixels, -1e4).astype(np.float32)
        at = at.reshape(*fine, 2)
        grey = cv2.remap(image, at[..., 0], at[..., 1], cv2.INTER_LINEAR)
        mask = np.uint8(255) * valid.reshape(fine)
        return {"picture": self._reduced(grey), "mask": self._reduced(mask)}

    def corners(self, camera, view):
        """The board's corners in the picture (N, 2), NaN where there is no ray."""
        rays = camera.rays(view.pixels).directions
        seen, _ = corrected_view(rays, self.plane)
        return (
            seen - self.plane.principal_pixel
        ) * self.zoom + self._middle

    @property
    def _middle(self):
        return (np.array(self.shape[::-1]) - 1) / 2

    @property
    def _half_step(self):
        return (1 / SUPERSAMPLED - 1) / 2

    def _reduced(self, fine):
        import cv2

        return cv2.resize(
            fine, self.shape[::-1], interpolation=cv2.INTER_AREA
        )
