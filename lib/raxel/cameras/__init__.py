"""Cameras: bulk maps from pixels to rays and from points to pixels, each the inverse
of the other, with flags for pixels and points that have none.
"""

from raxel.cameras.base import Camera, Projection, Rays, pixel_grid
from raxel.cameras.fisheye import FisheyeCamera
from raxel.cameras.general import GeneralCamera
from raxel.cameras.io import load_camera
from raxel.cameras.perspective import PerspectiveCamera

__all__ = [
    "Camera",
    "FisheyeCamera",
    "GeneralCamera",
    "PerspectiveCamera",
    "Projection",
    "Rays",
    "load_camera",
    "pixel_grid",
]
