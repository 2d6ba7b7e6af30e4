"""Following the four edges of every corner to the next corner.

No model and no prediction: one step along the edge, then across to the strongest
gradient. Along an edge the same side is bright; where it passes a corner the sides
change, so a trace knows that it has passed one even if nobody found it.
"""

from typing import NamedTuple

import numpy as np

from raxel.features.find.ring import paint, pixels_of

# A trace starts so many px of its level from its corner, and ends so near to one.
START, CAUGHT = 3.0, 2.6
ARRIVAL = np.radians(38)
# Slope across an edge (grey levels over 2 ACROSS) as a share of the ring's contrast.
USUAL_SLOPE = 0.12


class Atlas(NamedTuple):
    """All levels in one picture: grey and the known corners (index + 1, 0 for none).

    left, top, width, height, scale: (levels,) where each lies and what it shows.
    """

    grey: np.ndarray
    known: np.ndarray
    left: np.ndarray
    top: np.ndarray
    width: np.ndarray
    height: np.ndarray
    scale: np.ndarray


def atlas_of(levels, points):
    """The Atlas of the levels with corners `points` (N, 2) of the image."""
    sizes = np.array([level.grey.shape for level in levels])
    height, width = sizes.T
    top = np.concatenate([[0, 0], np.cumsum(height[1:-1])])[: len(levels)]
    left = np.where(np.arange(len(levels)) == 0, 0, width[0])
    shape = (top + height).max(), (left + width).max()
    grey, known = np.zeros(shape, np.float32), np.zeros(shape, np.int32)
    numbers = np.arange(1, len(points) + 1)
    for level, x, y, w, h in zip(levels, left, top, width, height, strict=True):
        room = slice(y, y + h), slice(x, x + w)
        grey[room] = level.grey
        place = pixels_of(points / level.scale, (h, w))
        paint(known[room], place, numbers, CAUGHT)
    scale = np.array([level.scale for level in levels], np.float32)
    left, top = left.astype(np.float32), top.astype(np.float32)
    sizes = width.astype(np.float32), height.astype(np.float32)
    return Atlas(grey, known, left, top, *sizes, scale)


class Arms(NamedTuple):
    """Edges to follow: from points (N, 2) px at angles (N,); signs (N,), contrast (N,)
    and level (N,) as of `ring.Nodes`; own (N,): index of the corner each leaves."""

    points: np.ndarray
    angles: np.ndarray
    signs: np.ndarray
    contrast: np.ndarray
    level: np.ndarray
    own: np.ndarray


def links_of(nodes, levels):
    """Index (N, 4, 2) of (node, arm) that each arm leads to and back; -1 for none."""
    arms = Arms(
        np.repeat(nodes.points, 4, axis=0),
        nodes.angles.ravel(),
        nodes.signs.ravel(),
        np.repeat(nodes.contrast, 4),
        np.repeat(nodes.level, 4),
        np.repeat(np.arange(len(nodes.points)), 4),
    )
    ends, heading = _traced(arms, atlas_of(levels, nodes.points))
    return _mutual(nodes, ends.reshape(-1, 4), heading.reshape(-1, 4))


def _traced(arms, atlas):
    """(corner reached (N,) or -1, heading there (N,)) of Arms in the Atlas."""
    from raxel.features.find.compiled import followed

    d = np.stack([np.cos(arms.angles), np.sin(arms.angles)], axis=1).astype(np.float32)
    start = arms.points / atlas.scale[arms.level][:, None] + START * d
    usual = USUAL_SLOPE * arms.contrast
    single = (a.astype(np.float32) for a in (start, d, arms.signs, usual))
    end, d = followed(atlas, *single, arms.level, arms.own)
    return end, np.where(end < 0, arms.angles, np.arctan2(d[:, 1], d[:, 0]))


def _mutual(nodes, ends, heading):
    """Keep links that both ends confirm, and say by which arm they arrive."""
    links = np.full((*ends.shape, 2), -1)
    i, k = np.nonzero(ends >= 0)
    if not len(i):
        return links
    j = ends[i, k]
    back = heading[i, k] + np.pi
    off = (nodes.angles[j] - back[:, None] + np.pi) % (2 * np.pi) - np.pi
    wrong = nodes.signs[j] != -nodes.signs[i, k][:, None]
    off = np.abs(off) + 10.0 * wrong
    m = off.argmin(axis=1)
    sure = (off.min(axis=1) < ARRIVAL) & (ends[j, m] == i)
    links[i[sure], k[sure]] = np.stack([j[sure], m[sure]], axis=1)
    agreed = links[links[..., 0], links[..., 1]]
    number = np.arange(len(ends))[:, None]
    same = (agreed[..., 0] == number) & (agreed[..., 1] == np.arange(4))
    links[~same | (links[..., 0] < 0)] = -1
    return links
