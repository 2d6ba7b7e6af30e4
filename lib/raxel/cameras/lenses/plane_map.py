"""Smooth maps of the plane on the largest disc where they do not fold."""

import abc
import math

import numpy as np

BLOCK = 1 << 15
# Squares of larger values overflow.
MAX_COORDINATE = 1e100
N_RINGS, N_SPOKES = 96, 64
N_SCAN_RADII = 400
# Largest radius of an unbounded map: 89.9 degrees from the axis of an image plane.
MAX_RADIUS = math.tan(math.radians(89.9))


class PlaneMap(abc.ABC):
    """A map of a disc about the origin into the plane, and its inverse.

    The disc ends where, along any of the scanned azimuths, the map's Jacobian
    determinant reaches zero: beyond that fold two points share an image. Other points
    of the disc with a zero determinant are rejected, too. The inverse is Newton's
    method with halved steps, from the nearest of a few thousand mapped points; it stays
    in the disc.
    """

    def __init__(self, radius, azimuths=120):
        """radius: upper limit of the disc; an infinite one is cut at MAX_RADIUS."""
        self.limit = self._first_fold(radius, azimuths)
        self._seeds = None

    @abc.abstractmethod
    def value(self, p):
        """Images (N, 2) of points (N, 2)."""

    @abc.abstractmethod
    def jacobian(self, p):
        """Derivatives (N, 2, 2) of the image at points (N, 2)."""

    def regular(self, p):
        """Where the map keeps its orientation (and is finite)."""
        with np.errstate(all="ignore"):
            return determinant(self.jacobian(p)) > 0

    def apply(self, p):
        """Images (N, 2) and which of them are valid (N,)."""
        with np.errstate(all="ignore"):
            q = self.value(p)
            valid = np.hypot(*p.T) <= self.limit
            valid &= np.isfinite(q).all(axis=1)
        valid[valid] = self.regular(p[valid])
        return np.where(valid[:, None], q, np.nan), valid

    def invert(self, q):
        """Points (N, 2) of the disc that map to `q`, and whether one exists (N,)."""
        p = np.full(q.shape, np.nan)
        for start in range(0, len(q), BLOCK):
            rows = slice(start, start + BLOCK)
            near = (np.abs(q[rows]) < MAX_COORDINATE).all(axis=1)
            p[rows][near] = self._search(q[rows][near])
        return p, np.isfinite(p[:, 0])

    def _first_fold(self, radius, azimuths):
        phi = np.linspace(0, 2 * math.pi, azimuths, endpoint=False)
        spoke = np.column_stack([np.cos(phi), np.sin(phi)])
        radius = min(float(radius), MAX_RADIUS)
        r = spread(radius, N_SCAN_RADII)
        grid = (r[:, None, None] * spoke).reshape(-1, 2)
        good = self.regular(grid).reshape(len(r), azimuths).all(axis=1)
        if good.all():
            return radius
        first = int(np.argmin(good))
        low, high = (r[first - 1], r[first]) if first else (0.0, 0.0)
        for _ in range(80):
            middle = (low + high) / 2
            if self.regular(middle * spoke).all():
                low = middle
            else:
                high = middle
        return float(low)

    def _polar_seeds(self):
        """Images of a polar grid, in a search tree, and the grid's points."""
        from scipy.spatial import cKDTree

        r = spread(self.limit, N_RINGS)
        phi = 2 * math.pi * np.arange(N_SPOKES) / N_SPOKES
        p = np.column_stack(
            [np.outer(r, np.cos(phi)).ravel(), np.outer(r, np.sin(phi)).ravel()]
        )
        q, valid = self.apply(p)
        scale = float(np.median(np.hypot(*q[valid].T)))
        return cKDTree(q[valid]), p[valid], scale

    def _search(self, q):
        if self._seeds is None:
            self._seeds = self._polar_seeds()
        tree, points, scale = self._seeds
        count = min(2, len(points))
        _, near = tree.query(q, k=count)
        near = near.reshape(len(q), count)
        p = np.full(q.shape, np.nan)
        left = np.arange(len(q))
        for attempt in range(count):
            if not len(left):
                break
            found, ok = self._newton(q[left], points[near[left, attempt]], scale)
            p[left[ok]] = found[ok]
            left = left[~ok]
        return p

    def _newton(self, q, p, scale):
        """Newton from p towards q: points, and which converged inside the disc."""
        miss = self.value(p) - q
        size = np.hypot(*miss.T)
        tolerance = 1e-11 * (scale + np.hypot(*q.T))
        todo = np.arange(len(q))
        for _ in range(60):
            if not len(todo):
                break
            J = self.jacobian(p[todo])
            with np.errstate(all="ignore"):
                step = solve(J, miss[todo])
            new, gap, better = self._shortened(
                q[todo], p[todo], step, size[todo], tolerance[todo]
            )
            moved = todo[better]
            p[moved], miss[moved] = new[better], gap[better]
            size[moved] = np.hypot(*gap[better].T)
            todo = moved[size[moved] > 0]
        return p, (size <= tolerance) & self.regular(p)

    def _shortened(self, q, p, step, size, enough):
        """Halve steps until they stay in the disc and approach q.

        Below `enough`, near rounding, only a whole step is tried.
        """
        new, gap = p.copy(), np.full_like(p, np.nan)
        better = np.zeros(len(p), bool)
        todo = np.flatnonzero(np.isfinite(step).all(axis=1))
        length = 1.0
        while len(todo) and length > 1e-4:
            trial = p[todo] - length * step[todo]
            with np.errstate(all="ignore"):
                miss = self.value(trial) - q[todo]
                good = np.hypot(*miss.T) < size[todo]
                good &= np.hypot(*trial.T) <= self.limit
            done = todo[good]
            new[done], gap[done], better[done] = trial[good], miss[good], True
            todo, length = todo[~good & (size[todo] > enough[todo])], length / 2
        return new, gap, better


def spread(radius, count):
    """Radii from 0 to `radius`: evenly spaced near 0, by equal factors far out."""
    return np.sinh(np.linspace(0, 1, count) * math.asinh(radius))


def determinant(J):
    """Determinants (N,) of matrices (N, 2, 2)."""
    return J[:, 0, 0] * J[:, 1, 1] - J[:, 0, 1] * J[:, 1, 0]


def solve(J, q):
    """J^-1 q for matrices (N, 2, 2) and vectors (N, 2)."""
    x = J[:, 1, 1] * q[:, 0] - J[:, 0, 1] * q[:, 1]
    y = J[:, 0, 0] * q[:, 1] - J[:, 1, 0] * q[:, 0]
    return np.column_stack([x, y]) / determinant(J)[:, None]
