"""Figures of a calibration, drawn in pixels of the camera's image.

Pixel centres are at integers; an image ends half a pixel outside the outermost ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import cv2
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from raxel.calibration.views.correspondence import BoardView
from raxel.calibration.views.dense import DenseView
from raxel.cameras.core.base import Camera
from raxel.evaluation.coverage import board_counts
from raxel.evaluation.ray_errors import COLUMNS, ROWS
from raxel.evaluation.split_half import Division

WIDTH_IN, DPI = 9.6, 100
MARGIN_IN = 0.75  # for titles and labels
TINT = 0.55  # opacity of a grid's points over the image
PALE = 0.4  # opacity of the image behind residuals
ARROW_SHARE = 0.05  # of the image's width: the 95th percentile of residuals
MAX_ARROW_RATIO = 3.0  # times that; longer arrows are truncated
# Of boards, in turn; distinguishable without red or green.
COLOURS = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#3c3c3c"
RESIDUAL, TRUNCATED, MISSING, QUIET = "#003ca0", "#c81e1e", "#dc2828", "#969696"
BOARDS = ListedColormap(["white", "#aaceeb", "#64a5de", "#1e5faa"])  # 0 to 3 and more
# Steps of predicted SDs, and their colours with the one above.
ERROR_STEPS_PX = 0.0, 0.05, 0.1, 0.2, 0.5, 1.0
ERROR_COLOURS = ListedColormap(
    ["#deebf7", "#9ecae1", "#6baed6", "#3182bd", "#08519c", "#be3c3c"], "errors"
).with_extremes(bad="#c8c8c8")
N_ERRORS = 240  # computed along the width of the image


def image_figure(
    width: int, height: int, rows: int = 1, columns: int = 1
) -> tuple[Figure, list[Any]]:
    """Return a figure and its axes, each showing an image of width x height px."""
    size = WIDTH_IN, rows * (WIDTH_IN / columns * height / width + MARGIN_IN)
    # Fixed margins take half the time, which counts for the figures of all images.
    layout: Any = "compressed" if columns == 1 else "none"
    figure = Figure(size, dpi=DPI, layout=layout)
    if columns > 1:
        side, edge = 0.4 / WIDTH_IN, MARGIN_IN / 2 / size[1]
        figure.subplots_adjust(side, edge, 1 - side / 2, 1 - edge, wspace=0.1)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for each in axes:
        each.set(aspect="equal", xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
        each.tick_params(labelsize=7)
    return figure, list(axes)


def show_image(axes: Any, image: np.ndarray, alpha: float = 1.0) -> None:
    """Show a grey image (h, w) uint8, reduced to what the figure resolves."""
    height, width = image.shape
    step = min(1.0, WIDTH_IN * DPI / width)
    size = max(1, round(step * width)), max(1, round(step * height))
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    show_array(axes, small, width, height, cmap="gray", vmin=0, vmax=255, alpha=alpha)


def show_array(
    axes: Any, array: np.ndarray, width: int, height: int, **how: Any
) -> Any:
    """Show an array over the whole of an image of width x height px."""
    extent = -0.5, width - 0.5, height - 0.5, -0.5
    return axes.imshow(array, extent=extent, interpolation="nearest", **how)


def typical_length(residuals: np.ndarray) -> float:
    """Return the 95th percentile of the lengths of residuals (N, 2), some NaN, px."""
    lengths = np.linalg.norm(residuals, axis=1)
    lengths = lengths[np.isfinite(lengths)]
    return max(float(np.percentile(lengths, 95)), 1e-6) if len(lengths) else 1.0


def draw_arrows(
    axes: Any, pixels: np.ndarray, residuals: np.ndarray, long: float, colour: str
) -> None:
    """Draw residuals (N, 2) at pixels (N, 2); crosses where there is a pixel alone.

    Residuals of length `long` get ARROW_SHARE of the image's width; longer ones than
    MAX_ARROW_RATIO times that are truncated, in another colour.
    """
    known = np.isfinite(residuals).all(axis=1)
    axes.plot(*pixels[~known].T, "x", color=QUIET, markersize=3)
    lengths = np.linalg.norm(residuals[known], axis=1)
    shares = np.minimum(1, MAX_ARROW_RATIO * long / np.maximum(lengths, 1e-12))
    magnified = ARROW_SHARE * abs(np.diff(axes.get_xlim())[0]) / long
    arrows = axes.quiver(
        *pixels[known].T, *(residuals[known] * shares[:, None]).T,
        color=np.where(shares < 1, TRUNCATED, colour),
        angles="xy", scale_units="xy", scale=1 / magnified, width=0.0025,
    )  # fmt: skip
    key = float(f"{long:.0e}")
    axes.quiverkey(
        arrows,
        0.02,
        1.025,
        key,
        f"{key:g} px",
        labelpos="E",
        fontproperties={"size": 8},
    )
    axes.set_title(
        f"magnified {magnified:.3g} times; above {MAX_ARROW_RATIO * long:.2g} px "
        "truncated (red)",
        fontsize=8,
        loc="right",
    )


def board_figure(
    image: np.ndarray,
    view: BoardView,
    predicted: np.ndarray,
    residuals: np.ndarray,
    long: float,
) -> Figure:
    """Return the corners of a board over its image, next to their residuals.

    Parameters
    ----------
    image : ndarray, shape (H, W), uint8
        The image.
    view : BoardView
        The board: one line per row, numbers at the ends of the rows.
    predicted : ndarray, shape (N, 2)
        Where missing corners are expected; NaN where unknown.
    residuals : ndarray, shape (N, 2)
        Detected minus projected corners, px; NaN where not scored.
    long : float
        Length of a long residual of the set (`typical_length`), px.

    Returns
    -------
    Figure
        The figure.
    """
    figure, (left, right) = image_figure(image.shape[1], image.shape[0], columns=2)
    show_image(left, image)
    for number, row in enumerate(view.pixels.reshape(view.rows, view.columns, 2)):
        left.plot(*row.T, "-", color="white", linewidth=2.5)
        colour = COLOURS[number % len(COLOURS)]
        left.plot(*row.T, "o-", color=colour, linewidth=1, markersize=3, mfc="none")
        for column in (0, view.columns - 1):
            if np.isfinite(row[column, 0]):
                label(left, row[column], str(number * view.columns + column))
    missing = np.isnan(view.pixels[:, 0]) & np.isfinite(predicted[:, 0])
    left.plot(*predicted[missing].T, "x", color=MISSING, markersize=5)
    for k in np.flatnonzero(missing):
        label(left, predicted[k], f"{k} missing", MISSING)
    _show_residuals(right, image, view.pixels, residuals, long)
    return figure


def grid_figure(
    image: np.ndarray,
    view: DenseView,
    pixels: np.ndarray,
    residuals: np.ndarray,
    long: float,
) -> Figure:
    """Return the points of an active grid over its image, next to residuals.

    Red increases along x and green along y of the grid. Dots are the pixels to which
    models and poses are fitted; residuals (N, 2) are those at `pixels` (N, 2).
    """
    figure, (left, right) = image_figure(image.shape[1], image.shape[0], columns=2)
    show_image(left, image)
    step = max(1, image.shape[1] // N_ERRORS)
    location = view.location[::step, ::step]
    low, high = np.nanmin(location, axis=(0, 1)), np.nanmax(location, axis=(0, 1))
    colour = np.zeros((*location.shape[:2], 4))
    colour[..., :2] = np.nan_to_num((location - low) / np.maximum(high - low, 1e-9))
    colour[..., 3] = TINT * np.isfinite(location[..., 0])
    show_array(left, colour, *image.shape[::-1])
    left.plot(*view.pixels.T, ".", color="white", markersize=1)
    left.set_title(f"{view.area()} pixels with a point", fontsize=8, loc="left")
    _show_residuals(right, image, pixels, residuals, long)
    return figure


def residual_figure(
    image: np.ndarray, pixels: np.ndarray, residuals: np.ndarray, long: float
) -> Figure:
    """Return residuals (N, 2) at pixels (N, 2) of an image (H, W) uint8."""
    figure, (axes,) = image_figure(*image.shape[::-1])
    _show_residuals(axes, image, pixels, residuals, long)
    return figure


def _show_residuals(axes, image, pixels, residuals, long):
    show_image(axes, image, PALE)
    draw_arrows(axes, pixels, residuals, long, RESIDUAL)


def pooled_figure(
    width: int,
    height: int,
    boards: Iterable[tuple[np.ndarray, np.ndarray]],
    long: float,
) -> Figure:
    """Return residuals of all boards (pixels, residuals), a colour each."""
    figure, (axes,) = image_figure(width, height)
    for number, board in enumerate(boards):
        draw_arrows(axes, *board, long, COLOURS[number % len(COLOURS)])
    return figure


def disagreement_figure(
    width: int, height: int, pixels: np.ndarray, division: Division
) -> Figure:
    """Return the differences between the rays of halves, at pixels (N, 2).

    Arrows within the expected difference stay short.
    """
    figure, (axes,) = image_figure(width, height)
    long = max(typical_length(division.field), division.allowed_px)
    draw_arrows(axes, pixels, division.field, long, RESIDUAL)
    return figure


def coverage_figure(
    views: Sequence[BoardView | DenseView],
    width: int,
    height: int,
    mask: np.ndarray | None = None,
) -> Figure:
    """Return how many views cover each part of the image, with their corners.

    mask: (height, width) bool, True where a table has a ray; its limit is drawn. None
    for a camera with rays everywhere.
    """
    figure, (axes,) = image_figure(width, height)
    step = max(1, width // N_ERRORS // 4)
    counts = board_counts(views, width, height)[::step, ::step]
    shown = show_array(axes, counts, width, height, cmap=BOARDS, vmin=-0.5, vmax=3.5)
    bar = figure.colorbar(shown, ax=axes, ticks=range(4), pad=0.01, shrink=0.6)
    bar.set_ticklabels(["0", "1", "2", "3+"])
    if mask is not None:
        v, u = (np.arange(n)[::step] for n in mask.shape)
        axes.contour(u, v, mask[::step, ::step], [0.5], colors="#ff7800")
        axes.set_title("orange: limit of the rays", fontsize=8, loc="left")
    for view in views:
        if not view.every_pixel:
            axes.plot(*view.pixels.T, ".", color="black", markersize=1.5)
    return figure


def error_figure(camera: Camera, place: str | None = None) -> Figure:
    """Return the predicted SD of where in the image the rays of a camera belong.

    place: the ninth of the image for the next image (`ray_errors.next_place`), framed.
    """
    width, height = camera.width, camera.height
    figure, (axes,) = image_figure(width, height)
    n = N_ERRORS, max(1, round(N_ERRORS * height / width))
    u, v = (
        (np.arange(k) + 0.5) * side / k - 0.5
        for k, side in zip(n, (width, height), strict=True)
    )
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    errors = camera.pixel_covariance(pixels)
    sd = np.sqrt(np.trace(errors, axis1=1, axis2=2)).reshape(n[::-1])
    norm = BoundaryNorm(ERROR_STEPS_PX, ERROR_COLOURS.N, extend="max")
    shown = show_array(axes, sd, width, height, cmap=ERROR_COLOURS, norm=norm)
    figure.colorbar(shown, ax=axes, label="SD (px)", pad=0.01, shrink=0.6)
    if place:
        row, column = place.split()
        corner = np.array([COLUMNS.index(column) * width, ROWS.index(row) * height])
        corner = corner / 3 - 0.5
        frame = Rectangle(
            tuple(corner), width / 3, height / 3, fill=False, linestyle="--"
        )
        axes.add_patch(frame)
        label(axes, corner + [0, height / 30], "next image")
    return figure


def label(axes: Any, point: np.ndarray, text: str, colour: str = "black") -> None:
    """Write a text next to a point, on a white patch."""
    axes.annotate(
        text, point, (4, 3), textcoords="offset points", color=colour, fontsize=6,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8},
        annotation_clip=True,
    )  # fmt: skip
