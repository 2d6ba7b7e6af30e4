"""Lens formulas as fits need them: pixels of points, and their derivatives.

A point X of the camera frame is seen at the angle theta to the axis z from the pupil at
height z0(theta) on it: (z - z0) sin theta = rho cos theta, with rho its distance from
the axis. With e the unit vector across the axis towards X, the formula is

    p = s(theta) e,    q = p (1 + k1 s^2 + k2 s^4 + ...) + d(p),
    pixel = (fx q_x + cx, fy q_y + cy),    z0 = a1 theta^2 + a2 theta^4 + ...

The base s is theta (Kannala and Brandt) or (1 + xi) sin theta / (cos theta + xi) (the
unified sphere): both are theta near the axis, so that xi changes neither the focal
length nor the size of the other terms there. A perspective lens is the unified sphere
with xi = 0, s = tan theta; where xi is free beside the radial terms, all of these hang
together, and no fit ends on 0 by itself. With (x, y) = p, the decentring d is
Brown's and that of a thin prism,

    d = (2 p1 x y + p2 (s^2 + 2 x^2) + s1 s^2, p1 (s^2 + 2 y^2) + 2 p2 x y + s2 s^2):

together all that grows with s^2 and goes once round with the azimuth. Sources: Brown
1971, Photogrammetric Engineering 37(8); Weng, Cohen and Herniou 1992,
doi:10.1109/34.159901.
"""

from typing import NamedTuple

import numpy as np

from raxel.cameras.lenses.kannala_brandt import KannalaBrandtCamera
from raxel.cameras.lenses.moving_pupil import MovingPupilCamera, sight_angles
from raxel.cameras.lenses.unified_sphere import UnifiedSphereCamera
from raxel.errors import CalibrationError, InputError

FRAME = 4  # fx, fy, cx, cy come first
MAX_XI = 100.0  # a fisheye has 2 or 3; the image of more is the same to 1 %
NEAR_AXIS = 1e-9  # of the distance: nearer to the axis a point counts as on it


class LensFormula(NamedTuple):
    """Which terms a lens formula has.

    base: "kannala-brandt", "unified", or "perspective", the unified sphere whose xi is
    0 and no parameter; radial: number of terms k; decentring: 0, 2 (p1, p2) or 4
    (s1, s2, too); pupil: number of terms of z0, 0 for a central lens; board: which
    values of a BoardShape are fitted with it, names in their order.

    Its parameters stand in one vector (P,): fx, fy, cx, cy; xi of the unified base; k;
    the decentring; a; the board's. Lengths are in the board's unit.
    """

    base: str
    radial: int
    decentring: int
    pupil: int
    board: tuple = ()

    @property
    def names(self):
        """The names of the parameters, in their order."""
        names = ["fx", "fy", "cx", "cy"]
        names += ["xi"] * (self.base == "unified")
        names += [f"k{j + 1}" for j in range(self.radial)]
        names += ["p1", "p2", "s1", "s2"][: self.decentring]
        names += [f"a{j + 1}" for j in range(self.pupil)]
        return names + list(self.board)

    def parts(self, values):
        """(xi, k, (p1, p2, s1, s2), a) of a vector (P,); xi is None where the law has
        none."""
        xi = 0.0 if self.base == "perspective" else None
        first = FRAME
        if self.base == "unified":
            xi, first = values[FRAME], FRAME + 1
        off_axis = first + self.radial
        pupil = off_axis + self.decentring
        decentring = np.zeros(4)
        decentring[: self.decentring] = values[off_axis:pupil]
        a = values[pupil : pupil + self.pupil]
        return xi, values[first:off_axis], decentring, a

    def moved_to(self, other, values):
        """The vector of another formula of the same base; terms it lacks are dropped,
        new ones are 0."""
        known = dict(zip(self.names, values, strict=True))
        return np.array([known.get(name, 0.0) for name in other.names])

    def bounded(self, values):
        """The vector with a xi that a unified sphere can have."""
        if self.base == "unified" and not 0 <= values[FRAME] <= MAX_XI:
            values = values.copy()
            values[FRAME] = np.clip(values[FRAME], 0, MAX_XI)
        return values

    def camera(self, values, width, height):
        """The Camera of parameters (P,), or CalibrationError where there is none."""
        xi, k, decentring, a = self.parts(values)
        fx, fy, cx, cy = values[:FRAME]
        off_axis = {"tangential": decentring[:2], "prism": decentring[2:]}
        try:
            if xi is None:
                terms = np.concatenate([[1.0], k if len(k) else [0.0]])
                lens = KannalaBrandtCamera(
                    terms, (fx, fy), (cx, cy), width, height, **off_axis
                )
            else:
                # The camera's own base is smaller by this factor.
                scale = 1 + xi
                K = [[scale * fx, 0, cx], [0, scale * fy, cy], [0, 0, 1]]
                k = k * scale ** (2.0 * np.arange(1, len(k) + 1))
                off_axis = {name: scale * terms for name, terms in off_axis.items()}
                lens = UnifiedSphereCamera(xi, K, width, height, k, **off_axis)
            return MovingPupilCamera(lens, a) if len(a) else lens
        except InputError as fault:
            raise CalibrationError(
                f"{self.base}: what was fitted is no camera: {fault}", code="no-camera"
            ) from None


class Imaged(NamedTuple):
    """pixels (N, 2), NaN beyond the formula; by_values (N, 2, P), 0 for the board's,
    and by_points (N, 2, 3), their derivatives."""

    pixels: np.ndarray
    by_values: np.ndarray
    by_points: np.ndarray


def imaged_points(formula, values, points, derivatives=True):
    """Pixels of points (N, 3) by a formula, and their derivatives: Imaged; without
    them, the pixels (N, 2) alone."""
    xi, k, decentring, a = formula.parts(values)
    focal, centre = values[:2], values[2:FRAME]
    with np.errstate(all="ignore"):
        rho, unit = _across(points)
        theta = sight_angles(rho, points[:, 2], a)
        s, slope, s_by_xi = _base(theta, xi)
        p = s[:, None] * unit
        terms = _terms(p, k)
        q = terms.factor[:, None] * p + terms.by_decentring @ decentring
        if not derivatives:
            return focal * q + centre
        by_rho, by_z, by_a = _slopes(theta, rho, points[:, 2], a)
        by_p, q_by_k = _warp_slopes(p, k, decentring, terms)
        # Radially p moves with theta, across with the azimuth.
        outer = unit[:, :, None] * unit[:, None]
        p_by_points = np.empty((len(points), 2, 3))
        p_by_points[:, :, :2] = (slope * by_rho)[:, None, None] * outer + (s / rho)[
            :, None, None
        ] * (np.eye(2) - outer)
        p_by_points[:, :, 2] = (slope * by_z)[:, None] * unit
        radial = np.einsum("nij,nj->ni", by_p, unit)
        own = [q_by_k, terms.by_decentring[:, :, : formula.decentring]]
        if formula.base == "unified":
            own = [(s_by_xi[:, None] * radial)[:, :, None], *own]
        own.append(radial[:, :, None] * (slope[:, None] * by_a)[:, None])
        own = focal[:, None] * np.concatenate(own, axis=2)
        by_values = np.zeros((len(points), 2, len(values)))
        by_values[:, :, FRAME : FRAME + own.shape[2]] = own
        by_values[:, 0, 0], by_values[:, 1, 1] = q.T
        by_values[:, 0, 2] = by_values[:, 1, 3] = 1.0
        return Imaged(
            focal * q + centre, by_values, focal[:, None] * (by_p @ p_by_points)
        )


def _across(points):
    """Distance rho (N,) of points (N, 3) from the axis, and unit vectors (N, 2)."""
    across, z = points[:, :2], points[:, 2]
    rho = np.maximum(np.hypot(*across.T), NEAR_AXIS * np.abs(z))
    return rho, across / rho[:, None]


def _slopes(theta, rho, z, a):
    """Derivatives of theta by rho, z and a (N, A)."""
    sine, cosine = np.sin(theta), np.cos(theta)
    powers = theta[:, None] ** (2 * np.arange(1, len(a) + 1))
    height = z - powers @ a
    height_slope = (
        powers @ (2 * np.arange(1, len(a) + 1) * a) / np.maximum(theta, 1e-300)
    )
    rise = height * cosine + rho * sine - height_slope * sine
    return cosine / rise, -sine / rise, (sine / rise)[:, None] * powers


def _base(theta, xi):
    """s, ds/dtheta and ds/dxi at angles (N,); NaN beyond the sphere's rim."""
    if xi is None:
        return theta, np.ones_like(theta), np.zeros_like(theta)
    sine, cosine = np.sin(theta), np.cos(theta)
    depth = np.where(cosine + xi > 0, cosine + xi, np.nan)
    slope = (1 + xi) * (1 + xi * cosine) / depth**2
    slope = np.where(slope > 0, slope, np.nan)
    return (1 + xi) * sine / depth, slope, sine * (cosine - 1) / depth**2


class _Terms(NamedTuple):
    """At p: s^2 (N,), its powers (N, K), 1 + k1 s^2 + ... (N,), and the derivatives of
    q by p1 to s2 (N, 2, 4)."""

    squared: np.ndarray
    powers: np.ndarray
    factor: np.ndarray
    by_decentring: np.ndarray


def _terms(p, k):
    x, y = p.T
    squared = x * x + y * y
    powers = squared[:, None] ** np.arange(1, len(k) + 1)
    by_terms = np.zeros((len(p), 2, 4))
    by_terms[:, 0, 0] = by_terms[:, 1, 1] = 2 * x * y
    by_terms[:, 0, 1] = squared + 2 * x * x
    by_terms[:, 1, 0] = squared + 2 * y * y
    by_terms[:, 0, 2] = by_terms[:, 1, 3] = squared
    return _Terms(squared, powers, 1 + powers @ k, by_terms)


def _warp_slopes(p, k, decentring, terms):
    """Derivatives of q by p (N, 2, 2) and by k (N, 2, K)."""
    x, y = p.T
    p1, p2, s1, s2 = decentring
    factor, powers = terms.factor, terms.powers
    change = (
        2
        * (powers / np.maximum(terms.squared, 1e-300)[:, None])
        @ (np.arange(1, len(k) + 1) * k)
    )
    by_p = np.empty((len(p), 2, 2))
    across = change * x * y + 2 * p1 * x + 2 * p2 * y
    by_p[:, 0, 0] = factor + change * x * x + 2 * p1 * y + 6 * p2 * x + 2 * s1 * x
    by_p[:, 1, 1] = factor + change * y * y + 6 * p1 * y + 2 * p2 * x + 2 * s2 * y
    by_p[:, 0, 1], by_p[:, 1, 0] = across + 2 * s1 * y, across + 2 * s2 * x
    return by_p, p[:, :, None] * powers[:, None]
