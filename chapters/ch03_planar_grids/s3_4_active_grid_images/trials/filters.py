"""The active grid of Table 3.8, near and far, with each of the decoder's filters."""

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.captures import (
    capture_of,
    pictures_of,
    rig_of,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.conditions import (
    corner_conditions,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.corners import (
    calibrated,
    residual_of,
    square_px,
    through,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.metric_search import (
    at_four_pixels,
    by_local_fit,
)
from raxel.features.active_grid import decode
from raxel.multiview.perspective_view import perspective_view, resample, source_pixels

# Averaging: none; sinusoids; sinusoids and then locations, as in 3.2.2.
AS_TEXT = "7 x 7 and 3 x 3"
FILTERS = {
    "none": {"smooth": False, "neighbours": False},
    "7 x 7": {"smooth": True, "neighbours": False},
    AS_TEXT: {"smooth": True, "neighbours": True},
}
SEARCHES = {"four nearest pixels": at_four_pixels, "local fit": by_local_fit}


def filter_conditions(effort):
    """Return a condition for each distance and seed."""
    return [
        {name: one[name] for name in ("case", "seed", "rig", "boards", "pose")}
        for one in corner_conditions(effort, ("near", "far"))
    ]


def filter_trial(condition, rng):
    """Return the mean residual (px) of the active grid's corners with each filter.

    Images are undistorted as in Table 3.8; `true_lens`: as by the true lens.
    """
    camera = calibrated(condition["boards"], condition["seed"])
    sources = source_pixels(camera, perspective_view(camera))
    image_set, view = capture_of(condition["rig"], condition["seed"], condition["pose"])
    pictures, others = pictures_of(image_set, view)
    pictures = np.array([resample(picture, sources) for picture in pictures])
    lit = {k: resample(others[k], sources) for k in ("white", "black") if k in others}
    metric = image_set.target.chessboard_points()
    truth = rig_of(condition["rig"]).camera
    out = {}
    for name, options in FILTERS.items():
        grid = decode(
            pictures, view.patterns, image_set.target,
            fill=True, linear=True, **lit, **options,
        )  # fmt: skip
        for search, found_by in SEARCHES.items():
            corners = found_by(grid, metric)
            left = residual_of(corners, metric)
            moved = residual_of(through(camera, truth, corners), metric)
            out[f"{name}.{search}"] = {
                "mean": left["mean"],
                "true_lens": {"mean": moved["mean"]},
                "lost": left["lost"],
            }
    return out | {"square_px": square_px(corners, metric)}
