"""Scores of section 2.5.2: what perspective correction leaves, and a seed's numbers."""

from __future__ import annotations

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.trials.shots import (
    STAGE_IMAGES,
    views_of,
)
from chapters.shared.corrected_views import source_pixels_of
from chapters.shared.facade import straightness
from chapters.shared.methods import LINEAR, METHODS
from chapters.shared.zoom_rigs import FACADE_ZOOM, STAGE_ZOOM, camera_of
from raxel.calibration import calibrate_generic, calibrate_zhang
from raxel.errors import CalibrationError, InputError
from raxel.evaluation import (
    corrected_view,
    distortion_residual,
    synthetic_plane,
)
from raxel.geometry import (
    homography_dlt,
    inverse_pose,
    pose_from_homography,
    refine_homography,
)

FEWEST = 12
QUINTILES = 5
NEIGHBOURS = 8
PERMUTATIONS = 999


def calibrate(method, views, size, rng):
    """The camera of one method, from views of boards; size (width, height)."""
    if method == "parametric":
        return calibrate_zhang(views, *size).camera
    return calibrate_generic(
        views,
        *size,
        rng=rng,
        linear=LINEAR[method],
        interpolation="homographic",
    ).camera


def residuals_of(camera, view):
    """Residuals of one board in both scales, and where they stand.

    Returns (pixels, corrected, source, left_out): corners (M, 2) that have a
    ray, residual vectors (M, 2) in px of the corrected view and of the source
    image, and how many corners have none.
    """
    plane = synthetic_plane(camera)
    rays = camera.rays(view.pixels)
    seen, ahead = corrected_view(
        rays.directions, plane, np.nan_to_num(rays.origins)
    )
    usable = rays.valid & ahead
    left_out = int(np.count_nonzero(~usable))
    if np.count_nonzero(usable) < FEWEST:
        empty = np.empty((0, 2))
        return empty, empty, empty, len(usable)
    corrected = distortion_residual(seen[usable], view.points[usable])
    source = view.pixels[usable] - source_pixels_of(
        camera, plane, seen[usable] - corrected
    )
    return view.pixels[usable], corrected, source, left_out


def summary_of(camera, views):
    """RMS, mean and SD of residual lengths over all boards, both scales."""
    boards = [residuals_of(camera, view) for view in views]
    left_out = sum(board[3] for board in boards)
    out = {"left_out": left_out, "boards": len(boards)}
    for scale, place in (("corrected", 1), ("source", 2)):
        vectors = np.concatenate([board[place] for board in boards])
        lengths = np.linalg.norm(vectors, axis=1)
        lengths = lengths[np.isfinite(lengths)]
        if len(lengths) < FEWEST:
            continue
        out[scale] = {
            "rms_px": np.sqrt(np.mean(lengths**2)),
            "mean_px": lengths.mean(),
            "sd_px": lengths.std(ddof=1),
        }
    return out


def radial_bias(camera, views, middle):
    """Mean signed radial residual in quintiles of the image radius.

    Returns per quintile mean, p-value of the mean against zero (t test over
    corners), and the RMS of all; in px of the corrected view and of the source
    image. Outwards is positive.
    """
    from scipy.stats import ttest_1samp

    boards = [residuals_of(camera, view) for view in views]
    pixels = np.concatenate([board[0] for board in boards])
    offset = pixels - middle
    radius = np.linalg.norm(offset, axis=1)
    outward = offset / np.maximum(radius, 1e-9)[:, None]
    limits = np.quantile(radius, np.linspace(0, 1, QUINTILES + 1)[1:-1])
    place = np.digitize(radius, limits)
    out = {}
    for scale, column in (("corrected", 1), ("source", 2)):
        vectors = np.concatenate([board[column] for board in boards])
        signed = np.sum(vectors * outward, axis=1)
        known = np.isfinite(signed)
        out[scale] = {
            "rms_px": np.sqrt(np.mean(np.sum(vectors[known] ** 2, 1)))
        }
        for quintile in range(QUINTILES):
            values = signed[known & (place == quintile)]
            test = ttest_1samp(values, 0.0)
            out[scale][f"q{quintile + 1}"] = {
                "mean_px": values.mean(),
                "p": test.pvalue,
            }
    return out


def moran(positions, vectors, rng):
    """Moran's I of residual vectors of one board, and its p-value.

    Weights: the eight nearest neighbours; p: share of random reorderings with
    an I as large, one-sided.
    """
    distances = np.linalg.norm(positions[:, None] - positions, axis=2)
    nearest = np.argsort(distances, axis=1)[:, 1 : NEIGHBOURS + 1]
    centred = vectors - vectors.mean(axis=0)
    spread = np.sum(centred**2) / len(centred)

    def index(values):
        return (
            np.mean(np.sum(values[:, None] * values[nearest], 2)) / spread
        )

    found = index(centred)
    shuffled = [
        index(rng.permutation(centred)) for _ in range(PERMUTATIONS)
    ]
    beaten = np.count_nonzero(np.array(shuffled) >= found)
    return float(found), (beaten + 1) / (PERMUTATIONS + 1)


def stage_poses(camera, views):
    """Poses T_camera_grid (n, 4, 4) by the decomposition of homographies.

    Raises InputError for a board with too few rays.
    """
    poses = []
    for view in views:
        rays = camera.rays(view.pixels)
        ahead = rays.valid & (rays.directions[:, 2] > 0)
        if np.count_nonzero(ahead) < FEWEST:
            raise InputError(f"stage image {view.name}: too few rays")
        flat = rays.directions[ahead, :2] / rays.directions[ahead, 2:]
        points = view.points[ahead]
        H = refine_homography(homography_dlt(points, flat), points, flat)
        poses.append(pose_from_homography(H))
    return np.stack(poses)


def steps_of(poses):
    """Steps (n - 1, 3) in mm between poses, in the grid's and camera's frame."""
    in_grid = -np.diff(inverse_pose(poses)[:, :3, 3], axis=0)
    return {"grid": in_grid, "camera": np.diff(poses[:, :3, 3], axis=0)}


def scatter_of(steps):
    """RMS deviation (mm) of steps (n, 3) from their mean, and its length."""
    mean = steps.mean(axis=0)
    deviation = np.sqrt(np.mean(np.sum((steps - mean) ** 2, axis=1)))
    return {"deviation_mm": deviation, "step_mm": np.linalg.norm(mean)}


def example_view(zoom, boards):
    """The first calibration picture in which the board was found."""
    found = np.isfinite(boards["calibration"].found).all(axis=(1, 2))
    return int(np.argmax(found))


def scores(zoom, boards, rng):
    """Every number of a seed, and the calibrated cameras by method."""
    views = {
        use: views_of(zoom, seen.found) for use, seen in boards.items()
    }
    true = camera_of(zoom)
    size = true.width, true.height
    out = {f"found.{use}": len(of_use) for use, of_use in views.items()}
    out["corner_error_px"] = corner_error(boards)
    out["distortion_level"] = distortion_level(true, boards)
    cameras = {}
    for method in METHODS:
        try:
            camera = calibrate(method, views["calibration"], size, rng)
            out[method] = of_camera(zoom, camera, views, rng)
            cameras[method] = camera
        except (CalibrationError, InputError) as error:
            out[method] = {"failed": str(error)}
    if zoom == FACADE_ZOOM and len(cameras) == len(METHODS):
        out["lines"] = straightness(cameras)
    return out, cameras


def of_camera(zoom, camera, views, rng):
    """Scores of one calibrated camera."""
    out = {
        use: summary_of(camera, views[use])
        for use in ("calibration", "held_out")
    }
    middle = (np.array([camera.width, camera.height]) - 1) / 2
    if zoom == STAGE_ZOOM:
        for use in ("calibration", "held_out"):
            out[use]["radial"] = radial_bias(camera, views[use], middle)
        out["moran"] = correlation(camera, views["calibration"][0], rng)
        out["stage"] = stage(camera, views["stage"])
    return out


def correlation(camera, view, rng):
    """Moran's I of one board's residuals, in both scales."""
    pixels, corrected, source, _ = residuals_of(camera, view)
    out = {}
    for scale, vectors in (("corrected", corrected), ("source", source)):
        known = np.isfinite(vectors).all(axis=1)
        index, p = moran(pixels[known], vectors[known], rng)
        out[scale] = {"index": index, "p": p}
    return out


def stage(camera, views):
    """Steps of the stage: all five images are needed."""
    if len(views) < STAGE_IMAGES:
        return {"failed": f"{len(views)} of {STAGE_IMAGES} boards found"}
    try:
        steps = steps_of(stage_poses(camera, views))
    except InputError as error:
        return {"failed": str(error)}
    return {
        frame: scatter_of(s) | {"steps": s} for frame, s in steps.items()
    }


def fields(zoom, boards, sample, cameras):
    """Arrays for Fig. 2.5: residual vectors of the sample picture."""
    corners = boards["calibration"].found[sample][None]
    view = views_of(zoom, corners)[0]
    out = {}
    for method, camera in cameras.items():
        pixels, corrected, source, _ = residuals_of(camera, view)
        out[f"field.{method}"] = np.hstack([pixels, corrected, source])
    return out


def corner_error(boards):
    """RMS distance (px) of found corners from the true ones."""
    errors = np.concatenate(
        [seen.found - seen.true for seen in boards.values()]
    ).reshape(-1, 2)
    return np.sqrt(np.nanmean(np.sum(errors**2, axis=1)))


def distortion_level(camera, boards):
    """Largest |r_distorted / r_pinhole - 1| over the calibration boards.

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
