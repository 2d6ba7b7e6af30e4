"""Scores of section 2.5.2: residuals of perspective correction, numbers of a run."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.trials.shots import (
    STAGE_IMAGES,
    views_of,
)
from chapters.shared.corrected_views import source_pixels_of
from chapters.shared.facade import straightness
from chapters.shared.methods import LINEAR, METHODS, SCALES
from chapters.shared.zoom_rigs import FACADE_ZOOM, STAGE_ZOOM, camera_of
from raxel.calibration import calibrate_zhang
from raxel.calibration.generic.standard import calibrate_compared, compared_boards
from raxel.calibration.parametric.opencv_fisheye import calibrate_opencv_fisheye
from raxel.cameras import pixel_grid
from raxel.errors import CalibrationError, InputError
from raxel.evaluation import corrected_view, distortion_residual, synthetic_plane
from raxel.geometry import (
    homography_dlt,
    inverse_pose,
    pose_from_homography,
    refine_homography,
)

MIN_POINTS = 12
QUINTILES = 5
NEIGHBOURS = 8
PERMUTATIONS = 999
COVERAGE_PX = 8  # spacing of the pixels on which coverage is counted


def calibrate(method, views, size, rng, prepared):
    """Return the camera of one method, from views of boards; size (width, height).

    prepared() returns the common input of all generic methods, computed once.
    """
    if method == "parametric":
        return calibrate_zhang(views, *size).camera
    if method == "opencv_fisheye":
        return calibrate_opencv_fisheye(views, *size).camera
    return calibrate_compared(prepared(), rng=rng, linear=LINEAR[method]).camera


class Residuals(NamedTuple):
    """Residuals of one board and their positions.

    pixels (M, 2): corners that have a ray; corrected, source (M, 2): residual
    vectors in px of the corrected view and of the source image; left_out: the
    number of corners without a ray.
    """

    pixels: np.ndarray
    corrected: np.ndarray
    source: np.ndarray
    left_out: int


def residuals_of(camera, views):
    """Return the residuals of each board: corrected corners compared with its grid."""
    plane = synthetic_plane(camera)
    found, straight = [], []
    for view in views:
        rays = camera.rays(view.pixels)
        seen, ahead = corrected_view(
            rays.directions, plane, np.nan_to_num(rays.origins)
        )
        usable = rays.valid & ahead
        if np.count_nonzero(usable) < MIN_POINTS:
            usable[:] = False
        seen, points = seen[usable], view.points[usable]
        residual = distortion_residual(seen, points) if len(seen) else seen
        straight.append(seen - residual)
        left_out = int(np.count_nonzero(~usable))
        found.append((view.pixels[usable], residual, left_out))
    bent = source_pixels_of(camera, plane, np.concatenate(straight))
    ends = np.cumsum([len(points) for points in straight])[:-1]
    return [
        Residuals(pixels, corrected, pixels - back, left_out)
        for (pixels, corrected, left_out), back in zip(
            found, np.split(bent, ends), strict=True
        )
    ]


def summary_of(boards):
    """Return RMS, mean and SD of residual lengths over all boards, in both scales."""
    out = {"left_out": sum(board.left_out for board in boards), "boards": len(boards)}
    for scale in SCALES:
        vectors = np.concatenate([getattr(board, scale) for board in boards])
        lengths = np.linalg.norm(vectors, axis=1)
        lengths = lengths[np.isfinite(lengths)]
        if len(lengths) < MIN_POINTS:
            continue
        out[scale] = {
            "rms_px": np.sqrt(np.mean(lengths**2)),
            "mean_px": lengths.mean(),
            "sd_px": lengths.std(ddof=1),
        }
    return out


def radial_bias(boards, middle):
    """Return the mean signed radial residual in quintiles of the image radius.

    boards: Residuals; middle: (2,) px. Returns per quintile mean, p-value of
    the mean against zero (t test over corners), and the RMS of all; in px of
    the corrected view and of the source image. Outwards is positive.
    """
    from scipy.stats import ttest_1samp

    pixels = np.concatenate([board.pixels for board in boards])
    if len(pixels) < MIN_POINTS:
        return {}
    offset = pixels - middle
    radius = np.linalg.norm(offset, axis=1)
    outward = offset / np.maximum(radius, 1e-9)[:, None]
    limits = np.quantile(radius, np.linspace(0, 1, QUINTILES + 1)[1:-1])
    place = np.digitize(radius, limits)
    out = {}
    for scale in SCALES:
        vectors = np.concatenate([getattr(board, scale) for board in boards])
        signed = np.sum(vectors * outward, axis=1)
        known = np.isfinite(signed)
        out[scale] = {"rms_px": np.sqrt(np.mean(np.sum(vectors[known] ** 2, 1)))}
        for quintile in range(QUINTILES):
            values = signed[known & (place == quintile)]
            if len(values) < MIN_POINTS:
                continue
            out[scale][f"q{quintile + 1}"] = {
                "mean_px": values.mean(),
                "p": ttest_1samp(values, 0.0).pvalue,
            }
    return out


def moran(positions, vectors, rng):
    """Return Moran's I of the residual vectors of one board, and its p-value.

    Weights: the eight nearest neighbours; p: share of random reorderings with
    an I as large, one-sided.
    """
    distances = np.linalg.norm(positions[:, None] - positions, axis=2)
    nearest = np.argsort(distances, axis=1)[:, 1 : NEIGHBOURS + 1]
    centred = vectors - vectors.mean(axis=0)
    spread = np.sum(centred**2) / len(centred)
    beside = np.mean(np.sum(centred[:, None] * centred[nearest], 2))
    shuffled = [rng.permutation(centred) for _ in range(PERMUTATIONS)]
    # Sums over neighbours, of all orders at once; the first is the order found.
    neighbours = np.zeros((len(centred), len(centred)))
    np.put_along_axis(neighbours, nearest, 1.0, axis=1)
    orders = np.stack([centred, *shuffled], axis=1)
    sums = np.tensordot(neighbours, orders, axes=1)
    found, *others = np.sum(orders * sums, axis=(0, 2))
    beaten = np.count_nonzero(np.array(others) >= found)
    return float(beside / spread), (beaten + 1) / (PERMUTATIONS + 1)


def stage_poses(camera, views):
    """Return poses T_camera_grid (n, 4, 4) from decomposed homographies.

    Raises InputError for a board with too few rays.
    """
    poses = []
    for view in views:
        rays = camera.rays(view.pixels)
        ahead = rays.valid & (rays.directions[:, 2] > 0)
        if np.count_nonzero(ahead) < MIN_POINTS:
            raise InputError(f"stage image {view.name}: too few rays")
        flat = rays.directions[ahead, :2] / rays.directions[ahead, 2:]
        points = view.points[ahead]
        H = refine_homography(homography_dlt(points, flat), points, flat)
        poses.append(pose_from_homography(H))
    return np.stack(poses)


def steps_of(poses):
    """Return steps (n - 1, 3) in mm between poses, in grid and camera frame."""
    in_grid = -np.diff(inverse_pose(poses)[:, :3, 3], axis=0)
    return {"grid": in_grid, "camera": np.diff(poses[:, :3, 3], axis=0)}


def scatter_of(steps):
    """Return the RMS deviation (mm) of steps (n, 3) from their mean, and its length."""
    mean = steps.mean(axis=0)
    deviation = np.sqrt(np.mean(np.sum((steps - mean) ** 2, axis=1)))
    return {"deviation_mm": deviation, "step_mm": np.linalg.norm(mean)}


def example_view(zoom, boards):
    """Return the first calibration image in which the board was detected."""
    return int(np.argmax(np.isfinite(boards["calibration"].found).all(axis=(1, 2))))


def scores(zoom, boards, rng, methods=METHODS, interpolation="homographic"):
    """Return all numbers of a run, and the calibrated cameras by method."""
    views = {use: views_of(zoom, seen.found) for use, seen in boards.items()}
    true = camera_of(zoom)
    size = true.width, true.height
    out = {f"found.{use}": len(of_use) for use, of_use in views.items()}
    out["distortion_level"] = distortion_level(true, boards)
    cameras, seen = {}, views["calibration"]
    prepared = cache(lambda: compared_boards(seen, *size, interpolation))
    for method in methods:
        try:
            camera = calibrate(method, seen, size, rng, prepared)
            out[method] = of_camera(zoom, camera, views, rng)
            cameras[method] = camera
        except (CalibrationError, InputError) as error:
            out[method] = {"failed": error.code}
    if zoom == FACADE_ZOOM and "parametric" in cameras:
        out["lines"] = straightness(cameras)
    return out, cameras


def of_camera(zoom, camera, views, rng):
    """Return the scores of one calibrated camera."""
    boards = {
        use: residuals_of(camera, views[use]) for use in ("calibration", "held_out")
    }
    out = {use: summary_of(of_use) for use, of_use in boards.items()}
    out["share_of_image"] = share_of_image(camera)
    middle = (np.array([camera.width, camera.height]) - 1) / 2
    if zoom == STAGE_ZOOM:
        for use, of_use in boards.items():
            out[use]["radial"] = radial_bias(of_use, middle)
        out["moran"] = correlation(boards["calibration"][0], rng)
        out["stage"] = stage(camera, views["stage"])
    return out


def share_of_image(camera):
    """Return the share of the image with a ray, on every eighth row and column."""
    size = camera.width // COVERAGE_PX, camera.height // COVERAGE_PX
    pixels = COVERAGE_PX * pixel_grid(*size) + COVERAGE_PX // 2
    return float(np.mean(camera.rays(pixels).valid))


def correlation(board, rng):
    """Return Moran's I of one board's residuals, in both scales."""
    out = {}
    for scale in SCALES:
        vectors = getattr(board, scale)
        known = np.isfinite(vectors).all(axis=1)
        if np.count_nonzero(known) < MIN_POINTS:
            continue
        index, p = moran(board.pixels[known], vectors[known], rng)
        out[scale] = {"index": index, "p": p}
    return out


def stage(camera, views):
    """Return the steps of the stage, which require all five images."""
    if len(views) < STAGE_IMAGES:
        return {"failed": "too-few-boards"}
    try:
        steps = steps_of(stage_poses(camera, views))
    except InputError as error:
        return {"failed": error.code}
    return {frame: scatter_of(s) | {"steps": s} for frame, s in steps.items()}


def fields(zoom, boards, sample, cameras):
    """Return arrays for Fig. 2.5: residual vectors of the sample image."""
    views = views_of(zoom, boards["calibration"].found[sample][None])
    return {
        f"field.{method}": np.hstack(residuals_of(camera, views)[0][:3])
        for method, camera in cameras.items()
    }


def distortion_level(camera, boards):
    """Return the largest |r_distorted / r_pinhole - 1| over the calibration boards.

    A pinhole with the camera's scale at the centre; beyond 90 degrees it has
    no radius, and the level is 1.
    """
    pixels = boards["calibration"].true.reshape(-1, 2)
    middle = camera.project(np.array([[0.0, 0.0, 1.0]])).pixels[0]
    step = camera.project(np.array([[1e-4, 0, 1], [-1e-4, 0, 1]])).pixels
    focal = np.linalg.norm(step[0] - step[1]) / 2e-4
    z = camera.rays(pixels).directions[:, 2]
    tangent = np.sqrt(1 - z**2) / np.maximum(z, 1e-12)
    radius = np.linalg.norm(pixels - middle, axis=1)
    level = np.abs(radius / (focal * np.maximum(tangent, 1e-12)) - 1)
    return float(np.max(np.where(z > 0, level, 1.0)))
