"""Table 3.8: corners of one board by four methods, in undistorted images."""

from functools import cache

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.captures import (
    capture_of,
    decoded,
    rig_of,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.metric_search import (
    at_four_pixels,
    by_local_fit,
)
from raxel.calibration.parametric.zhang import calibrate_zhang
from raxel.calibration.views.boards import board_views
from raxel.features import DEFAULT_DETECTOR
from raxel.features.boards import detect_boards
from raxel.features.localise.ridges import fit_ridges, gradient
from raxel.features.localise.saddle import blurred, fit_saddles
from raxel.features.localise.subpix import opencv_subpix
from raxel.geometry.homography import (
    apply_homography,
    homography_dlt,
    refine_homography,
)
from raxel.multiview.perspective_view import perspective_view, resample, source_pixels
from raxel.sets import load_set
from repro.run.rendered import rendered_set

# In 16-bit images the camera's rounding to 8 bits is the only noise.
NOISE = {8: {}, 16: {"noise": 257 / np.sqrt(12)}}


def corner_trial(condition, rng):
    """Return residuals of every corner by every method and setting, at one pose.

    condition: rig, boards (the rig whose images calibrate the camera), seed, pose
    (its number), bits (of the undistorted images), windows: full widths, px; blurs:
    SD, px. Returns the mean residual (px) by method, window and blur, infinite
    where a corner was not found. For the best setting of each method, also returns
    the corners and their residuals, and (`true_lens`) the residuals after
    undistortion with the true lens.
    """
    camera = calibrated(condition["boards"], condition["seed"])
    sources = source_pixels(camera, perspective_view(camera))
    image_set, view = capture_of(condition["rig"], condition["seed"], condition["pose"])
    grid, picture = decoded(
        image_set,
        view,
        lambda taken: resample(in_bits(taken, condition["bits"]), sources),
        neighbours=True,
        fill=True,
        **NOISE[condition["bits"]],
    )
    metric = image_set.target.chessboard_points()
    found = {
        "four nearest pixels": at_four_pixels(grid, metric)[None],
        "local fit": by_local_fit(grid, metric)[None],
    }
    start = starts(found["local fit"][0], metric)
    found |= sweep(picture, start, condition["windows"], condition["blurs"])
    truth = rig_of(condition["rig"]).camera
    out = {name: best_of(corners, metric) for name, corners in found.items()}
    for name, corners in found.items():
        best = corners.reshape(-1, *metric.shape)[out[name]["best"]]
        moved = residual_of(through(camera, truth, best), metric)
        out[name]["true_lens"] = {key: moved[key] for key in ("mean", "sd")}
    return out | {
        "metric": metric,
        "largest_window_px": largest_window(start, picture.shape),
        "square_px": square_px(start, metric),
        "middle": camera.K[:2, 2],
        "radial": camera.radial,
        "views": len(image_set.views),
    }


def starts(corners, metric):
    """Return whole pixels (n, 2) from which corners are localised, as from a detector.

    Corners that the active grid lacks are predicted from the others.
    """
    known = np.isfinite(corners[:, :1])
    return np.rint(np.where(known, corners, mapped(corners, metric)))


def mapped(corners, metric):
    """Return the metric grid (n, 2) by the homography to the corners found."""
    found = np.isfinite(corners[:, 0])
    H = refine_homography(
        homography_dlt(metric[found], corners[found]), metric[found], corners[found]
    )
    return apply_homography(H, metric)


def in_bits(picture, bits):
    """Return an 8-bit image as it is, or in 16 bits to reduce rounding."""
    return picture if bits == 8 else picture.astype(np.uint16) * 257


@cache
def calibrated(rig, seed):
    """Return the camera that Zhang's method gives from a rig's chessboard images."""
    boards = load_set(rendered_set(rig, seed))
    found = detect_boards(boards, DEFAULT_DETECTOR, boards.views, lambda line: None)
    views = board_views(boards, found)
    return calibrate_zhang(views, boards.width, boards.height).camera


def through(camera, truth, corners):
    """Return corners (n, 2) undistorted with one camera, as by another."""
    as_taken = camera.project(perspective_view(camera).directions(corners)).pixels
    rays = truth.rays(as_taken).directions
    return rays[:, :2] / rays[:, 2:] @ truth.K[:2, :2].T + truth.K[:2, 2]


def sweep(picture, start, windows, blurs):
    """Return {method: corners (settings..., n, 2)} at every setting, NaN if not found.

    A window that leaves the image at any corner finds none.
    """
    if picture.dtype == np.uint16:
        picture = (picture / 257).astype(np.float32)
    slopes = gradient(picture.astype(float))
    nowhere = np.full_like(start, np.nan)
    fit = [inside(start, picture.shape, w // 2).all() for w in windows]

    def in_windows(method):
        pairs = zip(windows, fit, strict=True)
        return np.array([method(w) if fits else nowhere for w, fits in pairs])

    def derivative(window):
        ridges, settled = fit_ridges(slopes, start, window)
        return kept(ridges[:, :2], settled)

    def opencv(half):
        moved = opencv_subpix(picture, start, half)
        return kept(moved, (moved != start).any(axis=1))

    def saddle(blur):
        soft = blurred(picture.astype(float), blur)
        return in_windows(lambda window: kept(*fit_saddles(soft, start, window)))

    return {
        "derivative": in_windows(derivative),
        "OpenCV": in_windows(lambda window: opencv(window // 2)),
        # The same numbers as half-windows.
        "OpenCV half": np.array([opencv(window) for window in windows]),
        "saddle point": np.array([saddle(blur) for blur in blurs]),
    }


def kept(corners, good):
    """Return corners (n, 2), NaN where they are not valid."""
    return np.where(good[:, None], corners, np.nan)


def inside(corners, shape, half):
    """Return which corners (n, 2) have a window of this half-width inside the image."""
    size = np.array(shape[::-1])
    return ((corners >= half) & (corners <= size - 1 - half)).all(axis=1)


def largest_window(corners, shape):
    """Return the full width (px) of the largest window that fits around all corners."""
    room = min(corners.min(), (np.array(shape[::-1]) - 1 - corners).min())
    return 2 * int(room) + 1


def residual_of(corners, metric):
    """Return residual vectors (px) after the homography from the metric grid (n, 2)."""
    found = np.isfinite(corners[:, 0])
    vectors = corners - mapped(corners, metric)
    size = np.linalg.norm(vectors[found], axis=1)
    return {
        "corners": corners,
        "vectors": vectors,
        "mean": float(size.mean()),
        "sd": float(size.std(ddof=1)),
        "lost": int((~found).sum()),
    }


def best_of(settings, metric):
    """Return the mean residual at each setting, and the residuals of the best one.

    settings: corners (..., n, 2). The mean is infinite where a setting loses a
    corner.
    """
    shape = settings.shape[:-2]
    flat = settings.reshape(-1, *settings.shape[-2:])
    mean = np.full(len(flat), np.inf)
    lost = np.isnan(flat[..., 0]).sum(axis=1)
    for k in np.flatnonzero(lost == 0):
        mean[k] = residual_of(flat[k], metric)["mean"]
    best = int(mean.argmin()) if (lost == 0).any() else int(lost.argmin())
    return residual_of(flat[best], metric) | {
        "means": mean.reshape(shape),
        "best": best,
    }


def square_px(corners, metric):
    """Return the median side (px) of a square of the board."""
    lattice = corners.reshape(-1, int(np.sqrt(len(metric))), 2)
    return float(np.nanmedian(np.linalg.norm(np.diff(lattice, axis=1), axis=2)))
