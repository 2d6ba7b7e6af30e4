"""Cameras that hold another camera: the viewer of mirrors, the lens of a field."""

import numpy as np

from raxel.cameras.core.base import checked_array, near_rows
from raxel.errors import InputError


def nested_fields(name, camera):
    """The fields of a nested camera, by the names that `CameraFile.nested` reads."""
    size = {"width": np.array(camera.width), "height": np.array(camera.height)}
    fields = {"kind": np.array(camera.kind)} | size | camera._fields()
    return {f"{name}.{key}": value for key, value in fields.items()}


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
