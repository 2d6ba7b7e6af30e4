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
from raxel.cameras.tables.interpolation import walked, within_cells

# Where Newton's method starts in a cell. The centre does, except where noise folds it.
STARTS = ((0.5, 0.5), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0))
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
        start = self._start[nearest] + 0.5
        return walked(points, start, *table.rows, table.width, table.height)

    def _search(self, points):
        """The complete search, for the points on which the walk gave up."""
        who, u, v = self._pyramid.cells(points)
        who, cells = self._solvable(who, u, v)
        place = np.full((len(who), 2), np.nan)
        todo = np.ones(len(who), bool)
        rows, width = self._table.rows, self._table.width
        for start in STARTS:
            place[todo] = within_cells(
                points[who[todo]], cells[todo], start, *rows, width
            )
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
        who, *place = joined
        return who, np.column_stack([*place, *extent])
