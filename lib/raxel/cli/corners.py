"""`raxel corners SET --json F`"""

from pathlib import Path

from raxel.cli.boards import detected, detector_name
from raxel.cli.outputs import check_written
from raxel.errors import InputError
from raxel.features.boards import write_boards
from raxel.io.files import check_can_be_written
from raxel.sets import load_set


def corners(options, say):
    """Find the board in every view of the set.

    Raises InputError where there is none in any of them; what is in order of the
    refused boards is written all the same, but in place of no file that is there.
    """
    if options.json:
        check_can_be_written(options.json)
    image_set = load_set(options.set)
    check_written([options.json], [image_set])
    boards, vote = detected(image_set, options, image_set.views, say)
    found = sum(board.detection.found for board in boards)
    kept = options.json and not found and Path(options.json).exists()
    if options.json and not kept:
        detector = detector_name(image_set, options)
        write_boards(options.json, image_set, detector, boards, vote)
    print(f"{image_set.name}: board found in {found} of {len(boards)} images")
    if vote:
        print(f"{image_set.name}: {vote.line()}")
    for board in boards:
        if board.detection.missing:
            count, of = board.detection.missing, len(board.detection.corners)
            print(f"  {board.view.label}: {count} of {of} corners are missing")
    for board in boards:
        if not board.detection.found:
            print(f"  {board.view.label}: {board.detection.reason}")
    if not found:
        raise InputError(
            f"{image_set.description}: views: no image has a board that could be used; "
            "see the reasons above, check target.columns and target.rows (interior "
            "corners, one less than squares), or try another --detector"
            + (f"; {options.json} is kept as it was" if kept else "")
        )
