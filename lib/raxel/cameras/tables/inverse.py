"""From points to pixels of a general camera: the inverse of its interpolation.

A point P is seen at (s, t) of a cell when the interpolated ray passes through it:
(P - o(s, t)) x d(s, t) = 0, two independent equations, solved by Newton's method.

Most points are found by a walk: it starts in the cell whose direction is nearest (a
tree over a coarse grid of cells), and each Newton step may enter a neighbouring cell.
A walk can be stopped by a hole in the table. Whatever it did not find is searched for
completely, in a pyramid of bounds: each node holds a cone of directions and a ball of
origins that enclose all rays below it, so no cell that sees the point is passed over.
"""

from functools import cached_property

import numpy as np

from raxel.cameras.tables.bounds import BoundPyramid

# In pixels: a step this small ends the iteration, and a cell reaches this far over its
# border, so that rounding cannot lose a point between two cells.
STEP = 1e-10
# Sine of the angle by which a ray may miss its point. Rounding alone stays below it.
MISS = 1e-11
# Where Newton's method starts in a cell. The centre does, except where noise folds it.
STARTS = ((0.5, 0.5), (0, 0), (1, 0), (0, 1), (1, 1))
COARSE_CELLS = 1 << 16
SEARCH_BLOCK = 1 << 11


class TableInverse:
    """The search structure of one `RayTable`."""

    def __init__(self, table):
        self._table = table
        self._plant_tree()

    @cached_property
    def _pyramid(self):
        # Points in the middle of the field of view are found without it.
        return BoundPyramid(self._table)

    def project(self, points):
        """Pixels (N, 2) of points (N, 3), NaN where no position sees the point."""
        pixels = np.full((len(points), 2), np.nan)
        finite = np.flatnonzero(np.isfinite(points).all(axis=1))
        if self._tree is not None:
            pixels[finite] = self._walk(points[finite])
        left = finite[np.isnan(pixels[finite, 0])]
        for start in range(0, len(left), SEARCH_BLOCK):
            rows = left[start : start + SEARCH_BLOCK]
            pixels[rows] = self._search(points[rows])
        return pixels

    def _plant_tree(self):
        from scipy.spatial import cKDTree

        mask = self._table.mask
        whole = mask[:-1, :-1] & mask[1:, :-1] & mask[:-1, 1:] & mask[1:, 1:]
        stride = max(1, int(np.ceil(np.sqrt(whole.size / COARSE_CELLS))))
        coarse = np.zeros_like(whole)
        coarse[stride // 2 :: stride, stride // 2 :: stride] = True
        v, u = np.nonzero(whole & coarse)
        self._start = np.column_stack([u, v])
        self._tree = cKDTree(self._table.directions[v, u]) if len(u) else None
        self._eye = self._table.origins
        if not self._table.central and len(u):
            self._eye = self._table.origins[v, u].mean(axis=0)

    def _walk(self, points):
        """Newton's method across cells; NaN where it does not arrive."""
        table = self._table
        far = points - self._eye
        length = np.linalg.norm(far, axis=1, keepdims=True)
        _, nearest = self._tree.query(far / np.where(length > 0, length, 1.0))
        place = self._start[nearest] + 0.5
        last = np.array([table.width - 2, table.height - 2])
        found = np.full_like(place, np.nan)
        active = np.arange(len(points))
        one = np.ones(len(points), int)
        for _ in range(20):
            cell = np.clip(np.floor(place).astype(int), 0, last)
            whole = one[: len(active)]
            corners = table.corners(*cell.T, whole, whole)
            step, good = self._newton(points[active], corners, place - cell)
            small = np.all(np.abs(step) < STEP, axis=1)
            place = place + step
            inside = np.all(np.abs(place - cell - 0.5) <= 0.5 + STEP, axis=1)
            arrived = small & inside & good
            found[active[arrived]] = np.clip(place, cell, cell + 1)[arrived]
            go_on = ~small & np.isfinite(step).all(axis=1)
            active, place = active[go_on], np.clip(place[go_on], 0, last + 1)
            if not len(active):
                break
        return found

    def _newton(self, points, corners, place):
        """Newton step (N, 2) towards the ray through each point; and whether the ray
        after a small step meets the point, ahead of its origin."""
        (d, d_s, d_t), (o, o_s, o_t) = self._table.interpolate(corners, *place.T)
        far = points - o
        length = np.linalg.norm(far, axis=1, keepdims=True)
        length[length == 0] = np.nan
        far = far / length
        miss = _cross(far, d)
        miss_s, miss_t = _cross(far, d_s), _cross(far, d_t)
        if not self._table.central:
            miss_s -= _cross(o_s / length, d)
            miss_t -= _cross(o_t / length, d)
        ss, tt, st = _dot(miss_s, miss_s), _dot(miss_t, miss_t), _dot(miss_s, miss_t)
        gs, gt = _dot(miss_s, miss), _dot(miss_t, miss)
        # An edge has no extent one way, a single pixel neither way: no step there.
        ss, tt = np.where(ss > 0, ss, 1.0), np.where(tt > 0, tt, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = -np.stack([tt * gs - st * gt, ss * gt - st * gs], axis=1)
            step /= (ss * tt - st * st)[:, None]
            rest = miss + step[:, :1] * miss_s + step[:, 1:] * miss_t
        sine = np.sqrt(_dot(rest, rest) / _dot(d, d))
        return step, (sine < MISS) & (_dot(far, d) > 0)

    def _search(self, points):
        """The complete search, for the points on which the walk gave up."""
        who, u, v = self._pyramid.cells(points)
        who, *cells = self._solvable(who, u, v)
        place = np.full((len(who), 2), np.nan)
        todo = np.ones(len(who), bool)
        for start in STARTS:
            few = [column[todo] for column in cells]
            place[todo] = self._within_cells(points[who[todo]], *few, start)
            todo = ~np.isin(who, who[np.isfinite(place[:, 0])])
        seen = np.isfinite(place[:, 0])
        who, place = who[seen], place[seen]
        order = np.lexsort([place[:, 0], place[:, 1], who])
        who, first = np.unique(who[order], return_index=True)
        pixels = np.full((len(points), 2), np.nan)
        pixels[who] = place[order][first]
        return pixels

    def _solvable(self, who, u, v):
        """Replace cells that miss a corner by the edges and pixels they do have."""
        mask = self._table.mask
        have = np.stack(
            [mask[v, u], mask[v, u + 1], mask[v + 1, u], mask[v + 1, u + 1]]
        )
        whole = have.all(axis=0)
        parts = [(who[whole], u[whole], v[whole], 1, 1)]
        for du, dv, right, below in [
            (0, 0, 1, 0), (0, 1, 1, 0), (0, 0, 0, 1), (1, 0, 0, 1),
            (0, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0), (1, 1, 0, 0),
        ]:  # fmt: skip
            first = have[du + 2 * dv]
            second = have[du + right + 2 * (dv + below)]
            use = ~whole & first & second
            parts.append((who[use], u[use] + du, v[use] + dv, right, below))
        sizes = [len(part[0]) for part in parts]
        joined = [np.concatenate([part[k] for part in parts]) for k in range(3)]
        extent = [np.repeat([part[k] for part in parts], sizes) for k in (3, 4)]
        return (*joined, *extent)

    def _within_cells(self, points, u, v, right, below, start):
        """Newton's method inside one cell for each point; NaN where it leads out."""
        directions, origins = self._table.corners(u, v, right, below)
        extent = np.column_stack([right, below]).astype(float)
        place = extent * start
        found = np.full_like(place, np.nan)
        active = np.arange(len(points))
        for _ in range(20):
            size = extent[active]
            corners = directions[active], None if origins is None else origins[active]
            step, good = self._newton(points[active], corners, place)
            small = np.all(np.abs(step) < STEP, axis=1)
            place = np.clip(place + step, -1.0, 2.0)
            inside = np.all(np.abs(place - size / 2) <= size / 2 + STEP, axis=1)
            arrived = small & inside & good
            found[active[arrived]] = np.clip(place, 0, size)[arrived]
            go_on = ~small & np.isfinite(step).all(axis=1)
            active, place = active[go_on], place[go_on]
            if not len(active):
                break
        return np.column_stack([u, v]) + found


def _dot(a, b):
    return np.einsum("ni,ni->n", a, b)


def _cross(a, b):
    x, y, z = a.T
    p, q, r = b.T
    return np.stack([y * r - z * q, z * p - x * r, x * q - y * p], axis=1)
