"""Fit of a parametric lens model to boards or dense grids, without initial values.

The fit itself is in `raxel.calibration.parametric.lens_fit`. Here are the tests for an
entrance-pupil shift and for a board that is not flat.

Sources: Kannala and Brandt 2006, doi:10.1109/TPAMI.2006.153; Geyer and Daniilidis 2000,
doi:10.1007/3-540-45053-X_29.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc

from raxel.calibration.parametric.lens_bundle import (
    OUTLIER_SCALES,
    LensFormula,
    adjusted,
    stacked,
)
from raxel.calibration.parametric.lens_fit import (
    FIT_CACHE_SIZE,
    MAX_N_PUPIL_TERMS,
    MAX_N_RADIAL_TERMS,
    FormulaFit,
    GivenBoards,
    covariance_of,
    error_covariance,
    fitted_law,
    free_of,
    held_out_squares,
    refitted,
    start_of,
)
from raxel.calibration.parametric.opencv_fits import calibrate_zhang, found_corners
from raxel.calibration.views.correspondence import (
    BENDS,
    TERMS,
    BoardShape,
    BoardView,
    near_copies,
)
from raxel.calibration.views.dense import DenseView
from raxel.cameras.core.base import Camera
from raxel.cameras.lenses.moving_pupil import pupil_heights
from raxel.cameras.lenses.perspective import PerspectiveCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.poses import transform

# Test of the board's shape: flatness and aspect ratio. A camera absorbs most of a
# board's shape, and the errors of its rays are several times the residuals. The shape
# is therefore fitted with the camera: two bends, a twist, and the stretch of x against
# y. Two tests must support it. One compares the values with their covariance, for
# correlated corners of an image. The other requires a better prediction of held-out
# boards, beyond the scatter of the gain between boards. With few images there is no
# test, since bending of the board and lens distortion are then indistinguishable. The
# stretch requires boards that are rotated about the line of sight, or tilted: with
# upright boards only, non-square pixels have the same effect, and its standard
# deviation is large. Sources: J.-M. Lavest, M. Viala and M. Dhome 1998,
# doi:10.1007/BFb0055665; K. H. Strobl and G. Hirzinger 2011,
# doi:10.1109/ICCVW.2011.6130369.


STRETCH = TERMS[len(BENDS) :]
# One degree of freedom for each of four terms, and two more.
MIN_N_SHAPE_IMAGES = 6
# Of the test for correlated corners of an image.
BOARD_P_THRESHOLD = 1e-3
MIN_GAIN_SIGMAS = 2.0  # gain on held-out boards, in standard errors
MIN_BOARD_GAIN_PX = 1e-3  # smaller gains come from a nearly correct lens model


class BoardTest(NamedTuple):
    """Hold the test of whether the board has its stated shape.

    Attributes
    ----------
    shape : BoardShape
        Shape, estimated with no part of it taken as given.
    sd : ndarray, shape (4,)
        Predicted standard deviations of its values.
    used : tuple of str
        Names of the values that the fit of the camera took.
    p_bends, p_stretch : float
        How often a flat board gives as much.
    flat_px, shaped_px : float
        RMS distances on held-out boards, px, without the tested terms and with them;
        NaN where none was tested.
    """

    shape: BoardShape
    sd: np.ndarray
    used: tuple
    p_bends: float
    p_stretch: float
    flat_px: float
    shaped_px: float

    @property
    def taken(self) -> BoardShape:
        """Return the shape that the fit of the camera took: 0 for unused values."""
        values = [
            value if name in self.used else 0.0
            for name, value in zip(TERMS, self.shape.values, strict=True)
        ]
        return self.shape._replace(values=np.array(values))


def board_test(fit, boards, before=None):
    """BoardTest of a FormulaFit; None for too few images.

    Fitted shape values stay; the others are tested. before: the BoardTest that led to
    this fit, None for one of flat boards.
    """
    count = boards.groups.max() + 1
    if count < MIN_N_SHAPE_IMAGES:
        return None
    shape, covariance, estimated = _found_shape(fit, boards)
    p_values = [
        _wald(shape.values[own], estimated[own, own], count)
        for own in (slice(len(BENDS)), slice(len(BENDS), None))
    ]
    tested = tuple(
        name
        for names, p_value in zip((BENDS, STRETCH), p_values, strict=True)
        for name in names
        if p_value < BOARD_P_THRESHOLD or name in fit.formula.board
    )
    px = (before.flat_px, before.shaped_px) if before else (np.nan, np.nan)
    found = BoardTest(
        shape, np.sqrt(np.diag(covariance)), fit.formula.board, *p_values, *px
    )
    if tested == fit.formula.board:
        return found
    squares = [
        held_out_squares(each, boards)
        for each in (fit, _shaped_board(fit, tested, boards))
    ]
    gain = boards.of_groups(squares[0] - squares[1])
    gain /= np.bincount(boards.groups)
    error = np.std(gain, ddof=1) / np.sqrt(len(gain))
    pays = np.mean(gain) > max(MIN_GAIN_SIGMAS * error, MIN_BOARD_GAIN_PX**2)
    px = [float(np.sqrt(np.mean(of_boards))) for of_boards in squares]
    if before is None:
        found = found._replace(flat_px=px[0], shaped_px=px[1])
    return found._replace(used=tested, shaped_px=px[1]) if pays else found


def _found_shape(fit, boards):
    """BoardShape of a fit, the covariance (4, 4) of its values, and the estimate of it
    from the scatter. Values that the fit lacks come from a second fit, in which all are
    free."""
    free = _shaped_board(fit, TERMS, boards)
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
    """(2, P, P): of errors, and as estimated from the scatter."""
    found = covariance_of(fit, boards)
    return np.array([found.covariance, found.estimated])


def _shaped_board(fit, names, boards):
    formula = fit.formula._replace(board=names)
    return refitted(fit, formula, boards, "tukey", fit.result.scales)


def _wald(values, covariance, n_images):
    """p-value of values (k,) being 0; n_images: number of images behind the
    covariance."""
    ratio = values @ np.linalg.solve(covariance, values) / len(values)
    return float(fdtrc(len(values), n_images - 1, ratio))


# Test for an entrance-pupil shift along the axis. A shift bends the image as a function
# of the angle, as any radial term does, but more for near points than for far ones, as
# no radial term does. A law with too few radial terms absorbs its error in a shift. The
# comparison is therefore with a central law that has as many additional radial terms as
# the pupil has terms. It uses a likelihood-ratio test, which assumes independent
# corners, and, if that is significant, held-out boards. There the error must fall by a
# fraction that pays for a camera without a centre, and the gain must exceed its scatter
# between boards, in a sign-exchange (randomisation) test. If two laws disagree, the one
# with the better prediction of held-out boards counts; the other is undecided.
# Sources: entrance-pupil shift, Gennery 2006, doi:10.1007/s11263-006-5168-1; exchanged
# signs, Fisher, The Design of Experiments, 1935, section 21.


# Of the likelihood-ratio test: one false shift in a thousand central cameras.
PUPIL_P_THRESHOLD = 1e-3
# Fraction of the error on held-out boards. Many corners make any small misfit of a law
# significant. A shift that explains less than 5 % of the error (10 % of its square) is
# not worth a camera without a common point: no image of it is free of distortion.
MIN_PUPIL_GAIN = 0.05
MIN_RESIDUAL_PX = 1e-3  # smaller residuals contain no information on a pupil shift
# Of a gain on held-out boards: six of six boards suffice, five do not.
GAIN_P_THRESHOLD = 0.02
# Boards, or sums of boards, with exchanged signs: 2^14 combinations.
MAX_N_SIGN_EXCHANGES = 14
MOVES, RESTS, UNDECIDED = "moves", "rests", "undecided"


class PupilTest(NamedTuple):
    """Hold the test of whether the entrance pupil moves.

    Attributes
    ----------
    p_value : float
        Of the likelihood-ratio (F) test, for corners with independent errors.
    central_px, moving_px : float
        RMS distances on held-out boards, px, where the test is significant; else NaN,
        as `chance`, `shift` and `shift_sd`.
    chance : float
        How often exchanged signs give so large a gain.
    shift : float
        Motion of the pupil over the observed angles, in the unit of the board.
    shift_sd : float
        Its predicted standard deviation.
    verdict : str
        "moves", "rests" or "undecided".
    against : str
        A law that predicts boards better and gives another verdict; "" where there is
        none.
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
    def moves(self) -> bool:
        """Return whether all tests support a moving pupil."""
        return self.verdict == MOVES


class TestedLaw(NamedTuple):
    """A law, its FormulaFits with a fixed pupil (bent: with more radial terms), and its
    PupilTest."""

    law: str
    central: FormulaFit
    bent: FormulaFit
    test: PupilTest


def pupil_test(law, central, boards):
    """TestedLaw of a law's FormulaFit with a fixed pupil."""

    def again(fit, **terms):
        formula = fit.formula._replace(**terms)
        return refitted(fit, formula, boards, "tukey", central.result.scales)

    bent = again(central, radial=MAX_N_RADIAL_TERMS + MAX_N_PUPIL_TERMS)
    moving = [again(fit, pupil=MAX_N_PUPIL_TERMS) for fit in (central, bent)]
    p_value = _ratio_test(bent, moving[1], boards)
    if p_value > PUPIL_P_THRESHOLD:
        test = PupilTest(p_value, *[np.nan] * 5, RESTS)
        return TestedLaw(law, central, bent, test)
    _, without = _best((central, bent), boards)
    best, with_it = _best(moving, boards)
    errors = [_rms(squares, boards) for squares in (without, with_it)]
    gain = (without - with_it) * boards.seen.sum(axis=1)
    gain = boards.of_groups(gain)
    chance = _chance(gain[np.isfinite(gain)])
    verdict = _pupil_verdict(*errors, chance)
    test = PupilTest(p_value, *errors, chance, *pupil_shift(best, boards), verdict)
    return TestedLaw(law, central, bent, test)


def agreed(own, other, boards):
    """PupilTest of one TestedLaw in view of that of another law."""
    if own.test.verdict == other.test.verdict:
        return own.test
    if _error_px(own, boards) <= _error_px(other, boards):
        return own.test
    return own.test._replace(verdict=UNDECIDED, against=other.law)


def _pupil_verdict(central_px, moving_px, chance):
    if not moving_px < central_px:
        return RESTS
    large = moving_px <= (1 - MIN_PUPIL_GAIN) * central_px
    return MOVES if large and chance < GAIN_P_THRESHOLD else UNDECIDED


def _ratio_test(central, moving, boards):
    """p-value of the F test: the same model and loss, with and without a pupil
    shift."""
    free, q = free_of(moving, boards), moving.formula.pupil
    less, more = (
        max(fit.result.cost, free * MIN_RESIDUAL_PX**2) for fit in (central, moving)
    )
    return float(fdtrc(q, free, max(less - more, 0.0) / q / (more / free)))


def _best(fits, boards):
    """Fit with the best prediction of held-out boards, and its mean squares (n,)
    px^2."""
    tried = [(fit, held_out_squares(fit, boards)) for fit in fits]
    return min(tried, key=lambda each: _rms(each[1], boards))


def _rms(squares, boards):
    known = np.isfinite(squares)
    if not known.any():
        return np.inf
    weights = boards.seen.sum(axis=1)[known]
    return float(np.sqrt(np.average(squares[known], weights=weights)))


def _chance(gain):
    """Fraction of sign combinations of gains (n,) with a sum as large as theirs."""
    if len(gain) > MAX_N_SIGN_EXCHANGES:
        gain = np.bincount(np.arange(len(gain)) % MAX_N_SIGN_EXCHANGES, gain)
    signs = 1.0 - 2 * (np.arange(2 ** len(gain))[:, None] >> np.arange(len(gain)) & 1)
    return float(np.mean(signs @ gain >= gain.sum() * (1 - 1e-12)))


def _error_px(asked, boards):
    """RMS distance on held-out boards of the best prediction."""
    test = asked.test
    if np.isfinite(test.central_px):
        return min(test.central_px, test.moving_px)
    return _rms(_best((asked.central, asked.bent), boards)[1], boards)


def pupil_shift(fit, boards):
    """Shift of the pupil over the observed angles, and its standard deviation."""
    points = transform(fit.result.T_camera_grid, boards.points)[boards.seen]
    theta = np.arctan2(np.hypot(*points[:, :2].T), points[:, 2]).max()
    a = fit.formula.parts(fit.result.values)[3]
    first = fit.formula.names.index("a1")
    own = slice(first, first + len(a))
    powers = theta ** (2 * np.arange(1, len(a) + 1))
    covariance = covariance_of(fit, boards).covariance[own, own]
    shift = pupil_heights(theta, a)[0]
    return float(shift), float(np.sqrt(max(powers @ covariance @ powers, 0.0)))


LAWS = ("kannala-brandt", "unified")


class WrongCorner(NamedTuple):
    """Describe a rejected corner, which has zero weight.

    Attributes
    ----------
    view, corner : int
        Indices of the view and the corner.
    name : str
        Name of the view.
    distance_px : float
        Distance from where the camera sees the corner, px.
    """

    view: int
    corner: int
    name: str
    distance_px: float


class LensCalibration(NamedTuple):
    """Hold a camera from `calibrate_lens`.

    Attributes
    ----------
    camera : Camera
        The camera.
    T_camera_grid : ndarray, shape (n, 4, 4)
        One pose per view, in the unit of the board.
    rms_px : float
        Root mean square distance of all corners, wrong ones among them, px.
    formula : LensFormula
        Terms of the camera.
    values : ndarray, shape (P,)
        Its parameters.
    covariance : ndarray, shape (P, P)
        Covariance of the parameters.
    error_factor : float
        How much larger their standard deviations are than for independent errors of
        corners (`raxel.calibration.parametric.lens_fit`).
    wrong : list of WrongCorner
        Rejected corners.
    pupil : PupilTest or None
        None where the pupil was not tested.
    board : BoardTest or None
        None where the board was not tested.
    terms : tuple
        LensFormula, values and covariance of all terms whose errors move rays.
    """

    camera: Camera
    T_camera_grid: np.ndarray
    rms_px: float
    formula: LensFormula
    values: np.ndarray
    covariance: np.ndarray
    error_factor: float
    wrong: list
    pupil: PupilTest | None
    board: BoardTest | None
    terms: tuple


class _Proposal(NamedTuple):
    fit: FormulaFit
    pupil: PupilTest | None
    board: BoardTest | None


def calibrate_lens(
    views: Sequence[BoardView | DenseView],
    width: int,
    height: int,
    law: str,
    *,
    pupil: str = "by test",
    board: str = "by test",
) -> LensCalibration:
    """Calibrate a parametric camera model from views of a planar board.

    No start is needed. Lens and sensor may be decentred; there is no skew.

    Parameters
    ----------
    views : sequence of BoardView or DenseView
        Two or more views. Only the corners (the pixels of the lattice) that were found
        count, all alike.
    width, height : int
        Size of the image, px.
    law : {"kannala-brandt", "unified"}
        Law of the lens.
    pupil : {"by test", "fixed", "moving"}
        "fixed" gives a central camera; "by test" decides between the two.
    board : {"by test", "flat"}
        "by test" bends and stretches the board where the data support it.

    Returns
    -------
    LensCalibration
        The camera, its parameters and the poses.

    Raises
    ------
    ValueError
        If `law`, `pupil` or `board` is another name.
    InputError
        As `calibrate_zhang`.
    CalibrationError
        If no start leads to a camera, or the views do not determine it.
    """
    if law not in LAWS:
        raise ValueError(f"law: found {law!r}; give one of {', '.join(LAWS)}")
    if pupil not in ("by test", "fixed", "moving"):
        raise ValueError(f"pupil: found {pupil!r}; give 'by test', 'fixed' or 'moving'")
    if board not in ("by test", "flat"):
        raise ValueError(f"board: found {board!r}; give 'by test' or 'flat'")
    boards = _boards_of(views, law)
    given = GivenBoards(boards, width, height)
    if pupil == "by test":
        *_, found = _proposed(law, given, board == "flat")
    else:
        terms = MAX_N_PUPIL_TERMS * (pupil == "moving")
        found = _shaped(law, given, terms, board == "flat")
    return _completed(found, boards, views, width, height)


def proposed_lenses(
    views: Sequence[BoardView | DenseView],
    width: int,
    height: int,
    board: str = "by test",
    pupil: str = "by test",
) -> tuple[list[LensCalibration], list[str]]:
    """Return every formula that may serve.

    For each law this is that of a central lens. If the pupil moves, that of a lens with
    a moving pupil is added.

    Parameters
    ----------
    views : sequence of BoardView or DenseView
        Two or more views. Only the corners (the pixels of the lattice) that were found
        count, all alike.
    width, height : int
        Size of the image, px.
    board : {"by test", "flat"}
    pupil : {"by test", "fixed", "moving"}
        As of `calibrate_lens`.

    Returns
    -------
    found : list of LensCalibration
        The formulas.
    faults : list of str
        Reasons why others are not included.

    Raises
    ------
    InputError
        As `calibrate_zhang`.
    """
    boards = _boards_of(views, "lens formula")
    given, found, faults = GivenBoards(boards, width, height), [], []
    flat = board == "flat"
    for law in LAWS:
        if pupil == "by test":
            proposals = _proposed(law, given, flat)
        else:
            tried = (0, MAX_N_PUPIL_TERMS) if pupil == "moving" else (0,)
            proposals = [_shaped(law, given, terms, flat) for terms in tried]
        for each in proposals:
            try:
                found.append(_completed(each, boards, views, width, height))
            except CalibrationError as fault:
                faults.append(str(fault))
    return found, faults


def _boards_of(views, method):
    corners = [found_corners(view) for view in views]
    if len(corners) < 2:
        raise InputError(
            f"{method}: found {len(corners)} view; give two or more boards at "
            "different tilts"
        )
    return stacked(corners, near_copies(views))


@lru_cache(maxsize=FIT_CACHE_SIZE * len(LAWS))
def _tested_law(law, given, flat):
    """_Proposal of a central lens, and the TestedLaw on its pupil."""
    central = _shaped(law, given, 0, flat)
    return central, pupil_test(law, central.fit, given.boards)


@lru_cache(maxsize=FIT_CACHE_SIZE * len(LAWS))
def _proposed(law, given, flat=False):
    """_Proposal of a central lens; then, if all tests support it, that of one with a
    pupil shift."""
    boards = given.boards
    central, tested = _tested_law(law, given, flat)
    test = tested.test
    for other in LAWS:
        if test.p_value <= PUPIL_P_THRESHOLD and other != law:
            test = agreed(tested, _tested_law(other, given, flat)[1], boards)
    found = [central._replace(pupil=test)]
    if test.moves:
        # A pupil shift may have appeared as a bent board.
        again = _shaped(law, given, MAX_N_PUPIL_TERMS, flat)
        shift, sd = pupil_shift(again.fit, boards)
        test = test._replace(shift=shift, shift_sd=sd)
        found = [each._replace(pupil=test) for each in (central, again)]
    return found


@lru_cache(maxsize=2 * FIT_CACHE_SIZE * len(LAWS))
def _shaped(law, given, pupil, flat):
    """_Proposal of a law with this number of pupil terms, and its board by test."""
    start, boards = start_of(given), given.boards
    fit = fitted_law(law, start, boards, pupil)
    test = None if flat else board_test(fit, boards)
    while test and test.used != fit.formula.board:
        fit = fitted_law(law, start, boards, pupil, test.used)
        test = board_test(fit, boards, test)
    return _Proposal(fit, None, test)


# --------------------------------------------------------------------------- the result


def _completed(proposal, boards, views, width, height):
    formula, result = proposal.fit
    # Copies: callers must not change the cached values.
    values, poses = result.values.copy(), result.T_camera_grid.copy()
    covariance, factor, terms = error_covariance(proposal.fit, boards)
    camera = formula.camera(values, width, height)
    distances = np.linalg.norm(result.residuals, axis=2)
    errors = distances > OUTLIER_SCALES * result.scales[:, None]
    placed = boards.placed(formula, values)
    valid = camera.project(transform(poses, placed).reshape(-1, 3)).valid
    unseen = boards.seen & ~valid.reshape(boards.seen.shape) & ~errors
    if unseen.any():
        raise CalibrationError(
            f"{formula.base}: the fitted camera folds the image at "
            f"{np.count_nonzero(unseen)} corners; check the corners, or give more "
            "boards",
            code="no-camera",
        )
    wrong = []
    for view, place in np.argwhere(errors & boards.seen):
        found = np.flatnonzero(np.isfinite(np.asarray(views[view].pixels)[:, 0]))
        name = views[view].name or f"view {view}"
        wrong.append(
            WrongCorner(
                int(view), int(found[place]), name, float(distances[view, place])
            )
        )
    rms = float(np.sqrt(np.mean(distances[boards.seen] ** 2)))
    return LensCalibration(
        camera, poses, rms, formula, values, covariance, factor,
        wrong, proposal.pupil, proposal.board, terms,
    )  # fmt: skip


# Zhang's pinhole camera with standard deviations and the board's shape. The fit is that
# of `calibrate_zhang`. A further adjustment of the same terms and the poses gives their
# covariance, and estimates a bent or stretched board, as for other models. For a flat
# board the camera remains that of OpenCV.


PINHOLE = LensFormula("perspective", 2, 0, 0)


class PinholeCalibration(NamedTuple):
    """Hold a camera from `calibrate_pinhole`.

    Attributes
    ----------
    camera : PerspectiveCamera
        The camera.
    T_camera_grid : ndarray, shape (n, 4, 4)
        One pose per view, in the unit of the board.
    formula : LensFormula
        Names of the parameters.
    values : ndarray, shape (P,)
        The parameters.
    covariance : ndarray, shape (P, P), or None
        Their covariance; None where points lie behind what was fitted.
    error_factor, board, terms
        As of a LensCalibration; terms is None where covariance is.
    """

    camera: PerspectiveCamera
    T_camera_grid: np.ndarray
    formula: LensFormula
    values: np.ndarray
    covariance: np.ndarray | None
    error_factor: float
    board: BoardTest | None
    terms: tuple | None = None


def calibrate_pinhole(
    views: Sequence[BoardView | DenseView], width: int, height: int
) -> PinholeCalibration:
    """Calibrate a pinhole camera with its covariance from views of a planar board.

    Parameters and errors are those of `calibrate_zhang`.
    """
    found = calibrate_zhang(views, width, height)
    K = found.camera.K
    values = np.array([K[0, 0], K[1, 1], *K[:2, 2], *found.camera.radial])
    boards = stacked([found_corners(view) for view in views], near_copies(views))
    fit = FormulaFit(
        PINHOLE, adjusted(PINHOLE, values, found.T_camera_grid, boards, "tukey")
    )
    if not np.isfinite(fit.result.cost):
        return PinholeCalibration(
            found.camera, found.T_camera_grid, PINHOLE, values, None, np.nan, None
        )
    test = board_test(fit, boards)
    while test and test.used != fit.formula.board:
        formula = PINHOLE._replace(board=test.used)
        fit = refitted(fit, formula, boards, "tukey")
        test = board_test(fit, boards, test)
    camera, poses = found.camera, found.T_camera_grid
    if fit.formula.board:
        values, poses = fit.result.values, fit.result.T_camera_grid
        fx, fy, cx, cy, *radial = values[: len(PINHOLE.names)]
        K = [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]
        camera = PerspectiveCamera(K, radial, width, height)
    covariance, factor, terms = error_covariance(fit, boards)
    return PinholeCalibration(
        camera, poses, fit.formula, values, covariance, factor, test, terms
    )
