"""A pyramid of bounds over a ray table: which cells may see a point.

The bound of a group of rays is a cone, around an axis, that holds every direction, and
a ball that holds every origin. A point P at distance L from the centre of the ball can
only be met if the angle between the axis and the direction to P is at most the angle
of the cone plus arcsin(radius of the ball / L).
"""

from typing import NamedTuple

import numpy as np

# Cells along each side of the groups at the foot of the pyramid.
SIDE = 4
# Room for rounding, in radians.
SLACK = 1e-9
BLOCK = 1 << 12


class Bounds(NamedTuple):
    """axis (..., 3) unit or zero, angle (...); centre (..., 3) and reach (...) of the
    origins, or None for a central camera. A group without rays has angle -inf."""

    axis: np.ndarray
    angle: np.ndarray
    centre: np.ndarray | None
    reach: np.ndarray | None

    def at(self, *index):
        return Bounds(*(None if field is None else field[index] for field in self))


class BoundPyramid:
    """Bounds of groups of SIDE x SIDE cells, then of 2 x 2 groups, up to the whole."""

    def __init__(self, table):
        self._table = table
        self._levels = [self._foot()]
        while self._levels[-1].angle.size > 1:
            self._levels.append(_parents(self._levels[-1]))

    def cells(self, points):
        """All pairs (point, cell) that the bounds cannot exclude.

        points: (N, 3). Returns index of the point, u and v of the cell's upper left
        pixel, each (M,). The bounds of single cells are taken on the way.
        """
        who = np.arange(len(points))
        u = v = np.zeros(len(points), int)
        for level in self._levels[::-1]:
            height, width = level.angle.shape
            keep = (u < width) & (v < height)
            who, u, v = who[keep], u[keep], v[keep]
            keep = self._may_see(points[who], level.at(v, u))
            who, u, v = who[keep], u[keep], v[keep]
            if level is not self._levels[0]:
                who, u, v = _split(who, u, v, 2)
        found = [
            self._cells_of_groups(points, *(k[i : i + BLOCK] for k in (who, u, v)))
            for i in range(0, max(len(who), 1), BLOCK)
        ]
        return tuple(np.concatenate(column) for column in zip(*found, strict=True))

    def _cells_of_groups(self, points, who, u, v):
        who, u, v = _split(who, u, v, SIDE)
        keep = (u < self._table.width - 1) & (v < self._table.height - 1)
        who, u, v = who[keep], u[keep], v[keep]
        one = np.ones(len(u), int)
        bounds = _enclose(*self._table.corners(u, v, one, one))
        keep = self._may_see(points[who], bounds)
        return who[keep], u[keep], v[keep]

    def _may_see(self, points, bounds):
        if bounds.centre is None:
            far, room = points - self._table.origins, 0.0
        else:
            far = points - bounds.centre
        length = np.linalg.norm(far, axis=-1)
        if bounds.centre is not None:
            ratio = np.maximum(bounds.reach, 0) / np.where(length > 0, length, 1.0)
            room = np.where(
                bounds.reach < length, np.arcsin(np.minimum(ratio, 1)), np.pi
            )
        far = far / np.where(length > 0, length, 1.0)[..., None]
        return _angle(far, bounds.axis) <= bounds.angle + room + SLACK

    def _foot(self):
        table = self._table
        rows = -(-(table.height - 1) // SIDE)
        columns = -(-(table.width - 1) // SIDE)
        offset = np.arange(SIDE + 1)
        u = np.minimum(SIDE * np.arange(columns)[:, None] + offset, table.width - 1)
        parts = []
        for row in range(rows):
            v = np.minimum(SIDE * row + offset, table.height - 1)
            # (columns, 5, 5) pixels of the groups in this row, their borders shared.
            place = (v[None, :, None], u[:, None, :])
            flat = (columns, -1, 3)
            directions = table.directions[place].reshape(flat)
            origins = None if table.central else table.origins[place].reshape(flat)
            parts.append(_enclose(directions, origins))
        fields = zip(*parts, strict=True)
        return Bounds(*(None if f[0] is None else np.stack(f) for f in fields))


def _split(who, u, v, side):
    """Each group's side x side members."""
    dv, du = np.divmod(np.arange(side * side), side)
    u = (side * u[:, None] + du).ravel()
    v = (side * v[:, None] + dv).ravel()
    return np.repeat(who, side * side), u, v


def _angle(a, b):
    """Angle between unit vectors by their chord, accurate also when small."""
    chord = np.linalg.norm(a - b, axis=-1)
    return 2 * np.arcsin(np.minimum(chord / 2, 1.0))


def _unit(vectors):
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)


def _enclose(directions, origins):
    """Bounds (n,) of n groups of k rays (n, k, 3); rays that are NaN do not count."""
    have = np.isfinite(directions[..., 0])
    directions = np.where(have[..., None], directions, 0.0)
    axis = _unit(directions.sum(axis=1))
    angle = np.where(have, _angle(axis[:, None], directions), -np.inf).max(axis=1)
    # Interpolated directions lie in the hull of their corners, which a cone is sure
    # to hold only while it is narrower than a half-space.
    angle = np.where(angle < np.pi / 2, angle, np.where(angle > 0, np.pi, angle))
    if origins is None:
        return Bounds(axis, angle, None, None)
    origins = np.where(have[..., None], origins, 0.0)
    centre = origins.sum(axis=1) / np.maximum(have.sum(axis=1), 1)[:, None]
    distance = np.linalg.norm(origins - centre[:, None], axis=-1)
    reach = np.where(have, distance, -np.inf).max(axis=1)
    return Bounds(axis, angle, centre, reach)


def _parents(level):
    """Bounds of 2 x 2 neighbouring groups."""
    height, width = level.angle.shape
    pad = ((0, height % 2), (0, width % 2))

    def quads(field, fill):
        if field is None:
            return None
        widths = pad + ((0, 0),) * (field.ndim - 2)
        field = np.pad(field, widths, constant_values=fill)
        return np.stack([field[i::2, j::2] for i in (0, 1) for j in (0, 1)])

    axes, angles = quads(level.axis, 0.0), quads(level.angle, -np.inf)
    axis = _unit(axes.sum(axis=0))
    angle = np.minimum((_angle(axis, axes) + angles).max(axis=0), np.pi)
    if level.centre is None:
        return Bounds(axis, angle, None, None)
    centres, reaches = quads(level.centre, 0.0), quads(level.reach, -np.inf)
    have = np.isfinite(reaches)
    centre = centres.sum(axis=0) / np.maximum(have.sum(axis=0), 1)[..., None]
    reach = (np.linalg.norm(centres - centre, axis=-1) + reaches).max(axis=0)
    return Bounds(axis, angle, centre, reach)
