"""Registry of all kinds of camera."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Any

from raxel.cameras.core.base import Camera
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


def camera_from(kind: str, fields: Mapping[str, Any]) -> Camera:
    """Return the camera of a kind from its constructor's arguments by name.

    Parameters
    ----------
    kind : str
        Key of `CAMERAS`.
    fields : mapping of str to number, text or list
        Arguments by name. The `viewer` of a mirror camera, and the `lens` whose pupil
        moves, is a camera or a dict, see `with_nested`.

    Returns
    -------
    Camera
        Camera of that kind.

    Raises
    ------
    InputError
        A kind or name is unknown (reported with the nearest known one) or missing, or
        no such camera can have the values. The message is one line.

    Examples
    --------
    >>> from raxel.cameras import camera_from
    >>> K = [[800, 0, 320], [0, 800, 240], [0, 0, 1]]
    >>> fields = {"K": K, "radial": [], "width": 640, "height": 480}
    >>> camera = camera_from("perspective", fields)
    >>> camera.project([[0.1, 0, 1]]).pixels.round(6)
    array([[400., 240.]])
    """
    if kind not in CAMERAS:
        raise InputError(f"field 'kind': found {kind!r}; {_nearest(kind, CAMERAS)}")
    names, needed = argument_names(CAMERAS[kind])
    for name in fields:
        if name not in names:
            raise InputError(
                f"field '{name}': unknown for kind '{kind}'; " + _nearest(name, names)
            )
    for name in needed:
        if name not in fields:
            raise InputError(
                f"field '{name}': missing; give the fields of kind '{kind}': "
                + ", ".join(needed)
            )
    try:
        return CAMERAS[kind](**with_nested(fields))
    except (TypeError, ValueError) as fault:
        raise InputError(
            f"{kind} camera: a field has a wrong type ({fault}); give numbers, or "
            "lists of numbers of equal length"
        ) from fault


def with_nested(fields):
    """Fields of a camera, with `viewer` and `lens` dicts converted to cameras.

    A dict contains the camera's `kind` and its constructor's arguments by name. Raises
    InputError as `camera_from`.
    """
    return {name: _nested(name, value) for name, value in fields.items()}


def _nested(name, value):
    if name not in NESTED or not isinstance(value, dict):
        return value
    if "kind" not in value:
        raise InputError(
            f"field '{name}': 'kind' is missing; give the kind of the {name}"
        )
    own = {key: entry for key, entry in value.items() if key != "kind"}
    try:
        return camera_from(value["kind"], own)
    except InputError as fault:
        raise InputError(f"field '{name}': {fault}") from fault


def _nearest(name, known):
    return f"{did_you_mean(name, known)} known are {', '.join(known)}".lstrip()


# Read a camera of any kind from its file.


def load_camera(path: str | PathLike[str]) -> Camera:
    """Return the camera in an .npz file, of the class its field `kind` names.

    Parameters
    ----------
    path : str or path-like
        File that `Camera.save` wrote.

    Returns
    -------
    Camera
        Camera of the class in `CAMERAS`.

    Raises
    ------
    InputError
        The file is missing, truncated or of an unknown kind, or holds values that no
        such camera can have. The message names file and field.
    """
    with CameraFile(path, CAMERAS) as file:
        camera = file.camera()
        camera.board, camera.board_cells = file.board(), file.board_cells()
        if file.has("board_distance"):
            camera.board_distance = float(file.number("board_distance"))
        if file.has("error_nodes"):
            camera.error_nodes = file.numbers("error_nodes", 3)
        return camera
