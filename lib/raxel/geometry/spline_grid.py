"""Tensor-product B-splines over the picture: basis rows, derivatives, knots (5.4-5.7).

A coefficient c_ij belongs to f_i(u) g_j(v) and has the index i + Kf * j, as the vec()
of (5.15) stacks columns. (u, v) are the points given, turned by an angle so that u can
run at right angles to a clamped edge that is not upright in the picture.
Source: Cox 1972, doi:10.1093/imamat/10.2.134; de Boor 1972,
doi:10.1016/0021-9045(72)90080-9.
"""

from functools import cached_property

import numpy as np

from raxel.errors import InputError

# Of the box's size: a point this near outside it is on its edge but for rounding.
ON_EDGE = 1e-9
MOST_COEFFICIENTS, HIGHEST_DEGREE = 200, 7


class SplineGrid:
    """Basis functions over a box of the (u, v) plane, which end at its border.

    knots_u, knots_v: non-decreasing, each end repeated degree + 1 times (open), in the
    unit of the points; degree: (along u, along v), each at least 1; angle: of the u
    axis from the x axis of the points towards y, radians.
    Raises InputError naming the field.
    """

    def __init__(self, knots_u, knots_v, degree=(2, 2), angle=0.0):
        self.degree = _checked_degree(degree)
        self.knots_u = _checked_knots("knots_u", knots_u, self.degree[0])
        self.knots_v = _checked_knots("knots_v", knots_v, self.degree[1])
        if np.ndim(angle) != 0 or not np.isfinite(angle):
            raise InputError(f"field 'angle': found {angle}; give one finite angle")
        self.angle = float(angle)
        self._axes = _axes(self.angle)

    @property
    def shape(self):
        """(Kf, Kg): numbers of basis functions along u and v."""
        return tuple(
            len(knots) - degree - 1
            for knots, degree in zip(self._knots, self.degree, strict=True)
        )

    @property
    def size(self):
        """Kf * Kg, the number of coefficients."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def breaks(self):
        """The knots without repetition, along u and along v."""
        return tuple(np.unique(knots) for knots in self._knots)

    @property
    def corners(self):
        """The box's four corners (4, 2), in the frame of the points, going round."""
        u, v = ((knots[0], knots[-1]) for knots in self._knots)
        box = np.array([[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]])
        return self.unturned(box)

    def turned(self, points):
        """(u, v) (N, 2) of points (N, 2)."""
        return np.asarray(points, float) @ self._axes.T

    def unturned(self, uv):
        """Points (N, 2) at (u, v) (N, 2)."""
        return np.asarray(uv, float) @ self._axes

    def inside(self, points):
        """Which of the points (N, 2) lie in the box, (N,) bool."""
        return self._inside(self.turned(points))

    def intervals(self, points):
        """Knot interval of points (N, 2) along u and along v, (N, 2), -1 outside."""
        uv = self.turned(points)
        found = [
            np.clip(np.searchsorted(b, x, "right") - 1, 0, len(b) - 2)
            for b, x in zip(self.breaks, uv.T, strict=True)
        ]
        return np.where(self._inside(uv)[:, None], np.column_stack(found), -1)

    def rows(self, points):
        """Basis functions at points (N, 2), and their derivatives by x and by y.

        Three arrays (N, Kf * Kg); NaN in rows of points outside the box, since a
        spline continued beyond its knots says nothing.
        """
        (f, f_u), (g, g_v) = self._bases(points, 1)
        return (_products(f, g), *self._gradient(_products(f_u, g), _products(f, g_v)))

    def second_rows(self, points):
        """Second derivatives by x, x; x, y; y, y of the basis functions, as `rows`."""
        (f, f_u, f_uu), (g, g_v, g_vv) = self._bases(points, 2)
        uu, uv, vv = _products(f_uu, g), _products(f_u, g_v), _products(f, g_vv)
        u_x, u_y = self._gradient(uu, uv)
        v_x, v_y = self._gradient(uv, vv)
        xx, xy = self._gradient(u_x, v_x)
        return xx, xy, self._gradient(u_y, v_y)[1]

    def _gradient(self, by_u, by_v):
        axes = self._axes
        return tuple(axes[0, i] * by_u + axes[1, i] * by_v for i in range(2))

    @property
    def _knots(self):
        return self.knots_u, self.knots_v

    def _inside(self, uv):
        low, high = np.array([(knots[0], knots[-1]) for knots in self._knots]).T
        slack = ON_EDGE * (high - low)
        with np.errstate(invalid="ignore"):
            return np.all((uv >= low - slack) & (uv <= high + slack), axis=1)

    def _bases(self, points, order):
        uv = self.turned(points)
        uv = np.where(self._inside(uv)[:, None], uv, np.nan)
        return [
            basis(knots, degree, x, order)
            for knots, degree, x in zip(self._knots, self.degree, uv.T, strict=True)
        ]


def spline_grid(points, shape=(7, 3), degree=(2, 2), angle=0.0):
    """The SplineGrid of (Kf, Kg) functions on open uniform knots that spans points.

    points: (N, 2), of which rows that are not finite do not count; degree, angle: see
    SplineGrid. Raises InputError for too few functions for the degree, or points that
    span no box.
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
    return SplineGrid(*knots, degree, angle)


def open_knots(low, high, count, degree):
    """Open uniform knots of `count` basis functions of a degree on [low, high]."""
    if not count > degree:
        raise InputError(
            f"spline: {count} basis functions of degree {degree}; give {degree + 1} "
            "or more, or a lower degree"
        )
    if not high > low:
        raise InputError(
            f"spline: the points span [{low:g}, {high:g}]; give points that spread"
        )
    inner = np.linspace(low, high, count - degree + 1)
    return np.concatenate([np.full(degree, low), inner, np.full(degree, high)])


def basis(knots, degree, x, order=0):
    """Values and derivatives up to `order` of all B-splines of a degree at x (N,).

    knots: open. A list of arrays (N, K); rows of an x that is NaN are NaN. An x outside
    the knots takes the polynomials of the nearest interval.
    """
    unknown = np.isnan(x)
    last = len(knots) - degree - 2
    interval = np.clip(np.searchsorted(knots, x, "right") - 1, degree, last)
    found = np.zeros((len(x), len(knots) - 1))
    found[np.arange(len(x)), interval] = np.where(unknown, np.nan, 1.0)
    found[unknown] = np.nan
    by_degree = [found]
    for p in range(1, degree + 1):
        rise = (x[:, None] - knots[:-p]) * _inverse_spans(knots, p)
        found = rise[:, :-1] * found[:, :-1] + (1 - rise[:, 1:]) * found[:, 1:]
        by_degree.append(found)
    return [
        _differentiated(by_degree, knots, degree, times) for times in range(order + 1)
    ]


def _differentiated(by_degree, knots, degree, times):
    """B'_ik = k (B_i,k-1 / (t_i+k - t_i) - B_i+1,k-1 / (t_i+k+1 - t_i+1)), repeated."""
    if times > degree:
        return np.zeros_like(by_degree[degree])
    found = by_degree[degree - times]
    for p in range(degree - times + 1, degree + 1):
        scaled = p * _inverse_spans(knots, p) * found
        found = scaled[:, :-1] - scaled[:, 1:]
    return found


def _inverse_spans(knots, p):
    """One over t_i+p - t_i, and 0 where knots coincide: no spline lives there."""
    span = knots[p:] - knots[:-p]
    return np.where(span > 0, 1 / np.where(span > 0, span, 1.0), 0.0)


def _products(f, g):
    """f_i g_j at i + Kf * j: (N, Kf), (N, Kg) -> (N, Kf * Kg)."""
    return (g[:, :, None] * f[:, None, :]).reshape(len(f), f.shape[1] * g.shape[1])


def _axes(angle):
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, sine], [-sine, cosine]])


def _checked_degree(degree):
    found = np.array(degree)
    whole = found.shape == (2,) and np.all(found == np.round(found))
    if not (whole and np.all((found >= 1) & (found <= HIGHEST_DEGREE))):
        raise InputError(
            f"field 'degree': found {degree}; give two whole numbers, 1 to "
            f"{HIGHEST_DEGREE}"
        )
    return tuple(int(k) for k in found)


def _checked_knots(name, knots, degree):
    knots = np.array(knots, float)
    if knots.ndim != 1 or not 2 * degree + 2 <= len(knots) <= MOST_COEFFICIENTS:
        raise InputError(
            f"field '{name}': shape {knots.shape} found; give {2 * degree + 2} to "
            f"{MOST_COEFFICIENTS} knots in a row for degree {degree}"
        )
    inner = knots[degree : len(knots) - degree]
    ends = np.concatenate([knots[: degree + 1] - inner[0], knots[-degree - 1 :]])
    ends[degree + 1 :] -= inner[-1]
    if not (np.isfinite(knots).all() and np.all(np.diff(inner) > 0) and not ends.any()):
        raise InputError(
            f"field '{name}': found {knots.tolist()}; give finite knots that rise, "
            f"with each end {degree + 1} times"
        )
    knots.flags.writeable = False
    return knots
