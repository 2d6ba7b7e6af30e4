"""Chessboards found without clicks, whatever the lens: corners, order and size.

Saddles of the grey values at several scales (`saddles`), those with four fields around
them (`ring`), edges followed from one to the next (`trace`), lattices grown from the
links (`growth`), checked, filled and run on with the lattice's own shape (`grids`,
`patches`, `corners`), and judged (`verdict`, `rim`). No model of the lens enters.
"""

import numpy as np

from raxel.errors import InputError
from raxel.features.detector import Detection, Partial, as_8_bit, refused
from raxel.features.find.search import seen_in
from raxel.features.find.verdict import continues, fault_of, open_side
from raxel.features.lattice import in_standard_order, symmetries


def find_board(image, columns=None, rows=None):
    """The chessboard of an image (height, width), uint8 or uint16: a Detection.

    `columns`, `rows`: interior corners, or both None where unknown. Returned is a board
    that is complete, of that size, and certain to a quarter of a pixel (SD); else the
    reason, and as `partial` the corners in order. Raises InputError for one of the two.
    """
    if (columns is None) != (rows is None):
        found, missing = ("columns", "rows") if rows is None else ("rows", "columns")
        raise InputError(f"{missing}: not given, but {found} is; give both or neither")
    if min(image.shape) < 16:
        return refused(columns, rows, "the image is too small to show a board")
    seen = seen_in(as_8_bit(image))
    known = columns is not None and rows is not None
    if not seen.grids:
        of = f"of {columns} x {rows} interior corners" if known else "of any size"
        count = len(seen.nodes.points)
        reason = f"no board {of}: {count} corners are seen and no lattice of them"
        return refused(columns, rows, reason)
    if not known:
        return _unknown_size(seen, image)
    return _known_size(seen, image, columns, rows)


def find_boards(image):
    """Detections of all complete boards in an image; for more than one board."""
    if min(image.shape) < 16:
        return []
    seen = seen_in(as_8_bit(image))
    return [_detection(g, image) for g in seen.grids if not fault_of(g, image)]


def _known_size(seen, image, columns, rows):
    grids = seen.grids
    wanted = {(columns, rows), (rows, columns)}
    faults = [fault_of(grid, image) for grid in grids]
    boards = [
        grid
        for grid, fault in zip(grids, faults, strict=True)
        if not fault and grid.known.shape in wanted
    ]
    if len(boards) == 1:
        return _detection(boards[0], image, columns, rows)
    if boards:
        reason = f"{len(boards)} boards of {columns} x {rows} corners are seen"
        return _refused(grids[0], image, columns, rows, reason)
    fault = faults[0] or _size(grids[0])
    reason = f"no board of {columns} x {rows} interior corners: {fault}"
    return _refused(grids[0], image, columns, rows, reason)


def _unknown_size(seen, image):
    grids = seen.grids
    faults = [fault_of(grid, image) for grid in grids]
    boards = [grid for grid, fault in zip(grids, faults, strict=True) if not fault]
    if len(boards) > 1:
        sizes = ", ".join(map(_size, boards))
        reason = f"{len(boards)} boards are seen ({sizes}); give columns and rows"
        return _refused(boards[0], image, None, None, reason)
    if not boards:
        return _refused(grids[0], image, None, None, faults[0])
    board = boards[0]
    side = open_side(board, image)
    if side:
        reason = (
            f"{_size(board)}, but the board may go on beyond its {side}, outside the "
            "image; give columns and rows"
        )
        return _refused(board, image, None, None, reason)
    if continues(board, [grid for grid in grids if grid is not board]):
        reason = (
            f"{_size(board)}, but more of a lattice stands beside it; give columns "
            "and rows"
        )
        return _refused(board, image, None, None, reason)
    return _detection(board, image)


def _size(grid):
    rows, columns = sorted(grid.known.shape)
    return f"{columns} x {rows} corners found"


def _detection(grid, image, columns=None, rows=None):
    """The Detection of a complete grid; its longer side is columns unless given."""
    if columns is None:
        columns, rows = max(grid.known.shape), min(grid.known.shape)
    high, wide = grid.known.shape
    index = np.arange(high * wide).reshape(-1, 1)
    both = np.column_stack([grid.points.reshape(-1, 2), index]).reshape(high, wide, 3)
    if (wide, high) != (columns, rows):
        both = both.transpose(1, 0, 2)
    both = both.reshape(-1, 3)
    corners = in_standard_order(both[:, :2], columns, rows, image)
    sd = grid.sd.ravel()[_order(both, corners, columns, rows)]
    return Detection(True, corners, columns, rows, sd=sd)


def _order(both, corners, columns, rows):
    """Index into the grid's cells of each corner, in the order of `corners`."""
    numbers = np.column_stack([both[:, 2], both[:, 2]])
    for (points, size), (index, _) in zip(
        symmetries(both[:, :2], columns, rows),
        symmetries(numbers, columns, rows),
        strict=True,
    ):
        if size == (columns, rows) and np.array_equal(points, corners):
            return index[:, 0].astype(int)
    raise AssertionError("the standard order is a symmetry of the lattice")


def _refused(grid, image, columns, rows, reason):
    i, j = np.nonzero(grid.known)
    partial = Partial(grid.points[i, j], np.column_stack([i, j]))
    return refused(columns, rows, reason)._replace(partial=partial)
