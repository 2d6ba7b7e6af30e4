"""Camera with a B-spline ray field from boards or active grids, without a guess.

The trend is a lens model fitted to the same boards, for each law that leads to a
camera. If the tests support an entrance-pupil shift, that model is one more trend. If
no law leads to a camera, the trend is the radial law closest to the rays of the generic
method. The field on top of it is fitted to the corners. Among several trends the one
with the best prediction of held-out boards is selected.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from raxel.calibration.generic.standard import calibrate_generic
from raxel.calibration.parametric.lens_bundle import LensFormula, imaged_points
from raxel.calibration.parametric.lens_formula import (
    BoardTest,
    PupilTest,
    proposed_lenses,
)
from raxel.calibration.parametric.opencv_fits import found_corners
from raxel.calibration.smooth.adjustment import (
    MIN_N_CORNERS,
    SplineAdjustment,
    adjust_spline,
)
from raxel.cameras.lenses.fisheye import KannalaBrandtCamera
from raxel.cameras.tables.ray_spline import RaySplineCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import nearest_rotation, pose, rotation_from_vector, transform

MAX_N_TREND_RAYS = 2000  # rays of a table for the fit of a trend
SHARE_STEP_PX = 8  # of the pixels that determine shares of the image


class SplineCalibration(NamedTuple):
    """Hold a B-spline ray field from `calibrate_spline`.

    The shape of the board is that of the trend.

    Attributes
    ----------
    camera : RaySplineCamera
        The camera, in the frame of the trend.
    T_camera_grid : ndarray, shape (m, 4, 4)
        Poses of the boards in `used`.
    used : list of int
        Indices of views.
    left_out : dict of int to str
        Reason for each excluded view.
    share_with_ray : float
        Share of the pixels of the image that have a ray.
    share_covered : float
        Share of those that lie in a cell in which a corner was found. Elsewhere nothing
        checks the rays.
    wrong_corners : dict of int to int
        Number of corners of each view that were rejected as wrong.
    trend : str
        Name of the fitted trend.
    adjustment : SplineAdjustment
        The adjustment of the field.
    pupil : PupilTest or None
        Of the trend, where its pupil moves.
    board : BoardTest or None
        Of the trend; None where it is no lens formula.
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
    formula: LensFormula  # of the trend
    values: np.ndarray

    def slopes(self, points):
        """Derivatives (N, 2, P) of the trend's pixels by its parameters, without those
        of the board."""
        own = slice(len(self.values) - len(self.formula.board))
        return imaged_points(self.formula, self.values, points).by_values[..., own]

    def solid(self, points):
        """Points (N, 3) of nominal ones (N, 2), with the board shape of the trend."""
        return self.board.taken.points(points) if self.board else on_plane(points)


def calibrate_spline(
    views: Sequence[Any],
    width: int,
    height: int,
    *,
    rng: np.random.Generator,
    units: str = "mm",
    side: int = -1,
    pupil: str = "by test",
    board: str = "by test",
) -> SplineCalibration:
    """Calibrate a B-spline ray field from views of a planar board.

    Parameters
    ----------
    views : sequence of BoardView or DenseView
        Two or more views. Only the corners (the pixels of the lattice) that were found
        count, all alike.
    width, height : int
        Size of the image, px.
    rng, units, side
        As of the generic method (`calibrate_generic`), which gives the start where no
        lens formula fits.
    pupil : {"by test", "fixed", "moving"}
        "fixed" gives a central camera. "moving" also tries trends with a pupil shift,
        without a test.
    board : {"by test", "flat"}
        As of `calibrate_lens`.

    Returns
    -------
    SplineCalibration
        The camera and the poses.

    Raises
    ------
    InputError
        As `calibrate_zhang`.
    CalibrationError
        If no trend is found, or the views do not determine a field.
    """
    corners = [found_corners(view) for view in views]
    lenses, faults = _lenses(views, width, height, board, pupil)
    starts = [_lens_start(lens) for lens in lenses]
    if not starts:
        try:
            starts = [_generic_start(views, width, height, rng, units, side)]
        except CalibrationError as fault:
            raise CalibrationError(
                "smooth rays: no trend: " + "; ".join([*faults, str(fault)]),
                code="no-lens-formula",
            ) from None
    fields = []
    for start in starts:
        try:
            fields.append(_laid(start, corners, width, height))
        except InputError as fault:  # also a field too steep for a camera
            faults.append(str(fault))
    if not fields:
        raise CalibrationError(f"smooth rays: {faults[-1]}", code="no-camera")
    best = min(fields, key=lambda field: min(field.adjustment.held_out_px.values()))
    return _completed(best, width, height)


def _lenses(views, width, height, board, pupil):
    try:
        return proposed_lenses(views, width, height, board, pupil)
    except CalibrationError as fault:
        return [], [str(fault)]


def _lens_start(lens):
    poses = dict(enumerate(lens.T_camera_grid))
    moves = lens.pupil if lens.formula.pupil else None
    return _Start(
        lens.formula.base, lens.camera, poses, {}, moves, lens.board,
        lens.formula, lens.values,
    )  # fmt: skip


def _generic_start(views, width, height, rng, units, side):
    found = calibrate_generic(views, width, height, rng=rng, units=units, side=side)
    v, u = np.nonzero(found.camera.mask)
    v, u = (a[:: 1 + len(u) // MAX_N_TREND_RAYS] for a in (v, u))
    rays = found.camera.directions[v, u]
    pixels = np.column_stack([u, v]).astype(float)
    trend = trend_of_rays(pixels, rays, width, height)
    T_trend_rays = pose(trend.R_rays_trend.T, np.zeros(3))
    poses = dict(zip(found.used, T_trend_rays @ found.T_camera_grid, strict=True))
    lens = trend.camera
    formula = LensFormula("kannala-brandt", len(lens.k) - 1, 0, 0)
    values = np.concatenate([lens.pixels_per_unit, lens.principal_point, lens.k[1:]])
    return _Start(
        "rays", lens, poses, dict(found.left_out), None, None, formula, values
    )


def _laid(start, corners, width, height):
    """_Laid: the field on one trend, from boards with enough imaged corners."""
    used, left_out = [], dict(start.left_out)
    for k, T in start.T_camera_grid.items():
        solid = start.solid(corners[k][1])
        count = np.count_nonzero(start.trend.project(transform(T, solid)).valid)
        if count < MIN_N_CORNERS:
            left_out[k] = f"the trend images {count} of its corners"
        else:
            used.append(k)
    poses = np.array([start.T_camera_grid[k] for k in used]).reshape(-1, 4, 4)
    boards = [(corners[k][0], start.solid(corners[k][1])) for k in used]
    found = adjust_spline(start.trend, poses, boards, width, height, start.slopes)
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


# Lens model closest to given rays, as the trend of a smooth field. Kannala and Brandt's
# radial law (2.9) about a free axis and centre, fitted in px, with Cauchy's loss
# against outliers.


MAX_N_TERMS = 5
MIN_N_RAYS = 40


class RayTrend(NamedTuple):
    """Hold a lens formula that rays follow nearly.

    Attributes
    ----------
    camera : KannalaBrandtCamera
        The formula, with its own axis as z.
    R_rays_trend : ndarray, shape (3, 3)
        Rotation to the frame of the rays.
    scale_px : float
        Robust standard deviation of a coordinate of pixels about those of the formula.
    """

    camera: KannalaBrandtCamera
    R_rays_trend: np.ndarray
    scale_px: float


def trend_of_rays(
    pixels: np.ndarray, directions: np.ndarray, width: int, height: int
) -> RayTrend:
    """Return the trend of rays.

    It has as many radial terms, 2 to 5, as let the law rise out to the corners of the
    image.

    Parameters
    ----------
    pixels : ndarray, shape (N, 2)
        Pixels (u, v).
    directions : ndarray, shape (N, 3)
        Unit directions of their rays.
    width, height : int
        Size of the image, px.

    Returns
    -------
    RayTrend
        The trend.

    Raises
    ------
    CalibrationError
        If there are fewer than 40 rays (code ``too-few-rays``), or no such law is near.
    """
    if len(pixels) < MIN_N_RAYS:
        raise CalibrationError(
            f"trend of rays: found {len(pixels)} rays; give at least {MIN_N_RAYS}",
            code="too-few-rays",
        )
    start, R = _start(pixels, directions, width, height)
    corners = np.array([[x, y] for x in (0, width - 1) for y in (0, height - 1)])
    fits = []
    for terms in range(2, MAX_N_TERMS + 1):
        values, scale = _fitted(pixels, directions @ R, start[: 7 + terms])
        try:
            camera = KannalaBrandtCamera(
                values[7:], np.exp(values[5:7]), values[3:5], width, height
            )
        except InputError:
            continue
        reach = camera.rays(corners).valid.all() or _passes_pi(values, corners)
        turned = R @ rotation_from_vector(values[:3]).T
        fits.append((reach, -scale, RayTrend(camera, turned, scale)))
        start[: len(values)] = values
    if not fits:
        raise CalibrationError(
            "trend of rays: no radial law fits these rays; use a generic camera",
            code="no-lens-formula",
        )
    return max(fits, key=lambda fit: fit[:2])[2]


def _passes_pi(values, corners):
    """Whether the law reaches pi before the image's corners."""
    radius = np.linalg.norm((corners - values[3:5]) / np.exp(values[5:7]), axis=1)
    return radius.max() > np.pi * np.polyval(values[:6:-1], np.pi**2)


def _start(pixels, directions, width, height):
    """Values (7 + MAX_N_TERMS,) of r = theta and the rotation of the initial axis.

    The axes map the rays best to those of an equidistance lens; its focal length
    follows from the angles between rays and the one in the image centre.
    """
    middle = (np.array([width, height]) - 1) / 2
    offset = pixels - middle
    radius = np.linalg.norm(offset, axis=1)
    nearest = np.argsort(radius)[: max(3, len(radius) // 50)]
    z = directions[nearest].mean(axis=0)
    cosine = np.clip(directions @ z / np.linalg.norm(z), -1, 1)
    angle = np.arccos(cosine)
    focal = np.vdot(radius, radius) / max(np.vdot(radius, angle), 1e-12)
    theta = np.minimum(radius / focal, np.pi)
    across = offset / np.maximum(radius, 1e-12)[:, None] * np.sin(theta)[:, None]
    R = nearest_rotation(directions.T @ np.column_stack([across, np.cos(theta)]))
    values = np.zeros(7 + MAX_N_TERMS)
    values[3:5], values[5:7], values[7] = middle, np.log(focal), 1.0
    return values, R


def _fitted(pixels, directions, start):
    """Values and robust scale. Values: rotation (3,), centre (2,), logarithms of
    pixels per unit (2,), then k1 = 1, which stays, k2, ..."""
    from scipy.optimize import least_squares

    free = np.arange(len(start)) != 7

    def misses(free_values):
        values = start.copy()
        values[free] = free_values
        return (_imaged(directions, values) - pixels).ravel()

    def scale_of(residuals):
        return max(1.4826 * float(np.median(np.abs(residuals))), 1e-9)

    found, scale = start[free], scale_of(misses(start[free]))
    for _ in range(3):
        found = least_squares(
            misses, found, loss="cauchy", f_scale=3 * scale, x_scale="jac",
            xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=60,
        ).x  # fmt: skip
        before, scale = scale, scale_of(misses(found))
        if scale > 0.9 * before:
            break
    values = start.copy()
    values[free] = found
    return values, scale


def _imaged(directions, values):
    """Pixels (N, 2) of directions by the polynomial, even where it decreases."""
    d = directions @ rotation_from_vector(values[:3]).T
    across = np.hypot(d[:, 0], d[:, 1])
    theta = np.arctan2(across, d[:, 2])
    radius = theta * np.polyval(values[:6:-1], theta**2)
    unit = d[:, :2] / np.maximum(across, 1e-300)[:, None]
    return radius[:, None] * unit * np.exp(values[5:7]) + values[3:5]
