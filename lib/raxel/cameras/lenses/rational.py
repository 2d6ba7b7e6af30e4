"""Rational models: ratios of cubics in the image plane, and lifted coordinates."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    as_rows,
    check_size,
    checked_array,
    checked_calibration_matrix,
)
from raxel.cameras.core.storage import NamedFields
from raxel.cameras.lenses.azimuthal import AzimuthalCamera, PlaneLaw
from raxel.cameras.lenses.perspective import distortion_warp
from raxel.cameras.lenses.plane_map import PlaneMap, determinant
from raxel.errors import InputError

# Domain of a lifted camera around the image, in half diagonals.
MAP_HALF_DIAGONALS = 1.5


def cubic_monomials(p):
    """1, x, y, x^2, x y, y^2, x^3, x^2 y, x y^2, y^3 (N, 10) and both derivatives."""
    x, y = p.T
    one, nil = np.ones_like(x), np.zeros_like(x)
    m = [one, x, y, x * x, x * y, y * y, x**3, x * x * y, x * y * y, y**3]
    m_x = [nil, one, nil, 2 * x, y, nil, 3 * x * x, 2 * x * y, y * y, nil]
    m_y = [nil, nil, one, nil, x, 2 * y, nil, x * x, 2 * x * y, 3 * y * y]
    return np.column_stack(m), np.column_stack(m_x), np.column_stack(m_y)


class CubicMap(PlaneMap):
    """(N_u / D_u, N_v / D_v), while both denominators keep their sign."""

    def __init__(self, coefficients, radius):
        self._cubics = coefficients.T
        super().__init__(radius)

    def value(self, p):
        n_u, d_u, n_v, d_v = (cubic_monomials(p)[0] @ self._cubics).T
        return np.column_stack([n_u / d_u, n_v / d_v])

    def jacobian(self, p):
        # (4, N, 3): each cubic's value and two derivatives.
        n_u, d_u, n_v, d_v = np.stack(
            [m @ self._cubics for m in cubic_monomials(p)], axis=-1
        ).transpose(1, 0, 2)
        rows = [
            (n[:, 1:] - (n[:, :1] / d[:, :1]) * d[:, 1:]) / d[:, :1]
            for n, d in ((n_u, d_u), (n_v, d_v))
        ]
        return np.stack(rows, axis=1)

    def regular(self, p):
        with np.errstate(all="ignore"):
            ahead = (cubic_monomials(p)[0] @ self._cubics[:, 1::2] > 0).all(axis=1)
        return super().regular(p) & ahead


class RationalCubicCamera(PlaneLaw, AzimuthalCamera):
    """Each pixel coordinate is a ratio of two cubic polynomials of the image point.

    u = N_u(x, y) / D_u(x, y), v = N_v(x, y) / D_v(x, y) with (x, y) = (X / Z, Y / Z).
    D_u and D_v are scaled to 1 at the principal point. The camera sees points with Z >
    0 inside the first circle where a denominator vanishes or the map folds. Pixels are
    solved for their rays numerically.

    There are 38 parameters: 40 coefficients, less one scale for each ratio. The
    published model divides cubics of the three space coordinates, 20 coefficients each:
    the 80 of the thesis (78 without the scales). Then the points behind one pixel form
    a curve, not a ray. They form rays through one centre only if the cubics are
    homogeneous in (X, Y, Z), with 10 coefficients each, and that is this class.

    Parameters
    ----------
    coefficients : array_like, shape (4, 10)
        Rows N_u, D_u, N_v, D_v over 1, x, y, x^2, x y, y^2, x^3, x^2 y, x y^2, y^3.
    width, height : int
        Size of the image, px.
    max_angle : float, optional
        Largest angle to the axis, rad; the law's own limit if omitted.

    Raises
    ------
    InputError
        A field has values that no such camera can have; the message names it.

    References
    ----------
    Hartley and Saxena 1997, The cubic rational polynomial camera model, DARPA Image
    Understanding Workshop.
    """

    kind = "rational cubic"

    def __init__(
        self,
        coefficients: ArrayLike,
        width: int,
        height: int,
        max_angle: float | None = None,
    ) -> None:
        check_size(self, width, height)
        coefficients = np.array(checked_array("coefficients", coefficients, (4, 10)))
        for numerator, denominator, name in ((0, 1, "D_u"), (2, 3, "D_v")):
            scale = coefficients[denominator, 0]
            if scale == 0:
                raise InputError(
                    f"field 'coefficients': {name} is 0 at the principal point; give a "
                    "nonzero constant term"
                )
            coefficients[numerator : denominator + 1] /= scale
        self.coefficients = coefficients
        self._set_up(
            np.eye(2),
            np.zeros(2),
            max_angle,
            math.pi / 2,
            math.inf,
            lambda radius: CubicMap(coefficients, radius),
        )

    @property
    def parameters(self) -> int:
        """40 coefficients, less the scale of each of the two ratios."""
        return 38


class LiftedMap(PlaneMap):
    """Offsets from the image centre to the stereographic chart around its ray.

    lifted: (3, 6), directions over x^2, x y, y^2, x, y, 1 in the chart's frame.
    """

    def __init__(self, lifted, radius):
        self._lifted = lifted
        # A mirrored map has the other orientation everywhere.
        area = determinant(self.jacobian(np.zeros((1, 2))))[0]
        self._sign = np.sign(area) * (abs(area) > 1e-24 * np.sum(lifted**2))
        super().__init__(radius)

    def value(self, p):
        g = lift(p) @ self._lifted.T
        length = np.linalg.norm(g, axis=1)
        return g[:, :2] / (length + g[:, 2])[:, None]

    def jacobian(self, p):
        (x, y), one, nil = p.T, np.ones(len(p)), np.zeros(len(p))
        g = lift(p) @ self._lifted.T
        length = np.linalg.norm(g, axis=1)[:, None]
        below = length + g[:, 2:]
        columns = []
        for change in ([2 * x, y, nil, one, nil, nil], [nil, x, 2 * y, nil, one, nil]):
            dg = np.column_stack(change) @ self._lifted.T
            d_below = np.sum(g * dg, axis=1, keepdims=True) / length + dg[:, 2:]
            columns.append((dg[:, :2] - g[:, :2] / below * d_below) / below)
        return np.stack(columns, axis=2)

    def regular(self, p):
        with np.errstate(all="ignore"):
            return self._sign * determinant(self.jacobian(p)) > 0


def lift(p):
    """chi = x^2, x y, y^2, x, y, 1 of points (N, 2): (N, 6)."""
    x, y = p.T
    return np.column_stack([x * x, x * y, y * y, x, y, np.ones_like(x)])


def lift_of_scaled(centre, scale):
    """S (6, 6) with chi(centre + scale p) = S chi(p)."""
    (a, b), s = centre, scale
    return np.array(
        [
            [s * s, 0, 0, 2 * a * s, 0, a * a],
            [0, s * s, 0, b * s, a * s, a * b],
            [0, 0, s * s, 0, 2 * b * s, b * b],
            [0, 0, 0, s, 0, a],
            [0, 0, 0, 0, s, b],
            [0, 0, 0, 0, 0, 1],
        ]
    )


class LiftedRationalCamera(NamedFields, Camera):
    """Direction = A chi(u, v) with chi = (u^2, u v, v^2, u, v, 1), pixels.

    `rays` is the closed form. `project` finds the pixel where the two conics given by a
    direction meet, on the branch that holds the image. That branch is the largest disc
    about mid-image on which the map does not fold, at most 1.5 half diagonals wide.
    Pixels outside that disc have no ray. 18 coefficients up to one scale give 17
    parameters. With lifted coordinates alone no principal axis is distinguished;
    directions may pass 90 degrees from any axis.

    Parameters
    ----------
    A : array_like, shape (3, 6)
        Coefficients; the sign matters, the size does not.
    width, height : int
        Size of the image, px.

    Raises
    ------
    InputError
        A field has values that no such camera can have; the message names it.

    References
    ----------
    Claus and Fitzgibbon 2005, doi:10.1109/CVPR.2005.43.
    """

    kind = "lifted rational"
    central = True
    parameters = 17

    def __init__(self, A: ArrayLike, width: int, height: int) -> None:
        check_size(self, width, height)
        self.A = checked_array("A", A, (3, 6))
        self._centre = np.array([self.width - 1, self.height - 1]) / 2
        self._scale = math.hypot(self.width, self.height) / 2
        lifted = self.A @ lift_of_scaled(self._centre, self._scale)
        if not np.linalg.norm(lifted[:, 5]) > 0:
            raise InputError(
                "field 'A': the image centre has no direction; give another A"
            )
        self._rotation = _frame_around(lifted[:, 5])
        lifted = self._rotation @ lifted / np.linalg.norm(lifted[:, 5])
        self._map = LiftedMap(lifted, MAP_HALF_DIAGONALS)
        if not self._map.limit > 0:
            raise InputError("field 'A': the image folds at its centre; give another A")
        self.max_radius_px = self._map.limit * self._scale

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays through the origin, in closed form."""
        with np.errstate(over="ignore", invalid="ignore"):
            p = (as_rows(pixels, 2) - self._centre) / self._scale
        q, valid = self._map.apply(p)
        squared = np.sum(q * q, axis=1, keepdims=True)
        d = np.hstack([2 * q, 1 - squared]) / (1 + squared) @ self._rotation
        return Rays(0.0 * d, d, valid)

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points.
        """
        with np.errstate(all="ignore"):
            x, y, z = (as_rows(points, 3) @ self._rotation.T).T
            below = np.hypot(np.hypot(x, y), z) + z
            q = np.column_stack([x, y]) / below[:, None]
        p, valid = self._map.invert(q)
        return Projection(self._centre + self._scale * p, valid)


def _frame_around(axis):
    """A rotation (3, 3) that maps `axis` to +z."""
    z = axis / np.linalg.norm(axis)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z])


# The unified sphere model of central catadioptric cameras, with distortion.


class UnifiedSphereCamera(AzimuthalCamera):
    """Onto the unit sphere, then from a point xi behind its centre onto a plane.

    With X on the sphere, p = (x, y) / (z + xi), so r = sin theta / (cos theta + xi). xi
    = 0 is a pinhole, xi = 1 a paraboloid, 0 < xi < 1 a hyperboloid or ellipsoid; xi > 1
    fits some fisheye lenses. For xi <= 1 the field of view ends at cos theta = -xi,
    where r is infinite. For xi > 1 it ends at cos theta = -1 / xi, where r = 1 /
    sqrt(xi^2 - 1) turns. 6 parameters, with distortion 6 + n + 2, and 2 of a prism. The
    centre of the image sees +z.

    Parameters
    ----------
    xi : float
        Offset of the centre of projection, xi >= 0.
    K : array_like, shape (3, 3)
        Matrix of the form (2.1) after the distortion, px.
    width, height : int
        Size of the image, px.
    radial : array_like, shape (n,)
        Radial coefficients (2.4), which act on p as Mei and Rives do; theirs has three.
    tangential : array_like, shape (2,)
        (p1, p2), as Mei and Rives.
    max_angle : float, optional
        Largest angle to the axis, rad; the law's own limit if omitted.
    prism : array_like, shape (2,)
        (s1, s2), adds (s1 r^2, s2 r^2) to p.

    Raises
    ------
    InputError
        A field has values that no such camera can have; the message names it.

    References
    ----------
    Geyer and Daniilidis 2000, doi:10.1007/3-540-45053-X_29; Mei and Rives 2007,
    doi:10.1109/ROBOT.2007.364084.
    """

    kind = "unified sphere"

    def __init__(
        self,
        xi: float,
        K: ArrayLike,
        width: int,
        height: int,
        radial: ArrayLike = (),
        tangential: ArrayLike = (0, 0),
        max_angle: float | None = None,
        prism: ArrayLike = (0, 0),
    ) -> None:
        check_size(self, width, height)
        self.xi = float(checked_array("xi", xi, ()))
        if self.xi < 0:
            raise InputError(f"field 'xi': found {xi}; give a value of 0 or more")
        self.K = checked_calibration_matrix(K)
        self.radial = checked_array("radial", radial, (None,))
        self.tangential = checked_array("tangential", tangential, (2,))
        self.prism = checked_array("prism", prism, (2,))
        if self.xi <= 1:
            limits = math.acos(-self.xi), math.inf
        else:
            limits = math.acos(-1 / self.xi), 1 / math.sqrt(self.xi**2 - 1)
        warp = distortion_warp(self.radial, self.tangential, self.prism)
        self._set_up(self.K[:2, :2], self.K[:2, 2], max_angle, *limits, warp)

    @property
    def parameters(self) -> int:
        """xi, the five of K, and the distortion."""
        off_axis = [terms for terms in (self.tangential, self.prism) if np.any(terms)]
        return 6 + len(self.radial) + 2 * len(off_axis)

    def _radius(self, angle):
        return np.sin(angle) / (np.cos(angle) + self.xi)

    def _angle(self, radius):
        xi, squared = self.xi, radius**2
        root = np.sqrt(np.maximum(1 + (1 - xi * xi) * squared, 0.0))
        # The ray (t p, t - xi) meets the sphere at t = (xi + root) / (1 + r^2).
        return np.arctan2(radius * (xi + root), root - xi * squared)
