"""Edges of the Gray code in one image, and midpoints with its inverse."""

import numpy as np

REACH_PX = 14  # along a column; the next edge of a bit is two cells away


def edge_errors(pictures, patterns, points, cell_mm):
    """RMS distances (px), along columns, of the code's edges from the true ones.

    Charge flows along columns, so the edges across them are measured, of the code
    along y. pictures: (n, H, W) grey values; patterns: n `Pattern`, what each shows;
    points: (H, W, 2) mm, what each pixel sees of the monitor; cell_mm: width of a cell.
    """
    own = {
        (pattern.bit, pattern.inverse): picture
        for picture, pattern in zip(pictures, patterns, strict=True)
        if (pattern.kind, pattern.axis) == ("gray", "y")
    }
    bits = 1 + max(bit for bit, _ in own)
    alone, midway = [], []
    for edge in range(1, round(np.nanmax(points[..., 1]) / cell_mm)):
        rows = true_rows(points[..., 1], edge * cell_mm)
        bit = changing_bit(edge, bits)
        off = [crossing(own[bit, inverse], rows) - rows for inverse in (False, True)]
        alone.append(np.concatenate(off))
        midway.append(np.mean(off, axis=0))
    return {"one picture": rms_known(alone), "midpoint": rms_known(midway)}


def changing_bit(edge, bits):
    """The bit, 0 the coarsest, in which the codes of cells edge - 1 and edge differ."""
    before, after = (cell ^ (cell >> 1) for cell in (edge - 1, edge))
    return bits - (before ^ after).bit_length()


def true_rows(seen, place):
    """Row (W,) px at which each column sees a position along y.

    seen: (H, W) mm, NaN outside the monitor; place: mm. NaN where REACH_PX of a column
    about the place are not all on the monitor.
    """
    rows = np.full(seen.shape[1], np.nan)
    for u, along in enumerate(seen.T):
        known = np.flatnonzero(np.isfinite(along))
        if len(known):
            row = np.interp(place, along[known], known)
            if known[0] <= row - REACH_PX and row + REACH_PX <= known[-1]:
                rows[u] = row
    return rows


def crossing(picture, rows):
    """Row (W,) px where each column of an image is midway between dark and bright.

    Of its darkest and brightest grey value within REACH_PX of `rows`; between the
    pixels it is a straight line.
    """
    found = np.full(len(rows), np.nan)
    columns = np.flatnonzero(np.isfinite(rows))
    around = np.arange(-REACH_PX + 1, REACH_PX)
    v = np.rint(rows[columns, None]).astype(int) + around
    grey = picture[v, columns[:, None]].astype(float)
    above = grey - (grey.min(axis=1) + grey.max(axis=1))[:, None] / 2
    last = np.argmax((above[:, 1:] > 0) != (above[:, :1] > 0), axis=1)
    each = np.arange(len(columns))
    before, after = above[each, last], above[each, last + 1]
    found[columns] = v[each, last] + before / (before - after)
    return found


def rms_known(off):
    """RMS of the finite distances in lists."""
    off = np.concatenate(off)
    return float(np.sqrt(np.mean(off[np.isfinite(off)] ** 2)))
