"""Observations in a flexible mirror: sightings, ray points, matches, support.

A partly visible board has no first corner to count from. Its lattice in one image may
be rotated and shifted against that in another. The clamp resolves the ambiguity: the
mirror does not move there, so both images show the same board positions at the clamp.
These positions are extrapolated from the corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.pose.grid_pose import refine_pose_angular
from raxel.calibration.pose.three_point import placed_points
from raxel.calibration.views.correspondence import BoardView
from raxel.cameras.core.base import Camera
from raxel.cameras.mirrors.spline import depth_rows, normal_rows
from raxel.errors import CalibrationError, InputError
from raxel.features.detector import Detection, Partial
from raxel.geometry.homography import homography_dlt
from raxel.geometry.poses import nearest_rotation, pose, pose_from_homography
from raxel.geometry.spline_grids import SplineGrid, spline_grid
from raxel.sets.model import Chessboard

# Points of a flat target in the image of a central camera, and the pose from them.
# Image points are normalised: (x/z, y/z) of the viewing ray, without distortion.
# The local magnification of the camera converts their errors to pixels.


MIN_N_POSE_CORNERS = 6  # twelve equations for the six pose parameters
MIN_SD_PX = 1e-3  # highest accuracy of a corner, also of an exact one


class Sighting(NamedTuple):
    """image (N, 2), normalised; scale (N,), px per unit; points (N, 2) of the target,
    mm; sd (N,), px, of each corner along an axis, NaN where unknown."""

    image: np.ndarray
    scale: np.ndarray
    points: np.ndarray
    sd: np.ndarray
    unknown_sd: bool = False

    def alike(self):
        """The same with equal standard deviations, for corners of unknown accuracy."""
        return self._replace(sd=np.ones(len(self.points)), unknown_sd=True)

    def residuals(self, p):
        """(2N,) px over sd: detected minus projected, for points p (N, 3) in front."""
        with np.errstate(divide="ignore", invalid="ignore"):
            projected = np.where(p[:, 2:] > 0, p[:, :2] / p[:, 2:], np.nan)
        return ((self.image - projected) * (self.scale / self.sd)[:, None]).ravel()

    def change(self, p, motion):
        """(2N, k): change of the residuals with points p, motion (N, 3, k)."""
        depth = p[:, 2]
        weight = -self.scale / self.sd / depth
        projected = (p[:, :2] / depth[:, None])[:, :, None]
        across = motion[:, :2] - projected * motion[:, 2:]
        return (weight[:, None, None] * across).reshape(2 * len(p), -1)


def normalised(viewer: Camera, pixels: ArrayLike) -> NDArray[np.float64]:
    """Return the normalised image coordinates of pixels.

    Parameters
    ----------
    viewer : Camera
        Central camera.
    pixels : array_like, shape (N, 2)
        Pixels, px.

    Returns
    -------
    ndarray, shape (N, 2)
        Coordinates (x / z, y / z) of the viewing rays, NaN without one in front.
    """
    d = viewer.rays(pixels).directions
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(d[:, 2:] > 0, d[:, :2] / d[:, 2:], np.nan)


def magnification(viewer: Camera, pixels: ArrayLike) -> NDArray[np.float64]:
    """Return the number of pixels for a unit of `normalised`.

    Parameters
    ----------
    viewer : Camera
        Central camera.
    pixels : array_like, shape (N, 2)
        Pixels, px.

    Returns
    -------
    ndarray, shape (N,)
        Mean over directions, by area, px.
    """
    step = 0.5 * np.eye(2)
    ends = np.concatenate([np.asarray(pixels) + s for s in (*step, *-step)])
    ends = normalised(viewer, ends).reshape(2, 2, -1, 2)
    across, down = ends[0] - ends[1]
    area = np.abs(across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0])
    return 1 / np.sqrt(area)


def sighting(viewer, view, name):
    """Sighting of the corners of a view that were detected and have a viewing ray.

    Raises CalibrationError for fewer than MIN_N_POSE_CORNERS.
    """
    pixels, points = np.asarray(view.pixels, float), np.asarray(view.points, float)
    sd = np.full(len(pixels), np.nan) if view.sd is None else np.asarray(view.sd, float)
    image = normalised(viewer, pixels)
    found = np.isfinite(image).all(axis=1)
    if np.count_nonzero(found) < MIN_N_POSE_CORNERS:
        raise CalibrationError(
            f"{name}: found {np.count_nonzero(found)} corners; give at least "
            f"{MIN_N_POSE_CORNERS}",
            code="too-few-corners",
        )
    scale = magnification(viewer, pixels[found])
    return Sighting(
        image[found], scale, points[found], np.maximum(sd[found], MIN_SD_PX)
    )


def target_pose(seen):
    """T_camera_grid (4, 4), right-handed, of the target of a Sighting.

    From the homography, refined by least angles. For a small or distant flat target
    the cost has a second minimum with the opposite tilt: both are tried. Raises
    CalibrationError for points that do not determine the pose.
    """
    rays = np.column_stack([seen.image, np.ones(len(seen.image))])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    try:
        first = pose_from_homography(homography_dlt(seen.points, seen.image))
    except InputError as error:
        raise CalibrationError(f"pose of a board: {error}", code=error.code) from None
    starts = first, other_tilt(first, seen.points)
    found = [refine_pose_angular(rays, seen.points, T) for T in starts]
    return min(found, key=lambda refined: refined.rms).T_camera_grid


def other_tilt(T_camera_grid, points):
    """The pose (4, 4) with nearly the same image: tilted to the other side of the line
    of sight, about the centroid of points (N, 2)."""
    middle = points.mean(axis=0)[None]
    at = placed_points(middle, T_camera_grid)[0]
    sight = at / np.linalg.norm(at)
    axes = T_camera_grid[:3, :2]
    R = nearest_rotation(axes - 2 * np.outer(sight, sight @ axes))
    return pose(R, at - R[:, :2] @ middle[0])


# Distances of scene points from the scene rays of a spline mirror (5.29), as vectors.
# The length of the vector is the thesis's scalar distance, and the sum of squares is
# the same. The root in the scalar stalls Gauss-Newton; the vector's Jacobian is smooth.
# With the normal m = M c, linear in the coefficients c, the unit viewing ray V, the
# scene ray V_r = V - 2 (V . m) m / m.m, q = P - S and a = V_r . q: r = (I - V_r V_r^T)
# q, dr/dc = -(a I + V_r q^T) G M - (I - V_r V_r^T) dS/dc, G = -2 [m V^T / m.m + (V . m)
# / m.m I - 2 (V . m) / (m.m)^2 m m^T]


RAY_STEP = 1e-6  # normalised, for derivatives with respect to the viewing ray


class RayPoints:
    """Compute distances of points from the scene rays of a spline mirror.

    The viewing rays are fixed. What does not change with the coefficients is stored.
    This takes about 1.5 kB for each point and 21 coefficients.

    Parameters
    ----------
    p : ndarray, shape (N, 2)
        Normalised image coordinates, inside the grid's box.
    grid : SplineGrid
        Grid of the spline.
    quantity : str
        "inverse depth" or "distance"; see `spline_surface`.

    References
    ----------
    Thesis (5.29).
    """

    def __init__(self, p: NDArray[np.float64], grid: SplineGrid, quantity: str) -> None:
        self.p, self.grid, self.quantity = p, grid, quantity
        rows = depth_rows(grid, p, quantity)
        self.depth_rows = rows[0]
        self.normal_rows = normal_rows(p, rows, quantity)
        self.w = np.column_stack([p, np.ones(len(p))])
        self.viewing = self.w / np.linalg.norm(self.w, axis=1, keepdims=True)

    def surface(
        self, c: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return mirror points (N, 3) and unit scene directions (N, 3) of c (K,)."""
        m = self.normal_rows @ c
        turn = 2 * _dot(self.viewing, m) / _dot(m, m)
        scene = self.viewing - turn[:, None] * m
        depth = self.depth_rows @ c
        depth = depth if self.quantity == "distance" else 1 / depth
        return depth[:, None] * self.w, scene

    def in_front(self, c: NDArray[np.float64]) -> bool:
        """Return whether all mirror points are in front of the viewing camera."""
        return bool(np.all(self.depth_rows @ c > 0))

    def residuals(
        self, c: NDArray[np.float64], points: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return vectors (N, 3), mm, from the scene rays to points (N, 3)."""
        S, scene = self.surface(c)
        q = points - S
        return q - _dot(scene, q)[:, None] * scene

    def jacobian(
        self, c: NDArray[np.float64], points: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the change (N, 3, K) of the residuals with the coefficients."""
        S, scene = self.surface(c)
        by_direction, across = self._parts(scene, points - S)
        jacobian = (by_direction @ self._turning(c)) @ self.normal_rows
        sliding = np.einsum("nij,nj->ni", across, self._slide(c))
        jacobian -= sliding[:, :, None] * self.depth_rows[:, None, :]
        return jacobian

    def direction_jacobian(self, c: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the change (N, 3, K) of unit scene directions with coefficients."""
        return self._turning(c) @ self.normal_rows

    def across(self, c: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the change (N, 3, 3) of the residuals with the points."""
        scene = self.surface(c)[1]
        return np.eye(3) - scene[:, :, None] * scene[:, None, :]

    def image_jacobian(
        self, c: NDArray[np.float64], points: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the change (N, 3, 2) of the residuals with p, by differences.

        The difference is one-sided where the other side lies outside the box.
        """
        shifts = RAY_STEP * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
        ends = (self.p + shifts[:, None]).reshape(-1, 2)
        stay = np.tile(self.p, (4, 1))
        ends = np.where(self.grid.inside(ends)[:, None], ends, stay)
        errors = RayPoints(ends, self.grid, self.quantity)
        errors = errors.residuals(c, np.tile(points, (4, 1))).reshape(2, 2, -1, 3)  # type: ignore[assignment]
        ends = ends.reshape(2, 2, -1, 2)  # type: ignore[assignment]
        width = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=2)
        return np.moveaxis((errors[:, 0] - errors[:, 1]) / width[:, :, None], 0, 2)  # type: ignore[index]

    def _parts(self, scene, q):
        a = _dot(scene, q)
        by_direction = -scene[:, :, None] * q[:, None, :]
        by_direction -= a[:, None, None] * np.eye(3)
        return by_direction, np.eye(3) - scene[:, :, None] * scene[:, None, :]

    def _turning(self, c):
        """G (N, 3, 3): change of scene directions with the normals m."""
        V, m = self.viewing, self.normal_rows @ c
        mm, Vm = _dot(m, m), _dot(V, m)
        G = m[:, :, None] * (V / mm[:, None])[:, None, :]
        G += (Vm / mm)[:, None, None] * np.eye(3)
        G -= (2 * Vm / mm**2)[:, None, None] * m[:, :, None] * m[:, None, :]
        return -2 * G

    def _slide(self, c):
        """(N, 3): change of mirror points with the depth rows."""
        if self.quantity == "distance":
            return self.w
        return -self.w / ((self.depth_rows @ c) ** 2)[:, None]


def _dot(a, b):
    return np.einsum("ni,ni->n", a, b)


# Wrong matches between a flat grid and its image in a smooth mirror. The image is a
# smooth function of the grid's coordinates: a cubic leaves a few pixels for correct
# matches and many for wrong ones.


# Exponents of a cubic in two coordinates.
CUBIC_EXPONENTS = [(i, j) for i in range(4) for j in range(4 - i)]
MAX_N_ROUNDS, MEDIAN_TOL = 30, 1e-2
# Medians of the correct ones, and px, beyond which a feature is wrong.
OUTLIER_MEDIANS, MIN_OUTLIER_PX = 6.0, 8.0


def wrong_matches(points, pixels):
    """Which rows (N,) bool deviate from a smooth image; False where pixels are NaN.

    points: (N, 2) on the grid; pixels: (N, 2). The fit minimises the sum of distances,
    so up to a third may be wrong. With too few features no row is marked.
    """
    shown = np.isfinite(pixels).all(axis=1)
    wrong = np.zeros(len(points), bool)
    if np.count_nonzero(shown) < 2 * len(CUBIC_EXPONENTS):
        return wrong
    x, y = _centred(points[shown]).T
    A = np.stack([x**i * y**j for i, j in CUBIC_EXPONENTS], axis=1)
    errors = _least_distances(A, pixels[shown])
    wrong[shown] = errors > max(OUTLIER_MEDIANS * np.median(errors), MIN_OUTLIER_PX)
    return wrong


def _least_distances(A, pixels):
    """Distances (N,), px, from the polynomial with the least sum of distances, by
    iteratively reweighted least squares."""
    weights, median = np.ones(len(A)), np.inf
    for _ in range(MAX_N_ROUNDS):
        normal = A.T * weights
        coefficients = np.linalg.solve(normal @ A, normal @ pixels)
        errors = np.linalg.norm(pixels - A @ coefficients, axis=1)
        weights = 1 / np.maximum(errors, 0.1)
        last, median = median, np.median(errors)
        if abs(last - median) <= MEDIAN_TOL * median:
            break
    return errors


def _centred(points):
    low, high = points.min(axis=0), points.max(axis=0)
    return (2 * points - low - high) / np.maximum(high - low, 1e-12)


# Knot intervals of a spline mirror with features. Without features the residual stays
# small for an arbitrary shape (5.2.2): the first and the last interval along u and v
# need at least one. The reach of features into them determines how much of the edge is
# extrapolated.


# As a fraction of the outermost interval: with less, the edge is extrapolated.
MIN_REACH = 0.6
ENDS = (("u", 0, "first"), ("u", -1, "last"), ("v", 0, "first"), ("v", -1, "last"))


class Support(NamedTuple):
    """Number of features per knot interval.

    along_u, along_v: numbers of features; cells (n_u, n_v): in each cell; reach: for
    the first and last interval along u, then along v, the fraction between its inner
    knot and the outermost feature, 0 without features.
    """

    along_u: np.ndarray
    along_v: np.ndarray
    cells: np.ndarray
    reach: np.ndarray

    def missing(self):
        """Names of the outermost intervals without a feature."""
        return [
            f"the {place} knot interval along {axis}"
            for axis, end, place in ENDS
            if (self.along_u if axis == "u" else self.along_v)[end] == 0
        ]

    def weak(self):
        """Names of the outermost intervals with a small reach of the features."""
        return [
            f"the {place} knot interval along {axis} ({100 * share:.0f} % of it)"
            for (axis, _, place), share in zip(ENDS, self.reach, strict=True)
            if 0 < share < MIN_REACH
        ]


def support_of(grid, p):
    """Support of a SplineGrid by features at p (N, 2); those outside do not count."""
    p = np.asarray(p, float)
    inside = grid.inside(p)
    i, j = grid.intervals(p[inside]).T
    shape = tuple(len(breaks) - 1 for breaks in grid.breaks)
    cells = np.zeros(shape, int)
    np.add.at(cells, (i, j), 1)
    reach = []
    for breaks, x in zip(grid.breaks, grid.turned(p[inside]).T, strict=True):
        low, high = (x.min(), x.max()) if len(x) else (np.inf, -np.inf)
        reach += [
            (breaks[1] - low) / (breaks[1] - breaks[0]),
            (high - breaks[-2]) / (breaks[-1] - breaks[-2]),
        ]
    return Support(cells.sum(axis=1), cells.sum(axis=0), cells, np.clip(reach, 0, 1))


def clamped_end(grid, clamp):
    """("u", 0) or ("u", -1), the end at which a Clamp or FixedLine fixes position and
    slope; None without such a clamp."""
    if clamp is None or clamp.slopes is None:
        return None
    u = np.median(grid.turned(clamp.points)[:, 0])
    first, last = grid.breaks[0][[0, -1]]
    return ("u", 0 if u - first < last - u else -1)


def need_support(support, clamp_at=None, prior=False):
    """Flags (list of text) for weak intervals; CalibrationError for unsupported ones.

    clamp_at: ("u", 0) or ("u", -1), the end whose position and slope a clamp fixes;
    prior: whether a prior determines intervals without features, which are flagged.
    """
    carried = dict.fromkeys(
        (f"the {place} knot interval along {axis}"
         for axis, end, place in ENDS if clamp_at == (axis, end)), "the clamp"
    )  # fmt: skip
    missing = support.missing()
    open_ends = [name for name in missing if name not in carried]
    if open_ends and not prior:
        raise CalibrationError(
            f"mirror shape: no common feature in {', '.join(open_ends)}; use fewer "
            "knots, a smaller deflection, features in these intervals, or a prior",
            code="no-feature-at-end",
        )
    flags = [
        f"{name}: determined by {carried.get(name, 'the prior')}" for name in missing
    ]
    return flags + [f"{name}: few features" for name in support.weak()]


def supported_grid(span, p, most=(7, 3), degree=(2, 2), angle=0.0, clamp_at=None):
    """SplineGrid with the most basis functions whose outermost intervals features
    support, at most `most` (Kf, Kg).

    span: (M, 2), span of its box; p: (N, 2), the features common to both images. The
    larger their displacement, the fewer reach the free edge, and the wider its interval
    must be. Raises CalibrationError where not even one interval is supported.
    """
    shape = list(most)
    while True:
        grid = spline_grid(span, shape, degree, angle)
        support = support_of(grid, p)
        poor = _unsupported_axes(support, clamp_at)
        fewer = [axis for axis in poor if shape[axis] > degree[axis] + 1]
        if not fewer:
            need_support(support, clamp_at)
            return grid
        for axis in fewer:
            shape[axis] -= 1


def _unsupported_axes(support, clamp_at):
    counts = {"u": support.along_u, "v": support.along_v}
    poor = {
        "uv".index(axis)
        for (axis, end, _), share in zip(ENDS, support.reach, strict=True)
        if (axis, end) != clamp_at and (counts[axis][end] == 0 or share < MIN_REACH)
    }
    return sorted(poor)


# Minimum number of corners in an image, three for each coefficient of a quadratic.
MIN_N_LATTICE_CORNERS = 18
# Lattice steps between the board positions at the clamp in both images: maximum for the
# correct labelling, minimum for any other. On both geometries of chapter 5, 24 runs of
# three deflections of 5 mm: at most 0.3, and at least 0.9.
MAX_CLAMP_SHIFT, MIN_OTHER_SHIFT = 0.4, 0.7
# Size of the common lattice, in boards.
LATTICE_BOARDS = 3
# Symmetries of a lattice: rotations by 90 degrees, and transposition of rows, columns.
LATTICE_SYMMETRIES = tuple(
    np.array([[a, b], [c, d]])
    for a, b, c, d in product((-1, 0, 1), repeat=4)
    if abs(a * d - b * c) == 1 and abs(a) + abs(b) + abs(c) + abs(d) == 2
)


def lattice_of(detection: Detection) -> Partial | None:
    """Return the detected lattice of a whole chessboard or of a part.

    Parameters
    ----------
    detection : Detection
        Result of the detector.

    Returns
    -------
    Partial or None
        Corners with their indices; None without any.
    """
    if not detection.found:
        return detection.partial
    there = np.isfinite(detection.corners[:, 0])
    row, column = np.divmod(np.arange(len(there)), detection.columns)  # type: ignore[arg-type]
    indices = np.column_stack([row, column])
    return Partial(detection.corners[there], indices[there])


def labelled_like(
    before: Partial, after: Partial, clamp: NDArray[np.float64], name: str = "board"
) -> Partial:
    """Label the corners of one lattice as those of another.

    Parameters
    ----------
    before, after : Partial
        Lattices detected before and after a deflection.
    clamp : ndarray, shape (L, 2)
        Points along the edge at which the mirror is held, px.
    name : str
        Start of the error message.

    Returns
    -------
    Partial
        `after`, each corner with the indices that `before` has for it.

    Raises
    ------
    InputError
        ``too-few-corners``: an image shows too few corners. ``corners-not-matched``:
        the labelling is ambiguous.
    """
    fewest = min(len(before.corners), len(after.corners))
    if fewest < MIN_N_LATTICE_CORNERS:
        raise InputError(
            f"{name}: found {fewest} corners of the board in an image; show at least "
            f"{MIN_N_LATTICE_CORNERS} to identify them",
            code="too-few-corners",
        )
    (there, hand), (places, other_hand) = (
        _run_on(partial, clamp) for partial in (before, after)
    )
    found = []
    for turn in LATTICE_SYMMETRIES:
        if np.linalg.det(turn) * other_hand * hand < 0:
            continue
        separation = there - places @ turn
        shift = np.rint(separation.mean(axis=0)).astype(int)
        gap = np.linalg.norm(separation - shift, axis=1).max()
        found.append((gap, after.indices @ turn + shift))
    found.sort(key=lambda one: one[0])
    if found[0][0] > MAX_CLAMP_SHIFT or found[1][0] < MIN_OTHER_SHIFT:
        raise InputError(
            f"{name}: the corner labels after the deflection are ambiguous; use a "
            "smaller deflection, or show the board up to the clamp",
            code="corners-not-matched",
        )
    return after._replace(indices=found[0][1])


def on_one_lattice(
    partials: Sequence[Partial], board: Chessboard, names: Sequence[str]
) -> list[BoardView]:
    """Return views of lattices that are labelled alike, all with the same corners.

    The lattice has LATTICE_BOARDS times the chessboard's side, with the first partial
    in its middle.

    Parameters
    ----------
    partials : sequence of Partial
        Lattices, labelled alike.
    board : Chessboard
        The chessboard.
    names : sequence of str
        Names of the views.

    Returns
    -------
    list of BoardView
        View of each lattice.

    Raises
    ------
    InputError
        ``corners-not-matched``: a partial reaches beyond the lattice.
    """
    side = LATTICE_BOARDS * max(board.columns, board.rows)  # type: ignore[operator, type-var]
    first = partials[0].indices
    origin = (first.min(axis=0) + first.max(axis=0) - side) // 2
    row, column = np.divmod(np.arange(side * side), side)
    points = board.pitch_mm * np.column_stack([column, row]).astype(float)
    views = []
    for partial, name in zip(partials, names, strict=True):
        at = partial.indices - origin
        if at.min() < 0 or at.max() >= side:
            raise InputError(
                f"{name}: its corners are {LATTICE_BOARDS // 2} boards away from those "
                f"of {names[0]}; use smaller deflections",
                code="corners-not-matched",
            )
        pixels = np.full((side * side, 2), np.nan)
        pixels[at @ [side, 1]] = partial.corners
        views.append(BoardView(pixels, points, side, side, name))  # type: ignore[call-arg]
    return views


def _run_on(partial, clamp):
    """(Lattice positions (L, 2) at pixels `clamp`, from a quadratic through all
    corners; orientation of rows and columns, 1 for clockwise or -1)."""
    middle = partial.corners.mean(axis=0)
    scale = np.abs(partial.corners - middle).max()
    A, at = (_quadratic((p - middle) / scale) for p in (partial.corners, clamp))
    c = np.linalg.lstsq(A, partial.indices.astype(float), rcond=None)[0]
    return at @ c, np.sign(np.linalg.det(c[1:3]))


def _quadratic(p):
    x, y = p.T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
