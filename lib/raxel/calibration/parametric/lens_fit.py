"""A lens formula from nothing to a fit: a start, its terms, what they leave.

The start knows no lens: poses of all boards from the azimuths of their corners
(`raxel.calibration.parametric.radial_alignment`). From there an adjustment of formula
and poses together (`raxel.calibration.parametric.lens_bundle`) goes from few terms to
all of them, and back to those that the corners ask for (Schwarz's criterion).

Source: G. Schwarz 1978, doi:10.1214/aos/1176344136.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from raxel.calibration.parametric.clustered import clustered_covariance
from raxel.calibration.parametric.lens_bundle import (
    WIDTH,
    AdjustedLens,
    adjusted,
    posed_residuals,
    told_by_boards,
    tukey_pull,
)
from raxel.calibration.parametric.lens_laws import FRAME, LensFormula
from raxel.calibration.parametric.radial_alignment import aligned_starts
from raxel.errors import CalibrationError

RADIAL, DECENTRING, PUPIL = 4, 4, 3  # terms at most
LEAST_TERMS = FRAME + 1  # the frame's, and a radial one
FIRST_XI = (0.0, 1.0, 2.0)  # a pinhole, a paraboloid, a fisheye
PARTS = 5  # of the boards, kept out in turn
# A loss's curvature over its weights: 0.89 of Gaussian scatter. Tails that are so much
# longer tell no curvature.
LEAST_CURVED = 0.5
FLOOR_PX = 1e-6  # residuals below it are as good as none
KEPT = 8  # sets of boards whose fits are remembered


class FormulaFit(NamedTuple):
    """A formula, and its adjustment to boards."""

    formula: LensFormula
    result: AdjustedLens


class GivenBoards:
    """What a lens is fitted to. Equal where the numbers are: a comparison asks for
    both formulas, and for smooth rays on them, from the same parts of the boards."""

    def __init__(self, boards, width, height):
        self.boards, self.width, self.height = boards, width, height
        parts = ((part.shape, part.tobytes()) for part in boards)
        self._numbers = (width, height, *parts)

    def __eq__(self, other):
        return self._numbers == other._numbers

    def __hash__(self):
        return hash(self._numbers)


@lru_cache(maxsize=KEPT)
def start_of(given):
    """The best fit of r = F theta (1 + k1 theta^2) from the starts that are tried."""
    boards, width, height = given.boards, given.width, given.height
    fits = []
    for start in aligned_starts(
        boards.pixels, boards.points[..., :2], boards.seen, width, height
    ):
        formula = LensFormula("kannala-brandt", int(start.k1 != 0), 0, 0)
        values = [start.focal_px, start.focal_px, *start.centre, start.k1]
        values = values[: len(formula.names)]
        fit = FormulaFit(
            formula, adjusted(formula, values, start.T_camera_grid, boards, "cauchy")
        )
        fits.append(refitted(fit, formula._replace(radial=1), boards, "cauchy"))
    sound = [fit for fit in fits if np.isfinite(fit.result.cost)]
    if not sound:
        raise CalibrationError(
            "lens formula: no start leads to poses of the boards; are the corners in"
            " the order of their rows?",
            code="no-start",
        )
    return min(sound, key=lambda fit: np.median(fit.result.scales))


def fitted_law(law, start, boards, pupil, board=()):
    """The FormulaFit of a law, with the terms that the corners ask for; pupil: how many
    terms at most; board: the terms of its shape."""
    firsts = [start] if law == "kannala-brandt" else _on_spheres(start, boards)
    widest = [_widened(first, boards, pupil, board) for first in firsts]
    widest.sort(key=lambda fit: np.median(fit.result.scales))
    scales = widest[0].result.scales
    best = _thinned(widest[0], boards, scales)
    for other in widest[1:]:
        # With fewer terms a fit is no better, only simpler.
        if _criterion(other, boards, LEAST_TERMS) < _criterion(best, boards):
            other = _thinned(other, boards, scales)
            best = min(best, other, key=lambda fit: _criterion(fit, boards))
    return best


def _widened(fit, boards, pupil, board):
    """The FormulaFit with all terms, so many of the pupil's, and the board's."""
    for radial, decentring, moving in (
        (2, 2, min(pupil, 1)),
        (RADIAL, DECENTRING, pupil),
    ):
        wider = LensFormula(fit.formula.base, radial, decentring, moving, board)
        fit = refitted(fit, wider, boards, "tukey")
    return fit


def _on_spheres(start, boards):
    """The best FormulaFit of a unified sphere with one radial term, and, where it
    images all points, that of a perspective lens: no free xi ends on 0."""
    values, poses = start.result.values, start.result.T_camera_grid

    def fitted(base, *xi):
        formula = LensFormula(base, 1, 0, 0)
        first = np.array([*values[:4], *xi, 0.0])
        return FormulaFit(formula, adjusted(formula, first, poses, boards, "cauchy"))

    free = [fitted("unified", xi) for xi in FIRST_XI]
    best = min(free, key=lambda fit: np.median(fit.result.scales))
    flat = fitted("perspective")
    return [best, flat] if np.isfinite(flat.result.cost) else [best]


def refitted(fit, formula, boards, loss, scales=None):
    """The FormulaFit of another formula, from where a fit ended."""
    values = fit.formula.moved_to(formula, fit.result.values)
    result = adjusted(formula, values, fit.result.T_camera_grid, boards, loss, scales)
    return FormulaFit(formula, result)


def _thinned(fit, boards, scales):
    """The FormulaFit without the terms that do not pay, one after the other."""
    fit = refitted(fit, fit.formula, boards, "tukey", scales)
    best = _criterion(fit, boards)
    while True:
        tried = [
            refitted(fit, formula, boards, "tukey", scales)
            for formula in _narrower(fit.formula)
        ]
        least = min(tried, key=lambda other: _criterion(other, boards), default=None)
        if least is None or _criterion(least, boards) > best:
            return fit
        fit, best = least, _criterion(least, boards)


def _narrower(formula):
    """The formulas with a step fewer terms of one sort; a pupil that moves stays so,
    and a board keeps its shape."""
    if formula.radial > 1:
        yield formula._replace(radial=formula.radial - 1)
    if formula.decentring:
        yield formula._replace(decentring=formula.decentring - 2)
    if formula.pupil > 1:
        yield formula._replace(pupil=formula.pupil - 1)


def _criterion(fit, boards, terms=None):
    """Schwarz's: what a fit's loss and its number of parameters (those of the formula,
    where no other is given) cost together."""
    count = 2 * np.count_nonzero(boards.seen)
    cost = max(fit.result.cost, count * FLOOR_PX**2)
    terms = len(fit.formula.names) if terms is None else terms
    return count * np.log(cost) + terms * np.log(count)


def kept_out_squares(fit, boards):
    """Mean squared distance (n,) px^2 on each board, kept out of fits with the same
    terms, and its near copies with it; a corner counts as at most WIDTH scales of its
    board off. NaN where fewer than two others are left."""
    n, scales = len(boards.seen), fit.result.scales
    poses, squares = fit.result.T_camera_grid, np.full(n, np.nan)
    groups = boards.groups
    parts = min(PARTS, groups.max() + 1)
    for part in range(parts):
        out = groups % parts == part
        if n - out.sum() < 2:
            continue
        inside, kept = boards.some(~out), boards.some(out)
        found = adjusted(
            fit.formula, fit.result.values, poses[~out], inside, "tukey", scales[~out]
        )
        off = posed_residuals(fit.formula, found.values, poses[out], kept)
        most = (WIDTH * scales[out, None]) ** 2
        off = np.minimum(np.nan_to_num(np.sum(off**2, axis=2), nan=np.inf), most)
        squares[out] = np.sum(np.where(kept.seen, off, 0.0), axis=1)
        squares[out] /= kept.seen.sum(axis=1)
    return squares


def covariance_of(fit, boards):
    """ClusteredCovariance of the parameters, from what the residuals leave. Near copies
    count together, as corners of one photograph do.

    A corner far off pulls less than its distance says, and less the farther it is: so
    the loss is less curved than its weights are (P. J. Huber and E. M. Ronchetti 2009,
    section 7.6, doi:10.1002/9780470434697).
    """
    found = fit.result
    squares = np.sum(found.residuals**2, axis=2)
    weight, slope = tukey_pull(np.where(boards.seen, squares, np.inf), found.scales)
    right = weight > 0
    curved = max(np.sum(slope) / np.sum(weight), LEAST_CURVED)
    free = max(free_of(fit, boards) - 2 * np.count_nonzero(boards.seen & ~right), 1)
    pulls = np.sum(weight[right] ** 2 * squares[right])
    variance = pulls / free / (curved * np.mean(weight[right]))
    told = told_by_boards(
        fit.formula, found.values, found.T_camera_grid, boards, found.scales
    )
    normal, gradient = (boards.of_groups(each) for each in told)
    return clustered_covariance(normal * curved, gradient, max(variance, FLOOR_PX**2))


def free_of(fit, boards):
    """Coordinates less parameters."""
    count = 2 * np.count_nonzero(boards.seen)
    return max(count - len(fit.formula.names) - 6 * len(boards.seen), 1)
