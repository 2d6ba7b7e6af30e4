"""Dark parts that are taken for lit ones, since their noise is more than was measured.

Noise is measured from differences of neighbouring pixels. A tone curve makes it larger
in the dark, and the blocks of a JPEG file hide it: outside the monitor, a pixel is then
decoded by chance. Two neighbours may agree by chance, a patch of them does not, and the
sines are faint there. Small images of a mirror need this: a quarter of their decoded
pixels are such specks.
"""

from dataclasses import replace

import cv2
import numpy as np

from raxel.features.active_grid.layout import ALONE, FILLED, RIM

FAINT = 5  # times the usual sigma
PATCH = 40  # pixels that hang together; of fewer, it is a speck
MANY = 0.01  # of what is decoded: fewer specks are what cameras in facets see


def without_specks(decoded):
    """(Decoded without specks and what is near them, the share that they were).

    Where specks are few, they stay, and the share is 0. Where they are many, what lies
    beside the lit area did not count as dark: the rim is left out here, by margin_px
    about all that is not decoded.
    """
    mask = decoded.mask.astype(np.uint8)
    count = np.count_nonzero(mask)
    labels, stats = cv2.connectedComponentsWithStats(mask, connectivity=8)[1:3]
    small = stats[:, cv2.CC_STAT_AREA] < PATCH
    small[0] = False
    specks = small[labels] & _faint(decoded.sigma, mask > 0)
    share = np.count_nonzero(specks) / max(count, 1)
    if share < MANY:
        return decoded, 0.0
    mask[specks] = 0
    kernel = np.ones((2 * decoded.margin_px + 1,) * 2, np.uint8)
    inner = cv2.erode(mask, kernel, borderValue=1) > 0
    status = np.where(specks, ALONE, decoded.status)
    status = np.where((mask > 0) & ~inner, RIM, status).astype(np.uint8)
    gone = status > FILLED
    location, sigma = decoded.location.copy(), decoded.sigma.copy()
    location[gone] = sigma[gone] = np.nan
    return replace(decoded, location=location, sigma=sigma, status=status), share


def _faint(sigma, mask):
    """(H, W) bool: where an axis is known much worse than it usually is."""
    faint = np.zeros(mask.shape, bool)
    for own in np.moveaxis(sigma, 2, 0):
        known = own[mask]
        if np.isfinite(known).any():
            faint |= own > FAINT * np.nanmedian(known)
    return faint
