"""A lens formula fitted to boards or dense grids, without a guess.

From nothing to a fit: `raxel.calibration.parametric.lens_fit`. Whether the entrance
pupil moves: `raxel.calibration.parametric.lens_pupil`; whether the board is flat:
`raxel.calibration.parametric.lens_board`.

Sources: Kannala and Brandt 2006, doi:10.1109/TPAMI.2006.153; Geyer and Daniilidis 2000,
doi:10.1007/3-540-45053-X_29.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from raxel.calibration.parametric.lens_board import BoardTest, board_test
from raxel.calibration.parametric.lens_bundle import WIDTH, stacked
from raxel.calibration.parametric.lens_fit import (
    KEPT,
    PUPIL,
    FormulaFit,
    GivenBoards,
    covariance_of,
    fitted_law,
    start_of,
)
from raxel.calibration.parametric.lens_laws import LensFormula
from raxel.calibration.parametric.lens_pupil import (
    SURE,
    PupilTest,
    agreed,
    pupil_shift,
    pupil_test,
)
from raxel.calibration.parametric.zhang import found_corners
from raxel.calibration.views.near_copies import near_copies
from raxel.cameras.core.base import Camera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.poses import transform

LAWS = ("kannala-brandt", "unified")
UNDETERMINED = 0.2  # of a focal length, as its standard deviation


class WrongCorner(NamedTuple):
    """A corner that counts for nothing: view, corner (indices), name of the view, and
    its distance in px from where the camera sees it."""

    view: int
    corner: int
    name: str
    distance_px: float


class LensCalibration(NamedTuple):
    """camera; T_camera_grid (n, 4, 4), one pose per view in the board's unit; rms_px:
    root mean square distance of all corners, wrong ones among them; formula: its terms;
    values (P,) and covariance (P, P) of its parameters, and error_factor, by which
    their standard deviations are larger than if every corner erred for itself
    (`raxel.calibration.parametric.clustered`); wrong: WrongCorners; pupil: PupilTest,
    board: BoardTest, each None where nothing was tested.
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


class _Proposal(NamedTuple):
    fit: FormulaFit
    pupil: PupilTest | None
    board: BoardTest | None


def calibrate_lens(views, width, height, law, *, pupil="by test", board="by test"):
    """A lens formula from views of a planar board, with no start given.

    views: two or more BoardViews or DenseViews, of which only the corners (the
    lattice's pixels) that were found count, all alike; width, height: the image in px.
    law: "kannala-brandt" or "unified". pupil: "fixed" (a central camera), "moving", or
    "by test", which decides between the two. board: "flat", or "by test", which bends
    and stretches it where views ask for that. Lens and sensor may be decentred; there
    is no skew.

    Returns LensCalibration. Raises InputError as `calibrate_zhang` does;
    CalibrationError: no start leads to a camera, or the views do not determine it.
    """
    if law not in LAWS:
        raise ValueError(f"law: {law!r}; give one of {', '.join(LAWS)}")
    if pupil not in ("by test", "fixed", "moving"):
        raise ValueError(f"pupil: {pupil!r}; 'by test', 'fixed' or 'moving'")
    if board not in ("by test", "flat"):
        raise ValueError(f"board: {board!r}; 'by test' or 'flat'")
    boards = _boards_of(views, law)
    given = GivenBoards(boards, width, height)
    if pupil == "by test":
        *_, found = _proposed(law, given, board == "flat")
    else:
        terms = PUPIL * (pupil == "moving")
        found = _shaped(law, start_of(given), boards, terms, board == "flat")
    return _completed(found, boards, views, width, height)


def proposed_lenses(views, width, height, board="by test"):
    """Every formula that may serve: of each law that of a central lens, and where both
    tests say that the pupil moves, that of a lens whose pupil does; board: as of
    `calibrate_lens`.

    Returns a list of LensCalibrations and one of the reasons why others are none.
    Raises as `calibrate_lens` does before a law is fitted.
    """
    boards = _boards_of(views, "lens formula")
    given, found, faults = GivenBoards(boards, width, height), [], []
    for law in LAWS:
        for each in _proposed(law, given, board == "flat"):
            try:
                found.append(_completed(each, boards, views, width, height))
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
    return stacked(corners, near_copies(views))


@lru_cache(maxsize=KEPT * len(LAWS))
def _asked(law, given, flat):
    """The _Proposal of a central lens, and the AskedLaw on its pupil."""
    central = _shaped(law, start_of(given), given.boards, 0, flat)
    return central, pupil_test(law, central.fit, given.boards)


@lru_cache(maxsize=KEPT * len(LAWS))
def _proposed(law, given, flat=False):
    """The _Proposal of a central lens; then, if all tests say so, that of one whose
    pupil moves."""
    boards = given.boards
    central, asked = _asked(law, given, flat)
    test = asked.test
    for other in LAWS:
        if test.p_value <= SURE and other != law:
            test = agreed(asked, _asked(other, given, flat)[1], boards)
    found = [central._replace(pupil=test)]
    if test.moves:
        # A board that seemed bent may have been a pupil that moves.
        again = _shaped(law, start_of(given), boards, PUPIL, flat)
        shift, sd = pupil_shift(again.fit, boards)
        test = test._replace(shift=shift, shift_sd=sd)
        found = [each._replace(pupil=test) for each in (central, again)]
    return found


def _shaped(law, start, boards, pupil, flat):
    """The _Proposal of a law with so many terms of the pupil, its board as it asks."""
    fit = fitted_law(law, start, boards, pupil)
    test = None if flat else board_test(fit, boards)
    while test and test.used != fit.formula.board:
        fit = fitted_law(law, start, boards, pupil, test.used)
        test = board_test(fit, boards, test)
    return _Proposal(fit, None, test)


# --------------------------------------------------------------------------- the result


def _completed(proposal, boards, views, width, height):
    formula, result = proposal.fit
    # Copies: what is kept for the next model is nobody's to change.
    values, poses = result.values.copy(), result.T_camera_grid.copy()
    told = covariance_of(proposal.fit, boards)
    spread = float(np.sqrt(told.estimated[0, 0]) / values[0])
    if not spread < UNDETERMINED:
        raise CalibrationError(
            f"{formula.base}: the focal length is not determined (standard deviation"
            f" {100 * spread:.0f} %); tilt the boards more, in more directions",
            code="focal-length-not-determined",
        )
    camera = formula.camera(values, width, height)
    distances = np.linalg.norm(result.residuals, axis=2)
    off = distances > WIDTH * result.scales[:, None]
    placed = boards.placed(formula, values)
    unseen = _unseen(camera, transform(poses, placed), boards.seen) & ~off
    if unseen.any():
        raise CalibrationError(
            f"{formula.base}: what was fitted folds the image where"
            f" {np.count_nonzero(unseen)} corners lie",
            code="no-camera",
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
    return LensCalibration(
        camera, poses, rms, formula, values, told.covariance, told.factor, wrong,
        proposal.pupil, proposal.board,
    )  # fmt: skip


def _unseen(camera, points, seen):
    return ~camera.project(points.reshape(-1, 3)).valid.reshape(seen.shape) & seen
