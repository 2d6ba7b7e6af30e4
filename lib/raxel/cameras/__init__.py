"""Cameras: bulk maps from pixels to rays and from points to pixels, each the inverse
of the other, with flags for pixels and points that have none.
"""

from raxel.cameras.base import Camera, Projection, Rays, pixel_grid
from raxel.cameras.brown import BrownCamera
from raxel.cameras.fisheye import FisheyeCamera
from raxel.cameras.general import GeneralCamera
from raxel.cameras.io import load_camera
from raxel.cameras.kannala_brandt import KannalaBrandtCamera
from raxel.cameras.perspective import PerspectiveCamera
from raxel.cameras.radial_laws import FieldOfViewCamera, MicusikPajdlaCamera
from raxel.cameras.rational import LiftedRationalCamera, RationalCubicCamera
from raxel.cameras.ray_polynomials import (
    DivisionCamera,
    ScaramuzzaCamera,
    TardifCamera,
)
from raxel.cameras.registry import CAMERAS, camera_from
from raxel.cameras.unified_sphere import UnifiedSphereCamera

__all__ = [
    "CAMERAS",
    "BrownCamera",
    "Camera",
    "DivisionCamera",
    "FieldOfViewCamera",
    "FisheyeCamera",
    "GeneralCamera",
    "KannalaBrandtCamera",
    "LiftedRationalCamera",
    "MicusikPajdlaCamera",
    "PerspectiveCamera",
    "Projection",
    "RationalCubicCamera",
    "Rays",
    "ScaramuzzaCamera",
    "TardifCamera",
    "UnifiedSphereCamera",
    "camera_from",
    "load_camera",
    "pixel_grid",
]
