"""Is a lens central, or does its entrance pupil move along the axis?

It is asked twice, of a likelihood-ratio test and of the error on boards that are kept
out; the pupil moves if both say so.

Source: the moving pupil, Gennery 2006, doi:10.1007/s11263-006-5168-1.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.parametric.lens_fit import (
    PUPIL,
    covariance_of,
    fitted_law,
    free_of,
    kept_out_px,
    refitted,
)
from raxel.cameras.lenses.moving_pupil import pupil_heights
from raxel.geometry.poses import transform

SURE = 1e-3  # of the ratio test
MIN_RESIDUAL_PX = 1e-3  # residuals below it tell nothing of a pupil


class PupilTest(NamedTuple):
    """Does the entrance pupil move? p_value: of the likelihood-ratio (F) test, for
    corners that err independently; where it says yes, central_px and moving_px: RMS
    distances on boards kept out, and shift: how far the pupil moves over the angles
    seen, in the board's unit, with shift_sd (else NaN); moves: whether both say so."""

    p_value: float
    central_px: float
    moving_px: float
    shift: float
    shift_sd: float
    moves: bool


def pupil_test(central, start, boards):
    """The best FormulaFit with a moving pupil, and the PupilTest that compares it."""
    wider = central.formula._replace(pupil=PUPIL)
    moving = refitted(central, wider, boards, "tukey", central.result.scales)
    p_value = _ratio_test(central, moving, boards)
    if p_value > SURE:
        return moving, PupilTest(p_value, *[np.nan] * 4, False)
    law, board = central.formula.base, central.formula.board
    moving = fitted_law(law, start, boards, PUPIL, board)
    errors = [kept_out_px(fit, boards) for fit in (central, moving)]
    shift, sd = _pupil_shift(moving, boards)
    return moving, PupilTest(p_value, *errors, shift, sd, errors[1] < errors[0])


def _ratio_test(central, moving, boards):
    """p-value of the F test: the same formula and loss, with and without a pupil that
    moves."""
    from scipy.stats import f as fisher

    fixed = refitted(central, central.formula, boards, "tukey", moving.result.scales)
    free, q = free_of(moving, boards), moving.formula.pupil
    less, more = (
        max(fit.result.cost, free * MIN_RESIDUAL_PX**2) for fit in (fixed, moving)
    )
    return float(fisher.sf((less - more) / q / (more / free), q, free))


def _pupil_shift(fit, boards):
    """How far the pupil moves over the angles that are seen, and its deviation."""
    points = transform(fit.result.T_camera_grid, boards.points)[boards.seen]
    theta = np.arctan2(np.hypot(*points[:, :2].T), points[:, 2]).max()
    a = fit.formula.parts(fit.result.values)[3]
    first = fit.formula.names.index("a1")
    own = slice(first, first + len(a))
    powers = theta ** (2 * np.arange(1, len(a) + 1))
    covariance = covariance_of(fit, boards).covariance[own, own]
    shift = pupil_heights(np.array([theta]), a)[0][0]
    return float(shift), float(np.sqrt(max(powers @ covariance @ powers, 0.0)))
