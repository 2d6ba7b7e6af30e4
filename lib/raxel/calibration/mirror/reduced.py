"""Calibration of the reduced model of a bent mirror, a cubic in a plane (5.2).

The grid is seen before and after bending. Two steps follow each other (5.2.2): a linear
one from directions alone, which takes the scene to be infinitely far away, and a
refinement that makes the distances of the features from their scene rays small. The
clamp does not move, and both keep it.

Frames and units are those of `raxel.calibration.mirror.curves`.
Source of the linear stage: Halstead et al. 1996, doi:10.1145/237170.237272; of the
infinite scene and the ray-point distance: the thesis, (5.28) and (5.29).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.curves import (
    DistanceCurve,
    HeightCurve,
    cross,
    dot,
    reflected,
    viewing_rays,
)
from raxel.errors import CalibrationError
from raxel.geometry.damped import descend, gauss_newton

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
