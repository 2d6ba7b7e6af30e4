"""Is the board flat, and as long one way as the other, as it is said to be?

A camera takes in most of a board's shape, and its rays are off by several times what
the residuals show. So the shape is fitted with the camera: two bends and a twist, and
how much longer x is against y. It is used where two tests ask for it. One holds what
was found against its covariance, for corners that err together within a photograph; the
other asks whether boards that are kept out are predicted better, beyond what the gain
scatters by from board to board. With few photographs nothing is asked, since a bend of
the board and one of the lens are then the same.

That x is longer is told by boards turned about the line of sight, or tilted: with all
boards upright the camera's pixels may as well be oblong. Its standard deviation says so
by itself. Sources of the idea that the board is to be fitted, too: J.-M. Lavest, M.
Viala and M. Dhome 1998, doi:10.1007/BFb0055665; K. H. Strobl and G. Hirzinger 2011,
doi:10.1109/ICCVW.2011.6130369.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.parametric.lens_fit import (
    covariance_of,
    kept_out_squares,
    refitted,
)
from raxel.calibration.views.board_shape import BENDS, TERMS, BoardShape

STRETCH = TERMS[len(BENDS) :]
FEWEST = 6  # photographs: a degree of freedom for each of four terms, and two
SURE = 1e-3  # of the test that takes corners of a photograph to err together
GAIN = 2.0  # standard errors of the gain on boards kept out
MIN_GAIN_PX = 1e-3  # a smaller one is a formula's that is nearly the lens's


class BoardTest(NamedTuple):
    """Is the board as it is said to be? shape: BoardShape, as found where nothing of it
    is taken as given; sd (4,) of its values; used: names of those that the camera's
    fit took; p_bends and p_stretch: how often a flat board does as much; flat_px,
    shaped_px: RMS distances on boards kept out, without the terms asked for and with
    them, NaN where none was asked for."""

    shape: BoardShape
    sd: np.ndarray
    used: tuple
    p_bends: float
    p_stretch: float
    flat_px: float
    shaped_px: float

    @property
    def taken(self):
        """The BoardShape that the camera's fit took: 0 for what is not used."""
        values = [
            value if name in self.used else 0.0
            for name, value in zip(TERMS, self.shape.values, strict=True)
        ]
        return self.shape._replace(values=np.array(values))


def board_test(fit, boards, before=None):
    """BoardTest of a FormulaFit; None for too few photographs.

    What the fit has of the shape stays; of the rest is asked whether it is to be used.
    before: the BoardTest that led to this fit, None for one of flat boards.
    """
    count = boards.groups.max() + 1
    if count < FEWEST:
        return None
    shape, covariance, estimated = _found_shape(fit, boards)
    p_values = [
        _wald(shape.values[own], estimated[own, own], count)
        for own in (slice(len(BENDS)), slice(len(BENDS), None))
    ]
    asked = tuple(
        name
        for names, p_value in zip((BENDS, STRETCH), p_values, strict=True)
        for name in names
        if p_value < SURE or name in fit.formula.board
    )
    px = (before.flat_px, before.shaped_px) if before else (np.nan, np.nan)
    found = BoardTest(
        shape, np.sqrt(np.diag(covariance)), fit.formula.board, *p_values, *px
    )
    if asked == fit.formula.board:
        return found
    squares = [
        kept_out_squares(each, boards) for each in (fit, _shaped(fit, asked, boards))
    ]
    gain = boards.of_groups(squares[0] - squares[1])
    gain /= np.bincount(boards.groups)
    error = np.std(gain, ddof=1) / np.sqrt(len(gain))
    pays = np.mean(gain) > max(GAIN * error, MIN_GAIN_PX**2)
    px = [float(np.sqrt(np.mean(of_boards))) for of_boards in squares]
    if before is None:
        found = found._replace(flat_px=px[0], shaped_px=px[1])
    return found._replace(used=asked, shaped_px=px[1]) if pays else found


def _found_shape(fit, boards):
    """The BoardShape of a fit, the covariance (4, 4) of its values and the same as it
    is estimated; those that the fit has none of come from another, in which all are
    free."""
    free = _shaped(fit, TERMS, boards)
    own = slice(-len(TERMS), None)
    covariances = _covariances(free, boards)[:, own, own].copy()
    values = free.result.values[own].copy()
    if fit.formula.board:
        of_fit = [fit.formula.names.index(name) for name in fit.formula.board]
        of_shape = [TERMS.index(name) for name in fit.formula.board]
        values[of_shape] = fit.result.values[of_fit]
        of_board = _covariances(fit, boards)[:, of_fit][:, :, of_fit]
        covariances[np.ix_((0, 1), of_shape, of_shape)] = of_board
    shape = boards.shape(free.formula, free.result.values)
    return shape._replace(values=values), *covariances


def _covariances(fit, boards):
    """(2, P, P): of errors, and as it is estimated."""
    found = covariance_of(fit, boards)
    return np.array([found.covariance, found.estimated])


def _shaped(fit, names, boards):
    formula = fit.formula._replace(board=names)
    return refitted(fit, formula, boards, "tukey", fit.result.scales)


def _wald(values, covariance, photographs):
    """p-value of values (k,) being 0; photographs: what the covariance was told by."""
    from scipy.stats import f as fisher

    ratio = values @ np.linalg.solve(covariance, values) / len(values)
    return float(fisher.sf(ratio, len(values), photographs - 1))
