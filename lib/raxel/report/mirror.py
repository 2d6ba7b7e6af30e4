"""The report of a flexible mirror: shapes, support, residuals, flags."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np

from raxel.calibration.mirror.clamp import plane_through
from raxel.calibration.mirror.observations import normalised, support_of
from raxel.calibration.mirror.stages import MirrorCalibration
from raxel.evaluation.diagnoses import mirror_lines, number
from raxel.features.detector import as_8_bit
from raxel.report.canvas import INK, MISSING, QUIET, Canvas, encoded
from raxel.report.images import COLOURS, PALE, ArrowScale, level_lines, residual_figure
from raxel.report.page import PAGE, document, figure, numbers, pairs, table, warnings
from raxel.sets import read_image
from raxel.sets.mirror_set import MirrorSet

# Shapes of a flexible mirror: profiles in one chart, and contour lines over images.


CHART = (960, 400)  # px
FRAME = (90, 30, 30, 60)  # margins in px: left, top, right, bottom
N_SAMPLES = 81  # along a profile
N_TICKS = 6  # on an axis, about
LEVELS, MIN_STEP_MM = 8, 0.01  # lines of equal height, about; mm between them
STEP_PX = 2  # of a figure, between computed heights, along each axis
KNOT, LEVEL = (150, 120, 60), (40, 40, 200)
ROUND_STEPS = (1.0, 2.0, 5.0, 10.0)


def profiles(calibration):
    """(along, height), (n, N_SAMPLES) mm each, of the centre line of each stage.

    along: distance from the clamp line in the plane of the first shape; height: over
    that plane, towards the camera.
    """
    first, found = calibration.cameras[0], []
    n, k = _first_plane(first)
    start = None
    for camera in calibration.cameras:
        grid = camera.grid
        u = grid.turned(calibration.line.ends)[:, 0].mean()
        ends, across = grid.breaks[0][[0, -1]], grid.breaks[1][[0, -1]]
        free = ends[np.argmax(np.abs(ends - u))]
        place = np.linspace(np.clip(u, *ends), free, N_SAMPLES)
        middle = np.full(N_SAMPLES, across.mean())
        S = camera.mirror.points(grid.unturned(np.column_stack([place, middle])))
        start = S[0] if start is None else start
        height = S @ n - k
        flat = S - height[:, None] * n
        found.append((np.linalg.norm(flat - start, axis=1), height))
    return tuple(np.stack(one) for one in zip(*found, strict=True))


def heights(calibration, stage, pixels):
    """Heights (N,), mm, of what pixels (N, 2) see of a stage's mirror, over the plane
    of the first shape, towards the camera; NaN outside the knots."""
    camera, (n, k) = calibration.cameras[stage], _first_plane(calibration.cameras[0])
    p = normalised(camera.viewer, pixels)
    found = np.full(len(p), np.nan)
    inside = camera.grid.inside(p)
    found[inside] = camera.mirror.points(p[inside]) @ n - k
    return found


def profile_figure(along, height):
    """The profiles (n, N_SAMPLES), mm, of all stages in one chart."""
    canvas = Canvas(*CHART)
    left, above, right, below = FRAME
    low = np.array([0.0, min(height.min(), 0.0)])
    high = np.array([along.max(), max(height.max(), low[1] + 1.0)])
    size = np.array([CHART[0] - left - right, CHART[1] - above - below])

    def place(x, y):
        share = (np.column_stack([x, y]) - low) / (high - low)
        return np.column_stack(
            [left + share[:, 0] * size[0], above + (1 - share[:, 1]) * size[1]]
        )

    for axis in (0, 1):
        for tick in _ticks(low[axis], high[axis]):
            ends = np.array([low, high])
            ends[:, axis] = tick
            line = place(*ends.T)
            canvas.line(line, QUIET)
            at = line[0] + ([-14, 20] if axis == 0 else [-60, 10])
            canvas.text(at, f"{tick:g}")
    canvas.text([CHART[0] / 2 - 120, CHART[1] - 6], "distance from the clamp line (mm)")
    canvas.text([0, 20], "height (mm)")
    legend = []
    for stage, profile in enumerate(zip(along, height, strict=True)):
        colour = COLOURS[stage % len(COLOURS)]
        canvas.line(place(*profile), colour, 2)
        legend.append((colour, f"stage {stage}"))
    return canvas.with_legend(legend)


def shape_figure(image, calibration, stage):
    """A stage over its image (H, W) uint8: contour lines of the height over the plane
    of the first shape, the knots, and the number of corners between them."""
    camera = calibration.cameras[stage]
    canvas = Canvas(image.shape[1], image.shape[0], image, PALE)
    height = _shown_heights(canvas, calibration, stage)
    legend = [(KNOT, "knots, with the corners between them")]
    known = height[np.isfinite(height)]
    if len(known):
        step = _round(max(np.ptp(known) / LEVELS, MIN_STEP_MM))
        canvas.image[level_lines(height, step)] = LEVEL
        legend.append((LEVEL, f"equal height, every {step:g} mm"))
    _draw_knots(canvas, camera, calibration.bundle.corners[stage])
    return canvas.with_legend(legend)


def _draw_knots(canvas, camera, corners):
    grid = camera.grid
    u, v = grid.breaks
    for axis, breaks in enumerate(grid.breaks):
        other = np.linspace(*grid.breaks[1 - axis][[0, -1]], N_SAMPLES)
        for at in breaks:
            uv = np.column_stack([np.full(N_SAMPLES, at), other])
            canvas.line(_pixels(camera, uv if axis == 0 else uv[:, ::-1]), KNOT)
    cells = support_of(grid, corners).cells
    middles = [(breaks[1:] + breaks[:-1]) / 2 for breaks in (u, v)]
    for i, x in enumerate(middles[0]):
        for j, y in enumerate(middles[1]):
            (pixel,) = _pixels(camera, np.array([[x, y]]))
            canvas.text(pixel, f"{cells[i, j]}", INK if cells[i, j] else MISSING, 0.5)


def _pixels(camera, uv):
    """Pixels (N, 2) of places (N, 2) of a spline's box."""
    p = camera.grid.unturned(uv)
    return camera.viewer.project(np.column_stack([p, np.ones(len(p))])).pixels


def _shown_heights(canvas, calibration, stage):
    """Heights (h, w), mm, at the pixels of a canvas; NaN outside the knots."""
    h, w = canvas.image.shape[:2]
    # At the middle of what a height stands for, where `resize` takes it to be.
    x, y = (np.arange(0, n, STEP_PX) + (STEP_PX - 1) / 2 for n in (w, h))
    x, y = np.meshgrid(x, y)
    pixels = (np.column_stack([x.ravel(), y.ravel()]) + 0.5) / canvas.scale - 0.5
    height = heights(calibration, stage, pixels).reshape(x.shape)
    return cv2.resize(height, (w, h), interpolation=cv2.INTER_LINEAR)


def _first_plane(camera):
    """(n, k) of the plane n . X = k nearest to a shape, n towards the viewer."""
    u, v = (np.linspace(b[0], b[-1], 9) for b in camera.grid.breaks)
    uv = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    n, k = plane_through(camera.mirror.points(camera.grid.unturned(uv)))
    return (n, k) if k < 0 else (-n, -k)


def _ticks(low, high):
    step = _round((high - low) / N_TICKS)
    return step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)


def _round(length):
    """The largest of 1, 2, 5 times a power of ten that is not above a length."""
    power = 10.0 ** np.floor(np.log10(max(length, 1e-6)))
    return max(
        power * step for step in ROUND_STEPS if power * step <= length * 1.0001 + 1e-6
    )


HEADS = (
    "Stage", "Specified deflection (mm)", "Deflection at the end (mm)", "Residual (mm)",
    "Corners", "Outliers", "Ray error, median (deg)", "Ray error, largest (deg)",
)  # fmt: skip


class ShownView(NamedTuple):
    """Hold what the page shows of one image of a board.

    Attributes
    ----------
    stage : int
        Stage of the mirror.
    name : str
        Name of the view.
    residuals : str
        Name of its figure of residuals.
    """

    stage: int
    name: str
    residuals: str


def write_mirror_report(
    folder: str | Path,
    mirror_set: MirrorSet,
    found: MirrorCalibration,
    result: dict[str, Any],
) -> None:
    """Write the report of the calibration of a mirror set into an empty folder.

    Files are numbered, so that no name of an image becomes a name of a file.

    Parameters
    ----------
    folder : str or Path
        An empty folder.
    mirror_set : MirrorSet
        The set.
    found : MirrorCalibration
        Its calibration.
    result : dict
        What `raxel calibrate` writes as JSON.
    """
    folder = Path(folder)
    files = {view.label: view.main_image for view in mirror_set.stages.views}
    off = found.bundle.residuals
    scale = ArrowScale.of(np.concatenate(off), mirror_set.size[0])
    views, of_stage = [], {}  # type: ignore[var-annotated]
    for count, (shown, residuals) in enumerate(zip(found.views, off, strict=True), 1):
        name = shown.view.name
        image = as_8_bit(read_image(mirror_set.stages, files[name]))
        of_stage.setdefault(shown.stage, image)
        views.append(ShownView(shown.stage, name, f"residuals-{count:03}.jpg"))
        pixels = _counted(found.cameras[shown.stage], shown.view.pixels)
        drawn = residual_figure(image, pixels, residuals, scale)
        (folder / views[-1].residuals).write_bytes(encoded(drawn, ".jpg"))
    for stage, image in of_stage.items():
        drawn = shape_figure(image, found, stage)
        (folder / _shape_name(stage)).write_bytes(encoded(drawn, ".jpg"))
    along, height = profiles(found)
    drawn = encoded(profile_figure(along, height), ".png")
    (folder / "profiles.png").write_bytes(drawn)
    moved = height[:, -1] - np.interp(along[:, -1], along[0], height[0])
    (folder / PAGE).write_text(_page(mirror_set, result, views, moved), "utf-8")


def _counted(camera, pixels):
    """Those of pixels (N, 2) that count in the bundle: found, and between the knots."""
    with np.errstate(invalid="ignore"):
        return pixels[camera.grid.inside(normalised(camera.viewer, pixels))]


def _page(mirror_set, result, views, moved):
    """The page as text; moved (n,) mm: the end of each profile, off the first shape."""
    title = escape(f"{mirror_set.name}: calibration, {result['model']}")
    parts = [
        f"<h1>{title}</h1>",
        *warnings(result["warnings"]),
        pairs(mirror_lines(result)),
        "<h2>Shapes</h2>",
        figure(
            "profiles.png",
            "Centre line of the mirror at all stages, from the clamp line to the last "
            "knot: height over the plane of the first shape, towards the camera. The "
            "table lists the deflection of its end.",
        ),
        _table(result["stages"], moved),
    ]
    for stage, about in enumerate(result["stages"]):
        parts += _stage(stage, about, [view for view in views if view.stage == stage])
    return document(title, parts)


def _table(stages, moved):
    rows = []
    for stage, (about, distance) in enumerate(zip(stages, moved, strict=True)):
        error = about["predicted_ray_error_deg"]
        deflection = about.get("deflection_mm")
        cells = (
            "" if deflection is None else f"{deflection:g}",
            number(distance, ".2f") if stage else "",
            number(about["residual_mm"]["mean"], ".3f"),
            about.get("corners", ""),
            about.get("wrong_corners", ""),
            number(error["median"], ".3f"),
            number(error["largest"], ".3f"),
        )
        rows.append(f"<td>{stage}</td>{numbers(cells)}")
    return table(HEADS, rows)


def _stage(stage, about, views):
    """HTML of one stage: its shape and knots, its flags, its boards' residuals."""
    parts = [f"<h2>Stage {stage}</h2>"]
    if stage:
        support = about["support"]
        counts, across = (", ".join(map(str, support[f"along_{k}"])) for k in "uv")
        parts.append(
            f"<p>From {escape(about['before'])} to {escape(about['after'])}. Corners "
            f"per knot interval: {counts} along the mirror, {across} across it."
            "</p>"
        )
        parts += [f"<p>flagged: {escape(text)}</p>" for text in about["flags"]]
    else:
        parts.append(
            "<p>The first shape is determined by the monitor, not by the corners that "
            "the figure counts.</p>"
        )
    shape = figure(
        _shape_name(stage),
        "Contour lines of the height over the plane of the first shape, knots, and "
        "corners per knot interval. No corner constrains the shape where it is 0.",
    )
    residuals = (
        figure(view.residuals, f"Residuals of {view.name}, same scale for all.")
        for view in views
    )
    return [*parts, shape, *residuals]


def _shape_name(stage):
    return f"shape-{stage:03}.jpg"
