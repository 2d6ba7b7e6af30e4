"""Pictures of active grids: all patterns on one sheet, and what was decoded."""

import numpy as np

from raxel.features.active_grid import REASONS
from raxel.features.active_grid.coding import (
    ALONE,
    BESIDE,
    BREAK,
    DARK,
    FILLED,
    RIM,
    SATURATED,
    UNREADABLE,
)
from raxel.report.canvas import FONT, INK, Canvas
from raxel.sets.patterns import pattern_picture

THUMBNAIL = 240  # width of a pattern on the sheet, px
GAP, LABEL = 12, 22  # px between thumbnails, and below each for its label
# Blue, green, red.
COLOURS = {
    FILLED: (40, 200, 240),
    DARK: (70, 60, 60),
    SATURATED: (60, 60, 220),
    UNREADABLE: (200, 60, 200),
    ALONE: (0, 120, 255),
    BESIDE: (180, 170, 60),
    RIM: (170, 170, 170),
    BREAK: (90, 200, 90),
}
STRENGTH = 0.6  # of the colours over the photograph
PALENESS = 0.25
LINES = 16  # parts of the lit area that lines divide, along each axis
LINE_COLOURS = (40, 40, 230), (60, 150, 0)
SURE, UNSURE = (120, 40, 20), (60, 230, 250)


def pattern_sheet(patterns, monitor_px):
    """Labelled thumbnails (h, w, 3) uint8, a row for each kind and axis (Fig. 3.8).

    patterns: `raxel.sets.Pattern`; monitor_px: (width, height).
    """
    import cv2

    width, height = monitor_px
    size = THUMBNAIL, max(1, round(THUMBNAIL * height / width))
    rows = {}
    for pattern in patterns:
        picture = pattern_picture(pattern, monitor_px)
        small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
        row = rows.setdefault((pattern.kind, pattern.axis), [])
        row.append((small, _label(pattern)))
    levels = [(np.full(size[::-1], grey, np.uint8), n) for grey, n in LEVELS]
    rows = [*rows.values(), levels]
    step = size[0] + GAP, size[1] + LABEL + GAP
    most = max(map(len, rows))
    sheet = np.full((GAP + len(rows) * step[1], GAP + most * step[0], 3), 200, np.uint8)
    for i, row in enumerate(rows):
        for k, (picture, label) in enumerate(row):
            y, x = GAP + i * step[1], GAP + k * step[0]
            sheet[y : y + size[1], x : x + size[0]] = picture[..., None]
            place = x, y + size[1] + LABEL - 6
            cv2.putText(sheet, label, place, FONT, 0.45, INK, 1, cv2.LINE_AA)
    return sheet


LEVELS = (255, "white"), (0, "black")


def _label(pattern):
    if pattern.kind == "phase":
        return f"{pattern.axis}: sine, step {pattern.step} of {pattern.of}"
    inverse = ", inverse" if pattern.inverse else ""
    return f"{pattern.axis}: bit {pattern.bit} of {pattern.of}{inverse}"


def decoded_picture(decoded, photograph, extent):
    """What was decoded, over a photograph (H, W) uint8, and how sure it is; (h, w, 3).

    Above, lines of equal x and of equal y on the monitor, and what has no location
    marked with its reason; below, the standard deviation of the locations. extent: (2,)
    of the lit area in the unit of the locations.
    """
    return np.vstack(
        [_places(decoded, photograph, extent), _deviations(decoded, photograph)]
    )


def _places(decoded, photograph, extent):
    import cv2

    height, width = photograph.shape
    canvas = Canvas(width, height, photograph, PALENESS)
    counts = np.bincount(decoded.status.ravel(), minlength=len(REASONS))
    colour, mixed = np.zeros((height, width, 3), np.uint8), np.zeros((height, width))
    entries = []
    for status, mark in COLOURS.items():
        if counts[status]:
            there = decoded.status == status
            colour[there], mixed[there] = mark, STRENGTH
            entries.append((mark, f"{REASONS[status]}: {_share(counts, status)}"))
    size = canvas.picture.shape[1::-1]
    colour = cv2.resize(colour, size, interpolation=cv2.INTER_NEAREST)
    mixed = cv2.resize(mixed, size, interpolation=cv2.INTER_NEAREST)[..., None]
    canvas.picture = np.rint((1 - mixed) * canvas.picture + mixed * colour).astype(
        np.uint8
    )
    lines = []
    for axis, mark in enumerate(LINE_COLOURS):
        place = cv2.resize(
            np.ascontiguousarray(decoded.location[..., axis]), size,
            interpolation=cv2.INTER_NEAREST,
        )  # fmt: skip
        if np.isfinite(place).any():
            canvas.picture[level_lines(place, extent[axis] / LINES)] = mark
            step = f"{extent[axis] / LINES:.3g} {decoded.unit}"
            lines.append((mark, f"{'xy'[axis]}, every {step}"))
    told = [((255, 255, 255), f"decoded: {_share(counts, 0)}")]
    return canvas.with_legend([*lines, *told, *entries])


def _share(counts, status):
    share = 100 * counts[status] / counts.sum()
    return f"{share:.1f} %" if share >= 0.05 else f"{counts[status]} px"


def level_lines(place, step):
    """Where a value (h, w) and the next one, right or below, lie in different parts,
    each `step` wide."""
    with np.errstate(invalid="ignore"):
        part = np.floor(place / step)
    line = np.zeros(place.shape, bool)
    for near, far in (
        (line[:, :-1], (part[:, :-1], part[:, 1:])),
        (line[:-1], (part[:-1], part[1:])),
    ):
        near |= np.abs(far[0] - far[1]) == 1
    return line


def _deviations(decoded, photograph):
    """The standard deviation, root mean square of the axes, in colours."""
    import cv2

    height, width = photograph.shape
    canvas = Canvas(width, height)
    sigma = decoded.sigma[..., np.isfinite(decoded.sigma).any(axis=(0, 1))]
    if not sigma.shape[2]:
        return canvas.with_legend([])
    sigma = np.sqrt(np.mean(sigma**2, axis=2))
    low, high = np.nanquantile(sigma, (0.02, 0.98))
    share = (np.log(sigma) - np.log(low)) / max(np.log(high / low), 0.1)
    share = np.nan_to_num(share).clip(0, 1)[..., None]
    colour = np.rint((1 - share) * SURE + share * UNSURE).astype(np.uint8)
    colour[~np.isfinite(sigma)] = 235
    size = canvas.picture.shape[1::-1]
    canvas.picture = cv2.resize(colour, size, interpolation=cv2.INTER_AREA)
    unit, nowhere = decoded.unit, ((235, 235, 235), "no location")
    if high < 1.01 * low:
        return canvas.with_legend(
            [(SURE, f"standard deviation {low:.3g} {unit}"), nowhere]
        )
    ends = (SURE, f"{low:.3g} {unit} or less"), (UNSURE, f"{high:.3g} {unit} or more")
    (mark, words), last = ends
    return canvas.with_legend([(mark, f"standard deviation {words}"), last, nowhere])
