"""Cameras that hold another camera, the viewer of their mirrors."""

import numpy as np

from raxel.cameras.base import Camera, checked_array, near_rows
from raxel.cameras.orthographic import OrthographicCamera
from raxel.cameras.storage import CameraFile
from raxel.errors import InputError


def checked_viewer(viewer):
    """A camera given as one, or as a dict of `kind` and constructor arguments.

    Raises InputError for anything but an OrthographicCamera or a central camera with
    its centre at the origin of its frame.
    """
    if isinstance(viewer, dict):
        # The registry knows this module's cameras too, so it is not known earlier.
        from raxel.cameras.registry import camera_from

        if "kind" not in viewer:
            raise InputError(
                "field 'viewer': 'kind' is missing; name the viewer's kind of camera"
            )
        fields = {name: value for name, value in viewer.items() if name != "kind"}
        try:
            viewer = camera_from(viewer["kind"], fields)
        except InputError as fault:
            raise InputError(f"field 'viewer': {fault}") from fault
    if not isinstance(viewer, Camera):
        raise InputError(
            f"field 'viewer': found {type(viewer).__name__}; give a camera, or its "
            "kind and fields"
        )
    if isinstance(viewer, OrthographicCamera):
        return viewer
    centre = getattr(viewer, "origins", None)
    if centre is None:
        centre = getattr(viewer, "centre", None)
    if not viewer.central or (centre is not None and np.any(centre)):
        raise InputError(
            f"field 'viewer': a {viewer.kind} camera whose rays do not all start at "
            "the origin of its frame; a central viewer or an orthographic one is needed"
        )
    return viewer


def nested_fields(name, camera):
    """The fields of a camera's file under names that begin with `name` and a dot."""
    size = {"width": np.array(camera.width), "height": np.array(camera.height)}
    fields = {"kind": np.array(camera.kind)} | size | camera._fields()
    return {f"{name}.{key}": value for key, value in fields.items()}


def read_viewer(name, file):
    """The camera that `nested_fields` put into an open `CameraFile`."""
    from raxel.cameras.registry import CAMERAS

    part = _FilePart(name, file)
    if part.kind not in CAMERAS:
        raise InputError(
            f"{part.path}: field 'kind': found {part.kind!r}; known are "
            + ", ".join(CAMERAS)
        )
    return part.build(CAMERAS[part.kind])


class _FilePart(CameraFile):
    """The fields of an open file whose names begin with `name` and a dot."""

    def __init__(self, name, file):
        self.path, self._name, self._file = f"{file.path}: field '{name}'", name, file
        self.kind = self.text("kind")

    def array(self, name):
        return self._file.array(f"{self._name}.{name}")


def finite_rows(points):
    """Points (N, 3), NaN in rows that are not finite or far beyond any scene."""
    return near_rows(points, 3)


def checked_rigid(name, T):
    """A read-only pose (4, 4), or InputError naming the field."""
    T = checked_array(name, T, (4, 4))
    R = T[:3, :3]
    rigid = np.abs(R @ R.T - np.eye(3)).max() < 1e-9 and np.linalg.det(R) > 0
    if not (rigid and np.array_equal(T[3], [0, 0, 0, 1])):
        raise InputError(
            f"field '{name}': not a pose; give a rotation, a translation in mm and the "
            "last row 0 0 0 1"
        )
    return T
