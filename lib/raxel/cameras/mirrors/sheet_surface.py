"""Bent mirror sheet with a polynomial height: intersection, reflection, chart.

In the mirror's frame the flat sheet is in the plane z = 0 about the origin. Bent, it
is at
    z(x, y) = sum over i, j of h_ij (x / X)^i (y / Y)^j,
X and Y half its width and height; light comes from the side of negative z. Lengths
are mm.
"""

import numpy as np
from numpy.polynomial import polynomial

from raxel.cameras.core.base import checked_array, checked_positive
from raxel.cameras.mirrors.quadric import Reflection
from raxel.errors import InputError

# Newton steps from the flat sheet to the bent one, and relative tolerance, over half
# of the diagonal.
MAX_N_MEETING_STEPS, MEETING_TOL = 60, 1e-13
# Domain of a sheet's polynomial, over half of its sides.
MAX_EXTRAPOLATION = 1.5
EDGE_TOL = 1e-12
# Rays may meet steeper sheets more than once.
MAX_SLOPE = 1.0
GRID_SIZE = 33


class BentSheet:
    """A sheet at z(x, y) over the plane z = 0 in which it lies flat.

    Subclasses have `radius`, half the diagonal; `_middle`, x and y of the flat sheet's
    middle; `_domain`, least and greatest (x, y) of the surface; `height(x, y)`, the
    height and its derivatives by x, y, ...; and `carries`.
    """

    # With `inside` False the search for reflections starts as on a convex mirror; a
    # sheet may have both kinds of areas.
    inside = True
    chart_extent = 1.0  # |p| at the corners of the flat sheet

    def normals(self, points):
        """Normals (N, 3), not unit, towards the light."""
        _, by_x, by_y, *_ = self.height(points[:, 0], points[:, 1])
        return np.column_stack([by_x, by_y, -np.ones(len(points))])

    def reflect(self, origins, directions):
        """Intersect rays with the sheet and reflect them: exact to rounding.

        origins, directions: (N, 3), the latter unit. Not valid for rays from behind.
        The sheet is too flat for a second reflection except of a grazing ray, which is
        neglected.
        """
        points, met = self._meetings(origins, directions)
        with np.errstate(over="ignore", invalid="ignore"):
            n = self.normals(points)
            towards = np.sum(directions * n, axis=1)
            leaving = directions - (2 * towards / np.sum(n * n, axis=1))[:, None] * n
            leaving /= np.linalg.norm(leaving, axis=1, keepdims=True)
            valid = met & (towards < 0) & self.carries(points)
        keep = valid[:, None]
        return Reflection(
            np.where(keep, points, np.nan), np.where(keep, leaving, np.nan), valid
        )

    def _meetings(self, o, d):
        """(points (N, 3), met (N,)): Newton on the height of the ray over the sheet."""
        with np.errstate(all="ignore"):
            t = -o[:, 2] / d[:, 2]
            met = np.zeros(len(o), bool)
            for _ in range(MAX_N_MEETING_STEPS):
                places = o + t[:, None] * d
                x, y = np.clip(places[:, :2], *self._domain).T
                height, by_x, by_y, *_ = self.height(x, y)
                rate = d[:, 2] - by_x * d[:, 0] - by_y * d[:, 1]
                step = (height - places[:, 2]) / rate
                t = t + step
                met = np.abs(step) <= MEETING_TOL * np.maximum(self.radius, np.abs(t))
                if met[np.isfinite(t)].all():
                    break
            points = o + t[:, None] * d
            return points, met & (t > 0)

    def chart(self, points):
        """Chart coordinates p (N, 2) of places next to points (N, 3), see `point`."""
        return (points[:, :2] - self._middle) / self.radius


class SheetMirror(BentSheet):
    """size: (width, height), mm; heights: (n, m) coefficients h_ij, mm, i along x.

    Raises InputError naming the invalid field, also for a sheet that is steeper than 45
    degrees anywhere.
    """

    def __init__(self, size, heights):
        self.size = checked_positive("size", size, (2,))
        self.half = self.size / 2
        self.heights = checked_array("heights", heights, (None, None))
        self.radius = float(np.hypot(*self.half))
        self._middle, reach = np.zeros(2), MAX_EXTRAPOLATION * self.half
        self._domain = -reach, reach
        self._z = _derivatives(self.heights, self.half)
        self._check_slope()

    def _check_slope(self):
        x, y = np.meshgrid(*(np.linspace(-h, h, GRID_SIZE) for h in self.half))
        slope = np.hypot(self._value(1, 0, x, y), self._value(0, 1, x, y)).max()
        if slope > MAX_SLOPE:
            steep = np.degrees(np.arctan(slope))
            raise InputError(
                f"field 'heights': the sheet is up to {steep:.0f} degrees steep; give "
                "at most 45"
            )

    def _value(self, dx, dy, x, y):
        """A derivative of the height at x, y (any shape)."""
        x, y = x / self.half[0], y / self.half[1]
        return polynomial.polyval2d(x, y, self._z[dx, dy])

    def height(self, x, y):
        """Height (N,) at x, y (N,), then its derivatives by x and y."""
        return tuple(self._value(*by, x, y) for by in ((0, 0), (1, 0), (0, 1)))

    def carries(self, points):
        """Whether points (N, 3) of the surface are on the sheet."""
        with np.errstate(invalid="ignore"):
            return np.all(np.abs(points[:, :2]) <= self.half * (1 + EDGE_TOL), axis=1)

    def point(self, p):
        """Surface points (N, 3) of chart coordinates p (N, 2): x, y over half diagonal.

        Returns the points, their first derivatives (N, 3, 2) and second (N, 3, 2, 2).
        """
        x, y = self.radius * p.T
        points = np.column_stack([x, y, self._value(0, 0, x, y)])
        first = np.zeros((len(p), 3, 2))
        first[:, :2] = self.radius * np.eye(2)
        second = np.zeros((len(p), 3, 2, 2))
        for i in range(2):
            first[:, 2, i] = self.radius * self._value(*_orders(i), x, y)
            for j in range(2):
                bend = self._value(*_orders(i, j), x, y)
                second[:, 2, i, j] = self.radius**2 * bend
        return points, first, second


def _orders(*axes):
    return axes.count(0), axes.count(1)


def _derivatives(heights, half):
    """Coefficients of the derivatives by mm, of order (along x, along y) up to 2."""
    found = {}
    for dx in range(3):
        for dy in range(3 - dx):
            c = polynomial.polyder(heights, dx, axis=0) if dx else heights
            c = polynomial.polyder(c, dy, axis=1) if dy else c
            found[dx, dy] = c / half[0] ** dx / half[1] ** dy
    return found


# Unevenness of a low-cost mirror sheet in addition to its bending: waves, and strained
# edges. Both are heights over the bent sheet, so small that the additional length (the
# square of their slope) is neglected. They are multiplied by 1 - exp(-(x /
# CLAMP_TRANSITION_MM)^2): the clamp presses the sheet flat, so they vanish there with
# their slope.


# Distance from the clamp at which its effect ends.
CLAMP_TRANSITION_MM = 15.0
N_WAVES = 4
# Nodes for the RMS of the waves over the sheet.
N_NODES = (97, 65)


class Unevenness:
    """size: (length from the clamp, width), mm. Heights are mm along z.

    aberration: RMS of the waves over the sheet, mm, after the clamp's flattening;
    wavelengths: (least, greatest), mm: N_WAVES plane waves of equal height with lengths
    drawn evenly between them, in directions and phases drawn evenly, from `seed`. The
    waves are functions of x and y in the mirror's frame.
    strain: height of the three free edges, mm, falling off as exp(-distance / reach);
    beyond an edge, outside the sheet, as the first terms of that function's series.
    Raises InputError naming the field.
    """

    def __init__(self, size, aberration, wavelengths, seed, strain, reach):
        self.size = size
        self.aberration = float(checked_array("aberration", aberration, ()))
        self.wavelengths = checked_positive("wavelengths", wavelengths, (2,))
        self.strain = float(checked_array("strain", strain, ()))
        self.reach = float(checked_positive("strain_reach", reach))
        self.seed = _checked_seed(seed)
        if self.aberration < 0:
            raise InputError(
                f"field 'aberration': found {aberration}; give an RMS of 0 mm or more"
            )
        if self.wavelengths[0] > self.wavelengths[1]:
            raise InputError(
                f"field 'wavelengths': found {self.wavelengths.tolist()}; give the "
                "smallest first, then the largest"
            )
        rng = np.random.default_rng(self.seed)
        length = rng.uniform(*self.wavelengths, N_WAVES)
        angle = rng.uniform(0, 2 * np.pi, N_WAVES)
        self._phase = rng.uniform(0, 2 * np.pi, N_WAVES)
        self._wave = 2 * np.pi / length * np.stack([np.cos(angle), np.sin(angle)])
        self._height = 1.0
        self._height = self.aberration / self._rms()

    def _rms(self):
        share_x, share_y = (np.linspace(0, 1, n) for n in N_NODES)
        x, y = np.meshgrid(share_x * self.size[0], (share_y - 0.5) * self.size[1])
        waves = flattened(x.ravel(), self._waves(x.ravel(), y.ravel()))
        return np.sqrt(np.mean(waves[0] ** 2))

    @property
    def flat(self):
        """Whether there is no unevenness."""
        return not (self.aberration or self.strain)

    def at(self, x, y):
        """Height (N,) at x, y (N,), then its derivatives by x, y, xx, xy and yy."""
        height = np.zeros((6, len(x)))
        if self.aberration:
            height += self._waves(x, y)
        if self.strain:
            height += self._edges(x, y)
        return flattened(x, height)

    def _waves(self, x, y):
        k_x, k_y = self._wave
        angle = x[:, None] * k_x + y[:, None] * k_y + self._phase
        sine, cosine = self._height * np.sin(angle), self._height * np.cos(angle)
        return np.stack(
            [
                sine.sum(axis=1),
                *(cosine @ k_x, cosine @ k_y),
                *(-sine @ k_x**2, -sine @ (k_x * k_y), -sine @ k_y**2),
            ]
        )

    def _edges(self, x, y):
        length, half = self.size[0], self.size[1] / 2
        end = self._edge(length - x)
        low, high = self._edge(half + y), self._edge(half - y)
        zero = np.zeros(len(x))
        return np.stack(
            [
                end[0] + low[0] + high[0],
                *(-end[1], low[1] - high[1]),
                *(end[2], zero, low[2] + high[2]),
            ]
        )

    def _edge(self, distance):
        """Height of one edge at a distance (N,) mm from it, and its derivatives."""
        exponent = -distance / self.reach
        inner = np.exp(np.minimum(exponent, 0))
        over = np.maximum(exponent, 0)
        terms = inner + over + over**2 / 2, inner + over, inner
        return [
            self.strain * term / (-self.reach) ** order
            for order, term in enumerate(terms)
        ]


def flattened(x, heights):
    """Heights (6, N), as from `Unevenness.at`, pressed flat next to the clamp."""
    place = x / CLAMP_TRANSITION_MM
    bell = np.exp(-(place**2))
    free, rise = 1 - bell, 2 * place * bell / CLAMP_TRANSITION_MM
    turn = (2 - 4 * place**2) * bell / CLAMP_TRANSITION_MM**2
    z, by_x, by_y, xx, xy, yy = heights
    return np.stack(
        [
            free * z,
            *(free * by_x + rise * z, free * by_y),
            *(free * xx + 2 * rise * by_x + turn * z, free * xy + rise * by_y),
            free * yy,
        ]
    )


def _checked_seed(seed):
    whole = np.ndim(seed) == 0 and isinstance(seed, (int, float, np.number))
    if not (whole and 0 <= seed < 2**53 and float(seed).is_integer()):
        raise InputError(f"field 'seed': found {seed}; give a whole number from 0 on")
    return int(seed)
