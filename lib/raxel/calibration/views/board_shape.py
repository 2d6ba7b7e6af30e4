"""The shape of a board that is not quite flat, or longer one way than stated.

One board is in all photographs, so one shape is. To first order in how far a sheet
leaves its plane it is a quadratic: two bends and a twist. Paper on a bent support bends
without being stretched: what rises draws the rest towards the middle. With r a point
from the board's middle and H the curvatures, that is

    z = r . H r / 2,    shift in the plane = -z H r / 3,

which for a cylinder keeps lengths along the sheet to the third order. Apart from this a
board may be longer along x against y than it is said to be, by the printer's or the
monitor's doing. That it is larger both ways no photograph of it tells.
"""

from typing import NamedTuple

import numpy as np

from raxel.geometry.planes import on_plane

BENDS = ("bend_x", "bend_y", "twist")
TERMS = (*BENDS, "stretch")


class BoardShape(NamedTuple):
    """middle (2,) and half (2,), of its sides, in the board's unit, and values (4,).

    The values: bend_x and bend_y, how far the ends of x and of y lie behind the middle,
    along z; twist, how far the corner where x and y end does beyond these, all in the
    board's unit; stretch, how much longer x is against y, 0.01 being 1 %.
    """

    middle: np.ndarray
    half: np.ndarray
    values: np.ndarray

    def points(self, flat):
        """Points (..., 2), as stated, of the board where they are, (..., 3)."""
        return shaped(flat, self)[0]

    def seen_on_plane(self, flat, directions):
        """Where rays that see points (N, 2) of the board meet the plane z = 0, (N, 2);
        directions: (N, 3), in the frame of the board."""
        placed = self.points(flat)
        return placed[:, :2] - placed[:, 2:] * directions[:, :2] / directions[:, 2:]


def board_points(flat, shape):
    """Points (..., 3) of stated ones (..., 2): of a BoardShape, of a plane for None."""
    return on_plane(flat) if shape is None else shape.points(flat)


def shaped(flat, shape):
    """Points (..., 3) of a BoardShape for stated ones (..., 2), and how they move with
    its values, (..., 3, 4)."""
    r = np.asarray(flat, float) - shape.middle
    (bend_x, bend_y, twist, stretch), (a, b) = shape.values, shape.half
    x, y = r[..., 0] / a, r[..., 1] / b
    z = bend_x * x**2 + bend_y * y**2 + twist * x * y
    z_by = np.stack([x**2, y**2, x * y], axis=-1)
    # H r, by its parts: 2 / a^2, 1 / (a b) and 2 / b^2 of the bends and the twist.
    zero = np.zeros_like(x)
    slope_by = np.stack(
        [
            np.stack([2 * x / a, zero, y / a], axis=-1),
            np.stack([zero, 2 * y / b, x / b], axis=-1),
        ],
        axis=-2,
    )
    slope = slope_by @ np.array([bend_x, bend_y, twist])
    wider = r * np.array([stretch / 2, -stretch / 2])
    points = on_plane(np.asarray(flat, float) + wider - z[..., None] * slope / 3)
    points[..., 2] = z
    by_values = np.zeros((*points.shape, 4))
    by_values[..., :2, :3] = (
        -(z_by[..., None, :] * slope[..., None] + z[..., None, None] * slope_by) / 3
    )
    by_values[..., 2, :3] = z_by
    by_values[..., 0, 3], by_values[..., 1, 3] = r[..., 0] / 2, -r[..., 1] / 2
    return points, by_values
