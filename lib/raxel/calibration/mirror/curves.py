"""Two readings of the reduced model (5.2): a bent mirror as a cubic in a plane.

Everything lies in the plane at right angles to the clamp line. The viewer's centre is
the origin, the z axis its principal axis, and a pixel is the normalised coordinate
u = x / z of its viewing ray. Points and directions are rows (x, z), in mm.

The thesis calls u the image coordinate and takes the slope dS/du as that of a beam,
which is metric (E-5.01). `DistanceCurve` is the first: with (5.3) the mirror is
S(u) = D(u) V_l(u), D a cubic of u. `HeightCurve` is the second: the height over the
line of the clamp is a cubic of the length along it, as in the beam's formula (5.1).

Both bring their variable to about [-1, 1] or [0, 1], so that four powers are well
conditioned. Both answer the same questions, which is all that a calibration asks:
where a viewing ray meets the mirror, how steep it is there, and how both change with
the coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from raxel.errors import CalibrationError

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
