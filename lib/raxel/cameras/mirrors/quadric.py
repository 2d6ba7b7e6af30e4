"""Catadioptric camera from its geometry: a viewing camera, a quadric mirror (2.2.3)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import (
    MAX_SCALE,
    MIN_SCALE,
    Camera,
    Projection,
    checked_array,
    checked_positive,
    checked_word,
    nested_fields,
)
from raxel.cameras.linear.line_cameras import OrthographicCamera
from raxel.cameras.mirrors.curved import MirrorCamera, checked_viewer
from raxel.errors import InputError
from raxel.geometry.poses import pose, rotation_from_vector, transform

# Mirrors whose surface is a conic of revolution: intersection, reflection, chart. One
# formula describes all of them. In the mirror's frame, with the apex at the
# origin and the axis along +z into the curve, x^2 + y^2 = 2 R z - kappa z^2, kappa =
# 1 - e^2, R the radius of curvature at the apex and e the eccentricity: 0 for a
# sphere, below 1 for a prolate ellipsoid, 1 for a paraboloid, above 1 for a
# hyperboloid of two sheets. The foci are at z = R / (1 + e) and R / (1 - e). Lengths
# are mm.


SHAPES = {
    "hyperboloid": ("a", "b"),
    "paraboloid": ("f",),
    "ellipsoid": ("a", "b"),
    "sphere": ("R",),
}
SIDES = ("outside", "inside")
# Rounding tolerance relative to the mirror's size, so that its edge is part of it.
EDGE_TOL = 1e-12
# Along a reflected ray, in radii of curvature: closer hits are the point it leaves.
MIN_HIT_RADII = 1e-9


class Reflection(NamedTuple):
    """points (N, 3) on the mirror, unit directions (N, 3) leaving it, valid (N,)."""

    points: np.ndarray
    directions: np.ndarray
    valid: np.ndarray


class ConicMirror:
    """Part of the surface up to an edge, silvered on one side.

    shape and axes: 'hyperboloid' (a, b) with z^2/a^2 - r^2/b^2 = 1 about its middle;
    'ellipsoid' (a, b), a > b, with z^2/a^2 + r^2/b^2 = 1; 'paraboloid' (f,), its focal
    length; 'sphere' (R,). rim_radius, hole_radius: distances from the axis, mm; no
    mirror extends beyond its widest circle. side: 'outside' (convex) or 'inside'.
    Raises InputError naming the invalid field.
    """

    def __init__(self, shape, axes, rim_radius, hole_radius, side):
        self.radius, self.eccentricity, self.kappa = conic_of(shape, axes)
        checked_word("side", side, SIDES)
        self.rim, self.inside = self._checked_rim(rim_radius), side == "inside"
        self.hole = float(checked_array("hole_radius", hole_radius, ()))
        if not 0 <= self.hole < self.rim:
            raise InputError(
                f"field 'hole_radius': found {hole_radius}; give at least 0 and less "
                f"than the rim radius, {self.rim:g} mm"
            )
        self.height = self.rim * self.slope_at(self.rim)
        stretch = (1 + self.eccentricity) / self.kappa if self.kappa else math.inf
        self.foci = np.array([1 / (1 + self.eccentricity), stretch]) * self.radius

    def _checked_rim(self, rim_radius):
        rim = float(checked_positive("rim_radius", rim_radius))
        widest = self.radius / math.sqrt(self.kappa) if self.kappa > 0 else math.inf
        if rim > widest * (1 + EDGE_TOL):
            raise InputError(
                f"field 'rim_radius': found {rim_radius}; give at most {widest:g} mm, "
                "the radius of the surface"
            )
        return rim

    def slope_at(self, across):
        """z / across at a distance from the axis: the parameter |p| of `point`."""
        root = np.sqrt(np.maximum(self.radius**2 - self.kappa * across**2, 0))
        return across / (self.radius + root)

    def depth(self, points):
        """x^2 + y^2 - 2 R z + kappa z^2 of points (N, 3): zero on the surface."""
        x, y, z = points.T
        return x * x + y * y - z * (2 * self.radius - self.kappa * z)

    def encloses(self, points):
        """Whether points (N, 3) are within the surface, where its foci may be."""
        beyond = points[:, 2] > 0
        return beyond & (self.depth(points) < 0)

    def normals(self, points):
        """Normals (N, 3), not unit, towards the silvered side."""
        x, y, z = points.T
        out = np.column_stack([x, y, self.kappa * z - self.radius])
        return -out if self.inside else out

    def reflect(self, origins, directions):
        """Intersect rays with the mirror and reflect them: exact to rounding.

        origins, directions: (N, 3), the latter unit. Not valid where a ray first meets
        the back of the mirror, or meets the mirror again after the reflection.
        """
        shape = self.radius, self.kappa, self.hole, self.rim, self.height
        rays = (np.ascontiguousarray(a, float) for a in (origins, directions))
        return Reflection(*_reflected(*rays, shape, self.inside))

    def quadric_meetings(self, origins, directions):
        """Roots (N, 2) of the quadric along lines, NaN where none; not sorted.

        The larger root from a sum without cancellation, the other by Vieta's product.
        """
        o, d = origins, directions
        weight = np.array([1.0, 1.0, self.kappa])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            a = np.sum(weight * d * d, axis=1)
            b = np.sum(weight * o * d, axis=1) - self.radius * d[:, 2]
            c = self.depth(o)
            q = -(b + np.copysign(np.sqrt(b * b - a * c), b))
            return np.column_stack([q / a, c / q])

    def chart(self, points):
        """Chart coordinates p (N, 2) of places next to points (N, 3), see `point`."""
        if self.kappa <= 0:
            return points[:, :2] / (2 * self.radius)
        across = np.sum(points[:, :2] ** 2, axis=1)
        return points[:, :2] * (points[:, 2] / across)[:, None]

    @property
    def chart_extent(self):
        """|p| at the edge."""
        if self.kappa <= 0:
            return self.rim / (2 * self.radius)
        return self.slope_at(self.rim)

    def point(self, p):
        """Surface points (N, 3) of chart coordinates p (N, 2), pure numbers.

        Open surfaces: x and y over 2 R. Closed ones: the slopes x/r z/r and y/r z/r of
        the line from the apex, 2 R (p, |p|^2) / (1 + kappa |p|^2), which reach past the
        widest circle. Near the apex both are the same.
        Returns the points, their first derivatives (N, 3, 2) and second (N, 3, 2, 2).
        """
        return self._open_point(p) if self.kappa <= 0 else self._closed_point(p)

    def _open_point(self, p):
        double = 2 * self.radius
        across = double * p
        square = np.sum(across**2, axis=1)
        root = np.sqrt(self.radius**2 - self.kappa * square)
        points = np.column_stack([across, square / (self.radius + root)])
        first = np.zeros((len(p), 3, 2))
        first[:, :2] = double * np.eye(2)
        first[:, 2] = double * across / root[:, None]
        second = np.zeros((len(p), 3, 2, 2))
        bend = self.kappa * across[:, :, None] * across[:, None, :]
        bend = np.eye(2) + bend / root[:, None, None] ** 2
        second[:, 2] = double**2 * bend / root[:, None, None]
        return points, first, second

    def _closed_point(self, p):
        square = np.sum(p * p, axis=1)
        scale = 1 / (1 + self.kappa * square)
        lifted = np.column_stack([p, square])
        d_lifted = np.zeros((len(p), 3, 2))
        d_lifted[:, :2] = np.eye(2)
        d_lifted[:, 2] = 2 * p
        d_scale = -2 * self.kappa * p * scale[:, None] ** 2
        dd_scale = (
            8 * self.kappa**2 * p[:, :, None] * p[:, None, :] * scale[:, None, None]
            - 2 * self.kappa * np.eye(2)
        ) * scale[:, None, None] ** 2
        cross = d_lifted[:, :, :, None] * d_scale[:, None, None, :]
        second = lifted[:, :, None, None] * dd_scale[:, None]
        second += cross + np.swapaxes(cross, 2, 3)
        second[:, 2] += 2 * np.eye(2) * scale[:, None, None]
        first = d_lifted * scale[:, None, None]
        first += lifted[:, :, None] * d_scale[:, None, :]
        double = 2 * self.radius
        return double * lifted * scale[:, None], double * first, double * second


@numba.njit(cache=True, error_model="numpy")
def _reflected(origins, directions, shape, inside):
    """`Reflection` of rays (N, 3), (N, 3) on a mirror of `shape`: radius, kappa, radii
    of hole and edge, height."""
    radius = shape[0]
    points, leaving = np.full((2, len(origins), 3), np.nan)
    valid = np.zeros(len(origins), np.bool_)
    for n in range(len(origins)):
        o, d = origins[n], directions[n]
        first = min(*_meetings(o[0], o[1], o[2], d[0], d[1], d[2], shape))
        if not first < np.inf:
            continue
        x, y, z = o[0] + first * d[0], o[1] + first * d[1], o[2] + first * d[2]
        u, v, w = x, y, shape[1] * z - radius
        if inside:
            u, v, w = -u, -v, -w
        towards = d[0] * u + d[1] * v + d[2] * w
        if not towards < 0:
            continue
        turn = 2 * towards / (u * u + v * v + w * w)
        u, v, w = d[0] - turn * u, d[1] - turn * v, d[2] - turn * w
        length = math.sqrt(u * u + v * v + w * w)
        u, v, w = u / length, v / length, w / length
        for again in _meetings(x, y, z, u, v, w, shape):
            if MIN_HIT_RADII * radius < again < np.inf:
                break
        else:
            valid[n] = True
            points[n, 0], points[n, 1], points[n, 2] = x, y, z
            leaving[n, 0], leaving[n, 1], leaving[n, 2] = u, v, w
    return points, leaving, valid


@numba.njit(cache=True, error_model="numpy")
def _meetings(ox, oy, oz, dx, dy, dz, shape):
    """Distances at which a ray meets the mirror, two; inf where it does not."""
    radius, kappa = shape[:2]
    # The roots of `quadric_meetings`.
    a = dx * dx + dy * dy + kappa * dz * dz
    b = ox * dx + oy * dy + kappa * oz * dz - radius * dz
    c = ox * ox + oy * oy - oz * (2 * radius - kappa * oz)
    q = -(b + math.copysign(math.sqrt(b * b - a * c), b))
    one, other = q / a, c / q
    if not (one > 0 and _carries(ox + one * dx, oy + one * dy, oz + one * dz, shape)):
        one = np.inf
    if not (
        other > 0 and _carries(ox + other * dx, oy + other * dy, oz + other * dz, shape)
    ):
        other = np.inf
    return one, other


@numba.njit(cache=True, error_model="numpy")
def _carries(x, y, z, shape):
    """Whether a point of the quadric is between hole and edge of the mirror."""
    _, _, hole, rim, height = shape
    across, scale = math.hypot(x, y), EDGE_TOL * rim
    # A second sheet, or the far half of an ellipsoid, is as wide.
    middle = height * (1 + EDGE_TOL) + scale
    return hole - scale <= across <= rim + scale and -scale <= z <= middle


def conic_of(shape, axes):
    """(R, e, kappa) of a shape and its axes; InputError if no such surface exists."""
    names = SHAPES[checked_word("shape", shape, SHAPES)]
    listed = axes if isinstance(axes, list) else np.atleast_1d(axes)
    axes = checked_array("axes", listed, (None,))
    if len(axes) != len(names) or not ((axes > MIN_SCALE) & (axes < MAX_SCALE)).all():
        raise InputError(
            f"field 'axes': found {axes.tolist()}; give positive ({', '.join(names)}) "
            f"in mm for the {shape}"
        )
    if shape == "sphere":
        return axes[0], 0.0, 1.0
    if shape == "paraboloid":
        return 2 * axes[0], 1.0, 0.0
    a, b = axes
    if shape == "hyperboloid":
        return b * b / a, math.hypot(a, b) / a, -((b / a) ** 2)
    if not a > b:
        raise InputError(
            f"field 'axes': found {axes.tolist()}; give an ellipsoid with a above b "
            "(foci on the axis)"
        )
    return b * b / a, math.sqrt((a - b) * (a + b)) / a, (b / a) ** 2


# Maximum distance of the viewer from the focus in a central camera.
FOCUS_TOL_MM = 1e-9
# Direction of the mirror's axis +z (into the curve) in an aligned viewer's frame.
AXIS_ROTATIONS = {"outside": np.eye(3), "inside": np.diag([1.0, -1.0, -1.0])}


class QuadricMirrorCamera(MirrorCamera):
    """A viewer that sees the world in a mirror of revolution. Frame: the viewer's.

    A ray starts at the mirror and runs into the world. A pixel has one where the
    viewer's ray meets the silvered side first and does not meet the mirror again. The
    viewer's own body hides nothing. The camera is central with the viewer at one focus
    of the mirror, and `centre` then is the other; for a paraboloid the viewer is
    orthographic and parallel to the axis. A viewer tilted about its focus remains
    central.

    Parameters
    ----------
    viewer : Camera
        Central camera with its centre at the origin of its frame, or an
        `OrthographicCamera`.
    shape, axes, rim_radius, hole_radius
        See `ConicMirror`.
    T_viewer_mirror : array_like, shape (4, 4)
        Pose, mm; the mirror's frame has its origin at the apex and +z along the axis
        into the curve.
    side : str, optional
        See `ConicMirror`; 'outside' (convex) if omitted, for an ellipsoid 'inside'.

    Raises
    ------
    InputError
        The mirror is behind the viewer, the viewer behind the mirror, or no mirror can
        have the values.

    References
    ----------
    Baker, Nayar 1999, doi:10.1023/A:1008128724364; off the focus, Micusik, Pajdla 2004,
    Autocalibration and 3D reconstruction with non-central catadioptric cameras, CVPR.
    """

    kind = "quadric mirror"

    def __init__(
        self,
        viewer: Camera,
        shape: str,
        axes: ArrayLike,
        rim_radius: float,
        T_viewer_mirror: ArrayLike,
        side: str | None = None,
        hole_radius: float = 0.0,
    ) -> None:
        viewer, self.shape = checked_viewer(viewer), shape
        self.side = usual_side(shape) if side is None else side
        mirror = ConicMirror(shape, axes, rim_radius, hole_radius, self.side)
        self._place(viewer, mirror, T_viewer_mirror)
        self.axes = checked_array("axes", np.atleast_1d(axes), (None,))
        self.rim_radius, self.hole_radius = mirror.rim, mirror.hole
        self._check_sides()
        self._focus = self._effective_focus()

    @classmethod
    def on_axis(
        cls,
        viewer: Camera,
        shape: str,
        axes: ArrayLike,
        rim_radius: float,
        distance: float,
        **optional: Any,
    ) -> QuadricMirrorCamera:
        """Return the camera with the mirror's apex ahead of the viewer, on its axis.

        It is central only if the distance happens to be right.

        Parameters
        ----------
        viewer, shape, axes, rim_radius
            As of the class.
        distance : float
            Distance of the apex from the viewer, mm.
        **optional
            side, hole_radius.

        Returns
        -------
        QuadricMirrorCamera
            Camera.
        """
        side = optional.get("side") or usual_side(shape)
        # The constructor rejects an unknown side, with the reason.
        T = pose(AXIS_ROTATIONS.get(side, AXIS_ROTATIONS["outside"]), [0, 0, distance])
        return cls(viewer, shape, axes, rim_radius, T, **optional)

    @classmethod
    def aligned(
        cls,
        viewer: Camera,
        shape: str,
        axes: ArrayLike,
        rim_radius: float,
        **optional: Any,
    ) -> QuadricMirrorCamera:
        """Return the central camera: viewer at the focus, axis along the mirror's.

        An orthographic viewer belongs to a paraboloid. Its distance from the mirror is
        one focal length and the depth of the mirror's edge.

        Parameters
        ----------
        viewer, shape, axes, rim_radius
            As of the class.
        **optional
            side, hole_radius.

        Returns
        -------
        QuadricMirrorCamera
            Camera.

        Raises
        ------
        InputError
            The combination has no such position.
        """
        viewer = checked_viewer(viewer)
        side = optional.get("side") or usual_side(shape)
        mirror = ConicMirror(shape, axes, rim_radius, 0.0, side)
        if isinstance(viewer, OrthographicCamera) != (shape == "paraboloid"):
            raise InputError(
                f"field 'viewer': found {viewer.kind!r} with a {shape}; give an "
                "orthographic viewer for a paraboloid, and only for that"
            )
        if shape == "sphere" or (shape, side) == ("ellipsoid", "outside"):
            raise InputError(
                f"field 'shape': a {shape} silvered {side} makes no central camera; "
                "place the viewer with 'on_axis'"
            )
        if shape == "paraboloid":
            distance = mirror.foci[0] + mirror.height
        else:
            near, far = np.abs(mirror.foci)
            distance = near if (shape, side) == ("hyperboloid", "inside") else far
        return cls.on_axis(viewer, shape, axes, rim_radius, distance, **optional)

    @classmethod
    def misaligned(
        cls,
        viewer: Camera,
        shape: str,
        axes: ArrayLike,
        rim_radius: float,
        offset: ArrayLike,
        rotation: ArrayLike = (0, 0, 0),
        **optional: Any,
    ) -> QuadricMirrorCamera:
        """Return the aligned camera with its mirror shifted and rotated.

        Parameters
        ----------
        viewer, shape, axes, rim_radius
            As of the class.
        offset : array_like, shape (3,)
            Shift in the viewer's frame, mm.
        rotation : array_like, shape (3,)
            Rotation vector about the apex, rad, same frame.
        **optional
            side, hole_radius.

        Returns
        -------
        QuadricMirrorCamera
            Camera.
        """
        T = cls.aligned(viewer, shape, axes, rim_radius, **optional).T_viewer_mirror
        turn = rotation_from_vector(checked_array("rotation", rotation, (3,)))
        offset = checked_array("offset", offset, (3,))
        moved = pose(turn @ T[:3, :3], T[:3, 3] + offset)
        return cls(viewer, shape, axes, rim_radius, moved, **optional)

    @property
    def central(self) -> bool:
        """Whether all rays, continued, meet in one point."""
        return self._focus is not None

    @property
    def centre(self) -> NDArray[np.float64] | None:
        """The point (3,) where all rays meet, in the viewer's frame; else None."""
        if self._focus is None:
            return None
        return transform(self.T_viewer_mirror, self._focus)

    @property
    def parameters(self) -> int:
        """Viewer, axes and pose, without a rotation about the axis of the mirror.

        A central camera has two parameters of its pose: tilts, or shifts across
        parallel rays. Rotations of a sphere and shifts along parallel rays do not
        count.
        """
        free = 3 if self.shape == "sphere" else 5
        free = 2 if self.central else free - self._parallel
        return self.viewer.parameters + len(self.axes) + free

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Central: the line from the focus to the point holds the mirror point. Else:
        the path from viewer to point is stationary (`reflection_points`), to rounding.
        A convex mirror shows a point once. A concave one may show a point short of
        its caustic several times: one of these pixels is given, and rarely, where two
        nearly coincide, none.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points that the mirror shows.
        """
        return super().project(points)

    def _shown_at(self, points):
        return (
            self._on_line_from_focus(points)
            if self.central
            else super()._shown_at(points)
        )

    def _on_line_from_focus(self, points):
        steps = self.mirror.quadric_meetings(
            np.broadcast_to(self._focus, points.shape), points - self._focus
        )
        found = np.full(points.shape, np.nan)
        for step in steps.T:
            with np.errstate(invalid="ignore"):
                M = self._focus + step[:, None] * (points - self._focus)
            good = self._retraces(M, points)
            found[good] = M[good]
        return found

    def _check_sides(self):
        apex = self.T_viewer_mirror[:3, 3]
        if not apex[2] > 0:
            raise InputError(
                f"field 'T_viewer_mirror': the mirror's apex is behind the viewer (z = "
                f"{apex[2]:g} mm); give a positive z"
            )
        if self._parallel:
            wrong = (self._axis[2] > 0) == self.mirror.inside
        elif self.mirror.inside:
            wrong = not self._eye[2] > 0
        else:
            wrong = self.mirror.encloses(self._eye[None])[0]
        if wrong:
            raise InputError(
                "field 'T_viewer_mirror': the viewer is not on the silvered side, "
                f"which is the {self.side}; rotate or move the mirror"
            )

    def _effective_focus(self):
        """Focus of all rays, in the mirror's frame, or None."""
        near, far = self.mirror.foci
        if self._parallel:
            tilt = np.hypot(*self._axis[:2]) * self.mirror.radius
            fits = self.shape == "paraboloid" and tilt <= FOCUS_TOL_MM
            return np.array([0, 0, near]) if fits else None
        for here, other in ((near, far), (far, near)):
            gap = np.linalg.norm(self._eye - [0, 0, here]) if here < np.inf else np.inf
            if gap <= FOCUS_TOL_MM and np.isfinite(other):
                return np.array([0, 0, other])
        return None

    def _fields(self):
        return nested_fields("viewer", self.viewer) | {
            "shape": np.array(self.shape),
            "axes": self.axes,
            "rim_radius": np.array(self.rim_radius),
            "T_viewer_mirror": self.T_viewer_mirror,
            "side": np.array(self.side),
            "hole_radius": np.array(self.hole_radius),
        }

    @classmethod
    def _from_file(cls, file):
        return cls(
            file.nested("viewer"),
            file.text("shape"),
            file.numbers("axes"),
            file.number("rim_radius"),
            file.numbers("T_viewer_mirror"),
            file.text("side"),
            file.number("hole_radius"),
        )


def usual_side(shape):
    """Convex mirrors are silvered outside; an ellipsoid has both foci inside."""
    return "inside" if shape == "ellipsoid" else "outside"
