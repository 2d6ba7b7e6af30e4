"""Non-central camera: a viewing camera and a bent mirror sheet (3.3.2, 5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from raxel.cameras.core.base import Camera, checked_positive, nested_fields
from raxel.cameras.mirrors.curved import MirrorCamera
from raxel.cameras.mirrors.sheet_surface import SheetMirror
from raxel.errors import InputError
from raxel.geometry.poses import pose, rotation_from_vector

# Facets of a mirror ball: square mirrors in rows, with small random tilts.


MAX_N_FACETS = 5000


def ball_facets(ball_radius, distance, facet_size, gap, cap, tilt_sd=0.0, specimen=0):
    """Poses (F, 4, 4) and outlines (F, 4, 2) of the facets towards a viewer, mm.

    The ball's centre is at (0, 0, distance + ball_radius) in the frame of the viewer
    (the camera that views the mirror); its poles are above and below. Rows of facets
    run around it, `gap` apart. cap: rad, largest angle of a facet's centre from the
    point next to the viewer. tilt_sd: rad, standard deviation of a facet's random tilt
    about either side; specimen: whole number, seed of these tilts.

    z of a facet points away from the ball. Rows start from the equator, and a row has
    as many facets as fit, one of them straight ahead. Raises InputError naming the
    field.
    """
    radius = float(checked_positive("ball_radius", ball_radius))
    size = float(checked_positive("facet_size", facet_size))
    away = float(checked_positive("distance", distance))
    for name, value, most in (
        ("gap", gap, radius),
        ("cap", cap, np.pi / 2),
        ("tilt_sd", tilt_sd, np.pi / 8),
    ):
        if not 0 <= value <= most:
            raise InputError(f"field '{name}': found {value}; give 0 to {most:.4g}")
    pitch = size + gap
    if 2 * np.pi * (1 - np.cos(cap)) * (radius / pitch) ** 2 > MAX_N_FACETS:
        raise InputError(
            f"field 'facet_size': found {facet_size} on a ball of {ball_radius} mm; "
            f"give larger facets, at most {MAX_N_FACETS}"
        )
    normals = _normals(radius, pitch, cap)
    if not len(normals):
        raise InputError(f"field 'cap': found {cap} (no facet); give a larger value")
    down = np.array([0.0, 1.0, 0.0])
    x = np.cross(down, normals)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    R = np.stack([x, np.cross(normals, x), normals], axis=2)
    if specimen != int(specimen) or specimen < 0:
        raise InputError(f"field 'specimen': found {specimen}; give a whole number")
    tilts = np.random.default_rng(int(specimen)).normal(0, tilt_sd, (len(R), 2))
    R = R @ rotation_from_vector(np.pad(tilts, ((0, 0), (0, 1))))
    middles = [0, 0, away + radius] + radius * normals
    half = size / 2
    square = [[-half, -half], [half, -half], [half, half], [-half, half]]
    return pose(R, middles), [square] * len(R)


def _normals(radius, pitch, cap):
    """Unit normals (F, 3) of the facets within the cap, rows from top to bottom."""
    reach = int(cap * radius / pitch)
    normals = []
    for row in range(-reach, reach + 1):
        latitude = row * pitch / radius
        count = max(1, int(2 * np.pi * radius * np.cos(latitude) / pitch))
        longitude = 2 * np.pi * (np.arange(count) - count // 2) / count
        level = np.cos(latitude)
        normals.append(
            np.column_stack(
                [
                    level * np.sin(longitude),
                    np.full(count, np.sin(latitude)),
                    -level * np.cos(longitude),
                ]
            )
        )
    normals = np.concatenate(normals)
    return normals[-normals[:, 2] >= np.cos(cap)]


class BentMirrorCamera(MirrorCamera):
    """A viewer that sees the world in a bent sheet. Frame: the viewer's.

    The pose of the mirror is T_viewer_mirror, or else `offset` and `rotation` of the
    mirror's frame in the viewer's.

    Parameters
    ----------
    viewer : Camera
        Central camera with its centre at the origin of its frame, or an
        `OrthographicCamera`.
    size : array_like, shape (2,)
        (width, height) of the sheet, mm.
    heights : array_like, shape (m, n)
        Coefficients h_ij of its height, mm (see `SheetMirror`).
    offset : array_like, shape (3,)
        Position of the mirror, mm.
    rotation : array_like, shape (3,)
        Rotation vector, rad.
    T_viewer_mirror : array_like, shape (4, 4)
        Pose of the mirror, mm; its z axis points away from the light.

    Raises
    ------
    InputError
        The viewer is behind the mirror, or no mirror can have the values.
    """

    kind = "bent mirror"

    def __init__(
        self,
        viewer: Camera,
        size: ArrayLike,
        heights: ArrayLike,
        offset: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike = (0.0, 0.0, 0.0),
        T_viewer_mirror: ArrayLike | None = None,
    ) -> None:
        mirror = SheetMirror(size, heights)
        if T_viewer_mirror is None:
            R = rotation_from_vector(np.asarray(rotation, float))
            T_viewer_mirror = pose(R, np.asarray(offset, float))
        self._place(viewer, mirror, T_viewer_mirror)
        ahead = self._axis[2] > 0 if self._parallel else self._eye[2] < 0
        if not ahead:
            raise InputError(
                "field 'T_viewer_mirror': the viewer is behind the mirror; rotate it "
                "so that its z axis points away from the viewer"
            )

    @property
    def central(self) -> bool:
        """False: the rays from a bent sheet have no common point."""
        return False

    @property
    def parameters(self) -> int:
        """Viewer, pose, and heights of second order or above (others are pose)."""
        order = np.add.outer(*map(np.arange, self.mirror.heights.shape))
        return self.viewer.parameters + 6 + int((order > 1).sum())

    def _fields(self):
        return nested_fields("viewer", self.viewer) | {
            "size": self.mirror.size,
            "heights": self.mirror.heights,
            "T_viewer_mirror": self.T_viewer_mirror,
        }

    @classmethod
    def _from_file(cls, file):
        return cls(
            file.nested("viewer"),
            file.numbers("size"),
            file.numbers("heights"),
            T_viewer_mirror=file.numbers("T_viewer_mirror"),
        )
