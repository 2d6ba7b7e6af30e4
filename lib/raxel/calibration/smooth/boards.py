"""A camera of smooth rays from pictures of boards or active grids, without a guess.

The trend is a lens formula fitted to the same boards, of the laws that lead to a
camera; where the tests propose a pupil that moves, that is one more. Where none leads
to a camera, it is the radial law nearest to the rays of the generic method. The
field on top of it is fitted to the corners themselves. Of several trends that one is
taken on which kept-out boards are predicted best.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.generic.standard import calibrate_generic
from raxel.calibration.parametric.lens_board import BoardTest
from raxel.calibration.parametric.lens_formula import PupilTest, proposed_lenses
from raxel.calibration.parametric.zhang import found_corners
from raxel.calibration.smooth.adjustment import (
    MIN_CORNERS,
    SplineAdjustment,
    adjust_spline,
)
from raxel.calibration.smooth.trend import trend_of_rays
from raxel.cameras.tables.ray_spline import RaySplineCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import pose, transform

THINNED = 2000  # rays of a table that a trend is fitted to
SHARE_STEP_PX = 8  # of the pixels that shares of the image are counted with


class SplineCalibration(NamedTuple):
    """camera: RaySplineCamera, its frame the trend's; T_camera_grid (m, 4, 4): poses of
    the boards in `used` (indices of views). left_out: {index: reason}.

    share_with_ray: share of the image's pixels that have a ray; share_covered: of those
    that lie in a cell in which a corner was found: elsewhere nothing checks the rays.
    wrong_corners: {index: how many corners were left out as wrong}; trend: what it was
    fitted as; adjustment: SplineAdjustment; pupil: the trend's PupilTest where that
    moves, else None; board: its BoardTest, None where the trend is no lens formula. The
    shape of the board is the trend's.
    """

    camera: RaySplineCamera
    T_camera_grid: np.ndarray
    used: list
    left_out: dict
    share_with_ray: float
    share_covered: float
    wrong_corners: dict
    trend: str
    adjustment: SplineAdjustment
    pupil: PupilTest | None
    board: BoardTest | None


class _Laid(NamedTuple):
    start: object
    used: list
    left_out: dict
    adjustment: SplineAdjustment


class _Start(NamedTuple):
    name: str
    trend: object
    T_camera_grid: dict  # of boards by index
    left_out: dict
    pupil: PupilTest | None
    board: BoardTest | None

    def solid(self, points):
        """Points (N, 3) of stated ones (N, 2), by the shape that the trend took."""
        return self.board.taken.points(points) if self.board else on_plane(points)


def calibrate_spline(
    views, width, height, *, rng, units="mm", side=-1, board="by test"
):
    """Smooth rays from two or more views of a planar board.

    views: BoardViews or DenseViews, of which only the corners (the lattice's pixels)
    that were found count, all alike; width, height: the image in px. rng, units, side:
    of the generic method (`calibrate_generic`), which begins where no lens formula
    fits; board: as of `calibrate_lens`.

    Returns SplineCalibration. Raises InputError as `calibrate_zhang` does;
    CalibrationError where no trend is found, or the views do not determine a field.
    """
    corners = [found_corners(view) for view in views]
    lenses, faults = _lenses(views, width, height, board)
    starts = [_lens_start(lens) for lens in lenses]
    if not starts:
        try:
            starts = [_generic_start(views, width, height, rng, units, side)]
        except CalibrationError as fault:
            raise CalibrationError(
                "smooth rays: no trend to begin with: "
                + "; ".join([*faults, str(fault)]),
                code="no-lens-formula",
            ) from None
    fields = []
    for start in starts:
        try:
            fields.append(_laid(start, corners, width, height))
        except InputError as fault:  # a field so steep that it makes no camera, too
            faults.append(str(fault))
    if not fields:
        raise CalibrationError(f"smooth rays: {faults[-1]}", code="no-camera")
    best = min(fields, key=lambda field: min(field.adjustment.held_out_px.values()))
    return _completed(best, width, height)


def _lenses(views, width, height, board):
    try:
        return proposed_lenses(views, width, height, board)
    except CalibrationError as fault:
        return [], [str(fault)]


def _lens_start(lens):
    poses = dict(enumerate(lens.T_camera_grid))
    moves = lens.pupil if lens.formula.pupil else None
    return _Start(lens.formula.base, lens.camera, poses, {}, moves, lens.board)


def _generic_start(views, width, height, rng, units, side):
    found = calibrate_generic(views, width, height, rng=rng, units=units, side=side)
    v, u = np.nonzero(found.camera.mask)
    v, u = (a[:: 1 + len(u) // THINNED] for a in (v, u))
    rays = found.camera.directions[v, u]
    pixels = np.column_stack([u, v]).astype(float)
    trend = trend_of_rays(pixels, rays, width, height)
    T_trend_rays = pose(trend.R_rays_trend.T, np.zeros(3))
    poses = dict(zip(found.used, T_trend_rays @ found.T_camera_grid, strict=True))
    return _Start("rays", trend.camera, poses, dict(found.left_out), None, None)


def _laid(start, corners, width, height):
    """The field on one trend, of the boards of which it images enough: _Laid."""
    used, left_out = [], dict(start.left_out)
    for k, T in start.T_camera_grid.items():
        solid = start.solid(corners[k][1])
        count = np.count_nonzero(start.trend.project(transform(T, solid)).valid)
        if count < MIN_CORNERS:
            left_out[k] = f"the trend images {count} of its corners"
        else:
            used.append(k)
    poses = np.array([start.T_camera_grid[k] for k in used]).reshape(-1, 4, 4)
    boards = [(corners[k][0], start.solid(corners[k][1])) for k in used]
    found = adjust_spline(start.trend, poses, boards, width, height)
    return _Laid(start, used, left_out, found)


def _completed(laid, width, height):
    start, used, left_out, found = laid
    wrong = {
        k: int(np.count_nonzero(out))
        for k, out in zip(used, found.outliers, strict=True)
        if out.any()
    }
    v, u = np.mgrid[:height:SHARE_STEP_PX, :width:SHARE_STEP_PX]
    pixels = np.column_stack([u.ravel(), v.ravel()]).astype(float)
    return SplineCalibration(
        found.camera, found.T_camera_grid, used, left_out,
        float(np.mean(found.camera.rays(pixels).valid)),
        float(np.mean(found.camera.covers(pixels))),
        wrong, start.name, found, start.pupil, start.board,
    )  # fmt: skip
