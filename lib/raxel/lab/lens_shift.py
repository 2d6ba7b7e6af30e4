"""A lens that sits on its camera a little to one side.

A heavy lens sags: the image on the sensor moves when the camera is turned over.
"""

from raxel.cameras.core.base import Camera, Projection, as_rows, checked_array
from raxel.errors import InputError


class ShiftedLens(Camera):
    """A camera whose lens has moved the image by `shift` px on the sensor.

    camera: any Camera; shift: (2,), right and down. Rays are those of `camera`, each
    seen by a pixel so far away. It stands for one view and is never written to disk.
    """

    def __init__(self, camera, shift):
        self.camera, self.shift = camera, checked_array("lens_shift", shift, (2,))
        self.width, self.height = camera.width, camera.height
        self.kind, self.continuous = camera.kind, camera.continuous
        self.projects = camera.projects

    @property
    def central(self):
        """As that of the camera."""
        return self.camera.central

    @property
    def parameters(self):
        """Those of the camera; a shift that is told is none."""
        return self.camera.parameters

    def rays(self, pixels):
        """Rays of pixels (N, 2)."""
        return self.camera.rays(as_rows(pixels, 2) - self.shift)

    def project(self, points):
        """Pixels of points (N, 3)."""
        pixels, valid = self.camera.project(points)
        return Projection(pixels + self.shift, valid)

    def _fields(self):
        raise InputError(
            f"{self.kind}: the lens has moved; save the camera before it",
            code="moved-lens",
        )

    @classmethod
    def _from_file(cls, file):
        raise InputError(f"{cls.kind}: no file holds a camera whose lens has moved")
