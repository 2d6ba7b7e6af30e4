"""Clamped edge of a flexible mirror, which no deflection moves (5.1.3).

At the clamp the mirror keeps its position and its slope. The slope follows from the
beam equation (5.1); the thesis does not use it. Both are linear in the coefficients of
a spline, so coefficients c_P + C_B Phi (5.21) keep the clamp exactly, in the linear
stage and in the refinement. A line along a knot axis gives as many equations as the
spline has functions along it. For an oblique line some equations are nearly dependent;
those are discarded. A line that replaces a hidden clamp moves a little: its equations
are weighted with their standard deviations.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.mirror.observations import magnification, normalised
from raxel.cameras.core.base import Camera
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.spline_grids import SplineGrid, basis

# Line of the clamped edge in the image, and the quantities that it fixes. The thesis
# picks points on the clamped edge by hand and fits a line (5.1.3). Where a holder hides
# the edge (5.3.3), the nearest visible line of the mirror replaces it. That line moves:
# by the beam equation (5.1), a mirror of length m with end deflection v is shifted, at
# x from the clamp, by v x^2 (3 m - x) / (2 m^3) and rotated by 3 v x (2 m - x) / (2
# m^3). These are the standard deviations of position and slope there. Frame: that of
# the viewing camera; image points are normalised, (x/z, y/z) of the viewing ray.


MIN_N_PICKS = 3  # points: two determine a line, a third one tests it
# Fits of the line, and residual scales beyond which a point is rejected.
MAX_N_LINE_FITS, OUTLIER_SCALES = 10, 3.0
MIN_SCALE_PX = 0.02  # highest accuracy of a point
MAX_LINE_RMS_PX = 2.0  # rms distance of points on a straight edge
MIN_CONTRAST = 0.02  # across an edge, as a fraction of the brightest grey level
MIN_CLAMP_SD_MM, MIN_CLAMP_SD_RAD = 1e-3, 1e-5  # accuracy of an ideal clamp


class ClampLine(NamedTuple):
    """Hold the line of the clamp in the image.

    Attributes
    ----------
    ends : ndarray, shape (2, 2)
        Ends of the line, normalised.
    angle : float
        Angle of the u axis at right angles to it, for SplineGrid, rad, from -pi/2 to
        pi/2.
    offset_sd : float
        Standard deviation of its position at mid-line, normalised.
    angle_sd : float
        Standard deviation of its direction, rad.
    used : ndarray of bool, shape (N,)
        Picks that lie on it.
    rms_px : float
        Root mean square distance of these from it, px.
    """

    ends: np.ndarray
    angle: float
    offset_sd: float
    angle_sd: float
    used: np.ndarray
    rms_px: float

    def points(self, count: int) -> NDArray[np.float64]:
        """Return points (count, 2) from end to end, evenly spread."""
        share = np.linspace(0, 1, count)[:, None]
        return (1 - share) * self.ends[0] + share * self.ends[1]


class FixedLine(NamedTuple):
    """Hold what stays unchanged at points of the clamp's line, for all stages.

    Attributes
    ----------
    points : ndarray, shape (N, 2)
        Points of the line, normalised.
    values : ndarray, shape (N,)
        Quantity of the spline.
    slopes : ndarray, shape (N, 2)
        Derivatives of the quantity by the points' two coordinates.
    value_sd : ndarray, shape (N,)
        Standard deviation with which the values are held.
    slope_sd : ndarray, shape (N,)
        Standard deviation of the derivative along u, at right angles to the line.
    angle : float
        Angle of the u axis, rad.
    """

    points: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    value_sd: np.ndarray
    slope_sd: np.ndarray
    angle: float

    @property
    def u(self) -> NDArray[np.float64]:
        """Return the u axis (2,), of unit length, at right angles to the line."""
        return np.array([np.cos(self.angle), np.sin(self.angle)])


def edge_picks(image, picks, reach=6.0):
    """Points (N, 2), px, moved onto the nearest edge, to subpixel accuracy.

    image: (H, W) grey; picks: (N, 2), N >= 2, within `reach` px of the edge. Each is
    moved perpendicular to the straight line through all points, to the centroid of the
    squared grey-level gradient. NaN where no edge is in reach. Raises InputError for
    too few points.
    """
    from scipy.ndimage import map_coordinates

    image, picks = np.asarray(image, float), np.asarray(picks, float)
    _enough(picks, 2)
    across = _axes(picks)[2]
    steps = np.arange(-reach, reach + 0.25, 0.5)
    places = picks[:, None] + steps[None, :, None] * across
    grey = map_coordinates(
        image, np.moveaxis(places[..., ::-1], 2, 0), order=1, cval=np.nan
    )
    change = np.diff(grey, axis=1)
    weight = change**2
    at = (steps[1:] + steps[:-1]) / 2
    with np.errstate(invalid="ignore", divide="ignore"):
        errors = weight @ at / weight.sum(axis=1)
        clear = np.ptp(grey, axis=1) > MIN_CONTRAST * image.max()
    return np.where(clear[:, None], picks + errors[:, None] * across, np.nan)


def clamp_line(viewer: Camera, picks: ArrayLike) -> ClampLine:
    """Fit the straight line through picked points in the undistorted image.

    Picks far from the line of the others are rejected. Rows of NaN do not count.

    Parameters
    ----------
    viewer : Camera
        Central camera that views the mirror.
    picks : array_like, shape (N, 2)
        Points along the clamped edge, px.

    Returns
    -------
    ClampLine
        Line with its standard deviations.

    Raises
    ------
    InputError
        Fewer than MIN_N_PICKS picks.
    CalibrationError
        ``bent-clamp-line``: the picks do not lie on a line.
    """
    picks = np.asarray(picks, float)
    image = normalised(viewer, picks)
    finite = np.isfinite(image).all(axis=1)
    _enough(picks[finite], MIN_N_PICKS)
    scale = np.median(magnification(viewer, picks[finite]))
    used = finite.copy()
    for _ in range(MAX_N_LINE_FITS):
        middle, along, across = _axes(image[used])
        errors = (image - middle) @ across * scale
        width = max(1.4826 * np.median(np.abs(errors[finite])), MIN_SCALE_PX)
        retained = finite & (
            np.abs(np.nan_to_num(errors, nan=np.inf)) <= OUTLIER_SCALES * width
        )
        if np.array_equal(retained, used) or np.count_nonzero(retained) < MIN_N_PICKS:
            break
        used = retained
    rms = float(np.sqrt(np.mean(errors[used] ** 2)))
    if 2 * np.count_nonzero(used) < np.count_nonzero(finite) or rms > MAX_LINE_RMS_PX:
        raise CalibrationError(
            f"clamp: found {np.count_nonzero(used)} of {np.count_nonzero(finite)} "
            f"points on a line, with {rms:.1f} px rms distance; give points along one "
            "straight edge",
            code="bent-clamp-line",
        )
    reach = (image[used] - middle) @ along
    count = np.count_nonzero(used)
    spread = max(rms, MIN_SCALE_PX) / scale * np.sqrt(count / (count - 2))
    normal = across if across[0] > 0 or (across[0] == 0 and across[1] > 0) else -across
    return ClampLine(
        middle + np.outer([reach.min(), reach.max()], along),
        float(np.arctan2(normal[1], normal[0])),
        float(spread / np.sqrt(count)),
        float(spread / np.sqrt(np.sum(reach**2))),
        used,  # type: ignore[arg-type]
        rms,
    )


def fixed_line(
    camera: SplineMirrorCamera,
    line: ClampLine,
    *,
    hidden: float = 0.0,
    length: float | None = None,
    deflection: float = 0.0,
    count: int = 8,
) -> FixedLine:
    """Return what a line of the clamp fixes, read from the primary stage.

    The error of the line's own position counts as hidden. Points of the line beyond the
    knots are excluded.

    Parameters
    ----------
    camera : SplineMirrorCamera
        Camera of the primary stage.
    line : ClampLine
        Line whose angle should be the spline's.
    hidden : float
        Distance on the mirror from the line to the true clamp, mm; 0 where the line is
        the clamp.
    length : float or None
        Distance from the clamp to where the mirror is pushed, mm.
    deflection : float
        Largest deflection there that is to come, mm.
    count : int
        Number of points on the line.

    Returns
    -------
    FixedLine
        Values and slopes with their standard deviations.

    Raises
    ------
    InputError
        The line is not on the mirror's spline, or lengths are missing or do not fit.

    References
    ----------
    Thesis (5.1), 5.1.3.
    """
    if (deflection or hidden) and not (deflection and length and length > hidden >= 0):
        raise InputError(
            f"clamp: found hidden {hidden}, length {length}, deflection {deflection} "
            "mm; give all three in mm (length: from the clamp to the pushed point)"
        )
    p = line.points(count)
    grid = camera.grid
    inside = grid.inside(p)
    if np.count_nonzero(inside) < MIN_N_PICKS:
        raise InputError(
            f"clamp: {np.count_nonzero(inside)} of {count} points of the line are "
            "within the knots of the primary stage; include the line in the span of "
            "the spline"
        )
    p = p[inside]
    c = camera.coefficients.ravel("F")
    u = np.array([np.cos(line.angle), np.sin(line.angle)])
    values, by_x, by_y = (rows @ c for rows in grid.rows(p))
    moved, turned = _give(camera, p, u, line, hidden, length, deflection)
    value_sd, slope_sd = _in_quantity(camera, p, u, moved, turned)
    slopes = np.column_stack([by_x, by_y])
    return FixedLine(p, values, slopes, value_sd, slope_sd, line.angle)


def beam_motion(hidden, length, deflection):
    """(mm, rad): shift and rotation of a beam at `hidden` mm from its clamp, when its
    end at `length` mm is deflected (5.1)."""
    x, m = np.minimum(hidden, length), length
    moved = deflection * x**2 * (3 * m - x) / (2 * m**3)
    return moved, 3 * deflection * x * (2 * m - x) / (2 * m**3)


def _give(camera, p, u, line, hidden, length, deflection):
    """(mm, rad), (N,) each: standard deviations of the mirror at the line."""
    firm = np.full(len(p), MIN_CLAMP_SD_MM), np.full(len(p), MIN_CLAMP_SD_RAD)
    if not deflection:
        return firm
    # mm on the mirror per unit of u; one side may be outside the knots.
    step = 1e-6
    sides = [camera.mirror.points(p + direction * step * u) for direction in (1, -1)]
    away = np.linalg.norm(sides - camera.mirror.points(p), axis=2) / step
    hidden = np.hypot(hidden, line.offset_sd * np.nanmax(away, axis=0))
    return np.maximum(firm, beam_motion(hidden, length, abs(deflection)))


def _in_quantity(camera, p, u, moved, turned):
    """Standard deviations (N,) of the quantity and of its slope along u, from a shift
    (N,) mm along the normal and a rotation (N,) about the line."""
    S = camera.mirror.points(p)
    n = camera.mirror.normals(S)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    # The line on the mirror is in the plane of the camera centre and the image line.
    axis = np.cross(n, np.cross(S, [-u[1], u[0], 0.0]))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    leaning = n + turned[:, None] * np.cross(axis, n)
    k = np.sum(n * S, axis=1)
    rest = _of_plane(n, k, p, u, camera.quantity)
    shifted = _of_plane(n, k + moved, p, u, camera.quantity)
    leant = _of_plane(leaning, np.sum(leaning * S, axis=1), p, u, camera.quantity)
    return tuple(np.hypot(shifted[i] - rest[i], leant[i] - rest[i]) for i in range(2))


def _of_plane(n, k, p, u, quantity):
    """Quantity of planes n.X = k on viewing rays p (N, 2), and its slope along u."""
    w = np.column_stack([p, np.ones(len(p))])
    inverse, slope = np.sum(w * n, axis=1) / k, n[:, :2] @ u / k
    if quantity == "inverse depth":
        return inverse, slope
    size = np.linalg.norm(w, axis=1)
    return size / inverse, p @ u / size / inverse - size * slope / inverse**2


def _axes(points):
    middle = points.mean(axis=0)
    along, across = np.linalg.svd(points - middle, full_matrices=False)[2]
    return middle, along, across


def _enough(picks, fewest):
    if picks.ndim != 2 or picks.shape[1] != 2 or len(picks) < fewest:
        raise InputError(
            f"clamp: found {len(picks)} points on the line near the clamp; give "
            f"{fewest} or more (u, v)"
        )


# Prior on the change of curvature between features, where only a prior determines the
# spline. The second derivatives along u and v change little from one knot interval to
# the next, as in a beam. Along an axis with a single interval the second derivative
# itself is small. Both are relative to a plane, whose inverse depth is linear. A large
# weight biases the deflection, so every result states the size of the prior. Its
# benefit on beams does not extend to mirrors of another kind.


class PriorRows(NamedTuple):
    """Equations rows @ c = values with standard deviations sd, one or (R,).

    mm: millimetres per unit of the spline's quantity, included in the rows of a prior
    on bending.
    """

    rows: np.ndarray
    values: np.ndarray
    sd: float | np.ndarray
    mm: float = 1.0


def bending_prior(grid, quantity, plane, sd):
    """PriorRows for the coefficients of a spline mirror.

    plane: (n (3,), k), n . X = k mm, near the mirror, frame of the viewing camera. sd:
    mm, twice the sagitta that a change of the second derivative makes over one knot
    interval.
    """
    rows = bending_rows(grid)
    flat = _plane_coefficients(grid, quantity, plane)
    # From inverse depth to mm at the middle of the plane.
    mm = 1.0 if quantity == "distance" else 1 / np.mean(flat) ** 2
    return PriorRows(mm * rows, mm * (rows @ flat), float(sd), mm)


@lru_cache(maxsize=8)
def bending_rows(grid):
    """Rows (R, K): change of second derivative between neighbouring knot intervals,
    times the square of the narrowest interval's width.

    Evaluated at the middles of the intervals along one axis and at the Greville points
    of the other. Along an axis with one interval, the second derivative itself. Cached
    for the same SplineGrid, which a stage uses twice.
    """
    f_changes, f = _along(grid.knots_u, grid.degree[0], grid.breaks[0])
    g_changes, g = _along(grid.knots_v, grid.degree[1], grid.breaks[1])
    return np.vstack([np.kron(g, f_changes), np.kron(g_changes, f)])


def plane_through(points):
    """(n (3,), k) of the plane n . X = k nearest to points (N, 3); n unit."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd(points - middle, full_matrices=False)[2][2]
    return normal, normal @ middle


def _along(knots, degree, breaks):
    bend = basis(knots, degree, (breaks[1:] + breaks[:-1]) / 2, 2)[2]
    changes = np.diff(bend, axis=0) if len(bend) > 1 else bend
    width = np.diff(breaks).min()
    return changes * width**2, basis(knots, degree, _greville(knots, degree))[0]


def _greville(knots, degree):
    """Greville point of each basis function: mean of its inner knots."""
    inner = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree)
    return inner.mean(axis=1)


def _plane_coefficients(grid, quantity, plane):
    """Coefficients (K,) of the spline that equals a plane at the Greville points."""
    normal, offset = plane
    u, v = (
        _greville(knots, degree)
        for knots, degree in zip((grid.knots_u, grid.knots_v), grid.degree, strict=True)
    )
    v, u = (a.ravel() for a in np.meshgrid(v, u, indexing="ij"))
    p = grid.unturned(np.column_stack([u, v]))
    w = np.column_stack([p, np.ones(len(p))])
    inverse = w @ normal / offset
    values = np.linalg.norm(w, axis=1) / inverse if quantity == "distance" else inverse
    return np.linalg.solve(grid.rows(p)[0], values)


# As a fraction of the largest singular value: smaller equations are noise of others.
TRUNCATION_TOL = 1e-2
OUTSIDE_MESSAGE = "clamp: some points are outside the knots; extend the knots over them"


class Clamp(NamedTuple):
    """Hold image points whose mirror points do not move.

    Attributes
    ----------
    points : ndarray, shape (M, 2)
        Normalised image coordinates.
    values : ndarray, shape (M,)
        Quantity of the spline there, mm or 1 / mm.
    slopes : ndarray, shape (M, 2), or None
        Derivatives of the quantity by the two coordinates. None where only the position
        is held.
    """

    points: np.ndarray
    values: np.ndarray
    slopes: np.ndarray | None = None


class Subspace(NamedTuple):
    """Coefficients `particular` + `directions` @ Phi: (K,), (K, F); F may be K."""

    particular: np.ndarray
    directions: np.ndarray

    def coefficients(self, free: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the coefficients (K,) of the free unknowns Phi (F,)."""
        return self.particular + self.directions @ free

    def free(self, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return Phi (F,) of the coefficients nearest to those given (K,)."""
        return self.directions.T @ (coefficients - self.particular)


def clamp_of_camera(
    camera: SplineMirrorCamera, pixels: ArrayLike, *, slope: bool = True
) -> Clamp:
    """Return the clamp that a calibrated camera has at pixels of its edge.

    Determine it once, from the primary calibration. Determined anew at every stage, it
    would drift.

    Parameters
    ----------
    camera : SplineMirrorCamera
        Calibrated camera.
    pixels : array_like, shape (M, 2)
        Pixels of the clamped edge, px.
    slope : bool
        Whether the slope is held, too.

    Returns
    -------
    Clamp
        Points, values and slopes.

    Raises
    ------
    CalibrationError
        ``outside-knots``: a pixel lies outside the knots.
    """
    seen = camera.viewer.rays(np.asarray(pixels, float)).directions
    points = seen[:, :2] / seen[:, 2:]
    inside = camera.grid.inside(points)
    if len(points) == 0 or not inside.all():
        raise CalibrationError(
            f"clamp: {np.count_nonzero(~inside)} of {len(points)} pixels are outside "
            "the camera's knots; give pixels of the edge in the mirror's image",
            code="outside-knots",
        )
    b, b_x, b_y = camera.grid.rows(points)
    c = camera.coefficients.ravel("F")
    slopes = np.column_stack([b_x @ c, b_y @ c]) if slope else None
    return Clamp(points, b @ c, slopes)


def clamped(
    grid: SplineGrid,
    clamp: Clamp | FixedLine | None,
    truncation: float = TRUNCATION_TOL,
) -> Subspace:
    """Return the subspace of a spline's coefficients that keep a clamp.

    Parameters
    ----------
    grid : SplineGrid
        Grid of the spline.
    clamp : Clamp, FixedLine or None
        The clamp; None for the whole space.
    truncation : float
        Share of the largest singular value. Combinations of equations below it are
        excluded.

    Returns
    -------
    Subspace
        One solution (K,) and free directions (K, F).

    Raises
    ------
    CalibrationError
        ``outside-knots``: points of the clamp lie outside the knots.

    References
    ----------
    Thesis (5.19) to (5.21).
    """
    if clamp is None:
        return Subspace(np.zeros(grid.size), np.eye(grid.size))
    rows, values = _equations(grid, clamp)
    if not np.isfinite(rows).all():
        raise CalibrationError(OUTSIDE_MESSAGE, code="outside-knots")
    U, size, Vt = np.linalg.svd(rows)
    rank = np.count_nonzero(size > truncation * size[0])
    particular = Vt[:rank].T @ ((U[:, :rank].T @ values) / size[:rank])
    return Subspace(particular, Vt[rank:].T)


def soft_clamp(grid, clamp):
    """PriorRows of a FixedLine, with its standard deviations; None for a firm Clamp.

    Values, and slopes perpendicular to the line unless `slopes` is None.
    """
    if not isinstance(clamp, FixedLine):
        return None
    b, b_x, b_y = grid.rows(clamp.points)
    if not np.isfinite(b).all():
        raise CalibrationError(OUTSIDE_MESSAGE, code="outside-knots")
    if clamp.slopes is None:
        return PriorRows(b, clamp.values, clamp.value_sd)
    u = clamp.u
    rows = np.vstack([b, u[0] * b_x + u[1] * b_y])
    values = np.concatenate([clamp.values, clamp.slopes @ u])
    return PriorRows(rows, values, np.concatenate([clamp.value_sd, clamp.slope_sd]))


def _equations(grid, clamp):
    """Rows (m, K) and values (m,). Slopes are multiplied by the width of a knot
    interval, to weigh as much as positions."""
    b, b_x, b_y = grid.rows(clamp.points)
    if clamp.slopes is None:
        return b, clamp.values
    width = min(np.diff(breaks).min() for breaks in grid.breaks)
    rows = np.vstack([b, width * b_x, width * b_y])
    return rows, np.concatenate([clamp.values, *(width * clamp.slopes.T)])
