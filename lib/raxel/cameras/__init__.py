"""Cameras: bulk maps from pixels to rays and from points to pixels, each the inverse
of the other, with flags for pixels and points that have none.
"""

from raxel.cameras.axial import AxialCamera
from raxel.cameras.base import Camera, Projection, Rays, pixel_grid
from raxel.cameras.bent_mirror import BentMirrorCamera
from raxel.cameras.brown import BrownCamera
from raxel.cameras.caustic import caustic_points
from raxel.cameras.centrality import centrality, closest_point
from raxel.cameras.fisheye import FisheyeCamera
from raxel.cameras.general import GeneralCamera
from raxel.cameras.io import load_camera
from raxel.cameras.kannala_brandt import KannalaBrandtCamera
from raxel.cameras.moving_pupil import MovingPupilCamera
from raxel.cameras.orthographic import OrthographicCamera
from raxel.cameras.perspective import PerspectiveCamera
from raxel.cameras.planar_mirrors import PlanarMirrorsCamera
from raxel.cameras.polar_polynomial import ShahAggarwalCamera
from raxel.cameras.pushbroom import PushbroomCamera
from raxel.cameras.quadric_mirror import QuadricMirrorCamera
from raxel.cameras.radial_laws import FieldOfViewCamera, MicusikPajdlaCamera
from raxel.cameras.rational import LiftedRationalCamera, RationalCubicCamera
from raxel.cameras.ray_polynomials import DivisionCamera, ScaramuzzaCamera, TardifCamera
from raxel.cameras.ray_spline import RaySplineCamera
from raxel.cameras.registry import CAMERAS, camera_from
from raxel.cameras.unified_sphere import UnifiedSphereCamera
from raxel.cameras.xslits import XSlitsCamera

__all__ = [
    "CAMERAS",
    "AxialCamera",
    "BentMirrorCamera",
    "BrownCamera",
    "Camera",
    "DivisionCamera",
    "FieldOfViewCamera",
    "FisheyeCamera",
    "GeneralCamera",
    "KannalaBrandtCamera",
    "LiftedRationalCamera",
    "MicusikPajdlaCamera",
    "MovingPupilCamera",
    "OrthographicCamera",
    "PerspectiveCamera",
    "PlanarMirrorsCamera",
    "Projection",
    "PushbroomCamera",
    "QuadricMirrorCamera",
    "RationalCubicCamera",
    "RaySplineCamera",
    "Rays",
    "ScaramuzzaCamera",
    "ShahAggarwalCamera",
    "TardifCamera",
    "UnifiedSphereCamera",
    "XSlitsCamera",
    "camera_from",
    "caustic_points",
    "centrality",
    "closest_point",
    "load_camera",
    "pixel_grid",
]
