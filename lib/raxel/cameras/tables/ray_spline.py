"""Any central camera: a parametric model plus a smooth field of its residuals.

A pixel p has the ray of another camera, the trend, at p + s(p). The field s, in px, is
a cubic B-spline (`raxel.cameras.tables.interpolation`). The parametric model describes
the large terms, also beyond 180 degrees, and the spline the remainder. In px the
field's errors are those of corners and decoded points, the same over the image and in
all directions for any lens. A trend with an entrance-pupil shift makes the camera
non-central.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    as_rows,
    check_size,
    checked_array,
    checked_positive,
    checked_rigid,
    near_rows,
    nested_fields,
)
from raxel.cameras.tables.interpolation import (
    control_shape,
    field_at,
    steepest,
    undisplaced,
)
from raxel.errors import InputError
from raxel.geometry.poses import inverse_pose, rotate, transform

# Look-up table of a general camera with interpolation between its cells.


class RayTable:
    """One ray per pixel centre; a cell without a ray contains NaN.

    directions: (H, W, 3) unit; origins: (3,) for a central camera or (H, W, 3);
    mask: (H, W) bool, which pixels have a ray.
    Between pixel centres directions and origins are bilinear; callers normalise the
    direction if they need a unit vector.
    """

    def __init__(self, directions, origins):
        self.directions, self.origins = directions, origins
        self.mask = np.isfinite(directions[..., 0])
        self.height, self.width = self.mask.shape

    @property
    def central(self):
        return self.origins.ndim == 1

    @property
    def rows(self):
        """Directions (H * W, 3) and origins, likewise or (1, 3), as
        `raxel.cameras.tables.interpolation` takes them."""
        return self.directions.reshape(-1, 3), self.origins.reshape(-1, 3)


# With steeper fields two pixels might have the same ray.
MAX_FIELD_SLOPE = 0.9


class RaySplineCamera(Camera):
    """The trend's ray of p + s(p), in the frame that T_camera_trend leads to.

    It answers where the trend does, also outside the image.

    Parameters
    ----------
    trend : Camera
        Camera that projects.
    spacing_px : float
        Side of the spline's cells, px.
    control : array_like, shape (rows, columns, 2)
        The field's control values, px; `control_shape` returns their number.
    width, height : int
        Size of the image, px.
    covered : array_like, shape (rows - 3, columns - 3)
        Cells with measurements, bool (all, if None). Elsewhere the field is
        extrapolated, fading, and the rays are not checked.
    covariance : array_like, shape (2 rows - 5, 2 columns - 5, 3)
        Variances uu, uv, vv of the field, px^2, at the cells' corners and half-way
        between; None where they are unknown.
    T_camera_trend : array_like, shape (4, 4)
        Pose of the trend, the identity if None.

    Raises
    ------
    InputError
        Shapes do not fit, or the field is so steep that the image might fold; the
        message names the field.
    """

    kind = "ray spline"

    def __init__(
        self,
        trend: Camera,
        spacing_px: float,
        control: ArrayLike,
        width: int,
        height: int,
        covered: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
        T_camera_trend: ArrayLike | None = None,
    ) -> None:
        check_size(self, width, height)
        if not (isinstance(trend, Camera) and trend.projects):
            raise InputError(
                f"field 'trend': found {type(trend).__name__}; give a camera that "
                "projects"
            )
        self.trend = trend
        self.spacing_px = float(checked_positive("spacing_px", spacing_px))
        if not self.spacing_px >= 1:
            raise InputError(
                f"field 'spacing_px': found {spacing_px}; give 1 px at least"
            )
        rows, columns = control_shape(width, height, self.spacing_px)
        self.control = checked_array("control", control, (None, None, 2))
        _check_shape("control", self.control, (rows, columns, 2))
        steep = steepest(self.control, self.spacing_px)
        if steep > MAX_FIELD_SLOPE:
            raise InputError(
                f"field 'control': the field changes by up to {steep:.2g} px per px; "
                f"give a closer trend, for at most {MAX_FIELD_SLOPE} (otherwise the "
                "image may fold)"
            )
        cells = rows - 3, columns - 3
        covered = np.ones(cells, bool) if covered is None else np.asarray(covered)
        _check_shape("covered", covered, cells)
        self.covered = covered.astype(bool)
        self.covariance = None
        if covariance is not None:
            nodes = 2 * cells[0] + 1, 2 * cells[1] + 1, 3
            self.covariance = np.array(covariance, float)
            _check_shape("covariance", self.covariance, nodes)
            if not np.isfinite(self.covariance).all():
                raise InputError("field 'covariance': values must be finite; fix them")
        T = np.eye(4) if T_camera_trend is None else T_camera_trend
        self.T_camera_trend = checked_rigid("T_camera_trend", T)

    @property
    def central(self) -> bool:
        """Whether the trend is."""
        return self.trend.central

    @property
    def parameters(self) -> int:
        """The trend's and the control values."""
        return self.trend.parameters + self.control.size

    def displacement(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Return the field s `(N, 2)`, px, at pixels `(N, 2)`."""
        return field_at(as_rows(pixels, 2), self.control, self.spacing_px)[0]

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays of the trend at the displaced pixels."""
        pixels = near_rows(pixels, 2)
        return self._in_camera(self.trend.rays(pixels + self.displacement(pixels)))

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points, to rounding.
        """
        T_trend_camera = inverse_pose(self.T_camera_trend)
        found = self.trend.project(transform(T_trend_camera, near_rows(points, 3)))
        pixels = undisplaced(found.pixels, self.control, self.spacing_px)
        return Projection(pixels, found.valid)

    def covers(self, pixels: ArrayLike) -> NDArray[np.bool_]:
        """Return which of the pixels `(N, 2)` are in a cell with measurements."""
        pixels = as_rows(pixels, 2)
        inside = self.in_image(pixels)
        place = np.where(inside[:, None], pixels + 0.5, 0.0) / self.spacing_px
        column, row = np.minimum(
            place.astype(int), np.array(self.covered.shape)[::-1] - 1
        ).T
        return inside & self.covered[row, column]

    def _node_errors(self):
        if self.error_nodes is not None:
            return super()._node_errors()
        return self.covariance, self.spacing_px / 2

    def _in_camera(self, rays):
        T = self.T_camera_trend
        return Rays(transform(T, rays.origins), rotate(T, rays.directions), rays.valid)

    def _fields(self):
        fields = {
            "spacing_px": np.array(self.spacing_px),
            "control": self.control,
            "covered": self.covered,
            "T_camera_trend": self.T_camera_trend,
        }
        if self.covariance is not None:
            fields["covariance"] = self.covariance
        return fields | nested_fields("trend", self.trend)

    @classmethod
    def _from_file(cls, file):
        width, height = file.size()
        spacing = file.number("spacing_px")
        if not spacing >= 1:
            raise InputError(f"field 'spacing_px': found {spacing}; give 1 px at least")
        rows, columns = control_shape(width, height, spacing)
        covariance = None
        if file.has("covariance"):
            covariance = file.table("covariance", (2 * rows - 5, 2 * columns - 5, 3))
        return cls(
            file.nested("trend"),
            spacing,
            file.table("control", (rows, columns, 2)),
            width,
            height,
            file.table("covered", (rows - 3, columns - 3)),
            covariance,
            file.numbers("T_camera_trend"),
        )


def _check_shape(name, array, shape):
    if array.shape != shape:
        raise InputError(
            f"field '{name}': found shape {array.shape}; give {shape} for this size of "
            "image and these cells"
        )
