"""Rays of a camera in bulk: polynomials through exact rays, tile by tile.

An image needs the rays of millions of positions, and most cameras change smoothly from
one to the next. The image is cut into tiles. Rays at 7 x 7 Chebyshev nodes of a tile
give those in between, to about 1e-7 px and usually far better. Where the last
coefficients do not vanish (a kink or a jump of the camera's map) or some nodes have no
ray, every position of the tile gets its own exact ray.

Only an irregular patch without a node can be overlooked, smaller than the 5 px between
nodes.
"""

from functools import lru_cache

import numba
import numpy as np

from raxel.cameras.core.base import Rays

# Maximum side of a tile, and extent of its nodes beyond it, px.
TILE_PX, MARGIN_PX = 16.0, 1.0
N_NODES = 7
NODE_POSITIONS = -np.cos(np.pi * np.arange(N_NODES) / (N_NODES - 1))
# Limit in px, and rounding, for the terms of highest degree of a tile's Chebyshev
# series. Neglected terms are much smaller again.
LAST_TERMS_TOL_PX, ROUNDING_TOL = 1e-6, 1e-13
TILE_BLOCK = 1 << 11
# State of a tile without a polynomial: not tested, exact rays, no ray at all.
UNKNOWN, EXACT, EMPTY = -1, -2, -3


@lru_cache(maxsize=8)
def smooth_rays(camera):
    """Cached `SmoothRays` of a camera."""
    return SmoothRays(camera)


class SmoothRays:
    """Rays of one camera; tiles are computed on demand.

    For a central camera with a common origin of all rays, origins are (1, 3); rays may
    also start on a mirror, each where it leaves.
    """

    def __init__(self, camera):
        self.camera = camera
        full = np.array([camera.width, camera.height])
        self._count = np.ceil(full / TILE_PX).astype(int)
        self._size = full / self._count
        self._tiles = np.full(self._count[::-1], UNKNOWN)
        u, v = ((np.arange(n) + 0.5) * TILE_PX for n in self._count)
        seen = camera.rays(_pairs(u, v))
        first = seen.origins[np.argmax(seen.valid)]
        one = np.all((seen.origins == first) | ~seen.valid[:, None])
        self._origin = first[None] if camera.central and one else None
        # Memory for all tiles; pages that are never written are not allocated.
        self._directions = np.empty((self._tiles.size, N_NODES, N_NODES, 3))
        self._origins = np.empty_like(self._directions)
        self._known = 0

    def rays(self, pixels):
        """`Rays` of positions (N, 2)."""
        column, x = self._place(pixels[:, 0], 0)
        row, y = self._place(pixels[:, 1], 1)
        wanted = np.zeros(self._tiles.shape, bool)
        wanted[row, column] = True
        self._look_at(wanted)
        tile = self._tiles[row, column]
        tile[~((np.abs(x) <= 1) & (np.abs(y) <= 1))] = EXACT
        rays = self._interpolated(lambda values: _at_points(values, tile, x, y))
        exact = np.flatnonzero(tile == EXACT)
        return self._corrected(rays, exact, pixels[exact])

    def grid(self, u, v):
        """`Rays` of all (u, v), (len(v) * len(u)), by rows; u and v rise."""
        (column, x), (row, y) = self._place(u, 0), self._place(v, 1)
        wanted = np.zeros(self._tiles.shape, bool)
        wanted[np.ix_(np.unique(row), np.unique(column))] = True
        self._look_at(wanted)
        wu, wv = _weights(x), _weights(y)
        rays = self._interpolated(
            lambda values: _on_grid(values, self._tiles, column, wu, row, wv)
        )
        exact = np.zeros(0, int)
        if np.any(wanted & (self._tiles == EXACT)):
            exact = np.flatnonzero((self._tiles == EXACT)[row][:, column])
        j, i = np.divmod(exact, len(u))
        return self._corrected(rays, exact, np.column_stack([u[i], v[j]]))

    def exact_on_grid(self, u, v, rays, where):
        """The camera's own `Rays` at indices (n,) of a grid, of which `grid` gave
        `rays`."""
        j, i = np.divmod(where, len(u))
        origins = rays.origins if self._origin is not None else rays.origins[where]
        found = Rays(origins, rays.directions[where], rays.valid[where])
        tile = self._tiles[self._place(v[j], 1)[0], self._place(u[i], 0)[0]]
        again = np.flatnonzero(tile != EXACT)
        pixels = np.column_stack([u[i[again]], v[j[again]]])
        return self._corrected(found, again, pixels)

    def _place(self, values, axis):
        """Tile of each coordinate, and position in it: -1 to 1 between end nodes."""
        return _places(values, self._size[axis], self._count[axis])

    def _interpolated(self, values_at):
        directions = values_at(self._directions)
        valid = np.isfinite(directions[:, 2])
        one = self._origin is not None
        return Rays(
            self._origin if one else values_at(self._origins), directions, valid
        )

    def _corrected(self, rays, where, pixels):
        """Rays with exact ones at the indices `where`."""
        if len(where):
            exact = self.camera.rays(pixels)
            rays.directions[where], rays.valid[where] = exact.directions, exact.valid
            if self._origin is None:
                rays.origins[where] = exact.origins
        return rays

    def _look_at(self, wanted):
        """Compute the wanted tiles (rows, columns) that are unknown."""
        rows, columns = np.nonzero(wanted & (self._tiles == UNKNOWN))
        for first in range(0, len(rows), TILE_BLOCK):
            part = slice(first, first + TILE_BLOCK)
            self._look_at_some(rows[part], columns[part])

    def _look_at_some(self, rows, columns):
        u, v = (
            -0.5
            + (tile[:, None] + 0.5) * size
            + NODE_POSITIONS * (size / 2 + MARGIN_PX)
            for tile, size in zip((columns, rows), self._size, strict=True)
        )
        u, v = np.broadcast_arrays(u[:, None, :], v[:, :, None])
        rays = self.camera.rays(np.column_stack([u.ravel(), v.ravel()]))
        shape = len(rows), N_NODES, N_NODES, 3
        origins, directions = (field.reshape(shape) for field in rays[:2])
        valid = rays.valid.reshape(shape[:3])
        good = valid.all(axis=(1, 2))
        good[good] = _smooth(directions[good]) & _smooth(origins[good])
        kind = np.where(valid.any(axis=(1, 2)), EXACT, EMPTY)
        kind[good] = self._known + np.arange(np.count_nonzero(good))
        self._tiles[rows, columns] = kind
        new = slice(self._known, self._known + np.count_nonzero(good))
        self._directions[new] = directions[good]
        if self._origin is None:
            self._origins[new] = origins[good]
        self._known = new.stop


def _pairs(u, v):
    return np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)


def _chebyshev():
    """Coefficients (N_NODES, N_NODES) of T_0, T_1, ... from values at the nodes."""
    series = np.polynomial.chebyshev.chebvander(NODE_POSITIONS, N_NODES - 1)
    return np.linalg.inv(series)


TO_SERIES = _chebyshev()


def _smooth(values):
    """Whether the series of tiles (n, N_NODES, N_NODES, 3) end in terms near zero."""
    last = TO_SERIES[-1]
    down = np.einsum("j,njkc,lk->nlc", last, values, TO_SERIES)
    across = np.einsum("k,njkc,lj->nlc", last, values, TO_SERIES)
    terms = np.abs(down).sum(axis=1) + np.abs(across).sum(axis=1)
    per_px = np.ptp(values, axis=(1, 2)).max(axis=1) / TILE_PX
    size = np.abs(values).max(axis=(1, 2, 3))
    return terms.max(axis=1) <= LAST_TERMS_TOL_PX * per_px + ROUNDING_TOL * size


LAGRANGE = 1 / np.prod(
    NODE_POSITIONS[:, None] - NODE_POSITIONS + np.eye(N_NODES), axis=1
)


@numba.njit(cache=True)
def _places(values, size, count):
    """Tiles (N,) of coordinates (N,) among `count` of a size; places in them (N,)."""
    tile, x = np.empty(len(values), np.int64), np.empty(len(values))
    for n in range(len(values)):
        from_edge = values[n] + 0.5
        # NaN and very large values are no valid index.
        inside = 0 <= from_edge < count * size
        tile[n] = int(from_edge / size) if inside else (count - 1) * (from_edge > 0)
        x[n] = (from_edge - (tile[n] + 0.5) * size) / (size / 2 + MARGIN_PX)
    return tile, x


@numba.njit(cache=True)
def _weight_into(weights, x):
    """Weights of the nodes' values for the value at x: Lagrange's polynomials."""
    left = 1.0
    for k in range(N_NODES):
        weights[k] = left * LAGRANGE[k]
        left *= x - NODE_POSITIONS[k]
    right = 1.0
    for k in range(N_NODES - 1, -1, -1):
        weights[k] *= right
        right *= x - NODE_POSITIONS[k]


@numba.njit(cache=True)
def _weights(x):
    """Weights (N, N_NODES) for values at x (N,)."""
    weights = np.empty((len(x), N_NODES))
    for n in range(len(x)):
        _weight_into(weights[n], x[n])
    return weights


@numba.njit(cache=True)
def _on_grid(values, tiles, column, wu, row, wv):
    """Values (m * n, 3) on a grid; column, wu of its n abscissae, row, wv of m."""
    n = len(column)
    out = np.empty((len(row) * n, 3))
    inner = np.empty((N_NODES, 3))
    for r in range(len(row)):
        here = -1
        for p in range(n):
            tile = tiles[row[r], column[p]]
            if tile < 0:
                out[r * n + p] = np.nan
                continue
            if tile != here:
                here = tile
                for k in range(N_NODES):
                    for c in range(3):
                        total = 0.0
                        for j in range(N_NODES):
                            total += wv[r, j] * values[tile, j, k, c]
                        inner[k, c] = total
            for c in range(3):
                total = 0.0
                for k in range(N_NODES):
                    total += wu[p, k] * inner[k, c]
                out[r * n + p, c] = total
    return out


@numba.njit(cache=True)
def _at_points(values, tile, x, y):
    """Values (N, 3) in tiles (N,) at x, y (N,)."""
    out = np.empty((len(tile), 3))
    wu, wv = np.empty(N_NODES), np.empty(N_NODES)
    for n in range(len(tile)):
        if tile[n] < 0:
            out[n] = np.nan
            continue
        _weight_into(wu, x[n])
        _weight_into(wv, y[n])
        # Sums in single variables stay in registers: twice as fast as in an array.
        a = b = c = 0.0
        for j in range(N_NODES):
            d = e = f = 0.0
            for k in range(N_NODES):
                d += wu[k] * values[tile[n], j, k, 0]
                e += wu[k] * values[tile[n], j, k, 1]
                f += wu[k] * values[tile[n], j, k, 2]
            a += wv[j] * d
            b += wv[j] * e
            c += wv[j] * f
        out[n, 0], out[n, 1], out[n, 2] = a, b, c
    return out
