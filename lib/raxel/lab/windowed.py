"""A part of a rig's picture as a picture of its own.

Where a mirror fills only some of a large picture, the rest costs time and memory and
shows nothing. A windowed rig renders the rectangle alone: pixel (0, 0) of its pictures
is pixel (window.u, window.v) of the whole one, and lens and sensor treat it as they
would there.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from raxel.cameras.core.base import Camera, Projection, as_rows
from raxel.errors import InputError
from raxel.lab.sight import Crop

# Pixels around what is wanted: the point spread reaches less far.
MARGIN_PX = 16


class WindowedCamera(Camera):
    """The part `window` (a `Crop`) of a camera's picture. It is never written to disk.

    Pixels count from the window's own first pixel.
    """

    def __init__(self, camera, window):
        self.camera, self.window = camera, window
        self.width, self.height = window.width, window.height
        self.kind, self.continuous = camera.kind, camera.continuous
        self.projects = camera.projects
        self._first = np.array([window.u, window.v], float)

    @property
    def central(self):
        """As that of the camera."""
        return self.camera.central

    @property
    def parameters(self):
        """Those of the camera."""
        return self.camera.parameters

    def rays(self, pixels):
        """Rays of pixels (N, 2)."""
        return self.camera.rays(as_rows(pixels, 2) + self._first)

    def project(self, points):
        """Pixels of points (N, 3)."""
        pixels, valid = self.camera.project(points)
        return Projection(pixels - self._first, valid)

    def _fields(self):
        raise InputError(f"{self.kind}: a window of a picture; save the camera itself")

    @classmethod
    def _from_file(cls, file):
        raise InputError(f"{cls.kind}: no file holds a window of a camera's picture")


def windowed(rig, window):
    """The `Rig` that takes only the part `window` of its picture.

    Blur and vignetting are those of the same pixels of the whole picture; the lens's
    centre may lie beside the window. (Blooming and blur do not know what lies beyond.)
    """
    camera, optics = rig.camera, rig.optics
    low, high = (sd**2 for sd in optics.blur_sd_px)
    share = (window.width**2 + window.height**2) / (camera.width**2 + camera.height**2)
    centre = optics.centre(camera.width, camera.height) - [window.u, window.v]
    optics = replace(
        optics,
        blur_sd_px=(low**0.5, max(low + (high - low) * share, 0) ** 0.5),
        centre_px=tuple(map(float, centre)),
    )
    return replace(rig, camera=_windowed_camera(camera, window), optics=optics)


@lru_cache(maxsize=8)
def _windowed_camera(camera, window):
    """The same object for the same window, so that its smooth rays are kept."""
    return WindowedCamera(camera, window)


def window_around(camera, pixels, margin_px=MARGIN_PX):
    """The `Crop` of a camera's picture that holds pixels (N, 2), and a margin.

    Pixels that are NaN do not count. Raises InputError where none is in the picture.
    """
    full = np.array([camera.width, camera.height])
    inside = pixels[camera.in_image(pixels)]
    if not len(inside):
        raise InputError(
            "window: nothing of it is in the picture; turn the camera",
            code="outside-image",
        )
    low = np.floor(np.nanmin(pixels, axis=0)) - margin_px
    high = np.ceil(np.nanmax(pixels, axis=0)) + margin_px + 1
    low = np.clip(low, 0, full).astype(int)
    high = np.clip(high, 0, full).astype(int)
    return Crop(*map(int, (*low, *(high - low), *full)))


def mirror_window(camera):
    """The `Crop` that holds all that the sheet of a FlexibleMirrorCamera shows."""
    points = camera.mirror.point(camera.mirror.nodes().reshape(-1, 2))[0]
    T = camera.T_viewer_mirror
    pixels = camera.viewer.project(points @ T[:3, :3].T + T[:3, 3]).pixels
    return window_around(camera, pixels)


def bands(window, count, height_px):
    """`count` Crops of the window's whole width and `height_px` rows, evenly spaced.

    Where some thousand pixels are wanted all over a picture, these cost less than all.
    Raises InputError where the window has not so many rows.
    """
    if not 0 < count * height_px <= window.height:
        raise InputError(
            f"bands: {count} of {height_px} rows in {window.height}; give fewer"
        )
    middle = window.v + window.height * (np.arange(count) + 0.5) / count
    return [
        window._replace(v=int(v), height=int(height_px)) for v in middle - height_px / 2
    ]
