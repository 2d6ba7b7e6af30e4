"""Zhang's pinhole with what users ask beside it: deviations, and the board's shape.

The fit is that of `calibrate_zhang`. From there the same terms and the poses are
adjusted once more: that gives their covariance, and a board that is bent or longer one
way is fitted with them, as with other formulas. Where the board is taken as stated the
camera stays the one that OpenCV fitted.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.parametric.lens_board import BoardTest, board_test
from raxel.calibration.parametric.lens_bundle import adjusted, stacked
from raxel.calibration.parametric.lens_fit import FormulaFit, covariance_of, refitted
from raxel.calibration.parametric.lens_laws import LensFormula
from raxel.calibration.parametric.zhang import calibrate_zhang, found_corners
from raxel.calibration.views.near_copies import near_copies
from raxel.cameras.lenses.perspective import PerspectiveCamera

PINHOLE = LensFormula("perspective", 2, 0, 0)


class PinholeCalibration(NamedTuple):
    """camera; T_camera_grid (n, 4, 4), in the board's unit; formula: names of its
    parameters; values (P,) and covariance (P, P) of these, None where points lie behind
    what was fitted; error_factor, board: as of a LensCalibration."""

    camera: PerspectiveCamera
    T_camera_grid: np.ndarray
    formula: LensFormula
    values: np.ndarray
    covariance: np.ndarray | None
    error_factor: float
    board: BoardTest | None


def calibrate_pinhole(views, width, height):
    """PinholeCalibration of views of a planar board; arguments and errors as of
    `calibrate_zhang`."""
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
    told = covariance_of(fit, boards)
    return PinholeCalibration(
        camera, poses, fit.formula, values, told.covariance, told.factor, test
    )
