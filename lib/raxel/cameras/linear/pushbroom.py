"""Linear pushbroom camera: a line sensor carried along a straight path (2.2.4)."""

import numpy as np

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    check_size,
    checked_array,
    checked_positive,
    near_rows,
)
from raxel.cameras.core.named_fields import NamedFields
from raxel.errors import InputError


class PushbroomCamera(NamedFields, Camera):
    """Row v of the image is seen at once, from a centre that moves from row to row.

    The centre of row v is velocity (v - reference_row), velocity: (3,) in mm per row,
    in the camera frame, whose axes do not turn. A row sees the plane y = 0 of its
    centre: pixel u looks along ((u - principal_column) / focal_px, 0, 1). Rows are
    perspective, columns parallel, so the camera is the crossed-slits camera whose one
    slit is the path and whose other is the line at infinity of the planes y = 0.
    Raises InputError for a focal length that is not positive or a path inside y = 0,
    where rows would see the same plane.
    Source: Gupta, Hartley 1997, Linear pushbroom cameras, IEEE Transactions on Pattern
    Analysis and Machine Intelligence 19(9).
    """

    kind = "pushbroom"
    central = False
    # Focal length, principal column, velocity; the reference row is the frame's.
    parameters = 5

    def __init__(
        self, focal_px, principal_column, velocity, width, height, reference_row=0.0
    ):
        check_size(self, width, height)
        self.focal_px = float(checked_positive("focal_px", focal_px))
        self.principal_column = float(
            checked_array("principal_column", principal_column, ())
        )
        self.velocity = checked_array("velocity", velocity, (3,))
        self.reference_row = float(checked_array("reference_row", reference_row, ()))
        if abs(self.velocity[1]) <= 1e-9 * np.linalg.norm(self.velocity):
            raise InputError(
                f"field 'velocity': found {self.velocity.tolist()}; y must not be "
                "zero, or all rows see one plane"
            )

    def rays(self, pixels):
        """Rays of pixels (N, 2), from the centres of their rows."""
        u, v = near_rows(pixels, 2).T
        x = (u - self.principal_column) / self.focal_px
        d = np.column_stack([x, 0 * x, 1 + 0 * x]) / np.hypot(x, 1)[:, None]
        origins = (v - self.reference_row)[:, None] * self.velocity
        valid = np.isfinite(d).all(axis=1) & np.isfinite(origins).all(axis=1)
        keep = valid[:, None]
        return Rays(np.where(keep, origins, np.nan), np.where(keep, d, np.nan), valid)

    def project(self, points):
        """Pixels of points (N, 3): the row whose plane holds the point, then 2.2."""
        points = near_rows(points, 3)
        rows = points[:, 1] / self.velocity[1]
        x = points[:, 0] - rows * self.velocity[0]
        z = points[:, 2] - rows * self.velocity[2]
        valid = np.isfinite(points).all(axis=1) & (z > 0)
        with np.errstate(over="ignore"):
            u = self.focal_px * x / np.where(valid, z, np.nan) + self.principal_column
        pixels = np.column_stack([u, rows + self.reference_row])
        valid &= np.isfinite(u)
        return Projection(np.where(valid[:, None], pixels, np.nan), valid)
