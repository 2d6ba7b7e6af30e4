"""All boards of an image set: detected, written as JSON, read back."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.features.april_grid import find_april_grid
from raxel.features.celect.algorithm import find_celect
from raxel.features.charuco import (
    CHARUCO,
    charuco_reason,
    find_charuco,
    find_markers,
    with_marker_hint,
)
from raxel.features.chessboard.board import find_board
from raxel.features.circle_grid import find_circle_grid
from raxel.features.corner_files import corner_data
from raxel.features.detector import Detection, find_opencv, find_opencv_sb, rejected
from raxel.features.lattice import order_of_clicks
from raxel.io.documents import one_line, shown
from raxel.io.files import write_json
from raxel.sets.image_files import read_image
from raxel.sets.model import (
    AprilGrid,
    Charuco,
    Chessboard,
    CircleGrid,
    ImageSet,
    View,
    plain_sd,
    sd_from_plain,
)

DETECTORS = {"raxel": find_board, "opencv": find_opencv, "opencv-sb": find_opencv_sb}
DEFAULT_DETECTOR = "raxel"
CLICK_DETECTORS = {"celect": find_celect}
# Targets with their own detector: its name in corners files and results.
TARGET_DETECTORS = {
    Charuco: (CHARUCO, find_charuco),
    AprilGrid: ("aprilgrid", find_april_grid),
    CircleGrid: ("circles", find_circle_grid),
}
# Larger than any image, and exact as a float.
MAX_COORDINATE_PX = 1e9


class Board(NamedTuple):
    """Hold what was found in one view.

    Attributes
    ----------
    view : View
        The view.
    detection : Detection
        The answer of the detector.
    milliseconds : float or None
        Time of the detection in ms; None where it was not measured.
    """

    view: View
    detection: Detection
    milliseconds: float | None


def check_chessboard(image_set):
    """Raise InputError unless the target of the set is a chessboard."""
    if not isinstance(image_set.target, Chessboard):
        raise InputError(
            f"{image_set.description}: target.kind: found active_grid, but a "
            "board is required; use raxel decode for active grids"
        )


def detect_boards(
    image_set: ImageSet,
    detector: str = DEFAULT_DETECTOR,
    views: Sequence[View] | None = None,
    say: Callable[[str], object] | None = None,
    found: dict[str, Board] | None = None,
) -> list[Board]:
    """Detect the board in each view of an image set.

    All images are read before the first is searched, so that a faulty one is reported
    at once. A ChArUco board, an AprilTag grid and a grid of circles have their own
    detectors, whatever `detector` is.

    Parameters
    ----------
    image_set : ImageSet
        The set, with a chessboard as its target.
    detector : str
        A name in DETECTORS or CLICK_DETECTORS.
    views : Sequence[View], optional
        Some of the views of the set; default all.
    say : Callable, optional
        Called with one line of text per image.
    found : dict[str, Board], optional
        Boards by image. Those in it are not searched again, and each new one is added
        at once, so that an interruption loses none.

    Returns
    -------
    list[Board]
        One Board per view, in order.

    Raises
    ------
    InputError
        `bad-input` for a set without a chessboard, for images as `read_image`, and for
        impossible clicks or contours by hand.
    """
    check_chessboard(image_set)
    views = image_set.views if views is None else views
    found = {} if found is None else found
    missing = [view for view in views if view.label not in found]
    for view in missing:
        read_image(image_set, view)
    for number, view in enumerate(missing, 1 + len(views) - len(missing)):
        board = _detect(image_set, view, _finder(image_set, view, detector))
        found[view.label] = board
        if say:
            say(f"{number}/{len(views)} {_line(board)}")
    return [found[view.label] for view in views]


def marker_warning(image_set, boards):
    """A warning about markers in the squares of a detected chessboard, or ''.

    One image is tested, the first that shows a board.
    """
    found = [board.view for board in boards if board.detection.found]
    if type(image_set.target) in TARGET_DETECTORS or not found:
        return ""
    markers = find_markers(read_image(image_set, found[0]))
    if markers is None:
        return ""
    return (
        f"{found[0].label}: {charuco_reason(markers)} and is used as a "
        "chessboard; with target.kind: charuco the markers would identify the "
        "corners"
    )


def write_boards(path, image_set, detector, boards, vote=None):
    """Write boards as JSON: {images: [{file, found, columns, rows, corners, ...}]}.

    A missing corner is null, and `missing` counts them. `sd` holds the standard
    deviation of each corner in px, null where the detector gives none. `partial` holds
    the ordered part of a rejected board: its corners, and the [row, column] of each;
    null without one. `vote`: a `SizeVote`, written as `size`.
    """
    images = [
        {
            "file": board.view.label,
            "found": board.detection.found,
            "columns": board.detection.columns,
            "rows": board.detection.rows,
            "corners": _corner_lists(board.detection.corners),
            "missing": board.detection.missing,
            "sd": plain_sd(board.detection.sd),
            "milliseconds": board.milliseconds,
            "partial": _partial(board.detection.partial),
            "reason": board.detection.reason,
        }
        for board in boards
    ]
    size = {"size": vote.fields()} if vote else {}
    about = {"set": image_set.name, "detector": detector} | size
    write_json(path, about | {"images": images})


def read_boards(
    path: str | Path, image_set: ImageSet, views: Sequence[View] | None = None
) -> list[Board]:
    """Read the boards of the views of a set from a file of corners.

    A view without an entry counts as not found, with that reason.

    Parameters
    ----------
    path : str or Path
        The JSON file, a .vnl file of mrgingham or mrcal, or the image and object
        points of a cv2.FileStorage (.xml, .yml, .yaml) in the order of the views.
    image_set : ImageSet
        The set, with a chessboard as its target.
    views : Sequence[View], optional
        Some of the views of the set; default all.

    Returns
    -------
    list[Board]
        One Board per view, in the order of the views.

    Raises
    ------
    InputError
        `bad-input` for entries that are no boards of this set. The message states file,
        field, what was found, and what to do.
    """
    check_chessboard(image_set)
    data = corner_data(path, image_set)
    entries = data.get("images") if isinstance(data, dict) else None
    if not isinstance(entries, list):
        raise InputError(
            f"{path}: images: not a list; give a file written by raxel corners"
        )
    name = data.get("set")
    if name is not None and name != image_set.name:
        raise InputError(
            f"{path}: set: found {shown(name)}, expected {image_set.name!r}; give "
            "the corners of this set"
        )
    found = {}
    labels = {view.label for view in image_set.views}
    for index, entry in enumerate(entries):
        field = f"images[{index}]"
        name = entry.get("file") if isinstance(entry, dict) else None
        if not isinstance(name, str) or name not in labels or name in found:
            raise InputError(
                f"{path}: {field}.file: found {shown(name)}; name each image of "
                f"{image_set.description} once"
            )
        found[name] = _read_detection(f"{path}: {field}", entry, image_set)
    nothing = rejected(None, None, f"{path} has no entry for it")
    views = image_set.views if views is None else views
    return [Board(view, found.get(view.label, nothing), None) for view in views]


def _corner_lists(corners):
    """[[u, v], ...], null for a missing corner."""
    points = np.round(corners, 6).tolist()
    return [None if np.isnan(point).any() else point for point in points]


def _partial(partial):
    if partial is None:
        return None
    return {
        "corners": _corner_lists(partial.corners),
        "indices": partial.indices.tolist(),
    }


def _finder(image_set, view, detector):
    """The detector as a callable (image, columns, rows), with the view's clicks."""
    target = image_set.target
    if type(target) in TARGET_DETECTORS:
        find = TARGET_DETECTORS[type(target)][1]
        return lambda image, columns, rows: find(image, target)
    if detector in DETECTORS:
        return DETECTORS[detector]

    def find(image, columns, rows):
        try:
            return CLICK_DETECTORS[detector](
                image, columns, rows, view.outer_corners, view.contours
            )
        except InputError as fault:
            where = f"views[{image_set.views.index(view)}]"
            raise InputError(f"{image_set.description}: {where}.{fault}") from fault

    return find


def _detect(image_set, view, detector):
    target = image_set.target
    image = read_image(image_set, view)
    start = time.perf_counter()
    try:
        detection = detector(image, target.columns, target.rows)
    except Exception as fault:
        if not _is_out_of_memory(fault):
            raise
        raise InputError(
            f"{image_set.folder / view.image}: not enough memory to search "
            f"{image_set.width} x {image_set.height} px; use another detector or "
            "smaller images"
        ) from fault
    milliseconds = round((time.perf_counter() - start) * 1000, 1)
    hinted = detector is find_board or type(target) in TARGET_DETECTORS
    if not detection.found and not hinted:
        detection = with_marker_hint(detection, image)
    if detection.found and view.outer_corners is not None:
        detection = _in_click_order(detection, np.array(view.outer_corners))
    return Board(view, detection, milliseconds)


def _is_out_of_memory(fault):
    import cv2

    if isinstance(fault, cv2.error):
        return fault.code == cv2.Error.StsNoMem
    return isinstance(fault, MemoryError)


def _in_click_order(detection, clicks):
    """The detection in the order of the clicks (4, 2), rejected where no order fits.

    An order fits where each click is nearest to its own of the outermost corners.
    """
    columns, rows = detection.columns, detection.rows
    order = order_of_clicks(detection.corners, columns, rows, clicks)
    corners = detection.corners[order]
    outermost = corners[[0, columns - 1, columns * rows - 1, columns * (rows - 1)]]
    known = np.flatnonzero(np.isfinite(outermost[:, 0]))
    distance = np.linalg.norm(clicks[known, None] - outermost[known], axis=2)
    if not np.array_equal(distance.argmin(axis=1), range(len(known))):
        reason = (
            f"outer_corners: the clicks do not fit the {columns} x {rows} corners "
            "found; click the first corner, the other end of its row of "
            f"{columns}, then clockwise"
        )
        return rejected(columns, rows, reason)
    sd = None if detection.sd is None else detection.sd[order]
    return detection._replace(corners=corners, sd=sd)


def _line(board):
    detection = board.detection
    what = detection.reason
    if detection.found:
        what = f"{detection.columns} x {detection.rows} corners"
        if detection.missing:
            what += f", {detection.missing} of them missing"
    return f"{board.view.label}: {what} ({board.milliseconds:.0f} ms)"


def _read_detection(where, entry, image_set):
    if not isinstance(entry.get("found"), bool):
        raise InputError(f"{where}.found: not a truth value; give true or false")
    if not entry["found"]:
        return rejected(None, None, one_line(entry.get("reason", "")) or "not found")
    target = image_set.target
    size = [
        _count(f"{where}.{key}", entry.get(key), expected)
        for key, expected in (("columns", target.columns), ("rows", target.rows))
    ]
    corners = _corners(f"{where}.corners", entry.get("corners"), size[0] * size[1])
    missing = int(np.count_nonzero(np.isnan(corners[:, 0])))
    stated = entry.get("missing", missing)
    if stated != missing or isinstance(stated, bool):
        raise InputError(
            f"{where}.missing: found {shown(stated)}, but {missing} corners are "
            "null; give their number, or omit it"
        )
    beyond = (corners < -0.5) | (
        corners > [image_set.width - 0.5, image_set.height - 0.5]
    )
    if beyond.any():
        u, v = corners[beyond.any(axis=1)][0]
        raise InputError(
            f"{where}.corners: found ({u:g}, {v:g}), outside the image of "
            f"{image_set.width} x {image_set.height} px; give corners in pixels of it"
        )
    if len(np.unique(corners[~np.isnan(corners[:, 0])], axis=0)) == 1:
        u, v = np.nanmin(corners, axis=0)
        raise InputError(
            f"{where}.corners: found all of them at ({u:g}, {v:g}); give each "
            "corner its own position, or found: false"
        )
    sd = sd_from_plain(f"{where}.sd", entry.get("sd"), len(corners))
    return Detection(True, corners, *size, sd=sd)


def _count(where, value, expected):
    if type(value) is not int or value < 3 or (expected and value != expected):
        wanted = f"{expected}, as the set's target" if expected else "3 or more"
        raise InputError(f"{where}: found {shown(value)}; give {wanted}")
    return value


def _corners(where, points, count):
    number = len(points) if isinstance(points, list) else 0
    if number != count:
        raise InputError(
            f"{where}: found {number} corners; give columns x rows = {count}"
        )
    known = np.array([point is not None for point in points])
    if not known.any():
        raise InputError(
            f"{where}: every corner is null; give those that were detected, or "
            "found: false"
        )
    for index, point in enumerate(points):
        if point is not None and not _is_point(point):
            raise InputError(
                f"{where}[{index}]: found {shown(point)}, not a point; give [x, "
                "y] in finite numbers, or null if missing"
            )
    known_points = np.array(
        [point for point in points if point is not None], dtype=float
    )
    corners = np.full((count, 2), np.nan)
    corners[known] = known_points
    return corners


def _is_point(point):
    """Whether a value is two numbers that may be pixels; not a bool or a text."""
    return (
        isinstance(point, list)
        and len(point) == 2
        and all(type(x) in (int, float) and abs(x) < MAX_COORDINATE_PX for x in point)
    )


# The size of a board that is not given, by a majority vote of the images of a set. An
# image that shows complete boards votes for their sizes. Occluders of the board's end,
# and patterns that continue it, vary between images; the board does not. Images without
# a board of the elected size are searched again for that size.


# Of all votes: with two thirds the size is found twice as often as all others together.
MIN_VOTE_FRACTION = 2 / 3
# Number of images listed in a line.
MAX_NAMED_IMAGES = 3


class SizeVote(NamedTuple):
    """The vote on the size of a board.

    votes: {(columns, rows): labels of images with such a board}, the elected size
    first; image_count: number of images; retried: labels of images searched again for
    the elected size; found: those of them in which it was then found.
    """

    votes: dict
    image_count: int
    retried: list
    found: list

    @property
    def size(self):
        """The elected size (columns, rows)."""
        return next(iter(self.votes))

    def line(self):
        """The vote as one line of text."""
        first, *others = self.votes.items()
        count = len(first[1])
        text = (
            f"size not given: {_size(first[0])} corners in {count} of "
            f"{self.image_count} images"
        )
        for size, labels in others:
            text += f", {_size(size)} in {_named_images(labels)}"
        if self.retried:
            text += (
                f"; {len(self.retried)} searched again, {len(self.found)} of them found"
            )
        return text

    def fields(self):
        """The vote as result fields."""
        votes = [
            {"columns": size[0], "rows": size[1], "files": labels}
            for size, labels in self.votes.items()
        ]
        retries = {"looked_at_again": self.retried, "found_then": self.found}
        return {"photographs": self.image_count, "votes": votes} | retries


def votes_of(boards):
    """{(columns, rows): [labels]} of Boards, the most frequent size first."""
    votes = {}
    for board in boards:
        detection = board.detection
        sizes = (
            {(detection.columns, detection.rows)}
            if detection.found
            else set(detection.complete)
        )
        for size in sorted(sizes):
            votes.setdefault(size, []).append(board.view.label)
    return dict(sorted(votes.items(), key=lambda vote: -len(vote[1])))


def agree_on_size(image_set, boards, detector, say=None):
    """Boards of one size, and the SizeVote, of a set whose target has no size.

    Images without a board of the elected size are searched again. (boards, None) where
    no image shows a complete board. Raises InputError where no size has two thirds of
    the votes.
    """
    votes = votes_of(boards)
    if not votes:
        return boards, None
    size, labels = next(iter(votes.items()))
    if len(labels) < MIN_VOTE_FRACTION * sum(map(len, votes.values())):
        size_texts = "; ".join(
            f"{_size(s)} in {_named_images(names)}" for s, names in votes.items()
        )
        raise InputError(
            f"{image_set.description}: target.columns: found null, but the images "
            f"show boards of different sizes ({size_texts}); give columns and "
            "rows, or split the set"
        )
    target = replace(image_set.target, columns=size[0], rows=size[1])
    others = [k for k, board in enumerate(boards) if not _has_size(board, size)]
    views = [boards[k].view for k in others]
    if views and say:
        say(f"{len(views)} images are searched again for {_size(size)} corners")
    sized = replace(image_set, target=target)
    repeated = detect_boards(sized, detector, views, say) if views else []
    boards = list(boards)
    for k, board in zip(others, repeated, strict=True):
        boards[k] = _explain_rejection(board, boards[k].detection, size, len(labels))
    found = [board.view.label for board in repeated if board.detection.found]
    names = [view.label for view in views]
    return boards, SizeVote(votes, len(boards), names, found)


def _has_size(board, size):
    detection = board.detection
    return detection.found and (detection.columns, detection.rows) == size


def _explain_rejection(board, before, size, count):
    """The Board of a second search; if rejected, with the size found before."""
    if board.detection.found or not before.found:
        return board
    reason = (
        f"it shows {_size((before.columns, before.rows))} corners, but {count} "
        f"other images show {_size(size)}: {board.detection.reason}"
    )
    return board._replace(detection=board.detection._replace(reason=reason))


def _size(size):
    return f"{size[0]} x {size[1]}"


def _named_images(labels):
    more = len(labels) - MAX_NAMED_IMAGES
    names = ", ".join(labels[:MAX_NAMED_IMAGES]) + (
        f" and {more} more" if more > 0 else ""
    )
    return f"{len(labels)} ({names})"
