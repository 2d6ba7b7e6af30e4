"""Surfaces that rays can meet: rectangle, disc, cylinder, height field, box.

A surface has a pose `T_world_surface` (4, 4), in mm, in the world, and two coordinates
uv in mm for its texture. Every surface is visible from both sides.
"""

from __future__ import annotations

import abc
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.geometry import pose, transform


class Hit(NamedTuple):
    """Hold the first intersections of N rays with a surface.

    distance: (N,) from the ray's origin, inf without an intersection; uv: (N, 2)
    surface coordinates in mm; cosine: (N,) of the angle between ray and normal (the
    frame's z axis, or away from a cylinder's axis), so positive where a flat surface is
    viewed from the front, with x right and y down. Without an intersection, uv and
    cosine are undefined.
    """

    distance: np.ndarray
    uv: np.ndarray
    cosine: np.ndarray


class TracedSurface(abc.ABC):
    """Represent a surface with its pose `T_world_surface` in the world."""

    def __init__(self, T_world_surface):
        T = np.array(T_world_surface, float)
        if T.shape != (4, 4) or not np.isfinite(T).all():
            raise InputError(
                f"surface: pose has shape {T.shape}; give 4 x 4 finite numbers"
            )
        self.T_world_surface = T

    @abc.abstractmethod
    def hit(self, origins: ArrayLike, directions: ArrayLike) -> Hit:
        """Return the `Hit` of rays with the surface, in the world frame.

        Parameters
        ----------
        origins : (N, 3) or (1, 3) array_like
            Origins, mm; one row for rays from one point.
        directions : (N, 3) array_like
            Unit directions; rays that hold NaN miss.

        Returns
        -------
        Hit
            Distances, surface coordinates and cosines.
        """

    @property
    @abc.abstractmethod
    def outline(self) -> NDArray[np.float64]:
        """Straight borders as segments (n, 2, 3) in the world frame."""


class _Flat(TracedSurface):
    """Part of the plane z = 0 of its frame, between `low` and `high` (2,); uv: (x, y).

    Subclasses set both.
    """

    low: np.ndarray
    high: np.ndarray

    def hit(self, origins: ArrayLike, directions: ArrayLike) -> Hit:
        """Return the `Hit` of rays, as `TracedSurface.hit`."""
        origins, directions = np.asarray(origins, float), np.asarray(directions, float)
        pose_and_box = self.T_world_surface, self.low, self.high
        return Hit(*_plane_hits(origins, directions, *pose_and_box))


class Rectangle(_Flat):
    """Rectangular part of the plane z = 0 of its frame; uv is (x, y).

    It reaches from `corner` by `width` along x and `height` along y.

    Parameters
    ----------
    T_world_surface : (4, 4) array_like
        Pose of the surface's frame in the world, mm.
    width, height : float
        Size along x and y, mm.
    corner : (2,) array_like
        Corner of the least x and y, mm.

    Raises
    ------
    InputError
        For a pose that is not 4 x 4 finite numbers, or a size that is not positive.
    """

    def __init__(
        self,
        T_world_surface: ArrayLike,
        width: float,
        height: float,
        corner: ArrayLike = (0.0, 0.0),
    ) -> None:
        super().__init__(T_world_surface)
        self.width = _positive("rectangle", "width", width)
        self.height = _positive("rectangle", "height", height)
        self.low = np.array(corner, float)
        self.high = self.low + [self.width, self.height]

    @property
    def outline(self) -> NDArray[np.float64]:
        """The four sides, (4, 2, 3), in the world frame, mm."""
        (x0, y0), (x1, y1) = self.low, self.high
        ring = np.array([[x0, y0, 0], [x1, y0, 0], [x1, y1, 0], [x0, y1, 0]])
        ring = transform(self.T_world_surface, ring)
        return np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)


class Disc(_Flat):
    """Disc in the plane z = 0 around the origin of its frame; uv is (x, y).

    Parameters
    ----------
    T_world_surface : (4, 4) array_like
        Pose of the surface's frame in the world, mm.
    radius : float
        Outer radius, mm.
    inner_radius : float
        Radius of the hole, mm; 0 without a hole.

    Raises
    ------
    InputError
        For a pose that is not 4 x 4 finite numbers, or a radius that is not positive.
    """

    def __init__(
        self, T_world_surface: ArrayLike, radius: float, inner_radius: float = 0.0
    ) -> None:
        super().__init__(T_world_surface)
        self.radius = _positive("disc", "radius", radius)
        self.inner_radius = float(inner_radius)
        self.high = np.full(2, self.radius)
        self.low = -self.high

    def hit(self, origins: ArrayLike, directions: ArrayLike) -> Hit:
        """Return the `Hit` of rays, as `TracedSurface.hit`."""
        hit = super().hit(origins, directions)
        with np.errstate(all="ignore"):
            square = np.sum(hit.uv**2, axis=1)
            on = (square <= self.radius**2) & (square >= self.inner_radius**2)
        hit.distance[~on] = np.inf
        return hit

    @property
    def outline(self) -> NDArray[np.float64]:
        """Return an empty array, (0, 2, 3): a disc has no straight border."""
        return np.empty((0, 2, 3))


class _Curved(TracedSurface):
    """Met in its own frame."""

    def hit(self, origins, directions):
        """As `TracedSurface.hit`."""
        R, t = self.T_world_surface[:3, :3], self.T_world_surface[:3, 3]
        o = R.T @ (np.asarray(origins, float) - t).T
        d = R.T @ np.asarray(directions, float).T
        with np.errstate(all="ignore"):
            return self._hit(o, d)

    @abc.abstractmethod
    def _hit(self, o, d):
        """As `hit`, in the surface's frame; o is (3, 1) or (3, N), d is (3, N)."""


class Cylinder(_Curved):
    """Represent a mantle around the z axis of its frame, from z = 0 to `height`.

    uv is (radius * azimuth, z) with the azimuth in (-pi, pi] from the x axis: the seam
    is on the side of -x. Inside and outside are both visible; there are no lids.
    """

    def __init__(self, T_world_surface, radius, height):
        super().__init__(T_world_surface)
        self.radius = _positive("cylinder", "radius", radius)
        self.height = _positive("cylinder", "height", height)

    def _hit(self, o, d):
        a = d[0] ** 2 + d[1] ** 2
        b = o[0] * d[0] + o[1] * d[1]
        c = o[0] ** 2 + o[1] ** 2 - self.radius**2
        square = b * b - a * c
        # Most rays pass a slim cylinder by: only the others are followed.
        rays = np.flatnonzero(square >= 0)
        o = np.broadcast_to(o, d.shape)[:, rays]
        near = self._followed(o, d[:, rays], a[rays], b[rays], np.sqrt(square[rays]))
        distance, uv = np.full(len(a), np.inf), np.zeros((len(a), 2))
        cosine = np.zeros(len(a))
        distance[rays], uv[rays], cosine[rays] = near
        return Hit(distance, uv, cosine)

    def _followed(self, o, d, a, b, root):
        """`Hit` of rays whose lines meet the endless mantle."""
        c = o[0] ** 2 + o[1] ** 2 - self.radius**2
        # Pair of roots in the form without cancellation for small c.
        q = -(b + np.where(b >= 0, root, -root))
        pair = np.stack([q / a, c / q])
        z = o[2] + pair * d[2]
        seen = (pair > 0) & (z >= 0) & (z <= self.height)
        distance = np.where(seen, pair, np.inf).min(axis=0)
        x, y = o[0] + distance * d[0], o[1] + distance * d[1]
        cosine = (x * d[0] + y * d[1]) / self.radius
        along = self.radius * np.arctan2(y, x)
        seen = np.isfinite(distance)
        return _as_hit(seen, distance, along, o[2] + distance * d[2], cosine)

    @property
    def outline(self):
        """Return None: both edges are circles."""
        return np.empty((0, 2, 3))


class Relief(_Curved):
    """Represent a height field z = h(x, y) over a rectangle; uv is (x, y).

    heights: (rows, columns) in mm at x = column * pitch_mm, y = row * pitch_mm,
    interpolated bilinearly. In each cell a ray meets it where a quadratic vanishes, so
    the intersection is exact to rounding. Visible from above and below.
    """

    def __init__(self, T_world_surface, heights, pitch_mm):
        super().__init__(T_world_surface)
        self.heights = np.array(heights, float)
        if self.heights.ndim != 2 or min(self.heights.shape) < 2:
            raise InputError(
                f"relief: found heights of shape {self.heights.shape}; give at least "
                "2 x 2"
            )
        if not np.isfinite(self.heights).all():
            raise InputError("relief: heights are not finite; give finite numbers")
        self.pitch_mm = _positive("relief", "pitch_mm", pitch_mm)

    def _hit(self, o, d):
        o = np.ascontiguousarray(o.T)
        return Hit(*_relief_hits(o, d.T.copy(), self.heights, self.pitch_mm))

    @property
    def outline(self):
        """Return None: the border follows the heights."""
        return np.empty((0, 2, 3))


def box(T_world_box, size):
    """Return the six faces of a box of `size` (3,) mm, a corner at its frame's origin.

    The first three faces are at x = 0, y = 0 and z = 0, the others opposite. Returns
    six Rectangles; uv is (y, z), (z, x) and (x, y) in turn.
    """
    size = np.array(size, float)
    if size.shape != (3,) or not (size > 0).all():
        raise InputError(f"box: size is {size.tolist()}; give three positive mm")
    faces = []
    for far in (False, True):
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            R = np.eye(3)[:, [u, v, axis]]
            T = T_world_box @ pose(R, far * size[axis] * np.eye(3)[axis])
            faces.append(Rectangle(T, size[u], size[v]))
    return faces


@numba.njit(cache=True, error_model="numpy")
def _plane_hits(origins, directions, T, low, high):
    """(distance (N,), uv (N, 2), cosine (N,)) of rays that meet the plane z = 0 of T.

    origins: (N, 3) or (1, 3). The distance is inf for rays that lead away from the
    plane or meet it outside of low to high (2,).
    """
    count = len(directions)
    distance, cosine = np.empty(count), np.empty(count)
    uv = np.empty((count, 2))
    for n in range(count):
        o, d = origins[n if len(origins) > 1 else 0], directions[n]
        x, y, z = o[0] - T[0, 3], o[1] - T[1, 3], o[2] - T[2, 3]
        away = x * T[0, 2] + y * T[1, 2] + z * T[2, 2]
        slant = d[0] * T[0, 2] + d[1] * T[1, 2] + d[2] * T[2, 2]
        far = -away / slant
        on = far > 0
        for c in range(2):
            start = x * T[0, c] + y * T[1, c] + z * T[2, c]
            along = d[0] * T[0, c] + d[1] * T[1, c] + d[2] * T[2, c]
            place = start + far * along
            on = on and low[c] <= place <= high[c]
            uv[n, c] = place
        distance[n], cosine[n] = far if on else np.inf, slant
    return distance, uv, cosine


@numba.njit(cache=True, error_model="numpy")
def _relief_hits(origins, directions, heights, pitch):
    """Return (distance (N,), uv (N, 2), cosine (N,)) of rays at a height field.

    origins: (N, 3) or (1, 3), directions: (N, 3), mm, in its frame; heights: (rows,
    columns), mm, `pitch` mm apart. Distance inf and uv 0 without an intersection.
    """
    count = len(directions)
    rows, columns = heights.shape
    distance, cosine = np.full(count, np.inf), np.zeros(count)
    uv = np.zeros((count, 2))
    # Margins above and below, so that a flat relief has an inside too.
    lowest, highest = heights.min(), heights.max()
    room = 1e-6 * max(pitch, highest - lowest)
    for n in range(count):
        # In units of the pitch, where cells are unit squares.
        o, d = origins[n if len(origins) > 1 else 0], directions[n]
        ox, oy, oz = o[0] / pitch, o[1] / pitch, o[2]
        dx, dy, dz = d[0] / pitch, d[1] / pitch, d[2]
        now, leave = 0.0, np.inf
        now, leave = _between(ox, dx, 0.0, columns - 1.0, now, leave)
        now, leave = _between(oy, dy, 0.0, rows - 1.0, now, leave)
        now, leave = _between(oz, dz, lowest - room, highest + room, now, leave)
        while now < leave:
            # A step beyond the line decides which cell the ray is in.
            forward = now + 1e-9 / max(abs(dx), abs(dy), 1e-12)
            i = min(max(int(np.floor(ox + forward * dx)), 0), columns - 2)
            j = min(max(int(np.floor(oy + forward * dy)), 0), rows - 2)
            after = min(_crossing(ox, dx, i), _crossing(oy, dy, j), leave)
            after = max(after, forward)
            root = _root_in_cell(
                (ox - i, oy - j, oz),
                (dx, dy, dz),
                heights[j : j + 2, i : i + 2],
                now,
                after,
            )
            if root < np.inf:
                distance[n] = root
                uv[n, 0], uv[n, 1] = o[0] + root * d[0], o[1] + root * d[1]
                px, py = ox + root * dx - i, oy + root * dy - j
                cosine[n] = _slant(d, heights[j : j + 2, i : i + 2], px, py, pitch)
                break
            now = after
    return distance, uv, cosine


@numba.njit(cache=True, error_model="numpy")
def _between(o, d, low, high, enter, leave):
    """The part of enter to leave of a ray on which low <= o + t d <= high."""
    if d == 0:
        return (enter, leave) if low <= o <= high else (np.inf, leave)
    one, two = (low - o) / d, (high - o) / d
    if not one <= two:
        one, two = two, one
    # A ray of NaN has no part.
    if not one <= two:
        return np.inf, leave
    return max(enter, one), min(leave, two)


@numba.njit(cache=True, error_model="numpy")
def _crossing(o, d, cell):
    """Where a ray leaves the cell from `cell` to one more."""
    if d == 0:
        return np.inf
    return ((cell + 1 if d > 0 else cell) - o) / d


@numba.njit(cache=True, error_model="numpy")
def _root_in_cell(o, d, h, now, after):
    """First t from now to after where o + t d meets the bilinear patch h (2, 2)."""
    bx, by = h[0, 1] - h[0, 0], h[1, 0] - h[0, 0]
    bxy = h[1, 1] - h[0, 1] - h[1, 0] + h[0, 0]
    # Height of the ray over the patch, from `now` on: a t^2 + b t + c.
    px, py, pz = o[0] + now * d[0], o[1] + now * d[1], o[2] + now * d[2]
    a = -bxy * d[0] * d[1]
    b = d[2] - bx * d[0] - by * d[1] - bxy * (px * d[1] + py * d[0])
    c = pz - h[0, 0] - bx * px - by * py - bxy * px * py
    q = -0.5 * (b + np.copysign(np.sqrt(b * b - 4 * a * c), b))
    # A root on the line belongs to either cell; rounding may put it outside both.
    slack = 1e-9 * (after - now)
    first = np.inf
    for t in (now + q / a, now + c / q):
        if now - slack <= t <= after + slack:
            first = min(first, t)
    return first


@numba.njit(cache=True, error_model="numpy")
def _slant(d, h, px, py, pitch):
    """Cosine between a ray and the patch's normal at (px, py) of its cell."""
    bx, by = h[0, 1] - h[0, 0], h[1, 0] - h[0, 0]
    bxy = h[1, 1] - h[0, 1] - h[1, 0] + h[0, 0]
    across, down = -(bx + bxy * py) / pitch, -(by + bxy * px) / pitch
    along = across * d[0] + down * d[1] + d[2]
    return along / np.sqrt(across**2 + down**2 + 1)


def _as_hit(seen, distance, u, v, cosine):
    uv = np.empty((len(seen), 2))
    uv[:, 0], uv[:, 1] = u, v
    return Hit(np.where(seen, distance, np.inf), uv, cosine)


def _positive(surface, name, value):
    value = float(value)
    if not (0 < value < np.inf):
        raise InputError(
            f"{surface}: {name}: {value} is invalid; give a positive length"
        )
    return value
