"""Cameras: bulk maps from pixels to rays and from points to pixels, each the inverse
of the other, with flags for pixels and points that have none.
"""

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    centrality,
    closest_point,
    pixel_grid,
)
from raxel.cameras.core.caustic import caustic_points
from raxel.cameras.lenses.fisheye import FisheyeCamera, KannalaBrandtCamera
from raxel.cameras.lenses.moving_pupil import AxialCamera, MovingPupilCamera
from raxel.cameras.lenses.perspective import BrownCamera, PerspectiveCamera
from raxel.cameras.lenses.polynomials import (
    DivisionCamera,
    FieldOfViewCamera,
    MicusikPajdlaCamera,
    ScaramuzzaCamera,
    ShahAggarwalCamera,
    TardifCamera,
)
from raxel.cameras.lenses.rational import (
    LiftedRationalCamera,
    RationalCubicCamera,
    UnifiedSphereCamera,
)
from raxel.cameras.linear.line_cameras import (
    OrthographicCamera,
    PushbroomCamera,
    XSlitsCamera,
)
from raxel.cameras.mirrors.bent import BentMirrorCamera
from raxel.cameras.mirrors.flexible import FlexibleMirrorCamera
from raxel.cameras.mirrors.planar import PlanarMirrorsCamera
from raxel.cameras.mirrors.quadric import QuadricMirrorCamera
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.cameras.registry import CAMERAS, camera_from, load_camera
from raxel.cameras.tables.general import GeneralCamera
from raxel.cameras.tables.ray_spline import RaySplineCamera

__all__ = [
    "CAMERAS",
    "AxialCamera",
    "BentMirrorCamera",
    "BrownCamera",
    "Camera",
    "DivisionCamera",
    "FieldOfViewCamera",
    "FisheyeCamera",
    "FlexibleMirrorCamera",
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
    "SplineMirrorCamera",
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
