"""Non-central camera: a viewing camera and a mirror with a spline shape (5.1.1)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import Camera, checked_array, checked_word, nested_fields
from raxel.cameras.linear.line_cameras import OrthographicCamera
from raxel.cameras.mirrors.curved import MirrorCamera
from raxel.cameras.mirrors.quadric import Reflection
from raxel.errors import InputError
from raxel.geometry.spline_grids import SplineGrid

# Mirror as a spline over the viewer's image: surface, derivatives, reflection. The
# viewer's centre is the origin, and p = (x, y) of a viewing ray w = (x, y, 1) are its
# normalised image coordinates. Two quantities may be the spline q(p): distance S = q w
# / |w| (5.3), as published; inverse depth S = w / q, exactly linear in p for a flat
# mirror. In both cases the depth S_z, or its inverse, is linear in the coefficients,
# and so is the normal. Lengths are mm.


QUANTITIES = ("distance", "inverse depth")
# Points per side at which a mirror is checked.
N_CHECK_POINTS = 13


def depth_rows(grid, p, quantity):
    """Rows B, B_x, B_y (N, K): B c is the depth S_z, or 1 / S_z for "inverse depth".

    grid: SplineGrid over normalised image coordinates p (N, 2). NaN outside its box.
    """
    b, b_x, b_y = grid.rows(p)
    if quantity == "inverse depth":
        return b, b_x, b_y
    h, (h_x, h_y), _ = _one_over_length(p)
    return (
        h[:, None] * b,
        h[:, None] * b_x + h_x[:, None] * b,
        h[:, None] * b_y + h_y[:, None] * b,
    )


def sense(quantity):
    """+1 where the depth rises with the quantity's rows, -1 where it falls."""
    return 1.0 if quantity == "distance" else -1.0


def normal_rows(p, rows, quantity):
    """M (N, 3, K) with the normal M c, not unit, away from the viewer: w . M c > 0.

    p: (N, 2); rows: those of `depth_rows`. It is S_x x S_y up to a positive factor.
    """
    B, B_x, B_y = rows
    s, x, y = sense(quantity), p[:, :1], p[:, 1:]
    return np.stack([-s * B_x, -s * B_y, B + s * (x * B_x + y * B_y)], axis=1)


class SplineMirror:
    """grid: SplineGrid; coefficients: (K,), index i + Kf * j; quantity: see above."""

    # The search for reflections starts at the coarse minimum of the angle between
    # bisector and normal; more starts found no more on bent sheets, in ten times as
    # long.
    inside = False

    def __init__(self, grid, coefficients, quantity):
        self.grid, self.quantity = grid, quantity
        self.coefficients = np.asarray(coefficients, float)
        corners = grid.corners
        self._middle = corners.mean(axis=0)
        self._half = float(np.linalg.norm(corners - self._middle, axis=1).max())
        looked = self._look()
        self.radius = float(np.linalg.norm(looked - looked.mean(axis=0), axis=1).max())

    def _look(self):
        u, v = (np.linspace(b[0], b[-1], N_CHECK_POINTS) for b in self.grid.breaks)
        u, v = np.meshgrid(u, v)
        p = self.grid.unturned(np.column_stack([u.ravel(), v.ravel()]))
        q = self.grid.values(p, self.coefficients)
        if not (q > 0).all():
            raise InputError(
                f"field 'coefficients': the {self.quantity} falls to {q.min():.3g}; "
                "give a mirror entirely in front of the viewer"
            )
        return self.points(p)

    def points(self, p):
        """Mirror points (N, 3) on viewing rays p (N, 2); NaN outside the box."""
        w, q = _homogeneous(p), self.grid.values(p, self.coefficients)
        if self.quantity == "inverse depth":
            return w / q[:, None]
        return w * (q / np.linalg.norm(w, axis=1))[:, None]

    def chart(self, points):
        """Chart coordinates (N, 2), about the box's middle, of points (N, 3)."""
        return (_normalised(points) - self._middle) / self._half

    @property
    def chart_extent(self):
        """The size of chart coordinates at the box's corners."""
        return 1.0

    def point(self, chart):
        """Surface points of chart coordinates (N, 2), as other mirrors have it.

        Returns the points (N, 3), their first derivatives (N, 3, 2) and second
        (N, 3, 2, 2).
        """
        p = self._middle + self._half * chart
        s, s_i, s_ij = self._depth(p)
        w, along = _homogeneous(p), np.eye(3)[:, :2]
        first = w[:, :, None] * s_i[:, None, :] + s[:, None, None] * along
        across = along[:, :, None] * s_i[:, None, None, :]
        second = w[:, :, None, None] * s_ij[:, None] + across
        second += np.swapaxes(across, 2, 3)
        return s[:, None] * w, self._half * first, self._half**2 * second

    def normals(self, points):
        """Normals (N, 3), not unit, towards the viewer, at surface points (N, 3)."""
        return -self._normals(_normalised(points))

    def reflect(self, origins, directions):
        """Reflect the viewer's rays at the mirror: exact to rounding.

        origins: (N, 3), all zero, the viewer's centre; directions: (N, 3). Not valid
        outside the box of the knots.
        """
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            p = _normalised(directions)
            met = (directions[:, 2] > 0) & self.grid.inside(p)
        p = np.where(met[:, None], p, np.nan)
        n = self._normals(p)
        with np.errstate(invalid="ignore"):
            along = np.sum(directions * n, axis=1) / np.sum(n * n, axis=1)
            leaving = directions - 2 * along[:, None] * n
            leaving /= np.linalg.norm(leaving, axis=1, keepdims=True)
        points = self.points(p)
        valid = np.isfinite(points).all(axis=1) & np.isfinite(leaving).all(axis=1)
        keep = valid[:, None]
        return Reflection(
            np.where(keep, points, np.nan), np.where(keep, leaving, np.nan), valid
        )

    def _normals(self, p):
        rows = depth_rows(self.grid, p, self.quantity)
        values = [part @ self.coefficients for part in rows]
        B, B_x, B_y = (value[:, None] for value in values)
        return normal_rows(p, (B, B_x, B_y), self.quantity)[:, :, 0]

    def _depth(self, p):
        """S_z (N,), and its derivatives (N, 2) and (N, 2, 2) by p."""
        c = self.coefficients
        q, q_x, q_y = (part @ c for part in self.grid.rows(p))
        inverse = self.quantity == "inverse depth"
        h, h_i, h_ij = _one_over_length(p)
        depth = 1 / q if inverse else h * q
        q_i = np.column_stack([q_x, q_y])
        xx, xy, yy = (part @ c for part in self.grid.second_rows(p))
        q_ij = np.stack([xx, xy, xy, yy], axis=1).reshape(-1, 2, 2)
        if inverse:
            s_i = -(depth**2)[:, None] * q_i
            s_ij = 2 * (depth**3)[:, None, None] * _outer(q_i, q_i)
            return depth, s_i, s_ij - (depth**2)[:, None, None] * q_ij
        h_i = np.column_stack(h_i)
        s_i = h[:, None] * q_i + q[:, None] * h_i
        s_ij = h[:, None, None] * q_ij + q[:, None, None] * h_ij
        return depth, s_i, s_ij + _outer(q_i, h_i) + _outer(h_i, q_i)


def _one_over_length(p):
    """1 / |w| (N,), its derivatives by x and y, (N,) each, and second (N, 2, 2)."""
    h = 1 / np.sqrt(1 + np.sum(p * p, axis=1))
    second = 3 * (h**5)[:, None, None] * _outer(p, p)
    second -= (h**3)[:, None, None] * np.eye(2)
    return h, (-(h**3) * p[:, 0], -(h**3) * p[:, 1]), second


def _outer(a, b):
    return a[:, :, None] * b[:, None, :]


def _homogeneous(p):
    return np.column_stack([p, np.ones(len(p))])


def _normalised(vectors):
    return vectors[:, :2] / vectors[:, 2:]


class SplineMirrorCamera(MirrorCamera):
    """The thesis's full model of a flexible mirror (5.3-5.7). Frame: the viewer's.

    Rays start at the mirror. Only pixels inside the box of the knots have one: a spline
    is not extrapolated beyond it. Whether a ray meets the mirror twice is not checked.

    Parameters
    ----------
    viewer : Camera
        Central camera with its centre at the origin of its frame.
    knots_u, knots_v : array_like
        Knots of a `SplineGrid` over normalised image coordinates of the viewing rays (x
        / z, y / z).
    coefficients : array_like, shape (Kf, Kg)
        The matrix C of (5.5).
    degree : sequence of int
        Degrees of the grid, each at least 2.
    angle : float
        Angle of the grid, rad.
    quantity : str
        'distance' of the mirror from the viewer along the ray, mm (5.3), or 'inverse
        depth', one over its z, 1 / mm (not in the thesis).

    Raises
    ------
    InputError
        A field is not valid: also a degree below 2, whose rays would jump at the knots,
        and a mirror that is not wholly in front of the viewer. The message names the
        field.

    References
    ----------
    Thesis (5.3) to (5.7).
    """

    kind = "spline mirror"

    def __init__(
        self,
        viewer: Camera,
        knots_u: ArrayLike,
        knots_v: ArrayLike,
        coefficients: ArrayLike,
        degree: Sequence[int] = (2, 2),
        angle: float = 0.0,
        quantity: str = "inverse depth",
    ) -> None:
        self.grid = SplineGrid(knots_u, knots_v, degree, angle)
        if min(self.grid.degree) < 2:
            raise InputError(
                f"field 'degree': found {self.grid.degree}; give 2 or more along both "
                "axes (otherwise rays jump at the knots)"
            )
        self.quantity = checked_word("quantity", quantity, QUANTITIES)
        self.coefficients = checked_array("coefficients", coefficients, self.grid.shape)
        mirror = SplineMirror(self.grid, self.coefficients.ravel("F"), self.quantity)
        self._place(viewer, mirror, np.eye(4))
        if isinstance(self.viewer, OrthographicCamera):
            raise InputError(
                "field 'viewer': found an orthographic camera; give a central viewer "
                "for a spline over the image"
            )

    @classmethod
    def on_grid(
        cls,
        viewer: Camera,
        grid: SplineGrid,
        coefficients: ArrayLike,
        quantity: str = "inverse depth",
    ) -> SplineMirrorCamera:
        """Return the camera of a SplineGrid and vec(C), index i + Kf * j."""
        C = np.reshape(coefficients, grid.shape, order="F")
        return cls(
            viewer, grid.knots_u, grid.knots_v, C, grid.degree, grid.angle, quantity
        )

    @classmethod
    def fitted(
        cls,
        viewer: Camera,
        grid: SplineGrid,
        points: ArrayLike,
        quantity: str = "inverse depth",
    ) -> SplineMirrorCamera:
        """Return the spline nearest to points of a mirror.

        Least squares in the quantity, of the points that are in the grid's box.

        Parameters
        ----------
        viewer : Camera
            Central camera.
        grid : SplineGrid
            Basis functions.
        points : array_like, shape (N, 3)
            Points of the mirror in the viewer's frame, mm.
        quantity : str
            As of the class.

        Returns
        -------
        SplineMirrorCamera
            Camera.

        Raises
        ------
        InputError
            The points leave a coefficient undetermined.
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
                f"{grid.size - rank} of {grid.size} coefficients undetermined; give "
                "more points, or fewer knots"
            )
        return cls.on_grid(viewer, grid, coefficients, quantity)

    @property
    def central(self) -> bool:
        """False: the rays from a bent mirror have no common point."""
        return False

    @property
    def parameters(self) -> int:
        """The viewer's, and the coefficients."""
        return self.viewer.parameters + self.coefficients.size

    @property
    def knots_u(self) -> NDArray[np.float64]:
        """Knots along u, with repeated ends."""
        return self.grid.knots_u

    @property
    def knots_v(self) -> NDArray[np.float64]:
        """Knots along v, with repeated ends."""
        return self.grid.knots_v

    def mirror_points(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Return mirror points `(N, 3)` that pixels `(N, 2)` see, NaN for none."""
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
