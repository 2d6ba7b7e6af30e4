"""ChArUco boards: OpenCV's markers identify the corners, this library localises them.

The markers are painted over with the white around them, so that the windows of the
corners contain only squares, as on a plain chessboard.
"""

import numpy as np

from raxel.features.chessboard.grids import Grid, mask_corners, patches_of, refine_grid
from raxel.features.chessboard.saddles import levels_of, noise_sd, sharp_level
from raxel.features.chessboard.verdict import uncertain_corners
from raxel.features.detector import Detection, as_8_bit, rejected

CHARUCO = "charuco"  # as corners files and results name this detector
# A pose has six parameters; fewer corners do not verify a detection.
MIN_N_CORNERS = 6


def find_charuco(image, target):
    """Detect the ChArUco board `target` (`raxel.sets.Charuco`) in an image: a
    Detection.

    image: (height, width), uint8 or uint16. The markers determine the order of the
    corners. A corner is NaN where the markers next to it cannot be decoded, or where
    its predicted SD is above a third of a pixel. A board that a mirror shows reversed
    is detected too: its corners are then those of the board viewed from behind.
    """
    grey = as_8_bit(image)
    markers = _detect_markers(grey, target)
    flipped = _detect_markers(np.ascontiguousarray(grey[:, ::-1]), target)
    mirrored = flipped.count > markers.count
    if mirrored:
        grey, markers = np.ascontiguousarray(grey[:, ::-1]), flipped
    points, sd = _localise(grey, markers, target)
    if mirrored:
        points = points[:, ::-1] * [-1, 1] + [grey.shape[1] - 1, 0]
        sd = sd[:, ::-1]
    found = np.isfinite(sd)
    spread = min(found.any(axis=0).sum(), found.any(axis=1).sum())
    if found.sum() < MIN_N_CORNERS or spread < 2:
        reason = (
            f"{len(markers.markers)} of {target.marker_count} markers of "
            f"{target.dictionary} and {found.sum()} corners detected, "
            f"{MIN_N_CORNERS} in two rows and columns required; check dictionary, "
            "columns, rows and legacy"
        )
        return rejected(target.columns, target.rows, reason)
    return Detection(
        True, points.reshape(-1, 2), target.columns, target.rows, sd=sd.ravel()
    )


class _MarkerDetection:
    """Corners (rows, columns, 2), NaN where unknown, and markers [(4, 2)] in px."""

    def __init__(self, points, markers):
        self.points, self.markers = points, markers
        self.count = np.count_nonzero(np.isfinite(points[..., 0]))


def _detect_markers(grey, target):
    """Detect the markers of a board in an image (height, width) uint8 by OpenCV."""
    import cv2

    squares = target.columns + 1, target.rows + 1
    board = cv2.aruco.CharucoBoard(
        squares, target.pitch_mm, target.marker_mm, _dictionary(target.dictionary)
    )
    board.setLegacyPattern(target.legacy)
    at, numbers, markers, _ = cv2.aruco.CharucoDetector(board).detectBoard(grey)
    points = np.full((target.rows * target.columns, 2), np.nan)
    if numbers is not None:
        points[np.ravel(numbers)] = np.reshape(at, (-1, 2))
    markers = [] if markers is None else [m.reshape(4, 2) for m in markers]
    return _MarkerDetection(points.reshape(target.rows, target.columns, 2), markers)


def _dictionary(name):
    import cv2

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
    import cv2

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


# Markers of a ChArUco board in an image that should show a plain chessboard.


# So many markers of one dictionary are not chance patterns.
MIN_N_MARKERS = 4
DICTIONARIES = ("4X4_50", "5X5_50", "6X6_50", "7X7_50", "ARUCO_ORIGINAL") + (
    "APRILTAG_16h5",
    "APRILTAG_25h9",
    "APRILTAG_36h11",
)
# Boards begin with a dictionary's first markers, and larger dictionaries with those of
# the smaller ones.
N_FIRST_MARKERS = 50
# A larger image is reduced first: a marker is decoded where its cells are 2 px wide.
MAX_PIXELS = 2e6
CHARUCO_REASON = "this looks like a ChArUco board"


def find_markers(image):
    """(count, dictionary) of ArUco markers in an image of another target, or None.

    image: (height, width), uint8 or uint16. The dictionary with most decoded markers,
    if these are too many to be there by chance.
    """
    import cv2

    grey = as_8_bit(image)
    share = np.sqrt(MAX_PIXELS / grey.size)
    if share < 1:
        grey = cv2.resize(grey, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    counts = {}
    for names, dictionary in _dictionaries():
        numbers = cv2.aruco.ArucoDetector(dictionary).detectMarkers(grey)[1]
        for number in np.unique([] if numbers is None else numbers):
            counts[names[number]] = counts.get(names[number], 0) + 1
    best = max(counts, key=counts.get, default=None)
    return (counts[best], best) if counts.get(best, 0) >= MIN_N_MARKERS else None


def with_marker_hint(detection, image):
    """A rejected Detection, with a hint where the image shows a ChArUco board."""
    markers = None if CHARUCO_REASON in detection.reason else find_markers(image)
    if markers is None:
        return detection
    reason = f"{charuco_reason(*markers)}, use target.kind: charuco. As a chessboard: "
    return detection._replace(reason=reason + detection.reason)


def charuco_reason(count, dictionary):
    """Description of an image that contains such markers."""
    return f"{CHARUCO_REASON} ({count} ArUco markers of {dictionary})"


def _dictionaries():
    """[(names (N,), OpenCV's dictionary of N markers)] of the DICTIONARIES.

    The first markers of each, merged where markers have the same number of cells, so
    that an image is searched once for each size.
    """
    import cv2

    of_size = {}
    for name in DICTIONARIES:
        whole = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{name}"))
        names, codes = of_size.setdefault(whole.markerSize, ([], []))
        codes.append(whole.bytesList[:N_FIRST_MARKERS])
        names += [name] * len(codes[-1])
    return [
        (names, cv2.aruco.Dictionary(np.concatenate(codes), size))
        for size, (names, codes) in of_size.items()
    ]
