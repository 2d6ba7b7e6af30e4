"""The edge that the mirror is clamped at: its line in the picture, and what is fixed.

The thesis picks points at the clamped edge by hand and refines them by a fit of a line
(5.1.3). The edge itself may be hidden by its holder (5.3.3): then the nearest line of
the mirror that can be seen stands in for it. That line does move: by the beam's formula
(5.1), a mirror of length m whose end is deflected by v has, at x from the clamp,

    moved by v x^2 (3 m - x) / (2 m^3),   turned by 3 v x (2 m - x) / (2 m^3).

These are the standard deviations with which position and slope are held there.

Frame: the viewer's; image points are normalised, (x/z, y/z) of the viewing ray.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.sightings import magnification, normalised
from raxel.errors import CalibrationError, InputError

FEWEST = 3  # picks: a line and one that can contradict it
ROUNDS, FAR = 10, 3.0  # fits of the line; scales beyond which a pick is left out
LEAST_SCALE_PX = 0.02  # no pick is placed better
CROOKED_PX = 2.0  # a straight edge leaves less, rms
LEAST_CONTRAST = 0.02  # of the brightest grey, across an edge
FIRM_MM, FIRM_RADIANS = 1e-3, 1e-5  # no clamp holds better


class ClampLine(NamedTuple):
    """ends (2, 2): of the line, normalised; angle: of the u axis at right angles to it,
    for SplineGrid, radians, from -pi/2 to pi/2; offset_sd, angle_sd: standard
    deviations of its place at mid-line (normalised) and of its direction (radians);
    used (N,) bool: picks that lie on it; rms_px: how far these lie from it."""

    ends: np.ndarray
    angle: float
    offset_sd: float
    angle_sd: float
    used: np.ndarray
    rms_px: float

    def points(self, count):
        """Points (count, 2) from end to end, evenly spread."""
        share = np.linspace(0, 1, count)[:, None]
        return (1 - share) * self.ends[0] + share * self.ends[1]


class FixedLine(NamedTuple):
    """What stays as it was, at points of the clamp's line, for all stages.

    points (N, 2), normalised; values (N,): of the spline's quantity; slopes (N, 2): its
    derivatives by the points' two coordinates; value_sd (N,): how well the values are
    held; slope_sd (N,): how well the derivative along u, at right angles to the line;
    angle: of the u axis, radians.
    """

    points: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    value_sd: np.ndarray
    slope_sd: np.ndarray
    angle: float

    @property
    def u(self):
        """The u axis (2,), of unit length, at right angles to the line."""
        return np.array([np.cos(self.angle), np.sin(self.angle)])


def edge_picks(picture, picks, reach=6.0):
    """Picks (N, 2) px moved onto the edge nearby, to a part of a pixel.

    picture: (H, W) grey; picks: (N, 2), N >= 2, within `reach` px of the edge. Each is
    moved at right angles to the straight line through all, to the centroid of the
    squared change of grey there. NaN where no edge is in reach. Raises InputError for
    too few picks.
    """
    from scipy.ndimage import map_coordinates

    picture, picks = np.asarray(picture, float), np.asarray(picks, float)
    _enough(picks, 2)
    across = _axes(picks)[2]
    steps = np.arange(-reach, reach + 0.25, 0.5)
    places = picks[:, None] + steps[None, :, None] * across
    grey = map_coordinates(
        picture, np.moveaxis(places[..., ::-1], 2, 0), order=1, cval=np.nan
    )
    change = np.diff(grey, axis=1)
    weight = change**2
    at = (steps[1:] + steps[:-1]) / 2
    with np.errstate(invalid="ignore", divide="ignore"):
        off = weight @ at / weight.sum(axis=1)
        clear = np.ptp(grey, axis=1) > LEAST_CONTRAST * picture.max()
    return np.where(clear[:, None], picks + off[:, None] * across, np.nan)


def clamp_line(viewer, picks):
    """The straight line through picks (N, 2) px in the undistorted picture.

    Picks that lie far from the line of the others are left out; rows of NaN do not
    count. Raises InputError for fewer than FEWEST picks, and CalibrationError where
    they do not lie on a line.
    """
    picks = np.asarray(picks, float)
    image = normalised(viewer, picks)
    finite = np.isfinite(image).all(axis=1)
    _enough(picks[finite], FEWEST)
    scale = np.median(magnification(viewer, picks[finite]))
    used = finite.copy()
    for _ in range(ROUNDS):
        middle, along, across = _axes(image[used])
        off = (image - middle) @ across * scale
        width = max(1.4826 * np.median(np.abs(off[finite])), LEAST_SCALE_PX)
        kept = finite & (np.abs(np.nan_to_num(off, nan=np.inf)) <= FAR * width)
        if np.array_equal(kept, used) or np.count_nonzero(kept) < FEWEST:
            break
        used = kept
    rms = float(np.sqrt(np.mean(off[used] ** 2)))
    if 2 * np.count_nonzero(used) < np.count_nonzero(finite) or rms > CROOKED_PX:
        raise CalibrationError(
            f"clamp: {np.count_nonzero(used)} of {np.count_nonzero(finite)} picks lie "
            f"on a line, within {rms:.1f} px (rms); pick points along one straight "
            "edge",
            code="bent-clamp-line",
        )
    reach = (image[used] - middle) @ along
    count = np.count_nonzero(used)
    spread = max(rms, LEAST_SCALE_PX) / scale * np.sqrt(count / (count - 2))
    normal = across if across[0] > 0 or (across[0] == 0 and across[1] > 0) else -across
    return ClampLine(
        middle + np.outer([reach.min(), reach.max()], along),
        float(np.arctan2(normal[1], normal[0])),
        float(spread / np.sqrt(count)),
        float(spread / np.sqrt(np.sum(reach**2))),
        used,
        rms,
    )


def fixed_line(camera, line, *, hidden=0.0, length=None, deflection=0.0, count=8):
    """What a line of the clamp fixes, read from the primary stage: FixedLine.

    camera: SplineMirrorCamera of the primary stage; line: ClampLine, whose angle should
    be the spline's. hidden: mm on the mirror from the line to the true clamp, 0 where
    the line is the clamp; length: mm from the clamp to where the mirror is pushed;
    deflection: the largest there that is to come, mm. The error of the line's own place
    counts as hidden. Points of the line beyond the knots are left out. Raises
    InputError for a line that is not on the mirror's spline, and for lengths that are
    missing or do not fit.
    """
    if (deflection or hidden) and not (deflection and length and length > hidden >= 0):
        raise InputError(
            f"clamp: found hidden {hidden}, length {length}, deflection {deflection}; "
            "give all three in mm, with length from the clamp to where the mirror is "
            "pushed"
        )
    p = line.points(count)
    grid = camera.grid
    inside = grid.inside(p)
    if np.count_nonzero(inside) < FEWEST:
        raise InputError(
            f"clamp: {np.count_nonzero(inside)} of {count} points of the line lie "
            "within the knots of the primary stage; include the line when the box of "
            "the spline is chosen"
        )
    p = p[inside]
    c = camera.coefficients.ravel("F")
    u = np.array([np.cos(line.angle), np.sin(line.angle)])
    values, by_x, by_y = (rows @ c for rows in grid.rows(p))
    moved, turned = _give(camera, p, u, line, hidden, length, deflection)
    value_sd, slope_sd = _in_quantity(camera, p, u, moved, turned)
    slopes = np.column_stack([by_x, by_y])
    return FixedLine(p, values, slopes, value_sd, slope_sd, line.angle)


def beam_give(hidden, length, deflection):
    """(mm, radians) by which a beam moves and turns at `hidden` mm from its clamp, when
    its end at `length` mm is deflected (5.1)."""
    x, m = np.minimum(hidden, length), length
    moved = deflection * x**2 * (3 * m - x) / (2 * m**3)
    return moved, 3 * deflection * x * (2 * m - x) / (2 * m**3)


def _give(camera, p, u, line, hidden, length, deflection):
    """(mm, radians), (N,) each: standard deviations of the mirror at the line."""
    firm = np.full(len(p), FIRM_MM), np.full(len(p), FIRM_RADIANS)
    if not deflection:
        return firm
    # mm on the mirror for a unit of u; one side may lie beyond the knots.
    step = 1e-6
    sides = [camera.mirror.points(p + way * step * u) for way in (1, -1)]
    away = np.linalg.norm(sides - camera.mirror.points(p), axis=2) / step
    hidden = np.hypot(hidden, line.offset_sd * np.nanmax(away, axis=0))
    return np.maximum(firm, beam_give(hidden, length, abs(deflection)))


def _in_quantity(camera, p, u, moved, turned):
    """What a shift (N,) mm along the normal and a turn (N,) about the line change of
    the quantity and of its slope along u: their standard deviations, (N,) each."""
    S = camera.mirror.points(p)
    n = camera.mirror.normals(S)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    # The line on the mirror lies in the plane of eye and picture line.
    axis = np.cross(n, np.cross(S, [-u[1], u[0], 0.0]))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    leaning = n + turned[:, None] * np.cross(axis, n)
    k = np.sum(n * S, axis=1)
    rest = _of_plane(n, k, p, u, camera.quantity)
    shifted = _of_plane(n, k + moved, p, u, camera.quantity)
    leant = _of_plane(leaning, np.sum(leaning * S, axis=1), p, u, camera.quantity)
    return tuple(np.hypot(shifted[i] - rest[i], leant[i] - rest[i]) for i in range(2))


def _of_plane(n, k, p, u, quantity):
    """The quantity of planes n.X = k on viewing rays p (N, 2), and its slope by u."""
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
            f"clamp: found {len(picks)} picks on the line near the clamp; give "
            f"{fewest} or more (u, v)"
        )
