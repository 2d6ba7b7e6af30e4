"""How much of a shape next to the outermost knots is a guess.

Two questions that need no truth. How uncertain are rays at the knots, by the
covariance? And how would they turn at the ends if the mirror bent there as evenly as a
sheet does? Residuals answer neither: beyond the last feature a spline goes on as the
misfit of that feature says, multiplied, and fits all the same.
"""

import numpy as np

from raxel.calibration.mirror.ray_points import RayPoints
from raxel.calibration.mirror.refine import ray_sd
from raxel.calibration.mirror.support import ENDS
from raxel.errors import CalibrationError

# Standard deviations of rays at the knots, degrees: flagged, and refused.
UNCERTAIN_DEG, OPEN_DEG = 0.3, 5.0
# By how much rays at an end turn where a prior of EVEN_MM is put upon the shape, mean
# over ALONG places, degrees: flagged, and refused. Chosen on seeds that judge nothing,
# geometries A and B on both benches. There each of the 17 ends whose rays were 1.5
# degrees off or more, on average, is flagged, and each of the 14 beyond 2 refused.
UNEVEN_DEG, SWINGING_DEG = 3.0, 5.0
EVEN_MM, ALONG = 0.1, 5


def edge_flags(grid, quantity, fit, widening, evenly, swinging_deg):
    """By how much rays at an end would turn at most (degrees), and flags (list of text)
    for what is a guess of a ShapeFit, next to knots and ends.

    widening: of its covariance, by the misfit; evenly: PriorRows of a mirror that bends
    so; swinging_deg: the turn from which on the shape is rejected. Raises
    CalibrationError, naming the place, where it is anything.
    """
    c, covariance = fit.coefficients, fit.covariance
    flags = uncertain_knots(grid, quantity, c, covariance)
    turns = turns_if_even(grid, quantity, c, widening * covariance, evenly)
    return max(turns.values(), default=0.0), flags + swinging_ends(turns, swinging_deg)


def uncertain_knots(grid, quantity, coefficients, covariance):
    """Flags (list of text) where rays next to a knot are uncertain.

    Raises CalibrationError where they are anything.
    """
    u, v = np.meshgrid(*grid.breaks)
    places = grid.unturned(np.column_stack([u.ravel(), v.ravel()]))
    sd = np.degrees(ray_sd(places, grid, quantity, coefficients, covariance))
    worst = np.argmax(sd)
    text = (
        f"rays next to knot {worst % len(grid.breaks[0])} along u, "
        f"{worst // len(grid.breaks[0])} along v, are uncertain by {sd[worst]:.2g} "
        "degrees"
    )
    if not sd[worst] < OPEN_DEG:
        raise CalibrationError(
            f"mirror shape: {text}; give features there, fewer knots, or a prior",
            code="uncertain-shape",
        )
    return [text] if sd[worst] > UNCERTAIN_DEG else []


def swinging_ends(turns, limit_deg):
    """Flags (list of text) for outermost knot intervals that bend as no sheet does.

    turns: of `turns_if_even`. Raises CalibrationError where an end is a guess: its rays
    would turn by limit_deg or more.
    """
    flags = []
    for (axis, _, place), turn in turns.items():
        text = (
            f"the {place} knot interval along {axis}: rays would turn by {turn:.2g} "
            "degrees if the mirror bent there as evenly as a sheet"
        )
        if not turn < limit_deg:
            raise CalibrationError(
                f"mirror shape: {text}; give features that reach the edge, fewer "
                "knots, or a prior, and see that board, viewer and clamp stayed",
                code="swinging-end",
            )
        if turn > UNEVEN_DEG:
            flags.append(f"{text}; few features")
    return flags


def turns_if_even(grid, quantity, coefficients, covariance, evenly):
    """{one of ENDS: degrees} by which rays at that end turn if a prior joins the shape.

    covariance: (K, K), widened by the misfit; evenly: as `edge_flags` has it. Along an
    axis of one interval there is no such end.
    """
    towards = covariance @ evenly.rows.T
    normal = evenly.rows @ towards + evenly.sd**2 * np.eye(len(evenly.rows))
    gap = evenly.values - evenly.rows @ coefficients
    step = towards @ np.linalg.solve(normal, gap)
    ends = [end for end in ENDS if len(grid.breaks["uv".index(end[0])]) > 2]
    if not ends:
        return {}
    places = grid.unturned(np.concatenate([_along(grid, end) for end in ends]))
    change = RayPoints(places, grid, quantity).direction_jacobian(coefficients) @ step
    angles = np.degrees(np.linalg.norm(change, axis=1)).reshape(len(ends), ALONG)
    return dict(zip(ends, angles.mean(axis=1), strict=True))


def _along(grid, end):
    """ALONG places (n, 2) of the knots' box, turned, along one of its ends."""
    axis, place = "uv".index(end[0]), end[1]
    other = grid.breaks[1 - axis]
    found = np.empty((ALONG, 2))
    found[:, axis] = grid.breaks[axis][place]
    found[:, 1 - axis] = np.linspace(other[0], other[-1], ALONG)
    return found
