"""Write the figures and the page of one calibration into a folder."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from raxel.calibration.views.correspondence import BoardView, board_points
from raxel.calibration.views.dense import DenseView
from raxel.evaluation.cross_validation import Evaluation
from raxel.evaluation.split_half import SplitHalf
from raxel.features.detector import as_8_bit
from raxel.geometry.poses import transform
from raxel.report.canvas import encoded
from raxel.report.images import (
    ArrowScale,
    corner_figure,
    coverage_figure,
    disagreement_figure,
    error_figure,
    grid_figure,
    pooled_figure,
    residual_figure,
)
from raxel.report.page import ERRORS, PAGE, ReportImage, page
from raxel.sets import read_image
from raxel.sets.model import ImageSet, View


def write_report(
    folder: str | Path,
    image_set: ImageSet,
    entries: Iterable[tuple[View, bool, str]],
    views: Sequence[BoardView | DenseView],
    fitted: Any,
    evaluation: Evaluation,
    result: dict[str, Any],
    stability: SplitHalf | None,
) -> None:
    """Write the report of a calibration into an empty folder.

    Files are numbered, so that no name of an image becomes a name of a file.

    Parameters
    ----------
    folder : str or Path
        An empty folder.
    image_set : ImageSet
        The set.
    entries : iterable of (View, bool, str)
        For each view of the set: the view, whether it can be used, and why not.
    views : sequence of BoardView or DenseView
        The usable views, in their order.
    fitted : object
        Has the attributes `camera`, and `shape`: the BoardShape that was found with the
        camera, or None.
    evaluation : Evaluation
        Scores of the camera on these views.
    result : dict
        What `raxel calibrate` writes as JSON.
    stability : SplitHalf or None
        Split-half test of the camera, or None.
    """
    folder = Path(folder)
    scale = ArrowScale.of(
        np.concatenate([score.residuals_px for score in evaluation.images]),
        image_set.width,
    )
    pairs = list(zip(views, evaluation.images, strict=True))
    scored, images = iter(pairs), []
    for number, (taken, found, reason) in enumerate(entries, 1):
        if not found:
            images.append(ReportImage(taken.label, None, None, None, reason))
            continue
        view, score = next(scored)
        image = as_8_bit(read_image(image_set, taken.main_image))
        if view.every_pixel:
            detected, kind = grid_figure(image, view), "points"
        else:
            predicted = _predicted(fitted, view, score)
            detected, kind = corner_figure(image, view, predicted), "corners"
        residuals = residual_figure(image, *_arrows(view, score), scale)  # type: ignore[call-arg]
        names = f"{kind}-{number:03}.jpg", f"residuals-{number:03}.jpg"
        for name, drawing in zip(names, (detected, residuals), strict=True):
            (folder / name).write_bytes(encoded(drawing, ".jpg"))
        images.append(ReportImage(view.name, score, *names, score.reason))
    size = image_set.width, image_set.height
    mask = fitted.camera.mask if fitted.camera.kind == "general" else None
    drawn = {
        "residuals.png": pooled_figure(*size, [_arrows(*p) for p in pairs], scale),
        "coverage.png": coverage_figure(views, *size, mask),
    }
    if np.isfinite(fitted.camera.pixel_covariance([[(s - 1) / 2 for s in size]])).all():
        drawn[ERRORS] = error_figure(fitted.camera)
    if stability is not None:
        drawn["stability.png"] = disagreement_figure(
            *size, stability.pixels, stability.divisions[0]
        )
    for name, drawing in drawn.items():
        (folder / name).write_bytes(encoded(drawing, ".png"))
    (folder / PAGE).write_text(
        page(image_set, result, images, ERRORS in drawn), "utf-8"
    )


def _arrows(view, score):
    """Pixels and residuals (N, 2) to draw: every second row and column of a grid, to
    separate its arrows."""
    of_view = view.pixels, score.residuals_px
    if not view.every_pixel:
        return of_view
    shape = view.rows, view.columns, 2
    return [array.reshape(shape)[1::2, 1::2].reshape(-1, 2) for array in of_view]


def _predicted(fitted, view, score):
    """Predicted position of each corner (N, 2); NaN where unknown."""
    if score.T_camera_grid is None:
        return np.full(view.pixels.shape, np.nan)
    solid = board_points(view.points, fitted.shape)
    return fitted.camera.project(transform(score.T_camera_grid, solid)).pixels
