"""Lines instead of rays from one point: relaxed centrality after CGSP (4.4).

A slightly misplaced mirror gives a camera that is almost central. The thesis proposes
to calibrate it as central first, and then to free the rays. Here every pixel has its
own line with four unknowns, against two coordinates on each of three grids or more. The
poses are adjusted with the lines, and the base grid fixes the frame. The residuals are
those of `raxel.calibration.adjust.consistent`: in the grids' planes, whitened with
frozen weights.

The line of a pixel is X(l) = C + B b + l (u + B g), with u its initial direction and B
two axes across it: b, in mm, is its distance from the initial centre. b and g are
eliminated (Schur complement), and 6 (n - 1) unknowns of the poses are left.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.calibration.adjust.bundle import (
    check_shared,
    homogeneous,
    reduced_normal_equations,
)
from raxel.calibration.adjust.consistent import (
    FIRST_DAMPING,
    MAX_DAMPING,
    ConsistentResult,
    is_rounding,
)
from raxel.calibration.adjust.ray_elimination import moved
from raxel.errors import CalibrationError
from raxel.geometry.least_squares import damped_step, descend
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import cross_matrix, pose, rotation_from_vector, transform

BLOCK = 4096  # lines handled at once
MIN_N_GRIDS = 3  # grids of a line that contributes to the poses
# Relative difference of a line's depths: where grids intersect, no line is determined.
MIN_DEPTH_SPREAD = 0.02


class FreeLines(NamedTuple):
    """Hold the lines of N pixels and the adjusted poses, in the base frame.

    Attributes
    ----------
    origins : ndarray, shape (N, 3)
        Point of each line closest to the initial centre, in the plane across its
        initial direction, mm. NaN where a pixel sees fewer than two grids.
    directions : ndarray, shape (N, 3)
        Unit directions, away from the centre; NaN as `origins`.
    T_base_grid : ndarray, shape (n, 4, 4)
        Poses of the grids.
    used : ndarray of bool, shape (N,)
        Whether a line sees three grids or more and contributes to the poses. A line
        that sees two grids is their join.
    offsets : ndarray, shape (N, 2)
        Offsets b on the axes across, mm; NaN where not used, as the next three.
    axes : ndarray, shape (N, 3, 2)
        Axes B across the initial directions.
    offset_covariance : ndarray, shape (N, 2, 2)
        Covariance of b from the noise of the line's own points, mm^2.
    offset_of_poses : ndarray, shape (N, 2, 6 (n - 1))
        Derivatives of b by the poses.
    covariance : ndarray, shape (6 (n - 1), 6 (n - 1))
        Covariance of the poses: for each but the base its rotation vector (rad) and
        translation (mm), both in its own frame.
    noise : float
        Standard deviation of the whitened residuals.
    cost : float
        Sum of the squared whitened residuals.
    degrees_of_freedom : int
        Number of residuals minus number of unknowns.
    converged : bool
        Whether the adjustment converged within the allowed iterations.
    """

    origins: np.ndarray
    directions: np.ndarray
    T_base_grid: np.ndarray
    used: np.ndarray
    offsets: np.ndarray
    axes: np.ndarray
    offset_covariance: np.ndarray
    offset_of_poses: np.ndarray
    covariance: np.ndarray
    noise: float
    cost: float
    degrees_of_freedom: int
    converged: bool


class _Lines(NamedTuple):
    """Pixels that take part: points, whitening, parametrisation of the lines."""

    points: np.ndarray
    whitening: np.ndarray
    centre: np.ndarray
    u: np.ndarray
    axes: np.ndarray
    unknowns: np.ndarray


def relax_centrality(
    points: ArrayLike,
    central: ConsistentResult,
    *,
    iterations: int = 50,
    tolerance: float = 1e-3,
) -> FreeLines:
    """Return a line for every pixel, and the poses, from a central calibration.

    Parameters
    ----------
    points
        (n, N, 2), points of N pixels on n >= 3 grids, mm.
    central
        Result of `adjust_consistent` for the same points. It is the start, and its
        weights are kept.
    iterations
        Largest number of steps.
    tolerance
        The adjustment ends when a step is shorter than this, in standard deviations of
        the result.

    Returns
    -------
    FreeLines
        Lines and poses in the base frame.

    Raises
    ------
    CalibrationError
        A grid shares fewer than three such lines with the others, or there are more
        unknowns than points ("too-few-rays").

    References
    ----------
    Thesis section 4.4.
    """
    points = np.ascontiguousarray(points, float)
    seen = central.whitening[..., 0] > 0
    used = _determined(points, seen, central)
    check_shared(seen & used)
    moving = 6 * (len(points) - 1)
    freedom = int(2 * seen[:, used].sum() - 4 * used.sum()) - moving
    if freedom <= 0:
        raise CalibrationError(
            f"free lines: {used.sum()} pixels see three grids or more; let more pixels "
            "see three grids",
            code="too-few-rays",
        )
    lines = _chosen(points, central, used)
    T, equations, converged = _descend(
        lines, central.T_base_grid, freedom, iterations, tolerance
    )
    result = _result(lines, used, T, equations, freedom, converged)
    _join(points, central, np.count_nonzero(seen, axis=0) == 2, T, result)
    return result


def _determined(points, seen, central):
    """Which pixels see three grids or more, at sufficiently different depths."""
    near, far = np.full(seen.shape[1], np.inf), np.zeros(seen.shape[1])
    for j, T in enumerate(central.T_base_grid):
        p = np.nan_to_num(points[j]) @ T[:3, :2].T + T[:3, 3] - central.centre
        depth = np.linalg.norm(p, axis=1)
        near = np.minimum(near, np.where(seen[j], depth, np.inf))
        far = np.maximum(far, np.where(seen[j], depth, 0.0))
    return (np.count_nonzero(seen, axis=0) >= MIN_N_GRIDS) & (
        far > (1 + MIN_DEPTH_SPREAD) * near
    )


def _chosen(points, central, rays):
    """_Lines of some pixels, initially the central rays."""
    u = central.directions[rays]
    return _Lines(
        points[:, rays],
        central.whitening[:, rays].astype(float),
        central.centre,
        u,
        np.linalg.svd(u[:, None, :])[2][:, 1:].swapaxes(1, 2),
        np.zeros((len(u), 4)),
    )


def _descend(lines, T, freedom, iterations, tolerance):
    """Poses with the best fit of the lines, by Levenberg-Marquardt."""
    for _ in range(2):
        now = _normal_equations(lines, T)
    damping = FIRST_DAMPING
    for _ in range(iterations):
        step = damped_step(now[1], now[2], damping)
        gain = -step @ now[2]
        if gain * freedom <= tolerance**2 * now[0] or is_rounding(step, lines.centre):
            return T, now, True
        trial = _moved(T, step)
        before = lines.unknowns.copy()
        new = _normal_equations(lines, trial)
        if new[0] < now[0]:
            T, now = trial, new
            damping = max(damping / 10, FIRST_DAMPING)
        else:
            lines.unknowns[:] = before
            damping *= 10
            if damping > MAX_DAMPING:
                break
    return T, now, False


def _moved(T, step):
    """Poses moved by R exp([w]x) and t - R s, for steps (w, s) of all but the base."""
    both = step.reshape(-1, 2, 3)
    R = T[1:, :3, :3]
    t = T[1:, :3, 3] - (R @ both[:, 1, :, None])[..., 0]
    moving = pose(R @ rotation_from_vector(both[:, 0]), t)
    return np.concatenate([T[:1], moving])


def _normal_equations(lines, T):
    """Cost, normal matrix, half gradient of the poses; moves the lines by one step."""
    size = 6 * (len(T) - 1)
    cost, normal, gradient = 0.0, np.zeros((size, size)), np.zeros(size)
    for start in range(0, len(lines.u), BLOCK):
        block = slice(start, start + BLOCK)
        own, _, residual = _system(lines, block, T)
        pull = np.einsum("nra,nr->na", own, residual)
        V = np.swapaxes(own, 1, 2) @ own
        lines.unknowns[block] -= np.linalg.solve(V, pull[..., None])[..., 0]
        own, of_poses, residual = _system(lines, block, T)
        V = np.swapaxes(own, 1, 2) @ own
        rows = np.concatenate([of_poses, residual[..., None]], axis=2)
        cross = np.swapaxes(own, 1, 2) @ rows
        flat = rows.reshape(-1, size + 1)
        left = np.einsum("nap,naq->pq", cross, np.linalg.solve(V, cross))
        both = flat.T @ flat - left
        normal += both[:size, :size]
        gradient += both[:size, size]
        cost += np.vdot(residual, residual)
    return float(cost), normal, gradient


def _system(lines, block, T):
    """Jacobians (N, 2 n, 4) of the lines and (N, 2 n, 6 (n - 1)) of the poses, and the
    whitened residuals (N, 2 n); zero where a point is not seen."""
    axes, unknowns = lines.axes[block], lines.unknowns[block, :, None]
    origin = lines.centre + (axes @ unknowns[:, :2])[..., 0]
    along = lines.u[block] + (axes @ unknowns[:, 2:])[..., 0]
    count, grids = len(along), len(T)
    own = np.zeros((count, 2 * grids, 4))
    of_poses = np.zeros((count, 2 * grids, 6 * (grids - 1)))
    residual = np.zeros((count, 2 * grids))
    for j in range(grids):
        rows = slice(2 * j, 2 * j + 2)
        R, w = T[j, :3, :3], lines.whitening[j, block]
        d, c = along @ R, (origin - T[j, :3, 3]) @ R
        m, depth = d[:, :2] / d[:, 2:], -c[:, 2] / d[:, 2]
        q = c[:, :2] - c[:, 2:] * m
        W = np.zeros((count, 2, 2))
        W[:, 0, 0], W[:, 0, 1], W[:, 1, 1] = w.T
        seen = w[:, 0] > 0
        errors = np.where(seen[:, None], q - lines.points[j, block], 0.0)
        residual[:, rows] = np.einsum("nab,nb->na", W, errors)
        A = np.concatenate([np.tile(np.eye(2), (count, 1, 1)), -m[..., None]], axis=2)
        E = W @ A
        across = E @ R.T @ axes
        own[:, rows, :2] = across
        own[:, rows, 2:] = depth[:, None, None] * across
        if j:
            G = cross_matrix(on_plane(q))
            of_poses[:, rows, 6 * j - 6 : 6 * j] = np.concatenate([E @ G, E], axis=2)
    return own, of_poses, residual


def _result(lines, used, T, equations, freedom, converged):
    cost, normal, _ = equations
    variance = cost / freedom
    own, of_poses, _ = _system(lines, slice(None), T)
    V = np.swapaxes(own, 1, 2) @ own
    cross = np.swapaxes(own, 1, 2) @ of_poses
    origins, directions = _of_unknowns(lines)
    return FreeLines(
        _spread(origins, used),
        _spread(directions, used),
        T,
        used,
        _spread(lines.unknowns[:, :2], used),
        _spread(lines.axes, used),
        _spread(variance * np.linalg.inv(V)[:, :2, :2], used),
        _spread(-np.linalg.solve(V, cross)[:, :2], used),
        variance * np.linalg.inv(normal),
        float(np.sqrt(variance)),
        cost,
        freedom,
        converged,
    )


def _spread(values, rays):
    """Values of the chosen pixels among all, NaN for the others."""
    whole = np.full((len(rays), *values.shape[1:]), np.nan)
    whole[rays] = values
    return whole


def _join(points, central, pairs, T, result):
    """The lines of pixels that see two grids: through both points."""
    if not pairs.any():
        return
    lines = _chosen(points, central, pairs)
    for _ in range(4):
        _normal_equations(lines, T)
    result.origins[pairs], result.directions[pairs] = _of_unknowns(lines)


def _of_unknowns(lines):
    """Origins and unit directions (N, 3)."""
    both = lines.unknowns[..., None]
    along = lines.u + (lines.axes @ both[:, 2:])[..., 0]
    origins = lines.centre + (lines.axes @ both[:, :2])[..., 0]
    return origins, along / np.linalg.norm(along, axis=1, keepdims=True)


# Two adjustments with a free centre and inconsistent estimates (4.1.4).
# `adjust_concurrence` is the thesis's third scheme: every ray is the best-fitting line
# of its points, and centre and poses move until the lines pass as close to the centre
# as possible. `adjust_ray_point` is its first scheme with a free centre: rays through
# the centre, and the ray-point distances (4.18). In both, the cost of noise alone
# depends on the parameters. A line through more distant points is extrapolated less,
# and a point's noise has a smaller component across a ray with oblique incidence. So
# centre and poses drift to values with the smallest cost of the noise, and more rays do
# not help. They serve for a comparison with `raxel.calibration.adjust.consistent`, not
# for calibration.


class FreeCentreResult(NamedTuple):
    """Hold the result of an adjustment with a free centre.

    Attributes
    ----------
    centre : ndarray, shape (3,)
        Camera centre in the base frame, mm.
    T_base_grid : ndarray, shape (n, 4, 4)
        Poses of the grids.
    costs : ndarray
        Sums of squared lengths, mm^2, from the initial one on.
    converged : bool
        Whether the adjustment converged within the allowed iterations.
    """

    centre: np.ndarray
    T_base_grid: np.ndarray
    costs: np.ndarray
    converged: bool


def adjust_ray_point(
    points: np.ndarray,
    seen: ArrayLike,
    centre: ArrayLike,
    T_base_grid: ArrayLike,
    *,
    iterations: int = 50,
    tolerance: float = 1e-9,
) -> FreeCentreResult:
    """Return centre and poses that minimise the ray-point distances over directions.

    Parameters
    ----------
    points
        (n, N, 2), points of N rays on n grids, mm.
    seen
        (n, N) bool.
    centre
        (3,), start, base frame.
    T_base_grid
        (n, 4, 4), start. The pose of grid 0, the base, is kept.
    iterations
        Largest number of steps.
    tolerance
        Least share by which the cost falls.

    Returns
    -------
    FreeCentreResult
        Centre, poses and costs.

    Raises
    ------
    CalibrationError
        As `bundle_adjust_fixed_centre`.

    References
    ----------
    Thesis (4.18) and section 4.1.4.
    """
    check_shared(np.asarray(seen, bool))
    q = homogeneous(points, seen)

    def evaluate(state):
        # All grids move, as seen from the centre; the base does not rotate.
        cost, normal, gradient = reduced_normal_equations(q, *state, first=0)
        return cost, lambda: (normal[3:, 3:], gradient[3:])

    def move(state, step):
        # A shift of the points equals the opposite shift of the centre.
        step = step.copy()
        step[:3] *= -1
        step[3:].reshape(-1, 2, 3)[:, 1] *= -1
        return moved(*state, step)

    return _adjusted(evaluate, move, q, centre, T_base_grid, iterations, tolerance)


def adjust_concurrence(
    points: np.ndarray,
    seen: ArrayLike,
    centre: ArrayLike,
    T_base_grid: ArrayLike,
    *,
    iterations: int = 50,
    tolerance: float = 1e-9,
) -> FreeCentreResult:
    """Return centre and poses for which lines fitted to the points pass nearest to it.

    The method minimises the squared distances of the centre from the lines. These have
    the least squared distances to their points. Rays that see fewer than two grids are
    not used.

    Parameters
    ----------
    points, seen, centre, T_base_grid, iterations, tolerance
        As `adjust_ray_point`.

    Returns
    -------
    FreeCentreResult
        Centre, poses and costs.

    Raises
    ------
    CalibrationError
        As `adjust_ray_point`, or the points of a ray coincide ("degenerate-points").

    References
    ----------
    Thesis section 4.1.4, third scheme.
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
            "line fitting: the points of a ray coincide; use grids at different depths",
            code="degenerate-points",
        )
    along = axes[..., 2]
    reach = np.einsum("ni,ni->n", along, middle)
    distance = middle - reach[:, None] * along
    # The line rotates about the other two axes, by its share of the lever arms.
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
