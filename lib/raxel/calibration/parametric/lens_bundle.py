"""Bundle adjustment of a lens model and the poses of boards, by reprojection error.

Levenberg-Marquardt on the normal equations after elimination of the poses (Schur
complement): each board's pose has its own block of six, and only the few parameters of
the model are common to all boards. A step of a pose is X' = exp([w]x) R X + t + s, in
the camera frame. The shape of the board, common to all images, may be among the
parameters (`raxel.calibration.views.correspondence`).

The loss is quadratic for small residuals. Outliers, relative to the scale of the
residuals, have a reduced weight (Cauchy's loss, at the start) or none (Tukey's, at the
end). A wrong model shifts all corners of a board alike, so each board has its own
scale: at least that of all boards, and at most a few times it. Source: Huber and
Ronchetti, Robust Statistics, 2009.
"""

import math
from typing import NamedTuple

import numba
import numpy as np

from raxel.calibration.views.correspondence import TERMS, BoardShape, shaped
from raxel.cameras.lenses.fisheye import KannalaBrandtCamera
from raxel.cameras.lenses.moving_pupil import (
    MovingPupilCamera,
    pupil_heights,
    sight_angle,
)
from raxel.cameras.lenses.rational import UnifiedSphereCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.poses import rotate, rotation_from_vector, transform

# Pixels of points under a lens model, and their derivatives. A point X of the camera
# frame is seen at the angle theta to the axis z from the pupil at height z0(theta) on
# it: (z - z0) sin theta = rho cos theta, with rho its distance from the axis. With e
# the unit vector across the axis towards X, the model is p = s(theta) e, q = p (1 + k1
# s^2 + k2 s^4 + ...) + d(p), pixel = (fx q_x + cx, fy q_y + cy), z0 = a1 theta^2 + a2
# theta^4 + ... The base s is theta (Kannala and Brandt) or (1 + xi) sin theta / (cos
# theta + xi) (unified sphere). Both are theta near the axis, so xi changes neither the
# focal length nor the size of the other terms there. A perspective lens is the unified
# sphere with xi = 0, s = tan theta. If xi and the radial terms are free they are
# strongly correlated, and no fit converges to xi = 0. With (x, y) = p, the decentring d
# combines Brown's terms and those of a thin prism, d = (2 p1 x y + p2 (s^2 + 2 x^2) +
# s1 s^2, p1 (s^2 + 2 y^2) + 2 p2 x y + s2 s^2): all terms that grow with s^2 and have
# the period of one turn in azimuth. Sources: Brown 1971, Photogrammetric Engineering
# 37(8); Weng, Cohen and Herniou 1992, doi:10.1109/34.159901.


N_FRAME_PARAMETERS = 4  # fx, fy, cx, cy come first
MAX_XI = 100.0  # a fisheye has 2 or 3; larger values change the image by less than 1 %
AXIS_TOL = 1e-9  # as a fraction of the distance: nearer points count as on the axis


class LensFormula(NamedTuple):
    """Terms of a lens model.

    base: "kannala-brandt", "unified", or "perspective", the unified sphere with xi
    fixed at 0; radial: number of terms k; decentring: 0, 2 (p1, p2) or 4 (s1, s2, too);
    pupil: number of terms of z0, 0 for a central lens; board: fitted values of a
    BoardShape, by name, in order.

    The parameters form one vector (P,): fx, fy, cx, cy; xi of the unified base; k; the
    decentring; a; the board's. Lengths are in the board's unit.
    """

    base: str
    radial: int
    decentring: int
    pupil: int
    board: tuple = ()

    @property
    def names(self):
        """Names of the parameters, in order."""
        names = ["fx", "fy", "cx", "cy"]
        names += ["xi"] * (self.base == "unified")
        names += [f"k{j + 1}" for j in range(self.radial)]
        names += ["p1", "p2", "s1", "s2"][: self.decentring]
        names += [f"a{j + 1}" for j in range(self.pupil)]
        return names + list(self.board)

    def parts(self, values):
        """(xi, k, (p1, p2, s1, s2), a) of a vector (P,); xi is None for a base without
        it."""
        xi = 0.0 if self.base == "perspective" else None
        first = N_FRAME_PARAMETERS
        if self.base == "unified":
            xi, first = values[N_FRAME_PARAMETERS], N_FRAME_PARAMETERS + 1
        off_axis = first + self.radial
        pupil = off_axis + self.decentring
        decentring = np.zeros(4)
        decentring[: self.decentring] = values[off_axis:pupil]
        a = values[pupil : pupil + self.pupil]
        return xi, values[first:off_axis], decentring, a

    def moved_to(self, other, values):
        """Vector of another model of the same base; missing terms are dropped, new ones
        are 0."""
        known = dict(zip(self.names, values, strict=True))
        return np.array([known.get(name, 0.0) for name in other.names])

    def bounded(self, values):
        """Vector with xi clipped to the range of a unified sphere."""
        if self.base == "unified" and not 0 <= values[N_FRAME_PARAMETERS] <= MAX_XI:
            values = values.copy()
            values[N_FRAME_PARAMETERS] = np.clip(values[N_FRAME_PARAMETERS], 0, MAX_XI)
        return values

    def camera(self, values, width, height):
        """Camera of parameters (P,); CalibrationError where none exists."""
        xi, k, decentring, a = self.parts(values)
        fx, fy, cx, cy = values[:N_FRAME_PARAMETERS]
        off_axis = {"tangential": decentring[:2], "prism": decentring[2:]}
        try:
            if xi is None:
                terms = np.concatenate([[1.0], k if len(k) else [0.0]])
                lens = KannalaBrandtCamera(
                    terms, (fx, fy), (cx, cy), width, height, **off_axis
                )
            else:
                # The camera's own base is smaller by this factor.
                scale = 1 + xi
                K = [[scale * fx, 0, cx], [0, scale * fy, cy], [0, 0, 1]]
                k = k * scale ** (2.0 * np.arange(1, len(k) + 1))
                off_axis = {name: scale * terms for name, terms in off_axis.items()}
                lens = UnifiedSphereCamera(xi, K, width, height, k, **off_axis)
            return MovingPupilCamera(lens, a) if len(a) else lens
        except InputError as fault:
            raise CalibrationError(
                f"{self.base}: no camera has the fitted parameters ({fault}); check "
                "the corners, or give more boards",
                code="no-camera",
            ) from None


class Imaged(NamedTuple):
    """pixels (N, 2), NaN outside the model; derivatives by_values (N, 2, P), 0 for the
    board's values, and by_points (N, 2, 3)."""

    pixels: np.ndarray
    by_values: np.ndarray
    by_points: np.ndarray


def imaged_points(formula, values, points, derivatives=True):
    """Pixels of points (N, 3) under a model, with derivatives (Imaged), or without, as
    pixels (N, 2) alone."""
    xi, k, decentring, a = formula.parts(values)
    count = len(points) if derivatives else 0
    pixels, by_points = np.empty((len(points), 2)), np.empty((count, 2, 3))
    by_values = np.zeros((count, 2, len(values)))
    _image(
        points, tuple(values[:N_FRAME_PARAMETERS]), xi, k, tuple(decentring), a,
        formula.base == "unified", formula.decentring, pixels, by_values, by_points,
    )  # fmt: skip
    return Imaged(pixels, by_values, by_points) if derivatives else pixels


@numba.njit(cache=True, error_model="numpy")
def _image(
    points, frame, xi, k, decentring, a, free_xi, n_decentring, pixels, by_values,
    by_points,
):  # fmt: skip
    """Write the pixels, and the derivatives if there is space for them."""
    fx, fy, cx, cy = frame
    p1, p2, s1, s2 = decentring
    for n in range(len(points)):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        rho = max(math.hypot(x, y), AXIS_TOL * abs(z))
        unit_x, unit_y = x / rho, y / rho
        theta = sight_angle(rho, z, a)
        s, slope, s_by_xi = _base(theta, xi)
        x, y = s * unit_x, s * unit_y
        squared = x * x + y * y
        factor, change = 0.0, 0.0
        for term in k[::-1]:
            change = change * squared + factor
            factor = factor * squared + term
        factor, change = 1 + factor * squared, 2 * (factor + change * squared)
        by_decentring = (
            (2 * x * y, squared + 2 * x * x, squared, 0.0),
            (squared + 2 * y * y, 2 * x * y, 0.0, squared),
        )
        q_x, q_y = factor * x, factor * y
        for j in range(4):
            q_x += by_decentring[0][j] * decentring[j]
            q_y += by_decentring[1][j] * decentring[j]
        pixels[n, 0], pixels[n, 1] = fx * q_x + cx, fy * q_y + cy
        if len(by_points) == 0:
            continue
        by_values[n, 0, 0], by_values[n, 1, 1] = q_x, q_y
        by_values[n, 0, 2] = by_values[n, 1, 3] = 1.0
        sine, cosine = math.sin(theta), math.cos(theta)
        z0, z0_slope = pupil_heights(theta, a)
        rise = (z - z0) * cosine + (rho - z0_slope) * sine
        across = change * x * y + 2 * p1 * x + 2 * p2 * y
        by_p = (
            (
                factor + change * x * x + 2 * p1 * y + 6 * p2 * x + 2 * s1 * x,
                across + 2 * s1 * y,
            ),
            (
                across + 2 * s2 * x,
                factor + change * y * y + 6 * p1 * y + 2 * p2 * x + 2 * s2 * y,
            ),
        )
        for c in range(2):
            focal, (by_x, by_y) = frame[c], by_p[c]
            # p moves radially with theta, tangentially with the azimuth.
            radial = focal * (by_x * unit_x + by_y * unit_y)
            tangential = focal * (by_y * unit_x - by_x * unit_y) * s / rho
            by_rho = radial * slope * cosine / rise
            by_height = radial * slope * sine / rise
            by_points[n, c, 0] = by_rho * unit_x - tangential * unit_y
            by_points[n, c, 1] = by_rho * unit_y + tangential * unit_x
            by_points[n, c, 2] = -by_height
            own, first = by_values[n, c, N_FRAME_PARAMETERS:], int(free_xi)
            if free_xi:
                own[0] = radial * s_by_xi
            for j in range(len(k)):
                own[first + j] = focal * (x, y)[c] * squared ** (j + 1)
            for j in range(n_decentring):
                own[first + len(k) + j] = focal * by_decentring[c][j]
            for j in range(len(a)):
                own[first + len(k) + n_decentring + j] = by_height * theta ** (
                    2 * j + 2
                )


@numba.njit(cache=True, error_model="numpy")
def _base(theta, xi):
    """s, ds/dtheta and ds/dxi at an angle; NaN beyond the edge of the sphere."""
    if xi is None:
        return theta, 1.0, 0.0
    sine, depth = math.sin(theta), math.cos(theta) + xi
    if not depth > 0:
        return np.nan, np.nan, np.nan
    slope = (1 + xi) * (1 + xi * math.cos(theta)) / depth**2
    by_xi = sine * (math.cos(theta) - 1) / depth**2
    return (1 + xi) * sine / depth, slope if slope > 0 else np.nan, by_xi


RAYLEIGH_MEDIAN = 1.1774  # median distance at unit standard deviation per coordinate
OUTLIER_SCALES = 6.0  # scales beyond which a corner is an outlier
MAX_SCALE_RATIO = 5.0  # scale of a board over that of all boards
MIN_SCALE_PX = 0.01  # highest accuracy of a corner
ROUNDING_PX = 1e-7
MAX_N_STEPS, COST_TOL = 40, 1e-6
MIN_DAMPING, CONVERGED_DAMPING, MAX_DAMPING = 1e-13, 1e-8, 1e10
MAX_N_ROUNDS, SCALE_TOL = 4, 0.05  # of the scales
N_POSE_STEPS = 20


class StackedBoards(NamedTuple):
    """pixels (n, M, 2), points (n, M, 3) with z = 0, seen (n, M) bool; outline (2, 2):
    centre of all boards' points and half of their extent along x and y; copies (n,):
    equal numbers for near copies."""

    pixels: np.ndarray
    points: np.ndarray
    seen: np.ndarray
    outline: np.ndarray
    copies: np.ndarray

    def some(self, chosen):
        """The chosen boards, (n,) bool."""
        parts = (part[chosen] for part in self[:3])
        return StackedBoards(*parts, self.outline, self.copies[chosen])

    @property
    def groups(self):
        """(n,): index of each board's group of near copies, from 0."""
        return np.unique(self.copies, return_inverse=True)[1]

    def of_groups(self, values):
        """Sums (G, ...) over each group of values (n, ...) of boards."""
        groups = self.groups
        summed = np.zeros((groups.max() + 1, *values.shape[1:]))
        np.add.at(summed, groups, values)
        return summed

    def shape(self, formula, values):
        """BoardShape of a model's parameters (P,); missing values are 0."""
        known = dict(zip(formula.names, values, strict=True))
        return BoardShape(*self.outline, np.array([known.get(n, 0.0) for n in TERMS]))

    def placed(self, formula, values):
        """Points (n, M, 3) of the board with the shape of the parameters."""
        if not formula.board:
            return self.points
        return self.shape(formula, values).points(self.points[..., :2])


class AdjustedLens(NamedTuple):
    """values (P,), T_camera_grid (n, 4, 4); residuals (n, M, 2) px, detected minus
    projected, NaN where not seen; scales (n,), px per coordinate, for the loss; cost:
    the loss, px^2; normal (P, P): normal matrix after elimination of the poses."""

    values: np.ndarray
    T_camera_grid: np.ndarray
    residuals: np.ndarray
    scales: np.ndarray
    cost: float
    normal: np.ndarray


def stacked(corners, copies=None):
    """StackedBoards of (pixels, points) pairs, (N, 2) each; copies: groups as numbered
    by `near_copies`, None without near copies."""
    most = max(len(pixels) for pixels, _ in corners)
    found = np.zeros((len(corners), most, 2))
    points, seen = np.zeros((len(corners), most, 3)), np.zeros(found.shape[:2], bool)
    for k, (pixels, flat) in enumerate(corners):
        found[k, : len(pixels)], points[k, : len(pixels), :2] = pixels, flat
        seen[k, : len(pixels)] = True
        # Unseen corners need a finite position; their weight is zero.
        points[k, len(pixels) :, :2] = flat[0]
    ends = points[seen].min(axis=0)[:2], points[seen].max(axis=0)[:2]
    outline = np.array([(ends[1] + ends[0]) / 2, (ends[1] - ends[0]) / 2])
    copies = np.arange(len(corners)) if copies is None else copies
    return StackedBoards(found, points, seen, outline, copies)


def adjusted(formula, values, T_camera_grid, boards, loss, scales=None):
    """AdjustedLens: parameters and poses, from a start at which all points are imaged.

    loss: "cauchy" or "tukey"; scales: (n,) px, of the loss; None for those of the
    residuals, which are updated until they converge.
    """
    values, T = np.array(values, float), np.array(T_camera_grid, float)
    residuals = _residuals(formula, values, T, boards)
    fixed = scales is not None
    for _ in range(1 if fixed else MAX_N_ROUNDS):
        before = scales if fixed else scales_of(residuals)
        values, T, residuals, cost, normal = _minimised(
            formula, values, T, boards, loss, before
        )
        scales = before if fixed else scales_of(residuals)
        if np.all(np.abs(scales - before) < SCALE_TOL * before):
            break
    return AdjustedLens(values, T, residuals, before, cost, normal)


def start_without(formula, narrower, found, boards):
    """Start (values, poses) of a model with some of the terms of an AdjustedLens: that
    of smaller loss without a change of the others, or with the change that is best to
    first order.

    Terms may compensate each other, as a decentring does a shift of the centre and
    rotations of all boards. If only the terms change, the corners move so far that the
    loss counts them as outliers.
    """
    values, T, scales = found.values, found.T_camera_grid, found.scales
    system = _system(formula, values, T, boards, "tukey", scales)
    normal, _, solved, size, sizes = _reduced(system, MIN_DAMPING)
    kept = np.array([name in narrower.names for name in formula.names])
    step = -values * size
    step[kept] = -np.linalg.lstsq(
        normal[np.ix_(kept, kept)], normal[np.ix_(kept, ~kept)] @ step[~kept], 1e-15
    )[0]
    moved = values + step / size, _moved(T, -(solved[..., :-1] @ step) / sizes)
    starts = [(formula.moved_to(narrower, v), P) for v, P in ((values, T), moved)]

    def loss(start):
        residuals = _residuals(narrower, *start, boards)
        return _costs(residuals, boards, "tukey", scales).sum()

    return min(starts, key=loss)


def posed_residuals(formula, values, T_camera_grid, boards):
    """Residuals (n, M, 2) px at the poses with the smallest loss for given parameters,
    starting from T_camera_grid."""
    T = np.array(T_camera_grid, float)
    residuals = _residuals(formula, values, T, boards)
    scales = scales_of(residuals)
    cost = _costs(residuals, boards, "tukey", scales)
    damping = np.full(len(T), 1e-3)
    for _ in range(N_POSE_STEPS):
        _, normal, _, _, gradient = _system(formula, values, T, boards, "tukey", scales)
        size = np.sqrt(np.maximum(np.diagonal(normal, axis1=1, axis2=2), 1e-300))
        damped = normal / (size[:, :, None] * size[:, None])
        damped += damping[:, None, None] * np.eye(6)
        moves = np.linalg.solve(damped, (gradient / size)[..., None])[..., 0] / size
        trial = _moved(T, moves)
        new = _costs(
            _residuals(formula, values, trial, boards), boards, "tukey", scales
        )
        better = new < cost
        T = np.where(better[:, None, None], trial, T)
        at_rest = np.all(~better | (new > (1 - 1e-4) * cost))
        cost = np.where(better, new, cost)
        damping = np.where(better, damping / 10, damping * 10)
        if at_rest:
            break
    return _residuals(formula, values, T, boards)


def scales_of(residuals):
    """Standard deviation (n,) px of a coordinate for each board, from the median
    distance (robust)."""
    distances = np.linalg.norm(residuals, axis=-1)
    whole = max(np.nanmedian(distances) / RAYLEIGH_MEDIAN, MIN_SCALE_PX)
    own = np.nanmedian(distances, axis=1) / RAYLEIGH_MEDIAN
    return np.clip(own, whole, MAX_SCALE_RATIO * whole)


def distance_loss(squares, scales, loss):
    """(loss, weight) of squared distances (n, M) px^2: the loss is quadratic near 0,
    the weight its derivative."""
    squares_of = scales[:, None] ** 2
    if loss == "cauchy":
        width = (OUTLIER_SCALES / 2) ** 2 * squares_of
        return width * np.log1p(squares / width), 1 / (1 + squares / width)
    width = OUTLIER_SCALES**2 * squares_of
    left = np.maximum(1 - squares / width, 0.0)
    return width / 3 * (1 - left**3), left**2


def tukey_pull(squares, scales):
    """(weight, slope), (n, M) each, of Tukey's loss at squared distances px^2: the
    gradient is weight times distance, and slope its derivative with the distance, mean
    of both coordinates; 0 for outliers."""
    left = np.maximum(1 - squares / (OUTLIER_SCALES * scales[:, None]) ** 2, 0.0)
    return left**2, left * (3 * left - 2)


def _minimised(formula, values, T, boards, loss, scales):
    residuals = _residuals(formula, values, T, boards)
    cost, damping = _costs(residuals, boards, loss, scales).sum(), 1e-4
    rounding = np.count_nonzero(boards.seen) * ROUNDING_PX**2
    system = _system(formula, values, T, boards, loss, scales)
    for _ in range(MAX_N_STEPS):
        step, moves = _step(system, damping)
        new_values, new_T = formula.bounded(values + step), _moved(T, moves)
        new = _residuals(formula, new_values, new_T, boards)
        new_cost = _costs(new, boards, loss, scales).sum()
        if new_cost < cost:
            # A small step under strong damping does not mean convergence.
            at_rest = cost - new_cost < COST_TOL * cost and damping < CONVERGED_DAMPING
            values, T, residuals, cost = new_values, new_T, new, new_cost
            damping = max(damping / 30, MIN_DAMPING)
            system = _system(formula, values, T, boards, loss, scales)
            if at_rest or cost < rounding:
                break
        else:
            damping *= 30
            if damping > MAX_DAMPING:
                break
    normal, _, _, size, _ = _reduced(system, MIN_DAMPING)
    return values, T, residuals, cost, normal * np.outer(size, size)


def _residuals(formula, values, T, boards):
    points = transform(T, boards.placed(formula, values))
    shape = boards.pixels.shape
    seen = imaged_points(formula, values, points.reshape(-1, 3), derivatives=False)
    return np.where(boards.seen[..., None], boards.pixels - seen.reshape(shape), np.nan)


def _costs(residuals, boards, loss, scales):
    """Loss (n,) of each board; infinite where the model does not image a point."""
    squares = np.where(boards.seen, np.sum(residuals**2, axis=2), 0.0)
    return np.sum(
        np.where(np.isnan(squares), np.inf, distance_loss(squares, scales, loss)[0]),
        axis=1,
    )


def board_information(formula, values, T_camera_grid, boards, scales):
    """Information of each board, with a free pose, on the parameters: normal (n, P, P)
    and gradient (n, P) of the final loss."""
    A, B, b = _rows(formula, values, T_camera_grid, boards, "tukey", scales)
    # An orthonormal basis of the pose directions keeps the digits of small rows.
    basis, _ = np.linalg.qr(A)
    B = B - basis @ (np.swapaxes(basis, 1, 2) @ B)
    Bt = np.swapaxes(B, 1, 2)
    return Bt @ B, (Bt @ b)[..., 0]


def _system(formula, values, T, boards, loss, scales):
    """Normal blocks of model, boards and both, and their gradients."""
    A, B, b = _rows(formula, values, T, boards, loss, scales)
    At = np.swapaxes(A, 1, 2)
    flat = B.reshape(-1, B.shape[2])
    return flat.T @ flat, At @ A, At @ B, flat.T @ b.ravel(), (At @ b)[..., 0]


def _rows(formula, values, T, boards, loss, scales):
    """Weighted changes of pixels with poses (n, 2M, 6) and parameters (n, 2M, P), and
    weighted residuals (n, 2M, 1)."""
    n, count = boards.seen.shape
    turned = rotate(T, boards.placed(formula, values))
    points = turned + T[:, None, :3, 3]
    seen = imaged_points(formula, values, points.reshape(-1, 3))
    errors = boards.pixels - seen.pixels.reshape(n, count, 2)
    _, weight = distance_loss(np.sum(errors**2, axis=2), scales, loss)
    weight = np.where(boards.seen, weight, 0.0) ** 0.5
    by_values = seen.by_values.reshape(n, count, 2, -1)
    by_shape = np.zeros((n, count, 3, 0))
    if formula.board:
        shape = boards.shape(formula, values)
        of_shape = [TERMS.index(name) for name in formula.board]
        by_shape = shaped(boards.points[..., :2], shape)[1][..., of_shape]
    by_points = seen.by_points.reshape(n, count, 2, 3)
    by_pose = _weighted(turned, T, by_points, by_shape, weight, by_values)
    b = np.where(boards.seen[..., None], errors * weight[..., None], 0.0)
    return (
        by_pose.reshape(n, 2 * count, 6), by_values.reshape(n, 2 * count, -1),
        b.reshape(n, 2 * count, 1),
    )  # fmt: skip


@numba.njit(cache=True)
def _weighted(turned, T, by_points, by_shape, weight, by_values):
    """Weighted changes of pixels with poses (n, M, 2, 6); those with the board's shape
    are written to by_values (n, M, 2, P), and weights applied to it; 0 for unknown
    ones. by_shape (n, M, 3, S): change of points on the board."""
    by_pose = np.zeros((*weight.shape, 2, 6))
    first = by_values.shape[3] - by_shape.shape[3]
    for n, m in np.ndindex(weight.shape):
        x, y, z = turned[n, m, 0], turned[n, m, 1], turned[n, m, 2]
        for c in range(2):
            own = by_points[n, m, c]
            u, v, w = own[0], own[1], own[2]
            for i in range(3):
                along = u * T[n, 0, i] + v * T[n, 1, i] + w * T[n, 2, i]
                for j in range(by_shape.shape[3]):
                    by_values[n, m, c, first + j] += along * by_shape[n, m, i, j]
            turn = y * w - z * v, z * u - x * w, x * v - y * u
            for j in range(3):
                by_pose[n, m, c, j] = weight[n, m] * turn[j]
                by_pose[n, m, c, 3 + j] = weight[n, m] * own[j]
            by_values[n, m, c] *= weight[n, m]
            for row in (by_pose[n, m, c], by_values[n, m, c]):
                for j in range(len(row)):
                    row[j] = row[j] if math.isfinite(row[j]) else 0.0
    return by_pose


def _step(system, damping):
    """Steps (P,) and (n, 6) of Marquardt's damped equations."""
    normal, gradient, solved, size, sizes = _reduced(system, damping)
    step = np.linalg.lstsq(normal, gradient, rcond=1e-15)[0]
    moves = solved[..., -1] - solved[..., :-1] @ step
    return step / size, moves / sizes


def _reduced(system, damping):
    """Damped normal matrix and gradient of the model without the poses, the terms from
    which the poses (n, 6) follow, and the scales of both: the diagonal's roots."""
    values, poses, both, values_gradient, poses_gradient = system
    size = np.sqrt(np.maximum(np.diag(values), 1e-300))
    sizes = np.sqrt(np.maximum(np.diagonal(poses, axis1=1, axis2=2), 1e-300))
    both = both / (sizes[:, :, None] * size)
    solved = np.linalg.solve(
        poses / (sizes[:, :, None] * sizes[:, None]) + damping * np.eye(6),
        np.concatenate([both, (poses_gradient / sizes)[..., None]], axis=2),
    )
    left = np.tensordot(both, solved, ((0, 1), (0, 1)))
    normal = values / np.outer(size, size) + damping * np.eye(len(size))
    gradient = values_gradient / size
    return normal - left[:, :-1], gradient - left[:, -1], solved, size, sizes


def _moved(T, moves):
    new = T.copy()
    new[:, :3, :3] = rotation_from_vector(moves[:, :3]) @ T[:, :3, :3]
    new[:, :3, 3] += moves[:, 3:]
    return new
