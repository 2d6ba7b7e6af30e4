"""Boards for calibrating and scoring: from a corners file, or detected now."""

from raxel.errors import InputError
from raxel.features import charuco
from raxel.features.boards import (
    CLICK_DETECTORS,
    DEFAULT_DETECTOR,
    agree_on_size,
    check_chessboard,
    detect_boards,
    marker_warning,
    read_boards,
)
from raxel.sets import Charuco

NEED_SIZE = ("opencv", "celect")


def boards_for(image_set, views, options, say):
    """(Boards of these views, SizeVote or None), as --corners and --detector say."""
    if options.corners:
        return read_boards(options.corners, image_set, views), None
    return detected(image_set, options, views, say)


def detector_name(image_set, options):
    """The detector that --detector, or the set's target, asks for."""
    if isinstance(image_set.target, Charuco):
        return charuco.CHARUCO
    return options.detector or DEFAULT_DETECTOR


def detected(image_set, options, views, say):
    """(Boards of these views, SizeVote or None) by the option --detector.

    Photographs of a board of unknown size vote for it. Raises InputError where the set
    lacks what this detector needs in every view, and where they do not agree.
    """
    detector = detector_name(image_set, options)
    check_chessboard(image_set)
    where = image_set.description
    if isinstance(image_set.target, Charuco) and options.detector:
        raise InputError(
            f"{where}: target.kind: found charuco, whose corners are found by their "
            f"markers and not by --detector {options.detector}; leave --detector out"
        )
    if detector in NEED_SIZE and image_set.target.columns is None:
        raise InputError(
            f"{where}: target.columns: found null, but --detector {detector} needs the "
            f"board's size; give columns and rows, or take --detector "
            f"{DEFAULT_DETECTOR}, which counts"
        )
    clicked = any(view.outer_corners is not None for view in views)
    if detector in CLICK_DETECTORS and not clicked:
        raise InputError(
            f"{where}: views: found no outer_corners in the {len(views)} to be "
            f"searched, but --detector {detector} needs these four clicks in each; add "
            f"them, or take --detector {DEFAULT_DETECTOR}"
        )
    boards = detect_boards(image_set, detector, views, say)
    if beside := marker_warning(image_set, boards):
        say(beside)
    if image_set.target.columns is not None:
        return boards, None
    return agree_on_size(image_set, boards, detector, say)
