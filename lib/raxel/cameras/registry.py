"""All kinds of camera by name."""

from raxel.cameras.core.storage import CameraFile, argument_names
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
from raxel.cameras.tables.general import GeneralCamera
from raxel.cameras.tables.ray_spline import RaySplineCamera
from raxel.errors import InputError, did_you_mean

CAMERAS = {
    camera.kind: camera
    for camera in (
        PerspectiveCamera,
        FisheyeCamera,
        GeneralCamera,
        BrownCamera,
        DivisionCamera,
        ShahAggarwalCamera,
        FieldOfViewCamera,
        RationalCubicCamera,
        LiftedRationalCamera,
        KannalaBrandtCamera,
        MicusikPajdlaCamera,
        ScaramuzzaCamera,
        TardifCamera,
        UnifiedSphereCamera,
        OrthographicCamera,
        QuadricMirrorCamera,
        BentMirrorCamera,
        FlexibleMirrorCamera,
        PlanarMirrorsCamera,
        XSlitsCamera,
        PushbroomCamera,
        AxialCamera,
        RaySplineCamera,
        MovingPupilCamera,
        SplineMirrorCamera,
    )
}

NESTED = ("viewer", "lens", "trend")  # fields that hold a camera


def camera_from(kind, fields):
    """The camera of a kind from its constructor's arguments by name.

    kind: a key of CAMERAS; fields: dict name -> number, text or list; the `viewer` of a
    mirror camera, and the `lens` whose pupil moves, is a camera or a dict, see
    `with_nested`.
    Raises InputError, one line, for a kind or name that is unknown (with the nearest
    known one) or missing, and for values that no such camera can have.
    """
    if kind not in CAMERAS:
        raise InputError(f"field 'kind': found {kind!r}; {_nearest(kind, CAMERAS)}")
    names, needed = argument_names(CAMERAS[kind])
    for name in fields:
        if name not in names:
            raise InputError(
                f"field '{name}': no such field of kind '{kind}'; "
                + _nearest(name, names)
            )
    for name in needed:
        if name not in fields:
            raise InputError(
                f"field '{name}': missing; kind '{kind}' needs " + ", ".join(needed)
            )
    try:
        return CAMERAS[kind](**with_nested(fields))
    except (TypeError, ValueError) as fault:
        raise InputError(
            f"{kind} camera: a field has values of a wrong type ({fault}); give "
            "numbers, or lists of numbers of equal length"
        ) from fault


def with_nested(fields):
    """The fields of a camera with `viewer` and `lens`, where they are dicts, made the
    cameras they are.

    A dict holds the camera's `kind` and its constructor's arguments by name. Raises
    InputError as `camera_from`.
    """
    return {name: _nested(name, value) for name, value in fields.items()}


def _nested(name, value):
    if name not in NESTED or not isinstance(value, dict):
        return value
    if "kind" not in value:
        raise InputError(
            f"field '{name}': 'kind' is missing; name the {name}'s kind of camera"
        )
    own = {key: entry for key, entry in value.items() if key != "kind"}
    try:
        return camera_from(value["kind"], own)
    except InputError as fault:
        raise InputError(f"field '{name}': {fault}") from fault


def _nearest(name, known):
    return f"{did_you_mean(name, known)} known are {', '.join(known)}".lstrip()


# Read a camera of any kind from its file.


def load_camera(path):
    """The camera in an .npz file, of the class its field `kind` names.

    Raises InputError with file and field for a file that is missing, cut off, of an
    unknown kind, or holds values that no such camera can have.
    """
    with CameraFile(path, CAMERAS) as file:
        return file.camera()
