"""How blurred a view is, from the edges of its own Gray code.

A picture less its inverse goes from minus to plus the contrast across an edge, as the
error function does where lens, focus and monitor blur it like a Gaussian. Its slope
says how wide that is, wherever the edge lies. A tone curve that is concave, as files
of cameras have, makes the blur look up to half as wide again, never narrower.
"""

from typing import NamedTuple

import cv2
import numpy as np
from scipy.special import erfinv, ndtri

from raxel.features.active_grid.layout import REACH

SAMPLES = 40_000  # pixels looked at for edges, all over the picture
REACH_PX = 12  # of the patch around an edge, beyond what its place is uncertain by
SMOOTHED_PX = 1.5  # against noise; taken off again
OF_DIFFERENCES = 1 / 3  # variance, px^2, that differences over two pixels add
NEAR_EDGE = 0.5  # of the contrast
TOO_FINE = 0.5  # share of a patch near edges: they flow together
CLEAR, LEAST_SHARE = 10, 0.2  # contrast in deviations of the noise, and of the usual
AREAS = 3  # along each side of the picture, each with a blur of its own
EDGES = 8  # of each area
LEAST_PIXELS = 100  # of an area, or of the whole picture where no area has so many
DARK_BELOW = 7  # deviations of the noise: contrasts that the decoder takes for none
FARTHEST = 3  # standard deviations of the blur, beyond which there is no light


class Blur(NamedTuple):
    """Standard deviation px of the blur of a view, in the worst ninth of the picture.

    beyond_px: so far beyond the rim of the lit area there is light enough to decode.
    """

    px: float
    beyond_px: float = 0.0

    def margins(self, smooth):
        """(2,) px: from where there is no light, and from jumps, to sound pixels."""
        reach = REACH * bool(smooth) + FARTHEST * self.px
        return int(np.ceil(reach + self.beyond_px)), int(np.ceil(reach))


def measured_blur(stack, noise):
    """The Blur of a view, or None where too few edges of Gray code are seen.

    stack: a PictureStack; noise: a Noise.
    """
    pairs = [pair for code in stack.codes for pair in code.bits]
    step = max(4, round(np.sqrt(np.prod(stack.shape) / SAMPLES)))
    reach = REACH_PX + step // 2
    if not pairs or min(stack.shape) <= 2 * reach:
        return None
    row, column = (np.arange(step // 2, size, step) for size in stack.shape)
    coarse = np.array([stack.apart(pair, np.ix_(row, column)) for pair in pairs])
    lit, contrast, dark = _lit(stack, coarse, pairs[0], np.ix_(row, column), noise)
    if not lit.any():
        return None
    bit, v, u, area = _edges(coarse, lit)
    v, u = (
        np.clip(ends[at], reach, size - 1 - reach)
        for ends, at, size in zip((row, column), (v, u), stack.shape, strict=True)
    )
    spread, patch = _spread(stack, pairs, bit, v, u, reach, contrast)
    medians = [
        np.median(own)
        for own in (spread[area[patch] == k] for k in range(AREAS * AREAS))
        if len(own) >= LEAST_PIXELS
    ]
    if not medians and len(spread) < LEAST_PIXELS:
        return None
    widest = max(medians) if medians else np.median(spread)
    blur = float(np.sqrt(max(widest - SMOOTHED_PX**2 - OF_DIFFERENCES, 0)))
    share = np.clip(DARK_BELOW * np.sqrt(noise.at(dark)) / contrast, 1e-3, 0.5)
    return Blur(blur, -blur * float(ndtri(share)))


def _lit(stack, apart, pair, where, noise):
    """Where there is contrast (h, w), how much there usually is, and the level of dark.

    apart: (bits, h, w), pictures less inverses at `where`; pair: of the first bit.
    """
    contrast = np.abs(apart).max(axis=0)
    light = stack.images[pair[0]][where].astype(np.float32)
    dark = light - (apart[0] + contrast) / 2
    lit = contrast > CLEAR * np.sqrt(noise.at(dark))
    if lit.any():
        lit &= contrast > LEAST_SHARE * np.quantile(contrast[lit], 0.9)
    if not lit.any():
        return lit, 0.0, 0.0
    return lit, np.median(contrast[lit]), np.median(dark[lit])


def _edges(apart, lit):
    """Some pixels beside an edge, in each area: bit, row, column and area of each."""
    light, found = apart > 0, []
    for first, second in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1, :], np.s_[1:, :])):
        changed = light[:, *first] != light[:, *second]
        found.append(np.nonzero(changed & lit[first] & lit[second]))
    bit, v, u = np.concatenate(found, axis=1)
    area = AREAS * (AREAS * v // lit.shape[0]) + AREAS * u // lit.shape[1]
    kept = []
    for k in range(AREAS * AREAS):
        own = np.flatnonzero(area == k)
        kept.append(own[:: -(-len(own) // EDGES) or 1])
    kept = np.concatenate(kept)
    return bit[kept], v[kept], u[kept], area[kept]


def _spread(stack, pairs, bit, v, u, reach, contrast):
    """(E,) squared width px^2 at pixels near edges, and the patch of each.

    bit, v, u: of the patches, which reach so far to each side of row v and column u.
    """
    around = np.arange(-reach, reach + 1)
    where = (v[:, None] + around)[:, :, None], (u[:, None] + around)[:, None, :]
    size = len(around)
    apart = np.array([stack.apart(pair, where) for pair in pairs])
    most = np.abs(apart).max(axis=0)
    own = apart[bit, np.arange(len(bit))] / np.maximum(most, 1)
    # Patches one below the other; what they give each other is left out with the rim.
    share = cv2.GaussianBlur(own.reshape(-1, size), (0, 0), SMOOTHED_PX)
    share = share.reshape(own.shape)
    rim = 1 + round(3 * SMOOTHED_PX)
    clear = most > LEAST_SHARE * contrast
    whole = clear.all(axis=(1, 2))
    inner = share[:, rim:-rim, rim:-rim]
    near = np.abs(inner) < NEAR_EDGE
    whole &= np.mean(near, axis=(1, 2)) < TOO_FINE
    patch, y, x = np.nonzero(near & whole[:, None, None])
    y, x = y + rim, x + rim
    right = (share[patch, y, x + 1] - share[patch, y, x - 1]) / 2
    down = (share[patch, y + 1, x] - share[patch, y - 1, x]) / 2
    steepest = np.sqrt(2 / np.pi) * np.exp(-(erfinv(share[patch, y, x]) ** 2))
    return steepest**2 / (right**2 + down**2 + 1e-12), patch
