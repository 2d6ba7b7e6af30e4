"""Two adjustments that free the centre and do not come out right (4.1.4).

`adjust_concurrence` is the thesis's third scheme: every ray is the line that fits its
points best, wherever it passes, and centre and poses move until the lines pass as close
to the centre as they can. `adjust_ray_point` is its first scheme with the centre set
free: rays through the centre, and the ray-point distances (4.18).

In both, the cost of noise alone hangs on what is adjusted. A line through points that
are farther apart is extrapolated less, and a point's noise has a smaller part across
a ray that meets its grid aslant. So centre and poses drift to where the noise costs
least, and more rays do not help. They are here to be compared with
`raxel.calibration.adjust.consistent`, not to calibrate with.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.adjust.bundle import (
    check_shared,
    homogeneous,
    reduced_normal_equations,
)
from raxel.calibration.adjust.ray_elimination import moved
from raxel.errors import CalibrationError
from raxel.geometry.damped import descend
from raxel.geometry.poses import transform


class FreeCentreResult(NamedTuple):
    """centre (3,), T_base_grid (n, 4, 4); costs: squared lengths in all, start first;
    converged: whether it came to rest within the iterations allowed."""

    centre: np.ndarray
    T_base_grid: np.ndarray
    costs: np.ndarray
    converged: bool


def adjust_ray_point(
    points, seen, centre, T_base_grid, *, iterations=50, tolerance=1e-9
):
    """Centre, poses and directions that minimise the ray-point distances (4.18).

    points: (n, N, 2) mm; seen: (n, N) bool; centre: (3,) and T_base_grid: (n, 4, 4) the
    start; grid 0, the base, is kept. tolerance: least share by which the cost falls.

    Returns FreeCentreResult. Raises CalibrationError as `bundle_adjust_fixed_centre`.
    """
    check_shared(np.asarray(seen, bool))
    q = homogeneous(points, seen)

    def evaluate(state):
        # All grids move, as seen from the centre; the base does not turn.
        cost, normal, gradient = reduced_normal_equations(q, *state, first=0)
        return cost, lambda: (normal[3:, 3:], gradient[3:])

    def move(state, step):
        # Points that are shifted are a centre that is shifted the other way.
        step = step.copy()
        step[:3] *= -1
        step[3:].reshape(-1, 2, 3)[:, 1] *= -1
        return moved(*state, step)

    return _adjusted(evaluate, move, q, centre, T_base_grid, iterations, tolerance)


def adjust_concurrence(
    points, seen, centre, T_base_grid, *, iterations=50, tolerance=1e-9
):
    """Centre and poses for which lines fitted to each ray's points pass nearest to it.

    Minimises the squared distances of the centre from the lines that have the least
    squared distances to their points. Arguments and result as `adjust_ray_point`; rays
    that see fewer than two grids are not used.
    """
    seen = np.asarray(seen, bool)
    check_shared(seen)
    shared = np.sum(seen, axis=0) >= 2
    q = homogeneous(points[:, shared], seen[:, shared])

    def evaluate(state):
        distance, jacobian = concurrence_system(q, *state)
        rows = jacobian.reshape(distance.size, -1)
        cost = float(np.vdot(distance, distance))
        return cost, lambda: (rows.T @ rows, rows.T @ distance.ravel())

    def move(state, step):
        return moved(*state, step)

    return _adjusted(evaluate, move, q, centre, T_base_grid, iterations, tolerance)


def _adjusted(evaluate, move, q, centre, T_base_grid, iterations, tolerance):
    (centre, T_base_grid), costs, converged = descend(
        evaluate,
        move,
        (np.array(centre, float), np.array(T_base_grid, float)),
        iterations=iterations,
        tolerance=tolerance,
        rounding=1e-26 * np.sum(q**2),
    )
    return FreeCentreResult(centre, T_base_grid, costs, converged)


def concurrence_system(q, centre, T_base_grid):
    """Vectors (N, 3) from the centre to the lines, and Jacobian (N, 3, 6 n - 3).

    q: (n, 3, N) homogeneous points, zero where not seen. Columns: steps of
    `ray_elimination.moved`.
    """
    weight = q[:, 2]
    number = weight.sum(axis=0)
    flat = np.swapaxes(q * [[1.0], [1.0], [0.0]], 1, 2)
    P = transform(T_base_grid, flat) - centre
    middle = np.einsum("jn,jnk->nk", weight, P) / number[:, None]
    arms = weight[..., None] * (P - middle)
    sizes, axes = np.linalg.eigh(np.einsum("jni,jnk->nik", arms, arms))
    if not np.all(sizes[:, 2] > sizes[:, 1]):
        raise CalibrationError(
            "line fitting: the points of a ray are in one place",
            code="degenerate-points",
        )
    along = axes[..., 2]
    reach = np.einsum("ni,ni->n", along, middle)
    distance = middle - reach[:, None] * along
    # The line turns about the other two axes, by its share of what the arms gain.
    gaps = 1.0 / (sizes[:, 2:] - sizes[:, :2])
    turn = (axes[..., :2] * gaps[:, None]) @ np.swapaxes(axes[..., :2], 1, 2)
    of_turn = -reach[:, None, None] * turn
    of_turn -= along[:, :, None] * (distance[:, None] @ turn)
    of_shift = (np.eye(3) - along[:, :, None] * along[:, None]) / number[:, None, None]
    jacobian = np.zeros((len(along), 3, 6 * len(q) - 3))
    for j, arm in enumerate(arms):
        size = np.einsum("ni,ni->n", arm, along)
        by_point = of_shift + size[:, None, None] * of_turn
        by_point += (of_turn @ arm[..., None]) * along[:, None]
        by_point *= weight[j, :, None, None]
        at = 6 * j - 3
        jacobian[..., max(at, 0) : at + 6] = _by_pose(
            by_point @ T_base_grid[j, :3, :3], flat[j]
        )[..., 0 if j else 3 :]
    return distance, jacobian


def _by_pose(by_point, q):
    """Derivatives (N, 3, 6) by a grid's (w, s), from those by its points (N, 3, 3)."""
    x, y = q[:, None, 0], q[:, None, 1]
    v = np.moveaxis(by_point, 2, 0)
    turns = [y * v[2], -x * v[2], x * v[1] - y * v[0]]
    return np.stack([*turns, *-v], axis=-1)
