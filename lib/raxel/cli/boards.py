"""Boards for calibrating and scoring: from a corners file, or detected now."""

from raxel.errors import InputError
from raxel.features import DEFAULT_DETECTOR
from raxel.features.boards import detect_boards, read_boards


def boards_for(image_set, views, options, say):
    """Boards of these views, as the options --corners and --detector say."""
    if options.corners:
        return read_boards(options.corners, image_set, views)
    return detect_boards(image_set, options.detector or DEFAULT_DETECTOR, views, say)


def left_out(boards):
    """The images without a board, for the result: [{file, reason}]."""
    return [
        {"file": board.view.label, "reason": board.detection.reason}
        for board in boards
        if not board.detection.found
    ]


def check_enough(image_set, boards, needed, purpose):
    """Raise InputError unless boards were found in `needed` views."""
    found = sum(board.detection.found for board in boards)
    if found >= needed:
        return
    missed = left_out(boards)
    example = f" ({missed[0]['file']}: {missed[0]['reason']})" if missed else ""
    raise InputError(
        f"{image_set.description}: views: board found in {found} of {len(boards)} "
        f"images, {purpose} needs {needed}{example}; check target.columns and "
        "target.rows, or try another --detector"
    )
