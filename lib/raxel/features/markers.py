"""Markers of a ChArUco board in a photograph of which a plain chessboard was asked."""

import numpy as np

from raxel.features.detector import as_8_bit

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
