"""ChArUco boards: OpenCV's markers identify the corners, this library localises them.

The markers are painted over with the white around them, so that the windows of the
corners contain only squares, as on a plain chessboard.
"""

import functools
import json
from collections import Counter
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np

from raxel.features.chessboard.grids import Grid, mask_corners, patches_of, refine_grid
from raxel.features.chessboard.saddles import levels_of, noise_sd, sharp_level
from raxel.features.chessboard.verdict import uncertain_corners
from raxel.features.circles import circle_lattice, resized
from raxel.features.detector import Detection, as_8_bit, rejected

CHARUCO = "charuco"  # as corners files and results name this detector
# A pose has six parameters; fewer corners do not verify a detection.
MIN_N_CORNERS = 6
# So many numbers beyond those of a board are not chance.
MIN_N_BEYOND = 2
# A board is seen as a whole where one of its last numbers is.
MIN_END_FRACTION = 0.8


def find_charuco(image, target):
    """Detect the ChArUco board `target` (`raxel.sets.Charuco`) in an image: a
    Detection.

    image: (height, width), uint8 or uint16. The markers determine the order of the
    corners. A corner is NaN where the markers next to it cannot be decoded, or where
    its predicted SD is above a third of a pixel. A board that a mirror shows reversed
    is detected too: its corners are then those of the board viewed from behind.
    """
    grey = as_8_bit(image)
    points, sd, count = _corners(grey, target)
    if not _sufficient(sd):
        reason = (
            f"{count} of {target.marker_count} markers of {target.dictionary} and "
            f"{np.isfinite(sd).sum()} corners detected, {MIN_N_CORNERS} in two rows "
            "and columns required; check dictionary, columns, rows and legacy"
        )
        detection = rejected(target.columns, target.rows, reason)
        return with_other_target(detection, _explanation(grey, target))
    return Detection(
        True, points.reshape(-1, 2), target.columns, target.rows, sd=sd.ravel()
    )


def _corners(grey, target):
    """Corners (rows, columns, 2), their SD (rows, columns), and number of markers."""
    markers = _detect_markers(grey, target)
    flipped = _detect_markers(np.ascontiguousarray(grey[:, ::-1]), target)
    if flipped.count <= markers.count:
        return *_localise(grey, markers, target), len(markers.markers)
    points, sd = _localise(np.ascontiguousarray(grey[:, ::-1]), flipped, target)
    points = points[:, ::-1] * [-1, 1] + [grey.shape[1] - 1, 0]
    return points, sd[:, ::-1], len(flipped.markers)


def _sufficient(sd):
    """Whether the corners verify a detection; sd: (rows, columns), NaN if missing."""
    found = np.isfinite(sd)
    spread = min(found.any(axis=0).sum(), found.any(axis=1).sum())
    return found.sum() >= MIN_N_CORNERS and spread >= 2


def _explanation(grey, target):
    """Which other target, board or layout a rejected image shows, or ''."""
    markers = find_markers(grey)
    other = other_target(grey, markers)
    if other or markers is None:
        return other
    name, numbers, _ = markers
    if np.sum(numbers >= target.marker_count) >= MIN_N_BEYOND:
        return (
            f"another board: {len(numbers)} markers of {name}, numbers {numbers.min()} "
            f"to {numbers.max()}, but one of {target.columns} x {target.rows} corners "
            f"has 0 to {target.marker_count - 1}; check columns and rows"
        )
    own, shown = (dictionary_of(one).bytesList for one in (target.dictionary, name))
    contained = np.array_equal(own[: len(shown)], shown)
    first = {} if contained else {"dictionary": name}
    # Without its last markers, a board may have fewer rows than that.
    swapped = {"columns": target.rows, "rows": target.columns}
    whole = numbers.max() >= MIN_END_FRACTION * target.marker_count
    changes = [first, first | swapped] if whole else [first]
    changes += [change | {"legacy": not target.legacy} for change in changes]
    for change in changes:
        other = replace(target, **change)
        if other != target and _sufficient(_corners(grey, other)[1]):
            return _change_text(change)
    return "" if contained else _change_text(first)


def _change_text(change):
    """The rejection of a board that differs from the target by these fields."""
    since = "before" if change.get("legacy") else "since"
    texts = {
        "dictionary": f"markers of {change.get('dictionary')}",
        "columns": "columns and rows exchanged",
        "legacy": f"the layout {since} OpenCV 4.6",
    }
    shown = " and ".join(text for name, text in texts.items() if name in change)
    fields = (f"target.{name}: {json.dumps(value)}" for name, value in change.items())
    return f"the image shows {shown}; set {', '.join(fields)}".replace('"', "")


class _MarkerDetection:
    """Corners (rows, columns, 2), NaN where unknown, and markers [(4, 2)] in px."""

    def __init__(self, points, markers):
        self.points, self.markers = points, markers
        self.count = np.count_nonzero(np.isfinite(points[..., 0]))


def _detect_markers(grey, target):
    """Detect the markers of a board in an image (height, width) uint8 by OpenCV."""
    squares = target.columns + 1, target.rows + 1
    board = cv2.aruco.CharucoBoard(
        squares, target.pitch_mm, target.marker_mm, dictionary_of(target.dictionary)
    )
    board.setLegacyPattern(target.legacy)
    at, numbers, markers, _ = cv2.aruco.CharucoDetector(board).detectBoard(grey)
    points = np.full((target.rows * target.columns, 2), np.nan)
    if numbers is not None:
        points[np.ravel(numbers)] = np.reshape(at, (-1, 2))
    markers = [] if markers is None else [m.reshape(4, 2) for m in markers]
    return _MarkerDetection(points.reshape(target.rows, target.columns, 2), markers)


def dictionary_of(name):
    """The dictionary of OpenCV with this name, without DICT_."""
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{name}"))


def _localise(grey, detected, target):
    """Corners (rows, columns, 2) and their SD (rows, columns) px, NaN if uncertain."""
    shape = target.rows, target.columns
    unplaced = np.where(np.isfinite(detected.points[..., 0]), np.inf, np.nan)
    blank = np.full(shape, np.nan)
    grid = Grid(detected.points, unplaced, unplaced.copy(), blank, blank)
    patches, _, _ = patches_of(detected.points)
    if detected.count < MIN_N_CORNERS or not len(patches.p):  # as of a single row
        return np.full_like(detected.points, np.nan), blank
    plain = without_markers(grey, detected.markers, target.pitch_mm / target.marker_mm)
    plain = plain.astype(np.float32)
    noise = noise_sd(grey.astype(np.float32))
    levels = levels_of(plain, noise)[0], sharp_level(plain, noise)
    grid = refine_grid(grid, levels)
    certain = mask_corners(grid, uncertain_corners(grid))
    return certain.points, certain.sd


def without_markers(grey, markers, squares):
    """The image with markers [(4, 2)] px painted over, and half of their white border.

    squares: side of a square over that of a marker. The paint continues the white
    around the painted area as a plane, since light falls off across a square.
    """
    painted = grey.copy()
    for marker in markers:
        middle = marker.mean(axis=0)
        outline = middle + (marker - middle) * (1 + squares) / 2
        low = np.maximum(np.floor(outline.min(axis=0)).astype(int), 0)
        high = np.ceil(outline.max(axis=0)).astype(int) + 1
        region = slice(low[1], high[1]), slice(low[0], high[0])
        local = np.rint(outline - low).astype(np.int32)
        inside = np.zeros(grey[region].shape, np.uint8)
        border = inside.copy()
        cv2.fillConvexPoly(inside, local, 1)
        cv2.polylines(border, [local], True, 1)
        # Blur may darken the border; its brighter half is white.
        border = (border > 0) & (grey[region] >= np.median(grey[region][border > 0]))
        painted[region][inside > 0] = _plane(grey[region], border, inside > 0)
    return painted


def _plane(grey, known, wanted):
    """Grey levels of a plane through pixels `known`, at pixels `wanted` (both bool)."""
    v, u = np.nonzero(known)
    design = np.column_stack([u, v, np.ones(len(u))])
    coefficients = np.linalg.lstsq(design, grey[known].astype(float), rcond=None)[0]
    v, u = np.nonzero(wanted)
    values = np.column_stack([u, v, np.ones(len(u))]) @ coefficients
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


# Other targets: their markers, in any dictionary, and grids of circles.


# Nested dictionaries: each contains the markers of the smaller ones, as its first.
DICTIONARIES = (
    *(f"{n}X{n}_{count}" for n in (4, 5, 6, 7) for count in (50, 100, 250, 1000)),
    *("ARUCO_ORIGINAL", "APRILTAG_16h5", "APRILTAG_25h9", "APRILTAG_36h10"),
    "APRILTAG_36h11",
)
# Cells along the side of a marker's code, and those of its black border. Printed
# AprilTag grids of Kalibr have a border of two.
CODE_CELLS = ((4, 1), (5, 1), (6, 1), (7, 1), (6, 2))
CELL_PX = 4  # of a rectified marker, whose cells are averaged over their inner half
# More markers than this, less three times those expected by chance, are no chance.
MAX_N_CHANCE_MARKERS, CHANCE_WEIGHT = 3, 3
# Size of the searched image: a marker is decoded where its cells are 2 px wide, and
# squares that touch tags in their corners are separated at a few px.
N_PIXELS = 2e6
# Offset of the next marker in sides of a marker: a ChArUco board has it diagonally.
MAX_NEXT_SIDES, MAX_NEXT_SLOPE = 2.0, 0.5
UNSUPPORTED = (
    "{}, which raxel does not read; use a chessboard, a ChArUco board, or an AprilTag "
    "or square circle grid"
)


class Markers(NamedTuple):
    """Markers of an image: the smallest dictionary with all of them, their numbers
    (N,) and outlines (N, 4, 2) px of the resized image."""

    dictionary: str
    numbers: np.ndarray
    outlines: np.ndarray

    @property
    def in_every_cell(self):
        """Whether markers are next to each other along rows, as in no ChArUco board."""
        sides = self.outlines[:, 1:3] - self.outlines[:, :2]
        centres = self.outlines.mean(axis=1)
        offsets = np.linalg.solve(
            sides.swapaxes(1, 2)[:, None], (centres - centres[:, None])[..., None]
        )
        offsets = np.sort(np.abs(offsets[..., 0]), axis=2)
        offsets[np.diag_indices(len(centres))] = np.inf
        nearest = offsets.sum(axis=2).argmin(axis=1)
        short, long = offsets[range(len(centres)), nearest].T
        next_ = (long < MAX_NEXT_SIDES) & (short < MAX_NEXT_SLOPE * long)
        return next_.mean() > 0.5

    @property
    def is_tag_grid(self):
        """Whether they are AprilTags in every cell."""
        return "APRILTAG" in self.dictionary and self.in_every_cell


def find_markers(image):
    """Markers of ArUco or AprilTag in an image of any target, or None.

    image: (height, width), uint8 or uint16. Of the dictionaries, that with most decoded
    markers, if these are too many to be there by chance.
    """
    grey = resized(as_8_bit(image), N_PIXELS)
    black = cv2.aruco.Dictionary(np.zeros((1, 2, 4), np.uint8), 4)  # no marker
    squares, _, others = cv2.aruco.ArucoDetector(black).detectMarkers(grey)[:3]
    outlines = np.array([*squares, *others], np.float32).reshape(-1, 4, 2)
    best, best_score = None, (MAX_N_CHANCE_MARKERS, 0)
    for ring in (outlines, outlines[:, ::-1]):  # the second as a mirror shows them
        codes = [
            (_code(grey, one, *cells), one) for one in ring for cells in CODE_CELLS
        ]
        lengths = Counter(len(code) for code, _ in codes)
        for name in DICTIONARIES:
            known = _codes(name)
            found = {known[code]: one for code, one in codes if code in known}
            n_bytes, n_bits = (
                len(next(iter(known))),
                dictionary_of(name).markerSize ** 2,
            )
            chance = lengths[n_bytes] * len(known) / 2**n_bits
            # Boards have a dictionary's first markers, and some are those of a mirror.
            score = len(found) - CHANCE_WEIGHT * chance, -max(found, default=0)
            if score > best_score:
                parts = map(np.array, (list(found), list(found.values())))
                best, best_score = Markers(name, *parts), score
    return best


@functools.cache
def _codes(name):
    """{code of a marker in bytes, in each of its four rotations: its number}."""
    rows = enumerate(dictionary_of(name).bytesList)
    return {one.tobytes(): k for k, row in rows for one in row.reshape(4, -1)}


def _code(grey, outline, n, border):
    """Bytes of the n x n cells inside an outline (4, 2); b"" without a black border."""
    cells, side = n + 2 * border, CELL_PX * (n + 2 * border)
    square = np.array([[0, 0], [side, 0], [side, side], [0, side]], np.float32) - 0.5
    H = cv2.getPerspectiveTransform(outline, square)
    patch = cv2.warpPerspective(grey, H, (side, side))
    patch = patch.reshape(cells, CELL_PX, cells, CELL_PX)
    levels = patch[:, 1:-1, :, 1:-1].mean(axis=(1, 3))
    white = levels > (levels.min() + levels.max()) / 2
    code = white[border:-border, border:-border]
    if white.sum() > code.sum():
        return b""
    code = cv2.aruco.Dictionary.getByteListFromBits(code.astype(np.uint8))
    return code.reshape(4, -1)[0].tobytes()


def with_marker_hint(detection, image):
    """A rejected Detection, with a hint where the image shows another target."""
    grey = as_8_bit(image)
    markers = find_markers(grey)
    reason = other_target(grey, markers)
    if markers and not reason:
        use = f"{charuco_reason(markers)}, use target.kind: charuco"
        reason = f"{use}. As a chessboard: {detection.reason}"
    return with_other_target(detection, reason)


def with_other_target(detection, reason):
    """A rejected Detection that names the target of the image; unchanged for ''."""
    return detection._replace(reason=reason, other_target=True) if reason else detection


def other_target(grey, markers):
    """The rejection of an image with tags in every cell or a grid of circles, or ''."""
    if markers is None:
        circles = circle_lattice(grey)
        if circles is None:
            return ""
        if circles.hexagonal:
            return UNSUPPORTED.format("this looks like a hexagonal grid of circles")
        count = len(circles.centres)
        return f"this looks like a grid of {count} circles; set target.kind: circles"
    count = f"{len(markers.numbers)} markers of {markers.dictionary}"
    if markers.is_tag_grid:
        length = row_length(markers.numbers, markers.outlines)
        shown = f"this is an AprilTag grid ({count}, {length} in a row)"
        return f"{shown}; set target.kind: aprilgrid"
    if markers.in_every_cell:
        return UNSUPPORTED.format(f"this is an ArUco grid ({count})")
    return ""


def row_length(numbers, outlines):
    """Number of tags in a row of a grid, by numbers (N,) and outlines (N, 4, 2).

    Numbers count along rows from 0. With the right length, an affine map from column
    and row to the image fits best.
    """
    centres = outlines.mean(axis=1)

    def misfit(length):
        design = np.column_stack([*np.divmod(numbers, length), np.ones(len(numbers))])
        fitted = design @ np.linalg.lstsq(design, centres)[0]
        return np.sum((centres - fitted) ** 2)

    return min(range(2, numbers.max() + 2), key=misfit)


def charuco_reason(markers):
    """Description of an image that contains such Markers."""
    count = f"{len(markers.numbers)} ArUco markers of {markers.dictionary}"
    return f"this looks like a ChArUco board ({count})"
