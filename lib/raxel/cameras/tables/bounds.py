"""Pyramid of bounds over a ray table: cells that may see a point.

The bound of a group of rays is a cone around an axis that contains every direction, and
a ball that contains every origin. A point P at distance L from the centre of the ball
can only be met if the angle between the axis and the direction to P is at most the
angle of the cone plus arcsin(radius of the ball / L).
"""

from typing import NamedTuple

import numba
import numpy as np

# Cells along each side of the groups at the lowest level of the pyramid.
GROUP_SIDE = 4
# Rounding tolerance.
ANGLE_TOL_RAD = 1e-9


class Bounds(NamedTuple):
    """axis (h, w, 3) unit or zero, angle (h, w); centre (h, w, 3) and reach (h, w) of
    the origins, (1, 1, 3) and (1, 1) for a central camera. A group without rays has
    angle -inf."""

    axis: np.ndarray
    angle: np.ndarray
    centre: np.ndarray
    reach: np.ndarray


class BoundPyramid:
    """Bounds of groups of GROUP_SIDE x GROUP_SIDE cells, then of 2 x 2 groups, up to
    one."""

    def __init__(self, table):
        self._table = table
        shape = table.height, table.width
        self._levels = [Bounds(*_foot(*table.rows, *shape))]
        while self._levels[-1].angle.size > 1:
            self._levels.append(_parents(self._levels[-1]))

    def cells(self, points):
        """All pairs (point, cell) that the bounds cannot exclude.

        points: (N, 3). Returns index of the point, u and v of the cell's upper left
        pixel, each (M,). The bounds of single cells are computed on the fly.
        """
        index = np.arange(len(points))
        u = v = np.zeros(len(points), int)
        for level in self._levels[::-1]:
            keep = _may_see(points, index, u, v, *level)
            index, u, v = index[keep], u[keep], v[keep]
            if level is not self._levels[0]:
                index, u, v = _split(index, u, v, 2)
        table = self._table
        index, u, v = _split(index, u, v, GROUP_SIDE)
        keep = _cells_may_see(
            points, index, u, v, *table.rows, table.height, table.width
        )
        return index[keep], u[keep], v[keep]


@numba.njit(cache=True)
def _may_see(points, who, u, v, axis, angle, centre, reach):
    """Which of the groups (u, v) of a level may see points[who]: (M,) bool."""
    height, width = angle.shape
    keep = np.zeros(len(who), np.bool_)
    for i in range(len(who)):
        x, y = u[i], v[i]
        if x < width and y < height:
            at = min(y, reach.shape[0] - 1), min(x, reach.shape[1] - 1)
            bound = _three(axis[y, x]), angle[y, x], _three(centre[at]), reach[at]
            keep[i] = _holds(bound, _three(points[who[i]]))
    return keep


@numba.njit(cache=True)
def _cells_may_see(points, who, u, v, directions, origins, height, width):
    """The same of single cells."""
    keep = np.zeros(len(who), np.bool_)
    for i in range(len(who)):
        x, y = u[i], v[i]
        if x < width - 1 and y < height - 1:
            ends = y, y + 2, x, x + 2
            bound = _enclosed(directions, origins, width, ends)
            keep[i] = _holds(bound, _three(points[who[i]]))
    return keep


@numba.njit(cache=True)
def _holds(bound, point):
    axis, angle, centre, reach = bound
    length, room = _distance(point, centre), np.pi
    x, y, z = point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]
    if reach < length:
        room = np.arcsin(max(reach, 0.0) / length)
        x, y, z = x / length, y / length, z / length
    return _angle((x, y, z), axis) <= angle + room + ANGLE_TOL_RAD


@numba.njit(cache=True)
def _foot(directions, origins, height, width):
    """Bounds of groups of GROUP_SIDE x GROUP_SIDE cells, which share border pixels."""
    rows, columns = -(-(height - 1) // GROUP_SIDE), -(-(width - 1) // GROUP_SIDE)
    axis, angle = np.zeros((rows, columns, 3)), np.zeros((rows, columns))
    central = len(origins) == 1
    shape = (1, 1) if central else (rows, columns)
    centre, reach = np.zeros((*shape, 3)), np.zeros(shape)
    centre[0, 0] = origins[0]
    for y in range(rows):
        for x in range(columns):
            top, left = GROUP_SIDE * y, GROUP_SIDE * x
            down, right = (
                min(top + GROUP_SIDE + 1, height),
                min(left + GROUP_SIDE + 1, width),
            )
            ends = top, down, left, right
            bound = _enclosed(directions, origins, width, ends)
            axis[y, x] = bound[0]
            angle[y, x] = bound[1]
            if not central:
                centre[y, x] = bound[2]
                reach[y, x] = bound[3]
    return axis, angle, centre, reach


@numba.njit(cache=True)
def _enclosed(directions, origins, width, ends):
    """Bound of the rays of pixels from a row and a column to others, without NaN."""
    top, down, left, right = ends
    last = len(origins) - 1
    x = y = z = a = b = c = 0.0
    count = 0
    for v in range(top, down):
        for u in range(left, right):
            at = v * width + u
            if np.isfinite(directions[at, 0]):
                d, o = _three(directions[at]), _three(origins[min(at, last)])
                x, y, z = x + d[0], y + d[1], z + d[2]
                a, b, c = a + o[0], b + o[1], c + o[2]
                count += 1
    if count == 0:
        return (x, y, z), -np.inf, (a, b, c), -np.inf
    length = _distance((x, y, z), (0.0, 0.0, 0.0))
    if length > 0:
        x, y, z = x / length, y / length, z / length
    centre = a / count, b / count, c / count
    angle, reach = -np.inf, -np.inf
    for v in range(top, down):
        for u in range(left, right):
            at = v * width + u
            if np.isfinite(directions[at, 0]):
                angle = max(angle, _angle((x, y, z), _three(directions[at])))
                reach = max(reach, _distance(_three(origins[min(at, last)]), centre))
    # Interpolated directions are in the hull of their corners, which a cone contains
    # only while it is narrower than a half-space.
    if not angle < np.pi / 2:
        angle = np.pi
    return (x, y, z), angle, centre, reach


@numba.njit(cache=True)
def _angle(a, b):
    """Angle between unit vectors by their chord, accurate also when small."""
    return 2 * np.arcsin(min(_distance(a, b) / 2, 1.0))


@numba.njit(cache=True)
def _distance(a, b):
    return np.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@numba.njit(cache=True)
def _three(row):
    return row[0], row[1], row[2]


def _split(who, u, v, side):
    """Each group's side x side members."""
    dv, du = np.divmod(np.arange(side * side), side)
    u = (side * u[:, None] + du).ravel()
    v = (side * v[:, None] + dv).ravel()
    return np.repeat(who, side * side), u, v


def _parents(level):
    """Bounds of 2 x 2 neighbouring groups."""
    height, width = level.angle.shape
    pad = ((0, height % 2), (0, width % 2))

    def quads(field, fill):
        widths = pad + ((0, 0),) * (field.ndim - 2)
        field = np.pad(field, widths, constant_values=fill)
        return np.stack([field[i::2, j::2] for i in (0, 1) for j in (0, 1)])

    axes, angles = quads(level.axis, 0.0), quads(level.angle, -np.inf)
    axis = _unit(axes.sum(axis=0))
    between = np.linalg.norm(axis - axes, axis=-1)
    separation = 2 * np.arcsin(np.minimum(between / 2, 1.0))
    angle = np.minimum((separation + angles).max(axis=0), np.pi)
    if level.reach.shape != level.angle.shape:
        return Bounds(axis, angle, level.centre, level.reach)
    centres, reaches = quads(level.centre, 0.0), quads(level.reach, -np.inf)
    have = np.isfinite(reaches)
    centre = centres.sum(axis=0) / np.maximum(have.sum(axis=0), 1)[..., None]
    reach = (np.linalg.norm(centres - centre, axis=-1) + reaches).max(axis=0)
    return Bounds(axis, angle, centre, reach)


def _unit(vectors):
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)
