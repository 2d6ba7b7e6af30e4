"""Locations averaged with their eight neighbours, and holes filled from them (3.2.2).

Neither extrapolates or goes across a break: a pixel is averaged if all nine are there
and agree, a hole is filled from neighbours on opposite sides that agree.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.layout import DECODED, FILLED, RIM

# Standard deviation of a mean of 3 x 3 independent values, and of 3 x 3 means over
# 7 x 7 pixels, which overlap: (1 + 4 + 9 + 9 + 9 + 9 + 9 + 4 + 1) / 21^2 along each
# axis, where one mean over 7 x 7 has 1 / 7.
OF_PIXELS, OF_WINDOWS = np.float32(1 / 3), np.float32(55 / 441 * 7)


@njit(cache=True, nogil=True, error_model="numpy")
def smooth_neighbours(location, sigma, status, reach):
    """Average locations over 3 x 3 pixels, in place.

    location, sigma: (A, H, W) float32; status: (H, W) uint8; reach: (A,), how far
    neighbours on one surface may be apart. sigma is negative where the sines of a pixel
    were not averaged over 7 x 7 before, and positive afterwards; where that is so of
    only some of the nine, a pixel is left as it is.
    """
    count, height, width = location.shape
    ninth = np.float32(1 / 9)
    # Rows as they were, since those written are read again.
    before = np.empty((2, 2, count, width), np.float32)
    for y in range(1, height - 1):
        for axis in range(count):
            if y == 1:
                before[0, 0, axis], before[1, 0, axis] = (
                    location[axis, 0],
                    sigma[axis, 0],
                )
            before[0, y % 2, axis] = location[axis, y]
            before[1, y % 2, axis] = sigma[axis, y]
        here, above = y % 2, (y - 1) % 2
        for x in range(1, width - 1):
            agree = True
            for v in range(y - 1, y + 2):
                for u in range(x - 1, x + 2):
                    agree = agree and status[v, u] == DECODED
            for axis in range(count):
                if not agree:
                    break
                own = before[0, here, axis, x]
                alone = before[1, here, axis, x] < 0
                for u in range(x - 1, x + 2):
                    for place, spread in (
                        (before[0, above, axis, u], before[1, above, axis, u]),
                        (before[0, here, axis, u], before[1, here, axis, u]),
                        (location[axis, y + 1, u], sigma[axis, y + 1, u]),
                    ):
                        agree = agree and abs(place - own) < reach[axis]
                        agree = agree and (spread < 0) == alone
            if not agree:
                continue
            for axis in range(count):
                place = spread = np.float32(0)
                for u in range(x - 1, x + 2):
                    place += before[0, above, axis, u] + before[0, here, axis, u]
                    place += location[axis, y + 1, u]
                    spread += before[1, above, axis, u] + before[1, here, axis, u]
                    spread += sigma[axis, y + 1, u]
                location[axis, y, x] = ninth * place
                share = OF_PIXELS if spread < 0 else OF_WINDOWS
                sigma[axis, y, x] = share * (ninth * spread)
    for axis in range(count):
        for y in range(height):
            for x in range(width):
                sigma[axis, y, x] = abs(sigma[axis, y, x])


@njit(cache=True, nogil=True, error_model="numpy")
def fill_holes(location, sigma, cells, status, reach, length):
    """Give pixels without a location the mean of neighbours on opposite sides.

    As `smooth_neighbours`; cells: (A, H, W) int16; length: (A,) of a period. Filled
    pixels fill no others. Their sigma is the mean of the neighbours', as these may be
    averages of the same pixels.
    """
    count, height, width = location.shape
    mean = np.empty((2, count), np.float32)
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            if status[y, x] == DECODED:
                continue
            mean[:] = 0
            pairs = 0
            for v, u in ((0, 1), (1, 0), (1, 1), (1, -1)):
                if status[y + v, x + u] != DECODED or status[y - v, x - u] != DECODED:
                    continue
                apart = False
                for axis in range(count):
                    step = location[axis, y + v, x + u] - location[axis, y - v, x - u]
                    apart = apart or abs(step) > reach[axis]
                if apart:
                    continue
                pairs += 1
                for axis in range(count):
                    for one, other in ((v, u), (-v, -u)):
                        mean[0, axis] += location[axis, y + one, x + other]
                        mean[1, axis] += sigma[axis, y + one, x + other]
            if pairs:
                status[y, x] = FILLED
                for axis in range(count):
                    location[axis, y, x] = mean[0, axis] / (2 * pairs)
                    sigma[axis, y, x] = mean[1, axis] / (2 * pairs)
                    cells[axis, y, x] = np.floor(location[axis, y, x] / length[axis])


@njit(cache=True, nogil=True, error_model="numpy")
def mark_rim(near, location, sigma, status):
    """Take away the locations (A, H, W) of decoded pixels where `near` is not 0."""
    width = status.shape[1]
    rim = np.zeros(-(-width // 8) * 8, np.uint8)
    eight = rim.view(np.uint64)
    for y in range(len(status)):
        marked, own = near[y], status[y]
        for x in range(width):
            rim[x] = (marked[x] != 0) & (own[x] == DECODED)
        # Few are: eight pixels at a time are passed over.
        for k in range(len(eight)):
            if eight[k]:
                for x in range(8 * k, min(8 * k + 8, width)):
                    if rim[x]:
                        status[y, x] = RIM
                        location[:, y, x] = np.nan
                        sigma[:, y, x] = np.nan
