"""Tensor-product B-splines over an image: basis rows, derivatives, knots (5.4-5.7).

A coefficient c_ij belongs to f_i(u) g_j(v) and has the index i + Kf * j, as the vec()
of (5.15) stacks columns. (u, v) are the given points, rotated by an angle so that u can
be perpendicular to a clamped edge that is not upright in the image.
Source: Cox 1972, doi:10.1093/imamat/10.2.134; de Boor 1972,
doi:10.1016/0021-9045(72)90080-9.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError

# Over the box's size: a point this close outside is on its edge within rounding.
EDGE_TOL = 1e-9
MAX_N_COEFFICIENTS, MAX_DEGREE = 200, 7


class SplineGrid:
    """Basis functions over a box of the (u, v) plane, which end at its border.

    Parameters
    ----------
    knots_u, knots_v : array_like
        Non-decreasing knots, each end repeated degree + 1 times (open), in the unit of
        the points.
    degree : sequence of int
        Degrees along u and v, each at least 1.
    angle : float
        Angle of the u axis from the x axis of the points towards y, rad.

    Raises
    ------
    InputError
        A field is not valid; the message names the field.
    """

    def __init__(
        self,
        knots_u: ArrayLike,
        knots_v: ArrayLike,
        degree: Sequence[int] = (2, 2),
        angle: float = 0.0,
    ) -> None:
        self.degree = _checked_degree(degree)
        self.knots_u = _checked_knots("knots_u", knots_u, self.degree[0])
        self.knots_v = _checked_knots("knots_v", knots_v, self.degree[1])
        if np.ndim(angle) != 0 or not np.isfinite(angle):
            raise InputError(f"field 'angle': found {angle}; give one finite angle")
        self.angle = float(angle)
        self._axes = _axes(self.angle)

    @property
    def shape(self) -> tuple[int, ...]:
        """(Kf, Kg): numbers of basis functions along u and v."""
        return tuple(
            len(knots) - degree - 1
            for knots, degree in zip(self._knots, self.degree, strict=True)
        )

    @property
    def size(self) -> int:
        """Kf * Kg, the number of coefficients."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def breaks(self) -> tuple[NDArray[np.float64], ...]:
        """The knots without repetition, along u and along v."""
        return tuple(np.unique(knots) for knots in self._knots)

    @property
    def corners(self) -> NDArray[np.float64]:
        """The box's four corners (4, 2), in the frame of the points, going round."""
        u, v = ((knots[0], knots[-1]) for knots in self._knots)
        box = np.array([[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]])
        return self.unturned(box)

    def turned(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return (u, v) `(N, 2)` of points `(N, 2)`."""
        return np.asarray(points, float) @ self._axes.T

    def unturned(self, uv: ArrayLike) -> NDArray[np.float64]:
        """Return points `(N, 2)` at (u, v) `(N, 2)`."""
        return np.asarray(uv, float) @ self._axes

    def inside(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return which of the points `(N, 2)` are in the box, `(N,)` bool."""
        return self._inside(self.turned(points))

    def intervals(self, points: ArrayLike) -> NDArray[np.intp]:
        """Return knot intervals `(N, 2)` of points `(N, 2)`, -1 outside."""
        uv = self.turned(points)
        found = [
            np.clip(np.searchsorted(b, x, "right") - 1, 0, len(b) - 2)
            for b, x in zip(self.breaks, uv.T, strict=True)
        ]
        return np.where(self._inside(uv)[:, None], np.column_stack(found), -1)

    def rows(
        self, points: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return the basis functions at points, and their derivatives by x and by y.

        Parameters
        ----------
        points : array_like, shape (N, 2)
            Points.

        Returns
        -------
        tuple of three ndarray, shape (N, Kf * Kg)
            NaN in rows of points outside the box: a spline is not extrapolated beyond
            its knots.
        """
        (f, f_u), (g, g_v) = self._bases(points, 1)
        return (_products(f, g), *self._gradient(_products(f_u, g), _products(f, g_v)))

    def values(self, points: ArrayLike, coefficients: ArrayLike) -> NDArray[np.float64]:
        """Return the spline's values at points, NaN outside the box.

        Parameters
        ----------
        points : array_like, shape (N, 2)
            Points.
        coefficients : array_like, shape (Kf * Kg,)
            Coefficients, index i + Kf * j.

        Returns
        -------
        ndarray, shape (N,)
            Values.
        """
        (f,), (g,) = self._bases(points, 0)
        C = np.reshape(coefficients, self.shape, order="F")
        return np.einsum("ni,ij,nj->n", f, C, g)

    def second_rows(
        self, points: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return second derivatives by xx, xy, yy of the basis, as `rows`."""
        (f, f_u, f_uu), (g, g_v, g_vv) = self._bases(points, 2)
        uu, uv, vv = _products(f_uu, g), _products(f_u, g_v), _products(f, g_vv)
        u_x, u_y = self._gradient(uu, uv)
        v_x, v_y = self._gradient(uv, vv)
        xx, xy = self._gradient(u_x, v_x)
        return xx, xy, self._gradient(u_y, v_y)[1]

    def _gradient(self, by_u, by_v):
        (c, s), (_, _) = self._axes
        return c * by_u - s * by_v, s * by_u + c * by_v

    @property
    def _knots(self):
        return self.knots_u, self.knots_v

    @cached_property
    def _box(self):
        """Lowest and highest (u, v), with a rounding tolerance."""
        low, high = np.array([(knots[0], knots[-1]) for knots in self._knots]).T
        slack = EDGE_TOL * (high - low)
        return low - slack, high + slack

    def _inside(self, uv):
        low, high = self._box
        with np.errstate(invalid="ignore"):
            return ((uv >= low) & (uv <= high)).all(axis=1)

    def _bases(self, points, order):
        uv = self.turned(points)
        uv = np.where(self._inside(uv)[:, None], uv, np.nan)
        return [
            basis(knots, degree, x, order)
            for knots, degree, x in zip(self._knots, self.degree, uv.T, strict=True)
        ]


def spline_grid(
    points: NDArray[np.float64],
    shape: Sequence[int] = (7, 3),
    degree: Sequence[int] = (2, 2),
    angle: float = 0.0,
) -> SplineGrid:
    """Return the SplineGrid on open uniform knots that spans points.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Points; rows that are not finite do not count.
    shape : sequence of int
        (Kf, Kg), numbers of basis functions along u and v.
    degree : sequence of int
        Degrees along u and v, see `SplineGrid`.
    angle : float
        Angle of the u axis from the x axis towards y, rad.

    Returns
    -------
    SplineGrid
        Basis functions over the bounding box of the points.

    Raises
    ------
    InputError
        Too few functions for the degree, or points that span no box.
    """
    degree = _checked_degree(degree)
    points = np.asarray(points, float)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        raise InputError("spline: no point is finite; give points that span a box")
    uv = points @ _axes(angle).T
    knots = [
        open_knots(low, high, count, k)
        for low, high, count, k in zip(uv.min(0), uv.max(0), shape, degree, strict=True)
    ]
    return SplineGrid(*knots, degree, angle)  # type: ignore[call-arg]


def open_knots(low, high, count, degree):
    """Open uniform knots of `count` basis functions of a degree on [low, high]."""
    if not count > degree:
        raise InputError(
            f"spline: found {count} basis functions of degree {degree}; give "
            f"{degree + 1} or more, or a lower degree"
        )
    if not high > low:
        raise InputError(
            f"spline: the points span [{low:g}, {high:g}]; give points with a spread"
        )
    inner = np.linspace(low, high, count - degree + 1)
    return np.concatenate([np.full(degree, low), inner, np.full(degree, high)])


def basis(knots, degree, x, order=0):
    """Values and derivatives up to `order` of all B-splines of a degree at x (N,).

    knots: open. Returns (order + 1, N, K); rows of an x that is NaN are NaN. An x
    outside the knots uses the polynomials of the nearest interval.
    """
    return _basis(knots, degree, np.ascontiguousarray(x, float), order)


@numba.njit(cache=True)
def _basis(knots, degree, x, order):
    count = len(knots) - degree - 1
    found = np.zeros((order + 1, len(x), count))
    local = np.empty(degree + 1)
    for n in range(len(x)):
        if np.isnan(x[n]):
            found[:, n] = np.nan
            continue
        # The interval [t_i, t_i+1) that contains x; the last one includes its end.
        i = degree
        while i < count - 1 and x[n] >= knots[i + 1]:
            i += 1
        for times in range(min(order, degree) + 1):
            local[0] = 1.0
            for p in range(1, degree + 1):
                _raise(local, knots, i, p, x[n], p > degree - times)
            found[times, n, i - degree : i + 1] = local
    return found


@numba.njit(cache=True)
def _raise(local, knots, i, p, x, derived):
    """From the p functions of degree p - 1 on [t_i, t_i+1) to the p + 1 of
    degree p, in place at the front of `local`.

    B_j,p = (x - t_j) a_j + (t_j+p+1 - x) a_j+1 with a_j = B_j,p-1 / (t_j+p - t_j);
    derived: their derivatives p (a_j - a_j+1), where `local` holds derivatives of one
    order less, or values.
    """
    carried = 0.0
    for r in range(p):
        j = i - p + 1 + r
        share = local[r] / (knots[j + p] - knots[j])
        if derived:
            local[r], carried = carried - p * share, p * share
        else:
            local[r] = carried + (knots[j + p] - x) * share
            carried = (x - knots[j]) * share
    local[p] = carried


@numba.njit(cache=True)
def _products(f, g):
    """f_i g_j at i + Kf * j: (N, Kf), (N, Kg) -> (N, Kf * Kg)."""
    found = np.empty((len(f), f.shape[1] * g.shape[1]))
    for n in range(len(f)):
        k = 0
        for j in range(g.shape[1]):
            for i in range(f.shape[1]):
                found[n, k] = f[n, i] * g[n, j]
                k += 1
    return found


def _axes(angle):
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, sine], [-sine, cosine]])


def _checked_degree(degree):
    found = np.array(degree)
    whole = found.shape == (2,) and np.all(found == np.round(found))
    if not (whole and np.all((found >= 1) & (found <= MAX_DEGREE))):
        raise InputError(
            f"field 'degree': found {degree}; give two whole numbers, 1 to {MAX_DEGREE}"
        )
    return tuple(int(k) for k in found)


def _checked_knots(name, knots, degree):
    knots = np.array(knots, float)
    if knots.ndim != 1 or not 2 * degree + 2 <= len(knots) <= MAX_N_COEFFICIENTS:
        raise InputError(
            f"field '{name}': found shape {knots.shape}; give {2 * degree + 2} to "
            f"{MAX_N_COEFFICIENTS} knots in a row for degree {degree}"
        )
    inner = knots[degree : len(knots) - degree]
    ends = np.concatenate([knots[: degree + 1] - inner[0], knots[-degree - 1 :]])
    ends[degree + 1 :] -= inner[-1]
    if not (np.isfinite(knots).all() and np.all(np.diff(inner) > 0) and not ends.any()):
        raise InputError(
            f"field '{name}': found {knots.tolist()}; give finite, increasing knots "
            f"with each end {degree + 1} times"
        )
    knots.flags.writeable = False
    return knots
