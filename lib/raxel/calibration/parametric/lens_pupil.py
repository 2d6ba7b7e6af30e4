"""Is a lens central, or does its entrance pupil move along the axis?

A pupil that moves bends the image in the angle alone, as any radial term does, and more
for near points than for far ones, as none does. A law that lacks a lens's bend takes a
moving pupil for it. So it is asked beside a law that has as many radial terms more as
the pupil has of its own, of a likelihood-ratio test, which takes every corner to err
for itself; and where that says yes, of boards that are kept out. There the gain must be
larger than boards scatter: its sign could as well have been the other one on each of
them, and only in few of all such draws is their sum so large. Where two laws are asked
and say otherwise, that one counts which predicts kept-out boards better; the other is
undecided.

Sources: the moving pupil, Gennery 2006, doi:10.1007/s11263-006-5168-1; signs exchanged,
Fisher, The Design of Experiments, 1935, section 21.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.parametric.lens_fit import (
    PUPIL,
    RADIAL,
    FormulaFit,
    covariance_of,
    free_of,
    kept_out_squares,
    refitted,
)
from raxel.cameras.lenses.moving_pupil import pupil_heights
from raxel.geometry.poses import transform

SURE = 1e-3  # of the ratio test
MIN_RESIDUAL_PX = 1e-3  # residuals below it tell nothing of a pupil
CHANCE = 0.02  # of a gain on kept-out boards: six of six boards are enough, five not
LEAST_GAIN_PX = 0.01  # no corner is known better
DRAWN = 14  # boards, or sums of some, whose signs are exchanged: 2^14 draws
MOVES, RESTS, UNDECIDED = "moves", "rests", "undecided"


class PupilTest(NamedTuple):
    """Does the entrance pupil move?

    verdict: "moves", "rests" or "undecided". p_value: of the likelihood-ratio (F) test,
    for corners that err independently; where it finds something, central_px and
    moving_px: RMS distances on boards kept out, chance: how often exchanged signs make
    so large a gain of them, and shift: how far the pupil moves over the angles seen, in
    the board's unit, with shift_sd (else NaN). against: a law that predicts boards
    better and says otherwise, "" where there is none.
    """

    p_value: float
    central_px: float
    moving_px: float
    chance: float
    shift: float
    shift_sd: float
    verdict: str
    against: str = ""

    @property
    def moves(self):
        """Whether all that was asked says so."""
        return self.verdict == MOVES


class AskedLaw(NamedTuple):
    """A law, its FormulaFits with a pupil that rests (bent: with more radial terms),
    and the PupilTest that asks whether it does."""

    law: str
    central: FormulaFit
    bent: FormulaFit
    test: PupilTest


def pupil_test(law, central, boards):
    """AskedLaw of a law's FormulaFit with a pupil that rests."""

    def again(fit, **terms):
        formula = fit.formula._replace(**terms)
        return refitted(fit, formula, boards, "tukey", central.result.scales)

    bent = again(central, radial=RADIAL + PUPIL)
    moving = [again(fit, pupil=PUPIL) for fit in (central, bent)]
    p_value = _ratio_test(bent, moving[1], boards)
    if p_value > SURE:
        test = PupilTest(p_value, *[np.nan] * 5, RESTS)
        return AskedLaw(law, central, bent, test)
    _, without = _best((central, bent), boards)
    best, with_it = _best(moving, boards)
    errors = [_rms(squares, boards) for squares in (without, with_it)]
    gain = (without - with_it) * boards.seen.sum(axis=1)
    gain = boards.of_groups(gain)
    chance = _chance(gain[np.isfinite(gain)])
    verdict = _said(*errors, chance)
    test = PupilTest(p_value, *errors, chance, *pupil_shift(best, boards), verdict)
    return AskedLaw(law, central, bent, test)


def agreed(own, other, boards):
    """The PupilTest of one AskedLaw beside that of another law."""
    if own.test.verdict == other.test.verdict:
        return own.test
    if _error_px(own, boards) <= _error_px(other, boards):
        return own.test
    return own.test._replace(verdict=UNDECIDED, against=other.law)


def _said(central_px, moving_px, chance):
    if not moving_px < central_px:
        return RESTS
    if chance < CHANCE and central_px**2 - moving_px**2 > LEAST_GAIN_PX**2:
        return MOVES
    return UNDECIDED


def _ratio_test(central, moving, boards):
    """p-value of the F test: the same formula and loss, with and without a pupil that
    moves."""
    from scipy.stats import f as fisher

    free, q = free_of(moving, boards), moving.formula.pupil
    less, more = (
        max(fit.result.cost, free * MIN_RESIDUAL_PX**2) for fit in (central, moving)
    )
    return float(fisher.sf((less - more) / q / (more / free), q, free))


def _best(fits, boards):
    """The fit that predicts kept-out boards best, and its mean squares (n,) px^2."""
    tried = [(fit, kept_out_squares(fit, boards)) for fit in fits]
    return min(tried, key=lambda each: _rms(each[1], boards))


def _rms(squares, boards):
    known = np.isfinite(squares)
    if not known.any():
        return np.inf
    weights = boards.seen.sum(axis=1)[known]
    return float(np.sqrt(np.average(squares[known], weights=weights)))


def _chance(gain):
    """How often the sum of gains (n,), each of either sign, is as large as theirs."""
    if len(gain) > DRAWN:
        gain = np.bincount(np.arange(len(gain)) % DRAWN, gain)
    signs = 1.0 - 2 * (np.arange(2 ** len(gain))[:, None] >> np.arange(len(gain)) & 1)
    return float(np.mean(signs @ gain >= gain.sum() * (1 - 1e-12)))


def _error_px(asked, boards):
    """RMS distance on kept-out boards by what predicts them best."""
    test = asked.test
    if np.isfinite(test.central_px):
        return min(test.central_px, test.moving_px)
    return _rms(_best((asked.central, asked.bent), boards)[1], boards)


def pupil_shift(fit, boards):
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
