"""The lattice of a chessboard's corners: its symmetries, its order, its faults.

A lattice is (rows * columns, 2) pixels (u, v), row by row. In the image, x along the
columns turns clockwise into y along the rows (v points down), for every camera: where
a mirror shows the board reversed, the lattice is the board seen from behind, which is
a rigid motion of it.
"""

import numpy as np

LARGEST_MISFIT = 0.3
LEAST_ALTERNATING = 0.9
LEAST_STEP_PX = 1.0


def symmetries(corners, columns, rows):
    """The eight orders of a lattice that keep neighbours neighbours.

    Yields (corners (columns * rows, 2), (columns, rows)); transposed orders have the
    two counts exchanged, so a caller with fixed counts takes those that fit.
    """
    lattice = np.asarray(corners, dtype=float).reshape(rows, columns, 2)
    for turned in (lattice, lattice.transpose(1, 0, 2)):
        for down in (1, -1):
            for right in (1, -1):
                order = turned[::down, ::right]
                yield order.reshape(-1, 2), (order.shape[1], order.shape[0])


def in_standard_order(corners, columns, rows, image):
    """The same lattice with the first corner and the handedness fixed by rule.

    x turns clockwise into y. Of the orders that are left, those come first whose first
    cell is bright (a board with columns + rows odd has one such order, others two),
    then the one whose x points most to the right. `image` is (height, width) grey.
    """
    fitting = [
        order
        for order, size in symmetries(corners, columns, rows)
        if size == (columns, rows) and _is_clockwise(order, columns, rows)
    ]
    return max(fitting, key=lambda order: _rank(order, columns, rows, image))


def in_order_of_clicks(corners, columns, rows, outer_corners):
    """The order whose four outermost corners lie nearest to four clicked points.

    `outer_corners` (4, 2): the clicks, clockwise from the first corner.
    """
    outermost = [0, columns - 1, columns * rows - 1, columns * (rows - 1)]
    wanted = columns, rows
    fitting = [o for o, size in symmetries(corners, columns, rows) if size == wanted]
    return min(fitting, key=lambda o: np.linalg.norm(o[outermost] - outer_corners))


def lattice_fault(corners, columns, rows, image):
    """Why these corners are no chessboard lattice in `image`, or '' if they are one.

    Checked: finite, inside the image, distinct, every cell convex and turned the same
    way, every corner in line with its neighbours, dark and bright cells in turn.
    """
    height, width = image.shape
    if not np.isfinite(corners).all():
        return "a corner is not finite"
    if (corners < -0.5).any() or (corners > (width - 0.5, height - 0.5)).any():
        return "a corner lies outside the image"
    if spacing(corners, columns, rows).min() < LEAST_STEP_PX:
        return "two corners lie less than a pixel apart"
    lattice = corners.reshape(rows, columns, 2)
    turns = _cell_turns(lattice)
    if not (np.all(turns > 0) or np.all(turns < 0)):
        return "a cell is folded or turned against the others"
    if misfit(corners, columns, rows)[0].max() > LARGEST_MISFIT:
        return "a corner is out of line with its neighbours"
    signs = np.sign(_contrast(lattice, image))
    if max((signs > 0).mean(), (signs < 0).mean()) < LEAST_ALTERNATING:
        return "cells are not dark and bright in turn"
    return ""


def spacing(corners, columns, rows):
    """Distance in px from each corner to its nearest neighbour, (rows * columns,)."""
    lattice = corners.reshape(rows, columns, 2)
    along = np.linalg.norm(np.diff(lattice, axis=1), axis=2)
    down = np.linalg.norm(np.diff(lattice, axis=0), axis=2)
    far = np.inf
    return np.minimum.reduce(
        [
            np.pad(along, ((0, 0), (1, 0)), constant_values=far),
            np.pad(along, ((0, 0), (0, 1)), constant_values=far),
            np.pad(down, ((1, 0), (0, 0)), constant_values=far),
            np.pad(down, ((0, 1), (0, 0)), constant_values=far),
        ]
    ).ravel()


def misfit(corners, columns, rows):
    """How far each corner is from where its neighbours in line would put it.

    Returns (misfit (rows * columns,), prediction (rows * columns, 2)). The prediction
    is the cubic through the four nearest others of the same row, or of the same
    column, whichever agrees better (a bad neighbour spoils one of them only). The
    misfit is the distance to it in steps of that line.
    """
    lattice = corners.reshape(rows, columns, 2)
    along = _line_misfit(lattice)
    down = [a.swapaxes(0, 1) for a in _line_misfit(lattice.swapaxes(0, 1))]
    better = along[0] <= down[0]
    size = np.where(better, along[0], down[0])
    prediction = np.where(better[..., None], along[1], down[1])
    return size.ravel(), prediction.reshape(-1, 2)


def _line_misfit(lattice):
    """Misfit and prediction of every corner within its row (second axis)."""
    prediction = np.einsum("jk,ikc->ijc", _leave_one_out(lattice.shape[1]), lattice)
    steps = np.linalg.norm(np.diff(lattice, axis=1), axis=2)
    local = (
        np.pad(steps, ((0, 0), (1, 0)), "edge")
        + np.pad(steps, ((0, 0), (0, 1)), "edge")
    ) / 2
    apart = np.linalg.norm(prediction - lattice, axis=2)
    return apart / np.maximum(local, LEAST_STEP_PX), prediction


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
    return np.median(_cell_turns(corners.reshape(rows, columns, 2))) > 0


def _rank(corners, columns, rows, image):
    lattice = corners.reshape(rows, columns, 2)
    first_is_bright = _contrast(lattice, image).sum() > 0
    x = (lattice[:, -1] - lattice[:, 0]).mean(axis=0)
    return first_is_bright, x[0] / np.hypot(*x)


def _contrast(lattice, image):
    """Each cell's grey against its edge neighbours, times the first cell's sign.

    (rows - 1, columns - 1); positive throughout where the first cell is bright.
    """
    padded = np.pad(_cell_grey(lattice, image), 1, constant_values=np.nan)
    around = (padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:])
    own = padded[1:-1, 1:-1]
    i, j = np.indices(own.shape)
    return (own - np.nanmean(around, axis=0)) * (-1.0) ** (i + j)


def _cell_grey(lattice, image):
    """Mean of 3 x 3 px around the middle of each cell, (rows - 1, columns - 1)."""
    ring = lattice[:-1, :-1], lattice[:-1, 1:], lattice[1:, 1:], lattice[1:, :-1]
    u, v = np.rint(sum(ring) / 4).astype(int).transpose(2, 0, 1)
    height, width = image.shape
    around = [
        image[np.clip(v + dv, 0, height - 1), np.clip(u + du, 0, width - 1)]
        for dv in (-1, 0, 1)
        for du in (-1, 0, 1)
    ]
    return np.mean(around, axis=0, dtype=float)
