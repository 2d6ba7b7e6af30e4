"""Figures of a report: views with residuals, and active grids.

Figures of active grids: all patterns on one sheet, and the decoded positions.
"""

from typing import NamedTuple

import cv2
import numpy as np

from raxel.evaluation.coverage import board_counts
from raxel.features.active_grid import REASONS
from raxel.features.active_grid.coding import (
    ALONE,
    BORDER,
    BREAK,
    DARK,
    FILLED,
    OUTSIDE,
    SATURATED,
    UNREADABLE,
)
from raxel.report.canvas import FONT, INK, MISSING, PAPER, QUIET, Canvas
from raxel.sets.patterns import pattern_image

# Views of a calibration: corners or points, residuals as arrows, coverage.


TINT = 0.55  # weight of a grid's points over the image
PALE = 0.6  # of the image behind residuals
MIN_LABEL_SPACING_PX = 30.0  # between corners in the figure, for a number at each
ARROW_SHARE = 0.05  # of the image's width: the 95th percentile of residuals
MAX_ARROW_RATIO = 3.0  # times that; longer arrows are truncated
RESIDUAL = (160, 60, 0)
CUT = (30, 30, 200)
BOARDS = ((235, 206, 170), (222, 165, 100), (170, 95, 30))  # 1, 2, 3 and more
EDGE_OF_RAYS = (0, 120, 255)
# Steps of predicted SDs, their colours, and those above and unknown.
ERROR_STEPS_PX = (0.05, 0.1, 0.2, 0.5, 1.0)
ERROR_COLOURS = (
    (247, 235, 222), (225, 202, 158), (214, 174, 107), (189, 130, 49), (156, 81, 8),
    (60, 60, 190), (200, 200, 200),
)  # fmt: skip
# Of boards, in turn; distinguishable without red or green.
COLOURS = (
    (178, 114, 0), (0, 94, 213), (115, 158, 0), (167, 121, 204), (0, 159, 230),
    (233, 180, 86), (60, 60, 60),
)  # fmt: skip


class ArrowScale(NamedTuple):
    """magnified: arrow length over residual; cut_px: longest residual drawn."""

    magnified: float
    cut_px: float

    @classmethod
    def of(cls, residuals, width):
        """The scale for all residuals (N, 2), some NaN, of images of a width."""
        lengths = np.linalg.norm(residuals, axis=1)
        lengths = lengths[np.isfinite(lengths)]
        long = max(np.percentile(lengths, 95), 1e-6) if len(lengths) else 1.0
        return cls(ARROW_SHARE * width / long, MAX_ARROW_RATIO * long)

    def arrow(self, residual):
        """(vector in px of the image, whether it is truncated)"""
        length = np.linalg.norm(residual)
        shown = residual * min(1.0, self.cut_px / max(length, 1e-12))
        return self.magnified * shown, length > self.cut_px

    def legend(self, canvas):
        """Legend entries: an arrow of a round length, and truncated arrows."""
        long = self.cut_px / MAX_ARROW_RATIO
        power = 10.0 ** np.floor(np.log10(long))
        key = max(step * power for step in (1, 2, 5) if step * power <= long * 1.0001)
        pixels = key * self.magnified * canvas.scale
        return [
            (pixels, f"{key:g} px, magnified {self.magnified:.3g} times"),
            (CUT, f"longer than {self.cut_px:.3g} px, truncated"),
        ]


def corner_figure(image, view, predicted):
    """Corners of a BoardView in their order on the image (height, width) uint8.

    One line per row, from the first corner, 0; all numbers where the spacing allows,
    else those of the ends of a row. A missing corner is marked at `predicted` (N, 2),
    NaN where unknown.
    """
    canvas = Canvas(image.shape[1], image.shape[0], image)
    lattice = view.pixels.reshape(view.rows, view.columns, 2)
    gaps = np.linalg.norm(np.diff(lattice, axis=1), axis=2) * canvas.scale
    numbered = np.isfinite(gaps).any() and np.nanmedian(gaps) > MIN_LABEL_SPACING_PX
    for number, row in enumerate(lattice):
        colour = COLOURS[number % len(COLOURS)]
        canvas.line(row, PAPER, 3)
        canvas.line(row, colour, 1)
        for column, point in enumerate(row):
            if not np.isfinite(point[0]):
                continue
            canvas.ring(point, PAPER, 4, 3)
            canvas.ring(point, colour, 4, 1)
            if numbered or column in (0, view.columns - 1):
                canvas.text(point, str(number * view.columns + column))
    if np.isfinite(view.pixels[0, 0]):
        canvas.ring(view.pixels[0], INK, 8, 2)
    missing = np.flatnonzero(np.isnan(view.pixels[:, 0]))
    for k in missing:
        if np.isfinite(predicted[k, 0]):
            canvas.cross(predicted[k], MISSING, 6, 2)
            canvas.text(predicted[k], f"{k} missing", MISSING)
    legend = [(INK, "first corner, 0")]
    if len(missing):
        legend.append((MISSING, "missing (predicted position)"))
    return canvas.with_legend(legend)


def grid_figure(image, view):
    """The points of a DenseView in colours over the image (height, width) uint8.

    Red increases along x and green along y of the grid, from the smallest value to the
    largest. Dots are the pixels to which models and poses are fitted.
    """
    location = view.location
    seen = np.isfinite(location[..., 0])
    low, high = (f(location[seen], axis=0) for f in (np.min, np.max))
    share = (location - low) / np.maximum(high - low, 1e-9)
    colour = np.zeros((*seen.shape, 3), np.uint8)
    colour[..., 2], colour[..., 1] = np.moveaxis(np.nan_to_num(255 * share), 2, 0)
    canvas = Canvas(image.shape[1], image.shape[0], image)
    size = canvas.image.shape[1::-1]
    tint = cv2.resize(colour, size, interpolation=cv2.INTER_AREA)
    weight = cv2.resize(seen.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    weight = TINT * weight[..., None]
    blended = np.rint((1 - weight) * canvas.image + weight * tint)
    canvas.image = blended.astype(np.uint8)
    for point in view.pixels[np.isfinite(view.pixels[:, 0])]:
        canvas.ring(point, PAPER, 1, -1)
    return canvas.with_legend(
        [
            ((60, 150, 60), f"{view.area()} pixels with a point"),
            (PAPER, "fitted and scored"),
        ]
    )


def residual_figure(image, pixels, residuals, scale):
    """Residuals (N, 2), found less projected, at pixels (N, 2) of the image."""
    canvas = Canvas(image.shape[1], image.shape[0], image, PALE)
    _arrows(canvas, pixels, residuals, scale, RESIDUAL)
    return canvas.with_legend([*scale.legend(canvas), (QUIET, "not scored")])


def pooled_figure(width, height, boards, scale):
    """Residuals of all boards in one image: [(pixels, residuals)], a colour each."""
    canvas = Canvas(width, height)
    for number, (pixels, residuals) in enumerate(boards):
        colour = COLOURS[number % len(COLOURS)]
        _arrows(canvas, pixels, residuals, scale, colour)
    return canvas.with_legend([*scale.legend(canvas), (QUIET, "not scored")])


def disagreement_figure(width, height, pixels, division):
    """Difference between the rays of the halves of a Division, at pixels (N, 2)."""
    canvas = Canvas(width, height)
    lengths = np.linalg.norm(division.field, axis=1)
    # Arrows within the expected difference stay short.
    long = max(np.nanpercentile(lengths, 95), division.allowed_px)
    scale = ArrowScale(ARROW_SHARE * width / long, MAX_ARROW_RATIO * long)
    _arrows(canvas, pixels, division.field, scale, RESIDUAL)
    return canvas.with_legend([*scale.legend(canvas), (QUIET, "not covered by both")])


def coverage_figure(views, width, height, mask=None):
    """Number of views that cover each part of the image, and the limit of rays.

    views: BoardViews, whose corners are marked, or DenseViews; mask: (height, width)
    bool, True where a table has a ray; None for a camera with rays everywhere.
    """
    canvas = Canvas(width, height)
    size = canvas.image.shape[1::-1]
    counts = np.minimum(board_counts(views, width, height), len(BOARDS))
    counts = cv2.resize(counts, size, interpolation=cv2.INTER_NEAREST)
    canvas.image = np.array([PAPER, *BOARDS], np.uint8)[counts]
    legend = list(zip(BOARDS, ("1 view", "2 views", "3 and more"), strict=True))
    if mask is not None:
        seen = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
        edges, _ = cv2.findContours(seen, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(canvas.image, edges, -1, EDGE_OF_RAYS, 2)
        legend.append((EDGE_OF_RAYS, "limit of rays"))
    boards = [view for view in views if not view.every_pixel]
    for view in boards:
        for point in view.pixels[np.isfinite(view.pixels[:, 0])]:
            canvas.ring(point, INK, 1, -1)
    return canvas.with_legend([*legend, (INK, "corners")] if boards else legend)


def error_figure(camera):
    """Predicted SD of where in the image the rays of a camera belong, in steps."""
    canvas = Canvas(camera.width, camera.height)
    height, width = canvas.image.shape[:2]
    v, u = (np.mgrid[:height, :width] + 0.5) / canvas.scale - 0.5
    errors = camera.pixel_covariance(np.column_stack([u.ravel(), v.ravel()]))
    sd = np.sqrt(np.trace(errors, axis1=1, axis2=2))
    step = np.searchsorted(ERROR_STEPS_PX, sd)
    step[np.isnan(sd)] = len(ERROR_COLOURS) - 1
    canvas.image = np.array(ERROR_COLOURS, np.uint8)[step].reshape(height, width, 3)
    texts = [f"up to {step:g} px" for step in ERROR_STEPS_PX]
    texts += [f"above {ERROR_STEPS_PX[-1]:g} px", "unknown"]
    return canvas.with_legend(list(zip(ERROR_COLOURS, texts, strict=True)))


def _arrows(canvas, pixels, residuals, scale, colour):
    for point, residual in zip(pixels, residuals, strict=True):
        if np.isfinite(residual[0]):
            vector, cut = scale.arrow(residual)
            canvas.arrow(point, vector, CUT if cut else colour)
        elif np.isfinite(point[0]):
            canvas.cross(point, QUIET, 3)


THUMBNAIL = 240  # width of a pattern on the sheet, px
GAP, LABEL = 12, 22  # px between thumbnails, and below each for its label
# Blue, green, red.
GRID_COLOURS = {
    FILLED: (40, 200, 240),
    DARK: (70, 60, 60),
    SATURATED: (60, 60, 220),
    UNREADABLE: (200, 60, 200),
    ALONE: (0, 120, 255),
    OUTSIDE: (180, 170, 60),
    BORDER: (170, 170, 170),
    BREAK: (90, 200, 90),
}
STRENGTH = 0.6  # of the colours over the image
PALENESS = 0.25
LINES = 16  # intervals of the contour lines on the lit area, along each axis
LINE_COLOURS = (40, 40, 230), (60, 150, 0)
CERTAIN, UNCERTAIN = (120, 40, 20), (60, 230, 250)


def pattern_sheet(patterns, monitor_px):
    """Labelled thumbnails (h, w, 3) uint8, a row for each kind and axis (Fig. 3.8).

    patterns: `raxel.sets.Pattern`; monitor_px: (width, height).
    """
    width, height = monitor_px
    size = THUMBNAIL, max(1, round(THUMBNAIL * height / width))
    rows = {}
    for pattern in patterns:
        image = pattern_image(pattern, monitor_px)
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        row = rows.setdefault((pattern.kind, pattern.axis), [])
        row.append((small, _label(pattern)))
    rows["levels"] = [(np.full_like(small, grey), name) for grey, name in LEVELS]
    step = size[0] + GAP, size[1] + LABEL + GAP
    most = max(map(len, rows.values()))
    sheet = np.full((GAP + len(rows) * step[1], GAP + most * step[0], 3), 200, np.uint8)
    for i, row in enumerate(rows.values()):
        for k, (image, label) in enumerate(row):
            y, x = GAP + i * step[1], GAP + k * step[0]
            sheet[y : y + size[1], x : x + size[0]] = image[..., None]
            place = x, y + size[1] + LABEL - 6
            cv2.putText(sheet, label, place, FONT, 0.45, INK, 1, cv2.LINE_AA)
    return sheet


LEVELS = (255, "white"), (0, "black")


def _label(pattern):
    if pattern.kind == "phase":
        return f"{pattern.axis}: sine, step {pattern.step} of {pattern.of}"
    inverse = ", inverse" if pattern.inverse else ""
    return f"{pattern.axis}: bit {pattern.bit} of {pattern.of}{inverse}"


def decoded_picture(decoded, image, extent):
    """Decoded positions over an image (H, W) uint8, and their uncertainty; (h, w, 3).

    Top: contour lines of x and of y on the monitor, and pixels without a position, by
    reason. Bottom: the standard deviation of the positions. extent: (2,) of the lit
    area in the unit of the positions.
    """
    return np.vstack([_places(decoded, image, extent), _deviations(decoded, image)])


def _places(decoded, image, extent):
    height, width = image.shape
    canvas = Canvas(width, height, image, PALENESS)
    counts = np.bincount(decoded.status.ravel(), minlength=len(REASONS))
    colour, mixed = np.zeros((height, width, 3), np.uint8), np.zeros((height, width))
    entries = []
    for status, mark in GRID_COLOURS.items():
        if counts[status]:
            there = decoded.status == status
            colour[there], mixed[there] = mark, STRENGTH
            entries.append((mark, f"{REASONS[status]}: {_share(counts, status)}"))
    size = canvas.image.shape[1::-1]
    colour = cv2.resize(colour, size, interpolation=cv2.INTER_NEAREST)
    mixed = cv2.resize(mixed, size, interpolation=cv2.INTER_NEAREST)[..., None]
    canvas.image = np.rint((1 - mixed) * canvas.image + mixed * colour).astype(np.uint8)
    lines = []
    for axis, mark in enumerate(LINE_COLOURS):
        place = cv2.resize(
            np.ascontiguousarray(decoded.location[..., axis]), size,
            interpolation=cv2.INTER_NEAREST,
        )  # fmt: skip
        if np.isfinite(place).any():
            canvas.image[level_lines(place, extent[axis] / LINES)] = mark
            step = f"{extent[axis] / LINES:.3g} {decoded.unit}"
            lines.append((mark, f"{'xy'[axis]}, every {step}"))
    decoded_share = ((255, 255, 255), f"decoded: {_share(counts, 0)}")
    return canvas.with_legend([*lines, decoded_share, *entries])


def _share(counts, status):
    share = 100 * counts[status] / counts.sum()
    return f"{share:.1f} %" if share >= 0.05 else f"{counts[status]} px"


def level_lines(place, step):
    """Mask of pixels whose value (h, w) and the next one, right or below, are in
    different intervals of width `step`."""
    with np.errstate(invalid="ignore"):
        part = np.floor(place / step)
    line = np.zeros(place.shape, bool)
    for near, far in (
        (line[:, :-1], (part[:, :-1], part[:, 1:])),
        (line[:-1], (part[:-1], part[1:])),
    ):
        near |= np.abs(far[0] - far[1]) == 1
    return line


def _deviations(decoded, image):
    """The standard deviation, root mean square of the axes, in colours."""
    height, width = image.shape
    canvas = Canvas(width, height)
    sigma = decoded.sigma[..., np.isfinite(decoded.sigma).any(axis=(0, 1))]
    if not sigma.shape[2]:
        return canvas.with_legend([])
    sigma = np.sqrt(np.mean(sigma**2, axis=2))
    low, high = np.nanquantile(sigma, (0.02, 0.98))
    share = (np.log(sigma) - np.log(low)) / max(np.log(high / low), 0.1)
    share = np.nan_to_num(share).clip(0, 1)[..., None]
    colour = np.rint((1 - share) * CERTAIN + share * UNCERTAIN).astype(np.uint8)
    colour[~np.isfinite(sigma)] = 235
    size = canvas.image.shape[1::-1]
    canvas.image = cv2.resize(colour, size, interpolation=cv2.INTER_AREA)
    unit, nowhere = decoded.unit, ((235, 235, 235), "no location")
    legend = [(CERTAIN, f"standard deviation {low:.3g} {unit}"), nowhere]
    if high >= 1.01 * low:
        legend = [
            (CERTAIN, f"standard deviation {low:.3g} {unit} or less"),
            (UNCERTAIN, f"{high:.3g} {unit} or more"),
            nowhere,
        ]
    return canvas.with_legend(legend)
