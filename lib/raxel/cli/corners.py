"""`raxel corners SET --json F`"""

from raxel.cli.boards import left_out
from raxel.cli.outputs import check_not_read
from raxel.features import DEFAULT_DETECTOR
from raxel.features.boards import detect_boards, write_boards
from raxel.files import check_can_be_written
from raxel.sets import load_set


def corners(options, say):
    """Find the board in every view of the set."""
    if options.json:
        check_can_be_written(options.json)
    image_set = load_set(options.set)
    check_not_read([options.json], [image_set])
    detector = options.detector or DEFAULT_DETECTOR
    boards = detect_boards(image_set, detector, say=say)
    if options.json:
        write_boards(options.json, image_set, detector, boards)
    found = sum(board.detection.found for board in boards)
    print(f"{image_set.name}: board found in {found} of {len(boards)} images")
    for missed in left_out(boards):
        print(f"  {missed['file']}: {missed['reason']}")
