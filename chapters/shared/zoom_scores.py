"""Scores of section 2.5.2: what is left after perspective correction."""

from __future__ import annotations

import numpy as np

from chapters.shared.methods import LINEAR
from raxel.calibration import calibrate_generic, calibrate_zhang
from raxel.errors import InputError
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
    transform,
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
        views, *size, rng=rng, linear=LINEAR[method]
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


def source_pixels_of(camera, plane, corrected):
    """Pixels of the source image under points (M, 2) of the corrected view."""
    flat = (corrected - plane.principal_pixel) / plane.px_per_unit
    points = transform(plane.T_camera_plane, np.pad(flat, ((0, 0), (0, 1))))
    return camera.project(points).pixels


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
