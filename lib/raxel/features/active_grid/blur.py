"""How blurred a view is, from the edges of its own Gray code.

A picture less its inverse goes from minus to plus the contrast across an edge, as the
error function does where lens, focus and monitor blur it like a Gaussian. Its slope
says how wide that is, wherever the edge lies. A tone curve that is concave, as files
of cameras have, makes the blur look up to half as wide again; one like an S, which is
steepest in the middle, by its steepness there too narrow.
"""

from typing import NamedTuple

import cv2
import numpy as np
from scipy.special import erfinv, ndtri

from raxel.features.active_grid.layout import REACH

# Of the contrast: by how much a picture and its inverse together change where one of
# them is covered and its bit turned over; at an edge behind a tone curve 0.6 at most.
TURNED = 0.75
SAMPLES = 10_000  # pixels looked at for edges, all over the picture
REACH_PX = 12  # of the patch around an edge
SMOOTHED_PX = 1.5  # against noise; taken off again
OF_DIFFERENCES = 1 / 3  # variance, px^2, that differences over two pixels add
NEAR_EDGE = 0.5  # of the contrast
TOO_FINE = 0.7  # share of a patch near edges: they flow together
CLEAR, MIN_SHARE = 10, 0.2  # contrast in deviations of the noise, and of the usual
AREAS = 3  # along each side of the picture, each with a blur of its own
EDGES = 6  # of each area
MIN_PIXELS = 100  # of an area, or of the whole picture where no area has so many
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


class _Edges(NamedTuple):
    """E places beside an edge of one bit: that bit, and another with full contrast
    there; (row, column) before the edge and step (rows, columns) to one behind it;
    area of the picture."""

    bit: np.ndarray
    other: np.ndarray
    place: np.ndarray
    step: np.ndarray
    area: np.ndarray


def measured_blur(stack, noise):
    """The Blur of a view, or None where too few edges of Gray code are seen.

    stack: a PictureStack; noise: a Noise.
    """
    pairs = [pair for code in stack.codes for pair in code.bits]
    if not pairs or min(stack.shape) <= 2 * REACH_PX:
        return None
    step = max(4, round(np.sqrt(np.prod(stack.shape) / SAMPLES)))
    coarse = np.s_[step // 2 :: step, step // 2 :: step]
    apart = np.array([stack.apart(pair, coarse) for pair in pairs])
    light = stack.images[pairs[0][0]][coarse].astype(np.float32)
    contrast = np.abs(apart).max(axis=0)
    dark = light - (apart[0] + contrast) / 2
    lit = contrast > CLEAR * np.sqrt(noise.at(dark))
    if not lit.any():
        return None
    lit &= contrast > MIN_SHARE * np.quantile(contrast[lit], 0.9)
    usual, dark = np.median(contrast[lit]), np.median(dark[lit])
    edges = _edges(apart, lit, step)
    if not len(edges.bit):
        return None
    spread, edge = _spread(stack, pairs, edges, MIN_SHARE * usual)
    parts = (spread[edges.area[edge] == k] for k in range(AREAS * AREAS))
    medians = [np.median(own) for own in parts if len(own) >= MIN_PIXELS]
    if not medians and len(spread) < MIN_PIXELS:
        return None
    widest = max(medians) if medians else np.median(spread)
    blur = float(np.sqrt(max(widest - SMOOTHED_PX**2 - OF_DIFFERENCES, 0)))
    share = np.clip(DARK_BELOW * np.sqrt(noise.at(dark)) / usual, 1e-3, 0.5)
    return Blur(blur, -blur * float(ndtri(share)))


def _edges(apart, lit, step):
    """Some edges in each area; apart: (bits, h, w), every `step` px; lit: (h, w)."""
    light, strength, found = apart > 0, np.abs(apart), []
    for down, right in ((0, 1), (1, 0)):
        first = np.s_[: len(lit) - down, : lit.shape[1] - right]
        both = lit[first] & lit[down:, right:]
        changed = light[:, *first] != light[:, down:, right:]
        bit, v, u = np.nonzero(changed & both)
        found.append([bit, v, u, np.full(len(bit), down), np.full(len(bit), right)])
    bit, v, u, down, right = np.concatenate(found, axis=1)
    strength = strength[:, v, u]
    strength[bit, np.arange(len(bit))] = -1
    area = AREAS * (AREAS * v // lit.shape[0]) + AREAS * u // lit.shape[1]
    place, steps = step // 2 + step * np.stack([v, u]), step * np.stack([down, right])
    kept = []
    for k in range(AREAS * AREAS):
        own = np.flatnonzero(area == k)
        kept.append(own[:: -(-len(own) // EDGES) or 1])
    kept = np.concatenate(kept)
    every = bit, strength.argmax(axis=0), place, steps, area
    return _Edges(*(array[..., kept] for array in every))


def _apart(values, pairs, bit, v, u):
    """Pictures less inverses of bits (E,) at rows v and columns u, (E, ...) float32.

    values: `PictureStack.apart`, or `together`, NaN where there is no inverse.
    """
    out = np.full(np.broadcast_shapes(v.shape, u.shape), np.nan, np.float32)
    for k in np.unique(bit):
        own = bit == k
        found = values(pairs[k], (v[own], u[own]))
        if found is not None:
            out[own] = found
    return out


def _spread(stack, pairs, edges, least):
    """(P,) squared width px^2 at pixels near edges, and the edge of each.

    least: contrast, all over the patch around an edge.
    """
    walk = np.arange(edges.step.max(initial=0) + 1)
    line = edges.place[..., None] + np.sign(edges.step)[..., None] * walk
    values = _apart(stack.apart, pairs, edges.bit, *line)
    crossed = np.argmax((values > 0) != (values[:, :1] > 0), axis=1)
    middle = edges.place + np.sign(edges.step) * crossed
    middle = [
        np.clip(at, REACH_PX, size - 1 - REACH_PX)
        for at, size in zip(middle, stack.shape, strict=True)
    ]
    around = np.arange(-REACH_PX, REACH_PX + 1)
    v, u = (at[:, None] + around for at in middle)
    where = v[:, :, None], u[:, None, :]
    own = _apart(stack.apart, pairs, edges.bit, *where)
    most = np.maximum(
        np.abs(own), np.abs(_apart(stack.apart, pairs, edges.other, *where))
    )
    # Patches one below the other; what they give each other is left out with the rim.
    share = (own / np.maximum(most, 1)).reshape(-1, len(around))
    share = cv2.GaussianBlur(share, (0, 0), SMOOTHED_PX).reshape(own.shape)
    rim = 1 + round(3 * SMOOTHED_PX)
    near = np.abs(share[:, rim:-rim, rim:-rim]) < NEAR_EDGE
    whole = (most > least).all(axis=(1, 2))
    # Where something covers one picture, it and its inverse are alike without an edge.
    light = [_apart(stack.together, pairs, n, *where) for n in (edges.bit, edges.other)]
    off = cv2.blur((light[0] - light[1]).reshape(-1, len(around)), (3, 3))
    whole &= ~(np.abs(off.reshape(own.shape)) > TURNED * most).any(axis=(1, 2))
    whole &= np.mean(near, axis=(1, 2)) < TOO_FINE
    edge, y, x = np.nonzero(near & whole[:, None, None])
    y, x = y + rim, x + rim
    right = (share[edge, y, x + 1] - share[edge, y, x - 1]) / 2
    down = (share[edge, y + 1, x] - share[edge, y - 1, x]) / 2
    steepest = np.sqrt(2 / np.pi) * np.exp(-(erfinv(share[edge, y, x]) ** 2))
    return steepest**2 / (right**2 + down**2 + 1e-12), edge
