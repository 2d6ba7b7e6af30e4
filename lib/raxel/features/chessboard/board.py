"""Chessboards found without clicks, whatever the lens: corners, order and size.

Saddles of the grey values at several scales (`saddles`), those with four fields around
them (`ring`), edges followed from one to the next (`trace`), lattices grown from the
links (`growth`), checked, filled and run on with the lattice's own shape (`grids`,
`patches`, `corners`), cut where the paper ends (`ends`) or where its ground begins
(`windows`), and judged (`verdict`, `rim`, `sides`, `covers`, `squares`). No model of
the lens enters.
"""

from __future__ import annotations

import numpy as np

from raxel.errors import InputError
from raxel.features.charuco import with_markers_named
from raxel.features.chessboard.ends import covered_side, doubtful_side, shaded_side
from raxel.features.chessboard.search import seen_in
from raxel.features.chessboard.sides import cut_side, dark_side
from raxel.features.chessboard.verdict import (
    continues,
    judged,
    lies_on_pattern,
    open_side,
    open_sides,
    shape_fault,
)
from raxel.features.detector import Detection, Partial, as_8_bit, refused
from raxel.features.lattice import standard_order


def find_board(
    image: np.ndarray, columns: int | None = None, rows: int | None = None
) -> Detection:
    """Detect the chessboard of an image, whatever the lens.

    Two thirds of each row and column of the board must be visible, and all of its sides
    where the size is not given. Corners with a predicted standard deviation above a
    third of a pixel, at most a third of all, are missing (NaN) like those not detected.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels, uint8 or uint16.
    columns, rows : int, optional
        Numbers of interior corners, or both None where unknown.

    Returns
    -------
    Detection
        The board. Otherwise the reason why there is none, and as `partial` the corners
        in order.

    Raises
    ------
    InputError
        `bad-input` for one count without the other, and for an array that is no grey
        image.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features import find_board
    >>> squares = np.indices((5, 6)).sum(axis=0) % 2
    >>> board = np.kron(squares, np.ones((30, 30)))
    >>> image = np.pad(255 * board, 40, constant_values=255).astype(np.uint8)
    >>> found = find_board(image)
    >>> found.found, found.columns, found.rows
    (True, 5, 4)
    >>> bool(np.abs(found.corners.min(axis=0) - 69.5).max() < 0.1)
    True
    """
    if (columns is None) != (rows is None):
        found, missing = ("columns", "rows") if rows is None else ("rows", "columns")
        raise InputError(f"{missing}: not given, but {found} is; give both or neither")
    grey = as_8_bit(image)
    if min(grey.shape) < 16:
        return refused(columns, rows, "the image is too small to show a board")
    detection = _found(image, grey, columns, rows)
    return detection if detection.found else with_markers_named(detection, grey)


def _found(image, grey, columns, rows):
    known = columns is not None and rows is not None
    seen = seen_in(grey, (columns, rows) if known else None)
    if not seen.grids:
        of = f"of {columns} x {rows} interior corners" if known else "of any size"
        count = len(seen.nodes.points)
        reason = f"no board {of}: {count} corners are seen and no lattice of them"
        return refused(columns, rows, reason)
    if not known:
        return _unknown_size(seen, image)
    return _known_size(seen, image, columns, rows)


def _verdicts(seen, image, told):
    """What each lattice is: `verdict.Judged`, by its corners and by its fields."""
    level = seen.levels[0]
    verdicts = []
    for grid, part in zip(seen.grids, seen.parted, strict=True):
        verdict = judged(grid, image, told, part)
        fault = shape_fault(grid, level) or verdict.fault
        named = not grid.complete and not lies_on_pattern(grid, image)
        if verdict.fault == fault and fault and named:
            fault = _edge_named(doubtful_side(grid, level)) + fault
        verdicts.append(verdict._replace(fault=fault))
    return verdicts


def _edge_named(side):
    """What a lattice's doubtful side may be, before what is wrong with it."""
    if not side:
        return ""
    return f"the last row of corners at its {side} may be the edge of the paper: "


def _known_size(seen, image, columns, rows):
    grids = seen.grids
    wanted = {(columns, rows), (rows, columns)}
    verdicts = _verdicts(seen, image, told=True)
    sound = [v.sure for v in verdicts if not v.fault]
    boards = [grid for grid in sound if grid.known.shape in wanted]
    if len(boards) == 1:
        return _detection(boards[0], image, columns, rows)
    if boards:
        reason = f"{len(boards)} boards of {columns} x {rows} corners are seen"
        return _refused(grids[0], image, columns, rows, reason)
    fault = verdicts[0].fault or _other_size(grids[0], image, wanted)
    reason = f"no board of {columns} x {rows} interior corners: {fault}"
    return _refused(grids[0], image, columns, rows, reason)


def _other_size(grid, image, wanted):
    """What a board's size is that is none of the wanted (columns, rows), in words."""
    shape = grid.known.shape
    lacking = {
        axis
        for size in wanted
        if all(n <= most for n, most in zip(shape, size, strict=True))
        for axis in (0, 1)
        if shape[axis] < size[axis]
    }
    open_ = [name for axis, name in open_sides(grid, image) if axis in lacking]
    but = f", but {_goes_on(open_[0])}" if open_ else ""
    return f"{_size(grid)}{but}; check columns and rows"


def _goes_on(side):
    return f"the board may go on beyond its {side}, outside the image"


def _unknown_size(seen, image):
    grids = seen.grids
    verdicts = _verdicts(seen, image, told=False)
    boards = [v for v in verdicts if not v.fault]
    if len(boards) > 1:
        sizes = ", ".join(_size(v.seen) for v in boards)
        reason = f"{len(boards)} boards are seen ({sizes}); give columns and rows"
        found = _refused(boards[0].seen, image, None, None, reason)
        shapes = (sorted(v.seen.known.shape, reverse=True) for v in boards)
        return found._replace(complete=tuple(map(tuple, shapes)))
    if not boards:
        return _refused(grids[0], image, None, None, verdicts[0].fault)
    board = boards[0].seen
    doubt = _doubt(board, seen.levels[0], image, [v.seen for v in verdicts if v.fault])
    if doubt:
        reason = f"{_size(board)}, but {doubt}; give columns and rows"
        return _refused(board, image, None, None, reason)
    return _detection(boards[0].sure, image)


def _doubt(board, level, image, others):
    """Why a board that was counted may not be the whole one, in words, or ''."""
    grey = as_8_bit(image)
    side = open_side(board, image)
    if side:
        return _goes_on(side)
    side = cut_side(board, grey)
    if side:
        return (
            f"the squares at its {side} look cut short, as by a shadow, by glare, by "
            "something before the board or by a shutter that rolls"
        )
    side = dark_side(board, grey)
    if side:
        return (
            f"behind its {side} it is dark, where other sides have white paper: a "
            "shadow may hide squares"
        )
    side = covered_side(board, grey)
    if side:
        return (
            f"the edge at its {side} runs straight on beyond the board: something that "
            "lies before it may hide squares"
        )
    side = shaded_side(board, level)
    if side:
        return f"more squares stand in a shadow beyond its {side}"
    return "more of a lattice stands beside it" if continues(board, others) else ""


def _size(grid):
    rows, columns = sorted(grid.known.shape)
    return f"{columns} x {rows} corners found"


def _detection(grid, image, columns=None, rows=None):
    """The Detection of a complete grid; its longer side is columns unless given."""
    if columns is None:
        columns, rows = max(grid.known.shape), min(grid.known.shape)
    points, sd = grid.points, grid.sd
    if grid.known.shape != (rows, columns):
        points, sd = points.transpose(1, 0, 2), sd.T
    corners, sd = points.reshape(-1, 2), sd.ravel()
    order = standard_order(corners, columns, rows, image)
    return Detection(True, corners[order], columns, rows, sd=sd[order])


def _refused(grid, image, columns, rows, reason):
    i, j = np.nonzero(grid.known)
    partial = Partial(grid.points[i, j], np.column_stack([i, j]))
    return refused(columns, rows, reason)._replace(partial=partial)
