"""Pixels left out: at the rim of the lit area, the picture's border, and at jumps."""

import cv2
import numpy as np

from raxel.features.active_grid.breaks import EVERY, HALF, mark_breaks
from raxel.features.active_grid.layout import BESIDE, DARK, DECODED, RIM
from raxel.features.active_grid.neighbours import mark_rim

SPECK = 2  # px; so small, a spot without light is no rim


def trim_rim(first, stop, margin, out):
    """Leave out what is within `margin` px of pixels without light; specks are none."""
    location, sigma, _, status = out
    reach = SPECK + margin
    start, end = max(0, first - reach), min(len(status), stop + reach)
    around = status[start:end]
    unlit = ((around == DARK) | (around == BESIDE)).view(np.uint8)
    if not unlit.any():
        return
    # Beyond the picture it goes on as at its border, where strips are no specks.
    unlit = cv2.copyMakeBorder(unlit, *(SPECK,) * 4, cv2.BORDER_REPLICATE)
    unlit = cv2.erode(unlit, np.ones((SPECK + 1,) * 2, np.uint8))
    # What is left of a spot grows by what it lost, and by the margin.
    size = 2 * margin + SPECK + 1
    near = cv2.dilate(unlit, np.ones((size, size), np.uint8))
    near = near[SPECK + first - start :, SPECK:-SPECK]
    mark_rim(near, location[:, first:stop], sigma[:, first:stop], status[first:stop])


def trim_sides(margin, extent, out):
    """Leave out pixels at the picture's border whose surroundings end beyond it.

    What lies `margin` px further out is not in the picture. It is where the surface
    seen there goes on; a blurred pixel sees the monitor's border if that is beyond.
    """
    location, sigma, _, status = out
    if min(status.shape) <= 2 * margin:
        return
    for turned in (False, True):
        for step in (1, -1):
            place, spread, own = (
                (np.swapaxes(a, -1, -2) if turned else a)[..., ::step, :]
                for a in (location, sigma, status)
            )
            outwards = place[:, margin] - place[:, 2 * margin]
            beyond = place[:, :margin] + outwards[:, None]
            inside = np.all((beyond >= 0) & (beyond <= extent), axis=0)
            rim = np.nonzero(~inside & (own[:margin] == DECODED))
            own[rim] = RIM
            place[:, *rim] = np.nan
            spread[:, *rim] = np.nan


def leave_out_breaks(first, stop, margin, broken, out):
    """Leave out what is within `margin` px of a jump; broken: every EVERY-th row."""
    location, sigma, _, status = out
    # A jump was found HALF to either side of it, or in rows passed over a little less.
    grow = max(margin - HALF + EVERY, 0)
    start = max(0, first - grow) // EVERY
    end = -(-min(len(status), stop + grow) // EVERY)
    if not broken[start:end].any():
        return
    near = np.zeros(((end - start) * EVERY, status.shape[1]), np.uint8)
    near[::EVERY] = broken[start:end]
    near = cv2.dilate(near, np.ones((2 * grow + 1,) * 2, np.uint8))
    near, part = near[first - start * EVERY :], slice(first, stop)
    mark_breaks(near, location[:, part], sigma[:, part], status[part])
