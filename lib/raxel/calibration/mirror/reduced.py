"""Calibration of the reduced model of a bent mirror, a cubic in a plane (5.2).

The grid is seen before and after bending. Two steps follow each other (5.2.2): a linear
one from directions alone, which takes the scene to be infinitely far away, and a
refinement that makes the distances of the features from their scene rays small. The
clamp does not move, and both keep it.

Frames and units are those of `raxel.calibration.mirror.reduced`.
Source of the linear stage: Halstead et al. 1996, doi:10.1145/237170.237272; of the
infinite scene and the ray-point distance: the thesis, (5.28) and (5.29).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from raxel.errors import CalibrationError
from raxel.geometry.least_squares import descend, gauss_newton

# Two readings of the reduced model (5.2): a bent mirror as a cubic in a plane.
# Everything lies in the plane at right angles to the clamp line. The viewer's centre
# is the origin, the z axis its principal axis, and a pixel is the normalised
# coordinate u = x / z of its viewing ray. Points and directions are rows (x, z), in
# mm. The thesis calls u the image coordinate and takes the slope dS/du as that of a
# beam, which is metric (E-5.01). `DistanceCurve` is the first: with (5.3) the mirror
# is S(u) = D(u) V_l(u), D a cubic of u. `HeightCurve` is the second: the height over
# the line of the clamp is a cubic of the length along it, as in the beam's formula
# (5.1). Both bring their variable to about [-1, 1] or [0, 1], so that four powers are
# well conditioned. Both answer the same questions, which is all that a calibration
# asks: where a viewing ray meets the mirror, how steep it is there, and how both
# change with the coefficients.


NEWTON_STEPS = 50


class _Curve:
    """What both curves share; each has `distances`, `tangents` and their changes."""

    def replaced(self, coefficients):
        """The same curve with other coefficients (4,)."""
        return replace(self, coefficients=np.asarray(coefficients, float))

    def points(self, u):
        """Mirror points S (N, 2) on viewing rays u (N,), mm."""
        return self.distances(u)[:, None] * viewing_rays(u)[0]

    def scene_rays(self, u):
        """Unit directions (N, 2) from the mirror into the scene."""
        return reflected(viewing_rays(u)[0], self.tangents(u))


@dataclass(frozen=True)
class DistanceCurve(_Curve):
    """Distances along the viewing rays, a cubic of the picture.

    coefficients: (4,) mm, of 1, s, s^2, s^3, with s = -1 at the clamp and +1 at the
    free edge; span: u of both.
    """

    coefficients: np.ndarray
    span: tuple[float, float]

    def distances(self, u):
        """Distances D (N,) from the viewer, mm."""
        return self._rows(u)[0] @ self.coefficients

    def tangents(self, u):
        """dS/du (N, 2), not of unit length."""
        b, b_u = self._rows(u)
        V, V_u = viewing_rays(u)
        D, D_u = b @ self.coefficients, b_u @ self.coefficients
        return D[:, None] * V_u + D_u[:, None] * V

    def way(self, u):
        """Share (N,) of the way from clamp to free edge, in the picture."""
        return (np.asarray(u, float) - self.span[0]) / (self.span[1] - self.span[0])

    def changes(self, u):
        """Changes with the coefficients (N, 4): of D, and of the tangent's angle."""
        b, b_u = self._rows(u)
        V, V_u = viewing_rays(u)
        S_u = self.tangents(u)
        turn = cross(S_u, V)[:, None] * b_u + cross(S_u, V_u)[:, None] * b
        return b, turn / dot(S_u, S_u)[:, None]

    def slope_equations(self, u, normals):
        """Rows (N, 4) and right sides (N,): tangents at right angles to normals (5.15).

        (dV_l/du . N) D + (V_l . N) dD/du = 0, linear in the coefficients of D.
        """
        b, b_u = self._rows(u)
        V, V_u = viewing_rays(u)
        rows = dot(V_u, normals)[:, None] * b + dot(V, normals)[:, None] * b_u
        return rows, np.zeros(len(rows))

    def clamp_equation(self, clamp):
        """Row (4,) and right side: the distance at the clamped edge is known (5.20)."""
        u, distance = clamp
        return self._rows([u])[0][0], distance

    def _rows(self, u):
        """Powers of s (N, 4), and their derivatives by u (N, 4)."""
        rate = 2 / (self.span[1] - self.span[0])
        b, b_s = _powers(2 * self.way(u) - 1)
        return b, rate * b_s


@dataclass(frozen=True)
class HeightCurve(_Curve):
    """Height over the line of the clamped mirror, a cubic of the length along it.

    coefficients: (4,) mm, of 1, s, s^2, s^3, with s = length along the line / length.
    foot: (2,) mm, where the line starts; direction: (2,) unit, along it; the height
    counts across, a quarter turn on from the direction. length: mm, to the free edge.
    """

    coefficients: np.ndarray
    foot: np.ndarray
    direction: np.ndarray
    length: float

    def distances(self, u):
        """Distances D (N,) from the viewer, mm, by Newton's steps.

        Raises CalibrationError where a viewing ray passes the curve.
        """
        V = viewing_rays(u)[0]
        along, across = V @ self.direction, V @ self._upright
        foot = self.foot @ self.direction, self.foot @ self._upright
        with np.errstate(divide="ignore", invalid="ignore"):
            D = foot[1] / across
            for _ in range(NEWTON_STEPS):
                height, slope = self._height(D * along - foot[0])
                step = (D * across - foot[1] - height) / (across - slope * along)
                D = D - step
                if np.all(np.abs(step) <= 1e-12 * np.abs(D)):
                    return D
        raise CalibrationError(
            "reduced mirror: a viewing ray does not meet the curve; check the line of "
            "the clamp, and which picture was taken before",
            code="ray-misses-mirror",
        )

    def tangents(self, u):
        """Tangents (N, 2), of length 1 along the line."""
        _, slope = self._height(self._lengths(u))
        return self.direction + slope[:, None] * self._upright

    def way(self, u):
        """Share (N,) of the way from clamp to free edge, along the line."""
        return self._lengths(u) / self.length

    def changes(self, u):
        """Changes with the coefficients (N, 4): of D, and of the tangent's angle.

        The point slides on its viewing ray until its height is right again.
        """
        x = self._lengths(u)
        b, b_x, b_xx = self._rows(x)
        V = viewing_rays(u)[0]
        slope = b_x @ self.coefficients
        along, across = V @ self.direction, V @ self._upright
        slide = b / (across - slope * along)[:, None]
        bend = (b_xx @ self.coefficients) * along
        return slide, (b_x + bend[:, None] * slide) / (1 + slope**2)[:, None]

    def slope_equations(self, u, normals):
        """Rows (N, 4) and right sides (N,): tangents at right angles to normals (5.9).

        The slope is linear in the coefficients where the features lie; they are taken
        to lie where their rays meet this curve, the one before.
        """
        _, b_x, _ = self._rows(self._lengths(u))
        return (normals @ self._upright)[:, None] * b_x, -normals @ self.direction

    def clamp_equation(self, clamp):
        """Row (4,) and right side: the height of the known point at the clamp."""
        u, distance = clamp
        point = distance * viewing_rays([u])[0][0] - self.foot
        b, _, _ = self._rows(np.array([point @ self.direction]))
        return b[0], float(point @ self._upright)

    @property
    def _upright(self):
        return np.array([-self.direction[1], self.direction[0]])

    def _lengths(self, u):
        return (self.points(u) - self.foot) @ self.direction

    def _rows(self, x):
        """Powers of s (N, 4), and their first two derivatives by the length."""
        b, b_s = _powers(x / self.length)
        s = x / self.length
        none = np.zeros_like(s)
        b_ss = np.stack([none, none, none + 2, 6 * s], axis=1)
        return b, b_s / self.length, b_ss / self.length**2

    def _height(self, x):
        b, b_x, _ = self._rows(x)
        return b @ self.coefficients, b_x @ self.coefficients


def viewing_rays(u):
    """Unit viewing rays V_l (N, 2) of u (N,), and their derivatives by u (5.17)."""
    u = np.asarray(u, float)
    length = np.sqrt(1 + u**2)[:, None]
    V = np.column_stack([u, np.ones_like(u)]) / length
    return V, np.column_stack([np.ones_like(u), -u]) / length**3


def reflected(directions, tangents):
    """Directions (N, 2) after reflection at tangents (N, 2) of any length.

    The part along the tangent stays, the part across changes its sign.
    """
    along = tangents / np.linalg.norm(tangents, axis=1, keepdims=True)
    return 2 * dot(directions, along)[:, None] * along - directions


def dot(a, b):
    """Scalar products (N,) of rows."""
    return np.einsum("ij,ij->i", a, b)


def cross(a, b):
    """a_x b_z - a_z b_x (N,), positive where b is on from a, from x towards z."""
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _powers(s):
    """1, s, s^2, s^3 (N, 4), and their derivatives by s (N, 4)."""
    one, none = np.ones_like(s), np.zeros_like(s)
    b = np.stack([one, s, s**2, s**3], axis=1)
    return b, np.stack([none, one, 2 * s, 3 * s**2], axis=1)


LEAST_FEATURES = 4
"""The clamp leaves three unknowns; one more feature can tell a misfit."""
LEAST_REACH = 1 / 3
"""Of the way from clamp to free edge, to the outermost feature: beyond three times as
far as it was measured, the end of a cubic is a guess."""
FIRST_TURNS = 120
"""Directions of a row of points that are tried, 3 degrees apart."""


class ReducedCalibration(NamedTuple):
    """What a dynamic calibration of the reduced model returns.

    curve: refined; linear: as the linear stage left it. residuals: (N,) mm, offsets of
    the features from their scene rays. covariance: (4, 4) mm^2, of the coefficients,
    from the residuals' scatter. reach: share of the way from clamp to free edge at
    which the outermost feature lies; beyond, the curve is carried on.
    """

    curve: DistanceCurve | HeightCurve
    linear: DistanceCurve | HeightCurve
    costs: np.ndarray
    residuals: np.ndarray
    covariance: np.ndarray
    reach: float
    converged: bool

    def deviation(self, u):
        """Standard deviation (N,) of the distances along viewing rays u (N,), mm."""
        slide, _ = self.curve.changes(u)
        return np.sqrt(np.einsum("ij,jk,ik->i", slide, self.covariance, slide))


def calibrate_reduced(before, u, scene_rays, points, clamp):
    """The curve of a bent mirror from one grid, seen before and after (5.2.2).

    before: the curve before bending, with the span or length of the mirror after it; of
    a `DistanceCurve` the span alone is used. u: (N,) features after bending, as
    normalised coordinates. scene_rays: (N, 2), the directions in which the same
    features were seen before; in the linear stage they stand for those after (5.28).
    points: (N, 2) mm, where the features are. clamp: u of the clamped edge, and its
    distance along that viewing ray, mm.

    Returns ReducedCalibration. Raises CalibrationError for fewer than four features,
    values that are not finite, features outside the mirror, none beyond a third of it,
    too few different ones, and a curve that comes to the viewer.
    """
    u, scene_rays, points = (np.asarray(v, float) for v in (u, scene_rays, points))
    for given in (u, scene_rays, points, clamp):
        if not np.all(np.isfinite(given)):
            raise CalibrationError(
                "reduced mirror: found values that are not finite", code="not-finite"
            )
    if len(np.unique(u)) < LEAST_FEATURES:
        raise CalibrationError(
            f"reduced mirror: found {len(np.unique(u))} different features seen before "
            f"and after; give {LEAST_FEATURES} or more, spread from clamp to free edge",
            code="too-few-features",
        )
    linear = linear_reduced(before, u, scene_rays, clamp)
    return refine_reduced(linear, u, points, clamp)


def linear_reduced(before, u, scene_rays, clamp):
    """The curve from viewing and scene rays alone, linear (5.8, 5.9, 5.19 to 5.22).

    The normal halves the angle between the rays, N ~ V_l - V_r, and the tangent is at
    right angles to it: an equation for each feature. The clamp gives the scale.
    """
    across = viewing_rays(u)[0] - scene_rays
    length = np.linalg.norm(across, axis=1, keepdims=True)
    if np.any(length < 1e-9):
        raise CalibrationError(
            "reduced mirror: a scene ray goes on along its viewing ray, and none is "
            "reflected so; give directions from the mirror into the scene",
            code="no-reflection",
        )
    rows, sides = before.slope_equations(u, across / length)
    particular, basis = _kept_clamp(before, clamp)
    free = np.linalg.lstsq(rows @ basis, sides - rows @ particular, rcond=None)[0]
    return before.replaced(particular + basis @ free)


def refine_reduced(start, u, points, clamp):
    """ReducedCalibration from a start: least ray-point distances (5.29)."""
    particular, basis = _kept_clamp(start, clamp)

    def curve_of(free):
        return start.replaced(particular + basis @ free)

    def evaluate(free):
        residuals, jacobian = ray_point_offsets(curve_of(free), u, points)
        return gauss_newton(residuals, lambda: jacobian @ basis)

    free, costs, converged = descend(
        evaluate,
        np.add,
        basis.T @ (start.coefficients - particular),
        iterations=100,
        tolerance=1e-12,
        rounding=1e-24 * np.sum(points**2),
    )
    curve = curve_of(free)
    reach = _reach(curve, u)
    residuals, jacobian = ray_point_offsets(curve, u, points)
    covariance = basis @ _covariance(residuals, jacobian @ basis) @ basis.T
    return ReducedCalibration(
        curve, start, costs, residuals, covariance, reach, converged
    )


def ray_point_offsets(curve, u, points):
    """Offsets (N,) of points from their scene rays, mm, and their Jacobian (N, 4).

    In a plane the vector of (5.29) lies across the ray; this is its length with a sign,
    e = V_r x (P - S). The scene ray turns twice as fast as the tangent, so that
    de = -2 (V_r . (P - S)) d(angle) - (V_r x V_l) dD.
    """
    V = viewing_rays(u)[0]
    V_r = reflected(V, curve.tangents(u))
    q = points - curve.points(u)
    slide, turn = curve.changes(u)
    J = -2 * dot(V_r, q)[:, None] * turn - cross(V_r, V)[:, None] * slide
    return cross(V_r, q), J


def place_row(origins, directions, places):
    """Where a straight row of points lies, from a ray to each of them.

    origins, directions: (N, 2), the rays, directions of unit length; places: (N,) mm
    along the row. Returns (foot, way): the points are foot + places way, way (2,) of
    unit length. They have the least sum of squared distances from their rays, in front
    of them: the pose of a grid (2.26) in the plane. Non-central rays are fine.

    For a given way the foot follows linearly, so that one angle is left to search: all
    are tried, and the best is refined with the foot. Raises CalibrationError for fewer
    than three points, for parallel rays, and where no row lies in front of its rays.
    """
    if len(places) < 3:
        raise CalibrationError(
            f"row of points: found {len(places)} points; give 3 or more",
            code="too-few-features",
        )
    across = np.column_stack([-directions[:, 1], directions[:, 0]])
    start = _first_row(origins, directions, across, places)

    def evaluate(row):
        foot, way = row[:2], np.array([np.cos(row[2]), np.sin(row[2])])
        residuals = dot(across, foot + places[:, None] * way - origins)
        turned = across @ np.array([-way[1], way[0]])
        return gauss_newton(
            residuals, lambda: np.column_stack([across, places * turned])
        )

    tiny = 1e-26 * np.sum(places**2)
    row, *_ = descend(
        evaluate, np.add, start, iterations=50, tolerance=1e-14, rounding=tiny
    )
    return row[:2], np.array([np.cos(row[2]), np.sin(row[2])])


def _first_row(origins, directions, across, places):
    """Foot and angle (3,) of the best row tried that lies in front of its rays."""
    angles = np.linspace(0, 2 * np.pi, FIRST_TURNS, endpoint=False)
    ways = np.stack([np.cos(angles), np.sin(angles)])
    sides = dot(across, origins)[:, None] - places[:, None] * (across @ ways)
    Q, R = np.linalg.qr(across)
    if abs(R[1, 1]) < 1e-9 * abs(R[0, 0]):
        raise CalibrationError(
            "row of points: the rays are parallel, and say nothing about how far it is",
            code="parallel-rays",
        )
    feet = np.linalg.solve(R, Q.T @ sides)
    costs = np.sum((sides - across @ feet) ** 2, axis=0)
    for best in np.argsort(costs):
        points = feet[:, best] + places[:, None] * ways[:, best]
        if np.all(dot(points - origins, directions) > 0):
            return np.array([*feet[:, best], angles[best]])
    raise CalibrationError(
        "row of points: no row lies in front of all its rays; check that the rays "
        "point into the scene and that the points are in their order",
        code="behind-camera",
    )


def _kept_clamp(curve, clamp):
    """Coefficients of one curve through the clamp (4,), and of all others (4, 3).

    The clamp is one equation; what is free are the changes that leave it (5.21).
    """
    row, side = curve.clamp_equation(clamp)
    directions = np.linalg.svd(row[None])[2]
    return row * side / (row @ row), directions[1:].T


def _reach(curve, u):
    """Share of the way to the free edge that features reach; refuses bad support."""
    least = curve.distances(u).min()
    if not least > 0:
        raise CalibrationError(
            f"reduced mirror: the curve found comes to {least:.3g} mm from the viewer; "
            "check the clamp's distance, and which picture was taken before",
            code="behind-camera",
        )
    way = curve.way(u)
    outside = np.count_nonzero((way < -1e-9) | (way > 1 + 1e-9))
    if outside:
        raise CalibrationError(
            f"reduced mirror: {outside} of {len(u)} features lie outside the mirror, "
            f"at {way.min():.3g} to {way.max():.3g} of the way from clamp (0) to free "
            "edge (1); check the edges, and which picture was taken before",
            code="outside-mirror",
        )
    if way.max() < LEAST_REACH:
        raise CalibrationError(
            f"reduced mirror: the features reach {way.max():.0%} of the way from clamp "
            f"to free edge; have some beyond {LEAST_REACH:.0%}",
            code="short-reach",
        )
    return float(way.max())


def _covariance(residuals, J):
    """(P, P) of the free unknowns, from the scatter of the residuals."""
    scale = np.linalg.norm(J, axis=0)
    lengths = np.linalg.svd(J / scale, compute_uv=False)
    if lengths[-1] < 1e-9 * lengths[0]:
        raise CalibrationError(
            "reduced mirror: the features lie at too few different places; spread them "
            "between clamp and free edge",
            code="open-coefficients",
        )
    variance = residuals @ residuals / (len(residuals) - J.shape[1])
    return variance * np.linalg.inv(J.T @ J)
