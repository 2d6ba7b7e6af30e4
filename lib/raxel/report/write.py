"""Write the figures and the page of one calibration into a folder."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from raxel.calibration.views.correspondence import BoardView, board_points
from raxel.calibration.views.dense import DenseView
from raxel.evaluation.cross_validation import Evaluation, ImageScore
from raxel.evaluation.diagnoses import (
    TEXT,
    camera_lines,
    comparison_lines,
    line,
    number,
    overview,
    summary,
)
from raxel.evaluation.distortion import MIN_N_BOARDS
from raxel.evaluation.split_half import (
    MAX_FACTOR,
    MAX_FACTOR_PX,
    MIN_DIFFERENCE_PX,
    MIN_RATIO,
    P_THRESHOLD,
    SplitHalf,
)
from raxel.features.detector import as_8_bit
from raxel.geometry.poses import transform
from raxel.report.figures import (
    board_figure,
    coverage_figure,
    disagreement_figure,
    error_figure,
    grid_figure,
    pooled_figure,
    typical_length,
)
from raxel.report.page import PAGE, html
from raxel.sets import read_image
from raxel.sets.model import ImageSet, View, words_of

RULE = (
    "{target}s differ from each other {found[photographs_over_scatter]:.2g} times as "
    "much as {point} scatter explains. There is a warning above {factor:g} times, if "
    "halves differ by {factor_px:g} px or more; and if halves differ by {least_px:g} "
    "px or more, {times:g} times what differences between images allow (p < "
    "{p_threshold:g}, all divisions)."
)
# What the left part of the figure of an image shows.
SEEN = {
    "board": "Left: corners, numbered row by row.",
    "grid": "Left: decoded positions; red increases along x of the grid, green along "
    "y; dots are the fitted pixels.",
}


class ReportImage(NamedTuple):
    """Hold what the page shows of one image; without score, it could not be used.

    Attributes
    ----------
    name : str
        Name of the image.
    score : ImageScore or None
        Its score.
    file : str
        Name of its figure.
    reason : str
        Remark on the image.
    """

    name: str
    score: ImageScore | None
    file: str
    reason: str


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
    words = words_of(image_set.target)
    long = typical_length(
        np.concatenate([score.residuals_px for score in evaluation.images])
    )
    pairs = list(zip(views, evaluation.images, strict=True))
    scored, images = iter(pairs), []
    for count, (taken, found, reason) in enumerate(entries, 1):
        if not found:
            images.append(ReportImage(taken.label, None, "", reason))
            continue
        view, score = next(scored)
        image = as_8_bit(read_image(image_set, taken.main_image))
        if isinstance(view, DenseView):
            pixels, residuals = _arrows(view, score)
            figure = grid_figure(image, view, pixels, residuals, long)
        else:
            expected = _predicted(fitted, view, score)
            figure = board_figure(image, view, expected, score.residuals_px, long)
        images.append(
            ReportImage(view.name, score, f"view-{count:03}.jpg", score.reason)
        )
        figure.savefig(folder / images[-1].file)
    size, camera = (image_set.width, image_set.height), fitted.camera
    mask = camera.mask if camera.kind == "general" else None
    drawn = {
        "residuals.png": pooled_figure(*size, [_arrows(*p) for p in pairs], long),
        "coverage.png": coverage_figure(views, *size, mask),
    }
    middle = [[(side - 1) / 2 for side in size]]
    has_errors = bool(np.isfinite(camera.pixel_covariance(middle)).all())
    if has_errors:
        drawn["uncertainty.png"] = error_figure(camera, result["next_image"])
    if stability is not None:
        drawn["stability.png"] = disagreement_figure(
            *size, stability.pixels, stability.divisions[0]
        )
    for name, figure in drawn.items():
        figure.savefig(folder / name, bbox_inches="tight")
    page = html(
        "calibration",
        name=image_set.name,
        camera=image_set.camera,
        result=result,
        words=words,
        overview=list(overview(result, words)),
        has_errors=has_errors,
        images=images,
        seen=SEEN[words.target],
        rows=list(_rows(image_set, result, words)),
        **_stability(result["stability"], words),
    )
    (folder / PAGE).write_text(page, "utf-8")


def _stability(found, words):
    """What the page tells of the split-half test."""
    if found is None:
        return {"stability": None}
    _, worst = line("halves", words, found, {"count": len(found["divisions"])})
    limits = {
        "factor": MAX_FACTOR,
        "factor_px": MAX_FACTOR_PX,
        "times": MIN_RATIO,
        "least_px": MIN_DIFFERENCE_PX,
        "p_threshold": P_THRESHOLD,
        "found": found,
    }
    rule = TEXT.format(RULE, **words._asdict() | limits)
    keys = "disagreement_px", "scatter_px", "allowed_px"
    forms = dict.fromkeys(keys, ".2f") | {"p_value": ".2g"}
    divisions = [
        (each["divided_by"], *(number(each[key], form) for key, form in forms.items()))
        for each in found["divisions"]
    ]
    return {
        "stability": found,
        "worst": worst,
        "rule": rule[0].upper() + rule[1:],
        "divisions": divisions,
    }


def _rows(image_set, result, words):
    """Yield (label, text) of the camera and its tests."""
    yield "image", f"{image_set.width} x {image_set.height} px"
    if "size" in result:
        yield "board size, by vote", _vote(result["size"])
    if "chosen_because" in result:
        yield line("chosen", words, result)
    yield from camera_lines(result, words)
    yield from summary(result, words, MIN_N_BOARDS)
    if counts := result["wrong_points_of"]:
        yield (
            f"excluded {words.point}s",
            ", ".join(f"{name}: {n}" for name, n in counts.items()),
        )
    yield from comparison_lines(result.get("cross_validation", {}), words)


def _vote(size):
    """The vote of the images for the size of a board, as text."""
    votes = [
        f"{vote['columns']} x {vote['rows']} corners in {len(vote['files'])}"
        for vote in size["votes"]
    ]
    return f"{', '.join(votes)} of {size['photographs']} images"


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
