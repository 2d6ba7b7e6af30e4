"""Detect chessboards of unknown pose and lens: corners, order and size.

Saddle points of the grey levels at several scales with four squares around them are
corner candidates (`saddles`). Edges are followed from candidate to candidate, and
lattices grown from these links (`links`). Lattices are verified, completed and
extrapolated with their own local shape (`grids`, `corners`). They are cut where the
paper or the printed pattern ends (`ends`), and judged (`verdict`, `sides`). No lens
model is used.
"""

from __future__ import annotations

import numpy as np

from raxel.errors import InputError
from raxel.features.charuco import with_marker_hint
from raxel.features.chessboard.ends import (
    occluded_side,
    side_before_shadow,
    uncertain_side,
)
from raxel.features.chessboard.saddles import halved
from raxel.features.chessboard.search import search_image
from raxel.features.chessboard.sides import dark_side, truncated_side
from raxel.features.chessboard.verdict import (
    has_continuation,
    is_within_pattern,
    judge_grid,
    open_side,
    open_sides,
    shape_fault,
)
from raxel.features.detector import Detection, Partial, as_8_bit, rejected
from raxel.features.lattice import standard_order

# Squares of a second board, relative to the largest; others are background.
MIN_SQUARE_RATIO = 1 / 3


def find_board(
    image: np.ndarray, columns: int | None = None, rows: int | None = None
) -> Detection:
    """Detect the chessboard of an image, without a lens model.

    Two thirds of each row and column of the board must be visible, and all of its sides
    where the size is not given. With a given size, two thirds of the board suffice
    if three of its outer corners and half of each side are visible. Corners with a
    predicted standard deviation above a third of a pixel, at most a third of all, are
    missing (NaN) like those not detected.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels, uint8 or uint16.
    columns, rows : int, optional
        Numbers of interior corners, or both None where unknown.

    Returns
    -------
    Detection
        The board. Otherwise the reason for its rejection, and as `partial` the corners
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
        return rejected(columns, rows, "image below 16 x 16 px")
    detection = _search(image, columns, rows)
    return detection if detection.found else with_marker_hint(detection, grey)


def _search(image, columns, rows):
    known = columns is not None and rows is not None
    result = search_image(as_8_bit(image), (columns, rows) if known else None)
    if not result.grids:
        size_text = (
            f"of {columns} x {rows} interior corners" if known else "of any size"
        )
        count = len(result.nodes.points)
        reason = (
            f"no board {size_text}: {count} corners detected, but no lattice of them"
        )
        detection = rejected(columns, rows, reason)
    elif known:
        detection = _known_size(result, image, columns, rows)
    else:
        detection = _unknown_size(result, image)
    return _with_more_corners(detection, result, image, columns, rows)


def _with_more_corners(detection, result, image, columns, rows):
    """The Detection, or that in the halved image if that has more corners.

    For boards that are not complete. The windows of the corner fit are too small for
    an image without detail at the scale of its pixels, as of digital zoom.
    """
    complete = detection.found and not detection.missing
    if complete or any(shape_fault(grid, result.levels[0]) for grid in result.grids):
        return detection
    half = halved(image)
    if half is None:
        return detection
    other = _search(half, columns, rows)
    same = (detection.columns, detection.rows) == (other.columns, other.rows)
    fewer = detection.found and same and other.missing < detection.missing
    if other.found and (fewer or not detection.found):
        # Pixel centres are at integers.
        return other._replace(corners=2 * other.corners + 0.5, sd=2 * other.sd)
    return detection


def _verdicts(result, image, known_size):
    """The `verdict.Verdict` on each lattice, from its corners and its squares."""
    level = result.levels[0]
    verdicts = []
    for grid, part in zip(result.grids, result.is_part, strict=True):
        verdict = judge_grid(grid, image, known_size, part)
        fault = shape_fault(grid, level) or verdict.fault
        named = not grid.complete and not is_within_pattern(grid, image)
        if verdict.fault == fault and fault and named:
            fault = _paper_edge_prefix(uncertain_side(grid, level)) + fault
        verdicts.append(verdict._replace(fault=fault))
    return verdicts


def _paper_edge_prefix(side):
    """Text that names an uncertain side of a lattice, in front of the fault."""
    if not side:
        return ""
    return f"the last row of corners at its {side} may be the edge of the paper: "


def _known_size(result, image, columns, rows):
    grids = result.grids
    wanted = {(columns, rows), (rows, columns)}
    verdicts = _verdicts(result, image, known_size=True)
    sound = [v.certain for v in verdicts if not v.fault]
    boards = _in_front([grid for grid in sound if grid.known.shape in wanted])
    if len(boards) == 1:
        return _detection(boards[0], image, columns, rows)
    if boards:
        reason = f"{len(boards)} boards of {columns} x {rows} corners in the image"
        return _rejected_with_part(grids[0], image, columns, rows, reason)
    fault = verdicts[0].fault or _other_size(grids[0], image, wanted)
    reason = f"no board of {columns} x {rows} interior corners: {fault}"
    return _rejected_with_part(grids[0], image, columns, rows, reason)


def _in_front(boards):
    """The boards without those whose squares are small compared with the largest.

    Prints on a wall or a screen far behind the board may have its number of squares.
    """
    spacings = [
        np.nanmedian(np.linalg.norm(np.diff(grid.points, axis=axis), axis=2))
        for grid in boards
        for axis in (0, 1)
    ]
    sides = np.reshape(spacings, (-1, 2)).max(axis=1)
    return [
        grid
        for grid, side in zip(boards, sides, strict=True)
        if side >= MIN_SQUARE_RATIO * sides.max()
    ]


def _other_size(grid, image, wanted):
    """Text on the size of a board that has none of the wanted (columns, rows)."""
    shape = grid.known.shape
    lacking = {
        axis
        for size in wanted
        if all(n <= maximum for n, maximum in zip(shape, size, strict=True))
        for axis in (0, 1)
        if shape[axis] < size[axis]
    }
    open_ = [name for axis, name in open_sides(grid, image) if axis in lacking]
    but = f", but {_extends_outside(open_[0])}" if open_ else ""
    return f"{_size(grid)}{but}; check columns and rows"


def _extends_outside(side):
    return f"the board may continue beyond its {side}, outside the image"


def _unknown_size(result, image):
    grids = result.grids
    verdicts = _verdicts(result, image, known_size=False)
    boards = [v for v in verdicts if not v.fault]
    if len(boards) > 1:
        sizes = ", ".join(_size(v.grid) for v in boards)
        reason = f"{len(boards)} boards in the image ({sizes}); give columns and rows"
        found = _rejected_with_part(boards[0].grid, image, None, None, reason)
        shapes = (sorted(v.grid.known.shape, reverse=True) for v in boards)
        return found._replace(complete=tuple(map(tuple, shapes)))
    if not boards:
        return _rejected_with_part(grids[0], image, None, None, verdicts[0].fault)
    board = boards[0].grid
    doubt = _whole_board_doubt(
        board, result.levels[0], image, [v.grid for v in verdicts if v.fault]
    )
    if doubt:
        reason = f"{_size(board)}, but {doubt}; give columns and rows"
        return _rejected_with_part(board, image, None, None, reason)
    return _detection(boards[0].certain, image)


def _whole_board_doubt(board, level, image, others):
    """Why a detected board of unknown size may be a part of a larger one, or ''."""
    grey = as_8_bit(image)
    side = open_side(board, image)
    if side:
        return _extends_outside(side)
    side = truncated_side(board, grey)
    if side:
        return (
            f"the outer squares at its {side} appear truncated (shadow, glare, "
            "occluder or rolling shutter)"
        )
    side = dark_side(board, grey)
    if side:
        return (
            f"the margin at its {side} is dark, unlike at other sides (a shadow "
            "may hide squares)"
        )
    side = occluded_side(board, grey)
    if side:
        return (
            f"the edge at its {side} extends beyond the board (an occluder may "
            "hide squares)"
        )
    side = side_before_shadow(board, level)
    if side:
        return f"more squares are in a shadow beyond its {side}"
    return "another lattice continues it" if has_continuation(board, others) else ""


def _size(grid):
    rows, columns = sorted(grid.known.shape)
    return f"{columns} x {rows} corners found"


def _detection(grid, image, columns=None, rows=None):
    """The Detection of a grid; its longer side is columns unless given."""
    if columns is None:
        columns, rows = max(grid.known.shape), min(grid.known.shape)
    points, sd = grid.points, grid.sd
    if grid.known.shape != (rows, columns):
        points, sd = points.transpose(1, 0, 2), sd.T
    corners, sd = points.reshape(-1, 2), sd.ravel()
    order = standard_order(corners, columns, rows, image)
    return Detection(True, corners[order], columns, rows, sd=sd[order])


def _rejected_with_part(grid, image, columns, rows, reason):
    i, j = np.nonzero(grid.known)
    partial = Partial(grid.points[i, j], np.column_stack([i, j]))
    return rejected(columns, rows, reason)._replace(partial=partial)
