"""The neighbourhood of each corner, as its own lattice bends it.

Around corner p the lattice is x(s, t) = p + s u + t v + s^2 uu + t^2 vv + s t w, with
p's neighbours at s, t = -1, 0, 1. In (s, t) the edges are straight and cross at right
angles, whatever the lens, so windows are squares there.
"""

from typing import NamedTuple

import numpy as np

AXES = ((0, 1), (0, -1), (1, 0), (-1, 0))


class Patches(NamedTuple):
    """Local shape of a lattice at N corners, px: each field is (N, 2)."""

    p: np.ndarray
    u: np.ndarray
    v: np.ndarray
    uu: np.ndarray
    vv: np.ndarray
    w: np.ndarray

    def at(self, s, t):
        """Pixels (N, *shape, 2) of (s, t), arrays of one shape."""
        s, t = s[..., None], t[..., None]
        of = Patches(*(a.reshape(len(a), *(1,) * (s.ndim - 1), 2) for a in self))
        bent = s * s * of.uu + t * t * of.vv + s * t * of.w
        return of.p + s * of.u + t * of.v + bent

    def moved(self, shift):
        """The same shapes around corners moved by shift (N, 2) px."""
        return self._replace(p=self.p + shift)

    def shrunk(self, share):
        """The same bends, for (s, t) that are the share (N,) of theirs."""
        one = share[:, None]
        bent = (one**2 * a for a in (self.uu, self.vv, self.w))
        return Patches(self.p, one * self.u, one * self.v, *bent)

    def of(self, index):
        """Some of them."""
        return Patches(*(a[index] for a in self))

    @property
    def size(self):
        """Length in px of the shorter of u and v, (N,)."""
        return np.minimum(*(np.linalg.norm(a, axis=1) for a in (self.u, self.v)))


def shifted(grid, rows, columns):
    """grid[i + rows, j + columns], NaN beyond its ends; grid (rows, columns, ...)."""
    out = np.full_like(grid, np.nan)
    height, width = grid.shape[:2]
    i, j = (
        slice(max(0, -rows), height - max(0, rows)),
        slice(max(0, -columns), width - max(0, columns)),
    )
    k, m = (
        slice(max(0, rows), height + min(0, rows)),
        slice(max(0, columns), width + min(0, columns)),
    )
    if i.start < i.stop and j.start < j.stop:
        out[i, j] = grid[k, m]
    return out


def predicted(grid):
    """Where each corner should be, from the others: (rows, columns, 2), NaN unknown.

    The middle of neighbours on both sides, where there are such; else the median of
    lines run on and of parallelograms.
    """
    near = {d: shifted(grid, *d) for d in AXES}
    far = {d: shifted(grid, 2 * d[0], 2 * d[1]) for d in AXES}
    between, beyond = [], []
    for d in ((0, 1), (1, 0)):
        e = -d[0], -d[1]
        plain = (near[d] + near[e]) / 2
        better = (4 * (near[d] + near[e]) - far[d] - far[e]) / 6
        between.append(np.where(np.isfinite(better), better, plain))
    for d in AXES:
        third = shifted(grid, 3 * d[0], 3 * d[1])
        line = 2 * near[d] - far[d]
        curve = line + near[d] - 2 * far[d] + third
        beyond.append(np.where(np.isfinite(curve), curve, line))
    for d in AXES[:2]:
        for e in AXES[2:]:
            corner = shifted(grid, d[0] + e[0], d[1] + e[1])
            beyond.append(near[d] + near[e] - corner)
    inner = _median(between)
    return np.where(np.isfinite(inner), inner, _median(beyond))


def _median(arrays):
    stack = np.stack(arrays)
    known = np.isfinite(stack).all(axis=-1)
    some = known.any(axis=0)
    stack[:, ~some] = 0
    known[:, ~some] = True
    ordered = np.sort(np.where(known[..., None], stack, np.inf), axis=0)
    count = known.sum(axis=0)
    low, high = (count - 1) // 2, count // 2
    pick = [
        np.take_along_axis(ordered, k[None, ..., None], axis=0)[0] for k in (low, high)
    ]
    middle = (pick[0] + pick[1]) / 2
    middle[~some] = np.nan
    return middle


def patches_of(grid):
    """(Patches, rows (N,), columns (N,)) of the corners of a grid that have a shape.

    Neighbours that are missing are predicted; corners alone in their row or column
    have no shape.
    """
    full = np.pad(grid, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
    guess = predicted(full)
    near = np.where(np.isfinite(full), full, guess)
    ring = {d: shifted(near, *d) for d in AXES}
    for d in AXES:
        opposite = ring[-d[0], -d[1]]
        ring[d] = np.where(np.isfinite(ring[d]), ring[d], 2 * full - opposite)
    right, left, below, above = (ring[d] for d in AXES)
    u, v = (right - left) / 2, (below - above) / 2
    uu, vv = (right + left) / 2 - full, (below + above) / 2 - full
    turns = [
        a * b * (shifted(near, a, b) - full - b * u - a * v - uu - vv)
        for a in (-1, 1)
        for b in (-1, 1)
    ]
    w = _mean(turns)
    shape = [full, u, v, uu, vv, w]
    known = np.isfinite(np.concatenate(shape[:5], axis=-1)).all(axis=-1)
    i, j = np.nonzero(known)
    return Patches(*(a[i, j] for a in shape)), i - 1, j - 1


def side_patches_of(grid):
    """As `patches_of`, of corners on the sides, with bends that change as inside.

    `patches_of` gives a corner on a side the bend of the one next to it.
    """
    full = np.pad(grid, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
    for a, b in AXES:
        line = [shifted(full, k * a, k * b) for k in (1, 2, 3, 4)]
        cubic = 4 * line[0] - 6 * line[1] + 4 * line[2] - line[3]
        full = np.where(np.isfinite(full), full, cubic)
    full[1:-1, 1:-1] = grid
    patches, i, j = patches_of(full)
    rows, columns = grid.shape[:2]
    inside = (i > 0) & (i <= rows) & (j > 0) & (j <= columns)
    side = inside & ((i == 1) | (i == rows) | (j == 1) | (j == columns))
    return patches.of(side), i[side] - 1, j[side] - 1


def _mean(arrays):
    stack = np.stack(arrays)
    known = np.isfinite(stack)
    return np.where(known, stack, 0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
