"""Pictures and page of one calibration, into a folder."""

from pathlib import Path

import numpy as np

from raxel.calibration.board_views import board_views
from raxel.features.detector import as_8_bit
from raxel.geometry.poses import transform
from raxel.report.canvas import encoded
from raxel.report.folder import PAGE
from raxel.report.page import Photograph, page
from raxel.report.pictures import (
    ArrowScale,
    corner_picture,
    coverage_picture,
    pooled_picture,
    residual_picture,
)
from raxel.sets import read_image


def write_report(folder, image_set, boards, camera, evaluation, result):
    """Write the report of a calibration into an empty folder.

    boards: the Boards it was given, found or not; evaluation: of the camera on the
    BoardViews of those found, in their order; result: what `raxel calibrate` writes as
    JSON. Files are numbered, so that no name of a photograph becomes one.
    """
    folder = Path(folder)
    views = board_views(image_set, boards)
    scale = ArrowScale.of(
        np.concatenate([score.residuals_px for score in evaluation.images]),
        image_set.width,
    )
    scored = iter(zip(views, evaluation.images, strict=True))
    photographs = []
    for number, board in enumerate(boards, 1):
        if not board.detection.found:
            reason = board.detection.reason
            photographs.append(Photograph(board.view.label, None, None, None, reason))
            continue
        view, score = next(scored)
        image = as_8_bit(read_image(image_set, board.view))
        names = f"corners-{number:03}.jpg", f"residuals-{number:03}.jpg"
        corners = corner_picture(image, view, _predicted(camera, view, score))
        residuals = residual_picture(image, view.pixels, score.residuals_px, scale)
        for name, picture in zip(names, (corners, residuals), strict=True):
            (folder / name).write_bytes(encoded(picture, ".jpg"))
        photographs.append(Photograph(view.name, score, *names, score.reason))
    size = image_set.width, image_set.height
    at = [
        (view.pixels, score.residuals_px)
        for view, score in zip(views, evaluation.images, strict=True)
    ]
    mask = camera.mask if camera.kind == "general" else None
    drawn = {
        "residuals.png": pooled_picture(*size, at, scale),
        "coverage.png": coverage_picture(views, *size, mask),
    }
    for name, picture in drawn.items():
        (folder / name).write_bytes(encoded(picture, ".png"))
    text = page(image_set, result, photographs)
    (folder / PAGE).write_text(text, "utf-8")


def _predicted(camera, view, score):
    """Where the camera expects each corner (N, 2); NaN where it does not say."""
    if score.T_camera_grid is None:
        return np.full(view.pixels.shape, np.nan)
    flat = np.pad(view.points, ((0, 0), (0, 1)))
    return camera.project(transform(score.T_camera_grid, flat)).pixels
