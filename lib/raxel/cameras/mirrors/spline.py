"""Non-central camera: a viewer before a mirror whose shape is a spline (5.1.1)."""

import numpy as np

from raxel.cameras.core.base import checked_array, checked_word
from raxel.cameras.core.nested import nested_fields
from raxel.cameras.linear.orthographic import OrthographicCamera
from raxel.cameras.mirrors.curved import MirrorCamera
from raxel.cameras.mirrors.spline_surface import QUANTITIES, SplineMirror
from raxel.errors import InputError
from raxel.geometry.spline_grid import SplineGrid


class SplineMirrorCamera(MirrorCamera):
    """The thesis's full model of a flexible mirror (5.3-5.7). Frame: the viewer's.

    viewer: a central camera with its centre at the origin of its frame. knots_u,
    knots_v, degree, angle: of a SplineGrid over normalised image coordinates of the
    viewing rays (x / z, y / z). coefficients: (Kf, Kg), the matrix C of (5.5).
    quantity: "distance" of the mirror from the viewer along the ray, mm (5.3), or
    "inverse depth", one over its z, 1 / mm (not in the thesis).

    Rays start at the mirror. Only pixels inside the box of the knots have one: beyond
    it a spline says nothing. That a ray may meet the mirror twice is not looked at.
    Raises InputError naming the field: also for a degree below 2, whose rays would
    jump at the knots, and for a mirror that is not wholly before the viewer.
    """

    kind = "spline mirror"

    def __init__(
        self,
        viewer,
        knots_u,
        knots_v,
        coefficients,
        degree=(2, 2),
        angle=0.0,
        quantity="inverse depth",
    ):
        self.grid = SplineGrid(knots_u, knots_v, degree, angle)
        if min(self.grid.degree) < 2:
            raise InputError(
                f"field 'degree': found {self.grid.degree}; a mirror needs 2 or more "
                "each way, or its rays jump at the knots"
            )
        self.quantity = checked_word("quantity", quantity, QUANTITIES)
        self.coefficients = checked_array("coefficients", coefficients, self.grid.shape)
        mirror = SplineMirror(self.grid, self.coefficients.ravel("F"), self.quantity)
        self._place(viewer, mirror, np.eye(4))
        if isinstance(self.viewer, OrthographicCamera):
            raise InputError(
                "field 'viewer': an orthographic camera; a spline over the picture "
                "needs a central viewer"
            )

    @classmethod
    def on_grid(cls, viewer, grid, coefficients, quantity="inverse depth"):
        """From a SplineGrid and vec(C) (Kf * Kg,), index i + Kf * j."""
        C = np.reshape(coefficients, grid.shape, order="F")
        return cls(
            viewer, grid.knots_u, grid.knots_v, C, grid.degree, grid.angle, quantity
        )

    @classmethod
    def fitted(cls, viewer, grid, points, quantity="inverse depth"):
        """The spline nearest to points (N, 3) of a mirror, in the viewer's frame.

        Least squares in the quantity, of the points that lie in the grid's box. Raises
        InputError where they leave a coefficient open.
        """
        points = np.asarray(points, float)
        with np.errstate(invalid="ignore", divide="ignore"):
            p = points[:, :2] / points[:, 2:]
        inside = grid.inside(p) & (points[:, 2] > 0)
        b = grid.rows(p[inside])[0]
        found = points[inside]
        values = (
            np.linalg.norm(found, axis=1) if quantity == "distance" else 1 / found[:, 2]
        )
        coefficients, _, rank, _ = np.linalg.lstsq(b, values)
        if rank < grid.size:
            raise InputError(
                f"spline mirror: {len(found)} points inside the knots leave "
                f"{grid.size - rank} of {grid.size} coefficients open; give more, or "
                "fewer knots"
            )
        return cls.on_grid(viewer, grid, coefficients, quantity)

    @property
    def central(self):
        """False: a bent mirror sends the viewer's rays through no common point."""
        return False

    @property
    def parameters(self):
        """The viewer's, and the coefficients."""
        return self.viewer.parameters + self.coefficients.size

    @property
    def knots_u(self):
        """Knots along u, with repeated ends."""
        return self.grid.knots_u

    @property
    def knots_v(self):
        """Knots along v, with repeated ends."""
        return self.grid.knots_v

    def mirror_points(self, pixels):
        """Mirror points (N, 3) that pixels (N, 2) see; NaN where there is none."""
        return self.rays(pixels).origins

    def _fields(self):
        return nested_fields("viewer", self.viewer) | {
            "knots_u": self.knots_u,
            "knots_v": self.knots_v,
            "coefficients": self.coefficients,
            "degree": np.array(self.grid.degree),
            "angle": np.array(self.grid.angle),
            "quantity": np.array(self.quantity),
        }

    @classmethod
    def _from_file(cls, file):
        return cls(
            file.nested("viewer"),
            file.numbers("knots_u"),
            file.numbers("knots_v"),
            file.numbers("coefficients"),
            file.numbers("degree"),
            file.number("angle"),
            file.text("quantity"),
        )
