"""ChArUco boards: which corner is which is read from markers, OpenCV's; where each is
lies with this library, as on a plain chessboard.

The markers are painted over with the white around them, so that nothing but squares
is left in the windows in which corners are placed.
"""

import numpy as np

from raxel.features.chessboard.grids import Grid, holed, patches_of, settled
from raxel.features.chessboard.saddles import levels_of, noise_sd, sharp_level
from raxel.features.chessboard.verdict import unsure
from raxel.features.detector import Detection, as_8_bit, refused

CHARUCO = "charuco"  # as corners files and results name this detector
# A pose has six numbers; fewer corners judge nothing.
FEWEST_CORNERS = 6


def find_charuco(image, target):
    """The ChArUco board `target` (`raxel.sets.Charuco`) in an image: a Detection.

    image: (height, width), uint8 or uint16. The corners are in the board's own order,
    which the markers tell; NaN where the markers beside one cannot be read, or where
    it cannot be placed to a third of a pixel (SD). A board that a mirror shows
    reversed is read too: its corners are then those of the board seen from behind.
    """
    grey = as_8_bit(image)
    seen = _seen(grey, target)
    reversed_ = _seen(np.ascontiguousarray(grey[:, ::-1]), target)
    turned = reversed_.count > seen.count
    if turned:
        grey, seen = np.ascontiguousarray(grey[:, ::-1]), reversed_
    points, sd = _placed(grey, seen, target)
    if turned:
        points = points[:, ::-1] * [-1, 1] + [grey.shape[1] - 1, 0]
        sd = sd[:, ::-1]
    found = np.isfinite(sd)
    spread = min(found.any(axis=0).sum(), found.any(axis=1).sum())
    if found.sum() < FEWEST_CORNERS or spread < 2:
        reason = (
            f"{len(seen.markers)} of {target.marker_count} markers of "
            f"{target.dictionary} are read, and {found.sum()} corners between them are "
            f"placed; {FEWEST_CORNERS} in two rows and columns are needed: check "
            "dictionary, columns, rows and legacy"
        )
        return refused(target.columns, target.rows, reason)
    return Detection(
        True, points.reshape(-1, 2), target.columns, target.rows, sd=sd.ravel()
    )


class _Seen:
    """Corners (rows, columns, 2), NaN where unknown, and markers [(4, 2)] in px."""

    def __init__(self, points, markers):
        self.points, self.markers = points, markers
        self.count = np.count_nonzero(np.isfinite(points[..., 0]))


def _seen(grey, target):
    """What OpenCV reads in an image (height, width) uint8: `_Seen`."""
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
    return _Seen(points.reshape(target.rows, target.columns, 2), markers)


def _dictionary(name):
    import cv2

    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{name}"))


def _placed(grey, seen, target):
    """(corners (rows, columns, 2), their SD (rows, columns) px), NaN where unsure."""
    shape = target.rows, target.columns
    unplaced = np.where(np.isfinite(seen.points[..., 0]), np.inf, np.nan)
    blank = np.full(shape, np.nan)
    grid = Grid(seen.points, unplaced, unplaced.copy(), blank, blank)
    beside, _, _ = patches_of(seen.points)
    if seen.count < FEWEST_CORNERS or not len(beside.p):  # as of a single row
        return np.full_like(seen.points, np.nan), blank
    plain = without_markers(grey, seen.markers, target.pitch_mm / target.marker_mm)
    plain = plain.astype(np.float32)
    noise = noise_sd(grey.astype(np.float32))
    levels = levels_of(plain, noise)[0], sharp_level(plain, noise)
    grid = settled(grid, levels)
    sure = holed(grid, unsure(grid))
    return sure.points, sure.sd


def without_markers(grey, markers, squares):
    """The image with markers [(4, 2)] px painted over, half of their white rim as well.

    squares: side of a square over that of a marker. The paint continues the white on
    the border of what is painted, as a plane: light falls off across a square.
    """
    import cv2

    painted = grey.copy()
    for marker in markers:
        middle = marker.mean(axis=0)
        rim = middle + (marker - middle) * (1 + squares) / 2
        low = np.maximum(np.floor(rim.min(axis=0)).astype(int), 0)
        high = np.ceil(rim.max(axis=0)).astype(int) + 1
        room = slice(low[1], high[1]), slice(low[0], high[0])
        local = np.rint(rim - low).astype(np.int32)
        inside = np.zeros(grey[room].shape, np.uint8)
        border = inside.copy()
        cv2.fillConvexPoly(inside, local, 1)
        cv2.polylines(border, [local], True, 1)
        # Blur may carry dark onto the border; its brighter half is white.
        border = (border > 0) & (grey[room] >= np.median(grey[room][border > 0]))
        painted[room][inside > 0] = _plane(grey[room], border, inside > 0)
    return painted


def _plane(grey, known, wanted):
    """Grey values of a plane through pixels `known`, at pixels `wanted` (both bool)."""
    v, u = np.nonzero(known)
    design = np.column_stack([u, v, np.ones(len(u))])
    coefficients = np.linalg.lstsq(design, grey[known].astype(float), rcond=None)[0]
    v, u = np.nonzero(wanted)
    values = np.column_stack([u, v, np.ones(len(u))]) @ coefficients
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


# Markers of a ChArUco board in a photograph of which a plain chessboard was asked.


# So many markers of one dictionary in an image are no chance patterns.
TELLING_MARKERS = 4
FAMILIES = ("4X4_50", "5X5_50", "6X6_50", "7X7_50", "ARUCO_ORIGINAL") + (
    "APRILTAG_16h5",
    "APRILTAG_25h9",
    "APRILTAG_36h11",
)
# Boards begin with a dictionary's first markers, and larger ones with the smaller's.
FIRST = 50
# A larger image is made smaller first: a marker is read where its cells are 2 px wide.
MOST_PIXELS = 2e6
LOOKS_LIKE = "this looks like a ChArUco board"


def markers_seen(image):
    """(count, dictionary) of ArUco markers in an image of another target, or None.

    image: (height, width), uint8 or uint16. The dictionary of whose first markers most
    are read, if these are too many to be there by chance.
    """
    import cv2

    grey = as_8_bit(image)
    share = np.sqrt(MOST_PIXELS / grey.size)
    if share < 1:
        grey = cv2.resize(grey, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    counts = {}
    for names, dictionary in _dictionaries():
        numbers = cv2.aruco.ArucoDetector(dictionary).detectMarkers(grey)[1]
        for number in np.unique([] if numbers is None else numbers):
            counts[names[number]] = counts.get(names[number], 0) + 1
    best = max(counts, key=counts.get, default=None)
    return (counts[best], best) if counts.get(best, 0) >= TELLING_MARKERS else None


def with_markers_named(detection, image):
    """A refusal, with a word on markers where the image shows a ChArUco board."""
    seen = None if LOOKS_LIKE in detection.reason else markers_seen(image)
    if seen is None:
        return detection
    reason = f"{looks_like(*seen)}: give target.kind: charuco; as a chessboard: "
    return detection._replace(reason=reason + detection.reason)


def looks_like(count, dictionary):
    """What an image is that shows such markers, in words."""
    return f"{LOOKS_LIKE} ({count} ArUco markers of {dictionary} are in the image)"


def _dictionaries():
    """[(names (N,), OpenCV's dictionary of N markers)]: the FIRST of all FAMILIES,
    together where their markers have as many cells, so that an image is searched once
    for each size."""
    import cv2

    of_size = {}
    for name in FAMILIES:
        whole = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{name}"))
        names, codes = of_size.setdefault(whole.markerSize, ([], []))
        codes.append(whole.bytesList[:FIRST])
        names += [name] * len(codes[-1])
    return [
        (names, cv2.aruco.Dictionary(np.concatenate(codes), size))
        for size, (names, codes) in of_size.items()
    ]
