"""One seed of section 2.5.2: boards, three calibrations, every score."""

from __future__ import annotations

import numpy as np

from chapters.shared.facade import (
    corrected_pictures,
    facade_picture,
    straightness,
)
from chapters.shared.methods import METHODS
from chapters.shared.zoom_scores import (
    calibrate,
    moran,
    radial_bias,
    residuals_of,
    scatter_of,
    stage_poses,
    steps_of,
    summary_of,
)
from chapters.shared.zoom_shots import (
    FACADE_ZOOM,
    STAGE_IMAGES,
    STAGE_ZOOM,
    camera_of,
    draw_poses,
    found_in_pictures,
    redrawn,
    views_of,
)
from raxel.errors import CalibrationError, InputError


def rendered_trial(condition, rng, counts):
    """A seed whose boards are photographed and searched."""
    zoom = condition["zoom"]
    poses = draw_poses(zoom, counts, rng)
    boards, pictures = {}, {}
    for use, of_use in poses.items():
        boards[use], pictures[use] = found_in_pictures(zoom, of_use, rng)
    errors = [seen.found - seen.true for seen in boards.values()]
    out, cameras = scores(zoom, boards, rng)
    out["errors"] = np.concatenate(errors)
    sample = example_view(zoom, boards)
    out["sample"] = pictures["calibration"][sample]
    if zoom == STAGE_ZOOM:
        out |= fields(zoom, boards, sample, cameras)
    if zoom == FACADE_ZOOM:
        out["facade"] = facade_picture(rng)
        out |= corrected_pictures(out["facade"], cameras)
    return out


def redrawn_trial(condition, rng, counts, errors):
    """A seed whose boards err as those of rendered pictures did."""
    zoom = condition["zoom"]
    poses = draw_poses(zoom, counts, rng)
    boards = {
        use: redrawn(zoom, of_use, errors[zoom], rng)
        for use, of_use in poses.items()
    }
    return scores(zoom, boards, rng)[0]


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
