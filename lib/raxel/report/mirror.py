"""The report of a flexible mirror: shapes, support, residuals, flags."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from raxel.calibration.mirror.clamp import plane_through
from raxel.calibration.mirror.observations import normalised, support_of
from raxel.calibration.mirror.stages import MirrorCalibration
from raxel.evaluation.diagnoses import mirror_lines
from raxel.features.detector import as_8_bit
from raxel.report.figures import (
    COLOURS,
    DPI,
    MISSING,
    PALE,
    WIDTH_IN,
    image_figure,
    residual_figure,
    show_image,
    typical_length,
)
from raxel.report.page import PAGE, html
from raxel.sets import read_image
from raxel.sets.mirror_set import MirrorSet

N_SAMPLES = 81  # along a profile
N_LEVELS = 8  # lines of equal height, about
N_HEIGHTS = 320  # computed along the width of a figure
KNOT, LEVEL = "#3c7896", "#c82828"


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


def deflections(along: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return the height (n,), mm, of the end of each profile over the first shape."""
    return height[:, -1] - np.interp(along[:, -1], along[0], height[0])


def profile_figure(along: np.ndarray, height: np.ndarray) -> Figure:
    """Return the profiles (n, N_SAMPLES), mm, of all stages in one chart."""
    figure = Figure((WIDTH_IN, 4), dpi=DPI, layout="constrained")
    axes = figure.subplots()
    axes.set_prop_cycle(color=COLOURS)
    for stage, profile in enumerate(zip(along, height, strict=True)):
        axes.plot(*profile, label=f"stage {stage}")
    axes.set(xlabel="distance from the clamp line (mm)", ylabel="height (mm)")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    return figure


def shape_figure(
    image: np.ndarray, calibration: MirrorCalibration, stage: int
) -> Figure:
    """Return a stage over its image (H, W) uint8.

    Contour lines of the height over the plane of the first shape, the knots, and the
    number of corners between them.
    """
    camera = calibration.cameras[stage]
    figure, (axes,) = image_figure(*image.shape[::-1])
    show_image(axes, image, PALE)
    v, u = (
        np.linspace(0, n - 1, max(2, round(N_HEIGHTS * n / image.shape[1])))
        for n in image.shape
    )
    pixels = np.stack(np.meshgrid(u, v), axis=-1)
    height = heights(calibration, stage, pixels.reshape(-1, 2))
    if np.isfinite(height).any():
        height = height.reshape(pixels.shape[:2])
        lines = axes.contour(u, v, height, N_LEVELS, colors=LEVEL, linewidths=0.8)
        axes.clabel(lines, fmt="%g mm", fontsize=7)
    _draw_knots(axes, camera, calibration.bundle.corners[stage])
    return figure


def _draw_knots(axes, camera, corners):
    grid = camera.grid
    for axis, breaks in enumerate(grid.breaks):
        other = np.linspace(*grid.breaks[1 - axis][[0, -1]], N_SAMPLES)
        for at in breaks:
            uv = np.column_stack([np.full(N_SAMPLES, at), other])
            line = _pixels(camera, uv if axis == 0 else uv[:, ::-1])
            axes.plot(*line.T, color=KNOT, linewidth=0.8)
    middles = [(breaks[1:] + breaks[:-1]) / 2 for breaks in grid.breaks]
    for (i, j), count in np.ndenumerate(support_of(grid, corners).cells):
        (pixel,) = _pixels(camera, np.array([[middles[0][i], middles[1][j]]]))
        if np.isfinite(pixel).all():
            colour = "black" if count else MISSING
            axes.text(*pixel, f"{count}", color=colour, fontsize=8, clip_on=True)


def _pixels(camera, uv):
    """Pixels (N, 2) of places (N, 2) of a spline's box."""
    p = camera.grid.unturned(uv)
    return camera.viewer.project(np.column_stack([p, np.ones(len(p))])).pixels


def _first_plane(camera):
    """(n, k) of the plane n . X = k nearest to a shape, n towards the viewer."""
    u, v = (np.linspace(b[0], b[-1], 9) for b in camera.grid.breaks)
    uv = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    n, k = plane_through(camera.mirror.points(camera.grid.unturned(uv)))
    return (n, k) if k < 0 else (-n, -k)


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
    residuals = found.bundle.residuals
    long = typical_length(np.concatenate(residuals))
    figures: dict[str, Figure] = {}
    images: dict[int, np.ndarray] = {}
    views: list[list[tuple[str, str]]] = [[] for _ in found.cameras]
    for count, (seen, off) in enumerate(zip(found.views, residuals, strict=True), 1):
        name, file = seen.view.name, f"residuals-{count:03}.jpg"
        image = as_8_bit(read_image(mirror_set.stages, files[name]))
        images.setdefault(seen.stage, image)
        pixels = _counted(found.cameras[seen.stage], seen.view.pixels)
        figures[file] = residual_figure(image, pixels, off, long)
        views[seen.stage].append((name, file))
    for stage, image in images.items():
        figures[f"shape-{stage:03}.jpg"] = shape_figure(image, found, stage)
    along, height = profiles(found)
    figures["profiles.png"] = profile_figure(along, height)
    for file, figure in figures.items():
        figure.savefig(folder / file, bbox_inches="tight")
    page = html(
        "mirror",
        name=mirror_set.name,
        result=result,
        pairs=mirror_lines(result),
        moved=deflections(along, height),
        views=views,
    )
    (folder / PAGE).write_text(page, "utf-8")


def _counted(camera, pixels):
    """Those of pixels (N, 2) that count in the bundle: found, and between the knots."""
    with np.errstate(invalid="ignore"):
        return pixels[camera.grid.inside(normalised(camera.viewer, pixels))]
