"""Non-central camera: a viewer before a sheet of mirror bent by hand (3.3.2, 5)."""

import numpy as np

from raxel.cameras.core.nested import nested_fields
from raxel.cameras.mirrors.curved import MirrorCamera
from raxel.cameras.mirrors.sheet_surface import SheetMirror
from raxel.errors import InputError
from raxel.geometry.poses import pose, rotation_from_vector


class BentMirrorCamera(MirrorCamera):
    """A viewer that sees the world in a bent sheet. Frame: the viewer's.

    viewer: a central camera with its centre at the origin of its frame, or an
    OrthographicCamera. size: (width, height) of the sheet, mm; heights: coefficients
    h_ij of its height, mm (see SheetMirror). T_viewer_mirror: (4, 4), mm; the mirror's
    z axis points away from the light. Or `offset` (3,), mm, and `rotation` (3,), a
    rotation vector in radians, of the mirror's frame in the viewer's.

    Raises InputError for a viewer behind the mirror and values no mirror can have.
    """

    kind = "bent mirror"

    def __init__(
        self,
        viewer,
        size,
        heights,
        offset=(0.0, 0.0, 0.0),
        rotation=(0.0, 0.0, 0.0),
        T_viewer_mirror=None,
    ):
        mirror = SheetMirror(size, heights)
        if T_viewer_mirror is None:
            R = rotation_from_vector(np.asarray(rotation, float))
            T_viewer_mirror = pose(R, np.asarray(offset, float))
        self._place(viewer, mirror, T_viewer_mirror)
        ahead = self._axis[2] > 0 if self._parallel else self._eye[2] < 0
        if not ahead:
            raise InputError(
                "field 'T_viewer_mirror': the viewer is behind the mirror; turn it so "
                "that its z axis points away from the viewer"
            )

    @property
    def central(self):
        """False: a bent sheet sends the rays of a viewer through no common point."""
        return False

    @property
    def parameters(self):
        """Viewer, pose, and heights of second order or above: others are pose."""
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
