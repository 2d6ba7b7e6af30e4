"""Pictures of active grids: all patterns on one sheet, and what was decoded."""

import numpy as np

from raxel.features.active_grid import REASONS
from raxel.features.active_grid.layout import DARK, FILLED, RIM, SATURATED
from raxel.report.canvas import Canvas
from raxel.sets.patterns import pattern_picture

THUMBNAIL = 240  # width of a pattern on the sheet, px
GAP = 12
# Blue, green, red.
COLOURS = {
    DARK: (70, 60, 60),
    SATURATED: (60, 60, 220),
    RIM: (160, 160, 160),
    FILLED: (40, 200, 240),
}
OTHER = (200, 60, 200)
STRENGTH = 0.55  # of the colours over the photograph


def pattern_sheet(patterns, monitor_px):
    """Thumbnails (h, w) uint8, a row for each axis and kind (Fig. 3.8).

    patterns: `raxel.sets.Pattern`; monitor_px: (width, height).
    """
    import cv2

    width, height = monitor_px
    size = THUMBNAIL, max(1, round(THUMBNAIL * height / width))
    rows = {}
    for pattern in patterns:
        picture = pattern_picture(pattern, monitor_px)
        small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
        rows.setdefault((pattern.kind, pattern.axis), []).append(small)
    most = max(map(len, rows.values()))
    sheet = np.full(
        (GAP + len(rows) * (size[1] + GAP), GAP + most * (size[0] + GAP)), 128, np.uint8
    )
    for i, row in enumerate(rows.values()):
        for k, picture in enumerate(row):
            y, x = GAP + i * (size[1] + GAP), GAP + k * (size[0] + GAP)
            sheet[y : y + size[1], x : x + size[0]] = picture
    return sheet


def decoded_picture(decoded, photograph, extent):
    """What was decoded, in colours over a photograph (H, W) uint8; (h, w, 3).

    Red grows along x and green along y, a step for every second cell is darker; what
    has no location is marked with its reason. extent: (2,) of the lit area in the unit
    of the locations.
    """
    import cv2

    height, width = photograph.shape
    share = np.nan_to_num(decoded.location / np.asarray(extent, np.float32)).clip(0, 1)
    colour = np.zeros((height, width, 3), np.uint8)
    dark = 0.7 + 0.3 * (decoded.cells.sum(axis=2) % 2)
    colour[..., 2] = 255 * share[..., 0] * dark
    colour[..., 1] = 255 * share[..., 1] * dark
    entries = []
    counts = np.bincount(decoded.status.ravel(), minlength=len(REASONS))
    for status in (k for k in REASONS if k and counts[k]):
        mark = COLOURS.get(status, OTHER)
        if status != FILLED:
            colour[decoded.status == status] = mark
        entries.append((mark, f"{REASONS[status]}: {counts[status]}"))
    canvas = Canvas(width, height, photograph)
    size = canvas.picture.shape[1::-1]
    tint = cv2.resize(colour, size, interpolation=cv2.INTER_AREA)
    cv2.addWeighted(canvas.picture, 1 - STRENGTH, tint, STRENGTH, 0, canvas.picture)
    return canvas.with_legend([((60, 150, 60), f"decoded: {counts[0]}"), *entries])
