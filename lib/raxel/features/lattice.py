"""The lattice of a chessboard's corners: symmetries, order and validity.

A lattice is (rows * columns, 2) pixels (u, v), row by row, NaN for a missing corner. In
the image, x along the columns turns clockwise into y along the rows (v points down),
for every camera. Where a mirror shows the board reversed, the lattice is the board
viewed from behind, which is a rigid motion of it.
"""

import numpy as np

MAX_MISFIT_STEPS = 0.3
MIN_ALTERNATING_FRACTION = 0.9
MIN_STEP_PX = 1.0


def symmetries(corners, columns, rows):
    """The eight orders of a lattice that keep neighbours neighbours.

    Yields (corners (columns * rows, 2), (columns, rows)); transposed orders have the
    two counts exchanged, so a caller with fixed counts takes those that fit.
    """
    corners = np.asarray(corners, dtype=float)
    for order, size in orders(columns, rows):
        yield corners[order], size


def orders(columns, rows):
    """Yield the eight orders: (index (rows * columns,), (columns, rows))."""
    lattice = np.arange(rows * columns).reshape(rows, columns)
    for oriented in (lattice, lattice.T):
        for down in (1, -1):
            for right in (1, -1):
                order = oriented[::down, ::right]
                yield order.ravel(), order.shape[::-1]


def standard_order(corners, columns, rows, image):
    """Index (rows * columns,) of a lattice's corners in the standard order.

    x turns clockwise into y. Of the remaining orders, those with a bright first cell
    are preferred (a board with columns + rows odd has one such order, others two), then
    the one whose x points most to the right. `image` is (height, width) grey.
    """
    fitting = [
        order
        for order, size in orders(columns, rows)
        if size == (columns, rows) and _is_clockwise(corners[order], columns, rows)
    ]
    return max(fitting, key=lambda order: _rank(corners[order], columns, rows, image))


def order_of_clicks(corners, columns, rows, outer_corners):
    """Index of the order whose outermost corners are nearest to four clicked points.

    `outer_corners` (4, 2): the clicks, clockwise from the first corner. A missing
    outermost corner is ignored.
    """
    outermost = [0, columns - 1, columns * rows - 1, columns * (rows - 1)]
    wanted = columns, rows
    fitting = [order for order, size in orders(columns, rows) if size == wanted]

    def squared_distance(order):
        return np.nansum((corners[order][outermost] - outer_corners) ** 2)

    return min(fitting, key=squared_distance)


def lattice_fault(corners, columns, rows, image):
    """Why these corners are not a chessboard lattice in `image`, or ''.

    Tests: finite or missing, inside the image, distinct, every cell convex and of the
    same orientation, every corner in line with its neighbours, dark and bright cells
    alternating. Missing corners and the cells around them are not tested.
    """
    height, width = image.shape
    missing = np.isnan(corners).all(axis=1)
    if not np.isfinite(corners[~missing]).all():
        return "a corner is not finite"
    if missing.all():
        return "every corner is missing"
    if (corners < -0.5).any() or (corners > (width - 0.5, height - 0.5)).any():
        return "a corner is outside the image"
    if spacing(corners, columns, rows).min() < MIN_STEP_PX:
        return "two corners are less than a pixel apart"
    lattice = corners.reshape(rows, columns, 2)
    turns = _cell_turns(lattice)
    turns = turns[np.isfinite(turns)]
    if not (np.all(turns > 0) or np.all(turns < 0)):
        return "a cell is folded or reversed relative to the others"
    if np.nanmax(misfit(corners, columns, rows)[0], initial=0) > MAX_MISFIT_STEPS:
        return "a corner is out of line with its neighbours"
    contrast = _contrast(lattice, image)
    signs = np.sign(contrast[np.isfinite(contrast)])
    if not len(signs):
        return "no cell has all its corners"
    if max((signs > 0).mean(), (signs < 0).mean()) < MIN_ALTERNATING_FRACTION:
        return "cells are not alternately dark and bright"
    return ""


def spacing(corners, columns, rows):
    """Distance in px from each corner to its nearest neighbour, (rows * columns,).

    Infinite without a neighbour.
    """
    lattice = corners.reshape(rows, columns, 2)
    along = np.linalg.norm(np.diff(lattice, axis=1), axis=2)
    down = np.linalg.norm(np.diff(lattice, axis=0), axis=2)
    far = np.inf
    return np.fmin.reduce(
        [
            np.pad(along, ((0, 0), (1, 0)), constant_values=far),
            np.pad(along, ((0, 0), (0, 1)), constant_values=far),
            np.pad(down, ((1, 0), (0, 0)), constant_values=far),
            np.pad(down, ((0, 1), (0, 0)), constant_values=far),
        ]
    ).ravel()


def misfit(corners, columns, rows):
    """Deviation of each corner from the prediction of its neighbours in line.

    Returns (misfit (rows * columns,), prediction (rows * columns, 2)). The prediction
    is the cubic through the four nearest others of the same row or column, whichever
    agrees better, since a wrong neighbour affects one of them only. The misfit is the
    distance to it in steps of that line. It is NaN where corners are missing in either
    line, since the other alone may be too curved for a cubic.
    """
    lattice = corners.reshape(rows, columns, 2)
    along = _line_misfit(lattice)
    down = [a.swapaxes(0, 1) for a in _line_misfit(lattice.swapaxes(0, 1))]
    better = along[0] <= down[0]
    size = np.minimum(along[0], down[0])
    prediction = np.where(better[..., None], along[1], down[1])
    return size.ravel(), prediction.reshape(-1, 2)


def _line_misfit(lattice):
    """Misfit and prediction of every corner within its row (second axis)."""
    weights = _leave_one_out(lattice.shape[1])
    missing = np.isnan(lattice[..., 0])
    prediction = np.einsum("jk,ikc->ijc", weights, np.nan_to_num(lattice))
    prediction[missing @ (weights != 0).T] = np.nan
    steps = np.linalg.norm(np.diff(lattice, axis=1), axis=2)
    local = (
        np.pad(steps, ((0, 0), (1, 0)), "edge")
        + np.pad(steps, ((0, 0), (0, 1)), "edge")
    ) / 2
    distance = np.linalg.norm(prediction - lattice, axis=2)
    return distance / np.maximum(local, MIN_STEP_PX), prediction


def _leave_one_out(count):
    """Weights (count, count) that predict each sample from its four nearest others."""
    weights = np.zeros((count, count))
    for at in range(count):
        others = sorted(set(range(count)) - {at}, key=lambda k: (abs(k - at), k))[:4]
        for k in others:
            rest = [other for other in others if other != k]
            weights[at, k] = np.prod([(at - r) / (k - r) for r in rest])
    return weights


def _cell_turns(lattice):
    """Cross product (px^2) at the four corners of each cell; positive = clockwise."""
    ring = np.stack(
        (lattice[:-1, :-1], lattice[:-1, 1:], lattice[1:, 1:], lattice[1:, :-1]), axis=2
    )
    ahead = np.roll(ring, -1, axis=2) - ring
    after = np.roll(ahead, -1, axis=2)
    return ahead[..., 0] * after[..., 1] - ahead[..., 1] * after[..., 0]


def _is_clockwise(corners, columns, rows):
    return np.nanmedian(_cell_turns(corners.reshape(rows, columns, 2))) > 0


def _rank(corners, columns, rows, image):
    lattice = corners.reshape(rows, columns, 2)
    first_is_bright = np.nansum(_contrast(lattice, image)) > 0
    x = np.nanmean(np.diff(lattice, axis=1), axis=(0, 1))
    return first_is_bright, x[0] / np.hypot(*x)


def _contrast(lattice, image):
    """Contrast of each cell to its edge neighbours, times the first cell's sign.

    (rows - 1, columns - 1); positive throughout where the first cell is bright.
    """
    padded = np.pad(_cell_grey(lattice, image), 1, constant_values=np.nan)
    around = (padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:])
    own = padded[1:-1, 1:-1]
    i, j = np.indices(own.shape)
    known = np.isfinite(around).sum(axis=0)
    mean = np.nansum(around, axis=0) / np.where(known, known, np.nan)
    return (own - mean) * (-1.0) ** (i + j)


def _cell_grey(lattice, image):
    """Mean of 3 x 3 px around the centre of each cell, (rows - 1, columns - 1).

    NaN for a cell that lacks a corner.
    """
    ring = lattice[:-1, :-1], lattice[:-1, 1:], lattice[1:, 1:], lattice[1:, :-1]
    middle = sum(ring) / 4
    known = np.isfinite(middle[..., 0])
    u, v = np.rint(np.nan_to_num(middle)).astype(int).transpose(2, 0, 1)
    height, width = image.shape
    around = [
        image[np.clip(v + dv, 0, height - 1), np.clip(u + du, 0, width - 1)]
        for dv in (-1, 0, 1)
        for du in (-1, 0, 1)
    ]
    return np.where(known, np.mean(around, axis=0, dtype=float), np.nan)
