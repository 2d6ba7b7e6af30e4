"""A lens formula fitted to boards or dense grids, without a guess.

The start knows no lens: poses of all boards from the azimuths of their corners
(`raxel.calibration.parametric.radial_alignment`). From there an adjustment of formula
and poses together (`raxel.calibration.parametric.lens_bundle`) goes from few terms to
all of them, and back to those that the corners ask for (Schwarz's criterion). Whether
the entrance pupil moves along the axis is asked twice, of a likelihood-ratio test and
of the error on boards that are kept out; it moves if both say so.

Sources: Kannala and Brandt 2006, doi:10.1109/TPAMI.2006.153; Geyer and Daniilidis 2000,
doi:10.1007/3-540-45053-X_29; the moving pupil, Gennery 2006,
doi:10.1007/s11263-006-5168-1; G. Schwarz 1978, doi:10.1214/aos/1176344136.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from raxel.calibration.parametric.lens_bundle import (
    WIDTH,
    AdjustedLens,
    adjusted,
    posed_residuals,
    stacked,
)
from raxel.calibration.parametric.lens_laws import LensFormula
from raxel.calibration.parametric.radial_alignment import aligned_starts
from raxel.calibration.parametric.zhang import found_corners
from raxel.cameras.core.base import Camera
from raxel.cameras.lenses.moving_pupil import pupil_heights
from raxel.errors import CalibrationError, InputError
from raxel.geometry.poses import transform

LAWS = ("kannala-brandt", "unified")
RADIAL, DECENTRING, PUPIL = 4, 4, 3  # terms at most
FIRST_XI = (0.0, 1.0, 2.0)  # a pinhole, a paraboloid, a fisheye
SURE = 1e-3  # of the ratio test
PARTS = 5  # of the boards, kept out in turn
FLOOR_PX = 1e-6  # residuals below it are as good as none
MIN_RESIDUAL_PX = 1e-3  # residuals below it tell nothing of a pupil
KEPT = 8  # sets of boards whose fits are remembered
UNDETERMINED = 0.2  # of a focal length, as its standard deviation


class WrongCorner(NamedTuple):
    """A corner that counts for nothing: view, corner (indices), name of the view, and
    its distance in px from where the camera sees it."""

    view: int
    corner: int
    name: str
    distance_px: float


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


class LensCalibration(NamedTuple):
    """camera; T_camera_grid (n, 4, 4), one pose per view in the board's unit; rms_px:
    root mean square distance of all corners, wrong ones among them; formula: its terms;
    values (P,) and covariance (P, P) of its parameters; wrong: WrongCorners;
    pupil: PupilTest, None where nothing was tested.
    """

    camera: Camera
    T_camera_grid: np.ndarray
    rms_px: float
    formula: LensFormula
    values: np.ndarray
    covariance: np.ndarray
    wrong: list
    pupil: PupilTest | None


class _FormulaFit(NamedTuple):
    formula: LensFormula
    result: AdjustedLens


def calibrate_lens(views, width, height, law, *, pupil="by test"):
    """A lens formula from views of a planar board, with no start given.

    views: two or more BoardViews or DenseViews, of which only the corners (the
    lattice's pixels) that were found count, all alike; width, height: the image in px.
    law: "kannala-brandt" or "unified". pupil: "fixed" (a central camera), "moving", or
    "by test", which decides between the two. Lens and sensor may be decentred; there is
    no skew.

    Returns LensCalibration. Raises InputError as `calibrate_zhang` does;
    CalibrationError: no start leads to a camera, or the views do not determine it.
    """
    if law not in LAWS:
        raise ValueError(f"law: {law!r}; give one of {', '.join(LAWS)}")
    if pupil not in ("by test", "fixed", "moving"):
        raise ValueError(f"pupil: {pupil!r}; 'by test', 'fixed' or 'moving'")
    boards = _boards_of(views, law)
    given, test = _Given(boards, width, height), None
    start = _start(given)
    if pupil == "by test":
        *_, (fit, test) = _proposed(law, given)
    else:
        fit = _fitted(law, start, boards, PUPIL * (pupil == "moving"))
    return _completed(fit, boards, views, test, width, height)


def proposed_lenses(views, width, height):
    """Every formula that may serve: of each law that of a central lens, and where both
    tests say that the pupil moves, that of a lens whose pupil does.

    Returns a list of LensCalibrations and one of the reasons why others are none.
    Raises as `calibrate_lens` does before a law is fitted.
    """
    boards = _boards_of(views, "lens formula")
    given, found, faults = _Given(boards, width, height), [], []
    for law in LAWS:
        for fit, test in _proposed(law, given):
            try:
                found.append(_completed(fit, boards, views, test, width, height))
            except CalibrationError as fault:
                faults.append(str(fault))
    return found, faults


def _boards_of(views, method):
    corners = [found_corners(view) for view in views]
    if len(corners) < 2:
        raise InputError(
            f"{method}: {len(corners)} view given; two or more boards at different"
            " tilts are needed"
        )
    return stacked(corners)


# ---------------------------------------------------------------- from nothing to a fit


class _Given:
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
def _start(given):
    """The best fit of r = F theta (1 + k1 theta^2) from the starts that are tried."""
    boards, width, height = given.boards, given.width, given.height
    fits = []
    for start in aligned_starts(
        boards.pixels, boards.points[..., :2], boards.seen, width, height
    ):
        formula = LensFormula("kannala-brandt", int(start.k1 != 0), 0, 0)
        values = [start.focal_px, start.focal_px, *start.centre, start.k1]
        values = values[: len(formula.names)]
        fit = _FormulaFit(
            formula, adjusted(formula, values, start.T_camera_grid, boards, "cauchy")
        )
        fits.append(_refit(fit, formula._replace(radial=1), boards, "cauchy"))
    sound = [fit for fit in fits if np.isfinite(fit.result.cost)]
    if not sound:
        raise CalibrationError(
            "lens formula: no start leads to poses of the boards; are the corners in"
            " the order of their rows?"
        )
    return min(sound, key=lambda fit: np.median(fit.result.scales))


def _fitted(law, start, boards, pupil):
    """The _FormulaFit of a law, with the terms that the corners ask for."""
    fit = start if law == "kannala-brandt" else _on_sphere(start, boards)
    for radial, decentring, moving in (
        (2, 2, min(pupil, 1)),
        (RADIAL, DECENTRING, pupil),
    ):
        wider = LensFormula(law, radial, decentring, moving)
        fit = _refit(fit, wider, boards, "tukey")
    return _thinned(fit, boards)


def _on_sphere(start, boards):
    """The best _FormulaFit of a unified sphere with one radial term."""
    fits, formula = [], LensFormula("unified", 1, 0, 0)
    for xi in FIRST_XI:
        values = np.array([*start.result.values[:4], xi, 0.0])
        poses = start.result.T_camera_grid
        fits.append(
            _FormulaFit(formula, adjusted(formula, values, poses, boards, "cauchy"))
        )
    return min(fits, key=lambda fit: np.median(fit.result.scales))


def _refit(fit, formula, boards, loss, scales=None):
    values = fit.formula.moved_to(formula, fit.result.values)
    result = adjusted(formula, values, fit.result.T_camera_grid, boards, loss, scales)
    return _FormulaFit(formula, result)


def _thinned(fit, boards):
    """The _FormulaFit without the terms that do not pay, one after the other."""
    scales = fit.result.scales
    fit = _refit(fit, fit.formula, boards, "tukey", scales)
    best = _criterion(fit, boards)
    while True:
        tried = [
            _refit(fit, formula, boards, "tukey", scales)
            for formula in _narrower(fit.formula)
        ]
        least = min(tried, key=lambda other: _criterion(other, boards), default=None)
        if least is None or _criterion(least, boards) > best:
            return fit
        fit, best = least, _criterion(least, boards)


def _narrower(formula):
    """The formulas with a step fewer terms of one sort; a pupil that moves stays so."""
    if formula.radial > 1:
        yield formula._replace(radial=formula.radial - 1)
    if formula.decentring:
        yield formula._replace(decentring=formula.decentring - 2)
    if formula.pupil > 1:
        yield formula._replace(pupil=formula.pupil - 1)


def _criterion(fit, boards):
    """Schwarz's: what a fit's loss and its number of parameters cost together."""
    count = 2 * np.count_nonzero(boards.seen)
    cost = max(fit.result.cost, count * FLOOR_PX**2)
    return count * np.log(cost) + len(fit.formula.names) * np.log(count)


# ----------------------------------------------------------------- is the lens central?


@lru_cache(maxsize=KEPT * len(LAWS))
def _proposed(law, given):
    """(_FormulaFit, PupilTest) of a central lens; then, if both tests say so, of one
    whose pupil moves."""
    start, boards = _start(given), given.boards
    central = _fitted(law, start, boards, 0)
    moving, test = _pupil_test(central, start, boards)
    return tuple((fit, test) for fit in (central, moving)[: 1 + test.moves])


def _pupil_test(central, start, boards):
    """The best _FormulaFit with a moving pupil, and the PupilTest that compares it."""
    wider = central.formula._replace(pupil=PUPIL)
    moving = _refit(central, wider, boards, "tukey", central.result.scales)
    p_value = _ratio_test(central, moving, boards)
    if p_value > SURE:
        return moving, PupilTest(p_value, *[np.nan] * 4, False)
    moving = _fitted(central.formula.base, start, boards, PUPIL)
    errors = [_kept_out_px(fit, boards) for fit in (central, moving)]
    shift, sd = _pupil_shift(moving, boards)
    return moving, PupilTest(p_value, *errors, shift, sd, errors[1] < errors[0])


def _ratio_test(central, moving, boards):
    """p-value of the F test: the same formula and loss, with and without a pupil that
    moves."""
    from scipy.stats import f as fisher

    fixed = _refit(central, central.formula, boards, "tukey", moving.result.scales)
    free, q = _free(moving, boards), moving.formula.pupil
    less, more = (
        max(fit.result.cost, free * MIN_RESIDUAL_PX**2) for fit in (fixed, moving)
    )
    return float(fisher.sf((less - more) / q / (more / free), q, free))


def _kept_out_px(fit, boards):
    """RMS distance, px, of boards that were kept out of fits with the same terms; a
    corner counts as at most WIDTH scales of its board off."""
    n = len(boards.seen)
    squares = []
    for part in range(min(PARTS, n)):
        out = np.arange(n) % min(PARTS, n) == part
        if n - out.sum() < 2:
            continue
        inside, scales = boards.some(~out), fit.result.scales
        poses = fit.result.T_camera_grid
        found = adjusted(
            fit.formula, fit.result.values, poses[~out], inside, "tukey", scales[~out]
        )
        off = posed_residuals(fit.formula, found.values, poses[out], boards.some(out))
        squares.append(np.sum(off[boards.seen[out]] ** 2, axis=1))
    return float(np.sqrt(np.mean(np.concatenate(squares)))) if squares else np.inf


def _pupil_shift(fit, boards):
    """How far the pupil moves over the angles that are seen, and its deviation."""
    points = transform(fit.result.T_camera_grid, boards.points)[boards.seen]
    theta = np.arctan2(np.hypot(*points[:, :2].T), points[:, 2]).max()
    a = fit.formula.parts(fit.result.values)[3]
    powers = theta ** (2 * np.arange(1, len(a) + 1))
    covariance = _covariance(fit, boards)[-len(a) :, -len(a) :]
    shift = pupil_heights(np.array([theta]), a)[0][0]
    return float(shift), float(np.sqrt(max(powers @ covariance @ powers, 0.0)))


# --------------------------------------------------------------------------- the result


def _completed(fit, boards, views, test, width, height):
    formula, result = fit
    # Copies: what is kept for the next model is nobody's to change.
    values, poses = result.values.copy(), result.T_camera_grid.copy()
    covariance = _covariance(fit, boards)
    spread = float(np.sqrt(covariance[0, 0]) / values[0])
    if not spread < UNDETERMINED:
        raise CalibrationError(
            f"{formula.base}: the focal length is not determined (standard deviation"
            f" {100 * spread:.0f} %); tilt the boards more, in more directions"
        )
    camera = formula.camera(values, width, height)
    distances = np.linalg.norm(result.residuals, axis=2)
    off = distances > WIDTH * result.scales[:, None]
    unseen = _unseen(camera, poses, boards) & ~off
    if unseen.any():
        raise CalibrationError(
            f"{formula.base}: what was fitted folds the image where"
            f" {np.count_nonzero(unseen)} corners lie"
        )
    wrong = []
    for view, place in np.argwhere(off & boards.seen):
        found = np.flatnonzero(np.isfinite(np.asarray(views[view].pixels)[:, 0]))
        name = views[view].name or f"view {view}"
        wrong.append(
            WrongCorner(
                int(view), int(found[place]), name, float(distances[view, place])
            )
        )
    rms = float(np.sqrt(np.mean(distances[boards.seen] ** 2)))
    return LensCalibration(camera, poses, rms, formula, values, covariance, wrong, test)


def _unseen(camera, T_camera_grid, boards):
    points = transform(T_camera_grid, boards.points).reshape(-1, 3)
    return ~camera.project(points).valid.reshape(boards.seen.shape) & boards.seen


def _covariance(fit, boards):
    """Covariance (P, P) of the parameters, from what the residuals leave."""
    squares = np.sum(fit.result.residuals**2, axis=2)
    right = squares < (WIDTH * fit.result.scales[:, None]) ** 2
    variance = np.sum(squares[right]) / _free(fit, boards)
    size = np.sqrt(np.maximum(np.diag(fit.result.normal), 1e-300))
    scaled = fit.result.normal / np.outer(size, size)
    return variance * np.linalg.pinv(scaled, rcond=1e-15) / np.outer(size, size)


def _free(fit, boards):
    """Coordinates less parameters."""
    count = 2 * np.count_nonzero(boards.seen)
    return max(count - len(fit.formula.names) - 6 * len(boards.seen), 1)
