"""Calibration of the reduced model of a bent mirror, a cubic in a plane (5.2).

The grid is seen before and after bending. The calibration has two steps (5.2.2). A
linear step uses directions only and assumes an infinitely distant scene. A refinement
minimises the distances of the features from their scene rays. The clamp does not move,
and both steps keep it.

Sources: linear step, Halstead et al. 1996, doi:10.1145/237170.237272; infinite scene
and ray-point distance, thesis (5.28) and (5.29).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import CalibrationError
from raxel.geometry.least_squares import descend, gauss_newton

# Two interpretations of the reduced model (5.2): a bent mirror as a cubic in a plane.
# The plane is perpendicular to the clamp line. The origin is the centre of the viewing
# camera, the z axis its optical axis, and a pixel is the normalised coordinate u = x /
# z of its viewing ray. Points and directions are rows (x, z), in mm. In the thesis u is
# the image coordinate, but the slope dS/du is that of a beam, which is metric (E-5.01).
# `DistanceCurve` is the first interpretation: with (5.3) the mirror is S(u) = D(u)
# V_l(u), D a cubic of u. `HeightCurve` is the second: the height over the clamp line is
# a cubic of the length along it, as in the beam equation (5.1). Both scale their
# variable to about [-1, 1] or [0, 1], so that four powers are well conditioned. Both
# compute what a calibration needs: the intersection of a viewing ray with the mirror,
# the slope there, and the derivatives of both with respect to the coefficients.


MAX_N_NEWTON_STEPS = 50


class _Curve:
    """Common part of both curves; each has `distances`, `tangents`, their changes."""

    def replaced(self, coefficients: ArrayLike) -> Self:
        """Return the same curve with other coefficients.

        Parameters
        ----------
        coefficients : array_like, shape (4,)
            Coefficients of the cubic, mm.

        Returns
        -------
        DistanceCurve or HeightCurve
            A curve of the same class.
        """
        return replace(self, coefficients=np.asarray(coefficients, float))  # type: ignore[type-var]

    def points(self, u: ArrayLike) -> NDArray[np.float64]:
        """Return the mirror points on viewing rays.

        Parameters
        ----------
        u : array_like, shape (N,)
            Normalised coordinates x / z of the viewing rays.

        Returns
        -------
        ndarray, shape (N, 2)
            Mirror points S (x, z), mm.
        """
        return self.distances(u)[:, None] * viewing_rays(u)[0]  # type: ignore[attr-defined]

    def scene_rays(self, u: ArrayLike) -> NDArray[np.float64]:
        """Return unit directions from the mirror into the scene.

        Parameters
        ----------
        u : array_like, shape (N,)
            Normalised coordinates x / z of the viewing rays.

        Returns
        -------
        ndarray, shape (N, 2)
            Directions (x, z) of unit length.
        """
        return reflected(viewing_rays(u)[0], self.tangents(u))  # type: ignore[attr-defined]


@dataclass(frozen=True)
class DistanceCurve(_Curve):
    """Describe a bent mirror by distances along the viewing rays, a cubic of the image.

    Everything lies in the plane at right angles to the clamp line. The origin is the
    centre of the camera that views the mirror; rows are (x, z), mm.

    Parameters
    ----------
    coefficients : ndarray, shape (4,)
        Coefficients of 1, s, s^2, s^3, mm, with s = -1 at the clamp and +1 at the free
        edge.
    span : tuple of float
        Normalised coordinate u = x / z of the clamp and of the free edge.

    References
    ----------
    Thesis (5.3); E-5.01 for the two interpretations of the reduced model.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import DistanceCurve
    >>> curve = DistanceCurve(np.array([520.0, 90.0, 30.0, -4.0]), (-0.4, 0.4))
    >>> curve.distances([-0.4, 0.0, 0.4]).round(1)
    array([464., 520., 636.])
    >>> curve.points([0.0]).round(1)
    array([[  0., 520.]])
    """

    coefficients: np.ndarray
    span: tuple[float, float]

    def distances(self, u: ArrayLike) -> NDArray[np.float64]:
        """Return the distances D (N,) from the camera along rays u (N,), mm."""
        return self._rows(u)[0] @ self.coefficients

    def tangents(self, u: ArrayLike) -> NDArray[np.float64]:
        """Return the derivatives dS/du (N, 2) at rays u (N,), not of unit length."""
        b, b_u = self._rows(u)
        V, V_u = viewing_rays(u)
        D, D_u = b @ self.coefficients, b_u @ self.coefficients
        return D[:, None] * V_u + D_u[:, None] * V

    def fraction(self, u: ArrayLike) -> NDArray[np.float64]:
        """Return the share (N,) of the way from clamp to free edge, in the image."""
        return (np.asarray(u, float) - self.span[0]) / (self.span[1] - self.span[0])

    def changes(self, u: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the derivatives by the coefficients of distance and tangent angle.

        Parameters
        ----------
        u : array_like, shape (N,)
            Normalised coordinates of the viewing rays.

        Returns
        -------
        by_distance : ndarray, shape (N, 4)
            Changes of the distance D, mm / mm.
        by_angle : ndarray, shape (N, 4)
            Changes of the tangent's angle, rad / mm.
        """
        b, b_u = self._rows(u)
        V, V_u = viewing_rays(u)
        S_u = self.tangents(u)
        turn = cross(S_u, V)[:, None] * b_u + cross(S_u, V_u)[:, None] * b
        return b, turn / dot(S_u, S_u)[:, None]

    def slope_equations(
        self, u: ArrayLike, normals: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return equations for tangents at right angles to normals.

        (dV_l/du . N) D + (V_l . N) dD/du = 0 is linear in the coefficients of D.

        Parameters
        ----------
        u : array_like, shape (N,)
            Normalised coordinates of the viewing rays.
        normals : ndarray, shape (N, 2)
            Normals of the mirror (x, z).

        Returns
        -------
        rows : ndarray, shape (N, 4)
            Rows for the coefficients.
        sides : ndarray, shape (N,)
            Right sides, zero.

        References
        ----------
        Thesis (5.15).
        """
        b, b_u = self._rows(u)
        V, V_u = viewing_rays(u)
        rows = dot(V_u, normals)[:, None] * b + dot(V, normals)[:, None] * b_u
        return rows, np.zeros(len(rows))

    def clamp_equation(
        self, clamp: tuple[float, float]
    ) -> tuple[NDArray[np.float64], float]:
        """Return the equation of the known distance at the clamped edge.

        Parameters
        ----------
        clamp : tuple of float
            Normalised coordinate u of the clamp, and its distance along that ray, mm.

        Returns
        -------
        row : ndarray, shape (4,)
            Row for the coefficients.
        side : float
            Right side, mm.

        References
        ----------
        Thesis (5.20).
        """
        u, distance = clamp
        return self._rows([u])[0][0], distance

    def _rows(self, u):
        """Powers of s (N, 4), and their derivatives by u (N, 4)."""
        rate = 2 / (self.span[1] - self.span[0])
        b, b_s, _ = _powers(2 * self.fraction(u) - 1)
        return b, rate * b_s


@dataclass(frozen=True)
class HeightCurve(_Curve):
    """Describe a bent mirror by its height over the line of the clamped mirror.

    The height is a cubic of the length along the line, as in the beam's formula. Frame
    and rows (x, z) are those of `DistanceCurve`.

    Parameters
    ----------
    coefficients : ndarray, shape (4,)
        Coefficients of 1, s, s^2, s^3, mm, with s = length along the line / `length`.
    foot : ndarray, shape (2,)
        Point (x, z) where the line starts, mm.
    direction : ndarray, shape (2,)
        Unit vector along the line. Heights count across it, rotated by 90 degrees.
    length : float
        Length of the line to the free edge, mm.

    References
    ----------
    Thesis (5.1); E-5.01 for the two interpretations of the reduced model.
    """

    coefficients: np.ndarray
    foot: np.ndarray
    direction: np.ndarray
    length: float

    def distances(self, u: ArrayLike) -> NDArray[np.float64]:
        """Return the distances of the mirror from the camera, by Newton's steps.

        Parameters
        ----------
        u : array_like, shape (N,)
            Normalised coordinates of the viewing rays.

        Returns
        -------
        ndarray, shape (N,)
            Distances D along the rays, mm.

        Raises
        ------
        CalibrationError
            ``ray-misses-mirror``: a viewing ray does not meet the curve.
        """
        V = viewing_rays(u)[0]
        along, across = V @ self.direction, V @ self._upright
        foot = self.foot @ self.direction, self.foot @ self._upright
        with np.errstate(divide="ignore", invalid="ignore"):
            D = foot[1] / across
            for _ in range(MAX_N_NEWTON_STEPS):
                height, slope = self._height(D * along - foot[0])
                step = (D * across - foot[1] - height) / (across - slope * along)
                D = D - step
                if np.all(np.abs(step) <= 1e-12 * np.abs(D)):
                    return D
        raise CalibrationError(
            "reduced mirror: a viewing ray does not meet the curve; check the clamp "
            "line and the order of the images",
            code="ray-misses-mirror",
        )

    def tangents(self, u: ArrayLike) -> NDArray[np.float64]:
        """Return the tangents (N, 2) at rays u (N,), of length 1 along the line."""
        _, slope = self._height(self._lengths(u))
        return self.direction + slope[:, None] * self._upright

    def fraction(self, u: ArrayLike) -> NDArray[np.float64]:
        """Return the share (N,) of the way from clamp to free edge, along the line."""
        return self._lengths(u) / self.length

    def changes(self, u: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the derivatives by the coefficients of distance and tangent angle.

        The point slides on its viewing ray until its height fulfils the cubic again.

        Parameters
        ----------
        u : array_like, shape (N,)
            Normalised coordinates of the viewing rays.

        Returns
        -------
        by_distance : ndarray, shape (N, 4)
            Changes of the distance D, mm / mm.
        by_angle : ndarray, shape (N, 4)
            Changes of the tangent's angle, rad / mm.
        """
        x = self._lengths(u)
        b, b_x, b_xx = self._rows(x)
        V = viewing_rays(u)[0]
        slope = b_x @ self.coefficients
        along, across = V @ self.direction, V @ self._upright
        slide = b / (across - slope * along)[:, None]
        bend = (b_xx @ self.coefficients) * along
        return slide, (b_x + bend[:, None] * slide) / (1 + slope**2)[:, None]

    def slope_equations(
        self, u: ArrayLike, normals: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return equations for tangents at right angles to normals.

        The slope is linear in the coefficients at the positions of the features. These
        are taken to be where their rays meet this curve, the previous one.

        Parameters
        ----------
        u : array_like, shape (N,)
            Normalised coordinates of the viewing rays.
        normals : ndarray, shape (N, 2)
            Normals of the mirror (x, z).

        Returns
        -------
        rows : ndarray, shape (N, 4)
            Rows for the coefficients.
        sides : ndarray, shape (N,)
            Right sides.

        References
        ----------
        Thesis (5.9).
        """
        _, b_x, _ = self._rows(self._lengths(u))
        return (normals @ self._upright)[:, None] * b_x, -normals @ self.direction

    def clamp_equation(
        self, clamp: tuple[float, float]
    ) -> tuple[NDArray[np.float64], float]:
        """Return the equation of the known point's height at the clamp.

        Parameters
        ----------
        clamp : tuple of float
            Normalised coordinate u of the clamp, and its distance along that ray, mm.

        Returns
        -------
        row : ndarray, shape (4,)
            Row for the coefficients.
        side : float
            Right side, mm.
        """
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
        b, b_s, b_ss = _powers(x / self.length)
        return b, b_s / self.length, b_ss / self.length**2

    def _height(self, x):
        b, b_x, _ = self._rows(x)
        return b @ self.coefficients, b_x @ self.coefficients


def viewing_rays(u: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return unit viewing rays in the plane, and their derivatives.

    Parameters
    ----------
    u : array_like, shape (N,)
        Normalised coordinates x / z.

    Returns
    -------
    rays : ndarray, shape (N, 2)
        Unit directions V_l (x, z).
    derivatives : ndarray, shape (N, 2)
        Derivatives of the directions by u.

    References
    ----------
    Thesis (5.17).

    Examples
    --------
    >>> from raxel.calibration import viewing_rays
    >>> rays, derivatives = viewing_rays([0.0, 0.75])
    >>> rays.round(6)
    array([[0. , 1. ],
           [0.6, 0.8]])
    """
    return _viewing_rays(np.asarray(u, float))


@numba.njit(cache=True)
def _viewing_rays(u):
    V, V_u = np.empty((len(u), 2)), np.empty((len(u), 2))
    length = np.sqrt(1 + u * u)
    V[:, 0], V[:, 1] = u / length, 1 / length
    V_u[:, 0], V_u[:, 1] = 1 / length**3, -u / length**3
    return V, V_u


def reflected(
    directions: NDArray[np.float64], tangents: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Reflect directions in a plane curve with given tangents.

    The component along the tangent stays, the component across it changes its sign.

    Parameters
    ----------
    directions : ndarray, shape (N, 2)
        Directions (x, z) of the incoming rays.
    tangents : ndarray, shape (N, 2)
        Tangents (x, z) of any length.

    Returns
    -------
    ndarray, shape (N, 2)
        Directions of the reflected rays, as long as those given.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import reflected
    >>> reflected(np.array([[0.6, 0.8]]), np.array([[2.0, 0.0]])).round(6)
    array([[ 0.6, -0.8]])
    """
    along = tangents / np.sqrt(dot(tangents, tangents))[:, None]
    return 2 * dot(directions, along)[:, None] * along - directions


def dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the scalar products of rows.

    Parameters
    ----------
    a, b : ndarray, shape (N, K)
        Rows to multiply.

    Returns
    -------
    ndarray, shape (N,)
        Scalar product of each pair of rows.
    """
    return np.einsum("ij,ij->i", a, b)


def cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a_x b_z - a_z b_x (N,) of rows (N, 2).

    It is positive where b follows a in the rotation from x towards z.
    """
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


@numba.njit(cache=True)
def _powers(s):
    """1, s, s^2, s^3 (N, 4), and their first and second derivatives by s (N, 4)."""
    b, b_s, b_ss = np.ones((len(s), 4)), np.zeros((len(s), 4)), np.zeros((len(s), 4))
    b[:, 1], b[:, 2], b[:, 3] = s, s * s, s**3
    b_s[:, 1], b_s[:, 2], b_s[:, 3] = 1.0, 2 * s, 3 * s * s
    b_ss[:, 2], b_ss[:, 3] = 2.0, 6 * s
    return b, b_s, b_ss


MIN_N_FEATURES = 4
"""The clamp leaves three unknowns; one more feature makes a misfit detectable."""
MIN_REACH = 1 / 3
"""Fraction of the way from clamp to free edge that features must reach: extrapolation
of a cubic by more than a factor of three is unreliable."""
N_START_ANGLES = 120
"""Initial directions of a row of points, 3 degrees apart."""


class ReducedCalibration(NamedTuple):
    """Hold the result of a dynamic calibration of the reduced model.

    Attributes
    ----------
    curve : DistanceCurve or HeightCurve
        The refined curve.
    linear : DistanceCurve or HeightCurve
        The curve of the linear stage.
    costs : ndarray
        Sum of squared residuals at the start and after each step, mm^2.
    residuals : ndarray, shape (N,)
        Offsets of the features from their scene rays, mm.
    covariance : ndarray, shape (4, 4)
        Covariance of the coefficients from the scatter of the residuals, mm^2.
    reach : float
        Share of the way from clamp to free edge at the outermost feature. Beyond it the
        curve is extrapolated.
    converged : bool
        Whether the refinement converged.
    """

    curve: DistanceCurve | HeightCurve
    linear: DistanceCurve | HeightCurve
    costs: np.ndarray
    residuals: np.ndarray
    covariance: np.ndarray
    reach: float
    converged: bool

    def deviation(self, u: ArrayLike) -> NDArray[np.float64]:
        """Return the predicted standard deviation (N,), mm, of distances at u (N,)."""
        slide, _ = self.curve.changes(u)
        return np.sqrt(np.einsum("ij,jk,ik->i", slide, self.covariance, slide))


def calibrate_reduced(
    before: DistanceCurve | HeightCurve,
    u: ArrayLike,
    scene_rays: ArrayLike,
    points: ArrayLike,
    clamp: tuple[float, float],
) -> ReducedCalibration:
    """Calibrate the curve of a bent mirror from one grid, seen before and after.

    The linear stage is followed by a refinement of the ray-point distances. Both keep
    the clamp.

    Parameters
    ----------
    before : DistanceCurve or HeightCurve
        The curve before bending, with the span or length of the mirror after it. Of a
        `DistanceCurve` the span alone is used.
    u : array_like, shape (N,)
        Features after bending, as normalised coordinates.
    scene_rays : array_like, shape (N, 2)
        Directions in which the same features were seen before. In the linear stage they
        replace those after bending (5.28).
    points : array_like, shape (N, 2)
        Positions (x, z) of the features, mm.
    clamp : tuple of float
        Normalised coordinate u of the clamped edge, and its distance along that ray,
        mm.

    Returns
    -------
    ReducedCalibration
        Refined and linear curve with residuals and covariance.

    Raises
    ------
    CalibrationError
        ``not-finite``: a value is not finite. ``too-few-features``: fewer than four
        different features. ``outside-mirror``: features outside the mirror.
        ``short-reach``: no feature beyond a third of the mirror. ``open-coefficients``:
        too few different positions. ``behind-camera``: the curve reaches the camera.
        ``no-reflection``, ``ray-misses-mirror``: see `linear_reduced`, `HeightCurve`.

    References
    ----------
    Thesis 5.2.2.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import DistanceCurve, calibrate_reduced
    >>> before = DistanceCurve(np.array([520.0, 90.0, 24.0, -3.2]), (-0.4, 0.4))
    >>> bent = DistanceCurve(np.array([520.0, 90.0, 30.0, -4.0]), (-0.4, 0.4))
    >>> u = np.linspace(-0.35, 0.33, 12)
    >>> points = bent.points(u) + 1500.0 * bent.scene_rays(u)
    >>> clamp = -0.4, float(bent.distances([-0.4])[0])
    >>> found = calibrate_reduced(before, u, before.scene_rays(u), points, clamp)
    >>> bool(np.allclose(found.curve.coefficients, bent.coefficients, atol=1e-3))
    True
    """
    u, scene_rays, points = (np.asarray(v, float) for v in (u, scene_rays, points))
    for given in (u, scene_rays, points, clamp):
        if not np.all(np.isfinite(given)):
            raise CalibrationError(
                "reduced mirror: values must be finite; remove NaN and infinity",
                code="not-finite",
            )
    if len(np.unique(u)) < MIN_N_FEATURES:
        raise CalibrationError(
            f"reduced mirror: found {len(np.unique(u))} features in both images; give "
            f"{MIN_N_FEATURES} or more, spread from clamp to free edge",
            code="too-few-features",
        )
    linear = linear_reduced(before, u, scene_rays, clamp)
    return refine_reduced(linear, u, points, clamp)


def linear_reduced(
    before: DistanceCurve | HeightCurve,
    u: ArrayLike,
    scene_rays: NDArray[np.float64],
    clamp: tuple[float, float],
) -> DistanceCurve | HeightCurve:
    """Estimate the curve from viewing and scene rays alone, linearly.

    The normal bisects the angle between the rays, N ~ V_l - V_r. The tangent is at
    right angles to it, which gives one equation for each feature. The clamp gives the
    scale.

    Parameters
    ----------
    before : DistanceCurve or HeightCurve
        The curve before bending.
    u : array_like, shape (N,)
        Features after bending, as normalised coordinates.
    scene_rays : ndarray, shape (N, 2)
        Unit directions from the mirror into the scene.
    clamp : tuple of float
        Normalised coordinate u of the clamped edge, and its distance along that ray,
        mm.

    Returns
    -------
    DistanceCurve or HeightCurve
        A curve of the class of `before`.

    Raises
    ------
    CalibrationError
        ``no-reflection``: a scene ray continues its viewing ray.

    References
    ----------
    Thesis (5.8), (5.9), (5.19) to (5.22). Halstead et al. 1996,
    doi:10.1145/237170.237272.
    """
    across = viewing_rays(u)[0] - scene_rays
    length = np.linalg.norm(across, axis=1, keepdims=True)
    if np.any(length < 1e-9):
        raise CalibrationError(
            "reduced mirror: a scene ray is parallel to its viewing ray (no "
            "reflection); give directions from the mirror into the scene",
            code="no-reflection",
        )
    rows, sides = before.slope_equations(u, across / length)
    particular, basis = _kept_clamp(before, clamp)
    free = np.linalg.lstsq(rows @ basis, sides - rows @ particular, rcond=None)[0]
    return before.replaced(particular + basis @ free)


def refine_reduced(
    start: DistanceCurve | HeightCurve,
    u: ArrayLike,
    points: NDArray[np.float64],
    clamp: tuple[float, float],
) -> ReducedCalibration:
    """Refine a curve by least ray-point distances.

    Parameters
    ----------
    start : DistanceCurve or HeightCurve
        Initial curve.
    u : array_like, shape (N,)
        Features after bending, as normalised coordinates.
    points : ndarray, shape (N, 2)
        Positions (x, z) of the features, mm.
    clamp : tuple of float
        Normalised coordinate u of the clamped edge, and its distance along that ray,
        mm.

    Returns
    -------
    ReducedCalibration
        The refined curve; its `linear` is `start`.

    Raises
    ------
    CalibrationError
        ``behind-camera``, ``outside-mirror``, ``short-reach`` or ``open-coefficients``,
        as `calibrate_reduced`.

    References
    ----------
    Thesis (5.29).
    """
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


def ray_point_offsets(
    curve: DistanceCurve | HeightCurve, u: ArrayLike, points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the offsets of points from their scene rays, and their Jacobian.

    In a plane the vector of (5.29) is perpendicular to the ray. The offset is its
    length with a sign, e = V_r x (P - S). The scene ray turns twice as fast as the
    tangent, so that de = -2 (V_r . (P - S)) d(angle) - (V_r x V_l) dD.

    Parameters
    ----------
    curve : DistanceCurve or HeightCurve
        The mirror.
    u : array_like, shape (N,)
        Features, as normalised coordinates.
    points : ndarray, shape (N, 2)
        Positions (x, z) of the features, mm.

    Returns
    -------
    offsets : ndarray, shape (N,)
        Signed distances, mm.
    jacobian : ndarray, shape (N, 4)
        Derivatives by the coefficients.

    References
    ----------
    Thesis (5.29).
    """
    V = viewing_rays(u)[0]
    V_r = reflected(V, curve.tangents(u))
    q = points - curve.points(u)
    slide, turn = curve.changes(u)
    J = -2 * dot(V_r, q)[:, None] * turn - cross(V_r, V)[:, None] * slide
    return cross(V_r, q), J


def place_row(
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    places: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Estimate the pose of a straight row of points from a ray to each of them.

    This is the pose of a grid in the plane; non-central rays are permitted. For a given
    direction the foot follows linearly, so that one angle remains to be searched. All
    angles are tried, and the best is refined together with the foot.

    Parameters
    ----------
    origins, directions : ndarray, shape (N, 2)
        The rays (x, z); origins in mm, directions of unit length.
    places : ndarray, shape (N,)
        Positions of the points along the row, mm.

    Returns
    -------
    foot : ndarray, shape (2,)
        Position of the row's origin, mm.
    way : ndarray, shape (2,)
        Unit direction of the row. The points are foot + places way. They have the least
        sum of squared distances from their rays, in front of them.

    Raises
    ------
    CalibrationError
        ``too-few-features``: fewer than three points. ``parallel-rays``: parallel rays.
        ``behind-camera``: no row lies in front of all its rays.

    References
    ----------
    Thesis (2.26).
    """
    if len(places) < 3:
        raise CalibrationError(
            f"row of points: found {len(places)} points; give 3 or more",
            code="too-few-features",
        )
    across = np.column_stack([-directions[:, 1], directions[:, 0]])
    start = _first_row(origins, directions, across, places)

    def evaluate(row):
        foot, direction = row[:2], np.array([np.cos(row[2]), np.sin(row[2])])
        residuals = dot(across, foot + places[:, None] * direction - origins)
        turned = across @ np.array([-direction[1], direction[0]])
        return gauss_newton(
            residuals, lambda: np.column_stack([across, places * turned])
        )

    tiny = 1e-26 * np.sum(places**2)
    row, *_ = descend(
        evaluate, np.add, start, iterations=50, tolerance=1e-14, rounding=tiny
    )
    return row[:2], np.array([np.cos(row[2]), np.sin(row[2])])


def _first_row(origins, directions, across, places):
    """Foot and angle (3,) of the best initial row in front of its rays."""
    angles = np.linspace(0, 2 * np.pi, N_START_ANGLES, endpoint=False)
    axes_tried = np.stack([np.cos(angles), np.sin(angles)])
    sides = dot(across, origins)[:, None] - places[:, None] * (across @ axes_tried)
    Q, R = np.linalg.qr(across)
    if abs(R[1, 1]) < 1e-9 * abs(R[0, 0]):
        raise CalibrationError(
            "row of points: the rays are parallel and do not determine its distance; "
            "spread the features",
            code="parallel-rays",
        )
    feet = np.linalg.solve(R, Q.T @ sides)
    costs = np.sum((sides - across @ feet) ** 2, axis=0)
    for best in np.argsort(costs):
        points = feet[:, best] + places[:, None] * axes_tried[:, best]
        if np.all(dot(points - origins, directions) > 0):
            return np.array([*feet[:, best], angles[best]])
    raise CalibrationError(
        "row of points: no row is in front of all its rays; check that rays point into "
        "the scene and that points are in their order",
        code="behind-camera",
    )


def _kept_clamp(curve, clamp):
    """Coefficients of one curve through the clamp (4,), and of all others (4, 3).

    The clamp is one equation; the free changes are its null space (5.21).
    """
    row, side = curve.clamp_equation(clamp)
    directions = np.linalg.svd(row[None])[2]
    return row * side / (row @ row), directions[1:].T


def _reach(curve, u):
    """Fraction of the way to the free edge that features reach; rejects bad support."""
    least = curve.distances(u).min()
    if not least > 0:
        raise CalibrationError(
            f"reduced mirror: the curve comes within {least:.3g} mm of the camera; "
            "check the clamp's distance and the order of the images",
            code="behind-camera",
        )
    fraction = curve.fraction(u)
    outside = np.count_nonzero((fraction < -1e-9) | (fraction > 1 + 1e-9))
    if outside:
        raise CalibrationError(
            f"reduced mirror: {outside} of {len(u)} features are outside the mirror, "
            f"at {fraction.min():.3g} to {fraction.max():.3g} of its length; check "
            "the edges and the order of the images",
            code="outside-mirror",
        )
    if fraction.max() < MIN_REACH:
        raise CalibrationError(
            f"reduced mirror: features reach {fraction.max():.0%} of the way from "
            f"clamp to free edge; give some beyond {MIN_REACH:.0%}",
            code="short-reach",
        )
    return float(fraction.max())


def _covariance(residuals, J):
    """(P, P) of the free unknowns, from the scatter of the residuals."""
    scale = np.linalg.norm(J, axis=0)
    lengths = np.linalg.svd(J / scale, compute_uv=False)
    if lengths[-1] < 1e-9 * lengths[0]:
        raise CalibrationError(
            "reduced mirror: features are at too few different positions; spread them "
            "between clamp and free edge",
            code="open-coefficients",
        )
    variance = residuals @ residuals / (len(residuals) - J.shape[1])
    return variance * np.linalg.inv(J.T @ J)
